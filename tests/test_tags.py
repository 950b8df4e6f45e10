"""Tags and notes: kept in the run's file with who and when, taken back but not forgotten; nothing else changes."""

import json
import shutil

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.annotation import Annotation, tags_after

RUN, OTHER = "si3n4-air-200mN", "si3n4-air-other"
WHEN = "2026-01-05T08:00:00+00:00"


def annotation(kind: str, text: str) -> Annotation:
    return Annotation(kind=kind, text=text, date=WHEN, operator="anna")


@pytest.fixture
def two(archive):
    """An archive of a processed run under two ids."""
    shutil.copy(archive / f"{RUN}.h5", archive / f"{OTHER}.h5")
    return archive


@pytest.fixture
def tribopipe(run_cli, two):
    """Run a command on that archive."""
    return lambda *arguments: run_cli(*arguments, "--archive", two)


def members(path) -> dict[str, bytes]:
    """What every dataset of a file holds, by its path."""
    found: dict[str, bytes] = {}

    def take(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            found[name] = np.asarray(item[()]).tobytes() if item.dtype.kind != "O" else bytes(item[()])

    with h5py.File(path, "r") as file:
        file.visititems(take)
    return found


# --- the record ---


@pytest.mark.parametrize("text", ["run in", "a,b", "", " ", "x" * 61, "tab\t", "zero\u200bwidth", "new\nline"])
def test_tags_that_could_not_be_asked_for_are_refused(text):
    with pytest.raises(ValidationError, match="expected up to 60 characters"):
        annotation("tag", text)


def test_empty_notes_are_refused():
    with pytest.raises(ValidationError, match="expected at least one word"):
        annotation("note", " \n")


@given(st.lists(st.tuples(st.sampled_from(["tag", "untag", "note"]), st.sampled_from(["a", "b", "c"]))))
def test_tags_are_what_was_given_and_not_taken_back(history):
    left = set()
    for kind, text in history:
        left = left | {text} if kind == "tag" else left - {text} if kind == "untag" else left
    assert set(tags_after(annotation(*entry) for entry in history)) == left


# --- the file ---


@pytest.mark.slow
def test_history_is_kept_and_all_else_stays(two):
    archive, path = Archive(two), two / f"{RUN}.h5"
    before = members(path)
    assert (archive.annotations(RUN), archive.tags(RUN)) == ([], ())
    given_ = [annotation("tag", "run-in"), annotation("tag", "reference"), annotation("note", "the disc rang")]
    archive.annotate(RUN, *given_)
    archive.annotate(RUN, annotation("untag", "run-in"))
    assert archive.annotations(RUN) == [*given_, annotation("untag", "run-in")]
    assert archive.tags(RUN) == ("reference",)
    after = members(path)
    assert {name: after[name] for name in after if not name.startswith("entry/annotations")} == before
    with h5py.File(path, "r") as file:
        assert file["entry/annotations"].attrs["NX_class"] == "NXnote"
        assert file["entry"].attrs["default"] == "wear"


@pytest.mark.slow
def test_annotations_outlive_a_new_ingestion_and_new_steps(two):
    archive = Archive(two)
    archive.annotate(RUN, annotation("tag", "run-in"))
    run, step = archive.raw(RUN), archive.steps(RUN)["friction_fit"]
    archive.add(run, archive.findings(RUN), force=True)
    archive.put_step(RUN, step)
    assert archive.tags(RUN) == ("run-in",)


def test_tag_that_is_not_there_cannot_be_taken_back(two):
    archive = Archive(two)
    archive.annotate(RUN, annotation("tag", "run-in"))
    before = (two / f"{RUN}.h5").read_bytes()
    with pytest.raises(ArchiveError, match=r"no tag 'runin' to remove.*did you mean 'run-in'"):
        archive.annotate(RUN, annotation("untag", "runin"))
    assert (two / f"{RUN}.h5").read_bytes() == before


# --- the commands ---


@pytest.mark.slow
def test_tags_are_given_to_several_and_taken_back(tribopipe, two):
    told = tribopipe("tag", RUN, OTHER, "--add", "run-in", "--add", "thesis", "--by", "anna", "--json")
    assert told.exit_code == 0
    assert json.loads(told.stdout) == {"runs": [{"id": run, "tags": ["run-in", "thesis"]} for run in (RUN, OTHER)]}
    assert tribopipe("tag", RUN, "--remove", "thesis").exit_code == 0
    assert "si3n4-air-200mN: run-in\n" in tribopipe("tag", RUN).output
    listed = json.loads(tribopipe("ls", "--where", "tag=thesis", "--json").stdout)["runs"]
    assert [(run["id"], run["tags"]) for run in listed] == [(OTHER, ["run-in", "thesis"])]
    history = Archive(two).annotations(RUN)
    assert [(one.kind, one.text) for one in history] == [("tag", "run-in"), ("tag", "thesis"), ("untag", "thesis")]
    assert history[0].operator == "anna"
    assert history[0].date.startswith("20")


def test_tag_given_twice_changes_nothing(tribopipe, two):
    tribopipe("tag", RUN, "--add", "run-in")
    before = (two / f"{RUN}.h5").read_bytes()
    assert tribopipe("tag", RUN, "--add", "run-in").exit_code == 0
    assert (two / f"{RUN}.h5").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["tag", RUN, "si3n4-air-oter", "--add", "x"], ["no run 'si3n4-air-oter'", "did you mean 'si3n4-air-other'?"]),
        (["tag", RUN, "--add", "run in"], ["the tag", "'run in'", "without spaces"]),
        (["tag", RUN, "--remove", "x"], ["no tag 'x' to remove"]),
        (["note", RUN, "si3n4-air-oter", "text"], ["no run 'si3n4-air-oter'"]),
        (["note", RUN, " "], ["the note", "expected at least one word"]),
    ],
)
def test_what_is_refused_changes_nothing(tribopipe, two, arguments, words):
    before = {path.name: path.read_bytes() for path in two.glob("*.h5")}
    told = tribopipe(*arguments)
    assert told.exit_code == 1
    assert [word for word in words if word not in told.stderr] == []
    assert {path.name: path.read_bytes() for path in two.glob("*.h5")} == before


def test_notes_are_written_to_several_runs(tribopipe):
    told = tribopipe("note", RUN, OTHER, "the disc rang, <b>loud</b>", "--by", "otto", "--json")
    assert told.exit_code == 0
    runs = json.loads(told.stdout)["runs"]
    assert [run["id"] for run in runs] == [RUN, OTHER]
    assert [(note["text"], note["operator"]) for note in runs[0]["notes"]] == [("the disc rang, <b>loud</b>", "otto")]
    assert RUN in tribopipe("ls", "--where", 'note~"disc rang"').output
    assert tribopipe("ls", "--where", "tag!=none", "--json").stdout.count('"id"') == 0
