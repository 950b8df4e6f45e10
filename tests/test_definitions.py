"""NeXus application definitions: valid NXDL, in step with what is written, and told from files that break them."""

import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib.resources import as_file, files
from pathlib import Path

import h5py
import numpy as np
import pytest
from archived_files import edited, put, remove
from built_files import archived
from end_value_runs import measured
from folders import DISC_IDS, ROOT, SAMPLE_IDS, SAMPLES
from lxml import etree
from sweeps import others_slow

from tribopipe.archive.definitions.entries import run_definition
from tribopipe.archive.definitions.nxdl import definitions, nxdl_text
from tribopipe.archive.definitions.parts import FieldPart, GroupPart
from tribopipe.archive.formats import STUDY
from tribopipe.archive.store import Archive
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.documents.contact_kinds import SHIPPED, contacts, variants
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.wear.local import LocalOptions
from tribopipe.pipeline.stages import process, wear_archived_locally
from tribopipe.pipeline.studies import run_study
from tribopipe.pipeline.verify.file_findings import Look
from tribopipe.pipeline.verify.nexus import check_nexus, read_tree
from tribopipe.readers import long_runs as means
from tribopipe.readers import long_text
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import SourceFile

SCHEMAS = Path(__file__).parents[1] / "schemas"
PIN, DISC = "si3n4-air-200mN", "si3n4-twin-disc-4pct-100k"
PIN_STUDY, DISC_STUDY = "pins", "discs"
DATE = "2026-07-01T10:00:00+00:00"


# --- the definitions themselves ---


@pytest.mark.parametrize("name", definitions())
def test_committed_definition_is_the_generated_one(name):
    committed = (SCHEMAS / f"{name}.nxdl.xml").read_text(encoding="utf-8")
    assert committed == nxdl_text(definitions()[name]), "run `tribopipe schema export schemas`"


@pytest.mark.parametrize("name", definitions())
def test_definition_is_valid_nxdl(name):
    with as_file(files("nexusformat.definitions") / "nxdl.xsd") as schema:
        etree.XMLSchema(etree.parse(schema)).assertValid(etree.parse(SCHEMAS / f"{name}.nxdl.xml"))


def test_each_contact_has_a_definition_that_requires_its_bodies():
    bodies = {name for kind in contacts().values() for name in kind.body_names}
    required = {
        tribometer: {part.name for part in run_definition(tribometer).entry.members if part.required} & bodies
        for tribometer in (*SHIPPED, None)
    }
    # A pin may be a ball.
    bodies_of = {kind: [set(contact.body_names) for contact in variants(kind)] for kind in contacts()}
    assert required == {kind: set.intersection(*bodies) for kind, bodies in bodies_of.items()} | {None: set()}


def fields(part: GroupPart) -> Iterator[FieldPart]:
    for member in part.members:
        if isinstance(member, GroupPart):
            yield from fields(member)
        elif isinstance(member, FieldPart):
            yield member


@pytest.mark.parametrize("name", definitions())
def test_every_part_is_told_and_every_quantity_has_its_unit(name):
    for field in fields(definitions()[name].entry):
        assert field.doc.strip(), field.name
        assert not field.name.endswith("_errors") or field.units, field.name


# --- files hold what is declared ---


def breaches(path: Path) -> list[str]:
    look = Look(path.name)
    with h5py.File(path) as file:
        check_nexus(read_tree(file, look), look)
    return [f"{finding.where}: {finding.message}" for finding in look.findings]


@pytest.mark.slow
@pytest.mark.parametrize("run_id", SAMPLE_IDS)
def test_samples_hold_what_is_declared_and_no_more(sample_archive, run_id):
    assert breaches(sample_archive.path(run_id)) == []


@pytest.mark.slow
@pytest.mark.parametrize("run_id", DISC_IDS)
def test_twin_disc_samples_hold_what_is_declared_and_no_more(disc_archive, run_id):
    assert breaches(disc_archive.path(run_id)) == []


