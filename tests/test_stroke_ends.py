"""The groove at mid-stroke against wear in discrete passes under constant load, on a mattress and on a half-space."""

from collections.abc import Callable

import numpy as np
import pytest

from tribopipe.physics.local.grids import PinGrid
from tribopipe.physics.local.half_space import HalfSpace
from tribopipe.physics.pin_on_track import FlatOnTrack, OnTrack, SphereOnTrack, WornContact
from tribopipe.physics.stroke_ends import Stroke

RADIUS, FLAT = 10.0, 1.0
TIP = SphereOnTrack(RADIUS)
SLICES, PER_LENGTH = 12, 7
LOAD = 1.0
Press = Callable[[np.ndarray], np.ndarray]


class Passes:
    """A pin that goes there and back over a flat: cells of both, of which those that touch wear by their pressure."""

    def __init__(self, rigid: WornContact, ratio: float, stroke: float, passes: int, slices: int = SLICES) -> None:
        """Set up wear that would leave the pin as deep as ``rigid``, whose track is endless."""
        half_length, half_width = float(rigid.half_length), float(rigid.half_width)
        self.along = max(half_length / PER_LENGTH, half_width / 30)
        self.places, self.passes = round(stroke / self.along), passes
        self.stroke = self.places * self.along
        self.reach, self.across = int(1.35 * half_width / self.along), 2.4 * half_width / slices
        self.x = (np.arange(slices) - (slices - 1) / 2)[:, None] * self.across
        self.y = (np.arange(2 * self.reach + 1) - self.reach) * self.along
        self.pin = (self.x**2 + self.y**2) / (2 * RADIUS)
        self.flat = np.zeros((slices, self.places + 1 + 2 * self.reach))
        self.wear = float(rigid.pin_volume) / (passes * self.stroke * LOAD)
        self.flat_wear = ratio * self.stroke * self.wear

    def section(self, press: Press) -> float:
        """Wear both bodies; return the cross-section of the groove at mid-stroke."""
        for one in range(self.passes):
            there = range(self.places)
            for place in there if one % 2 == 0 else reversed(there):
                under = self.flat[:, place : place + self.pin.shape[1]]
                pressure = press(self.pin + under)
                self.pin += self.wear * pressure * self.along
                under += self.flat_wear * pressure * self.along
        middle = self.flat.shape[1] // 2
        return float(self.across * self.flat[:, middle - 2 : middle + 3].mean(axis=1).sum())

    def mattress(self, area: float, deflection: float) -> Press:
        """Return what presses springs together, by Newton's method, from the depth of the call before."""
        total, depth = area * deflection / (self.across * self.along), 0.0

        def press(gap: np.ndarray) -> np.ndarray:
            nonlocal depth
            for _ in range(60):
                overlap = np.maximum(depth - gap, 0.0)
                count = np.count_nonzero(overlap)
                step = (total - overlap.sum()) / max(count, 1)
                depth += step
                if count and abs(step) < 1e-6 * total / count:
                    break
            return np.maximum(depth - gap, 0.0) * LOAD / (area * deflection)

        return press

    def half_space(self, modulus: float) -> Press:
        """Return what presses half-spaces together."""
        grid = PinGrid(LOAD, HalfSpace(modulus, (self.across, self.along), self.pin.shape), np.zeros(self.pin.shape))
        last = None

        def press(gap: np.ndarray) -> np.ndarray:
            nonlocal last
            last = grid.press(gap, start=last)
            return last.pressure

        return press


def extension(
    ratio_times_b: float, stroke: float, evened: float, passes: int = 400, *, tip: OnTrack = TIP, elastic: bool = False
) -> tuple[float, float]:
    """Return the extension of a stroke, in half lengths of the scar, by discrete passes and by the formula.

    ``evened`` is the depth of the groove over the deflection, times (half length/stroke)².
    """
    half = float(tip.half_width_at(0.02))
    rigid = tip.worn_to(0.02, ratio_times_b / half)
    cells = Passes(rigid, ratio_times_b / half, stroke * half, passes, slices=2 * SLICES)
    if isinstance(tip, FlatOnTrack):
        cells.pin = np.where(cells.x**2 + cells.y**2 <= FLAT**2, 0.0, 1e9)
    area, deflection = float(rigid.area), float(rigid.groove_depth) * half**2 / (evened * cells.stroke**2)
    modulus = LOAD * half / (1.7 * area * deflection)
    section = cells.section(cells.half_space(modulus) if elastic else cells.mattress(area, deflection))
    worn = tip.worn(rigid.pin_volume, section)
    expected = Stroke(np.asarray(cells.stroke), np.asarray(modulus / LOAD)).extended(worn)
    lost = cells.flat_wear * LOAD * passes
    return (lost * cells.stroke / section - cells.stroke) / half, float(expected - cells.stroke) / half


@pytest.mark.slow
def test_a_short_stroke_between_stiff_bodies_shares_its_middle_with_its_ends():
    found, expected = extension(1.0, 6.0, 1.0)
    assert found > 0.3
    assert expected == pytest.approx(found, abs=0.15)


@pytest.mark.slow
def test_between_soft_bodies_each_place_passes_under_the_whole_load():
    found, expected = extension(1.0, 10.0, 0.1)
    assert [found, expected] == pytest.approx([0, 0], abs=0.07)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ratio", "stroke", "evened", "passes"),
    [
        *((0.1, 6.0, 0.3, 400), (0.1, 6.0, 2.0, 3000), (0.3, 12.0, 1.0, 2500)),
        *((1.0, 6.0, 3.0, 800), (1.0, 25.0, 0.3, 1500), (3.0, 12.0, 1.0, 900), (10.0, 25.0, 0.3, 400)),
    ],
)
def test_the_cross_section_is_that_of_discrete_passes_within_1_percent(ratio, stroke, evened, passes):
    found, expected = extension(ratio, stroke, evened, passes)
    assert expected == pytest.approx(found, abs=0.15)
    if stroke > 10:
        assert (stroke + expected) / (stroke + found) == pytest.approx(1, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "evened"), [(0.3, 0.4), (3.0, 2.0)])
def test_a_flat_pin_on_a_stroke(ratio, evened):
    found, expected = extension(ratio, 12.0, evened, 800, tip=FlatOnTrack(FLAT))
    assert (12 + expected) / (12 + found) == pytest.approx(1, abs=0.015)


@pytest.mark.slow
def test_half_spaces_even_out_as_mattresses_do():
    found, expected = extension(1.0, 7.0, 0.3, 150, elastic=True)
    assert found == pytest.approx(extension(1.0, 7.0, 0.3, 150)[0], abs=0.1)
    assert expected == pytest.approx(found, abs=0.15)
