"""Meanings of columns from their names, as used by labs and instruments in several languages.

Where several columns define the friction coefficient, as an effective value, an integral or a peak, none is taken by
itself. Units that a header leaves open are proposed by the identities between its columns: an identity such as m·g =
F_N holds for masses in g and forces in N, not for masses in kg. It fixes ratios of units alone; of those that hold,
the most usual ones are proposed.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from typing import Literal, NamedTuple

import numpy as np

from tribopipe.base.units import is_rotational, is_unit_of, to_si
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.physics.identities import Identity, Role, ratios
from tribopipe.readers.number_fields import is_mostly_numbers
from tribopipe.readers.reader import ReadColumn
from tribopipe.readers.tables import bare_name

# As plain_name writes names: small letters and digits alone, accents taken off.
_SYNONYMS: dict[SignalName, str] = {
    "time": (
        "testtime elapsedtime elapsed runtime clock clocktime timeofday timestamp datetime uhrzeit zeitstempel "
        "t zeit messzeit testzeit versuchszeit czas tiempo temps tempo tid aika "
        "cas tempsessai tiempoensayo czastarcia 时间 時間 试验时间 試験時間 経過時間 "
        "시간 경과시간 시험시간"
    ),
    "rotations": (
        "revolutions numberofrevolutions umdrehungen anzahlumdrehungen obroty liczbaobrotow vueltas giri "
        "laps numberoflaps runden anzahlrunden tours nombretours numerovueltas 圈数 周数 総回転数 累積回転数 "
        "voltas numerovoltas 누적회전수"
    ),
    "sliding_distance": (
        "distance totaldistance slidedistance distanz weg gleitweg reibweg droga drogatarcia dystans "
        "distancia distanciatotal distanciadeslizamiento distancetotale distanceglissement distancefrottement distanza "
        "slidingdist s 距离 滑动距离 滑行距离 距離 すべり距離 摺動距離 "
        "distanciapercorrida 거리 미끄럼거리 마찰거리 이동거리"
    ),
    "sliding_speed": (
        "speed velocity slidingvelocity linearspeed linearvelocity geschwindigkeit gleitgeschwindigkeit "
        "predkosc predkoscposlizgu velocidad velocidadlineal vitesse vitesseglissement velocita "
        "gleitgeschw vitesselineaire 速度 滑动速度 线速度 すべり速度 摺動速度 "
        "velocidade velocidadedeslizamento velocidadelinear 속도 미끄럼속도 선속도"
    ),
    "normal_force": (
        "fn fz nf load normalload appliedload normalkraft last normallast belastung kraftnormal silanormalna "
        "nacisk obciazenie carga carganormal cargaaplicada fuerzanormal charge chargenormale "
        "chargeappliquee forcenormale carico forzanormale obciazenienormalne "
        "载荷 法向载荷 法向力 正压力 荷重 垂直荷重 試験荷重 "
        "forcanormal 하중 수직하중 수직력"
    ),
    "friction_force": (
        "ff ft fr friction frictionload frictionalforce tangentialforce lateralforce reibkraft reibungskraft "
        "frictiontorque reibmoment reibungsmoment momenttarcia tangentialkraft tarcie silatarcia fuerza "
        "fuerzafriccion fuerzarozamiento friccion rozamiento forcefrottement forcetangentielle forzaattrito "
        "fuerzatangencial frottement 摩擦力 "
        "forcaatrito forcatangencial atrito 마찰력"
    ),
    "friction_coefficient": (
        "mu cof coefffriction coeffoffriction coefficientoffriction coefficientfriction reibwert reibzahl "
        "reibungszahl reibungskoeffizient reibkoeffizient wspolczynniktarcia coeficientefriccion coefficientefriccion "
        "coeficienterozamiento coefficientfrottement coefficienteattrito wspolczynnik coeffrottement "
        "coeffriccion coefrozamiento coeffriction 摩擦系数 摩擦因数 摩擦係数 "
        "coeficienteatrito 마찰계수"
    ),
    "depth": (
        "weardepth penetrationdepth penetration displacement lineardisplacement wear linearwear lvdt tiefe verschleiss "
        "verschleisstiefe eindringtiefe zuzycie zuzycieliniowe profundidad profundidaddesgaste desgaste h "
        "profondeur profondeurpenetration profondeurusure usure profondita usura weartrackdepth verschleissweg "
        "verschleissbetrag linearerverschleiss wegaufnehmer usurelineaire enfoncement desgastelineal przemieszczenie "
        "磨损深度 磨损量 摩耗量 磨损位移 位移 摩耗深さ 変位 "
        "profundidade profundidadedesgaste profundidadepenetracao desgastelinear 마모깊이 마모량 변위"
    ),
    "temperature": ("temp t temperatur temperatura temperatureambiante 温度 試験温度 试验温度 온도"),
    "relative_humidity": (
        "humidity rh relhumidity humidite umidita feuchte luftfeuchte luftfeuchtigkeit relativefeuchte "
        "wilgotnosc wilgotnoscwzgledna humedad humedadrelativa humiditerelative 相对湿度 湿度 相対湿度 "
        "umidade umidaderelativa humidade humidaderelativa 습도 상대습도"
    ),
}
_AXES: dict[SignalName, str] = {"friction_force": "fx fy", "depth": "z"}
"""Axes of a machine, which count where no other column has a name of the signal."""
_TORQUES: dict[SignalName, str] = {"friction_force": "torque drehmoment couple coppia momento 扭矩 转矩 トルク"}
"""Torques that may be the drive's, which count where friction is recorded in no other way."""
_SLIDING_SPEED = re.compile(r"v(?:s|t|m|rel|lin|ist|act|actual|mean|avg|slid|slide|sliding|gleit|gliss|desliz)?")
"""Symbols of the sliding speed, plain, which mean it where the unit is that of a speed."""
_OTHER_SPEED = re.compile(
    r"v[xyz\d]|v?(?:max|min|set|soll|nom)|nominal|target|setpoint|roll|entrain|walz|adjust|stage|position"
    r"|feed|vorschub|flow|vibrat|schwing|air|wear|rate|peak"
)
"""Beginnings or parts of the names of speeds at which no bodies slide."""
_SLOWEST = 1e-5
"""Value in m/s of the smallest unit in which sliding speeds are recorded; wear rates are in smaller ones."""
_PARTICLES = re.compile(r"(?<![^\W_])(?:d(?:[aeiou]s?|el|ella)|l(?:[ae]|as|es|os)|[dl](?=['’]))(?![^\W_])")
"""Articles and prepositions of Romance languages between the words of a name: "fuerza de fricción", "durée d'essai"."""
_FIRST_OF_THE_EAST = "\u2e80"
"""First of the Chinese and Japanese characters."""
_KOREAN = ("\u1100", "\u11ff")
"""First and last of the parts of Korean syllables."""
_OF_SAMPLES = re.compile(
    r"mean|avg|average|actual|act|measured|ist|mittel|mittelwert|gemittelt|moyen|moyenne|medio|media|promedio|平均"
)
"""Words in names that do not change which signal a column is: the mean of the samples in an interval is a sample."""
_SCRIPTS = re.compile(r"[\u2e80-\U0001ffff]+|[^\W\d_\u2e80-\U0001ffff]+")
"""Words, which end where another script begins: "载荷Load"."""
_IN_BRACKETS = re.compile(r"(?P<bare>[^\[\](){}]+)[\[(](?P<unit>[^\[\](){}]+)[\])]")
NO_UNIT = "its unit is unknown"
UNKNOWN_UNIT = "is not a known unit"
By = Literal["from the format", "from its name"]


