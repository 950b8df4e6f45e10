"""Runs as a list gives them: its columns, what one run has in each, and the order of several.

Nothing heavy is imported here: listing needs no units.
"""

import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cache, lru_cache
from typing import Any, Literal, NamedTuple

from tribopipe.base.column_formatting import moment
from tribopipe.base.errors import QueryError, did_you_mean
from tribopipe.base.files import natural_key
from tribopipe.base.plugins import names
from tribopipe.physics.calculation_methods import LAW_GROUP

ITEM = "\n"
"""Separator between several texts of one run in the catalog."""


@dataclass(frozen=True)
class ListedColumn:
    """One column: what it holds, and how it is shown."""

    name: str
    """Name in --where, --sort and --columns."""
    label: str
    """Heading, without the unit."""
    help: str
    """Meaning of the column."""
    kind: Literal["number", "text", "date"] = "text"
    unit: str = ""
    """Unit in which numbers are shown; empty for texts and plain numbers."""
    measures: str = ""
    """Kind of number, a key of ``tribopipe.base.units.KINDS``."""
    joint: str | None = None
    """Separator between several texts of one run; none if there is at most one."""
    shown: bool = False
    """Whether the column is listed by default."""
    exact: bool = False
    """Whether its numbers have no uncertainty."""

    @property
    def heading(self) -> str:
        """Label and unit: "load, mN"."""
        return f"{self.label}, {self.unit}" if self.unit else self.label


class Cell(NamedTuple):
    """What a run has in a column: a number in SI, or a text; as it is shown, without the unit."""

    value: float | str | None = None
    standard_uncertainty: float | None = None
    shown: str | None = None


def _text(name: str, label: str, about: str, *, joint: str | None = None, shown: bool = False) -> ListedColumn:
    return ListedColumn(name, label, about, joint=joint, shown=shown)


def _number(name: str, label: str, about: str, measures: str, unit: str = "", *, shown: bool = False) -> ListedColumn:
    return ListedColumn(name, label, about, kind="number", measures=measures, unit=unit, shown=shown)


def _of_other_laws() -> Iterator[ListedColumn]:
    """Give the columns of each further wear law; its name gives them, so that it is not loaded."""
    for law in names(LAW_GROUP):
        if law not in ("archard", "sarkar") and law.isidentifier():
            by = law.replace("_", " ")
            of_one = "of the pin or the crowned disc"
            yield _number(f"k_d_{law}", f"k_D ({by})", f"Wear coefficient {of_one} ({by}).", "wear coefficient", _K_D)
            yield _number(
                f"k_d_{law}_disc",
                f"k_D disc ({by})",
                f"Wear coefficient of the disc or the cylindrical disc ({by}).",
                "wear coefficient",
                _K_D,
            )
            yield _number(
                f"predicted_depth_{law}",
                f"predicted wear depth ({by})",
                f"Predicted wear depth ({by}).",
                "length",
                "µm",
            )


PER_SI: Mapping[str, float] = {
    "": 1.0,
    "N": 1.0,
    "m": 1.0,
    "%": 1e2,
    "mN": 1e3,
    "mm": 1e3,
    "mm/s": 1e3,
    "µm": 1e6,
    "mm³": 1e9,
    "mm³/(N·mm)": 1e6,
    "mm³/(N·m)": 1e9,
    "nm/min": 6e10,
}
"""How many of a column's unit one SI unit is, so that listing needs no units; temperatures are shown as they are."""
_K_D, _RATE = "mm³/(N·mm)", "mm³/(N·m)"

