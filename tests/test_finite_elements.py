"""Contact by finite elements against Hertz's, its wear against converged numbers, and the mesh that wears with it."""

import sys

import numpy as np
import pytest
from fe_bodies import (
    COEFFICIENT,
    DISC_COEFFICIENT,
    DISC_LOAD,
    ELLIPSE,
    LOAD,
    MODULUS,
    PEAK,
    RADIUS,
    START,
    discs,
    sphere,
)
from sweeps import others_slow

from tribopipe.base.errors import ContactError
from tribopipe.physics.local.course import wear
from tribopipe.physics.local.elastic_body import skfem, stiffness
from tribopipe.physics.local.finite_elements import QuarterDisc, pin_body
from tribopipe.physics.local.nodes import continued, graded, nested_dissection, tributary

DISTANCES = np.array([0.1, 1.0, 10.0, 100.0, 500.0])
DEPTHS = np.array([0.32352, 1.03758, 3.29059, 10.42579, 23.37819]) * 1e-6
ROTATIONS = np.array([1e5, 1e6, 2e6])
DISC_DEPTHS = np.array([0.07280, 0.39241, 0.62771]) * 1e-6

SMALL_PIN = sphere(graded(START / 5, 8 * START, 0.1))
FEW_CELLS = discs((5, 4), 1e5)


def test_spacings_are_even_and_then_grow():
    nodes = graded(1.0, 100.0, 0.1)
    assert nodes[[0, -1]] == pytest.approx([0.0, 100.0])
    assert np.diff(nodes)[:5] == pytest.approx(np.diff(nodes)[0])
    assert np.diff(nodes)[-1] == pytest.approx(0.1 * nodes[-2])
    more = continued(nodes, 1e4, 1.5)
    assert more[: nodes.size] == pytest.approx(nodes)
    assert more[-2] < 1e4 <= more[-1]
    assert np.diff(more)[nodes.size - 1 :] == pytest.approx(np.diff(more)[nodes.size - 2 : -1] * 1.5)


def test_what_nodes_stand_for_adds_up_to_all():
    nodes = graded(1.0, 30.0, 0.2)
    assert tributary(nodes).sum() == pytest.approx(30.0)
    assert tributary(nodes) @ nodes == pytest.approx(30.0**2 / 2)
    assert tributary(nodes, radial=True).sum() == pytest.approx(np.pi * 30.0**2)


@pytest.mark.parametrize("shape", [(40, 7), (9, 8, 7), (1, 1), (30, 1)])
def test_dissection_leaves_no_node_out(shape):
    grid = np.arange(np.prod(shape)).reshape(shape)
    assert np.sort(nested_dissection(grid)) == pytest.approx(grid.ravel())


def test_even_strain_stores_the_energy_of_hooke_s_law():
    mesh = skfem().MeshHex.init_tensor(*[np.array([0.0, 0.3, 1.0])] * 3)
    x, y, z = mesh.p
    skewed = type(mesh)(np.stack([x + 0.1 * y * z, y + 0.2 * x * z, z - 0.1 * x * y]), mesh.t)
    volume = float(np.sum(skfem().Basis(skewed, skewed.elem(), intorder=3).dx))
    matrix = stiffness(skewed, modulus=10.0, poisson_ratio=0.25)
    gradient = np.array([[0.1, 0.2, 0.3], [-0.2, 0.4, 0.1], [0.5, 0.0, 0.2]])
    moved = (gradient @ skewed.p).T.ravel()
    strain = (gradient + gradient.T) / 2
    energy = (4.0 * np.trace(strain) ** 2 + 2 * 4.0 * np.sum(strain**2)) * volume
    assert moved @ matrix @ moved == pytest.approx(energy)
    turned = ((gradient - gradient.T) @ skewed.p + 1.0).T.ravel()
    assert matrix @ turned == pytest.approx(np.zeros(turned.size), abs=1e-12)


def test_even_strain_round_an_axis():
    mesh = skfem().MeshQuad.init_tensor(np.array([0.0, 0.4, 1.0, 2.0]), np.array([0.0, 0.5, 3.0]))
    matrix = stiffness(mesh, modulus=10.0, poisson_ratio=0.25)
    moved = (np.array([0.1, -0.3])[:, None] * mesh.p).T.ravel()
    energy = 4.0 * (0.1 + 0.1 - 0.3) ** 2 + 2 * 4.0 * (0.1**2 + 0.1**2 + 0.3**2)
    assert moved @ matrix @ moved == pytest.approx(energy * np.pi * 2.0**2 * 3.0)


