"""Units: text to SI and back to the last digit, in every spelling a lab writes, and one sentence for all else."""

import math
import re
import string
from fractions import Fraction
from functools import partial

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tribopipe.base.errors import UnitError
from tribopipe.base.ordinary_units import ORDINARY
from tribopipe.base.units import (
    KINDS,
    _by_pint,
    _cleaned,
    _unit,
    from_si,
    interval_from_si,
    is_unit,
    parse,
    parse_interval,
    pretty,
    show,
    show_interval,
    to_si,
)

FACTORS = {  # unit: kind and SI units in it
    "m": ("length", "1"),
    "mm": ("length", "1/1000"),
    "um": ("length", "1/1000000"),
    "nm": ("length", "1/1000000000"),
    "inch": ("length", "254/10000"),
    "km": ("distance", "1000"),
    "mm/s": ("speed", "1/1000"),
    "m/min": ("speed", "1/60"),
    "min": ("time", "60"),
    "h": ("time", "3600"),
    "mN": ("force", "1/1000"),
    "kgf": ("force", "980665/100000"),
    "GPa": ("pressure", "1000000000"),
    "N/mm^2": ("pressure", "1000000"),
    "g/cm^3": ("density", "1000"),
    "MPa*m^0.5": ("toughness", "1000000"),
    "%": ("percentage", "1/100"),
    "kHz": ("frequency", "1000"),
    "nm/min": ("drift rate", "1/60000000000"),
    "mm^3/(N*mm)": ("wear coefficient", "1/1000000"),
    "mm^3/(N*m)": ("wear coefficient", "1/1000000000"),
}


def in_si(number: str, unit: str) -> float:
    return float(Fraction(number) * Fraction(FACTORS[unit][1]))


@pytest.mark.parametrize("kind", KINDS)
def test_examples_and_units_shown_are_of_their_kind(kind):
    assert math.isfinite(parse(KINDS[kind].example, kind))
    assert to_si(1.0, KINDS[kind].si, kind) == 1.0
    assert is_unit(KINDS[kind].shown)


@given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(sorted(FACTORS)))
@example(3.21, "g/cm^3")
@example(120.0, "nm")
@example(11.0, "nm/min")
def test_parse_is_exact_to_the_last_digit(number, unit):
    try:
        expected = in_si(repr(number), unit)
    except OverflowError:
        with pytest.raises(UnitError, match="not finite"):
            parse(f"{number!r} {unit}", FACTORS[unit][0])
    else:
        assert parse(f"{number!r} {unit}", FACTORS[unit][0]) == expected


@given(st.floats(1e-200, 1e200), st.sampled_from(sorted(FACTORS)))
def test_columns_convert_as_single_numbers_do_and_back(number, unit):
    kind = FACTORS[unit][0]
    column = to_si(np.array([number, -number, 0.0, math.nan]), unit, kind)
    assert column[:3] == pytest.approx([in_si(repr(number), unit), -in_si(repr(number), unit), 0.0], rel=1e-15)
    assert np.isnan(column[3])
    back = from_si(column, KINDS[kind].si, unit)
    assert back[:3] == pytest.approx([number, -number, 0.0], rel=1e-15)
    assert interval_from_si(float(column[0]), KINDS[kind].si, unit) == back[0]


@pytest.mark.parametrize(
    ("text", "kelvin"),
    [("0 degC", 273.15), ("23 °C", 296.15), ("23 ℃", 296.15), ("-40 degF", 233.15), ("300 K", 300.0)],
)
def test_temperatures_have_an_offset(text, kelvin):
    assert parse(text, "temperature") == kelvin


def test_temperature_differences_have_none():
    assert parse_interval("0.5 degC", "temperature", of=296.15) == 0.5
    assert parse_interval("0.9 degF", "temperature", of=296.15) == pytest.approx(0.5)
    assert interval_from_si(0.5, "K", "degC") == 0.5
    assert from_si(296.15, "K", "degC") == pytest.approx(23)
    assert show(296.15, 0.5, "K", "degC") == "23.00 ± 0.50 °C"


@pytest.mark.parametrize(
    ("text", "kind", "of", "expected"),
    [
        ("1 %", "force", 0.2, 0.002),
        ("1 %", "length", -4e-6, 4e-8),
        ("2 um", "length", 1.0, 2e-6),
        ("5 %", "percentage", 0.45, 0.05),
        ("0.01", "ratio", 0.24, 0.01),
        ("10 %", "ratio", 0.5, 0.05),
        ("10 %", "ratio", -5.0, 0.5),
        ("1 %", "count", 1e6, 1e4),
    ],
)
def test_uncertainties_are_absolute_or_a_share(text, kind, of, expected):
    assert parse_interval(text, kind, of=of) == pytest.approx(expected, rel=1e-15)


