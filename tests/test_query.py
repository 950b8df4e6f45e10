"""The language of --where: what it understands, what it says of the rest, and that SQL chooses what it says."""

import sqlite3
import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.archive.catalog.listing import ALIASES, COLUMNS, column_named, columns_named, step_words
from tribopipe.archive.catalog.query import Span, holds, matches, parse_where, where_clause
from tribopipe.archive.step_names import STEPS
from tribopipe.base.errors import QueryError
from tribopipe.base.units import KINDS, is_unit_of

NUMBERS = [name for name, column in COLUMNS.items() if column.kind == "number"]
TEXTS = [name for name, column in COLUMNS.items() if column.kind == "text"]


def quoted(text: str) -> str:
    """Write a value so that it is read as it stands."""
    return '"' + text.replace('"', '""') + '"'


def asked(text: str) -> list[tuple[str, str, object]]:
    terms = [(term.column.name, term.operator, term.value) for term in parse_where(text)]
    return [(name, sign, sum(value) / 2 if isinstance(value, Span) else value) for name, sign, value in terms]


# --- columns ---


def test_every_column_has_a_unit_of_its_kind():
    assert [name for name in NUMBERS if not is_unit_of(COLUMNS[name].unit, COLUMNS[name].measures)] == []
    assert [name for name, column in COLUMNS.items() if (column.kind == "number") != bool(column.measures)] == []
    assert {column.measures for column in COLUMNS.values()} <= {"", *KINDS}


def test_aliases_name_columns_and_hide_none():
    assert set(ALIASES.values()) <= set(COLUMNS)
    assert not set(ALIASES) & set(COLUMNS)


def test_every_step_has_a_word():
    assert len({step_words(name) for name in STEPS}) == len(STEPS)
    assert step_words("prediction_running_in") == "predicted by Running in"


@pytest.mark.parametrize("name", ["k_d", "K_D", "k-d", " k_d ", "tag", "μ", "µ", "Pin-Material"])
def test_columns_are_found_as_people_write_them(name):
    assert column_named(name).name in ("k_d", "tags", "friction", "pin_material")


def test_unknown_columns_are_refused_with_the_nearest():
    with pytest.raises(QueryError, match="'lod' among the columns; expected a column name; did you mean 'load'"):
        columns_named("id,lod")


# --- what is understood ---


@pytest.mark.parametrize(
    ("text", "terms"),
    [
        ("", []),
        ("   ", []),
        ("load>300mN", [("load", ">", 0.3)]),
        ("load > 300 mN", [("load", ">", 0.3)]),
        ("normal_load<=2.5 N", [("load", "<=", 2.5)]),
        ("LOAD ≥ 1N", [("load", ">=", 1.0)]),
        ("slip=4", [("slip", "=", 0.04)]),
        ("temperature>23", [("temperature", ">", 296.15)]),
        ("k_d<1e-8", [("k_d", "<", 1e-14)]),
        ("k_d<1e-14 m^2/N", [("k_d", "<", 1e-14)]),
        ("material=Si3N4", [("material", "=", "Si3N4")]),
        ("material==Si3N4", [("material", "=", "Si3N4")]),
        ("medium=water vapour load>1 mN", [("medium", "=", "water vapour"), ("load", ">", 1e-3)]),
        ("'medium=water vapour' load>1mN", [("medium", "=", "water vapour"), ("load", ">", 1e-3)]),
        ("load>1mN 'medium=water vapour'", [("load", ">", 1e-3), ("medium", "=", "water vapour")]),
        ('medium = "water vapour"', [("medium", "=", "water vapour")]),
        ('title="a ""b"" load>3 c"', [("title", "=", 'a "b" load>3 c')]),
        ("title='it''s'", [("title", "=", "it's")]),
        ("title~wear", [("title", "~", "wear")]),
        ("tag=none", [("tags", "=", None)]),
        ("k_d != NONE", [("k_d", "!=", None)]),
        ('title="none"', [("title", "=", "none")]),
        ("started>=2006-03", [("started", ">=", "2006-03")]),
        ("started=2006-03-01 09:30", [("started", "=", "2006-03-01T09:30")]),
    ],
)
def test_terms_are_understood(text, terms):
    found = asked(text)
    assert [term[:2] for term in found] == [term[:2] for term in terms]
    for (*_, value), (*_, wanted) in zip(found, terms, strict=True):
        assert value == (pytest.approx(wanted) if isinstance(wanted, float) else wanted)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("lod>300", ("'lod' at character 1", "did you mean 'load'?")),
        ("load>300N lod>1", ("'lod' at character 11",)),
        ("load>55", ("load at character 1", "found '55' without a unit", "mN or N", "write 55 mN or 55 N")),
        ("xyzzy=1", ("'xyzzy'", "`tribopipe ls --columns help`")),
        ("Si3N4", ("'Si3N4' at character 1", "expected a column, an operator")),
        ("load>", ("load at character 1", "no value after >")),
        ("load>300 kg", ("load at character 1", "'kg'", "not a unit of force", "'mN'")),
        ("load>heavy", ("load at character 1", "'heavy'", "not a number with a unit")),
        ("load~3", ("the operator ~", "expected one of = != < <= > >= for a number")),
        ("title<3", ("the operator <", "expected one of = != ~ for a text")),
        ("load>none", ("the operator > with none", "expected = or !=")),
        ("started>yesterday", ("started at character 1", "'yesterday'", "2006-03")),
        ("started=2006-13", ("'2006-13'",)),
        ('title="open', ("'\"open' at character 7", "closing quote")),
        ("'load>3", ("at character 1",)),
        ("title=" + "x" * 5000, ("5,006 characters", "2,000")),
    ],
)
def test_what_is_not_understood_is_one_sentence(text, words):
    with pytest.raises(QueryError) as refused:
        parse_where(text)
    said = str(refused.value)
    assert [word for word in words if word not in said] == []
    assert "\n" not in said


