"""Friction coefficients without a load to speak of: a quotient of two noises, without information on friction."""

import numpy as np

from tribopipe.documents.preprocessing import UnloadedFriction
from tribopipe.evaluation.preprocessing.masking import MOST_FRICTION
from tribopipe.evaluation.preprocessing.workbench import Bench


def mask_unloaded_friction(bench: Bench, step: UnloadedFriction) -> None:
    """Mask μ where the measured load is below a share of the nominal one, and where it is out of all reason.

    A load that never reaches half the nominal one is no measure of whether anything pressed: one of both is wrong.
    """
    mu, load, nominal = (
        bench.columns.get("friction_coefficient"),
        bench.measured("normal_force"),
        bench.manifest.conditions.normal_load,
    )
    if mu is None:
        return
    if load is not None and step.share and np.nanmax(load) >= nominal.value / 2:
        what = f"load below {step.share:.3g} of the nominal {nominal.shown()}"
        bench.mask("friction_coefficient", load < step.share * nominal.value, what, "no load")
        mu = bench.columns.get("friction_coefficient", mu)
    bench.mask("friction_coefficient", np.abs(mu) > MOST_FRICTION, "beyond ±10", "physically impossible")
