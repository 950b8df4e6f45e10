"""The folder that a page of the documentation is followed in: what is laid into it, and what is run there."""

import os
import shutil
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path

from documented import Block, Command, difference, shown_file
from folders import ROOT
from listening import listening

SECONDS = 900
"""After which a command hangs."""


class PageError(AssertionError):
    """What a page shows is not what comes."""


@dataclass
class PageFolder:
    """A folder that a reader of a page would be in, and what the last block printed there."""

    folder: Path
    archive: Path | None = None
    """Of all sample runs, to be copied."""
    programs: Path = Path(sys.executable).parent
    """Where `tribopipe` and `python` are."""
    printed: str = ""

    def lay(self, given: str) -> None:
        """Lay what is given into the folder, under its own or another name."""
        for each in filter(None, map(str.strip, given.split(","))):
            name, _, source = (part.strip().rstrip("/") for part in each.partition("="))
            path, _, file = (source or name).partition("#")
            if file:
                self.write(name, shown_file(path, file))
                continue
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            origin = self._origin(path)
            copy = shutil.copytree if origin.is_dir() else shutil.copy
            copy(origin, self.folder / name)

    def _origin(self, path: str) -> Path:
        """Return where something is that is given: in the archive of samples, or in the clone."""
        first, _, rest = path.partition("/")
        return self.archive / rest if first == "archive" and self.archive is not None else ROOT / path

    def write(self, name: str, text: str) -> Path:
        """Write a file that a page shows."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
        return path

    def run(self, block: Block) -> None:
        """Run the commands of a block. Raises ``PageError`` where one ends, or prints, otherwise than the page says."""
        said = []
        told = block.said.get("until")
        for command in block.commands:
            where = f"{block.place}: {command.line}"
            code, printed = self.do(command) if told is None else self.end(command.line, told)
            _expect(code == int(block.said.get("exit", 0)), f"{where}\nended with exit code {code}\n{printed}")
            wrong = difference(command.output, printed) if any(command.output) else ""
            _expect(not wrong, f"{where}\n{wrong}")
            said.append(printed)
        self.printed = "".join(said)
        for each in told.split(" | ") if told else ():
            _expect(each in self.printed, f"{block.place}: no command said {each!r}\n{self.printed}")

    def do(self, command: Command) -> tuple[int, str]:
        """Run a command to its end, and return its exit code and what it printed; `cd` holds for all that follow."""
        if command.line.startswith("cd "):
            self.folder /= command.line.removeprefix("cd ")
            return int(not self.folder.is_dir()), ""
        done = subprocess.run(command.line, timeout=SECONDS, **self._shell())
        return done.returncode, done.stdout.decode("utf-8")

    def end(self, line: str, told: str) -> tuple[int, str]:
        """Run a command to its end, or until it tells something: then end it by Ctrl-C, which counts as exit code 0."""
        printed = ""
        how = {"start_new_session": True, "preexec_fn": listening, **self._shell()}
        with subprocess.Popen(line, **how) as running:
            hangs = threading.Timer(SECONDS, os.killpg, [running.pid, signal.SIGKILL])
            hangs.start()
            for row in running.stdout:
                printed += row.decode("utf-8")
                if any(each in printed for each in told.split(" | ")):
                    os.killpg(running.pid, signal.SIGINT)
                    break
            printed += running.stdout.read().decode("utf-8")
            hangs.cancel()
        return 0 if running.returncode in (130, -signal.SIGINT) else running.returncode, printed

    def run_python(self, block: Block, name: str) -> None:
        """Run a script that a page shows, from a file of that name."""
        self.write(name, block.text)
        code, self.printed = self.do(Command(f'python "{name}"'))
        _expect(code == 0, f"{block.place}: this script ended with exit code {code}\n{self.printed}")

    def _shell(self) -> dict:
        """Say how a command is run: by the shell, in the folder, with the programs of this environment first."""
        own = {"PATH": os.pathsep.join([str(self.programs), os.environ["PATH"]]), "COLUMNS": "150"}
        quiet = {"MPLBACKEND": "Agg", "BROWSER": "true", "PYTHONUTF8": "1"}  # no window opens
        pipes = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        return {"shell": True, "cwd": self.folder, "env": os.environ | own | quiet, **pipes}


def _expect(holds: bool, otherwise: str) -> None:
    if not holds:
        raise PageError(otherwise)
