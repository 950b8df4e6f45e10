"""Files that are no code and come with the package: pages of the documentation, and what sample runs are made from.

A wheel has them in this folder, laid out as in the repository; in a checkout they are where they are written.
"""

from pathlib import Path

from tribopipe.base.errors import InternalError

_FOLDERS = (Path(__file__).parent, Path(__file__).parents[2])


def shipped(name: str) -> Path:
    """Return a file or folder by its path in the repository. Raises ``InternalError`` where it was not installed."""
    for folder in _FOLDERS:
        if (folder / name).exists():
            return folder / name
    raise InternalError(
        f"{name}: found no such file in this installation; expected a file that is part of tribopipe; reinstall "
        "tribopipe"
    )
