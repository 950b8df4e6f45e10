"""The archive: what goes in comes out, NeXus' own checker finds nothing, and a failed write changes nothing."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from archived_files import edited, write_as_earlier
from folders import DISC_IDS, DISC_PAIR, SAMPLE_IDS
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from sweeps import others_slow

from tribopipe.archive.history import FILE_NAME as HISTORY
from tribopipe.archive.lock import LOCKS
from tribopipe.archive.rescue import rescue
from tribopipe.archive.step_names import STEPS, Step, downstream
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.base.files import natural_order
from tribopipe.documents.quantity import Quantity
from tribopipe.pipeline.stages import ingest
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.finding import Finding
from tribopipe.results.run import ExtraColumn, RawRun, SourceFile
from tribopipe.results.wear_fit import WearFit


def run_with(bare: RawRun, values: np.ndarray, **more) -> RawRun:
    distance = np.linspace(0, 1, len(values))
    columns = {"time": distance, "sliding_distance": distance, "depth": values}
    origins = {"time": "measured", "sliding_distance": "derived from nominal speed", "depth": "measured"}
    sources = (SourceFile("run.toml", b"# as it was\n"), SourceFile("signals.csv", bytes(range(256))))
    return replace(bare, columns=columns, origins=origins, sources=sources, **more)


def same(first: RawRun, second: RawRun) -> None:
    assert first.manifest == second.manifest
    assert (first.origins, first.headers) == (second.origins, second.headers)
    assert list(first.columns) == list(second.columns)
    for name in first.columns:
        np.testing.assert_array_equal(first.columns[name], second.columns[name])
    assert [(one.name, one.content) for one in first.sources] == [(one.name, one.content) for one in second.sources]
    assert set(first.extras) == set(second.extras)
    for name, extra in first.extras.items():
        assert extra.unit == second.extras[name].unit
        assert list(extra.values) == list(second.extras[name].values)


def test_long_column_of_texts_is_kept(bare_run, tmp_path):
    clock = np.array([f"12:00:{second % 60:02d}" for second in range(5000)], dtype=object)
    archive = Archive(tmp_path)
    archive.add(run_with(bare_run, np.arange(5000.0), extras={"Clock": ExtraColumn(clock)}))
    assert list(archive.raw("bare").extras["Clock"].values) == list(clock)


@settings(max_examples=15, deadline=None)
@given(
    npst.arrays(np.float64, st.integers(2, 600), elements=st.floats(allow_infinity=False, width=64)),
    st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=20), min_size=2, max_size=2),
)
def test_raw_run_comes_back_bit_for_bit(bare_run, values, texts):
    extras = {
        "a/b [°]": ExtraColumn(np.arange(len(values)), "deg"),
        "words": ExtraColumn(np.array(texts, dtype=object)),
    }
    run = run_with(bare_run, values, extras=extras, headers={"signals.csv": "Test №1; µ"})
    with TemporaryDirectory() as folder:
        archive = Archive(Path(folder))
        archive.add(run)
        same(run, archive.raw("bare"))


def test_findings_are_kept(bare_run, tmp_path):
    finding = Finding(severity="warning", code="gaps", where="time", message="found a gap", remedy="look there")
    archive = Archive(tmp_path)
    archive.add(run_with(bare_run, np.arange(10.0)), [finding])
    assert archive.findings("bare") == [finding]


def test_equal_content_gives_equal_bytes(bare_run, tmp_path):
    run = run_with(bare_run, np.arange(5000.0))
    for name in ("first", "second"):
        Archive(tmp_path / name).add(run)
    assert (tmp_path / "first" / "bare.h5").read_bytes() == (tmp_path / "second" / "bare.h5").read_bytes()


def test_same_run_again_is_left_alone_and_other_content_is_refused(bare_run, tmp_path):
    archive, run = Archive(tmp_path), run_with(bare_run, np.arange(10.0))
    assert [archive.add(run), archive.add(run), archive.add(run, force=True)] == ["added", "unchanged", "rewritten"]
    before = archive.path("bare").read_bytes()
    with pytest.raises(ArchiveError, match="different content"):
        archive.add(run_with(bare_run, np.arange(11.0)), force=True)
    assert archive.path("bare").read_bytes() == before


def step(name, result, **curves) -> Step:
    return Step(
        name,
        result,
        f"inputs of {name}",
        {"told": 1},
        "0.1.0",
        "2026-01-01T00:00:00+00:00",
        {curve: (values, "m") for curve, values in curves.items()},
    )


def metres(value: float) -> Quantity:
    return Quantity(value=value, unit="m", standard_uncertainty=value / 10)


def test_step_comes_back_whole_and_leaves_the_raw_part_as_it_was(bare_run, tmp_path):
    archive, run = Archive(tmp_path), run_with(bare_run, np.arange(10.0))
    archive.add(run)
    put = step(
        "drift_correction",
        DriftCorrection(outcome="corrected", zero_offset=metres(0.1 + 0.2)),
        wear_depth=np.arange(10.0) / 3,
        pin_wear_depth=np.arange(10.0) / 7,
    )
    archive.put_step("bare", put)
    got = archive.step("bare", "drift_correction")
    assert (got.result, got.options, got.inputs_sha256, got.date) == (
        put.result,
        put.options,
        put.inputs_sha256,
        put.date,
    )
    assert got.result_sha256 == put.result_sha256
    np.testing.assert_array_equal(got.curves["wear_depth"][0], put.curves["wear_depth"][0])
    same(run, archive.raw("bare"))
    with archive.open("bare") as file:
        assert file["entry"].attrs["default"] == "wear"
        assert file["entry/wear/pin_wear_depth"].attrs["units"] == "um"
        assert file["entry/wear/sliding_distance"].attrs["long_name"].endswith(" (m)")


@pytest.mark.slow
def test_new_result_drops_what_stood_on_the_old_one_and_an_equal_one_does_not(bare_run, tmp_path):
    archive = Archive(tmp_path)
    archive.add(run_with(bare_run, np.arange(10.0)))
    drift = step("drift_correction", DriftCorrection(outcome="uncorrected", missing=("an end value",)))
    archive.put_step("bare", drift)
    archive.put_step("bare", step("friction_fit", FrictionFit(outcome="none")))
    archive.put_step("bare", step("wear_fit_archard", WearFit(model="archard", outcome="not fitted")))
    archive.put_step("bare", drift)
    assert archive.step_names("bare") == ["drift_correction", "friction_fit", "wear_fit_archard"]
    archive.put_step("bare", step("drift_correction", DriftCorrection(outcome="uncorrected", missing=("a depth",))))
    assert archive.step_names("bare") == ["drift_correction", "friction_fit"]


def test_raw_part_written_anew_keeps_the_steps(bare_run, tmp_path):
    archive, run = Archive(tmp_path), run_with(bare_run, np.arange(10.0))
    archive.add(run)
    archive.put_step("bare", step("friction_fit", FrictionFit(outcome="none")))
    assert archive.add(run, force=True) == "rewritten"
    assert archive.step_names("bare") == ["friction_fit"]


def test_downstream_follows_the_table_of_steps():
    by_friction = ("sarkar", "dissipated_energy")
    fitted, every = ("wear_fit", "local_wear"), ("wear_fit", "prediction", "local_wear")
    laws = ("archard", "running_in", *by_friction)
    assert downstream("drift_correction") == {"specific_wear", *(f"{step}_{law}" for step in fitted for law in laws)}
    assert downstream("friction_fit") == {f"{step}_{law}" for step in every for law in by_friction}
    assert all(downstream(name) <= set(STEPS) for name in STEPS)


def test_failed_write_changes_nothing_and_leaves_nothing(bare_run, tmp_path, monkeypatch):
    archive = Archive(tmp_path)
    archive.add(run_with(bare_run, np.arange(10.0)))
    before = archive.path("bare").read_bytes()

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tribopipe.base.files.os.fsync", fail)
    with pytest.raises(ArchiveError, match="No space left on device"):
        archive.put_step("bare", step("friction_fit", FrictionFit(outcome="none")))
    assert archive.path("bare").read_bytes() == before
    assert [path.name for path in tmp_path.glob("*") if path.name not in (LOCKS, HISTORY)] == ["bare.h5"]


def test_file_of_a_later_format_is_refused(bare_run, tmp_path):
    archive = Archive(tmp_path)
    archive.add(run_with(bare_run, np.arange(10.0)))
    with edited(archive.path("bare")) as file:
        file["entry/archived/format"][()] = "tribopipe.run/99"
    with pytest.raises(ArchiveError, match=r"'tribopipe.run/99'; .*; use the tribopipe version that wrote it"):
        archive.raw("bare")


@pytest.mark.slow
def test_file_of_a_format_before_the_first_release_says_how_to_bring_it_over(short_runs, tmp_path):
    archive, path = Archive(tmp_path / "archive"), tmp_path / "archive" / "si3n4-air-200mN.h5"
    ingest(short_runs / path.stem, archive)
    raw = archive.raw_sha256(path.stem)
    write_as_earlier(path)
    with pytest.raises(ArchiveError, match=r"'tribopipe.archive/3', .*; save .*`tribopipe rescue`, and ingest them"):
        archive.raw(path.stem)
    again = Archive(tmp_path / "again")
    ingest(rescue(path, tmp_path / "saved").folder, again)
    assert again.raw_sha256(path.stem) == raw


def nxcheck(path: Path) -> tuple[int, int, str]:
    """Count what NeXus' own checker finds; its exit code says nothing."""
    script = Path(sys.executable).with_name("nxcheck")
    printed = subprocess.run([script, path], capture_output=True, text=True, encoding="utf-8").stdout
    plain = re.sub(r"\x1b\[[0-9;]*m", "", printed)
    warnings, errors = (re.search(rf"Total number of {what}: (\d+)", plain) for what in ("warnings", "errors"))
    assert warnings, printed
    assert errors, printed
    return int(warnings[1]), int(errors[1]), plain


