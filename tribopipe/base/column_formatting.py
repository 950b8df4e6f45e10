"""Numbers beneath each other: one power of ten for all of a column, digits by the standard uncertainty.

Nothing heavy is imported here: `tribopipe ls` needs no numpy.
"""

import math
import re
from collections.abc import Sequence
from datetime import datetime, time
from typing import NamedTuple

WITHIN_NUMBER = re.compile(
    r"(?<=\d) (?=[±µmnNs°%]|to -?\d)|(?<=\d to) (?=-?\d)|(?<=±) (?=\d)|(?<=\)) (?=mm)|(?<=[⁰¹²³⁴-⁹]) (?=mm)"
)
"""A space within an interval, or a number with its uncertainty and unit; lines are not broken there."""
Number = tuple[float, float | None]
"""A value and its standard uncertainty, both in the unit of the column; none where nobody stated one."""
_WIDE = 15
"""Characters up to which a number reads well."""
_TOO_WIDE = 17
"""From here on a power of ten of its own reads better than one for all."""
_LEAST = -3
"""Exponent of the smallest number that is written without a power of ten if it can be."""
_SIGNIFICANT = 4
"""Digits of a number without uncertainty."""
_TO_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
NOTHING = "–"


class NumberColumn(NamedTuple):
    """Numbers as they are shown beneath each other."""

    power: int
    """Power of ten that each of them has to be multiplied by."""
    cells: tuple[str, ...]

    def unit(self, unit: str) -> str:
        """Return what stands in the head of the column: the power and the unit, "10⁻⁹ mm³/(N·mm)"."""
        return " ".join(part for part in (power_of_ten(self.power), unit) if part)


def power_of_ten(power: int) -> str:
    """Write a power of ten: "10⁻⁹"; nothing for the zeroth."""
    return f"10{str(power).translate(_TO_SUPERSCRIPT)}" if power else ""


def moment(date: datetime) -> str:
    """Write a date with its time: "2024-05-14 10:12"; a date that was stated without a time is read as its midnight."""
    shown = f"{date:%Y-%m-%d %H:%M %Z}".strip()
    return f"{date:%Y-%m-%d}" if date.tzinfo is None and date.time() == time.min else shown


def number_column(numbers: Sequence[Number | None]) -> NumberColumn:
    """Write numbers for one column, with the power of ten that suits them.

    Parameters
    ----------
    numbers
        Values with standard uncertainties; none where there is no value.

    Returns
    -------
    NumberColumn
        With two digits of each standard uncertainty (JCGM 100:2008, 7.2.6), four digits of a value without one, and
        the signs ± beneath each other.
    """
    return in_power(numbers, power_for(numbers))


def in_power(numbers: Sequence[Number | None], power: int | None) -> NumberColumn:
    """Write numbers for one column with a power of ten; each with its own where none is given."""
    if power is None:
        return NumberColumn(0, tuple(NOTHING if number is None else _alone(number) for number in numbers))
    parts = [None if number is None else _parts(number, power) for number in numbers]
    values = max((len(part[0]) for part in parts if part is not None), default=0)
    return NumberColumn(power, tuple(_cell(part, values) for part in parts))


def power_for(numbers: Sequence[Number | None]) -> int | None:
    """Return the power of ten, a multiple of three, that suits all numbers: zero, or the largest that is short.

    None where some number would be too long under any.
    """
    known = [number for number in numbers if number is not None and any(number)]
    if not known:
        return 0
    exponents = [math.floor(math.log10(max(abs(value), u or 0.0))) for value, u in known]
    powers = range(3 * math.floor(max(exponents) / 3), 3 * math.floor(min(exponents) / 3) - 3, -3)
    candidates = [*([0] if min(exponents) >= _LEAST else []), *powers]
    widths = {power: max(_width(_parts(number, power)) for number in known) for power in candidates}
    best = next((power for power in candidates if widths[power] <= _WIDE), min(candidates, key=widths.__getitem__))
    return best if widths[best] < _TOO_WIDE else None


def rounded_value(number: Number) -> str:
    """Write a value alone, to the first digit of its standard uncertainty."""
    value, u = number
    if not _is_uncertain(number):
        return _plain(value)
    return _fixed(value, -_exponent(u or 0.0))


def _parts(number: Number, power: int) -> tuple[str, str]:
    value, u = number[0] / 10.0**power, None if number[1] is None else number[1] / 10.0**power
    if u is None or not _is_uncertain(number):
        return _plain(value), ""
    digits = 1 - _exponent(u)
    return _fixed(value, digits), _fixed(u, digits)


def _is_uncertain(number: Number) -> bool:
    value, u = number
    return u is not None and u > 1e-12 * abs(value)


def _exponent(u: float) -> int:
    """Return the power of ten of the first digit of an uncertainty that is rounded to two."""
    return int(f"{u:.1e}".partition("e")[2])


def _fixed(value: float, digits: int) -> str:
    """Write a number with as many digits behind the point; negative where zeros stand for them. No sign on nothing."""
    return f"{round(value, digits) + 0.0:.{max(0, digits)}f}"


def _plain(value: float) -> str:
    """Write a value without uncertainty, never with a power of ten."""
    digits = _SIGNIFICANT - 1 - (math.floor(math.log10(abs(value))) if value else 0)
    return _fixed(value, digits).rstrip("0").rstrip(".") if digits > 0 else _fixed(value, digits)


def _width(parts: tuple[str, str]) -> int:
    return len(parts[0]) + (len(parts[1]) + 3 if parts[1] else 0)


def _cell(parts: tuple[str, str] | None, width: int) -> str:
    if parts is None:
        return NOTHING
    value, u = parts
    return f"{value:>{width}} ± {u}" if u else f"{value:>{width}}"


def _alone(number: Number) -> str:
    power = math.floor(math.log10(abs(number[0]))) if number[0] else 0
    value, u = _parts(number, power)
    times = f"×{power_of_ten(power)}" if power else ""
    return f"({value} ± {u}){times}" if u and times else f"{value} ± {u}" if u else f"{value}{times}"
