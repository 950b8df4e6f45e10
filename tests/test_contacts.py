"""A kind of contact of another package, a pin on a drum, through every command; kinds that are none, or broken."""

import ast
import json
import os
import re
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import TypeVar

import h5py
import numpy as np
import pytest
from browse_client import serving
from conftest import MANIFEST
from example_rig import PLUGIN

import tribopipe
from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.database import FILE_NAME
from tribopipe.archive.definitions.entries import run_definition
from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError, ManifestError
from tribopipe.base.plugins import declared
from tribopipe.documents import contact_kinds
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import contacts
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.pin_on_flat import PinOnDisc
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import read_document
from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario
from tribopipe.evaluation.wear.scenario import given_wear
from tribopipe.physics.hertz import hertz_ellipse, hertz_radius
from tribopipe.readers.draft.blanks import blanks_of
from tribopipe.readers.draft.known_values import sections

Node = TypeVar("Node", bound=ast.AST)
PACKAGE = Path(tribopipe.__file__).parent
CONTACT_FILES = {
    "documents/contact.py": "what a kind declares, and the pin that slides",
    "documents/contact_kinds.py": "the list of kinds",
    "documents/pin_on_flat.py": "pin or ball on a disc or a flat",
    "documents/block_on_ring.py": "block on a ring",
    "documents/four_ball.py": "four balls",
    "documents/twin_disc.py": "two discs",
    "contacts/__init__.py": "package of the wear of each kind",
    "contacts/kinds.py": "choice of the wear of a kind",
    "contacts/wear.py": "what the wear of a kind gives",
    "contacts/surfaces.py": "local surface of each kind",
    "contacts/pin_on_disc.py": "wear of a pin alone",
    "contacts/pin_on_track.py": "wear of a pin and its track",
    "contacts/twin_disc.py": "wear of two discs",
    "evaluation/measurements/kinds.py": "choice of the post-test measurements of a kind",
    "evaluation/measurements/pin_tip.py": "measurements of a pin",
    "evaluation/measurements/disc_track.py": "measurements of the track of a pin",
    "evaluation/measurements/worn_pair.py": "wear of pin and track from measurements of both",
    "evaluation/measurements/pin_on_disc.py": "wear of a pin and its track at the end of a test",
    "evaluation/measurements/twin_disc.py": "measurements of two discs",
    "extras/simulate/__init__.py": "choice of the virtual test of a kind",
    "extras/simulate/pin_on_disc.py": "virtual test of a pin",
    "extras/simulate/twin_disc.py": "virtual test of two discs",
}
"""Modules that are about one kind of contact or its family, or about all of them, and what each one is about."""
SHARED = {
    *("documents/contact.py", "documents/contact_kinds.py", "contacts/__init__.py", "contacts/kinds.py"),
    *("contacts/wear.py", "contacts/surfaces.py", "evaluation/measurements/kinds.py", "extras/simulate/__init__.py"),
}
"""Those of all kinds, which others ask; of ``contact.py`` not for the classes of families."""
OTHER_MEANINGS = [
    ("cli/runs.py", "disc"),  # heading of the column that tells the discs of a pair apart
    ("readers/draft/value_sources.py", "ball"),  # word in the name of a file, as people write it
]
"""Literals that are no name of a body of a contact, though they look like one."""
OWN = ["pin-on-disc", "reciprocating", "block-on-ring", "four-ball", "twin-disc"]
K_D = 13.5e-15
"""m²/N: the truth of the plan."""
PLAN = """\
schema = "tribopipe.plan/1"
[[series]]
title = "Si3N4 on the side of a steel drum"
law = "archard"
medium = "air"
sliding_speed = { value = "400 mm/s", standard_uncertainty = "0.5 %" }
depth_scale = { value = 1, standard_uncertainty = "0.5 %" }
systematic_errors = true
sliding_distance = "200 m"
sensors = { sampling_rate = "2 Hz" }
[series.contact]
kind = "pin-on-drum"
[series.contact.pin]
shape = "spherical"
radius = { value = "3 mm", standard_uncertainty = "0.2 %" }
diameter = "6 mm"
material = "Si3N4"
youngs_modulus = { value = "304 GPa", standard_uncertainty = "2 %" }
poisson_ratio = 0.24
[series.contact.drum]
radius = { value = "20 mm", standard_uncertainty = "0.1 %" }
material = "100Cr6"
youngs_modulus = { value = "210 GPa", standard_uncertainty = "2 %" }
poisson_ratio = 0.3
"""
RUN = """\
[[series.runs]]
id = "drum-NUMBER"
started = 2026-03-0NUMBERT09:30:00+01:00
seed = 4NUMBER
normal_load = { value = "NUMBER N", standard_uncertainty = "1 %" }
wear_coefficient = "13.5e-9 mm^3/(N*mm)"
friction = { amplitude = 0.226, steady_state = 0.496, running_in_distance = "32.877 m" }
zero_offset = "1.8 um"
drift_rate = "-9 nm/min"
disc_wear_depth = { value = "120 nm", standard_uncertainty = "20 nm" }
"""
RECIPE = 'schema = "tribopipe.recipe/1"\n[wear]\nmodels = ["archard"]\n'
SWEEP = """\
schema = "tribopipe.sweep/1"
[predictions]
run = "drum-1"
at = ["200 m"]
[vary.run]
conditions.normal_load = ["0.5 N", "1 N"]
contact.drum.radius = ["10 mm", "20 mm"]
"""


