"""k_D of the bodies of a contact as a prediction takes it over: with all that makes it mean what it does."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.physics.conventions import DistanceConvention, WearEngine
from tribopipe.results.wear_fit import LawValue, WearFit

_UNWORN = Quantity(value=0.0, unit="m^2/N")


@dataclass(frozen=True)
class KnownWear:
    """k_D of each body, m²/N; a body that is left out does not wear."""

    bodies: Mapping[str, Quantity]
    """By name; first the one whose k_D is always known."""
    engine: WearEngine = "giwm"
    """That k_D was found by: by another one it gives another depth."""
    distance: DistanceConvention = "full-slip"
    """Sliding distance per rotation of bodies that roll; under another convention k_D has another meaning."""
    correlation: float = 0.0
    """Of the k_D of both bodies."""
    parameters: tuple[LawValue, ...] = ()
    """Of the law with k_D."""
    covariance: tuple[tuple[float, ...], ...] | None = None
    """Of ln k_D and those parameters that were fitted."""

    @property
    def first(self) -> Quantity:
        """k_D of the body whose k_D is always known."""
        return next(iter(self.bodies.values()))

    def of(self, body: str) -> Quantity:
        """Return k_D of a body, 0 where it does not wear."""
        return self.bodies.get(body, _UNWORN)

    @property
    def parts(self) -> tuple[Quantity | str, ...]:
        """Everything that identifies it, for a fingerprint."""
        bodies = [part for name, found in self.bodies.items() for part in (name, found)]
        beside = [part for one in self.parameters for part in (one.name, one.value)]
        return *bodies, self.engine, self.distance, str(self.correlation), *beside, str(self.covariance)


def known_wear(fit: WearFit) -> KnownWear | None:
    """Return k_D of a fit; none where nothing was fitted."""
    if not fit.bodies:
        return None
    return KnownWear(
        {name: body.wear_coefficient for name, body in fit.bodies.items()},
        engine=fit.engine,
        distance=fit.distance_per_rotation or "full-slip",
        correlation=fit.correlation or 0.0,
        parameters=fit.parameters or (),
        covariance=fit.parameter_covariance,
    )


def given_wear(bodies: Iterable[str], coefficients: Iterable[Quantity], recipe: Recipe) -> KnownWear:
    """Return k_D that somebody states of bodies in their order, those without one unworn, as a recipe takes it."""
    stated = dict(zip(bodies, coefficients, strict=False))
    return KnownWear(stated, engine=recipe.wear.engine or "giwm", distance=recipe.wear.distance_per_rotation)
