"""`show`: a page that reads well on a terminal, any part of the HDF5 file, and nothing that steers the terminal."""

import json
import re

import h5py
import numpy as np
import pytest
from archived_files import edited
from folders import replace_in, set_key

from tribopipe.archive.part_by_path import find_part
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.cli.pages import show_facts, show_run_page, show_study_page
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.pipeline.stages import ingest
from tribopipe.results.finding import Finding
from tribopipe.views.page import AgreementLine, Fact, LawPage, StudyPage, TextTable
from tribopipe.views.run_page import run_page

RUN = "si3n4-air-200mN"
DATE = "2026-07-01T10:00:00+00:00"
STEERING = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


@pytest.fixture
def show(run_cli, archive):
    return lambda *arguments: run_cli("show", RUN, *arguments, "--archive", archive)


@pytest.fixture
def terminal(monkeypatch):
    """Make stdout a terminal of some width."""

    def become(columns: int) -> None:
        monkeypatch.setattr("sys.stdout.isatty", lambda: True)
        monkeypatch.setenv("COLUMNS", str(columns))

    return become


def refused(result, *words: str) -> None:
    assert (result.exit_code, result.stdout) == (1, "")
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: ")
    assert [word for word in words if word not in line] == [], line


# --- the page ---


def test_page_has_headings_facts_and_tables(show, archive):
    shown = show("-v")
    assert shown.exit_code == 0
    lines = shown.stdout.splitlines()
    assert lines[0] == RUN
    for heading in ("Pin", "Disc", "Conditions", "Recorded", "Signals", "Post-test measurements", "Source files"):
        assert lines[lines.index(heading) - 1] == ""
    assert re.search(r"(?m)^  normal load +200\.0 ± 2\.0 mN$", shown.output)
    assert re.search(r"(?m)^  k_D of the pin \(Archard's law\) +\(", shown.output)
    assert re.search(r"(?m)^Wear coefficient \(Archard's law\) \(wear_fit_archard, tribopipe \S+, \S+\)$", shown.output)
    assert "  uncertainty budget of k_D of the pin" in lines
    assert re.search(r"(?m)^ normal load +200\.0 ± 2\.0 mN +run\.toml +", shown.output)
    assert lines[-1] == str(archive / f"{RUN}.h5")
    assert STEERING.search(shown.output) is None


def test_values_stand_beneath_each_other(show):
    shown = show("-v").output.partition("\nSignals\n")[2].partition("\n\n")[0]
    starts = {re.match(r"  \S+( \S+)* {2,}", line).end() for line in shown.splitlines()}
    assert len(starts) == 1


def test_terminal_has_bold_headings_and_wrapped_lines(archive, terminal, capsys):
    page = run_page(Archive(archive), RUN)
    show_run_page(page)
    plain = capsys.readouterr().out
    terminal(60)
    show_run_page(page)
    written = capsys.readouterr().out
    assert "\x1b" not in plain
    assert "\nPin\n" in re.sub("\x1b.*?m", "", written)
    texts = [line for line in re.sub("\x1b.*?m", "", written).splitlines() if line.startswith("  ")]
    prose = [line for line in texts if " ± " not in line and "SHA" not in line]
    assert max(map(len, prose)) <= 80
    (title,) = [line for line in texts if "Si3N4 on Si3N4" in line]
    assert len(title) <= 60


@pytest.mark.slow
def test_findings_and_remarks_are_told(archive, capsys):
    store = Archive(archive)
    store.mark(RUN, Mark(kind="bad", reason="slipped", date=DATE, operator="anna"))
    store.annotate(
        RUN, Annotation(kind="tag", text="run-in", date=DATE), Annotation(kind="note", text="odd", date=DATE)
    )
    finding = Finding(severity="warning", code="c", where="depth", message="found x; expected y", remedy="correct it")
    page = run_page(store, RUN)
    show_run_page(type(page)(**(vars(page) | {"findings": (finding,), "studies": ("air",)})))
    told = capsys.readouterr().out
    for line in (
        *("marked bad: slipped", "tags: run-in", "warning: depth: found x; expected y; correct it"),
        *(f"marked bad by anna, {DATE}: slipped", f"tagged, {DATE}: run-in", f"note, {DATE}: odd", "air"),
    ):
        assert f"\n  {line}\n" in told