@pytest.mark.parametrize("run_id", others_slow(SAMPLE_IDS))
def test_archived_samples_conform_to_nexus(sample_archive, run_id):
    warnings, errors, printed = nxcheck(sample_archive.path(run_id))
    assert (warnings, errors) == (0, 0), printed


@pytest.mark.slow
def test_archived_twin_disc_sample_conforms_to_nexus(disc_pair):
    warnings, errors, printed = nxcheck(disc_pair.path(DISC_PAIR[1]))
    assert (warnings, errors) == (0, 0), printed


@pytest.mark.slow
@pytest.mark.parametrize("run_id", DISC_IDS)
def test_archived_twin_disc_samples_conform_to_nexus(disc_archive, run_id):
    warnings, errors, printed = nxcheck(disc_archive.path(run_id))
    assert (warnings, errors) == (0, 0), printed


@pytest.mark.slow
def test_nexus_checker_would_find_a_fault(sample_archive, tmp_path):
    broken = tmp_path / "broken.h5"
    broken.write_bytes(sample_archive.path(SAMPLE_IDS[0]).read_bytes())
    with edited(broken) as file:
        file["entry/raw"].attrs["signal"] = "no_such_field"
        file["entry/pin"].attrs["NX_class"] = "NXpin"
    warnings, errors, _ = nxcheck(broken)
    assert warnings + errors > 0


@pytest.mark.slow
def test_everything_a_fit_needs_comes_from_the_file_alone(sample_archive, tmp_path, monkeypatch):
    monkeypatch.setattr("tribopipe.physics.uncertainty.BLOCK", 2_000)  # as the archived fit was drawn
    from tribopipe.documents.recipe import Recipe
    from tribopipe.pipeline.stages import advance

    run_id = SAMPLE_IDS[0]
    alone = Archive(tmp_path)
    alone.path(run_id).write_bytes(sample_archive.path(run_id).read_bytes())
    outcome = advance(alone, run_id, "wear_fit_sarkar", Recipe(), force=True)
    assert outcome.status == "done"
    assert outcome.result == sample_archive.step(run_id, "wear_fit_sarkar").result


@given(st.lists(st.integers(0, 10**9), min_size=2, max_size=5, unique=True))
def test_names_are_listed_by_their_numbers(numbers):
    names = [f"run-{number}mN" for number in numbers]
    assert sorted(names, key=natural_order) == [f"run-{number}mN" for number in sorted(numbers)]
