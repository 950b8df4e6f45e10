"""UMESHMOTION's economy against the Wear-Processor: what is worn off, how far it drifts, and what is refused."""

import numpy as np
import pytest
from fe_bodies import DISC_COEFFICIENT, DISC_LOAD, LOAD, START, discs, sphere

from tribopipe.base.errors import ContactError
from tribopipe.physics.local.course import LocalWear, wear
from tribopipe.physics.local.economy import wear_economically

PIN = sphere(np.linspace(0, 4 * START, 21))
LIMIT = PIN.stable_amount(PIN.press(np.zeros_like(PIN.gap)))
INCREMENT = LIMIT / 2
AMOUNTS = INCREMENT * np.arange(1, 16)


def drifts(courses: dict[int | None, LocalWear]) -> list[float]:
    """Return the largest difference of depth from the Wear-Processor's, by number of increments between corrections."""
    full = courses[1].depth[1:]
    return [float(np.abs(course.depth[1:] / full - 1).max()) for course in courses.values()]


def test_each_correction_is_a_step_of_the_wear_processor():
    course = wear_economically(PIN, AMOUNTS[:3], increment=INCREMENT, correct_every=1)
    surface, worn = PIN, np.zeros_like(PIN.gap)
    for place in range(3):
        contact = surface.press(worn)
        assert course.pressure[place] == pytest.approx(contact.pressure)
        worn = worn + INCREMENT * contact.pressure
        surface = surface.refreshed(worn)
        assert course.worn[place + 1] == pytest.approx(worn, rel=1e-9)


@pytest.mark.parametrize("every", [None, 3])
def test_volume_is_archard_s(every):
    course = wear_economically(PIN, [INCREMENT / 3, 7.1 * INCREMENT], increment=INCREMENT, correct_every=every)
    assert course.amount == pytest.approx([0, INCREMENT / 3, 7.1 * INCREMENT], abs=0)
    assert course.volume == pytest.approx(LOAD * course.amount, rel=1e-12, abs=0)
    assert course.pressure.min() >= 0


def test_the_mended_contact_is_that_of_a_full_solution_where_its_status_stays():
    course = wear_economically(PIN, [1e-3 * INCREMENT], increment=INCREMENT)
    contact = PIN.press(course.worn[-1])
    assert course.pressure[-1] == pytest.approx(contact.pressure, rel=1e-9)
    assert course.approach[-1] == pytest.approx(contact.approach, rel=1e-9)


@pytest.mark.slow
def test_drift_is_small_and_corrections_bring_it_back():
    courses = {
        every: wear_economically(PIN, AMOUNTS, increment=INCREMENT, correct_every=every) for every in (None, 2, 1)
    }
    never, often, none = drifts(courses)
    assert 0 == none < often < never < 5e-3


@pytest.mark.slow
def test_lost_stresses_lower_the_pressure_until_a_correction():
    """Fig. 11: less wear than the Wear-Processor's, the less often the geometry is corrected."""
    courses = {
        every: wear_economically(PIN, AMOUNTS, increment=INCREMENT, correct_every=every, stress_loss=0.02)
        for every in (None, 5, 1)
    }
    never, some, full = courses.values()
    assert never.depth[-1] < some.depth[-1] < full.depth[-1]
    assert np.all(never.peak_pressure[6:] < full.peak_pressure[6:])
    before, after = (some.peak_pressure / full.peak_pressure)[4:6]
    assert before < 0.97
    assert after > 1.0


def test_it_comes_to_where_implicit_wear_does():
    economical = wear_economically(PIN, AMOUNTS[-1:], increment=INCREMENT)
    assert economical.depth[-1] == pytest.approx(wear(PIN, AMOUNTS[-1:], refresh_every=1000).depth[-1], rel=0.01)


def test_long_increments_are_refused():
    with pytest.raises(ContactError, match=rf"expected at most {LIMIT:.3g} \(SI units\), .* smaller increments"):
        wear_economically(PIN, [10 * LIMIT], increment=1.01 * LIMIT)


@pytest.mark.parametrize(
    ("told", "found"),
    [
        ({"increment": 0.0}, "increments of 0 for a total amount of wear "),
        ({"increment": 1e-9 * LIMIT}, "increments of .* for a total amount of wear of "),
        ({"correct_every": 0}, "an interval of 0 increments between corrections"),
        ({"stress_loss": 1.5}, "a stress loss of 1.5"),
        ({"stress_loss": np.nan}, "a stress loss of nan"),
    ],
)
def test_what_makes_no_sense_is_refused(told, found):
    with pytest.raises(ContactError, match=f"found {found}.*; expected .*; "):
        wear_economically(PIN, AMOUNTS, **{"increment": INCREMENT, **told})


@pytest.mark.slow
def test_drift_of_the_paper_s_discs():
    surface = discs((5, 3), 1e6)
    amounts = DISC_COEFFICIENT * np.linspace(0, 1e6, 5)[1:]
    courses = [
        wear_economically(surface, amounts, increment=DISC_COEFFICIENT * 5e4, correct_every=every, stress_loss=0.01)
        for every in (None, 10, 1)
    ]
    never, some, full = courses
    for course in courses:
        assert course.volume == pytest.approx(DISC_LOAD * course.amount, rel=1e-9)
        assert np.all(np.diff(course.depth) > 0)
    assert never.depth[-1] < 0.995 * full.depth[-1]
    assert never.depth[-1] < some.depth[-1] < full.depth[-1]
    assert never.peak_pressure[-1] < 0.95 * full.peak_pressure[-1]
    exact = wear_economically(surface, amounts, increment=DISC_COEFFICIENT * 5e4)
    assert exact.depth[1:] == pytest.approx(full.depth[1:], rel=5e-3)
