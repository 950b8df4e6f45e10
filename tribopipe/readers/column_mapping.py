"""Meanings of the columns of a table, from the manifest or else from the file, and their signals in SI.

Also the files that run.toml names and the columns found in them by name, with the errors that all of that can have.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ReaderError, UnitError, did_you_mean
from tribopipe.base.files import beside, leads_out, read_file
from tribopipe.base.units import KINDS, is_rotational, is_unit, is_unit_of, show, to_si
from tribopipe.documents.manifest import ColumnSource, RunManifest, SignalFile, SignalSource
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.readers.column_meanings import Meaning, is_synonym, meanings_of, unit_for
from tribopipe.readers.number_fields import remarks
from tribopipe.readers.reader import Hints, ReadColumn, ReadTable
from tribopipe.readers.tables import GROUPED, bare_name, is_number
from tribopipe.results.run import AT_A_LEVER, OF_ANOTHER_KIND, READ_IN, ExtraColumn, SourceFile

T = TypeVar("T")
_MOST = 1e60
_POWER = r"(?:10\s*(?:\^|\*\*)\s*[-+]?\d|10[⁻²³⁴⁵⁶]+|1000|1e-?\d)"
_TURNS = r"(?:rev|turn|lap|cyc|rot|umdr|tour|obr)\w*\.?"
_FACTOR = re.compile(
    rf"[\[(]\s*(?:[x×*·]\s*)?(?:{_POWER}(?:\s*{_TURNS})?|[kM]\s?{_TURNS})\s*[\])]|(?<![^\W_])[x×]\s*{_POWER}(?!\w)",
    re.IGNORECASE,
)
"""Factor in the name of a column, such as "[10^3]", "(krev)" or "x1000"."""


def read_source(folder: Path, name: str, key: str = "signals.file", what: str = "signal file") -> SourceFile:
    """Read a file that a key of run.toml names. Raises ``ReaderError`` where that cannot be done."""
    return with_file(folder, name, lambda path: SourceFile(name, read_file(path)), key, what)


def with_file(
    folder: Path, name: str, read: Callable[[Path], T], key: str = "signals.file", what: str = "signal file"
) -> T:
    """Return what is read of a file that a key of run.toml names. Raises ``ReaderError`` where that cannot be done."""
    path = folder / name
    if leads_out(path, folder):
        raise ReaderError(
            f"{name}: found a link to a file outside the run folder; expected a {what} in the run folder, which must "
            "contain all files of the run; replace the link with a copy of the file"
        )
    try:
        if path.is_dir():
            raise ReaderError(f"{name}: found a folder; expected a {what}; specify the file in run.toml under {key}")
        return read(path)
    except FileNotFoundError:
        raise ReaderError(
            f"{name}: no such file; expected the {what} specified in run.toml; {did_you_mean(name, beside(path))}"
        ) from None
    except OSError as error:
        raise ReaderError(
            f"{name}: cannot be read ({error.strerror}); expected a readable file; check its permissions"
        ) from None


def find_column(table: ReadTable, wanted: str, meaning: str, file: str) -> ReadColumn:
    """Return the column with a name, with or without unit. Raises ``ReaderError`` if there is none or more than one."""
    exact = [column for column in table.columns if column.name == wanted.strip()]
    found = exact or [column for column in table.columns if bare_name(column.name) == wanted.strip()]
    if len(found) == 1:
        return found[0]
    names = [column.name for column in table.columns]
    if len(found) > 1:
        raise ReaderError(
            f"{file}: found {len(found)} columns that match {wanted!r} for {meaning}; expected one column; specify "
            f"the name with its unit: {', '.join(repr(column.name) for column in found)}"
        )
    raise ReaderError(
        f"{file}: found no column {wanted!r} for {meaning}; expected it in the header; {did_you_mean(wanted, names)}"
    )


def needs_unit(kind: str) -> bool:
    """Return whether numbers of a kind have no meaning without a unit; a percentage may as well be a share of 1."""
    return KINDS[kind].si != "1" or kind == "percentage"


def unit_of(column: ReadColumn, source: ColumnSource | None) -> str | None:
    """Return the unit of a column from the manifest, else from the file."""
    return (source.unit if source else None) or column.unit


def contradiction(column: ReadColumn, stated: str | None, where: str, *, scaled: bool = False) -> str | None:
    """Report that a unit stated elsewhere is another than the file's own one; a scale converts units of two kinds."""
    if stated is None or column.unit is None:
        return None
    own, read = _beside(column.unit, stated), _beside(stated, column.unit)
    kind = next((kind for kind in KINDS if is_unit_of(read, kind) and is_unit_of(own, kind)), None)
    if kind is None and (scaled or not _are_of_two_kinds(own, read)):
        return None
    if kind is not None and all(to_si(value, read, kind) == to_si(value, own, kind) for value in (0.0, 1.0)):
        return None
    other = f", {OF_ANOTHER_KIND}" if kind is None else ""
    return f"column {column.name!r} is in {column.unit} in the file{other}, but {READ_IN} {stated} as stated in {where}"


