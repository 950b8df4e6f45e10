"""Profiles measured on the specimens of a run, named as such or found among its files."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from tribopipe.errors import ManifestError, ReaderError, did_you_mean
from tribopipe.ingest.draft.known import Known
from tribopipe.ingest.draft.toml import toml
from tribopipe.ingest.exports import Export, read_export

_BODIES = ("pin", "disc", "curved_disc", "flat_disc")


class Measured(NamedTuple):
    """A profile, and the body it was measured on."""

    body: str
    export: Export


def read_profile(written: str) -> Measured:
    """Read the profile that "disc=track.txt" names.

    Raises ``ManifestError`` where it names no body, ``ReaderError`` where there is no such file or no reader for it.
    """
    body, equals, file = (part.strip() for part in written.partition("="))
    if not equals or body not in _BODIES:
        raise ManifestError(
            f"--profile {written}: found no body; expected one and the file of its profile, such as disc=track.txt; "
            f"{did_you_mean(body, _BODIES)}"
        )
    try:
        return Measured(body, read_export(Path(file), holds="profile"))
    except ReaderError:
        return Measured(body, read_export(Path(file)))  # a table, whose columns somebody has to name


def add_profiles(known: Known, measured: Sequence[Measured]) -> None:
    """Take profiles as end values. Raises ``ManifestError`` where the tribometer has no such body."""
    for body in dict.fromkeys(one.body for one in measured):
        exports = [one.export for one in measured if one.body == body]
        key, tables = f"end_values.{body}_profile", [export for export in exports if export.reader.holds == "signals"]
        if tables:
            known.doubt(key, [_named(export) for export in exports], _ask_for_columns(tables[0]))
            continue
        files = [{"file": export.name} for export in exports]
        problem = known.take(key, files[0] if len(files) == 1 else files)
        if problem is not None:
            raise ManifestError(f"--profile {body}={exports[0].name}: {problem}")


def which_profile(known: Known, exports: Sequence[Export]) -> None:
    """Note profiles of which nobody has said what they were measured on."""
    for export in exports:
        known.doubt(
            "end_values.disc_profile", {"file": export.name}, "a profile; of the disc, or the pin: pin_profile?"
        )


def _named(export: Export) -> dict[str, Any]:
    columns = {} if export.reader.holds == "profile" else {"position": "…", "height": "…"}
    return {"file": export.name} | columns


def _ask_for_columns(export: Export) -> str:
    names = ", ".join(toml(column.name) for column in export.table.columns)
    return f"name the columns of position and height: {names}"
