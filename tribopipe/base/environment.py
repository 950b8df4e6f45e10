"""What numbers are computed with: versions of everything that has a hand in them, and the machine."""

import platform
from functools import cache
from importlib.metadata import version

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