_ALL = (
    _text("id", "run", "ID of the run.", shown=True),
    _text("mark", "mark", "'bad' if the run is marked bad.", shown=True),
    _text("tags", "tags", "Tags of the run.", joint=", ", shown=True),
    _text("title", "title", "Title of the run."),
    _text("tribometer", "tribometer", "Type of tribometer.", shown=True),
    _text("material", "materials", "Materials of the bodies.", joint=" / ", shown=True),
    _text("pin_material", "pin material", "Material of the pin."),
    _text("disc_material", "disc material", "Material of the disc under the pin."),
    _text("curved_disc_material", "crowned disc material", "Material of the crowned disc."),
    _text("flat_disc_material", "cylindrical disc material", "Material of the cylindrical disc."),
    _text("shape", "shape", "Shape of the pin."),
    _number("radius", "radius", "Radius of the pin, or of the crowned disc's crown.", "length", "mm"),
    _text("medium", "medium", "Environment or lubricant.", shown=True),
    _number("load", "load", "Nominal normal load.", "force", "mN", shown=True),
    _number("speed", "speed", "Nominal sliding speed, or speed of the crowned disc.", "speed", "mm/s"),
    _number("distance", "distance", "Sliding distance at the end, recorded or planned.", "distance", "m"),
    _number("rotations", "rotations", "Rotations of the crowned disc, recorded or planned.", "count"),
    _number("slip", "slip", "Nominal slip of two discs.", "percentage", "%"),
    _number("temperature", "temperature", "Room temperature.", "temperature", "°C"),
    _number("humidity", "humidity", "Relative humidity of the surrounding air.", "percentage", "%"),
    _number("friction", "steady-state μ", "Steady-state friction coefficient (b in the fit).", "ratio", shown=True),
    _number("friction_amplitude", "A", "Initial minus steady-state friction coefficient (A in the fit).", "ratio"),
    _number("running_in", "c", "Running-in distance (c in the fit).", "distance", "m"),
    _number("mean_friction", "mean μ", "Mean friction coefficient over the entire run.", "ratio"),
    _number("drift_rate", "drift", "Drift rate of the depth signal.", "drift rate", "nm/min"),
    _number(
        "discrepancy", "discrepancy", "Wear depth from the sensor minus the post-test measurement.", "length", "µm"
    ),
    _number(
        "k_d",
        "k_D",
        "Wear coefficient of the pin or the crowned disc (Archard's law).",
        "wear coefficient",
        _K_D,
        shown=True,
    ),
    _number(
        "k_d_sarkar",
        "k_D (Sarkar)",
        "Wear coefficient of the pin or the crowned disc (Sarkar's law).",
        "wear coefficient",
        _K_D,
    ),
    _number(
        "k_d_disc",
        "k_D disc",
        "Wear coefficient of the disc or the cylindrical disc (Archard's law).",
        "wear coefficient",
        _K_D,
    ),
    _number(
        "k_d_sarkar_disc",
        "k_D disc (Sarkar)",
        "Wear coefficient of the disc or the cylindrical disc (Sarkar's law).",
        "wear coefficient",
        _K_D,
    ),
    _number("end_depth", "final wear depth", "Final wear depth of the pin or of both discs together.", "length", "µm"),
    _number("predicted_depth", "predicted wear depth", "Predicted wear depth (Archard's law).", "length", "µm"),
    _number(
        "predicted_depth_sarkar",
        "predicted wear depth (Sarkar)",
        "Predicted wear depth (Sarkar's law).",
        "length",
        "µm",
    ),
    _number("wear_volume", "wear volume", "Wear volume of the pin or the crowned disc.", "volume", "mm³"),
    _number(
        "disc_wear_volume", "disc wear volume", "Wear volume of the disc or the cylindrical disc.", "volume", "mm³"
    ),
    _number("wear_rate", "wear rate", "Specific wear rate of the pin or crowned disc.", "wear coefficient", _RATE),
    _number(
        "disc_wear_rate",
        "disc wear rate",
        "Specific wear rate of the disc or cylindrical disc.",
        "wear coefficient",
        _RATE,
    ),
    ListedColumn("started", "started", "Start of the test, local time.", kind="date", shown=True),
    _text("operator", "operator", "Person who ran the test."),
    _text("instrument", "instrument", "Name of the tribometer."),
    _text("comment", "comment", "Comment in run.toml."),
    _text("stage", "stage", "Last step of the run.", shown=True),
    _text("steps", "steps", "All steps of the run.", joint=", "),
    _text("missing", "missing", "Missing inputs, such as a post-test measurement.", joint="; "),
    replace(_number("findings", "findings", "Number of errors and warnings at ingest.", "count"), exact=True),
    ListedColumn("amended", "amended", "Date of the last amendment of run.toml.", kind="date"),
    _text("run_toml", "run.toml", "SHA-256 of run.toml."),
    _text("marked_bad", "reason for bad mark", "Reason for the bad mark."),
    _text("notes", "notes", "Notes on the run.", joint="; "),
    _text("studies", "studies", "Studies that include the run.", joint=", "),
    _text("agreement", "agreement", "Agreement of the run with each law in these studies.", joint="; "),
)

