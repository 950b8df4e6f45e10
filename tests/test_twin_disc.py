"""Wear of two discs against quadrature in many digits, plain integration, closed forms, limits, and printed steps."""

import re
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk
from sweeps import others_slow

from tribopipe.base.errors import ContactError
from tribopipe.physics import disc_course
from tribopipe.physics.hertz import contact_modulus
from tribopipe.physics.twin_disc import DiscPair, DiscWear, published_wear

CONVENTIONS = ("contact-width", "full-slip", "volume-conserving")
ZRO2 = float(contact_modulus(pin_modulus=152e9, pin_ratio=0.32, disc_modulus=152e9, disc_ratio=0.32))
SI3N4 = float(contact_modulus(pin_modulus=304e9, pin_ratio=0.24, disc_modulus=304e9, disc_ratio=0.24))


class Case(NamedTuple):
    load: float
    crown: float
    curved: float
    flat: float
    modulus: float
    slip: float
    k_1: float
    k_2: float
    rotations: float


# mm³/(N mm) = 1e-6 m²/N. Fig. 7's dimensions are not in the text: radii of 4 mm are chosen.
TABLE_3 = Case(0.3, 4e-3, 4e-3, 4e-3, ZRO2, 0.1, 1e-16, 0.0, 1e6)
CASES = {
    "Table 3": TABLE_3,
    "Section 3.5": Case(0.25, 4e-3, 4e-3, 4e-3, SI3N4, 0.04, 4.6e-18, 2.0e-18, 1e6),
    "unequal radii": Case(5.0, 8e-3, 20e-3, 35e-3, SI3N4, 0.1, 3e-17, 8e-17, 3e5),
    "negative slip": Case(0.3, 10e-3, 20e-3, 12e-3, ZRO2, -0.05, 2e-17, 5e-18, 1e6),
    "cylindrical disc only": Case(0.3, 4e-3, 5e-3, 4e-3, ZRO2, 0.02, 0.0, 3e-16, 1e5),
    "hardly worn": Case(40.0, 10e-3, 20e-3, 30e-3, 1e9, 0.01, 1e-16, 2e-16, 50.0),
    "deeply worn": Case(0.3, 4e-3, 30e-3, 40e-3, ZRO2, 0.3, 1e-14, 3e-15, 1e5),
}
FIELDS = (
    "curved_depth",
    "flat_depth",
    "curved_volume",
    "flat_volume",
    "half_width",
    "half_length",
    "pressure",
    "slip",
    "sliding_distance",
)

all_cases = pytest.mark.parametrize("case", CASES.values(), ids=list(CASES))
all_conventions = pytest.mark.parametrize("convention", CONVENTIONS)


def approx(value, rel):
    """As pytest's, which takes all below 1e-12 for equal: a picometre and a thousandth of a cubic millimetre."""
    return pytest.approx(value, rel=rel, abs=0)


def discs_of(case: Case, convention, **changes) -> DiscPair:
    given = dict(zip(("normal_load", "crown_radius", "curved_radius", "flat_radius"), case[:4], strict=True))
    return DiscPair(**{**given, "modulus": case.modulus, "slip": case.slip, "distance": convention, **changes})


def worn(case: Case, convention, rotations=None, **changes) -> DiscWear:
    turns = case.rotations if rotations is None else rotations
    return discs_of(case, convention, **changes).worn(turns, case.k_1, case.k_2)


def values(state: DiscWear, *names) -> np.ndarray:
    return np.array([np.asarray(getattr(state, name)) for name in names or FIELDS])


# --- the differential equations, integrated twice -------------------------------------------------------------------


def integrated(case: Case, convention) -> dict[str, float]:
    """Integrate the differential equations as printed, a_x by bisection wherever they ask for it."""
    load, crown, curved, flat, modulus, slip, k_1, k_2, turns = case
    ratio = (1 + slip) * curved / flat

    def contact(h_1, h_2):
        r_1, r_2 = curved - h_1, flat - h_2
        equivalent = r_1 * r_2 / (r_1 + r_2)

        def length(a):
            return np.pi / 4 * np.sqrt(4 * load / (2 * a) * equivalent / (np.pi * modulus))

        def gap(log_a):
            a = np.exp(log_a)
            elastic = load / (2 * modulus * np.sqrt(a * length(a)))
            return a**2 / (crown + np.sqrt(crown**2 - a**2)) - h_1 - h_2 - elastic

        a = np.exp(brentq(gap, np.log(crown * 1e-9), np.log(crown) - 1e-12, xtol=1e-15, rtol=1e-15))
        pressure = np.pi / 4 * np.sqrt(load / (2 * a) * modulus / (np.pi * equivalent))
        return a, length(a), pressure, r_1, r_2

    def rates(h_1, h_2):
        a, a_z, pressure, r_1, r_2 = contact(h_1, h_2)
        slid = 2 * np.pi * abs(ratio * r_2 - r_1)
        if convention == "volume-conserving":
            # k·F·s is the volume 2πr·2a·dh.
            worn_1, worn_2 = (k * load * slid / (4 * np.pi * r * a) for k, r in ((k_1, r_1), (k_2, r_2)))
        else:
            way = slid if convention == "full-slip" else 2 * a_z
            worn_1, worn_2 = k_1 * pressure * way, k_2 * pressure * way * ratio
        return np.array([worn_1, worn_2, 4 * np.pi * r_1 * a * worn_1, 4 * np.pi * r_2 * a * worn_2, slid])

    first = rates(0.0, 0.0) * turns
    unit = np.where(first > 0, first, 1.0)
    # N = x²·turns smooths the start, where the depths rise steeply.
    solved = solve_ivp(
        lambda x, y: 2 * x * turns * rates(*(y * unit)[:2]) / unit,
        (0, 1),
        np.zeros(5),
        method="DOP853",
        rtol=1e-12,
        atol=1e-15,
    )
    end = solved.y[:, -1] * unit
    a, a_z, pressure, r_1, r_2 = contact(*end[:2])
    found = dict(zip(FIELDS, [*end[:4], a, a_z, pressure, ratio * r_2 / r_1 - 1, end[4]], strict=True))
    return found | dict(zip(("curved_rate", "flat_rate"), rates(*end[:2])[:2], strict=True))


