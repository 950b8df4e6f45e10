"""The script that makes mutants: where it finds places for them, how it draws, and that its list fits the code."""

import subprocess
import sys
from dataclasses import replace

import pytest
from folders import ROOT
from mutant_sites import bounds, draw, function_at, sites
from mutants import Mutant, misplaced, mutants

SOURCE = '''\
"""A module: 1 + 1."""

LIMIT = 2.0


class Pin:
    """A pin."""

    @dataclass(order=True)
    def depth(self, worn: list[0], radius=1) -> "a[0]":
        """Return 1 < 2."""
        if worn[-1] < -radius and not radius:
            raise ValueError(worn[0] + 1)
        µ = max(worn[0], LIMIT) * 2  # columns count characters
        return f"{µ + 1}" + "a", zip(worn, worn, strict=True)


def depth(a, b):
    return a is b or a >= b
'''


def changed(site) -> str:
    line = SOURCE.splitlines()[site.line - 1]
    return line[: site.start] + site.choices[0] + line[site.end :]


def test_places_are_those_where_meaning_may_change():
    found = {(site.kind, changed(site).strip()) for site in sites(SOURCE)}
    assert found == {
        ("constant", "LIMIT = 4.0"),
        ("constant", 'def depth(self, worn: list[0], radius=2) -> "a[0]":'),
        ("comparison", "if worn[-1] <= -radius and not radius:"),
        ("index", "if worn[0] < -radius and not radius:"),
        ("sign", "if worn[-1] < radius and not radius:"),
        ("boolean", "if worn[-1] < -radius or not radius:"),
        ("boolean", "if worn[-1] < -radius and radius:"),
        ("extreme", "µ = min(worn[0], LIMIT) * 2  # columns count characters"),
        ("index", "µ = max(worn[-1], LIMIT) * 2  # columns count characters"),
        ("arithmetic", "µ = max(worn[0], LIMIT) / 2  # columns count characters"),
        ("constant", "µ = max(worn[0], LIMIT) * 3  # columns count characters"),
        ("boolean", "return a is b and a >= b"),
        ("comparison", "return a is not b or a >= b"),
        ("comparison", "return a is b or a > b"),
    }


def test_functions_are_found_by_name_with_their_class():
    assert bounds(SOURCE, "Pin.depth") == (9, 15)
    assert bounds(SOURCE, "") == (0, 19)
    assert [function_at(SOURCE, line) for line in (3, 12, 19)] == ["", "Pin.depth", "depth"]
    with pytest.raises(LookupError, match="found 0 functions named disc"):
        bounds(SOURCE, "disc")


def test_a_mutant_changes_one_place_and_is_refused_where_there_are_more_or_none():
    mutant = Mutant("depth grows", "pin.py", old="a >= b", new="a > b", within="depth")
    assert mutant.applied(SOURCE) == SOURCE.replace("a >= b", "a > b")
    for old, times in (("a", 3), ("worn", 0)):
        with pytest.raises(LookupError, match=f"found the old text {times} times"):
            replace(mutant, old=old).applied(SOURCE)


def test_a_draw_is_the_same_again_and_another_one_with_another_seed(tmp_path):
    (tmp_path / "pin.py").write_text(SOURCE, encoding="utf-8")
    (tmp_path / "disc.py").write_text("def f(a, b, c):\n    return a + b * c - 1\n", encoding="utf-8")
    groups = {"one": ["pin.py"], "two": ["d*.py"]}
    first = draw(tmp_path, groups, 3, 6)
    assert draw(tmp_path, groups, 3, 6) == first
    assert draw(tmp_path, groups, 4, 6) != first
    assert [one.file for one in first] == ["pin.py", "disc.py"] * 3
    for one in first:
        Mutant("drawn", one.file, one.old, one.new, one.within).applied((tmp_path / one.file).read_text("utf-8"))


@pytest.mark.slow
@pytest.mark.skipif(not (ROOT / "tribopipe").is_dir(), reason="the sources of the package are not here")
def test_every_mutant_of_the_list_has_its_place_in_the_code_and_a_default_test():
    listed = mutants()
    assert list(misplaced([*listed, *mutants("survivor")])) == []
    assert [one.changes for one in listed if not one.killed_by] == []
    assert len({one.changes for one in listed}) == len(listed)


@pytest.mark.slow
def test_script_tells_what_survives_from_what_is_killed():
    ended = subprocess.run(
        [sys.executable, "tests/mutants.py", "--only", "slip of two discs"], cwd=ROOT, capture_output=True, text=True
    )
    assert (ended.returncode, ended.stdout.splitlines()[-1].partition(";")[0]) == (0, "1 of 1 mutants killed")
