"""Expressions that somebody types who has not read the API, and how many of them work.

The first twenty were written down before the API was read, from the habits of pandas,
xarray and lmfit; ``run`` is a run folder that was read, ``archive`` an archive that was
opened, ``fit`` a wear fit.
"""

# ruff: noqa: ARG001, ARG005 - each expectation is told the same, and a fixture may have an effect alone

import math
import pickle
import re
import shutil

import numpy as np
import pandas
import pytest
from folders import SAMPLES
from sweeps import others_slow

import tribopipe as tp
from tribopipe.base.errors import FitError, OutputError, UnitError
from tribopipe.base.units import KINDS
from tribopipe.physics.law_functions import law_of_function
from tribopipe.physics.laws import law_named
from tribopipe.results.wear_fit import WearFit

FROM_HABIT = (
    "tp.read_run(folder)",
    "run.columns",
    "run.head()",
    "run.describe()",
    "len(run)",
    "'depth' in run",
    "run.depth",
    "run['depth'].values",
    "run['depth'].mean()",
    "run['depth'].attrs['units']",
    "run.to_csv(path)",
    "run.plot()",
    "run.to_xarray()",
    "tp.open_archive(archive_path)",
    "archive.keys()",
    "archive.items()",
    "fit.params['k_d'].value",
    "fit.params['k_d'].stderr",
    "fit.residual",
    "fit.fit_report()",
)

BY_NAME = (
    "run['depth']",
    "run.frame()",
    "corrected.frame()",
    "archive['si3n4-air-200mN']",
    "len(archive)",
    "[archive[run_id] for run_id in archive]",
    "'si3n4-air-200mN' in archive",
    "archive.table()",
    "archive.table()['u_k_d']",
    "archive.table().attrs['units']['k_d']",
    "fit.plot()",
    "fit.k_d",
    "fit.k_d.to('mm^3/(N*m)')",
    "float(fit.k_d)",
    "2 * fit.k_d",
    "fit._repr_html_()",
    "repr(fit)",
    "[name for name in dir(fit) if name.startswith('model_')]",
    "tp.fit_wear(run, my_function)",
    "archive['si3n4-air-200mN'].to_datatree()",
)
"""These follow from what was asked of the API."""
NEEDS = {
    "run.to_xarray()": "xarray",
    "archive['si3n4-air-200mN'].to_datatree()": "xarray",
    "2 * fit.k_d": "uncertainties",
}
"""Packages that few need."""
REFUSED = {
    "run.depth": r"did you mean 'depth'\?; columns are items: \['depth'\]",
    "fit.params['k_d'].stderr": "found no 'stderr'; expected one of .*standard_uncertainty, to, u,",
    "fit.fit_report()": "found no 'fit_report'; expected one of .*",
}
"""Those that do not work, and what the error says."""


def my_function(s, power=1.5):
    return (1 + s / 10) ** (power - 1)


@pytest.fixture(scope="module")
def known(short_runs, _processed, tmp_path_factory, few_draws):
    """What the names of the expressions stand for."""
    folder = short_runs / "si3n4-air-200mN"
    archive_path = tmp_path_factory.mktemp("guessed") / "archive"
    shutil.copytree(_processed, archive_path)
    run = tp.read_run(folder)
    corrected = tp.correct_drift(run)
    return {
        "tp": tp,
        "folder": str(folder),
        "archive_path": str(archive_path),
        "path": tmp_path_factory.mktemp("csv") / "run.csv",
        "run": run,
        "corrected": corrected,
        "fit": tp.fit_wear(corrected),
        "archive": tp.open_archive(archive_path),
        "my_function": my_function,
    }


def evaluated(expression, known):
    return eval(expression, dict(known))  # noqa: S307 - of this file


def test_at_least_34_of_40_work():
    assert len({*FROM_HABIT, *BY_NAME}) == 40
    assert len(FROM_HABIT) == 20
    assert 40 - len(REFUSED) == 37


