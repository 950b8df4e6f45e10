"""The only place where units are converted: text and vendor units to SI, SI to what people read.

Inside tribopipe every number is SI: m, s, N, Pa, m/s, K, and m²/N for the dimensional wear
coefficient k_D (1 mm³/(N mm) = 1 mm²/N = 1e-6 m²/N). Ratios such as the friction coefficient have unit "1".
"""

import math
import re
from collections.abc import Callable
from decimal import Context, Decimal
from functools import cache
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.errors import UnitError
from tribopipe.base.ordinary_units import OFFSETS, ORDINARY

Numbers = TypeVar("Numbers", float, NDArray[np.float64])


class Kind(NamedTuple):
    """What a number measures: its SI unit, the unit people read it in, an example to show them."""

    si: str
    shown: str
    example: str


KINDS: dict[str, Kind] = {
    "length": Kind("m", "um", "0.794 mm"),
    "distance": Kind("m", "m", "500 m"),
    "speed": Kind("m/s", "mm/s", "400 mm/s"),
    "time": Kind("s", "s", "1250 s"),
    "force": Kind("N", "mN", "200 mN"),
    "torque": Kind("N*m", "mN*m", "50 mN*m"),
    "pressure": Kind("Pa", "GPa", "304 GPa"),
    "density": Kind("kg/m^3", "g/cm^3", "3.21 g/cm^3"),
    "toughness": Kind("Pa*m^0.5", "MPa*m^0.5", "7 MPa*m^0.5"),
    "temperature": Kind("K", "degC", "23 degC"),
    "ratio": Kind("1", "1", "0.24"),
    "percentage": Kind("1", "%", "45 %"),
    "count": Kind("1", "1", "1e6"),
    "area": Kind("m^2", "um^2", "480 um^2"),
    "volume": Kind("m^3", "mm^3", "2.7e-3 mm^3"),
    "mass": Kind("kg", "mg", "1.2 mg"),
    "frequency": Kind("1/s", "Hz", "10 Hz"),
    "rotational speed": Kind("rad/s", "rpm", "328 rpm"),
    "drift rate": Kind("m/s", "nm/min", "12 nm/min"),
    "wear coefficient": Kind("m^2/N", "mm^3/(N*mm)", "13.5e-9 mm^3/(N*mm)"),
}

WEAR_COEFFICIENT = KINDS["wear coefficient"].shown
"""Unit in which people read k_D."""
SPECIFIC_WEAR_RATE = "mm^3/(N*m)"
"""Unit in which people read a specific wear rate, and in which other labs may state k_D."""