@all_conventions
@all_cases
def test_exact_model_agrees_with_an_integration_of_the_differential_equations(case, convention):
    state, truth = worn(case, convention), integrated(case, convention)
    for name, true in truth.items():
        assert float(getattr(state, name)) == approx(true, rel=1e-9), name


def half_width(case: Case, worn_depth, equivalent) -> mpf:
    """Return a_x where both discs have receded by a depth, for mpmath's precision."""
    load, crown, modulus = mpf(case.load), mpf(case.crown), mpf(case.modulus)

    def excess(a, root=mp.sqrt, pi=mp.pi, at=(crown, worn_depth, load, equivalent, modulus)):
        crown, depth, load, equivalent, modulus = at
        a_z = pi / 4 * root(4 * load / (2 * a) * equivalent / (pi * modulus))
        return a**2 / (crown + root(crown**2 - a**2)) - depth - load / (2 * modulus * root(a * a_z))

    plain = tuple(float(value) for value in (crown, worn_depth, load, equivalent, modulus))
    guess = mpf(brentq(lambda a: excess(a, np.sqrt, np.pi, plain), 1e-9 * plain[0], plain[0], xtol=1e-16))
    return mp.findroot(excess, (guess, guess * (1 + mpf("1e-10"))), tol=1e-46)


def by_quadrature(case: Case, convention, curved_depth) -> dict[str, mpf]:
    """Return rotations, volumes and slip distance at a depth h₁ > 0 by integrals over h₁, in 24 digits."""
    with mp.workdps(24):
        load, crown, curved, flat, modulus, slip, k_1, k_2, _ = (mpf(value) for value in case)
        ratio, most = (1 + slip) * curved / flat, mpf(float(curved_depth))
        conserving = convention == "volume-conserving"

        def opposite(h_1):
            """h₂ of h₁: both recede by the same k·p·s but for n₂/n₁, or both lose volume as k₁ : k₂."""
            if conserving:
                square = k_2 / k_1 * h_1 * (2 * curved - h_1)
                return square / (flat + mp.sqrt(flat**2 - square))
            return ratio * k_2 / k_1 * h_1

        @cache
        def state(x):
            h_1 = most * x
            h_2 = opposite(h_1)
            r_1, r_2 = curved - h_1, flat - h_2
            equivalent = r_1 * r_2 / (r_1 + r_2)
            a = half_width(case, h_1 + h_2, equivalent)
            slid = 2 * mp.pi * abs(ratio * r_2 - r_1)
            pressure = mp.pi / 4 * mp.sqrt(load / (2 * a) * modulus / (mp.pi * equivalent))
            a_z = mp.pi / 4 * mp.sqrt(4 * load / (2 * a) * equivalent / (mp.pi * modulus))
            work = {
                "contact-width": pressure * 2 * a_z,
                "full-slip": pressure * slid,
                "volume-conserving": load * slid / (4 * mp.pi * r_1 * a),
            }[convention]
            # dN, dV₁, dV₂ and ds for dx, with dh₂/dh₁ as above.
            turns = most / (k_1 * work)
            opposite_share = k_2 * r_1 / (k_1 * r_2) if conserving else ratio * k_2 / k_1
            across = 4 * mp.pi * a * most
            return a, turns, r_1 * across, r_2 * across * opposite_share, slid * turns

        pieces = [0, mpf("1e-4"), mpf("1e-2"), 1] if most > crown / 100 else [0, 1]
        names = ["rotations", "curved_volume", "flat_volume", "sliding_distance"]
        totals = {
            name: mp.quad(lambda x, place=place: state(x)[place], pieces, method="gauss-legendre")
            for place, name in enumerate(names, start=1)
        }
        return totals | {"half_width": state(mpf(1))[0], "flat_depth": opposite(most)}


@all_conventions
@pytest.mark.parametrize("turns", [1e-6, 1e-3, 1.0, 1e4])
def test_exact_model_keeps_its_digits_from_a_millionth_of_a_rotation_on(turns, convention):
    case = CASES["unequal radii"]
    state = worn(case, convention, turns)
    truth = by_quadrature(case, convention, state.curved_depth)
    assert float(truth.pop("rotations")) == approx(turns, rel=1e-12)
    for name, true in truth.items():
        assert float(getattr(state, name)) == approx(float(true), rel=1e-12), name


@pytest.mark.slow
@all_conventions
def test_exact_model_keeps_its_digits_on_the_way_to_the_crown_s_radius(convention):
    case = CASES["deeply worn"]._replace(k_2=0.0)
    depth = 0.999 * case.crown
    truth = by_quadrature(case, convention, depth)
    turns = float(discs_of(case, convention).rotations(depth, case.k_1))
    assert turns == approx(float(truth["rotations"]), rel=1e-11)
    state = worn(case, convention, turns)
    assert float(state.curved_depth) == approx(depth, rel=1e-11)
    assert float(state.curved_volume) == approx(float(truth["curved_volume"]), rel=1e-11)


def test_contact_width_on_large_discs_is_the_closed_form():
    # Where radii along the track do not change, u = C·a^(-1/4), dh₁/dN = πk₁F/(8a) and with G' = a·cap'(a)
    #   πk₁F·N/8 = ∫a dh = G(a) − G(a*) + (C/4)·∫a^(-1/4) da,   G(a) = (R²·asin(a/R) − a·√(R² − a²))/2.
    load, crown, radius, modulus, k = 2.0, 5e-3, 1e8, 2e9, 1e-15
    with mp.workdps(40):
        F, R, E = mpf(load), mpf(crown), mpf(modulus)
        C = F / (2 * E * mp.sqrt(mp.pi / 4) * (2 * F * (mpf(radius) / 2) / (mp.pi * E)) ** mpf("0.25"))

        def cap(a):
            return R - mp.sqrt(R**2 - a**2)

        def area(a):
            return (R**2 * mp.asin(a / R) - a * mp.sqrt(R**2 - a**2)) / 2

        start = mp.findroot(lambda a: cap(a) - C / a ** mpf("0.25"), (mpf("1e-4"), mpf("2e-4")), tol=1e-60)
        for times in ("1.001", "2", "8"):
            a = start * mpf(times)
            depth = cap(a) - C / a ** mpf("0.25")
            elastic = C / 3 * (a ** mpf("0.75") - start ** mpf("0.75"))
            turns = 8 / (mp.pi * mpf(k) * F) * (area(a) - area(start) + elastic)
            pair = DiscPair(load, crown, radius, radius, modulus, 0.1, "contact-width")
            state = pair.worn(float(turns), k)
            assert float(state.curved_depth) == approx(float(depth), rel=1e-12)
            assert float(state.half_width) == approx(float(a), rel=1e-13)


