"""Wear of a ball and its track by the engines `volume` and `local`, compared with local wear computed at every point.

    python benchmarks/contact_local_wear.py --write docs/results/contact_local_wear.md

All remove the same volumes; they differ in the shape of scar and groove. The engine `volume` has rigid bodies, and
`local` the elastic start of `tribopipe.physics.elastic_start`. Local wear at every point solves an elastic contact
after every step. D is the wear depth of both bodies together, δ₀ the elastic approach of the unworn contact, and
κb the share of the track: κ = k_2/(k_1·L), b the half-length of the scar of rigid bodies.
"""

import argparse
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from labs import Report, arguments

from tribopipe.physics.elastic_start import ElasticSphereOnTrack
from tribopipe.physics.hertz import hertz_ellipse
from tribopipe.physics.local.track import pin_on_track, wear_pin_and_track
from tribopipe.physics.pin_on_track import SphereOnTrack, WornContact

LOAD, RADIUS, MODULUS, COEFFICIENT = 0.2, 0.794e-3, 161.3e9, 1.35e-14
PATH = 2 * np.pi * 4e-3
BALL = SphereOnTrack(RADIUS)
HERTZ = hertz_ellipse(normal_load=LOAD, radius_x=RADIUS, radius_z=RADIUS, modulus=MODULUS)
PAPER = [(ratio, distance) for ratio in (0, 10, 300) for distance in (0.1, 1.0, 10.0, 500.0)]
ELASTIC = ElasticSphereOnTrack(BALL, HERTZ.half_width)
TRACK_SHARES = (0.01, 0.2, 2.0, 20.0, 100.0)
DEPTHS = (1.0, 2.5, 8.0, 60.0)
CLOSE = 2.0
"""Deviation, %, within which shapes agree."""
QUANTITIES = ("pin depth", "groove depth", "scar half-width", "scar half-length")


class Case(NamedTuple):
    """Wear of one ball and its track."""

    track_ratio: float
    """κ, 1/m."""
    amount: float
    """k_1·S, m²/N."""

    def local(self, cells: int, steps: int) -> list[float]:
        """Return the ``QUANTITIES`` by local wear, m, on a quarter of so many cells squared."""
        surface = pin_on_track(
            normal_load=LOAD,
            modulus=MODULUS,
            radius=RADIUS,
            track_ratio=self.track_ratio,
            amount=self.amount,
            cells=(cells, cells),
        )
        worn = wear_pin_and_track(surface, self.amount, steps_per_decade=steps)
        return [worn.pin_depth, worn.groove_depth, worn.half_width, worn.half_length]

    def rigid(self) -> list[float]:
        """Return them by rigid bodies."""
        return self.by(BALL)

    def elastic(self) -> list[float]:
        """Return them with an elastic start."""
        return self.by(ELASTIC)

    def by(self, bodies: SphereOnTrack | ElasticSphereOnTrack) -> list[float]:
        """Return them by a shape in closed form."""
        volume = self.amount * LOAD
        worn: WornContact = bodies.worn(volume, self.track_ratio * volume)
        return [float(one) for one in (worn.pin_depth, worn.groove_depth, worn.half_width, worn.half_length)]


def above(found: list[float], local: list[float]) -> list[float]:
    """Return by how much a shape is above what was computed, %; 0 for a groove that there is not."""
    return [100 * (one / true - 1) if true else 0.0 for one, true in zip(found, local, strict=True)]


def case_of(track_share: float, depth: float) -> Case:
    """Return the wear for which rigid bodies have this κb, and D in δ₀, to the accuracy of a paraboloid."""
    pin = depth * HERTZ.approach / (1 + 4 / 3 * track_share)
    ratio = track_share / float(BALL.half_width_at(pin))
    worn = BALL.at_depths(pin, ratio * BALL.middle_slice(pin))
    return Case(ratio, float(worn.pin_volume) / LOAD)


def percents(deviations: list[float]) -> Iterator[str]:
    """Write deviations."""
    return (f"{one:+.2f} %" for one in deviations)


def paper(report: Report, options: argparse.Namespace) -> None:
    """Compare wear of the paper's ball on tracks that wear more and more."""
    report.say(
        f"## Si₃N₄, 0.2 N, R {1e3 * RADIUS:g} mm, track radius 4 mm, k₁ 1.35·10⁻⁸ mm²/N\n\nLocal wear in µm, followed "
        "by the deviations of the results with the engines `volume` and `local`."
    )
    rows = []
    for ratio, distance in PAPER:
        case = Case(ratio / PATH, COEFFICIENT * distance)
        local = case.local(options.cells, options.steps)
        each = zip(
            (f"{1e6 * one:.5g}" for one in local),
            percents(above(case.rigid(), local)),
            percents(above(case.elastic(), local)),
            strict=True,
        )
        rows.append([f"{ratio:g}", f"{distance:g} m", *(f"{true}: {', '.join(both)}" for true, *both in each)])
    report.table(["k₂/k₁", "s", *QUANTITIES], rows)


