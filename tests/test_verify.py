"""Verifying an archive: nothing is found in a sound one, and each kind of damage is found for what it is."""

import json
import os
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from archived_files import edited, put, remove
from bit_flips import flip_bits, rows_of
from folders import SAMPLES, tree_bytes
from sweeps import others_slow
from test_archive import nxcheck

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.database import FILE_NAME, sum_of
from tribopipe.archive.history import Account
from tribopipe.archive.lock import writers_lock
from tribopipe.archive.provenance import digest
from tribopipe.archive.removal import remove as take_out
from tribopipe.archive.store import Archive
from tribopipe.base.executor import Crew
from tribopipe.base.files import sha256_of
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.wear.local import LocalOptions
from tribopipe.pipeline.stages import process, wear_archived_locally
from tribopipe.pipeline.studies import run_study
from tribopipe.pipeline.verify import archive as verifying
from tribopipe.pipeline.verify.archive import Verified, look_at, verify
from tribopipe.pipeline.verify.file_findings import Look
from tribopipe.pipeline.verify.nexus import check_nexus, read_tree

PIN, HEAVY, DISC = "si3n4-air-200mN", "si3n4-air-400mN", "si3n4-twin-disc-4pct-100k"
STUDY = Study(id="si3n4-air", fit=(PIN,), predict=(HEAVY,), laws=("archard",))
RECIPE = Recipe(wear=WearRecipe(models=("archard",)))
DATE = "2026-07-01T10:00:00+00:00"
NOTE = Annotation(kind="note", text="it rang", date=DATE)


@pytest.fixture(scope="module")
def whole(short_runs, few_draws, tmp_path_factory) -> Path:  # noqa: ARG001 - few_draws works by being there
    """An archive with all that an archive may hold: both tribometers, a study, local wear, marks, tags, a catalogue."""
    archive = Archive(tmp_path_factory.mktemp("whole") / "archive")
    folders = [short_runs / PIN, short_runs / HEAVY, SAMPLES / DISC]
    outcomes = [*process(folders, archive, RECIPE, studied={PIN, HEAVY}), *run_study(archive, STUDY, RECIPE)]
    assert [one for one in outcomes if one.status == "failed"] == []
    wear_archived_locally(archive, PIN, "archard", RECIPE, LocalOptions(steps_per_decade=3), at=[1.0, 10.0])
    archive.mark(DISC, Mark(kind="bad", reason="it slipped", date=DATE))
    archive.annotate(PIN, Annotation(kind="tag", text="run-in", date=DATE), NOTE)
    catalogued(archive.folder)
    return archive.folder


