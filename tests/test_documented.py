"""Every command and snippet that the README and the documentation show, followed from top to bottom page by page."""

import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from functools import cache
from pathlib import Path

import pytest
from documented import Block, Command, blocks, code_spans, difference, pages, tokens
from documented_runs import PageFolder
from filelock import FileLock
from folders import ROOT, SAMPLES
from typer.main import get_command

from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.documents.record import read_document
from tribopipe.results.json_schema import SCHEMAS

PAGES = pages()
TUTORIAL = "docs/tutorial.md"
"""The page that CI follows in a fresh environment, by tests/follow_tutorial.py."""
NOTEBOOK = ROOT / "docs" / "tutorial_in_python.ipynb"
NOT_RUN = {
    "README.md": 3,
    "CONTRIBUTING.md": 6,
    "docs/archive.md": 2,
    "docs/browse.md": 1,
    "docs/cluster.md": 5,
    "docs/long_runs.md": 1,
    "docs/new_run.md": 2,
    "docs/notebook.md": 2,
    "docs/process.md": 1,
    "docs/remote.md": 2,
    "docs/report.md": 2,
    "docs/sweep.md": 1,
    "docs/tutorial.md": 1,
    "docs/watch.md": 3,
    "docs/wear_laws.md": 2,
}
"""How many blocks of each page are not run; each says why."""
WHOLE = {
    "run": SAMPLES / "si3n4-air-200mN" / "run.toml",
    "twin-disc run": SAMPLES / "si3n4-twin-disc-4pct-1000k" / "run.toml",
    "study": SAMPLES / "si3n4-air.study.toml",
}
"""Documents whose keys are replaced by those of a part that a page shows."""


@pytest.fixture(scope="session")
def archived_samples(tmp_path_factory) -> Path:
    """An archive of all sample runs and studies as `process` leaves it; test processes share it, to be copied."""
    if (ready := os.environ.get("DOCUMENTED_ARCHIVE")) is not None:
        return Path(ready)
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    archive = folder / "documented" / "archive"
    with FileLock(folder / "documented.lock"):
        if not archive.exists():
            line = [
                sys.executable,
                "-m",
                "tribopipe",
                "process",
                SAMPLES,
                "--archive",
                archive,
                "-j",
                "2",
            ]
            subprocess.run(line, check=True, capture_output=True)
    return archive


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if page != TUTORIAL])
def test_all_that_a_page_shows_is_so(page, archived_samples, tmp_path):
    here = PageFolder(tmp_path, archived_samples)
    for block in blocks(page):
        here.lay(block.said.get("given", ""))
        follow(block, here)


def follow(block: Block, here: PageFolder) -> None:
    """Do with a block what its kind asks for."""
    file = block.said.get("file")
    match block.kind:
        case "output":
            wrong = difference(tuple(block.text.splitlines()), here.printed)
            assert not wrong, f"{block.place}\n{wrong}"
        case "toml":
            check_toml(block)
        case "json":
            json.loads(block.text)
        case "python":
            here.run_python(block, file or "script.py")
        case "commands":
            here.run(block)
    if file is not None:
        here.write(file, block.text)


def check_toml(block: Block) -> None:
    """Validate TOML as the record that it is, or is part of."""
    document = tomllib.loads(block.text)
    kind = block.said.get("as")
    if kind == "pyproject":
        return
    if kind is None:
        kind = document["schema"].removeprefix("tribopipe.").partition("/")[0]
    elif kind in WHOLE:
        document = tomllib.loads(WHOLE[kind].read_text(encoding="utf-8")) | document
    else:
        document = {"schema": f"tribopipe.{kind}/1"} | document
    read_document(document, SCHEMAS[kind.split()[-1]], where=block.place)


@pytest.mark.slow
def test_the_notebook_runs_from_top_to_bottom():
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbclient.NotebookClient(notebook, timeout=120).execute(cwd=str(NOTEBOOK.parent))
    shown = [output.output_type for cell in notebook.cells for output in cell.get("outputs", ())]
    assert "error" not in shown
    assert shown.count("display_data") + shown.count("execute_result") >= 5


# --- what takes no time, for every page ---


def test_the_notebook_is_kept_without_outputs():
    cells = json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]
    assert [cell for cell in cells if cell.get("outputs") or cell.get("execution_count")] == []


