"""What the server of the pages answers, of good archives and of spoilt ones, and the command that starts it."""

import csv
import hashlib
import io
import json
import re
import shutil
import subprocess
import sys
import time

import h5py
import pytest
from browse_client import serving
from study_runs import HEAVY, LIGHT

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.browse import app
from tribopipe.browse.answers import _finding, sparkline_answer
from tribopipe.browse.server import listening
from tribopipe.documents.annotation import Mark
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.study import Study
from tribopipe.pipeline.studies import run_study
from tribopipe.results.evaluation import DriftCorrection
from tribopipe.results.finding import Finding

RUN = "si3n4-air-200mN"
pytestmark = pytest.mark.usefixtures("few_draws")


@pytest.fixture
def client(archive):
    """A server of an archive to do anything with."""
    with serving(archive) as client:
        yield client


@pytest.fixture(scope="module")
def lasting(_processed, tmp_path_factory):
    """An archive not to be written into, and its server."""
    folder = tmp_path_factory.mktemp("lasting") / "archive"
    shutil.copytree(_processed, folder)
    with serving(folder) as client:
        yield folder, client


@pytest.fixture
def reader(lasting):
    return lasting[1]


def test_a_small_curve_goes_from_start_to_end_of_the_wear(lasting):
    archive, client = lasting
    told = client.get("api", "runs", RUN, "sparkline").json
    assert told["name"] == "pin wear depth / µm"
    assert 16 <= len(told["x"]) == len(told["y"]) <= 128
    end = Archive(archive).result(RUN, "drift_correction", DriftCorrection).end_wear_depth
    assert told["y"][-1] == pytest.approx(end.value * 1e6, abs=1.0)
    assert abs(told["y"][0]) < 1.0


@pytest.mark.parametrize("left", [None, b"\x89HDF no more"])
def test_a_run_gone_or_damaged_has_no_small_curve(archive, client, left):
    assert client.get("api", "runs", RUN, "sparkline").json["x"]
    (archive / f"{RUN}.h5").unlink()
    if left is not None:
        (archive / f"{RUN}.h5").write_bytes(left)
    answer = client.get("api", "runs", RUN, "sparkline")
    assert (answer.status, answer.json) == (200, {"name": "", "x": [], "y": []})


def test_a_run_without_plots_has_no_small_curve():
    assert sparkline_answer([]) == {"name": "", "x": [], "y": []}


def test_the_archive_says_what_it_is(lasting):
    archive, client = lasting
    told = client.get("api", "archive").json
    assert (told["name"], told["folder"]) == (archive.name, str(archive.resolve()))
    assert (told["runs"], told["studies"], told["unreadable"]) == (1, 0, [])
    assert told["revision"] == client.get("api", "revision").json["revision"]
    columns = {column["name"]: column for column in told["columns"]}
    assert columns["load"]["unit"] == "mN"
    assert {"name", "label", "unit", "help", "kind", "shown", "joint"} == set(columns["id"])
    units = {name: (columns[name]["factor"], columns[name]["offset"]) for name in ("load", "temperature", "k_d")}
    assert units == {"load": (1e3, 0), "temperature": (1, -273.15), "k_d": (1e6, 0)}


def test_the_list_has_every_column_of_every_run(reader):
    runs = reader.get("api", "runs").json
    assert runs["ids"] == [RUN]
    row = dict(zip(runs["columns"], runs["rows"][0], strict=True))
    assert row["id"] == RUN
    assert row["load"] == [0.2, "200.0 ± 2.0", 0.002]
    assert len(row["findings"]) == 2  # a count has no uncertainty
    assert row["k_d"][0] == pytest.approx(13.5e-15, rel=0.2)
    assert "±" in row["k_d"][1]
    assert None in row.values()
    k_d = runs["aligned"]["k_d"]
    assert re.fullmatch(r"10⁻⁹ mm³/\(N·mm\)", k_d["unit"])
    assert [float(text.partition(" ± ")[0]) for text in k_d["texts"]] == [pytest.approx(row["k_d"][0] * 1e15, rel=1e-3)]
    assert "load" not in runs["aligned"]


