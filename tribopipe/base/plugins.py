"""What packages add to tribopipe: the entry points of a group, those of tribopipe itself declared the same way.

Nothing is imported before it is asked for, and what cannot be loaded is left out, with a warning.
"""

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache, cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Generic, TypeVar

from tribopipe.base.errors import did_you_mean

T = TypeVar("T")


@cache
def declared(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group, those of tribopipe first."""
    return own_first(entry_points(group=group))


def names(group: str) -> list[str]:
    """Return the names of what is installed, each once."""
    return list(dict.fromkeys(entry.name for entry in declared(group)))


def not_installed(group: str, what: str, name: str) -> str:
    """Return one sentence: nothing of a name is installed, and which name is the nearest."""
    return (
        f"found the {what} {name!r}, which is not installed; expected the name of an installed {what}; "
        f"{did_you_mean(name, names(group))}"
    )


def own_first(entries: Iterable[EntryPoint]) -> tuple[EntryPoint, ...]:
    """Put entry points in order of their names, tribopipe's own first, so that nothing can take their names."""
    return tuple(sorted(entries, key=lambda entry: (not is_own(entry), entry.name)))


def is_own(entry: EntryPoint) -> bool:
    """Return whether an entry point is tribopipe's."""
    return entry.module.startswith("tribopipe.")


def added(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group that other packages declare under names which tribopipe has not."""
    taken = {entry.name for entry in declared(group) if is_own(entry)}
    return tuple(entry for entry in declared(group) if entry.name not in taken)


class Plugins(Mapping[str, T], Generic[T]):
    """What the entry points of a group stand for, by name; all are loaded when the first is asked for."""

    def __init__(self, group: str, what: str, load: Callable[[EntryPoint], T], name_of: Callable[[T], str]) -> None:
        self._group, self._what, self._load, self._name_of = group, what, load, name_of

    def __getitem__(self, name: str) -> T:
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._loaded)

    def __len__(self) -> int:
        return len(self._loaded)

    @cached_property
    def _loaded(self) -> dict[str, T]:
        found: dict[str, T] = {}
        for entry in declared(self._group):
            try:
                plugin = self._load(entry)
            except Exception as error:  # noqa: BLE001 - somebody else's code may raise anything
                why = f"{self._what} {entry.name!r} skipped: {entry.value} cannot be loaded ({error!r})"
                warnings.warn(why, stacklevel=2)
                continue
            if (name := self._name_of(plugin)) in found:
                why = f"{entry.value}: skipped, because a {self._what} with the name {name!r} is already installed"
                warnings.warn(why, stacklevel=2)
            else:
                found[name] = plugin
        return found
