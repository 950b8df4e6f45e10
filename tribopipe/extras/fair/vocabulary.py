"""Meaning of the names in tribopipe, and their terms in published vocabularies.

Where a name is not listed, no identifier is known of it.

Units: QUDT (qudt.org, CC BY 4.0), read from its units on 2026-08-05, with UCUM codes next to them. Neither has a unit
of fracture toughness, Pa·m½.

Quantities and things: TriboDataFAIR Ontology 0.1.1 (N. Garabedian et al., doi:10.1038/s41597-022-01429-9, CC BY 4.0),
read from its OWL file. It describes how a test was set up. It has no class of a friction coefficient, friction force,
wear depth, wear volume, wear coefficient, wear rate, drift, slip, contact pressure or elastic constant.
"""

from collections.abc import Mapping
from typing import NamedTuple

from tribopipe.documents.signals import SIGNALS
from tribopipe.physics.laws import LAWS, law_title

_QUDT = "http://qudt.org/vocab/unit/"
_TRIBODATAFAIR = (
    "https://raw.githubusercontent.com/nick-garabedian/TriboDataFAIR-Ontology/v0.1.1/TriboDataFAIR_Ontology.owl#"
)


class Unit(NamedTuple):
    """A unit of tribopipe elsewhere."""

    ucum: str | None
    """Code by the Unified Code for Units of Measure; None if it has none."""
    qudt: str | None
    """Name in QUDT; None if it has none."""

    @property
    def iri(self) -> str | None:
        """Identifier in QUDT."""
        return None if self.qudt is None else f"{_QUDT}{self.qudt}"


UNITS: Mapping[str, Unit] = {
    "1": Unit("1", "UNITLESS"),
    "m": Unit("m", "M"),
    "um": Unit("um", "MicroM"),
    "m^2": Unit("m2", "M2"),
    "m^3": Unit("m3", "M3"),
    "mm^3": Unit("mm3", "MilliM3"),
    "s": Unit("s", "SEC"),
    "1/s": Unit("s-1", "PER-SEC"),
    "rad/s": Unit("rad.s-1", "RAD-PER-SEC"),
    "m/s": Unit("m.s-1", "M-PER-SEC"),
    "kg": Unit("kg", "KiloGM"),
    "kg/m^3": Unit("kg.m-3", "KiloGM-PER-M3"),
    "N": Unit("N", "N"),
    "N*m": Unit("N.m", "N-M"),
    "Pa": Unit("Pa", "PA"),
    "Pa*m^0.5": Unit(None, None),
    "K": Unit("K", "K"),
    "m^2/N": Unit("m2.N-1", "M2-PER-N"),
}
"""Terms of units, with the archive's unit as key."""

_TERMS: Mapping[str, str] = {
    "test": "TribologicalExperiment",
    "evaluation": "DataProcessing",
    "tribometer": "Tribometer",
    "conditions.normal_load": "NormalLoadSetpoint",
    "conditions.sliding_speed": "SlidingSpeedSetpoint",
    "conditions.track_radius": "RadialPositionSetpoint",
    "conditions.medium": "SurroundingMediumType",
    "conditions.temperature": "UncontrolledEnvironmentTemperature",
    "conditions.relative_humidity": "UncontrolledEnvironmentRelativeHumidity",
    "material": "MaterialName",
    "density": "ObjectMassDensity",
    "radius": "ObjectRadius",
    "diameter": "ObjectDiameter",
    "width": "ObjectWidth",
    "vickers_hardness": "HardnessMagnitude",
    "time": "ExperimentElapsedTime",
    "sliding_distance": "ExperimentTraveledDistance",
    "temperature": "TemperatureMagnitude",
    "relative_humidity": "RelativeHumidityMagnitude",
    "normal_force": "ForceMagnitude",
    "friction_force": "ForceMagnitude",
}


def term(name: str) -> str | None:
    """Return the TriboDataFAIR identifier of a term of tribopipe; None if there is none."""
    return term_of(_TERMS.get(name))


def term_of(identifier: str | None) -> str | None:
    """Return an identifier of TriboDataFAIR in full; None if there is none."""
    return None if identifier is None else f"{_TRIBODATAFAIR}{identifier}"


TERMS: Mapping[str, str] = {name: f"{_TRIBODATAFAIR}{found}" for name, found in _TERMS.items()}
"""Every name that has one."""


_ENDS: Mapping[str, str] = {
    "_lower": "lower limit of the 95 % band of",
    "_upper": "upper limit of the 95 % band of",
    "_errors": "standard uncertainty of",
}
_MEANINGS: Mapping[str, str] = {
    **{name: signal.meaning for name, signal in SIGNALS.items()},
    "wear_depth": "total wear depth of both bodies, corrected for drift or from a wear law",
    "pin_wear_depth": "wear depth of the pin",
    "fitted_friction_coefficient": "friction coefficient from the exponential fit",
    **{law: f"wear from {law_title(law)}" for law in LAWS},
    "curved_depth": "wear depth of the crowned disc",
    "flat_depth": "wear depth of the cylindrical disc",
    "curved_volume": "wear volume of the crowned disc",
    "flat_volume": "wear volume of the cylindrical disc",
    "half_width": "semi-axis of the contact across the rolling direction",
    "half_length": "semi-axis of the contact along the rolling direction",
    "pressure": "contact pressure",
    "measured": "measured wear",
    "predicted": "wear from the law",
    "lower": "lower limit of the 95 % band of the prediction",
    "upper": "upper limit of the 95 % band of the prediction",
    "measurement": "name of the post-test measurement",
    "position": "position across the worn surface",
    "height": "height, positive outward from the body",
    "radius": "distance from the center of the contact",
    "across": "position across the rolling direction",
    "along": "position along the rolling direction",
    "wear": "wear depth at this position",
    "gap": "gap between the unworn surfaces",
}


def meaning(column: str) -> str | None:
    """Return what a column holds, by its name without unit; None for those that only the instrument knows."""
    if column in _MEANINGS:
        return _MEANINGS[column]
    for end, said in _ENDS.items():
        if column.endswith(end) and column.removesuffix(end) in _MEANINGS:
            return f"{said} {_MEANINGS[column.removesuffix(end)]}"
    return None