def test_a_part_of_the_list_is_searched_and_sorted_by_the_server(archive, client):
    for name in ("a2", "a10"):
        shutil.copy(archive / f"{RUN}.h5", archive / f"{name}.h5")
    part = client.get("api", "runs", sort="-id", start=1, most=1).json
    assert (part["total"], part["start"], part["ids"], part["aligned"]) == (3, 1, ["a10"], {})
    whole = client.get("api", "runs", most=3).json
    assert (whole["total"], whole["start"], whole["ids"]) == (3, 0, ["a2", "a10", RUN])
    assert "k_d" in whole["aligned"]
    found = client.get("api", "runs", search="A1 200.0", columns="id,load", most=2).json
    assert (found["total"], found["ids"]) == (1, ["a10"])
    for asked in ({"sort": "lod"}, {"search": "x", "columns": "lod"}):
        assert "did you mean 'load'?" in client.get("api", "runs", **asked).error
    assert client.get("api", "runs", most=0).status == 400
    assert client.get("api", "values", "material").json == ["Si3N4"]
    assert client.get("api", "values", "id", begins="A").json == ["a2", "a10"]
    assert client.get("api", "values", "load").json == []
    assert client.get("api", "values", "lod").status == 400


def test_a_choice_of_runs_is_made_by_the_server(reader):
    assert reader.get("api", "runs", where="load>100mN").json["ids"] == [RUN]
    assert reader.get("api", "runs", where="load>1N").json["ids"] == []
    answer = reader.get("api", "runs", where="lod>1N")
    assert answer.status == 400
    assert "'lod'" in answer.error
    assert reader.get("api", "runs", where="x" * 5000).status == 400


def test_the_list_can_be_saved(reader):
    answer = reader.get("api", "runs.csv", where="load>100mN")
    assert answer.headers["content-disposition"].startswith('attachment; filename="runs.csv"')
    rows = list(csv.reader(io.StringIO(answer.body.decode("utf-8-sig"))))
    assert RUN in rows[1]
    assert reader.get("api", "runs.csv", where="?").status == 400


def test_a_run_tells_all_that_is_known_of_it(reader):
    run = reader.get("api", "runs", RUN).json
    assert (run["id"], run["file"], run["bad"]) == (RUN, f"{RUN}.h5", None)
    assert [stage["name"] for stage in run["stages"]][:3] == ["clean_up", "drift_correction", "friction_fit"]
    assert all(stage["options"] is not None and stage["path"] == f"/entry/{stage['name']}" for stage in run["stages"])
    assert [plot["name"] for plot in run["plots"]] == ["wear", "depth", "friction", "coefficient", "signals"]
    assert run["plots"][0]["axes"][0] == {"name": "sliding_distance", "label": "sliding distance s / m"}
    assert [source["name"] for source in run["sources"]] == ["run.toml", "signals.csv"]


def test_sources_come_back_byte_for_byte(reader):
    for source in reader.get("api", "runs", RUN).json["sources"]:
        body = reader.get("api", "runs", RUN, "sources", str(source["number"])).body
        assert (len(body), hashlib.sha256(body).hexdigest()) == (source["size"], source["sha256"])
    for number in ("2", "-1", "99999999999999999999"):
        assert reader.get("api", "runs", RUN, "sources", number).status == 404
    assert reader.get("api", "runs", RUN, "sources", "run.toml").status == 400


def test_the_file_itself_can_be_saved(lasting):
    archive, client = lasting
    answer = client.get("api", "runs", RUN, "file")
    assert answer.body == (archive / f"{RUN}.h5").read_bytes()
    assert f'filename="{RUN}.h5"' in answer.headers["content-disposition"]


def test_columns_can_be_saved(reader):
    answer = reader.get("api", "runs", RUN, "csv", "wear")
    assert answer.headers["content-type"] == "text/csv; charset=utf-8"
    assert len(answer.body.splitlines()) == 1252
    refused = reader.get("api", "runs", RUN, "csv", "weather")
    assert refused.status == 422
    assert "weather" in refused.error


@pytest.mark.slow
def test_a_report_is_a_page_of_its_own(reader):
    answer = reader.get("api", "runs", RUN, "report")
    assert answer.headers["content-type"].startswith("text/html")
    assert b"<svg" in answer.body


@pytest.mark.slow
def test_the_revision_follows_the_archive(client, archive):
    before = client.get("api", "revision").json["revision"]
    assert client.get("api", "revision").json["revision"] == before
    Archive(archive).mark(RUN, Mark(kind="bad", reason="chipped", date="2026-01-01T00:00:00+00:00", operator=None))
    after = client.get("api", "revision").json["revision"]
    assert after != before
    assert client.get("api", "runs", RUN).json["bad"] == "chipped"
    runs = client.get("api", "runs").json
    assert runs["revision"] == after
    assert "bad" in runs["rows"][0]


