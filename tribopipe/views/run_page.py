"""One archived run on a page: bodies, conditions, results of each step, and sources."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from tribopipe.archive.outline import RunOutline
from tribopipe.archive.step_names import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, StepName, StepOutline
from tribopipe.archive.store import Archive
from tribopipe.base.column_formatting import moment
from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT, show
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import Conditions, EndValues, RunManifest
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.quantity import Quantity, between
from tribopipe.documents.record import Record
from tribopipe.physics.laws import law_title
from tribopipe.results.evaluation import DepthModel, DriftCorrection, FrictionFit, StrokeFriction
from tribopipe.results.finding import Finding, first_of_each_code
from tribopipe.results.local_wear import LocalWearResult
from tribopipe.results.specific_wear import BodyWearRate, SpecificWear, measured_quantities, measured_quantity
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction
from tribopipe.views.page import (
    NOTHING,
    Fact,
    FactGroup,
    Remark,
    RunPage,
    SourceEntry,
    StagePage,
    TextTable,
    duration,
    facts,
    interval,
    listed,
    record_facts,
    shown,
)
from tribopipe.views.wear_sections import Section, Steps, local_wear_section, prediction_section, wear_fit_section

_TITLES: Mapping[StepName, str] = {
    "clean_up": "Preprocessing",
    "drift_correction": "Drift correction",
    "friction_fit": "Friction",
    "specific_wear": "Specific wear rate",
}
_UNDER_LAWS = ((WEAR_FITS, "Wear coefficient"), (PREDICTIONS, "Prediction"), (LOCAL_WEAR, "Local wear"))


def step_title(name: StepName) -> str:
    """Return the displayed name of a step."""
    for steps, title in _UNDER_LAWS:
        if (law := steps.law_of(name)) is not None:
            return f"{title} ({law_title(law)})"
    return _TITLES[name]


def stage_pages(steps: Steps, worded: Callable[[str], str] = str) -> tuple[StagePage, ...]:
    """Return a page for each step, in order; ``worded`` replaces the names of bodies by those of the contact."""
    return tuple(_stage_page(step, steps, worded) for step in steps.values())


def _stage_page(step: StepOutline, steps: Steps, worded: Callable[[str], str]) -> StagePage:
    section = _SECTIONS[type(step.result)](step.result, steps).worded(worded)
    return StagePage(
        name=step.name,
        title=step_title(step.name),
        sentence=section.sentence,
        facts=section.facts,
        notes=section.notes,
        tables=tuple(table for table in section.tables if table.rows),
        path=f"/entry/{step.name}",
        program_version=step.program_version,
        date=step.date,
        options=step.options,
        inputs_sha256=step.inputs_sha256,
        result_sha256=step.result_sha256,
    )


def _clean_up_section(result: CleanUp, _: Steps) -> Section:
    rows = [(spoken(one.signal), one.step, f"{one.samples:,}", one.what, one.why) for one in result.changes]
    return Section(
        "; ".join(f"{one.signal}: {one.what}" for one in result.changes) or "nothing to do",
        (
            *facts(*((f"{spoken(name)}, recalculated", origin) for name, origin in result.derived.items())),
            *facts(("excluded", listed(map(spoken, result.left_out)))),
        ),
        tables=(TextTable("changes", ("signal", "step", "samples", "change", "reason"), tuple(rows)),),
    )


def _drift_correction_section(result: DriftCorrection, _: Steps) -> Section:
    return Section(
        str(result),
        facts(
            ("drift rate", shown(result.drift_rate, "nm/min")),
            ("drift rate (two-step correction)", _by_two_steps(result)),
            ("zero offset", shown(result.zero_offset)),
            ("discrepancy at the end", shown(result.discrepancy)),
            ("post-test measurement used", result.anchor and measured_quantities(result.anchor)),
            ("wear depth at the end", shown(result.end_wear_depth)),
            ("contribution of the pin", shown(result.pin_wear_depth)),
            ("contribution of the disc", shown(result.disc_wear_depth)),
            *(() if result.model is None else _besides_wear(result.model)),
        ),
    )


def _by_two_steps(result: DriftCorrection) -> str | None:
    return None if result.model is None else shown(result.two_step_rate, "nm/min")


def _besides_wear(model: DepthModel) -> Iterator[tuple[str, str | None]]:
    """Yield the contributions to the depth signal in the model other than wear and linear drift."""
    yield "95 % CI of the drift rate", between(model.drift_interval, "nm/min")
    yield "probability of settling", f"{model.settling_probability:.2f}"
    yield "settling amplitude", shown(model.settling)
    yield "settling time constant", duration(model.settling_time)
    if model.thermal_probability is not None:
        yield "probability of a temperature-dependent shift", f"{model.thermal_probability:.2f}"
    yield "shift over the temperature range", shown(model.thermal_shift)
    yield "low-frequency fluctuations (RMS)", shown(model.wander, "nm")
    yield "noise of block averages (standard deviation)", shown(model.noise, "nm")


def _friction_section(result: FrictionFit, _: Steps) -> Section:
    sentences = {
        "none": "friction not fitted",
        "steady-only": f"μ = {result.steady_state}, steady-state value only",
        "exponential": str(result.model_copy(update={"notes": ()})),
    }
    samples = result.effective_samples
    return Section(
        sentences[result.outcome],
        facts(
            ("A, initial excess over the steady state", shown(result.amplitude)),
            ("b, steady state", shown(result.steady_state)),
            ("c, running-in distance", shown(result.running_in_distance, "m")),
            ("fitted range", interval(result.window, "m")),
            ("standard deviation about the fit", shown(result.residual_deviation)),
            ("independent samples", None if samples is None else f"{samples:,.0f}"),
            ("mean of μ over the run", shown(result.mean)),
            ("standard deviation of μ over the run", shown(result.standard_deviation)),
            ("load used for the friction coefficient", result.load),
            *(() if result.strokes is None else _definition(result.strokes)),
        ),
        result.notes,
        () if result.strokes is None else (_definitions(result.strokes),),
    )


def _definition(strokes: StrokeFriction) -> Iterator[tuple[str, str | None]]:
    yield "definition used for the friction coefficient", strokes.used or "every sample, including the turning points"
    yield "offset of the friction coefficient", shown(strokes.offset)


def _definitions(strokes: StrokeFriction) -> TextTable:
    """Return a row for each definition of the friction coefficient."""
    rows = [
        (name, shown(value) or NOTHING, "yes" if name == strokes.used else "")
        for name, value in strokes.by_definition.items()
    ]
    columns = ("definition", "mean over strokes", "used")
    return TextTable("friction coefficient according to each definition", columns, tuple(rows))


def _specific_wear_section(result: SpecificWear, _: Steps) -> Section:
    load, bodies = result.normal_load, {spoken(name): body for name, body in result.bodies.items()}
    rows = [
        (name, measured_quantity(one.by), shown(one.depth) or NOTHING, shown(one.volume) or NOTHING)
        for name, body in bodies.items()
        for one in body.measured
    ]
    return Section(
        str(result.model_copy(update={"notes": ()})),
        facts(
            *(
                (f"wear rate of the {name}", shown(body.specific_wear_rate, SPECIFIC_WEAR_RATE))
                for name, body in bodies.items()
            ),
            *(
                (f"steady-state wear rate of the {name}", _steady(body))
                for name, body in bodies.items()
                if body.steady_rate is not None
            ),
            ("wear rate of both bodies", shown(result.total, SPECIFIC_WEAR_RATE)),
            *((f"wear volume of the {name}", _found_by(body.volume, body.volume_by)) for name, body in bodies.items()),
            *((f"wear depth of the {name}", _found_by(body.depth, body.depth_by)) for name, body in bodies.items()),
            ("sliding distance", shown(result.sliding_distance, "m")),
            ("normal load", None if load is None else f"{shown(load)}, {result.load}"),
        ),
        result.notes,
        (
            TextTable("wear from each measurement", ("body", "measured", "depth", "volume"), tuple(rows)),
            *_intervals(bodies),
        ),
    )


def _steady(body: BodyWearRate) -> str:
    return f"{shown(body.steady_rate, SPECIFIC_WEAR_RATE)}, from {shown(body.steady_from, 'm')} on"


def _intervals(bodies: Mapping[str, BodyWearRate]) -> Iterator[TextTable]:
    """Yield a table of the wear between consecutive measurements, if a test was interrupted."""
    rows = [
        (
            name,
            shown(one.start, "m"),
            shown(one.end, "m"),
            shown(one.volume),
            shown(one.specific_wear_rate, SPECIFIC_WEAR_RATE),
        )
        for name, body in bodies.items()
        for one in body.intervals
    ]
    if rows:
        head = ("body", "from", "to", "volume", "specific wear rate")
        yield TextTable(
            "wear between measurements", head, tuple(tuple(cell or NOTHING for cell in row) for row in rows)
        )


def _found_by(quantity: Quantity | None, by: str | None) -> str | None:
    return None if quantity is None or by is None else f"{shown(quantity)}, from the {measured_quantity(by)}"


_SECTIONS: Mapping[type[Record], Callable[[Any, Steps], Section]] = {
    CleanUp: _clean_up_section,
    DriftCorrection: _drift_correction_section,
    FrictionFit: _friction_section,
    SpecificWear: _specific_wear_section,
    WearFit: wear_fit_section,
    WearPrediction: prediction_section,
    LocalWearResult: local_wear_section,
}
"""Presentation of each kind of result."""


def run_page(archive: Archive, run_id: str) -> RunPage:
    """Return the content of an archived run except its curves.

    Raises ``ArchiveError`` if there is no such run, or its file is damaged.
    """
    run = archive.outline(run_id)
    manifest, last = run.manifest, run.marks[-1] if run.marks else None
    return RunPage(
        id=manifest.id,
        title=manifest.title or manifest.id,
        tribometer=None if manifest.contact is None else manifest.contact.kind,
        bad=last.reason if last is not None and last.kind == "bad" else None,
        tags=archive.tags(run_id),
        remarks=_remarks(archive, run_id, run),
        facts=tuple(group for group in _groups(run) if group.facts),
        findings=(*run.findings, *_fit_findings(run)),
        stages=stage_pages(run.steps, manifest.worded),
        sources=tuple(SourceEntry(n, one.name, one.size, one.sha256) for n, one in enumerate(run.sources)),
        raw_sha256=run.raw_sha256,
        studies=tuple(archive.studies_of(run_id)),
    )


def results_table(run: RunOutline) -> TextTable:
    """Return wear and k_D of a run, a row for each quantity, a column for each body; without wear, it has no rows."""

    def named(name: str) -> str:
        return run.manifest.worded(spoken(name))

    rows: list[tuple[str, dict[str, str | None]]] = [
        (label, {named(role): shown(size, "mm")}) for label, role, size in measured_widths(run.manifest)
    ]
    for result in (step.result for step in run.steps.values()):
        if isinstance(result, SpecificWear):
            worn = {named(name): body for name, body in result.bodies.items()}
            rows += [
                ("wear volume", {name: shown(body.volume) for name, body in worn.items()}),
                ("wear depth", {name: shown(body.depth) for name, body in worn.items()}),
                (
                    "specific wear rate",
                    {name: shown(body.specific_wear_rate, SPECIFIC_WEAR_RATE) for name, body in worn.items()},
                ),
            ]
        if isinstance(result, WearFit):
            fitted, law = {named(name): body for name, body in result.bodies.items()}, law_title(result.model)
            rows += [
                (f"k_D ({law})", {n: shown(body.wear_coefficient, WEAR_COEFFICIENT) for n, body in fitted.items()}),
                ("95 % CI", {name: interval(body.interval, WEAR_COEFFICIENT) for name, body in fitted.items()}),
            ]
    kept = [{"quantity": quantity, **values} for quantity, values in rows if any(values.values())]
    return TextTable.of_rows("results", kept, NOTHING)


def measured_widths(manifest: RunManifest) -> Iterator[tuple[str, str, Quantity]]:
    """Yield what was measured across scar and track, with its label and the role of its body."""
    ends, pin, (of_scar, of_track) = manifest.end_values, manifest.pin, manifest.contact_class.roles
    scar = ends.mean_pin_scar
    if pin is not None and scar is not None:
        yield "scar width" if pin.line else "scar diameter", of_scar, scar
    if ends.disc_track_width is not None:
        yield "track width", of_track, ends.disc_track_width


def _fit_findings(run: RunOutline) -> tuple[Finding, ...]:
    fits = (step.result for step in run.steps.values() if isinstance(step.result, DriftCorrection | WearFit))
    return first_of_each_code(finding for fit in fits for finding in fit.findings)


def _remarks(archive: Archive, run_id: str, run: RunOutline) -> tuple[Remark, ...]:
    marks = [Remark(mark.kind, mark.reason, mark.date, mark.operator) for mark in run.marks]
    said = [Remark(one.kind, one.text, one.date, one.operator) for one in archive.annotations(run_id)]
    amended = [Remark("amended", one.changes, one.date, None) for one in archive.earlier_manifests(run_id)]
    return tuple(sorted([*marks, *said, *amended], key=lambda remark: remark.date))


def _groups(run: RunOutline) -> Iterator[FactGroup]:
    manifest = run.manifest
    for name, body in manifest.bodies.items():
        yield FactGroup(spoken(name).capitalize(), record_facts(body))
    yield FactGroup("Conditions", (*record_facts(manifest.conditions), *_followed(manifest)))
    yield FactGroup("Instrument", _instrument(manifest))
    yield FactGroup("Recorded", _recorded(run))
    yield FactGroup("Signals", facts(*((spoken(name), origin) for name, origin in run.origins.items())))
    yield FactGroup("Post-test measurements", _measured(manifest, manifest.end_values))
    for stop in manifest.interruptions:
        yield FactGroup(f"Interruption after {manifest.progress.shown(stop.place)}", _measured(manifest, stop))
    yield FactGroup("Computed with", _computed_with(run))


def _measured(manifest: RunManifest, ends: EndValues) -> tuple[Fact, ...]:
    return tuple(Fact(manifest.worded(fact.name), fact.value) for fact in record_facts(ends))


def _followed(manifest: RunManifest) -> tuple[Fact, ...]:
    """Return speed and slip if they follow from other conditions."""
    conditions: Conditions = manifest.conditions
    speed = conditions.nominal_speed if conditions.sliding_speed is None else None
    slipped = manifest.slip if conditions.slip is None else None
    return facts(
        ("sliding speed (calculated)", shown(speed)),
        ("slip (calculated)", shown(slipped, "%")),
    )


def _instrument(manifest: RunManifest) -> tuple[Fact, ...]:
    return facts(
        ("tribometer", None if manifest.contact is None else manifest.contact.kind),
        ("instrument", manifest.instrument),
        ("operator", manifest.operator),
        ("started", None if manifest.started is None else moment(manifest.started)),
        ("scale of the depth sensor", shown(manifest.sensors.depth_scale)),
        ("comment", manifest.comment),
    )


def _recorded(run: RunOutline) -> tuple[Fact, ...]:
    ends = run.ends
    slid = "sliding distance" if run.manifest.contact is None else run.manifest.contact.slid
    return facts(
        ("samples", _samples(run)),
        ("duration", duration(Quantity(value=ends["time"], unit="s")) if "time" in ends else None),
        ("rotations", f"{ends['rotations']:,.0f}" if "rotations" in ends else None),
        (slid, show(ends["sliding_distance"], None, "m") if "sliding_distance" in ends else None),
        ("other columns", listed(run.extras)),
    )


def _samples(run: RunOutline) -> str:
    return f"{run.samples:,}" if run.recorded is None else f"{run.recorded:,}, evaluated as {run.samples:,} means"


def _computed_with(run: RunOutline) -> tuple[Fact, ...]:
    """Return versions and machine, only once if they are the same for all steps."""
    environments = {"ingest": run.environment} | {name: step.environment for name, step in run.steps.items()}
    steps: dict[str, list[str]] = {}
    for name, environment in environments.items():
        steps.setdefault(", ".join(map(" ".join, environment.items())), []).append(spoken(name))
    every = "all steps" if len(steps) == 1 else None
    return facts(*((every or ", ".join(names), told or None) for told, names in steps.items()))
