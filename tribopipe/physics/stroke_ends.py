"""What the ends of a stroke make of the groove in its middle.

The groove holds V_2 = k_2·F_N·S, ends included. Between soft bodies each place at mid-stroke passes under the whole
load, so that its cross-section is V_2 over the stroke. Between stiff bodies the load moves to where the groove is
shallow: depth evens out along the stroke, as heat does, and the middle takes part in what the ends have not lost. Then

    cross-section at mid-stroke = V_2/(stroke + c·b),    c = 1.2/(1 + (0.55/τ)^1.2),    τ = (b/stroke)²·∫dh_d/δ

with the half length b of the scar, the depth h_d of the groove, and δ = p·b/(1.7·E*), the deflection under the mean
pressure p of a mattress that resists tilting as an elastic half-space does. δ falls while the scar grows, which makes
of the integral h_d/δ at the end times 0.4 for a sphere, and 1 for a flat pin.

c is from wear in discrete passes under constant load, for κb from 0.1 to 10 and strokes longer than six half lengths,
with which the cross-section agrees within 5 %, and 1 % from twelve half lengths on; half-spaces and mattresses give the
same (tests/test_stroke_ends.py). Within about a quarter of the stroke from its ends, the groove is shallower still.
"""

from typing import NamedTuple

import numpy as np

from tribopipe.physics.pin_on_track import Array, WornContact

_STIFF = 1.2
"""Extension between rigid bodies, in half lengths of the scar."""
_HALFWAY, _POWER = 0.55, 1.2
_TILT = 1.7
"""16/(3π): a circular punch on a half-space tilts as on a mattress of this stiffness times E* over its radius."""
EXTENSION_UNCERTAINTY = 0.25
"""Standard uncertainty of a stroke's extension, in half widths of the groove: wear at the ends may differ."""


class Stroke(NamedTuple):
    """A stroke, and what moves load along it."""

    length: Array
    """m."""
    stiffness: Array
    """Reduced modulus over normal load, 1/m²."""

    def extended(self, worn: WornContact) -> Array:
        """Return V_2 over the cross-section at mid-stroke, m."""
        # (b/stroke)²·h_d/δ, in which a half length of zero does not matter.
        evened = _TILT * self.stiffness * worn.groove_depth * worn.area * worn.half_length / self.length**2
        evened = evened / (1 + 1.5 * _growth(worn))
        share = np.power(evened, _POWER)
        return np.asarray(self.length + _STIFF * worn.half_length * share / (share + _HALFWAY**_POWER))


def _growth(worn: WornContact) -> Array:
    """Return the exponent n − 1 by which the scar's area grows with depth, where the pin loses h^n: 1 for a sphere."""
    steep = worn.pin_slope * worn.pin_depth
    power = np.divide(steep, worn.pin_volume, out=np.full(np.shape(steep), 2.0), where=worn.pin_volume > 0)
    return np.asarray(power - 1)
