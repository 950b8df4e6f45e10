"""What elasticity makes of the shape of a ball and its track while the scar is small.

An elastic contact begins with Hertz's radius a₀, while that of rigid bodies begins in a point. With the same wear
volumes, scar and groove are therefore wider and shallower at first than those of rigid bodies, whose scar has the half
width a and the half length b. In units of a₀,

    groove depth, rigid over elastic     g = (1 + (9/(8a))^4.5)^(1/4.5)
    pin depth, rigid over elastic        g·(1 + (β/b)⁴)^¼,       β = (32/27)/(1 + (a/1.33)^2.5)^(1/5)
    half width, elastic                  (a⁴ + 1 + 0.7·a²/(1 + 2.7·b²/(1 + b²/3)))^¼
    half length of the scar, elastic     the larger of (b⁴ + 1.34·b^1.2/a^1.1)^¼ and 1 − a²/300

β is half the length of a line contact in the groove, which shrinks as the groove widens; the scar stays as long as the
first contact until wear makes it longer. At first, wear is that of Hertz's pressure: the middle of the pin recedes 1.5
times as fast as under uniform pressure, which fixes 9/8 and 32/27. The other constants are from local wear of both
bodies (``tribopipe.physics.local.track``). With that, all four agree within 2 % for κb from 0 to 300, from a wear depth
of both bodies equal to the elastic approach a₀²/R on, and within 6 % from a third of it on
(benchmarks/contact_local_wear.py).
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.physics.pin_on_track import Array, SphereOnTrack, WornContact, power_root

_BLEND = 4.5
_POINT = 1e-12
"""Half width and length, in Hertz's radius, of a scar that there is not yet."""
_STEP = 1e-4
"""Relative step of a depth in a difference quotient."""


class ElasticStart(NamedTuple):
    """Shape of an elastic contact against that of rigid bodies with the same wear volumes."""

    pin: Array
    """Wear depth of the pin, over that of a rigid one."""
    groove: Array
    """Wear depth of the track, over that of a rigid one."""
    half_width: Array
    """Half width of scar and groove, m."""
    half_length: Array
    """Half length of the scar, m."""
    contact_length: Array
    """Half length of the contact, m: in a wide groove, it is shorter than the scar of the first contact."""


def elastic_start(*, half_width: ArrayLike, half_length: ArrayLike, hertz_radius: ArrayLike) -> ElasticStart:
    """Return what elasticity makes of a scar of rigid bodies.

    Parameters
    ----------
    half_width, half_length
        Of the scar of rigid bodies, m, across and along the sliding direction.
    hertz_radius
        Contact radius of the unworn sphere, m.

    Returns
    -------
    ElasticStart
        Depths as shares of those of rigid bodies, and extents, m; arrays broadcast against each other.
    """
    first = np.asarray(hertz_radius, dtype=float)
    a, b = (np.maximum(np.asarray(half, dtype=float) / first, _POINT) for half in (half_width, half_length))
    groove = (1 + (9 / 8 / a) ** _BLEND) ** (-1 / _BLEND)
    line = 32 / 27 / (1 + (a / 1.33) ** 2.5) ** 0.2
    spread = 1 + 0.7 * a**2 / (1 + 2.7 * b**2 / (1 + b**2 / 3))
    grown = (b**4 + 1.34 * b**1.2 / a**1.1) ** 0.25
    return ElasticStart(
        pin=np.asarray(groove * (1 + (line / b) ** 4) ** -0.25),
        groove=np.asarray(groove),
        half_width=np.asarray(first * (a**4 + spread) ** 0.25),
        half_length=np.asarray(first * np.maximum(grown, 1 - a**2 / 300)),
        contact_length=np.asarray(first * (b**4 + 1 / (1 + (32 / 27 * a) ** 2)) ** 0.25),
    )


@dataclass(frozen=True)
class ElasticSphereOnTrack:
    """A sphere on a track, both elastic: the rigid ones with the same wear volumes, in another shape."""

    rigid: SphereOnTrack
    hertz_radius: ArrayLike
    """Contact radius of the unworn sphere, m."""

    @property
    def most(self) -> Array:
        """Approach at which the scar would be as wide as the sphere, m."""
        return self.rigid.most

    def worn(self, pin_volume: ArrayLike, groove_area: ArrayLike) -> WornContact:
        """Return the contact whose pin has lost V_1, m³, and whose groove has the cross-section V_2/L, m²."""
        return self._deformed(self.rigid.worn(pin_volume, groove_area))

    def worn_to(self, depth: ArrayLike, track_ratio: ArrayLike) -> WornContact:
        """Return the contact whose pin is worn to a depth, m, or its track if κ is infinite; κ in 1/m."""

        def reached(rigid: Array) -> Array:
            worn = self._deformed(self.rigid.worn_to(rigid, track_ratio))
            return np.asarray(np.where(np.isfinite(track_ratio), worn.pin_depth, worn.groove_depth))

        wanted = np.broadcast_to(depth, np.broadcast_shapes(*map(np.shape, (depth, track_ratio, self.hertz_radius))))
        return self._deformed(self.rigid.worn_to(power_root(reached, wanted, wanted, self.most), track_ratio))

    def _deformed(self, worn: WornContact) -> WornContact:
        first = np.asarray(self.hertz_radius, dtype=float)
        start = self._start(worn.pin_depth, worn.groove_depth)
        pin, groove = (worn.pin_depth * start.pin, worn.groove_depth * start.groove)
        # Slices of the elastic contact fill as much of its width times length as those of the rigid one.
        unit = worn.half_width * worn.half_length
        filled = np.divide(worn.area, unit, out=np.full(unit.shape, np.pi), where=unit > 0)
        next_pin, next_groove = self._a_step_on(worn)
        after = self._start(next_pin, next_groove)
        pin_growth = _slope(next_pin * after.pin - pin, next_pin - worn.pin_depth)
        groove_growth = _slope(next_groove * after.groove - groove, next_groove - worn.groove_depth)
        return replace(
            worn,
            pin_depth=pin,
            groove_depth=groove,
            half_width=start.half_width,
            half_length=start.half_length,
            area=filled * start.half_width * start.contact_length,
            # Where nothing is worn yet, they are those under Hertz's pressure.
            pin_slope=_slope(worn.pin_slope, pin_growth, 2 * np.pi / 3 * first**2),
            groove_slope=_slope(worn.groove_slope, groove_growth, 4 / 3 * first),
        )

    def _start(self, pin_depth: Array, groove_depth: Array) -> ElasticStart:
        return elastic_start(
            half_width=self.rigid.half_width_at(pin_depth + groove_depth),
            half_length=self.rigid.half_width_at(pin_depth),
            hertz_radius=self.hertz_radius,
        )

    def _a_step_on(self, worn: WornContact) -> tuple[Array, Array]:
        """Return the depths of the rigid pin and track, m, after a little more wear."""
        pin = (1 + _STEP) * worn.pin_depth
        slice_before, slice_after = self.rigid.middle_slice(worn.pin_depth), self.rigid.middle_slice(pin)
        grown = np.divide(slice_after, slice_before, out=np.full(pin.shape, 1 + _STEP), where=slice_before > 0)
        return pin, worn.groove_depth * grown


def _slope(change: Array, step: Array, unworn: ArrayLike = 0.0) -> Array:
    """Return a ratio, and another value where there is no step."""
    there = np.array(np.broadcast_to(unworn, step.shape), dtype=float)
    return np.asarray(np.divide(change, step, out=there, where=step > 0))
