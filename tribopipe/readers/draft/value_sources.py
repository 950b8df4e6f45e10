"""Sources of the values in run.toml, and their priority: person, table, headers, template, file names, recordings.

What names of files seem to state ("9-Al10Cu-50N-140m-328rpm") is a hint, and never taken: a value is offered where the
names state one alone, with the label that its unit has; all else is named and not offered. What a recording shows is
proposed where nobody states it, and compared with what is stated.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import PurePath
from typing import Any, NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ManifestError, UnitError
from tribopipe.base.units import is_rotational, is_unit_of, to_si, with_point
from tribopipe.documents.quantity import read_quantity
from tribopipe.evaluation.checks.material_ranges import typical_of
from tribopipe.readers.column_meanings import plain_name
from tribopipe.readers.draft.known_values import (
    LOAD,
    Given,
    Known,
    alike,
    bodies_of,
    counterbody_key,
    flat,
    shared_key,
    value_of,
)
from tribopipe.readers.export_files import Export
from tribopipe.readers.reader import ReadColumn

_MOST_DOUBTS = 4
_ROUNDED = 0.01
"""How far half a diameter may be from a radius for both to be the same."""
_SHAPE, _DIAMETER, _RADIUS = "contact.pin.shape", "contact.pin.diameter", "contact.pin.radius"


def gather(
    template: Mapping[str, Any],
    template_name: str,
    settings: Sequence[str],
    exports: Sequence[Export],
    measured: Mapping[str, Given] | None = None,
) -> Known:
    """Gather what a template, a person, a table of ``measured`` values and the headers of files state about a run.

    A person's word goes before the table's, that before a header's, that before a template's. Raises ``ManifestError``
    where the template, the table or the person state what cannot be; what headers state is doubted.
    """
    known = Known()
    told = {key: value for key, value in flat(template).items() if key not in ("schema", "signals")}
    known.given = {key: Given(value, f"from {template_name}") for key, value in told.items()}
    if told and (problem := known.problem()) is not None:
        raise ManifestError(f"{template_name}: {problem}")
    for key, given in (measured or {}).items():
        problem = known.take_text(key, given.value, given.origin) if isinstance(given.value, str) else None
        problem = problem if isinstance(given.value, str) else known.take(key, given.value, given.origin)
        if problem is not None:
            raise ManifestError(f"{given.origin.removeprefix('from ')}: {problem}")
        known.of_tables.add(shared_key(key))
    # The type of tribometer comes first, since it determines what bodies there are.
    for setting in sorted(settings, key=lambda one: not one.startswith("contact.kind")):
        _set(known, setting)
    for key, values in _facts(exports).items():
        _take_fact(known, counterbody_key(key, known.kind), values)
    take_radius(known)
    return known


def take_radius(known: Known) -> None:
    """Take half the diameter of a ball as its radius, where nobody has stated another one."""
    diameter, shape = (known.values.get(key) for key in (_DIAMETER, _SHAPE))
    if diameter is None or shape != "spherical":
        return
    whole, before = read_quantity(diameter, "length"), known.given.get(_RADIUS)
    half, unsure = (f"{1e3 * number / 2:.12g} mm" for number in (whole.value, whole.u_or_zero))
    origin = "half of the diameter"
    if before is not None:
        if not before.origin or alike(_RADIUS, before.value, half, _ROUNDED):
            return
        origin += f"; {before.origin.removeprefix('from ')} gives {before.value}"
    stated = half if whole.standard_uncertainty is None else {"value": half, "standard_uncertainty": unsure}
    problem = known.take(_RADIUS, stated, origin)
    if problem is not None:
        known.dissent.append(
            f"the radius of the pin is not calculated from its diameter of {whole.shown('mm')}: {problem}"
        )


def _set(known: Known, setting: str) -> None:
    key, equals, text = (part.strip() for part in setting.partition("="))
    if not equals:
        raise ManifestError(
            f"--set {setting}: found no '='; expected a key of run.toml and its value, such as {LOAD}='50 N'"
        )
    table, _, name = key.rpartition(".")
    if table == "contact.ball" and "contact.kind" in known.given and table not in bodies_of(known.kind):
        known.take(_SHAPE, "spherical")
        key = f"contact.pin.{name}"
    value = value_of(text)
    problem = known.take(key, value)
    if problem is not None and not isinstance(value, Mapping | list):
        problem = known.take_typed(key, text)
    if problem is not None:
        raise ManifestError(f"--set {setting}: {problem}")


Said = dict[str, list[str]]
"""Values of one key in headers → the files with this value, and the line if it is free text."""


def _facts(exports: Iterable[Export]) -> dict[str, Said]:
    told: dict[str, Said] = {}
    for export in exports:
        for key, text in export.header.facts.items():
            line = export.header.lines.get(key)
            source = export.name if line is None else f"{export.name}, {' '.join(line.split())!r}"
            told.setdefault(key, {}).setdefault(text, []).append(source)
    return told


def _take_fact(known: Known, key: str, said: Said) -> None:
    if len(said) > 1 and key != "started":
        for text, files in islice(said.items(), _MOST_DOUBTS):
            known.doubt(key, text, f"given by {_few(files)}; the files do not agree")
        return
    text, files = next(iter(said.items()))  # a test starts with its first file
    before, origin = known.given.get(key), f"from {_few(files)}"
    if before is not None and key in known.of_tables:
        if not alike(key, before.value, text):
            known.object(key, f"{text} {origin}")
        return
    if before is not None and not before.origin:
        known.given[key] = before if text == before.value else Given(before.value, f"{_few(files)} gives {text}")
        return
    if before is not None and text != before.value:
        known.dissent += _other_material(key, f"{text} {origin}", before)
        origin += f"; {before.origin.removeprefix('from ')} gives {before.value}"
    problem = known.take_text(key, text, origin)
    if problem is None:
        known.of_headers.add(key)
    else:
        known.doubt(key, text, f"from {_few(files)}, but {problem}")


def _other_material(key: str, stated: str, before: Given) -> list[str]:
    """Report another material than that of the template, whose modulus is used."""
    if not key.endswith(".material"):
        return []
    return [
        f"{key}: found {stated}, but {before.value} {before.origin}; expected both to agree; check that the modulus "
        "in run.toml is correct for the material"
    ]


def _few(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"


_DATE = re.compile(r"(?<!\d)(?:\d{4}([-_.]?)\d\d\1\d\d|\d\d([-_.])\d\d\2\d{4})(?!\d)", re.ASCII)
# A number with its unit, and the letters in front of it; none behind a digit and a dash, which may be a decimal sign:
# "0-3N".
_HINT = re.compile(
    r"(?<![^\W_])(?<![.,])(?<!\d[-_])(?P<label>[^\W\d_]*)(?P<gap>[ =]?)(?P<number>\d+(?:[.,]\d+)?) ?"
    r"(?P<unit>mN|kN|N|rpm|mm[-_/]s|mmp?s|m[-_/]s|mp?s|mm|Hz|°C|degC)(?![^\W_]|[.,]\d)"
)


class _Meaning(NamedTuple):
    """Meaning of a number with a unit after certain labels."""

    key: str
    unit: str
    labels: tuple[str, ...]


_LOADS = ("", "f", "fn", "load", "last", "kraft")
_SPEED = ("v", "speed")
_MEANINGS: dict[str, tuple[_Meaning, ...]] = {
    **{unit: (_Meaning(LOAD, unit, _LOADS),) for unit in ("mN", "kN", "N")},
    **dict.fromkeys(
        ("mm/s", "mm-s", "mm_s", "mmps", "mms"), (_Meaning("conditions.sliding_speed", "mm/s", ("", *_SPEED)),)
    ),
    **dict.fromkeys(("m/s", "m-s", "m_s", "mps"), (_Meaning("conditions.sliding_speed", "m/s", ("", *_SPEED)),)),
    "ms": (_Meaning("conditions.sliding_speed", "m/s", _SPEED),),  # alone, milliseconds
    "rpm": (_Meaning("conditions.rotational_speed", "rpm", ("", "n")),),
    "Hz": (_Meaning("conditions.frequency", "Hz", ("", "f")),),
    **dict.fromkeys(("°C", "degC"), (_Meaning("conditions.temperature", "degC", ("", "t", "temp")),)),
    "mm": (
        _Meaning("contact.pin.diameter", "mm", ("ball", "kugel", "bille", "bola", "kulka")),
        _Meaning("conditions.track_radius", "mm", ("r", "radius", "track", "spur")),
        _Meaning("conditions.stroke", "mm", ("stroke", "hub")),
    ),
}


def doubt_names(known: Known, names: Iterable[str]) -> None:
    """Offer what names of files, where they agree, seem to state about what is not known."""
    seen: dict[str, dict[str, str]] = {}
    for name in names:
        for key, value, written in _said(PurePath(name).stem):
            seen.setdefault(key, {}).setdefault(value, written)
    for key, values in seen.items():
        fitting = [value for value in values if known.fits(key, value)]
        stated = known.given.get(key)
        for value in fitting:
            if stated is not None and not (len(fitting) == 1 and alike(key, stated.value, value)):
                known.object(key, f"{values[value]!r} in the file name")
            elif stated is None and len(fitting) == 1:
                known.offer(key, value, f"suggested by the file name, {values[value]!r}")
            elif stated is None:
                known.doubt(key, value, f"the file name contains {values[value]!r} and another value")


def _said(stem: str) -> Iterator[tuple[str, str, str]]:
    """Give key, value and what is written of each value in a name."""
    for found in _HINT.finditer(_DATE.sub("", stem)):
        labels = (found["label"].casefold(), "") if found["gap"] == " " else (found["label"].casefold(),)
        meanings = _MEANINGS[found["unit"]]
        meaning = next((one for label in labels for one in meanings if label in one.labels), None)
        if meaning is None:
            continue
        try:
            yield meaning.key, with_point(f"{found['number']} {meaning.unit}"), found[0].strip()
        except UnitError:
            continue


_SIGNALS = {
    "normal_force": (LOAD, "force"),
    "sliding_speed": ("conditions.sliding_speed", "speed"),
}
"""Key of run.toml and kind of quantity, by the signal; a temperature need not be that of the room."""
_NAMES = {
    "frequency": ("conditions.frequency", "frequency"),
    "stroke": ("conditions.stroke", "length"),
    "radius": ("conditions.track_radius", "length"),
    "trackradius": ("conditions.track_radius", "length"),
}
"""The same, by the name of a column that is no signal."""
_FEW_DIGITS = ".4g"
_STEADY, _MOST_ROWS_OFF = 0.1, 0.2
_CONTRADICTS = 0.2
"""Largest relative difference between recorded and stated value that is no contradiction."""


class Recorded(NamedTuple):
    """Value of one test condition from a recorded column."""

    key: str
    kind: str
    column: ReadColumn
    values: Column
    """Finite ones, in the column's unit."""
    where: str

    @property
    def value(self) -> str:
        """The median, as run.toml would hold it; weights are forces."""
        unit = self.column.unit or "1"
        median = float(np.median(np.abs(self.values)))
        if self.kind == "force" and is_unit_of(unit, "mass"):
            return f"{float(to_si(median, f'({unit})*g_0', 'force')):{_FEW_DIGITS}} N"
        return f"{median:{_FEW_DIGITS}} {unit}"

    @property
    def is_steady(self) -> bool:
        """Whether most values lie close to the median."""
        sizes = np.abs(self.values)
        off = np.abs(sizes - np.median(sizes)) > _STEADY * np.median(sizes)
        return float(np.mean(off)) <= _MOST_ROWS_OFF


