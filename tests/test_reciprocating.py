"""A pin or ball that slides there and back on a flat: its keys, its path, and a ball in the place of a pin."""

import json

import numpy as np
import pytest
from conftest import MANIFEST

from tribopipe.base.errors import ManifestError
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.record import read_document
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import predict_wear, wear_scenario
from tribopipe.evaluation.wear.scenario import given_wear
from tribopipe.results.run import RawRun

STEEL = {"material": "100Cr6", "youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
MOTION = {"normal_load": "10 N", "stroke": "20 mm", "frequency": "1 Hz"}


def to_and_fro(**changes: object) -> dict:
    """Return a run.toml as a document."""
    contact = {"kind": "reciprocating", "ball": {"diameter": "6 mm", **STEEL}, "flat": STEEL}
    return {**MANIFEST, "contact": contact, "conditions": MOTION, "end_values": {}, **changes}


def read(document: dict) -> RunManifest:
    return read_document(document, RunManifest, where="run.toml")


def test_a_ball_is_a_spherical_pin_of_half_its_diameter():
    ball = {
        "value": "6 mm",
        "standard_uncertainty": "2 um",
    }
    contact = {"kind": "reciprocating", "ball": {"diameter": ball, **STEEL}, "flat": STEEL}
    run = read(to_and_fro(contact=contact, end_values={"ball_scar_length": "1 mm", "flat_wear_depth": "10 um"}))
    assert (run.contact.pin.shape, run.contact.pin.radius.value) == ("spherical", pytest.approx(3e-3))
    assert run.contact.pin.radius.standard_uncertainty == pytest.approx(1e-6)
    assert run.contact.pin.diameter.value == pytest.approx(6e-3)
    assert run.end_values.pin_scar_length.value == pytest.approx(1e-3)
    assert run.end_values.disc_wear_depth.value == pytest.approx(10e-6)
    again = RunManifest.model_validate(json.loads(run.model_dump_json(by_alias=True)))
    assert again == run


def test_a_ball_stands_for_the_pin_on_a_disc_as_well():
    contact = {"kind": "pin-on-disc", "ball": {"diameter": "6 mm", **STEEL}, "disc": STEEL}
    assert read({**MANIFEST, "contact": contact, "end_values": {}}).contact.pin.radius.value == pytest.approx(3e-3)


def test_both_wear_as_published():
    """The check value of a reciprocating ball, L = stroke (mm): 10 N, 400 m, k 2e-8 and 5e-8 mm³/(N·mm).

    The stroke is the length of the track between soft bodies alone (tests/test_stroke_ends.py).
    """
    soft = {**STEEL, "youngs_modulus": "1 kPa"}
    run = read(to_and_fro(contact={"kind": "reciprocating", "ball": {"diameter": "6 mm", **soft}, "flat": soft}))
    known = {"ball": Quantity(value=2e-14, unit="m^2/N"), "flat": Quantity(value=5e-14, unit="m^2/N")}
    (point,) = predict_wear(wear_scenario(run, given_wear(run.described, known, Recipe())), [400.0]).prediction
    assert point.bodies["ball"].wear_depth.value == pytest.approx(0.0893282519e-3, rel=1e-6)
    assert point.bodies["flat"].wear_depth.value == pytest.approx(0.0108507144e-3, rel=1e-6)
    assert point.contact.half_width.value == pytest.approx(0.768789941e-3, rel=1e-6)
    assert point.contact.half_length.value == pytest.approx(0.726629187e-3, rel=1e-6)


def strokes(count: int, ratio: float, stroke: float, radius: float) -> tuple[float, float]:
    """Return the depths of ball and groove, m, by cells of both that meet in the middle slice, stroke by stroke.

    The pressure of a slice is what keeps its surfaces together: in each step of the approach, cells that overlap share
    the overlap as k_1·ΔS to k_2·ΔS/L.
    """
    z = (np.arange(401) - 200) * 5e-6
    ball, groove, dz = z**2 / (2 * radius), 0.0, z[1] - z[0]
    for approach in np.linspace(0, 40e-6, count):
        overlap = np.maximum(approach - groove - ball, 0.0)
        # All cells of the ball that overlap pass each cell of the groove once: it wears by their sum over the path.
        share = ratio * np.sum(overlap > 0) * dz / stroke
        ball = ball + overlap / (1 + share)
        groove += ratio * float(np.sum(overlap / (1 + share))) * dz / stroke
    return float(ball[200]), groove


@pytest.mark.slow
def test_depths_in_the_middle_are_those_of_strokes_counted_one_by_one():
    ratio, stroke, radius = 60.0, 0.02, 3e-3
    ball, groove = strokes(4000, ratio, stroke, radius)
    run = read(to_and_fro())
    k = 1e-14
    known = {"ball": Quantity(value=k, unit="m^2/N"), "flat": Quantity(value=ratio * k, unit="m^2/N")}
    scenario = wear_scenario(run, given_wear(run.described, known, Recipe()))
    place = scenario.place_at(ball)
    (point,) = predict_wear(scenario, [float(place)]).prediction
    assert point.bodies["flat"].wear_depth.value == pytest.approx(groove, rel=0.01)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"conditions": {"normal_load": "10 N"}}, r"conditions\.stroke: missing"),
        (
            {"conditions": {"normal_load": "10 N", "track_radius": "5 mm"}},
            r"conditions\.track_radius: found a key of circular sliding in a reciprocating run",
        ),
        (
            {"contact": {"kind": "reciprocating", "ball": STEEL, "flat": STEEL}},
            r"contact\.ball\.diameter: missing",
        ),
        (
            {"contact": {"kind": "reciprocating", "ball": {"diameter": "6", **STEEL}, "flat": STEEL}},
            r"contact\.ball\.diameter: found",
        ),
        (
            {"contact": {"kind": "reciprocating", "ball": {"diameter": "6 mm", "radius": "3 mm"}, "flat": STEEL}},
            r"contact\.ball: found radius, a key that does not apply to a ball; expected diameter; remove radius",
        ),
        (
            {"contact": {"kind": "reciprocating", "ball": {"radius": "3 mm", **STEEL}, "flat": STEEL}},
            r"contact\.ball: found radius, .*; enter twice the radius as diameter",
        ),
        (
            {"contact": {"kind": "reciprocating", "ball": {"diameter": "6 mm"}, "pin": STEEL, "flat": STEEL}},
            "contact: ball: found a ball in addition to a pin",
        ),
        ({"end_values": {"ball_scar_length": "1 mm", "pin_scar_length": "1 mm"}}, "found this key in addition to"),
        ({"end_values": {"flat_track_widht": "1 mm"}}, r"flat_track_widht: unknown key; .*'flat_track_width'"),
    ],
)
def test_what_does_not_fit_is_refused_in_the_names_of_the_test(changes, words):
    with pytest.raises(ManifestError, match=words):
        read(to_and_fro(**changes))


