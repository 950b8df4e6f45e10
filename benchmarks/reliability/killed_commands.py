"""`watch`, `import` and `process -j 2` killed after their first write, and given again.

    python benchmarks/reliability/killed_commands.py --points 200

Each command begins in a folder that holds run folders, exports and a crate, and no archive. It is killed so long after
its first file in the archive (or of `watch` its first run folder) as chance says, every other time with all its
processes, as when the power fails, else alone, so that its workers outlive it. Then every archived file has to be
whole, with what was recorded, and the same command, given again, has to complete: with the archive that one finds where
nobody killed, no temporary file anywhere, and nothing wrong for `verify`. POSIX only.

With ``--kept FILE`` what was found is written there after each kill, and a later call goes on from it.
"""

import json
import os
import shutil
import signal
import sys
import tempfile
import time
import tomllib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from forks import command, ended, forked
from held import RAW, content, contents, differences, files
from short_runs import quick_recipe, short_runs
from told import Row, asked, tell

from tribopipe.archive.store import Archive
from tribopipe.base.files import found_below
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml
from tribopipe.pipeline import stages as pipeline
from tribopipe.readers.draft.known_values import toml
from tribopipe.views.archived_figures import save_run_figures

RUNS = 2
_WAIT = 0.002
"""How often is looked whether something was written, s."""
_LONGEST = 60.0
"""How long a command may take, s."""
WRONG = {
    "unreadable": "unreadable files",
    "changed": "runs with changed raw data",
    "lost": "lost files",
    "failed": "next command failed",
    "different": "results that differ from those without interruption",
    "left over": "temporary files left by the next command",
    "remarked on": "findings of `verify`",
}
"""What may go wrong, as the table calls it."""


@dataclass(frozen=True)
class Command:
    """What is killed."""

    name: str
    words: Sequence[object]
    """Behind `tribopipe`, in the folder where it works."""
    whole: dict[str, dict[str, bytes]]
    """What its archive holds where nobody kills."""
    seconds: float
    """From its first write to its end, s."""


@dataclass
class Found:
    """What became of one command."""

    kills: int = 0
    ended: int = 0
    """Commands that came to their end before they could be killed."""
    parts: int = 0
    """Temporary files there after the kills, and gone after the next command."""
    wrong: dict[str, list[str]] = field(default_factory=lambda: defaultdict(list))


class Kept:
    """What was found so far, in a file where that is wanted."""

    def __init__(self, path: Path | None, seed: int) -> None:
        self._path, self._seed = path, seed
        told = json.loads(path.read_text(encoding="utf-8")) if path is not None and path.exists() else {}
        self._found = {name: Found(**one | {"wrong": defaultdict(list, one["wrong"])}) for name, one in told.items()}

    def of(self, name: str) -> Found:
        """Return what was found of a command."""
        return self._found.setdefault(name, Found())

    def chance_of(self, name: str) -> Random:
        """Return what the moment of the next kill is drawn from, which is the same however often one goes on."""
        found = self.of(name)
        return Random(f"{self._seed} {name} {found.kills + found.ended}")  # noqa: S311

    def keep(self) -> None:
        """Write what was found."""
        if self._path is not None:
            told = {name: vars(found) for name, found in self._found.items()}
            self._path.write_text(json.dumps(told), encoding="utf-8")