def test_json_has_tags_and_annotations_too(show, archive):
    note = Annotation(kind="note", text="odd", date=DATE)
    Archive(archive).annotate(RUN, Annotation(kind="tag", text="run-in", date=DATE), note)
    document = json.loads(show("--json").stdout)
    assert document["tags"] == ["run-in"]
    assert document["annotations"][1] == note.model_dump(mode="json")
    assert document["wear_fits"]["archard"]["model"] == "archard"
    assert document["steps"] == Archive(archive).step_names(RUN)


def test_a_study_is_shown_by_its_own_command(run_cli, archive, monkeypatch):
    monkeypatch.setattr(Archive, "study_ids", lambda _: ["air"])
    refused(run_cli("show", "air", "--archive", archive), "found the study 'air'", "use `tribopipe study show air`")


def test_hostile_texts_steer_no_terminal(sample_run, tmp_path, run_cli):
    nasty = "a\\u001b]0;owned\\u0007 \\u202ebackwards\\u009b2J b"
    for key in ("title", "instrument"):
        set_key(sample_run, key, f'"{nasty}"')
    replace_in(sample_run / "run.toml", 'material = "Si3N4"', f'material = "{nasty}"')
    store = Archive(tmp_path / "a")
    run_id = ingest(sample_run, store).run_id
    for more in ([], ["--path", "/entry/manifest/data"], ["--path", "/entry/instrument"], ["--path", "/"]):
        shown = run_cli("show", run_id, "--archive", tmp_path / "a", *more)
        assert shown.exit_code == 0
        assert STEERING.search(shown.output) is None
        assert "owned" in shown.stdout


def test_fact_of_a_hostile_name_is_shown_harmless(capsys):
    show_facts([Fact("a\x1b[31m", "b\r\nc")], 9)
    assert capsys.readouterr().out == "  a\\x1b[31m  b c\n"


def test_study_page_says_all(capsys):
    law = LawPage(
        model="archard",
        heading="Archard's law",
        title="Archard's law: k_D = 1",
        tables=(TextTable("agreement of each run with the model", ("run", "agreement"), (("a", "consistent"),)),),
        sentences=("scatter of k_D",),
        agreement=(AgreementLine("a", "fitted", "consistent", "It holds.", ("beware",)),),
    )
    show_study_page(StudyPage("air", "In air", ("a",), (), (law,), ("note: one run",), "0.1.0", DATE, ""))
    lines = capsys.readouterr().out.splitlines()
    assert lines[:4] == [f"air (tribopipe 0.1.0, {DATE})", "  In air", "", "air, Archard's law: k_D = 1"]
    assert lines[-4:] == ["scatter of k_D", "a: It holds.", "a: note: beware", "note: one run"]


# --- a part of the file ---


def test_group_is_a_tree_of_what_it_holds(show):
    told = show("--path", "/entry").stdout
    assert re.match(r"/entry \(NXentry, \d+ members\)\n  @default = wear\n", told)
    for line in (
        "  raw (NXdata, 6 members)",
        "      time (1,251, float64) [s]",
        "          @origin = measured",
        "      sliding_distance -> /entry/raw/sliding_distance",
        f"  identifier_run = {RUN}",
    ):
        assert line in told.splitlines()


def test_plot_is_a_table_of_first_and_last_rows(show, archive):
    told = show("--path", "entry/wear/", "--rows", "2").output
    with h5py.File(archive / f"{RUN}.h5") as file:
        last = file["entry/wear/pin_wear_depth"][-1]
    rows = told[told.index("─") :].splitlines()[1:]
    assert [row.split()[0] for row in rows if row] == ["0", "1", "…", "1,249", "1,250"]
    assert f"{last:.8g}" in rows[4]
    assert "pin_wear_depth [um]" in told


def test_values_come_whole_in_json(show, archive):
    document = json.loads(show("--path", "/entry/raw/depth", "--json").stdout)
    assert document["value"] == Archive(archive).raw(RUN).columns["depth"].tolist()
    assert (document["shape"], document["attributes"]["units"]) == ([1251], "m")
    group = json.loads(show("--path", "/entry/drift_correction/data", "--json").stdout)
    assert set(group["values"]) == {"sliding_distance", "wear_depth", "pin_wear_depth"}
    assert group["members"]["sliding_distance"] == {"kind": "link", "leads_to": "/entry/raw/sliding_distance"}


