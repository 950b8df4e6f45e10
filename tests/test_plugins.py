"""A reader, a law, a check and a contact of another package: installed as such, and by their entry points alone."""

import json
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import h5py
import numpy as np
import pytest
from disc_runs import known_pair
from example_rig import DISTANCE, EXCESS, JOINT, K_D, LENGTH, PLUGIN, predicted, record, series_of, virtual, worn

from tribopipe.archive.definitions.entries import run_definition
from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.base.errors import FitError, ManifestError
from tribopipe.base.plugins import Plugins, declared, own_first
from tribopipe.cli.live import live
from tribopipe.documents import contact_kinds
from tribopipe.documents.plan import Plan
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.documents.record import load_toml, read_document
from tribopipe.evaluation.checks import registry as checks
from tribopipe.evaluation.wear.scenario import Scenario
from tribopipe.extras.simulate import VirtualTest, VirtualTwinDiscTest
from tribopipe.physics import laws
from tribopipe.readers import reader as readers
from tribopipe.readers.conformance import Example, check_reader
from tribopipe.readers.draft.blanks import blanks_of
from tribopipe.readers.draft.known_values import sections
from tribopipe.readers.harmonize import read_run
from tribopipe.results.wear_fit import WearFit

ROOT = Path(__file__).parents[1]
GROUPS = tomllib.loads((PLUGIN / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
HEAD = b"RIG LOG 2\nload=200 mN\n"
LOG = HEAD + b"t/s;d/um;Ff/mN;T/degC;\n0.00;1.20;102.5;21.5;\n0.25;1.22;101.0;21.5;\n0.50;1.24;99.5;21.6;\n"
PERMUTED = HEAD + b"t/s;T/degC;d/um;Ff/mN;\n0.00;21.5;1.20;102.5;\n0.25;21.5;1.22;101.0;\n0.50;21.6;1.24;99.5;\n"


@pytest.fixture
def installed(monkeypatch):
    """Declare the entry points of the example beside tribopipe's own, as if its package were installed."""
    own = {group: declared(group) for group in GROUPS}
    checks.load_checks()  # tribopipe's own, which no module registers twice
    monkeypatch.syspath_prepend(str(PLUGIN))
    more = {group: [EntryPoint(name, value, group) for name, value in said.items()] for group, said in GROUPS.items()}
    monkeypatch.setattr("tribopipe.base.plugins.declared", lambda group: own_first([*own[group], *more[group]]))
    monkeypatch.setattr(checks, "CHECKS", dict(checks.CHECKS))
    forget()
    yield
    forget()
    for group in GROUPS.values():
        for value in group.values():
            sys.modules.pop(value.partition(":")[0], None)


def forget() -> None:
    """Have what is installed looked for again."""
    readers._loaded.cache_clear()
    checks.load_checks.cache_clear()
    assert isinstance(laws.LAWS, Plugins)
    laws.LAWS.__dict__.pop("_loaded", None)
    contact_kinds.ADDED.__dict__.pop("_loaded", None)
    for known in (sections, blanks_of, definitions, run_definition):
        known.cache_clear()


@pytest.mark.usefixtures("installed")
def test_the_reader_keeps_to_all_that_a_reader_must():
    example = Example(
        "run.rig",
        LOG,
        rows=3,
        columns={"t/s": "s", "d/um": "um", "Ff/mN": "mN", "T/degC": "degC"},
        signals={"t/s": "time", "d/um": "depth", "Ff/mN": "friction_force", "T/degC": "temperature"},
        values={"d/um": [1.20, 1.22, 1.24]},
        facts={"conditions.normal_load": "200 mN"},
        permuted=PERMUTED,
    )
    check_reader(readers.reader_named("rig-log"), [example], quick=True)


@pytest.mark.usefixtures("installed")
def test_the_law_is_one_of_those_installed():
    law = laws.law_named("running_in")
    assert list(laws.LAWS) == ["archard", "sarkar", "running_in"]
    assert (laws.law_title("running_in"), laws.law_label("running_in")) == ("exponential running-in", "Running in")
    distance = np.array([0.0, 0.1, 3.0, 500.0])
    by_quadrature = laws.WearLaw.effective_distance(law, distance, None)
    np.testing.assert_allclose(law.effective_distance(distance, None), by_quadrature, rtol=1e-9)
    told = read_document({"wear": {"models": ["running_in"]}}, Recipe, where="recipe.toml")
    assert told.wear.models == ("running_in",)


def test_a_law_that_is_not_installed_is_refused_where_people_write_it_but_read_back():
    with pytest.raises(
        ManifestError, match=r"wear\.models\[0\]: found the wear law 'archrd'.*did you mean 'archard'\?"
    ):
        read_document({"wear": {"models": ["archrd"]}}, Recipe, where="recipe.toml")
    with pytest.raises(FitError, match="'running_in', which is not installed"):
        laws.law_named("running_in")
    kept = WearFit(model="running_in", outcome="not fitted", missing=("depth",)).model_dump_json()
    assert WearFit.model_validate_json(kept).model == "running_in"


@pytest.mark.usefixtures("installed")
def test_the_check_finds_something(tmp_path):
    run = read_run(record(tmp_path / "run", laws.law_named("running_in")))
    (found,) = (one for one in checks.check_run(run) if one.code == "room_temperature")
    assert str(found).startswith("temperature: found a change of 6.0 K; expected at most 5 K; check for thermal drift")


@pytest.mark.usefixtures("installed")
def test_a_check_that_fails_itself_says_so(tmp_path):
    run = read_run(record(tmp_path / "run", laws.law_named("running_in")))

    def stumbles(run):
        yield 1 // 0 if run else None

    checks.check("note")(stumbles)
    (found,) = (one for one in checks.check_run(run) if one.code == "stumbles")
    assert "the check stumbles failed (ZeroDivisionError" in str(found)
    with pytest.raises(ValueError, match="'stumbles' already exists"):
        checks.check("note")(stumbles)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"lenght": "30 m"}, r"running_in\.lenght: found a parameter.*did you mean 'length'\?"),
        ({"length": "30 N"}, r"running_in\.length: found the unit 'N', which is not a unit of distance"),
        ({"excess": -1.0}, r"running_in\.excess: found -1; expected 0 to 1000; correct it"),
        ({"length": "30 m"}, r"found no excess; expected values"),
    ],
)
@pytest.mark.usefixtures("installed")
def test_given_parameters_are_checked(given, words):
    from tribopipe.evaluation.wear.inputs import law_as_given

    recipe = read_document({"wear": {"parameters": {"running_in": given}}}, Recipe, where="recipe.toml")
    with pytest.raises(FitError, match=words):
        law_as_given("running_in", recipe)


