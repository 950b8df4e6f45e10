"""What is handed on: sdist and wheel, and the wheel in an environment of its own, with no extra, far from the clone."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tarfile
import tomllib
from importlib import metadata
from pathlib import Path
from zipfile import ZipFile

import pytest
from built_files import tdms, xlsx
from filelock import FileLock
from folders import ROOT, SAMPLES
from range_server import serving
from test_cli_contract import FLAGS
from test_surface_topography import SDF

from tribopipe.archive.catalog.catalog import Catalogue

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FOR_WORK_ON_TRIBOPIPE = {"bench", "crates", "dev", "docs", "test"}
"""Extras that no command needs."""
NEEDS_IN_PYTHON = {"xarray": "tribopipe.read_run('sample-run').to_xarray()"}
"""A call in Python for each extra that no command needs, in the folder ``lab``."""
ADDRESS = "http://localhost/archive"
"""Where nothing is served; a test that reads puts the address of its own server in the place."""
NEEDS = {
    "excel": ("formats", "detect", "forces.xlsx"),
    "fair": ("export", "--ro-crate", "crate"),
    "fe": ("local-wear", "sample-run", "--engine", "fe", "--wear-coefficient", "13.5e-9 mm^3/(N*mm)", "--at", "1 m"),
    "hpc": ("process", "sample-run", "--scheduler", "local"),
    "parquet": ("export", "runs", "-o", "runs.parquet"),
    "remote": ("ls", "--archive", ADDRESS),
    "surface": ("formats", "detect", "heights.sdf"),
    "tdms": ("formats", "detect", "forces.tdms"),
}
"""A command for each other extra that cannot do without it, in the folder ``lab``."""
NEED_NO_EXTRA = """
new stroke_1.csv --template lab.toml
check sample-run
ingest sample-run
correct-drift
fit
predict
live sample-run --once
local-wear sample-run --wear-coefficient "13.5e-9 mm^3/(N*mm)" --at "1 m"
ls
show si3n4-air-200mN
tag si3n4-air-200mN --add seen
note si3n4-air-200mN "seen"
plan si3n4-air-200mN --interval "5 %"
sweep sweep.toml
study new sample-run other-run
study run study.toml
study show
study figures si3n4-air
report si3n4-air-200mN
export csv si3n4-air-200mN
export runs
export umeshmotion si3n4-air-200mN
verify
reproduce
rescue archive/si3n4-air-200mN.h5 --to rescued
formats list
formats detect stroke_1.csv
watch exports --template lab.toml --once --settle 0
import crate --archive imported
remove si3n4-air-200mN --archive imported --force
restore si3n4-air-200mN --archive imported
mark-bad si3n4-air-200mN --reason "worn through"
simulate simulated --plan plan.toml
schema export schemas
help shell
"""
"""The other commands, one after another in that folder."""
SWEEP = """
schema = "tribopipe.sweep/1"
[predictions]
run = "si3n4-air-200mN"
at = ["100 m"]
[vary.run]
conditions.normal_load = ["100 mN", "200 mN"]
"""
SERVE = {"browse", "demo"}
"""Commands of the extra web, which go on until Ctrl-C."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (ROOT / "tribopipe").is_dir(), reason="the sources of the package are not here"),
]