@pytest.mark.parametrize(
    "expression", others_slow([one for one in (*FROM_HABIT, *BY_NAME) if one not in REFUSED], first=10)
)
def test_expression_works(expression, known):
    if expression in NEEDS:
        pytest.importorskip(NEEDS[expression])
    found = evaluated(expression, known)
    run = known["run"]
    expected = EXPECTED.get(expression)
    assert expected is None or expected(found, run, known), found


def held(archive):
    with archive.open("si3n4-air-200mN") as file:
        return file["entry/raw/depth"][()]


EXPECTED = {
    "tp.read_run(folder)": lambda found, run, _: np.array_equal(found["depth"], run.columns["depth"], equal_nan=True),
    "run.columns": lambda found, run, _: list(found) == list(run),
    "run.head()": lambda found, run, _: found.shape == (5, 6),
    "run.describe()": lambda found, run, _: found["depth"]["max"] == np.nanmax(run.columns["depth"]),
    "len(run)": lambda found, run, _: found == 1251,
    "'depth' in run": lambda found, *_: found is True,
    "run['depth'].values": lambda found, run, _: np.array_equal(found, run.columns["depth"], equal_nan=True),
    "run['depth'].mean()": lambda found, run, _: found == pytest.approx(np.nanmean(run.columns["depth"])),
    "run['depth'].attrs['units']": lambda found, *_: found == "m",
    "run.to_csv(path)": lambda _, run, known: known["path"].read_text(encoding="utf-8").startswith("time [s],"),
    "run.plot()": lambda found, run, _: len(found.axes) == 4,
    "run.to_xarray()": lambda found, run, _: found["depth"].attrs == {"units": "m"} and found.sizes == {"sample": 1251},
    "tp.open_archive(archive_path)": lambda found, run, known: found.ids() == known["archive"].ids(),
    "archive.keys()": lambda found, *_: list(found) == ["si3n4-air-200mN"],
    "archive.items()": lambda found, *_: [run.id for _, run in found] == ["si3n4-air-200mN"],
    "fit.params['k_d'].value": lambda found, run, known: found == known["fit"].first.wear_coefficient.value,
    "fit.residual": lambda found, run, known: float(found.std()) < 1e-7 and found.attrs["units"] == "m",
    "run['depth']": lambda found, run, _: found.name == "depth",
    "run.frame()": lambda found, run, _: found.attrs["units"]["friction_force"] == "N",
    "corrected.frame()": lambda found, run, known: np.array_equal(
        found["wear_depth"], known["corrected"].wear_depth, equal_nan=True
    ),
    "archive['si3n4-air-200mN']": lambda found, run, known: np.array_equal(found.raw["depth"], held(known["archive"])),
    "len(archive)": lambda found, *_: found == 1,
    "[archive[run_id] for run_id in archive]": lambda found, *_: [run.id for run in found] == ["si3n4-air-200mN"],
    "'si3n4-air-200mN' in archive": lambda found, *_: found is True,
    "archive.table()": lambda found, *_: list(found["id"]) == ["si3n4-air-200mN"],
    "archive.table()['u_k_d']": lambda found, run, known: (
        found[0] == known["archive"]["si3n4-air-200mN"].fits["archard"].k_d.standard_uncertainty
    ),
    "archive.table().attrs['units']['k_d']": lambda found, *_: found == "m^2/N",
    "fit.plot()": lambda found, *_: [ax.get_ylabel() for ax in found.axes] == ["pin wear depth / µm", "residual / µm"],
    "fit.k_d": lambda found, run, known: found == known["fit"].bodies["pin"].wear_coefficient,
    "fit.k_d.to('mm^3/(N*m)')": lambda found, run, known: found.value == pytest.approx(1e9 * known["fit"].k_d.value),
    "float(fit.k_d)": lambda found, run, known: found == known["fit"].k_d.value,
    "2 * fit.k_d": lambda found, run, known: (
        (found.value, found.u) == pytest.approx((2 * known["fit"].k_d.value, 2 * known["fit"].k_d.u))
    ),
    "fit._repr_html_()": lambda found, *_: len(found.splitlines()) <= 30 and "data:image/png;base64" in found,
    "repr(fit)": lambda found, *_: len(found) < 200 and "k_D = " in found,
    "[name for name in dir(fit) if name.startswith('model_')]": lambda found, *_: found == [],
    "tp.fit_wear(run, my_function)": lambda found, *_: list(found.params) == ["k_d", "power"],
    "archive['si3n4-air-200mN'].to_datatree()": lambda found, run, known: np.array_equal(
        found["raw"]["depth"], held(known["archive"])
    ),
}
"""What each gives."""


