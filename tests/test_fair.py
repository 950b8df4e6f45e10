"""RO-Crates: what is in them, what is said of it, and that the archive comes back out of them."""

import csv
import hashlib
import json
import shutil
from pathlib import Path
from urllib.parse import unquote
from zipfile import ZipFile

import jsonschema
import pytest
from crate_validation import LATER_NAMES, graph_of, issues, without_network

from tribopipe.archive.store import Archive
from tribopipe.errors import ArchiveError
from tribopipe.fair.export import choose, export_crate
from tribopipe.fair.restore import restore
from tribopipe.fair.terms import TERMS, UNITS
from tribopipe.records.base import load_toml
from tribopipe.records.dataset import Dataset
from tribopipe.units import KINDS

RUN = "si3n4-air-200mN"
DATASET = """\
schema = "tribopipe.dataset/1"
title = "Wear of silicon nitride"
description = "Virtual tests."
licence = "CC-BY-4.0"
version = "1.0"
publisher = "Zenodo"
keywords = ["running-in"]

[[creators]]
given_name = "Josiah"
family_name = "Carberry"
orcid = "0000-0002-1825-0097"
affiliation = { name = "Brown University", ror = "https://ror.org/05gq02987" }
operator = ["jc"]

[[creators]]
family_name = "Somebody"

[[instruments]]
name = "virtual micro pin-on-disc tribometer"
manufacturer = "nobody"

[[funding]]
funder = "DFG"
award = "SFB 499"

[[publications]]
doi = "10.1038/s41597-022-01429-9"
"""
VIEWS = {"tables/wear.csv"}
"""Made of several steps for people to look at, so that no single action has it as its result."""


@pytest.fixture(scope="module")
def exported(_processed, tmp_path_factory) -> Path:
    """A folder with an archive, a dataset.toml beside it, and a crate and a .eln of it; not to be written into."""
    folder = tmp_path_factory.mktemp("fair")
    shutil.copytree(_processed, folder / "archive")
    said = folder / "dataset.toml"
    said.write_text(DATASET, encoding="utf-8")
    dataset = load_toml(said, Dataset)
    archive = Archive(folder / "archive")
    for name, eln in (("crate", False), ("crate.zip", False), ("runs.eln", True)):
        export_crate(
            archive,
            choose(archive, ()),
            folder / name,
            eln=eln,
            dataset=dataset,
            document=said.read_bytes(),
            reports=False,
        )
    return folder


@pytest.fixture(scope="module")
def crate(exported) -> Path:
    return exported / "crate"


@pytest.fixture(scope="module")
def graph(crate) -> dict[str, dict]:
    return graph_of(crate)


def of_kind(graph, kind):
    return [entity for entity in graph.values() if entity["@type"] == kind]


# --- what is in a crate ---


def test_every_file_is_described_and_is_what_it_is_said_to_be(crate, graph):
    files = {unquote(one["@id"]): one for one in of_kind(graph, "File")}
    there = {path.relative_to(crate).as_posix() for path in crate.rglob("*") if path.is_file()}
    assert set(files) == there - {"ro-crate-metadata.json"}
    for name, said in files.items():
        content = (crate / name).read_bytes()
        assert said["contentSize"] == str(len(content))
        assert said["sha256"] == hashlib.sha256(content).hexdigest()
        assert said["name"] == Path(name).name
        assert said["encodingFormat"]
        assert said["description"]


def test_archive_and_sources_are_in_it_byte_for_byte(exported, crate):
    old = Archive(exported / "archive")
    assert (crate / f"archive/{RUN}.h5").read_bytes() == old.path(RUN).read_bytes()
    for source in old.raw(RUN).sources:
        assert (crate / f"runs/{RUN}/source/{source.name}").read_bytes() == source.content
    assert Archive(crate / "archive").step_names(RUN) == old.step_names(RUN)


def test_every_step_is_there_as_json_that_its_schema_describes(exported, crate, graph):
    old = Archive(exported / "archive")
    for name in old.step_names(RUN):
        path = f"runs/{RUN}/results/{name}.json"
        found = json.loads((crate / path).read_text(encoding="utf-8"))
        schema = json.loads((crate / graph[path]["conformsTo"]["@id"]).read_text(encoding="utf-8"))
        jsonschema.validate(found, schema)
        assert found == old.step(RUN, name).result.model_dump(mode="json", by_alias=True)


