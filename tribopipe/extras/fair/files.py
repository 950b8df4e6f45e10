"""The files of a crate for those without HDF5: parts of the archive as CSV and JSON, and pages for people.

Run and study as a notebook shows them, and ro-crate-preview.html.
"""

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from mimetypes import guess_type
from pathlib import PurePosixPath
from typing import Any
from urllib.parse import unquote

import numpy as np
import orjson
from markupsafe import Markup

from tribopipe.archive.earlier_manifests import EarlierManifest
from tribopipe.archive.step_names import LOCAL_WEAR, PREDICTIONS, WEAR_FITS, Step, StepName, Table
from tribopipe.archive.store import Archive
from tribopipe.documents.record import Record
from tribopipe.physics.laws import law_title
from tribopipe.results.json_schema import SCHEMAS
from tribopipe.results.run import RawRun
from tribopipe.views.csv_files import CSV_KINDS, csv_kinds, csv_lines, csv_parts
from tribopipe.views.html.rendering import rendered
from tribopipe.views.run_page import run_page, step_title
from tribopipe.views.study_page import study_page

CSV = "text/csv"
JSON = "application/json"
_ROWS = 65_536
_TOML = "application/toml"


@dataclass(frozen=True)
class Part:
    """One file of a crate, with what is stated about every file."""

    path: str
    """Path in the folder of its run or study."""
    content: Iterable[bytes]
    meaning: str
    media_type: str
    columns: tuple[str, ...] = ()
    """Heads of a table, "depth [m]"."""
    schema: str | None = None
    """Name of the JSON Schema that it follows."""
    made_by: StepName | None = None
    """The step that found it; none of what was ingested, and of what is made of the whole run."""


def run_parts(archive: Archive, run_id: str) -> Iterator[Part]:
    """Give what an archived run holds, but for its HDF5 file and its report."""
    outline, raw = archive.outline(run_id), archive.raw(run_id)
    yield _record("run.json", outline.manifest, "content of run.toml, numbers in SI")
    for source in raw.sources:
        yield Part(f"source/{source.name}", source.pieces(), "original file", media_type(source.name))
    earlier = archive.earlier_manifests(run_id)
    for one in earlier:
        yield Part(earlier_path(one), one.source.pieces(), f"run.toml before the change of {one.date}", _TOML)
    for kind in csv_kinds(archive, run_id):
        yield _table(f"tables/{kind}.csv", csv_parts(archive, run_id, kind), CSV_KINDS[kind], _MADE_BY.get(kind))
    yield from _profiles(raw)
    for name, step in outline.steps.items():
        yield _record(f"results/{name}.json", step.result, f"result: {step_title(name)}", name)
        yield from _fields(archive, run_id, name)
    history = {
        "findings": outline.findings,
        "marks": outline.marks,
        "annotations": archive.annotations(run_id),
        "amended": [
            {"date": one.date, "changes": one.changes, "earlier": earlier_path(one), "raw_sha256": one.raw_sha256}
            for one in earlier
        ],
        "archived_with": outline.environment,
        "raw_sha256": outline.raw_sha256,
        "steps": {
            name: {
                "version": step.program_version,
                "date": step.date,
                "options": step.options,
                "environment": step.environment,
                "inputs_sha256": step.inputs_sha256,
                "result_sha256": step.result_sha256,
            }
            for name, step in outline.steps.items()
        },
    }
    yield Part("history.json", [_json(history)], "findings, annotations, steps and the programs used", JSON)


def earlier_path(one: EarlierManifest) -> str:
    """Return where a run.toml that was amended lies in the folder of its run."""
    return f"earlier/{one.source.name}"


def study_parts(archive: Archive, study_id: str) -> Iterator[Part]:
    """Give what an archived study holds, but for its HDF5 file and its report."""
    stored = archive.study(study_id)
    yield _record("study.json", stored.study, "content of study.toml, numbers in SI")
    yield _record("results/study.json", stored.result, "k_D of the study, and the agreement of each run with it")
    for number, curve in enumerate(stored.curves):
        columns = {name: values for name, values in vars(curve).items() if isinstance(values, np.ndarray)}
        unit = {"rotations": "1"} if "rotations" in columns else {}
        other = "m^3" if "rotations" in columns else "m"
        heads = [f"{name} [{unit.get(name, other)}]" for name in columns]
        meaning = f"{curve.run_id}: measured wear with {law_title(curve.model)}, {curve.role}"
        yield Part(f"tables/curve-{number:03}.csv", _rows(heads, list(columns.values())), meaning, CSV, tuple(heads))
    history = {
        "version": stored.program_version,
        "date": stored.date,
        "options": stored.options,
        "environment": stored.environment,
        "inputs_sha256": stored.inputs_sha256,
        "stands_on": stored.stands_on,
    }
    yield Part("history.json", [_json(history)], "inputs of the study, and the software that evaluated it", JSON)


_MADE_BY: Mapping[str, StepName] = {
    "cleaned": "clean_up",
    "corrected": "drift_correction",
    "friction": "friction_fit",
    **{f"fit-{law}": step for law, step in WEAR_FITS.items()},
    **{f"prediction-{law}": step for law, step in PREDICTIONS.items()},
    **{f"local-wear-{law}": step for law, step in LOCAL_WEAR.items()},
}
"""Tables that a step found; the others are as ingested, or made of several steps."""


def _record(path: str, record: Record, meaning: str, made_by: StepName | None = None) -> Part:
    """Return a record as JSON, every number in SI with its unit, and the schema that describes each of its keys."""
    schema = next(name for name, kind in SCHEMAS.items() if kind is type(record))
    content = orjson.dumps(record.model_dump(mode="json", by_alias=True), option=orjson.OPT_INDENT_2)
    return Part(path, [content, b"\n"], meaning, JSON, schema=schema, made_by=made_by)