def recorded(exports: Sequence[Export], step: tuple[str, int] | None = None) -> Iterator[Recorded]:
    """Give what was recorded of the conditions, in all rows or in those of a step: its column, and its number."""
    for export in exports if step is None else exports[:1]:
        numbers = next((one.values for one in export.table.columns if step and one.name == step[0]), None)
        rows = slice(None) if numbers is None or step is None else np.asarray(numbers, dtype=float) == step[1]
        for key, kind, column in _columns(export):
            values = np.asarray(column.values[rows], dtype=float)
            values = values[np.isfinite(values)]
            if len(values) and np.any(values):
                yield Recorded(key, kind, column, values, "" if step is None else f" in step {step[1]}")


def _columns(export: Export) -> Iterator[tuple[str, str, ReadColumn]]:
    turning = rotational_speeds(export)
    for column in export.table.columns:
        meaning = export.meanings.get(column.name)
        known = _SIGNALS.get(meaning.signal) if meaning and not meaning.doubt else _NAMES.get(plain_name(column))
        if column.first_bad is not None or column.unit is None or column.values.dtype.kind != "f":
            continue
        if turning == [column]:
            yield "conditions.rotational_speed", "rotational speed", column
        elif known and (is_unit_of(column.unit, known[1]) or (known[1] == "force" and is_unit_of(column.unit, "mass"))):
            yield *known, column


