"""Files of older formats are brought to the present one with all they hold, or stay as they were."""

import json
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from archived_files import edited
from folders import tree_bytes
from hostile_runs import QUICK
from killed import Killed, dying_at
from old_formats import take_archive_back, take_back

from tribopipe.archive import migrate as module
from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.digest import columns_and_sources, digest, raw_digest
from tribopipe.archive.formats import RUN_FORMAT, STUDY_FORMAT, Format
from tribopipe.archive.lock import writers_lock
from tribopipe.archive.migrate import content_of, files_of, migrate
from tribopipe.archive.opening import of_any_format
from tribopipe.archive.seal import is_sealed
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.annotation import Annotation
from tribopipe.documents.mark import Mark
from tribopipe.documents.study import Study
from tribopipe.pipeline.stages import process
from tribopipe.pipeline.studies import run_study

pytestmark = pytest.mark.slow

RUN, STUDY = "si3n4-air-200mN", "lightest"
DATE = "2026-07-01T10:00:00+00:00"
KEPT = f"before-format-{RUN_FORMAT.version}"
DISC_RUN = "si3n4-twin-disc-4pct-100k"


@pytest.fixture(scope="module")
def _full(_processed, tmp_path_factory) -> Path:
    folder = Path(shutil.copytree(_processed, tmp_path_factory.mktemp("full") / "archive"))
    store = Archive(folder)
    store.mark(RUN, Mark(kind="bad", reason="slipped", date=DATE, operator="anna"))
    store.mark(RUN, Mark(kind="good", reason="it was another", date=DATE))
    store.annotate(RUN, Annotation(kind="tag", text="run-in", date=DATE), Annotation(kind="note", text="µ", date=DATE))
    assert [one for one in run_study(store, Study(id=STUDY, fit=(RUN,)), QUICK) if one.error] == []
    return folder


@pytest.fixture
def full(_full, tmp_path) -> Archive:
    """An archive of a run with all steps, marks, tags and notes, and of a study."""
    return Archive(Path(shutil.copytree(_full, tmp_path / "archive")))


@pytest.fixture(scope="module")
def _old(_full, tmp_path_factory) -> Path:
    folder = Path(shutil.copytree(_full, tmp_path_factory.mktemp("old") / "archive"))
    take_archive_back(folder, 1)
    return folder


@pytest.fixture
def old(_old, tmp_path) -> Archive:
    """The same in format 1."""
    return Archive(Path(shutil.copytree(_old, tmp_path / "old")))


def contents(archive: Archive) -> dict[str, dict[str, str]]:
    found = {}
    for path in files_of(archive):
        with of_any_format(path) as file:
            found[path.name] = content_of(file)
    return found


def bring_up(archive: Archive) -> None:
    for path in files_of(archive):
        migrate(archive, path)


def without_environment(content: dict[str, str]) -> dict[str, str]:
    return {path: told for path, told in content.items() if "environment" not in path.split("/")}


@pytest.fixture
def say_migrate(run_cli):
    """Run migrate on an archive."""
    return lambda archive, *arguments: run_cli("migrate", *arguments, "--archive", archive.folder)


def sentence(result) -> str:
    (error,) = (line for line in result.stderr.splitlines() if line.startswith("error: "))
    return error


# --- what comes out ---


def test_files_come_back_as_they_were_but_for_what_the_old_format_did_not_say(full, old):
    expected = {name: without_environment(content) for name, content in contents(full).items()}
    study = expected[f"{STUDY}.h5"]
    expected[f"{STUDY}.h5"] = {path: told for path, told in study.items() if "stands_on" not in path}
    bring_up(old)
    assert contents(old) == expected
    assert old.study(STUDY).result.laws


def test_twin_disc_run_comes_back_as_it_was(disc_archive, tmp_path):
    archive = Archive(tmp_path)
    archive.path(DISC_RUN).write_bytes(disc_archive.path(DISC_RUN).read_bytes())
    before = contents(archive)
    take_archive_back(tmp_path, 1)
    bring_up(archive)
    assert contents(archive) == {name: without_environment(content) for name, content in before.items()}


def test_steps_are_not_stale_afterwards(old, short_runs):
    bring_up(old)
    assert {outcome.status for outcome in process([short_runs / RUN], old)} == {"unchanged"}
    assert {outcome.status for outcome in run_study(old, Study(id=STUDY, fit=(RUN,)), QUICK)} == {"unchanged"}


def test_step_says_what_it_stands_on_only_where_that_is_certain(full):
    told = {name: step.stands_on for name, step in full.steps(RUN).items()}
    take_archive_back(full.folder, 1)
    with h5py.File(full.path(RUN), "r+") as file:
        file["entry/friction_fit/fingerprints/inputs_sha256"][()] = "another version's"
    migrate(full, full.path(RUN))
    assert {name: step.stands_on for name, step in full.steps(RUN).items()} == told | {"friction_fit": {}}
    assert all(told.values())


def test_present_format_is_left_alone(full):
    before = tree_bytes(full.folder)
    assert [migrate(full, path).kept for path in files_of(full)] == [None, None]
    assert tree_bytes(full.folder) == before


