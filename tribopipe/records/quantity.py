"""Numbers with a unit and a standard uncertainty, as people write them and as tribopipe keeps them."""

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, WithJsonSchema

from tribopipe import units
from tribopipe.errors import UnitError
from tribopipe.records.base import Record


class Quantity(Record):
    """A value in SI with its standard uncertainty (JCGM 100:2008, 2.3.1)."""

    value: float
    """In ``unit``."""
    unit: str
    """SI unit: m, s, N, Pa, m/s, m^2/N, or 1 for a ratio."""
    standard_uncertainty: float | None = None
    """In ``unit``; none where nobody stated one."""

    def __str__(self) -> str:
        return self.shown()

    def shown(self, unit: str | None = None) -> str:
        """Write the quantity for people, in ``unit`` where one is named."""
        return units.show(self.value, self.standard_uncertainty, self.unit, unit)


def wear_coefficient(value: float, standard_uncertainty: float | None = None) -> Quantity:
    """Return a wear coefficient k_D, m²/N."""
    return Quantity(value=value, unit="m^2/N", standard_uncertainty=standard_uncertainty)


class EndValue(Quantity):
    """A quantity measured on a specimen after the test."""

    method: str | None = None
    """How it was measured: "white-light", "stylus", "optical microscope"…"""


def _take(written: Any, *, kind: str) -> Any:
    """Turn "200 mN", or a table with value and standard_uncertainty, into SI numbers."""
    try:
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
    found = f"the bare number {written!r}" if is_number else repr(written)
    raise UnitError(f"found {found}; expected a text with its unit, such as {example!r}")


def _read_table(written: Mapping[str, Any], kind: str) -> dict[str, Any]:
    if "value" not in written:
        raise UnitError(
            f"found a table without 'value'; expected {{ value = "
            f"{units.KINDS[kind].example!r}, standard_uncertainty = … }}"
        )
    taken: dict[str, Any] = {**written, **_read_value(written["value"], kind)}
    spread = written.get("standard_uncertainty")
    if isinstance(spread, str):
        taken["standard_uncertainty"] = units.parse_interval(spread, kind, of=taken["value"])
    elif spread is not None and not (units.KINDS[kind].si == "1" and isinstance(spread, int | float)):
        raise UnitError(
            f"found the bare standard_uncertainty {spread!r}; expected a text such as '2 %' or "
            f"{units.KINDS[kind].example!r}"
        )
    return taken


def _of_kind(quantity: Quantity, *, kind: str, positive: bool) -> Quantity:
    si = units.KINDS[kind].si
    if quantity.unit != si:
        raise ValueError(
            f"found the unit {quantity.unit!r} beside a bare number; expected SI ({si!r}), or "
            f"a text such as {units.KINDS[kind].example!r}"
        )
    if positive and not quantity.value > 0:
        raise ValueError(f"found {quantity.shown()}; expected more than zero; check sign and value")
    if quantity.standard_uncertainty is not None and quantity.standard_uncertainty < 0:
        raise ValueError("found a negative standard_uncertainty; expected zero or more")
    return quantity


def _written_schema(kind: str, *, method: bool = False) -> dict[str, Any]:
    example = units.KINDS[kind].example
    text = {"type": "string", "pattern": r"^\s*[+-]?(\d|\.\d)", "examples": [example]}
    value: list[dict[str, Any]] = [text]
    if units.KINDS[kind].si == "1":
        value.append({"type": "number"})
    table: dict[str, Any] = {
        "value": {"anyOf": value},
        "unit": {"type": "string", "description": "Only beside a bare number in SI."},
        "standard_uncertainty": {
            "anyOf": [text, {"type": "number"}, {"type": "null"}],
            "description": "Of the same unit, or a share of the value such as '1 %'.",
        },
    }
    if method:
        table["method"] = {"type": ["string", "null"]}
    bare = {
        "type": "object",
        "properties": table | {"value": {"type": "number"}},
        "required": ["value", "unit"],
        "additionalProperties": False,
    }
    written = {
        "type": "object",
        "properties": {name: rule for name, rule in table.items() if name != "unit"},
        "required": ["value"],
        "additionalProperties": False,
    }
    return {"anyOf": [*value, written, bare], "examples": [example]}


def _rules(kind: str, *, positive: bool = True, method: bool = False) -> tuple[Any, ...]:
    return (
        BeforeValidator(partial(_take, kind=kind)),
        AfterValidator(partial(_of_kind, kind=kind, positive=positive)),
        WithJsonSchema(_written_schema(kind, method=method)),
    )


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
Frequency = Annotated[Quantity, *_rules("frequency")]
Temperature = Annotated[Quantity, *_rules("temperature")]
Ratio = Annotated[Quantity, *_rules("ratio", positive=False)]
Percentage = Annotated[Quantity, *_rules("percentage")]
Slip = Annotated[Quantity, *_rules("percentage", positive=False)]
DriftRate = Annotated[Quantity, *_rules("drift rate", positive=False)]
WearCoefficient = Annotated[Quantity, *_rules("wear coefficient")]
MeasuredLength = Annotated[EndValue, *_rules("length", method=True)]
MeasuredDepth = Annotated[EndValue, *_rules("length", positive=False, method=True)]
MeasuredVolume = Annotated[EndValue, *_rules("volume", positive=False, method=True)]
MeasuredMass = Annotated[EndValue, *_rules("mass", positive=False, method=True)]