@pytest.mark.parametrize("nodes", [20, 20.4])
def test_hertz_s_sphere(nodes):
    surface = sphere(np.arange(int(1.5 * nodes)) * START / nodes)
    contact = surface.press(np.zeros_like(surface.gap))
    assert contact.pressure.max() == pytest.approx(PEAK, rel=0.01)
    hertz = PEAK * np.sqrt(np.clip(1 - (surface.radius / START) ** 2, 0, None))
    inner = (surface.radius > 0) & (surface.radius < 0.8 * START)
    assert contact.pressure[inner] == pytest.approx(hertz[inner], rel=0.01)
    assert surface.extent(contact).half_width == pytest.approx(START, rel=0.01)
    assert contact.approach == pytest.approx(START**2 / RADIUS, rel=0.01)
    assert surface.areas @ contact.pressure == pytest.approx(LOAD, rel=1e-12)


def close_to_hertz_s_ellipse(surface: QuarterDisc, share: float) -> None:
    contact = surface.press(np.zeros_like(surface.gap))
    extent = surface.extent(contact)
    found = [contact.pressure.max(), extent.half_width, extent.half_length, contact.approach]
    assert found == pytest.approx(
        [ELLIPSE.peak_pressure, ELLIPSE.half_width, ELLIPSE.half_length, ELLIPSE.approach], rel=share, abs=0
    )
    assert np.sum(surface.areas * contact.pressure) == pytest.approx(DISC_LOAD, rel=1e-12)


@pytest.mark.slow
def test_hertz_s_ellipse():
    close_to_hertz_s_ellipse(FEW_CELLS, 0.03)


@pytest.mark.slow
def test_hertz_s_ellipse_on_a_finer_mesh():
    close_to_hertz_s_ellipse(discs((8, 8)), 0.01)


@pytest.mark.slow
def test_wear_of_the_paper_s_pin():
    surface = sphere(graded(START / 10, 0.21e-3, 0.08))
    course = wear(surface, COEFFICIENT * DISTANCES, refresh_every=20)
    assert course.depth[1:] == pytest.approx(DEPTHS, rel=5e-3)
    assert course.volume[1:] == pytest.approx(COEFFICIENT * LOAD * DISTANCES, rel=1e-12)
    assert np.all(np.diff(course.half_width) > 0)
    assert np.all(np.diff(course.peak_pressure) < 0)


@pytest.mark.slow
def test_wear_of_the_paper_s_pin_on_a_finer_mesh():
    surface = sphere(graded(START / 20, 0.21e-3, 0.04))
    course = wear(surface, COEFFICIENT * DISTANCES, steps_per_decade=16, refresh_every=4)
    assert course.depth[1:] == pytest.approx(DEPTHS, rel=1.5e-3)
    assert course.volume[1:] == pytest.approx(COEFFICIENT * LOAD * DISTANCES, rel=1e-9)


def test_a_flat_pin_wears_evenly_in_the_end():
    radius = np.linspace(0, 0.1e-3, 41)
    flat = pin_body(normal_load=LOAD, modulus=MODULUS, poisson_ratio=0.24, radius=radius, gap=np.zeros(41))
    course = wear(flat, COEFFICIENT * np.array([1e4]), refresh_every=1000)
    even = LOAD / (np.pi * radius[-1] ** 2)
    assert course.pressure[0, -1] > 3 * even
    assert course.pressure[-1] == pytest.approx(np.full(41, even), rel=2e-3)
    assert course.half_width == pytest.approx(radius[-1], abs=0)


@pytest.mark.slow
def test_wear_of_the_paper_s_discs():
    course = wear(FEW_CELLS, DISC_COEFFICIENT * ROTATIONS[:1], steps_per_decade=24, refresh_every=1000)
    assert course.depth[1:] == pytest.approx(DISC_DEPTHS[:1], rel=0.02)
    assert course.volume[1:] == pytest.approx(DISC_COEFFICIENT * DISC_LOAD * ROTATIONS[:1], rel=1e-12)
    assert np.all(np.diff(course.half_width) > 0)
    assert np.all(np.diff(course.half_length) < 0)


