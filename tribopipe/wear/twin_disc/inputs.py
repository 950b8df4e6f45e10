"""Everything uncertain that the wear of two discs depends on."""

from tribopipe.motion import slip
from tribopipe.records.manifest import RunManifest, TwinDisc
from tribopipe.records.quantity import Quantity
from tribopipe.records.recipe import Recipe
from tribopipe.wear.inputs import DISC_INPUTS, Input, relative_input


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


def run_inputs(manifest: RunManifest, recipe: Recipe) -> dict[str, Input]:
    """Collect the inputs of a run."""
    return disc_inputs(manifest.twin_disc, manifest.conditions.normal_load, slip(manifest), recipe)
