"""The k_D that a subroutine is written with, and where it came from."""

from dataclasses import dataclass

from tribopipe.base.errors import FitError
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.wear.known import known_wear
from tribopipe.evaluation.wear.local import ARCHARDS, archards_wear
from tribopipe.results.wear_fit import WearFit

_MEASURED = "k_D was identified with friction as measured; the subroutine takes the fit of Eq. 7."
_OTHER_WEARS = "in the test the {} wore too, which this leaves out: it wears the {} alone."
_PRESSURES = {
    "giwm": "uniform pressure (the Global Incremental Wear Model)",
    "volume": "the wear volume of the pin",
    "local": "local pressure",
}


@dataclass(frozen=True)
class KnownWear:
    """k_D of a run's pin or crowned disc."""

    run_id: str
    coefficient: Quantity
    """m²/N; of discs as Eq. 9 has it, which counts what a point slides while it is in contact."""
    origin: str
    """Where it came from, in one sentence."""
    notes: tuple[str, ...] = ()
    """What to beware of."""


def given_wear(run_id: str, coefficient: Quantity) -> KnownWear:
    """Return a k_D that somebody states."""
    return KnownWear(run_id, coefficient, "It was given with --wear-coefficient.")


def fitted_wear(run_id: str, fit: WearFit) -> KnownWear:
    """Return the k_D of a fit. Raises ``FitError`` where it found none, or none that Eq. 9 can be given."""
    origin = f"It was identified from run {run_id} under {fit.model.title()}'s law"
    notes: tuple[str, ...] = (_MEASURED,) if fit.friction == "measured" else ()
    if fit.first is None:
        lacks = " and ".join(fit.lacks)
        raise FitError(f"{run_id}: found no k_D (missing: {lacks}); give one with --wear-coefficient")
    first, *others = fit.bodies
    worn = (name for name in others if fit.bodies[name].wear_coefficient.value > 0)
    notes += tuple(_OTHER_WEARS.format(spoken(name), spoken(first)) for name in worn)
    if fit.distance_per_rotation is None:
        return KnownWear(run_id, fit.first.wear_coefficient, f"{origin} with {_PRESSURES[fit.engine]}.", notes)
    coefficient, how = _of_eq_9(run_id, fit)
    return KnownWear(run_id, coefficient, f"{origin} {how}", notes)


def _of_eq_9(run_id: str, fit: WearFit) -> tuple[Quantity, str]:
    """Return k_D of the crowned disc for Eq. 9, with distance counted as in Archard's law, and how it was obtained."""
    own, same = known_wear(fit), archards_wear(fit)
    if own is None or same is None:
        raise FitError(
            f"{run_id}: found a k_D that was fitted with {fit.distance_per_rotation}; expected {ARCHARDS}, as Eq. 9 "
            f'has it; fit again with a recipe that sets distance_per_rotation = "{ARCHARDS}" under [wear]'
        )
    if own.distance == ARCHARDS:
        return same.first, f"with {ARCHARDS}, as Eq. 9 has it."
    return same.first, (
        f"with {own.distance}, as {own.first.value * 1e6:.4g} mm^3/(N mm), and turned into {ARCHARDS}, as Eq. 9 "
        f"has it: with either the {spoken(next(iter(fit.bodies)))} loses the same volume in the run."
    )