def plain(name: str) -> str:
    """Write a name in small letters and digits, without articles and scripts other than those of known names."""
    spelt = _PARTICLES.sub("", name.casefold()).translate({ord("ł"): "l", ord("µ"): "mu", ord("μ"): "mu"})
    kept = unicodedata.normalize("NFKD", spelt)
    return "".join(sign for sign in kept if sign.isalnum() and (sign.isascii() or _is_of_the_east(sign)))


def _is_of_the_east(sign: str) -> bool:
    return sign >= _FIRST_OF_THE_EAST or _KOREAN[0] <= sign <= _KOREAN[1]


_NAMED, _ON_AXES, _TURNING = (
    {signal: frozenset(map(plain, written.split())) for signal, written in names.items()}
    for names in (_SYNONYMS, _AXES, _TORQUES)
)


def names_of(signal: str | None) -> tuple[str, ...]:
    """Return the plain names that stand for a signal, its own the first; none of no signal."""
    return () if signal is None else next((signal, *sorted(_NAMED[one])) for one in _NAMED if one == signal)


class Meaning(NamedTuple):
    """Meaning of one column, and where it comes from."""

    signal: SignalName
    by: By
    doubt: str = ""
    """Reason why the column is not used unless the user confirms it."""
    synonym: bool = False
    """Whether the name is another one than the signal's own."""


