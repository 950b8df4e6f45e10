"""Where commands may write: over nothing that they did not make, and never into an archive or a run folder."""

import os
import shutil
import typing
from collections.abc import Iterator
from pathlib import Path

import pytest
from folders import SAMPLES, tree_bytes
from matplotlib.figure import Figure
from sweeps import others_slow
from typer.main import get_command

from tribopipe.base.errors import OutputError
from tribopipe.cli.app import app
from tribopipe.pipeline.output_paths import made_here, require_free, require_outside
from tribopipe.views.run_figures import save_figures

pytestmark = pytest.mark.usefixtures("few_draws")

RUN = "si3n4-air-200mN"
FILES = {
    ("export runs", "output"): "export runs --output {} --archive archive",
    ("export dataset", "ro_crate"): "export dataset --ro-crate {} --no-report --archive archive",
    ("export dataset", "eln"): "export dataset --eln {} --no-report --archive archive",
    ("report", "output"): f"report {RUN} --output {{}} --archive archive",
    ("sweep", "out"): "sweep sweep.toml --out {} --archive archive",
    ("sweep", "figure"): "sweep sweep.toml --figure {} --archive archive",
    ("live", "figure"): "live sample-run --once --figure {}",
}
"""Options that name a file to write, and a command that would write it."""
FOLDERS = {
    ("export csv", "output"): f"export csv {RUN} --output {{}} --archive archive",
    ("export umeshmotion", "output"): f"export umeshmotion {RUN} --output {{}} --archive archive",
    ("study new", "into"): "study new sample-run other-run --into {}",
    ("study figures", "into"): "study figures --into {} --archive archive",
    ("local-wear", "figures"): f"local-wear {RUN} --steps-per-decade 2 --figures {{}} --archive archive",
    ("new", "into"): "new bare.csv --into {}",
    ("rescue", "into"): f"rescue {RUN}.h5 --to {{}}",
    ("simulate", "folder"): f"simulate {{}} --plan {SAMPLES / 'plan.toml'}",
    ("schema export", "folder"): "schema export {}",
    ("demo", "folder"): "demo --folder {} --no-browser",
    ("watch", "runs"): "watch exports --once --settle 0 --runs {} --archive other",
}
"""Those that name a folder."""
READ = {
    *((command, "recipe") for command in ("process", "correct-drift", "fit", "predict", "local-wear", "study run")),
    *((command, "recipe") for command in ("sweep", "plan", "watch", "live")),
    *((command, "paths") for command in ("check", "ingest", "process", "study new")),
    *((command, "template") for command in ("new", "watch")),
    *(("new", name) for name in ("files", "ends")),
    *(("live", name) for name in ("run", "drift_from", "wear_from")),
    *(("sweep", name) for name in ("document", "reuse")),
    ("report", "details"),
    *(("rescue", "files"), ("import", "crate"), ("study run", "path"), ("simulate", "plan")),
    *(("export dataset", "dataset"), ("formats detect", "files"), ("predict", "run"), ("verify", "folder")),
    ("watch", "folder"),
}
"""Those that are only read. An archive is written into by its own commands."""


def path_options() -> Iterator[tuple[str, str]]:
    """Give every parameter of a command that takes a path, but for the archive."""

    def walk(command, name):
        for part, inner in getattr(command, "commands", {}).items():
            yield from walk(inner, f"{name} {part}".strip())
        if not getattr(command, "commands", {}):
            for parameter, kind in typing.get_type_hints(command.callback).items():
                if "Path" in str(kind) and parameter not in ("archive", "return"):
                    yield name, parameter

    return walk(get_command(app), "")


def test_every_option_that_takes_a_path_is_known():
    assert set(path_options()) == {*FILES, *FOLDERS, *READ}


def takes_force(name: str) -> bool:
    """Tell whether a command has ``--force``."""
    command = get_command(app)
    for part in name.split():
        command = command.commands[part]
    return "force" in typing.get_type_hints(command.callback)


def test_force_is_known_of_commands():
    assert takes_force("export runs")
    assert not takes_force("rescue")


@pytest.fixture
def place(archive, sample_run, other_run, tmp_path, monkeypatch) -> Path:
    """A folder with an archive, run folders, exports, and links to some of it."""
    monkeypatch.chdir(tmp_path)
    assert other_run.is_dir()
    shutil.copy(sample_run / "signals.csv", "bare.csv")
    shutil.copy(archive / f"{RUN}.h5", ".")
    (tmp_path / "exports").mkdir()
    shutil.copy("bare.csv", "exports")
    (tmp_path / "sweep.toml").write_text(
        f'schema = "tribopipe.sweep/1"\ntitle = "Choices"\n[choices]\nruns = ["{RUN}"]\n'
        '[vary.recipe]\nwear.correction = ["two-step", "model"]\n',
        encoding="utf-8",
    )
    for link, target in LINKS.items():
        (tmp_path / link).symlink_to(tmp_path / target, target_is_directory=target == "archive")
    return tmp_path


LINKS = (
    {}  # which need rights on Windows
    if os.name == "nt"
    else {"link.h5": f"archive/{RUN}.h5", "link.toml": "sample-run/run.toml", "linked": "archive"}
)


KEPT = ("archive", "sample-run", "other-run", f"{RUN}.h5", "bare.csv", "exports", "sweep.toml")
THERE = (
    f"archive/{RUN}.h5",
    f"{RUN}.h5",
    "sample-run/run.toml",
    "sample-run/signals.csv",
    "archive",
    *LINKS,
)
INSIDE = (
    "archive/new",
    "archive/studies/new",
    "sample-run/new",
    "sample-run/deeper/new",
    *(f"{one}/new" for one in LINKS),
)