def _beside(unit: str, other: str) -> str:
    """Return a unit as it is meant where another one is stated: "C" for a column in K, or "kg" for one in N."""
    if is_unit_of(other, "temperature") and unit in ("C", "F"):
        return f"deg{unit}"
    return f"({unit})*g_0" if is_unit_of(other, "force") and is_unit_of(unit, "mass") else unit


def _are_of_two_kinds(unit: str, other: str) -> bool:
    """Return whether units are of two kinds; none of "-" or counts, and "S" may be written for "s"."""
    known = all(is_unit(one) and not is_unit_of(one, "ratio") for one in (unit, other))
    return known and unit.casefold() != other.casefold()


def is_a_weight(column: ReadColumn, source: ColumnSource | None, kind: str) -> bool:
    """Return whether a force is given as a mass, which as a force can only be the weight of it."""
    unit = unit_of(column, source)
    return kind == "force" and unit is not None and is_unit_of(unit, "mass")


def column_in_si(
    column: ReadColumn, source: ColumnSource | None, meaning: str, kind: str, file: str, before: int = 0
) -> Column:
    """Return a column in SI, by the manifest's unit or the file's own; so many rows were read ``before`` it.

    Raises ``ReaderError`` where not all of it are numbers, or the unit is missing or of another kind.
    """
    _refuse_text(column, meaning, file)
    unit = unit_for(kind, unit_of(column, source))
    if unit is None and not needs_unit(kind) and (factor := _FACTOR.search(column.name)):
        units = '"kcount" for thousands, or "count"' if kind == "count" else '"permille" for thousandths, or "1"'
        raise ReaderError(
            f"{file}, column {column.name!r}: found {factor[0]!r}, which may be a factor; expected a unit for "
            f"{meaning}; add it in run.toml: {meaning} = {{ column = {column.name!r}, unit = … }}; enter {units} for "
            "values without a factor"
        )
    if unit is None and needs_unit(kind):
        raise ReaderError(
            f"{file}, column {column.name!r}: found no unit; expected a unit for {meaning}; add it in run.toml: "
            f"{meaning} = {{ column = {column.name!r}, unit = … }}"
        )
    if is_a_weight(column, source, kind):
        unit = f"({unit})*g_0"
    values = np.asarray(column.values, dtype=float)
    _refuse_absurd(values, f"{file}, column {column.name!r}", meaning, before)
    try:
        return np.asarray(to_si(values, unit or "1", kind), dtype=float)
    except UnitError as error:
        raise ReaderError(f"{file}, column {column.name!r} for {meaning}: {error}") from None


def _refuse_text(column: ReadColumn, meaning: str, file: str) -> None:
    """Refuse a column in which a field is no number."""
    if column.first_bad is None:
        return
    line, text = column.first_bad
    if text == column.name:
        raise ReaderError(
            f"{file}, line {line}: found the header row again; expected one table per file; split the file there"
        )
    wanted, remedy = [], ""
    if is_number(text, ".,"):
        wanted.append("with the decimal separator of the others")
    if GROUPED.fullmatch(text):
        wanted.append("without thousands separators")
        remedy = "export the file again without them, "
    raise ReaderError(
        f"{file}, line {line}, column {column.name!r}: found {text!r}; expected a number for "
        f"{' '.join([meaning, ' and '.join(wanted)]).strip()}; {remedy}correct that line, leave the field empty "
        "for a missing sample, or map another column"
    )


