"""Linear elasticity of bilinear quadrilaterals round an axis, and of trilinear hexahedra.

K = ∫ Bᵀ·D·B dV with strains ε = B·u, the three normal ones first: ε_rr, ε_yy, ε_θθ = u_r/r and γ_ry round an axis;
ε_xx, ε_zz, ε_yy and the three shears in space. D has λ + 2μ and λ for the normal strains, μ for the shears.
"""

from importlib import import_module
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError

_QUADRATURE_ORDER = 3
"""Two Gauss points in each direction."""


def skfem() -> Any:
    """Return scikit-fem. Raises ``ContactError`` where it is not installed."""
    try:
        return import_module("skfem")
    except ImportError:
        raise ContactError(
            "local wear: found no package scikit-fem; expected it, since finite elements are requested; run "
            'pip install "tribopipe[fe]"'
        ) from None


def stiffness(mesh: Any, modulus: float, poisson_ratio: float) -> Any:
    """Return K of a mesh of quadrilaterals or hexahedra as a sparse matrix, N/m, for Young's modulus in Pa.

    Degree of freedom i of node n is number dim·n + i. Radii are the first coordinate of quadrilaterals.
    """
    from scipy.sparse import coo_array

    basis = skfem().Basis(mesh, mesh.elem(), intorder=_QUADRATURE_ORDER)
    functions = [function[0] for function in basis.basis]
    gradients = np.stack([function.grad for function in functions])
    values = np.stack([np.broadcast_to(np.asarray(function), basis.dx.shape) for function in functions])
    dim, (cells, points) = mesh.dim(), basis.dx.shape
    law = _elasticity(modulus, poisson_ratio, shears=2 * dim - 3)
    radius = np.asarray(basis.global_coordinates())[0]
    volume = basis.dx * (2 * np.pi * radius if dim == 2 else 1.0)
    size = dim * len(functions)
    blocks = np.zeros((cells, size, size))
    for q in range(points):
        strain = _strain(gradients[..., q], values[..., q] / radius[:, q] if dim == 2 else None)
        blocks += strain.swapaxes(1, 2) @ (law * volume[:, q, None, None]) @ strain
    dofs = (dim * mesh.t[:, None, :] + np.arange(dim)[:, None]).reshape(size, cells).T
    rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
    return coo_array((blocks.ravel(), (rows.ravel(), columns.ravel()))).tocsc()


def _elasticity(modulus: float, poisson_ratio: float, shears: int) -> Column:
    """Return D, Pa."""
    lame = modulus * poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio))
    shear = modulus / (2 * (1 + poisson_ratio))
    law = np.diag([2 * shear] * 3 + [shear] * shears)
    law[:3, :3] += lame
    return law


def _strain(gradients: Column, hoop: Column | None) -> NDArray[np.float64]:
    """Return B of each cell at a point, from gradients of shape functions (function, direction, cell) and N/r."""
    functions, dim, cells = gradients.shape
    pairs = list(combinations(range(dim), 2))
    strain = np.zeros((cells, 3 + len(pairs), functions, dim))
    for i in range(dim):
        strain[:, i, :, i] = gradients[:, i].T
    if hoop is not None:
        strain[:, 2, :, 0] = hoop.T
    for row, (i, j) in enumerate(pairs, 3):
        strain[:, row, :, i] = gradients[:, j].T
        strain[:, row, :, j] = gradients[:, i].T
    return strain.reshape(cells, 3 + len(pairs), functions * dim)