def meanings_of(columns: Sequence[ReadColumn], given: frozenset[SignalName] = frozenset()) -> dict[str, Meaning]:
    """Report what columns mean, by name: by the format, else by their own names where the unit fits.

    Signals that are ``given`` by other columns are left out. No two columns are the same signal: the format's word goes
    before a signal's own name, that before a synonym, that before the words of a name such as "Normalkraft Fn", that
    before an axis such as Fx, that before a symbol such as v with its unit, and that before a unit alone. Where two
    synonyms stand for one signal both are in doubt. A column of numbers keeps its meaning although a field of it is
    none, for which it is refused later; one of words has a meaning that cannot be taken.
    """
    counted = Counter(column.name for column in columns)
    named = [column for column in columns if counted[column.name] == 1 and column.name]
    numbers = [column for column in named if is_mostly_numbers(column)]
    found: dict[str, Meaning] = {}
    for column in numbers:
        if column.signal is not None and not _taken(column.signal, found):
            doubt = NO_UNIT if column.unit is None and not _fits(None, column.signal) else ""
            found[column.name] = Meaning(column.signal, "from the format", doubt)
    for told in (_by_own_name, _by_synonym, _by_words, _by_axis, _by_symbol, _by_unit):
        left = [column for column in numbers if column.name not in found]
        _add_named([column for column in left if told(column) not in given], found, told)
    if not {"friction_force", "friction_coefficient"} & {*given, *(meaning.signal for meaning in found.values())}:
        _add_named([column for column in numbers if is_unit_of(column.unit or "1", "torque")], found, _by_torque)
    for column in named:
        meaning = _strange(column)
        if column.name not in found and meaning and meaning.signal not in given and not _taken(meaning.signal, found):
            found[column.name] = meaning
    return {name: meaning for name, meaning in found.items() if meaning.signal not in given}


def _strange(column: ReadColumn) -> Meaning | None:
    """Report which signal a column is called as although it holds words, or its unit is of another kind."""
    own = column.signal or _by_own_name(column)
    by: By = "from the format" if column.signal else "from its name"
    signal = own or _by_synonym(column)
    if signal is None:
        return _with_unknown_unit(column)
    if column.first_bad is not None and not is_mostly_numbers(column):
        line, text = column.first_bad
        return Meaning(signal, by, f"it contains text, first {text!r} in line {line}", synonym=own is None)
    if own:
        return Meaning(own, by)
    # Beside a sliding speed, many files have a rotational one, which is no doubtful sliding speed.
    if column.unit is None or is_rotational(column.unit):
        return None
    return Meaning(signal, by, f"its unit {column.unit!r} is not a unit of {SIGNALS[signal].kind}", synonym=True)


def _with_unknown_unit(column: ReadColumn) -> Meaning | None:
    """Report which signal a column is called as, if its name ends in brackets with something that is no unit."""
    written = _IN_BRACKETS.fullmatch(column.name)
    signal = None if written is None or column.unit else _signal_of(written["bare"], None)
    if written is None or signal is None:
        return None
    return Meaning(signal, "from its name", f"{written['unit']!r} {UNKNOWN_UNIT}", synonym=True)


def is_synonym(column: ReadColumn, signal: SignalName) -> bool:
    """Return whether a column that is a signal by its name is called otherwise than the signal."""
    return column.signal is None and _by_own_name(column) != signal


def _by_own_name(column: ReadColumn) -> SignalName | None:
    return _own(plain_name(column))


def _own(name: str) -> SignalName | None:
    return next((signal for signal in SIGNALS if name == signal.replace("_", "")), None)


