"""The base installation: everything but `browse` and `demo` works without the packages of the web server."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from folders import ROOT
from sweeps import others_slow

from tribopipe.cli.browse import SERVER_PACKAGES

EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
PROGRAM = """
import sys
from importlib.abc import MetaPathFinder

class NotInstalled(MetaPathFinder):
    def find_spec(self, fullname, path, target=None):
        if fullname.partition(".")[0] in {packages!r}:
            raise ModuleNotFoundError(f"No module named {{fullname!r}}", name=fullname)

sys.meta_path.insert(0, NotInstalled())
import tribopipe
[getattr(tribopipe, name) for name in tribopipe.__all__]
from tribopipe.cli.entry_point import main
main()
"""


def without_web(*arguments: str, cwd: Path) -> "subprocess.CompletedProcess[str]":
    """Run a command where no package of the server can be imported."""
    program = PROGRAM.format(packages=set(SERVER_PACKAGES))
    command = [sys.executable, "-c", program, *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, encoding="utf-8", timeout=300)


def test_the_extra_has_the_packages_of_the_server():
    assert [re.match(r"[\w-]+", one)[0] for one in EXTRAS["web"]] == list(SERVER_PACKAGES)
    assert "web" in re.search(r"\[(.*)\]", EXTRAS["test"][0])[1].split(",")


@pytest.mark.slow
def test_a_run_is_processed_without_the_packages_of_the_server(sample_run):
    done = without_web("process", sample_run.name, cwd=sample_run.parent)
    assert done.returncode == 0, done.stderr
    assert (sample_run.parent / "archive" / "si3n4-air-400mN.h5").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("command", others_slow(["browse", "demo"], "demo"))
def test_commands_of_the_server_name_the_extra(command, archive):
    done = without_web(command, "--no-browser", cwd=archive.parent)
    assert done.returncode == 1
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert "found no package anyio" in line
    assert 'run `pip install "tribopipe[web]"`' in line
    assert not (archive.parent / "tribopipe-demo").exists()
