"""Which rows of the catalog a list shows, and in what order, as questions to SQLite."""

from collections.abc import Sequence
from typing import NamedTuple

from tribopipe.archive.catalog.listing import ListedColumn, columns_named, ordered_by
from tribopipe.archive.catalog.query import parse_where, where_clause, words_clause


class Asked(NamedTuple):
    """Which runs are asked for, and in what order."""

    where: str = ""
    """Conditions, as of ``tribopipe ls --where``."""
    sort: str = "id"
    """Columns to sort by, such as "material,-k_d"."""
    search: str = ""
    """Words that must all be in what is shown of a run."""
    searched: str = "id"
    """Columns in which they are searched for, such as "id,material"."""


class Selection(NamedTuple):
    """Questions about the runs that match a query."""

    places: str
    """Asks for their row numbers in order, as many as a first further value states, from where a second one does."""
    total: str
    """Asks for their number."""
    values: Sequence[float | str]
    """Values of the condition, which both questions begin with."""


def selection(asked: Asked) -> Selection:
    """Return the questions for what is asked. Raises ``QueryError`` where that cannot be understood."""
    terms = parse_where(asked.where)
    stated, values = where_clause(terms)
    has_words, words = words_clause(asked.search, columns_named(asked.searched))
    condition, values = f"{stated} AND {has_words}", [*values, *words]
    # With a condition, the narrow index is read and the few matches are sorted; the sign keeps SQLite from reading the
    # whole table in the order of the other index.
    by_id = "+id_key" if terms or words else "id_key"
    order = ", ".join(_in_order(column, by_id, descending=descending) for column, descending in ordered_by(asked.sort))
    return Selection(
        f"SELECT place FROM listed WHERE {condition} ORDER BY {order}, place LIMIT ? OFFSET ?",  # noqa: S608
        f"SELECT count(*) FROM listed WHERE {condition}",  # noqa: S608, of names of columns alone
        values,
    )


def _in_order(column: ListedColumn, by_id: str, *, descending: bool) -> str:
    """Return what sorts by a column; unknown comes last, before and after a minus alike."""
    direction = " DESC" if descending else ""
    if column.name == "id":
        return f"{by_id}{direction}"
    key = f'"{column.name}"' if column.kind == "number" else f"sort_key('{column.name}', \"{column.name}\")"
    return f'"{column.name}" IS NULL, {key}{direction}'
