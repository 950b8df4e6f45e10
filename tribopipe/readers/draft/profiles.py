"""Profiles measured on the specimens of a run, named as such or found among its files."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from tribopipe.base.errors import ManifestError, ReaderError, did_you_mean
from tribopipe.documents.contact_kinds import contacts
from tribopipe.readers.draft.known_values import Known, run_key, shared_key
from tribopipe.readers.draft.toml import toml
from tribopipe.readers.export_files import Export, read_export
from tribopipe.readers.profiles import tells_axes


def _bodies() -> list[str]:
    """Name the bodies of all types of tribometer."""
    return list(dict.fromkeys(name for contact in contacts().values() for name in contact.body_names))


class Measured(NamedTuple):
    """A profile, and the body it was measured on."""

    body: str
    export: Export


def read_profile(written: str) -> Measured:
    """Read the profile that "disc=track.txt" names.

    Raises ``ManifestError`` where it names no body, ``ReaderError`` where there is no such file or no reader for it.
    """
    body, equals, file = (part.strip() for part in written.partition("="))
    if not equals or body not in _bodies():
        found = f"no body {body!r}" if equals else "no '='"
        raise ManifestError(
            f"--profile {written}: found {found}; expected a body and the file of its profile, such as "
            f"disc=track.txt; {did_you_mean(body, _bodies()) if equals else 'write both'}"
        )
    try:
        return Measured(body, read_export(Path(file), holds="profile"))
    except ReaderError:
        return Measured(body, read_export(Path(file)))  # a table, whose columns somebody has to name


def add_profiles(known: Known, measured: Sequence[Measured]) -> None:
    """Take profiles as post-test measurements. Raises ``ManifestError`` where the tribometer has no such body."""
    for body in dict.fromkeys(one.body for one in measured):
        exports = [one.export for one in measured if one.body == body]
        key, files = f"end_values.{body}_profile", [_named(export) for export in exports]
        untold = [export for export in exports if not tells_axes(export.table)]
        if untold:
            known.doubt(shared_key(key), files, _ask_for_columns(untold[0]))
            continue
        problem = known.take(key, files[0] if len(files) == 1 else files)
        if problem is not None:
            raise ManifestError(f"--profile {body}={exports[0].name}: {problem}")


def which_profile(known: Known, exports: Sequence[Export]) -> None:
    """Note profiles of which nobody has stated what they were measured on."""
    for export in exports:
        known.doubt(
            "end_values.disc_profile", {"file": export.name}, "a profile: of the disc, or of the pin (pin_profile)?"
        )


def profiles_left_open(known: Known) -> list[str]:
    """Report for which profiles run.toml holds but a comment, and why."""
    return [
        f"{run_key(key, known.kind)} is in a comment of run.toml: {doubt.why}"
        for key, doubts in known.doubts.items()
        if key.endswith("_profile")
        for doubt in doubts
    ]


def _named(export: Export) -> dict[str, Any]:
    columns = {} if tells_axes(export.table) else {"position": "…", "height": "…"}
    return {"file": export.name} | columns


def _ask_for_columns(export: Export) -> str:
    names = ", ".join(toml(column.name) for column in export.table.columns)
    return f"name the columns of position and height: {names}"