@pytest.mark.parametrize(("expression", "said"), REFUSED.items())
def test_what_does_not_work_says_what_there_is(expression, said, known):
    with pytest.raises(AttributeError, match=said) as caught:
        evaluated(expression, known)
    assert isinstance(caught.value, tp.TribopipeError)


# --- errors name what was asked for, and what to call ---


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        ("run['dept']", "run si3n4-air-200mN: found no 'dept'; expected one of time, .*; did you mean 'depth'"),
        ("archive['si3n4-air-20mN']", "did you mean 'si3n4-air-200mN'.*archive.ids"),
        ("archive[0]", "found no 0; expected one of si3n4-air-200mN"),
        ("fit.frame()['nothing']", "nothing"),
    ],
)
def test_missing_item_is_a_key_error(expression, said, known):
    with pytest.raises(KeyError, match=said):
        evaluated(expression, known)


FURTHER = {
    "run[['time', 'depth']].shape": lambda found, known: found == (1251, 2),
    "run[['depth']].attrs['units']": lambda found, known: found == {"depth": "m"},
    "dict(run)['depth'].max()": lambda found, known: found == known["run"]["depth"].max(),
    "list(run.keys())": lambda found, known: found == list(known["run"]),
    "list(archive.values())[0].id": lambda found, known: found == "si3n4-air-200mN",
    "corrected['wear_depth'].iloc[-1]": lambda found, known: found == known["corrected"].frame()["wear_depth"].iloc[-1],
    "archive.table().set_index('id')['k_d']": lambda found, known: len(found) == 1,
    "f'{fit.k_d:.3e}'": lambda found, known: found == f"{fit_of(known).value:.3e} m²/N",
    "f'{fit.k_d.to(\"mm^3/(N*m)\"):.2e}'": lambda found, known: found.endswith(" mm³/(N·m)"),
    "f'{fit.k_d}'": lambda found, known: found == str(fit_of(known)),
    "run.manifest.conditions.normal_load.to('mN').value": lambda found, known: found == pytest.approx(200),
}
"""Expressions of users of pandas and pint, written down after the first forty."""
HINTS = {
    "run.tail()": "did you mean 'frame'",
    "run.df": "did you mean 'frame'",
    "run.iloc[0]": "did you mean 'frame'",
    "run.name": "did you mean 'id'",
    "run.conditions": "did you mean 'manifest'",
    "fit.best_values": "did you mean 'params'",
    "fit.conf_interval()": "did you mean 'bodies'",
    "fit.k_d.std_dev": "did you mean 'u'",
    "fit.k_d.magnitude": "did you mean 'value'",
    "fit.k_d.units": "did you mean 'unit'",
    "archive.query('load > 300')": "did you mean 'table'.*archive\\[run_id\\]",
    "archive.runs": "did you mean 'ids'",
    "archive['si3n4-air-200mN'].k_d": "did you mean 'fits'",
    "tp.load(folder)": "did you mean 'read_run'",
    "tp.fit(run)": "did you mean 'fit_friction' or 'fit_wear'",
    "tp.open('archive')": "did you mean 'open_archive'",
}
"""Expressions that do not work, and what the error names instead."""


def fit_of(known):
    return known["fit"].k_d


@pytest.mark.parametrize("expression", FURTHER)
def test_further_expression_works(expression, known):
    found = evaluated(expression, known)
    assert FURTHER[expression](found, known), found