_NUMBER_THEN_UNIT = re.compile(
    r"\s*(?P<number>[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>.*)\Z", re.DOTALL
)
_DECIMAL_COMMA = re.compile(r"(?P<whole>\s*[+-]?\d+),(?P<decimals>\d+)(?![\d.,])", re.ASCII)
_AFTER_THOUSANDS = re.compile(r"\s*[+-]?\d{1,3}(?:\.\d{3})+,\d+(?![\d.,])", re.ASCII)
"""Number with a decimal comma after points between thousands."""
_MAYBE_THOUSANDS = re.compile(
    r"\s*(?P<number>[+-]?0*[1-9]\d*(?P<sign>[.,])\d{3}(?:(?P=sign)\d{3})*)(?![\d.,]|[eE][+-]?\d)", re.ASCII
)
_LONGEST_UNIT = 40
_SPELLINGS = str.maketrans(
    {
        "·": "*",
        "⋅": "*",
        "×": "*",
        "−": "-",
        "µ": "u",
        "μ": "u",
        "℃": "degC",
        "°": "deg",
        "º": "deg",
        "˚": "deg",
        "½": "^0.5",
    }
)
_LAB_SPELLINGS = {
    **dict.fromkeys(("deg c", "deg. c", "°c", "ºc", "grad c"), "degC"),
    **dict.fromkeys(("deg f", "deg. f"), "degF"),
    **dict.fromkeys(("rpm", "u/min", "rev/min", "r/min", "tr/min", "obr/min", "obr./min", "giri/min", "转/分"), "rpm"),
    **dict.fromkeys(("rev/s", "rev/sec", "r/s"), "rps"),
    **dict.fromkeys(("fpm", "sfpm"), "ft/min"),
    **dict.fromkeys(("%rh", "% rh", "% r.h.", "%rf", "% rf", "% r.f.", "%r.f."), "%"),
    **dict.fromkeys(("sek", "sek.", "sec", "sec.", "seg", "seg.", "秒"), "s"),
    **dict.fromkeys(("sekunde", "sekunden", "secondes", "segundos", "secondi", "초"), "s"),
    **dict.fromkeys(("minuten", "minutos", "minuti"), "min"),
    **dict.fromkeys(("stunden", "heures", "horas", "ore", "hrs", "小时"), "h"),
    "kg": "kg",
    **dict.fromkeys(("gm", "gms", "grams"), "g"),
    **dict.fromkeys(("newton", "newtons", "牛", "牛顿"), "N"),
    **dict.fromkeys(("meter", "metre", "meters", "metres"), "m"),
    "min": "min",
    "min.": "min",
    "分": "min",
    "hz": "Hz",
    **dict.fromkeys(("micron", "microns", "micra", "micras", "micromètres", "micrómetros"), "um"),
    # Capitals, and what is left of µ where a program lost it or took its bytes for letters of their own.
    **dict.fromkeys(("um", "?m", "\ufffdm", "â\u03bcm", "î¼m"), "um"),
    **dict.fromkeys(("mil", "mils"), "thou"),
    **dict.fromkeys(("kp", "kilopond"), "kgf"),
    # Torques, in which a pound is a force: ft-lb, lbf·in, in*lbs …
    **{
        f"{one}{sign}{other}": f"{arm}*{force}"
        for arm in ("ft", "in")
        for name, force in (("lb", "lbf"), ("lbs", "lbf"), ("lbf", "lbf"), ("oz", "ozf"), ("ozf", "ozf"))
        for one, other in ((arm, name), (name, arm))
        for sign in "-*·. "
    },
}
"""As labs write units, in small letters; most are none, or another one, by the rules: "Min" would be millions of
inches, "Deg C" degrees times coulomb, "U/min" atomic mass units."""
_TORQUES = {
    "Nm": "N*m",
    "mNm": "mN*m",
    "kNm": "kN*m",
    "Nmm": "N*mm",
    "Ncm": "N*cm",
    "N m": "N*m",
    "N mm": "N*mm",
    "cNm": "cN*m",
    "uNm": "uN*m",
    "µNm": "uN*m",
    "μNm": "uN*m",
    **{f"{force}-{arm}": f"{force}*{arm}" for force in ("N", "mN", "kgf", "gf") for arm in ("m", "cm", "mm")},
}
"""Torques as labs write them; capitals count, or "Nm" would be a nanometer."""
_SUPERSCRIPTS = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
_FROM_SUPERSCRIPT = str.maketrans(_SUPERSCRIPTS, "-0123456789")
_TO_SUPERSCRIPT = str.maketrans("-0123456789", _SUPERSCRIPTS)
_POWER = r"(?:\^|\*\*)\s*(?:[+-]?\d{1,2}(?:\.\d)?|\([+-]?\d{1,2}(?:/\d{1,2})?\))(?![\d.])"
_UNIT = re.compile(rf"(?:(?:[^\W\d_]\w*+|\))(?:\s*{_POWER})?|1(?=\s*/)|[%*/.(\s])+")
"""Names, small powers and the signs between them: pint would go on to compute 9^9^9, and skip what it does not know."""
_ANGLE = re.compile("rad|deg|°|rpm|rps|rev|turn|cycle")
"""In units of angle. Any other rotational speed, such as 1/min or Hz, is given in revolutions; of a frequency or a
count with such a unit, a revolution is one."""
_GRAMS_OR_GRAINS = re.compile(r"(?<!\w)[kmu]?gr(?!\w)")
"""Grams as many labs write them, which by the rules are grains, of 64.8 mg."""
_WIDTH_IN_SPREADS = 2 * 1.959963985
"""Width of the 95 % interval of a normal distribution in standard uncertainties."""
_MOST_DECIMALS = 7
"""Decimals from which each end of an interval has a power of ten of its own."""
_EXACT = Context(prec=40, traps=[])
"""Decimal arithmetic in which a number too large becomes infinite rather than an exception."""


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True, cache_folder=None, non_int_type=Decimal)


class _Unit(NamedTuple):
    """A unit against the SI unit of its dimension: SI = slope × value + offset, to the last digit."""

    dimension: str
    """Powers of the base dimensions, in their order."""
    slope: Decimal
    offset: Decimal


