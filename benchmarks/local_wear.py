"""Local wear: how results settle with steps and grid, and what they cost.

    python benchmarks/local_wear.py

Convergence is shown for the paper's pin (Si3N4, 200 mN, k_D = 13.5e-9 mm³/(N·mm)) and its two discs (Table 3, all radii
4 mm). Costs are medians of repeats in turn in one process. Contact solves of both kinds come down to convolutions, so
that a pin's whole course is held against one solve of 128² points, and a step of wear of two discs against one solve on
the same grid. tamaas (AGPL, so no dependency) solves the same contact where it happens to be installed.
"""

import importlib.util
import statistics
import time
from collections.abc import Callable, Iterable

import numpy as np
from labs import Report, arguments

from tribopipe.base.arrays import Column
from tribopipe.physics.calculation_methods import DistanceConvention
from tribopipe.physics.hertz import contact_modulus, hertz_radius
from tribopipe.physics.local.course import STEPS_PER_DECADE, step_ends, wear
from tribopipe.physics.local.finite_elements import pin_body, quarter_disc
from tribopipe.physics.local.grids import DiscTrack, disc_track, round_pin
from tribopipe.physics.local.nodes import graded
from tribopipe.physics.local.rings import Rings
from tribopipe.physics.pin_on_disc import SphericalPin
from tribopipe.physics.twin_disc import DiscPair

LOAD, RADIUS, COEFFICIENT = 0.2, 0.794e-3, 13.5e-15
MODULUS = float(contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24))
START = float(hertz_radius(normal_load=LOAD, pin_radius=RADIUS, modulus=MODULUS))
TABLE_3 = {
    "normal_load": 0.3,
    "modulus": float(contact_modulus(pin_modulus=152e9, pin_ratio=0.32, disc_modulus=152e9, disc_ratio=0.32)),
    "crown_radius": 4e-3,
    "curved_radius": 4e-3,
    "flat_radius": 4e-3,
}
DISC_COEFFICIENT = 1e-16
GIWM: dict[str, DistanceConvention] = {"GIWM, κ = π/4": "contact-width", "GIWM, κ = 1": "line-load"}
ROTATIONS = np.array([1e4, 1e5, 1e6, 2e6])
DISTANCES = np.array([0.01, 0.1, 1.0, 10.0, 100.0, 500.0])


def pin(per_radius: int, growth: float) -> Rings:
    """Return the pin as rings, so many in the radius of the first contact, growing with the radius further out."""
    edges = [START * number / per_radius for number in range(per_radius + 1)]
    while edges[-1] < 1.1 * 0.192e-3:
        edges.append(edges[-1] + max(START / per_radius, growth * edges[-1]))
    outline = np.array(edges)
    return Rings(LOAD, MODULUS, outline, tip((outline[1:] + outline[:-1]) / 2))


def tip(radius: Column) -> Column:
    """Return how far the sphere is behind its end at each radius, m."""
    return np.asarray(RADIUS - np.sqrt(RADIUS**2 - radius**2))


def micrometres(depths: Iterable[float]) -> list[str]:
    """Write depths in µm."""
    return [f"{1e6 * depth:.5f}" for depth in depths]


def pin_convergence(report: Report) -> None:
    """Show how the depth of the pin settles with steps and rings."""
    report.say("## Pin: wear depth in µm at several sliding distances, with different numbers of rings and steps")
    head = ["rings (spacing: number)", "steps (total)", *(f"{distance:g} m" for distance in DISTANCES)]
    grids = [(10, 0.05), (20, 0.05), (20, 0.025), (20, 0.0125), (40, 0.0125)]
    amounts = COEFFICIENT * DISTANCES
    rows = []
    cases = [((20, 0.025), steps) for steps in (2, 4, 8, 16, 64)] + [(grid, 64) for grid in grids]
    for (per_radius, growth), per_decade in cases:
        surface = pin(per_radius, growth)
        course = wear(surface, amounts, steps_per_decade=per_decade)
        rows.append(
            [
                f"{per_radius} in a₀, then {100 * growth:g} % of r: {len(surface.gap)}",
                f"{per_decade} per decade ({len(step_ends(amounts, per_decade))})",
                *micrometres(course.depth[1:]),
            ]
        )
    exact = SphericalPin(normal_load=LOAD, radius=RADIUS, modulus=MODULUS).worn(amounts * LOAD).depth
    rows.append(["GIWM", "", *micrometres(exact)])
    report.table(head, rows)
    local = wear(pin(20, 0.025), amounts).depth[1:]
    report.say(
        "The wear depth from the GIWM is smaller than the local wear depth by "
        + ", ".join(f"{100 * (1 - g / h):.3g} % at {s:g} m" for g, h, s in zip(exact, local, DISTANCES, strict=True))
        + "."
    )


