"""Which default tests run which functions of tribopipe, and how long each takes: where a mutant may be noticed.

Each function of a copy of the package says when it is called, and a plug-in of pytest asks after each test which did.
What runs in other processes goes unseen, and what tests share is counted for the first of them.
"""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

from mutant_sites import named

PLUGIN = """
import json, pathlib, time
import pytest

called, tests = set(), {}
add = called.add

@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    called.clear()
    start = time.perf_counter()
    yield
    tests[item.nodeid] = [time.perf_counter() - start, sorted(called)]
    return True

def pytest_sessionfinish():
    pathlib.Path(__file__).with_suffix(".json").write_text(json.dumps(tests), encoding="utf-8")
"""


def reach(package: Path, root: Path) -> dict[str, list[str]]:
    """Return the tests that run each function ("file::name"), the quickest first; those of a module under "file::".

    The functions of a copy of the package are changed for it.
    """
    folder = package.parent
    (folder / "mutant_calls.py").write_text(PLUGIN, encoding="utf-8")
    for path in package.rglob("*.py"):
        path.write_text(
            _telling(path.read_text(encoding="utf-8"), path.relative_to(folder).as_posix()), encoding="utf-8"
        )
    told = os.environ | {"PYTHONPATH": str(folder)}
    whole = [sys.executable, "-P", "-m", "pytest", "-q", "-n0", "-p", "no:cacheprovider", "-p", "mutant_calls"]
    subprocess.run(whole, cwd=root, env=told, stdout=subprocess.DEVNULL, check=False)
    tests = json.loads((folder / "mutant_calls.json").read_text(encoding="utf-8"))
    found: dict[str, list[str]] = {}
    for test, (_, called) in sorted(tests.items(), key=lambda one: one[1][0]):
        for name in dict.fromkeys([*called, *(f"{one.partition('::')[0]}::" for one in called)]):
            found.setdefault(name, []).append(test)
    return found


def _telling(source: str, file: str) -> str:
    """Return a module whose functions say that they are called."""
    tree = ast.parse(source)
    functions = [(node, name) for node, name in named(tree) if not isinstance(node, ast.ClassDef)]
    for node, name in functions:
        call = ast.parse(f"_mutant_called({f'{file}::{name}'!r})").body[0]
        node.body.insert(1 if ast.get_docstring(node) is not None else 0, call)
    after = 1 if ast.get_docstring(tree) is not None else 0
    while after < len(tree.body) and getattr(tree.body[after], "module", None) == "__future__":
        after += 1
    tree.body.insert(after, ast.parse("from mutant_calls import add as _mutant_called").body[0])
    return ast.unparse(ast.fix_missing_locations(tree))
