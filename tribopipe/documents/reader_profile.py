"""A reader described in TOML: how a lab's own export is laid out, and what its columns mean."""

import re
import warnings
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from tribopipe.base.errors import did_you_mean
from tribopipe.base.units import is_unit
from tribopipe.documents.manifest import Conditions
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SignalName

_NAME = re.compile(r"(?=.{1,60}\Z)[a-z0-9]+(?:-[a-z0-9]+)*")
_TOP_FACTS = ("started", "title", "operator", "instrument", "comment")
_BODY_FACT = re.compile(r"contact\.(?:pin|disc|curved_disc|flat_disc)\.[a-z_]+")


def _a_short_name(written: str) -> str:
    if not _NAME.fullmatch(written):
        raise ValueError(
            f"found {written!r}; expected at most 60 lowercase letters, digits and single hyphens, such as 'our-rig'; "
            "correct the name"
        )
    return written


def _a_pattern(written: str) -> str:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            re.compile(written)
    except (re.error, OverflowError, RecursionError, Warning) as error:
        raise ValueError(
            f"found {written!r}, which is not a regular expression ({error}); expected an expression such as '^Time'; "
            "put a backslash before literal characters such as [ and ("
        ) from None
    return written


def _a_unit(written: str) -> str:
    if not is_unit(written):
        raise ValueError(
            f"found {written!r}, which is not a unit; expected a unit such as 'N', 'um' or 'V'; correct the unit"
        )
    return written


def _a_separator(written: str) -> str:
    if len(written) != 1 or not written.isascii() or written.isalnum() or written in '"+-.\r\n\0':
        raise ValueError(
            f'found {written!r}; expected one character such as ";" or "\\t", or " " for whitespace; correct the '
            "separator"
        )
    return written


def _a_pattern_alone(written: Any) -> Any:
    return {"pattern": written} if isinstance(written, str) else written


Pattern = Annotated[str, AfterValidator(_a_pattern), Field(min_length=1, max_length=500)]
"""A regular expression, searched for in each line."""
Unit = Annotated[str, AfterValidator(_a_unit)]
Point = tuple[float, float]


class Calibration(Record):
    """Calibration of a sensor: the quantity as a function of its reading."""

    reading: Unit
    """Unit of the reading, such as "V"."""
    unit: Unit
    """Unit of the calibrated quantity, such as "N"."""
    points: tuple[Point, ...] = ()
    """Pairs of reading and value, in any order; interpolated linearly."""
    polynomial: tuple[float, ...] = Field(default=(), max_length=20)
    """Alternative to points: c₀, c₁, c₂… of c₀ + c₁x + c₂x² + … for the reading x."""
    range: Point | None = None
    """Lowest and highest reading for which the polynomial is valid."""
    outside: Literal["error", "missing"] = "error"
    """Treatment of readings outside the points or the range: an error, or missing samples, counted in a note."""

    @model_validator(mode="after")
    def _is_a_table_or_a_polynomial(self) -> Self:
        if bool(self.points) == bool(self.polynomial):
            found = "both points and polynomial" if self.points else "neither points nor polynomial"
            raise ValueError(
                f"found {found}; expected one of the two; write points = [[0.0, 0.0], [5.0, 10.0]] for pairs of "
                "reading and value"
            )
        if bool(self.polynomial) != (self.range is not None):
            found = (
                "a polynomial without a range" if self.polynomial else "a range in addition to points, which define it"
            )
            raise ValueError(
                f"range: found {found}; expected a range of readings, such as [0, 10], for a polynomial, and no range "
                "for points; add or remove range"
            )
        return self

    @model_validator(mode="after")
    def _readings_are_distinct(self) -> Self:
        readings = sorted(reading for reading, _ in self.points)
        twice = next((one for one, other in pairwise(readings) if one == other), None)
        if len(readings) == 1 or twice is not None:
            found = "one pair" if twice is None else f"the reading {twice:g} twice"
            raise ValueError(
                f"points: found {found}; expected at least two pairs, each with a different reading; correct the points"
            )
        if self.range is not None and not self.range[0] < self.range[1]:
            raise ValueError(f"range: found {list(self.range)}; expected [lowest, highest] reading; correct the range")
        return self


class DescribedColumn(Record):
    """Content of one column of the file."""

    signal: SignalName | None = None
    """Measured signal; without it, the column is kept but not interpreted."""
    axis: Literal["x", "y", "z"] | None = None
    """Coordinate of a profile: x along the scan, y across scans, z the height, positive out of the specimen."""
    unit: Unit | None = None
    """Unit after scale and offset; overrides the unit in the file; required if the file contains none."""
    scale: float = 1.0
    """Factor by which the column is multiplied."""
    offset: float = 0.0
    """Offset that is added after scaling, in the unit of the column."""
    calibration: str | None = None
    """Name of the calibration that converts the column to the measured quantity."""


