"""What run.toml stated before it was amended: each earlier one as it came, with the one that counts.

/entry/earlier_manifests            NXcollection, in a run that was amended
  /entry/earlier_manifests/amended  when that was last done, ISO 8601
  /entry/earlier_manifests/run_1 …  NXnote, oldest first: the bytes with their SHA-256, when another one took their
                                    place, what it changed, and the fingerprint of the run as ingested with them
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py

from tribopipe.archive import nexus
from tribopipe.archive.runfile import EARLIER, members, source_pieces
from tribopipe.documents.toml import parse_toml, written_key
from tribopipe.results.run import RawRun, SourceFile

AMENDED = f"entry/{EARLIER}/amended"
"""Where a run states when it was amended last; missing in one that never was."""
_MOST_NAMED = 12


@dataclass(frozen=True)
class EarlierManifest:
    """A run.toml that another one took the place of."""

    source: SourceFile
    """Its bytes, under a name of their own: "run.earlier-1.toml"."""
    checksum: str
    """SHA-256 of its bytes as it was written."""
    raw_sha256: str
    """Fingerprint of the run as ingested with this run.toml."""
    date: str
    """Date of the amendment, ISO 8601."""
    changes: str
    """Differences of the other one: "end_values added"."""


def changed_file(entry: h5py.Group, run: RawRun) -> str | None:
    """Return the name of an instrument file that differs from the archived one; none if all are unchanged."""
    there = {(source.name, source.sha256) for source in run.sources[1:]}
    _, *archived = members(entry["source_files"])
    was = ((nexus.text(note, "file_name"), nexus.text(note, "checksum")) for note in archived)
    return next((name for name, checksum in was if (name, checksum) not in there), None)


def changes(old: Mapping[str, Any], new: Mapping[str, Any], within: str = "") -> Iterator[str]:
    """Report for each key whether it was added, removed or changed: "end_values.pin_scar_diameter added"."""
    for key in {**old, **new}:
        name = f"{within}{written_key(key)}"
        if key not in old or key not in new:
            yield f"{name} {'removed' if key in old else 'added'}"
        elif isinstance(old[key], Mapping) and isinstance(new[key], Mapping):
            yield from changes(old[key], new[key], f"{name}.")
        elif old[key] != new[key]:
            yield f"{name} changed"


def add_earlier(old: h5py.Group, entry: h5py.Group, date: str) -> None:
    """Keep the run.toml of an entry as it was in the one that takes its place."""
    kept = entry[EARLIER] if EARLIER in entry else nexus.group(entry, EARLIER, "NXcollection")
    number = len(_notes(kept)) + 1
    was = old["source_files/file_0"]
    note = nexus.group(kept, f"run_{number}", "NXnote")
    nexus.field(note, "file_name", f"run.earlier-{number}.toml")
    nexus.field(note, "type", "application/octet-stream")
    for name in ("data", "checksum", "algorithm"):
        was.copy(name, note)
    nexus.field(note, "description", _changes_in_words(old, entry))
    nexus.field(note, "date", date)
    nexus.field(note, "identifier_raw", nexus.text(old, "archived/raw_sha256"))
    if "amended" in kept:
        del kept["amended"]
    nexus.field(kept, "amended", date)


def _changes_in_words(old: h5py.Group, new: h5py.Group) -> str:
    """Report what has changed between the run.toml of two entries, the first keys of it by name."""
    was, now = (parse_toml(Path("run.toml"), _bytes(entry["source_files/file_0"])) for entry in (old, new))
    found = list(changes(was, now))
    more = [f"and {len(found) - _MOST_NAMED} more"] if len(found) > _MOST_NAMED else []
    return ", ".join([*found[:_MOST_NAMED], *more]) or "only comments and layout changed"


def read_earlier(entry: h5py.Group) -> list[EarlierManifest]:
    """Read the earlier ones, oldest first; empty where the run was never amended."""
    return [_read(note) for note in _notes(entry[EARLIER])] if EARLIER in entry else []


def _notes(kept: h5py.Group) -> list[h5py.Group]:
    return [kept[f"run_{number}"] for number in range(1, len(kept) + 1) if f"run_{number}" in kept]


def _read(note: h5py.Group) -> EarlierManifest:
    return EarlierManifest(
        source=SourceFile(nexus.text(note, "file_name"), _bytes(note)),
        checksum=nexus.text(note, "checksum"),
        raw_sha256=nexus.text(note, "identifier_raw"),
        date=nexus.text(note, "date"),
        changes=nexus.text(note, "description"),
    )


def _bytes(note: h5py.Group) -> bytes:
    return b"".join(source_pieces(note["data"]))