SPELLINGS = {
    "length": (1e-6, ["1 um", "1um", " 1  um ", "1 µm", "1 μm", "1 micron", "1e-3 mm", "+1.0 um", ".1e1 um", "1. um"]),
    "wear coefficient": (
        1e-6,
        [
            "1 mm^3/(N*mm)",
            "1 mm^3/(N mm)",
            "1 mm**3/(N mm)",
            "1 mm³/(N·mm)",
            "1 mm³/(N⋅mm)",
            "1 mm^3 / (N mm)",
            "1 mm³ N⁻¹ mm⁻¹",
            "1 mm^3*N^-1*mm^-1",
            "1 mm²/N",
            "1 mm^2/N",
            "1 mm2/N",
            "1e-6 m^2/N",
            "1 mm3/Nmm",
            "1 mm^3/N mm",
            "1 mm³/N·mm",
            "1000 mm^3/(N*m)",
            "1000 mm³/(N·m)",
            "1000 mm³/N·m",
            "1000 mm3/Nm",
            "1e3 mm³ N⁻¹ m⁻¹",
        ],
    ),
    "toughness": (1e6, ["1 MPa*m^0.5", "1 MPa m^0.5", "1 MPa*m^(1/2)", "1 MPa·m½", "1e6 Pa*m^0.5"]),
    "density": (1000.0, ["1 g/cm^3", "1 g/cm³", "1 g/cm**3", "1 g cm⁻³", "1000 kg/m³", "1 kg/dm^3"]),
    "speed": (0.4, ["400 mm/s", "0.4 m/s", "0.4 m*s^-1", "0.4 m s⁻¹", "24 m/min", "0.4 m.s^-1", "0.4 m . s^-1"]),
    "ratio": (0.24, ["0.24", "24 %", "24%", "0.24 1", "0.24 -"]),
    "frequency": (10.0, ["10 Hz", "10 1/s", "600 1/min", "10 s^-1"]),
}


@pytest.mark.parametrize(("kind", "text"), [(kind, text) for kind, (_, texts) in SPELLINGS.items() for text in texts])
def test_spelling_is_understood(kind, text):
    assert parse(text, kind) == SPELLINGS[kind][0]


@pytest.mark.parametrize(("kind", "unit"), [(kind, unit) for kind, known in KINDS.items() for unit in known[:2]])
def test_units_as_shown_to_people_can_be_written_again(kind, unit):
    assert parse(f"2 {pretty(unit)}", kind) == parse(f"2 {unit}", kind)


REFUSED = {
    "200": ("force", "without a unit.*'200 mN'"),
    "200 mm": ("force", "'mm'.*not a unit of force.*'mN'"),
    "200 kg": ("force", "'kg'.*not a unit of force"),
    "200 mNn": ("force", "'mNn'.*not a unit"),
    "0,794 mm": ("length", "'0,794 mm'.*'0.794 mm'.*point"),
    "1,000.5 mm": ("length", "not a number with a unit"),
    "mm": ("length", "'mm'.*not a number with a unit"),
    "": ("length", "''.*not a number"),
    "0.24 mm": ("ratio", "'mm'.*not a unit of ratio"),
    "nan mm": ("length", "not a number"),
    "inf mm": ("length", "not a number"),
    "1e400 mm": ("length", "not finite in m"),
    "1e9999999999999999999999 mm": ("length", "not finite in m"),
    "2 3 mm": ("length", "'3 mm'.*not a unit"),
    "2 * 3 mm": ("length", "not a unit"),
    "5 MPa√m": ("toughness", "'MPa√m'.*not a unit.*'MPa\\*m\\^0.5'"),
    "5 mm$": ("length", "'mm\\$'.*not a unit"),
    "5 m^9^9^9": ("length", "not a unit"),
    "5 9**9**9**9": ("ratio", "not a unit"),
    "5 km^(99999999)": ("length", "not a unit"),
    "5 " + "m*" * 40 + "m": ("length", "not a unit"),
    "3 dB": ("ratio", "'dB'.*not a unit"),
    "3 Np": ("ratio", "'Np'.*not a unit"),
    "5 __import__('os')": ("ratio", "not a unit"),
}


@pytest.mark.parametrize("text", REFUSED)
def test_text_is_refused_with_what_was_expected(text):
    kind, words = REFUSED[text]
    with pytest.raises(UnitError, match=words) as refused:
        parse(text, kind)
    assert "expected" in str(refused.value)
    assert "\n" not in str(refused.value)


UNIT_LIKE = st.text(alphabet="0123456789.eE+-*/^() %°·µ³⁻mNsPakgrd" + string.ascii_letters, max_size=45)


QUANTITY_LIKE = st.one_of(st.text(), UNIT_LIKE, st.builds("{} {}".format, st.floats(), UNIT_LIKE))


