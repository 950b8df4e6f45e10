"""What predictions and local wear come to, on a page."""

from collections.abc import Iterator, Sequence

from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import Quantity
from tribopipe.results.local_wear import LocalDiscPoint, LocalPinPoint, LocalWearResult
from tribopipe.results.wear_prediction import DiscPoint, PredictedPoint, TwinDiscPrediction, WearPrediction
from tribopipe.views.labeled_values import NOTHING, duration, facts, shown, signed_share
from tribopipe.views.page import TextTable
from tribopipe.views.result_summary import Steps, Told, cells


def prediction_told(result: WearPrediction, _: Steps) -> Told:
    """Tell wear of a pin at the wanted places."""
    return Told(
        str(result).splitlines()[0],
        facts(
            ("k_D used", shown(result.wear_coefficient, WEAR_COEFFICIENT)),
            ("identified from", result.reference),
            ("normal load", shown(result.normal_load)),
            ("pin radius", shown(result.pin_radius, "mm")),
            *_scheme(result),
        ),
        result.notes,
        (
            _pin_points("predicted", result.prediction),
            _pin_points("where wanted depths are reached", result.reached),
        ),
    )


def _scheme(prediction: WearPrediction | TwinDiscPrediction) -> Iterator[tuple[str, str | None]]:
    yield "scheme", prediction.scheme
    yield "steps of the scheme", None if prediction.steps is None else f"{prediction.steps:,}"
    yield "relative error by its steps", None if prediction.step_error is None else signed_share(prediction.step_error)


def _pin_points(title: str, points: Sequence[PredictedPoint]) -> TextTable:
    return TextTable(
        title,
        ("sliding distance", "time", "wear depth", "contact radius", "mean pressure"),
        tuple(
            (
                one.sliding_distance.shown("m"),
                duration(one.time) or NOTHING,
                *cells((one.wear_depth, "um"), (one.contact_radius, "um"), (one.pressure, "MPa")),
            )
            for one in points
        ),
    )


def disc_prediction_told(result: TwinDiscPrediction, _: Steps) -> Told:
    """Tell wear of both discs at the wanted places."""
    return Told(
        str(result).splitlines()[0],
        facts(
            ("k_D used, curved disc", shown(result.curved_disc_wear_coefficient, WEAR_COEFFICIENT)),
            ("k_D used, flat disc", shown(result.flat_disc_wear_coefficient, WEAR_COEFFICIENT)),
            ("identified from", result.reference),
            ("normal load", shown(result.normal_load)),
            ("slip", shown(result.slip, "%")),
            ("distance per rotation", result.distance_per_rotation),
            ("half width of the unworn contact", shown(result.start.half_width)),
            ("half length of the unworn contact", shown(result.start.half_length)),
            ("peak pressure of the unworn contact", shown(result.start.peak_pressure, "MPa")),
            *_scheme(result),
        ),
        result.notes,
        (
            _disc_points("predicted", result.prediction),
            _disc_points("where wanted depths are reached", result.reached),
        ),
    )


def _disc_points(title: str, points: Sequence[DiscPoint]) -> TextTable:
    return TextTable(
        title,
        (
            *("rotations", "time", "curved disc, depth", "flat disc, depth", "curved disc, volume"),
            *("flat disc, volume", "track width", "mean pressure", "slip"),
        ),
        tuple(
            (
                f"{one.rotations.value:,.0f}",
                duration(one.time) or NOTHING,
                *cells(
                    (one.curved_disc_wear_depth, "um"),
                    (one.flat_disc_wear_depth, "um"),
                    (one.curved_disc_wear_volume, "mm^3"),
                    (one.flat_disc_wear_volume, "mm^3"),
                    (_twice(one.half_width), "um"),
                    (one.pressure, "MPa"),
                    (one.slip, "%"),
                ),
            )
            for one in points
        ),
    )


def _twice(half: Quantity) -> Quantity:
    spread = half.standard_uncertainty
    return Quantity(value=2 * half.value, unit=half.unit, standard_uncertainty=None if spread is None else 2 * spread)


def local_wear_told(result: LocalWearResult, _: Steps) -> Told:
    """Tell local wear at the wanted places, beside the GIWM."""
    pin = [one for one in result.points if isinstance(one, LocalPinPoint)]
    discs = [one for one in result.points if isinstance(one, LocalDiscPoint)]
    return Told(
        str(result).splitlines()[0],
        facts(
            ("k_D used", shown(result.wear_coefficient, WEAR_COEFFICIENT)),
            ("k_D used, flat disc", shown(result.flat_disc_wear_coefficient, WEAR_COEFFICIENT)),
            ("identified from", result.reference),
            ("normal load", shown(result.normal_load)),
            ("contact solved by", result.engine),
            ("scheme", result.scheme),
            ("wear steps per decade", f"{result.steps_per_decade}"),
            ("points of the grid", " × ".join(f"{number:,}" for number in result.grid)),
            ("least distance between points", shown(result.finest)),
            ("elasticity anew every", f"{result.update_mesh_every} steps" if result.update_mesh_every else "never"),
        ),
        result.notes,
        (_local_pin(pin), _local_discs(discs)),
    )


_LOCAL = ("wear depth", "by the GIWM", "difference", "peak pressure", "in the middle", "on average")


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
    sizes = ("half width", "half length", "curved disc, volume", "flat disc, volume")
    return TextTable("local wear of both discs, and pressure", ("rotations", *_LOCAL, *sizes), tuple(rows))
