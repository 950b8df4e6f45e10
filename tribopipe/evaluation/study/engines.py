"""k_D of one run by both wear engines, from the same data: whether the way of spreading the load matters.

The GIWM assumes uniform pressure over the contact. The true pressure in the middle is 1.5 times the mean at the start,
and becomes even as the pin wears (tribopipe.physics.local.excess), so that the GIWM's k_D is biased while wear is
shallow against the elastic approach. Where the two k_D differ by more than their standard uncertainty, the local one
is to be trusted.
"""

from dataclasses import replace

import numpy as np

from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import wear_coefficient
from tribopipe.evaluation.study.member import RunDraws
from tribopipe.evaluation.wear.draws import solve_draws
from tribopipe.physics.conventions import WearEngine
from tribopipe.results.agreement import EngineComparison

_DRAWS = 1_000
"""Draws that give a standard uncertainty to about 2 %."""


def compare_engines(draws: RunDraws) -> EngineComparison | None:
    """Fit a run by both engines on the same draws; none unless the pin is a whole sphere.

    A flat pin is worn alike by both, and a truncated sphere by the GIWM only.
    """
    problem = draws.run.problem
    if problem.contact.pin.shape != "spherical":
        return None
    some = draws.kept(np.arange(len(draws.coefficient)) < _DRAWS)
    found = {}
    engines: tuple[WearEngine, ...] = ("giwm", "local")
    for engine in engines:
        posed = replace(problem, engine=engine)
        drawn = solve_draws(posed, some.values, some.noise) if engine != problem.engine else some.coefficient
        found[engine] = wear_coefficient(posed.coefficient(), float(np.nanstd(drawn)))
    giwm, local = found["giwm"], found["local"]
    uncertain = max(giwm.standard_uncertainty or 0.0, local.standard_uncertainty or 0.0)
    trusted: WearEngine | None = "local" if abs(local.value - giwm.value) > uncertain else None
    return EngineComparison(giwm=giwm, local=local, trusted=trusted)


def engine_notes(compared: EngineComparison | None) -> tuple[str, ...]:
    """Report where the two differ, and which to trust."""
    if compared is None or compared.trusted is None:
        return ()
    giwm, local = (k.shown(WEAR_COEFFICIENT) for k in (compared.giwm, compared.local))
    return (
        f"k_D is {local} with local pressure and {giwm} with the GIWM, a difference of more than their standard "
        "uncertainty; use the local one: the GIWM assumes uniform pressure, while the pressure in the middle is 1.5 "
        "times the mean at the start, and wear is still small compared with the elastic approach",
    )
