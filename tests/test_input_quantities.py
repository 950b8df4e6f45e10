"""Inputs of k_D have the labels that a metrologist would write, and the units in which people read them."""

import pytest

from tribopipe.documents.quantity import Quantity
from tribopipe.results.input_quantities import input_label, shown_unit


@pytest.mark.parametrize(
    ("name", "label"),
    [
        ("normal load", "normal load"),
        ("pin modulus", "Young's modulus of the pin"),
        ("curved_modulus", "Young's modulus of the crowned disc"),
        ("depth scale", "scale of the depth sensor"),
        ("pin end value", "post-test measurement of the pin"),
        ("drum end value", "post-test measurement of the drum"),
        ("pin value at interruption 2", "measurement of the pin at interruption 2"),
        ("curved disc wear volume", "wear volume of the crowned disc"),
        ("flat disc track width at interruption 1", "track width of the cylindrical disc at interruption 1"),
        ("ball unseen groove", "unmeasured groove in the counterbody of the ball"),
        ("law running in length", "law parameter running in length"),
        ("friction fit", "fitted friction coefficient"),
        ("noise of the depth signal", "noise of the depth signal"),
    ],
)
def test_label_of_an_input(name, label):
    assert input_label(name) == label


@pytest.mark.parametrize(
    ("name", "si", "unit"),
    [
        ("pin_end_value", "m", "um"),
        ("pin_end_value", "m^3", "mm^3"),
        ("pin_value_at_interruption_1", "m", "um"),
        ("curved_disc_track_width_at_interruption_1", "m", "um"),
        ("normal_load", "N", "mN"),
        ("law_length", "m", None),
    ],
)
def test_unit_of_an_input_depends_on_what_was_measured(name, si, unit):
    assert shown_unit(name, Quantity(value=0.2, unit=si)) == unit
