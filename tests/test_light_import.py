"""`tribopipe --help` and completion are quick because nothing heavy is imported before it is needed."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from sweeps import others_slow

HEAVY = {"numpy", "pandas", "scipy", "h5py", "matplotlib", "pydantic", "pint"}


def heavy_modules_after(code: str) -> set[str]:
    report = (
        f"{code}\nimport json, sys\nprint('\\n' + json.dumps(sorted({{name.split('.')[0] for name in sys.modules}})))"
    )
    done = subprocess.run([sys.executable, "-c", report], capture_output=True, text=True, encoding="utf-8", check=True)
    return HEAVY & set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize("code", ["import tribopipe", "import tribopipe; dir(tribopipe)", "import tribopipe.cli.app"])
def test_nothing_heavy_is_imported_by(code):
    assert heavy_modules_after(code) == set()


@pytest.mark.parametrize("arguments", others_slow([["--help"], ["process", "--help"], ["--version"]]), ids=" ".join)
def test_help_needs_nothing_heavy(arguments):
    run = f"from tribopipe.cli.app import app; app({arguments}, standalone_mode=False)"
    assert heavy_modules_after(run) <= {"pydantic"}  # which typer itself may import


@pytest.mark.slow
def test_what_is_heavy_is_seen():
    assert heavy_modules_after("import tribopipe.base.units; tribopipe.base.units.parse('1 ft', 'length')") >= {
        "numpy",
        "pint",
    }


@pytest.mark.slow
@pytest.mark.parametrize("sample", others_slow(["wc-co-water-400mN", "steel-four-ball-147N", "peek-block-on-ring-50N"]))
def test_a_run_in_ordinary_units_is_read_without_pint(sample):
    folder = Path(__file__).parents[1] / "sample_runs" / sample
    assert "pint" not in heavy_modules_after(
        f"from tribopipe.readers.harmonize import read_run; read_run({str(folder)!r})"
    )


def test_public_names_are_all_there():
    import tribopipe

    assert [name for name in tribopipe.__all__ if not hasattr(tribopipe, name)] == []
    with pytest.raises(AttributeError, match="no_such_name"):
        tribopipe.no_such_name  # noqa: B018