@pytest.mark.parametrize("page", PAGES)
def test_every_block_is_run_or_says_why_not(page):
    for block in blocks(page):
        assert block.kind or not block.text, f"{block.place}: neither run nor compared; expected <!-- not run: why -->"
        assert len(block.said.get("not run", "as good as any")) > 10, f"{block.place}: say why"
        prompts = [line for line in block.text.splitlines() if line.startswith("$ ")]
        assert block.language == "console" or not prompts, f"{block.place}: a console of no language"


@pytest.mark.parametrize("page", PAGES)
def test_no_output_is_left_out_altogether(page):
    for block in blocks(page):
        outputs = [command.output for command in block.commands if any(command.output)]
        for shown in [*outputs, *([block.text.splitlines()] if block.kind == "output" else [])]:
            assert {line.strip() for line in shown} - {"", "…"}, f"{block.place}: shows nothing of what is printed"


def test_no_page_of_the_repository_is_left_out():
    listing = ["git", "ls-files", "-z", "*.md"]
    done = subprocess.run(listing, cwd=ROOT, capture_output=True, check=False)
    if done.returncode != 0:
        pytest.skip("this is no clone")
    known = {*PAGES, "CHANGELOG.md"}
    others = [name for name in done.stdout.decode("utf-8").split("\0") if name and name not in known]
    assert [name for name in others if not name.startswith("docs/results/")] == []


def test_no_block_hides_in_html():
    html = [token.content for page in PAGES for token in tokens(page) if token.type == "html_block"]
    assert [text for text in html if "<pre" in text or "<code" in text] == []


def test_groups_that_the_page_on_archives_lists_are_declared():
    declared = {part.name for part in definitions()["NXtribometry_pin_on_disc"].entry.members}
    listed = re.findall(r"^/entry/(\w+)", next(blocks("docs/archive.md")).text, re.MULTILINE)
    assert len(listed) > 10
    assert set(listed) <= declared


def test_what_is_not_run_is_little():
    counts = {page: sum("not run" in block.said for block in blocks(page)) for page in PAGES}
    assert {page: count for page, count in counts.items() if count} == NOT_RUN


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_commands_within_sentences_exist(page):
    wrong = [span for span in code_spans(page) if span.startswith("tribopipe ") and not is_command(span)]
    assert wrong == []


@cache
def is_command(line: str) -> bool:
    """Tell whether a line names a command that exists, and options that it has."""
    from tribopipe.cli.app import app

    command = get_command(app)
    words = shlex.split(line.replace("…", ""))[1:]
    while words and words[0] in getattr(command, "commands", ()):
        command = command.commands[words.pop(0)]
    known = {name for option in command.params for name in (*option.opts, *option.secondary_opts)} | {"--help", "-h"}
    unknown_command = hasattr(command, "commands") and words and not words[0].startswith("-")
    options = (re.split("[= ]", word)[0] for word in words if word.startswith("-"))
    return not unknown_command and all(option in known for option in options)


# --- the checker itself ---


@pytest.mark.parametrize(
    ("shown", "printed"),
    [
        (["k_D = 1.4"], "k_D = 1.4\n"),
        (["k_D = …"], "k_D = 1.4 ± 0.1\n"),
        (["first", "…", "last"], "first\n1\n2\nlast\n"),
        (["a (b) …", "", "c"], "a (b) 12\n\nc  \n"),
    ],
)
def test_an_ellipsis_stands_for_what_changes(shown, printed):
    assert difference(tuple(shown), printed) == ""


@pytest.mark.parametrize(
    ("shown", "printed"),
    [
        (["k_D = 1.4"], "k_D = 1.5\n"),
        (["k_D = …"], "mu = 1.4\n"),
        (["first", "…", "last"], "first\nlast\n"),
        (["first"], "first\nsecond\n"),
        (["k_D …"], "k_D 1\nmore\n"),
    ],
)
def test_anything_else_is_a_difference(shown, printed):
    assert "as it was printed" in difference(tuple(shown), printed)


@pytest.mark.parametrize(
    ("text", "commands"),
    [
        (
            "tribopipe ls  # all\n\ntribopipe \\\n  show A\n",
            [Command("tribopipe ls  # all"), Command("tribopipe   show A")],
        ),
        (".venv/bin/pip install .\n", [Command(".venv/bin/pip install .")]),
        ("k = V/(F_N·s)\n", []),
        ("/entry/raw   signals\n", []),
    ],
)
def test_commands_are_told_from_formulas(text, commands):
    assert Block("page.md", 1, "", text).commands == commands
