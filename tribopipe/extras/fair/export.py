"""Runs and studies packed with all that is known of them, as RO-Crate or as the .eln of lab notebooks."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from shutil import copyfile, rmtree
from tempfile import TemporaryDirectory
from typing import Literal, NamedTuple
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile

from tribopipe.archive.file_signature import SUFFIX
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, did_you_mean
from tribopipe.base.files import replacing
from tribopipe.base.process_lifecycle import undone_by
from tribopipe.documents.dataset import NOTHING_SAID, Dataset
from tribopipe.extras.fair.files import preview
from tribopipe.extras.fair.graph import ARCHIVE, METADATA, PREVIEW, Graph
from tribopipe.extras.fair.root import describe_root
from tribopipe.extras.fair.runs import Crating, Described

Form = Literal["folder", "zip", "eln"]


class Chosen(NamedTuple):
    """Runs and studies in a crate, by id."""

    runs: tuple[str, ...]
    studies: tuple[str, ...]


class Exported(NamedTuple):
    """Result of an export."""

    path: Path
    chosen: Chosen
    lacking: tuple[str, ...]
    """Metadata that repositories require but that are not stated."""


def choose(archive: Archive, ids: Sequence[str]) -> Chosen:
    """Return the runs and studies of an archive that are named, or all; a study brings its runs.

    Raises ``ArchiveError`` where an id is not known, or there is nothing.
    """
    runs, studies = archive.ids(), archive.study_ids()
    unknown = next((one for one in ids if one not in runs and one not in studies), None)
    if unknown is not None:
        raise ArchiveError(
            f"{archive.folder}: found neither a run nor a study {unknown!r}; expected the ID of an archived run or "
            f"study; {did_you_mean(unknown, [*runs, *studies])}"
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
        with _beside(path) as folder, _as_in(archive, folder):
            _fill(archive, chosen, folder, form, dataset, document, reports=reports, advance=advance)
            if form == "folder":
                path.unlink(missing_ok=True)
                folder.rename(path)
            else:
                with replacing(path) as part:
                    _pack(folder, part, f"{path.stem}/" if form == "eln" else "")
    except OSError as error:
        raise ArchiveError(
            f"{path}: cannot be written ({error.strerror or error}); expected a folder with free space and write "
            "permission; choose another folder"
        ) from None
    return Exported(path, chosen, tuple(dataset.lacking()))


@contextmanager
def _beside(path: Path) -> Iterator[Path]:
    """Give the name of a folder next to a path, which is taken away where it is still there in the end."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = TemporaryDirectory(prefix=f".{path.name}.", suffix=".part", dir=path.parent)
    with beside as part, undone_by(partial(rmtree, part, ignore_errors=True)):
        folder = Path(part) / "crate"
        folder.mkdir()
        yield folder


@contextmanager
def _as_in(archive: Archive, folder: Path) -> Iterator[None]:
    """Have errors name files of the archive where they would name those of its copy, which nobody will find."""
    try:
        yield
    except ArchiveError as error:
        raise ArchiveError(str(error).replace(str(folder / ARCHIVE), str(archive.folder))) from None


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
    """Make the crate in a folder. All its content is read from the copy of the archive that is in it."""
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
    described = [*runs.values(), *studies]
    describe_root(graph, described, dataset, document, one_author=form == "eln")
    page = preview(graph.write(), {one.folder["@id"]: one.text for one in described})
    (folder / PREVIEW).write_text(page, encoding="utf-8", newline="\n")


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


def _pack(folder: Path, path: Path, root: str) -> None:
    """Put a folder into a zip file, the metadata first; HDF5 is packed already."""
    names = sorted(one.relative_to(folder).as_posix() for one in folder.rglob("*"))
    with ZipFile(path, "w", strict_timestamps=False) as packed:
        for name in sorted(names, key=lambda name: name != METADATA):
            packed.write(folder / name, root + name, ZIP_STORED if name.endswith(SUFFIX) else ZIP_DEFLATED)
