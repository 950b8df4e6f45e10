"""Two discs: from what run.toml states of them to the course of their wear."""

from tribopipe.base.arrays import Values
from tribopipe.documents.contact import TwinDisc
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.slip import slip
from tribopipe.physics.conventions import DistanceConvention
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.twin_disc import DiscPair


def disc_pair(contact: TwinDisc, values: Values, distance: DistanceConvention) -> DiscPair:
    """Build two discs from values of ``nominal_values``' names."""
    curved, flat = contact.curved_disc, contact.flat_disc
    modulus = contact_modulus(
        pin_modulus=values["curved_modulus"],
        pin_ratio=curved.poisson_ratio.value,
        disc_modulus=values["flat_modulus"],
        disc_ratio=flat.poisson_ratio.value,
    )
    return DiscPair(
        normal_load=values["normal_load"],
        crown_radius=values["crown_radius"],
        curved_radius=values["curved_radius"],
        flat_radius=values["flat_radius"],
        modulus=modulus,
        slip=values["slip"],
        distance=distance,
    )


def nominal_values(manifest: RunManifest) -> dict[str, float]:
    """Return what run.toml says of two discs, SI."""
    discs = manifest.twin_disc
    return {
        "normal_load": manifest.conditions.normal_load.value,
        "crown_radius": discs.curved_disc.crown_radius.value,
        "curved_radius": discs.curved_disc.rolling_radius.value,
        "flat_radius": discs.flat_disc.rolling_radius.value,
        "curved_modulus": discs.curved_disc.youngs_modulus.value,
        "flat_modulus": discs.flat_disc.youngs_modulus.value,
        "slip": slip(manifest).value,
    }