# --- the steps as printed -------------------------------------------------------------------------------------------


def hertz(load, radius_x, radius_z, modulus) -> tuple[float, float]:
    """Half axes across and along, for the longer one across, with Legendre's integrals."""

    def excess(q):
        m = 1 - 1 / q**2
        return (q**2 * ellipe(m) - ellipk(m)) / (ellipk(m) - ellipe(m)) - radius_x / radius_z

    q = brentq(excess, 1.0001, 1e3, xtol=1e-15, rtol=1e-15)
    m = 1 - 1 / q**2
    b = np.cbrt(3 * load * radius_z / (np.pi * modulus * q**3 * m) * (q**2 * ellipe(m) - ellipk(m)))
    return float(q * b), float(b)


def flow_chart(case: Case, convention, steps) -> np.ndarray:
    """Fig. A written down a second time, by speeds: n₁ = 1/s, and a step is a time in which disc 1 turns so often."""
    load, crown, *radii, modulus, slip, k_1, k_2, _ = case
    r, h, volume, k = list(radii), [0.0, 0.0], [0.0, 0.0], (k_1, k_2)
    n = (1.0, (1 + slip) * 2 * np.pi * r[0] / (2 * np.pi * r[1]))
    a_x, a_z = hertz(load, crown, 1 / (1 / r[0] + 1 / r[1]), modulus)
    p, u = load / (np.pi * a_x * a_z), load / (2 * modulus * (a_x * a_z) ** 0.5)
    slid, states = 0.0, []
    for time in [*steps, None]:
        v = [2 * np.pi * n[i] * r[i] for i in (0, 1)]
        states.append((*h, *volume, a_x, a_z, p, (v[1] - v[0]) / v[0], slid))
        if time is None:
            break
        s = abs(v[1] - v[0])
        slid += s * time
        for i in (0, 1):
            if convention == "contact-width":
                loss = 2 * k[i] * p * a_z * n[i] * time
            elif convention == "full-slip":
                loss = k[i] * p * (s / n[0]) * (n[i] / n[0]) * time
            else:
                loss = k[i] * load * s * time / (2 * np.pi * r[i] * 2 * a_x)
            volume[i] += 2 * np.pi * r[i] * 2 * a_x * loss
            h[i] += loss
        h_t = h[0] + h[1] + u
        a_x = (2 * crown * h_t - h_t**2) ** 0.5
        r = [radii[0] - h[0], radii[1] - h[1]]
        r_eq, F_l = 1 / (1 / r[0] + 1 / r[1]), load / (2 * a_x)
        a_z = np.pi / 4 * (4 * F_l * r_eq / (np.pi * modulus)) ** 0.5
        p = np.pi / 4 * (F_l * modulus / (np.pi * r_eq)) ** 0.5
        u = load / (2 * modulus * (a_x * a_z) ** 0.5)
    return np.array(states).T


# Those in which the longer axis lies across, as the plain Hertz above has it.
plain = pytest.mark.parametrize(
    "case", [CASES[name] for name in ("Table 3", "Section 3.5", "negative slip", "cylindrical disc only")]
)


@all_conventions
@plain
def test_published_steps_are_those_of_the_flow_chart(case, convention):
    steps = np.concatenate([np.full(300, 1.0), np.geomspace(1, case.rotations / 100, 300)])
    state = published_wear(discs_of(case, convention), steps, case.k_1, case.k_2)
    assert len(state.curved_depth) == len(steps) + 1
    np.testing.assert_allclose(np.diff(state.curved_depth), state.curved_rate[:-1] * steps, rtol=1e-7, atol=1e-20)
    np.testing.assert_allclose(np.diff(state.flat_depth), state.flat_rate[:-1] * steps, rtol=1e-7, atol=1e-20)
    plain = flow_chart(case, convention, steps)
    np.testing.assert_allclose(values(state)[:7], plain[:7], rtol=1e-12)
    np.testing.assert_allclose(state.slip, plain[7], rtol=1e-12)
    np.testing.assert_allclose(state.sliding_distance, plain[8], rtol=1e-12)


def test_one_disc_that_wears_goes_by_figure_8():
    # Eq. 10–13: the cylindrical disc keeps its radius, the distance in a step is 2a_z.
    load, crown, curved, flat, modulus, _, k, _, _ = TABLE_3
    a_x, a_z = hertz(load, crown, curved * flat / (curved + flat), modulus)
    p, u, h = load / (np.pi * a_x * a_z), load / (2 * modulus * np.sqrt(a_x * a_z)), 0.0
    for _ in range(2000):
        h = h + 2 * k * p * a_z
        total = h + u
        a_x, r = np.sqrt(2 * crown * total - total**2), curved - h
        r_eq = r * flat / (r + flat)
        a_z = np.pi / 4 * np.sqrt(4 * (load / (2 * a_x)) * r_eq / (np.pi * modulus))
        p = np.pi / 4 * np.sqrt((load / (2 * a_x)) * modulus / (np.pi * r_eq))
        u = load / (2 * modulus * np.sqrt(a_x * a_z))
    state = published_wear(discs_of(TABLE_3, "contact-width"), np.ones(2000), k)
    found = values(state, "curved_depth", "flat_depth", "half_width", "half_length", "pressure")[:, -1]
    np.testing.assert_allclose(found, [h, 0.0, a_x, a_z, p], rtol=1e-12)


