"""A virtual instrument: what it reads of the truth, with errors and noise, and the run folder that it writes.

Errors are drawn once per run, noise sample by sample, post-test measurements about the truth; run.toml, signals.csv
and truth.json are written.
"""

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import OutputError
from tribopipe.base.files import write_file
from tribopipe.base.units import KINDS, from_si, interval_from_si
from tribopipe.documents.contact import Specimen
from tribopipe.documents.manifest import MANIFEST_NAME
from tribopipe.documents.plan import (
    RecordingSensors,
    Series,
    Truth,
    TwinDiscSeries,
    TwinDiscTruth,
    TwinDiscVirtualRun,
    VirtualRun,
)
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record, quoted
from tribopipe.evaluation.load_and_friction import stated_path
from tribopipe.evaluation.wear.inputs import law_with, read_parameters
from tribopipe.physics.laws import WearLaw, law_named

_PLACE = "law_parameters"


def true_law(series: Series | TwinDiscSeries) -> WearLaw:
    """Return the law of a series.

    Raises ``FitError`` where it is not installed here, where a parameter is missing, or one is none of the law's.
    """
    law = law_named(series.law)
    return law_with(law, read_parameters(law, series.law_parameters, _PLACE), f"{_PLACE} of the series")


def true_parameters(law: WearLaw) -> dict[str, Quantity] | None:
    """Return the parameters of a law in addition to k_D, in SI; None if it has none."""
    known = law.parameters()
    return {
        name: Quantity(value=value, unit=KINDS[known[name].kind].si) for name, value in law.values().items()
    } or None


TrueValue = Callable[[Quantity], float]
"""Function that draws the true value of a quantity from the stated value."""


def systematic_errors(seed: int, *, drawn: bool) -> TrueValue:
    """Return the function that draws true values: a new error for each quantity, or none."""
    # A stream of its own, so that the noise is the same with these errors and without.
    rng = np.random.Generator(np.random.PCG64([seed, 1]))

    def off(stated: Quantity) -> float:
        error = stated.u_or_zero * float(rng.standard_normal())
        return stated.value + (error if drawn else 0.0)

    return off


def read_depth(true: Column, time: Column, sensors: RecordingSensors, rng: Generator) -> Column:
    """Return the depth as digitised, m, from what the sensor would show at ``time``, s, without noise."""
    noise = correlated(rng, len(time), sensors.depth_correlation_time.value * sensors.sampling_rate.value)
    step = sensors.depth_resolution.value
    return np.asarray(np.round((true + sensors.depth_noise.value * noise) / step) * step)


def read_forces(
    friction: Column, load: float, nominal: float, sensors: RecordingSensors, rng: Generator
) -> tuple[Column, Column]:
    """Return friction force and normal force as recorded, N, from the true friction coefficient and the true load.

    The load cell shows the nominal load: by how much the true one is off is the error of its calibration.
    """
    count = len(friction)
    noise = correlated(rng, count, sensors.friction_correlation_time.value * sensors.sampling_rate.value)
    mu = friction + sensors.friction_noise.value * noise
    wobble = 1 + sensors.load_noise.value * rng.standard_normal(count)
    return mu * (load * wobble), nominal * wobble


def correlated(rng: Generator, count: int, length: float) -> Column:
    """Draw first-order autoregressive noise of unit variance that forgets itself over ``length`` samples."""
    from scipy.signal import lfilter

    memory = math.exp(-1 / length)
    white = rng.standard_normal(count)
    start = white[:1] * memory
    shaped, _ = lfilter([math.sqrt(1 - memory**2)], [1.0, -memory], white[1:], zi=start)
    return np.concatenate([white[:1], shaped])


def measured(true: float, spread: float, rng: Generator, unit: str = "m") -> Quantity:
    """Draw a post-test measurement about its true value."""
    return Quantity(value=true + spread * float(rng.standard_normal()), unit=unit, standard_uncertainty=spread)


SIGNALS_NAME, TRUTH_NAME = "signals.csv", "truth.json"


class Written(NamedTuple):
    """Column of signals.csv: header and units."""

    header: str
    si: str
    unit: str
    decimals: int


Layout = Mapping[str, Written]
"""The columns of signals.csv in their order."""