@given(QUANTITY_LIKE, st.sampled_from(sorted(KINDS)), st.sampled_from([parse, partial(parse_interval, of=1.0)]))
def test_any_text_is_a_number_or_refused_in_one_sentence(text, kind, read):
    try:
        found = read(text, kind)
    except UnitError as error:
        found = str(error)
    assert isinstance(found, float) or found.isprintable()


@given(st.one_of(st.text(), UNIT_LIKE))
def test_any_text_is_a_unit_or_none(text):
    if is_unit(text):
        assert not text.strip().isdigit() or text.strip() == "1"


@pytest.mark.parametrize(
    ("value", "uncertainty", "si", "unit", "shown"),
    [
        (2.3372637e-5, None, "m", "um", "23.37 µm"),
        (2.3372637e-5, 0.0, "m", "um", "23.37 µm"),
        (2.3372637e-5, 2.49e-7, "m", "um", "23.37 ± 0.25 µm"),
        (2.3372637e-5, 9.96e-8, "m", "um", "23.37 ± 0.10 µm"),
        (2.3372637e-5, 3.1e-5, "m", "um", "23 ± 31 µm"),
        (-3e-12, 1.4e-12, "m/s", "nm/min", "-0.180 ± 0.084 nm/min"),
        (0.0, 1e-9, "m", "um", "0.0000 ± 0.0010 µm"),
        (1.35e-14, 2.1e-16, "m^2/N", "mm^3/(N*mm)", "(1.350 ± 0.021)×10⁻⁸ mm³/(N·mm)"),
        (1.35e-14, None, "m^2/N", "mm^3/(N*mm)", "1.35×10⁻⁸ mm³/(N·mm)"),
        (0.496, 0.012, "1", None, "0.496 ± 0.012"),
        (0.45, None, "1", "%", "45 %"),
        (304e9, 6.08e9, "Pa", "GPa", "304.0 ± 6.1 GPa"),
        (500.0, None, "m", None, "500 m"),
        (7e6, None, "Pa*m^0.5", "MPa*m^0.5", "7 MPa·m½"),
        (3210.0, None, "kg/m^3", "g/cm^3", "3.21 g/cm³"),
        (123456.0, 1234.0, "m", "m", "(1.235 ± 0.012)×10⁵ m"),
        (667.3, 111.2, "m", "m", "670 ± 110 m"),
        (667.3, 99.6, "m", "m", "670 ± 100 m"),
        (-3.0, 1234.0, "m", "m", "0 ± 1200 m"),
        (20000.0, None, "s", "s", "20000 s"),
        (99999.0, None, "s", "s", "1×10⁵ s"),
    ],
)
def test_shown_with_two_digits_of_the_uncertainty(value, uncertainty, si, unit, shown):
    assert show(value, uncertainty, si, unit) == shown


@given(st.floats(-1e12, 1e12), st.one_of(st.none(), st.floats(0, 1e12)))
def test_anything_can_be_shown(value, uncertainty):
    text = show(value, uncertainty, "m", "mm")
    assert text.endswith(" mm")
    assert ("±" in text) == bool(uncertainty and uncertainty > 1e-12 * abs(value))


@given(st.floats(1e-6, 1e6), st.floats(1e-3, 0.5))
def test_shown_numbers_keep_two_digits_of_the_uncertainty(value, relative):
    number, _, spread = show(value, relative * value, "m").removesuffix(" m").replace("(", "").partition(" ± ")
    spread, _, power = spread.partition(")×10")
    scale = 10.0 ** int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or "0")
    assert float(spread) * scale == pytest.approx(relative * value, rel=0.051)
    assert abs(float(number) * scale - value) <= 0.051 * relative * value


def test_nothing_is_shown_without_a_sign():
    assert show(-0.02, 1.7, "m") == "0.0 ± 1.7 m"
    assert show(-0.2, 1.7, "m") == "-0.2 ± 1.7 m"


ONCE_A_SECOND = [
    *("60 rpm", "60 1/min", "60 min^-1", "1 Hz", "1 1/s", "6.283185307179586 rad/s", "360 deg/s"),
    *("1 rps", "60 rev/min", "60 U/min", "60 cycles/min", "1 cycle/s", "1 turn/s"),
]


@pytest.mark.parametrize("text", ONCE_A_SECOND)
def test_rotational_speeds_without_an_angle_are_revolutions(text):
    assert parse(text, "rotational speed") == pytest.approx(2 * math.pi)


@pytest.mark.parametrize("text", ONCE_A_SECOND)
def test_a_revolution_is_a_cycle_of_a_frequency(text):
    assert parse(text, "frequency") == pytest.approx(1.0)