def test_originals_are_kept_byte_for_byte_and_a_second_time_is_nothing_to_do(old):
    before = tree_bytes(old.folder)
    bring_up(old)
    after = tree_bytes(old.folder)
    assert {name: content for name, content in after.items() if name.startswith(KEPT)} == {
        f"{KEPT}/{name}": content for name, content in before.items() if name.endswith(".h5")
    }
    bring_up(old)
    assert tree_bytes(old.folder) == after


def test_first_way_of_counting_fingerprints_is_known(old):
    """The first files of format 1 counted what is null too, and had no checksums of sources."""
    run, step = old_raw(old), old_step(old, "friction_fit")
    with h5py.File(old.path(RUN), "r+") as file:
        entry = file["entry"]
        first = digest(entry["manifest/data"].asstr()[()], *columns_and_sources(run))
        entry["archived/raw_sha256"][()] = first
        entry["friction_fit/fingerprints/result_sha256"][()] = digest(
            entry["friction_fit/result/data"].asstr()[()], *step.arrays
        )
        for note in entry["source_files"].values():
            del note["checksum"], note["algorithm"]
    assert first != raw_digest(run)
    migrate(old, old.path(RUN))
    assert old.raw_sha256(RUN) == raw_digest(run)
    assert old.fingerprints(RUN, "friction_fit").result == step.result_sha256
    assert [one.sha256 for one in old.outline(RUN).sources] == [source.sha256 for source in run.sources]


def old_raw(archive: Archive):
    from tribopipe.archive.runfile import read_raw

    with of_any_format(archive.path(RUN)) as file:
        return read_raw(file)


def old_step(archive: Archive, name):
    from tribopipe.archive.runfile import read_step

    with of_any_format(archive.path(RUN)) as file:
        return read_step(file["entry"], name)


# --- what is refused ---


def flip_source(file: h5py.File) -> None:
    data = file["entry/source_files/file_0/data"]
    data[0] = data[0] ^ 1


def flip_column(file: h5py.File) -> None:
    file["entry/raw/depth"][7] += 1e-9


def flip_result(file: h5py.File) -> None:
    data = file["entry/friction_fit/result/data"]
    data[()] = data.asstr()[()].replace("0.", "1.", 1)


def spoil_manifest(file: h5py.File) -> None:
    file["entry/manifest/data"][()] = "{}"


def link_out(file: h5py.File) -> None:
    file["entry/raw/more"] = h5py.ExternalLink("other.h5", "/entry")


def lose_a_group(file: h5py.File) -> None:
    del file["entry/source_files"]


def text_for_numbers(file: h5py.File) -> None:
    attributes, length = dict(file["entry/raw/depth"].attrs), len(file["entry/raw/depth"])
    del file["entry/raw/depth"]
    file["entry/raw/depth"] = np.full(length, b"x")
    file["entry/raw/depth"].attrs.update(attributes)


def claim_a_version(version: int):
    def claim(file: h5py.File) -> None:
        file["entry/archived/format"][()] = str(Format(RUN_FORMAT.kind, version))

    return claim


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (flip_source, ["damaged", "run.toml", "checksum"]),
        (flip_column, ["damaged", "raw_sha256"]),
        (flip_result, ["damaged", "friction_fit"]),
        (spoil_manifest, ["damaged"]),
        (lose_a_group, ["damaged"]),
        (text_for_numbers, ["damaged"]),
        (link_out, ["link to another file"]),
        (claim_a_version(99), ["tribopipe.archive/99", "use the tribopipe version that wrote it"]),
    ],
)
def test_what_is_not_as_format_1_wrote_it_is_refused_and_stays(old, say_migrate, spoil, words):
    with h5py.File(old.path(RUN), "r+") as file:
        spoil(file)
    before = tree_bytes(old.folder)
    result = say_migrate(old, RUN)
    assert result.exit_code == 1
    assert [word for word in [str(old.path(RUN)), *words] if word not in sentence(result)] == [], sentence(result)
    assert tree_bytes(old.folder) == before


def test_what_is_no_file_of_ours_is_refused(old, say_migrate):
    old.path("notes").write_text("not HDF5", encoding="utf-8")
    with h5py.File(old.path("theirs"), "w") as file:
        file["x"] = np.arange(3)
    with edited_copy(old, "newer") as file:
        file["entry/archived/format"][()] = str(Format(RUN_FORMAT.kind, 99))
    result = say_migrate(old, "newer", "notes", STUDY, "theirs")
    assert result.exit_code == 3
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 3
    assert "not HDF5" in errors[1]
    assert "no tribopipe run" in errors[2]
    assert "later one" in errors[0]
    assert is_sealed(old.study_folder / f"{STUDY}.h5")


def edited_copy(archive: Archive, name: str):
    path = archive.path(name)
    path.write_bytes(archive.path(RUN).read_bytes())
    migrate(archive, path)
    return edited(path)


