"""Rates from measurements in between: of each interval, and after running-in, with how often ± holds."""

from dataclasses import replace

import numpy as np
import pytest
from end_value_runs import DENSITY, described, run_of, si

from tribopipe.documents.manifest import RunManifest
from tribopipe.evaluation.checks.registry import check_run
from tribopipe.evaluation.measurements.specific_wear import specific_wear
from tribopipe.views.run_page import _specific_wear_section

END, STOPS, LOAD = 25e3, 12, 10.0
PLACES = np.linspace(END / STOPS, END, STOPS)
STEADY, BALANCE = 2e-15, 5e-9
"""m²/N, and kg: 5 µg."""


def lost(running_in, length=1500.0, places=PLACES):
    """Mass, kg, lost until each place: a straight line and what running-in took."""
    return DENSITY * (STEADY * LOAD * places + running_in * -np.expm1(-places / length))


def weighed(masses, places=PLACES, body="pin", load=None, spread=BALANCE):
    """A run weighed at each place, at its end last; without any depth signal."""
    manifest = described(
        "flat", conditions={"normal_load": si(LOAD, "N", 0.1)}, **{f"{body}_mass_loss": si(masses[-1], "kg", spread)}
    )
    document = manifest.model_dump(mode="json", by_alias=True, exclude_none=True)
    document["interruptions"] = [
        {"sliding_distance": si(place, "m"), f"{body}_mass_loss": si(mass, "kg", spread)}
        for place, mass in zip(places[:-1], masses[:-1], strict=True)
    ]
    run = run_of(RunManifest.model_validate(document))
    distance = np.linspace(0, places[-1], len(run))
    columns = {"time": distance / 0.4, "sliding_distance": distance}
    if load is not None:
        columns["normal_force"] = load(distance)
    return replace(run, columns=columns, origins=dict.fromkeys(columns, "measured"))


RAN_IN = 1.6 * STEADY * LOAD * END
"""Volume by running-in that makes the overall rate 2.6 times the steady one."""


@pytest.mark.parametrize("body", ["pin", "disc"])
def test_steady_rate_is_the_slope_after_running_in(body):
    found = specific_wear(weighed(lost(RAN_IN), body=body))
    wear = found.bodies[body]
    assert wear.specific_wear_rate.value == pytest.approx(2.6 * STEADY, rel=1e-3)
    assert wear.steady_rate.value == pytest.approx(STEADY, rel=0.02)
    assert abs(wear.steady_rate.value - STEADY) < 2 * wear.steady_rate.standard_uncertainty
    assert 0 < wear.steady_from.value < 20e3
    said = f"the overall wear rate of the {body} is 2.6 times its steady-state rate, because of running-in"
    assert said in found.notes


def test_each_interval_has_its_rate():
    intervals = specific_wear(weighed(lost(RAN_IN))).pin.intervals
    assert len(intervals) == STOPS
    assert [one.end.value for one in intervals] == pytest.approx(PLACES)
    volumes = np.diff(lost(RAN_IN), prepend=0.0) / DENSITY
    np.testing.assert_allclose([one.volume.value for one in intervals], volumes, rtol=1e-9)
    np.testing.assert_allclose(
        [one.specific_wear_rate.value for one in intervals], volumes / (LOAD * END / STOPS), rtol=1e-9
    )
    own = np.hypot(BALANCE, BALANCE) / DENSITY
    assert intervals[-1].volume.standard_uncertainty == pytest.approx(own, rel=1e-6)


def test_rate_without_running_in_is_steady_and_says_nothing():
    found = specific_wear(weighed(lost(0.0)))
    assert found.pin.steady_rate.value == pytest.approx(STEADY, rel=1e-6)
    assert found.pin.steady_from.value == 0
    assert not any("running-in" in note for note in found.notes)


def test_a_steady_rate_of_nothing_is_no_divisor():
    """Where wear stopped after running-in, the overall rate was said to be -4.6e+15 times the steady one."""
    (told,) = (note for note in specific_wear(weighed(np.full(STOPS, DENSITY * RAN_IN))).notes if "running-in" in note)
    assert told.startswith("the overall wear rate of the pin is clearly different from its steady-state rate, which")


