"""What the tests share: a short virtual run, an archive of one, and the command run as a user runs it."""

import functools
import hashlib
import os
import shutil
import sys
from collections.abc import Callable, Iterator
from contextvars import copy_context
from dataclasses import dataclass
from pathlib import Path

import blas  # noqa: F401, before all that loads numpy
import pytest
import si_approx  # noqa: F401, before any test compares numbers
import typer.main
from folders import DISC_IDS, DISC_PAIR, FURTHER_IDS, SAMPLE_IDS, SAMPLES
from hypothesis import settings
from study_runs import fill, record_runs

from tribopipe.archive import hdf5_guard
from tribopipe.archive.catalog.database import FILE_NAME
from tribopipe.archive.store import Archive
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.plan import Plan
from tribopipe.documents.record import load_toml
from tribopipe.extras.simulate import simulate_plan
from tribopipe.pipeline.stages import process
from tribopipe.results.run import RawRun

# The first example of a test may have to import what takes longer than the others. A rare example is found by whoever
# runs the tests; CI takes the same ones each time, so that a change fails there by what it changes alone.
settings.register_profile("tribopipe", deadline=None, max_examples=50, derandomize="CI" in os.environ)
settings.load_profile("tribopipe")
# Tests start Python hundreds of times: without compiled files, each would compile the whole package again.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Two processes for whatever is not a few files or tests named; those start sooner in one."""
    return 0 if all(Path(name.partition("::")[0]).is_file() for name in config.args) else 2


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put those that look at archived samples where a process begins, so that each makes one archive of the two."""
    kinds: dict[str, list[pytest.Item]] = {
        name: [] for name in ("sample_archive", "disc_pair", "disc_archive", "further_run", "further_archive", "")
    }
    for item in items:
        asked = getattr(item, "callspec", None)  # fixtures named as parameters, which tests ask for themselves
        named = [value for value in asked.params.values() if isinstance(value, str)] if asked else []
        used = {*getattr(item, "fixturenames", ()), *named}
        kinds[next(kind for kind in kinds if kind in used or not kind)].append(item)
    samples, *further, others = kinds.values()
    half = max(0, len(items) // 2 - len(samples))
    items[:] = [*samples, *others[:half], *(item for kind in further for item in kind), *others[half:]]


@pytest.fixture(scope="session")
def short_plan(tmp_path_factory) -> Path:
    """The plan of the sample runs cut down to two runs of 50 m, that is 1251 samples each."""
    text = (SAMPLES / "plan.toml").read_text(encoding="utf-8")
    kept = text.partition('[[series.runs]]\nid = "si3n4-air-800mN"')[0]
    assert kept.count("[[series.runs]]") == 2
    path = tmp_path_factory.mktemp("plan") / "plan.toml"
    short = kept.replace('sliding_distance = "500 m"', 'sliding_distance = "50 m"')
    path.write_text(short.replace('"120 nm"', '"30 nm"').replace('"150 nm"', '"35 nm"'), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def short_runs(short_plan, tmp_path_factory) -> Path:
    """A folder of the two short runs; not to be written into."""
    folder = tmp_path_factory.mktemp("runs")
    simulate_plan(load_toml(short_plan, Plan), folder)
    return folder


@pytest.fixture
def sample_run(short_runs, tmp_path) -> Path:
    """A short run at 400 mN to do anything with."""
    return Path(shutil.copytree(short_runs / "si3n4-air-400mN", tmp_path / "sample-run"))


@pytest.fixture
def other_run(short_runs, tmp_path) -> Path:
    """A short run of the same bodies at 200 mN."""
    return Path(shutil.copytree(short_runs / "si3n4-air-200mN", tmp_path / "other-run"))


@pytest.fixture(scope="session")
def _processed(short_runs, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("processed") / "archive"
    list(process([short_runs / "si3n4-air-200mN"], Archive(folder)))
    (folder / FILE_NAME).unlink()
    return folder


@pytest.fixture
def archive(_processed, tmp_path) -> Path:
    """An archive that holds the run at 200 mN, fully processed, and no catalogue yet."""
    return Path(shutil.copytree(_processed, tmp_path / "archive"))


@pytest.fixture(scope="module")
def few_draws() -> Iterator[None]:
    """So few draws that a Monte Carlo takes no time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 200)
        yield


@pytest.fixture(scope="session")
def runs(tmp_path_factory) -> Path:
    """Folders of the runs of study_runs.py; not to be written into."""
    return record_runs(tmp_path_factory.mktemp("study-runs"))


@pytest.fixture(scope="session")
def filled(runs, tmp_path_factory) -> Path:
    """An archive of those runs, corrected; not to be written into."""
    return fill(tmp_path_factory.mktemp("study") / "archive", runs).folder