@pytest.fixture(scope="module")
def kinds(short_runs, tmp_path_factory) -> dict[str, Path]:
    """A file of each kind that an archive may hold."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 200)
        folder = tmp_path_factory.mktemp("kinds")
        contacts_of_pages = runs_of_pages(folder / "pages")
        return {
            **processed_kinds(short_runs, folder / "archive"),
            **other_kinds(short_runs, folder),
            **contacts_of_pages,
        }


def runs_of_pages(folder: Path) -> dict[str, Path]:
    """Process the run folders that the pages of further contacts show."""
    archive, runs = Archive(folder / "archive"), []
    for page in ("reciprocating", "block_on_ring", "four_ball"):
        text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
        for name, content in re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```", text, re.DOTALL):
            file = folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(content, encoding="utf-8")
        runs.append(file.parent)
    outcomes = list(process(runs, archive))
    assert [one.error for one in outcomes if one.status == "failed"] == []
    return {run_id: archive.path(run_id) for run_id in archive.ids()}


def processed_kinds(short_runs: Path, folder: Path) -> dict[str, Path]:
    archive = Archive(folder)
    outcomes = [
        *process([short_runs / PIN, SAMPLES / DISC], archive),
        *run_study(archive, Study(id=PIN_STUDY, fit=(PIN,)), Recipe()),
        *run_study(archive, Study(id=DISC_STUDY, fit=(DISC,)), Recipe()),
    ]
    assert [one.error for one in outcomes if one.status == "failed"] == []
    wear_archived_locally(archive, PIN, "archard", Recipe(), LocalOptions(steps_per_decade=3), at=[1.0, 10.0])
    archive.mark(PIN, Mark(kind="bad", reason="it slipped", date=DATE))
    archive.annotate(DISC, Annotation(kind="tag", text="run-in", date=DATE))
    studies = {name: archive.study_folder / f"{name}.h5" for name in (PIN_STUDY, DISC_STUDY)}
    return {"pin on disc": archive.path(PIN), "twin disc": archive.path(DISC), **studies}


def other_kinds(short_runs: Path, folder: Path) -> dict[str, Path]:
    raw, long, profiled = (Archive(folder / name) for name in ("raw", "long", "profiled"))
    raw.add(read_run(short_runs / PIN))
    with pytest.MonkeyPatch.context() as patch:
        for module, name, value in ((long_text, "LARGE", 0), (long_text, "PIECE", 6000), (means, "MOST", 251)):
            patch.setattr(module, name, value)
        long.add(read_run(short_runs / PIN))
    run = measured("pin_profile", "spherical", 10e-6)
    profiled.add(replace(run, sources=(SourceFile("run.toml", b"id"),)))
    archived(folder / "bare")
    return {
        "raw alone": raw.path(PIN),
        "long": long.path(PIN),
        "profiles": profiled.path(run.id),
        "no contact": folder / "bare" / "bare.h5",
    }


def definition_of(path: Path) -> str:
    with h5py.File(path) as file:
        return file["entry/definition"].asstr()[()]


def names_in(path: Path) -> set[str]:
    with h5py.File(path) as file:
        found: set[str] = set()
        file.visit(found.add)
        return found


@pytest.mark.slow
def test_every_kind_of_file_holds_what_is_declared_and_no_more(kinds):
    assert {"entry/recorded", "entry/raw"} <= names_in(kinds["long"])
    assert "entry/profiles/profile_0" in names_in(kinds["profiles"])
    assert "entry/extra_columns/column_0" in names_in(kinds["no contact"])
    assert {kind: breaches(path) for kind, path in kinds.items()} == {kind: [] for kind in kinds}
    assert {definition_of(kinds[name]) for name in (PIN_STUDY, DISC_STUDY)} == {STUDY}


NOT_WRITTEN = {
    "entry/clean_up/data",
    "entry/earlier_manifests",
    "entry/prediction_archard",
    "entry/prediction_sarkar",
    "entry/local_wear_sarkar",
    "entry/instrument/temperature",
    "entry/instrument/relative_humidity",
}
"""Groups that no file of these kinds has: others have signals to mend and other sensors, are predicted, or amended."""


@pytest.mark.slow
def test_no_group_is_declared_that_is_never_written(kinds):
    written = set().union(*map(names_in, kinds.values()))
    declared = {path for definition in definitions().values() for path in groups(definition.entry, "entry")}
    unwritten = declared - written
    assert {path for path in unwritten if not any(path.startswith(known) for known in NOT_WRITTEN)} == set()


def groups(part: GroupPart, path: str) -> Iterator[str]:
    yield path
    for member in part.members:
        if isinstance(member, GroupPart) and member.name and member.name == member.name.lower():
            yield from groups(member, f"{path}/{member.name}")


# --- NeXus' own validator ---


def nxvalidate(path: Path) -> tuple[int, int, str]:
    """Hold a file against its definition by NeXus' own validator: warnings, errors and all it says."""
    script = Path(sys.executable).with_name("nxvalidate")
    command = [script, "-a", SCHEMAS / f"{definition_of(path)}.nxdl.xml", path]
    printed = subprocess.run(command, capture_output=True, text=True, encoding="utf-8").stdout
    plain = re.sub(r"\x1b\[[0-9;]*m", "", printed)
    counts = [re.search(rf"Total number of {what}: (\d+)", plain) for what in ("warnings", "errors")]
    assert all(counts), printed
    assert "may affect validation" not in plain
    return int(counts[0][1]), int(counts[1][1]), plain


