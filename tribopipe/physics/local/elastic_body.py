"""A deformable body under the surface that wears: a graded mesh in layers, pressed at its surface nodes.

Its elements are linear: bilinear quadrilaterals round an axis, and trilinear hexahedra. K = ∫ Bᵀ·D·B dV with strains ε
= B·u, the three normal ones first: ε_rr, ε_yy, ε_θθ = u_r/r and γ_ry round an axis; ε_xx, ε_zz, ε_yy and the three
shears in space. D has λ + 2μ and λ for the normal strains, μ for the shears.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.optional_packages import required
from tribopipe.physics.local.nodes import nested_dissection

_QUADRATURE_ORDER = 3
"""Two Gauss points in each direction."""


def skfem() -> Any:
    """Return scikit-fem. Raises ``ContactError`` where it is not installed."""
    problem = "local wear: scikit-fem is not installed"
    return required("skfem", "fe", "finite elements", problem=problem, error=ContactError)


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


@dataclass(frozen=True)
class Block:
    """One body, of the radius and the depth into it, or of the places across and along and the depth.

    It is held at the bottom, slides on planes of symmetry, which are where the first nodes are, and is free elsewhere.
    """

    mesh: Any
    """Of scikit-fem."""
    grid: NDArray[np.int64]
    """Numbers of the mesh's nodes; the last axis is the depth, from the surface on."""
    modulus: float
    """Young's, Pa."""
    poisson_ratio: float

    @property
    def surface(self) -> NDArray[np.int64]:
        """Numbers of the nodes on the surface."""
        return self.grid[..., 0]

    def compliance(self, nodes: NDArray[np.int64]) -> Column:
        """Return how far each of some nodes sinks in under unit forces at each of them, m/N."""
        factors, free = self._factors(self._held)
        row = np.empty(self._held.size, dtype=int)
        row[free] = np.arange(free.size)
        pressed = row[self._depthwise(nodes)]
        forces = np.zeros((free.size, pressed.size))
        forces[pressed, np.arange(pressed.size)] = 1.0
        return np.asarray(factors.solve(forces)[pressed])

    def moved(self, by: Column) -> Self:
        """Return the block with its surface moved into it, m, and the nodes within along: boundary displacement.

        They move as they would elastically if the surface were displaced so, and nowhere sideways. Raises
        ``ContactError`` where a cell of the mesh is turned inside out.
        """
        displacement = np.zeros(self.mesh.p.size)
        displacement[self._depthwise(self.surface)] = by.ravel()
        factors, within = self._interior
        displacement[within] = -factors.solve((self._stiffness @ displacement)[within])
        return replace(self, mesh=_valid(_with_nodes(self.mesh, self.mesh.p + displacement.reshape(-1, self._dim).T)))

    @property
    def _dim(self) -> int:
        return self.grid.ndim

    def _depthwise(self, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the degrees of freedom into the depth."""
        return self._dim * nodes.ravel() + self._dim - 1

    @cached_property
    def _stiffness(self) -> Any:
        return stiffness(self.mesh, self.modulus, self.poisson_ratio)

    @cached_property
    def _order(self) -> NDArray[np.int64]:
        nodes = nested_dissection(self.grid)
        return (self._dim * nodes[:, None] + np.arange(self._dim)).ravel()

    @cached_property
    def _held(self) -> NDArray[np.bool_]:
        held = np.zeros((self.grid.size, self._dim), dtype=bool)
        held[self.grid[..., -1].ravel()] = True
        for axis in range(self._dim - 1):
            held[np.take(self.grid, 0, axis).ravel(), axis] = True
        return held.ravel()

    @cached_property
    def _interior(self) -> tuple[Any, NDArray[np.int64]]:
        """Factors of the stiffness where the surface is held too."""
        fixed = self._held.reshape(-1, self._dim).copy()
        fixed[self.surface.ravel()] = True
        return self._factors(fixed.ravel())

    def _factors(self, fixed: NDArray[np.bool_]) -> tuple[Any, NDArray[np.int64]]:
        """Return the factors of the stiffness of what is not fixed, and its degrees of freedom in their order."""
        from scipy.sparse.linalg import splu

        free = self._order[~fixed[self._order]]
        matrix = self._stiffness[free][:, free].tocsc()
        return splu(matrix, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True}), free


def block(axes: Sequence[Column], depth: Column, height: Column, modulus: float, poisson_ratio: float) -> Block:
    """Return a body over the given nodes, whose surface is so high above a plane, m.

    Columns of nodes are pushed together under the surface and keep the bottom. Raises ``ContactError`` where the
    package scikit-fem is missing.
    """
    fe = skfem()
    kind = fe.MeshQuad if len(axes) == 1 else fe.MeshHex
    mesh = kind.init_tensor(*axes, depth)
    grid = np.lexsort(mesh.p[::-1]).reshape([*map(len, axes), len(depth)])
    nodes = mesh.p.copy()
    share = 1 - depth / depth[-1]
    nodes[-1, grid] = depth + height[..., None] * share
    return Block(_with_nodes(mesh, nodes), grid, modulus, poisson_ratio)


def _with_nodes(mesh: Any, nodes: Column) -> Any:
    return type(mesh)(np.ascontiguousarray(nodes), mesh.t)


def _valid(mesh: Any) -> Any:
    """Return the mesh. Raises ``ContactError`` where a cell is turned inside out at a corner."""
    jacobian = mesh.mapping().detDF(mesh.elem.refdom.p)
    turned = int((np.sign(jacobian) != np.sign(np.median(jacobian))).any(axis=1).sum())
    if turned:
        raise ContactError(
            f"local wear: found {turned} of {len(jacobian)} finite elements inverted by wear of the surface; "
            "expected none; use a coarser mesh, or simulate less wear"
        )
    return mesh