def _json(document: object) -> bytes:
    def plainly(value: object) -> object:
        if isinstance(value, Record):
            return value.model_dump(mode="json", by_alias=True)
        raise TypeError(type(value).__name__)

    return orjson.dumps(document, default=plainly, option=orjson.OPT_INDENT_2) + b"\n"


def media_type(name: str) -> str:
    """Return the media type of a file by its name."""
    if PurePosixPath(name).suffix == ".toml":
        return _TOML
    return guess_type(name, strict=False)[0] or "application/octet-stream"


def _table(path: str, parts: Iterator[bytes], meaning: str, made_by: StepName | None) -> Part:
    """Return a table; its first part is the header."""
    first = next(parts)
    heads = next(csv.reader([first.decode("utf-8")]))
    return Part(path, chain([first], parts), meaning, CSV, tuple(heads), made_by=made_by)


def _profiles(run: RawRun) -> Iterator[Part]:
    for number, (name, profile) in enumerate(run.profiles.items()):
        heads = ["position [m]", "height [m]"]
        content = _rows(heads, [profile.position, profile.height])
        meaning = f"{name}: a profile across the worn surface"
        if profile.across is not None:
            meaning = f"{name}: the scan line at {profile.across:.9g} m across the height map {profile.scan}"
        yield Part(f"tables/profile-{number}.csv", content, meaning, CSV, tuple(heads))


def _fields(archive: Archive, run_id: str, name: StepName) -> Iterator[Part]:
    """Give what a step found over several axes, a row for each point."""
    if LOCAL_WEAR.law_of(name) is None:
        return
    step = archive.step(run_id, name)
    for title, table in step.tables.items() if isinstance(step, Step) else ():
        if title != "course":
            heads = [f"{column} [{unit}]" for column, (_, unit) in chain(table.axes.items(), table.arrays.items())]
            meaning = f"{step_title(name)}: {title.replace('_', ' ')}"
            path = f"tables/{name.replace('_', '-')}-{title.replace('_', '-')}.csv"
            yield Part(path, _rows(heads, _flat(table)), meaning, CSV, tuple(heads), made_by=name)


def _flat(table: Table) -> list[np.ndarray]:
    axes = np.meshgrid(*(values for values, _ in table.axes.values()), indexing="ij")
    return [values.ravel() for values in (*axes, *(values for values, _ in table.arrays.values()))]


def _rows(heads: Sequence[str], columns: Sequence[np.ndarray]) -> Iterator[bytes]:
    yield csv_lines([heads])
    for start in range(0, len(columns[0]), _ROWS):
        yield csv_lines(zip(*(values[start : start + _ROWS] for values in columns), strict=True))


_PREVIEW_ROWS = (
    ("Creators", "creator"),
    ("Publisher", "publisher"),
    ("Published", "datePublished"),
    ("Version", "version"),
    ("DOI", "identifier"),
    ("License", "license"),
    ("Funding", "funding"),
    ("Belongs to", "citation"),
    ("Keywords", "keywords"),
)
"""Properties of the crate that the preview shows."""
_Entity = Mapping[str, Any]


def run_text(archive: Archive, run_id: str, tested: str) -> Markup:
    """Return what a notebook shows of a run; ``tested`` states in a sentence what was tested."""
    return Markup(rendered("run_record.html", tested=tested, internal=True, run={"page": run_page(archive, run_id)}))  # noqa: S704


def study_text(archive: Archive, study_id: str) -> Markup:
    """Return what a notebook shows of a study."""
    return Markup(rendered("study_record.html", study=study_page(archive, study_id)))  # noqa: S704


def preview(metadata: bytes, texts: Mapping[str, Markup]) -> str:
    """Return the page that RO-Crate recommends, with a copy of the metadata in it, as RO-Crate 1.1 demands.

    ``texts`` are those of runs and studies, by their folder in the crate.
    """
    document = orjson.loads(metadata)
    graph = {entity["@id"]: entity for entity in document["@graph"]}

    def of(entity: _Entity, name: str) -> Sequence[Any]:
        """Yield the values of a property of an entity: texts, and the entities that it refers to."""
        said = entity.get(name, [])
        return [
            graph[one["@id"]] if isinstance(one, dict) else one for one in (said if isinstance(said, list) else [said])
        ]

    root = graph["./"]
    return rendered(
        "crate.html",
        title=root["name"],
        root=root,
        citation=_citation(root, of(root, "creator"), of(root, "publisher")),
        rows=_PREVIEW_ROWS,
        records=[(graph[folder], text) for folder, text in texts.items()],
        about=graph["about/"],
        metadata=_inert(document),
        of=of,
        decoded=unquote,
    )


def _citation(root: _Entity, creators: Sequence[_Entity], publishers: Sequence[_Entity]) -> str:
    """Return how DataCite would have the data cited: creators (year): title. Version. Publisher. DOI."""
    names = "; ".join(", ".join(filter(None, (one["familyName"], one.get("givenName")))) for one in creators)
    parts = [f"{names or 'Unknown'} ({root['datePublished'][:4]}): {root['name']}"]
    parts += [f"Version {root['version']}"] if "version" in root else []
    parts += [one["name"] for one in publishers]
    parts += [root["identifier"]] if "identifier" in root else []
    return ". ".join(parts)


def _inert(document: object) -> Markup:
    """Write JSON so that nothing in it ends the script element that it stands in."""
    return Markup(orjson.dumps(document).decode("utf-8").replace("<", "\\u003c"))  # noqa: S704
