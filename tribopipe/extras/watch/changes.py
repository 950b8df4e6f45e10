"""When something in a folder may have changed: as the system shows, or by asking again and again."""

from collections.abc import Iterator
from pathlib import Path

_TICK = 1000
"""How often it is asked whether a look is due though nothing changed, ms."""
_QUIET, _LONGEST = 500, 2000
"""Changes are reported once there was none for so long, or that long after the first, ms."""
_POLL_EVERY = 2000
"""How often a network share is asked, ms."""


def changes(folder: Path, *, poll: bool) -> Iterator[bool]:
    """Yield, at least each second and for ever, whether anything below a folder has changed.

    With ``poll`` the folder is listed again and again, since changes by other machines on a share are not reported.
    """
    from watchfiles import watch

    for found in watch(
        folder,
        watch_filter=None,
        debounce=_LONGEST,
        step=_QUIET,
        rust_timeout=_TICK,
        yield_on_timeout=True,
        force_polling=poll or None,  # as the library knows best
        poll_delay_ms=_POLL_EVERY,
        ignore_permission_denied=True,
    ):
        yield bool(found)