def discs(cells: tuple[int, int], amount: float) -> DiscTrack:
    """Return the paper's two discs for wear up to an amount, on a quarter of the contact with so many cells."""
    return disc_track(amount=amount, cells=cells, **TABLE_3)


def disc_convergence(report: Report) -> None:
    """Show how depth and extent of two discs settle with steps and grid, and where the GIWM lies."""
    report.say("## Two discs: wear depth in µm at several numbers of slip rotations, and final a_x and a_z in µm")
    amounts = DISC_COEFFICIENT * ROTATIONS
    head = ["grid", "steps per decade", *(f"{rotations:.0e}" for rotations in ROTATIONS), "a_x", "a_z"]
    rows = []
    cases = [((64, 32), steps) for steps in (4, 8, 16, 64)] + [(cells, 64) for cells in ((32, 16), (128, 64))]
    for cells, per_decade in cases:
        course = wear(discs(cells, amounts[-1]), amounts, steps_per_decade=per_decade)
        rows.append(
            [
                f"{2 * cells[0]} × {2 * cells[1]}",
                str(per_decade),
                *micrometres(course.depth[1:]),
                f"{1e6 * course.half_width[-1]:.2f}",
                f"{1e6 * course.half_length[-1]:.2f}",
            ]
        )
    for what, distance in GIWM.items():
        state = giwm(distance).worn(ROTATIONS, DISC_COEFFICIENT)
        a_x, a_z = (1e6 * float(column[-1]) for column in (state.half_width, state.half_length))
        rows.append([what, "", *micrometres(state.curved_depth), f"{a_x:.2f}", f"{a_z:.2f}"])
    report.table(head, rows)


def element_convergence(report: Report) -> None:
    """Show how finite elements settle with the mesh, each held against rings or the half space."""
    report.say(
        "## Finite elements: wear depth in µm, with the mesh moved and the compliance recalculated every 50 steps"
    )
    amounts = COEFFICIENT * DISTANCES[1:]
    rows = []
    for per_radius, growth in ((10, 0.08), (20, 0.04), (20, 0.025)):
        radius = graded(START / per_radius, 0.21e-3, growth)
        body = pin_body(normal_load=LOAD, modulus=MODULUS, poisson_ratio=0.24, radius=radius, gap=tip(radius))
        course = wear(body, amounts, refresh_every=50)
        rows.append(
            [f"{per_radius} in a₀, then {100 * growth:g} % of r: {len(radius)}", *micrometres(course.depth[1:])]
        )
    rows.append(["rings", *micrometres(wear(pin(20, 0.025), amounts).depth[1:])])
    report.table(["pin", *(f"{distance:g} m" for distance in DISTANCES[1:])], rows)
    amounts = DISC_COEFFICIENT * ROTATIONS[1:]
    rows = []
    for cells in ((6, 3), (8, 4), (12, 6)):
        disc = quarter_disc(amount=amounts[-1], cells=cells, poisson_ratio=0.32, **TABLE_3)
        depth = wear(disc, amounts, refresh_every=50).depth[1:]
        rows.append([f"{cells[0]} × {cells[1]} cells in a quarter", *micrometres(depth)])
    rows.append(["half-space", *micrometres(wear(discs((64, 32), amounts[-1]), amounts).depth[1:])])
    report.table(["two discs", *(f"{rotations:.0e}" for rotations in ROTATIONS[1:])], rows)


