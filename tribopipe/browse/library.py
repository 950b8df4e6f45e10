"""The archive as the server looks at it: its list, its files, and what was read of them lately."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.query import Asked
from tribopipe.archive.file_signature import STUDIES, SUFFIX
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.browse.answers import archive_answer, runs_answer, study_line
from tribopipe.browse.file_cache import Kept, RunFile, StudyFile
from tribopipe.browse.guard import inside
from tribopipe.browse.responses import encoded
from tribopipe.views.page import StudyPage
from tribopipe.views.study_page import study_page

FIRST_ROWS = 500
"""Runs that the table asks for first, as ui/src/table/parts.ts has it."""


class Library:
    """One archive folder; any thread may ask."""

    def __init__(self, folder: Path) -> None:
        self.archive = Archive(folder)
        self.catalogue = Catalogue(folder)
        self._kept = Kept()
        self._seen = ""
        self._lock = Lock()
        self.aside = ThreadPoolExecutor(1)
        """For what will be asked for next."""

    def revision(self) -> str:
        """Return the revision of the archive, with the catalog brought up to it."""
        with self._lock:
            revision = self.catalogue.revision
            if revision != self._seen:
                self.catalogue.refresh()
                self._seen = revision
        return revision

    def run(self, run_id: str) -> RunFile:
        """Return a run. Raises ``HTTPException`` where there is none of that name in the folder."""
        inside(self.archive.folder, f"{run_id}{SUFFIX}")
        return RunFile(self.archive, run_id, self._kept)

    def study(self, study_id: str) -> StudyFile:
        """Return a study. Raises ``HTTPException`` where there is none of that name in the folder."""
        inside(self.archive.folder, f"{STUDIES}/{study_id}{SUFFIX}")
        return StudyFile(self.archive, study_id, self._kept)

    def about(self) -> bytes:
        """Return what archive this is as JSON."""
        revision = self.revision()
        return self._kept.get(
            ("archive", revision), lambda: encoded(archive_answer(self.archive, self.catalogue, revision))
        )

    def runs(self, asked: Asked, start: int = 0, most: int | None = None) -> bytes:
        """Return a list of runs as JSON. Raises ``QueryError`` where what is asked cannot be understood."""
        revision = self.revision()
        key = ("runs", revision, *asked, start, most)
        return self._kept.get(key, lambda: encoded(runs_answer(self.catalogue, revision, asked, start, most)))

    def studies(self) -> bytes:
        """Return the list of studies as JSON; those that cannot be read are left out."""
        return self._kept.get(
            ("studies", self.revision()), lambda: encoded([study_line(page) for page in self._pages()])
        )

    def _pages(self) -> Iterator[StudyPage]:
        for study_id in self.archive.study_ids():
            try:
                self.study(study_id).refuse_foreign()
                yield study_page(self.archive, study_id)
            except ArchiveError:
                continue