def test_codebook_explains_every_column_and_every_number(crate):
    with (crate / "about/codebook.csv").open(encoding="utf-8", newline="") as file:
        rows = {(row["name"], row["unit"]): row for row in csv.DictReader(file)}
    for path in crate.glob("runs/*/tables/*.csv"):
        with path.open(encoding="utf-8", newline="") as file:
            for head in next(csv.reader(file)):
                name, _, unit = head.removesuffix("]").partition(" [")
                assert rows[name, unit]["meaning"], head
                assert rows[name, unit]["UCUM"] == (UNITS[unit].ucum or "")
    k_d = rows["wear_fit_archard.wear_coefficient", "m^2/N"]
    assert k_d["UCUM"] == "m2.N-1"
    assert k_d["QUDT"] == "http://qudt.org/vocab/unit/M2-PER-N"
    assert k_d["TriboDataFAIR"] == ""
    assert rows["conditions.normal_load", "N"]["TriboDataFAIR"].endswith("#NormalLoadSetpoint")


# --- what is said of it ---


def test_root_says_what_repositories_ask_for(graph):
    root = graph["./"]
    assert root["name"] == "Wear of silicon nitride"
    assert root["license"] == {"@id": "https://spdx.org/licenses/CC-BY-4.0"}
    assert (
        root["author"]
        == root["creator"]
        == [
            {"@id": "https://orcid.org/0000-0002-1825-0097"},
            {"@id": "#person/Somebody"},
        ]
    )
    assert graph[graph["https://orcid.org/0000-0002-1825-0097"]["affiliation"]["@id"]]["name"] == "Brown University"
    assert root["citation"] == {"@id": "https://doi.org/10.1038/s41597-022-01429-9"}
    assert root["keywords"].startswith("running-in, tribology, wear")
    assert "Si3N4" in root["keywords"]
    assert graph[root["publisher"]["@id"]]["name"] == "Zenodo"
    assert graph[root["funding"]["@id"]]["identifier"] == "SFB 499"


def test_datacite_has_its_mandatory_fields(crate):
    said = json.loads((crate / "about/datacite.json").read_text(encoding="utf-8"))
    assert said["titles"] == [{"title": "Wear of silicon nitride"}]
    assert said["types"]["resourceTypeGeneral"] == "Dataset"
    assert said["publisher"] == {"name": "Zenodo"}
    assert said["publicationYear"].isdigit()
    assert said["creators"][0]["name"] == "Carberry, Josiah"
    assert said["rightsList"][0]["rightsIdentifier"] == "CC-BY-4.0"


def test_each_result_is_that_of_an_action(crate, graph):
    actions = [*of_kind(graph, "CreateAction"), *of_kind(graph, "Action")]
    made = {one["@id"] for action in actions for one in as_list(action.get("result", []))}
    parts = {f"runs/{RUN}/{name}" for name in ("run.json", "tables/raw.csv", "source/signals.csv", *VIEWS)}
    parts |= {f"runs/{RUN}/results/{name}.json" for name in Archive(crate / "archive").step_names(RUN)}
    assert parts - {f"runs/{RUN}/{name}" for name in VIEWS} <= made
    fit = graph[f"#{RUN}/wear_fit_sarkar"]
    assert graph[fit["instrument"]["@id"]]["name"] == "tribopipe"
    assert graph[fit["instrument"]["@id"]]["softwareVersion"]
    assert {one["@id"] for one in fit["object"]} >= {
        f"runs/{RUN}/tables/raw.csv",
        f"runs/{RUN}/results/friction_fit.json",
    }
    assert fit["endTime"] == Archive(crate / "archive").step(RUN, "wear_fit_sarkar").date
    test = graph[f"#{RUN}/test"]
    assert graph[test["instrument"]["@id"]]["manufacturer"] == "nobody"
    assert test["additionalType"] == TERMS["test"]


def as_list(value):
    return value if isinstance(value, list) else [value]


def test_k_d_is_told_with_unit_uncertainty_and_interval(exported, graph):
    fit = Archive(exported / "archive").step(RUN, "wear_fit_archard").result
    told = graph[f"#{RUN}/wear_fit_archard.wear_coefficient"]
    assert told["value"] == fit.wear_coefficient.value
    assert told["unitCode"] == "http://qudt.org/vocab/unit/M2-PER-N"
    assert (told["minValue"], told["maxValue"]) == tuple(end.value for end in fit.interval)
    assert graph[told["valueReference"]["@id"]]["value"] == fit.wear_coefficient.standard_uncertainty


def test_everything_referred_to_is_there(graph):
    inside = ("#", "runs/", "studies/", "about/", "archive/")
    for entity in graph.values():
        for value in entity.values():
            for one in as_list(value):
                if isinstance(one, dict) and one["@id"].startswith(inside):
                    assert one["@id"] in graph


