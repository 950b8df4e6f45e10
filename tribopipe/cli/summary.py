"""What is said of an archived run in one line of a table, and in one document of JSON."""

from typing import Any

from tribopipe.archive.steps import PREDICTIONS, WEAR_FITS, Step, StepName
from tribopipe.archive.store import Archive
from tribopipe.cli.output import record_json, split_table
from tribopipe.records.quantity import Quantity
from tribopipe.records.results import DriftCorrection, FrictionFit, WearFit, WearPrediction
from tribopipe.units import pretty

K_D = "mm^3/(N*mm)"


def run_summary(archive: Archive, run_id: str) -> dict[str, Any]:
    """Return the numbers of a run as JSON types."""
    steps = archive.steps(run_id)
    drift, friction = _result(steps, "drift_correction"), _result(steps, "friction_fit")
    return {
        "id": run_id,
        "drift_rate": record_json(getattr(drift, "drift_rate", None)),
        "end_wear_depth": record_json(getattr(drift, "end_wear_depth", None)),
        "friction": record_json(friction),
        "wear_fits": {law: record_json(_result(steps, name)) for law, name in WEAR_FITS.items()},
        "predictions": {law: record_json(_result(steps, name)) for law, name in PREDICTIONS.items()},
    }


def _result(steps: dict[StepName, Step], name: StepName) -> Any:
    step = steps.get(name)
    return None if step is None else step.result


def show_summaries(archive: Archive, ids: list[str]) -> None:
    """Show the table that the whole line ends in."""
    columns = [
        "run",
        "drift, nm/min",
        "A",
        "b",
        "c, m",
        "k_D by Archard",
        "k_D by Sarkar",
        "end depth, µm",
        "predicted, Archard",
        "Sarkar",
        "from",
    ]
    title = "± is one standard uncertainty; k_D in mm³/(N·mm); end depth of the pin in µm, measured and predicted"
    split_table(title, columns, [_row(archive, run_id) for run_id in ids], at=5)


def _row(archive: Archive, run_id: str) -> list[str]:
    steps = archive.steps(run_id)
    drift, friction = _result(steps, "drift_correction"), _result(steps, "friction_fit")
    predictions = [_result(steps, name) for name in PREDICTIONS.values()]
    fitted = next((k for name in WEAR_FITS.values() if (k := _coefficient(steps, name))), None)
    reference = next((p.reference for p in predictions if isinstance(p, WearPrediction)), None)
    return [
        run_id,
        _cell(drift.drift_rate if isinstance(drift, DriftCorrection) else None, "nm/min"),
        *_friction_cells(friction),
        *(_cell(_coefficient(steps, name), K_D) for name in WEAR_FITS.values()),
        _cell(drift.pin_wear_depth if isinstance(drift, DriftCorrection) else None, "um"),
        *(_cell(p.prediction[0].wear_depth, "um") if isinstance(p, WearPrediction) else "–" for p in predictions),
        reference or ("–" if fitted is None else "(identifies k_D)"),
    ]


def _friction_cells(friction: object) -> list[str]:
    if not isinstance(friction, FrictionFit) or friction.outcome == "none":
        return ["–"] * 3
    if friction.outcome == "steady-only":
        return ["–", _cell(friction.steady_state, "1"), "not exponential"]
    return [_cell(friction.amplitude, "1"), _cell(friction.steady_state, "1"), _cell(friction.running_in_distance, "m")]


def _coefficient(steps: dict[StepName, Step], name: StepName) -> Quantity | None:
    fit = _result(steps, name)
    return fit.wear_coefficient if isinstance(fit, WearFit) else None


def _cell(quantity: Quantity | None, unit: str) -> str:
    """Show a number whose unit stands in the head of its column."""
    return "–" if quantity is None else quantity.shown(unit).removesuffix(f" {pretty(unit)}")