@all_conventions
@pytest.mark.parametrize(
    "name",
    others_slow(
        ["Table 3", "Section 3.5", "unequal radii", "negative slip", "cylindrical disc only"],
        "Table 3",
        "negative slip",
    ),
)
def test_published_steps_converge_to_the_exact_model_at_first_order(name, convention):
    case = CASES[name]
    exact = values(worn(case, convention), "half_width", "curved_volume", "flat_volume")
    counts = np.array([4000, 8000, 16000])
    errors = []
    for count in counts:
        state = published_wear(discs_of(case, convention), np.full(count, case.rotations / count), case.k_1, case.k_2)
        last = values(state, "half_width", "curved_volume", "flat_volume")[:, -1]
        errors.append(np.abs(last - exact)[exact > 0] / exact[exact > 0])
    orders = -np.diff(np.log(errors), axis=0) / np.diff(np.log(counts))[:, None]
    np.testing.assert_allclose(orders, 1.0, atol=0.03)


@pytest.mark.slow
@all_conventions
def test_exact_model_is_what_a_rotation_at_a_time_tends_to_after_100_000(convention):
    # From steps of a rotation and of half of one, as they would be with none.
    case = CASES["Section 3.5"]._replace(k_1=4.6e-16, k_2=2.0e-16, rotations=1e5)
    pair = discs_of(case, convention)
    whole, half = (
        values(published_wear(pair, np.full(100_000 * parts, 1 / parts), case.k_1, case.k_2))[:, -1] for parts in (1, 2)
    )
    exact = values(worn(case, convention))
    np.testing.assert_allclose(2 * half - whole, exact, rtol=1e-6)
    assert np.all(np.abs(half - exact)[:2] < np.abs(whole - exact)[:2])


# --- what must hold whatever the discs ------------------------------------------------------------------------------


few = settings(max_examples=25)


class Worn(NamedTuple):
    pair: DiscPair
    k_1: float
    k_2: float
    rotations: float
    curved_depth: float


def powers(low, high):
    return st.floats(low, high).map(lambda x: 10.0**x)


@st.composite
def worn_discs(draw, conventions=CONVENTIONS, least_depth=-9.0):
    """Discs worn until slip has changed by a fifth, or half of the crown is gone, at most."""
    crown, curved, flat = (draw(powers(-3, -1.3)) for _ in range(3))
    modulus, slip = draw(powers(10, 12)), draw(st.sampled_from([-1, 1])) * draw(powers(-2.3, -0.3))
    load = modulus * crown**2 * draw(powers(-9, -4))
    k_1 = draw(powers(-19, -14))
    k_2 = draw(st.one_of(st.just(0.0), powers(-3, 3).map(lambda ratio: ratio * k_1)))
    pair = DiscPair(load, crown, curved, flat, modulus, slip, draw(st.sampled_from(conventions)))
    assume(float(pair.start_height) < crown / 4)
    ratio = (1 + slip) * curved / flat
    most = min(crown / 2, 0.1 * abs(slip) * curved * min(1, 1 / ratio))
    depth = most / (1 + 2 * k_2 / k_1 * max(ratio, curved / flat)) * draw(powers(least_depth, 0))
    return Worn(pair, k_1, k_2, float(pair.rotations(depth, k_1, k_2)), depth)


@few
@given(worn_discs())
def test_rotations_found_from_the_depth_are_those_turned(discs):
    state = discs.pair.worn(discs.rotations, discs.k_1, discs.k_2)
    assert float(state.curved_depth) == approx(discs.curved_depth, rel=1e-11)
    again = discs.pair.rotations(state.curved_depth, discs.k_1, discs.k_2)
    assert float(again) == approx(discs.rotations, rel=1e-11)


@few
@given(worn_discs(["volume-conserving"]))
def test_volumes_are_archard_s_where_volume_is_conserved(discs):
    state = discs.pair.worn(discs.rotations, discs.k_1, discs.k_2)
    sliding = float(discs.pair.normal_load) * float(state.sliding_distance)
    assert float(state.curved_volume) == approx(discs.k_1 * sliding, rel=1e-11)
    assert float(state.flat_volume) == approx(discs.k_2 * sliding, rel=1e-11)


@few
@given(worn_discs())
def test_slip_is_that_of_the_radii_left(discs):
    state = discs.pair.worn([0.0, discs.rotations], discs.k_1, discs.k_2)
    assert float(state.slip[0]) == approx(discs.pair.slip, rel=1e-13)
    left = (1 - state.flat_depth[1] / discs.pair.flat_radius) / (1 - state.curved_depth[1] / discs.pair.curved_radius)
    assert float(state.slip[1]) == approx((1 + discs.pair.slip) * float(left) - 1, rel=1e-9)


@few
@given(worn_discs(least_depth=-4.0))
def test_wear_goes_on_as_figure_9_has_it(discs):
    state = discs.pair.worn(discs.rotations * np.linspace(0, 1, 6), discs.k_1, discs.k_2)
    assert np.all(np.diff(state.curved_depth) > 0)
    assert np.all(np.diff(state.curved_volume) > 0)
    assert np.all(np.diff(state.flat_depth) >= 0)
    assert np.all(np.diff(state.sliding_distance) > 0)
    assert np.all(np.diff(state.half_width) > 0)
    assert np.all(np.diff(state.half_length) < 0)
    assert np.all(np.diff(state.half_width * state.half_length) > 0)
    assert np.all(np.diff(state.pressure) < 0)


@few
@given(worn_discs(["contact-width"], least_depth=-4.0))
def test_depth_grows_ever_more_slowly_by_the_contact_s_width(discs):
    depth = discs.pair.worn(discs.rotations * np.linspace(0, 1, 6), discs.k_1, discs.k_2).curved_depth
    assert np.all(np.diff(depth, 2) < 0)


