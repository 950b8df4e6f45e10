"""The order of a list, which SQLite makes, against the same order in plain Python; and parts of a list."""

from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.archive.catalog.catalog import Catalogue, Known, Note, keep
from tribopipe.archive.catalog.database import in_memory
from tribopipe.archive.catalog.listing import COLUMNS, Cell, ListedRun, column_named
from tribopipe.archive.catalog.query import Asked
from tribopipe.base.errors import QueryError
from tribopipe.base.files import natural_key, natural_order

TEXTS = st.text(alphabet=st.sampled_from("aAbß 0129-_.\0é٣²İ"), max_size=8)
IDS = TEXTS.map(lambda text: f"r{text}")
CELLS = {
    "k_d": st.none() | st.sampled_from([-1.0, 0.0, -0.0, 1e-14, 2e-14, float("inf")]),
    "material": st.none() | st.lists(TEXTS.filter(bool), min_size=1, max_size=2).map("\n".join),
    "started": st.none() | st.sampled_from(["2005-12-31T23:00:00+01:00", "2006-03-01T09:30:00", "2006-03-01T09:30:59"]),
    "steps": st.none() | st.sampled_from(["clean_up", "clean_up\ndrift_correction", "wear_fit_archard"]),
}
ROWS = st.lists(st.fixed_dictionaries({"id": IDS, **CELLS}), max_size=8, unique_by=lambda row: row["id"])
SORTS = st.lists(
    st.tuples(st.sampled_from(["", "-"]), st.sampled_from(["id", "run", *CELLS])).map("".join), min_size=1, max_size=3
).map(",".join)


def in_order(runs: Iterable[ListedRun], sort: str) -> list[ListedRun]:
    """Sort runs by one column after the other, the last first."""
    ordered, names = list(runs), sort.split(",")
    for name in ("id", *reversed(names)) if names[0] != "id" else ("id",):
        column = column_named(name.removeprefix("-"))
        key: Callable[[ListedRun], Any] = (
            (lambda run, name=column.name: run.value(name))
            if column.kind == "number"
            else (lambda run, name=column.name: natural_order(run.text(name).casefold()))
        )
        known = [run for run in ordered if run.text(column.name)]
        unknown = [run for run in ordered if not run.text(column.name)]
        ordered = [*sorted(known, key=key, reverse=name.startswith("-")), *unknown]
    return ordered


def cell(value: float | str | None) -> Cell:
    return Cell(value, None, str(value)) if isinstance(value, float) else Cell(value)


def filled(folder: Path, rows: list[dict[str, Any]]) -> Catalogue:
    """Return a catalog in memory that holds some rows and looks at no folder."""
    catalogue = Catalogue(folder)
    catalogue._database._memory = connection = in_memory()
    catalogue._database._again = float("inf")
    catalogue._refresh = lambda *_: None  # type: ignore[method-assign]
    for number, row in enumerate(rows):
        cells = {name: cell(value) for name, value in row.items()}
        keep(connection, [Note(f"{number}.h5", Known("0 0 0 0", settled=True, sha256=""), cells=cells)])
    return catalogue


@given(st.lists(TEXTS | st.text(), max_size=8))
def test_key_has_the_natural_order(names):
    assert sorted(names, key=natural_key) == sorted(names, key=natural_order)


@pytest.mark.slow
@given(ROWS, SORTS)
def test_sqlite_sorts_as_python_does(rows, sort):
    catalogue = filled(Path("nowhere"), rows)
    unordered = sorted(catalogue.runs(), key=lambda run: run["place"])
    wanted = [run.id for run in in_order(unordered, sort)]
    assert [run.id for run in catalogue.runs(sort=sort)] == wanted
    for start in range(len(rows)):
        part = catalogue.listed(Asked(sort=sort), start, most=2)
        assert (part.total, [run.id for run in part.runs]) == (len(rows), wanted[start : start + 2])


@pytest.mark.slow
@given(ROWS)
def test_a_part_of_a_selection_states_how_many_there_are(rows):
    catalogue = filled(Path("nowhere"), rows)
    known = catalogue.runs("material!=none", "-k_d")
    part = catalogue.listed(Asked("material!=none", "-k_d"), most=1)
    assert part.total == len(known) == sum(row["material"] is not None for row in rows)
    assert [run.id for run in part.runs] == [run.id for run in known[:1]]


def test_words_are_searched_for_in_what_is_shown():
    rows = [
        {"id": "r1", "material": "Si3N4\nWC-Co", "started": "2006-03-01T09:30:00", "k_d": 2e-14},
        {"id": "r2", "material": "DLC", "steps": "drift_correction"},
    ]
    catalogue = filled(Path("nowhere"), rows)
    searched = "id,material,started,k_d,steps"
    for words, found in {
        "": ["r1", "r2"],
        "wc-co SI3": ["r1"],
        "/": ["r1"],
        "09:30 2e-14": ["r1"],
        "drift": ["r2"],
        "dlc r1": [],
    }.items():
        assert [run.id for run in catalogue.listed(Asked(search=words, searched=searched)).runs] == found
    assert catalogue.listed(Asked("k_d=none", search="r", searched="id"), most=0).total == 1
    with pytest.raises(QueryError, match="'lod' among the columns"):
        catalogue.listed(Asked(searched="lod"))


def test_values_are_those_that_runs_have():
    rows = [
        {"id": "r10", "material": "Si3N4\nWC-Co", "started": "2006-03-01T09:30:00", "k_d": 2e-14},
        {"id": "r9", "material": "Si3N4\nsteel", "started": "2006-03-01T13:10:00", "steps": "drift_correction"},
    ]
    catalogue = filled(Path("nowhere"), rows)
    assert catalogue.values("material") == ["Si3N4", "WC-Co", "steel"]
    assert catalogue.values("material", "S") == ["Si3N4", "steel"]
    assert catalogue.values("id") == ["r9", "r10"]
    assert catalogue.values("id", most=1) == ["r9"]
    assert catalogue.values("started") == ["2006-03-01"]
    assert catalogue.values("step") == ["drift"]
    assert catalogue.values("k_d") == []


def test_every_column_is_in_its_own_place():
    with closing(in_memory()) as connection:
        listed = [row["name"] for row in connection.execute("PRAGMA table_info(listed)")]
    assert set(COLUMNS) <= set(listed)
    assert len(listed) == len(set(listed))


def test_unknown_column_is_refused_wherever_it_stands():
    for sort in ("lod", "id,lod", "load,-lod"):
        with pytest.raises(QueryError, match="'lod' to sort by"):
            filled(Path("nowhere"), []).runs(sort=sort)
