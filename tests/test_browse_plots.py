"""Plots of the pages against what the archive holds, and what is left of a curve against all of it."""

import json
import shutil
from dataclasses import replace

import h5py
import numpy as np
import pytest
from archived_files import edited
from browse_client import serving
from folders import DISC_PAIR
from hypothesis import assume, example, given
from hypothesis import strategies as st

from tribopipe.archive.store import Archive
from tribopipe.browse.answers import plot_answer
from tribopipe.browse.file_cache import Kept, RunFile
from tribopipe.browse.plots import run_axes, run_plots
from tribopipe.browse.responses import encoded
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline.archived_results import archived_correction
from tribopipe.pipeline.stages import advance
from tribopipe.results.evaluation import COVERAGE_FACTOR, FrictionFit
from tribopipe.results.wear_fit import WearFit
from tribopipe.views.decimation import Window, shown
from tribopipe.views.plot import RATIO, Curve, Panel, Plot
from tribopipe.views.run_plots import PIN_WEAR, WANDER, WANDER_NAME

RUN = "si3n4-air-200mN"
DISC_RUNS = DISC_PAIR
columns = st.lists(st.floats(-1e3, 1e3) | st.just(np.nan), min_size=1, max_size=200).map(np.array)


def drawn(x, y, window, lower=None, upper=None):
    """Return the one line of a plot of these numbers, as the page gets it."""
    curve = Curve("line", "measured", x, y, RATIO, "run", lower=lower, upper=upper)
    plot = plot_answer("plot", Plot("", "", "x", "", (Panel("", RATIO, (curve,)),)), window)
    return json.loads(encoded(plot))["panels"][0]["lines"][0]


@given(columns, st.integers(1, 30))
def test_each_column_of_pixels_keeps_its_extremes(y, width):
    x = np.arange(len(y), dtype=float)
    part = shown(x, (x[0], x[-1]), width)
    kept = part.thinned(y)
    assert len(kept.x) <= 3 * width + 2
    assert set(zip(kept.x, np.nan_to_num(kept.y, nan=-1e9), strict=True)) <= set(
        zip(x, np.nan_to_num(y, nan=-1e9), strict=True)
    )
    assert (kept.x[0], kept.x[-1]) == (x[0], x[-1])
    for places in np.split(np.arange(len(y)), [] if part.starts is None else part.starts[1:]):
        of_column = kept.y[np.isin(kept.x, x[places])]
        if np.isfinite(y[places]).any():
            assert (np.nanmin(of_column), np.nanmax(of_column)) == (np.nanmin(y[places]), np.nanmax(y[places]))
        else:
            assert np.isnan(of_column).all()