def catalogued(folder: Path) -> None:
    """Make a catalogue as if the files had been there for a while."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.archive.file_signature._SETTLED_AFTER", 0)
        Catalogue(folder).refresh()


@pytest.fixture
def copied(whole, tmp_path) -> Path:
    """The same archive, to be damaged."""
    return Path(shutil.copytree(whole, tmp_path / "archive"))


@pytest.fixture
def small(whole, tmp_path) -> Path:
    """An archive of one short run of it, with a catalogue."""
    folder = tmp_path / "archive"
    (folder / "studies").mkdir(parents=True)
    path = whole / f"{DISC}.h5"
    Archive(folder).adopt(DISC, [path.read_bytes()], sha256_of(path))
    catalogued(folder)
    return folder


def found(verified: Verified) -> list[tuple[str, str]]:
    return [(finding.severity, finding.code) for finding in verified.findings]


@pytest.mark.slow
def test_sound_archive_gives_nothing(whole):
    before, told = tree_bytes(whole), []
    verified = verify(Archive(whole), advance=told.append)
    assert verified.findings == ()
    assert (verified.runs, verified.studies, verified.sound) == (3, 1, True)
    assert str(verified) == f"3 runs and 1 study, {verified.size / 1e6:.3g} MB, verified: sound"
    assert told == [f"{PIN}.h5", f"{HEAVY}.h5", f"{DISC}.h5", "studies/si3n4-air.h5"]
    assert tree_bytes(whole) == before


@pytest.mark.slow
def test_several_workers_find_the_same_in_the_same_order(copied):
    with edited(copied / f"{PIN}.h5") as file:
        change_source(file)
    (copied / f"{DISC}.h5").write_bytes(b"nothing")
    one, told, told_by_two = verify(Archive(copied)), [], []
    assert {finding.code for finding in one.findings} >= {"source", "content"}
    assert verify(Archive(copied), advance=told.append) == one
    assert verify(Archive(copied), advance=told_by_two.append, crew=Crew(jobs=2)) == one
    assert told_by_two == told


def change_source(file: h5py.File) -> None:
    data = file["entry/source_files/file_1/data"]
    data[7] = data[7] ^ 1


def change_column(file: h5py.File) -> None:
    file["entry/raw/time"][3] += 1e-12


def change_result(file: h5py.File) -> None:
    data = file["entry/specific_wear/result/data"]
    document = json.loads(data.asstr()[()])
    document["normal_load"]["value"] *= 1 + 1e-12
    data[()] = json.dumps(document)


def change_curve(file: h5py.File) -> None:
    file["entry/wear_fit_archard/data/curved_volume"][5] *= 1 + 1e-12


def change_option(file: h5py.File) -> None:
    data = file["entry/friction_fit/options/data"]
    data[()] = data.asstr()[()].replace("null", "1")


def change_base(file: h5py.File) -> None:
    """Leave a fit to stand on a drift correction that is not there."""
    process = file["entry/wear_fit_archard"]
    stands_on = json.loads(process["stands_on/data"].asstr()[()]) | {"drift_correction": "0" * 64}
    options = json.loads(process["options/data"].asstr()[()])
    process["stands_on/data"][()] = json.dumps(stands_on)
    told = digest(process["version"].asstr()[()], "wear_fit_archard", options, *stands_on.values())
    process["fingerprints/inputs_sha256"][()] = told


def attribute(path: str, name: str, value: object) -> Callable[[h5py.File], None]:
    """Give a part an attribute, or take it away where there is no value."""

    def change(file: h5py.File) -> None:
        if value is None:
            del file[path].attrs[name]
        else:
            file[path].attrs[name] = value

    change.__name__ = f"attribute {path}@{name}"
    return change


def change_shown(file: h5py.File) -> None:
    file["entry/conditions/normal_load"][()] *= 1 + 1e-12


def change_plot(file: h5py.File) -> None:
    file["entry/wear/archard"][5] *= 1 + 1e-12


DAMAGE = {
    change_shown: {("warning", "shown")},
    change_plot: {("warning", "shown")},
    attribute("entry/specific_wear/parameters/normal_load", "units", "kN"): {
        ("warning", "shown"),
        ("warning", "nexus"),
    },
    change_source: {("error", "source")},
    change_column: {("error", "raw")},
    change_result: {("error", "result"), ("warning", "shown")},
    change_curve: {("error", "result")},
    change_option: {("error", "inputs")},
    change_base: {("warning", "inputs")},
    put("entry/identifier_run", "another"): {("error", "identity")},
    put("entry/marks/data", "[{]"): {("error", "content")},
    put("entry/annotations", 1.0): {("error", "content"), ("warning", "nexus")},
    put("entry/archived/format", "tribopipe.run/99"): {("error", "content")},
    put("entry/wear_fit_archard/result/data", "{}"): {("error", "content")},
    put("entry/friction_fit/fingerprints/result_sha256", "0" * 64): {("error", "result")},
}


@pytest.mark.slow
@pytest.mark.parametrize("change", others_slow(DAMAGE, first=5), ids=lambda change: change.__name__)
def test_damage_that_was_sealed_is_found_by_what_the_file_says_of_itself(whole, tmp_path, change):
    path = Path(shutil.copy(whole / f"{DISC}.h5", tmp_path))
    with edited(path) as file:
        change(file)
    look, _ = look_at(tmp_path, path.name)
    assert {(finding.severity, finding.code) for finding in look.findings} == DAMAGE[change]
    assert all(finding.where.startswith(path.name) and finding.remedy for finding in look.findings)


FIT, RAW = "entry/wear_fit_archard/data", "entry/raw"
SPOILED = [
    attribute("entry/conditions", "NX_class", None),
    attribute("entry/curved_disc", "NX_class", "NXdisc"),
    attribute("entry/instrument/name", "signal", 1),
    attribute("entry/instrument", "colour", "grey"),
    attribute("entry/friction_fit/parameters", "NX_class", "NXsample"),
    attribute(RAW, "signal", "nothing"),
    attribute(RAW, "signal", None),
    attribute(RAW, "axes", None),
    attribute(RAW, "axes", ["rotations", "time"]),
    attribute(RAW, "axes", ["nothing"]),
    put(f"{RAW}/rotations", np.arange(7.0)),
    remove(f"{FIT}/rotations"),
    put("entry/friction_fit/sequence_index", "first"),
    put("entry/friction_fit/date", "yesterday"),
    put("entry/friction_fit/colour", "grey"),
    put("entry/friction_fit/parameters/mean_errors", "little"),
    put("entry/start_time", "in the morning"),
    put("entry/findings/found", "much"),
    put("entry/findings/a name", "much"),
]
"""What NeXus' own checker complains about."""
MORE = [
    put(f"{RAW}/elsewhere", h5py.SoftLink("/entry/nowhere")),
    attribute("/", "default", "nothing"),
    attribute("entry", "default", "conditions"),
    attribute(RAW, "auxiliary_signals", ["time", "nothing"]),
    attribute(FIT, "rotations_indices", 1),
    attribute(f"{FIT}/curved_volume", "units", None),
    attribute("entry/friction_fit/parameters/mean_errors", "units", "m"),
    remove("entry/friction_fit/date"),
    remove("entry/findings/type"),
]
"""What viewers stumble over besides."""