def test_every_unit_of_ours_has_a_code():
    assert {kind.si for kind in KINDS.values()} <= set(UNITS)


def test_names_beyond_the_vocabulary_are_defined(crate):
    context = json.loads((crate / "ro-crate-metadata.json").read_text(encoding="utf-8"))["@context"]
    assert context[0] == "https://w3id.org/ro/crate/1.1/context"
    assert set(context[1]) == LATER_NAMES


@pytest.mark.usefixtures("archive")
def test_without_dataset_toml_it_is_told_what_is_lacking(tmp_path, run_cli):
    done = run_cli("export", "--ro-crate", "out", RUN, "--no-report", cwd=tmp_path)
    assert done.exit_code == 0
    assert done.stderr == (
        "1 run written to out\nnote: repositories ask for title, description, licence, creators; say it in "
        "dataset.toml beside the archive\n"
    )
    graph = graph_of(tmp_path / "out")
    assert graph["./"]["license"] == {"@id": "#no-licence"}
    assert "creator" not in graph["./"]


@pytest.mark.slow
def test_each_run_has_its_report(archive, tmp_path):
    store = Archive(archive)
    export_crate(store, choose(store, ()), tmp_path / "out")
    page = (tmp_path / f"out/runs/{RUN}/report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert {"@id": f"runs/{RUN}/report.html"} in graph_of(tmp_path / "out")[f"runs/{RUN}/"]["hasPart"]


# --- .eln ---


def test_eln_keeps_the_rules_of_its_specification(exported):
    """Each rule that the specification writes in capitals, and what eLabFTW reads."""
    path = exported / "runs.eln"
    with ZipFile(path) as packed:
        names = packed.namelist()
    assert {name.partition("/")[0] for name in names} == {"runs"}
    assert names[0] == "runs/ro-crate-metadata.json"
    graph = graph_of(path)
    metadata, root = graph["ro-crate-metadata.json"], graph["./"]
    assert metadata["about"] == {"@id": "./"}
    assert metadata["version"]
    assert graph[metadata["sdPublisher"]["@id"]]["@type"] == "Organization"
    assert isinstance(root["author"], dict)
    for part in root["hasPart"]:
        folder = graph[part["@id"]]
        assert folder["@type"] == "Dataset"
        assert folder["name"]
        for file in folder["hasPart"]:
            assert graph[file["@id"]]["@type"] == "File"
            assert f"runs/{unquote(file['@id'])}" in names
            assert graph[file["@id"]]["contentSize"].isdigit()
    run = graph[f"runs/{RUN}/"]
    assert run["genre"] == "experiment"
    assert "<table>" in run["text"]
    assert all(graph[one["@id"]]["propertyID"] for one in run["variableMeasured"])
    assert all(isinstance(entity.get("keywords", ""), str) for entity in graph.values())


@pytest.mark.usefixtures("archive")
def test_notes_are_comments(tmp_path, run_cli):
    assert run_cli("note", RUN, "the disc rang", "--by", "anna", cwd=tmp_path).exit_code == 0
    assert run_cli("export", "--eln=out.eln", "--no-report", cwd=tmp_path).exit_code == 0
    graph = graph_of(tmp_path / "out.eln")
    comment = graph[graph[f"runs/{RUN}/"]["comment"][0]["@id"]]
    assert comment["text"] == "the disc rang"
    assert graph[comment["author"]["@id"]]["name"] == "anna"


# --- the way back ---


@pytest.mark.parametrize("name", ["crate", "crate.zip", "runs.eln"])
def test_archive_comes_back_byte_for_byte(exported, tmp_path, name):
    new = Archive(tmp_path / "lab" / "archive")
    restored = restore(exported / name, new)
    assert list(restored.done.values()) == ["added"]
    assert restored.dataset == tmp_path / "lab" / "dataset.toml"
    assert restored.dataset.read_text(encoding="utf-8") == DATASET
    assert new.path(RUN).read_bytes() == Archive(exported / "archive").path(RUN).read_bytes()
    again = restore(exported / name, new)
    assert list(again.done.values()) == ["unchanged"]
    assert again.dataset is None


def test_import_tells_what_it_did(exported, tmp_path, run_cli):
    first = run_cli("import", exported / "crate.zip", cwd=tmp_path)
    assert first.exit_code == 0
    assert first.stderr.startswith(f"{RUN}: run archived\n")
    second = run_cli("import", exported / "crate.zip", "--json", cwd=tmp_path)
    assert json.loads(second.stdout)["files"] == [{"id": RUN, "kind": "run", "status": "unchanged", "error": None}]


def test_another_run_of_the_same_id_stays(exported, archive, tmp_path, run_cli):
    assert run_cli("tag", RUN, "--add", "mine", cwd=tmp_path).exit_code == 0
    before = (archive / f"{RUN}.h5").read_bytes()
    done = run_cli("import", exported / "crate", cwd=tmp_path)
    assert done.exit_code == 1
    assert "found another file there than the one to be taken in" in done.stderr
    assert (archive / f"{RUN}.h5").read_bytes() == before


# --- what is refused ---


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--ro-crate", "out", "nobody"], "found neither a run nor a study 'nobody'"),
        (["--eln", "out.zip"], "expected a name that ends in .eln"),
        (["--ro-crate", "a", "--eln", "b.eln"], "say what to write"),
        (["--ro-crate", "archive"], "archive: found a folder there already"),
        (["--ro-crate", "out", "--dataset", "none.toml"], "none.toml"),
        (["--ro-crate", "out", "--archive", "elsewhere"], "found no archive there"),
    ],
)
@pytest.mark.usefixtures("archive")
def test_mistake_on_the_command_line_is_told(tmp_path, run_cli, args, said):
    done = run_cli("export", *args, cwd=tmp_path)
    assert done.exit_code in (1, 2)
    assert said in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("archive")