def _refuse_absurd(values: Column, where: str, meaning: str, before: int) -> None:
    """Refuse numbers whose sums and squares would be none any more."""
    absurd = np.flatnonzero(np.abs(values) > _MOST)
    if len(absurd):
        raise ReaderError(
            f"{where}: found {values[absurd[0]]:g} in row {before + absurd[0] + 1} of the table; expected a value that "
            f"an instrument can record for {meaning}; correct that row, or leave the field empty"
        )


class Arms(NamedTuple):
    """Lengths, m, by which what turns becomes what slides; none where run.toml does not state them."""

    track: float | None = None
    """Radius of the circle of the wear track."""
    friction: float | None = None
    """Friction torque over friction force."""
    shared: bool = False
    """Whether several contacts share the load, so that a force without its arm has no meaning."""

    @classmethod
    def of(cls, manifest: RunManifest) -> "Arms":
        """Return the arms of a run."""
        radius, contact = manifest.conditions.track_radius, manifest.contact
        shared = contact is not None and contact.load_share != 1
        return cls(None if radius is None else radius.value, manifest.friction_arm, shared)


NO_ARMS = Arms()


class Part(NamedTuple):
    """Columns of one file, of several consecutive ones, or of some rows."""

    columns: dict[SignalName, Column]
    extras: dict[str, ExtraColumn]


def hints_of(signals: SignalFile) -> Hints:
    """Return what the manifest states about how files are written."""
    return Hints(signals.encoding, signals.separator, signals.decimal, signals.sheet)


Meanings = dict[str, list[tuple[SignalName, SignalSource | None]]]


def meanings_in(table: ReadTable, signals: SignalFile, file: str) -> Meanings:
    """Report for each column by name which signals it is: by the manifest's word, else by the format's or its own name.

    Where the manifest maps no column of the file, names that stand for a signal count, too.
    """
    meanings: Meanings = {}
    for name, source in signals.columns.items():
        meanings.setdefault(find_column(table, source.column, name, file).name, []).append((name, source))
    meanings |= {name: [(meaning.signal, None)] for name, meaning in _by_the_file(table, signals) if not meaning.doubt}
    if not meanings:
        names = ", ".join(repr(column.name) for column in table.columns[:8])
        raise ReaderError(
            f"{file}: found the columns {names}, none of which is recognized as a signal; expected at least one "
            "signal; map columns to signals under [signals.columns] in run.toml"
        )
    return meanings


def _by_the_file(table: ReadTable, signals: SignalFile) -> Iterator[tuple[str, Meaning]]:
    """Give what columns mean that the manifest does not map, and signals that it maps to none."""
    mapped = {find_column(table, source.column, "", "").name for source in signals.columns.values()}
    columns = [column for column in table.columns if column.name not in mapped]
    for name, meaning in meanings_of(columns, frozenset(signals.columns)).items():
        if not (meaning.synonym and signals.columns):
            yield name, meaning


def doubts_on(table: ReadTable, signals: SignalFile, file: str) -> list[str]:
    """Report which columns seem to be signals and are not used, and why."""
    return [
        f"{file}: column {name!r} seems to be {meaning.signal} and is not used: {meaning.doubt}"
        for name, meaning in _by_the_file(table, signals)
        if meaning.doubt
    ]


def part_of(table: ReadTable, meanings: Meanings, file: str, before: int = 0, arms: Arms = NO_ARMS) -> Part:
    """Return the signals of a table in SI, and what no signal is made of; so many rows were read ``before`` it.

    A rotational speed n that is given for the sliding speed is one on a track of radius R, m: v = 2πR·n. A torque T
    that is given for the friction force has an arm r: F = T/r; so does a force
    F_m at a lever r_m: T = F_m·r_m.

    Raises ``ReaderError`` where a column does not hold what it should.
    """
    part = Part({}, {})
    for column in table.columns:
        for name, told in meanings.get(column.name, []):
            unit = unit_of(column, told) or "1"
            if name == "sliding_speed" and is_rotational(unit):
                part.columns[name] = _on_track(column, told, file, before, arms.track)
                continue
            if told is not None and told.arm is not None:
                part.columns[name] = _at_contact(column, told, told.arm.value, file, before, arms.friction)
                continue
            if name == "friction_force" and is_unit_of(unit, "torque"):
                if told is None and arms.friction is None:
                    part.extras[column.name] = ExtraColumn(column.values, column.unit)
                else:
                    part.columns[name] = _on_arm(column, told, file, before, arms.friction)
                continue
            part.columns[name] = column_in_si(column, told, name, SIGNALS[name].kind, file, before)
        if column.name not in meanings:
            part.extras[column.name] = ExtraColumn(column.values, column.unit)
    return part


