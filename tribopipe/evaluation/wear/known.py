"""k_D of the bodies of a contact as a prediction takes it over: with all that makes it mean what it does."""

from collections.abc import Mapping
from dataclasses import dataclass

from tribopipe.base.errors import FitError
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import spoken
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


def given_wear(contact: Contact, coefficients: Mapping[str, Quantity], recipe: Recipe) -> KnownWear:
    """Return k_D that somebody states of bodies by name, those without one unworn, as a recipe takes it.

    The counterbody of a pin wears by volume. Raises ``FitError`` where the recipe asks for another engine then.
    """
    stated = {name: coefficients[name] for name in contact.body_names if name in coefficients}
    both, engine = any(name not in contact.fitted_bodies for name in stated), recipe.wear.engine
    if both and engine not in (None, "volume"):
        raise FitError(
            f"wear coefficients: found those of the {' and '.join(map(spoken, stated))} with --engine {engine}, which "
            "computes only the wear of the pin; expected --engine volume, or k_D of the pin alone"
        )
    if both:
        # Depths that are to be reached are those of the first body, so that it has to wear.
        stated = {name: k for name, k in stated.items() if k.value > 0 or name not in contact.fitted_bodies}
    usual: WearEngine = "volume" if both else "giwm"
    return KnownWear(stated, engine=engine or usual, distance=recipe.wear.distance_per_rotation)