@pytest.mark.parametrize("unit", ["gr", "mgr", "gr/cm^3", "gr*m"])
def test_grams_that_may_be_grains_are_refused(unit):
    """A mass loss of "1.2 gr" was 78 mg."""
    assert not is_unit(unit)
    with pytest.raises(UnitError, match="not a unit"):
        parse(f"1.2 {unit}", "mass")


@pytest.mark.parametrize("text", ["3 cycles", "3 cycle", "3 turns", "3 revolutions", "3e-3 kcycle", "1080 deg", "3"])
def test_a_revolution_is_one_of_a_count(text):
    """pint counts it in radians: cycles in a column gave 2π times the sliding distance."""
    number, _, unit = text.partition(" ")
    assert parse(text, "count") == pytest.approx(3, rel=1e-15)
    assert to_si(np.array([float(number)]), unit, "count") == pytest.approx(3, rel=1e-15)


@pytest.mark.parametrize(
    "text", ["0.2 Nm", "200 mNm", "200 Nmm", "20 Ncm", "0.2 N m", "200 N·mm", "0.2 N*m", "20 cNm", "0.2 N-m"]
)
def test_torques_are_read_as_labs_write_them(text):
    assert parse(text, "torque") == pytest.approx(0.2)


@pytest.mark.parametrize("unit", ["ft-lb", "lb-ft", "ft·lbf", "lbf ft", "ft.lbs", "Ft-Lbs"])
def test_pounds_in_torques_are_forces(unit):
    assert parse(f"1 {unit}", "torque") == pytest.approx(0.3048 * 0.45359237 * 9.80665)
    assert parse(f"12 {unit.casefold().replace('ft', 'in')}", "torque") == pytest.approx(1.3558179483)


def test_the_unit_of_a_dead_weight_is_suggested():
    with pytest.raises(UnitError, match="or 'kgf' for a dead weight"):
        parse("4 kg", "force")


def test_a_nanometer_is_no_torque():
    assert parse("120 nm", "length") == 1.2e-7


# --- intervals ---


@pytest.mark.parametrize(
    ("low", "high", "unit", "written"),
    [
        (1.927e-15, 2.06e-15, "mm^3/(N*mm)", "(1.927 to 2.060)×10⁻⁹ mm³/(N·mm)"),
        (9.724e-15, 1.065e-14, "mm^3/(N*mm)", "(0.972 to 1.065)×10⁻⁸ mm³/(N·mm)"),
        (3.544e-18, 1.187e-17, "mm^3/(N*mm)", "(3.5 to 11.9)×10⁻¹² mm³/(N·mm)"),
        (1e-18, 1e-14, "mm^3/(N*mm)", "(0.001 to 10.000)×10⁻⁹ mm³/(N·mm)"),
        (0.0, 1e-8, "m^2/N", "(0.0 to 10.0)×10⁻⁹ m²/N"),
        (-1e-9, 1e-9, "m^2/N", "(-1.00 to 1.00)×10⁻⁹ m²/N"),
        (-0.001, 4.0, "m", "0.0 to 4.0 m"),
        (22.9e-6, 23.9e-6, "um", "22.90 to 23.90 µm"),
        (99e3, 101e3, "1", "(0.9900 to 1.0100)×10⁵"),
        (5.0, 5.0, "m", "5 to 5 m"),
        (1e-30, 1e-8, "m", "1×10⁻³⁰ to 1×10⁻⁸ m"),
    ],
)
def test_an_interval_has_one_power_and_as_many_decimals_for_both_ends(low, high, unit, written):
    si = {"mm^3/(N*mm)": "m^2/N", "um": "m"}.get(unit, unit)
    assert show_interval(low, high, si, unit) == written


@given(st.floats(1e-20, 1e9), st.floats(1.001, 1e4))
@example(0.001, 1.001)
@example(0.001953125, 1.001953125)
def test_both_ends_of_an_interval_can_be_read_back(low, ratio):
    high = low * ratio
    written = show_interval(low, high, "1")
    found = re.fullmatch(r"\(?([\d.]+) to ([\d.]+)\)?(?:×10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))?", written)
    assert found is not None, written
    power = int(found[3].translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))) if found[3] else 0
    read = [float(end) * 10.0**power for end in found.groups()[:2]]
    assert 0 < read[0] < read[1]
    assert read == pytest.approx([low, high], abs=0.02 * (high - low))
    assert len({len(end.partition(".")[2]) for end in found.groups()[:2]}) == 1


# --- ordinary units, read without pint ---


@pytest.mark.parametrize("unit", ORDINARY)
def test_ordinary_units_are_what_pint_makes_of_them(unit):
    assert _cleaned(unit) == unit
    assert _unit(unit) == _by_pint(unit)


@pytest.mark.parametrize("kind", KINDS.values())
def test_every_kind_is_read_in_ordinary_units(kind):
    assert {_cleaned(kind.si), _cleaned(kind.shown)} <= {*ORDINARY, "1"}