def spoiled(change: Callable[[h5py.File], None], whole: Path, folder: Path) -> Path:
    path = Path(shutil.copy(whole / f"{DISC}.h5", folder))
    with edited(path) as file:
        change(file)
    return path


def breaches(path: Path) -> set[str]:
    look = Look(path.name)
    with h5py.File(path) as file:
        check_nexus(read_tree(file, look), look)
    return {finding.code for finding in look.findings}


@pytest.mark.slow
@pytest.mark.parametrize("change", others_slow(MORE, first=3), ids=lambda change: change.__name__)
def test_breach_of_a_rule_of_nexus_is_found(whole, tmp_path, change):
    assert breaches(spoiled(change, whole, tmp_path)) == {"nexus"}


@pytest.mark.slow
@pytest.mark.parametrize("change", SPOILED, ids=lambda change: change.__name__)
def test_breach_that_nexus_own_checker_finds_is_found(whole, tmp_path, change):
    path = spoiled(change, whole, tmp_path)
    warnings, errors, printed = nxcheck(path)
    assert warnings + errors > 0, printed
    assert breaches(path) == {"nexus"}


def flip(path: Path, place: int) -> None:
    content = bytearray(path.read_bytes())
    content[place] ^= 4
    path.write_bytes(content)


@pytest.mark.parametrize("place", [3, 100, 400, 511, 512, 600, 5000, -1])
def test_flipped_bit_is_found_wherever_it_is(whole, tmp_path, place):
    path = Path(shutil.copy(whole / f"{DISC}.h5", tmp_path))
    flip(path, place)
    look, seen = look_at(tmp_path, path.name)
    (finding,) = look.findings
    assert (finding.severity, finding.code in ("seal", "content")) == ("error", True)
    assert seen is None


@pytest.mark.slow
def test_damaged_file_does_not_hide_the_others(copied):
    flip(copied / f"{PIN}.h5", 9000)
    flip(copied / f"{DISC}.h5", 9000)
    verified = verify(Archive(copied))
    assert {one.where for one in verified.findings if one.severity == "error"} == {f"{PIN}.h5", f"{DISC}.h5"}
    assert not verified.sound


@pytest.mark.parametrize("content", [b"", b"no HDF5", bytes(4000)])
def test_what_is_no_hdf5_is_told(small, content):
    (small / f"{DISC}.h5").write_bytes(content)
    assert ("error", "content") in found(verify(Archive(small)))


