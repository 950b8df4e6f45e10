"""The graph of a crate that is being written, and where the files that it describes lie."""

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias
from urllib.parse import quote

from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import sha256_of

METADATA = "ro-crate-metadata.json"
PREVIEW = "ro-crate-preview.html"
ARCHIVE = "archive"
"""A folder that is an archive of its own."""
DATASET = "about/dataset.toml"


RO_CRATE = "1.1"
"""Version of RO-Crate: the one on which notebooks, repositories and validators agree."""
Ref: TypeAlias = dict[str, str]
"""Reference to an entity from another entity."""
_TERMS = {"sha256": "http://schema.org/sha256"}
"""Names that the vocabulary of this version of RO-Crate does not have."""
_LISTS = ("hasPart", "mentions", "comment", "variableMeasured")


class Graph:
    """Entities of a crate. What is not known of one, none or empty, is left out of it."""

    def __init__(self, folder: Path) -> None:
        try:
            from rocrate.rocrate import ROCrate
        except ImportError:
            raise ArchiveError(
                "the package rocrate is not installed; expected this package, to write RO-Crates and .eln files; run "
                '`pip install "tribopipe[fair]"`'
            ) from None
        self.folder = folder
        self._crate = ROCrate(version=RO_CRATE, gen_preview=True)
        self._crate.metadata.extra_terms.update(_TERMS)
        self.root = self._crate.root_dataset

    def thing(self, identifier: str, kind: str, /, **said: Any) -> Ref:
        """Describe what is no file: a person, a quantity, an action."""
        from rocrate.model.contextentity import ContextEntity

        properties = {"@type": kind, **_known(said)}
        return _ref(self._crate.add(ContextEntity(self._crate, identifier, properties)))

    def file(self, path: str, content: Iterable[bytes], /, **said: Any) -> Ref:
        """Write a file into the crate and describe it, with its size and SHA-256."""
        place = self.folder / path
        place.parent.mkdir(parents=True, exist_ok=True)
        size, digest = _written(place, content)
        return self._file(place, size, digest, said)

    def standing(self, place: Path, /, **said: Any) -> Ref:
        """Describe a file that is in the crate already."""
        return self._file(place, place.stat().st_size, sha256_of(place), said)

    def _file(self, place: Path, size: int, digest: str, said: Mapping[str, Any]) -> Ref:
        described = {"name": place.name, "contentSize": str(size), "sha256": digest, **said}
        path = place.relative_to(self.folder).as_posix()
        return _ref(self._crate.add_file(place, path, properties=_known(described)))

    def folder_of(self, path: str, parts: Sequence[Ref], /, **said: Any) -> Ref:
        """Describe a folder of the crate and what belongs to it."""
        return _ref(self._crate.add_dataset(dest_path=path, properties=_known({**said, "hasPart": list(parts)})))

    def describe(self, **said: Any) -> None:
        """Report what the whole crate is."""
        for name, value in _known(said).items():
            self.root[name] = value

    def describe_metadata(self, **said: Any) -> None:
        """Describe the metadata of the crate beyond what every crate states."""
        for name, value in _known(said).items():
            self._crate.metadata[name] = value

    def things(self, kind: str) -> list[Mapping[str, Any]]:
        """Return all entities of a kind, as they are described."""
        return [entity.properties() for entity in self._crate.get_by_type(kind)]

    def followed(self, form: re.Pattern[str]) -> set[str]:
        """Return what files are stated to conform to, as far as it has a format: the first group of each."""
        said = (one.get("conformsTo", {}).get("@id", "") for one in self.things("File"))
        return {matched[1] for name in said if (matched := form.fullmatch(name))}

    def write(self) -> bytes:
        """Write the metadata with the files, and return them."""
        self._crate.metadata.write(self.folder)
        return (self.folder / METADATA).read_bytes()


def _ref(entity: Any) -> Ref:
    return {"@id": str(entity.id)}


def _known(said: Mapping[str, Any]) -> dict[str, Any]:
    """Leave out what is not known; a list of one is that one, as RO-Crate asks, but where notebooks want a list."""
    known = {name: value for name, value in said.items() if value is not None and value not in ("", [])}
    single = {name: value[0] for name, value in known.items() if isinstance(value, list) and len(value) == 1}
    return known | {name: value for name, value in single.items() if name not in _LISTS}


def _written(place: Path, content: Iterable[bytes]) -> tuple[int, str]:
    """Write a file; return its size and SHA-256."""
    size, digest = 0, hashlib.sha256()
    with place.open("wb") as file:
        for piece in content:
            size += file.write(piece)
            digest.update(piece)
    return size, digest.hexdigest()


def local(*names: str) -> str:
    """Return an identifier within the crate: "#si3n4-air-200mN/conditions.normal_load"."""
    return "#" + "/".join(quote(name, safe="") for name in names)