@pytest.mark.parametrize(("expression", "said"), HINTS.items())
def test_names_of_other_packages_lead_to_those_here(expression, said, known):
    with pytest.raises(AttributeError, match=said):
        evaluated(expression, known)


@pytest.mark.parametrize("make", [np.asarray, pandas.DataFrame])
def test_run_is_no_array_of_its_names(make, known):
    with pytest.raises(TypeError, match=r"found a run in place of an array; expected a table; call frame\(\)"):
        make(known["run"])


@pytest.mark.parametrize("written", [("5 N",), (5, "N")])
def test_quantity_without_keywords_is_refused_in_one_sentence(written):
    with pytest.raises(TypeError, match=r"found .* without keywords; expected SI units; write tribopipe\.Quantity"):
        tp.Quantity(*written)


def test_what_is_no_run_is_refused(known):
    with pytest.raises(TypeError, match=r"found str .*call tribopipe.read_run\(folder\)"):
        tp.fit_wear(known["folder"])


def test_archive_is_true_though_empty(tmp_path):
    empty = tp.open_archive(tmp_path / "none")
    assert len(empty) == 0
    assert empty
    assert empty.table().empty


def test_csv_replaces_nothing_unless_forced(known, tmp_path):
    path = tmp_path / "run.csv"
    known["run"].to_csv(path)
    with pytest.raises(OutputError, match="found an existing file"):
        known["run"].to_csv(path)
    known["run"].to_csv(path, force=True)
    read = pandas.read_csv(path)
    assert np.array_equal(read["depth [m]"], known["run"].columns["depth"], equal_nan=True)


# --- fits know their run as long as they are in memory ---


def test_fit_is_compared_without_its_run_and_sent_without_it(known):
    fit = known["fit"]
    again = pickle.loads(pickle.dumps(fit))  # noqa: S301 - of this test
    assert again == fit
    assert fit == WearFit.model_validate_json(fit.model_dump_json())
    assert len(pickle.dumps(fit)) < 20_000
    with pytest.raises(FitError, match="read without its run"):
        again.plot()
    assert "<img" not in again._repr_html_()


def test_archived_fit_draws_what_the_archive_holds(known):
    archived = known["archive"]["si3n4-air-200mN"]
    with known["archive"].open(archived.id) as file:
        fitted = file["entry/wear_fit_sarkar/data/wear_depth"][()]
    assert np.array_equal(archived.fits["sarkar"].frame()["wear_depth"], fitted, equal_nan=True)
    assert archived.plot().axes


def test_two_bodies_have_no_single_k_d(disc_fit):
    with pytest.raises(FitError, match=r"use fit.bodies\['curved_disc'\].wear_coefficient, "):
        _ = disc_fit.k_d
    assert list(disc_fit.params) == ["k_d_curved_disc", "k_d_flat_disc"]
    with pytest.raises(KeyError, match=r"fit\.measurements"):
        _ = disc_fit.residual
    assert disc_fit.plot().axes


@pytest.fixture(scope="module")
def disc_fit(few_draws):
    return tp.fit_wear(tp.correct_drift(tp.read_run(SAMPLES / "si3n4-twin-disc-4pct-100k")))


# --- functions as wear laws ---


def test_function_finds_what_the_law_of_the_same_formula_does(known):
    def frictionless(s):
        return np.ones_like(s)

    own, archard = tp.fit_wear(known["corrected"], frictionless), known["fit"]
    assert own.k_d.value == pytest.approx(archard.k_d.value, rel=1e-6)
    assert own.k_d.u == pytest.approx(archard.k_d.u, rel=1e-3)


@pytest.mark.slow
def test_function_takes_friction(known):
    def with_junctions(s, friction):
        return np.sqrt(1 + 3 * friction**2)

    friction = tp.fit_friction(known["run"])
    own = tp.fit_wear(known["corrected"], with_junctions, friction)
    assert own.k_d.value == pytest.approx(tp.fit_wear(known["corrected"], "sarkar", friction).k_d.value, rel=1e-5)