def _on_track(
    column: ReadColumn, told: ColumnSource | None, file: str, before: int, track_radius: float | None
) -> Column:
    """Return the sliding speed, m/s, of a rotational speed. Raises ``ReaderError`` where no track radius is stated."""
    if track_radius is None:
        raise ReaderError(
            f"{file}, column {column.name!r}: found a rotational speed for sliding_speed but no track radius in "
            'run.toml; expected a track radius R, since v = 2πR·n; add conditions.track_radius, such as "6 mm"'
        )
    return track_radius * column_in_si(column, told, "sliding_speed", "rotational speed", file, before)


def _on_arm(column: ReadColumn, told: SignalSource | None, file: str, before: int, arm: float | None) -> Column:
    """Return the friction force, N, of a friction torque. Raises ``ReaderError`` where run.toml states no arm."""
    torque = column_in_si(column, told, "friction_force", "torque", file, before)
    return torque / _known(arm, column, "torque", file)


def _at_contact(
    column: ReadColumn, told: SignalSource, lever: float, file: str, before: int, arm: float | None
) -> Column:
    """Return the friction force, N, of a force at a lever, m.

    Raises ``ReaderError`` for a torque, and where run.toml states no arm of the friction force.
    """
    if is_unit_of(unit_of(column, told) or "1", "torque"):
        raise ReaderError(
            f"{file}, column {column.name!r}: found a torque for friction_force and a lever arm in run.toml; expected "
            "a force with a lever arm, or a torque without one; remove arm"
        )
    force = column_in_si(column, told, "friction_force", "force", file, before)
    return force * (lever / _known(arm, column, "force at a lever arm", file))


def _known(arm: float | None, column: ReadColumn, what: str, file: str) -> float:
    if arm is None:
        raise ReaderError(
            f"{file}, column {column.name!r}: found a {what} for friction_force but no track radius in run.toml; "
            'expected a track radius R, since F = T/R; add conditions.track_radius, such as "6 mm"'
        )
    return arm


def notes_on(table: ReadTable, meanings: Meanings, file: str, arms: Arms = NO_ARMS) -> list[str]:
    """Return what a person should know of how a file was read and understood."""
    synonyms = [
        f"column {column.name!r} is interpreted as {name}, from its name"
        for column in table.columns
        for name, told in meanings.get(column.name, [])
        if told is None and is_synonym(column, name)
    ]
    units = [
        note
        for column in table.columns
        for _, told in meanings.get(column.name, [])
        if told is not None and (note := contradiction(column, told.unit, "run.toml"))
    ]
    weights = [
        f"{name} in {unit_of(column, told)} is converted to the weight of that mass"
        for column in table.columns
        for name, told in meanings.get(column.name, [])
        if is_a_weight(column, told, SIGNALS[name].kind)
    ]
    torques = [
        f"{name} in {unit_of(column, told)} is treated as a torque about the axis"
        if told is not None or arms.friction is not None
        else f"column {column.name!r} is a friction torque and is not used, since run.toml specifies no track radius"
        for column in table.columns
        for name, told in meanings.get(column.name, [])
        if name == "friction_force" and is_unit_of(unit_of(column, told) or "1", "torque")
    ]
    arm = show(arms.friction or 0.0, None, "m", "mm")
    forces = [
        f"{name} in {unit_of(column, told)} {AT_A_LEVER} {arm} from the axis"
        for column in table.columns
        for name, told in meanings.get(column.name, [])
        if name == "friction_force" and arms.shared and not is_unit_of(unit_of(column, told) or "1", "torque")
        if told is None or told.arm is None
    ]
    return [f"{file}: {note}" for note in (*remarks(table), *synonyms, *units, *weights, *torques, *forces)]


def spoken(names: Sequence[str]) -> str:
    """Name consecutive files."""
    return names[0] if len(names) == 1 else f"{names[0]} … {names[-1]}"
