"""How a virtual run is written: run.toml, signals.csv and truth.json."""

import json
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from tribopipe.base.arrays import Column
from tribopipe.base.errors import OutputError
from tribopipe.base.files import write_file
from tribopipe.base.units import from_si, interval_from_si
from tribopipe.documents.contact import Pin, Specimen
from tribopipe.documents.manifest import MANIFEST_NAME
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record, quoted
from tribopipe.documents.twin_disc import CurvedDisc, FlatDisc

SIGNALS_NAME, TRUTH_NAME = "signals.csv", "truth.json"


class Written(NamedTuple):
    """How a column stands in signals.csv."""

    header: str
    si: str
    unit: str
    decimals: int


Layout = Mapping[str, Written]
"""The columns of signals.csv in their order."""


def require_simulated(folder: Path) -> None:
    """Raise ``OutputError`` where a run folder holds another run than a simulated one, which may be written again."""
    there = [name for name in (MANIFEST_NAME, SIGNALS_NAME) if (folder / name).exists()]
    if there and not (folder / TRUTH_NAME).is_file():
        raise OutputError(
            f"{folder}: found {there[0]}, and no {TRUTH_NAME} next to it; expected a new folder, or a simulated run; "
            "name another folder"
        )


def write_run(folder: Path, layout: Layout, columns: Mapping[str, Column], manifest: list[str], truth: Record) -> None:
    """Write a run folder from columns in SI and the lines of its manifest."""
    folder.mkdir(parents=True, exist_ok=True)
    write_file(folder / SIGNALS_NAME, _csv(layout, columns).encode("ascii"))
    write_file(folder / MANIFEST_NAME, ("\n".join(manifest) + "\n").encode("utf-8"))
    exact = truth.model_dump_json(by_alias=True, exclude_none=True)
    document = json.dumps(json.loads(exact, parse_float=_same_on_every_machine), indent=2)
    write_file(folder / TRUTH_NAME, (document + "\n").encode("ascii"))


def _same_on_every_machine(digits: str) -> float:
    """Read a number to 12 digits: processors differ in the last of 17, and the file is to be the same byte for byte."""
    return float(f"{float(digits):.12g}")


def _csv(layout: Layout, columns: Mapping[str, Column]) -> str:
    shown = [
        [f"{value:.{column.decimals}f}" for value in from_si(columns[name], column.si, column.unit).tolist()]
        for name, column in layout.items()
    ]
    head = ",".join(column.header for column in layout.values())
    return "\n".join([head, *map(",".join, zip(*shown, strict=True))]) + "\n"


def manifest_head(run_id: str, started: datetime, title: str, instrument: str) -> list[str]:
    """Return what every manifest begins with."""
    return [
        "#:schema ../../schemas/run.schema.json",
        "# Synthetic: written by `tribopipe simulate`; truth.json next to it holds the true values.",
        'schema = "tribopipe.run/1"',
        f"id = {quoted(run_id)}",
        f"started = {started.isoformat()}",
        f"title = {quoted(title)}",
        f"instrument = {quoted(instrument)}",
        "",
    ]


def manifest_tail(
    layout: Layout,
    ends: Mapping[str, Quantity],
    measured_by: Mapping[str, tuple[str, str]],
    depth_scale: Quantity,
    worded: Callable[[str], str] = str,
) -> list[str]:
    """Return the end of every manifest; ``measured_by`` gives unit in the file and method of each measurement.

    ``worded`` gives the name of a post-test measurement in run.toml.
    """
    return [
        "[[signals]]",
        f"file = {quoted(SIGNALS_NAME)}",
        "[signals.columns]",
        *(f"{name} = {{ column = {quoted(column.header)} }}" for name, column in layout.items()),
        "",
        "[end_values]",
        *(f"{worded(name)} = {written(value, *measured_by[name])}" for name, value in ends.items()),
        "",
        "[sensors]",
        f"depth_scale = {written(depth_scale, '1')}",
    ]


_SPECIMEN_UNITS = {
    "material": None,
    "youngs_modulus": "GPa",
    "poisson_ratio": "1",
    "density": "g/cm^3",
    "surface_roughness": "um",
    "vickers_hardness": None,
    "fracture_toughness": "MPa*m^0.5",
    "diameter": "mm",
}


def specimen(body: Specimen) -> list[str]:
    """Return the lines of what is known of any specimen."""
    given = {name: getattr(body, name) for name in _SPECIMEN_UNITS}
    lines = [
        f"{name} = {written(value, _SPECIMEN_UNITS[name] or '') if isinstance(value, Quantity) else json.dumps(value)}"
        for name, value in given.items()
        if value is not None
    ]
    return [*_own_sizes(body), *lines]


def _own_sizes(body: Specimen) -> list[str]:
    """Return the lines of the sizes that a kind of counterbody has with what is known of any specimen."""
    if isinstance(body, Pin | CurvedDisc | FlatDisc):
        return []  # written where the order and the units of their keys are stated
    own = [name for name in type(body).model_fields if name not in Specimen.model_fields]
    sizes = {name: size for name in own if isinstance(size := getattr(body, name), Quantity)}
    return [f"{name} = {written(size, 'mm' if size.unit == 'm' else size.unit)}" for name, size in sizes.items()]


def written(quantity: Quantity, unit: str, method: str | None = None) -> str:
    """Write a quantity as TOML, a table where it carries more than its value."""
    value = _number(from_si(quantity.value, quantity.unit, unit), unit)
    if quantity.standard_uncertainty is None and method is None:
        return value
    fields = [f"value = {value}"]
    if quantity.standard_uncertainty is not None:
        spread = interval_from_si(quantity.standard_uncertainty, quantity.unit, unit)
        fields.append(f"standard_uncertainty = {_number(spread, unit)}")
    if method is not None:
        fields.append(f"method = {quoted(method)}")
    return f"{{ {', '.join(fields)} }}"


def _number(value: float, unit: str) -> str:
    return f"{value:.6g}" if unit == "1" else quoted(f"{value:.6g} {unit}")