TESTS = """\
schema = "tribopipe.sweep/1"
repeats = 2
[virtual_tests]
plan = "plan.toml"
runs = ["drum-1"]
[vary.series]
contact.drum.radius = ["10 mm"]
"""


@pytest.fixture
def installed(monkeypatch, tmp_path_factory):
    """Install the contact of the example, as far as entry points go; for processes that are started, too."""
    yield declare(monkeypatch, tmp_path_factory.mktemp("site"), "pin-on-drum = pin_on_drum:PinOnDrum")
    monkeypatch.undo()
    forget()


def declare(monkeypatch, site: Path, *entries: str) -> Path:
    """Make a package that declares contacts, beside what is installed, and return where it lies."""
    about = site / "drums-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Name: drums\nVersion: 1\n", encoding="ascii")
    (about / "entry_points.txt").write_text("\n".join(["[tribopipe.contacts]", *entries, ""]), encoding="ascii")
    monkeypatch.setenv("PYTHONPATH", str(PLUGIN), prepend=os.pathsep)
    monkeypatch.setenv("PYTHONPATH", str(site), prepend=os.pathsep)
    for path in (PLUGIN, site):
        monkeypatch.syspath_prepend(str(path))
    forget()
    return site


def forget() -> None:
    """Have what is installed looked for again."""
    declared.cache_clear()
    contact_kinds.ADDED.__dict__.pop("_loaded", None)
    for known in (sections, blanks_of, definitions, run_definition):
        known.cache_clear()


def drum(**changes: object) -> dict:
    """Return the run.toml of a pin on a drum as a document."""
    pin, other = MANIFEST["contact"]["pin"], MANIFEST["contact"]["disc"]
    kind = {"kind": "pin-on-drum", "pin": pin, "drum": {**other, "radius": "20 mm"}}
    return {**MANIFEST, "contact": kind, **changes}


def read(document: dict) -> RunManifest:
    """Read a document as a run.toml."""
    return read_document(document, RunManifest, where="run.toml")


