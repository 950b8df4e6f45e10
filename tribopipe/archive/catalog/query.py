"""The language of --where, and the rows of the catalog that a list shows in order, as questions to SQLite.

All terms of a query, such as "material=Si3N4 load>300mN", have to hold. A term is a column, an operator and a value. A
value goes on to the next term, so that it may hold spaces; in quotes it may hold anything. Texts are compared in any
case, with * and ? for what is not stated; ~ asks for a part of a text.
"""

import re
import unicodedata
from collections.abc import Iterator, Sequence
from fnmatch import translate
from functools import lru_cache
from typing import NamedTuple

from tribopipe.archive.catalog.listing import ITEM, ListedColumn, column_named, columns_named, ordered_by
from tribopipe.base.errors import QueryError, UnitError

_OPERATOR = r"(?:!=|<=|>=|==|[=<>~≠≤≥])"
_SPELT = {"==": "=", "≠": "!=", "≤": "<=", "≥": ">="}
_TERM = re.compile(rf"(?P<name>[^\W\d][\w-]*)\s*(?P<operator>{_OPERATOR})\s*")
_QUOTED = re.compile(r"""(?P<quote>["'])(?P<text>(?:(?!(?P=quote)).|(?P=quote){2})*)(?P=quote)(?=\s|\Z)""", re.DOTALL)
_NEXT = re.compile(rf"""(?<!\s)(?:\s+(?=[^\W\d][\w-]*\s*{_OPERATOR}|["'])|\s*\Z)""")
_DATE = re.compile(
    r"\d{4}(-(0[1-9]|1[0-2])(-(0[1-9]|[12]\d|3[01])([T ]([01]\d|2[0-3])(:[0-5]\d(:[0-5]\d)?)?)?)?)?", re.ASCII
)
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_OPERATORS = {"number": ("=", "!=", "<", "<=", ">", ">="), "date": ("=", "!=", "<", "<=", ">", ">=", "~")}
_TEXT_OPERATORS = ("=", "!=", "~")
_LONGEST = 2000
_REMEMBERED = 4096
"""Answers about texts that are remembered: most texts are those of many runs."""
_SAME = 1e-9
"""Share of a number by which it may differ from one it equals: what is computed is not exact to the last digit."""


class Span(NamedTuple):
    """Numbers that count as one, SI."""

    low: float
    high: float


class Term(NamedTuple):
    """One thing asked of a run."""

    column: ListedColumn
    operator: str
    value: Span | str | None
    """Numbers in SI, a text or the beginning of a date; none for nothing known."""


def parse_where(text: str) -> list[Term]:
    """Read a query. Raises ``QueryError``: what was found at which character, what was expected, what may be meant."""
    if len(text) > _LONGEST:
        raise QueryError(f"found a query of {len(text):,} characters; expected at most {_LONGEST:,}; shorten it")
    return [_term(*written) for written in _written(text)]


class _Written(NamedTuple):
    name: str
    operator: str
    value: str
    literal: bool
    """Whether the value stood in quotes, so that "none" is a text."""
    place: int
    """Character at which the term starts, from 1."""


def _written(text: str) -> Iterator[_Written]:
    """Cut a query into terms."""
    place = len(text) - len(text.lstrip())
    while place < len(text):
        whole = _QUOTED.match(text, place)
        if whole:
            yield _one(_unquoted(whole), place + 1)
            end = whole.end()
        else:
            term, end = _next(text, place)
            yield term
        place = end + len(text[end:]) - len(text[end:].lstrip())


def _next(text: str, place: int) -> tuple[_Written, int]:
    """Read the term at a place, and where it ends."""
    head = _head(text, place, place + 1)
    value = _QUOTED.match(text, head.end())
    if value:
        return _Written(head["name"], head["operator"], _unquoted(value), True, place + 1), value.end()
    if text[head.end() : head.end() + 1] in ('"', "'"):
        raise QueryError(
            f"found {_cut(text[head.end() :])!r} at character {head.end() + 1} of the query; expected a closing "
            "quote; add the quote, and double any quote within the value"
        )
    end = _NEXT.search(text, head.end())
    stop = end.start() if end else len(text)
    return _Written(head["name"], head["operator"], text[head.end() : stop], False, place + 1), stop


def _one(text: str, place: int) -> _Written:
    """Read a term that stood in quotes as a whole: all after the operator is its value."""
    start = len(text) - len(text.lstrip())
    head = _head(text, start, place)
    return _Written(head["name"], head["operator"], text[head.end() :].strip(), False, place)


def _head(text: str, start: int, place: int) -> re.Match[str]:
    head = _TERM.match(text, start)
    if head is None:
        raise QueryError(
            f"found {_cut(text[start:])!r} at character {place} of the query; expected a column, an operator such as "
            "= or <, and a value; write, for example, 'load > 300 mN', and quote a value that contains an operator"
        )
    return head


def _unquoted(found: re.Match[str]) -> str:
    return found["text"].replace(found["quote"] * 2, found["quote"])


