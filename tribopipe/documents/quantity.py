"""Numbers with a unit and a standard uncertainty, as people write them and as tribopipe keeps them."""

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from numbers import Real
from typing import Annotated, Any, Self

from pydantic import AfterValidator, WithJsonSchema, WrapValidator

from tribopipe.base import units
from tribopipe.base.errors import UnitError
from tribopipe.documents.record import Record

_FEWEST_READINGS = 2
_FEW_READINGS = {2: 12.706204736 / 1.959963985, 3: 4.302652730 / 1.959963985}
"""Student's t₀.₉₇₅ over that of a normal distribution, by the number of readings for which t has no variance."""
_LEAST, _MOST = 1e-40, 1e40
"""Smallest and largest magnitude, in SI units: products of seven such numbers are still finite."""
_ROUNDING = 1e-14
"""Share of a mean by which equal readings may differ in binary."""


class Arithmetic:
    """Operators of a quantity, with numbers and with each other: unit and uncertainty by pint and uncertainties."""

    __array_ufunc__ = None  # or arrays would compute element by element

    def __format__(self, spec: str) -> str:
        """Write the value by a format, with the unit and without the uncertainty; as ``str`` does without a format."""
        if not spec:
            return str(self)
        shown: Any = self
        return f"{shown.value:{spec}} {units.pretty(shown.unit)}".removesuffix(" 1")

    def __add__(self, other: Any) -> Any:
        return _computed(operator.add, self, other)

    def __radd__(self, other: Any) -> Any:
        return _computed(operator.add, other, self)

    def __sub__(self, other: Any) -> Any:
        return _computed(operator.sub, self, other)

    def __rsub__(self, other: Any) -> Any:
        return _computed(operator.sub, other, self)

    def __mul__(self, other: Any) -> Any:
        return _computed(operator.mul, self, other)

    def __rmul__(self, other: Any) -> Any:
        return _computed(operator.mul, other, self)

    def __truediv__(self, other: Any) -> Any:
        return _computed(operator.truediv, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return _computed(operator.truediv, other, self)

    def __pow__(self, other: Any) -> Any:
        return _computed(operator.pow, self, other)


class Computed(Arithmetic):
    """Result of arithmetic with quantities.

    Quantities count as independent of each other, and each as the same as itself: ``q - q`` is exactly 0. What one fit
    found is not independent; its covariance is with the fit, such as ``WearFit.correlation``.
    """

    def __init__(self, uncertain: Any) -> None:
        self.uncertain = uncertain
        """As pint has it. Pint is not what operators return: it would take a quantity for a number without a unit."""

    @property
    def value(self) -> float:
        """Value in ``unit``."""
        return units.parts(self.uncertain)[0]

    @property
    def u(self) -> float:
        """Standard uncertainty, in ``unit``; 0 where nothing that it is computed of has one."""
        return units.parts(self.uncertain)[1]

    @property
    def unit(self) -> str:
        """Such as "m^3"."""
        return units.parts(self.uncertain)[2]

    def to(self, unit: str) -> "Computed":
        """Return the same in another unit. Raises ``UnitError`` where it is none of the same kind."""
        return Computed(units.uncertain_in(self.uncertain, unit))

    def __float__(self) -> float:
        if self.unit != "1":
            raise TypeError(_bare(self.unit))
        return self.value

    def __str__(self) -> str:
        return units.show(self.value, self.u, self.unit)

    def __repr__(self) -> str:
        return f"<{self}>"


def _computed(operation: Callable[[Any, Any], Any], left: Any, right: Any) -> Any:
    if not (isinstance(left, Arithmetic | Real) and isinstance(right, Arithmetic | Real)):
        return NotImplemented
    return Computed(units.computed(operation, *(getattr(side, "uncertain", side) for side in (left, right))))


def _bare(unit: str) -> str:
    return (
        f"found a quantity in {unit} used as a plain number; expected a quantity in SI units, as functions "
        f"require; use .value for the number in {unit}"
    )


@dataclass(frozen=True)
class Converted:
    """A quantity in a unit that somebody asked for: to be shown, not to be computed with."""

    __format__ = Arithmetic.__format__

    value: float
    u: float | None
    """Standard uncertainty; None if not stated."""
    unit: str

    def __str__(self) -> str:
        return units.show(self.value, self.u, self.unit)

    def __repr__(self) -> str:
        return f"<{self}>"

    def __float__(self) -> float:
        raise TypeError(_bare(self.unit))


class Quantity(Record, Arithmetic):
    """A value in SI with its standard uncertainty (JCGM 100:2008, 2.3.1)."""

    value: float
    """Value in ``unit``."""
    unit: str
    """SI unit: m, s, N, Pa, m/s, m^2/N, or 1 for a ratio."""
    standard_uncertainty: float | None = None
    """Standard uncertainty in ``unit``; None if it was not stated."""

    def __new__(cls, *written: Any, **_: Any) -> Self:
        """Refuse what pydantic would refuse without stating how a quantity is written."""
        if written:
            raise TypeError(
                f"Quantity: found {', '.join(map(repr, written))} without keywords; expected SI units; write "
                'tribopipe.Quantity(value=0.2, unit="N", standard_uncertainty=0.002)'
            )
        return super().__new__(cls)

    def __str__(self) -> str:
        return self.shown()

    def __repr__(self) -> str:
        u = "" if self.standard_uncertainty is None else f", u = {self.standard_uncertainty!r}"
        return f"<{type(self).__name__}: {self.value!r} {self.unit}{u}>"

    def __float__(self) -> float:
        """Return the value in SI."""
        return self.value

    def shown(self, unit: str | None = None) -> str:
        """Write the quantity for people, in ``unit`` where one is named."""
        return units.show(self.value, self.standard_uncertainty, self.unit, unit)

    @property
    def u(self) -> float | None:
        """The standard uncertainty, in ``unit``; None if not stated."""
        return self.standard_uncertainty

    @property
    def u_or_zero(self) -> float:
        """The standard uncertainty, in ``unit``; 0 if not stated."""
        return self.standard_uncertainty or 0.0

    def to(self, unit: str) -> "Converted":
        """Return the quantity in another unit.

        Parameters
        ----------
        unit
            Such as ``"mm^3/(N*m)"`` or ``"um"``.

        Returns
        -------
        Converted
            With ``value``, ``u`` and ``unit``. It is no ``Quantity``, so that no function that expects SI takes it.

        Raises
        ------
        UnitError
            Where the unit is none of the same kind.
        """
        value, u = units.converted(self.value, self.standard_uncertainty, self.unit, unit)
        return Converted(value, u, unit)

    @property
    def uncertain(self) -> Any:
        """The quantity as pint and uncertainties compute with it; what operators do goes through it."""
        state = self.value, self.standard_uncertainty, self.unit
        kept = self.__dict__.get("_uncertain")  # a copy with another value has that of the original
        if kept is None or kept[0] != state:
            kept = self.__dict__["_uncertain"] = state, units.uncertain(*state)
        return kept[1]


@dataclass(frozen=True)
class Unit:
    """The SI unit that quantities of a field have, for whoever asks a record what it holds."""

    si: str


def scaled(quantity: Quantity, factor: float) -> Quantity:
    """Return a quantity times an exact factor."""
    if factor == 1.0:
        return quantity
    spread = quantity.standard_uncertainty
    changed = {"value": factor * quantity.value, "standard_uncertainty": None if spread is None else factor * spread}
    return quantity.model_copy(update=changed)


def wear_coefficient(value: float, standard_uncertainty: float | None = None) -> Quantity:
    """Return a wear coefficient k_D, m²/N."""
    return Quantity(value=value, unit="m^2/N", standard_uncertainty=standard_uncertainty)


def meters(value: float, standard_uncertainty: float | None = None) -> Quantity:
    """Return a length or distance, m."""
    return Quantity(value=value, unit="m", standard_uncertainty=standard_uncertainty)


def in_both_units(coefficient: Quantity) -> str:
    """Write a k_D that is the answer for readers of either unit: mm³/(N·mm) and mm³/(N·m)."""
    return " = ".join(coefficient.shown(unit) for unit in (units.WEAR_COEFFICIENT, units.SPECIFIC_WEAR_RATE))


def in_unit(quantity: Quantity | None, unit: str | None, unknown: str = "unknown") -> str:
    """Write a quantity for people in a unit; without a quantity, return ``unknown``."""
    return unknown if quantity is None else quantity.shown(unit)


def force(load: Quantity) -> str:
    """Write a load for people: in mN below 1 N, in N above."""
    return units.show_force(load.value, load.standard_uncertainty)


def between(ends: tuple[Quantity, Quantity], unit: str) -> str:
    """Write an interval for people, its unit once: "13.0 to 15.2 µm"."""
    low, high = ends
    return units.show_interval(low.value, high.value, low.unit, unit)


def change(before: Quantity | None, after: Quantity | None, unit: str) -> str:
    """Format a change of a value, with one unit: "13 → 15 µm"."""
    old, new = ("none" if one is None else one.shown(unit) for one in (before, after))
    return f"{old if after is None else old.removesuffix(f' {units.pretty(unit)}')} → {new}"


class EndValue(Quantity):
    """A quantity measured on a specimen after the test."""

    method: str | None = None
    """Measurement method: "white-light", "stylus", "optical microscope"…"""
    readings: tuple[float, ...] | None = None
    """Single readings, in ``unit``, of which ``value`` is the mean; None if one value was given."""


def of_readings(readings: Sequence[float], common: float | None = None) -> tuple[float, float | None]:
    """Return the mean of repeated readings and its standard uncertainty √(q²·s²/n + u²).

    s is the standard deviation of the n readings, u what is uncertain of all of them together, and q accounts for s
    being an estimate itself: from 4 readings on it is that of Student's t, q² = (n − 1)/(n − 3) (JCGM 101:2008,
    6.4.9.4). For 2 and 3 that variance does not exist; there q = t₀.₉₇₅(n − 1)/1.96, 6.48 and 2.20, which makes ±1.96
    standard uncertainties the 95 % interval of Student's t (JCGM 100:2008, G.3). Readings that are all the same show no
    scatter: then only u is left.
    """
    count = len(readings)
    mean = math.fsum(readings) / count
    squares = math.fsum((reading - mean) ** 2 for reading in readings)
    if squares <= (_ROUNDING * mean) ** 2:
        return mean, common
    widened = _FEW_READINGS[count] if count in _FEW_READINGS else math.sqrt((count - 1) / (count - 3))
    return mean, math.hypot(widened * math.sqrt(squares / (count - 1) / count), common or 0.0)


def _take(written: Any, *, kind: str, repeated: bool = False) -> Any:
    """Turn "200 mN", or a table with value and standard_uncertainty, into SI numbers."""
    try:
        if repeated and isinstance(written, Mapping) and "values" in written:
            return _read_readings(written, kind)
        return _read(written, kind)
    except UnitError as error:
        raise ValueError(str(error)) from None


def _read(written: Any, kind: str) -> Any:
    if isinstance(written, str | bool | int | float):
        return _read_value(written, kind)
    if isinstance(written, Mapping) and "unit" not in written:
        return _read_table(written, kind)
    return written


def _read_value(written: Any, kind: str) -> dict[str, Any]:
    si, example = units.KINDS[kind].si, units.KINDS[kind].example
    if isinstance(written, str):
        return {"value": units.parse(written, kind), "unit": si}
    is_number = isinstance(written, int | float) and not isinstance(written, bool)
    if is_number and si == "1":
        return {"value": written, "unit": si}
    found = f"the number {written!r} without a unit" if is_number else repr(written)
    raise UnitError(f"found {found}; expected a value with its unit, such as {example!r}")


def _read_table(written: Mapping[str, Any], kind: str) -> dict[str, Any]:
    if "value" not in written:
        raise UnitError(
            "found a table without 'value'; expected "
            f"{{ value = {units.KINDS[kind].example!r}, standard_uncertainty = … }}; add value"
        )
    taken: dict[str, Any] = {**written, **_read_value(written["value"], kind)}
    spread = written.get("standard_uncertainty")
    if isinstance(spread, str):
        taken["standard_uncertainty"] = units.parse_interval(spread, kind, of=taken["value"])
    elif spread is not None and not (units.KINDS[kind].si == "1" and isinstance(spread, int | float)):
        raise UnitError(
            f"found standard_uncertainty = {spread!r} without a unit; expected a value such as '2 %' or "
            f"{units.KINDS[kind].example!r}"
        )
    return taken


def _read_readings(written: Mapping[str, Any], kind: str) -> dict[str, Any]:
    """Turn a table with several values of one quantity into their mean; what is stated is common to all of them."""
    readings, example = written["values"], units.KINDS[kind].example
    if "value" in written or "unit" in written:
        raise UnitError("found 'values' in addition to a single value; expected only one of the two; remove the other")
    if not isinstance(readings, list | tuple) or len(readings) < _FEWEST_READINGS:
        raise UnitError(
            f"found values = {readings!r}; expected at least {_FEWEST_READINGS} readings, such as [{example!r}, …]; "
            "enter a single reading as value"
        )
    single = [_read_value(reading, kind)["value"] for reading in readings]
    rest = {name: said for name, said in written.items() if name != "values"}
    # What is stated may be a share of the mean.
    table = _read_table({**rest, "value": f"{math.fsum(single) / len(single)!r} {units.KINDS[kind].si}"}, kind)
    value, spread = of_readings(single, table.get("standard_uncertainty"))
    return table | {"value": value, "standard_uncertainty": spread, "readings": tuple(single)}


def _checked(
    written: Any, read: Callable[[Any], Quantity], *, kind: str, positive: bool, zero: bool, repeated: bool
) -> Quantity:
    """Read a quantity, and refuse one that its kind rules out; a wrong sign is shown as it is written."""
    quantity = _of_kind(read(_take(written, kind=kind, repeated=repeated)), kind=kind)
    readings = (quantity.readings if isinstance(quantity, EndValue) else None) or (quantity.value,)
    least = min(readings)
    if positive and not (least > 0 or (zero and least == 0)):
        expected = "zero or a positive value" if zero else "a positive value"
        found = _as_written(written, readings.index(least)) or units.show(
            least, None, quantity.unit, units.KINDS[kind].shown
        )
        raise ValueError(f"found {found}; expected {expected}; check sign and value")
    return quantity


def _as_written(written: Any, reading: int) -> str:
    """Return the text of a value, or of one of several readings; nothing where it is a number in SI."""
    said = written
    if isinstance(written, Mapping):
        said = written["values"][reading] if "values" in written else written.get("value")
    return repr(said) if isinstance(said, str) else ""


def _of_kind(quantity: Quantity, *, kind: str) -> Quantity:
    si = units.KINDS[kind].si
    if quantity.unit != si:
        raise ValueError(
            f"found a number with the unit {quantity.unit!r}; expected the SI unit ({si!r}), or a value such as "
            f"{units.KINDS[kind].example!r}"
        )
    readings = quantity.readings if isinstance(quantity, EndValue) and quantity.readings else ()
    for number in (quantity.value, quantity.u_or_zero, *readings):
        if number and not _LEAST < abs(number) < _MOST:
            raise ValueError(
                f"found {number:g} {si}, which is not physically possible; expected a {kind} such as "
                f"{units.KINDS[kind].example!r}; check number and unit"
            )
    if quantity.standard_uncertainty is not None and quantity.standard_uncertainty < 0:
        raise ValueError("found a negative standard_uncertainty; expected zero or a positive value; remove the sign")
    return quantity


_UNCERTAINTY = {"percentage": "In the unit of the value: '1 %' is one percentage point."}


def _written_schema(kind: str, *, method: bool = False) -> dict[str, Any]:
    example = units.KINDS[kind].example
    text = {"type": "string", "pattern": r"^\s*[+-]?(\d|\.\d)", "examples": [example]}
    value: list[dict[str, Any]] = [text]
    if units.KINDS[kind].si == "1":
        value.append({"type": "number"})
    table: dict[str, Any] = {
        "value": {"anyOf": value},
        "unit": {"type": "string", "description": "SI unit of a value that is a plain number."},
        "standard_uncertainty": {
            "anyOf": [text, {"type": "number"}, {"type": "null"}],
            "description": _UNCERTAINTY.get(kind, "In the unit of the value, or as a percentage of the value: '1 %'."),
        },
    }
    if method:
        table["method"] = {"type": ["string", "null"]}
    stated = {name: rule for name, rule in table.items() if name not in ("value", "unit")}
    forms = [
        _form({"value": table["value"]} | stated, ["value"]),
        _form(table | {"value": {"type": "number"}} | (_READINGS if method else {}), ["value", "unit"]),
    ]
    if method:
        repeated = {"type": "array", "items": text, "minItems": _FEWEST_READINGS}
        forms.append(_form({"values": repeated} | stated, ["values"]))
    return {"anyOf": [*value, *forms], "examples": [example]}


_READINGS = {"readings": {"anyOf": [{"type": "array", "items": {"type": "number"}}, {"type": "null"}]}}


def _form(properties: dict[str, Any], required: list[str]) -> dict[str, Any]:
    return {"type": "object", "properties": properties, "required": required, "additionalProperties": False}


def _rules(kind: str, *, positive: bool = True, zero: bool = False, method: bool = False) -> tuple[Any, ...]:
    return (
        Unit(units.KINDS[kind].si),
        WrapValidator(partial(_checked, kind=kind, positive=positive, zero=zero, repeated=method)),
        WithJsonSchema(_written_schema(kind, method=method)),
    )


def read_quantity(written: Any, kind: str) -> Quantity:
    """Read "80 degC", or a table with value and standard_uncertainty; ``ValueError`` where it is not of that kind."""
    return _of_kind(Quantity.model_validate(_take(written, kind=kind)), kind=kind)


Length = Annotated[Quantity, *_rules("length")]
Distance = Annotated[Quantity, *_rules("distance")]
Position = Annotated[Quantity, *_rules("distance", positive=False)]
Speed = Annotated[Quantity, *_rules("speed")]
Force = Annotated[Quantity, *_rules("force")]
Pressure = Annotated[Quantity, *_rules("pressure")]
Density = Annotated[Quantity, *_rules("density")]
Toughness = Annotated[Quantity, *_rules("toughness")]
RotationalSpeed = Annotated[Quantity, *_rules("rotational speed")]
Time = Annotated[Quantity, *_rules("time")]
Instant = Annotated[Quantity, *_rules("time", positive=False)]
Mass = Annotated[Quantity, *_rules("mass")]
Frequency = Annotated[Quantity, *_rules("frequency")]
Temperature = Annotated[Quantity, *_rules("temperature")]
Ratio = Annotated[Quantity, *_rules("ratio", positive=False)]
Percentage = Annotated[Quantity, *_rules("percentage")]
Slip = Annotated[Quantity, *_rules("percentage", positive=False)]
DriftRate = Annotated[Quantity, *_rules("drift rate", positive=False)]
WearCoefficient = Annotated[Quantity, *_rules("wear coefficient")]
MeasuredLength = Annotated[EndValue, *_rules("length", zero=True, method=True)]
MeasuredDepth = Annotated[EndValue, *_rules("length", positive=False, method=True)]
MeasuredArea = Annotated[EndValue, *_rules("area", zero=True, method=True)]
MeasuredVolume = Annotated[EndValue, *_rules("volume", positive=False, method=True)]
MeasuredMass = Annotated[EndValue, *_rules("mass", positive=False, method=True)]


def _found_in(unit: str) -> tuple[Any, ...]:
    return Unit(unit), AfterValidator(partial(_has_unit, unit=unit))


def _has_unit(quantity: Quantity, *, unit: str) -> Quantity:
    if quantity.unit != unit:
        raise ValueError(f"found the unit {quantity.unit!r}; expected {unit!r}")
    return quantity


Metres = Annotated[Quantity, *_found_in("m")]
"""Type of results, as the following types: results are always in SI units."""
Newtons = Annotated[Quantity, *_found_in("N")]
Pascals = Annotated[Quantity, *_found_in("Pa")]
CubicMetres = Annotated[Quantity, *_found_in("m^3")]
MetresPerSecond = Annotated[Quantity, *_found_in("m/s")]
Seconds = Annotated[Quantity, *_found_in("s")]
SquareMetresPerNewton = Annotated[Quantity, *_found_in("m^2/N")]
Number = Annotated[Quantity, *_found_in("1")]