BROKEN = """\
[tribopipe.laws]
broken = broken_law:Law
sarkar = broken_law:Law
my-law = broken_law:Law
"""


@pytest.mark.slow
def test_package_that_cannot_be_loaded_is_told_in_sentences(tmp_path):
    (tmp_path / "broken-1.dist-info").mkdir()
    (tmp_path / "broken-1.dist-info" / "METADATA").write_text("Name: broken\nVersion: 1\n", encoding="ascii")
    (tmp_path / "broken-1.dist-info" / "entry_points.txt").write_text(BROKEN, encoding="ascii")
    (tmp_path / "broken_law.py").write_text("raise RuntimeError('no licence')", encoding="ascii")
    program = [sys.executable, "-m", "tribopipe"]
    predict = ["predict", "--run", ROOT / "sample_runs" / "si3n4-air-200mN", "--wear-coefficient", "1e-9 mm^3/(N*mm)"]
    ends = {}
    for words in ([*predict, "--law", "broken"], [*predict, "--at", "1 m"], ["ls", "--columns", "help"]):
        ends[words[-1]] = subprocess.run(
            [*program, *words],
            env=os.environ | {"PYTHONPATH": str(tmp_path)},
            capture_output=True,
            text=True,
            encoding="utf-8",
            check=False,
        )
    told = ends["broken"].stderr
    assert "warning: wear law 'broken' skipped: broken_law:Law cannot be loaded (RuntimeError('no licence'))\n" in told
    assert "error: found the wear law 'broken', which cannot be loaded" in told
    assert ends["1 m"].returncode == 0
    assert "UserWarning" not in "".join(end.stderr for end in ends.values())
    assert re.search(r"k_d_sarkar .*\(Sarkar's law\)", ends["help"].stdout)
    assert "my-law" not in ends["help"].stdout


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """Install the example into a folder of its own."""
    target = tmp_path_factory.mktemp("site")
    quiet = ["--quiet", "--disable-pip-version-check", "--no-deps", "--no-build-isolation", "--no-index"]
    command = [sys.executable, "-m", "pip", "install", *quiet, "--target", target, PLUGIN]
    subprocess.run(command, check=True, timeout=300)
    return target


