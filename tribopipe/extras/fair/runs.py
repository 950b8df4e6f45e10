"""A run and a study as entities of a crate: what was tested on what, what came out, and the files with it.

`told` gives the numbers and texts of records by name: what a crate shows of a run without its files being opened.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import Markup

from tribopipe.archive.formats import RUN_FORMAT, STUDY_FORMAT, Format
from tribopipe.archive.outline import RunOutline
from tribopipe.archive.store import Archive
from tribopipe.documents.annotation import Annotation
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.dataset import Dataset
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record
from tribopipe.documents.study import Study
from tribopipe.extras.fair import provenance
from tribopipe.extras.fair.files import CSV, Part, run_parts, run_text, study_parts, study_text
from tribopipe.extras.fair.graph import Graph, Ref, local
from tribopipe.extras.fair.provenance import Placed, amendments, archive_action, step_action, study_action, test_action
from tribopipe.extras.fair.vocabulary import UNITS, meaning, term, term_of


class Told(NamedTuple):
    """One number or text of a record."""

    key: str
    """Key in the document or the archive, with dots: "conditions.normal_load"."""
    value: float | str
    unit: str | None = None
    """SI unit; none of a text."""
    standard_uncertainty: float | None = None
    """Standard uncertainty in ``unit``."""
    interval: tuple[float, float] | None = None
    """Coverage interval, in ``unit``."""
    meaning: str = ""


def told(record: Record, prefix: str) -> Iterator[Told]:
    """Give the quantities of a record and of the records in it, and its texts and numbers."""
    for name, field in type(record).model_fields.items():
        one = _told(f"{prefix}.{name}", getattr(record, name), (field.description or "").partition("\n\n")[0])
        beside = getattr(record, "interval", None) if name == "wear_coefficient" else None
        for found in one:
            yield found if beside is None else found._replace(interval=(beside[0].value, beside[1].value))


def _told(key: str, value: Any, meaning: str) -> Iterator[Told]:
    if isinstance(value, Quantity):
        yield Told(key, value.value, value.unit, value.standard_uncertainty, meaning=meaning)
    elif isinstance(value, Record):
        yield from told(value, key)
    elif isinstance(value, Mapping):
        for name, one in value.items():
            yield from _told(f"{key}.{name}", one, meaning)
    elif isinstance(value, str):
        yield Told(key, value, meaning=meaning)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield Told(key, float(value), "1", meaning=meaning)


HDF5 = "application/x-hdf5"
_RFC4180 = "https://www.rfc-editor.org/rfc/rfc4180"


@dataclass(frozen=True)
class Described:
    """A run or a study in a crate."""

    id: str
    folder: Ref
    actions: tuple[Ref, ...]
    text: Markup
    """Content shown in an electronic lab notebook."""
    keywords: tuple[str, ...] = ()
    study: bool = False


@dataclass(frozen=True)
class Crating:
    """Graph of a crate, and the archive that it is made from."""

    graph: Graph
    archive: Archive
    """The archive within the crate."""
    dataset: Dataset
    reports: bool
    """True if a report of each run and study is included."""

    def run(self, run_id: str) -> Described:
        """Put a run into the crate."""
        run, graph = self.archive.outline(run_id), self.graph
        manifest = run.manifest
        made = _placed(graph, f"runs/{run_id}", run_parts(self.archive, run_id))
        archived = _archived(graph, self.archive.path(run_id), RUN_FORMAT, f"the complete run {run_id}")
        who = provenance.operator(graph, self.dataset, manifest.operator)
        instrument, bodies = self._instrument(manifest), list(_bodies(graph, manifest))
        actions = [test_action(graph, run, who, instrument, bodies, made), archive_action(graph, run, archived, made)]
        actions += amendments(graph, run_id, self.archive.earlier_manifests(run_id), made)
        actions += [step_action(graph, run, name, step, made) for name, step in run.steps.items()]
        tested = _sentence(run)
        text = run_text(self.archive, run_id, tested)
        notes = [one for one in self.archive.annotations(run_id) if one.kind == "note"]
        keywords = (*_materials(manifest), manifest.contact.kind if manifest.contact else "friction")
        folder = graph.folder_of(
            f"runs/{run_id}",
            [archived, *(ref for _, ref in made.values()), *self._report(f"runs/{run_id}", run_id)],
            name=_name(run_id, manifest.title),
            identifier=run_id,
            description=tested,
            text=str(text),
            genre="experiment",
            author=who or provenance.author(graph, self.dataset),
            dateCreated=None if manifest.started is None else manifest.started.isoformat(),
            dateModified=max((step.date for step in run.steps.values()), default=None),
            keywords=", ".join(keywords),
            license=provenance.licence(graph, self.dataset),
            comment=[_comment(graph, run_id, note) for note in notes],
            variableMeasured=[_property(graph, run_id, one) for one in _numbers(run)],
        )
        return Described(run_id, folder, tuple(actions), text, keywords)

    def study(self, study_id: str, runs: Mapping[str, Described]) -> Described:
        """Put a study into the crate; ``runs`` are those that are in it already."""
        stored, graph = self.archive.study_outline(study_id), self.graph
        made = _placed(graph, f"studies/{study_id}", study_parts(self.archive, study_id))
        path = self.archive.study_folder / f"{study_id}.h5"
        archived = _archived(graph, path, STUDY_FORMAT, f"the complete study {study_id}")
        members = [runs[one].folder for one in (*stored.study.fit, *stored.study.predict) if one in runs]
        found = [archived, *(ref for _, ref in made.values())]
        text = study_text(self.archive, study_id)
        action = study_action(graph, study_id, stored.program_version, stored.date, members, found)
        folder = graph.folder_of(
            f"studies/{study_id}",
            [*found, *self._report(f"studies/{study_id}", study_id, study=True)],
            name=_name(study_id, stored.study.title),
            identifier=study_id,
            description=_of_study(stored.study),
            text=str(text),
            genre="evaluation",
            author=provenance.author(graph, self.dataset),
            dateCreated=stored.date,
            license=provenance.licence(graph, self.dataset),
            mentions=members,
        )
        return Described(study_id, folder, (action,), text, study=True)

    def _instrument(self, manifest: RunManifest) -> Ref:
        """Describe the tribometer."""
        name = manifest.instrument or "tribometer"
        said = self.dataset.apparatus(manifest.instrument)
        kinds = [term("tribometer"), term_of(manifest.contact.tribodatafair if manifest.contact else None)]
        return self.graph.thing(
            (said and said.identifier) or local("instrument", name),
            "IndividualProduct",
            name=name,
            additionalType=[kind for kind in kinds if kind],
            manufacturer=said and said.manufacturer,
            model=said and said.model,
            serialNumber=said and said.serial_number,
        )

    def _report(self, folder: str, one: str, *, study: bool = False) -> Iterator[Ref]:
        if not self.reports:
            return
        from tribopipe.views.html.document import run_report, study_report

        page = study_report(self.archive, one) if study else run_report(self.archive, [one])
        meaning = "figures, tables, methods and provenance on one page"
        yield self.graph.file(
            f"{folder}/report.html", [page.encode("utf-8")], description=meaning, encodingFormat="text/html"
        )


def _placed(graph: Graph, folder: str, parts: Iterable[Part]) -> Placed:
    """Write files into the folder of a run or a study; return them by their path in it."""
    return {part.path: (part, _file(graph, folder, part)) for part in parts}


def _file(graph: Graph, folder: str, part: Part) -> Ref:
    follows = {"@id": _RFC4180} if part.media_type == CSV and part.columns else None
    if part.schema is not None:
        follows = {"@id": f"about/schemas/{part.schema}.schema.json"}
    return graph.file(
        f"{folder}/{part.path}",
        part.content,
        description=part.meaning,
        encodingFormat=part.media_type,
        conformsTo=follows,
        variableMeasured=[_column(graph, head) for head in part.columns],
    )


def _archived(graph: Graph, path: Path, form: Format, meaning: str) -> Ref:
    """Describe a file of the archive, which is in the crate already."""
    follows = graph.thing(
        local("format", str(form)),
        "CreativeWork",
        name=str(form),
        description="NeXus HDF5 as archived by tribopipe, with the SHA-256 checksum of its content.",
    )
    return graph.standing(path, description=meaning, encodingFormat=HDF5, conformsTo=follows)


def _column(graph: Graph, head: str) -> Ref:
    """Describe a column of tables by its head, "depth [m]"; it is one entity in all of them."""
    name, _, unit = head.removesuffix("]").partition(" [")
    known = UNITS.get(unit)
    return graph.thing(
        local("column", name, unit),
        "PropertyValue",
        name=name,
        propertyID=name,
        description=meaning(name),
        identifier=term(name),
        unitText=unit,
        unitCode=known and known.iri,
    )


def _bodies(graph: Graph, manifest: RunManifest) -> Iterator[Ref]:
    """Describe the two specimens: material and what is known of each."""
    for name, body in manifest.bodies.items():
        properties = [_property(graph, manifest.id, one, one.key.removeprefix(f"{name}.")) for one in told(body, name)]
        yield graph.thing(
            local(manifest.id, name),
            "IndividualProduct",
            name=f"{body.material} {spoken(name)}",
            material=body.material,
            additionalProperty=properties,
        )


def _numbers(run: RunOutline) -> Iterator[Told]:
    """Give conditions, post-test measurements and results of a run."""
    yield from told(run.manifest.conditions, "conditions")
    yield from told(run.manifest.end_values, "end_values")
    for name, step in run.steps.items():
        yield from told(step.result, name)


def _property(graph: Graph, run_id: str, one: Told, meant: str | None = None) -> Ref:
    """Describe one number or text of a run; a standard uncertainty is a value next to it.

    ``meant`` is what it is called in vocabularies where that is not its key.
    """
    unit = UNITS.get(one.unit or "")
    spread = None
    if one.standard_uncertainty is not None:
        spread = graph.thing(
            local(run_id, one.key, "standard_uncertainty"),
            "PropertyValue",
            name=f"{one.key}, standard uncertainty",
            propertyID=f"{one.key}.standard_uncertainty",
            value=one.standard_uncertainty,
            unitText=one.unit,
            unitCode=unit and unit.iri,
        )
    low, high = one.interval or (None, None)
    return graph.thing(
        local(run_id, one.key),
        "PropertyValue",
        name=spoken(one.key).replace(".", ", "),
        propertyID=one.key,
        description=one.meaning,
        identifier=term(meant or one.key),
        value=one.value,
        unitText=one.unit,
        unitCode=unit and unit.iri,
        minValue=low,
        maxValue=high,
        valueReference=spread,
    )


def _comment(graph: Graph, run_id: str, note: Annotation) -> Ref:
    """Describe a note that somebody wrote to a run; notebooks ask for a name."""
    who = note.operator or "unknown"
    return graph.thing(
        local(run_id, "note", note.date, note.text[:40]),
        "Comment",
        text=note.text,
        dateCreated=note.date,
        author=graph.thing(local("person", who), "Person", name=who),
    )


def _name(identifier: str, title: str | None) -> str:
    """Name a run or a study so that it is distinguished from others of the same title."""
    return f"{identifier}: {title}" if title else identifier


def _materials(manifest: RunManifest) -> tuple[str, ...]:
    return tuple(dict.fromkeys(body.material for body in manifest.bodies.values()))


def _sentence(run: RunOutline) -> str:
    """State in a line what was tested."""
    manifest = run.manifest
    pair = " on ".join(body.material for body in manifest.bodies.values()) or "unknown bodies"
    kind = manifest.contact.kind if manifest.contact else "friction"
    load = manifest.conditions.normal_load
    medium = f" in {manifest.conditions.medium}" if manifest.conditions.medium else ""
    return f"{kind} test, {pair}, {load.shown('mN' if load.value < 1 else 'N')}{medium}, {run.samples:,} samples."


def _of_study(study: Study) -> str:
    return f"Fitted: {', '.join(study.fit)}; predicted: {', '.join(study.predict) or 'none'}."