def test_missing_package_is_named(tmp_path, run_cli, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rocrate.rocrate", None)
    done = run_cli("export", "--ro-crate", "out", cwd=tmp_path)
    assert done.exit_code == 1
    assert 'run `pip install "tribopipe[fair]"`' in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["archive"]


@pytest.mark.usefixtures("archive")
def test_existing_file_is_replaced_with_force_alone(tmp_path, run_cli):
    (tmp_path / "out.zip").write_bytes(b"mine")
    refused = run_cli("export", "--ro-crate", "out.zip", "--no-report", cwd=tmp_path)
    assert refused.exit_code == 1
    assert (tmp_path / "out.zip").read_bytes() == b"mine"
    assert run_cli("export", "--ro-crate", "out.zip", "--no-report", "--force", cwd=tmp_path).exit_code == 0
    assert graph_of(tmp_path / "out.zip")


def test_damaged_run_is_not_published(archive, tmp_path, run_cli):
    path = archive / f"{RUN}.h5"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    done = run_cli("export", "--ro-crate", "out", "--no-report", cwd=tmp_path)
    assert done.exit_code == 1
    assert "found a damaged file" in done.stderr
    assert not (tmp_path / "out").exists()


# --- validators ---


@pytest.mark.slow
@pytest.mark.parametrize("profile", ["ro-crate-1.1", "process-run-crate"])
def test_validator_finds_nothing_wrong(exported, monkeypatch, profile, tmp_path):
    without_network(monkeypatch)
    with ZipFile(exported / "runs.eln") as packed:
        packed.extractall(tmp_path)
    for path in (exported / "crate", exported / "crate.zip", tmp_path / "runs"):
        assert issues(path, profile) == []


@pytest.mark.slow
def test_validator_would_find_what_is_wrong(crate, monkeypatch, tmp_path):
    without_network(monkeypatch)
    broken = Path(shutil.copytree(crate, tmp_path / "crate"))
    (broken / "about/codebook.csv").unlink()
    metadata = broken / "ro-crate-metadata.json"
    text = metadata.read_text(encoding="utf-8")
    metadata.write_text(text.replace('"description": "Virtual tests."', '"unheard_of": ""'), encoding="utf-8")
    assert len(issues(broken, "ro-crate-1.1")) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("which", ["sample_archive", "disc_archive"])
def test_all_samples_and_studies_go_there_and_back(which, request, tmp_path):
    old = request.getfixturevalue(which)
    chosen = choose(old, ())
    export_crate(old, chosen, tmp_path / "samples.eln", eln=True, reports=False)
    new = Archive(tmp_path / "archive")
    restored = restore(tmp_path / "samples.eln", new)
    assert restored.failed == {}
    assert new.ids() == old.ids()
    assert new.study_ids() == old.study_ids()
    for run_id in old.ids():
        assert new.path(run_id).read_bytes() == old.path(run_id).read_bytes()
        assert new.raw_sha256(run_id) == old.raw_sha256(run_id)


def test_archive_without_runs_is_told(tmp_path):
    (tmp_path / "archive").mkdir()
    with pytest.raises(ArchiveError, match="found no runs"):
        choose(Archive(tmp_path / "archive"), ())