@few
@given(worn_discs(["contact-width"]))
def test_volume_grows_with_the_discs_turns_by_the_contact_s_width(discs):
    # dV₁/dN = 2πr₁·κ·k₁·F_N, whatever the slip; r₁ hardly changes.
    state = discs.pair.worn(discs.rotations, discs.k_1, discs.k_2)
    first = np.pi**2 / 2 * discs.pair.curved_radius * discs.k_1 * discs.pair.normal_load * discs.rotations
    share = float(state.curved_volume) / first
    assert 1 - discs.curved_depth / discs.pair.curved_radius <= share * (1 + 1e-12)
    assert share <= 1 + 1e-12


@few
@given(worn_discs(["contact-width", "full-slip"]))
def test_depths_are_as_coefficients_and_turns_where_the_points_slide_the_same_way(discs):
    state = discs.pair.worn(discs.rotations, discs.k_1, discs.k_2)
    turns = (1 + discs.pair.slip) * discs.pair.curved_radius / discs.pair.flat_radius
    assert float(state.flat_depth) == approx(turns * discs.k_2 / discs.k_1 * discs.curved_depth, rel=1e-10)


@pytest.mark.slow
@few
@given(worn_discs(["contact-width", "volume-conserving"]))
def test_discs_may_change_places(discs):
    # Either counts its own turns; the crowned disc's radius along the track is all that makes it different. By
    # full-slip both count the slip distance of a turn of disc 1, which is not symmetric.
    pair = discs.pair
    turns = (1 + pair.slip) * pair.curved_radius / pair.flat_radius
    other = DiscPair(
        pair.normal_load,
        pair.crown_radius,
        pair.flat_radius,
        pair.curved_radius,
        pair.modulus,
        -pair.slip / (1 + pair.slip),
        pair.distance,
    )
    state = pair.worn(discs.rotations, discs.k_1, discs.k_2)
    swapped = other.worn(discs.rotations * turns, discs.k_2, discs.k_1)
    names = ["curved_depth", "flat_depth", "curved_volume", "flat_volume", "half_width", "half_length", "pressure"]
    turned = ["flat_depth", "curved_depth", "flat_volume", "curved_volume", "half_width", "half_length", "pressure"]
    np.testing.assert_allclose(values(state, *names), values(swapped, *turned), rtol=1e-10)
    assert float(swapped.sliding_distance) == approx(float(state.sliding_distance), rel=1e-10)


@pytest.mark.slow
@few
@given(worn_discs(["volume-conserving"]))
def test_equal_discs_of_equal_coefficients_wear_alike_where_volume_is_conserved(discs):
    pair = discs.pair
    equal = DiscPair(
        pair.normal_load,
        pair.crown_radius,
        pair.curved_radius,
        pair.curved_radius,
        pair.modulus,
        pair.slip,
        pair.distance,
    )
    turns = float(equal.rotations(0.1 * discs.curved_depth, discs.k_1, discs.k_1))
    state = equal.worn(turns, discs.k_1, discs.k_1)
    assert float(state.flat_depth) == approx(float(state.curved_depth), rel=1e-12)
    assert float(state.flat_volume) == approx(float(state.curved_volume), rel=1e-12)
    # Nor does their slip distance change but for r itself.
    start = 2 * np.pi * abs(pair.slip) * pair.curved_radius
    left = 1 - float(state.curved_depth) / pair.curved_radius
    assert left <= float(state.sliding_distance) / (start * turns) * (1 + 1e-11)
    assert float(state.sliding_distance) <= start * turns * (1 + 1e-11)


@pytest.mark.slow
@few
@given(worn_discs(), st.floats(0.01, 100), st.floats(0.01, 100))
def test_scale_of_lengths_and_moduli_is_free(discs, length, stiffness):
    # Load as modulus times length²; k is one over a pressure.
    load, crown, curved, flat, modulus, slip = (float(value) for value in discs.pair.inputs)
    large = DiscPair(
        load * stiffness * length**2,
        crown * length,
        curved * length,
        flat * length,
        modulus * stiffness,
        slip,
        discs.pair.distance,
    )
    state = discs.pair.worn(discs.rotations, discs.k_1, discs.k_2)
    scaled = large.worn(discs.rotations, discs.k_1 / stiffness, discs.k_2 / stiffness)
    dimensions = np.array([length, length, length**3, length**3, length, length, stiffness, 1, length])
    np.testing.assert_allclose(values(scaled), values(state) * dimensions, rtol=1e-10)


@pytest.mark.slow
@few
@given(worn_discs(least_depth=-3.0), st.integers(1, 2000))
def test_one_disc_wears_as_two_of_which_one_never_does(discs, count):
    published = published_wear(discs.pair, np.full(count % 7 + 1, discs.rotations / 1000), discs.k_1)
    for state in (discs.pair.worn(discs.rotations / 10, discs.k_1), published):
        assert np.all(state.flat_depth == 0)
        assert np.all(state.flat_volume == 0)
    explicit = values(discs.pair.worn(discs.rotations / 10, discs.k_1, 0.0))
    assert np.array_equal(explicit, values(discs.pair.worn(discs.rotations / 10, discs.k_1)))


@all_conventions
@few
@given(load=powers(-2, 1), turns=powers(-3, 9), k_1=powers(-19, -13), k_2=powers(-19, -13))
def test_discs_that_only_roll_do_not_wear(convention, load, turns, k_1, k_2):
    pair = DiscPair(load, 4e-3, 5e-3, 7e-3, ZRO2, 0.0, convention)
    names = ["curved_depth", "flat_depth", "curved_volume", "flat_volume", "slip", "sliding_distance"]
    assert np.all(values(pair.worn([0.0, turns], k_1, k_2), *names) == 0)
    assert np.isinf(pair.rotations(1e-9, k_1, k_2))
    steps = values(published_wear(pair, [turns, turns], k_1, k_2), *names)
    np.testing.assert_allclose(steps, 0, atol=1e-15 * max(1.0, turns) if convention != "contact-width" else 0)


@all_conventions
def test_sign_of_slip_hardly_matters_at_first(convention):
    faster, slower = (worn(TABLE_3._replace(slip=slip), convention, 1e-3) for slip in (0.1, -0.1))
    assert float(faster.curved_depth) == approx(float(slower.curved_depth), rel=1e-6)
    assert float(faster.slip) > 0 > float(slower.slip)


