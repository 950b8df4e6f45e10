"""Post-test measurements are named in words, whatever the contact."""

import pytest

from tribopipe.documents.contact_kinds import spoken
from tribopipe.results.specific_wear import measured_quantities, measured_quantity


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("pin_scar_diameter", "scar diameter"),
        ("curved_disc_wear_volume", "wear volume"),
        ("drum_profile", "profile"),
        ("pin_height_map", "height map"),
        ("pin_mass_loss", "mass loss"),
    ],
)
def test_quantity_of_a_key(key, words):
    assert measured_quantity(key) == words


@pytest.mark.parametrize(
    ("anchor", "words"),
    [
        ("pin_wear_depth", "wear depth of the pin"),
        ("pin_height_map", "height map of the pin"),
        ("pin_scar_diameter + drum_wear_depth", "scar diameter of the pin and wear depth of the drum"),
        ("curved_disc_track_width", "track width of the crowned disc"),
    ],
)
def test_anchor_of_a_drift_correction(anchor, words):
    assert measured_quantities(anchor) == words


@pytest.mark.parametrize(
    ("key", "words"), [("curved_disc", "crowned disc"), ("curved_disc_speed", "crowned disc speed"), ("pin", "pin")]
)
def test_body_in_words(key, words):
    assert spoken(key) == words
