"""Evaluation of post-test measurements for each kind of contact."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from tribopipe.base.errors import ContactError
from tribopipe.documents.contact import Contact, SlidingPin
from tribopipe.documents.contact_kinds import family_of
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty, Recipe
from tribopipe.documents.twin_disc import TwinDisc
from tribopipe.evaluation.measurements import pin_on_disc, twin_disc, worn_pair
from tribopipe.evaluation.measurements.body_wear import BodyMeasurement, Contradiction, WornBodies
from tribopipe.evaluation.measurements.end_wear import EndWear, TotalLimit, TotalWear
from tribopipe.evaluation.measurements.readings import EndValueUsed, SignalDepths
from tribopipe.results.run import RawRun


class Sensed(NamedTuple):
    """Functions that evaluate the measurements of bodies whose wear a displacement sensor shows."""

    end_wear: Callable[[RawRun, DefaultUncertainty, int | None, Quantity | None], EndWear | None]
    groove_alone: Callable[[RawRun, DefaultUncertainty], EndValueUsed | None]
    beside_unseen_groove: Callable[[EndWear, float, bool], float]


class Measurements(NamedTuple):
    """Functions that evaluate the measurements of the bodies."""

    worn: Callable[[RawRun, DefaultUncertainty, int | None, SignalDepths], WornBodies]
    """Depth and volume of each body at an interruption, or at the end, with what only the depth signal shows."""
    single: Callable[[RawRun, DefaultUncertainty], tuple[BodyMeasurement, ...]]
    """Everything measured, in the order of the test, where k_D is found by the measurements of all bodies together."""
    contradictions: Callable[[WornBodies], Iterable[Contradiction]]
    """Measurements of one body that give it different wear."""
    totals: Callable[[RawRun, Recipe], Iterable[TotalWear]] | None
    """Wear depth of both bodies together by each kind of measurement, where one shape that both share determines it."""
    total: Callable[[RawRun, Recipe], TotalWear | None]
    """The surest of them."""
    widest: Callable[[RawRun], TotalLimit | None]
    """Where the contact would be wider than a body; None where no width is stated."""
    needed: str
    """Measurement required for the wear at the end as a displacement sensor has seen it."""
    sensed: Sensed | None = None


def measurements_of(contact: Contact) -> Measurements:
    """Return what follows from measurements of the bodies of a contact."""
    return family_of(contact, _FAMILIES)


def worn_bodies(
    run: RawRun,
    defaults: DefaultUncertainty,
    interruption: int | None = None,
    signal: SignalDepths = SignalDepths(),  # noqa: B008 - it is immutable
) -> WornBodies:
    """Return depth and volume of both bodies by each measurement at the end of a run, or at an interruption.

    ``signal`` is what only the depth signal shows of their depths.

    Raises ``FitError`` for a mass without density, and for profiles of which nothing can be taken.
    """
    return measurements_of(run.manifest.described).worn(run, defaults, interruption, signal)


def end_wear(
    run: RawRun, defaults: DefaultUncertainty, interruption: int | None = None, approach: Quantity | None = None
) -> EndWear | None:
    """Return the wear of a body with a tip at the end of a run or in between; None if nothing was measured on it.

    ``approach`` is the wear depth of both bodies, m, by a depth signal that shows a groove nobody measured.

    Raises ``FitError`` as ``worn_bodies`` does, and ``ContactError`` where both bodies pass.
    """
    return _sensed(run).end_wear(run, defaults, interruption, approach)


def groove_alone(run: RawRun, defaults: DefaultUncertainty) -> EndValueUsed | None:
    """Return the depth of the groove, m, at the end of a run whose pin was not measured; None where it was.

    Raises ``FitError`` as ``worn_bodies`` does, and ``ContactError`` where both bodies pass.
    """
    return _sensed(run).groove_alone(run, defaults)


def beside_unseen_groove(run: RawRun, end: EndWear, share: float, *, by_sensor: bool) -> float:
    """Return the volume of a body with a tip and a groove that was not measured, over that on an unworn counterbody.

    Parameters
    ----------
    run
        The run.
    end
        What gives its depth; where its volume or the counterbody was measured, or the contact is a line, the answer
        is 1.
    share
        Depth of the groove over that of the body.
    by_sensor
        Whether the depth is what a displacement sensor has seen, the groove included, rather than that of the body.
    """
    return _sensed(run).beside_unseen_groove(end, share, by_sensor)


def _sensed(run: RawRun) -> Sensed:
    contact = run.manifest.described
    found = measurements_of(contact).sensed
    if found is None:
        raise ContactError(
            f"{run.id}: found a {contact.kind} run; expected a contact whose depth signal shows its wear; specify "
            "another run"
        )
    return found


_FAMILIES: dict[type[Contact], Measurements] = {
    SlidingPin: Measurements(
        worn=pin_on_disc.pin_on_disc_wear,
        single=lambda _, __: (),
        contradictions=worn_pair.contradictions,
        totals=None,
        total=lambda _, __: None,
        widest=lambda _: None,
        needed="a post-test measurement of the pin (wear depth, scar, wear volume, mass or profile)",
        sensed=Sensed(pin_on_disc.end_wear, pin_on_disc.groove_alone, pin_on_disc.beside_unseen_groove),
    ),
    TwinDisc: Measurements(
        worn=lambda run, defaults, interruption, _: twin_disc.twin_disc_wear(run, defaults, interruption),
        single=twin_disc.disc_measurements,
        contradictions=lambda _: (),
        totals=twin_disc.disc_totals,
        total=twin_disc.disc_end_wear,
        widest=twin_disc.widest_contact,
        needed="a post-test measurement of the crowned disc (wear depth, track width or wear volume)",
    ),
}