def _term(name: str, operator: str, value: str, literal: bool, place: int) -> Term:
    column = column_named(name, f" at character {place} of the query")
    operator = _SPELT.get(operator, operator)
    known = _OPERATORS.get(column.kind, _TEXT_OPERATORS)
    where = f"{column.name} at character {place} of the query"
    if operator not in known:
        raise QueryError(
            f"{where}: found the operator {operator}; expected one of {' '.join(known)} for a {column.kind} column; "
            "change the operator"
        )
    if not value.strip():
        raise QueryError(
            f"{where}: found no value after {operator}; expected a value; add it, or write none to find missing values"
        )
    if value.strip().casefold() == "none" and not literal:
        return _unknown(column, operator, where)
    return Term(column, operator, _value(column, value, where))


def _unknown(column: ListedColumn, operator: str, where: str) -> Term:
    if operator not in ("=", "!="):
        raise QueryError(
            f"{where}: found the operator {operator} with none, which stands for a missing value; expected = or !=; "
            "change the operator"
        )
    return Term(column, operator, None)


def _value(column: ListedColumn, text: str, where: str) -> Span | str:
    if column.kind == "number":
        return _span(column, text.strip(), where)
    if column.kind == "text":
        return text
    if not _DATE.fullmatch(text.strip()):
        raise QueryError(
            f"{where}: found {_cut(text)!r}; expected a date or the first part of a date, such as 2006, "
            "2006-03 or 2006-03-01; change the value"
        )
    return text.strip().replace(" ", "T")


def _span(column: ListedColumn, text: str, where: str) -> Span:
    from tribopipe.base.units import parse

    if column.measures == "force" and _NUMBER.fullmatch(text):  # lists show loads in either unit
        raise QueryError(
            f"{where}: found {_cut(text)!r} without a unit; expected a force in mN or N; write {_cut(text)} mN or "
            f"{_cut(text)} N"
        )
    try:
        number = parse(f"{text} {column.unit}" if _NUMBER.fullmatch(text) else text, column.measures)
    except UnitError as error:
        raise QueryError(f"{where}: {error}") from None
    return Span(number - _SAME * abs(number), number + _SAME * abs(number))


def _cut(text: str) -> str:
    return text if len(text) <= 30 else text[:29] + "…"


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


def where_clause(terms: Sequence[Term]) -> tuple[str, list[float | str]]:
    """Write terms as a condition in SQL, and the values bound in it. It calls the functions of the database.

    What SQLite compares itself comes first, so that Python is asked about as few rows as possible.
    """
    conditions, values = ["1"], []
    for term in sorted(terms, key=_is_asked_of_python):
        condition, bound = _condition(term)
        conditions.append(condition)
        values += bound
    return " AND ".join(conditions), values


def words_clause(words: str, columns: Sequence[ListedColumn]) -> tuple[str, list[float | str]]:
    """Write words that are searched for in what is shown in some columns as a condition, with the values bound in it.

    The function ``has_words`` of the database is asked.
    """
    if not words.strip():
        return "1", []
    held = ", ".join(f'"{column.name}_shown"' if column.kind == "number" else f'"{column.name}"' for column in columns)
    return f"has_words(?, ?, {held})", [words, ",".join(column.name for column in columns)]


def _is_asked_of_python(term: Term) -> bool:
    return isinstance(term.value, str) and (term.column.kind == "text" or term.operator == "~")


def _condition(term: Term) -> tuple[str, list[float | str]]:
    column = f'"{term.column.name}"'
    if term.operator == "!=":
        condition, bound = _condition(term._replace(operator="="))
        return f"NOT coalesce({condition}, 0)", bound
    if term.value is None:
        return f"{column} IS NULL", []
    if isinstance(term.value, Span):
        return _numeric(column, term.operator, term.value)
    if term.column.name == "steps":
        column = f"steps_in_words({column})"
    if term.operator == "~":
        return f"holds({column}, ?)", [term.value]
    if term.column.kind == "date":
        return f"substr({column}, 1, {len(term.value)}) {term.operator} ?", [term.value]
    return f"matches({column}, ?)", [term.value]


def _numeric(column: str, operator: str, value: Span) -> tuple[str, list[float | str]]:
    if operator == "=":
        return f"{column} BETWEEN ? AND ?", list(value)
    return f"{column} {operator} ?", [value.low if operator in ("<", ">=") else value.high]


@lru_cache(maxsize=_REMEMBERED)
def matches(texts: str | None, pattern: str) -> bool:
    """Return whether one of the texts of a run is as a pattern with * and ? states."""
    if texts is None:
        return False
    fits = _pattern(pattern)
    return any(fits.match(_plain(text)) for text in texts.split(ITEM))


@lru_cache(maxsize=_REMEMBERED)
def holds(texts: str | None, part: str) -> bool:
    """Return whether the texts of a run hold a part."""
    return texts is not None and _plain(part) in _plain(texts)


@lru_cache(maxsize=64)
def _pattern(text: str) -> re.Pattern[str]:
    return re.compile(translate(_plain(text).replace("[", "[[]")))


def _plain(text: str) -> str:
    """Write a text as it is compared: in one case, and with one sign for all that mean the same, as 3 for ₃."""
    return unicodedata.normalize("NFKC", text).casefold()
