"""Goldens: what every command with --json says of the sample runs, and what their archive holds, as readable JSON.

`python tests/goldens.py --write` renews the files below tests/goldens; `git diff tests/goldens` then lists each number
that has changed, one a line. `python tests/goldens.py` shows what differs and writes nothing.
"""

import argparse
import io
import json
import math
import re
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import chdir, redirect_stderr, redirect_stdout
from contextvars import copy_context
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest import mock

import blas  # noqa: F401, before all that loads numpy
import numpy as np
from folders import ALL_IDS, ROOT, SAMPLES

from tribopipe.archive.store import Archive
from tribopipe.cli.app import main
from tribopipe.cli.summary import run_summary

FOLDER = ROOT / "tests" / "goldens"
RENEW = "python tests/goldens.py --write"
TOLERANCE = 1e-6
"""Relative, of numbers: other machines round the last digits otherwise."""
DIGITS = 9
LONGEST_SHOWN = 200
"""Characters of a value in a list of changes."""
LONGEST = 8
"""Longer lists are told by their length, first, last and mean; arrays of an archive without their length."""
VOLATILE = frozenset({"environment", "folder", "path", "program_version", "sha256", "size", "version", "versions"})
_VOLATILE_TEXT = re.compile(r"(.*[/\\])?\d{4}-\d\d-\d\dT\d\d[:-]|[0-9a-f]{64}\Z")
"""Keys of places and versions, and texts that are dates or fingerprints: a placeholder stands for what they hold."""
PLACEHOLDER = "…"
NAMES = ("id", "step", "name", "law", "model", "disc", "by", "path")
"""Keys by which the items of a list are told apart."""

PIN, OTHER_PIN, DISCS = "si3n4-air-200mN", "si3n4-air-400mN", "si3n4-twin-disc-4pct-100k"
STUDIES = ("si3n4-air", "wc-co-water", "si3n4-twin-disc")
SWEEP = f"""schema = "tribopipe.sweep/1"
[choices]
runs = ["{PIN}"]
[vary.recipe]
wear.correction = ["two-step", "model"]
"""
COMMANDS: Mapping[str, str] = {
    "formats-list": "formats list",
    "formats-detect": f"formats detect sample_runs/{PIN}/signals.csv",
    "new": f"new sample_runs/{PIN}/signals.csv --into drafts --id drafted",
    "check": "check sample_runs",
    "ingest": f"ingest sample_runs/{PIN} sample_runs/{DISCS} --archive other",
    "correct-drift": f"correct-drift {PIN} {DISCS} --archive other",
    "fit": f"fit {PIN} --law sarkar --archive other",
    "fit-discs": f"fit {DISCS} --archive other",
    "fit-together": f"fit {PIN} {OTHER_PIN} --together",
    "predict": f"predict {OTHER_PIN} {DISCS}",
    "predict-onto": f"predict --from {PIN} --onto {OTHER_PIN}",
    "predict-load": f"predict {PIN} --law sarkar --load 400mN --at 500m --depth 30um",
    "predict-published": f"predict {PIN} --scheme published --steps 500 --at 500m",
    "predict-folder": f"predict --run sample_runs/{PIN} --wear-coefficient 13.5e-9mm^3/(N*mm) --at 10m",
    "local-wear": f"local-wear {PIN} --steps-per-decade 3 --at 50m",
    "ls": "ls --where load<300mN",
    "show": f"show {PIN}",
    **{f"study-run-{study}": f"study run sample_runs/{study}.study.toml --no-figures" for study in STUDIES},
    "study-show": "study show",
    "sweep": "sweep choices.toml",
    "plan": f"plan {PIN} --interval 2%",
    "export-umeshmotion": f"export umeshmotion {PIN} --output subroutine",
    "export-csv": f"export csv {PIN} --output columns",
    "reproduce": f"reproduce {PIN}",
    "live": f"live sample_runs/{PIN} --once",
    "verify": "verify --archive other",
    "rescue": f"rescue other/{PIN}.h5 --to rescued",
    "mark-bad": f"mark-bad {PIN} --reason outlier --by lab --archive other",
    "tag": f"tag {PIN} --add first --by lab --archive other",
    "note": f"note {PIN} remark --by lab --archive other",
    "remove": f"remove {DISCS} --archive other",
    "restore": f"restore {DISCS} --archive other",
    "export-dataset": f"export dataset {PIN} --eln one.eln --no-report",
    "import": "import one.eln --archive imported",
    "simulate": "simulate simulated --plan sample_runs/plan.toml",
    "watch": "watch exports --template lab.toml --once --settle 0 --no-figures --archive watched",
}
"""Commands by the name of their golden, each as it is typed; in this order after `process`."""