class AnyVirtualTest(ABC):
    """One virtual run: its true state, what the instrument makes of it, and how that is written."""

    series: Series | TwinDiscSeries
    run: VirtualRun | TwinDiscVirtualRun
    time: Column
    """Time of each sample, s."""
    distance: Column
    """Sliding distance of the unworn bodies, m."""
    depth_scale: float
    """True displacement over displacement read."""
    instrument: str
    """Name of the instrument in run.toml."""
    layout: Layout
    measured_by: ClassVar[Mapping[str, tuple[str, str]]]
    """Unit in run.toml and method of each post-test measurement."""
    friction_arm: float = 1.0
    """Friction as written, a force or a torque, over the friction force."""

    def __init__(self, series: Series | TwinDiscSeries, run: VirtualRun | TwinDiscVirtualRun) -> None:
        self.series, self.run = series, run
        self.friction, self.law = stated_path(run.friction), true_law(series)

    @property
    @abstractmethod
    def displacement(self) -> Column:
        """Displacement by the wear of both bodies, as the sensor reads it, m."""

    @property
    @abstractmethod
    def loads(self) -> tuple[float, float]:
        """Normal load, N: the true one and the nominal one."""

    @property
    @abstractmethod
    def conditions(self) -> Mapping[str, str]:
        """The conditions, but for the medium, as run.toml has them."""

    @property
    def counted(self) -> Mapping[str, Column]:
        """Columns that the instrument counts in addition to time."""
        return {}

    @abstractmethod
    def truth(self) -> Truth | TwinDiscTruth:
        """Return what the run was made from."""

    @abstractmethod
    def end_values(self, rng: Generator) -> dict[str, Quantity]:
        """Draw the post-test measurements."""

    def record(self) -> tuple[dict[str, Column], dict[str, Quantity]]:
        """Return the instrument's columns, SI, and the uncertain post-test measurements, drawn with the run's seed."""
        run, sensors, rng = self.run, self.series.sensors, np.random.Generator(np.random.PCG64(self.run.seed))
        shown = run.zero_offset.value + self.displacement + run.drift_rate.value * self.time
        depth = read_depth(shown, self.time, sensors, rng)
        rubbing, load = read_forces(self.friction.coefficient(self.distance), *self.loads, sensors, rng)
        columns = {"time": self.time, **self.counted, "depth": depth, "normal_force": load, "friction_force": rubbing}
        return columns, self.end_values(rng)

    def write(self, folder: Path) -> Truth | TwinDiscTruth:
        """Write a run folder: run.toml, signals.csv and truth.json."""
        columns, ends = self.record()
        columns["friction_force"] = columns["friction_force"] * self.friction_arm
        truth = self.truth()
        _write_run(folder, self.layout, columns, _manifest(self, ends), truth)
        return truth

    def told(self) -> dict[str, Any]:
        """Return what the truth of any run states."""
        run = self.run
        return {
            "id": run.id,
            "law": self.series.law,
            "law_parameters": true_parameters(self.law),
            "friction": run.friction,
            "zero_offset": run.zero_offset,
            "drift_rate": run.drift_rate,
        }


def require_simulated(folder: Path) -> None:
    """Raise ``OutputError`` where a run folder holds another run than a simulated one, which may be written again."""
    there = [name for name in (MANIFEST_NAME, SIGNALS_NAME) if (folder / name).exists()]
    if there and not (folder / TRUTH_NAME).is_file():
        raise OutputError(
            f"{folder}: found {there[0]} without {TRUTH_NAME}; expected a new folder, or the folder of a simulated "
            "run; specify another folder"
        )


def _write_run(folder: Path, layout: Layout, columns: Mapping[str, Column], manifest: list[str], truth: Record) -> None:
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


def _manifest(test: "AnyVirtualTest", ends: Mapping[str, Quantity]) -> list[str]:
    """Return the lines of run.toml."""
    series, run, contact = test.series, test.run, test.series.contact
    return [
        "#:schema ../../schemas/run.schema.json",
        "# Synthetic: written by `tribopipe simulate`; truth.json next to it holds the true values.",
        'schema = "tribopipe.run/1"',
        f"id = {quoted(run.id)}",
        f"started = {run.started.isoformat()}",
        f"title = {quoted(series.title)}",
        f"instrument = {quoted(test.instrument)}",
        "",
        "[contact]",
        f"kind = {quoted(contact.kind)}",
        *(line for name, body in contact.bodies.items() for line in ("", f"[contact.{name}]", *_body(body))),
        "",
        "[conditions]",
        *(f"{name} = {value}" for name, value in test.conditions.items()),
        f"medium = {quoted(series.medium)}",
        "",
        "[[signals]]",
        f"file = {quoted(SIGNALS_NAME)}",
        "[signals.columns]",
        *(f"{name} = {{ column = {quoted(column.header)} }}" for name, column in test.layout.items()),
        "",
        "[end_values]",
        *(f"{contact.worded(name)} = {written(value, *test.measured_by[name])}" for name, value in ends.items()),
        "",
        "[sensors]",
        f"depth_scale = {written(series.depth_scale, '1')}",
    ]


_UNITS = {
    "flat_radius": "um",
    "youngs_modulus": "GPa",
    "poisson_ratio": "1",
    "density": "g/cm^3",
    "surface_roughness": "um",
    "coating_thickness": "um",
    "fracture_toughness": "MPa*m^0.5",
}
"""Unit in run.toml of what is known of a body; mm for other lengths."""


def _body(body: Specimen) -> list[str]:
    """Return the lines of a body: its shape and sizes, then what is known of any specimen."""
    own = [name for name in type(body).model_fields if name not in Specimen.model_fields]
    given = {name: getattr(body, name) for name in (*own, *Specimen.model_fields)}
    return [f"{name} = {_of_body(name, value)}" for name, value in given.items() if value is not None]


def _of_body(name: str, value: Any) -> str:
    if not isinstance(value, Quantity):
        return json.dumps(value)
    return written(value, _UNITS.get(name) or ("mm" if value.unit == "m" else value.unit))


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
