"""One archived run on a page: what was tested and how, what was found, every step it has been through, its sources."""

from collections.abc import Iterator

from tribopipe.archive.outline import RunOutline
from tribopipe.archive.store import Archive
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import Conditions, EndValues, RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.slip import stated_slip
from tribopipe.results.evaluation import DriftCorrection
from tribopipe.results.finding import Finding, first_of_each_code
from tribopipe.results.wear_fit import WearFit
from tribopipe.views.labeled_values import duration, facts, listed, record_facts, shown
from tribopipe.views.page import Fact, FactGroup, Remark, RunPage, SourceEntry
from tribopipe.views.step_sections import stage_pages


def run_page(archive: Archive, run_id: str) -> RunPage:
    """Return what the archive holds of a run, but its curves.

    Raises ``ArchiveError`` where there is no such run, or its file is damaged.
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
    """Return speed and slip where other conditions show them."""
    conditions: Conditions = manifest.conditions
    speed = conditions.nominal_speed if conditions.sliding_speed is None else None
    slipped = stated_slip(manifest) if conditions.slip is None else None
    return facts(
        ("sliding speed, from these", shown(speed)),
        ("slip, from these", shown(slipped, "%")),
    )


def _instrument(manifest: RunManifest) -> tuple[Fact, ...]:
    return facts(
        ("tribometer", None if manifest.contact is None else manifest.contact.kind.replace("-", " ")),
        ("instrument", manifest.instrument),
        ("operator", manifest.operator),
        ("started", None if manifest.started is None else f"{manifest.started:%Y-%m-%d %H:%M %Z}".strip()),
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
        (slid, f"{ends['sliding_distance']:.4g} m" if "sliding_distance" in ends else None),
        ("other columns", listed(run.extras)),
    )


def _samples(run: RunOutline) -> str:
    return f"{run.samples:,}" if run.recorded is None else f"{run.recorded:,}, evaluated as {run.samples:,} means"


def _computed_with(run: RunOutline) -> tuple[Fact, ...]:
    """Return versions and machine: once, where they were the same for every step."""
    environments = {"ingest": run.environment} | {name: step.environment for name, step in run.steps.items()}
    steps: dict[str, list[str]] = {}
    for name, environment in environments.items():
        steps.setdefault(", ".join(map(" ".join, environment.items())), []).append(spoken(name))
    every = "every step" if len(steps) == 1 else None
    return facts(*((every or ", ".join(names), told or None) for told, names in steps.items()))
