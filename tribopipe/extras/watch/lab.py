"""Folders of a watch: exports, run folders and archive."""

from dataclasses import dataclass, field
from pathlib import Path

from tribopipe.base.errors import ReaderError
from tribopipe.base.executor import Crew
from tribopipe.documents.lab_template import read_template
from tribopipe.documents.manifest import MANIFEST_NAME
from tribopipe.documents.recipe import Recipe
from tribopipe.extras.watch.drops import stamp_of
from tribopipe.extras.watch.journal import Entry


@dataclass(frozen=True)
class Lab:
    """Folders, each as it is without links, and how runs are made and processed."""

    folder: Path
    """Folder to which instruments write; tribopipe never writes to it."""
    runs: Path
    """Folder of the new run folders."""
    archive: Path
    recipe: Recipe
    template: Path | None = None
    together: bool = False
    """True if the files in a subfolder of the watched folder are one test."""
    settle: float = 10.0
    """Time without changes after which an export is complete, s."""
    figures: bool = True
    crew: Crew = field(default_factory=Crew)

    def refuse_what_cannot_be(self) -> None:
        """Raise ``TribopipeError`` where there is no folder to watch, or the template cannot be taken."""
        if not self.folder.is_dir():
            raise ReaderError(
                f"{self.folder}: found no folder at this path; expected the export folder of the instrument; connect "
                "its drive or network share, or choose another folder"
            )
        if self.folder.is_relative_to(self.runs) or self.folder.is_relative_to(self.archive):
            raise ReaderError(
                f"{self.folder}: found a folder within the folder of runs or the archive; expected a folder into "
                "which only instruments write; specify other folders with --runs and --archive"
            )
        if self.template is not None:
            read_template(self.template)

    def run(self, entry: Entry) -> Path:
        """Return the folder of a run, created or dropped."""
        return self.folder / entry.name if entry.run is None else self.runs / entry.run

    def manifest(self, entry: Entry) -> Path:
        """Return the run.toml of a run, which need not be there."""
        return self.run(entry) / MANIFEST_NAME

    def failed(self, entry: Entry) -> Entry:
        """Return the entry of a run that waits for its run.toml to change."""
        return self.seen(entry).model_copy(update={"state": "failed"})

    def seen(self, entry: Entry) -> Entry:
        """Return the entry of a run with what its run.toml looks like now."""
        try:
            stamp = stamp_of([self.manifest(entry)])
        except OSError:
            stamp = ""
        return entry.model_copy(update={"run_stamp": stamp})
