"""A run that was amended: what the instrument wrote stays, the earlier run.toml is kept, the rest is redone."""

import json
import shutil
from pathlib import Path

import pytest
from archived_files import edited, with_sources
from browse_client import serving
from folders import replace_in, tree_bytes
from hypothesis import given, settings
from hypothesis import strategies as st
from killed import Killed, dying_at

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.earlier_manifests import changes
from tribopipe.archive.history import FILE_NAME as HISTORY
from tribopipe.archive.lock import LOCKS
from tribopipe.archive.rescue import rescue
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline.reproduce import reproduce
from tribopipe.pipeline.stages import advance, ingest, process
from tribopipe.pipeline.verify.archive import verify
from tribopipe.pipeline.verify.history import accept

RUN = "si3n4-air-200mN"
NOW = "2026-03-01T12:00:00+00:00"


@pytest.fixture
def unmeasured(short_runs, tmp_path) -> tuple[Path, str]:
    """A run folder without end values, and the run.toml that has them."""
    folder = Path(shutil.copytree(short_runs / RUN, tmp_path / "run"))
    whole = (folder / "run.toml").read_text(encoding="utf-8")
    replace_in(folder / "run.toml", r"\[end_values\]\n(.+\n)*", "")
    return folder, whole


@pytest.fixture(scope="module")
def _amended(short_runs, tmp_path_factory) -> Path:
    """A folder of that run folder, measured by now, and of an archive to which it was amended; not to be written into.

    Its friction had been fitted, and it has a mark, a tag and a note.
    """
    place = tmp_path_factory.mktemp("amended")
    folder, archive = Path(shutil.copytree(short_runs / RUN, place / "run")), Archive(place / "archive")
    whole = (folder / "run.toml").read_text(encoding="utf-8")
    replace_in(folder / "run.toml", r"\[end_values\]\n(.+\n)*", "")
    ingest(folder, archive)
    advance(archive, RUN, "friction_fit", Recipe())
    archive.mark(RUN, Mark(kind="bad", reason="it rang", date=NOW))
    archive.annotate(RUN, *(Annotation(kind=kind, text="thesis", date=NOW) for kind in ("tag", "note")))
    (folder / "run.toml").write_text(whole, encoding="utf-8", newline="\n")
    assert ingest(folder, archive, amend=True).dropped == ("clean_up", "friction_fit")
    return place


@pytest.fixture
def measured(_amended, tmp_path) -> Path:
    """The run folder as measured."""
    return Path(shutil.copytree(_amended / "run", tmp_path / "measured"))


@pytest.fixture
def amended(_amended, tmp_path) -> Archive:
    """The archive in which the run was amended."""
    return Archive(Path(shutil.copytree(_amended / "archive", tmp_path / "archive")))


# --- what is taken in ---


def test_without_being_asked_for_nothing_is_amended_and_the_option_is_named(unmeasured, tmp_path, run_cli):
    folder, whole = unmeasured
    archive = tmp_path / "archive"
    ingest(folder, Archive(archive))
    before = tree_bytes(archive)
    (folder / "run.toml").write_text(whole, encoding="utf-8")
    refused = run_cli("ingest", folder, "--archive", archive)
    assert (refused.exit_code, tree_bytes(archive)) == (1, before)
    assert "use --amend to replace run.toml and keep the earlier version" in refused.stderr


def test_a_file_of_the_instrument_must_be_there_as_it_was_and_others_may_come(bare_run, tmp_path):
    archive = Archive(tmp_path)
    archive.add(with_sources(bare_run, run=b"a = 1", signals=b"1"))
    for others in ({"signals": b"2"}, {}, {"renamed": b"1"}):
        with pytest.raises(ArchiveError, match="signals has changed"):
            archive.add(with_sources(bare_run, run=b"a = 2", **others), amend=True)
    more = with_sources(bare_run, run=b"a = 2", signals=b"1", profile=b"3")
    assert archive.add(more, amend=True) == "amended"
    assert [source.name for source in archive.raw("bare").sources] == ["run.toml", "signals", "profile"]


def test_what_is_the_same_is_not_amended(bare_run, tmp_path):
    archive, run = Archive(tmp_path), with_sources(bare_run, run=b"a = 1", signals=b"1")
    assert [archive.add(run, amend=True) for _ in range(2)] == ["added", "unchanged"]
    assert archive.earlier_manifests("bare") == []


# --- what is kept ---


def test_earlier_run_toml_marks_tags_and_notes_are_kept_and_steps_are_dropped(amended, measured):
    (earlier,) = amended.earlier_manifests(RUN)
    assert b"[end_values]" not in earlier.source.content
    assert (earlier.source.name, earlier.changes) == ("run.earlier-1.toml", "end_values added")
    assert earlier.source.sha256 == earlier.checksum
    assert amended.raw(RUN).sources[0].content == (measured / "run.toml").read_bytes()
    assert amended.manifest(RUN).end_values.pin_scar_diameter is not None
    assert amended.steps(RUN) == {}
    assert (amended.bad(RUN).reason, amended.tags(RUN), len(amended.annotations(RUN))) == ("it rang", ("thesis",), 2)
    assert "end_values" not in {finding.where for finding in amended.findings(RUN)}


