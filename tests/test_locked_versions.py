"""requirements/locked.txt, by which the installation of README's first command can be repeated."""

import re
import tomllib

import pytest
from folders import ROOT
from packaging.requirements import Requirement

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
TEXT = (ROOT / "requirements" / "locked.txt").read_text(encoding="utf-8")
PINS = [
    Requirement(line.removesuffix("\\").strip()) for line in TEXT.splitlines() if re.match(r"[a-z0-9]", line, re.ASCII)
]
INSTALLED = re.search(r'pip install "\.\[([\w,]+)\]"', (ROOT / "README.md").read_text(encoding="utf-8"))[1].split(",")
"""Extras of README's first command."""
PYTHONS = [row.rpartition(" ")[2] for row in PROJECT["classifiers"] if "Python :: 3." in row]


def pinned(python: str) -> dict[str, str]:
    """The version of each package on a version of Python, on Linux."""
    machine = {"python_full_version": f"{python}.1", "python_version": python, "sys_platform": "linux"}
    held = [pin for pin in PINS if pin.marker is None or pin.marker.evaluate(machine)]
    assert len({pin.name for pin in held}) == len(held)
    return {pin.name: re.fullmatch(r"==([\w.]+)", str(pin.specifier))[1] for pin in held}


@pytest.mark.parametrize("python", PYTHONS)
def test_each_dependency_is_pinned_within_its_bounds(python):
    extras = (one for extra in INSTALLED for one in PROJECT["optional-dependencies"][extra])
    required = [Requirement(one) for one in (*PROJECT["dependencies"], *extras)]
    pins = pinned(python)
    assert [str(one) for one in required if not one.specifier.contains(pins.get(one.name, "0"))] == []


def test_each_pin_has_hashes():
    entries = re.split(r"(?m)^(?=[a-z0-9])", TEXT)[1:]
    assert len(entries) == len(PINS)
    assert all(re.search(r"--hash=sha256:[0-9a-f]{64}\b", entry) for entry in entries)


def test_no_registry_is_named():
    assert "://" not in TEXT
    assert "index-url" not in TEXT


def test_the_command_that_made_it_names_those_extras():
    command = re.search(r"(?m)^#\s+(uv pip compile .*)$", TEXT)[1]
    assert re.findall(r"--extra (\w+)", command) == INSTALLED
    assert command in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
