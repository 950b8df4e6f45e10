"""The k_D that a subroutine is written with, and where it came from."""

from dataclasses import dataclass

from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.evaluation.wear.local import ARCHARDS, archards_discs
from tribopipe.evaluation.wear.twin_disc.predict import known_discs
from tribopipe.results.disc_evaluation import TwinDiscFit
from tribopipe.results.evaluation import WearFit

_MEASURED = "k_D was identified with friction as measured; the subroutine takes the fit of Eq. 7."
_FLAT_DISC = "in the test the flat disc wore too, which this leaves out: it wears the curved disc alone."
_PRESSURES = {
    "giwm": "even pressure (the Global Incremental Wear Model)",
    "volume": "the volume that the pin lacks",
    "local": "local pressure",
}


@dataclass(frozen=True)
class KnownWear:
    """k_D of a run's pin or curved disc."""

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


def fitted_wear(run_id: str, fit: WearFit | TwinDiscFit) -> KnownWear:
    """Return the k_D of a fit. Raises ``FitError`` where it found none, or none that Eq. 9 can be given."""
    origin = f"It was identified from run {run_id} under {fit.model.title()}'s law"
    notes = (_MEASURED,) if fit.friction == "measured" else ()
    if isinstance(fit, TwinDiscFit) and fit.curved_disc is not None:
        flat_wears = fit.flat_disc is not None and fit.flat_disc.wear_coefficient.value > 0
        coefficient, how = _of_eq_9(run_id, fit)
        return KnownWear(run_id, coefficient, f"{origin} {how}", (*notes, _FLAT_DISC) if flat_wears else notes)
    if isinstance(fit, WearFit) and fit.wear_coefficient is not None:
        return KnownWear(run_id, fit.wear_coefficient, f"{origin} with {_PRESSURES[fit.engine]}.", notes)
    raise FitError(f"{run_id}: found no k_D; the run lacks {' and '.join(fit.lacks)}; give one with --wear-coefficient")


def _of_eq_9(run_id: str, fit: TwinDiscFit) -> tuple[Quantity, str]:
    """Return the curved disc's k_D as Eq. 9 has it, which counts distance as Archard's law does, and how it was had."""
    own, same = known_discs(fit), archards_discs(fit)
    if own is None or same is None:
        raise FitError(
            f"{run_id}: found a k_D that was fitted with {fit.distance_per_rotation}; expected {ARCHARDS}, as Eq. 9 "
            f'has it; fit again with a recipe that says distance_per_rotation = "{ARCHARDS}" under [wear]'
        )
    if own.distance == ARCHARDS:
        return same.curved, f"with {ARCHARDS}, as Eq. 9 has it."
    return same.curved, (
        f"with {own.distance}, as {own.curved.value * 1e6:.4g} mm^3/(N mm), and turned into {ARCHARDS}, as Eq. 9 "
        "has it: with either the curved disc loses the same volume in the run."
    )
