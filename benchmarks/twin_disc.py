"""Wear of two discs: the exact model's speed beside the published steps', and what each way of counting does to k_D.

    python benchmarks/twin_disc.py

The case is that of Section 3.5: Si3N4, 250 mN, 4 % slip, k_D as the paper found them with the whole slip distance of a
turn (Eq. 14). The discs' dimensions are in its Fig. 7 only; all radii are taken as 4 mm. Times are of the processor,
of all cases in turn in one process.
"""

import math
import statistics
import time
from collections.abc import Callable
from typing import NamedTuple, get_args

import numpy as np
from labs import Report, arguments

from tribopipe.base.arrays import Column
from tribopipe.physics.calculation_methods import DistanceConvention
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.twin_disc import DiscPair, published_wear

LOAD, RADIUS, SLIP, HIGHER_SLIP = 0.25, 4e-3, 0.04, 0.1
MODULUS = float(contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24))
CURVED, FLAT = 4.6e-18, 2.0e-18
"""k_D of Section 3.5, m²/N; 1 m²/N is 1e6 mm³/(N mm)."""
PUBLISHED: DistanceConvention = "full-slip"
KAPPA = math.pi / 4
ROTATIONS, MANY_ROTATIONS, STEPS, DRAWS = 1e6, 1e8, 10_000, 10_000
EXACT, BY_STEPS = "exact, 10⁸ rotations at 101 points", f"published, {STEPS} steps of one rotation"


class Found(NamedTuple):
    """What one way of counting makes of the same two volumes."""

    coefficients: Column
    """k₁ and k₂, m²/N."""
    exponents: Column
    """n of V ∝ N^n over the last decade."""
    at_higher_slip: Column
    """Volumes at the higher slip over those at the lower."""


def discs(distance: DistanceConvention, slip: float = SLIP) -> DiscPair:
    """Return the discs of Section 3.5."""
    return DiscPair(LOAD, RADIUS, RADIUS, RADIUS, MODULUS, slip, distance)


def volumes(pair: DiscPair, rotations: float, coefficients: Column) -> Column:
    """Return V₁ and V₂, m³."""
    state = pair.worn(rotations, *coefficients)
    return np.array([state.curved_volume, state.flat_volume], dtype=float)


def found(distance: DistanceConvention, asked: Column) -> Found:
    """Find the coefficients that give both volumes; each is close to proportional to its own."""
    pair, coefficients = discs(distance), np.array([CURVED, FLAT])
    for _ in range(100):
        given = volumes(pair, ROTATIONS, coefficients)
        coefficients = coefficients * asked / given
        if np.all(np.abs(given / asked - 1) < 1e-12):
            break
    decade = volumes(pair, ROTATIONS / 10, coefficients)
    higher = volumes(discs(distance, HIGHER_SLIP), ROTATIONS, coefficients)
    return Found(coefficients, np.log10(asked / decade), higher / asked)


def say_what_counting_does(report: Report) -> None:
    """Compare the three ways of counting on the same volumes."""
    asked = volumes(discs(PUBLISHED), ROTATIONS, np.array([CURVED, FLAT]))
    report.say("## Effect of each distance convention on k_D")
    report.say(
        f"With *{PUBLISHED}* and the k_D values of the paper, the wear volumes after 10⁶ rotations at "
        f"{100 * SLIP:.0f} % slip are {asked[0] * 1e9:.4g} mm³ (crowned disc) and {asked[1] * 1e9:.4g} mm³ "
        "(cylindrical disc). With the k_D values below, in mm³/(N·mm), the other conventions give the same volumes. n "
        "is the exponent in V ∝ Nⁿ over the last decade of rotations; the last column is the volume at "
        f"{100 * HIGHER_SLIP:.0f} % slip divided by that at {100 * SLIP:.0f} %, with the same k_D."
    )
    rows, by_name = [], {name: found(name, asked) for name in get_args(DistanceConvention)}
    for name, one in by_name.items():
        times = one.coefficients / by_name[PUBLISHED].coefficients
        cells = [
            [f"{1e6 * k:.4g}", f"{ratio:.4g}", f"{n:.4f}", f"{more:.3f}"]
            for k, ratio, n, more in zip(one.coefficients, times, one.exponents, one.at_higher_slip, strict=True)
        ]
        rows += [[name, disc, *cell] for disc, cell in zip(("crowned", "cylindrical"), cells, strict=True)]
    report.table(["convention", "disc", "k_D", f"divided by that with {PUBLISHED}", "n", "volume at higher slip"], rows)
    report.say(
        "k_D with *volume-conserving* is comparable with that of a pin, 13.5e-09 in Section 2.1.1. With "
        "*contact-width*, a volume of (π²/2)·r·k·F_N is removed per rotation of a disc, regardless of the slip, as "
        "with *volume-conserving* at a slip of π/4. Its k_D is therefore 4/π times the slip times that with "
        f"*volume-conserving*: a factor of {4 / np.pi * SLIP:.4f} for the crowned disc, and of "
        f"{4 / np.pi * SLIP / (1 + SLIP):.4f} for the cylindrical disc, which rotates faster. Except for this faster "
        "rotation, *contact-width* does not predict more wear at a higher slip. With *full-slip*, V tends to be "
        "proportional to N^(6/5) if the elastic part is small, because the volume per unit of depth increases with "
        "the width of the worn area, and the pressure decreases more slowly."
    )