@pytest.mark.usefixtures("installed")
def test_run_toml_names_the_drum_and_goes_there_and_back():
    ends = {"pin_scar_diameter": "600 um", "drum_wear_depth": {"value": "120 nm", "standard_uncertainty": "20 nm"}}
    run = read(drum(end_values=ends))
    assert list(contacts()) == [*OWN, "pin-on-drum"]
    assert list(run.bodies) == ["pin", "drum"]
    assert run.contact.counterbody.radius.value == 0.02
    assert run.end_values.disc_wear_depth.value == pytest.approx(120e-9)
    assert run.conditions.track_radius == run.contact.drum.radius
    again = RunManifest.model_validate_json(run.model_dump_json(by_alias=True))
    assert again == run
    assert type(again.contact) is type(run.contact)
    assert run.model_dump()["contact"]["drum"]["radius"]["value"] == 0.02


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"end_values": {"drum_wear_deph": "1 um"}}, r"end_values\.drum_wear_deph: unknown key; .*'drum_wear_depth'"),
        ({"end_values": {"drum_wear_depth": "-1 um"}}, "drum_wear_depth: found -1 µm; expected zero or more"),
        ({"end_values": {"drum_wear_depth": 3}}, r"end_values\.drum_wear_depth: found the number 3 without a unit"),
        (
            {"end_values": {"drum_wear_depth": "1 um", "disc_wear_depth": "1 um"}},
            "drum_wear_depth: found this key in addition to",
        ),
        ({"end_values": {"flat_disc_wear_depth": "1 um"}}, "found a key that does not apply to pin-on-drum runs"),
        (
            {"conditions": {**MANIFEST["conditions"], "track_radius": "1 mm"}},
            "track_radius: found a track radius in addition to c",
        ),
        (
            {"conditions": {**MANIFEST["conditions"], "slip": "4 %"}},
            "conditions.slip: found a key that does not apply to pin-on-drum runs",
        ),
        (
            {"conditions": {**MANIFEST["conditions"], "weld_load": "4 N"}},
            "weld_load: found a key that does not apply to pin-on-drum runs",
        ),
    ],
)
@pytest.mark.usefixtures("installed")
def test_what_does_not_fit_a_drum_is_refused_in_its_own_names(changes, words):
    with pytest.raises(ManifestError, match=words):
        read(drum(**changes))


@pytest.mark.usefixtures("installed")
def test_keys_of_the_bodies_are_checked_like_those_of_own_kinds():
    document = drum()
    document["contact"] = {**document["contact"], "drum": {**document["contact"]["drum"], "radius": 3}}
    with pytest.raises(ManifestError, match=r"^run\.toml: contact\.drum\.radius: found the number 3 without a unit"):
        read(document)
    document["contact"] = {**drum()["contact"], "drumm": {}}
    with pytest.raises(ManifestError, match=r"^run\.toml: contact\.drumm: unknown key; did you mean 'drum'\?"):
        read(document)
    document["contact"] = {**drum()["contact"], "pin": {**MANIFEST["contact"]["pin"], "shape": "flat"}}
    with pytest.raises(ManifestError, match="found a flat pin, which does not make point contact"):
        read(document)


def test_unknown_kind_is_refused_in_a_sentence_that_names_the_known_ones():
    with pytest.raises(ManifestError) as refused:
        read(drum())
    assert str(refused.value) == (
        "run.toml: contact.kind: found 'pin-on-drum'; expected 'pin-on-disc', 'reciprocating', 'block-on-ring', "
        "'four-ball', 'twin-disc', or a kind from an installed package; did you mean 'pin-on-disc'?"
    )


BROKEN = """\
from typing import ClassVar, Literal

from tribopipe.documents.contact import SlidingPin, Specimen


class OtherKind(SlidingPin):
    kind: Literal["something-else"]


class NoBody(SlidingPin):
    kind: Literal["no-body"]
    body_names: ClassVar[tuple[str, ...]] = ("pin", "drum")


class Taken(SlidingPin):
    kind: Literal["pin-on-disc"]
    disc: Specimen
"""


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("gone = no_such_module:Contact", "contact 'gone' skipped: no_such_module:Contact cannot be loaded"),
        ("no-class = broken_contact:Specimen", "expected a subclass of SlidingPin"),
        ("other-kind = broken_contact:OtherKind", "expected Literal\\['other-kind'\\]"),
        ("no-body = broken_contact:NoBody", "expected two specimens, one of them the pin"),
        ("pin-on-disc = broken_contact:Taken", "the name is used by tribopipe itself"),
    ],
)
def test_contact_that_cannot_be_loaded_is_left_out_with_a_warning(monkeypatch, tmp_path, entry, words):
    (tmp_path / "broken_contact.py").write_text(BROKEN, encoding="ascii")
    try:
        declare(monkeypatch, tmp_path, entry)
        with pytest.warns(UserWarning, match=words):
            assert list(contacts()) == OWN
        assert contacts()["pin-on-disc"] is PinOnDisc
        assert read(MANIFEST).contact.kind == "pin-on-disc"
    finally:
        monkeypatch.undo()
        forget()


