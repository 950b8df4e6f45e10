"""Experimental design: what a longer test, replicates, or a better known input would do for each k_D.

First-order (JCGM 100:2008, 5.1.2) on the run as it would be: the law with the k_D found (``longer_tests``).
"""

import math
from collections.abc import Callable, Collection, Sequence
from functools import cache, partial

import numpy as np

from tribopipe.base.errors import ContactError, FitError
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.study.evaluate import StudiedRun
from tribopipe.evaluation.wear.uncertainty import relative_uncertainty
from tribopipe.physics.laws import law_named
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.study import SCATTER, Design, Lever
from tribopipe.results.wear_fit import Contribution

_LENGTHS = np.geomspace(1.0, 100.0, 61)
"""Test lengths looked at, in lengths of the run."""


def designs(
    run: StudiedRun,
    law: LawName,
    wanted: float,
    shared: Collection[str] = (),
    scatter: Sequence[float | None] = (),
) -> tuple[Design, ...]:
    """Report for each body what it takes to know its k_D to ``wanted``, the half width of its 95 % interval over k_D.

    ``shared`` inputs are off by the same error in all replicates; ``scatter`` is that of each k_D between runs, over
    k_D. k_D of a test, however long it is, is off from that of the materials by this scatter, that of n tests by its
    nth part in square.
    """
    if not wanted > 0:
        raise FitError(f"plan: --interval: found {wanted:g}; expected a positive value, such as '10 %'")
    contact = run.member.corrected.run.manifest.described
    common = {name.replace("_", " ") for name in (*run.may_share(tuple(shared)), *law_named(law).inputs())}

    @cache
    def widths(length: float) -> list[float]:
        return [half_width(lines) for lines in run.budgets(length)]

    def width_of(place: int, own: float, between: float, length: float) -> float:
        # A test as long as the run is no better than the run, whose budget is that of its own samples.
        return math.hypot(widths(length)[place] * max(1.0, own / widths(1.0)[place]), between)

    found = []
    for place, (body, own) in enumerate(zip(run.bodies, run.budgets(), strict=True)):
        known = dict(enumerate(scatter)).get(place)
        plan = Design(
            id=run.member.id,
            model=law,
            of=f"k_D of the {spoken(body)}" if len(run.bodies) > 1 or body != contact.fitted_bodies[0] else "k_D",
            wear_coefficient=_known(run, place, own),
            wanted=wanted,
            scatter=known,
        )
        if _above_zero(plan.wear_coefficient):
            lines = (*own, Contribution(name=SCATTER, source="fit", relative=known)) if known else own
            length, by_distance = shortest(
                partial(width_of, place, half_width(own), COVERAGE_FACTOR * (known or 0.0)), wanted
            )
            end = None if length is None else run.end.model_copy(update={"value": length * run.end.value})
            longer = {contact.progress.signal: end, "by_distance": by_distance}
            plan = plan.model_copy(update=longer | _as_long(lines, common, wanted, contact))
        found.append(plan)
    return tuple(found)


def _as_long(
    lines: Collection[Contribution], common: Collection[str], wanted: float, contact: Contact
) -> dict[str, object]:
    """Return what tests as long as this one give, by the budget of one and the names of what they share."""
    now, by_shared = half_width(lines), half_width([line for line in lines if line.name in common])
    return {
        "half_width": now,
        "levers": tuple(lever.model_copy(update={"name": contact.worded(lever.name)}) for lever in levers(lines)),
        "replicates": replicates(now, by_shared, wanted),
        "by_replicates": by_shared,
    }


def _known(run: StudiedRun, place: int, lines: Collection[Contribution]) -> Quantity:
    """Return k_D of a body by one test, without the scatter between runs."""
    spread = float(run.scale[place]) * half_width(lines) / COVERAGE_FACTOR
    return wear_coefficient(float(run.coefficients[place]), spread)


def _above_zero(coefficient: Quantity) -> bool:
    """Return whether its 95 % interval is; otherwise nothing is meant by an interval relative to it."""
    return coefficient.value > COVERAGE_FACTOR * coefficient.u_or_zero


def half_width(lines: Collection[Contribution]) -> float:
    """Return the half width of the 95 % interval of k_D over k_D, by a budget."""
    return COVERAGE_FACTOR * relative_uncertainty(lines)


def levers(lines: Collection[Contribution]) -> list[Lever]:
    """Return what each line of a budget costs, the most rewarding first."""
    variance = sum(line.relative**2 for line in lines)
    return [
        Lever(
            name=line.name,
            value=line.value,
            shown_in=line.shown_in,
            relative=abs(line.relative),
            share=line.relative**2 / variance,
            if_halved=COVERAGE_FACTOR * math.sqrt(variance - 0.75 * line.relative**2),
        )
        for line in sorted(lines, key=lambda line: -abs(line.relative))
    ]


def shortest(width_at: Callable[[float], float], wanted: float) -> tuple[float | None, float]:
    """Return the length of a test that does, in lengths of the run, and the least half width of any.

    ``width_at`` gives the half width; it raises ``ContactError`` where the specimen would be worn away.
    """
    best = math.inf
    before = (1.0, math.inf)
    for length in _LENGTHS.tolist():
        try:
            width = width_at(length)
        except ContactError:
            break
        best = min(best, width)
        if width <= wanted:
            return _between(before, (length, width), wanted), best
        before = (length, width)
    return None, best


def _between(before: tuple[float, float], after: tuple[float, float], wanted: float) -> float:
    """Return the length at which the half width is as wanted, by interpolation of logarithms."""
    (short, wide), (long, narrow) = before, after
    if not math.isfinite(wide):
        return long
    share = math.log(wide / wanted) / math.log(wide / narrow)
    return float(short * (long / short) ** share)


def replicates(now: float, shared: float, wanted: float) -> int | None:
    """Return how many tests like this one it takes; None if what they share is too much."""
    room = wanted**2 - shared**2
    if room <= 0:
        return None
    return max(1, math.ceil((now**2 - shared**2) / room - 1e-9))