def say_what_kappa_carries(report: Report) -> None:
    """Check how much of the load the printed pressure carries over the printed ellipse."""
    pair = discs(PUBLISHED)
    state = pair.worn(np.geomspace(1, MANY_ROTATIONS, 50), CURVED, FLAT)
    shares = state.pressure * np.pi * state.half_width * state.half_length / LOAD
    off = float(np.max(np.abs(shares / (np.pi**2 / 16) - 1)))
    rectangle = 2 * state.half_width * 2 * (state.half_length / KAPPA)
    ellipse = np.pi * state.half_width * (state.half_length / KAPPA) * 4 / np.pi
    apart = float(np.max(np.abs(ellipse / rectangle - 1)))
    whole = float(np.max(np.abs(shares / KAPPA * 4 / np.pi - 1)))
    report.say("## Load carried with κ = π/4")
    report.say(
        f"According to Eq. 15 and 16 as printed, with κ = π/4, p·π·a_x·a_z = (π²/16)·F_N = {np.pi**2 / 16:.4f}·F_N "
        f"(within {off:.0e} at 50 points up to 10⁸ rotations), not F_N. With κ = 4/π, the area of the ellipse would "
        f"equal that of the rectangle, as stated in the text (within {apart:.0e}), and the pressure would carry F_N "
        f"(within {whole:.0e}, at the same a_x). tribopipe uses κ as printed. κ affects a_z, and thereby the elastic "
        "part u and the sliding distance of *contact-width*, whose k_D would be smaller by a factor of 16/π² = 1.62."
    )


def drawn() -> object:
    """Compute the exact model for draws of what is uncertain."""
    rng = np.random.default_rng(1)
    load, radius, modulus, curved, flat = (
        value * (1 + spread * rng.standard_normal(DRAWS))
        for value, spread in ((LOAD, 0.01), (RADIUS, 0.002), (MODULUS, 0.02), (CURVED, 0.1), (FLAT, 0.1))
    )
    pair = DiscPair(load, radius, radius, radius, modulus, SLIP, PUBLISHED)
    return pair.worn(ROTATIONS, curved, flat)


def timed(work: Callable[[], object]) -> float:
    """Return the time of the processor, s."""
    start = time.process_time()
    work()
    return time.process_time() - start


def say_how_long(report: Report, repeats: int) -> None:
    """Time the exact model beside the published steps."""
    places = np.linspace(0, MANY_ROTATIONS, 101)
    cases: dict[str, Callable[[], object]] = {
        BY_STEPS: lambda: published_wear(discs(PUBLISHED), np.ones(STEPS), CURVED, FLAT),
        EXACT: lambda: discs(PUBLISHED).worn(places, CURVED, FLAT),
        f"exact, {DRAWS} draws at 10⁶ rotations": drawn,
    }
    for work in cases.values():
        work()
    times: dict[str, list[float]] = {name: [] for name in cases}
    for _ in range(repeats):
        for name, work in cases.items():
            times[name].append(timed(work))
    medians = {name: statistics.median(taken) for name, taken in times.items()}
    report.say("## Speed")
    report.say(f"Medians of {repeats} alternating repeats; minimum and maximum in parentheses.")
    report.table(
        ["", "CPU time", "ratio"],
        [
            [
                name,
                f"{1e3 * medians[name]:.2f} ms ({1e3 * min(taken):.2f} to {1e3 * max(taken):.2f})",
                f"{medians[name] / medians[BY_STEPS]:.3g}",
            ]
            for name, taken in times.items()
        ],
    )


def main() -> None:
    """Compare and time, and print the tables."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--repeats", type=int, default=25, help="number of repeats (%(default)s)")
    options = parser.parse_args()
    report = Report("Wear of two discs", options)
    report.say(
        f"Si3N4 (304 GPa, 0.24), {LOAD * 1e3:.0f} mN, {100 * SLIP:.0f} % slip, radii {RADIUS * 1e3:.0f} mm (assumed), "
        f"k_D {CURVED * 1e6:.1e} and {FLAT * 1e6:.1e} mm³/(N·mm) with *{PUBLISHED}*."
    )
    say_how_long(report, options.repeats)
    say_what_counting_does(report)
    say_what_kappa_carries(report)
    report.finish()


if __name__ == "__main__":
    main()
