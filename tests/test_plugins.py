"""A reader, a wear law and a check of another package: installed as such, and by their entry points alone."""

import json
import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from example_rig import DISTANCE, EXCESS, K_D, LENGTH, PLUGIN, record

from tribopipe.checks import registry as checks
from tribopipe.errors import FitError, ManifestError
from tribopipe.ingest import registry as readers
from tribopipe.ingest.conformance import Example, check_reader
from tribopipe.ingest.harmonise import read_run
from tribopipe.plugins import Plugins, declared, own_first
from tribopipe.records.base import read_document
from tribopipe.records.recipe import Recipe
from tribopipe.records.results import WearFit
from tribopipe.wear import laws

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
    for module in ("tribopipe.plugins", "tribopipe.records.installed"):
        monkeypatch.setattr(f"{module}.declared", lambda group: own_first([*own[group], *more[group]]))
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
    with pytest.raises(FitError, match="'running_in', which is not installed here"):
        laws.law_named("running_in")
    kept = WearFit(model="running_in", outcome="not fitted", lacks=("depth",)).model_dump_json()
    assert WearFit.model_validate_json(kept).model == "running_in"


@pytest.mark.usefixtures("installed")
def test_the_check_finds_something(tmp_path):
    run = read_run(record(tmp_path / "run", laws.law_named("running_in")))
    (found,) = (one for one in checks.check_run(run) if one.check == "room_stays_as_warm")
    assert str(found).startswith("temperature: found that it moves by 6.0 K; expected at most 5 K; look for drift")


@pytest.mark.usefixtures("installed")
def test_a_check_that_fails_itself_says_so(tmp_path):
    run = read_run(record(tmp_path / "run", laws.law_named("running_in")))

    def stumbles(run):
        yield 1 // 0 if run else None

    checks.check("note")(stumbles)
    (found,) = (one for one in checks.check_run(run) if one.check == "stumbles")
    assert "found that the check stumbles fails itself (ZeroDivisionError" in str(found)
    with pytest.raises(ValueError, match="'stumbles' is there already"):
        checks.check("note")(stumbles)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"lenght": "30 m"}, r"running_in\.lenght: found a parameter.*did you mean 'length'\?"),
        ({"length": "30 N"}, r"running_in\.length: found the unit 'N', which is no unit of distance"),
        ({"excess": -1.0}, r"running_in\.excess: found -1; expected 0 to 1000; correct it"),
        ({"length": "30 m"}, r"found no excess; expected them given"),
    ],
)
@pytest.mark.usefixtures("installed")
def test_given_parameters_are_checked(given, words):
    from tribopipe.wear.own_parameters import law_as_given

    recipe = read_document({"wear": {"parameters": {"running_in": given}}}, Recipe, where="recipe.toml")
    with pytest.raises(FitError, match=words):
        law_as_given("running_in", recipe)


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
            [sys.executable, "-m", "tribopipe.cli.start", *map(str, words)],
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
    recipe = '[wear]\nmodels = ["archard", "running_in"]\ncorrection = "joint"\n'
    (tmp_path / "recipe.toml").write_text(f'schema = "tribopipe.recipe/1"\n{recipe}', encoding="utf-8")

    assert "rig-log" in tribopipe("formats", "list").stderr
    done = tribopipe("process", "run", "--recipe", "recipe.toml", "--json")
    assert done.returncode == 0, done.stderr
    assert "warning: temperature: found that it moves by 6.0 K" in done.stderr
    fit = json.loads(done.stdout)["runs"][0]["wear_fits"]["running_in"]
    found = {one["name"]: one["value"] for one in fit["parameters"]} | {"k_d": fit["wear_coefficient"]}
    for name, true in {"excess": EXCESS, "length": LENGTH, "k_d": K_D}.items():
        assert abs(found[name]["value"] - true) < 2.5 * found[name]["standard_uncertainty"], found
        assert found[name]["standard_uncertainty"] < 0.1 * true

    listed = tribopipe("ls", "--columns", "id,k_d,k_d_running_in,steps", "--json")
    assert json.loads(listed.stdout)["runs"][0]["k_d_running_in"]["value"] == pytest.approx(found["k_d"]["value"])
    assert "k_d_running_in" in tribopipe("ls", "--columns", "help").stderr
    shown = tribopipe("show", "run-in")
    assert "by exponential running-in" in shown.stderr
    assert "length" in shown.stderr
    predicted = tribopipe("predict", "run-in", "--law", "running_in", "--at", f"{DISTANCE} m", "--json")
    assert predicted.returncode == 0, predicted.stderr
    assert tribopipe("report", "run-in").returncode == 0
    assert tribopipe("verify").returncode == 0, tribopipe("verify").stderr
    assert tribopipe("schema", "export", "schemas").returncode == 0
    assert "running_in" in (tmp_path / "schemas" / "recipe.schema.json").read_text(encoding="utf-8")

    # On a machine without the package the archive opens still.
    bare = tribopipe("show", "run-in", plugin=False)
    assert bare.returncode == 0, bare.stderr
    assert "the law running_in, which is not installed here" in bare.stderr
    assert tribopipe("ls", plugin=False).returncode == 0
    assert tribopipe("verify", plugin=False).returncode == 0
    refused = tribopipe("fit", "run-in", "--law", "running_in", plugin=False)
    assert refused.returncode == 2
    assert "which is not installed here" in re.sub(r"\s+", " ", refused.stderr)


def test_contributing_shows_the_very_files_of_the_example():
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    shown = dict(re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```\n", page, re.DOTALL))
    held = {path.name: path.read_text(encoding="utf-8") for path in PLUGIN.iterdir() if path.is_file()}
    assert shown == held


def test_the_architecture_is_drawn_as_it_is(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import make_layers

    assert make_layers.PICTURE.read_text(encoding="utf-8") == make_layers.picture(), "run python docs/make_layers.py"
