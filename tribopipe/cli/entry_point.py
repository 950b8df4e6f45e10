"""Entry point of the `tribopipe` command, which handles Ctrl-C before it loads anything else.

An archive outlives a process that is killed at any moment, so an interrupted command simply ends: what it was writing
is taken away, one sentence is printed, and nothing more of it runs.
"""

import os
import signal
import warnings
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

from tribopipe.base.process_lifecycle import undo_all

_ENDINGS = {"SIGINT": "interrupted", "SIGTERM": "terminated", "SIGHUP": "ended because the terminal was closed"}
"""Signals that request a process to end, if the system has them, and the message printed for each."""
_STDERR = 2
_BY_PYTHON = warnings.formatwarning
_Handler = Callable[[int, FrameType | None], object] | signal.Handlers


def main() -> None:
    """Run the command."""
    _look_after(_end)
    if os.environ.get("_TRIBOPIPE_COMPLETE", "").startswith("complete_"):
        from tribopipe.cli.completion import answer

        answer(os.environ)
    from tribopipe.base.process_lifecycle import ONE_THREAD

    warnings.formatwarning = _told
    os.environ.update(ONE_THREAD | os.environ)  # so that results are those of workers, bit for bit
    from tribopipe.cli.app import main as run

    try:
        run()
    finally:
        _look_after(signal.SIG_IGN)  # what is asked for is done, or its failure told


def _told(message: Warning | str, category: type[Warning], filename: str, lineno: int, line: str | None = None) -> str:
    """Print a warning of tribopipe itself as a sentence, and any other with its location in the code."""
    if category is not UserWarning:
        return _BY_PYTHON(message, category, filename, lineno, line)
    from tribopipe.cli.output import seen

    return f"warning: {seen(str(message))}\n"


def _look_after(handler: _Handler) -> None:
    """Handle the signals that request a process to end, except those ignored because of nohup or a script."""
    for name in _ENDINGS:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, handler)


def _end(number: int, _: FrameType | None) -> None:
    """End the process, with the exit code that shells use for a signal."""
    signal.signal(number, signal.SIG_IGN)
    undo_all()
    said = f"{_ENDINGS[signal.Signals(number).name]}; archived results are kept; run the same command again to continue"
    with suppress(OSError):
        os.write(_STDERR, f"{said}{os.linesep}".encode("ascii"))
    os._exit(128 + number)