def content(place: Path) -> dict:
    """All that must stay as it is; the catalogue and locks of an archive are made by whoever reads it."""
    found = {name: (place / name).read_bytes() for name in KEPT if (place / name).is_file()}
    for name in KEPT:
        if (place / name).is_dir():
            found |= {f"{name}/{path}": text for path, text in tree_bytes(place / name).items()}
    return found


def refused(run_cli, place, line: str, at: str, suffix: str) -> None:
    before = content(place)
    named = at if not at.endswith("new") else at + suffix
    told = run_cli(*line.format(named).split())
    assert told.exit_code != 0, f"{line.format(named)}\n{told.stderr}"
    assert content(place) == before, line.format(named)


@pytest.mark.slow
@pytest.mark.parametrize(
    "option", others_slow(map(pytest.param, FILES), ("export runs", "output"), ("live", "figure")), ids=" ".join
)
def test_no_file_is_written_over_or_into_an_archive_or_a_run(run_cli, place, option):
    suffix = {"eln": ".eln", "figure": ".svg"}.get(option[1], ".out")
    for at in (*THERE, *INSIDE):
        if option == ("live", "figure") and at.startswith("sample-run") and at.endswith("new"):
            continue  # its own picture beside the run
        refused(run_cli, place, FILES[option], at, suffix)
        if takes_force(option[0]) and at != f"{RUN}.h5":  # which --force replaces, outside of an archive
            refused(run_cli, place, f"{FILES[option]} --force", at, suffix)


@pytest.mark.slow
@pytest.mark.parametrize(
    "option",
    others_slow(map(pytest.param, FOLDERS), ("export csv", "output"), ("study new", "into"), ("new", "into")),
    ids=" ".join,
)
def test_no_folder_is_filled_in_an_archive_or_a_run(run_cli, place, option):
    for at in (*THERE, "sample-run", "archive/figs", "sample-run/deeper"):
        refused(run_cli, place, FOLDERS[option], at, "")
        if takes_force(option[0]):
            refused(run_cli, place, f"{FOLDERS[option]} --force", at, "")


@pytest.mark.slow
@pytest.mark.parametrize("option", [*FILES, *FOLDERS], ids=" ".join)
def test_same_commands_write_where_nothing_is(run_cli, place, option):
    if option == ("demo", "folder"):  # which ends in a web server
        return
    name = {"eln": "new.eln", "figure": "new.svg"}.get(option[1], "new")
    told = run_cli(*(FILES | FOLDERS)[option].format(name).split())
    assert told.exit_code == 0, told.stderr
    if option[0] not in ("study figures", "live"):  # of which nothing is there to draw
        assert (place / name).exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    others_slow(
        ["process other-run", "ingest other-run", f"note {RUN} dry", "ls", "verify", "fit"], "process other-run", "ls"
    ),
)
def test_no_file_is_taken_for_an_archive(run_cli, place, line):
    for at in (f"archive/{RUN}.h5", f"{RUN}.h5", "sample-run/run.toml", "sample-run/signals.csv", *LINKS):
        if at != "linked":
            refused(run_cli, place, f"{line} --archive {{}}", at, "")


def test_file_that_is_there_is_replaced_by_force_alone(run_cli, place):
    (place / "runs.csv").write_text("mine", encoding="utf-8")
    line = ["export", "runs", "--output", "runs.csv", "--archive", "archive"]
    told = run_cli(*line)
    assert (told.exit_code, (place / "runs.csv").read_text(encoding="utf-8")) == (1, "mine")
    assert "runs.csv: found an existing file; expected a new file; use --force to replace it" in told.stderr
    assert run_cli(*line, "--force").exit_code == 0
    assert RUN in (place / "runs.csv").read_text(encoding="utf-8")


@pytest.mark.slow
def test_own_pictures_and_schemas_are_known_again(run_cli, place):
    line = ["live", "sample-run", "--once", "--figure", "live.svg"]
    assert [run_cli(*line).exit_code for _ in range(2)] == [run_cli(*line).exit_code] * 2
    for _ in range(2):
        assert run_cli("schema", "export", "schemas").exit_code == 0
    for path in (place / "schemas").iterdir():
        assert made_here(path), path
    (place / "schemas" / "run.schema.json").write_text("{}", encoding="utf-8")
    before = tree_bytes(place / "schemas")
    assert run_cli("schema", "export", "schemas").exit_code == 1
    assert tree_bytes(place / "schemas") == before


def test_picture_of_somebody_else_stays(place):
    theirs = place / "live.svg"
    theirs.write_text("<svg>theirs</svg>", encoding="utf-8")
    with pytest.raises(OutputError, match="found an existing file"):
        require_free([theirs], own=made_here)


def test_figures_are_not_drawn_where_a_picture_of_somebody_else_stays(tmp_path, monkeypatch):
    (tmp_path / "b.svg").write_text("<svg>theirs</svg>", encoding="utf-8")
    monkeypatch.setattr("tribopipe.views.run_figures._picture", lambda *_, **__: pytest.fail("drawn in vain"))
    with pytest.raises(OutputError, match="found an existing file"):
        save_figures(tmp_path, {"a.png": Figure(), "b.svg": Figure()})


def test_link_to_nowhere_is_something_that_is_there(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    with pytest.raises(OutputError, match="found an existing file"):
        require_free([tmp_path / "link"])


def test_ordinary_folder_is_free(tmp_path):
    (tmp_path / "archive").mkdir()
    require_outside(tmp_path / "archive" / "new")
    require_free([tmp_path / "report.html"])