def giwm(distance: DistanceConvention) -> DiscPair:
    """Return the GIWM of the same discs."""
    return DiscPair(
        normal_load=TABLE_3["normal_load"],
        crown_radius=TABLE_3["crown_radius"],
        curved_radius=TABLE_3["curved_radius"],
        flat_radius=TABLE_3["flat_radius"],
        modulus=TABLE_3["modulus"],
        slip=0.1,
        distance=distance,
    )


def costs(report: Report, repeats: int) -> None:
    """Hold the cost of a course against that of a contact solve of the kind it would otherwise take."""
    report.say("## Computing time")
    amounts = COEFFICIENT * DISTANCES[-1:]
    turns = DISC_COEFFICIENT * ROTATIONS[-1:]
    track, steps = discs((64, 32), turns[-1]), len(step_ends(turns, STEPS_PER_DECADE))
    sphere = round_pin(normal_load=LOAD, modulus=MODULUS, tip=tip, reach=1.4 * START, cells=128)
    work: dict[str, Callable[[], object]] = {
        "one contact solution of a sphere, 128 × 128 points": lambda: sphere.press(np.zeros_like(sphere.gap)),
        "wear of a pin up to 500 m, rings": lambda: wear(pin(20, 0.025), amounts),
        "one contact solution of two discs, 128 × 64 points": lambda: track.press(np.zeros_like(track.gap)),
        f"wear of two discs up to 2e6 slip rotations, {steps} steps": lambda: wear(track, turns),
    }
    if importlib.util.find_spec("tamaas") is not None:
        work["the same contact of two discs with tamaas"] = tamaas_contact(track)
    times: dict[str, list[float]] = {name: [] for name in work}
    for _ in range(repeats):
        for name, do in work.items():
            start = time.perf_counter()
            do()
            times[name].append(time.perf_counter() - start)
    medians = [statistics.median(taken) for taken in times.values()]
    report.table(
        ["", "elapsed time, ms", "minimum to maximum"],
        [
            [name, f"{1e3 * median:.1f}", f"{1e3 * min(taken):.1f} to {1e3 * max(taken):.1f}"]
            for (name, taken), median in zip(times.items(), medians, strict=True)
        ],
    )
    said = (
        f"Simulating the wear of a pin takes {medians[1] / medians[0]:.2f} times as long as one contact solution on "
        f"128 × 128 points; a wear step of the discs takes {medians[3] / steps / medians[2]:.2f} times as long as one "
        "contact solution on their grid."
    )
    if len(medians) > 4:
        said += f" tamaas takes {medians[4] / medians[2]:.2f} times as long for this contact."
    report.say(said)


def tamaas_contact(track: DiscTrack) -> Callable[[], object]:
    """Return the same contact as a call of tamaas: the whole grid, its kernel of a half space that does not repeat."""
    import tamaas as tm  # type: ignore[import-not-found,unused-ignore]

    tm.set_log_level(tm.LogLevel.error)
    shape = [2 * cells for cells in track.gap.shape]
    size = [2 * cells * step for cells, step in zip(track.gap.shape, track.half_space.spacing, strict=True)]
    half = np.concatenate([track.gap[::-1], track.gap])
    gap = np.ascontiguousarray(np.concatenate([half[:, ::-1], half], axis=1))
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, size, shape)
    model.E, model.nu = track.half_space.modulus, 0.0
    tm.ModelFactory.registerNonPeriodic(model, "free")
    solver = tm.PolonskyKeerRey(model, -gap, 1e-8)
    solver.setIntegralOperator("free")
    mean = track.normal_load / (size[0] * size[1])

    def solve() -> object:
        model.traction[...] = 0.0  # or it would begin from where it ended
        solver.solve(mean)
        return model.traction

    return solve


def main() -> None:
    """Show convergence and costs."""
    parser = arguments(__doc__ or "")
    parser.add_argument("--repeats", type=int, default=15, help="number of repeats (%(default)s)")
    options = parser.parse_args()
    report = Report("Local wear: convergence and computing time", options)
    pin_convergence(report)
    disc_convergence(report)
    element_convergence(report)
    costs(report, options.repeats)
    report.finish()


if __name__ == "__main__":
    main()
