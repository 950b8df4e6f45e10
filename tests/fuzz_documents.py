"""A program that lets atheris (Linux only) look for documents that are neither read nor refused in one sentence.

    python tests/fuzz_documents.py SECONDS SEED FOLDER

The first byte of what is tried says what is read: a run.toml, a recipe, a study, a plan, a template, or the description
of a reader. The first fault ends the program with status 1 or higher; FOLDER holds the document that caused it.
"""

import sys
import time
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

from fuzz_readers import LONGEST_SECONDS, guided

sys.path.append(str(Path(__file__).parents[1] / "benchmarks" / "reliability"))


class Trial:
    """How each kind of document is read, examples of each, and what is done with one."""

    def __init__(self, folder: Path, read: Sequence[Callable[[Path], object]], seeds: Sequence[bytes]) -> None:
        self.folder, self.read, self.seeds = folder, read, seeds
        self.document = folder / "document.toml"

    def run(self, data: bytes) -> None:
        """Read a document; its kind is the first byte."""
        from tribopipe.base.errors import ManifestError

        if not data:
            return
        self.document.write_bytes(data[1:])
        started = time.perf_counter()
        try:
            self.read[data[0] % len(self.read)](self.document)
        except ManifestError as error:
            if not str(error).isprintable():
                raise ValueError("no sentence") from error
        if time.perf_counter() - started > LONGEST_SECONDS:
            raise TimeoutError(f"more than {LONGEST_SECONDS} s")


def main() -> None:
    import atheris

    seconds, seed, folder = sys.argv[1:]
    with atheris.instrument_imports(include=["tomllib", "tribopipe.documents", "tribopipe.base.units"]):
        from fuzz_manifests import unchanged
        from fuzzing import READ
    kinds = list(READ)
    seeds = [
        bytes([kinds.index(case.kind)]) + case.files[case.made_of.rpartition("/")[2]]
        for case in unchanged()
        if case.made_of.endswith(".toml")
    ]
    warnings.simplefilter("error")
    guided(Trial(Path(folder), list(READ.values()), seeds), float(seconds), int(seed))


if __name__ == "__main__":
    main()
