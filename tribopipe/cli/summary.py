"""The row of an archived run in tables, and its JSON document."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from tribopipe.archive.outline import RunOutline
from tribopipe.archive.step_names import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, StepName, StepOutline
from tribopipe.archive.store import Archive
from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT
from tribopipe.cli.output import record_json, table
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, force
from tribopipe.documents.recipe import LawName
from tribopipe.physics.laws import law_label
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.specific_wear import SpecificWear, measured_quantity
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import PredictedBody, WearPrediction
from tribopipe.views.page import bare

R = TypeVar("R")


def run_summary(archive: Archive, run_id: str) -> dict[str, Any]:
    """Return the numbers of a run as JSON types."""
    steps = archive.outline(run_id).steps
    drift, friction = _result(steps, "drift_correction"), _result(steps, "friction_fit")
    return {
        "id": run_id,
        "clean_up": record_json(_result(steps, "clean_up")),
        "drift_rate": record_json(getattr(drift, "drift_rate", None)),
        "end_wear_depth": record_json(getattr(drift, "end_wear_depth", None)),
        "friction": record_json(friction),
        "specific_wear": record_json(_result(steps, "specific_wear")),
        "wear_fits": {law: record_json(_result(steps, name)) for law, name in WEAR_FITS.items()},
        "predictions": {law: record_json(_result(steps, name)) for law, name in PREDICTIONS.items()},
        "local_wear": {law: record_json(_result(steps, name)) for law, name in LOCAL_WEAR.items()},
    }


def _result(steps: Mapping[StepName, StepOutline], name: StepName) -> Any:
    step = steps.get(name)
    return None if step is None else step.result


def show_summaries(archive: Archive, ids: list[str]) -> None:
    """Show a table of the results of runs, and a table of specific wear rates, with a row for each body."""
    runs = [archive.outline(run_id) for run_id in ids]
    if runs:
        title = "± is one standard uncertainty; k_D in mm³/(N·mm); wear measured and predicted at the end of the test"
        laws = _laws(runs)
        table(title, _columns(laws), [row for run in runs for row in _rows(run, laws)])
    worn = [row for run in runs for row in _wear_rows(run)]
    if worn:
        table("Specific wear rate, from post-test measurements", _WEAR_COLUMNS, worn)


def _laws(runs: Sequence[RunOutline]) -> list[LawName]:
    """Return the laws that were fitted to, or predict, any of the runs."""
    steps = {name for run in runs for name in run.steps}
    return [law for law in WEAR_FITS if {WEAR_FITS[law], PREDICTIONS[law]} & steps]


def _columns(laws: Sequence[LawName]) -> tuple[str, ...]:
    labels = [law_label(law) for law in laws]
    return (
        *("run", "body", "drift, nm/min", "A", "b", "c, m"),
        *(f"k_D, {label}" for label in labels),
        "measured",
        *(f"predicted, {label}" for label in labels),
        "from",
    )


_WEAR_COLUMNS = ("run", "body", "depth, µm", "volume, mm³", "measured", "load", "distance, m", "rate, mm³/(N·m)")


def _wear_rows(run: RunOutline) -> list[list[str]]:
    """Return a row for each body with a known volume; data of the run are repeated in each."""
    found = _result(run.steps, "specific_wear")
    if not isinstance(found, SpecificWear):
        return []
    return [
        [
            run.manifest.id,
            spoken(run.manifest.described.body_name(name)),
            bare(body.depth, "um"),
            bare(body.volume, "mm^3"),
            measured_quantity(body.volume_by) if body.volume_by else "–",
            "–" if found.normal_load is None else force(found.normal_load),
            bare(found.sliding_distance, "m"),
            bare(body.specific_wear_rate, SPECIFIC_WEAR_RATE),
        ]
        for name, body in found.bodies.items()
        if body.volume is not None
    ]


def _rows(run: RunOutline, laws: Sequence[LawName]) -> list[list[str]]:
    """Return a row for each body that is fitted or predicted; only the first contains the values of the run."""
    steps, contact = run.steps, run.manifest.contact
    drift = _result(steps, "drift_correction")
    fits = [_found(steps, WEAR_FITS[law], WearFit) for law in laws]
    predictions = [_found(steps, PREDICTIONS[law], WearPrediction) for law in laws]
    origin = _origin({law: one.reference for law, one in zip(laws, predictions, strict=True) if one})
    fitted = any(fit is not None and fit.first is not None for fit in fits)
    ends: list[Mapping[str, PredictedBody]] = [{} if one is None else one.prediction[0].bodies for one in predictions]
    known = {name for one in (*(fit.bodies for fit in fits if fit is not None), *ends) for name in one}
    described = () if contact is None else contact.body_names
    names = [name for name in described if name in known] or [*described[:1]] or [""]
    rows: list[list[str]] = []
    for name in names:
        measured = _measured(run, name) if name else None
        found = [None if fit is None else fit.bodies.get(name) for fit in fits]
        rows.append(
            [
                "" if rows else run.manifest.id,
                run.manifest.worded(spoken(name)) if name else "–",
                "" if rows else bare(drift.drift_rate if isinstance(drift, DriftCorrection) else None, "nm/min"),
                *([""] * 3 if rows else _friction_cells(_result(steps, "friction_fit"))),
                *(bare(None if one is None else one.wear_coefficient, WEAR_COEFFICIENT) for one in found),
                _wear(measured),
                *(_wear(_predicted(one.get(name), measured)) for one in ends),
                "" if rows else origin or ("(fitted)" if fitted else "–"),
            ]
        )
    return rows


def _origin(references: Mapping[LawName, str | None]) -> str:
    """Return the run or runs whose k_D the predictions are based on, with the laws if these differ."""
    known = {law: reference for law, reference in references.items() if reference}
    if len(set(known.values())) <= 1:
        return next(iter(known.values()), "")
    return ", ".join(f"{reference} ({law_label(law)})" for law, reference in known.items())


def _found(steps: Mapping[StepName, StepOutline], name: StepName, record: type[R]) -> R | None:
    result = _result(steps, name)
    return result if isinstance(result, record) else None


def _measured(run: RunOutline, body: str) -> Quantity | None:
    """Return the final wear depth of a pin, or else the measured wear volume."""
    drift = _found(run.steps, "drift_correction", DriftCorrection)
    if drift is not None and drift.pin_wear_depth is not None and body == run.manifest.described.body_names[0]:
        return drift.pin_wear_depth
    volume: Quantity | None = getattr(run.manifest.end_values, f"{body}_wear_volume", None)
    return volume


def _predicted(body: PredictedBody | None, measured: Quantity | None) -> Quantity | None:
    """Return the predicted wear as the quantity that was measured."""
    if body is None:
        return None
    by_depth = body.wear_volume is None or (measured is not None and measured.unit == "m")
    return body.wear_depth if by_depth else body.wear_volume


def _wear(quantity: Quantity | None) -> str:
    return "–" if quantity is None else quantity.shown("um" if quantity.unit == "m" else "mm^3")


def _friction_cells(friction: object) -> list[str]:
    if not isinstance(friction, FrictionFit) or friction.outcome == "none":
        return ["–"] * 3
    if friction.outcome == "steady-only":
        return ["–", bare(friction.steady_state, "1"), "not exponential" if friction.window else "–"]
    return [bare(friction.amplitude, "1"), bare(friction.steady_state, "1"), bare(friction.running_in_distance, "m")]
