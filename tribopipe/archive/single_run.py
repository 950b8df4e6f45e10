"""An archive for the steps of one run that follow one another."""

from tribopipe.archive import nexus
from tribopipe.archive.runfile import read_cleaned, read_fingerprints
from tribopipe.archive.store import Archive
from tribopipe.results.run import RawRun


class OneRun(Archive):
    """An archive that keeps the cleaned run it gave last, and gives it again while it is that of the file."""

    def __init__(self, archive: Archive) -> None:
        super().__init__(archive.folder)
        self.__dict__.update(vars(archive))
        self._made_of: object = None
        self._cleaned: RawRun | None = None

    def cleaned(self, run_id: str) -> RawRun:
        """Return a run with its signals as they were cleaned up, which cannot be written into."""
        with self.open(run_id) as file:
            entry = file["entry"]
            made_of = run_id, nexus.text(entry, "archived/raw_sha256"), read_fingerprints(entry, "clean_up")
            if self._cleaned is None or made_of != self._made_of:
                self._cleaned, self._made_of = read_cleaned(file), made_of
                for values in self._cleaned.columns.values():
                    values.flags.writeable = False
            return self._cleaned