def test_file_in_which_anything_was_lost_does_not_take_the_place_of_the_old_one(old, monkeypatch):
    def lossy(before, after):
        before.copy("entry", after)
        del after["entry/marks"]
        after["entry/archived/format"][()] = str(RUN_FORMAT)
        return {"/", "entry/archived/format"}

    monkeypatch.setitem(module.MIGRATIONS[RUN_FORMAT.kind], 1, lossy)
    before = tree_bytes(old.folder)
    with pytest.raises(ArchiveError, match="found entry/marks"):
        migrate(old, old.path(RUN))
    assert tree_bytes(old.folder) == before


def test_another_original_is_never_replaced(old, say_migrate):
    kept = old.folder / KEPT / "studies" / f"{STUDY}.h5"
    kept.parent.mkdir(parents=True)
    kept.write_bytes(b"another")
    before = tree_bytes(old.folder)
    result = say_migrate(old, STUDY)
    assert result.exit_code == 1
    assert "move it away" in sentence(result)
    assert tree_bytes(old.folder) == before


# --- interrupted ---


def test_wherever_it_is_killed_nothing_is_lost_and_the_next_goes_on(old, monkeypatch):
    path = old.study_folder / f"{STUDY}.h5"
    original, kept, expected, ended = path.read_bytes(), old.folder / KEPT / "studies" / path.name, None, 0
    for moment in range(100):
        with monkeypatch.context() as patch:
            dying_at(patch, moment, [(module, "copyfile"), (Path, "write_bytes"), (Path, "mkdir")])
            try:
                migrate(old, path)
                break
            except Killed:
                ended += 1
        assert path.read_bytes() == original or kept.read_bytes() == original
        migrate(old, path)
        expected = expected or path.read_bytes()
        assert path.read_bytes() == expected
        path.write_bytes(original)
        shutil.rmtree(old.folder / KEPT)
    assert ended > 10


def test_no_file_is_migrated_while_another_writes_it(old, monkeypatch):
    monkeypatch.setattr("tribopipe.archive.lock._WAIT", 0.05)
    before = tree_bytes(old.folder)
    with writers_lock(old.folder, RUN), pytest.raises(ArchiveError, match="another tribopipe"):
        migrate(old, old.path(RUN))
    assert tree_bytes(old.folder) == before


def test_no_room_is_said_in_a_sentence(old, say_migrate, monkeypatch):
    before = tree_bytes(old.folder)

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fail)
    result = say_migrate(old)
    monkeypatch.undo()
    assert result.exit_code == 1
    assert result.stderr.count("No space left on device") == 2
    assert tree_bytes(old.folder) == before


# --- the command ---


def test_command_says_what_was_done_and_where_the_originals_are(old, say_migrate):
    result = say_migrate(old, "--json")
    assert result.exit_code == 0
    assert f"{old.folder / KEPT} until you delete it" in result.stderr
    run, study = json.loads(result.stdout)["files"]
    assert run == {
        "file": str(old.path(RUN)),
        "status": "migrated",
        "before": str(Format(RUN_FORMAT.kind, 1)),
        "format": str(RUN_FORMAT),
        "original": str(old.folder / KEPT / f"{RUN}.h5"),
        "error": None,
    }
    assert study["format"] == str(STUDY_FORMAT)
    again = say_migrate(old, "--json")
    assert "Nothing to do" in again.stderr
    assert [file["status"] for file in json.loads(again.stdout)["files"]] == ["unchanged", "unchanged"]


def test_only_what_is_named_is_migrated(old, say_migrate):
    assert say_migrate(old, STUDY).exit_code == 0
    assert (is_sealed(old.study_folder / f"{STUDY}.h5"), is_sealed(old.path(RUN))) == (True, False)
    result = say_migrate(old, "si3n4-air-20mN")
    assert result.exit_code == 1
    assert f"did you mean '{RUN}'?" in sentence(result)


def test_part_that_fails_does_not_stop_the_rest(old, say_migrate):
    old.path("a").write_bytes(b"damaged")
    result = say_migrate(old, "a", STUDY, "--json")
    assert result.exit_code == 3
    assert [file["status"] for file in json.loads(result.stdout)["files"]] == ["failed", "migrated"]


def test_other_commands_say_what_to_do(old, run_cli):
    before = tree_bytes(old.folder)
    for command in (["ls"], ["show", RUN], ["fit", RUN], ["mark-bad", RUN, "--reason", "x"], ["study", "show", STUDY]):
        result = run_cli(*command, "--archive", old.folder)
        assert result.exit_code == 1
        assert "`tribopipe migrate` brings it up to date" in result.stderr
    assert tree_bytes(old.folder) == before


def test_browser_lists_what_is_to_be_migrated(old):
    catalogue = Catalogue(old.folder)
    catalogue.refresh()
    told = dict(catalogue.unreadable)
    assert set(told) == {f"{RUN}.h5", f"studies/{STUDY}.h5"}
    assert all("tribopipe migrate" in said for said in told.values())


def test_a_file_taken_back_is_of_format_1(full):
    take_back(full.path(RUN), 1)
    with h5py.File(full.path(RUN)) as file:
        assert file.userblock_size == 0
        assert file["entry/archived/format"].asstr()[()] == "tribopipe.archive/1"
        assert "environment" not in file["entry/archived"]