def made(runs: Sequence[str], commands: Sequence[str]) -> dict[str, Any]:
    """Process sample runs and take commands on them; return each golden by its name."""
    with TemporaryDirectory(prefix="goldens-") as name, chdir(name):
        shutil.copytree(SAMPLES, "sample_runs")
        Path("choices.toml").write_text(SWEEP, encoding="utf-8")
        shutil.copy(ROOT / "tests" / "pages" / "lab.toml", "lab.toml")
        shutil.copytree(SAMPLES / PIN, "exports", ignore=shutil.ignore_patterns("*.toml", "*.json"))
        folders = [f"sample_runs/{run_id}" for run_id in runs]
        studied = ["sample_runs"] if set(runs) == set(ALL_IDS) else folders
        processed = document("process", *studied, "--no-figures")
        archive = Archive(Path("archive"))
        goldens = {f"process-{run_id}": of_run(archive, run_id, processed) for run_id in runs}
        return goldens | {one: plain(document(*COMMANDS[one].split())) for one in commands}


def document(*arguments: str) -> Any:
    """Take a command with --json; return its document, or the list of them where it writes one a line."""
    out, err = io.StringIO(), io.StringIO()
    with (
        mock.patch.object(sys, "argv", ["tribopipe", *arguments, "--json"]),
        redirect_stdout(out),
        redirect_stderr(err),
    ):
        try:
            copy_context().run(main)  # what one command sets (--json) is not for the next
        except SystemExit as ended:
            if ended.code:
                raise RuntimeError(f"tribopipe {' '.join(arguments)}: {err.getvalue()}") from None
    try:
        return json.loads(out.getvalue())
    except ValueError:
        return [json.loads(line) for line in out.getvalue().splitlines()]


def of_run(archive: Archive, run_id: str, processed: Mapping[str, Any]) -> Any:
    """Return what `process` says of a run, and what its archived steps hold beside that."""
    steps = archive.steps(run_id)
    summary = next(run for run in processed["runs"] if run["id"] == run_id)
    assert summary == run_summary(archive, run_id)
    curves = {name: {curve: told for curve, (told, _) in step.curves.items()} for name, step in steps.items()}
    return plain(
        {
            "summary": summary,
            "drift_correction": steps["drift_correction"].result.model_dump(mode="json"),
            "curves": curves,
            "steps": [
                {"step": outcome["step"] or outcome["stage"], **{key: outcome[key] for key in ("status", "findings")}}
                for outcome in processed["steps"]
                if outcome["id"] == run_id
            ],
        }
    )


def plain(told: Any) -> Any:
    """Return a document without what is empty or volatile, with short numbers, short lists and items by name."""
    if isinstance(told, Mapping):
        kept = {key: PLACEHOLDER if key in VOLATILE else plain(value) for key, value in _short(told).items()}
        return {key: value for key, value in kept.items() if value not in (None, [], {}, "")}
    if isinstance(told, np.ndarray):
        return {"first": plain(float(told[0])), "last": plain(float(told[-1])), "mean": plain(float(np.nanmean(told)))}
    if isinstance(told, list | tuple):
        return _items(told)
    if isinstance(told, float):
        return float(f"{told:.{DIGITS}g}") if math.isfinite(told) else str(told)
    return PLACEHOLDER if isinstance(told, str) and _VOLATILE_TEXT.match(told) else told