def _as_by_the_rules(text: str) -> str:
    """Return a unit that labs write in their own way as the rules have it."""
    plain = " ".join(text.split())
    return _TORQUES.get(plain) or _LAB_SPELLINGS.get(plain.casefold(), text)


def _cleaned(text: str) -> str:
    """Return a unit as pint reads it."""
    cleaned = re.sub(r"\.(?!\d)", "*", _as_by_the_rules(text).translate(_SPELLINGS).strip())
    cleaned = re.sub(r"/\s*N[\s*]*(m{1,2})\b", r"/(N*\1)", cleaned)
    cleaned = re.sub(r"\b([cu]?m{1,2})([23])\b", r"\1^\2", cleaned)
    return re.sub(f"[{_SUPERSCRIPTS}]+", lambda power: "^" + power[0].translate(_FROM_SUPERSCRIPT), cleaned)


@cache
def _unit(text: str) -> _Unit:
    """Read a unit; ``ValueError`` where the text is none."""
    cleaned = _cleaned(text)
    if cleaned in ("", "1", "-"):
        return _Unit("", Decimal(1), Decimal(0))
    if cleaned in ORDINARY:
        dimension, slope = ORDINARY[cleaned]
        return _Unit(dimension, Decimal(slope), Decimal(OFFSETS.get(cleaned, 0)))
    if _GRAMS_OR_GRAINS.search(cleaned):
        raise ValueError("may be grams or grains")
    if len(cleaned) > _LONGEST_UNIT or not _UNIT.fullmatch(cleaned):
        raise ValueError("too long for a unit, or contains characters that do not occur in units")
    return _by_pint(cleaned)


def _by_pint(cleaned: str) -> _Unit:
    registry = _registry()
    try:
        unit = registry.parse_units(cleaned)
        zero, one = (registry.Quantity(Decimal(number), unit).to_base_units() for number in (0, 1))
    except Exception as error:
        raise ValueError(str(error)) from error
    if zero.magnitude and unit.dimensionality != registry.kelvin.dimensionality:
        raise ValueError("a logarithm")  # only a temperature is slope × value + offset with an offset
    dimension = " ".join(f"{name}^{float(power):g}" for name, power in sorted(unit.dimensionality.items()))
    return _Unit(dimension, one.magnitude - zero.magnitude, zero.magnitude)


def is_unit(text: str) -> bool:
    """Return whether the text can be read as a unit."""
    try:
        _unit(text)
    except ValueError:
        return False
    return True


def is_unit_of(text: str, kind: str) -> bool:
    """Return whether the text is a unit of a kind of number."""
    return is_unit(text) and _unit(text).dimension == _unit(KINDS[kind].si).dimension


def is_same_unit(one: str, other: str) -> bool:
    """Return whether two units are the same one in other words; "C" and "F" may be degrees as well."""
    return _unit(one) == _unit(other) or any(text in ("C", "F") for text in (one, other))


def is_rotational(text: str) -> bool:
    """Return whether the text is a unit of rotational speed alone; Hz and 1/s may as well be those of a frequency."""
    return is_unit_of(text, "rotational speed") and text.casefold() not in ("hz", "khz", "1/s", "s^-1")


def _checked_unit(text: str, kind: str) -> _Unit:
    wanted = KINDS[kind]
    try:
        unit = _unit(text)
    except ValueError:
        raise UnitError(
            f"found {text!r}, which is not a unit; expected a {kind} unit such as {wanted.shown!r}"
        ) from None
    if unit.dimension != _unit(wanted.si).dimension:
        found = f"the unit {text!r}, which is not a unit of {kind}" if text.strip() else "no unit"
        weight = f", or {text + 'f'!r} for a dead weight" if kind == "force" and text in ("g", "kg", "lb") else ""
        raise UnitError(f"found {found}; expected a {kind} unit such as {wanted.shown!r}{weight}")
    in_angles = bool(_ANGLE.search(_as_by_the_rules(text)))
    if kind == "rotational speed" and not in_angles:
        return unit._replace(slope=unit.slope * Decimal(math.tau))
    counted = kind in ("frequency", "count") and in_angles
    return unit._replace(slope=unit.slope / Decimal(math.tau)) if counted else unit


