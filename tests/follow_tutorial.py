"""Follows docs/tutorial.md to the letter where nothing of tribopipe is yet: `python tests/follow_tutorial.py [FOLDER]`.

What git knows of the clone is copied into another folder, and installed there as the page says. Then each command of
the page is run in order, its output is compared with what the page shows, and its time is told. Ends with exit code 1
at the first command that prints anything else.
"""

import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from documented import Block, Command, blocks
from documented_runs import PageError, PageFolder
from folders import ROOT

PAGE = "docs/tutorial.md"
PROGRAMS = Path(".venv") / ("Scripts" if sys.platform == "win32" else "bin")


class Follower(PageFolder):
    """A reader with a watch, who has the clone and so lays nothing into it."""

    seconds = 0.0

    def lay(self, given: str) -> None:
        """Find there what is given: the clone has it."""

    def do(self, command: Command) -> tuple[int, str]:
        """Run a command, and tell how long it took."""
        return self._timed(command.line, lambda: super(Follower, self).do(command))

    def end(self, line: str, told: str) -> tuple[int, str]:
        """Run a command until it has told something, and tell how long it took."""
        return self._timed(line, lambda: super(Follower, self).end(line, told))

    def _timed(self, line: str, run) -> tuple[int, str]:
        begun = perf_counter()
        ended = run()
        took = perf_counter() - begun
        self.seconds += took
        say(took, line)
        return ended


def main() -> None:
    """Follow the page, in a folder that is named or in one that is taken away again."""
    with TemporaryDirectory() as folder:
        clone = Path(sys.argv[1] if len(sys.argv) > 1 else folder).absolute() / "tribopipe"
        copy_clone(clone)
        reader = Follower(clone, programs=clone / PROGRAMS)
        try:
            for block in blocks(PAGE):
                follow(block, reader)
        except PageError as error:
            sys.exit(str(error))
        say(reader.seconds, "in all; every output is as the page shows it")


def follow(block: Block, reader: Follower) -> None:
    """Do what a block says; the commands that install are one script, since one of them activates the environment."""
    if "not run" in block.said:
        code, printed = reader.do(Command("set -e\n" + block.text.strip()))
        if code != 0:
            raise PageError(f"{block.place}: cannot be installed\n{printed}")
    elif "file" in block.said:
        reader.write(block.said["file"], block.text)
    else:
        reader.run(block)


def say(seconds: float, what: str) -> None:
    """Tell how long something took."""
    sys.stdout.write(f"{seconds:6.1f} s  {what}\n")
    sys.stdout.flush()


def copy_clone(folder: Path) -> None:
    """Copy every file of the clone that git has, or would take."""
    listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    named = subprocess.run(listing, cwd=ROOT, check=True, capture_output=True).stdout.decode("utf-8")
    for name in filter(None, named.split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)


if __name__ == "__main__":
    main()