@pytest.mark.slow
@pytest.mark.usefixtures("installed")
def test_equivalent_pin_touches_and_wears_as_the_pin_on_the_drum():
    on_drum = read(drum()).contact
    radius, side = on_drum.pin.radius.value, on_drum.drum.radius.value
    equivalent, depth = on_drum.equivalent_pin.radius.value, radius / 1000
    assert equivalent == pytest.approx(radius / (1 + radius / side) ** 0.5, rel=1e-12)
    # Volume and area between the sphere and the cylinder that has come nearer by the depth, by quadrature.
    places = (np.arange(2000) + 0.5) / 2000 * 1.1 * (2 * depth * radius) ** 0.5
    across, along = np.meshgrid(places, places)
    sphere = radius - np.sqrt(radius**2 - across**2 - along**2)
    lost = np.maximum(depth - sphere - (side - np.sqrt(side**2 - along**2)), 0.0)
    cell = 4 * (places[1] - places[0]) ** 2
    cap = np.pi * depth**2 * (equivalent - depth / 3)
    assert lost.sum() * cell == pytest.approx(cap, rel=1e-3)
    assert np.count_nonzero(lost) * cell == pytest.approx(np.pi * (2 * equivalent - depth) * depth, rel=2e-3)
    ellipse = hertz_ellipse(normal_load=1.0, radius_x=radius, radius_z=radius / (1 + radius / side), modulus=1e11)
    circle = hertz_radius(normal_load=1.0, pin_radius=equivalent, modulus=1e11)
    assert ellipse.peak_pressure / 1.5 == pytest.approx(1 / (np.pi * float(circle) ** 2), rel=5e-3)


@pytest.mark.usefixtures("installed")
def test_drum_that_is_too_small_is_warned_of():
    document = drum()
    assert len(read(document).contact.limits) == 1
    document["contact"] = {**document["contact"], "drum": {**document["contact"]["drum"], "radius": "1 mm"}}
    taken, warned = read(document).contact.limits
    assert "treated as a pin of radius 0.5928" in taken
    assert warned.startswith("warning: found a ratio of pin radius to drum radius of 0.79; expected at most 0.5")


@pytest.mark.usefixtures("installed")
def test_pin_and_drum_wear_together():
    run = read(drum())
    known = {name: Quantity(value=k, unit="m^2/N") for name, k in (("pin", 1e-14), ("drum", 4e-13))}
    scenario = wear_scenario(run, given_wear(run.described, known, Recipe()))
    (point,) = predict_wear(scenario, [500.0]).prediction
    work = run.conditions.normal_load.value * 500.0
    assert {name: body.wear_volume.value for name, body in point.bodies.items()} == pytest.approx(
        {name: k.value * work for name, k in known.items()}, rel=1e-12
    )
    assert point.bodies["drum"].track_cross_section.value == pytest.approx(4e-13 * work / (2 * np.pi * 0.02), rel=1e-12)


def nodes(kind: type[Node], words: Collection[str], around: str = r"\b") -> Iterator[tuple[str, Node]]:
    """Yield the nodes of one kind in the modules outside the contacts' files that have any of the words."""
    pattern = re.compile(rf"{around}(?:{'|'.join(words)}){around}")
    for path in sorted(PACKAGE.rglob("*.py")):
        name, text = path.relative_to(PACKAGE).as_posix(), path.read_text(encoding="utf-8")
        if name not in CONTACT_FILES and pattern.search(text):
            yield from ((name, node) for node in ast.walk(ast.parse(text)) if isinstance(node, kind))


def own_kinds() -> tuple[type[Contact], ...]:
    return *contact_kinds.SHIPPED.values(), *contact_kinds.WITH_BALL.values()


