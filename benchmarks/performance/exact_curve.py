"""(b) The exact curve of a pin on a disc beside the published scheme and a solver of differential equations.

All follow the case of Section 2.1.1, Si3N4 under 200 mN over 500 m, at 12 500 places. The published scheme is of first
order: its steps are as many as bring its error at the end of the curve, relative to the depth there, down to 1e-6;
along the curve it is larger. The numpy loop takes the first of these steps only, and its time is scaled to all of them.
"""

import math
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
from case import Pair, Row, Setting
from scipy.integrate import solve_ivp

from tribopipe.base.arrays import Column
from tribopipe.base.units import superscript
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.pin_on_disc import SphericalPin

LOAD, RADIUS, COEFFICIENT, DISTANCE = 0.2, 0.794e-3, 13.5e-15, 500.0
MODULUS = float(contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24))
PLACES = 12_500
ACCURACY = 1e-6
_FIRST_ORDER = 16_000_000
"""Steps from which the number for the accuracy asked for follows, the error being in proportion to their length."""
_TOLERANCE = 1e-4
"""Of the solver: the loosest power of ten with which it is as accurate as asked for."""


def rows(setting: Setting) -> Iterator[Row]:
    """Yield the pairs."""
    compiled = _compiled(euler)
    steps = each_to(ACCURACY, compiled, setting)
    looped = setting.of(200, small=20)
    error = f"a relative error of {_power_of_ten(end_error(compiled(PLACES, steps, PLACES)))}"
    there = f"of the published scheme, {steps * PLACES:,} steps for {error}"
    loop = f"numpy loop {there}; extrapolated from {looped * steps:,} steps"
    along = float(np.max(np.abs(solved() - exact()[1:])) / exact()[-1])
    off = f"with a relative error of {_power_of_ten(along)} along the curve"
    by_solver = f"solve_ivp from scipy (DOP853, rtol {_TOLERANCE:g}), {off}"
    peers: list[tuple[str, Callable[[], object], float, float | None]] = [
        (loop, lambda: euler(looped, steps, PLACES), PLACES / looped, 1000),
        (f"numba loop {there}", lambda: compiled(PLACES, steps, PLACES), 1.0, 20),
        (by_solver, solved, 1.0, None),
    ]
    for beside, peer, scaled, at_least in peers:
        yield Pair(_WHAT, exact, peer, beside, scaled, at_least=at_least, clock=time.process_time)


def _power_of_ten(number: float) -> str:
    """Write a number as 1.0×10⁻⁶."""
    mantissa, exponent = f"{number:.1e}".split("e")
    return f"{mantissa}×10{superscript(int(exponent))}"


def _compiled(scheme: Callable[[int, int, int], Column]) -> Callable[[int, int, int], Column]:
    """Return a function compiled by numba, which looks for a package called coverage and would find that benchmark."""
    sys.modules.setdefault("coverage", None)  # type: ignore[arg-type]
    from numba import njit

    found: Callable[[int, int, int], Column] = njit()(scheme)
    return found


_WHAT = f"exact wear curve of a pin, {PLACES:,} points"


def exact() -> Column:
    """Return the depth, m, at the start and at all places."""
    volumes = COEFFICIENT * LOAD * np.linspace(0.0, DISTANCE, PLACES + 1)
    return SphericalPin(LOAD, RADIUS, MODULUS).worn(volumes).depth


def euler(places: int, steps: int, of_places: int) -> Column:
    """Return the depth, m, at the first places by the published scheme (Fig. 2), so many equal steps to each."""
    depth, here = np.zeros(places + 1), 0.0
    length = DISTANCE / of_places / steps
    a = (3 * LOAD * RADIUS / (4 * MODULUS)) ** (1 / 3)
    for place in range(places):
        for _ in range(steps):
            elastic = LOAD / (2 * MODULUS * a)
            here += COEFFICIENT * LOAD / (np.pi * a * a) * length
            total = here + elastic
            a = np.sqrt(2 * RADIUS * total - total * total)
        depth[place + 1] = here
    return depth


def end_error(depth: Column) -> float:
    """Return by how much the end of a curve is off, relative to itself."""
    return abs(float(depth[-1] / exact()[-1]) - 1)


def each_to(accuracy: float, scheme: Callable[[int, int, int], Column], setting: Setting) -> int:
    """Return the number of steps from place to place with which the published scheme ends as accurately as asked."""
    tried = setting.of(_FIRST_ORDER, small=_FIRST_ORDER // 16) // PLACES
    return math.ceil(tried * end_error(scheme(PLACES, tried, PLACES)) / accuracy)


def solved() -> Column:
    """Return the depth, m, at all places from the contact radius, which Eq. 5 and 6 make a differential equation of."""
    start = float(SphericalPin(LOAD, RADIUS, MODULUS).worn(0.0).radius)
    at = np.linspace(0.0, DISTANCE, PLACES + 1)[1:]

    def widening(_: float, a: Column) -> Column:
        rise = a / np.sqrt(RADIUS**2 - a**2) + LOAD / (2 * MODULUS * a**2)
        return np.asarray(COEFFICIENT * LOAD / (np.pi * a**2) / rise)

    found = solve_ivp(widening, (0.0, DISTANCE), [start], "DOP853", at, rtol=_TOLERANCE, atol=_TOLERANCE * start)
    a = found.y[0]
    return np.asarray(a**2 / (RADIUS + np.sqrt(RADIUS**2 - a**2)) - LOAD / (2 * MODULUS * a))