def _by_synonym(column: ReadColumn) -> SignalName | None:
    """Return the signal for the name of a column, preferably one that fits its unit."""
    return _meant(column, _NAMED)


def _by_words(column: ReadColumn) -> SignalName | None:
    """Return the signal of a mean, "Fn mean", or of a name whose two parts mean one signal: "Normalkraft Fn"."""
    written = _SCRIPTS.findall(bare_name(column.name))
    words = [word for word in written if not _OF_SAMPLES.fullmatch(word.casefold())]
    kept = plain("".join(words))
    if len(words) < len(written) and (signal := _own(kept) or _of_name(kept, column.unit, _NAMED)):
        return signal
    for end in range(1, len(words)):
        first, second = (_signal_of("".join(part), column.unit) for part in (words[:end], words[end:]))
        if first is not None and first == second:
            return first
    return None


def _signal_of(name: str, unit: str | None) -> SignalName | None:
    """Return the signal for a name, a synonym, or the symbol of a speed."""
    short = plain(name)
    if unit is not None and is_unit_of(unit, "speed") and _SLIDING_SPEED.fullmatch(short):
        return "sliding_speed"
    return _own(short) or _of_name(short, unit, _NAMED)


def _by_axis(column: ReadColumn) -> SignalName | None:
    """Give the signal that an axis of a machine may record."""
    return _meant(column, _ON_AXES)


def _by_symbol(column: ReadColumn) -> SignalName | None:
    """Return the sliding speed for a symbol such as v or v_gleit with the unit of a speed; without it, v may be any."""
    return "sliding_speed" if _is_a_speed(column) and _SLIDING_SPEED.fullmatch(plain_name(column)) else None


def _by_unit(column: ReadColumn) -> SignalName | None:
    """Return the signal that a column may be by its unit alone, which only a speed is."""
    return "sliding_speed" if _is_a_speed(column) and not _OTHER_SPEED.search(plain_name(column)) else None


def _is_a_speed(column: ReadColumn) -> bool:
    """Return whether a unit is that of a speed at which bodies slide."""
    unit = column.unit
    return unit is not None and is_unit_of(unit, "speed") and float(to_si(1.0, unit, "speed")) > _SLOWEST


def _by_torque(column: ReadColumn) -> SignalName | None:
    """Give the signal that a torque may be."""
    return _meant(column, _TURNING)


def _meant(column: ReadColumn, named: Mapping[SignalName, frozenset[str]]) -> SignalName | None:
    return _of_name(plain_name(column), column.unit, named)


def _of_name(name: str, unit: str | None, named: Mapping[SignalName, frozenset[str]]) -> SignalName | None:
    meant = [signal for signal in SIGNALS if name in named.get(signal, ())]
    return next((signal for signal in meant if _fits(unit, signal)), meant[0] if meant else None)


_OTHER_SENSES: dict[Callable[[ReadColumn], SignalName | None], str] = {
    _by_torque: "it could also be the torque of the drive",
    _by_unit: "it could also be another speed",
}
"""Other meanings of a column that does not mean a signal by its name."""


def _add_named(
    columns: list[ReadColumn], found: dict[str, Meaning], told: Callable[[ReadColumn], SignalName | None]
) -> None:
    meant = [(column, signal) for column in columns if (signal := told(column)) and not _taken(signal, found)]
    fitting = Counter(signal for column, signal in meant if _fits(column.unit, signal))
    for column, signal in meant:
        if _fits(column.unit, signal):
            doubt = "another column could also be this signal" if fitting[signal] > 1 else _other_sense(column, signal)
            doubt = doubt or _OTHER_SENSES.get(told, "")
            found[column.name] = Meaning(signal, "from its name", doubt, synonym=told is not _by_own_name)
        elif column.unit is None:
            found[column.name] = Meaning(signal, "from its name", NO_UNIT, synonym=told is not _by_own_name)


def _other_sense(column: ReadColumn, signal: SignalName) -> str:
    """Return another meaning of a column: "Weg [um]" and "distance [mm]" can be readings of a displacement sensor."""
    distant = signal == "sliding_distance" and column.unit not in ("m", "km")
    return "it could also be a displacement" if distant and _by_own_name(column) is None else ""