@pytest.fixture(scope="session")
def shared(tmp_path_factory) -> Path:
    """A folder that all processes of tests have in common."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


@pytest.fixture(scope="session")
def distributions(shared) -> tuple[Path, Path]:
    """The sdist and the wheel."""
    folder = shared / "distributions"
    with FileLock(shared / "distributions.lock"):
        if not folder.exists():
            called(sys.executable, "-m", "hatchling", "build", "--directory", folder, cwd=ROOT)
    (sdist,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    return sdist, wheel


@pytest.fixture(scope="session")
def bare(shared, distributions) -> Path:
    """The folder of commands of an environment with the wheel and no extra."""
    folder = shared / "bare"
    commands = folder / ("Scripts" if os.name == "nt" else "bin")
    with FileLock(shared / "bare.lock"):
        if not folder.exists():
            called(sys.executable, "-m", "venv", folder, cwd=shared)
            called(commands / "python", "-m", "pip", "install", distributions[1], cwd=shared)
    return commands


@pytest.fixture
def lab(sample_run, other_run, archive, tmp_path) -> Path:  # noqa: ARG001, they are in the folder
    """A folder with two runs, an archive of one, and exports of instruments."""
    (tmp_path / "forces.xlsx").write_bytes(xlsx({"Test": [["Time [s]", "Ff [N]"], [0.0, 0.1], [1.0, 0.2]]}))
    (tmp_path / "forces.tdms").write_bytes(tdms({"Test": {"Fz": ([0.1, 0.2], {"unit_string": "N"})}}))
    (tmp_path / "heights.sdf").write_bytes(SDF)
    return tmp_path


@pytest.fixture
def whole_lab(lab, short_plan) -> Path:
    """That folder with what all other commands take: a plan, a sweep, a template, a crate."""
    pages = ROOT / "tests" / "pages"
    (lab / "exports").mkdir()
    for source, copy in (
        (short_plan, "plan.toml"),
        (pages / "stroke_1.csv", "stroke_1.csv"),
        (pages / "stroke_2.csv", "exports/stroke_2.csv"),
    ):
        shutil.copy(source, lab / copy)
    template = (pages / "lab.toml").read_text(encoding="utf-8").replace('"200 mN"', '"10 N"')  # as the strokes have it
    (lab / "lab.toml").write_text(template, encoding="utf-8")
    (lab / "sweep.toml").write_text(SWEEP, encoding="utf-8")
    called(sys.executable, "-m", "tribopipe", "export", "--ro-crate", "crate", cwd=lab)
    return lab


def called(*command: Path | str, cwd: Path, exit_code: int = 0) -> "subprocess.CompletedProcess[str]":
    """Run a command that is to end with an exit code."""
    env = {**os.environ, "COLUMNS": "1000", "PYTHONUTF8": "1"}
    done = subprocess.run(command, cwd=cwd, capture_output=True, encoding="utf-8", env=env, timeout=900)
    assert done.returncode == exit_code, done.stdout + done.stderr
    return done


# --- what is in them ---


def tracked(*under: str) -> set[str]:
    """The files that git holds, or would."""
    listed = called("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", *under, cwd=ROOT).stdout
    return {name for name in listed.split("\0") if name and (ROOT / name).is_file()}


def is_page(name: str) -> bool:
    return name.startswith("tribopipe/browse/static/")


def needs_git() -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("not a clone")


def test_sdist_is_the_repository_and_the_pages(distributions):
    needs_git()
    with tarfile.open(distributions[0]) as archive:
        names = {member.name.partition("/")[2] for member in archive.getmembers() if member.isfile()}
    assert {name for name in names if not is_page(name)} == tracked() | {"PKG-INFO"}
    assert "tribopipe/browse/static/index.html" in names


def test_wheel_is_the_package_and_the_pages(distributions):
    needs_git()
    with ZipFile(distributions[1]) as archive:
        names = set(archive.namelist())
    held = {name for name in names if ".dist-info/" not in name and not is_page(name)}
    package = {name for name in tracked("tribopipe") if not name.startswith("tribopipe/browse/ui/")}
    shipped = tracked(":(glob)docs/*.md", ":(glob)docs/questions.toml", ":(glob)sample_runs/*.toml")
    assert held == package | {f"tribopipe/shipped/{name}" for name in shipped}
    assert {"tribopipe/browse/static/index.html", "tribopipe/browse/static/LICENCES.md", "tribopipe/py.typed"} <= names


def test_names_of_files_suit_every_system():
    needs_git()
    names = tracked()
    assert len({name.casefold() for name in names}) == len(names)
    reserved = re.compile(r"(?i)(^|/)(aux|con|nul|prn|com\d|lpt\d)(\.|/|$)|[<>:\"\\|?*]|[. ](/|$)")
    assert [name for name in names if reserved.search(name) or not name.isascii() or len(name) > 120] == []


def test_metadata_lead_to_the_readme_and_the_licence(distributions):
    with ZipFile(distributions[1]) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        told = archive.read(name).decode()
    assert "License-Expression: MIT" in told
    assert (ROOT / "README.md").read_text(encoding="utf-8") in told


# --- what it does ---


def test_main_job_runs_without_extras(bare, tmp_path):
    """Runs of each contact, and a study: CI's tests of all samples have the extras."""
    runs = tmp_path / "runs"
    kinds = ("al2o3-reciprocating-5N", "peek-block-on-ring-50N", "si3n4-twin-disc-4pct-500k", "steel-four-ball-147N")
    of_study = ("si3n4-air-200mN", "si3n4-air-400mN", "si3n4-air-800mN")
    for run_id in (*kinds, *of_study):
        shutil.copytree(SAMPLES / run_id, runs / run_id)
    shutil.copy(SAMPLES / "si3n4-air.study.toml", runs)
    done = called(bare / "tribopipe", "process", runs, cwd=tmp_path)
    assert "Warning" not in done.stderr
    archive = tmp_path / "archive"
    assert {path.stem for path in archive.glob("*.h5")} == {*kinds, *of_study}
    assert [path.stem for path in archive.glob("studies/*.h5")] == ["si3n4-air"]
    assert (archive / "figures" / "si3n4-air-wear-archard.svg").is_file()


