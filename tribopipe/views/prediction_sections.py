"""What predictions and local wear come to, on a page."""

from collections.abc import Iterator, Sequence

from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.results.local_wear import LocalDiscPoint, LocalPinPoint, LocalWearResult
from tribopipe.results.wear_prediction import PredictedPoint, WearPrediction
from tribopipe.views.labeled_values import NOTHING, duration, facts, shown, signed_share
from tribopipe.views.page import TextTable
from tribopipe.views.result_summary import Steps, Told, cells

_UNITS = {"m": "mm", "1": "%"}
"""Units in which people read sizes and ratios."""


_OF_BODIES = (
    ("depth at the sides", "wear_depth_edge", "um"),
    ("volume", "wear_volume", "mm^3"),
    ("cross-section of the track", "track_cross_section", "um^2"),
)
"""What else than its depth in the middle is stated of a body where it is predicted."""


def prediction_told(result: WearPrediction, _: Steps) -> Told:
    """Report wear of each body at the wanted places."""
    start = result.start
    return Told(
        str(result).splitlines()[0],
        facts(
            *(
                (f"k_D used, {spoken(name)}", shown(one.wear_coefficient, WEAR_COEFFICIENT))
                for name, one in result.bodies.items()
            ),
            ("identified from", result.reference),
            ("normal load", shown(result.normal_load)),
            *((spoken(name), shown(one, _UNITS[one.unit])) for name, one in result.conditions.items()),
            ("distance per rotation", result.distance_per_rotation),
            ("half width of the unworn contact", None if start is None else shown(start.half_width)),
            ("half length of the unworn contact", None if start is None else shown(start.half_length)),
            ("peak pressure of the unworn contact", None if start is None else shown(start.peak_pressure, "MPa")),
            ("scheme", result.scheme),
            ("number of steps", None if result.steps is None else f"{result.steps:,}"),
            ("relative error of the steps", None if result.step_error is None else signed_share(result.step_error)),
        ),
        result.notes,
        (_points("predicted", result.prediction), _points("points at which depths are reached", result.reached)),
    )


def _points(title: str, points: Sequence[PredictedPoint]) -> TextTable:
    """Return a table of places; what no place has, such as a slip, has no column."""
    rows = [dict(_cells(one)) for one in points]
    columns = tuple(dict.fromkeys(name for row in rows for name in row))
    return TextTable(title, columns, tuple(tuple(row.get(name, NOTHING) for name in columns) for row in rows))


def _cells(one: PredictedPoint) -> Iterator[tuple[str, str]]:
    """Yield what is stated about a place, each with its head."""
    if one.rotations is None:
        yield "sliding distance", one.sliding_distance.shown("m")
    else:
        yield "rotations", f"{one.rotations.value:,.0f}"
    yield "time", duration(one.time) or NOTHING
    for name, body in one.bodies.items():
        yield f"{spoken(name)}, depth", body.wear_depth.shown("um")
    for words, what, unit in _OF_BODIES:
        for name, body in one.bodies.items():
            if (found := getattr(body, what)) is not None:
                yield f"{spoken(name)}, {words}", found.shown(unit)
    yield "contact width", _twice(one.contact.half_width).shown("um")
    if one.contact.half_length.value != one.contact.half_width.value:
        yield "contact length", _twice(one.contact.half_length).shown("um")
    yield "mean pressure", one.contact.mean_pressure.shown("MPa")
    if one.slip is not None:
        yield "slip", one.slip.shown("%")


def _twice(half: Quantity) -> Quantity:
    spread = half.standard_uncertainty
    return Quantity(value=2 * half.value, unit=half.unit, standard_uncertainty=None if spread is None else 2 * spread)


def local_wear_told(result: LocalWearResult, _: Steps) -> Told:
    """Report local wear at the wanted places, with the GIWM."""
    pin = [one for one in result.points if isinstance(one, LocalPinPoint)]
    discs = [one for one in result.points if isinstance(one, LocalDiscPoint)]
    return Told(
        str(result).splitlines()[0],
        facts(
            ("k_D used", shown(result.wear_coefficient, WEAR_COEFFICIENT)),
            ("k_D used, cylindrical disc", shown(result.flat_disc_wear_coefficient, WEAR_COEFFICIENT)),
            ("identified from", result.reference),
            ("normal load", shown(result.normal_load)),
            ("contact solved with", result.engine),
            ("scheme", result.scheme),
            ("wear steps per decade", f"{result.steps_per_decade}"),
            ("grid points", " × ".join(f"{number:,}" for number in result.grid)),
            ("smallest grid spacing", shown(result.finest)),
            ("elasticity updated every", f"{result.update_mesh_every} steps" if result.update_mesh_every else "never"),
        ),
        result.notes,
        (_local_pin(pin), _local_discs(discs)),
    )


_LOCAL = ("wear depth", "with the GIWM", "difference", "peak pressure", "in the middle", "on average")


def _local_cells(one: LocalPinPoint | LocalDiscPoint) -> tuple[str, ...]:
    depths = cells((one.wear_depth, "um"), (one.giwm_depth, "um"))
    more = NOTHING if one.difference is None else signed_share(one.difference)
    pressures = ((one.peak_pressure, "MPa"), (one.middle_pressure, "MPa"), (one.mean_pressure, "MPa"))
    return (*depths, more, *cells(*pressures))


def _local_pin(points: Sequence[LocalPinPoint]) -> TextTable:
    rows = [
        (
            *cells((one.sliding_distance, "m")),
            *_local_cells(one),
            *cells((one.contact_radius, "um"), (one.wear_volume, "mm^3")),
        )
        for one in points
    ]
    columns = ("sliding distance", *_LOCAL, "contact radius", "volume")
    return TextTable("local wear of the pin, and pressure on it", columns, tuple(rows))


def _local_discs(points: Sequence[LocalDiscPoint]) -> TextTable:
    rows = [
        (
            f"{one.rotations.value:,.0f}",
            *_local_cells(one),
            *cells((one.half_width, "um"), (one.half_length, "um")),
            *cells((one.curved_disc_wear_volume, "mm^3"), (one.flat_disc_wear_volume, "mm^3")),
        )
        for one in points
    ]
    sizes = ("half width", "half length", "crowned disc, volume", "cylindrical disc, volume")
    return TextTable("local wear of both discs, and pressure", ("rotations", *_LOCAL, *sizes), tuple(rows))