@all_conventions
def test_draws_and_rotations_broadcast_against_each_other(convention):
    rng = np.random.default_rng(3)
    case = CASES["unequal radii"]
    load, crown, curved, flat, modulus, slip, k_1, k_2 = (
        value * rng.uniform(0.9, 1.1, size=(5, 1)) for value in case[:8]
    )
    k_1[1], k_2[2], slip[3] = 0.0, 0.0, 0.0
    turns = np.array([0.0, 1.0, 1e3, 1e6])
    pair = DiscPair(load, crown, curved, flat, modulus, slip, convention)
    together = values(pair.worn(turns, k_1, k_2))
    assert together.shape == (len(FIELDS), 5, 4)
    back = pair.rotations(together[0], k_1, k_2)
    assert back.shape == (5, 4)
    for i in range(5):
        one = DiscPair(*(float(value[i, 0]) for value in (load, crown, curved, flat, modulus, slip)), convention)
        for j, count in enumerate(turns):
            alone = values(one.worn(count, float(k_1[i, 0]), float(k_2[i, 0])))
            np.testing.assert_allclose(together[:, i, j], alone, rtol=1e-12)
            if i not in (1, 3):
                assert back[i, j] == approx(count, rel=1e-11)
            else:
                assert np.isinf(back[i, j])


@all_conventions
@pytest.mark.parametrize("ratio", [1e-9, 1e9, 1e14])
def test_disc_that_hardly_wears_keeps_its_digits(convention, ratio):
    case = CASES["Section 3.5"]
    k_1, k_2 = (case.k_1, case.k_1 * ratio) if ratio < 1 else (case.k_1 / ratio, case.k_1)
    state = worn(case._replace(k_1=k_1, k_2=k_2), convention)
    # h ≪ r, where volume is conserved.
    turns = 1.0 if convention == "volume-conserving" else 1 + case.slip
    assert float(state.flat_depth / state.curved_depth) == approx(turns * ratio, rel=1e-4)


@all_conventions
def test_disc_that_does_not_wear_stays_as_it_is(convention):
    turns = np.geomspace(1, 1e6, 200)
    curved, flat = (
        worn(TABLE_3._replace(k_1=k_1, k_2=k_2), convention, turns) for k_1, k_2 in ((1e-16, 0), (0, 1e-16))
    )
    assert np.all(curved.flat_depth == 0)
    assert np.all(flat.curved_depth == 0)


def test_only_what_differs_needs_an_axis():
    pair = discs_of(TABLE_3, "full-slip")
    coefficients, turns = np.array([[1e-16], [3e-16]]), np.array([1e3, 1e5, 1e6])
    together = pair.worn(turns, coefficients)
    loads = discs_of(TABLE_3, "full-slip", normal_load=np.array([0.1, 0.2, 0.3]))
    each = loads.worn(turns, 1e-16, np.array([[0.0], [1e-16]]))
    assert together.pressure.shape == each.pressure.shape == (2, 3)
    assert float(together.curved_depth[1, 2]) == approx(float(pair.worn(1e6, 3e-16).curved_depth), rel=1e-12)
    assert float(each.curved_depth[0, 2]) == approx(float(together.curved_depth[0, 2]), rel=1e-12)


# --- the paper's cases ----------------------------------------------------------------------------------------------


@all_conventions
def test_zirconia_of_table_3_wears_as_figure_9_describes_it(convention):
    turns = np.linspace(0, 2e6, 201)
    state = worn(TABLE_3, convention, turns)
    assert state.curved_depth[0] == 0
    assert np.all(np.diff(state.curved_depth) > 0)
    # "leading to a drop in the slope of the wear depth curve because of a drop in the contact pressure"
    assert np.all(np.diff(state.curved_depth, 2) < 0)
    assert np.all(np.diff(state.pressure) < 0)
    # "the semi major axis length of the contact ellipse continuously increases while the semi minor axis length
    # continuously decreases but the resulting contact area increases"
    assert np.all(state.half_width > state.half_length)
    assert np.all(np.diff(state.half_width) > 0)
    assert np.all(np.diff(state.half_length) < 0)
    assert np.all(np.diff(state.half_width * state.half_length) > 0)


@all_cases
def test_printed_correction_carries_five_eighths_of_the_load(case):
    # p·π·a_x·a_z = π·κ·F_N/4: all of it for κ = 4/π, which makes the ellipse as large as the rectangle.
    state = worn(case, "full-slip")
    carried = float(state.pressure * np.pi * state.half_width * state.half_length)
    assert carried == approx(np.pi**2 / 16 * case.load, rel=1e-13)


@pytest.mark.parametrize(("convention", "exponent"), list(zip(CONVENTIONS, [1.0, 1.2, 1.0], strict=True)))
def test_volume_grows_as_a_power_of_rotations_where_the_elastic_part_is_small(convention, exponent):
    # a² ∝ h and V ∝ a³ on discs so large that slip stays: by full-slip dh/dN ∝ a^(-1/2), so that V ∝ N^(6/5).
    pair = DiscPair(1e-6, 1.0, 1e4, 1e4, 1e12, 0.1, convention)
    depth = np.array([1e-4, 1e-3])
    turns = pair.rotations(depth, 1e-15, 1e-15)
    volume = pair.worn(turns, 1e-15, 1e-15).curved_volume
    assert float(np.diff(np.log(volume))[0] / np.diff(np.log(turns))[0]) == pytest.approx(exponent, abs=1e-3)


