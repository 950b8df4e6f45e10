"""What a release is made with agrees with pyproject.toml and the version."""

import json
import re
import shutil
import subprocess
import tomllib
from datetime import datetime

import pytest
import yaml
from folders import ROOT

from tribopipe.version import VERSION

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CONDA_NAMES = {"matplotlib": "matplotlib-base", "isal": "python-isal"}
"""Packages that conda has under another name."""


def loaded(name: str) -> dict:
    return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))


def test_the_conda_recipe_needs_what_the_package_and_its_server_need():
    recipe = loaded("recipe/recipe.yaml")
    required = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["web"]]
    needed = [re.fullmatch(r"([\w-]+)(.*)", one).groups() for one in required]
    expected = [f"{CONDA_NAMES.get(name, name)} {bound}" for name, bound in needed]
    assert recipe["requirements"]["run"] == [f"python {PROJECT['requires-python']}", *expected]
    (command,) = recipe["build"]["python"]["entry_points"]
    assert command == f"tribopipe = {PROJECT['scripts']['tribopipe']}"


def test_the_version_is_the_same_everywhere():
    assert loaded("recipe/recipe.yaml")["context"]["version"] == VERSION
    assert str(loaded("CITATION.cff")["version"]) == VERSION
    assert json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))["version"] == VERSION
    # The image is made of the clone, and so of its version; a number of its own could only be another one.
    assert not re.search(r"tribopipe[=:]+[\d.]+", (ROOT / "Dockerfile").read_text(encoding="utf-8"))


def test_zenodo_and_citation_name_who_the_package_names():
    zenodo = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    names = [one["name"] for one in PROJECT["authors"]]
    assert [one["name"] for one in zenodo["creators"]] == names
    assert [one["name"] for one in loaded("CITATION.cff")["authors"]] == names
    assert zenodo["license"] == PROJECT["license"]
    assert zenodo["keywords"] == PROJECT["keywords"]


def test_the_paper_has_what_joss_asks_for():
    _, front, text = (ROOT / "paper.md").read_text(encoding="utf-8").split("---\n", 2)
    said = yaml.safe_load(front)
    assert said.keys() >= {"title", "tags", "authors", "affiliations", "date", "bibliography"}
    assert [one["name"] for one in said["authors"]] == [one["name"] for one in PROJECT["authors"]]
    assert re.findall(r"(?m)^# (.+)", text) == [
        "Summary",
        "Statement of need",
        "State of the field",
        "Software design",
        "Validation",
        "Research impact statement",
        "AI usage disclosure",
        "References",
    ]
    bib = (ROOT / said["bibliography"]).read_text(encoding="utf-8")
    assert set(re.findall(r"@(\w+)[\];]", text)) == set(re.findall(r"(?m)^@\w+\{(\w+),", bib))
    assert {one["affiliation"] for one in said["authors"]} <= {one["index"] for one in said["affiliations"]}
    datetime.strptime(said["date"], "%d %B %Y")  # noqa: DTZ007
    assert 750 <= len(text.split()) <= 1750


def test_each_reference_of_the_paper_is_complete():
    entries = re.split(r"(?m)^@", (ROOT / "paper.bib").read_text(encoding="utf-8"))[1:]
    for entry in entries:
        assert entry.rstrip().endswith("\n}")
        assert entry.count("{") == entry.count("}")
        assert {"author", "title", "year"} <= set(re.findall(r"(?m)^  (\w+) = \{", entry)), entry


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("pandoc") is None, reason="needs pandoc and XeLaTeX")
def test_the_paper_is_typeset_with_its_references(tmp_path):
    made = ["pandoc", "paper.md", "--citeproc", "--fail-if-warnings", "--pdf-engine=xelatex", "-o"]
    done = subprocess.run([*made, str(tmp_path / "paper.pdf")], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "paper.pdf").read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize("name", ["ISSUE_TEMPLATE/bug.yml", "ISSUE_TEMPLATE/format.yml"])
def test_issue_forms_have_what_github_asks_for(name):
    form = loaded(f".github/{name}")
    assert form.keys() >= {"name", "description", "body"}
    assert all(one.keys() >= {"type", "attributes"} for one in form["body"])


def test_publishing_stores_no_password():
    text = (ROOT / ".github/workflows/release.yml").read_text(encoding="utf-8")
    jobs = yaml.safe_load(text)["jobs"]
    assert jobs["publish"]["permissions"] == {"id-token": "write"}
    assert "secrets." not in text
