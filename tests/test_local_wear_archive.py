"""Local wear in the archive: fields come back as they went in, NeXus' checker finds nothing, and nothing goes stale."""

from dataclasses import fields, replace

import h5py
import numpy as np
import pytest
from local_wear_runs import PIN, disc_curves, pin_curves
from sweeps import others_slow
from test_archive import nxcheck, run_with, step

from tribopipe.archive.local_wear_tables import archived_local_wear, local_wear_tables
from tribopipe.archive.step_names import Step
from tribopipe.archive.store import Archive
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.wear.local import LocalOptions
from tribopipe.physics.local.course import LocalWear
from tribopipe.pipeline.stages import wear_archived_locally
from tribopipe.results.wear_fit import WearFit


@pytest.fixture
def bare(bare_run, tmp_path) -> Archive:
    """An archive of a run without steps."""
    archive = Archive(tmp_path / "archive")
    archive.add(run_with(bare_run, np.arange(10.0)))
    return archive


def put(curves) -> Step:
    made = step("local_wear_archard", curves.result)
    return replace(made, tables=local_wear_tables(curves))


@pytest.mark.parametrize("made", others_slow([pin_curves, disc_curves]), ids=["pin", "discs"])
def test_local_wear_comes_back_whole(bare, made):
    curves = made()
    bare.put_step("bare", put(curves))
    kept = bare.step("bare", "local_wear_archard")
    back = archived_local_wear(kept)
    assert back.result == curves.result
    assert kept.result_sha256 == put(curves).result_sha256
    np.testing.assert_array_equal(back.along, curves.along)
    np.testing.assert_array_equal(back.gap, curves.gap)
    np.testing.assert_array_equal(back.mean_pressure, curves.mean_pressure)
    for one in fields(LocalWear):
        np.testing.assert_equal(getattr(back.course, one.name), getattr(curves.course, one.name))
    assert list(back.giwm) == list(curves.giwm)
    for name, wear in curves.giwm.items():
        np.testing.assert_array_equal(np.stack(back.giwm[name]), np.stack(wear))


@pytest.mark.slow
@pytest.mark.parametrize("made", others_slow([pin_curves, disc_curves]), ids=["pin", "discs"])
def test_fields_are_nexus_with_axes_and_units(bare, made):
    curves = made()
    bare.put_step("bare", put(curves))
    warnings, errors, printed = nxcheck(bare.path("bare"))
    assert (warnings, errors) == (0, 0), printed
    with bare.open("bare") as file:
        kept = file["entry/local_wear_archard/fields"]
        axes = list(kept.attrs["axes"])
        assert axes == (["rotations", "across", "along"] if curves.discs else ["sliding_distance", "radius"])
        assert [kept.attrs[f"{axis}_indices"] for axis in axes] == list(range(len(axes)))
        assert kept["pressure"].shape == tuple(kept[axis].size for axis in axes)
        units = {name: kept[name].attrs["units"] for name in ("pressure", "wear", axes[0], axes[1])}
        assert units == {"pressure": "Pa", "wear": "m", axes[0]: "1" if curves.discs else "m", axes[1]: "m"}


@pytest.mark.slow
def test_fields_are_chunked_and_compressed(bare):
    bare.put_step("bare", put(disc_curves()))
    with bare.open("bare") as file:
        pressure = file["entry/local_wear_archard/fields/pressure"]
        assert pressure.compression == "gzip"
        assert pressure.chunks[1:] == pressure.shape[1:]
        assert 1 < pressure.chunks[0] < pressure.shape[0]
        assert pressure.id.get_storage_size() < pressure.nbytes


def test_another_field_is_another_result():
    curves = pin_curves()
    other = replace(curves, course=replace(curves.course, worn=curves.course.worn * 1.001))
    assert put(other).result_sha256 != put(curves).result_sha256


def test_new_k_d_drops_what_was_worn_by_the_old_one(bare):
    fit = WearFit(model="archard", outcome="not fitted", missing=("a depth",))
    bare.put_step("bare", step("wear_fit_archard", fit))
    bare.put_step("bare", put(pin_curves()))
    bare.put_step("bare", step("wear_fit_archard", fit))
    assert "local_wear_archard" in bare.step_names("bare")
    bare.put_step("bare", step("wear_fit_archard", fit.model_copy(update={"missing": ("an end value",)})))
    assert bare.step_names("bare") == ["wear_fit_archard"]


@pytest.mark.slow
def test_step_is_skipped_while_nothing_has_changed(archive):
    store, known = Archive(archive), {"pin": Quantity(value=13.5e-15, unit="m^2/N")}

    def status(*, steps: int = 4, given=known, force: bool = False) -> str:
        how = LocalOptions(steps_per_decade=steps)
        return wear_archived_locally(
            store, PIN, "archard", Recipe(), how, coefficients=given, at=[1.0], force=force
        ).status

    assert [status(), status(), status(force=True), status(steps=5)] == ["done", "unchanged", "done", "done"]
    assert [status(given={}), status(given={})] == ["done", "unchanged"]
    raw, worn = store.path(PIN).read_bytes(), store.step(PIN, "local_wear_archard")
    assert worn.options["local_wear"]["steps_per_decade"] == 4
    assert status(given={}) == "unchanged"
    assert store.path(PIN).read_bytes() == raw


def test_archive_without_local_wear_has_none(bare):
    assert archived_local_wear(bare.step("bare", "local_wear_archard")) is None
    with h5py.File(bare.path("bare")) as file:
        assert "local_wear_archard" not in file["entry"]
