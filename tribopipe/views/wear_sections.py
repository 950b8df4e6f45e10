"""What fits of wear coefficients have found, on a page."""

from collections.abc import Iterator, Sequence

from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT
from tribopipe.documents.quantity import Quantity
from tribopipe.physics.conventions import WearEngine
from tribopipe.physics.laws import law_title
from tribopipe.results.disc_evaluation import DiscCoefficient, TwinDiscFit, spoken
from tribopipe.results.evaluation import Contribution, MonteCarlo, WearFit
from tribopipe.views.labeled_values import NOTHING, facts, interval, shown, signed_share
from tribopipe.views.page import TextTable
from tribopipe.views.result_summary import Steps, Told, cells

_ENGINES: dict[WearEngine, str] = {"giwm": "GIWM, even pressure", "volume": "by shape", "local": "local pressure"}


def wear_fit_told(result: WearFit, _: Steps) -> Told:
    """Tell k_D of a pin, with its budget, draws, and what reading and measurement say by themselves."""
    samples = result.effective_samples
    return Told(
        str(result),
        facts(
            (f"k_D by {law_title(result.model)}", shown(result.wear_coefficient, WEAR_COEFFICIENT)),
            ("the same in mm³/(N·m)", shown(result.wear_coefficient, SPECIFIC_WEAR_RATE)),
            ("95 % interval", interval(result.interval, WEAR_COEFFICIENT)),
            ("uncertainty by noise of the depth alone", shown(result.random_uncertainty, WEAR_COEFFICIENT)),
            ("pin wear at the end, fitted", shown(result.fitted_end_depth)),
            ("pin wear at the end, measured", shown(result.measured_end_depth)),
            (f"standard deviation{_of_blocks(result)} about the fit", shown(result.residual_deviation)),
            ("independent samples", None if samples is None else f"{samples:,.0f}"),
            ("depth against volume", _ENGINES[result.engine]),
            ("correction for drift", "two-step" if result.correction == "two-step" else "one model with k_D"),
            ("based on", result.basis),
            ("friction", result.friction),
            *((one.name.replace("_", " "), f"{one.value}") for one in result.parameters or ()),
        ),
        (*(f"{one.severity}: {one}" for one in result.findings), *result.notes),
        (
            _budget("k_D", result.budget),
            _drawn("k_D", result.wear_coefficient, result.interval, result.monte_carlo),
            _ways(result),
        ),
    )


def _of_blocks(fit: WearFit) -> str:
    return " of block averages" if fit.correction == "model" else ""


def _budget(what: str, budget: Sequence[Contribution]) -> TextTable:
    return TextTable(
        f"budget of {what}",
        ("input", "value", "stated by", "share of k_D"),
        tuple(
            (
                line.name,
                line.value.shown(line.shown_in) if line.value else NOTHING,
                "run.toml" if line.source == "manifest" else line.source,
                signed_share(line.relative),
            )
            for line in budget
        ),
    )


def _drawn(
    what: str, value: Quantity | None, ends: tuple[Quantity, Quantity] | None, draws: MonteCarlo | None
) -> TextTable:
    """Return the interval that was drawn beside that to first order."""
    rows: list[tuple[str, ...]] = []
    if draws is not None:
        stable = "" if draws.stable else ", not yet stable"
        mean = draws.mean.model_copy(update={"standard_uncertainty": draws.standard_uncertainty.value})
        agrees = "they agree" if draws.agrees_with_first_order else "they do not agree"
        first = draws.first_order_interval
        rows = [
            (
                f"Monte Carlo, {draws.draws:,} draws{stable}",
                mean.shown(WEAR_COEFFICIENT),
                interval(ends, WEAR_COEFFICIENT) or NOTHING,
                agrees,
            ),
            (
                "first order, log-normal",
                shown(value, WEAR_COEFFICIENT) or NOTHING,
                interval(first, WEAR_COEFFICIENT) or NOTHING,
                "",
            ),
        ]
    return TextTable(f"{what} by draws and to first order", ("by", what, "95 % interval", ""), tuple(rows))


def _ways(fit: WearFit) -> TextTable:
    """Return k_D by the depth reading alone, by the post-test measurement alone, and as reported."""
    known = (
        ("depth reading alone", fit.by_reading, "not trusted" if fit.basis == "measurement" else ""),
        ("post-test measurement alone", fit.by_measurement, ""),
        ("reported", fit.wear_coefficient, fit.basis or "two-step correction"),
    )
    rows = [(by, value.shown(WEAR_COEFFICIENT), note) for by, value, note in known if value is not None]
    if fit.deviation is not None:
        apart = f"{abs(fit.deviation):.1f} standard uncertainties"
        rows.append(("reading and measurement differ by", apart, ""))
    shown_rows = rows if fit.by_reading is not None else []
    return TextTable("k_D by reading and by measurement", ("by", "k_D", "based on"), tuple(shown_rows))


def disc_fit_told(result: TwinDiscFit, _: Steps) -> Told:
    """Tell k_D of both discs, with budgets and draws."""
    start = result.start
    return Told(
        str(result),
        facts(
            *(line for one in result.coefficients for line in _coefficient(one)),
            ("correlation of both k_D", None if result.correlation is None else f"{result.correlation:.2f}"),
            ("probability of as much disagreement", None if result.p_value is None else f"{result.p_value:.2g}"),
            ("distance per rotation", result.distance_per_rotation),
            ("friction", result.friction),
            ("half width of the unworn contact", None if start is None else shown(start.half_width)),
            ("half length of the unworn contact", None if start is None else shown(start.half_length)),
            ("peak pressure of the unworn contact", None if start is None else shown(start.peak_pressure, "MPa")),
        ),
        result.notes,
        tuple(_disc_tables(result)),
    )


def _coefficient(one: DiscCoefficient) -> Iterator[tuple[str, str | None]]:
    yield f"k_D of the {spoken(one.disc)}", shown(one.wear_coefficient, WEAR_COEFFICIENT)
    yield "the same in mm³/(N·m)", shown(one.wear_coefficient, SPECIFIC_WEAR_RATE)
    yield f"95 % interval, {spoken(one.disc)}", interval(one.interval, WEAR_COEFFICIENT)


def _disc_tables(fit: TwinDiscFit) -> Iterator[TextTable]:
    """Return what was fitted, the budgets, and k_D under the other ways of counting the distance slid."""
    measured = [
        (spoken(one.name), f"{one.rotations:,.0f}", *cells((one.measured, unit), (one.fitted, unit)))
        for one in fit.measurements
        for unit in ["mm^3" if one.measured.unit == "m^3" else "um"]
    ]
    yield TextTable(
        "what was measured, and what the law makes of it",
        ("measured", "rotations", "value", "by the law"),
        tuple(measured),
    )
    for one in fit.coefficients:
        what = f"k_D of the {spoken(one.disc)}"
        yield _budget(what, one.budget)
        yield _drawn(what, one.wear_coefficient, one.interval, one.monte_carlo)
    yield TextTable(
        "k_D that would wear as much, were distance counted otherwise",
        ("distance per rotation", "curved disc", "flat disc"),
        tuple(
            (one.distance_per_rotation, *cells((one.curved_disc, WEAR_COEFFICIENT), (one.flat_disc, WEAR_COEFFICIENT)))
            for one in fit.equivalents
        ),
    )