# --- ends of the range ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@all_conventions
@pytest.mark.parametrize("both", [False, True])
def test_more_nodes_change_nothing(monkeypatch, convention, both):
    pair = DiscPair(1e-3, 4e-3, 30e-3, 40e-3, ZRO2, 0.3, convention)
    k_1, k_2 = 1e-15, 5e-16 if both else 0.0
    start = float(pair.start_height)
    depth = np.unique([*np.geomspace(1e-9, 1, 5) * 2.6e-3, *np.geomspace(1, 1e5, 8) * start])
    depth = depth[depth < (1.3e-3 if both else 2.7e-3)]
    if not both:
        depth = np.append(depth, np.array([0.9, 0.99, 0.999]) * 4e-3)
    # Alone, so that each has the nodes of its own span only.
    before = [_there_and_back(pair, one, k_1, k_2) for one in depth]
    assert before[-1][4] > 300 * float(pair.worn(0.0, k_1).half_width)
    fewest, per_e_fold = disc_course.LAST_DIGITS
    monkeypatch.setattr(disc_course, "LAST_DIGITS", disc_course.Rule(3 * fewest, 3 * per_e_fold))
    after = [_there_and_back(pair, one, k_1, k_2) for one in depth]
    np.testing.assert_allclose(before, after, rtol=1e-12)


def _there_and_back(pair, depth, k_1, k_2):
    turns = pair.rotations(depth, k_1, k_2)
    return [*values(pair.worn(turns, k_1, k_2)), turns]


@all_conventions
@all_cases
def test_discs_that_have_not_turned_are_as_they_were(case, convention):
    state = worn(case, convention, 0.0)
    names = ["curved_depth", "flat_depth", "curved_volume", "flat_volume", "sliding_distance"]
    assert np.all(values(state, *names) == 0)
    assert float(state.slip) == approx(case.slip, rel=1e-13)
    elastic = case.load / (2 * case.modulus * np.sqrt(float(state.half_width * state.half_length)))
    cap = float(state.half_width) ** 2 / (case.crown + np.sqrt(case.crown**2 - float(state.half_width) ** 2))
    assert cap == approx(elastic, rel=1e-13)
    assert discs_of(case, convention).rotations(0.0, case.k_1, case.k_2) == (0 if case.k_1 else np.inf)


def one_sentence(caught, pattern):
    text = str(caught.value)
    assert re.search(pattern, text)
    assert re.fullmatch(r"[a-z ]+: found [^;\n]+; expected [^;\n]+; [^;\n]+", text)
    assert ". " not in text


@all_conventions
def test_wear_beyond_the_crown_is_refused(convention):
    pair = discs_of(TABLE_3, convention)
    with pytest.raises(ContactError) as caught:
        pair.worn([1.0, 1e18], 1e-14)
    one_sentence(caught, "more than 4 mm, at which the crown is completely worn away")
    with pytest.raises(ContactError) as caught:
        pair.rotations([1e-6, 4e-3], 1e-14)
    one_sentence(caught, "more than 4 mm, at which the crown is completely worn away")


def test_a_million_million_rotations_are_beyond_the_crown_of_table_3():
    with pytest.raises(ContactError, match="more than 4 mm, at which the crown is completely worn away"):
        worn(TABLE_3, "full-slip", 1e12)


def test_steps_that_wear_the_crown_past_its_radius_are_refused():
    with pytest.raises(ContactError) as caught:
        published_wear(discs_of(TABLE_3, "full-slip"), [1.0, 1e12], 1e-16)
    one_sentence(caught, "more steps with --steps")


@pytest.mark.parametrize("load", [0.0, -0.3, float("nan"), [0.3, 0.0]])
def test_discs_without_a_load_are_refused(load):
    with pytest.raises(ContactError) as caught:
        discs_of(TABLE_3, "full-slip", normal_load=load)
    one_sentence(caught, "found a load of .*; expected more than 0, for discs in rolling contact; check load")


@pytest.mark.parametrize("changes", [{"crown_radius": 1e-9}, {"normal_load": 1e9}, {"crown_radius": [4e-3, 1e-9]}])
def test_elastic_contact_as_large_as_the_crown_is_refused(changes):
    with pytest.raises(ContactError) as caught:
        discs_of(TABLE_3, "full-slip", **changes)
    one_sentence(caught, "as large as the crown")


@all_conventions
def test_a_crown_flatter_than_the_discs_are_round_wears_like_any_other(convention):
    # The disc, not the crown, is what is worn away first.
    flatter = TABLE_3._replace(crown=50e-3, curved=20e-3, flat=20e-3, rotations=1e7)
    state, truth = worn(flatter, convention), integrated(flatter, convention)
    assert float(state.curved_depth) == approx(truth["curved_depth"], rel=1e-9)
    with pytest.raises(ContactError):
        worn(flatter._replace(k_1=1e-11), convention, 1e12)


def test_steps_that_wear_a_disc_through_are_refused():
    flatter = TABLE_3._replace(crown=50e-3, curved=20e-3, flat=20e-3)
    pair = discs_of(flatter, "full-slip")
    depth = float(published_wear(pair, [1.0], 1e-16).curved_depth[-1])
    with pytest.raises(ContactError):
        published_wear(pair, [30e-3 / depth], 1e-16)


@pytest.mark.parametrize("turns", [float("nan"), [1e3, float("nan")]])
def test_rotations_that_are_no_number_do_not_pass_for_none(turns):
    try:
        depth = np.ravel(worn(TABLE_3, "full-slip", turns).curved_depth)
    except ContactError:
        return
    assert np.isnan(depth[-1])


# --- slip that vanishes because the faster disc wears ----------------------------------------------------------------

VANISHING = {
    # At a depth of h = r·(1 − 1/(1 + slip)) of the faster disc, whose wear alone counts here.
    "cylindrical disc faster": Case(0.3, 4e-3, 4e-3, 4e-3, ZRO2, 1e-4, 0.0, 1e-16, 0.0),
    "crowned disc faster": Case(0.3, 4e-3, 4e-3, 4e-3, ZRO2, -1e-3, 1e-16, 0.0, 0.0),
}
TIMES = {"full-slip": [1e7, 3e7, 1e8, 3e8], "volume-conserving": [1e10, 3e10, 1e11, 3e11]}
vanishing = pytest.mark.parametrize("case", VANISHING.values(), ids=list(VANISHING))
slides = pytest.mark.parametrize("convention", list(TIMES))


