"""Where a result comes from: fingerprints of content, versions of libraries, and the machine.

By fingerprints a step knows whether anything it depends on has changed.
"""

import hashlib
import json
import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from tribopipe.documents.record import Record
from tribopipe.results.run import RawRun
from tribopipe.version import VERSION

_LIBRARIES = ("numpy", "scipy", "pandas", "h5py")


@cache
def environment() -> dict[str, str]:
    """Return, by name, versions and the machine; where all are the same, results are the same bit for bit."""
    from h5py.version import hdf5_version
    from numpy import show_config

    built = show_config(mode="dicts")
    blas, extensions = built.get("Build Dependencies", {}).get("blas", {}), built.get("SIMD Extensions", {})
    return {
        "tribopipe": VERSION,
        "python": f"{platform.python_implementation()} {platform.python_version()}",
        **{library: version(library) for library in _LIBRARIES},
        "hdf5": hdf5_version,
        "blas": f"{blas.get('name', 'unknown')} {blas.get('version', '')}".rstrip(),
        "system": f"{platform.system()} {platform.release()}",
        "machine": platform.machine(),
        "vectors": " ".join(extensions.get("found", ())) or "none",
    }


Part: TypeAlias = Record | NDArray[Any] | Mapping[str, Any] | str


def digest(*parts: Part) -> str:
    """Return the SHA-256 of records, arrays, mappings and texts, in this order."""
    hashed = hashlib.sha256()
    for part in parts:
        contents = _contents(part)
        hashed.update(sum(map(len, contents)).to_bytes(8, "big"))
        for content in contents:
            hashed.update(content)
    return hashed.hexdigest()


def _contents(part: Part) -> list[bytes | memoryview]:
    """Return the bytes that a part counts by, in one piece or two."""
    if isinstance(part, Record):
        # What is not said is left out, so that a field more in a later version changes nothing.
        return [part.model_dump_json(by_alias=True, exclude_none=True).encode()]
    if isinstance(part, np.ndarray):
        plain = part.astype(str) if part.dtype == object else part
        told = f"{plain.dtype.str}{plain.shape}".encode()
        return [told, np.ascontiguousarray(plain).reshape(-1).view(np.uint8).data]
    return [part.encode() if isinstance(part, str) else json.dumps(part, sort_keys=True).encode()]


def raw_digest(run: RawRun) -> str:
    """Return the fingerprint of a run as ingested: manifest, columns, and the bytes they came from."""
    return digest(run.manifest, *columns_and_sources(run))


def columns_and_sources(run: RawRun) -> list[Part]:
    """Return the parts of the fingerprint of an ingested run, in addition to its manifest."""
    parts: list[Part] = []
    for name, values in run.columns.items():
        parts += [name, run.origins[name], values]
    for label, extra in run.extras.items():
        parts += [label, extra.unit or "", extra.values]
    return [*parts, *(f"{source.name} {source.sha256}" for source in run.sources)]