def cases(report: Report, options: argparse.Namespace) -> None:
    """Compare 20 cases from a track that hardly wears to a ball that hardly wears."""
    report.say("## Deviations of the engines `volume` and `local` from local wear, for wear depths D ≥ δ₀")
    rows, rigid, elastic = [], [], []
    for share in TRACK_SHARES:
        for depth in DEPTHS:
            case = case_of(share, depth)
            local = case.local(options.cells, options.steps)
            rigid.append(above(case.rigid(), local))
            elastic.append(above(case.elastic(), local))
            both = zip(percents(rigid[-1]), percents(elastic[-1]), strict=True)
            rows.append([f"{share:g}", f"{depth:g}", *map(", ".join, both)])
    report.table(["κb", "D/δ₀", *QUANTITIES], rows)
    most = np.max(np.abs(elastic), axis=0)
    agree = [int(np.sum(np.max(np.abs(found), axis=1) <= CLOSE)) for found in (rigid, elastic)]
    report.say(
        f"With the engine `volume`, all four quantities are within {CLOSE:g} % of local wear in {agree[0]} of "
        f"{len(rows)} cases; with `local`, in {agree[1]} cases. The largest deviations of the engine `local` are "
        + ", ".join(f"{one:.2f} % ({name})" for one, name in zip(most, QUANTITIES, strict=True))
        + "."
    )


def limits(report: Report, options: argparse.Namespace) -> None:
    """Find the wear from which on rigid bodies agree."""
    report.say(
        f"## Wear above which the engine `volume` (rigid bodies) agrees with local wear within {CLOSE:g} %\n\nFor each "
        "quantity, the table lists the D/δ₀ above which it agrees. The last column is the wear depth of the pin alone, "
        "divided by δ₀, above which both the wear depth and the scar length of the pin agree."
    )
    depths = np.geomspace(1.0, 100.0, options.depths)
    rows = []
    for share in TRACK_SHARES:
        each = [case_of(share, depth) for depth in depths]
        off = np.abs([above(case.rigid(), case.local(options.cells, options.steps)) for case in each])
        starts = [agreeing(depths, column) for column in off.T]
        pin = max(starts[0], starts[3]) / (1 + 4 / 3 * share)
        rows.append([f"{share:g}", *(f"{start:.2g}" for start in starts), f"{pin:.2g}"])
    report.table(["κb", *QUANTITIES, "pin depth/δ₀"], rows)


def agreeing(depths: np.ndarray, off: np.ndarray) -> float:
    """Return the depth from which on deviations are small, between the depths that were computed; they fall."""
    beyond = np.flatnonzero(off > CLOSE)
    if not beyond.size:
        return float(depths[0])
    place = int(beyond[-1])
    if place + 1 == len(depths):
        return float("inf")
    two = slice(place, place + 2)
    return float(np.exp(np.interp(-np.log(CLOSE), -np.log(off[two]), np.log(depths[two]))))


def convergence(report: Report, options: argparse.Namespace) -> None:
    """Show how local wear settles with grid and steps."""
    report.say("## Convergence of local wear: pin depth, groove depth, scar half-width and half-length in µm")
    grids = [(options.cells // 2, 16), (options.cells, 16), (2 * options.cells, 16)]
    settings = [*grids, *((options.cells, steps) for steps in (8, 12, 32))]
    rows = []
    for cells, steps in settings:
        found = [case_of(share, depth).local(cells, steps) for share, depth in ((0.1, 1.0), (1.0, 10.0), (100.0, 10.0))]
        written = [" · ".join(f"{1e6 * one:.4g}" for one in case) for case in found]
        rows.append([f"{2 * cells} × {2 * cells}", str(steps), *written])
    report.table(["grid", "steps per decade", "κb 0.1, D/δ₀ 1", "κb 1, D/δ₀ 10", "κb 100, D/δ₀ 10"], rows)


def main() -> None:
    """Compare rigid bodies with local wear."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--cells", type=int, default=64, help="points of a quarter, each way (%(default)s)")
    parser.add_argument("--steps", type=int, default=16, help="steps per decade (%(default)s)")
    parser.add_argument("--depths", type=int, default=25, help="wear depths on the way to agreement (%(default)s)")
    options = parser.parse_args()
    report = Report("Wear of a ball and its track: engines compared with local wear", options)
    report.say(
        "The wear volumes of the bodies are the same in all calculations. D is the sum of the wear depths of pin and "
        "track, δ₀ the elastic approach of the unworn contact, κ = k₂/(k₁·L), and b the half-length of the scar. Local "
        f"wear is computed at {2 * options.cells} × {2 * options.cells} points, with {options.steps} steps per decade; "
        "in each case, the grid extends beyond the scar and beyond the Hertzian contact."
    )
    paper(report, options)
    cases(report, options)
    limits(report, options)
    convergence(report, options)
    report.finish()


if __name__ == "__main__":
    main()