def test_earlier_fit_keeps_its_law_where_a_function_is_written_anew(known):
    def law(factor):
        def growing(s):
            return np.full_like(s, factor)

        return growing

    first = tp.fit_wear(known["corrected"], law(1.0))
    before = first.frame()["wear_depth"]
    second = tp.fit_wear(known["corrected"], law(2.0))
    assert first.model != second.model
    assert second.k_d.value == pytest.approx(first.k_d.value / 2, rel=1e-6)
    assert np.array_equal(first.frame()["wear_depth"], before, equal_nan=True)


def archard(s):
    return np.ones_like(s)


@pytest.mark.slow
def test_function_finds_its_parameter_of_a_run_with_a_known_law():
    fit = tp.fit_wear(tp.read_run(SAMPLES / "si3n4-air-200mN"), my_function)  # simulated by Archard's law
    assert abs(fit.params["power"].value - 1) < 3 * fit.params["power"].u < 0.05
    assert abs(fit.k_d.value - 13.5e-15) < 3 * fit.k_d.u < 3e-15


def test_annotation_of_a_parameter_is_its_unit():
    def fresh(s, excess=2.0, length: "m" = 10.0):  # noqa: F821 - a unit
        return 1 + excess * np.exp(-s / length)

    law = law_named(law_of_function(fresh))
    units = {name: (KINDS[known.kind].si, known.low, known.high) for name, known in law.parameters().items()}
    assert units == {"excess": ("1", 0.02, 200.0), "length": ("m", 0.1, 1000.0)}
    assert law.effective_distance(100.0, None) == pytest.approx(100 + 2 * 10 * (1 - math.exp(-10)), rel=1e-6)


def test_function_takes_no_name_of_a_law(known):
    assert tp.fit_wear(known["corrected"], archard).model == "archard_2"


def wrong_unit(s, length: "furlong" = 1.0):  # noqa: F821 - a unit
    return s / length


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda s, a: a * s, "found the argument 'a' without a default.*write a=1.0"),
        (lambda s, a=-1.0: a * s, "found a = -1 as the starting value"),
        (lambda s: math.exp(-s), "cannot be computed for arrays.*np.exp"),
        (lambda s: 1 / s, "expected one finite factor at each distance"),
        (lambda *s: s[0], "arguments cannot be determined"),
        (3, "arguments cannot be determined"),
        (wrong_unit, "found 'furlong' as the unit of length; expected one of m, "),
    ],
)
def test_function_that_is_no_law_is_one_sentence(function, said, known):
    with pytest.raises(FitError, match=said):
        tp.fit_wear(known["corrected"], function)


def test_module_names_the_nearest_of_its_names():
    with pytest.raises(AttributeError, match="found no 'fit_ware'; expected one of Archive, ") as caught:
        tp.fit_ware  # noqa: B018
    assert str(caught.value).endswith("did you mean 'fit_wear'?")
    assert not hasattr(tp, "__wrapped__")


# --- quantities ---

K_D = tp.Quantity(value=1.358e-14, unit="m^2/N", standard_uncertainty=2.5e-16)


def test_quantity_is_converted_and_never_taken_for_another_unit():
    rate = K_D.to("mm³/(N·m)")
    assert (rate.value, rate.u) == pytest.approx((1.358e-5, 2.5e-7), rel=1e-15)
    assert str(rate) == "(1.358 ± 0.025)×10⁻⁵ mm³/(N·m)"
    assert not isinstance(rate, tp.Quantity)
    with pytest.raises(TypeError, match=r"use \.value"):
        float(rate)
    assert tp.Quantity(value=296.15, unit="K", standard_uncertainty=1.0).to("degC").value == pytest.approx(23)
    assert tp.Quantity(value=math.tau, unit="rad/s").to("1/min").value == pytest.approx(60)
    with pytest.raises(UnitError, match="found the unit 'mm', which is not a unit of wear coefficient"):
        K_D.to("mm")


