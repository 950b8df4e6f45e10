"""Whether a file from elsewhere may take its place in an archive as it is."""

import json
from pathlib import Path

from tribopipe.archive import nexus
from tribopipe.archive.formats import STUDY_FORMAT, Format, check_format
from tribopipe.archive.opening import opened
from tribopipe.base.errors import ArchiveError


def check_adopted(part: Path, path: Path, form: Format) -> None:
    """Look through a file that is to have the name ``path``.

    Raises ``ArchiveError`` where it is damaged, hostile, of another format, or not the run or study of that name.
    """
    try:
        with opened(part) as file:
            check_format(file, path, form)
            document = "study" if form == STUDY_FORMAT else "manifest"
            held = json.loads(nexus.text(file, f"entry/{document}/data"))["id"]
    except ArchiveError as error:
        said = str(error).replace(str(part), path.name)
        raise ArchiveError(f"{path}: cannot be taken in; {said}") from None
    if held != path.stem:
        raise ArchiveError(
            f"{path}: found {held!r} in what is called {path.stem!r}; expected a file named after what it holds; "
            "rename it, or take nothing from there unless you know who made it"
        )
