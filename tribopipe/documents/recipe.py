"""recipe.toml: how runs are processed. Every value has a default; the archive keeps what was used."""

from typing import Annotated, Literal

from pydantic import Field

from tribopipe.documents.preprocessing import AUTOMATIC, CleaningStep
from tribopipe.documents.quantity import Length, Mass, Position, Quantity, meters
from tribopipe.documents.record import InstalledName, Record
from tribopipe.physics.calculation_methods import LAW_GROUP, LAW_PATTERN, DistanceConvention, WearEngine

LAWS = InstalledName(LAW_GROUP, "wear law", LAW_PATTERN)
LawName = Annotated[str, LAWS]
GivenParameter = str | float | dict[str, str | float]
"""A number with its unit, or a table of value and standard_uncertainty; the law gives for what kind."""
FrictionSource = Literal["fitted", "measured"]


class DriftRecipe(Record):
    """Settings of the drift correction."""

    window: float = Field(default=0.02, gt=0, lt=0.5)
    """Fraction of the distance at each end that gives zero offset and final value in the two-step correction."""
    prior: Length = Field(default_factory=lambda: meters(250e-9))
    """Standard uncertainty of the drift over a whole test, used only if no wear was measured after it.

    The default is the largest discrepancy that the paper found.
    """


class FrictionRecipe(Record):
    """Part of the friction signal that is fitted with Eq. 7."""

    start: Position | None = None
    """Start of the fit, such as "0 m" for the first sample; default: end of the loading ramp, which is detected."""
    end: Position | None = None
    """End of the fit; default: the end of the run."""


Correction = Literal["model", "two-step"]


class WearRecipe(Record):
    """Settings of the identification of the wear coefficient."""

    models: tuple[LawName, ...] = ("archard", "sarkar")
    """Wear laws that `process` fits."""
    parameters: dict[LawName, dict[str, GivenParameter]] = Field(default_factory=dict)
    """Known parameters of a wear law in addition to k_D; default: fitted together with k_D of a pin."""
    engine: WearEngine | None = None
    """Relation between wear depth and volume of a pin: Global Incremental Wear Model, wear volume, or local wear.

    Default: that of the model, or wear volume if the disc also wore. k_D is valid only for the engine with which it was
    fitted.
    """
    friction: FrictionSource = "fitted"
    """μ in a law that includes friction: Eq. 7 as fitted, or the measured curve."""
    correction: Correction = "model"
    """One model of wear, drift and all other contributions to the depth signal, or drift correction first, as in the
    paper."""
    distance_per_rotation: DistanceConvention = "full-slip"
    """Sliding distance per rotation of twin discs; k_D differs by orders of magnitude between the conventions."""


class DefaultUncertainty(Record):
    """Default standard uncertainties, relative or absolute, by name; used if run.toml contains none."""

    normal_load: float = Field(default=0.01, ge=0)
    """Relative."""
    pin_radius: float = Field(default=0.002, ge=0)
    """Relative."""
    youngs_modulus: float = Field(default=0.02, ge=0)
    """Relative, for each body."""
    sliding_speed: float = Field(default=0.005, ge=0)
    """Relative; used if the sliding distance is derived from the nominal speed."""
    depth_scale: float = Field(default=0.005, ge=0)
    """Relative: uncertainty of the calibration of the depth sensor."""
    crown_radius: float = Field(default=0.002, ge=0)
    """Relative."""
    rolling_radius: float = Field(default=0.001, ge=0)
    """Relative, for each disc of two."""
    slip: float = Field(default=0.01, ge=0)
    """Relative to the slip itself."""
    wear_volume: float = Field(default=0.1, ge=0)
    """Relative."""
    density: float = Field(default=0.005, ge=0)
    """Relative, for each body."""
    track_radius: float = Field(default=0.01, ge=0)
    """Relative: track radius, or stroke."""
    track_width: Length = Field(default_factory=lambda: meters(2e-6))
    """Absolute: approximately the resolution of an optical microscope."""
    pin_scar_diameter: Length = Field(default_factory=lambda: meters(2e-6))
    """Absolute: approximately the resolution of an optical microscope."""
    wear_depth: Length = Field(default_factory=lambda: meters(250e-9))
    """Absolute: the largest discrepancy found in the paper."""
    mass_loss: Mass = Field(default_factory=lambda: Quantity(value=1e-7, unit="kg"))
    """Absolute: approximately the repeatability of an analytical balance."""
    unseen_groove: float = Field(default=0.15, ge=0)
    """Depth of a possible groove in an unmeasured disc, relative to the wear depth of a pin that is not flat."""


class MonteCarloRecipe(Record):
    """Settings of the propagation of distributions (JCGM 101:2008)."""

    significant_digits: Literal[0, 1, 2] = 1
    """Digits of the standard uncertainty that must be stable before sampling ends (7.9.2); 0: first-order only."""
    seed: int = Field(default=1, ge=0)
    """Seed of the random numbers."""


class Recipe(Record):
    """Settings of all steps of the evaluation, from drift correction to prediction."""

    schema_version: Literal["tribopipe.recipe/1"] = Field(default="tribopipe.recipe/1", alias="schema")
    """Version of this document."""
    clean_up: tuple[CleaningStep, ...] = AUTOMATIC
    """Steps of preprocessing, in order; with an empty list, the recorded signals are used unchanged."""
    drift: DriftRecipe = DriftRecipe()
    """Drift correction."""
    friction: FrictionRecipe = FrictionRecipe()
    """Friction fit."""
    wear: WearRecipe = WearRecipe()
    """Wear fit."""
    uncertainty: DefaultUncertainty = DefaultUncertainty()
    """Standard uncertainties used if run.toml contains none."""
    monte_carlo: MonteCarloRecipe = MonteCarloRecipe()
    """Settings of the propagation of distributions."""