@pytest.mark.slow
def test_quantities_compute_with_their_uncertainty():
    pytest.importorskip("uncertainties")
    load = tp.Quantity(value=0.2, unit="N", standard_uncertainty=0.002)
    volume = K_D * load * tp.Quantity(value=500.0, unit="m")
    relative = math.hypot(0.025 / 1.358, 0.01)
    assert (volume.value, volume.u, volume.unit) == pytest.approx((1.358e-12, relative * 1.358e-12, "m^3"))
    assert volume.to("mm^3").value == pytest.approx(1.358e-3)
    difference = K_D - K_D
    assert (difference.value, difference.u) == (0, 0)
    assert (2 * K_D - K_D).u == pytest.approx(K_D.u)
    assert float(K_D / K_D) == 1
    assert (1 / load).unit == "1/N"
    with pytest.raises(TypeError, match=r"use \.value"):
        float(volume)
    with pytest.raises(UnitError, match="incompatible units"):
        K_D + load
    with pytest.raises(TypeError):
        np.array([1.0, 2.0]) * K_D


CYCLES = [
    *(("rad/s", unit) for unit in ("Hz", "kHz", "1/min", "1/s", "rpm", "deg/s", "rev/s", "rad/s")),
    *(("1/s", unit) for unit in ("Hz", "1/min")),
]


@pytest.mark.parametrize(("si", "unit"), CYCLES)
def test_computed_rotational_speeds_and_frequencies_are_converted_as_quantities_are(si, unit):
    pytest.importorskip("uncertainties")
    quantity = tp.Quantity(value=34.3, unit=si, standard_uncertainty=0.1)
    direct, computed = quantity.to(unit), (1 * quantity).to(unit)
    assert (computed.value, computed.u) == pytest.approx((direct.value, direct.u), rel=1e-12)


def test_computed_values_per_second_are_cycles_or_radians_only_where_this_is_known():
    pytest.importorskip("uncertainties")
    speed, radius = tp.Quantity(value=0.4, unit="m/s"), tp.Quantity(value=8e-3, unit="m")
    turning = tp.Quantity(value=50.0, unit="rad/s")
    assert (1 * turning).to("rpm").to("Hz").to("rad/s").value == pytest.approx(50)
    assert (turning * radius).to("mm/s").value == pytest.approx(400)
    assert (speed / radius).to("1/min").value == pytest.approx(3000)
    assert (speed / radius).to("Hz").to("rpm").value == pytest.approx(3000)
    with pytest.raises(UnitError, match="unit 'rpm' for a value in 1/s, which may count radians or cycles"):
        (speed / radius).to("rpm")


def test_quantity_of_pint_never_takes_one_for_a_number():
    import pint

    load = tp.Quantity(value=0.2, unit="N")
    mixed = pint.application_registry.Quantity(2.0, "N") * load
    assert not isinstance(mixed.magnitude, float)  # 0.4 N would be a wrong number
    assert mixed.magnitude.unit == "N"


def test_copy_of_a_quantity_computes_with_its_own_value():
    load = tp.Quantity(value=0.2, unit="N")
    assert load.uncertain is load.uncertain
    twice = load.model_copy(update={"value": 0.4})
    assert (twice - load).value == pytest.approx(0.2)
    assert load.model_copy() == load == tp.Quantity.model_validate_json(load.model_dump_json())
    assert pickle.loads(pickle.dumps(load)) == load  # noqa: S301 - of this test


@pytest.mark.slow
def test_reprs_are_short_and_completion_is_the_records_own(known):
    for thing in (known["run"], known["corrected"], known["fit"], known["archive"]["si3n4-air-200mN"], K_D):
        assert "\n" not in repr(thing)
        assert len(repr(thing)) < 300
        assert not {"model_dump", "model_fields", "copy", "json", "kinds"} & set(dir(thing))
    assert {"value", "unit", "standard_uncertainty", "to", "shown"} <= set(dir(K_D))
    for thing in (known["run"], known["corrected"], known["fit"], known["archive"]):
        shown = thing._repr_html_()
        assert len(shown.splitlines()) <= 30
        # VS Code and Colab show it too: it brings its figure with it, and runs and loads nothing.
        assert not re.search(r"<script|<link|https?://", shown)
