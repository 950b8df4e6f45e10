"""The run that another one is predicted from, against a look at every run of the archive."""

import shutil

import pytest
from folders import replace_in
from sweeps import others_slow

from tribopipe.archive.step_names import WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import Record
from tribopipe.documents.study import bodies, severity
from tribopipe.pipeline.archived_results import References
from tribopipe.pipeline.stages import process


def looked_for(archive, law):
    """Return the reference of each run that has one, by reading all of them."""
    manifests = {run_id: archive.manifest(run_id) for run_id in archive.ids()}
    fits = {run_id: archive.result(run_id, WEAR_FITS[law], Record) for run_id in manifests}
    fitted = [run_id for run_id, fit in fits.items() if fit is not None and fit.outcome == "fitted"]
    found = {}
    for run_id, manifest in manifests.items():
        comparable = [other for other in fitted if bodies(manifests[other]) == bodies(manifest)]
        found[run_id] = min(comparable, key=lambda other: severity(manifests[other]), default=run_id)
    return {run_id: other for run_id, other in found.items() if other != run_id}


@pytest.mark.parametrize("law", ["archard", "sarkar"])
@pytest.mark.parametrize(
    "tribometer", others_slow(["sample_archive", "disc_pair", "disc_archive"], "sample_archive", "disc_pair")
)
def test_it_is_the_lightest_of_all_comparable_runs(tribometer, law, request):
    archive = request.getfixturevalue(tribometer)
    known = References(archive, ["archard", "sarkar"])
    found = {run_id: known.lightest(run_id, law) for run_id in archive.ids()}
    assert {run_id: other for run_id, other in found.items() if other} == looked_for(archive, law)
    assert any(found.values())


def test_a_run_that_is_not_there_is_refused(sample_archive):
    with pytest.raises(ArchiveError, match="found no run 'another'"):
        References(sample_archive, ["archard"]).lightest("another", "archard")


@pytest.mark.slow
def test_a_damaged_file_is_told_and_its_neighbour_is_processed(archive, sample_run):
    store = Archive(archive)
    (damaged,) = store.ids()
    store.path(damaged).write_bytes(b"damaged")
    outcomes = list(process([sample_run], store, Recipe(wear={"models": ["archard"]})))
    assert [(outcome.run_id, outcome.stage) for outcome in outcomes if outcome.error] == [(damaged, "prediction")]
    assert store.result("si3n4-air-400mN", "wear_fit_archard", Record).outcome == "fitted"


@pytest.mark.slow
def test_a_run_without_friction_is_predicted_under_the_law_that_needs_none(short_runs, tmp_path, few_draws):  # noqa: ARG001 - few while it is there
    runs = [shutil.copytree(short_runs / name, tmp_path / name) for name in ("si3n4-air-200mN", "si3n4-air-400mN")]
    replace_in(runs[1] / "run.toml", r"(?m)^friction_force = .*\n", "")
    store = Archive(tmp_path / "archive")
    outcomes = list(process(runs, store, Recipe()))
    assert [str(outcome.error) for outcome in outcomes if outcome.error] == []
    predicted = {step for step in store.steps("si3n4-air-400mN") if step.startswith("prediction")}
    assert predicted == {"prediction_archard"}
