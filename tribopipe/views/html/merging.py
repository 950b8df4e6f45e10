"""What several runs state of the same things, in one table."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple


class Stated(NamedTuple):
    """What one run states of a thing: nothing where it should and does not."""

    subject: str
    name: str
    value: str | None


class Merged(NamedTuple):
    """What several runs state of a thing."""

    subject: str
    name: str
    values: Mapping[str | None, tuple[str, ...]]
    """Ids of runs by what they state; by none, of those that do not."""


def merged(by_run: Mapping[str, Iterable[Stated]]) -> list[Merged]:
    """Put together what runs state, subject by subject, in the order in which things first appear."""
    found: dict[str, dict[str, dict[str | None, tuple[str, ...]]]] = {}
    for run_id, stated in by_run.items():
        for subject, name, value in stated:
            values = found.setdefault(subject, {}).setdefault(name, {})
            values[value] = (*values.get(value, ()), run_id)
    return [Merged(subject, name, values) for subject, names in found.items() for name, values in names.items()]
