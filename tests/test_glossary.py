"""The glossary names what the code names: every column of ls, every key of results, and nothing that is not there."""

import re
from typing import NamedTuple

import pytest
from folders import ROOT

from tribopipe.archive.catalog.listing import COLUMNS
from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.archive.definitions.parts import GroupPart
from tribopipe.archive.step_names import STEPS
from tribopipe.base.units import pretty
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.record import Record
from tribopipe.results.evaluation import DepthModel, DriftCorrection, FrictionFit
from tribopipe.results.specific_wear import BodyWearRate, MeasuredWear, SpecificWear
from tribopipe.results.wear_fit import (
    BodyWear,
    Contribution,
    ConventionCoefficients,
    FittedValue,
    HertzStart,
    MonteCarlo,
    WearFit,
)
from tribopipe.results.wear_prediction import PredictedBody, PredictedContact, PredictedPoint, WearPrediction

TEXT = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
OWN_LAWS = [name for name in COLUMNS if not re.match("(k_d|predicted_depth)_", name)]


class Line(NamedTuple):
    term: str
    sign: str
    unit: str
    columns: str
    keys: str
    elsewhere: str


LINES = [
    Line(*cells)
    for row in re.findall(r"^\| (.*) \|$", TEXT, re.MULTILINE)
    if len(cells := [cell.strip() for cell in re.split(r"(?<= )\|(?= |$)", f"{row} ")]) == len(Line._fields)
    and cells[0] != "term"
]
RESULTS: list[type[Record]] = [
    *(DriftCorrection, FrictionFit, SpecificWear, BodyWearRate, MeasuredWear, WearFit, DepthModel, MonteCarlo),
    *(Contribution, BodyWear, HertzStart, FittedValue, ConventionCoefficients),
    *(WearPrediction, PredictedPoint, PredictedBody, PredictedContact),
]


def named(cell: str) -> list[str]:
    return re.findall(r"`([^`]+)`", cell)


def test_every_line_of_a_table_is_read():
    assert len(LINES) > 60
    assert [line.term for line in LINES if not line.term] == []


@pytest.mark.parametrize("name", OWN_LAWS)
def test_every_column_of_ls_has_an_entry(name):
    assert name in {name for line in LINES for name in named(line.columns)}


@pytest.mark.parametrize("record", RESULTS, ids=lambda record: record.__name__)
def test_every_key_of_a_result_has_an_entry(record):
    told = {name for line in LINES for name in named(line.keys)}
    assert set(record.model_fields) - told - {"disc"} == set()


def test_every_column_that_is_named_is_one_of_ls():
    assert [name for line in LINES for name in named(line.columns) if name not in COLUMNS] == []


def known_keys() -> set[str]:
    """Every name of a group or field that archived files may hold, and every key of a record."""
    found: set[str] = set()
    waiting = [definition.entry for definition in definitions().values()]
    while waiting:
        for part in waiting.pop().members:
            found.add(part.name)
            if isinstance(part, GroupPart):
                waiting.append(part)
    records = {record for kind in STEPS.values() for record in kind.records} | {RunManifest, *RESULTS}
    return found | {name for record in records for name in record.model_fields} | {"kind", "standard_uncertainty"}


def test_every_key_that_is_named_is_one():
    keys = [part for line in LINES for name in named(line.keys) for part in name.split(".")]
    assert [key for key in keys if key not in known_keys()] == []


def test_units_are_those_of_ls():
    for line in LINES:
        for name in named(line.columns):
            unit = pretty(COLUMNS[name].unit)
            assert unit in (line.unit or ""), f"{line.term}: {name} is shown in {unit}"