def parse(text: str, kind: str) -> float:
    """Read "200 mN" as SI.

    Raises ``UnitError`` where the text is no number with a unit of that kind, or not finite in SI.
    """
    wanted = KINDS[kind]
    matched = _NUMBER_THEN_UNIT.match(text.rstrip())
    if matched is None or matched["unit"].startswith((",", ".")):
        hint = "; write a decimal point" if re.search(r"\d,\d", text) else ""
        raise UnitError(
            f"found {text!r}, which is not a number with a unit; expected a {kind} such as {wanted.example!r}{hint}"
        )
    if not matched["unit"] and wanted.si != "1":
        raise UnitError(f"found {text!r} without a unit; expected a {kind} such as {wanted.example!r}")
    unit = _checked_unit(matched["unit"], kind)
    # In decimal, so that "120 nm" is 1.2e-7 to the last digit.
    number = _EXACT.create_decimal(matched["number"])
    value = float(_EXACT.fma(number, unit.slope, unit.offset))
    if not math.isfinite(value):
        raise UnitError(
            f"found {text!r}, which is not finite in {wanted.si}; expected a {kind} such as {wanted.example!r}"
        )
    return value


def with_point(text: str, *, commas: bool = False) -> str:
    """Write the decimal comma of a number that a person typed as a point: "0,1 m/s" is "0.1 m/s".

    Raises ``UnitError`` where the comma may as well stand between thousands, as in "1,000 N", or the point among other
    numbers with decimal ``commas``.
    """
    doubtful = _MAYBE_THOUSANDS.match(text)
    if doubtful and (commas or doubtful["sign"] == ","):
        sign = "comma" if doubtful["sign"] == "," else "point"
        raise UnitError(
            f"found {text!r}, where the {sign} may be a decimal or a thousands separator; expected no thousands "
            f"separators, or other than three decimals; write {doubtful['number'].replace(doubtful['sign'], '')}, or "
            "append a zero as a further decimal"
        )
    found = _DECIMAL_COMMA.match(text)
    return text if found is None else f"{found['whole']}.{found['decimals']}{text[found.end() :]}"


def is_maybe_thousands(text: str) -> bool:
    """Return whether a text begins with a number whose comma or point may stand between thousands: "1.000"."""
    return _MAYBE_THOUSANDS.match(text) is not None


def has_decimal_comma(text: str) -> bool:
    """Return whether a text is a number, with or without a unit, whose comma can only be a decimal one."""
    found = _AFTER_THOUSANDS.match(text) or _DECIMAL_COMMA.match(text)
    return found is not None and not _MAYBE_THOUSANDS.match(text) and is_unit(text[found.end() :])


def parse_interval(text: str, kind: str, *, of: float) -> float:
    """Read a standard uncertainty as SI: "2 um", or "1 %" of the value ``of`` it belongs to.

    Of a percentage, such as slip, "1 %" is one percentage point. A difference, so offsets (°C) do not count.
    """
    matched = _NUMBER_THEN_UNIT.match(text.rstrip())
    if matched is not None and matched["unit"] == "%" and kind != "percentage":
        return abs(of) * float(matched["number"]) / 100
    if kind == "temperature" and matched is not None and matched["unit"]:
        return float(matched["number"]) * float(_checked_unit(matched["unit"], kind).slope)
    return parse(text, kind)


def to_si(values: Numbers, unit: str, kind: str) -> Numbers:
    """Convert a number or a whole column from ``unit`` to the SI unit of its kind.

    Raises ``UnitError`` where ``unit`` is none of that kind.
    """
    source = _checked_unit(unit, kind)
    return values * float(source.slope) + float(source.offset)


def from_si(values: Numbers, si_unit: str, unit: str) -> Numbers:
    """Convert a number or a column from SI to the unit it is shown in."""
    if si_unit == unit:
        return values
    shown = _unit(unit)
    return (values - float(shown.offset)) * float(1 / shown.slope)


def interval_from_si(value: float, si_unit: str, unit: str) -> float:
    """Convert a difference or an uncertainty: as ``from_si``, but offsets (°C) do not count."""
    return value if si_unit == unit else value * float(1 / _unit(unit).slope)


def converted(value: float, uncertainty: float | None, si_unit: str, unit: str) -> tuple[float, float | None]:
    """Convert a value in SI with its standard uncertainty to a unit that somebody names.

    Raises ``UnitError`` where that is no unit of the same kind.
    """
    source, target = _unit(si_unit), _unit_like(unit, si_unit)
    if target.dimension != source.dimension:
        raise UnitError(
            f"found the unit {unit!r} for a value in {si_unit}; expected a unit of the same dimension as {si_unit!r}"
        )
    shown = float((_EXACT.create_decimal_from_float(value) - target.offset) / target.slope)
    return shown, None if uncertainty is None else uncertainty * float(1 / target.slope)


