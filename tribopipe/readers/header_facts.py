"""Facts about a run in free text lines above a table, in several languages: "Normalkraft;5 N", "Kugel D=6 mm".

A line is a label and a value between a tab, semicolon, bar, colon, equals sign, comma or two blanks; the unit stands
behind the number, in a field of its own, or in brackets behind the label. A line that begins with a ball is read as
its material and size. Nothing is guessed: a number without a unit, several numbers behind one label, a size that may be
a radius or a diameter and two values for one key are named in a note, and not taken.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from datetime import date, datetime
from typing import NamedTuple

from tribopipe.base.errors import UnitError
from tribopipe.base.units import has_decimal_comma, is_rotational, is_unit, is_unit_of, parse, with_point
from tribopipe.readers.column_meanings import names_of, plain
from tribopipe.readers.headed_tables import moment, moment_by
from tribopipe.readers.tables import is_unit_row, split_name

_QUANTITIES: dict[str, tuple[str, str]] = {
    "conditions.normal_load": ("force", "prufkraft testload kraft force"),
    "conditions.sliding_speed": ("speed", ""),
    "conditions.sliding_distance": ("distance", "sollweg gesamtweg distancearret stopdistance"),
    "conditions.temperature": ("temperature", "raumtemperatur roomtemperature ambienttemperature 环境温度 室温"),
    "conditions.relative_humidity": ("percentage", ""),
    "conditions.track_radius": (
        "length",
        "bahnradius spurradius reibradius laufradius trackradius weartrackradius testradius rayonpiste rayonrotation "
        "radiopista radiohuella radiogiro promientarcia raiopista raiotrilha raiodesgaste "
        "마찰반경 회전반경 轨道半径 摩擦半径 旋转半径 回転半径 摺動半径",
    ),
    "conditions.rotational_speed": (
        "rotational speed",
        "drehzahl rpm rotationalspeed rotationspeed vitesserotation velocidadrotacion velocidadgiro predkoscobrotowa "
        "rotacao velocidaderotacao 转速 回転速度 回転数 회전속도",
    ),
    "conditions.stroke": (
        "length",
        "hub hublange schwingweite schwingungsweg stroke strokelength course carrera skok curso "
        "行程 冲程 ストローク 스트로크",
    ),
    "conditions.frequency": (
        "frequency",
        "frequenz frequency frequence frecuencia czestotliwosc frequencia 频率 周波数 주파수",
    ),
    "contact.pin.diameter": (
        "length",
        "kugeldurchmesser balldiameter diametrebille diametrobola srednicakulki diametroesfera "
        "球直径 ボール直径 ボール径 볼직경",
    ),
    "contact.pin.radius": (
        "length",
        "kugelradius ballradius rayonbille radiobola promienkulki raioesfera 球半径 ボール半径 볼반경",
    ),
    "contact.block.width": ("length", "blockwidth blockbreite"),
    "contact.ring.radius": ("length", "ringradius"),
}
"""Kind of quantity and labels by key of run.toml; the names of the signal below are labels too."""
_SIGNALS = {
    "conditions.normal_load": "normal_force",
    "conditions.sliding_speed": "sliding_speed",
    "conditions.sliding_distance": "sliding_distance",
    "conditions.temperature": "temperature",
    "conditions.relative_humidity": "relative_humidity",
}
_TEXTS = {
    "title": "titel title versuch versuchsname testname testtitle titre titulo tytul 试验名称 試験名",
    "operator": "prufer bediener operator operateur operador badacz 操作员 试验员 試験者 オペレータ オペレーター",
    "instrument": "prufstand instrument tribometer tribometre tribometro gerat maschine machine 设备 装置 試験機",
    "comment": "kommentar bemerkung comment comments remark remarks commentaire comentario uwagi 备注 備考",
    "conditions.medium": (
        "umgebung medium environment atmosphere umgebungsmedium schmierstoff lubricant lubrifiant lubricante smar "
        "environnement ambiente otoczenie 环境 润滑剂 雰囲気 潤滑油"
    ),
    "contact.pin.material": (
        "kugelmaterial kugelwerkstoff ballmaterial pinmaterial stiftwerkstoff materiaubille materialbola "
        "materialkulki 球材料 ボール材質"
    ),
    "contact.disc.material": (
        "scheibe scheibenwerkstoff disc disk discmaterial diskmaterial disque materiaudisque disco "
        "materialdisco tarcza 圆盘 盘材料 ディスク "
        "ディスク材質"
    ),
    "contact.block.material": "blockmaterial blockwerkstoff",
    "contact.ring.material": "ringmaterial ringwerkstoff",
}
_DATES = "date datetime testdate startzeit teststart started startedat 日期 试验日期 日付 試験日 試験日時"
_DAYS_FIRST = "datum startdatum prufdatum fecha fechaensayo data"
"""Labels of dates in languages that write the day first, also between slashes."""
_CLOCKS = "zeit uhrzeit time starttime heure hora godzina 时间 時刻"
_HALVED = {
    "conditions.track_radius": (
        "bahndurchmesser spurdurchmesser trackdiameter weartrackdiameter diametrepiste diametropista srednicatoru"
    ),
    "contact.ring.radius": "ringdiameter ringdurchmesser",
}
"""Labels of diameters, by the key of the radius."""
_AMBIGUOUS = "radius rayon radio promien 半径"
_NOTHING = (
    "",
    "none",
    "keine",
    "keiner",
    "kein",
    "na",
    "no",
    "aucun",
    "aucune",
    "ninguno",
    "ninguna",
    "brak",
    "无",
    "なし",
)
"""Texts that state that there is nothing to state."""
_BALLS = "kugel ball bille bola kulka 球 ボール"
_UPPER = "oberkörper|gegenkörper|counterbody|upper specimen"

_LABELS = {
    plain(word): key
    for key, words in {
        **{key: f"{names} {' '.join(names_of(_SIGNALS.get(key)))}" for key, (_, names) in _QUANTITIES.items()},
        **_TEXTS,
        "date": _DATES,
        "day first": _DAYS_FIRST,
        "clock": _CLOCKS,
        **{f"half {key}": names for key, names in _HALVED.items()},
        "ambiguous": _AMBIGUOUS,
    }.items()
    for word in words.split()
}
_BALL = re.compile(
    rf"(?:(?:{_UPPER})[\s;:,=|]+)?(?:{'|'.join(_BALLS.split())})(?![^\W\d_])[\s;:,=|]*(?P<rest>.*)", re.IGNORECASE
)
_SIZE = re.compile(
    r"(?:(?:(?P<diameter>\b(?:D|dia\.?|diam[^\W\d]*|durchmesser)|[Ø⌀∅]|直径)|(?P<radius>\b(?:R|radius|rayon|radio)|半径))"
    r"[\s;:=]*|(?<![\w.,]))(?P<number>\d+(?:[.,]\d+)?)[ ;]*(?P<unit>mm|µm|μm|um|cm|in|inch)\b",
    re.IGNORECASE,
)
_NUMBER = re.compile(
    r"(?P<number>[+-]?\d++(?:[.,]\d++)?+(?:[eE][+-]?\d++)?+)(?![.,'’]\d|[\s\u00a0\u202f]\d{3})\s*+(?P<unit>.*)",
    re.ASCII | re.DOTALL,
)
"""Number without thousands separators."""
_DAY = re.compile(r"(?<!\d)(\d{1,2})\.(\d{1,2})\.(\d{4})(?:[\s,;T]+(\d{1,2}):(\d\d)(?::(\d\d))?)?(?!\d)", re.ASCII)
_ISO_DAY = re.compile(r"(?<!\d)(\d{4})[-./年](\d{1,2})[-./月](\d{1,2})日?(?!\d)", re.ASCII)
_CLOCK = re.compile(r"\d{1,2}:[0-5]\d(?::[0-5]\d)?", re.ASCII)
_BLANKS = " \t\r\n\"'"
_MARKS = f"{_BLANKS}#%!*/"
"""Characters allowed before a line; a percentage may follow it."""
_COLON_AND_MORE = re.compile(r"\s?[：:=](?=\s*[\t;|,])")
"""A colon before another separator, "Operator:,A. Tester"."""
_SEPARATORS = ("\t", ";", "|", "：", ":", "=", ",")
_CELLS = re.compile(r"[\t;|：:=]")
_LONGEST = 300
_MOST_LINES = 300
_RANGES = {"conditions.relative_humidity": (0.0, 1.0)}


def key_of(label: str) -> str | None:
    """Return the key of run.toml that a label of several languages stands for."""
    key = _LABELS.get(plain(label))
    return "started" if key in ("date", "day first") else key if key in _QUANTITIES or key in _TEXTS else None


class Fact(NamedTuple):
    """Value of one key of run.toml in one line."""

    value: str
    """Value as written in run.toml."""
    line: str


class HeaderFacts(NamedTuple):
    """Facts in free text lines by key of run.toml, and notes about facts that are not used."""

    facts: dict[str, str]
    lines: dict[str, str]
    """Line of each fact."""
    notes: tuple[str, ...] = ()


class _Label(NamedTuple):
    """A label, and the fields behind it."""

    key: str | None
    unit: str | None
    cells: Sequence[str]


def header_facts(header: str, names: Iterable[str] = (), *, commas: bool = False) -> HeaderFacts:
    """Return what the lines above a table state.

    Parameters
    ----------
    header
        The lines.
    names
        Names of the columns of the table; a line of them states nothing.
    commas
        Whether the numbers in the table have decimal commas.
    """
    columns, notes = frozenset(names), []
    lines = [line.strip() for line in header.splitlines()[:_MOST_LINES] if len(line) <= _LONGEST]
    lines = [line for line in lines if line and not _names_columns(line, columns) and not _is_row_of_units(line)]
    commas = commas or any(has_decimal_comma(cell.strip(_BLANKS)) for line in lines for cell in _CELLS.split(line))
    found: dict[str, list[Fact]] = {}
    for key, value, line in _said(lines, commas=commas):
        if value is None:
            notes.append(f"header line {line!r}: {key}")
        else:
            found.setdefault(key, []).append(Fact(value, line))
    for key, facts in found.items():
        if len(_sizes(key, facts)) > 1:
            listed = " and ".join(repr(line) for line in dict.fromkeys(fact.line for fact in facts))
            notes.append(f"the header lines {listed} give different values for {key}; none of them is used")
    once = {key: facts[0] for key, facts in found.items() if len(_sizes(key, facts)) == 1}
    return HeaderFacts(
        {key: fact.value for key, fact in once.items()}, {key: fact.line for key, fact in once.items()}, tuple(notes)
    )


def _sizes(key: str, facts: Iterable[Fact]) -> set[float | str]:
    """Return the different values of a key; 5 N and 5.0 N are the same."""
    kind = _QUANTITIES[key][0] if key in _QUANTITIES else None
    return {fact.value if kind is None else parse(fact.value, kind) for fact in facts}


def _names_columns(line: str, columns: frozenset[str]) -> bool:
    cells = [cell.strip(_BLANKS) for cell in re.split(r"[\t;|,]", _bare(line))]
    return len(cells) > 1 and 2 * sum(cell in columns for cell in cells) > len(cells)


def _is_row_of_units(line: str) -> bool:
    """Return whether all fields of a line are units, the s of seconds and not of a sliding distance among them."""
    cells = [cell.strip(_BLANKS) for cell in re.split(r"[\t;|,]|\s{2,}", _bare(line))]
    return len(cells) > 1 and is_unit_row(cells)


def _said(lines: Sequence[str], *, commas: bool) -> Iterator[tuple[str, str | None, str]]:
    """Give key, value and line of what lines state; where it is not taken, no value, and why in place of the key."""
    for line in lines:
        label = _label(line)
        if label.key is None:
            yield from ((key, value, line) for key, value in _of_a_ball(line))
        elif label.key in ("date", "day first"):
            written = " ".join(label.cells)
            written = written.replace("/", ".") if label.key == "day first" else written
            yield from ((key, value, line) for key, value in _started(written, lines))
        elif label.key.startswith("half "):
            key, value = _quantity(label.key.removeprefix("half "), label, commas=commas)
            yield key, value if value is None else _half(value), line
        elif label.key == "ambiguous":
            yield "it may be the radius of the wear track or that of the ball", None, line
        elif label.key in _QUANTITIES:
            yield *_quantity(label.key, label, commas=commas), line
        elif label.key in _TEXTS and label.cells and plain(label.cells[0]) not in _NOTHING:
            yield label.key, label.cells[0], line


def _label(line: str) -> _Label:
    """Split a line into a label that is known, its unit, and the fields behind it."""
    written = _COLON_AND_MORE.sub("", _bare(line))
    for separator in _SEPARATORS:
        cells = [cell.strip(_BLANKS) for cell in written.split(separator, 1 if separator in "：:=" else -1)]
        name, unit = split_name(cells[0].rstrip(" :：="))
        key = _LABELS.get(plain(name))
        if len(cells) > 1 and key is not None:
            return _Label(key, unit, [cell for cell in cells[1:] if cell])
    first, *others = re.split(r"\s{2,}", _bare(line), maxsplit=1)
    key = _LABELS.get(plain(first)) if others else None
    return _Label(key, None, others if key else ())


def _bare(line: str) -> str:
    return line.lstrip(_MARKS).rstrip(f"{_BLANKS};,")


def _quantity(key: str, label: _Label, *, commas: bool) -> tuple[str, str | None]:
    """Return key and value of a quantity, or why it is not taken and none."""
    kind = _QUANTITIES[key][0]
    found = _NUMBER.fullmatch(label.cells[0]) if label.cells else None
    if found is None or _more_numbers_follow(found["unit"], label.cells[1:]):
        return _why_no_number(key, label), None
    units = [found["unit"].strip(), *label.cells[1:2], label.unit or ""]
    unit = next((unit.strip("[]() ") for unit in units if unit and is_unit(unit.strip("[]() "))), None)
    if unit is None:
        return f"no unit is given with the {kind} of {key}", None
    if kind == "speed" and is_rotational(unit):
        return _quantity("conditions.rotational_speed", label, commas=commas)
    is_weight = kind == "force" and is_unit_of(unit, "mass")
    if not is_weight and not is_unit_of(unit, kind):
        return f"{unit!r} is not a unit for the {kind} of {key}", None
    try:
        written = with_point(f"{found['number']} {unit}", commas=commas)
        if is_weight:
            written = f"{parse(f'{written}*g_0', kind):.6g} N"
        value = parse(written, kind)
    except UnitError as error:
        return str(error), None
    least, most = _RANGES.get(key, (0.0, float("inf")))
    if not least < value <= most:
        return f"{written} cannot be a {kind} of {key}", None
    return key, written


def _more_numbers_follow(behind: str, cells: Sequence[str]) -> bool:
    """Return whether a line continues with another number, as in "Load [N];5;10;20" or "Load [N]: 5, 10"."""
    if re.search(r"\d", behind) and not is_unit(behind.strip("[]() ")):
        return True
    fields = (cell for cell in cells if not is_unit(cell.strip("[]() ")) or _NUMBER.fullmatch(cell))
    return _NUMBER.fullmatch(next(fields, "")) is not None


def _why_no_number(key: str, label: _Label) -> str:
    written = "".join(label.cells[:1])
    if _NUMBER.fullmatch(written):
        return f"several numbers follow the label of {key}"
    if not written.lstrip("+-")[:1].isdigit():
        return f"no number follows the label of {key}"
    return f"the number in {written!r} for {key} is not understood; write it without thousands separators"


def _half(diameter: str) -> str:
    number, unit = diameter.split(" ", 1)
    return f"{float(number) / 2:.12g} {unit}"


def _of_a_ball(line: str) -> Iterator[tuple[str, str | None]]:
    """Return the facts of a line that begins with a ball: shape, material and size."""
    matched = _BALL.match(_bare(line))
    if matched is None:
        return
    rest, size = matched["rest"], _SIZE.search(matched["rest"])
    material = (rest if size is None else rest[: size.start()] + " " + rest[size.end() :]).strip(f"{_MARKS},;:|=()")
    if re.search(r"[^\W_]", material) and len(material.split()) <= 3:
        yield "contact.pin.shape", "spherical"
        yield "contact.pin.material", material
    if size is None:
        return
    named = next((what for what in ("diameter", "radius") if size[what]), None)
    written = f"{size['number'].replace(',', '.')} {size['unit']}"  # no ball is thousands of mm large
    if named is None:
        yield f"{written} may be the radius or the diameter of the ball and is not used; put D = or R = in front", None
    else:
        yield f"contact.pin.{named}", written


def _started(written: str, lines: Sequence[str]) -> Iterator[tuple[str, str | None]]:
    """Return the date of a test, with the time of day where a line states it, in ISO 8601, or why it is not taken.

    Between points the day comes first. Of 05/12/2022, another date of the header has to show the order.
    """
    clock = _clock(written, lines)
    if day := _DAY.search(written):
        value = _iso(day[3], day[2], day[1], _clock(written[day.start() :], lines))
    elif known := moment(written):
        value = known
    elif day := _ISO_DAY.search(written):
        value = _iso(day[1], day[2], day[3], _clock("", lines))
    else:
        found, value = moment_by(f"{written} {clock or '0:00'}", lines) or ("", None)
        if found and value is None:
            yield "the date is not used, because the order of day and month is ambiguous", None
        value = value if clock or value is None else value[: len("2022-05-12")]
    if value is not None:
        yield "started", value


def _clock(written: str, lines: Sequence[str]) -> str | None:
    """Return the time of day behind a date, or in a line of its own."""
    labels = (label.cells for line in lines if (label := _label(line)).key == "clock")
    texts = [written, *(cells[0] for cells in labels if cells)]
    return next((found[0] for text in texts if (found := _CLOCK.search(text))), None)


def _iso(year: str, month: str, day: str, clock: str | None) -> str | None:
    try:
        if clock is None:
            return date(int(year), int(month), int(day)).isoformat()
        hour, minute, second, *_ = *map(int, clock.split(":")), 0
        return datetime(int(year), int(month), int(day), hour, minute, second).isoformat()  # noqa: DTZ001
    except ValueError:
        return None