@pytest.mark.slow
def test_wear_of_the_paper_s_discs_on_finer_meshes():
    amounts = DISC_COEFFICIENT * ROTATIONS
    courses = [
        wear(discs(cells, 2e6), amounts, steps_per_decade=32, refresh_every=every)
        for cells, every in [((8, 4), 1000), ((8, 4), 40), ((16, 8), 1000)]
    ]
    for course in courses:
        assert course.depth[1:] == pytest.approx(DISC_DEPTHS, rel=0.005)
        assert course.volume[1:] == pytest.approx(DISC_LOAD * amounts, rel=1e-9)
    off = [abs(course.depth[-1] / DISC_DEPTHS[-1] - 1) for course in courses]
    assert off[2] < off[0] / 2


@pytest.mark.slow
@pytest.mark.parametrize("surface", [SMALL_PIN, discs((3, 2), 1e5)], ids=["pin", "disc"])
def test_the_mesh_moves_with_the_worn_surface(surface):
    first = surface.places[0].reshape(-1, *[1] * (surface.gap.ndim - 1))
    worn = np.broadcast_to(0.3e-6 * np.clip(1 - (first / first[-1]) ** 2, 0, None), surface.gap.shape)
    moved = surface.refreshed(worn)
    at = tuple(slice(size) for size in surface.gap.shape)
    before, after = (body.mesh.p[:, body.surface[at]] for body in (surface.body, moved.body))
    assert after[-1] == pytest.approx(surface.gap + worn, rel=1e-12)
    assert after[:-1] == pytest.approx(before[:-1])
    bottom = surface.body.grid[..., -1]
    assert moved.body.mesh.p[:, bottom] == pytest.approx(surface.body.mesh.p[:, bottom])
    depths = moved.body.mesh.p[-1, moved.body.grid]
    assert np.all(np.diff(depths, axis=-1) > 0)
    again = moved.refreshed(worn / 2).refreshed(np.zeros_like(worn))
    assert again.body.mesh.p == pytest.approx(surface.body.mesh.p)


def test_elasticity_follows_the_worn_shape():
    worn = 1e-6 * np.clip(1 - (SMALL_PIN.radius / (6 * START)) ** 2, 0, None)
    moved = SMALL_PIN.refreshed(worn)
    change = np.abs(moved.compliance / SMALL_PIN.compliance - 1).max()
    assert 1e-5 < change < 0.05
    assert moved.gap == pytest.approx(SMALL_PIN.gap)


def test_a_mesh_turned_inside_out_is_refused():
    spike = np.zeros_like(SMALL_PIN.gap)
    spike[3] = START
    with pytest.raises(ContactError, match=r"found \d+ of \d+ finite elements inverted by .* coarser mesh"):
        SMALL_PIN.refreshed(spike)


@pytest.mark.parametrize("surface", others_slow([SMALL_PIN, FEW_CELLS]), ids=["pin", "disc"])
def test_a_contact_beyond_the_nodes_is_refused(surface):
    with pytest.raises(ContactError, match="reaches the last contact node"):
        surface.press(np.zeros_like(surface.gap), amount=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("surface", [sphere(np.linspace(0, 2 * START, 21)), FEW_CELLS], ids=["pin", "disc"])
def test_waves_of_wear_fade_below_the_stable_amount_and_grow_above(surface):
    """Explicit steps without the contact's conditions: p + C⁻¹·(change of wear) on the points in contact."""
    contact = surface.press(np.zeros_like(surface.gap))
    at = np.flatnonzero(contact.pressure)
    stiffness_there = np.linalg.inv(surface.compliance[np.ix_(at, at)])

    def after(steps: int, amount: float) -> float:
        pressure = np.zeros_like(surface.gap)
        wave = np.random.default_rng(1).normal(size=at.size)
        for _ in range(steps):
            pressure.flat[at] = -stiffness_there @ wave
            wave = wave + amount * surface.exposure(pressure).ravel()[at]
        return float(np.abs(pressure).max())

    limit = surface.stable_amount(contact)
    assert after(400, 0.97 * limit) < after(1, limit)
    assert after(400, 1.03 * limit) > 100 * after(1, limit)


def test_pressure_that_alternates_is_rough():
    surface = sphere(np.linspace(0, 2 * START, 41))
    contact = surface.press(np.zeros_like(surface.gap))
    assert surface.roughness(contact) < 0.01
    contact.pressure[: contact.pressure.argmin()][1::2] *= 0.3
    assert surface.roughness(contact) > 0.3


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "skfem", None)
    with pytest.raises(ContactError, match=r'scikit-fem is not installed; .* pip install "tribopipe\[fe\]"'):
        sphere(np.linspace(0, 2 * START, 11))