def _unit_like(unit: str, si_unit: str) -> _Unit:
    """Read a unit for values in an SI unit; angles per time are counted as those of rotational speed are."""
    kind = next((kind for kind, known in KINDS.items() if known.si == si_unit), None)
    if kind is not None:
        return _checked_unit(unit, kind)
    try:
        return _unit(unit)
    except ValueError:
        raise UnitError(
            f"found {unit!r}, which is not a unit; expected a unit of the same dimension as {si_unit!r}"
        ) from None


def uncertain(value: float, uncertainty: float | None, si_unit: str) -> Any:
    """Return a value that computes with its unit and standard uncertainty: pint's, holding one of ``uncertainties``.

    Of one value each call returns another variable: keep what is returned where a value occurs twice.
    """
    from pint import application_registry

    if not uncertainty:
        return application_registry.Quantity(value, si_unit)
    from uncertainties import ufloat

    return application_registry.Quantity(ufloat(value, uncertainty), si_unit)


def computed(operation: Callable[[Any, Any], Any], left: Any, right: Any) -> Any:
    """Add, multiply … what ``uncertain`` returned, or a number. Raises ``UnitError`` where the units forbid it."""
    from pint import DimensionalityError, OffsetUnitCalculusError

    try:
        return operation(left, right)
    except (DimensionalityError, OffsetUnitCalculusError) as error:
        raise UnitError(f"found incompatible units: {error}; expected quantities of the same dimension") from None


def uncertain_in(quantity: Any, unit: str) -> Any:
    """Convert what ``uncertain`` or ``computed`` returned. Raises ``UnitError`` where the unit is of another kind."""
    from pint import DimensionalityError

    _unit_like(unit, parts(quantity)[2])
    try:
        return quantity.to(_cleaned(unit)) * _per_cycle(quantity, unit)
    except DimensionalityError:
        raise UnitError(
            f"found the unit {unit!r} for a value in {parts(quantity)[2]}; expected a unit of the same dimension"
        ) from None


def _per_cycle(quantity: Any, unit: str) -> float:
    """Return the factor between radians, by which pint counts everything per time, and cycles: 1/2π from rad/s to Hz.

    Raises ``UnitError`` for an angle per time from 1/s, which is that of a speed over a radius or of a frequency.
    """
    held = parts(quantity)[2]
    from_angle, to_angle = (bool(_ANGLE.search(_as_by_the_rules(text))) for text in (held, unit))
    if from_angle == to_angle or not quantity.check("1/[time]"):
        return 1.0
    if from_angle:
        return 1 / math.tau
    if "Hz" in held:
        return math.tau
    raise UnitError(
        f"found the unit {unit!r} for a value in {held}, which may count radians or cycles; expected a unit without an "
        "angle; convert cycles to 'Hz' first, or write radians as a Quantity in 'rad/s'"
    )


def parts(quantity: Any) -> tuple[float, float, str]:
    """Return value, standard uncertainty and unit of what ``uncertain`` or ``computed`` returned."""
    unit = f"{quantity.units:~C}".replace("**", "^").replace("µ", "u")
    magnitude = quantity.magnitude
    return float(getattr(magnitude, "nominal_value", magnitude)), float(getattr(magnitude, "std_dev", 0.0)), unit or "1"


_PRETTY = {
    "um": "µm",
    "um^2": "µm²",
    "um/m": "µm/m",
    "degC": "°C",
    "1": "",
    "mm^3/(N*mm)": "mm³/(N·mm)",
    "mm^3/(N*m)": "mm³/(N·m)",
    "m^2/N": "m²/N",
    "mm^3": "mm³",
    "g/cm^3": "g/cm³",
    "kg/m^3": "kg/m³",
    "MPa*m^0.5": "MPa·m½",
}


def pretty(unit: str) -> str:
    """Write a unit as people read it: "um" as "µm"."""
    return _PRETTY.get(unit, unit)


def axis(label: str, unit: str) -> str:
    """Label a plot's axis: "wear depth / µm"."""
    return f"{label} / {pretty(unit)}" if pretty(unit) else label