COLUMNS: Mapping[str, ListedColumn] = {column.name: column for column in (*_ALL, *_of_other_laws())}
"""Columns by name, in the order of the list."""

ALIASES: Mapping[str, str] = {
    "run": "id",
    "tag": "tags",
    "note": "notes",
    "materials": "material",
    "pin_radius": "radius",
    "crown_radius": "radius",
    "normal_load": "load",
    "sliding_speed": "speed",
    "sliding_distance": "distance",
    "relative_humidity": "humidity",
    "mu": "friction",
    "μ": "friction",
    "µ": "friction",
    "k_d_archard": "k_d",
    "date": "started",
    "step": "steps",
    "study": "studies",
}
"""Other names of columns."""


def of_law(law: str) -> str:
    """Return how the columns of a wear law end; those of Archard's have the plain names."""
    return "" if law == "archard" else f"_{law}"


def column_named(name: str, where: str = "") -> ListedColumn:
    """Return a column by its name or alias, in any case, with - for _.

    Raises ``QueryError``, which states ``where`` the name was found and which one is nearest.
    """
    plain = name.strip().replace("-", "_")
    known = plain if plain in ALIASES else plain.lower()
    column = COLUMNS.get(ALIASES.get(known, known))
    if column is None:
        raise QueryError(f"found {name!r}{where}; expected a column name; {_nearest(known)}")
    return column


def columns_named(names: str) -> list[ListedColumn]:
    """Return the columns of a list such as "id,load". Raises ``QueryError`` where there is no such column."""
    return [column_named(name, " among the columns") for name in names.split(",")]


def _nearest(name: str) -> str:
    near = did_you_mean(name, [*COLUMNS, *ALIASES])
    return near if near.startswith("did") else "`tribopipe ls --columns help` lists them all"


_STEP_WORDS: Mapping[str, str] = {
    "clean_up": "preprocessing",
    "drift_correction": "drift",
    "friction_fit": "friction",
    "specific_wear": "specific wear",
}
_UNDER_LAWS = {"wear_fit_": "", "prediction_": "predicted by ", "local_wear_": "local wear by "}


def step_words(step: str) -> str:
    """Return a step of a run as a list shows it: "predicted by Running in" for ``prediction_running_in``."""
    for begins, words in _UNDER_LAWS.items():
        if step.startswith(begins):
            return words + " ".join(filter(None, step.removeprefix(begins).split("_"))).capitalize()
    return _STEP_WORDS[step]


def steps_in_words(steps: str | None) -> str | None:
    """Return the steps of a run, as the catalog holds them, in the words of a list."""
    return steps and ITEM.join(map(step_words, steps.split(ITEM)))


class ListedRun:
    """One run: what is known of it in each column."""

    def __init__(self, row: sqlite3.Row, places: Mapping[str, int]) -> None:
        self._row, self._places = row, places

    def __getitem__(self, name: str) -> Any:
        """Return what the catalog holds under a name; a row looks names up one by one, which takes long."""
        return self._row[self._places[name]]

    def __repr__(self) -> str:
        return f"ListedRun({self.id!r})"

    @property
    def id(self) -> str:
        """Name of the run."""
        return str(self["id"])

    def text(self, name: str) -> str:
        """Return what is shown in a column, numbers without their unit; empty where nothing is known."""
        return _shown_text(COLUMNS[name])(self)

    def texts(self, name: str) -> list[str]:
        """Return the texts of a column that can hold several, such as the tags."""
        held = self[name]
        return held.split(ITEM) if held else []

    def number(self, name: str) -> float | None:
        """Return a number in the unit of its column; none where nothing is known."""
        return shown_number(COLUMNS[name])(self.value(name))

    def spread(self, name: str) -> float | None:
        """Return the standard uncertainty of a number in the unit of its column; none where nothing is known."""
        return shown_number(COLUMNS[name], spread=True)(self.uncertainty(name))

    def value(self, name: str) -> float | None:
        """Return a number in SI; none if it is unknown."""
        found: float | None = self[name]
        return found

    def uncertainty(self, name: str) -> float | None:
        """Return the standard uncertainty of a number in SI; none where nothing is known."""
        found: float | None = self[f"{name}_uncertainty"]
        return found

    def date(self, name: str) -> str | None:
        """Return a date as run.toml has it, ISO 8601; none where nothing is known."""
        found: str | None = self[name]
        return found