@pytest.fixture(scope="session", autouse=True)
def _not_waiting_for_the_disk() -> Iterator[None]:
    """Leave files to the operating system: they need not outlast a power failure."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.fsync", lambda descriptor: None)  # noqa: ARG005
        yield


@pytest.fixture(scope="session", autouse=True)
def _each_content_looked_through_once() -> Iterator[None]:
    """Look through files of the same bytes once, since tests copy archives; what is foreign is refused each time."""
    look, known = hdf5_guard._Look.through, {}

    def through(self: hdf5_guard._Look) -> hdf5_guard.Shapes:
        if not (path := Path(self._file.filename)).is_file():  # of a remote file, whose bytes are not all here
            return look(self)
        content = hashlib.sha256(path.read_bytes()).digest()
        if content not in known:
            known[content] = look(self)
        return known[content]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hdf5_guard._Look, "through", through)
        yield


@pytest.fixture(autouse=True)
def _one_core(monkeypatch) -> None:
    """Have commands do all in this process, where tests see and change what they call, unless told otherwise."""
    monkeypatch.setattr("tribopipe.cli.options._cores", lambda: 1)


@dataclass(frozen=True)
class Finished:
    """What a command left behind."""

    exit_code: int
    stdout: str
    stderr: str

    @property
    def output(self) -> str:
        """All that people see."""
        return self.stdout + self.stderr


built_once = functools.cache(typer.main.get_command)
"""Typer builds all commands anew whenever one is called, which takes longer than most of them."""


@pytest.fixture
def run_cli(monkeypatch, capsys):
    """Run the `tribopipe` command with these arguments, in a folder, as the installed script does."""
    from tribopipe.cli.app import main

    def run(*args, cwd: Path | None = None) -> Finished:
        with monkeypatch.context() as patch:
            patch.setattr(sys, "argv", ["tribopipe", *map(str, args)])
            patch.setattr("typer.main.get_command", built_once)
            if cwd is not None:
                patch.chdir(cwd)
            capsys.readouterr()
            with pytest.raises(SystemExit) as stopped:
                copy_context().run(main)  # what a command sets (--json) must not outlive it
        shown = capsys.readouterr()
        return Finished(stopped.value.code or 0, shown.out, shown.err)

    return run


MANIFEST = {
    "schema": "tribopipe.run/1",
    "id": "bare",
    "started": "2006-03-01T09:30:00+01:00",
    "contact": {
        "kind": "pin-on-disc",
        "pin": {
            "shape": "spherical",
            "radius": "0.794 mm",
            "material": "Si3N4",
            "youngs_modulus": "304 GPa",
            "poisson_ratio": 0.24,
        },
        "disc": {"material": "Si3N4", "youngs_modulus": "304 GPa", "poisson_ratio": 0.24},
    },
    "conditions": {"normal_load": "200 mN", "sliding_speed": "400 mm/s"},
    "signals": [{"file": "signals.csv"}],
}


@pytest.fixture(scope="session")
def bare_run() -> RawRun:
    """A run in memory with a manifest and no samples yet."""
    return RawRun(RunManifest.model_validate(MANIFEST), {}, {}, {}, {}, ())


@pytest.fixture(scope="session")
def sample_archive(tmp_path_factory) -> Archive:
    """All pin-on-disc samples taken through the whole line, with fewer draws; not to be written into."""
    return _taken_through(SAMPLE_IDS, tmp_path_factory.mktemp("samples"))


@pytest.fixture(scope="session")
def further_archive(tmp_path_factory) -> Archive:
    """A sample of each further contact taken through the whole line, with fewer draws; not to be written into."""
    return _taken_through(FURTHER_IDS, tmp_path_factory.mktemp("further-samples"))


@pytest.fixture(scope="session")
def further_run(tmp_path_factory) -> Callable[[str], Archive]:
    """Take one sample of a further contact through the whole line the first time it is asked for."""
    return functools.cache(lambda run_id: _taken_through([run_id], tmp_path_factory.mktemp("further-sample")))


@pytest.fixture(scope="session")
def disc_pair(tmp_path_factory) -> Archive:
    """Two twin-disc samples taken through the whole line, with fewer draws; not to be written into."""
    return _taken_through(DISC_PAIR, tmp_path_factory.mktemp("disc-pair"))


@pytest.fixture(scope="session")
def disc_archive(tmp_path_factory) -> Archive:
    """All twin-disc samples taken through the whole line, with fewer draws; not to be written into."""
    return _taken_through(DISC_IDS, tmp_path_factory.mktemp("disc-samples"))


def _taken_through(run_ids: list[str], folder: Path) -> Archive:
    archive = Archive(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 2_000)
        outcomes = list(process([SAMPLES / run_id for run_id in run_ids], archive))
    assert [outcome for outcome in outcomes if outcome.status == "failed"] == []
    return archive
