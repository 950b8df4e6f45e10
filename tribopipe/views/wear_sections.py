"""What fits of wear coefficients have found, on a page."""

from collections.abc import Iterator, Sequence

from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.recipe import Correction
from tribopipe.physics.conventions import WearEngine
from tribopipe.physics.laws import law_title
from tribopipe.results.input_quantities import input_label
from tribopipe.results.wear_fit import BodyWear, Contribution, WearFit
from tribopipe.views.labeled_values import NOTHING, facts, interval, shown
from tribopipe.views.page import TextTable
from tribopipe.views.result_summary import Steps, Told, cells

_CORRECTIONS: dict[Correction, str] = {"two-step": "two-step", "model": "one model with k_D"}
_ENGINES: dict[WearEngine, str] = {"giwm": "GIWM, uniform pressure", "volume": "by shape", "local": "local pressure"}


def wear_fit_told(result: WearFit, _: Steps) -> Told:
    """Report k_D of each body with its budget and draws, by reading and by measurement alone, and what was fitted."""
    return Told(
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
    """Yield what is known of the wear of one body."""
    of = spoken(name)
    yield f"k_D of the {of} by {law_title(fit.model)}", shown(body.wear_coefficient, WEAR_COEFFICIENT)
    yield "the same in mm³/(N·m)", shown(body.wear_coefficient, SPECIFIC_WEAR_RATE)
    yield "95 % interval", interval(body.interval, WEAR_COEFFICIENT)
    yield "uncertainty from noise of the depth signal", shown(body.random_uncertainty, WEAR_COEFFICIENT)
    yield f"wear depth of the {of} at the end, fitted", shown(body.fitted_end_depth)
    yield f"wear depth of the {of} at the end, measured", shown(body.measured_end_depth)


def _of_fit(fit: WearFit) -> Iterator[tuple[str, str | None]]:
    """Yield what is known of the fit as a whole."""
    samples, start = fit.effective_samples, fit.start
    yield "correlation between the two k_D values", None if fit.correlation is None else f"{fit.correlation:.2f}"
    yield "p-value of the difference", None if fit.p_value is None else f"{fit.p_value:.2g}"
    yield f"standard deviation{_of_blocks(fit)} about the fit", shown(fit.residual_deviation)
    yield "independent samples", None if samples is None else f"{samples:,.0f}"
    yield "depth against volume", _ENGINES[fit.engine]
    yield "distance per rotation", fit.distance_per_rotation
    yield "correction for drift", None if fit.correction is None else _CORRECTIONS[fit.correction]
    yield "based on", fit.basis
    yield "friction", fit.friction
    yield "half width of the unworn contact", None if start is None else shown(start.half_width)
    yield "half length of the unworn contact", None if start is None else shown(start.half_length)
    yield "peak pressure of the unworn contact", None if start is None else shown(start.peak_pressure, "MPa")


def _tables(fit: WearFit) -> Iterator[TextTable]:
    """Yield what was fitted, how each k_D is known, and k_D under other ways of counting the sliding distance."""
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
        f"budget of {what}",
        ("input", "value", "stated by", "distribution", "sensitivity", "contribution", "share of variance"),
        tuple(rows),
        spare=("distribution", "sensitivity"),
    )


def _signed(sensitivity: float) -> str:
    """Write a sensitivity with its sign, "−1.00"; one that rounds to nothing without."""
    written = f"{sensitivity:+.2f}".replace("-", "−")
    return "0.00" if written[1:] == "0.00" else written


def _percent(share: float, decimals: int) -> str:
    return f"{100 * share:.{decimals}f} %"


def _drawn(what: str, body: BodyWear) -> TextTable:
    """Return the interval that was drawn with that by first-order propagation."""
    rows: list[tuple[str, ...]] = []
    if (draws := body.monte_carlo) is not None:
        stable = "" if draws.stable else ", not yet stable"
        mean = draws.mean.model_copy(update={"standard_uncertainty": draws.standard_uncertainty.value})
        agrees = "they agree" if draws.agrees_with_first_order else "they do not agree"
        rows = [
            (
                f"Monte Carlo, {draws.draws:,} draws{stable}",
                mean.shown(WEAR_COEFFICIENT),
                interval(body.interval, WEAR_COEFFICIENT) or NOTHING,
                agrees,
            ),
            (
                "first order, log-normal",
                shown(body.wear_coefficient, WEAR_COEFFICIENT) or NOTHING,
                interval(draws.first_order_interval, WEAR_COEFFICIENT) or NOTHING,
                "",
            ),
        ]
    return TextTable(f"{what} by Monte Carlo and first-order", ("by", what, "95 % interval", ""), tuple(rows))


def _ways(what: str, fit: WearFit, body: BodyWear) -> TextTable:
    """Return k_D by the depth reading alone, by the post-test measurement alone, and as reported."""
    known = (
        ("depth reading alone", body.by_reading, "not trusted" if fit.basis == "measurement" else ""),
        ("post-test measurement alone", body.by_measurement, ""),
        ("reported", body.wear_coefficient, fit.basis or "two-step correction"),
    )
    rows = [(by, value.shown(WEAR_COEFFICIENT), note) for by, value, note in known if value is not None]
    if fit.deviation is not None:
        apart = f"{abs(fit.deviation):.1f} standard uncertainties"
        rows.append(("reading and measurement differ by", apart, ""))
    shown_rows = rows if body.by_reading is not None else []
    return TextTable(f"{what} by reading and by measurement", ("by", "k_D", "based on"), tuple(shown_rows))


def _fitted_values(fit: WearFit) -> TextTable:
    rows = [
        (input_label(one.name), f"{one.place:,.0f}", *cells((one.measured, unit), (one.fitted, unit)))
        for one in fit.measurements
        for unit in ["mm^3" if one.measured.unit == "m^3" else "um"]
    ]
    return TextTable(
        "measured values and the fitted law", ("measured", "rotations", "value", "by the law"), tuple(rows)
    )


def _equivalents(fit: WearFit) -> TextTable:
    rows = [
        (one.distance_per_rotation, *cells(*((found, WEAR_COEFFICIENT) for found in one.bodies.values())))
        for one in fit.equivalents
    ]
    return TextTable(
        "k_D with other conventions of sliding distance",
        ("distance per rotation", *map(spoken, fit.bodies)),
        tuple(rows),
    )
