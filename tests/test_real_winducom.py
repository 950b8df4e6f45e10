"""Twelve real WINDUCOM runs, from export to archive, against the figures the vendor's software prints."""

from pathlib import Path

import numpy as np
import pytest

from tribopipe.archive.store import Archive
from tribopipe.pipeline.archived_results import archived_friction
from tribopipe.pipeline.stages import process

RUNS = Path(__file__).resolve().parents[2] / "shared" / "realdata" / "winducom-dwf-al10cu"
FILES = sorted(path.relative_to(RUNS).as_posix() for path in RUNS.glob("*/*.dwf"))

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not FILES, reason="the real WINDUCOM runs are not beside this checkout"),
]

# Mean and standard deviation of µ as the vendor's software shows them, by series and first figure of the file name.
VENDOR = {
    "2.5/1": ("0.539", "0.065"),
    "2.5/2": ("0.495", "0.052"),
    "2.5/4": ("0.448", "0.062"),
    "5/1": ("0.426", "0.033"),
    "5/3": ("0.501", "0.044"),
    "5/4": ("0.515", "0.060"),
    "7.5/1": ("0.496", "0.044"),
    "7.5/2": ("0.495", "0.051"),
    "7.5/3": ("0.507", "0.045"),
}

MANIFEST = """
schema = "tribopipe.run/1"
id = "{id}"
started = 2025-01-01T00:00:00
[contact]
kind = "pin-on-disc"
[contact.pin]
shape = "flat"
radius = "4 mm"
material = "Al10Cu"
youngs_modulus = "72 GPa"
poisson_ratio = 0.33
[contact.disc]
material = "steel"
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[conditions]
normal_load = "50 N"
sliding_speed = "2.4 m/s"
[[signals]]
file = "{file}"
"""


def key(file: str) -> str:
    folder, name = file.split("/")
    return f"{folder}/{name.split('-')[0]}"


@pytest.fixture(scope="module")
def archive(tmp_path_factory) -> Archive:
    """All twelve runs taken through the whole line, each with a run.toml written here."""
    folder = tmp_path_factory.mktemp("winducom")
    for file in FILES:
        run = folder / key(file).replace("/", "-")
        run.mkdir()
        (run / "signals.dwf").write_bytes((RUNS / file).read_bytes())
        (run / "run.toml").write_text(MANIFEST.format(id=run.name, file="signals.dwf"), encoding="utf-8")
    archive = Archive(folder / "archive")
    outcomes = list(process(sorted(path for path in folder.iterdir() if path.is_dir()), archive))
    assert [str(outcome.error) for outcome in outcomes if outcome.status == "failed"] == []
    return archive


def test_all_twelve_runs_are_archived_with_their_bytes(archive):
    assert len(archive.ids()) == len(FILES) == 12
    for file in FILES:
        run = archive.raw(key(file).replace("/", "-"))
        assert run.sources[1].content == (RUNS / file).read_bytes()
        assert run.origins["friction_coefficient"] == "derived from nominal load"


@pytest.mark.parametrize("run", VENDOR)
def test_mean_and_deviation_are_the_vendor_s(archive, run):
    fit = archived_friction(archive, run.replace("/", "-"))
    assert (f"{fit.mean.value:.3f}", f"{fit.standard_deviation.value:.3f}") == VENDOR[run]


@pytest.mark.parametrize("file", FILES)
def test_no_fit_reports_a_running_in_distance_that_the_data_cannot_hold(archive, file):
    run_id = key(file).replace("/", "-")
    fit, run = archived_friction(archive, run_id), archive.raw(run_id)
    spacing = float(np.median(np.diff(run.sliding_distance)))
    assert fit.outcome in ("exponential", "steady-only")
    if fit.outcome == "steady-only":
        assert fit.running_in_distance is None
        assert fit.notes
    elif not spacing < fit.running_in_distance.value < run.sliding_distance[-1]:
        assert any("longer than" in note for note in fit.notes)
    assert 0.3 < fit.steady_state.value < 0.6


def test_runs_without_depth_are_fitted_as_far_as_they_go(archive):
    for run_id in archive.ids():
        fit = archive.step(run_id, "wear_fit_archard").result
        assert (fit.outcome, fit.missing) == ("not fitted", ("a depth signal",))
        assert str(fit) == "archard: no wear coefficient: missing a depth signal"