def _short(told: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a quantity as its value under its unit, and u."""
    if not {"value", "unit", "standard_uncertainty"} <= told.keys():
        return told
    unit, *others = told["unit"], *(told.keys() - {"value", "unit", "standard_uncertainty"})
    named = "value" if unit == "1" else unit
    return {named: told["value"], "u": told["standard_uncertainty"], **{key: told[key] for key in others}}


def _items(told: Sequence[Any]) -> Any:
    for key in NAMES:
        names = [item.get(key) if isinstance(item, Mapping) else None for item in told]
        if told and all(isinstance(name, str) for name in names) and len(set(names)) == len(told):
            return {
                name: plain({other: value for other, value in item.items() if other != key})
                for name, item in zip(names, told, strict=True)
            }
    if len(told) <= LONGEST:
        return [plain(item) for item in told]
    short = {"count": len(told), "first": plain(told[0]), "last": plain(told[-1])}
    if all(isinstance(item, int | float) for item in told):
        short["mean"] = plain(float(np.nanmean(np.asarray(told, dtype=np.float64))))
    return short


def differences(old: Any, new: Any, path: str = "", scale: float = 0.0) -> Iterator[str]:
    """Yield a line for each number and text that differs: its path of keys, the old value and the new one.

    A value may differ by a share of its standard uncertainty, too, since it may be a difference of large numbers.
    """
    if isinstance(old, dict) and isinstance(new, dict):
        spread = max((abs(one["u"]) for one in (old, new) if isinstance(one.get("u"), float)), default=0.0)
        for key in sorted({*old, *new}):
            yield from differences(old.get(key), new.get(key), f"{path}.{key}" if path else key, spread)
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for number, (before, now) in enumerate(zip(old, new, strict=True)):
            yield from differences(before, now, f"{path}[{number}]")
    elif not _same(old, new, scale):
        yield f"{path}: {_told(old)} -> {_told(new)}"


def _same(old: Any, new: Any, scale: float) -> bool:
    numbers = [one for one in (old, new) if isinstance(one, int | float) and not isinstance(one, bool)]
    if len(numbers) == 2:
        return math.isclose(*numbers, rel_tol=TOLERANCE, abs_tol=TOLERANCE * scale)
    return type(old) is type(new) and old == new


def _told(value: Any) -> str:
    text = "nothing" if value is None else json.dumps(value, ensure_ascii=False)
    return text if len(text) <= LONGEST_SHOWN else f"{text[:LONGEST_SHOWN]}…"


def changes(goldens: Mapping[str, Any]) -> list[str]:
    """Return what differs between goldens and those that are committed."""
    return [line for name, golden in goldens.items() for line in differences(committed(name), golden, f"{name}.json")]


def committed(name: str) -> Any:
    """Return a golden as it is committed; nothing of one that is not."""
    path = FOLDER / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def write(goldens: Mapping[str, Any]) -> None:
    """Write all goldens, and take away those that are none any more; what is the same within tolerance stays."""
    FOLDER.mkdir(exist_ok=True)
    for path in FOLDER.glob("*.json"):
        if path.stem not in goldens:
            path.unlink()
    for name, golden in goldens.items():
        if list(differences(committed(name), golden)):
            text = json.dumps(golden, indent=1, sort_keys=True, ensure_ascii=False)
            (FOLDER / f"{name}.json").write_text(f"{text}\n", encoding="utf-8", newline="\n")


def _main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--write", action="store_true", help="write the goldens anew")
    writes = parser.parse_args().write
    goldens = made(ALL_IDS, list(COMMANDS))
    print("\n".join(changes(goldens)))  # noqa: T201
    if writes:
        write(goldens)


if __name__ == "__main__":
    _main()