@given(st.text(max_size=60) | st.text(alphabet="load=<>!~'\" k_d3mN*none", max_size=60))
def test_any_text_is_understood_or_refused(text):
    try:
        terms = parse_where(text)
    except QueryError:
        return
    condition, values = where_clause(terms)
    assert condition.count("?") == len(values)


@given(st.text(min_size=1).filter(lambda text: text.strip()))
def test_quoted_values_come_back(value):
    assert asked(f"load>1mN title={quoted(value)} tag=a") == [
        ("load", ">", pytest.approx(1e-3)),
        ("title", "=", value),
        ("tags", "=", "a"),
    ]


# --- what is chosen ---


@pytest.mark.parametrize(
    ("texts", "pattern", "fits"),
    [
        ("Si3N4\nWC-Co", "si3n4", True),
        ("Si3N4\nWC-Co", "WC*", True),
        ("Si3N4\nWC-Co", "Si?N?", True),
        ("Si3N4\nWC-Co", "Si*Co", False),
        ("Si₃N₄", "Si3N4", True),
        ("[a]", "[a]", True),
        ("a", "[a]", False),
        ("STRASSE", "straße", True),
        (None, "*", False),
    ],
)
def test_texts_match_in_any_case_with_wildcards(texts, pattern, fits):
    assert matches(texts, pattern) is fits


WORDS = st.sampled_from(["a", "B", "ab", "Ab c", "none", "%", "_", "*", "'; DROP TABLE listed; --"])
CELLS = {
    "load": st.none() | st.sampled_from([0.1, 0.2, 0.3, 0.1 + 0.2, 1.0]),
    "k_d": st.none() | st.floats(1e-15, 1e-13),
    "title": st.none() | WORDS,
    "tags": st.none() | st.lists(WORDS, min_size=1, max_size=3).map("\n".join),
    "started": st.none() | st.sampled_from(["2005-12-31T23:00:00+01:00", "2006-03-01T09:30:00", "2006-03-02T00:00:00"]),
}
ROWS = st.lists(st.fixed_dictionaries(CELLS), max_size=6)
TERMS = st.one_of(
    st.tuples(
        st.just("k_d"),
        st.sampled_from(["=", "!=", "<", "<=", ">", ">="]),
        st.sampled_from(["none", "200", "1e-8"]),
    ),
    st.tuples(
        st.just("load"),
        st.sampled_from(["=", "!=", "<", "<=", ">", ">="]),
        st.sampled_from(["none", "200 mN", "0.3 N", "1 N"]),
    ),
    st.tuples(st.sampled_from(["title", "tags"]), st.sampled_from(["=", "!=", "~"]), WORDS.map(quoted)),
    st.tuples(st.sampled_from(["title", "tags"]), st.sampled_from(["=", "!="]), st.just("none")),
    st.tuples(
        st.just("started"),
        st.sampled_from(["=", "!=", "<", "<=", ">", ">="]),
        st.sampled_from(["2005", "2006", "2006-03", "2006-03-02"]),
    ),
).filter(lambda term: term[2] != "none" or term[1] in ("=", "!="))


def really_holds(row: dict, name: str, operator: str, value: object) -> bool:
    """The same in plain Python, from what docs/listing.md says."""
    cell = row[name]
    if operator == "!=":
        return not really_holds(row, name, "=", value)
    if value is None:
        return cell is None
    if cell is None:
        return False
    if isinstance(value, Span):
        low, high = value
        return {
            "=": low <= cell <= high,
            "<": cell < low,
            "<=": cell <= high,
            ">": cell > high,
            ">=": cell >= low,
        }[operator]
    if name == "started":
        start = cell[: len(value)]
        return {"=": start == value, "<": start < value, "<=": start <= value, ">": start > value}.get(
            operator, start >= value
        )
    return matches(cell, value) if operator == "=" else holds(cell, value)


@given(ROWS, st.lists(TERMS, max_size=4))
def test_sql_chooses_what_the_terms_say(rows, written):
    terms = parse_where(" ".join("".join(term) for term in written))
    condition, values = where_clause(terms)
    connection = sqlite3.connect(":memory:")
    connection.create_function("matches", 2, matches)
    connection.create_function("holds", 2, holds)
    connection.execute("CREATE TABLE listed (number, load REAL, k_d REAL, title TEXT, tags TEXT, started TEXT)")
    connection.executemany(
        "INSERT INTO listed VALUES (?, ?, ?, ?, ?, ?)",
        [(n, *(row[name] for name in CELLS)) for n, row in enumerate(rows)],
    )
    chosen = {n for (n,) in connection.execute(f"SELECT number FROM listed WHERE {condition}", values)}  # noqa: S608
    connection.close()
    assert chosen == {
        n
        for n, row in enumerate(rows)
        if all(really_holds(row, term.column.name, term.operator, term.value) for term in terms)
    }


def test_conditions_hold_no_value_of_the_query():
    condition, values = where_clause(parse_where("title=zebra load>7 N started>2006 tag~giraffe"))
    assert [sign for sign in ("zebra", "giraffe", "7", "2006") if sign in condition] == []
    assert set(condition) <= set(string.ascii_letters + string.digits + " _\"'(),?=<>")
    assert values[-2:] == ["zebra", "giraffe"]  # Python is asked last


def test_long_queries_take_no_time():
    with pytest.raises(QueryError):
        parse_where("title=" + " " * 1900 + "x y=")
    assert matches("a" * 5000, "*a" * 30 + "b") is False
