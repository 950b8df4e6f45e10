"""What is stated about an archived run in one line of a table, and in one document of JSON."""

from collections.abc import Mapping, Sequence
from typing import Any

from tribopipe.archive.archived_run import RunOutline, StepOutline
from tribopipe.archive.steps import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, StepName
from tribopipe.archive.store import Archive
from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT, pretty, show
from tribopipe.cli.output import record_json, table
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, force
from tribopipe.documents.slip import slip
from tribopipe.documents.twin_disc import DISCS
from tribopipe.physics.laws import law_label
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.specific_wear import SpecificWear, measured_quantity
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction


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
    """Show the tables that the whole line ends in, one for each type of tribometer."""
    pins: list[list[str]] = []
    discs: list[list[str]] = []
    worn: list[list[str]] = []
    for run_id in ids:
        run = archive.outline(run_id)
        pins += [] if run.manifest.rolls else [_row(run)]
        discs += _disc_rows(run) if run.manifest.rolls else []
        worn += _wear_rows(run)
    if pins:
        title = "± is one standard uncertainty; k_D in mm³/(N·mm); end depth of the pin in µm, measured and predicted"
        columns = _columns(("run", "drift, nm/min", "A", "b", "c, m"), "end depth, µm")
        table(title, columns, pins)
    if discs:
        title = "Two discs: k_D in mm³/(N·mm) and wear volume in mm³, of the crowned and the cylindrical disc"
        columns = _columns(("run", "slip", "rotations", "drift, nm/min", "b", "disc"), "measured")
        table(title, columns, discs)
    if worn:
        table("Specific wear rate, from post-test measurements", _WEAR_COLUMNS, worn)


_WEAR_COLUMNS = ("run", "body", "depth, µm", "volume, mm³", "measured", "load", "distance, m", "rate, mm³/(N·m)")


def _wear_rows(run: RunOutline) -> list[list[str]]:
    """Return a row for each body of which a volume is known; what belongs to the run stands in each."""
    found = _result(run.steps, "specific_wear")
    if not isinstance(found, SpecificWear):
        return []
    return [
        [
            run.manifest.id,
            spoken(run.manifest.described.body_name(name)),
            _cell(body.depth, "um"),
            _cell(body.volume, "mm^3"),
            measured_quantity(body.volume_by) if body.volume_by else "–",
            "–" if found.normal_load is None else force(found.normal_load),
            _cell(found.sliding_distance, "m"),
            _cell(body.specific_wear_rate, SPECIFIC_WEAR_RATE),
        ]
        for name, body in found.bodies.items()
        if body.volume is not None
    ]


def _columns(about: Sequence[str], measured: str) -> list[str]:
    """Return the heads of a table: what it states about runs, then k_D and predictions under each law."""
    first, *others = map(law_label, WEAR_FITS)
    k_d = [f"k_D by {law}" for law in (first, *others)]
    return [*about, *k_d, measured, f"predicted, {first}", *others, "from"]


def _disc_rows(run: RunOutline) -> list[list[str]]:
    """Return one row per disc; only the first has the values of the run."""
    steps, manifest = run.steps, run.manifest
    drift, friction = _result(steps, "drift_correction"), _result(steps, "friction_fit")
    fits = [_result(steps, name) for name in WEAR_FITS.values()]
    predictions = [_result(steps, name) for name in PREDICTIONS.values()]
    volumes = {name: getattr(manifest.end_values, f"{name}_wear_volume") for name in DISCS}
    reference = next((p.reference for p in predictions if isinstance(p, WearPrediction)), None)
    fitted = any(isinstance(fit, WearFit) and fit.outcome == "fitted" for fit in fits)
    about = [
        manifest.id,
        show(slip(manifest).value, None, "1", "%"),
        f"{run.ends['rotations']:,.0f}" if "rotations" in run.ends else "–",
        _cell(drift.drift_rate if isinstance(drift, DriftCorrection) else None, "nm/min"),
        _cell(friction.steady_state if isinstance(friction, FrictionFit) else None, "1"),
    ]
    rows: list[list[str]] = []
    for name in DISCS:
        found = [fit.bodies.get(name) if isinstance(fit, WearFit) else None for fit in fits]
        ends = [
            p.prediction[0].bodies[name].wear_volume if isinstance(p, WearPrediction) else None for p in predictions
        ]
        rows.append(
            [
                *(about if not rows else [""] * len(about)),
                spoken(name).removesuffix(" disc"),
                *(_cell(one.wear_coefficient if one is not None else None, WEAR_COEFFICIENT) for one in found),
                *(_cell(volume, "mm^3") for volume in (volumes[name], *ends)),
                (reference or ("(identifies k_D)" if fitted else "–")) if not rows else "",
            ]
        )
    return rows


def _row(run: RunOutline) -> list[str]:
    steps = run.steps
    drift, friction = _result(steps, "drift_correction"), _result(steps, "friction_fit")
    predictions = [_result(steps, name) for name in PREDICTIONS.values()]
    fitted = next((k for name in WEAR_FITS.values() if (k := _coefficient(steps, name))), None)
    reference = next((p.reference for p in predictions if isinstance(p, WearPrediction)), None)
    return [
        run.manifest.id,
        _cell(drift.drift_rate if isinstance(drift, DriftCorrection) else None, "nm/min"),
        *_friction_cells(friction),
        *(_cell(_coefficient(steps, name), WEAR_COEFFICIENT) for name in WEAR_FITS.values()),
        _cell(drift.pin_wear_depth if isinstance(drift, DriftCorrection) else None, "um"),
        *(_cell(p.prediction[0].contact.approach, "um") if isinstance(p, WearPrediction) else "–" for p in predictions),
        reference or ("–" if fitted is None else "(identifies k_D)"),
    ]


def _friction_cells(friction: object) -> list[str]:
    if not isinstance(friction, FrictionFit) or friction.outcome == "none":
        return ["–"] * 3
    if friction.outcome == "steady-only":
        return ["–", _cell(friction.steady_state, "1"), "not exponential" if friction.window else "–"]
    return [_cell(friction.amplitude, "1"), _cell(friction.steady_state, "1"), _cell(friction.running_in_distance, "m")]


def _coefficient(steps: Mapping[StepName, StepOutline], name: StepName) -> Quantity | None:
    fit = _result(steps, name)
    return fit.first.wear_coefficient if isinstance(fit, WearFit) and fit.first is not None else None


def _cell(quantity: Quantity | None, unit: str) -> str:
    """Show a number whose unit stands in the head of its column."""
    return "–" if quantity is None else quantity.shown(unit).removesuffix(f" {pretty(unit)}")