def test_an_extra_is_for_a_command_or_for_work_on_tribopipe():
    assert set(PROJECT["optional-dependencies"]) == {*NEEDS, *NEEDS_IN_PYTHON, "web"} | FOR_WORK_ON_TRIBOPIPE


@pytest.mark.parametrize(("extra", "command"), [*NEEDS.items(), *(("web", (command,)) for command in sorted(SERVE))])
def test_missing_extra_is_named_by_the_command_that_needs_it(extra, command, bare, lab):
    said = called(bare / "tribopipe", *command, cwd=lab, exit_code=1)
    assert said.stdout == ""
    (line,) = said.stderr.splitlines()
    assert f'pip install "tribopipe[{extra}]"' in line
    assert "expected" in line


@pytest.mark.parametrize("extra", NEEDS_IN_PYTHON)
def test_missing_extra_is_named_by_the_call_that_needs_it(extra, bare, lab):
    program = f"import tribopipe\n{NEEDS_IN_PYTHON[extra]}"
    said = called(bare / "python", "-c", program, cwd=lab, exit_code=1)
    assert f'pip install "tribopipe[{extra}]"' in said.stderr.splitlines()[-1]


def test_every_command_is_known_to_need_an_extra_or_none():
    told = [*map(" ".join, NEEDS.values()), *NEED_NO_EXTRA.strip().splitlines()]
    begun = [line.replace("export --", "export dataset --") for line in told]
    assert {command for command in FLAGS if not any(f"{line} ".startswith(f"{command} ") for line in begun)} == SERVE


def test_other_commands_need_no_extra(bare, whole_lab):
    for line in NEED_NO_EXTRA.strip().splitlines():
        called(bare / "tribopipe", *shlex.split(line), cwd=whole_lab)


@pytest.mark.parametrize("extra", NEEDS)
def test_command_works_with_its_extra(extra, lab):
    for required in PROJECT["optional-dependencies"][extra]:
        name = re.match(r"[\w.-]+", required)[0]
        try:
            metadata.version(name)
        except metadata.PackageNotFoundError:
            pytest.skip(f"{name} is not installed")
    Catalogue(lab / "archive").refresh()
    with serving(lab / "archive") as server:
        command = [server.address if word == ADDRESS else word for word in NEEDS[extra]]
        called(sys.executable, "-m", "tribopipe", *command, cwd=lab)


# --- how a user's own programs see it ---

PROGRAM = """
from pathlib import Path
from typing import assert_type

import tribopipe
from tribopipe import Archive, Quantity, Scenario, TribopipeError


def identify(folder: Path) -> float | None:
    run = tribopipe.read_run(folder)
    corrected = tribopipe.correct_drift(run)
    fit = tribopipe.fit_wear(corrected, "archard")
    assert_type(fit.bodies["pin"].wear_coefficient, Quantity)
    return None if fit.first is None else fit.first.wear_coefficient.value


def ids(folder: Path) -> list[str]:
    archive: Archive = tribopipe.open_archive(folder)
    return archive.ids()


try:
    identify(Path("run"))
except TribopipeError as error:
    print(error)
"""


def checked(program: str, bare: Path, folder: Path, exit_code: int = 0) -> str:
    """What mypy says of a program that uses the installed package."""
    (folder / "program.py").write_text(program, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--python-executable", bare / "python", "program.py"]
    return called(*command, cwd=folder, exit_code=exit_code).stdout


def test_types_reach_programs_that_use_it(bare, tmp_path):
    assert "no issues found" in checked(PROGRAM, bare, tmp_path)


def test_mistakes_are_found_in_programs_that_use_it(bare, tmp_path):
    program = (
        PROGRAM.replace("fit_wear(corrected", "fit_wear(folder").replace(".value", ".unit").replace("_arch", "_ark")
    )
    said = checked(program, bare, tmp_path, exit_code=1)
    assert re.findall(r"\[([\w-]+)\]$", said, re.MULTILINE) == ["arg-type", "return-value", "attr-defined"]
