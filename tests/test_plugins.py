"""A reader, a law, a check and a contact of another package: installed as such, and by their entry points alone."""

import json
import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import h5py
import numpy as np
import pytest
from example_rig import DISTANCE, K_D, LENGTH, PLUGIN, record

from tribopipe.archive.definitions.entries import run_definition
from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.base.errors import FitError, ManifestError
from tribopipe.base.plugins import Plugins, declared, own_first
from tribopipe.documents import contact_kinds
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import read_document
from tribopipe.evaluation.checks import registry as checks
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
    law = laws.law_named("delayed")
    assert list(laws.LAWS) == ["archard", "dissipated_energy", "running_in", "sarkar", "delayed"]
    assert (laws.law_title("delayed"), laws.law_label("delayed")) == ("delayed wear", "Delayed")
    distance = np.array([0.0, 0.1, 3.0, 500.0])
    by_quadrature = laws.WearLaw.effective_distance(law, distance, None)
    np.testing.assert_allclose(law.effective_distance(distance, None), by_quadrature, rtol=1e-9)
    told = read_document({"wear": {"models": ["delayed"]}}, Recipe, where="recipe.toml")
    assert told.wear.models == ("delayed",)


def test_a_law_that_is_not_installed_is_refused_where_people_write_it_but_read_back():
    with pytest.raises(
        ManifestError, match=r"wear\.models\[0\]: found the wear law 'archrd'.*did you mean 'archard'\?"
    ):
        read_document({"wear": {"models": ["archrd"]}}, Recipe, where="recipe.toml")
    with pytest.raises(FitError, match="'delayed', which is not installed"):
        laws.law_named("delayed")
    kept = WearFit(model="delayed", outcome="not fitted", missing=("depth",)).model_dump_json()
    assert WearFit.model_validate_json(kept).model == "delayed"


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
        from delayed import Delayed
    finally:
        sys.path.pop(0)
    record(tmp_path / "run", Delayed())
    recipe = '[wear]\nmodels = ["archard", "delayed"]\ncorrection = "model"\n'
    (tmp_path / "recipe.toml").write_text(f'schema = "tribopipe.recipe/1"\n{recipe}', encoding="utf-8")

    assert "rig-log" in tribopipe("formats", "list").stdout
    done = tribopipe("process", "run", "--recipe", "recipe.toml", "--json")
    assert done.returncode == 0, done.stderr
    assert "warning: temperature: found a change of 6.0 K" in done.stderr
    fit = json.loads(done.stdout)["runs"][0]["wear_fits"]["delayed"]
    found = {one["name"]: one["value"] for one in fit["parameters"]} | {"k_d": fit["bodies"]["pin"]["wear_coefficient"]}
    for name, true in {"length": LENGTH, "k_d": K_D}.items():
        assert abs(found[name]["value"] - true) < 2.5 * found[name]["standard_uncertainty"], found
        assert found[name]["standard_uncertainty"] < 0.1 * true

    with h5py.File(tmp_path / "archive" / "run-in.h5") as file:
        told = {
            law: json.loads(file[f"entry/wear_fit_{law}/options/data"].asstr()[()]) for law in ("archard", "delayed")
        }
    assert told["delayed"]["law_package"] == "example-rig 1.0"
    assert "law_package" not in told["archard"]
    listed = tribopipe("ls", "--columns", "id,k_d,k_d_delayed,steps", "--json")
    assert json.loads(listed.stdout)["runs"][0]["k_d_delayed"]["value"] == pytest.approx(found["k_d"]["value"])
    assert "k_d_delayed" in tribopipe("ls", "--columns", "help").stdout
    shown = tribopipe("show", "run-in")
    assert ", delayed wear" in shown.stdout
    assert "length" in shown.stdout
    predicted = tribopipe("predict", "run-in", "--law", "delayed", "--at", f"{DISTANCE} m", "--json")
    assert predicted.returncode == 0, predicted.stderr
    assert tribopipe("report", "run-in").returncode == 0
    assert tribopipe("verify").returncode == 0, tribopipe("verify").stderr
    assert tribopipe("schema", "export", "schemas").returncode == 0
    assert "delayed" in (tmp_path / "schemas" / "recipe.schema.json").read_text(encoding="utf-8")

    # On a machine without the package the archive opens still.
    bare = tribopipe("show", "run-in", plugin=False)
    assert bare.returncode == 0, bare.stderr
    assert "the law delayed, which is not installed" in bare.stdout
    assert tribopipe("ls", plugin=False).returncode == 0
    assert tribopipe("verify", plugin=False).returncode == 0
    refused = tribopipe("fit", "run-in", "--law", "delayed", plugin=False)
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