@pytest.mark.slow
def test_validator_of_nexus_finds_nothing(kinds):
    for kind, path in kinds.items():
        warnings, errors, printed = nxvalidate(path)
        assert (warnings, errors) == (0, 0), f"{kind}: {printed}"


def units(path: str, unit: str | None) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        if unit is None:
            del file[path].attrs["units"]
        else:
            file[path].attrs["units"] = unit

    change.__name__ = f"units of {path}: {unit}"
    return change


FOUND_BY_BOTH = [
    remove("entry/identifier_run"),
    remove("entry/disc"),
    remove("entry/source_files/file_0/checksum"),
    remove("entry/raw/sliding_distance"),
    remove("entry/wear_fit_archard/parameters/model"),
    units("entry/raw/depth", None),
    units("entry/conditions/normal_load", None),
    put("entry/pin/properties/shape", "conical"),
    put("entry/friction_fit/parameters/mean", "about 0.5"),
]
FOUND_BY_US = [
    remove("entry/pin"),
    units("entry/raw/depth", "um"),
    units("entry/wear_fit_archard/parameters/pin_wear_coefficient", "mm^3/(N*mm)"),
    put("entry/definition", "NXtribometry_twin_disc"),
    put("entry/definition", "NXtribometry"),
    remove("entry/definition"),
    put("entry/conditions/colour", "grey"),
    put("entry/wear_fit_archard/data/wear_depth_median", np.zeros(3)),
]
"""NXDL has no word on the size of a unit nor for one of two groups; its validator passes over what is not declared."""


def spoiled(change: Callable[[h5py.File], None], whole: Path, folder: Path) -> Path:
    path = Path(shutil.copy(whole, folder))
    with edited(path) as file:
        change(file)
    return path


@pytest.mark.slow
@pytest.mark.parametrize("change", others_slow(FOUND_BY_US, first=3), ids=lambda change: change.__name__)
def test_breach_of_the_definition_is_found_by_verify(archive, tmp_path, change):
    assert breaches(spoiled(change, archive / f"{PIN}.h5", tmp_path)) != []


@pytest.mark.slow
@pytest.mark.parametrize("change", FOUND_BY_BOTH, ids=lambda change: change.__name__)
def test_breach_of_the_definition_is_found_by_verify_and_by_the_validator_of_nexus(archive, tmp_path, change):
    path = spoiled(change, archive / f"{PIN}.h5", tmp_path)
    warnings, errors, printed = nxvalidate(path)
    assert warnings + errors > 0, printed
    assert breaches(path) != []