@example(np.array([-1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), 0.0, 1.0, 1)
@given(columns, columns, st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.integers(1, 30))
def test_an_axis_that_goes_back_shows_all_that_lies_in_the_window(x, y, one, other, width):
    x, y = x[: len(y)], y[: len(x)]
    span = min(one, other), max(one, other)
    assume(span[0] < span[1])
    kept = shown(x, span, width).thinned(y)
    inside = (x >= span[0]) & (x <= span[1]) & np.isfinite(y)
    seen = np.isfinite(kept.y) & (kept.x >= span[0]) & (kept.x <= span[1])
    assert np.isfinite(kept.x).all()
    assert inside.any() == seen.any()
    if inside.any():
        assert (kept.y[seen].min(), kept.y[seen].max()) == (y[inside].min(), y[inside].max())


@given(columns, st.integers(1, 20))
def test_a_band_holds_the_bands_of_all_samples(y, width):
    y = np.nan_to_num(y)
    x = np.arange(len(y), dtype=float)
    part = shown(x, (x[0], x[-1]), width)
    kept = part.thinned(y, y - 1, y + 1)
    for place, low, high in zip(kept.x, kept.lower, kept.upper, strict=True):
        assert low <= y[int(place)] - 1
        assert high >= y[int(place)] + 1


def test_a_window_holds_a_sample_on_either_side():
    x = np.arange(100.0)
    line = drawn(x, x**2, Window(10.5, 20.5, 50))
    assert line["x"] == list(range(10, 22))
    assert drawn(x, x, Window(200.0, 300.0, 50))["x"] == [99.0]
    assert drawn(x, x, Window(5.0, 4.0, 50))["x"] in ([4.0, 5.0], [4.0])


def test_gaps_are_null_and_no_zero():
    y = np.where((np.arange(10_000) > 3000) & (np.arange(10_000) < 6000), np.nan, 1.0)
    line = drawn(np.arange(10_000.0), y, Window(None, None, 100))
    gap = [value for x, value in zip(line["x"], line["y"], strict=True) if 3100 < x < 5900]
    assert gap
    assert set(gap) == {None}


def test_nothing_known_is_a_plot_of_nothing():
    nothing = np.full(10_000, np.nan)
    assert drawn(np.arange(10_000.0), nothing, Window(None, None, 100))["y"].count(None) == 102 - 1
    assert drawn(nothing, nothing, Window(None, None, 100))["x"] == []
    assert drawn(np.array([]), np.array([]), Window(None, None, 100))["x"] == []


@pytest.fixture(scope="module")
def run(_processed):
    return RunFile(Archive(_processed), RUN, Kept())


def answer(run, name, against=None, **window):
    offer = next(offer for offer in run_plots(run) if offer.name == name)
    chosen = Window(window.get("start"), window.get("end"), window.get("width", 100_000))
    return json.loads(encoded(plot_answer(name, offer.drawing(against), chosen)))


def test_a_run_offers_its_plots_beside_their_steps(run):
    offers = {offer.name: offer for offer in run_plots(run)}
    assert list(offers) == ["wear", "depth", "friction", "coefficient", "signals"]
    assert {name: offer.stage for name, offer in offers.items()} == {
        "wear": "wear_fit_archard",
        "depth": "drift_correction",
        "friction": "friction_fit",
        "coefficient": "wear_fit_sarkar",
        "signals": "raw",
    }
    with run.archive.open(RUN) as file:
        assert all(file[offer.path].attrs["NX_class"] == "NXdata" for offer in offers.values())
    assert offers["wear"].axes == ("sliding_distance", "time", "sample")


def test_only_k_d_against_friction_has_words_of_its_own(run):
    words = {offer.name: answer(run, offer.name)["words"] for offer in run_plots(run) if offer.words}
    assert list(words) == ["coefficient"]
    assert "k_D·√(1 + 3μ²)" in words["coefficient"]


def test_depth_is_reading_less_drift_plus_wear(run):
    plot = answer(run, "depth")
    reading, drift, wear = plot["panels"][0]["lines"]
    assert np.allclose(np.subtract(reading["y"], drift["y"]), wear["y"], atol=1e-4)
    assert plot["panels"][0]["label"] == "depth / µm"
    corrected = archived_correction(run.archive, RUN)
    assert np.allclose(wear["y"], 1e6 * corrected.wear_depth, rtol=1e-6)
    (end,) = plot["panels"][0]["marks"]
    measured = corrected.correction.end_wear_depth
    assert end["y"] == pytest.approx(1e6 * measured.value)
    assert end["half_width"] == pytest.approx(1e6 * COVERAGE_FACTOR * measured.standard_uncertainty)
    assert end["value"] == f"{measured.shown('um')} (± u)"
    assert end["x"] == corrected.run.sliding_distance[-1]
    with h5py.File(run.path) as file:
        for line in (reading, wear):
            assert np.allclose(1e6 * file[line["path"]][()], line["y"], rtol=1e-6)


@pytest.mark.slow
def test_wander_is_drawn_beside_the_corrected_wear_where_there_is_some(run, tmp_path):
    raw, archive = run.archive.raw(RUN), Archive(tmp_path)
    wave = 0.5e-6 * np.sin(12 * np.pi * raw.sliding_distance / raw.sliding_distance[-1])
    archive.add(replace(raw, columns={**raw.columns, "depth": raw.columns["depth"] + wave}))
    advance(archive, RUN, "drift_correction", Recipe())
    (panel,) = answer(RunFile(archive, RUN, Kept()), "depth")["panels"]
    wander = panel["lines"][-1]
    assert (wander["role"], wander["name"], wander["path"]) == ("wander", WANDER_NAME, WANDER)
    assert np.allclose(wander["y"], 1e6 * archived_correction(archive, RUN).wander, atol=1e-6)
    assert "wander" not in {line["role"] for line in answer(run, "depth")["panels"][0]["lines"]}


def test_friction_is_drawn_fitted_where_it_was_fitted(run):
    above, below = answer(run, "friction")["panels"]
    fit = run.archive.result(RUN, "friction_fit", FrictionFit)
    x, fitted = np.array(above["lines"][1]["x"]), above["lines"][1]["y"]
    known = np.array([value is not None for value in fitted])
    start, end = (edge.value for edge in fit.window)
    assert (x[known][0], x[known][-1]) == (pytest.approx(start), pytest.approx(end))
    expected = fit.amplitude.value * np.exp(-x / fit.running_in_distance.value) + fit.steady_state.value
    assert np.allclose(np.array(fitted)[known].astype(float), expected[known], rtol=1e-5)
    residual = np.array(below["lines"][0]["y"], dtype=float)[known]
    assert np.std(residual) == pytest.approx(fit.residual_deviation.value, rel=0.01)


def test_wear_stands_beside_its_laws_with_their_bands(run):
    above, below = answer(run, "wear")["panels"]
    assert [(line["role"], line["law"]) for line in above["lines"]] == [
        ("measured", None),
        ("fit", "archard"),
        ("fit", "sarkar"),
    ]
    assert [line["role"] for line in below["lines"]] == ["residual", "residual"]
    for line in above["lines"][1:]:
        assert np.all(np.less_equal(line["lower"], line["y"]))
        assert np.all(np.greater_equal(line["upper"], line["y"]))
    fit = run.archive.result(RUN, "wear_fit_archard", WearFit)
    assert above["lines"][1]["y"][-1] == pytest.approx(1e6 * fit.first.fitted_end_depth.value, rel=1e-5)
    assert np.std(below["lines"][0]["y"]) > 1e6 * fit.residual_deviation.value  # which is that of block averages
    assert np.std(below["lines"][0]["y"]) == pytest.approx(np.std(drawn_less_fitted(run)), rel=0.05)


def drawn_less_fitted(run):
    wear, fitted = run.curve(PIN_WEAR), run.curve("/entry/wear_fit_archard/data/wear_depth")
    return 1e6 * (wear - fitted)


def test_a_plot_can_be_drawn_against_what_the_run_knows(run):
    for against, last in {"time": 125.0, "sample": 1250.0, "sliding_distance": 50.0}.items():
        x = answer(run, "wear", against)["x"]
        assert (x["name"], x["to"]) == (against, pytest.approx(last, rel=1e-3))
    assert answer(run, "wear", "rotations")["x"]["name"] == "sliding_distance"


def test_a_zoom_shows_every_sample(run):
    plot = answer(run, "depth", start=10.0, end=11.0, width=500)
    assert plot["samples"] == plot["points"] == 27
    assert (plot["x"]["from"], plot["x"]["to"]) == (10.0, 11.0)
    assert plot["panels"][0]["marks"] == []
    whole = answer(run, "depth", width=100)
    assert whole["samples"] == 1251
    assert whole["points"] <= 202


def test_k_d_against_friction_scatters_about_the_law(run):
    (panel,) = answer(run, "coefficient")["panels"]
    measured, archard, sarkar = panel["lines"]
    assert panel["label"] == "effective k_D / mm³/(N·mm)"
    inside = [low <= archard["y"][0] <= high for low, high in zip(measured["lower"], measured["upper"], strict=True)]
    assert np.mean(inside) > 0.7
    assert np.ptp(archard["y"]) == 0
    assert np.ptp(sarkar["y"]) > 0


@pytest.fixture
def spoilt(archive):
    """A run file to change, and how its plots are then answered."""

    def change(how):
        with edited(archive / f"{RUN}.h5") as file:
            how(file["entry"])
        return RunFile(Archive(archive), RUN, Kept())

    return change


def _only_raw(entry):
    for name in list(entry):
        if name.startswith(("wear", "drift", "friction_fit", "specific", "clean_up", "prediction")):
            del entry[name]


def test_a_run_without_any_step_shows_what_was_recorded(spoilt):
    run = spoilt(_only_raw)
    assert [offer.name for offer in run_plots(run)] == ["depth", "friction", "signals"]
    for offer in run_plots(run):
        plot = answer(run, offer.name)
        assert [len(panel["lines"]) for panel in plot["panels"]] in ([1], [1, 1])
        assert offer.path == "/entry/raw"


def test_signals_that_hold_nothing_are_drawn_as_nothing(spoilt):
    def empty(entry):
        for name in ("depth", "friction_coefficient", "normal_force", "sliding_distance"):
            entry[f"raw/{name}"][...] = np.nan

    run = spoilt(empty)
    assert run_axes(run) == ("time", "sample")
    for offer in run_plots(run):
        if offer.name != "coefficient":
            plot = answer(run, offer.name)
            assert plot["x"]["name"] == "time"
    reading = answer(run, "depth")["panels"][0]["lines"][0]
    assert set(reading["y"]) == {None}


def test_columns_without_a_meaning_are_offered(spoilt):
    def add(entry):
        kept = entry.create_group("extra_columns")
        for number, (name, values) in enumerate(
            {"<b>ch 7</b>": np.arange(1251.0), "text": np.array(["a"] * 1251, dtype=object)}.items()
        ):
            text = {"dtype": h5py.string_dtype()} if values.dtype == object else {}
            column = kept.create_dataset(f"column_{number}", data=values, **text)
            column.attrs.update(column_name=name, column_unit="")

    run = spoilt(add)
    offers = {offer.name: offer.title for offer in run_plots(run)}
    assert offers["column-0"] == "<b>ch 7</b>"
    assert "column-1" not in offers
    assert answer(run, "column-0")["panels"][0]["lines"][0]["y"][-1] == 1250.0


def test_what_clean_up_changed_stands_beside_what_was_recorded(spoilt):
    def mend(entry):
        data = entry["clean_up"].create_group("data")
        data["depth"] = entry["raw/depth"][()] * 2

    run = spoilt(mend)
    (panel,) = answer(run, "clean-up")["panels"]
    before, after = panel["lines"]
    assert np.allclose(2 * np.array(before["y"]), after["y"], rtol=1e-6)
    assert answer(run, "depth")["panels"][0]["lines"][0]["path"] == "/entry/clean_up/data/depth"


def test_a_column_of_absurd_length_is_refused(spoilt):
    def stretch(entry):
        del entry["raw/depth"]
        endless = entry["raw"].create_dataset("depth", (10**12,), dtype=float, chunks=(1 << 16,), compression="gzip")
        endless.attrs["origin"] = "measured"

    run = spoilt(stretch)
    with pytest.raises(
        Exception, match=r"found values .* at /entry/raw/depth; expected only content that tribopipe writes"
    ):
        answer(run, "depth")


def test_columns_of_other_lengths_are_refused(spoilt):
    def shorten(entry):
        del entry["raw/depth"]
        entry["raw/depth"] = np.zeros(7)
        entry["raw/depth"].attrs["origin"] = "measured"

    run = spoilt(shorten)
    with pytest.raises(Exception, match=r"found 7 values in /entry/raw/depth; expected 1,251"):
        answer(run, "depth")


def test_what_was_read_is_kept_until_the_file_changes(archive):
    kept = Kept()
    before = RunFile(Archive(archive), RUN, kept).signal("depth")
    assert RunFile(Archive(archive), RUN, kept).signal("depth") is before
    with edited(archive / f"{RUN}.h5") as file:
        file["entry/raw/depth"][...] = 1.0
    assert np.all(RunFile(Archive(archive), RUN, kept).signal("depth") == 1.0)


def test_no_more_is_kept_than_there_is_room_for():
    kept, made = Kept(room=100), []

    def make(name):
        return lambda: made.append(name) or np.zeros(5)

    for name in "abcab":
        kept.get((name,), make(name))
    assert made == ["a", "b", "c", "a", "b"]
    kept.get(("b",), make("b"))
    assert made[-2:] == ["a", "b"]
    with pytest.raises(ZeroDivisionError):
        kept.get(("d",), lambda: 1 / 0)
    assert kept.get(("d",), lambda: 1) == 1


@pytest.fixture(scope="module")
def samples(_processed, disc_pair, tmp_path_factory):
    """One archive of two pins, which are the same, and two runs of discs."""
    folder = tmp_path_factory.mktemp("both") / "archive"
    shutil.copytree(_processed, folder)
    shutil.copy(folder / f"{RUN}.h5", folder / "again.h5")
    for run_id in DISC_RUNS:
        shutil.copy(disc_pair.path(run_id), folder)
    return Archive(folder)


def test_two_discs_have_volumes_contact_and_marks(disc_pair):
    run = RunFile(disc_pair, DISC_RUNS[0], Kept())
    assert [offer.name for offer in run_plots(run)][:4] == ["wear", "contact", "depth", "friction"]
    curved, flat = answer(run, "wear")["panels"]
    assert curved["label"] == "crowned disc, wear volume / mm³"
    assert answer(run, "wear")["x"]["name"] == "rotations"
    for panel, disc in ((curved, "curved_disc"), (flat, "flat_disc")):
        (end,) = panel["marks"]
        measured = getattr(run.outline.manifest.end_values, f"{disc}_wear_volume")
        assert end["y"] == pytest.approx(1e9 * measured.value)
    for against, last in (("time", run.signal("time")[-1]), ("sample", run.outline.samples - 1)):
        marks = [one for panel in answer(run, "wear", against)["panels"] for one in panel["marks"]]
        assert [one["x"] for one in marks] == pytest.approx([last, last], rel=0.01)
    labels = [panel["label"] for panel in answer(run, "contact")["panels"]]
    assert labels == [
        "wear depth of both discs / µm",
        "mean pressure p / GPa",
        "half-width a_x / µm",
        "half-length a_z / µm",
    ]


@pytest.mark.slow
def test_wear_is_headed_by_the_body_that_wears(further_run):
    run_id = "al2o3-reciprocating-5N"
    titles = {offer.name: offer.title for offer in run_plots(RunFile(further_run(run_id), run_id, Kept()))}
    assert titles["wear"] == "Wear of the ball"


@pytest.mark.slow
def test_runs_are_compared_on_one_axis(samples):
    pins = ["again", RUN]
    with serving(samples.folder) as client:
        plot = client.get("api", "compare", "wear", runs=",".join(pins), with_="fit,prediction").json
        assert [(line["run"], line["role"]) for line in plot["panels"][0]["lines"]][:3] == [
            (pins[0], "measured"),
            (pins[0], "fit"),
            (pins[0], "fit"),
        ]
        assert len(plot["panels"]) == 1
        bare = client.get("api", "compare", "wear", runs=",".join(pins)).json
        assert [line["run"] for line in bare["panels"][0]["lines"]] == pins
        assert [end["run"] for end in bare["panels"][0]["marks"]] == pins
        mixed = client.get("api", "compare", "wear", runs=f"{RUN},{DISC_RUNS[0]}", with_="fit", x="time").json
        assert [panel["label"].partition(" /")[0] for panel in mixed["panels"]] == [
            "pin wear depth",
            "crowned disc, wear volume",
            "cylindrical disc, wear volume",
        ]
        assert mixed["x"]["name"] == "time"
        for what in ("friction", "depth"):
            assert len(client.get("api", "compare", what, runs=",".join(pins), width=100).json["panels"]) == 1
        assert client.get("api", "compare", "wear", runs="").status == 400
        assert client.get("api", "compare", "budget", runs=pins[0]).status == 400
        assert client.get("api", "compare", "wear", runs=f"{pins[0]},nobody").status == 404


@pytest.mark.slow
def test_every_plot_of_every_sample_is_answered(samples):
    for run_id in samples.ids():
        run = RunFile(samples, run_id, Kept())
        for offer in run_plots(run):
            for against in offer.axes:
                plot = json.loads(encoded(plot_answer(offer.name, offer.drawing(against), Window(None, None, 200))))
                assert plot["panels"]
                assert all(panel["lines"] for panel in plot["panels"])
                paths = [line["path"] for panel in plot["panels"] for line in panel["lines"]]
                assert {path for path in paths if path} <= set(run.datasets)
