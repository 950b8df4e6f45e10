"""A run or a study on one page: ordered texts, facts and tables for terminal, web and report.

Texts must be escaped for the output, since they contain input from users.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from tribopipe.base.units import WEAR_COEFFICIENT, force_unit, from_si, pretty, show
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import ProfileSource, StatedFriction
from tribopipe.documents.quantity import EndValue, Quantity, between
from tribopipe.documents.record import Record
from tribopipe.results.finding import Finding


@dataclass(frozen=True)
class Fact:
    """One displayed property: "normal load", "200.0 ± 2.0 mN"."""

    name: str
    value: str


@dataclass(frozen=True)
class FactGroup:
    """Properties that belong together, such as those of the pin."""

    title: str
    facts: tuple[Fact, ...]


@dataclass(frozen=True)
class TextTable:
    """A table of texts."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    spare: tuple[str, ...] = ()
    """Columns that are omitted on a narrow terminal."""

    @classmethod
    def of_rows(cls, title: str, rows: Sequence[Mapping[str, str | None]], missing: str) -> "TextTable":
        """Return a table of rows whose cells have the names of their columns; without rows, it has no columns."""
        columns = tuple(dict.fromkeys(name for row in rows for name in row))
        return cls(title, columns, tuple(tuple(row.get(name) or missing for name in columns) for row in rows))

    def without_spare(self) -> "TextTable":
        """Return the table without the columns that may be omitted."""
        kept = [place for place, name in enumerate(self.columns) if name not in self.spare]
        columns, *rows = (tuple(row[place] for place in kept) for row in (self.columns, *self.rows))
        return TextTable(self.title, columns, tuple(rows))


@dataclass(frozen=True)
class StagePage:
    """One completed step of a run."""

    name: str
    """Name in the archive: "drift_correction"."""
    title: str
    """Displayed name: "Drift correction"."""
    sentence: str
    """Its result in one sentence."""
    facts: tuple[Fact, ...]
    """Its results, one by one."""
    notes: tuple[str, ...]
    """Notes on the result."""
    tables: tuple[TextTable, ...]
    """Tables, such as uncertainty budgets."""
    path: str
    """Its path in the run's HDF5 file."""
    program_version: str
    date: str
    options: Mapping[str, object]
    """Options of the step, as JSON types."""
    inputs_sha256: str
    result_sha256: str


@dataclass(frozen=True)
class SourceEntry:
    """A source file, without its content."""

    number: int
    """Its index in /entry/source_files."""
    name: str
    size: int
    sha256: str


@dataclass(frozen=True)
class Remark:
    """A mark, tag or note on a run, or an amendment of its run.toml."""

    kind: str
    """"bad", "good", "tag", "untag", "note" or "amended"."""
    text: str
    date: str
    operator: str | None


@dataclass(frozen=True)
class RunPage:
    """One run."""

    id: str
    title: str
    tribometer: str | None
    bad: str | None
    """Why it is marked bad; None if it is not."""
    tags: tuple[str, ...]
    remarks: tuple[Remark, ...]
    """All annotations, oldest first."""
    facts: tuple[FactGroup, ...]
    """Test, bodies, post-test measurements, recorded data."""
    findings: tuple[Finding, ...]
    stages: tuple[StagePage, ...]
    sources: tuple[SourceEntry, ...]
    raw_sha256: str
    studies: tuple[str, ...]
    """Ids of the studies that include it."""


@dataclass(frozen=True)
class AgreementLine:
    """Result of a study for one run under one law."""

    run_id: str
    role: str
    """"fitted" or "predicted"."""
    outcome: str
    sentence: str
    notes: tuple[str, ...]


@dataclass(frozen=True)
class LawPage:
    """One wear law in a study."""

    model: str
    heading: str
    """The law without results, such as "Archard's law"."""
    title: str
    """The law and its k_D with interval."""
    tables: tuple[TextTable, ...]
    sentences: tuple[str, ...]
    """Sentences on the law, such as between-run scatter."""
    agreement: tuple[AgreementLine, ...]


@dataclass(frozen=True)
class StudyPage:
    """One study."""

    id: str
    title: str
    fitted: tuple[str, ...]
    predicted: tuple[str, ...]
    laws: tuple[LawPage, ...]
    sentences: tuple[str, ...]
    """Sentences on the whole study: comparison of the laws, excluded runs, notes."""
    program_version: str
    date: str
    inputs_sha256: str


NOTHING = "–"
_BY_SI = {
    "m": "um",
    "m/s": "mm/s",
    "Pa": "MPa",
    "kg/m^3": "g/cm^3",
    "Pa*m^0.5": "MPa*m^0.5",
    "K": "degC",
    "m^3": "mm^3",
    "kg": "mg",
    "1/s": "Hz",
    "rad/s": "rpm",
    "m^2/N": WEAR_COEFFICIENT,
}
"""Display units of quantities by SI unit, unless their field has another."""


class _Field(NamedTuple):
    """Displayed name of a field, and its display unit if that of its SI unit is not suitable."""

    label: str
    unit: str | None = None