def _taken(signal: SignalName, found: dict[str, Meaning]) -> bool:
    return any(meaning.signal == signal and not meaning.doubt for meaning in found.values())


def _fits(unit: str | None, signal: SignalName) -> bool:
    """Return whether a unit fits a signal; without a unit, a humidity of 45 could be 45 % or 4500 %."""
    kind = SIGNALS[signal].kind
    unit = unit_for(kind, unit)
    if kind == "percentage":
        return unit is not None and "%" in unit
    if signal == "friction_force" and is_unit_of(unit or "1", "torque"):
        return True
    return is_unit_of(unit or "1", kind) or (kind == "force" and is_unit_of(unit or "1", "mass"))


def unit_for(kind: str, unit: str | None) -> str | None:
    """Return a unit as a kind of number has it: of a temperature, "C" is no coulomb and "F" no farad."""
    return f"deg{unit}" if kind == "temperature" and unit in ("C", "F") else unit


def plain_name(column: ReadColumn) -> str:
    """Write a name without its unit in small letters and digits: "Reibkraft [N]", "fz_N", "µ", "Fₙ", "摩擦力"."""
    return plain(bare_name(column.name.removesuffix(f"_{column.unit}")))


_FRICTION_NAMES = re.compile(r"\bcof\b|friction|\bmu\b|\bµ\b|reibwert|reibzahl", re.IGNORECASE)
_FRICTION_UNITS = (None, "1", "-", "", "%", "1/µm", "1/um")
_LEAST_FRICTION, _LARGEST_FRICTION = 1e-3, 3.0
"""Limits of the median of a friction coefficient."""


def may_be_friction(column: ReadColumn) -> bool:
    """Return whether a column of numbers is named after friction, and its unit fits."""
    fits = column.unit in _FRICTION_UNITS or _fits(column.unit, "friction_force")
    return fits and column.first_bad is None and _FRICTION_NAMES.search(column.name) is not None


class Definition(NamedTuple):
    """A column that may be the friction coefficient."""

    column: str
    median: float


def friction_definitions(columns: Sequence[ReadColumn]) -> list[Definition]:
    """Return the columns that may be the friction coefficient by name, unit and size, where there are several."""
    found = []
    for column in columns:
        if column.first_bad is None and column.unit in _FRICTION_UNITS and _FRICTION_NAMES.search(column.name):
            known = column.values[np.isfinite(column.values)]
            median = float(np.median(np.abs(known))) if len(known) else 0.0
            if _LEAST_FRICTION <= median <= _LARGEST_FRICTION:
                found.append(Definition(column.name, median))
    return found if len(found) > 1 else []


def definitions_note(columns: Sequence[ReadColumn], taken: str | None) -> str | None:
    """Report which columns define friction differently, and which is taken; nothing where there is one at most."""
    found = friction_definitions(columns)
    if not found:
        return None
    names = [f"{one.column!r} (median {one.median:.3g})" for one in found]
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    chosen = f"{taken!r} is used; if you report the values of another column, map it"
    choice = "none is used; map the column whose values you report" if taken is None else chosen
    return (
        f"{len(found)} columns with different definitions of friction, {listed}; {choice} to friction_coefficient "
        "under [signals.columns]"
    )


