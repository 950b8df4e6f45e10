"""Least squares of many draws at once."""

import numpy as np

from tribopipe.base.arrays import Column


def least_squares(design: Column, rows: Column) -> Column:
    """Return the least-squares solution of each draw: (draws, rows, unknowns) and (draws, rows)."""
    scale = np.sqrt(np.sum(design**2, axis=-2))
    scaled = design / np.where(scale > 0, scale, 1.0)[..., None, :]
    normal = np.einsum("...ri,...rj->...ij", scaled, scaled)
    # A body that shows no wear at all has no slope; its unknown then stays.
    normal = normal + 1e-12 * np.eye(normal.shape[-1])
    pull = np.einsum("...ri,...r->...i", scaled, rows)
    return np.linalg.solve(normal, pull[..., None])[..., 0] / np.where(scale > 0, scale, 1.0)
