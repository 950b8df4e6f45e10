"""What h5web asks of an HDF5 file: attributes, data, metadata, statistics and paths, by h5grove's encoders.

h5grove follows links wherever they lead. Here it is handed only what ``part_at`` finds within the file: external links,
virtual datasets and datasets stored in another file are never opened, nor what leads to them.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import h5py
from fastapi import APIRouter, Query
from h5grove.content import DatasetContent, DatatypeContent, GroupContent
from h5grove.encoders import encode
from h5grove.utils import parse_slice
from h5py import h5g, h5l, h5o
from starlette.exceptions import HTTPException
from starlette.responses import Response

from tribopipe.archive.file_signature import SUFFIX
from tribopipe.archive.hdf5_compression import check_packed
from tribopipe.archive.hdf5_guard import RawFile, check_attributes
from tribopipe.archive.part_by_path import NoPart, Part, link_at, part_at
from tribopipe.archive.remote import readable
from tribopipe.browse.guard import inside

Content: TypeAlias = Any
"""What h5grove makes of it."""
Format = Literal["json", "bin", "csv", "npy", "tiff"]
LARGEST = 20_000_000
"""Bytes of values in an answer: two million samples and some."""
_LARGEST_CHUNK = 1 << 28
"""Bytes that have to be unpacked for the least of its values."""
_MOST_PATHS, _MOST_MEMBERS, _MOST_LEVELS = 100_000, 10_000, 64


def h5_router(folder: Path) -> APIRouter:
    """Return the routes of h5grove for the files of an archive folder."""
    router = APIRouter(prefix="/h5")

    @router.get("/attr")
    def attributes(file: str, path: str = "/", attr_keys: Annotated[list[str] | None, Query()] = None) -> Response:
        with _opened(folder, file) as opened:
            part = _entity(opened, path)
            check_attributes(part)
            return _encoded(_content(path, part).attributes(attr_keys))

    @router.get("/data")
    def data(
        file: str,
        path: str = "/",
        dtype: Literal["origin", "safe"] = "origin",
        format: Format = "json",  # noqa: A002, as h5web calls it
        flatten: bool = False,
        selection: str | None = None,
    ) -> Response:
        with _opened(folder, file) as opened:
            return _encoded(_values(opened, path, selection).data(selection, flatten, dtype), format)

    @router.get("/meta")
    def metadata(file: str, path: str = "/") -> Response:
        with _opened(folder, file) as opened:
            return _encoded(_metadata(path, _entity(opened, path)))

    @router.get("/stats")
    def statistics(file: str, path: str = "/", selection: str | None = None) -> Response:
        with _opened(folder, file) as opened:
            return _encoded(_values(opened, path, selection, kinds="biuf").data_stats(selection))

    @router.get("/paths")
    def paths(file: str, path: str = "/") -> Response:
        with _opened(folder, file) as opened:
            return _encoded(_paths(path, _entity(opened, path)))

    return router


@contextmanager
def _opened(folder: Path, file: str) -> Iterator[h5py.File]:
    """Open a file of the archive; whatever cannot be read of it is a sentence."""
    path = inside(folder, file)
    if path.suffix != SUFFIX:
        raise HTTPException(404, f"found {file!r}; expected an HDF5 file in the archive; choose one ending in {SUFFIX}")
    try:
        with h5py.File(readable(path), "r", locking=False) as opened:
            yield opened
    except (LookupError, MemoryError, OSError, OverflowError, RuntimeError, TypeError, ValueError) as error:
        why = str(error).partition("\n")[0]
        raise HTTPException(422, f"{file}: cannot be read as requested ({why}); open another part") from error


def _encoded(content: object, encoding: Format = "json") -> Response:
    """Write an answer as h5grove does; texts may turn out longer than anybody could know before."""
    answer = encode(content, encoding)
    if len(answer.content) > 3 * LARGEST:
        raise _too_large(f"a response of {len(answer.content):,} bytes")
    return Response(answer.content, headers=answer.headers)


def _content(path: str, found: Part) -> Content:
    if isinstance(found, h5py.Group):
        return GroupContent(path, found, found.file)
    return (DatasetContent if isinstance(found, h5py.Dataset) else DatatypeContent)(path, found)


def _entity(file: h5py.File, path: str) -> Part:
    """Return what stands at a path. Raises ``HTTPException`` where that is nothing, or lies in another file."""
    found = part_at(file, path)
    if isinstance(found, NoPart):
        raise HTTPException(
            403 if found.beyond else 404,
            f"{path} is not a valid path in this file: found {found.beyond or 'nothing'}; expected a path within the "
            "file itself; go back to /",
        )
    return found


def _metadata(path: str, found: Part) -> dict[str, Any]:
    """Return the metadata of an entity, and those of a group's children; links that are not followed as links."""
    check_attributes(found)
    known: dict[str, Any] = dict(_content(path, found).metadata(depth=0))
    if isinstance(found, h5py.Group):
        if len(found) > _MOST_MEMBERS:
            raise _too_large(f"{len(found):,} members")
        known["children"] = [_child(found, name) for name in found]
    return known


