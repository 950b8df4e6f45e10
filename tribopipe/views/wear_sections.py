"""Results of wear fits, predictions and local wear on a page."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

from tribopipe.archive.step_names import StepName, StepOutline
from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, scaled
from tribopipe.documents.recipe import Correction
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.physics.laws import law_title
from tribopipe.results.input_quantities import input_label
from tribopipe.results.local_wear import LocalDiscPoint, LocalPairPoint, LocalPinPoint, LocalWearResult
from tribopipe.results.wear_fit import Basis, BodyWear, Contribution, WearFit
from tribopipe.results.wear_prediction import CONDITION_UNITS, PredictedPoint, WearPrediction
from tribopipe.views.page import NOTHING, Fact, TextTable, duration, facts, interval, probability, shown, signed_share

Steps: TypeAlias = Mapping[StepName, StepOutline]
"""Outline of each completed step, by name."""


class Section(NamedTuple):
    """A result as text, numbers and tables; tables without rows are not shown."""

    sentence: str
    facts: tuple[Fact, ...] = ()
    notes: tuple[str, ...] = ()
    tables: tuple[TextTable, ...] = ()

    def worded(self, words: Callable[[str], str]) -> "Section":
        """Return the same with a function applied to its texts."""
        return Section(
            words(self.sentence),
            tuple(Fact(words(fact.name), words(fact.value)) for fact in self.facts),
            tuple(map(words, self.notes)),
            tuple(
                replace(
                    table,
                    title=words(table.title),
                    columns=tuple(map(words, table.columns)),
                    rows=tuple(tuple(map(words, row)) for row in table.rows),
                )
                for table in self.tables
            ),
        )


def cells(*told: tuple[Quantity | None, str]) -> tuple[str, ...]:
    """Return quantities as table cells, each in its unit."""
    return tuple(shown(quantity, unit) or NOTHING for quantity, unit in told)


_OF_BODIES = (
    ("wear depth at the edges", "wear_depth_edge", "um"),
    ("wear volume", "wear_volume", "mm^3"),
    ("cross-sectional area of the wear track", "track_cross_section", "um^2"),
)
"""Predicted quantities of a body other than its depth in the middle."""


def prediction_section(result: WearPrediction, _: Steps) -> Section:
    """Return the predicted wear of each body at the requested positions."""
    start = result.start
    return Section(
        str(result).splitlines()[0],
        facts(
            *(
                (f"k_D used, {spoken(name)}", shown(one.wear_coefficient, WEAR_COEFFICIENT))
                for name, one in result.bodies.items()
            ),
            ("identified from", result.reference),
            ("normal load", shown(result.normal_load)),
            *((spoken(name), shown(one, CONDITION_UNITS[one.unit])) for name, one in result.conditions.items()),
            ("sliding distance per rotation", result.distance_per_rotation),
            ("half-width of the unworn contact", None if start is None else shown(start.half_width)),
            ("half-length of the unworn contact", None if start is None else shown(start.half_length)),
            ("peak pressure of the unworn contact", None if start is None else shown(start.peak_pressure, "MPa")),
            ("scheme", result.scheme),
            ("number of steps", None if result.steps is None else f"{result.steps:,}"),
            (
                "relative error due to the step size",
                None if result.step_error is None else signed_share(result.step_error),
            ),
        ),
        result.notes,
        (
            _points("predicted", result.prediction),
            _points("points at which the specified wear depths are reached", result.reached),
        ),
    )


def _points(title: str, points: Sequence[PredictedPoint]) -> TextTable:
    """Return a table of positions, without empty columns."""
    rows = [dict(_cells(one)) for one in points]
    return TextTable.of_rows(title, rows, NOTHING)


def _cells(one: PredictedPoint) -> Iterator[tuple[str, str]]:
    """Yield the cells of a position, each with its column header."""
    if one.rotations is None:
        yield "sliding distance", one.sliding_distance.shown("m")
    else:
        yield "rotations", f"{one.rotations.value:,.0f}"
    yield "time", duration(one.time) or NOTHING
    for name, body in one.bodies.items():
        yield f"wear depth, {spoken(name)}", body.wear_depth.shown("um")
    for words, what, unit in _OF_BODIES:
        for name, body in one.bodies.items():
            if (found := getattr(body, what)) is not None:
                yield f"{words}, {spoken(name)}", found.shown(unit)
    yield "contact width", scaled(one.contact.half_width, 2).shown("um")
    if one.contact.half_length.value != one.contact.half_width.value:
        yield "contact length", scaled(one.contact.half_length, 2).shown("um")
    yield "mean pressure", one.contact.mean_pressure.shown("MPa")
    if one.slip is not None:
        yield "slip", one.slip.shown("%")


def local_wear_section(result: LocalWearResult, _: Steps) -> Section:
    """Return local wear at the requested positions, compared with the GIWM."""
    pin = [one for one in result.points if isinstance(one, LocalPinPoint)]
    pair = [one for one in result.points if isinstance(one, LocalPairPoint)]
    discs = [one for one in result.points if isinstance(one, LocalDiscPoint)]
    return Section(
        str(result).splitlines()[0],
        facts(
            ("k_D used", shown(result.wear_coefficient, WEAR_COEFFICIENT)),
            ("k_D used, cylindrical disc", shown(result.flat_disc_wear_coefficient, WEAR_COEFFICIENT)),
            ("k_D used, counterbody", shown(result.track_wear_coefficient, WEAR_COEFFICIENT)),
            ("identified from", result.reference),
            ("normal load", shown(result.normal_load)),
            ("contact solver", result.engine),
            ("scheme", result.scheme),
            ("wear steps per decade", f"{result.steps_per_decade}"),
            ("grid points", " × ".join(f"{number:,}" for number in result.grid)),
            ("smallest grid spacing", shown(result.finest)),
            (
                "mesh update interval",
                f"{result.update_mesh_every} steps" if result.update_mesh_every else "never",
            ),
        ),
        result.notes,
        (_local_pin(pin), *_local_pair(pair), _local_discs(discs)),
    )


_LOCAL = ("wear depth", "GIWM wear depth", "difference", "peak pressure", "central pressure", "mean pressure")


def _local_cells(one: LocalPinPoint | LocalPairPoint | LocalDiscPoint) -> tuple[str, ...]:
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
    return TextTable("local wear of the pin and contact pressure", columns, tuple(rows))


def _local_pair(points: Sequence[LocalPairPoint]) -> Iterator[TextTable]:
    """Yield the contact, and the wear of each body in comparison with that for uniform pressure."""
    rows = [
        (
            *cells((one.sliding_distance, "m")),
            *_local_cells(one),
            *cells((one.half_width, "um"), (one.half_length, "um")),
        )
        for one in points
    ]
    labels = [name.replace("GIWM", LocalPairPoint.uniform) for name in _LOCAL]
    columns = ("sliding distance", *labels, "scar half-width", "scar half-length")
    yield TextTable("local wear of both bodies together and contact pressure", columns, tuple(rows))
    wear = [
        (
            *cells((one.sliding_distance, "m")),
            spoken(name),
            *cells(
                (body.wear_depth, "um"),
                (one.uniform_pressure.bodies[name].wear_depth, "um"),
                (body.wear_volume, "mm^3"),
            ),
        )
        for one in points
        for name, body in one.bodies.items()
    ]
    columns = ("sliding distance", "body", "wear depth", "uniform pressure wear depth", "wear volume")
    yield TextTable("local wear of each body", columns, tuple(wear))


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
    sizes = ("half-width", "half-length", "wear volume, crowned disc", "wear volume, cylindrical disc")
    return TextTable("local wear of both discs and contact pressure", ("rotations", *_LOCAL, *sizes), tuple(rows))


_CORRECTIONS: dict[Correction, str] = {"two-step": "two-step", "model": "fitted in one model with k_D"}
_BASES: dict[Basis, str] = {
    "reading": "depth signal",
    "measurement": "measurement",
    "reading and measurement": "depth signal and measurement",
}
_ENGINES: dict[WearEngine, str] = {
    "giwm": "GIWM, uniform contact pressure",
    "volume": "from the wear volume and groove shape",
    "local": "local contact pressure",
}


def wear_fit_section(result: WearFit, _: Steps) -> Section:
    """Return k_D of each body with budget and Monte Carlo results, k_D from each source, and fitted values."""
    return Section(
        str(result),
        facts(
            *(fact for name, body in result.bodies.items() for fact in _of_body(result, name, body)),
            *_of_fit(result),
            *((one.name.replace("_", " "), f"{one.value}") for one in result.parameters or ()),
        ),
        (*(f"{one.severity}: {one}" for one in result.findings), *result.notes),
        tuple(_tables(result)),
    )


def _of_body(fit: WearFit, name: str, body: BodyWear) -> Iterator[tuple[str, str | None]]:
    """Yield the results for the wear of one body."""
    of = spoken(name)
    yield f"k_D of the {of} ({law_title(fit.model)})", shown(body.wear_coefficient, WEAR_COEFFICIENT)
    yield "same value in mm³/(N·m)", shown(body.wear_coefficient, SPECIFIC_WEAR_RATE)
    yield "95 % CI", interval(body.interval, WEAR_COEFFICIENT)
    if fit.basis != "measurement":
        yield "uncertainty due to noise in the depth signal", shown(body.random_uncertainty, WEAR_COEFFICIENT)
    yield f"final wear depth of the {of} (fitted)", shown(body.fitted_end_depth)
    yield f"final wear depth of the {of} (measured)", shown(body.measured_end_depth)


def _of_fit(fit: WearFit) -> Iterator[tuple[str, str | None]]:
    """Yield the results for the whole fit."""
    samples, start = fit.effective_samples, fit.start
    yield "correlation between the two k_D values", None if fit.correlation is None else f"{fit.correlation:.2f}"
    yield "p-value of the fit", None if fit.p_value is None else probability(fit.p_value)
    yield f"standard deviation{_of_blocks(fit)} about the fit", shown(fit.residual_deviation)
    yield "independent samples", None if samples is None else f"{samples:,.0f}"
    yield "relation between wear depth and volume", _ENGINES[fit.engine]
    yield "sliding distance per rotation", fit.distance_per_rotation
    yield "drift correction", None if fit.correction is None else _CORRECTIONS[fit.correction]
    yield "based on", None if fit.basis is None else _BASES[fit.basis]
    yield "friction", fit.friction
    yield "half-width of the unworn contact", None if start is None else shown(start.half_width)
    yield "half-length of the unworn contact", None if start is None else shown(start.half_length)
    yield "peak pressure of the unworn contact", None if start is None else shown(start.peak_pressure, "MPa")


def _tables(fit: WearFit) -> Iterator[TextTable]:
    """Yield tables of fitted values, of k_D from each source, and of k_D under other distance conventions."""
    yield _fitted_values(fit)
    for name, body in fit.bodies.items():
        what = f"k_D of the {spoken(name)}"
        yield _budget(what, body.budget)
        yield _drawn(what, body)
        yield _ways(what, fit, body)
    yield _equivalents(fit)


def _of_blocks(fit: WearFit) -> str:
    return " of block averages" if fit.correction == "model" else ""


def _budget(what: str, budget: Sequence[Contribution]) -> TextTable:
    """Return an uncertainty budget (JCGM 100:2008, 5.1.2)."""
    variance = sum(line.relative**2 for line in budget)
    rows = [
        (
            input_label(line.name),
            line.value.shown(line.shown_in) if line.value else NOTHING,
            "run.toml" if line.source == "manifest" else line.source,
            line.distribution,
            NOTHING if line.sensitivity is None else _signed(line.sensitivity),
            _percent(abs(line.relative), 2),
            _percent(line.relative**2 / variance, 1) if variance else NOTHING,
        )
        for line in budget
    ]
    return TextTable(
        f"uncertainty budget of {what}",
        ("input", "value", "source", "distribution", "sensitivity", "contribution", "share of variance"),
        tuple(rows),
        spare=("distribution", "sensitivity"),
    )


def _signed(sensitivity: float) -> str:
    """Format a sensitivity with its sign, "−1.00"; one that rounds to zero has no sign."""
    written = f"{sensitivity:+.2f}".replace("-", "−")
    return "0.00" if written[1:] == "0.00" else written


def _percent(share: float, decimals: int) -> str:
    return f"{100 * share:.{decimals}f} %"


def _drawn(what: str, body: BodyWear) -> TextTable:
    """Return the Monte Carlo interval with that from first-order propagation."""
    rows: list[tuple[str, ...]] = []
    if (draws := body.monte_carlo) is not None:
        stable = "" if draws.stable else " (not converged)"
        mean = draws.mean.model_copy(update={"standard_uncertainty": draws.standard_uncertainty.value})
        agrees = "agree" if draws.agrees_with_first_order else "do not agree"
        rows = [
            (
                f"Monte Carlo, {draws.draws:,} draws{stable}",
                mean.shown(WEAR_COEFFICIENT),
                interval(body.interval, WEAR_COEFFICIENT) or NOTHING,
                agrees,
            ),
            (
                "first-order, log-normal",
                shown(body.wear_coefficient, WEAR_COEFFICIENT) or NOTHING,
                interval(draws.first_order_interval, WEAR_COEFFICIENT) or NOTHING,
                "",
            ),
        ]
    return TextTable(f"{what}: Monte Carlo and first-order", ("method", what, "95 % CI", ""), tuple(rows))


def _ways(what: str, fit: WearFit, body: BodyWear) -> TextTable:
    """Return k_D from the depth signal alone, from the post-test measurement alone, and as reported."""
    known = (
        ("depth signal alone", body.by_reading, "not used" if fit.basis == "measurement" else ""),
        ("post-test measurement alone", body.by_measurement, ""),
        ("reported", body.wear_coefficient, _BASES[fit.basis] if fit.basis else "two-step correction"),
    )
    rows = [(by, value.shown(WEAR_COEFFICIENT), note) for by, value, note in known if value is not None]
    if fit.deviation is not None:
        apart = f"{abs(fit.deviation):.1f} standard uncertainties"
        rows.append(("difference", apart, ""))
    shown_rows = rows if body.by_reading is not None else []
    return TextTable(f"{what} from depth signal and measurement", ("method", "k_D", "based on"), tuple(shown_rows))


def _fitted_values(fit: WearFit) -> TextTable:
    rows = [
        (input_label(one.name), f"{one.place:,.0f}", *cells((one.measured, unit), (one.fitted, unit)))
        for one in fit.measurements
        for unit in ["mm^3" if one.measured.unit == "m^3" else "um"]
    ]
    return TextTable("measured values and the fitted law", ("measured", "rotations", "value", "model"), tuple(rows))


def _equivalents(fit: WearFit) -> TextTable:
    rows = [
        (one.distance_per_rotation, *cells(*((found, WEAR_COEFFICIENT) for found in one.bodies.values())))
        for one in fit.equivalents
    ]
    return TextTable(
        "k_D with other sliding-distance conventions",
        ("sliding distance per rotation", *map(spoken, fit.bodies)),
        tuple(rows),
    )