@pytest.mark.slow
def test_amendments_outlive_later_ones_steps_marks_and_a_rewriting(bare_run, tmp_path):
    archive = Archive(tmp_path)
    for number in range(4):
        archive.add(with_sources(bare_run, run=b"a = %d" % number, signals=b"1"), amend=True)
    archive.mark("bare", Mark(kind="bad", reason="x", date=NOW))
    archive.add(archive.raw("bare"), force=True)
    kept = archive.earlier_manifests("bare")
    assert [one.source.content for one in kept] == [b"a = 0", b"a = 1", b"a = 2"]
    assert [one.source.name for one in kept] == [f"run.earlier-{number}.toml" for number in (1, 2, 3)]
    assert {one.changes for one in kept} == {"a changed"}
    assert len({one.raw_sha256 for one in kept} | {archive.raw_sha256("bare")}) == 4


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_an_amended_run_is_evaluated_sound_and_reproduced(amended, measured):
    outcomes = list(process([measured], amended, amend=True))
    assert [outcome.error for outcome in outcomes if outcome.error is not None] == []
    assert amended.step(RUN, "wear_fit_archard").result.first is not None
    assert verify(amended).findings == ()
    assert reproduce(amended, RUN).steps[0].outcome == "identical"


def test_the_list_knows_what_was_amended(amended):
    catalogue = Catalogue(amended.folder)
    catalogue.refresh()
    (run,) = catalogue.runs("amended!=none")
    assert run.date("amended") == amended.earlier_manifests(RUN)[0].date
    assert run.text("run_toml") == amended.raw(RUN).sources[0].sha256


@pytest.mark.slow
def test_it_is_told_wherever_a_run_is_looked_at(amended, run_cli):
    (earlier,) = amended.earlier_manifests(RUN)
    at = ["--archive", amended.folder]
    shown = run_cli("show", RUN, "-v", *at).output
    assert f"run.toml amended, {earlier.date[:10]}" in shown
    assert ": end_values added" in shown
    (told,) = json.loads(run_cli("show", RUN, *at, "--json").stdout)["amended"]
    assert told == {"date": earlier.date, "changes": "end_values added", "earlier_sha256": earlier.checksum}
    listed = run_cli("ls", "--columns", "id,amended", *at).output
    assert f" {RUN}   {earlier.date[:16].replace('T', ' ')}" in listed
    with serving(amended.folder) as client:
        remarks = client.get("api", "runs", RUN).json["remarks"]
    assert [one["text"] for one in remarks if one["kind"] == "amended"] == ["end_values added"]


def test_it_is_undone_by_amending_back(amended, measured):
    (first,) = amended.earlier_manifests(RUN)
    (measured / "run.toml").write_bytes(first.source.content)
    assert ingest(measured, amended, amend=True).dropped == ()
    assert [one.changes for one in amended.earlier_manifests(RUN)] == ["end_values added", "end_values removed"]
    assert amended.raw_sha256(RUN) == first.raw_sha256
    assert amended.raw(RUN).sources[0].content == first.source.content
    assert verify(amended, [RUN]).findings == ()


def test_a_changed_earlier_run_toml_is_found(amended):
    with edited(amended.path(RUN)) as file:
        data = file["entry/earlier_manifests/run_1/data"]
        data[0] = data[0] ^ 1
    accept(amended.folder, RUN)
    (finding,) = verify(amended, [RUN]).findings
    assert (finding.severity, finding.code) == ("error", "source")
    assert "run.earlier-1.toml" in finding.message


def test_earlier_ones_are_rescued_beside_the_one_that_counts(amended, tmp_path):
    saved = rescue(amended.path(RUN), tmp_path / "saved")
    assert (saved.whole, saved.damaged) == (("run.toml", "signals.csv", "run.earlier-1.toml"), ())
    assert (saved.folder / "run.toml").read_bytes() == amended.raw(RUN).sources[0].content


# --- interrupted ---


@pytest.mark.slow
def test_wherever_it_is_killed_there_is_the_run_as_it_was_or_as_amended(bare_run, tmp_path, monkeypatch):
    archive = Archive(tmp_path)
    first, second = (with_sources(bare_run, run=text, signals=b"1") for text in (b"a = 1", b"a = 2"))
    archive.add(first)
    before, ended = archive.path("bare").read_bytes(), 0
    for moment in range(10):
        archive.path("bare").write_bytes(before)
        with monkeypatch.context() as patch:
            dying_at(patch, moment)
            try:
                archive.add(second, amend=True)
                break
            except Killed:
                ended += 1
        assert archive.raw("bare").sources[0].content in (b"a = 1", b"a = 2")
        assert [one.source.content for one in archive.earlier_manifests("bare")] in ([], [b"a = 1"])
    assert ended > 2
    archive.tidy()
    assert [path.name for path in tmp_path.iterdir() if path.name not in (LOCKS, HISTORY)] == ["bare.h5"]


# --- what has changed ---


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ({"a": 1}, {"a": 1}, []),
        ({}, {"end_values": {"x": 1}}, ["end_values added"]),
        ({"e": {"x": 1, "y": 2}}, {"e": {"y": 3, "z": 1}}, ["e.x removed", "e.y changed", "e.z added"]),
        ({"a b": [1]}, {"a b": [2]}, ['"a b" changed']),
        ({"a": {"b": 1}}, {"a": 1}, ["a changed"]),
    ],
)
def test_changes_are_named_by_key(old, new, told):
    assert list(changes(old, new)) == told


documents = st.recursive(
    st.integers() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.sampled_from("abc"), inner, max_size=3),
)


@pytest.mark.slow
@settings(max_examples=50)
@given(st.dictionaries(st.sampled_from("abc"), documents), st.dictionaries(st.sampled_from("abc"), documents))
def test_nothing_is_said_only_of_what_is_the_same(old, new):
    assert (list(changes(old, new)) == []) == (old == new)