_USUAL_UNITS: dict[Role, tuple[str, ...]] = {
    "time": ("s", "min", "h", "ms"),
    "sliding_distance": ("m", "mm", "km"),
    "sliding_speed": ("m/s", "mm/s"),
    "track_radius": ("mm", "m"),
    "rotational_speed": ("rpm", "rad/s"),
    "rotations": ("1",),
    "mass": ("g", "kg"),
    "normal_force": ("N", "mN", "kN"),
    "friction_force": ("N", "mN", "kN"),
    "friction_coefficient": ("1", "%"),
}
"""The most usual ones first."""
_ROLE_KINDS: dict[Role, str] = {
    "time": "time",
    "sliding_distance": "distance",
    "sliding_speed": "speed",
    "track_radius": "length",
    "rotational_speed": "rotational speed",
    "rotations": "count",
    "mass": "mass",
    "normal_force": "force",
    "friction_force": "force",
    "friction_coefficient": "ratio",
}
_ROLE_NAMES: dict[Role, str] = {
    "time": "time testtime elapsedtime zeit",
    "sliding_distance": "distance slidingdistance totaldistance weg gleitweg",
    "sliding_speed": "slidingvelocity slidingspeed linearvelocity linearspeed velocity gleitgeschwindigkeit speed",
    "track_radius": "radius trackradius wearradius wearscarradius spurradius reibradius",
    "rotational_speed": "rotationalspeed rpm drehzahl rotationspeed speed",
    "rotations": "revolutions totalrevolutions numberofrevolutions rotations laps umdrehungen",
    "mass": "mass deadmass masse",
    "normal_force": "load normalload normalforce fn fz normalkraft last",
    "friction_force": "frictionforce friction ff reibkraft",
    "friction_coefficient": "frictioncoefficient cof mu reibwert reibzahl",
}
NEAR = 0.2
"""Tolerance of the ratio of both sides of an identity: a radius may be rounded to a whole mm, and units that could
be confused are further apart."""
_MOST_ROWS_OF_IDENTITIES = 100_000


class OpenUnit(NamedTuple):
    """A unit that a header leaves open."""

    unit: str
    why: str
    """The identities that hold with it."""


def roles_of(columns: Sequence[ReadColumn]) -> dict[Role, ReadColumn]:
    """State by their names which quantities columns are, of two of one name the first.

    "Speed" is the sliding speed, or next to a sliding velocity the rotational one.
    """
    found: dict[Role, ReadColumn] = {}
    for role, names in _ROLE_NAMES.items():
        fitting = [one for one in columns if _may_be(one, role) and all(one is not other for other in found.values())]
        named = {plain_name(one): one for one in reversed(fitting)}
        name = next((name for name in names.split() if name in named), None)
        if name is not None:
            found[role] = named[name]
    return found


def _may_be(column: ReadColumn, role: Role) -> bool:
    """Return whether a column is one of numbers whose unit, where it has one, fits."""
    return column.first_bad is None and (column.unit is None or is_unit_of(column.unit, _ROLE_KINDS[role]))


def open_units(roles: Mapping[Role, ReadColumn]) -> dict[Role, OpenUnit]:
    """Propose units for the columns that have none, by the identities that hold with them."""
    values = {role: np.asarray(column.values[:_MOST_ROWS_OF_IDENTITIES], dtype=float) for role, column in roles.items()}
    known = list(ratios(values))
    concerned = [role for role in roles if any(role in identity.roles for identity, _ in known)]
    if not known or all(roles[role].unit for role in concerned):
        return {}
    best = max(_choices(roles, concerned), key=lambda choice: _fit(choice, known))
    holding = [identity for identity, ratio in known if _holds(identity, ratio, best)]
    return {
        role: OpenUnit(best[role], ", ".join(one.formula for one in holding if role in one.roles))
        for role in concerned
        if roles[role].unit is None and any(role in one.roles for one in holding)
    }


Choice = dict[Role, str]


def _choices(roles: Mapping[Role, ReadColumn], concerned: Sequence[Role]) -> Iterator[Choice]:
    """Give every choice of units, the most usual ones first."""
    units = [(roles[role].unit or "",) if roles[role].unit else _USUAL_UNITS[role] for role in concerned]
    for chosen in product(*units):
        yield dict(zip(concerned, chosen, strict=True))


def _fit(choice: Choice, known: Sequence[tuple[Identity, float]]) -> tuple[int, int]:
    """Rank a choice: by the identities that hold, then by how usual its units are."""
    unusual = sum(_USUAL_UNITS[role].index(unit) for role, unit in choice.items() if unit in _USUAL_UNITS[role])
    return sum(_holds(identity, ratio, choice) for identity, ratio in known), -unusual


def _holds(identity: Identity, ratio: float, choice: Choice) -> bool:
    for role in identity.left:
        ratio *= _factor(role, choice[role])
    for role in identity.right:
        ratio /= _factor(role, choice[role])
    return abs(ratio - 1) <= NEAR


def _factor(role: Role, unit: str) -> float:
    return float(to_si(1.0, unit, unit_kind(role)))


def unit_kind(role: Role) -> str:
    """Return the kind of number that a quantity is."""
    return _ROLE_KINDS[role]
