"""Whether all that an HDF5 file shows is its own.

HDF5 can show what other files hold: by external links, by datasets whose bytes lie in another file, and by virtual
datasets. tribopipe writes none of these. A file that has them, from whoever it came, could make a viewer tell what it
was not asked for.
"""

import h5py

from tribopipe.errors import ArchiveError


def own_datasets(file: h5py.File) -> dict[str, tuple[int, ...]]:
    """Return the shapes of all datasets of a file by their paths; soft links are not followed.

    Raises ``ArchiveError`` where any part of it would be read from elsewhere.
    """
    found: dict[str, tuple[int, ...]] = {}

    def visit(name: bytes, info: h5py.h5l.LinkInfo) -> str | None:
        path = f"/{name.decode(errors='replace')}"
        if info.type not in (h5py.h5l.TYPE_HARD, h5py.h5l.TYPE_SOFT):
            return f"a link to another file at {path}"
        known = h5py.h5o.open(file.id, name) if info.type == h5py.h5l.TYPE_HARD else None
        if not isinstance(known, h5py.h5d.DatasetID):
            return None
        if elsewhere := storage_elsewhere(known):
            return f"{elsewhere} at {path}"
        found[path] = known.shape
        return None

    outside = file.id.links.visit(visit, info=True)
    if outside is not None:
        raise ArchiveError(
            f"{file.filename}: found {outside}; expected a file that holds all it shows, as tribopipe writes them; "
            "move it out of the archive"
        )
    return found


def storage_elsewhere(dataset: h5py.h5d.DatasetID) -> str | None:
    """Say what makes the values of a dataset come from another file; none where they are in its own."""
    created = dataset.get_create_plist()
    if created.get_layout() == h5py.h5d.VIRTUAL:
        return "a virtual dataset"
    return "a dataset stored in another file" if created.get_external_count() else None
