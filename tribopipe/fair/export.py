"""Runs and studies packed with all that is known of them, as RO-Crate or as the .eln of lab notebooks."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from shutil import copyfile, rmtree
from tempfile import TemporaryDirectory
from typing import Literal, NamedTuple
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile

import orjson

from tribopipe.archive.store import SUFFIX, Archive
from tribopipe.errors import ArchiveError, did_you_mean
from tribopipe.fair import people
from tribopipe.fair.codebook import codebook
from tribopipe.fair.datacite import datacite
from tribopipe.fair.graph import Graph, Ref, local
from tribopipe.fair.parts import CSV, JSON
from tribopipe.fair.provenance import PROFILE, software
from tribopipe.fair.runs import ARCHIVE, Crating, Described
from tribopipe.files import replacing
from tribopipe.interrupts import undone_by
from tribopipe.records.dataset import NOTHING_SAID, Dataset
from tribopipe.records.export import schema_text
from tribopipe.version import VERSION

Form = Literal["folder", "zip", "eln"]
METADATA = "ro-crate-metadata.json"
DATASET = "about/dataset.toml"
_SCHEMA = re.compile(r"about/schemas/(.+)\.schema\.json")
_KEYWORDS = ("tribology", "wear", "friction", "tribometer")


class Chosen(NamedTuple):
    """What goes into a crate, by id."""

    runs: tuple[str, ...]
    studies: tuple[str, ...]


class Exported(NamedTuple):
    """What was written."""

    path: Path
    chosen: Chosen
    lacking: tuple[str, ...]
    """What repositories ask for and nobody said."""


def choose(archive: Archive, ids: Sequence[str]) -> Chosen:
    """Return the runs and studies of an archive that are named, or all; a study brings its runs.

    Raises ``ArchiveError`` where an id is not known, or there is nothing.
    """
    runs, studies = archive.ids(), archive.study_ids()
    unknown = next((one for one in ids if one not in runs and one not in studies), None)
    if unknown is not None:
        raise ArchiveError(
            f"{archive.folder}: found neither a run nor a study {unknown!r}; expected one of the archive's; "
            f"{did_you_mean(unknown, [*runs, *studies])}"
        )
    taken = [one for one in studies if not ids or one in ids]
    wanted = set(ids or runs)
    for study in (archive.study_outline(one).study for one in taken):
        wanted |= {*study.fit, *study.predict}
    if not wanted & set(runs):
        raise ArchiveError(f"{archive.folder}: found no runs; expected at least one; run `tribopipe ingest` first")
    return Chosen(tuple(one for one in runs if one in wanted), tuple(taken))


def form_of(path: Path, *, eln: bool) -> Form:
    """Return what is written by the name of a file; a crate without the suffix .zip is a folder."""
    if eln:
        return "eln"
    return "zip" if path.suffix.lower() == ".zip" else "folder"


def export_crate(
    archive: Archive,
    chosen: Chosen,
    path: Path,
    *,
    eln: bool = False,
    dataset: Dataset = NOTHING_SAID,
    document: bytes | None = None,
    reports: bool = True,
    advance: Callable[[str], None] = lambda _: None,
) -> Exported:
    """Write a crate whole or not at all; a file of its name is replaced, a folder is not.

    ``document`` is the dataset.toml that ``dataset`` was read from, which goes into it; ``advance`` is called with each
    run and study that is in. Raises ``ArchiveError`` where something of the archive is damaged, or ``path`` cannot be
    written.
    """
    form = form_of(path, eln=eln)
    try:
        with _beside(path) as folder:
            _fill(archive, chosen, folder, form, dataset, document, reports=reports, advance=advance)
            if form == "folder":
                folder.rename(path)
            else:
                with replacing(path) as part:
                    _pack(folder, part, f"{path.stem}/" if form == "eln" else "")
    except OSError as error:
        raise ArchiveError(
            f"{path}: cannot be written ({error.strerror or error}); expected a place with room and write permission; "
            "name another"
        ) from None
    return Exported(path, chosen, tuple(dataset.lacking()))


@contextmanager
def _beside(path: Path) -> Iterator[Path]:
    """Give the name of a folder beside a path, which is taken away where it is still there in the end."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = TemporaryDirectory(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    with beside as part, undone_by(partial(rmtree, part, ignore_errors=True)):
        folder = Path(part) / "crate"
        folder.mkdir()
        yield folder


def _fill(
    archive: Archive,
    chosen: Chosen,
    folder: Path,
    form: Form,
    dataset: Dataset,
    document: bytes | None,
    *,
    reports: bool,
    advance: Callable[[str], None],
) -> None:
    """Make the crate in a folder. All that it says is read from the copy of the archive that is in it."""
    graph = Graph(folder)
    crating = Crating(graph, _copied(archive, chosen, folder / ARCHIVE), dataset, reports)
    runs: dict[str, Described] = {}
    for run_id in chosen.runs:
        runs[run_id] = crating.run(run_id)
        advance(run_id)
    studies = []
    for study_id in chosen.studies:
        studies.append(crating.study(study_id, runs))
        advance(study_id)
    _describe(graph, [*runs.values(), *studies], chosen, dataset, document, eln=form == "eln")
    graph.write()