@pytest.mark.slow
def test_the_whole_line_with_another_package(package, tmp_path):
    def tribopipe(*words: object, plugin: bool = True) -> subprocess.CompletedProcess[str]:
        path = os.pathsep.join([str(package)] if plugin else [])
        return subprocess.run(
            [sys.executable, "-m", "tribopipe", *map(str, words)],
            env=os.environ | {"PYTHONPATH": path},
            cwd=tmp_path,
            capture_output=True,
            text=True,
            encoding="utf-8",
            timeout=300,
        )

    sys.path.insert(0, str(PLUGIN))
    try:
        from running_in import RunningIn
    finally:
        sys.path.pop(0)
    record(tmp_path / "run", RunningIn())
    recipe = '[wear]\nmodels = ["archard", "running_in"]\ncorrection = "model"\n'
    (tmp_path / "recipe.toml").write_text(f'schema = "tribopipe.recipe/1"\n{recipe}', encoding="utf-8")

    assert "rig-log" in tribopipe("formats", "list").stdout
    done = tribopipe("process", "run", "--recipe", "recipe.toml", "--json")
    assert done.returncode == 0, done.stderr
    assert "warning: temperature: found a change of 6.0 K" in done.stderr
    fit = json.loads(done.stdout)["runs"][0]["wear_fits"]["running_in"]
    found = {one["name"]: one["value"] for one in fit["parameters"]} | {"k_d": fit["bodies"]["pin"]["wear_coefficient"]}
    for name, true in {"excess": EXCESS, "length": LENGTH, "k_d": K_D}.items():
        assert abs(found[name]["value"] - true) < 2.5 * found[name]["standard_uncertainty"], found
        assert found[name]["standard_uncertainty"] < 0.1 * true

    with h5py.File(tmp_path / "archive" / "run-in.h5") as file:
        told = {
            law: json.loads(file[f"entry/wear_fit_{law}/options/data"].asstr()[()]) for law in ("archard", "running_in")
        }
    assert told["running_in"]["law_package"] == "example-rig 1.0"
    assert "law_package" not in told["archard"]
    listed = tribopipe("ls", "--columns", "id,k_d,k_d_running_in,steps", "--json")
    assert json.loads(listed.stdout)["runs"][0]["k_d_running_in"]["value"] == pytest.approx(found["k_d"]["value"])
    assert "k_d_running_in" in tribopipe("ls", "--columns", "help").stdout
    shown = tribopipe("show", "run-in")
    assert ", exponential running-in" in shown.stdout
    assert "length" in shown.stdout
    predicted = tribopipe("predict", "run-in", "--law", "running_in", "--at", f"{DISTANCE} m", "--json")
    assert predicted.returncode == 0, predicted.stderr
    assert tribopipe("report", "run-in").returncode == 0
    assert tribopipe("verify").returncode == 0, tribopipe("verify").stderr
    assert tribopipe("schema", "export", "schemas").returncode == 0
    assert "running_in" in (tmp_path / "schemas" / "recipe.schema.json").read_text(encoding="utf-8")

    # On a machine without the package the archive opens still.
    bare = tribopipe("show", "run-in", plugin=False)
    assert bare.returncode == 0, bare.stderr
    assert "the law running_in, which is not installed" in bare.stdout
    assert tribopipe("ls", plugin=False).returncode == 0
    assert tribopipe("verify", plugin=False).returncode == 0
    refused = tribopipe("fit", "run-in", "--law", "running_in", plugin=False)
    assert refused.returncode == 2
    assert "which is not installed" in re.sub(r"\s+", " ", refused.stderr)