class Bench:
    """A folder of what commands begin with, and those commands."""

    def __init__(self, scratch: Path) -> None:
        self.given, self.at, self.said = scratch / "given", scratch / "at", scratch / "said.txt"
        self._make_given()
        self.raw: dict[str, dict[str, bytes]] = {}
        process: list[object] = ["process", "runs", "--jobs", 2, "--archive", "archive", "--recipe", "recipe.toml"]
        watch: list[object] = ["watch", "exports", "--once", "--settle", 0, "--jobs", 1, "--recipe", "recipe.toml"]
        watch += ["--template", "template.toml", "--runs", "made", "--archive", "archive"]
        words: dict[str, list[object]] = {
            "watch": watch,
            "import": ["import", "crate", "--archive", "archive"],
            "process -j 2": process,
        }
        self.commands = [self._undisturbed(name, said) for name, said in words.items()]

    def _make_given(self) -> None:
        """Write run folders, exports with a template, and a crate."""
        self.given.mkdir()
        runs, recipe = short_runs(self.given / "runs", RUNS), quick_recipe(self.given)
        archive = self.given / "source"
        failed = [one for one in pipeline.process(runs, Archive(archive), load_toml(recipe, Recipe)) if one.error]
        if failed:
            raise RuntimeError(failed)
        save_run_figures(Archive(archive), runs[0].name)  # so that what draws is at hand
        (self.given / "exports").mkdir()
        for run in runs:
            shutil.copy(run / "signals.csv", self.given / "exports" / f"{run.name}.csv")
        known = tomllib.loads((runs[0] / "run.toml").read_text(encoding="utf-8"))
        told = {"schema": "tribopipe.template/1"} | {key: known[key] for key in ("contact", "conditions", "end_values")}
        text = "".join(f"{key} = {toml(value)}\n" for key, value in told.items())
        (self.given / "template.toml").write_text(text, encoding="utf-8")
        words = ["export", "dataset", "--ro-crate", "crate", "--no-report", "--archive", "source"]
        self._run(words, self.given)
        shutil.rmtree(archive)

    def _run(self, words: Sequence[object], at: Path) -> None:
        """Run a command to its end. Raises ``RuntimeError`` where that is not a good one."""
        child, reading = self._begun(words, at)
        _drain(reading)
        if (code := ended(child)) != 0:
            raise RuntimeError(f"{words}: exit code {code}\n{self.said.read_text(encoding='utf-8')}")

    def _begun(self, words: Sequence[object], at: Path) -> tuple[int, int]:
        """Begin a command with processes of its own; return its number and what ends with the last of them."""
        reading, writing = os.pipe()

        def work() -> None:
            os.setsid()
            os.chdir(at)
            os.dup2(writing, 0)  # which processes that it begins have from it
            command(*words)()

        self.said.unlink(missing_ok=True)
        child = forked(work, self.said)
        os.close(writing)
        return child, reading

    def _undisturbed(self, name: str, words: Sequence[object]) -> Command:
        """Run a command as often as it takes to know what it makes and how long that takes."""
        shutil.copytree(self.given, self.at)
        child, reading = self._begun(words, self.at)
        self._await_write(child)
        start = time.monotonic()
        _drain(reading)
        seconds = time.monotonic() - start
        if (code := ended(child)) != 0:
            raise RuntimeError(f"{name}: exit code {code}\n{self.said.read_text(encoding='utf-8')}")
        whole = contents(self.at / "archive")
        for path in files(self.at / "archive"):
            self.raw[f"{name} {path.stem}"] = content(path, RAW)
        shutil.rmtree(self.at)
        return Command(name, words, whole, seconds)

    def _await_write(self, child: int) -> None:
        """Wait until a command has begun to write."""
        end = time.monotonic() + _LONGEST
        places = [self.at / "archive", self.at / "made"]
        while not any(path.suffix != ".lock" for place in places for path in _below(place)):
            if time.monotonic() > end:
                raise RuntimeError(f"process {child} wrote nothing: {self.said.read_text(encoding='utf-8')}")
            time.sleep(_WAIT)

    def kill(self, one: Command, points: int, minutes: float, kept: "Kept") -> Found:
        """Kill a command so many times, or for so long."""
        found, end = kept.of(one.name), time.monotonic() + 60 * minutes
        while found.kills < points and time.monotonic() < end:
            shutil.copytree(self.given, self.at)
            child, reading = self._begun(one.words, self.at)
            self._await_write(child)
            time.sleep(kept.chance_of(one.name).uniform(0.0, one.seconds))
            (os.killpg if found.kills % 2 else os.kill)(child, signal.SIGKILL)
            _drain(reading)
            if ended(child) == -signal.SIGKILL:
                found.kills += 1
            else:
                found.ended += 1
            self._look(one, found)
            shutil.rmtree(self.at)
            kept.keep()
        return found

    def _look(self, one: Command, found: Found) -> None:
        """Look at what is there, give the command again, and look once more."""
        there, wrong = files(self.at / "archive"), found.wrong
        for path in there:
            try:
                if content(path, RAW) != self.raw[f"{one.name} {path.stem}"]:
                    wrong["changed"].append(path.name)
            except (OSError, KeyError, RuntimeError) as error:
                wrong["unreadable"].append(f"{path.name}: {error}")
        parts = found_below(self.at, "*.part")
        found.parts += len(parts)
        try:
            self._run(one.words, self.at)
        except RuntimeError as error:
            wrong["failed"].append(str(error))
        wrong["lost"] += [path.name for path in there if not path.exists()]
        wrong["different"] += differences(contents(self.at / "archive"), one.whole)
        wrong["left over"] += [str(path.relative_to(self.at)) for path in found_below(self.at, "*.part", "*-journal")]
        try:
            self._run(["verify", "--archive", "archive"], self.at)
        except RuntimeError as error:
            wrong["remarked on"].append(str(error))


def _below(folder: Path) -> Iterator[Path]:
    """Give the files below a folder, which may come and go meanwhile."""
    for path, _, names in os.walk(folder):
        yield from (Path(path, name) for name in names)


def _drain(reading: int) -> None:
    """Read until the last process that could write has ended."""
    with os.fdopen(reading, "rb") as file:
        while file.read(1 << 16):
            pass


def rows(found: dict[str, Found]) -> list[Row]:
    """Return what was found as rows of a table."""
    made = []
    for name, one in found.items():
        made += [
            Row(f"`{name}` killed after its first write", str(one.kills)),
            Row(f"`{name}`: temporary files after the kills", str(one.parts)),
        ]
        made += [
            Row(f"`{name}`: {label}", str(len(one.wrong[what])), "0", not one.wrong[what])
            for what, label in WRONG.items()
        ]
    return made


def main() -> int:
    """Kill, and tell what was found."""
    parser = asked(__doc__, points=200)
    parser.add_argument("--minutes", type=float, default=60.0, help="at most for each command (%(default)s)")
    parser.add_argument("--kept", type=Path, help="file of what was found so far, to go on from")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        bench, kept = Bench(Path(scratch)), Kept(options.kept, options.seed)
        found = {one.name: bench.kill(one, options.points, options.minutes, kept) for one in bench.commands}
    for name, one in found.items():
        for what, wrong in one.wrong.items():
            print(*(f"{name}: {what}: {text}" for text in wrong[:5]), sep="\n", file=sys.stderr)
    return tell(
        "killed_commands",
        "Commands killed after their first write",
        options,
        rows(found),
        f"`watch`, `import` and `process -j 2` with {RUNS} short runs, each in a new folder, are killed at a random "
        "time between the first write and the end, alone or with their workers. Then the same command is run again."
        + (
            ""
            if options.kept is None
            else " The benchmark was run in several parts, and other code of tribopipe was changed between these parts."
        ),
    )


if __name__ == "__main__":
    sys.exit(main())