def rotational_speeds(export: Export) -> list[ReadColumn]:
    """Return the columns of a rotational speed, such as "Rotary.Velocity (rpm)"."""
    return [
        column
        for column in export.table.columns
        if column.first_bad is None and column.unit is not None and is_rotational(column.unit)
    ]


def propose_recorded(known: Known, exports: Sequence[Export], step: tuple[str, int] | None = None) -> None:
    """Offer what was recorded of the conditions, where nobody has stated them, and note what it contradicts.

    What a header states against the recording is not taken any more; the word of a person or a template stays.
    """
    for one in recorded(exports, step):
        source = f"median of {one.column.name!r}{one.where}"
        stated = known.given.get(one.key)
        if stated is not None and one.is_steady and not alike(one.key, one.value, stated.value, _CONTRADICTS):
            known.object(one.key, f"a {source} of {one.value}")
            if one.key in known.of_headers:
                known.doubt(one.key, stated.value, f"{stated.origin}, which the recording contradicts")
                del known.given[one.key]
        if one.key in known.given or not known.fits(one.key, one.value):
            continue
        if one.is_steady:
            known.offer(one.key, one.value, source)
        else:
            known.doubt(one.key, one.value, f"{source}, which is not steady")


def offer_typical(known: Known) -> None:
    """Offer what is typical of the material of each body, where nobody has stated it."""
    for table in bodies_of(known.kind):
        material = known.given.get(f"{table}.material")
        found = None if material is None else typical_of(str(material.value))
        if found is None:
            continue
        title, typical = found
        offers = {
            "youngs_modulus": f"{typical.modulus:g} GPa",
            "poisson_ratio": typical.poisson_ratio,
            "density": f"{typical.density:g} g/cm^3",
        }
        for key in (f"{table}.{name}" for name in offers):
            if key not in known.given and key not in known.doubts:
                known.offer(key, offers[key.rpartition(".")[2]], f"typical of {title}")