class Fact(Record):
    """Information on the run in the lines above the table."""

    pattern: Pattern
    """Regular expression; the value is the match of its first group, or the entire match if there is no group."""
    unit: Unit | None = None
    """Unit of the number, if the file contains none."""
    date: str | None = None
    """Format of a date in the codes of strftime: "%d.%m.%Y %H:%M"."""


WrittenFact = Annotated[Fact, BeforeValidator(_a_pattern_alone, json_schema_input_type=str | Fact)]


class ReaderProfile(Record):
    """Description of a text table exported by a custom-built instrument."""

    schema_version: Literal["tribopipe.reader/1"] = Field(alias="schema")
    """Version of this document."""
    name: Annotated[str, AfterValidator(_a_short_name)]
    """Short name of the format: "our-rig"."""
    title: str = Field(min_length=1)
    """Title, one line."""
    holds: Literal["signals", "profile"] = "signals"
    """Content of the files: signals of a test, or a profile measured after the test."""
    detect: Pattern | None = None
    """Regular expression found in the first lines of every file of this format, and of no other format."""
    encoding: str | None = None
    """Text encoding, such as "cp1252" or "shift_jis"; default: detected."""
    separator: Annotated[str, AfterValidator(_a_separator)] | None = None
    """Column separator, such as ";", "\\t", or " " for whitespace; required if the position of the table is given."""
    decimal: Literal[".", ","] | None = None
    """Decimal separator; default: detected."""
    starts_at: Pattern | None = None
    """Regular expression found in the first line of the table: the header row, or the first data row with names."""
    header_lines: int | None = Field(default=None, ge=0, le=250)
    """Number of lines above the first line of the table; an alternative to starts_at."""
    names: tuple[Annotated[str, Field(min_length=1)], ...] = ()
    """Names of the columns, if the file has none."""
    units_row: Literal["above", "below"] | None = None
    """Whether a row of units is above or below the header row."""
    columns: dict[str, DescribedColumn] = Field(min_length=1, max_length=1000)
    """Column name, as in the file, with or without its unit → what the column contains."""
    calibrations: dict[str, Calibration] = Field(default_factory=dict, max_length=100)
    """Calibrations by name."""
    facts: dict[str, WrittenFact] = Field(default_factory=dict, max_length=100)
    """Key of run.toml → pattern that finds its value above the table: "conditions.normal_load" → 'Load: (.*)'."""

    @property
    def tells_place(self) -> bool:
        """Whether the profile states where the table begins."""
        return self.starts_at is not None or self.header_lines is not None or bool(self.names)

    @model_validator(mode="after")
    def _place_is_told_once_and_fully(self) -> Self:
        if self.starts_at is not None and self.header_lines is not None:
            raise ValueError(
                "header_lines: found header_lines in addition to starts_at; expected only one of the two; remove the "
                "other"
            )
        if self.tells_place and self.separator is None:
            raise ValueError(
                "separator: missing; expected a column separator, since the position of the table is specified; add "
                'this key, such as separator = ";"'
            )
        if self.units_row is not None and (self.names or not self.tells_place):
            raise ValueError(
                "units_row: found units_row without the position of the header row; expected units_row only with "
                "starts_at or header_lines; specify units under columns instead"
            )
        return self

    @model_validator(mode="after")
    def _calibrations_fit(self) -> Self:
        for name, column in self.columns.items():
            if column.calibration is None:
                continue
            calibration = self.calibrations.get(column.calibration)
            if calibration is None:
                raise ValueError(
                    f"columns.{name}.calibration: found {column.calibration!r}, which is not defined under "
                    "calibrations; expected a defined calibration; "
                    f"{did_you_mean(column.calibration, self.calibrations)}"
                )
            if column.unit not in (None, calibration.reading):
                raise ValueError(
                    f"columns.{name}.unit: found {column.unit!r}; expected {calibration.reading!r}, the unit of "
                    f"the readings of calibration {column.calibration!r}; correct one of the two"
                )
        return self

    @model_validator(mode="after")
    def _columns_mean_different_things(self) -> Self:
        taken: dict[str, str] = {}
        for name, column in self.columns.items():
            if column.signal is not None and taken.setdefault(column.signal, name) != name:
                raise ValueError(
                    f"columns.{name}.signal: found {column.signal!r}, which is also the signal of "
                    f"{taken[column.signal]!r}; expected each signal once; remove one of the two"
                )
            if self.names and name not in self.names:
                raise ValueError(
                    f"columns.{name}: found a column that is not in names; {did_you_mean(name, self.names)}"
                )
        return self

    @model_validator(mode="after")
    def _facts_are_keys_of_run_toml(self) -> Self:
        known = {*_TOP_FACTS, *(f"conditions.{name}" for name in Conditions.model_fields if name != "friction")}
        for key in self.facts:
            if key not in known and not _BODY_FACT.fullmatch(key):
                raise ValueError(f"facts.{key}: found a key unknown in run.toml; {did_you_mean(key, known)}")
        return self