_FIELDS = {
    "material": _Field("material"),
    "shape": _Field("shape"),
    "radius": _Field("radius", "mm"),
    "flat_radius": _Field("radius of the flat"),
    "rolling_radius": _Field("radius along the rolling direction", "mm"),
    "crown_radius": _Field("crown radius", "mm"),
    "width": _Field("width", "mm"),
    "diameter": _Field("diameter", "mm"),
    "youngs_modulus": _Field("Young's modulus", "GPa"),
    "poisson_ratio": _Field("Poisson ratio"),
    "density": _Field("density"),
    "surface_roughness": _Field("roughness Ra"),
    "vickers_hardness": _Field("Vickers hardness HV"),
    "fracture_toughness": _Field("fracture toughness K_Ic"),
    "coating_thickness": _Field("coating thickness"),
    "normal_load": _Field("normal load"),
    "sliding_speed": _Field("sliding speed"),
    "curved_disc_speed": _Field("speed of the crowned disc"),
    "flat_disc_speed": _Field("speed of the cylindrical disc"),
    "slip": _Field("slip", "%"),
    "rotational_speed": _Field("rotational speed"),
    "track_radius": _Field("track radius", "mm"),
    "stroke": _Field("stroke", "mm"),
    "frequency": _Field("frequency"),
    "sliding_distance": _Field("sliding distance", "m"),
    "rotations": _Field("rotations"),
    "medium": _Field("medium"),
    "temperature": _Field("temperature"),
    "relative_humidity": _Field("relative humidity", "%"),
    "friction": _Field("stated friction coefficient"),
}
"""Fields with their own name or unit, in display order; others follow."""


def record_facts(record: Record) -> tuple[Fact, ...]:
    """Return the content of a part of run.toml, in display order."""
    names = sorted(type(record).model_fields, key=lambda name: _ORDER.get(name, len(_ORDER)))
    return facts(*((_label(name), _stated(name, getattr(record, name))) for name in names))


_ORDER = {name: place for place, name in enumerate(_FIELDS)}


def facts(*told: tuple[str, str | None]) -> tuple[Fact, ...]:
    """Return the facts that have a value."""
    return tuple(Fact(name, value) for name, value in told if value is not None)


def shown(quantity: Quantity | None, unit: str | None = None) -> str | None:
    """Format a quantity in a unit, by default its display unit; None if it is unknown."""
    return None if quantity is None else quantity.shown(unit or usual_unit(quantity))


def probability(value: float) -> str:
    """Format a p-value with two digits, a small one with a power of ten: "0.14", "1.9×10⁻²¹"."""
    return show(float(f"{value:.2g}"), None, "1")


def usual_unit(quantity: Quantity) -> str:
    """Return the display unit of a quantity from its SI unit."""
    return force_unit(quantity.value) if quantity.unit == "N" else _BY_SI.get(quantity.unit, quantity.unit)


def interval(ends: tuple[Quantity, Quantity | None] | None, unit: str) -> str | None:
    """Format an interval with its unit once, "13 to 15 µm"; open above if it has no upper end."""
    if ends is None:
        return None
    low, high = ends
    if high is None:
        return f"{low.shown(unit)} or more"
    return between((low, high), unit)


def bare(quantity: Quantity | None, unit: str) -> str:
    """Format a quantity whose unit is shown elsewhere; a dash if it is unknown."""
    return NOTHING if quantity is None else quantity.shown(unit).removesuffix(f" {pretty(unit)}")


def duration(time: Quantity | None) -> str | None:
    """Format a duration in a suitable unit; None if it is unknown."""
    if time is None:
        return None
    return time.shown("s" if time.value < 600 else "min" if time.value < 7200 else "h")


def yes_or_no(answer: bool | None) -> str | None:
    """Format yes or no; None if there is no answer."""
    return None if answer is None else "yes" if answer else "no"


def signed_share(share: float) -> str:
    """Format a share with its sign, "+1.50 %"; a share that rounds to zero has no sign."""
    written = f"{100 * share:+.2f} %"
    return "0.00 %" if written[1:] == "0.00 %" else written


def listed(words: Iterable[str]) -> str | None:
    """Join words; None if there are none."""
    return ", ".join(words) or None


def _label(name: str) -> str:
    return _FIELDS[name].label if name in _FIELDS else spoken(name)


def _stated(name: str, value: Any) -> str | None:
    if isinstance(value, Quantity):
        unit = _FIELDS[name].unit if name in _FIELDS else None
        return f"{shown(value, unit)}{''.join(_measured(value))}"
    if isinstance(value, StatedFriction):
        parts = zip("Abc", (value.amplitude, value.steady_state, value.running_in_distance), strict=True)
        return ", ".join(f"{letter} = {part}" for letter, part in parts)
    if isinstance(value, bool):
        return yes_or_no(value)
    if isinstance(value, tuple):
        return listed(_files(source) for source in value if isinstance(source, ProfileSource))
    return value if value is None or isinstance(value, str) else f"{value:,.12g}"


def _files(source: ProfileSource) -> str:
    return source.file if source.before is None else f"{source.file} (before the test: {source.before})"


def _measured(value: Quantity) -> Iterator[str]:
    """Return how a post-test measurement was made, and the readings of which it is the mean."""
    if not isinstance(value, EndValue):
        return
    if value.method is not None:
        yield f", {value.method}"
    if value.readings is not None:
        unit = usual_unit(value)
        readings = ", ".join(f"{from_si(reading, value.unit, unit):.4g}" for reading in value.readings)
        yield f", mean of {len(value.readings)} readings: {readings}"
