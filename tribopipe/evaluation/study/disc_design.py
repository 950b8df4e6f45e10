"""Experimental design for two discs: what more rotations, replicates, or a better known input would do for each k_D.

To first order on the run as it would be: the law with the k_D found, volumes as uncertain relative to themselves and
depths and widths as uncertain as they are.
"""

from collections.abc import Collection
from dataclasses import replace
from functools import cache, partial

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.contacts.inputs import Input
from tribopipe.documents.contact import DISCS
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.study.design import half_width, levers, replicates, shortest
from tribopipe.evaluation.study.discs import posed_discs
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.wear.measurement_fit import measurement_budgets
from tribopipe.evaluation.wear.measurement_problem import MeasurementProblem
from tribopipe.physics.laws import law_named
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.test_design import Design
from tribopipe.results.wear_fit import spoken


def design_discs(
    member: Member,
    law: LawName,
    wanted: float,
    recipe: Recipe,
    shared: Collection[str] = (),
    scatter: tuple[float | None, ...] = (None, None),
) -> tuple[Design, ...]:
    """Say for each disc what it takes to know its k_D to ``wanted``, the half width of its 95 % interval over k_D.

    ``shared`` inputs are off by the same error in all replicates; ``scatter`` is that of each k_D between runs.
    """
    if not wanted > 0:
        raise FitError(f"plan: found a wanted interval of {wanted:g}; expected one above zero, such as '10 %'")
    run = posed_discs(member, law, recipe)
    common = {name.replace("_", " ") for name in (*shared, *law_named(law).inputs())}

    @cache
    def widths(length: float) -> list[float]:
        longer = at_rotations(run.problem, run.coefficients, length)
        return [half_width(lines) for lines in measurement_budgets(longer, run.coefficients)]

    def width_of(place: int, length: float) -> float:
        return widths(length)[place]

    designs = []
    for place, lines in enumerate(measurement_budgets(run.problem, run.coefficients)):
        now, by_shared = half_width(lines), half_width([line for line in lines if line.name in common])
        length, by_distance = shortest(partial(width_of, place), wanted)
        turns = None if length is None else length * float(run.problem.places[-1])
        known = scatter[place]
        designs.append(
            Design(
                id=member.id,
                model=law,
                of=f"k_D of the {spoken(DISCS[place])}",
                half_width=now,
                wanted=wanted,
                levers=tuple(levers(lines)),
                rotations=None if turns is None else Quantity(value=turns, unit="1"),
                by_distance=by_distance,
                replicates=replicates(now, by_shared, COVERAGE_FACTOR * (known or 0.0), wanted),
                by_replicates=by_shared,
                scatter=known,
            )
        )
    return tuple(designs)


def at_rotations(problem: MeasurementProblem, found: Column, length: float) -> MeasurementProblem:
    """Return the problem that a test of ``length`` times the rotations would pose if the law held exactly.

    Raises ``ContactError`` where the crown would be worn away.
    """
    longer = replace(
        problem,
        measurements=tuple(replace(one, rotations=one.rotations * length) for one in problem.measurements),
    )
    inputs = dict(problem.inputs)
    for one, value in zip(longer.measurements, longer.modelled(found, problem.values), strict=True):
        given = problem.inputs[one.name]
        scale = float(value) / one.quantity.value if one.what == "wear_volume" and one.quantity.value else 1.0
        quantity = Quantity(value=float(value), unit=one.quantity.unit, standard_uncertainty=given.spread * scale)
        inputs[one.name] = Input(quantity, given.source)
    return replace(longer, inputs=inputs)