def test_contributing_shows_the_very_files_of_the_example():
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    shown = dict(re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```\n", page, re.DOTALL))
    held = {path.name: path.read_text(encoding="utf-8") for path in PLUGIN.iterdir() if path.is_file()}
    assert shown == held


def test_the_architecture_is_drawn_as_it_is(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import make_layers

    assert make_layers.PICTURE.read_text(encoding="utf-8") == make_layers.picture(), "run python docs/make_layers.py"


@pytest.mark.usefixtures("installed")
def test_virtual_run_wears_by_the_true_parameters_of_its_law():
    series = series_of(systematic_errors=False)
    test = VirtualTest(series, series.runs[0])
    np.testing.assert_allclose(test.worn.pin_depth, worn(laws.law_named("running_in"), test.distance), rtol=1e-12)
    told = {name: (true.value, true.unit) for name, true in test.truth().law_parameters.items()}
    assert told == {"excess": (EXCESS, "1"), "length": (LENGTH, "m")}
    assert VirtualTest(series_of(law="archard", law_parameters={}), series.runs[0]).truth().law_parameters is None


@pytest.mark.usefixtures("installed")
def test_test_is_not_followed_under_a_law_whose_parameters_nobody_gave(tmp_path):
    with pytest.raises(FitError, match="found no excess or length; expected values"):
        live(record(tmp_path / "run", laws.law_named("running_in")), "running_in")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"excess": 4.0}, "exponential running-in: found no length; .* under law_parameters of the series"),
        ({"excess": 4.0, "lenght": "30 m"}, r"law_parameters\.lenght: found a parameter .* did you mean 'length'\?"),
    ],
)
@pytest.mark.usefixtures("installed")
def test_virtual_run_needs_all_parameters_of_its_law(given, words):
    series = series_of(law_parameters=given)
    with pytest.raises(FitError, match=words):
        VirtualTest(series, series.runs[0])


@pytest.mark.usefixtures("installed")
def test_virtual_discs_wear_by_the_true_parameters_of_their_law():
    series = load_toml(ROOT / "sample_runs" / "plan.toml", Plan).twin_disc_series[0]
    series = series.model_copy(update={"distance_per_rotation": "volume-conserving"})
    given = {"law": "running_in", "law_parameters": {"excess": EXCESS, "length": f"{LENGTH} m"}}
    plain, run_in = (VirtualTwinDiscTest(series.model_copy(update=said), series.runs[0]) for said in ({}, given))
    law = laws.law_named("running_in").at({"law_excess": EXCESS, "law_length": LENGTH})
    longer = law.effective_distance(plain.distance[-1], None) / plain.distance[-1]
    volumes = [test.truth().end_curved_wear_volume.value for test in (plain, run_in)]
    assert volumes[1] == pytest.approx(longer * volumes[0], rel=1e-6)
    with pytest.raises(FitError, match="found no excess or length"):
        VirtualTwinDiscTest(series.model_copy(update={"law": "running_in"}), series.runs[0])


def discs_under_running_in(length: str | dict[str, str]) -> Scenario:
    """Return a scenario of two discs that run in over a length."""
    load, slip = (Quantity(value=value, unit=unit) for value, unit in ((0.25, "N"), (0.04, "1")))
    recipe = Recipe(wear=WearRecipe(parameters={"running_in": {"excess": EXCESS, "length": length}}))
    return Scenario(
        load_toml(ROOT / "sample_runs" / "plan.toml", Plan).twin_disc_series[0].contact,
        load,
        known_pair(*(Quantity(value=k_d, unit="m^2/N") for k_d in (4.6e-18, 2e-18))),
        "running_in",
        recipe=recipe,
        slip=slip,
    )


@pytest.mark.usefixtures("installed")
def test_wear_of_discs_is_as_uncertain_as_the_parameters_of_their_law():
    rotations = np.asarray([1e5])
    scenario = discs_under_running_in({"value": "30 m", "standard_uncertainty": "10 m"})
    spread = scenario.uncertainties(rotations, ("law_length",))["curved_depth"]
    low, high = (discs_under_running_in(length).worn(rotations)["curved_depth"] for length in ("20 m", "40 m"))
    np.testing.assert_allclose(spread, (high - low) / 2, rtol=0.05)


@pytest.mark.usefixtures("installed")
def test_parameter_that_is_found_at_nothing_is_held_there_and_leaves_k_d_to_archard(monkeypatch):
    slow_at_first = replace(laws.law_named("running_in"), excess=-0.5, length=LENGTH)
    monkeypatch.setattr("tribopipe.extras.simulate.instrument.true_law", lambda _: slow_at_first)
    series = series_of(sliding_distance="100 m", systematic_errors=False)
    recipe = JOINT.model_copy(
        update={"wear": JOINT.wear.model_copy(update={"parameters": {"running_in": {"length": f"{LENGTH} m"}}})}
    )
    run_in, archard = (virtual(series, 1, law, recipe)[1] for law in ("running_in", "archard"))
    assert run_in.first.wear_coefficient.value == pytest.approx(archard.first.wear_coefficient.value, rel=1e-9)
    assert str(run_in.parameters[0].value) == "0"
    assert "excess was fitted at 0 and is fixed there: k_D and its uncertainty are those without it" in run_in.notes


@pytest.mark.slow
@pytest.mark.usefixtures("installed")
def test_intervals_hold_the_truth_as_often_as_they_say():
    off: dict[str, list[float]] = {name: [] for name in ("k_d", "excess", "length", "later", "heavier")}
    for seed in range(24):
        series = series_of()
        _, fit = virtual(series, 1000 + seed)
        found = {one.name: one.value for one in fit.parameters} | {"k_d": fit.first.wear_coefficient}
        true = {"excess": EXCESS, "length": LENGTH, "k_d": K_D}
        for name, load, at in (("later", 0.2, 2000.0), ("heavier", 0.4, 500.0)):
            found[name] = predicted(series, fit, load, at)
            true[name] = worn(laws.law_named("running_in"), at, load)
        for name, quantity in found.items():
            off[name].append((quantity.value - true[name]) / quantity.standard_uncertainty)
    for name, deviations in off.items():
        held = np.count_nonzero(np.abs(deviations) < 1.96)
        assert held >= 19, (name, held)  # fewer of 24 would come about once in 200 tests by chance
        assert abs(np.mean(deviations)) < 0.7, name


@pytest.mark.slow
@pytest.mark.usefixtures("installed")
def test_parameters_that_a_run_hardly_shows_leave_k_d_right():
    series = series_of(law="archard", law_parameters={}, sliding_distance="100 m", systematic_errors=False)
    for seed in range(8):
        fit = virtual(series, seed)[1].first.wear_coefficient
        assert abs(fit.value - K_D) < 3 * fit.standard_uncertainty
        assert fit.standard_uncertainty < 0.5 * K_D
