"""Everything uncertain that the wear of two discs depends on."""

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.contact import TwinDisc
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.slip import slip
from tribopipe.evaluation.wear.inputs import DISC_INPUTS, Input, load_input, relative_input
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import WearLaw
from tribopipe.results.run import RawRun


def disc_inputs(contact: TwinDisc, normal_load: Quantity, nominal_slip: Quantity, recipe: Recipe) -> dict[str, Input]:
    """Collect load, radii, moduli and slip with the uncertainties stated, or else the recipe's defaults."""
    curved, flat, defaults = contact.curved_disc, contact.flat_disc, recipe.uncertainty
    stated = (
        normal_load,
        curved.crown_radius,
        curved.rolling_radius,
        flat.rolling_radius,
        curved.youngs_modulus,
        flat.youngs_modulus,
    )
    relative = (
        defaults.normal_load,
        defaults.crown_radius,
        defaults.rolling_radius,
        defaults.rolling_radius,
        defaults.youngs_modulus,
        defaults.youngs_modulus,
    )
    inputs = {
        name: relative_input(quantity, share)
        for name, quantity, share in zip(DISC_INPUTS, stated, relative, strict=True)
    }
    return inputs | {"slip": relative_input(nominal_slip, defaults.slip)}


def run_inputs(run: RawRun, recipe: Recipe) -> dict[str, Input]:
    """Collect the inputs of a run, the load as it was recorded."""
    load = load_input(run, recipe)
    return disc_inputs(run.manifest.twin_disc, load.quantity, slip(run.manifest), recipe) | {"normal_load": load}


def effective_rotations(
    law: WearLaw, rotations: Column, slip_per_rotation: float, friction: FrictionPath | None
) -> Column:
    """Return the rotations in which Archard's law would wear as much: S over what slips in one, m."""
    slipped = rotations * slip_per_rotation
    effective = law.effective_distance(slipped, friction)
    # By the share of it Archard's law keeps every digit, and no slip is no wear.
    return rotations * np.divide(effective, slipped, out=np.ones_like(effective), where=slipped != 0)
