"""One file of the archive: its bytes, its format, and all that it holds."""

from pathlib import Path

from tribopipe.archive.file_signature import STUDIES
from tribopipe.archive.formats import RUN_FORMAT, STUDY_FORMAT, check_format
from tribopipe.archive.opening import opened
from tribopipe.archive.seal import check_every_byte, is_sealed
from tribopipe.base.errors import ArchiveError
from tribopipe.base.failures import mended_by
from tribopipe.pipeline.verify.look import Look
from tribopipe.pipeline.verify.nexus import check_nexus
from tribopipe.pipeline.verify.runs import SeenRun, look_into_run
from tribopipe.pipeline.verify.studies import SeenStudy, look_into_study
from tribopipe.pipeline.verify.tree import read_tree


def look_at(archive: Path, name: str) -> tuple[Look, SeenRun | SeenStudy | None]:
    """Look at a file of the archive by its path in it; return what was found, and what other files have to agree with.

    Damage of one file is given in what was found, never raised.
    """
    look, path = Look(name), archive / name
    if path.is_symlink():
        look.note("file", "found a link; expected the file itself", "make sure that its target is kept as long", "")
    try:
        return look, _look_inside(path, look)
    except ArchiveError as error:
        look.refused("content", error)
    except OSError as error:
        why = f"cannot be read ({error.strerror or error}); expected a readable file"
        look.error("file", why, mended_by(error.errno or 0))
    return look, None


def _look_inside(path: Path, look: Look) -> SeenRun | SeenStudy | None:
    if is_sealed(path):
        try:
            check_every_byte(path)
        except ArchiveError as error:
            look.refused("seal", error)
            return None
    is_study = look.name.startswith(f"{STUDIES}/")
    with opened(path) as file:
        check_format(file, path, STUDY_FORMAT if is_study else RUN_FORMAT)
        check_nexus(read_tree(file, look), look)
        return (look_into_study if is_study else look_into_run)(file, look, path.stem)