def _copied(archive: Archive, chosen: Chosen, folder: Path) -> Archive:
    """Copy what was chosen byte for byte into an archive of its own."""
    copy = Archive(folder)
    pairs = [(archive.path(one), copy.path(one)) for one in chosen.runs]
    names = (f"{one}{SUFFIX}" for one in chosen.studies)
    pairs += [(archive.study_folder / name, copy.study_folder / name) for name in names]
    for old, new in pairs:
        new.parent.mkdir(parents=True, exist_ok=True)
        copyfile(old, new)
    return copy


def _describe(
    graph: Graph,
    described: Sequence[Described],
    chosen: Chosen,
    dataset: Dataset,
    document: bytes | None,
    *,
    eln: bool,
) -> None:
    """Say what the crate is as a whole, and who made it."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    published = dataset.published.isoformat() if dataset.published else now[:10]
    title, description = dataset.title or _title(chosen), dataset.description or _description(chosen)
    keywords = list(
        dict.fromkeys([*dataset.keywords, *_KEYWORDS, *(word for one in described for word in one.keywords)])
    )
    fields = datacite(dataset, title=title, description=description, keywords=keywords, published=published)
    about = _about(graph, orjson.dumps(fields, option=orjson.OPT_INDENT_2) + b"\n", document)
    creators = [people.person(graph, one) for one in dataset.creators]
    publisher = people.organisation(graph, dataset.publisher) if dataset.publisher else None
    profile = graph.thing(PROFILE, "CreativeWork", name="Process Run Crate", version=PROFILE.rpartition("/")[2])
    made = graph.thing(
        "#export",
        "CreateAction",
        name="Export of the data set",
        description=f"tribopipe {VERSION}",
        instrument=software(graph, VERSION),
        result={"@id": "./"},
        endTime=now,
    )
    graph.describe(
        name=title,
        description=description,
        datePublished=published,
        license=people.licence(graph, dataset),
        creator=creators,
        author=creators[0] if creators and (eln or len(creators) == 1) else creators,
        publisher=publisher,
        keywords=", ".join(keywords),
        version=dataset.version,
        identifier=f"https://doi.org/{dataset.doi}" if dataset.doi else None,
        inLanguage=dataset.language,
        funder=[people.organisation(graph, one.funder) for one in dataset.funding],
        funding=[people.grant(graph, one) for one in dataset.funding],
        citation=[people.publication(graph, one) for one in dataset.publications],
        conformsTo=profile,
        hasPart=[*(one.folder for one in described), about],
        mentions=[*(action for one in described for action in one.actions), made],
    )
    graph.describe_metadata(
        version="1.0",
        dateCreated=now,
        sdPublisher=graph.thing(local("publisher", "tribopipe"), "Organization", name="tribopipe"),
    )


def _about(graph: Graph, fields: bytes, document: bytes | None) -> Ref:
    """Put in what describes the crate: the codebook, the schemas of its JSON files, DataCite's fields, dataset.toml."""
    parts = [_schema(graph, name) for name in sorted(graph.followed(_SCHEMA))]
    parts.append(
        graph.file(
            "about/codebook.csv",
            codebook(graph.things("PropertyValue")),
            description="every column and key: unit, meaning, identifiers",
            encodingFormat=CSV,
        )
    )
    parts.append(graph.file("about/datacite.json", [fields], description="fields of DataCite", encodingFormat=JSON))
    if document is not None:
        parts.append(
            graph.file(DATASET, [document], description="what the lab says of it", encodingFormat="application/toml")
        )
    meaning = "What the files mean: codebook, schemas, and what repositories ask for."
    return graph.folder_of("about", parts, name="About this data set", description=meaning)


def _schema(graph: Graph, name: str) -> Ref:
    return graph.file(
        f"about/schemas/{name}.schema.json",
        [schema_text(name).encode("utf-8")],
        description=f"JSON Schema of {name}",
        encodingFormat="application/schema+json",
    )


def _title(chosen: Chosen) -> str:
    named = chosen.studies or chosen.runs
    return f"Tribometer runs: {', '.join(named[:3])}{' and others' if len(named) > 3 else ''}"


def _description(chosen: Chosen) -> str:
    runs, studies = len(chosen.runs), len(chosen.studies)
    beside = f" and {studies} {'study' if studies == 1 else 'studies'}" if studies else ""
    return f"{runs} tribometer {'run' if runs == 1 else 'runs'}{beside}, as recorded and as evaluated by tribopipe."


def _pack(folder: Path, path: Path, root: str) -> None:
    """Put a folder into a zip file, the metadata first; HDF5 is packed already."""
    names = sorted(one.relative_to(folder).as_posix() for one in folder.rglob("*"))
    with ZipFile(path, "w", strict_timestamps=False) as packed:
        for name in sorted(names, key=lambda name: name != METADATA):
            packed.write(folder / name, root + name, ZIP_STORED if name.endswith(SUFFIX) else ZIP_DEFLATED)