def test_a_run_that_goes_away_is_a_sentence(client, archive):
    assert client.get("api", "runs", RUN, "plots", "wear").status == 200
    (archive / f"{RUN}.h5").unlink()
    for tail in ((), ("plots", "wear"), ("file",), ("sources", "0"), ("csv", "wear"), ("report",)):
        answer = client.get("api", "runs", RUN, *tail)
        assert answer.status == 404
        assert f"found no '{RUN}.h5'" in answer.error
    assert client.get("h5", "meta", file=f"{RUN}.h5").status == 404
    assert client.get("api", "runs").json["ids"] == []


def test_damaged_files_are_named_and_all_else_works(client, archive):
    whole = (archive / f"{RUN}.h5").read_bytes()
    (archive / "torn.h5").write_bytes(whole[: len(whole) // 2])
    (archive / "no-hdf5.h5").write_bytes(b"<script>alert(1)</script>")
    (archive / "empty.h5").touch()
    (archive / "studies").mkdir(exist_ok=True)
    (archive / "studies" / "torn.h5").write_bytes(b"torn")
    with h5py.File(archive / "other.h5", "w") as file:
        file["a"] = 1
    told = client.get("api", "archive").json
    named = [entry["file"] for entry in told["unreadable"]]
    assert {"torn.h5", "no-hdf5.h5", "empty.h5", "other.h5", "studies/torn.h5"} == set(named)
    assert client.get("api", "runs").json["ids"] == [RUN]
    for name in ("torn", "no-hdf5", "empty", "other"):
        answer = client.get("api", "runs", name)
        assert answer.status == 422
        assert f"{name}.h5: found" in answer.error
    assert client.get("api", "studies").json == []
    assert client.get("api", "studies", "torn").status == 422
    assert client.get("h5", "meta", file="torn.h5").status == 422
    assert client.get("api", "runs", RUN, "plots", "wear").status == 200


@pytest.mark.parametrize(
    "name",
    [
        "nobody",
        "a'b",
        'a"b',
        "a/b",
        "a\\b",
        "%",
        "%2e%2e",
        "..",
        "../x",
        "µ☃",
        "<script>",
        "a?b#c",
        " ",
        "con",
        "a" * 5000,
    ],
)
def test_an_odd_id_is_a_sentence(reader, name):
    for kind in ("runs", "studies"):
        answer = reader.get("api", kind, name)
        assert answer.status == 404
        assert "expected" in answer.error


@pytest.mark.slow
def test_a_file_of_an_odd_name_is_a_run_like_others(client, archive):
    names = ["it's", "50 % off", "µ☃", "a;b=c&d", "#1"]
    for name in names:
        shutil.copy(archive / f"{RUN}.h5", archive / f"{name}.h5")
    assert set(client.get("api", "runs").json["ids"]) == {RUN, *names}
    for name in names:
        run = client.get("api", "runs", name).json
        assert (run["id"], run["file"]) == (name, f"{name}.h5")
        assert client.get("api", "runs", name, "plots", "wear").status == 200
        assert client.get("api", "runs", name, "file").status == 200
        assert client.get("h5", "meta", file=run["file"]).status == 200


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such names")
def test_a_name_that_is_no_text_spoils_nothing(client, archive):
    shutil.copy(archive / f"{RUN}.h5", archive / "b\udcff.h5")
    for target in ("/api/archive", "/api/runs", "/api/revision"):
        answer = client.send(target)
        assert answer.status == 200
        json.loads(answer.body)


def test_no_such_plot_is_a_sentence(reader):
    answer = reader.get("api", "runs", RUN, "plots", "budget")
    assert answer.status == 404
    assert "expected one of these: wear, depth, friction, coefficient, signals" in answer.error


def test_unknown_addresses_of_the_server_are_no_pages(reader):
    for target in ("/api", "/api/", "/api/nothing", "/h5", "/h5/", "/h5/nothing", f"/api/runs/{RUN}/"):
        answer = reader.send(target)
        assert (answer.status, answer.headers["content-type"]) == (404, "application/json")


def test_an_empty_archive_is_an_answer(tmp_path):
    with serving(tmp_path) as client:
        assert client.get("api", "archive").json["runs"] == 0
        assert client.get("api", "runs").json["rows"] == []
        assert client.get("api", "studies").json == []
        assert client.get("api", "revision").status == 200


def test_without_the_bundle_a_page_says_how_to_build_it(reader, tmp_path, monkeypatch):
    monkeypatch.setattr(app, "BUNDLE", tmp_path)
    assert "npm ci && npm run build" in reader.send("/").error


@pytest.fixture
def pin_study(filled, tmp_path):
    """An archive with a study of two pins."""
    folder = tmp_path / "pins"
    folder.mkdir()
    for run_id in (LIGHT, HEAVY):
        shutil.copy(filled / f"{run_id}.h5", folder)
    list(run_study(Archive(folder), Study(id="pair", fit=(LIGHT,), predict=(HEAVY,)), Recipe()))
    return folder


@pytest.fixture
def disc_study(disc_archive, tmp_path):
    """An archive with a study of two runs of discs."""
    folder = tmp_path / "discs"
    folder.mkdir()
    shorter, longer = "si3n4-twin-disc-4pct-100k", "si3n4-twin-disc-4pct-250k"
    for run_id in (shorter, longer):
        shutil.copy(disc_archive.path(run_id), folder)
    list(run_study(Archive(folder), Study(id="discs", fit=(shorter,), predict=(longer,), laws=("archard",)), Recipe()))
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pin_study", "disc_study"])
def test_a_study_is_a_page_with_plots(kind, request):
    archive = request.getfixturevalue(kind)
    with serving(archive) as client:
        (line,) = client.get("api", "studies").json
        predicted = re.findall(r"(\d+) ", line["agreement"].partition("; ")[0])
        assert line["agreement"].startswith("Archard: ")
        assert sum(map(int, predicted)) == len(line["predicted"])
        study = client.get("api", "studies", line["id"]).json
        assert study["file"] == f"studies/{line['id']}.h5"
        assert client.get("api", "studies", line["id"], "file").body == (archive / study["file"]).read_bytes()
        assert (study["fitted"], study["predicted"]) == (line["fitted"], line["predicted"])
        for offer in study["plots"]:
            plot = client.get("api", "studies", line["id"], "plots", offer["name"]).json
            assert all(panel["lines"] for panel in plot["panels"])
            if offer["name"].startswith("wear"):
                assert all(panel["marks"] for panel in plot["panels"])
                assert all(one["value"].endswith("(± u)") for panel in plot["panels"] for one in panel["marks"])
                below = [panel["label"] for panel in plot["panels"] if panel["label"].endswith("measured / predicted")]
                assert len(below) == (2 if kind == "disc_study" else 0)
            with h5py.File(archive / study["file"]) as file:
                assert offer["path"] in file
                assert all(one["path"] in file for panel in plot["panels"] for one in panel["lines"] if one["path"])
        assert client.get("api", "studies", line["id"], "plots", "nothing").status == 404
        assert client.get("api", "studies", line["id"], "report").status == 200
        assert client.get("api", "studies", "nothing").status == 404


def test_the_command_needs_an_archive_and_the_bundle(run_cli, archive, tmp_path, monkeypatch):
    monkeypatch.setattr(app, "BUNDLE", tmp_path)
    missing = run_cli("browse", "--archive", tmp_path / "nowhere")
    assert (missing.exit_code, missing.stderr.count("\n")) == (1, 1)
    assert "found no archive in this folder" in missing.stderr
    unbuilt = run_cli("browse", "--archive", archive)
    assert (unbuilt.exit_code, unbuilt.stderr.count("\n")) == (1, 1)
    assert "npm ci && npm run build" in unbuilt.stderr


@pytest.mark.slow
def test_the_command_lists_serves_and_says_where(run_cli, archive, tmp_path, monkeypatch):
    (tmp_path / "index.html").write_text("page", encoding="utf-8")
    monkeypatch.setattr(app, "BUNDLE", tmp_path)
    opened, served = [], []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr("uvicorn.Server.run", lambda _, sockets: served.extend(sockets) or time.sleep(0.1))
    for flags in ((), ("--no-browser",)):
        told = run_cli("browse", "--archive", archive, *flags)
        assert told.exit_code == 0
        assert told.stderr.startswith(f"serving {archive} at http://127.0.0.1:")
    assert len(served) == 2
    assert len(opened) == 1
    assert opened[0].startswith("http://127.0.0.1:")


def test_a_taken_port_is_a_sentence():
    with listening(0) as listener:
        port = listener.getsockname()[1]
        with pytest.raises(ArchiveError, match=f"--port {port}: cannot be used .*; expected a free port"):
            listening(port)


def test_help_loads_no_server():
    code = "import sys, tribopipe.cli.app; print({'fastapi', 'uvicorn', 'h5grove', 'h5py'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "set()"


def test_findings_name_the_help_that_explains_them():
    own, other = (
        Finding(severity="note", code=code, where="depth", message="found x", remedy="do y")
        for code in ("reading_settles", "check_of_another_package")
    )
    assert _finding(own) == {"severity": "note", "text": "depth: found x; do y", "help": "reading_settles"}
    assert _finding(other)["help"] is None