def families() -> set[str]:
    """Return the names of the classes that are a contact of some kind or family."""
    return {kind.__name__ for one in own_kinds() for kind in one.__mro__ if issubclass(kind, Contact)} - {"Contact"}


def test_contacts_files_exist():
    assert [name for name in CONTACT_FILES if not (PACKAGE / name).is_file()] == []


def test_nothing_asks_which_kind_of_contact_there_is():
    kinds = families() | {"Contact"}
    found = [
        f"{name}:{call.lineno}"
        for name, call in nodes(ast.Call, kinds)
        if isinstance(call.func, ast.Name) and call.func.id in ("isinstance", "issubclass")
        if kinds & {one.id for one in ast.walk(call) if isinstance(one, ast.Name)}
    ]
    assert found == [], "ask the contact what you need to know"


def test_no_kind_and_no_body_is_named_outside_the_contacts_files():
    names = {word for one in own_kinds() for word in (contact_kinds.kind_of(one), *one.body_names, *one.roles)}
    assert {"pin-on-disc", "twin-disc", "pin", "flat", "ring", "top_ball", "curved_disc"} <= names
    literals = nodes(ast.Constant, names, "[\"']")
    assert sorted((name, one.value) for name, one in literals if one.value in names) == OTHER_MEANINGS


def test_nothing_is_imported_from_files_of_one_kind():
    of_one = {f"tribopipe.{name.removesuffix('.py').replace('/', '.')}" for name in CONTACT_FILES.keys() - SHARED}
    ends = {name.rpartition(".")[2] for name in of_one}
    found = [
        f"{name}: {one.name}"
        for name, node in nodes(ast.ImportFrom, ends | families())
        for one in node.names
        if one.name in families() or of_one & {node.module, f"{node.module}.{one.name}"}
    ]
    found += [
        f"{name}: {one.name}" for name, node in nodes(ast.Import, ends) for one in node.names if one.name in of_one
    ]
    assert found == [], "ask the contact what you need to know"


def test_no_module_names_the_kind_of_another_package():
    naming = [path for path in PACKAGE.rglob("*.py") if re.search(r"\bdrum\b|PinOnDrum", path.read_text("utf-8"))]
    assert naming == []


@pytest.fixture
def workspace(installed, tmp_path, run_cli, few_draws):  # noqa: ARG001 - installed while it is there
    """Two runs of a pin on a drum, recorded, and taken through the whole line."""
    (tmp_path / "plan.toml").write_text(PLAN + "".join(RUN.replace("NUMBER", n) for n in "12"), encoding="utf-8")
    (tmp_path / "recipe.toml").write_text(RECIPE, encoding="utf-8")
    done = run_cli("simulate", ".", "--plan", "plan.toml", cwd=tmp_path)
    assert done.exit_code == 0, done.stderr
    return tmp_path


@pytest.fixture
def tribopipe(workspace, run_cli):
    """Run a command in the workspace, and have it succeed."""

    def run(*words: object, code: int = 0) -> str:
        done = run_cli(*words, cwd=workspace)
        assert done.exit_code == code, done.stderr
        assert not re.search(r"\bdisc\b|disc_", done.stderr.replace("on a flat disc, with", "")), done.stderr
        return done.stdout

    return run


def watch_in_a_browser(archive: Path) -> None:
    """Ask the server for what its pages show of a run and of all, the plots included."""
    with serving(archive) as client:
        assert client.get("api", "runs", where="tribometer=pin-on-drum").json["ids"] == ["drum-1", "drum-2"]
        page = client.get("api", "runs", "drum-1").json
        assert {"Pin", "Drum"} <= {group["title"] for group in page["facts"]}
        assert page["plots"]
        for offer in page["plots"]:
            assert client.get("api", "runs", "drum-1", "plots", offer["name"]).status == 200, offer