def show(value: float, uncertainty: float | None, si_unit: str, unit: str | None = None) -> str:
    """Write a value for people, rounded to two digits of its standard uncertainty (GUM 7.2.6).

    "23.37 ± 0.25 µm"; four significant digits where there is no uncertainty.
    """
    unit = unit or si_unit
    number = float(from_si(value, si_unit, unit))
    tail = f" {pretty(unit)}" if pretty(unit) else ""
    if uncertainty is None or not uncertainty > 1e-12 * abs(value):
        return f"{_rounded(number)}{tail}"
    spread = interval_from_si(uncertainty, si_unit, unit)
    return f"{_rounded_pair(number, spread)}{tail}"


def show_interval(low: float, high: float, si_unit: str, unit: str | None = None) -> str:
    """Write an interval for people: one power of ten and unit, and as many decimals for both ends.

    "23.03 to 24.01 µm", "(1.312 to 1.408)×10⁻⁸ mm³/(N·mm)": decimals as for the standard uncertainty of a normal
    distribution whose 95 % interval is as wide, and enough that an end above 0 is not rounded to 0.
    """
    unit = unit or si_unit
    ends = (float(from_si(low, si_unit, unit)), float(from_si(high, si_unit, unit)))
    tail = f" {pretty(unit)}" if pretty(unit) else ""
    return f"{_rounded_ends(*ends)}{tail}"


def signed(number: float, digits: int) -> str:
    """Write a number with its sign, "+0.13"; what rounds to nothing has none but the plus."""
    return f"{round(number, digits) + 0.0:+.{digits}f}"


def force_unit(newtons: float) -> str:
    """Name the unit in which people read a force: mN below 1 N."""
    return "mN" if abs(newtons) < 1 else "N"


def show_force(newtons: float, uncertainty: float | None = None) -> str:
    """Write a load for people."""
    return show(newtons, uncertainty, "N", force_unit(newtons))


def _rounded(number: float) -> str:
    mantissa, _, power = f"{number:.4g}".partition("e")
    if power and not _power_for(abs(float(f"{number:.4g}"))):
        return f"{float(f'{number:.4g}'):.0f}"
    return f"{mantissa}{_power(int(power))}" if power else mantissa


def _power(exponent: int) -> str:
    return f"×10{superscript(exponent)}"


def superscript(exponent: int) -> str:
    """Write the exponent of a power: ⁻⁸."""
    return str(exponent).translate(_TO_SUPERSCRIPT)


def _rounded_pair(number: float, spread: float) -> str:
    power = _power_for(max(abs(number), spread))
    scaled, scaled_spread = number / 10.0**power, spread / 10.0**power
    place, digits = _last_digit(scaled_spread), _decimals(scaled_spread)
    scaled = round(scaled, place) + 0.0  # no sign is left on nothing
    scaled_spread = round(scaled_spread, place)
    if not power:
        return f"{scaled:.{digits}f} ± {scaled_spread:.{digits}f}"
    return f"({scaled:.{digits}f} ± {scaled_spread:.{digits}f}){_power(power)}"


def _rounded_ends(low: float, high: float) -> str:
    spread = (high - low) / _WIDTH_IN_SPREADS
    if not 1e-12 * max(abs(low), abs(high)) < spread < math.inf:
        return f"{_rounded(low)} to {_rounded(high)}"
    largest = max(abs(low + high), high - low) / 2
    # A narrow interval around a small number needs a power of ten that the number alone would not.
    for power in (_power_for(largest), math.floor(math.log10(largest))):
        ends = low / 10.0**power, high / 10.0**power
        digits = max(_decimals(spread / 10.0**power), -math.floor(math.log10(ends[0])) if low > 0 else 0)
        if digits <= _MOST_DECIMALS:
            first, last = (f"{round(end, digits) + 0.0:.{digits}f}" for end in ends)
            return f"({first} to {last}){_power(power)}" if power else f"{first} to {last}"
    return f"{_rounded(low)} to {_rounded(high)}"


def _power_for(largest: float) -> int:
    exponent = math.floor(math.log10(largest))
    return 0 if -3 <= exponent < 5 else exponent


def _decimals(spread: float) -> int:
    """Return the decimals that show two digits of a standard uncertainty."""
    return max(0, _last_digit(spread))


def _last_digit(spread: float) -> int:
    """Return the place of the second digit of a standard uncertainty, after the decimal point; tens are −1."""
    return 1 - int(f"{spread:.1e}".partition("e")[2])
