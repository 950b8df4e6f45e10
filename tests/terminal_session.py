"""Commands one after the other in one process, as `python terminal_session.py FILE`: FILE has a list of their words."""

import json
import os
import sys
from contextvars import copy_context
from pathlib import Path

from tribopipe.cli import options
from tribopipe.cli.app import main
from tribopipe.physics import uncertainty

MARK = "\x1e"
"""What stands before the output of each command on stdout, and on stderr before its exit code."""


def session(commands: list[list[str]]) -> None:
    """Run commands as the installed script does; those that go on after an error go on here too."""
    for words in commands:
        sys.argv = ["tribopipe", *words]
        sys.stdout.write(MARK)
        sys.stdout.flush()
        try:
            copy_context().run(main)  # what one command sets (--json) is not for the next
            code = 0
        except SystemExit as ended:
            code = ended.code or 0
        sys.stdout.flush()
        sys.stderr.flush()
        os.write(2, f"{MARK}{code}".encode())


if __name__ == "__main__":
    # Other processes and more draws take seconds, and show nothing else.
    options._cores, uncertainty.BLOCK = lambda: 1, 200
    session(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))