def test_run_under_another_name_is_told(small):
    shutil.move(small / f"{DISC}.h5", small / "another.h5")
    findings = verify(Archive(small)).findings
    assert ("another.h5", "error", "identity") in [(one.where, one.severity, one.code) for one in findings]


@pytest.mark.slow
def test_study_of_another_run_is_stale(copied):
    with edited(copied / "studies" / "si3n4-air.h5") as file:
        data = file["entry/stands_on/data"]
        stands_on = json.loads(data.asstr()[()]) | {HEAVY: "0" * 64}
        data[()] = json.dumps(stands_on)
    assert {("warning", "study"), ("error", "inputs")} <= set(found(verify(Archive(copied))))


@pytest.mark.slow
def test_prediction_from_another_coefficient_is_stale(copied):
    """The run that k_D came from is replaced by one of another k_D, whose study is gone."""
    archive = Archive(copied)
    fit = archive.step(PIN, "wear_fit_archard")
    other = fit.result.first.wear_coefficient.model_copy(update={"value": 1e-14})
    pin = fit.result.first.model_copy(update={"wear_coefficient": other})
    archive.put_step(PIN, replace(fit, result=fit.result.model_copy(update={"bodies": {"pin": pin}})))
    (copied / "studies" / "si3n4-air.h5").unlink()
    findings = verify(archive).findings
    assert (f"{HEAVY}.h5: /entry/prediction_archard", "warning", "reference") in [
        (one.where, one.severity, one.code) for one in findings
    ]


@pytest.mark.slow
def test_prediction_whose_reference_is_gone_is_noted(copied):
    (copied / FILE_NAME).unlink()
    take_out(Archive(copied), "si3n4-air", study=True)
    take_out(Archive(copied), PIN)
    assert set(found(verify(Archive(copied)))) == {("note", "reference"), ("note", "catalog")}


@pytest.mark.slow
def test_what_a_killed_writer_left_is_named(small):
    part = small / f".{DISC}.h5.abcd.part"
    part.write_bytes(b"half")
    (told,) = [one for one in verify(Archive(small)).findings if one.code == "folder"]
    assert (told.severity, told.where) == ("note", part.name)


@pytest.mark.slow
def test_what_a_writer_writes_now_is_not_named(small):
    (small / f".{DISC}.h5.abcd.part").write_bytes(b"half")
    with writers_lock(small, DISC):
        assert "folder" not in {check for _, check in found(verify(Archive(small)))}


@pytest.mark.slow
def test_what_is_none_of_ours_is_noted(small):
    (small / "thesis.docx").write_bytes(b"")
    (small / "old").mkdir()
    (small / "studies" / "draft.toml").write_bytes(b"")
    (small / "folder.h5").mkdir()
    told = {one.where: one.severity for one in verify(Archive(small)).findings if one.code == "folder"}
    assert told == dict.fromkeys(["thesis.docx", "old", "studies/draft.toml", "folder.h5"], "note")


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="a file system that does not tell capitals has no such names")
def test_ids_that_differ_in_capitals_alone_are_told(small):
    shutil.copy(small / f"{DISC}.h5", small / f"{DISC.upper()}.h5")
    assert ("warning", "folder") in found(verify(Archive(small)))


@pytest.mark.slow
def test_run_that_was_put_in_by_hand_and_is_gone_is_told_by_the_catalogue(small):
    by_hand = Path(shutil.copy(small / f"{DISC}.h5", small / "another.h5"))
    catalogued(small)
    by_hand.unlink()
    (told,) = verify(Archive(small)).findings
    assert (told.severity, told.code, told.where) == ("warning", "catalog", "another.h5")


@pytest.mark.slow
@pytest.mark.parametrize("content", [None, b"", b"no database" * 99])
def test_lost_or_damaged_catalogue_is_a_note_and_stays_as_it_is(small, content):
    (small / FILE_NAME).unlink()
    if content is not None:
        (small / FILE_NAME).write_bytes(content)
    assert found(verify(Archive(small))) == [("note", "catalog")]
    assert (small / FILE_NAME).is_file() == (content is not None)


