"""What is stated about the result of a step."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple, TypeAlias

from tribopipe.archive.outline import StepOutline
from tribopipe.archive.steps import StepName
from tribopipe.documents.quantity import Quantity
from tribopipe.views.labeled_values import NOTHING, shown
from tribopipe.views.page import Fact, TextTable

Steps: TypeAlias = Mapping[StepName, StepOutline]
"""The steps a run has been through."""


class Told(NamedTuple):
    """A result in words, numbers and tables; those without rows are not shown."""

    sentence: str
    facts: tuple[Fact, ...] = ()
    notes: tuple[str, ...] = ()
    tables: tuple[TextTable, ...] = ()

    def worded(self, words: Callable[[str], str]) -> "Told":
        """Return the same in other words."""
        return Told(
            words(self.sentence),
            tuple(Fact(words(fact.name), words(fact.value)) for fact in self.facts),
            tuple(map(words, self.notes)),
            tuple(
                replace(
                    table,
                    title=words(table.title),
                    columns=tuple(map(words, table.columns)),
                    rows=tuple(tuple(map(words, row)) for row in table.rows),
                )
                for table in self.tables
            ),
        )


def cells(*told: tuple[Quantity | None, str]) -> tuple[str, ...]:
    """Return quantities as cells of a table, each in its unit."""
    return tuple(shown(quantity, unit) or NOTHING for quantity, unit in told)
