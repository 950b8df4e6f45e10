"""Signs: compressive loads and friction in one direction are positive, and signals stated as reversed are inverted."""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.preprocessing import FrictionSign, PressingLoad, TurnOver
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.preprocessing.workbench import Bench, fewer

_LEAST_LOAD = 0.05
"""Share of the nominal load that a load measured upside down has at least."""
_ONE_WAY = 0.9
"""Share of the samples with friction that have the same sign in a test in one direction."""
_FRICTIONS: tuple[SignalName, ...] = ("friction_force", "friction_coefficient")


def pulls(load: Column, nominal: float) -> bool:
    """Return whether a load reads negative where it is on, by at least a twentieth of the nominal load."""
    some = fewer(load)
    if not len(some) or np.min(some) >= 0:
        return False
    on = some[np.abs(some) >= np.percentile(np.abs(some), 95) / 2]
    return bool(np.median(on) < -_LEAST_LOAD * nominal)


def turn_load(bench: Bench, _: PressingLoad) -> None:
    """Turn a load over that reads negative where it is on."""
    load = bench.measured("normal_force")
    if load is not None and pulls(load, bench.manifest.conditions.normal_load.value):
        bench.put("normal_force", -load, "sign reversed", "negative under load", factor=-1.0)


def turn_friction(bench: Bench, _: FrictionSign) -> None:
    """Turn friction over that reads negative throughout a test in one direction."""
    if bench.manifest.conditions.stroke is not None:
        return
    for name in _FRICTIONS:
        friction = bench.measured(name)
        if friction is not None and _is_negative(friction):
            bench.put(name, -friction, "sign reversed", "negative in a unidirectional test", factor=-1.0)


def turn_over(bench: Bench, step: TurnOver) -> None:
    """Turn over what the recipe names, where it was measured."""
    for name in dict.fromkeys(step.signals):
        values = bench.measured(name)
        if values is not None:
            bench.put(name, -values, "sign reversed", "the recipe states that its sign is reversed", factor=-1.0)
        elif name in bench.columns and bench.origins[name] != "measured":
            bench.leave(name, "sign not reversed, since it was not measured", bench.origins[name])


def _is_negative(friction: Column) -> bool:
    some = fewer(friction)
    if not len(some) or not np.median(some) < 0:
        return False
    rubbing = some[np.abs(some) > 0.2 * np.median(np.abs(some))]
    return bool(np.mean(rubbing < 0) >= _ONE_WAY)