@slides
@vanishing
def test_wear_ends_where_the_slip_does(case, convention):
    turns = np.concatenate([[0.0], np.geomspace(1e5, 1e15, 41)])
    state = worn(case, convention, turns)
    assert np.all(np.isfinite(values(state)))
    faster = state.flat_depth if case.slip > 0 else state.curved_depth
    # v₂ = v₁: (1 + slip)·(r₂ − h₂) = r₁ − h₁ on equal discs.
    last = case.flat * (1 - 1 / (1 + case.slip)) if case.slip > 0 else -case.slip * case.curved
    assert np.all(np.diff(faster) >= -1e-12 * last)
    assert np.all(faster <= last * (1 + 1e-12))
    assert faster[-1] == approx(last, rel=1e-9)
    assert np.all(state.slip * np.sign(case.slip) >= -1e-12 * abs(case.slip))
    # Then nothing slides either.
    assert np.all(np.diff(state.sliding_distance) >= -1e-12 * state.sliding_distance[1:])
    assert state.sliding_distance[-1] == approx(state.sliding_distance[-5], rel=1e-9)


@slides
@vanishing
@pytest.mark.parametrize("place", range(4))
def test_exact_model_keeps_its_digits_while_slip_vanishes(case, convention, place):
    case = case._replace(rotations=TIMES[convention][place])
    state, truth = worn(case, convention), integrated(case, convention)
    for name in ("curved_depth", "flat_depth", "curved_volume", "flat_volume", "half_width", "sliding_distance"):
        assert float(getattr(state, name)) == approx(truth[name], rel=1e-9), name


@slides
@vanishing
@pytest.mark.parametrize("slip", others_slow([1e-4, 1e-3, 1e-2]))
def test_rotations_are_found_where_half_of_the_slip_is_left(case, convention, slip):
    # None of them may be taken for one at which slip has vanished.
    case = case._replace(slip=slip * np.sign(case.slip))
    pair = discs_of(case, convention)
    shares = np.linspace(0.05, 0.5, 200)
    depth = shares * slip * 4e-3
    if case.k_1:
        turns = pair.rotations(depth, case.k_1)
        found = pair.worn(turns, case.k_1).curved_depth
        alone = [float(pair.worn(one, case.k_1).curved_depth) for one in turns[::10]]
    else:
        # Against a depth of the crowned disc that is a millionth of the flat one's.
        ratio = (1 + case.slip) if convention == "full-slip" else 1.0
        turns = pair.rotations(1e-6 * depth / ratio, 1e-6 * case.k_2, case.k_2)
        found = pair.worn(turns, 1e-6 * case.k_2, case.k_2).flat_depth
        alone = [float(pair.worn(one, 1e-6 * case.k_2, case.k_2).flat_depth) for one in turns[::10]]
    np.testing.assert_allclose(found, depth, rtol=1e-2)
    np.testing.assert_allclose(alone, depth[::10], rtol=1e-2)


@slides
def test_depths_at_which_slip_has_vanished_are_never_reached(convention):
    turns = discs_of(VANISHING["crowned disc faster"], convention).rotations([3.9e-6, 4.0001e-6, 1e-3], 1e-16)
    assert np.isfinite(turns[0])
    assert np.all(np.isinf(turns[1:]))


@pytest.mark.parametrize("turns", [3e6, 1e7, 1e8])
def test_slip_that_turns_round_is_slid_both_ways_by_the_contact_s_width(turns):
    # This convention wears on whatever the slip.
    case = VANISHING["cylindrical disc faster"]._replace(rotations=turns)
    state, truth = worn(case, "contact-width"), integrated(case, "contact-width")
    assert float(state.flat_depth) == approx(truth["flat_depth"], rel=1e-9)
    assert truth["slip"] < 0
    assert float(state.sliding_distance) == approx(truth["sliding_distance"], rel=1e-7)


def test_working_precision_of_mpmath_is_left_alone():
    assert mpmath.mp.dps == 15


def test_depth_of_an_area_does_not_end_with_the_slip():
    # The crowned disc is faster: by itself it would wear by 0.1 % of its radius, 4 µm, until the slip is gone.
    pair = discs_of(TABLE_3, "full-slip", slip=-1e-3)
    lasting = discs_of(TABLE_3, "contact-width", slip=-1e-3)
    assert float(pair.depth_of_area(4e-8)) == float(lasting.depth_of_area(4e-8)) > 4e-5
    assert float(pair.depth_of_width(2e-3)) == float(lasting.depth_of_width(2e-3)) > 1e-4


def test_line_load_wears_by_the_load_on_a_unit_of_length():
    """κ = 1: dh₁/dN = k₁·F_N/2a, with a_z and so u of Hertz's contact between cylinders."""
    load, crown, radius, modulus, k = 0.3, 4e-3, 4e-3, 8.47e10, 1e-16
    pair = DiscPair(load, crown, radius, radius, modulus, 0.1, "line-load")

    def half_width(depth: float) -> float:
        def excess(a: float) -> float:
            a_z = np.sqrt(4 * load / (2 * a) * (radius - depth) * radius / (2 * radius - depth) / (np.pi * modulus))
            return crown - np.sqrt(crown**2 - a**2) - depth - load / (2 * modulus * np.sqrt(a * a_z))

        return brentq(excess, 1e-8, crown / 2, xtol=1e-18)

    truth = solve_ivp(
        lambda _, h: [k * load / (2 * half_width(h[0]))], (0, 2e6), [0.0], rtol=1e-9, atol=1e-16, method="DOP853"
    )
    assert float(pair.worn(2e6, k).curved_depth) == approx(truth.y[0, -1], rel=1e-7)
    steps = published_wear(pair, np.diff(np.geomspace(1, 2e6, 4001), prepend=0), k)
    assert steps.curved_depth[-1] == approx(truth.y[0, -1], rel=2e-3)
    printed = replace(pair, distance="contact-width")
    ratios = [float(printed.worn(n, k).curved_depth / pair.worn(n, k).curved_depth) for n in (2e6, 2e8, 2e10)]
    assert np.all(np.diff(ratios) > 0)
    assert ratios[-1] == approx((np.pi / 4) ** (2 / 3), rel=2e-3)
