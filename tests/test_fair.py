"""RO-Crates: what is in them, what is said of it, and that the archive comes back out of them."""

import csv
import hashlib
import json
import re
import shutil
import tomllib
from datetime import datetime
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote
from zipfile import ZipFile

import jsonschema
import pytest
from crate_validation import LATER_NAMES, datacite_errors, graph_of, issues, without_network
from folders import DISC_IDS, SAMPLE_IDS, SAMPLES, set_key, tree_bytes

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.base.units import KINDS
from tribopipe.documents.annotation import Annotation
from tribopipe.documents.dataset import NOTHING_SAID, Dataset
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml, read_document
from tribopipe.extras.fair.export import choose, export_crate
from tribopipe.extras.fair.restore import restore
from tribopipe.extras.fair.root import datacite
from tribopipe.extras.fair.vocabulary import TERMS, UNITS
from tribopipe.pipeline.stages import ingest
from tribopipe.pipeline.studies import load_studies, run_study

RUN, AMENDED = "si3n4-air-200mN", "si3n4-air-400mN"
TITLES = ("as it was", "later", "<script>alert(1)</script>")
NOTE = "the disc rang </script><img src=x>"
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
def exported(_processed, short_runs, tmp_path_factory) -> Path:
    """A folder with an archive, a dataset.toml beside it, and a crate and a .eln of it; not to be written into.

    Of its two runs one is processed and has a note, the other one was amended twice.
    """
    folder = tmp_path_factory.mktemp("fair")
    archive = Archive(Path(shutil.copytree(_processed, folder / "archive")))
    archive.annotate(RUN, Annotation(kind="note", text=NOTE, date="2026-08-05T12:00:00+00:00", operator="anna"))
    amended = Path(shutil.copytree(short_runs / AMENDED, folder / AMENDED))
    for title in TITLES:
        set_key(amended, "title", f'"{title}"')
        ingest(amended, archive, amend=True)
    said = folder / "dataset.toml"
    said.write_text(DATASET, encoding="utf-8")
    dataset, document = load_toml(said, Dataset), said.read_bytes()
    for name, eln in (("crate", False), ("runs.eln", True)):
        export_crate(
            archive, choose(archive, ()), folder / name, eln=eln, dataset=dataset, document=document, reports=False
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
    assert set(files) == there - {"ro-crate-metadata.json", "ro-crate-preview.html"}
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


def test_what_run_toml_said_before_it_was_amended_is_in_it(exported, crate, graph):
    earlier = Archive(exported / "archive").earlier_manifests(AMENDED)
    names = [f"runs/{AMENDED}/earlier/run.earlier-{number}.toml" for number in (1, 2)]
    for one, name, title in zip(earlier, names, TITLES, strict=False):
        assert (crate / name).read_bytes() == one.source.content
        assert f'title = "{title}"'.encode() in one.source.content
    history = json.loads((crate / f"runs/{AMENDED}/history.json").read_text(encoding="utf-8"))
    assert [(one["date"], one["raw_sha256"]) for one in history["amended"]] == [
        (one.date, one.raw_sha256) for one in earlier
    ]
    for number, (before, after) in enumerate(pairwise([*names, f"runs/{AMENDED}/source/run.toml"]), start=1):
        action = graph[f"#{AMENDED}/amend/{number}"]
        assert (action["object"], action["result"]) == ({"@id": before}, {"@id": after})
        assert action["description"] == "title changed"


@pytest.mark.slow
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
    k_d = rows["wear_fit_archard.bodies.pin.wear_coefficient", "m^2/N"]
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
    told = graph[f"#{RUN}/wear_fit_archard.bodies.pin.wear_coefficient"]
    assert told["value"] == fit.first.wear_coefficient.value
    assert told["unitCode"] == "http://qudt.org/vocab/unit/M2-PER-N"
    assert (told["minValue"], told["maxValue"]) == tuple(end.value for end in fit.first.interval)
    assert graph[told["valueReference"]["@id"]]["value"] == fit.first.wear_coefficient.standard_uncertainty


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


@pytest.mark.slow
@pytest.mark.usefixtures("archive")
def test_without_dataset_toml_it_is_told_what_is_lacking(tmp_path, run_cli):
    (tmp_path / "out.zip").write_bytes(b"mine")
    refused = run_cli("export", "--ro-crate", "out.zip", RUN, "--no-report", cwd=tmp_path)
    assert refused.exit_code == 1
    assert (tmp_path / "out.zip").read_bytes() == b"mine"
    done = run_cli("export", "--ro-crate", "out.zip", RUN, "--no-report", "--force", cwd=tmp_path)
    assert done.exit_code == 0
    assert done.stderr == (
        "1 run written to out.zip\nnote: repositories require title, description, licence, creators; add this to "
        "dataset.toml next to the archive\n"
    )
    graph = graph_of(tmp_path / "out.zip")
    assert graph["./"]["license"] == {"@id": "#no-licence"}
    assert "creator" not in graph["./"]
    new = Archive(tmp_path / "lab" / "archive")
    assert list(restore(tmp_path / "out.zip", new).done.values()) == ["added"]
    assert new.path(RUN).read_bytes() == (tmp_path / f"archive/{RUN}.h5").read_bytes()


# --- for people ---


@pytest.fixture(scope="module")
def page(crate):
    """The preview of a crate as a browser reads it."""
    from lxml import html

    return html.document_fromstring((crate / "ro-crate-preview.html").read_text(encoding="utf-8"))


def test_preview_tells_what_the_data_are_and_whose(page):
    text = " ".join(page.text_content().split())
    assert page.findtext(".//h1") == "Wear of silicon nitride"
    assert re.search(r"Carberry, Josiah; Somebody \(\d{4}\): Wear of silicon nitride. Version 1.0. Zenodo", text)
    assert all(one in text for one in (RUN, AMENDED, "Brown University", "CC-BY-4.0", "SFB 499"))
    assert all(one in text for one in ("Young's modulus", "kD = (", NOTE, TITLES[-1]))


def test_preview_links_to_every_file_and_to_nothing_that_is_not_there(page, crate):
    links = {link for link in page.xpath("//a/@href") if not link.startswith("#")}
    there = {path.relative_to(crate).as_posix() for path in crate.rglob("*") if path.is_file()}
    inside = {unquote(link) for link in links if not link.startswith("https://")}
    assert inside == there - {"ro-crate-metadata.json", "ro-crate-preview.html"}
    assert {f"#{one}" for one in page.xpath("//@id")} >= {*page.xpath("//nav//a/@href")}


def test_preview_holds_the_metadata_and_neither_runs_nor_loads_anything(page, crate):
    (script,) = page.xpath("//script")
    assert script.get("type") == "application/ld+json"
    assert json.loads(script.text) == json.loads((crate / "ro-crate-metadata.json").read_text(encoding="utf-8"))
    assert page.xpath("//*[@src] | //link | //img | //iframe | //@*[starts-with(name(), 'on')]") == []
    assert page.xpath("//meta[@http-equiv='Content-Security-Policy']/@content")[0].startswith("default-src 'none'")
    assert b"\n<script>" not in (crate / "ro-crate-preview.html").read_bytes()


@pytest.mark.slow
def test_each_run_has_its_report(archive, tmp_path):
    store = Archive(archive)
    (tmp_path / "out").write_bytes(b"a file, which is replaced")
    export_crate(store, choose(store, ()), tmp_path / "out")
    page = (tmp_path / f"out/runs/{RUN}/report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    assert {"@id": f"runs/{RUN}/report.html"} in graph_of(tmp_path / "out")[f"runs/{RUN}/"]["hasPart"]


# --- .eln: each rule of its specification, and what eLabFTW reads ---


@pytest.fixture(scope="module")
def notebook(exported) -> dict[str, dict]:
    return graph_of(exported / "runs.eln")


def test_eln_is_one_folder_of_its_name_with_the_metadata_first(exported):
    with ZipFile(exported / "runs.eln") as packed:
        assert packed.testzip() is None
        names = packed.namelist()
    assert {name.partition("/")[0] for name in names} == {"runs"}
    assert names[0] == "runs/ro-crate-metadata.json"


def test_eln_says_which_program_wrote_it(notebook):
    metadata = notebook["ro-crate-metadata.json"]
    assert metadata["@type"] == "CreativeWork"
    assert metadata["about"] == {"@id": "./"}
    assert metadata["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert metadata["version"]
    assert datetime.fromisoformat(metadata["dateCreated"])
    publisher = notebook[metadata["sdPublisher"]["@id"]]
    assert (publisher["@type"], publisher["name"]) == ("Organization", "tribopipe")


def test_eln_lists_each_run_as_a_folder_of_files(exported, notebook):
    with ZipFile(exported / "runs.eln") as packed:
        sizes = {entry.filename: entry.file_size for entry in packed.infolist()}
    for part in notebook["./"]["hasPart"]:
        folder = notebook[part["@id"]]
        assert folder["@type"] == "Dataset"
        assert folder["name"]
        assert notebook[folder["author"]["@id"]]["@type"] == "Person"
        for one in folder["hasPart"]:
            file = notebook[one["@id"]]
            assert file["@type"] == "File"
            assert file["name"]
            assert file["encodingFormat"]
            assert file["contentSize"] == str(sizes[f"runs/{unquote(file['@id'])}"])


def test_eln_has_a_page_for_each_run(notebook):
    run = notebook[f"runs/{RUN}/"]
    assert run["name"].startswith(f"{RUN}: ")
    assert run["genre"] == "experiment"
    text = run["text"].replace("\u00a0", " ")
    assert "<td>normal load</td><td>200.0 ± 2.0 mN</td>" in text
    assert "×10⁻⁸ mm³/(N·mm)" in text
    assert "<img" not in run["text"]
    assert all(notebook[one["@id"]]["propertyID"] for one in run["variableMeasured"])


def test_eln_keeps_to_the_types_of_the_consortiums_schema(notebook):
    for entity in notebook.values():
        assert all(isinstance(entity.get(name, ""), str) for name in ("keywords", "genre", "name", "identifier", "url"))
        assert all(isinstance(entity.get(name, []), list) for name in ("hasPart", "comment"))
        assert all(isinstance(entity.get(name, {}), dict) for name in ("author", "conformsTo", "about", "sdPublisher"))
        for name in ("dateCreated", "dateModified"):
            assert name not in entity or datetime.fromisoformat(entity[name]).tzinfo


def test_eln_has_notes_as_comments(notebook):
    comment = notebook[notebook[f"runs/{RUN}/"]["comment"][0]["@id"]]
    assert (comment["@type"], comment["text"]) == ("Comment", NOTE)
    assert notebook[comment["author"]["@id"]]["name"] == "anna"


# --- the way back ---


@pytest.mark.parametrize("name", ["crate", "runs.eln"])
def test_archive_comes_back_byte_for_byte(exported, tmp_path, name):
    old, new = Archive(exported / "archive"), Archive(tmp_path / "lab" / "archive")
    restored = restore(exported / name, new)
    assert list(restored.done.values()) == ["added", "added"]
    assert restored.dataset == tmp_path / "lab" / "dataset.toml"
    assert restored.dataset.read_text(encoding="utf-8") == DATASET
    for run_id in old.ids():
        assert new.path(run_id).read_bytes() == old.path(run_id).read_bytes()
    assert new.earlier_manifests(AMENDED) == old.earlier_manifests(AMENDED)
    again = restore(exported / name, new)
    assert list(again.done.values()) == ["unchanged", "unchanged"]
    assert again.dataset is None


@pytest.mark.usefixtures("archive")
def test_another_run_of_the_same_id_stays(exported, tmp_path, run_cli):
    """The one in the archive has no note; the crate's other run gets in."""
    before = (tmp_path / f"archive/{RUN}.h5").read_bytes()
    done = run_cli("import", exported / "crate", "--json", cwd=tmp_path)
    assert done.exit_code == 3
    assert f"{AMENDED}: run archived\n" in done.stderr
    assert "found a different file with this name" in done.stderr
    assert (tmp_path / f"archive/{RUN}.h5").read_bytes() == before
    assert [(one["id"], one["status"]) for one in json.loads(done.stdout)["files"]] == [
        (AMENDED, "added"),
        (RUN, "failed"),
    ]


# --- what is refused ---


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["--ro-crate", "out", "nobody"], "found neither a run nor a study 'nobody'"),
        (["--eln", "out.zip"], "expected a file name that ends in .eln"),
        (["--ro-crate", "a", "--eln", "b.eln"], "specify the file to write"),
        (["--ro-crate", "archive"], "archive: found an existing folder; expected a folder that does not exist"),
        (["--ro-crate", "out", "--dataset", "none.toml"], "none.toml"),
        (["--ro-crate", "out", "--archive", "elsewhere"], "found no archive in this folder"),
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


def test_damaged_run_is_not_published(archive, tmp_path, run_cli):
    path = archive / f"{RUN}.h5"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    done = run_cli("export", "--ro-crate", "out", "--no-report", cwd=tmp_path)
    assert done.exit_code == 1
    assert f"{Path('archive', RUN)}.h5: found a damaged file" in done.stderr
    assert ".part" not in done.stderr
    assert not (tmp_path / "out").exists()


# --- validators ---


@pytest.mark.slow
@pytest.mark.parametrize("profile", ["ro-crate-1.1", "process-run-crate"])
def test_validator_finds_nothing_wrong(exported, monkeypatch, profile, tmp_path):
    without_network(monkeypatch)
    with ZipFile(exported / "runs.eln") as packed:
        packed.extractall(tmp_path)
    archive = Archive(exported / "archive")
    export_crate(archive, choose(archive, ()), tmp_path / "bare.zip")
    for path in (exported / "crate", tmp_path / "bare.zip", tmp_path / "runs"):
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
@pytest.mark.parametrize(
    "document",
    [
        "",
        DATASET,
        DATASET.replace('"Zenodo"', '{ name = "KIT", ror = "04t3en479" }\ndoi = "10.5281/zenodo.5720626"'),
        DATASET.replace('"DFG"', '{ name = "DFG", ror = "https://ror.org/018mejw64" }').replace("award", "title"),
    ],
)
def test_datacite_validator_finds_nothing_wrong(document):
    dataset = read_document(tomllib.loads(document), Dataset, where="dataset.toml") if document else NOTHING_SAID
    fields = datacite(dataset, title="Wear", description="Tests.", keywords=["wear"], published="2026-08-05")
    assert datacite_errors(fields) == []
    assert datacite_errors({**fields, "creators": [{}], "colour": "red"})


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_pin_on_disc_samples_and_studies_go_there_and_back(sample_archive, tmp_path):
    assert there_and_back(sample_archive, ["si3n4-air", "wc-co-water"], tmp_path) == len(SAMPLE_IDS) + 2


@pytest.mark.slow
@pytest.mark.usefixtures("few_draws")
def test_twin_disc_samples_and_their_study_go_there_and_back(disc_archive, tmp_path):
    assert there_and_back(disc_archive, ["si3n4-twin-disc"], tmp_path) == len(DISC_IDS) + 1


def there_and_back(samples: Archive, studies: list[str], folder: Path) -> int:
    """Put an archive with studies through a .eln file; count the files that came back byte for byte."""
    old, new = Archive(Path(shutil.copytree(samples.folder, folder / "old"))), Archive(folder / "new" / "archive")
    for study in load_studies([SAMPLES / f"{name}.study.toml" for name in studies]):
        list(run_study(old, study, Recipe()))
    export_crate(old, choose(old, ()), folder / "samples.eln", eln=True, reports=False)
    assert restore(folder / "samples.eln", new).failed == {}
    wanted = {name: content for name, content in tree_bytes(old.folder).items() if name.endswith(".h5")}
    assert {name: content for name, content in tree_bytes(new.folder).items() if name.endswith(".h5")} == wanted
    return len(wanted)


def test_archive_without_runs_is_told(tmp_path):
    (tmp_path / "archive").mkdir()
    with pytest.raises(ArchiveError, match="found no runs"):
        choose(Archive(tmp_path / "archive"), ())