def texts_in(column: ListedColumn, held: str | None) -> list[str]:
    """Return each text that a run has in a column, in the words of a list; the day of a date."""
    if column.kind == "date":
        return [held[:10]] if held else []
    shown = steps_in_words(held) if column.name == "steps" else held
    return shown.split(ITEM) if shown else []


def texts_of(runs: Iterable[ListedRun], column: ListedColumn) -> list[str]:
    """Return what is shown of several runs in one column, sooner than run by run."""
    shown = _shown_text(column)
    return [shown(run) for run in runs]


@cache
def _shown_text(column: ListedColumn) -> Callable[[ListedRun], str]:
    """Return what reads the text of a column out of a run."""
    name = column.name
    if column.kind == "number":
        shown = f"{name}_shown"
        return lambda run: run[shown] or ""
    shown_as = _shown_as(column)
    return lambda run: shown_as(run[name])


@cache
def _shown_as(column: ListedColumn) -> Callable[[str | None], str]:
    """Return what turns a text or date, as the catalog holds it, into what is shown."""
    joint = column.joint or " "
    if column.kind == "date":
        return lambda held: moment(datetime.fromisoformat(held).replace(tzinfo=None)) if held else ""
    if column.name == "steps":
        return lambda held: (steps_in_words(held) or "").replace(ITEM, joint)
    return lambda held: (held or "").replace(ITEM, joint)


@cache
def shown_number(column: ListedColumn, *, spread: bool = False) -> Callable[[float | None], float | None]:
    """Return what turns SI into the unit of a column, in as many digits as are sure."""
    from tribopipe.base.units import KINDS, from_si, interval_from_si

    convert, si = interval_from_si if spread else from_si, KINDS[column.measures].si
    return lambda value: None if value is None else float(f"{convert(value, si, column.unit):.15g}")


def usual_columns(runs: Sequence[ListedRun]) -> list[ListedColumn]:
    """Return the columns that are shown unless others are chosen, but for those of which nothing is known."""
    usual = [column for column in COLUMNS.values() if column.shown]
    return [column for column in usual if column.name == "id" or any(run.text(column.name) for run in runs)]


def ordered_by(sort: str) -> list[tuple[ListedColumn, bool]]:
    """Return the columns of an order such as "material,-k_d", and whether each is descending; the ID comes last.

    Raises ``QueryError`` where there is no such column.
    """
    names = [name.strip() for name in sort.split(",")]
    columns = [(column_named(name.removeprefix("-"), " to sort by"), name.startswith("-")) for name in names]
    by_id = (COLUMNS["id"], False)
    return [by_id] if columns[0] == by_id else [*columns, by_id]


def has_words(words: str, names: str, *held: str | None) -> bool:
    """Return whether each of some words is in what is shown of a run in some columns, in any case.

    Names of columns are separated by commas; of a number, ``held`` is the text that is shown.
    """
    columns = [COLUMNS[name] for name in names.split(",")]
    texts = (
        (text or "") if column.kind == "number" else _shown_as(column)(text)
        for column, text in zip(columns, held, strict=True)
    )
    row = ITEM.join(texts).lower()
    return all(word in row for word in words.lower().split())


@lru_cache(maxsize=4096)
def sort_key(name: str, held: str | None) -> bytes | None:
    """Return what a text or date of a column is sorted by; none where it is unknown."""
    text = _shown_as(COLUMNS[name])(held)
    return natural_key(text.casefold()) if text else None
