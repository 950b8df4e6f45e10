"""What says the same in several places before a release: version, licence, versions of Python."""

import json
import re
import tomllib

from folders import ROOT

from tribopipe.version import VERSION

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CITATION = (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def cited(key: str) -> str:
    """What stands in CITATION.cff at a key of the software, without line breaks."""
    found = re.search(rf"(?m)^{key}:(?: >-)?\s*(.*(?:\n +\S.*)*)$", CITATION)
    assert found, key
    return " ".join(found[1].split())


def test_citation_says_what_the_package_says():
    assert cited("version") == VERSION
    assert cited("title") == PROJECT["name"]
    assert cited("license") == PROJECT["license"]
    assert cited("abstract") == PROJECT["description"]
    assert cited("keywords").removeprefix("- ").split(" - ") == PROJECT["keywords"]
    assert cited("authors").removeprefix("- name: ") == PROJECT["authors"][0]["name"]


def test_changelog_begins_with_this_version():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    heading = re.search(r"(?m)^## (.*)$", text)[1]
    assert re.fullmatch(rf"{re.escape(VERSION)} \((unreleased|\d{{4}}-\d\d-\d\d)\)", heading)


def test_oldest_python_is_the_same_everywhere():
    declared = [row.rpartition(" ")[2] for row in PROJECT["classifiers"] if "Python :: 3." in row]
    oldest = PROJECT["requires-python"].removeprefix(">=")
    assert declared[0] == oldest
    assert declared == [f"3.{11 + index}" for index in range(len(declared))]
    tools = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    assert tools["ruff"]["target-version"] == f"py{oldest.replace('.', '')}"
    assert f"Python {oldest} or later" in (ROOT / "README.md").read_text(encoding="utf-8")
    workflow = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    assert f"python: {json.dumps(declared)}" in workflow
    assert "os: [ubuntu-latest, macos-latest, windows-latest]" in workflow