def test_json_notes_are_laid_out_and_texts_are_whole(show):
    told = show("--path", "/entry/manifest/data").stdout
    assert f'\n    "id": "{RUN}",\n' in told
    assert json.loads(told.partition("\n")[2])["id"] == RUN
    assert f'\n    "id": "{RUN}",\n' in show("--path", "/entry/manifest").stdout


@pytest.mark.parametrize(
    ("path", "nearest"),
    [("/entry/wer", "'/entry/wear'"), ("/entri", "'/entry'"), ("/entry/raw/time/x", "'/entry/raw/time'")],
)
def test_wrong_path_names_the_nearest(show, path, nearest):
    refused(show("--path", path), f"found no {path!r}", f"did you mean {nearest}?")


def test_plot_over_two_axes_is_a_tree_with_all_values_in_json(show, archive):
    with edited(archive / f"{RUN}.h5") as file:
        data = file.create_group("map")
        data.attrs.update(NX_class="NXdata", signal="wear", axes=["s", "r"], auxiliary_signals=["gone"])
        data["s"], data["r"], data["wear"] = np.arange(2.0), np.arange(3.0), np.ones((2, 3))
    told = show("--path", "/map").stdout
    assert "  wear (2 × 3, float64)" in told
    assert "number" not in told
    assert json.loads(show("--path", "/map", "--json").stdout)["values"]["wear"] == [[1.0] * 3] * 2


def test_rows_have_to_be_some(show):
    assert show("--path", "/entry", "--rows", "0").exit_code == 2


@pytest.fixture
def odd(archive):
    """The archive with what an odd file may hold that is read within bounds."""
    with edited(archive / f"{RUN}.h5") as file:
        group = file.create_group("odd", track_order=True)
        group["loop"] = h5py.SoftLink("loop")
        group["relative"] = h5py.SoftLink("./map")
        group["lost"] = h5py.SoftLink("/nowhere")
        group["map"] = np.arange(12.0).reshape(4, 3)
        group["gaps"] = np.array([1.0, np.nan, np.inf])
        group["words"] = np.array(["a\x1b[31m", "b"], dtype=h5py.string_dtype())
        group.attrs["\x1bname"] = "\x1b[2J"
    return archive


@pytest.mark.usefixtures("odd")
def test_links_in_circles_lead_nowhere(show):
    refused(show("--path", "odd/loop"), "expected an object in this file")
    refused(show("--path", "odd/loop", "--json"), "expected an object in this file")


def test_links_that_multiply_come_to_an_end(show, archive):
    with edited(archive / f"{RUN}.h5") as file:
        file["link_0"] = h5py.SoftLink("/")
        for number in range(60):
            file[f"link_{number + 1}"] = h5py.SoftLink(f"link_{number}/link_{number}")
    assert show("--path", "link_3").exit_code == 0
    refused(show("--path", "link_60"), "found a chain of more than 16 links", "expected an object in this file")


@pytest.mark.usefixtures("odd")
def test_odd_members_are_told_and_do_no_harm(show):
    told = show("--path", "odd")
    assert told.exit_code == 0
    assert STEERING.search(told.output) is None
    lines = told.output.splitlines()
    for line in (
        "  lost -> /nowhere",
        "  relative -> ./map",
        "  map (4 × 3, float64)",
        "  words (2, text)",
        "  @\\x1bname = \\x1b[2J",
    ):
        assert line in lines


@pytest.mark.usefixtures("odd")
def test_odd_values_are_shown(show):
    assert json.loads(show("--path", "odd/gaps", "--json").stdout)["value"] == [1.0, None, None]
    assert "\n  0: [0. 1. 2.]\n" in show("--path", "odd/relative").stdout
    assert "a\\x1b[31m" in show("--path", "odd/words").stdout
    assert show("--path", "odd/gaps").exit_code == 0
    refused(show("--path", "odd/lost"), "found no 'odd/lost'")


def test_parts_are_found_by_any_writing_of_their_path(archive):
    with Archive(archive).open(RUN) as file:
        for path in ("/entry/raw", "entry/raw", "//entry/./raw/"):
            assert find_part(file, path).name == "/entry/raw"
        assert find_part(file, "").name == "/"
        with pytest.raises(ArchiveError, match="found no"):
            find_part(file, "/entry/../etc")