def _child(group: h5py.Group, name: str) -> dict[str, Any]:
    found = part_at(group, name)
    if not isinstance(found, NoPart):
        check_attributes(found)
        return dict(_content(name, found).metadata(depth=0))
    link = link_at(group, name)
    if isinstance(link, h5py.ExternalLink):
        return {"name": name, "kind": "external_link", "target_file": link.filename, "target_path": link.path}
    if isinstance(link, h5py.SoftLink):
        return {"name": name, "kind": "soft_link", "target_path": link.path}
    return {"name": name, "kind": "other"}


def _values(file: h5py.File, path: str, selection: str | None, kinds: str | None = None) -> Content:
    """Return a dataset of which so much may be asked, and of certain kinds of numpy's where they are named.

    Raises ``HTTPException``: 413 where it is too much.
    """
    dataset = _entity(file, path)
    check_attributes(dataset)
    if not isinstance(dataset, h5py.Dataset):
        raise HTTPException(422, f"found no dataset at {path}; expected a dataset with values; open a dataset instead")
    if kinds is not None and dataset.dtype.kind not in kinds:
        raise HTTPException(422, f"found {dataset.dtype} at {path}; expected real numbers; open another dataset")
    count, size = _selected(dataset, selection), dataset.dtype.itemsize
    if count * size > LARGEST:
        raise _too_large(f"{count:,} values")
    if prod(dataset.chunks or ()) * size > _LARGEST_CHUNK:
        raise _too_large("chunks that are too large to decompress")
    if h5py.check_string_dtype(dataset.dtype) is None:
        check_packed(dataset)
    elif int(RawFile(file).text_lengths(dataset.id).sum()) > LARGEST:
        raise _too_large("strings that exceed this limit")
    return DatasetContent(path, dataset)


def _selected(dataset: h5py.Dataset, selection: str | None) -> int:
    """Return how many values a selection such as "0:10,3" has."""
    chosen = parse_slice(selection) if selection else ()
    every = (slice(None),) * len(dataset.shape or ())
    parts = zip((*chosen, *every), dataset.shape or (), strict=False)
    return prod(len(range(*part.indices(length))) if isinstance(part, slice) else 1 for part, length in parts)


def _too_large(found: str) -> HTTPException:
    expected = f"at most {LARGEST:,} bytes per response"
    return HTTPException(413, f"found {found}; expected {expected}; request a smaller selection")


def _paths(path: str, found: Part) -> list[str]:
    """Return the paths of all links below a group; none is followed but those that hold what they name."""
    if not isinstance(found, h5py.Group):
        raise HTTPException(422, f"found no group at {path}; expected the path of a group; open its parent group")
    names, waiting, seen = [path], [(path.rstrip("/"), found.id)], {h5o.get_info(found.id).addr}
    while waiting:
        above, group = waiting.pop()
        if len(names) + group.get_num_objs() > _MOST_PATHS or above.count("/") > _MOST_LEVELS:
            raise _too_large(f"more than {_MOST_PATHS:,} paths, or {_MOST_LEVELS} nested groups")
        for name, address in _links(group):
            names.append(f"{above}/{name.decode(errors='replace')}")
            if address is not None and address not in seen:
                seen.add(address)
                below = h5o.open(group, name)
                waiting += [(names[-1], below)] if isinstance(below, h5g.GroupID) else []
    return names


def _links(group: h5g.GroupID) -> list[tuple[bytes, int | None]]:
    """Return the names in a group, and where in the file each has what it names; none of what it does not hold."""
    links: list[tuple[bytes, int | None]] = []
    group.links.iterate(
        lambda name, link: links.append((name, link.u if link.type == h5l.TYPE_HARD else None)), info=True
    )
    return links