@pytest.mark.slow
@pytest.mark.parametrize("ran_in", [0.0, 0.5 * RAN_IN, RAN_IN])
@pytest.mark.parametrize("scatter", [1.0, 5.0])
def test_intervals_of_the_steady_rate_hold_the_truth(ran_in, scatter):
    held, runs, rng = 0, 100, np.random.default_rng(11)
    for _ in range(runs):
        masses = lost(ran_in) + scatter * BALANCE * rng.standard_normal(STOPS)
        rate = specific_wear(weighed(masses * (1 + 0.005 * rng.standard_normal()))).pin.steady_rate
        held += abs(rate.value - STEADY) < 1.96 * rate.standard_uncertainty
    assert held / runs >= 0.93 - 2 * (0.95 * 0.05 / runs) ** 0.5


def test_recorded_load_counts_in_each_interval():
    run = weighed(lost(0.0), load=lambda distance: np.where(distance < END / 2, 5.0, 20.0))
    first, *_, last = specific_wear(run).pin.intervals
    assert first.specific_wear_rate.value == pytest.approx(2 * STEADY, rel=1e-3)
    assert last.specific_wear_rate.value == pytest.approx(STEADY / 2, rel=1e-3)


@pytest.mark.parametrize("share", [0.98, 0.4])
def test_load_channel_that_ends_early_leaves_the_rates_alone(share):
    run = weighed(lost(0.0), load=lambda distance: np.where(distance <= share * END, LOAD, np.nan))
    wear = specific_wear(run).pin
    rates = [one.specific_wear_rate.value for one in wear.intervals]
    np.testing.assert_allclose([*rates, wear.steady_rate.value], STEADY, rtol=1e-9)


def test_interval_without_load_has_no_rate():
    run = weighed(lost(0.0), load=lambda distance: np.where(distance < PLACES[2], LOAD, 0.0))
    intervals = specific_wear(run).pin.intervals
    assert [one.end.value for one in intervals] == pytest.approx(PLACES[:3].tolist())


def test_few_measurements_tell_intervals_but_no_steady_rate():
    wear = specific_wear(weighed(lost(RAN_IN)[:3], PLACES[:3])).pin
    assert (len(wear.intervals), wear.steady_rate) == (3, None)
    assert specific_wear(weighed(lost(RAN_IN)[:1], PLACES[:1])).pin.intervals == ()


def test_measurement_at_the_very_end_is_no_interval_of_its_own():
    places = np.append(PLACES[:4], PLACES[3])
    wear = specific_wear(weighed(lost(0.0, places=places), places)).pin
    assert len(wear.intervals) == 4


@pytest.mark.parametrize(("ran_in", "found"), [(RAN_IN, 1), (0.0, 0)])
def test_check_says_where_the_overall_rate_is_not_the_steady_one(ran_in, found):
    findings = [one for one in check_run(weighed(lost(ran_in))) if one.code == "rate_not_steady"]
    assert [one.severity for one in findings] == found * ["warning"]


SEVERE = DENSITY * STEADY * LOAD * (PLACES + 4 * np.maximum(PLACES - 0.7 * END, 0))
"""Mass lost until each place where the rate becomes five times as high after 70 % of the test."""


@pytest.mark.parametrize("stops", [slice(None), slice(8, None, 3)], ids=["twelve", "two"])
@pytest.mark.parametrize(("masses", "found"), [(SEVERE, 1), (lost(0.0), 0)], ids=["severe", "steady"])
def test_check_reports_a_rate_that_changes_late(stops, masses, found):
    findings = [one for one in check_run(weighed(masses[stops], PLACES[stops])) if one.code == "rate_not_steady"]
    assert len(findings) == found


def test_a_rate_that_rises_is_no_running_in():
    (note,) = (one for one in specific_wear(weighed(SEVERE)).notes if "steady-state" in one)
    assert note.endswith("because the rate has increased")


@pytest.mark.slow
def test_weighings_that_scatter_are_no_change_of_rate():
    rng = np.random.default_rng(5)
    runs = [weighed(lost(0.0) + 2 * BALANCE * rng.standard_normal(STOPS)) for _ in range(100)]
    assert sum(one.code == "rate_not_steady" for run in runs for one in check_run(run)) <= 1


def test_page_of_the_run_has_the_intervals_and_the_steady_rate():
    told = _specific_wear_section(specific_wear(weighed(lost(RAN_IN))), {})
    *_, table = told.tables
    assert (table.title, len(table.rows)) == ("wear between measurements", STOPS)
    assert "steady-state wear rate of the pin" in str(told.facts)
    assert "steady" in told.sentence
