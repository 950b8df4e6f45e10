"""Processes that heed signals, also where the tests run in the background, which ignores some."""

import signal


def listening() -> None:
    """Heed signals in a process that begins; POSIX only."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)