def test_the_same_as_a_pin_on_a_disc_with_a_stroke():
    distance = np.linspace(0.0, 400.0, 50)
    columns = {"time": distance / 0.04, "sliding_distance": distance}
    found = []
    for kind, other in (("reciprocating", "flat"), ("pin-on-disc", "disc")):
        contact = {"kind": kind, "ball": {"diameter": "6 mm", **STEEL}, other: STEEL}
        ends = {"ball_scar_length": "1.45 mm", f"{other}_track_width": "1.54 mm"}
        manifest = read(to_and_fro(contact=contact, end_values=ends))
        run = RawRun(manifest, columns, dict.fromkeys(columns, "measured"), {}, {}, ())
        fit = fit_wear(run, "archard", recipe=Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0)))
        found.append([body.wear_coefficient for body in fit.bodies.values()])
    assert found[0] == found[1]
    assert len(found[0]) == 2


@pytest.mark.parametrize("kind", ["reciprocating", "block-on-ring", "four-ball"])
def test_cross_sections_of_the_track_have_the_name_of_the_body(kind):
    bodies, other = {
        "reciprocating": ({"ball": {"diameter": "6 mm", **STEEL}, "flat": STEEL}, "flat"),
        "block-on-ring": ({"block": {"width": "6 mm", **STEEL}, "ring": {"radius": "17 mm", **STEEL}}, "ring"),
        "four-ball": ({"ball": {"diameter": "12.7 mm", **STEEL}}, "top_ball"),
    }[kind]
    document = to_and_fro(contact={"kind": kind, **bodies}, end_values={f"{other}_track_area": "480 um^2"})
    if kind != "reciprocating":
        document["conditions"] = {"normal_load": "10 N", "sliding_speed": "0.1 m/s"}
    run = read(document)
    assert run.end_values.disc_track_area.value == pytest.approx(480e-12)
    assert f"{other}_track_area" in run.model_dump(mode="json", by_alias=True, exclude_none=True)["end_values"]
