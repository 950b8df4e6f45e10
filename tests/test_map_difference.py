"""Two height maps of one place are registered and subtracted: volume, uncertainty, refusals, and k_D of a run."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from end_value_runs import described, run_of
from map_pairs import MapPair
from pydantic import ValidationError
from test_tip_maps import RUN, points

from tribopipe.archive.store import Archive
from tribopipe.base.errors import FitError, ReaderError
from tribopipe.documents.manifest import ProfileSource
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import DefaultUncertainty
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.measurements.map_difference import map_difference
from tribopipe.evaluation.measurements.pin_on_disc import pin_on_disc_wear
from tribopipe.evaluation.measurements.tip_map import volume_below_sphere
from tribopipe.readers.harmonize import read_run

BOTH = {"file": "after.csv", "before": "before.csv"}
PAIRS = {
    "ball": MapPair(),
    "polished ball": MapPair(rough=1e-9, noise=2e-9, form=0.0),
    "rotated": MapPair(rotation=0.03),
    "other distance between points": MapPair(coarser=1.4),
    "much larger distance between points": MapPair(coarser=2.5),
    "many pixels off": MapPair(shift=(-152e-6, 90e-6), off=(0.0, 0.0), scar=0.3e-3),
    "spike": MapPair(debris=5e-6),
    "missing pixels": MapPair(missing=0.05),
    "groove within the map": MapPair(body="disc", depth=1e-6, whole=True),
    "groove on a polished disc": MapPair(body="disc", depth=1e-6, whole=True, rough=5e-9, form=0.0),
    "transfer": MapPair(body="disc", depth=-1e-6, whole=True),
    "flat pin in its holder": MapPair(body="pin", depth=2e-6, scar=0.6e-3, form=0.2e-6),
}
ON_A_BALL = {name for name, pair in PAIRS.items() if pair.body == "ball"}


IN_EVERY_RUN = {"ball", "groove on a polished disc"}


@pytest.mark.parametrize(
    "name", [name if name in IN_EVERY_RUN else pytest.param(name, marks=pytest.mark.slow) for name in PAIRS]
)
def test_volume_is_that_of_the_simulated_scar(name):
    pair = PAIRS[name]
    found = map_difference(*pair.maps())
    volume = found.volume()
    assert abs(volume.value - pair.volume) <= 3 * volume.standard_uncertainty
    assert volume.standard_uncertainty < (0.001 if name in ON_A_BALL else 0.06) * abs(pair.volume)
    assert found.shift == pytest.approx(pair.shift, abs=2.5e-6)
    assert found.rotation == pytest.approx(pair.rotation, abs=1e-3)


@pytest.mark.slow
def test_groove_through_a_polished_map_is_no_other_place():
    """Without roughness the shift is unknown; it must not be sought where the maps no longer show the groove."""
    pair = MapPair(body="disc", depth=1e-6, scar=0.3e-3, rough=5e-9, form=0.0)
    for seed in range(2):
        found = map_difference(*replace(pair, seed=seed).maps())
        assert found.reaches_edge
        assert np.count_nonzero(found.changed) == pytest.approx(0.3 * found.changed.size, rel=0.15)


def within(found, true, share=0.02):
    return abs(found.value - true) <= share * abs(true)


@pytest.mark.parametrize("hole", [40e-6, 90e-6])
def test_heights_missing_in_the_scar_make_the_volume_uncertain(hole):
    pair = MapPair()
    after, before = pair.maps()
    kept = [np.hypot(line.position - pair.off[0], line.across - pair.off[1]) > hole for line in after]
    after = [
        replace(line, position=line.position[one], height=line.height[one])
        for line, one in zip(after, kept, strict=True)
    ]
    volume = map_difference(after, before).volume()
    assert abs(volume.value - pair.volume) <= 2 * volume.standard_uncertainty < 0.15 * pair.volume


@pytest.mark.slow
def test_form_of_the_ball_is_not_counted_as_wear():
    pair = MapPair(off=(0.0, 0.0), shift=(21e-6, -13e-6), scar=0.3e-3, form=0.3e-6)
    after, before = pair.maps()
    found = map_difference(after, before).volume()
    alone = volume_below_sphere(after, Quantity(value=pair.radius, unit="m", standard_uncertainty=1e-5)).volume
    assert abs(found.value / pair.volume - 1) < 0.01
    assert abs(alone.value / pair.volume - 1) > 0.05


@pytest.mark.slow
def test_intervals_cover_the_volume():
    covered, errors = [], []
    kinds = ("ball", "polished ball", "groove within the map", "transfer")
    for seed in range(2000, 2016):
        kind = PAIRS[kinds[seed % len(kinds)]]
        pair = replace(kind, seed=seed, points=81, lines=71)
        found = map_difference(*pair.maps()).volume()
        covered.append(abs(found.value - pair.volume) <= 1.96 * found.standard_uncertainty)
        errors.append(abs(found.value / pair.volume - 1))
    assert np.mean(covered) >= 0.9
    assert max(errors) < 0.02


@pytest.mark.slow
def test_section_of_a_track_is_that_of_the_simulated_groove():
    pair = MapPair(body="disc", depth=1e-6, scar=0.3e-3)
    after, before = pair.maps()
    run = pair_run(after, before, body="disc", conditions={"track_radius": "8 mm"})
    (way,) = pin_on_disc_wear(run, DefaultUncertainty()).bodies["disc"]
    assert way.name == "disc_profile_difference"
    assert within(way.volume, 2 * math.pi * 8e-3 * pair.section)
    assert way.depth.value == pytest.approx(1e-6, rel=0.05)


def pair_run(after, before, body="pin", shape="spherical", conditions=None):
    key = f"end_values.{body}_profile"
    lines = {f"{key}[{number}]": line for number, line in enumerate(after)}
    lines |= {f"{key}.before[{number}]": line for number, line in enumerate(before)}
    return run_of(described(shape, conditions, **{f"{body}_profile": BOTH}), lines)


@pytest.mark.slow
@pytest.mark.parametrize("shape", ["spherical", "truncated-sphere", "flat"])
def test_volume_of_a_pin_of_any_shape_follows_from_both_maps(shape):
    pair = PAIRS["flat pin in its holder"] if shape == "flat" else PAIRS["ball"]
    run = pair_run(*pair.maps(), shape=shape)
    (way,) = pin_on_disc_wear(run, DefaultUncertainty()).bodies["pin"]
    assert way.name == "pin_height_map_difference"
    assert within(way.volume, pair.volume)
    assert [one.code for one in check_run(run) if one.where == "end_values.pin_profile"] == []


def elsewhere(pair):
    return MapPair(seed=77, form=4e-6, off=(0.2e-3, 0.1e-3), scar=pair.scar).maps()[1]


BALL = MapPair()


def another(form):
    return MapPair(seed=77, form=form, scar=BALL.scar).maps()[1]


REFUSED = {
    "another ball": (BALL.maps()[0], another(BALL.form), "found surroundings that differ by"),
    "another form": (BALL.maps()[0], another(2 * BALL.form), "found surroundings that differ by"),
    "same": (BALL.maps()[0], BALL.maps()[0], "found identical maps"),
    "other place": (BALL.maps()[0], elsewhere(BALL), "surroundings that differ"),
    "other unit": (
        BALL.maps()[0],
        [replace(one, position=0.1 * one.position, across=0.1 * one.across) for one in BALL.maps()[1]],
        "found that the map before the test shows",
    ),
    "no wear": (MapPair(body="disc").maps()[0], MapPair(body="disc").maps()[1], "found no change"),
    "face alone": (
        MapPair(body="pin", depth=2e-6, scar=4e-3).maps()[0],
        MapPair(body="pin", depth=2e-6, scar=4e-3).maps()[1],
        "found no change",
    ),
    "scar at the edge": (*MapPair(off=(0.35e-3, 0.0), scar=0.4e-3).maps(), "reaches the edge"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", REFUSED)
def test_maps_that_give_no_volume_are_refused_in_one_sentence(name):
    after, before, message = REFUSED[name]
    with pytest.raises(FitError, match=message) as refused:
        map_difference(after, before).volume()
    assert str(refused.value).startswith("map: found ")
    assert "; expected " in str(refused.value)


def test_single_line_is_no_map():
    after, before = BALL.maps()
    run = pair_run(after, before[:1])
    with pytest.raises(FitError, match=r"before: map: found 1 profiles that are no height map; expected at least 8"):
        pin_on_disc_wear(run, DefaultUncertainty())
    (note,) = [one for one in check_run(run) if one.code == "no_wear_in_profile"]
    assert note.where == "end_values.pin_profile"
    assert note.message.startswith("found 1 profiles")


@pytest.mark.parametrize(
    ("end", "message"),
    [
        ({"pin_profile": {"file": "tip.csv", "before": "./tip.csv"}}, "which is also the file of the worn surface"),
        ({"pin_profile": [BOTH, {"file": "b.csv"}]}, "found before for 1 of 2 files"),
        ({"curved_disc_profile": BOTH}, "before the test of a rolling disc"),
    ],
)
def test_keys_that_do_not_fit_are_refused(end, message):
    with pytest.raises(ValidationError, match=message):
        described(**end)


# --- files ---


def written(tmp_path, pair, head="x [mm],y [mm],z [um]"):
    folder = tmp_path / "mapped"
    folder.mkdir()
    named = 'pin_profile = { file = "after.csv", before = "before.csv" }'
    (folder / "run.toml").write_text(RUN.replace('pin_profile = { file = "tip.csv" }', named), encoding="utf-8")
    signals = "".join(f"{t:.1f},{2 + 0.02 * math.sin(t):.4f}\n" for t in np.linspace(0, 5000, 501))
    (folder / "signals.csv").write_text("t,F\n" + signals, encoding="utf-8")
    for name, lines in zip(("after.csv", "before.csv"), pair.maps(), strict=True):
        text = head if name == "before.csv" else "x [mm],y [mm],z [um]"
        (folder / name).write_text(f"{text}\n{points(lines)}", encoding="utf-8")
    return folder


def test_copy_of_the_map_is_refused(tmp_path):
    folder = written(tmp_path, BALL)
    (folder / "before.csv").write_bytes((folder / "after.csv").read_bytes())
    with pytest.raises(ReaderError, match=r"before\.csv is a copy of after\.csv; expected the map measured before"):
        read_run(folder)


def test_map_before_needs_units(tmp_path):
    with pytest.raises(ReaderError, match=r"before\.csv.*found no unit"):
        read_run(written(tmp_path, BALL, "x,y,z"))


def test_source_knows_its_map_before():
    assert ProfileSource(file="a.csv").before is None


@pytest.mark.slow
def test_k_d_of_the_pin_follows_from_both_maps_in_its_run_folder(tmp_path, run_cli, few_draws):  # noqa: ARG001
    written(tmp_path, BALL)
    done = run_cli("process", "mapped", "--json", cwd=tmp_path)
    assert done.exit_code == 0, done.stderr
    (run,) = json.loads(done.stdout)["runs"]
    pin = run["specific_wear"]["pin"]
    assert pin["volume_by"] == "pin_height_map_difference"
    assert pin["volume"]["value"] == pytest.approx(BALL.volume, rel=0.01)
    assert run_cli("verify", cwd=tmp_path).exit_code == 0
    assert run_cli("reproduce", cwd=tmp_path).exit_code == 0
    assert run_cli("show", "mapped", "--plot", cwd=tmp_path).exit_code == 0
    report = run_cli("report", "mapped", cwd=tmp_path)
    assert report.exit_code == 0, report.stderr
    shown = (tmp_path / "mapped.html").read_text(encoding="utf-8")
    assert "from the height map difference" in shown
    assert "before the test: before.csv" in shown
    again = Archive(tmp_path / "archive").raw("mapped").profiles
    assert again["end_values.pin_profile.before[0]"].scan == "before.csv"