@pytest.mark.slow
def test_every_command_takes_a_pin_on_a_drum(tribopipe, workspace):
    run = (workspace / "drum-1" / "run.toml").read_text(encoding="utf-8")
    assert '[contact.drum]\nradius = { value = "20 mm"' in run
    assert "drum_wear_depth" in run
    tribopipe("check", "drum-1")
    tribopipe("ingest", "drum-1", "drum-2")
    tribopipe("correct-drift", "drum-1")
    tribopipe("fit", "drum-1", "--law", "archard", "--recipe", "recipe.toml")
    document = json.loads(tribopipe("process", "drum-1", "drum-2", "--recipe", "recipe.toml", "--json"))
    found = document["runs"][0]["wear_fits"]["archard"]["bodies"]["pin"]["wear_coefficient"]
    assert abs(found["value"] - K_D) < 1.96 * found["standard_uncertainty"]
    assert found["standard_uncertainty"] < 0.05 * K_D
    with h5py.File(workspace / "archive" / "drum-1.h5") as file:
        assert file["entry/drum/properties/radius"][()] == 0.02
        assert file["entry/definition"].asstr()[()] == "NXtribometry_pin_on_drum"
    tribopipe("predict", "drum-1", "--at", "400 m", "--json")
    tribopipe("local-wear", "drum-1", "--at", "100 m")
    tribopipe("study", "new")
    study = json.loads(tribopipe("study", "run", "study.toml", "--recipe", "recipe.toml", "--json"))
    assert study["tribometer"] == "pin-on-drum"
    assert "drum" in tribopipe("ls", "--json")
    tribopipe("show", "drum-1")
    tribopipe("plan", "drum-1", "--interval", "3 %")
    tribopipe("live", "drum-1", "--once")
    (workspace / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    tribopipe("sweep", "sweep.toml")
    (workspace / "tests.toml").write_text(TESTS, encoding="utf-8")
    tribopipe("sweep", "tests.toml")
    watch_in_a_browser(workspace / "archive")
    tribopipe("report", "drum-1")
    tribopipe("export", "csv", "drum-1", "--output", "csv")
    tribopipe("export", "runs")
    tribopipe("export", "umeshmotion", "drum-1")
    tribopipe("export", "dataset", "--ro-crate", "crate.zip")
    tribopipe("verify")
    tribopipe("reproduce")
    without_the_package(workspace)


def without_the_package(workspace: Path) -> None:
    """See that an archive of such runs is not taken for damaged where the package is not installed."""
    folder = workspace / "archive"
    words = "found the contact kind 'pin-on-drum', which is not installed"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contact_kinds, "ADDED", {})
        with pytest.raises(ArchiveError, match=f"drum-1.h5: {words}"):
            Archive(folder).manifest("drum-1")
        (folder / FILE_NAME).unlink()
        catalog = Catalogue(folder)
        catalog.refresh()
        assert [words in why for _, why in catalog.unreadable] == [True, True]
    catalog.refresh()
    assert catalog.unreadable == []
    assert catalog.count == 2


@pytest.mark.usefixtures("installed")
def test_new_run_folder_has_the_names_of_the_drum(run_cli, tmp_path):
    rows = "".join(f"{second},{second / 100}\n" for second in range(50))
    (tmp_path / "test.csv").write_text(f"Time [s],Depth [um]\n{rows}", encoding="utf-8")
    bodies = {f"contact.pin.{key}": value for key, value in MANIFEST["contact"]["pin"].items()}
    bodies |= {f"contact.drum.{key}": value for key, value in drum()["contact"]["drum"].items()}
    told = bodies | {"conditions.normal_load": "1 N", "end_values.drum_wear_depth": "0.1 um"}
    words = [word for key, value in told.items() for word in ("--set", f"{key}={value}")]
    done = run_cli("new", "test.csv", "--id", "drum", *words, cwd=tmp_path)
    assert done.exit_code == 0, done.stderr
    written = (tmp_path / "drum" / "run.toml").read_text(encoding="utf-8")
    assert 'kind = "pin-on-drum"' in written
    assert "[contact.drum]\n" in written
    assert '\ndrum_wear_depth = "0.1 um"' in written
    assert "\n# drum_track_width = " in written
    assert "disc_" not in written
