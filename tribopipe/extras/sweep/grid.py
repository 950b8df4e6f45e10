"""Every combination of what is varied."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from tribopipe.base.errors import ManifestError
from tribopipe.extras.sweep.rows import Head
from tribopipe.extras.sweep.subject import Cell, Parameter, Settings, Value

_MOST_CASES = 1_000_000
REPEAT = "repeat"


@dataclass(frozen=True)
class Combination:
    """One value of each key that is varied."""

    settings: Settings
    cells: Mapping[str, Cell]
    repeat: int
    """From 1 on."""

    def labels(self, run_id: str) -> dict[str, Cell]:
        """Return what distinguishes its case of a run from all others."""
        return {"run": run_id, **self.cells, REPEAT: float(self.repeat)}


def combinations(parameters: Sequence[Parameter], repeats: int, seed: int) -> Iterator[Combination]:
    """Give every combination of the values that are listed, the last key's changing fastest, each so often.

    What is drawn depends on seed, repeat and path alone: a repeat has the same luck in every combination.
    """
    for chosen in product(*(listed(parameter) for parameter in parameters)):
        for repeat in range(1, repeats + 1):
            values = {
                parameter.path: value or parameter.draw(seed, repeat)
                for parameter, value in zip(parameters, chosen, strict=True)
            }
            yield Combination(
                {path: value.given for path, value in values.items()},
                {path: value.cell for path, value in values.items()},
                repeat,
            )


def listed(parameter: Parameter) -> tuple[Value | None, ...]:
    """Return the values of a key that make combinations: one, not yet known, where it is drawn."""
    return parameter.values if parameter.drawn is None else (None,)


def label_heads(varied: Sequence[Parameter], repeats: int | None) -> tuple[Head, ...]:
    """Return the columns that distinguish cases; that of repeats only where there are some."""
    return (Head("run"), *map(_head, varied), *([] if repeats is None else [Head(REPEAT)]))


def _head(varied: Parameter) -> Head:
    return Head(varied.path, varied.unit, written={value.cell: value.shown for value in varied.values if value.shown})


def refuse_endless(parameters: Sequence[Parameter], times: int, where: str) -> None:
    """Raise ``ManifestError`` where more cases are asked for than anyone waits for."""
    count = times * math.prod(len(listed(parameter)) for parameter in parameters)
    if count > _MOST_CASES:
        raise ManifestError(
            f"{where}: found {count} cases; expected at most {_MOST_CASES}; vary fewer keys at once, or repeat less"
        )