@pytest.mark.slow
def test_catalogue_that_tells_a_run_wrong_is_told(small):
    with closing(sqlite3.connect(small / FILE_NAME)) as connection, connection:
        *row, _ = connection.execute("SELECT * FROM runs").fetchone()
        row[row.index("Si3N4")] = "SiC"
        places = ", ".join("?" * (len(row) + 1))
        connection.execute("DELETE FROM runs")
        connection.execute(f"INSERT INTO runs VALUES ({places})", [*row, sum_of(tuple(row))])  # noqa: S608, of ? alone
    (finding,) = verify(Archive(small)).findings
    assert (finding.severity, finding.code, finding.where) == ("warning", "catalog", f"{DISC}.h5")


@pytest.mark.slow
def test_file_replaced_while_it_is_looked_at_is_looked_at_again(small, monkeypatch):
    """A writer puts another result in the place of the one that a look began with, twice."""
    archive, looks = Archive(small), []

    def meanwhile(folder: Path, name: str):
        looks.append(name)
        seen = look_at(folder, name)
        if looks.count(f"{DISC}.h5") < 3 and name == f"{DISC}.h5":
            seen[0].error("seal", "found what is there no more; expected the file as it is", "look again")
            archive.annotate(DISC, NOTE)
        return seen

    monkeypatch.setattr(verifying, "look_at", meanwhile)
    assert verify(archive).sound
    assert looks.count(f"{DISC}.h5") == 3


@pytest.mark.slow
def test_number_that_agrees_with_its_checksum_is_found_by_computing_it_again(small):
    archive = Archive(small)
    step = archive.step(DISC, "specific_wear")
    load = step.result.normal_load.model_copy(update={"value": 0.26})
    archive.put_step(DISC, replace(step, result=step.result.model_copy(update={"normal_load": load})))
    assert verify(archive).sound
    (told,) = verify(archive, again=True).findings
    assert (told.severity, told.code, told.where) == ("warning", "recompute", f"{DISC}.h5: /entry/specific_wear")
    assert "result.normal_load.value: archived 0.26, now 0.249" in told.message


@pytest.mark.slow
def test_one_run_alone(copied):
    flip(copied / f"{PIN}.h5", 9000)
    verified = verify(Archive(copied), [DISC])
    assert (verified.runs, verified.studies, verified.findings) == (1, 0, ())


@pytest.mark.slow
def test_command_on_a_sound_archive(run_cli, small):
    done = run_cli("verify", small)
    assert done.exit_code == 0
    assert done.output.endswith("verified: sound\n")


def test_command_tells_findings_as_json_too(run_cli, small):
    flip(small / f"{DISC}.h5", 9000)
    done = run_cli("verify", "--archive", small, "--json")
    document = json.loads(done.stdout)
    assert done.exit_code == 1
    assert (document["sound"], document["runs"], document["studies"]) == (False, 1, 0)
    assert document["head"] == Account(small).read().head
    assert [(one["severity"], one["code"], one["where"]) for one in document["findings"]] == [
        ("error", "seal", f"{DISC}.h5")
    ]
    assert f"error: {DISC}.h5: found" in done.stderr
    assert "1 error, 0 warnings" in done.stderr


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_links_are_told(small):
    (small / f"{DISC}.h5").rename(small.parent / "elsewhere")
    (small / f"{DISC}.h5").symlink_to(small.parent / "elsewhere")
    (small / "lost.h5").symlink_to("nowhere")
    told = {(one.where, one.severity, one.code) for one in verify(Archive(small)).findings}
    assert told == {(f"{DISC}.h5", "note", "file"), ("lost.h5", "error", "folder")}


def test_command_takes_one_archive(run_cli, whole, tmp_path):
    assert run_cli("verify", whole, "--archive", tmp_path).exit_code == 2


def test_command_on_an_archive_or_a_run_that_is_not_there(run_cli, whole, tmp_path):
    assert "found no archive in this folder" in run_cli("verify", tmp_path / "nothing").stderr
    done = run_cli("verify", whole, "--run", "si3n4-air-200")
    assert done.exit_code == 1
    assert f"did you mean '{PIN}'?" in done.stderr


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_random_flips_are_all_found(tmp_path):
    every = flip_bits(20, 1, tmp_path)
    assert [row.what for row in rows_of(every) if not row.holds] == []
