"""Figures hold what they say, look the same each time, and are drawn from whatever a run has."""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from folders import FURTHER_IDS, SAMPLE_IDS
from matplotlib import rc_context
from PIL import Image
from sweeps import others_slow

from tribopipe.archive.store import Archive
from tribopipe.documents.preprocessing import AUTOMATIC, Change, CleanUp, Invert
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.documents.signals import SIGNALS
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.preprocessing.cleaning import clean_run
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.prediction import fitted_curves
from tribopipe.pipeline.archived_results import archived_correction, archived_friction
from tribopipe.pipeline.stages import advance
from tribopipe.views.archived_figures import RUN_CAPTIONS, run_is_drawn, save_run_figures
from tribopipe.views.clean_up_figures import plot_clean_up
from tribopipe.views.decimation import thinned
from tribopipe.views.html.document import run_report
from tribopipe.views.run_figures import plot_depth, plot_friction, plot_wear, save_figure
from tribopipe.views.run_page import results_table
from tribopipe.views.run_plots import WANDER_NAME, depth_panels, friction_panels


@pytest.mark.parametrize("run_id", others_slow(["si3n4-air-800mN", "wc-co-water-400mN"], "si3n4-air-800mN"))
def test_every_archived_run_gets_its_three_figures(sample_archive, run_id):
    written = save_run_figures(sample_archive, run_id)
    assert [path.name for path in written] == [f"{run_id}-{what}.png" for what in ("depth", "friction", "wear")]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in written)


def labels(figure) -> set[str]:
    return {text.get_text() for legend in figure.legends for text in legend.get_texts()}


@pytest.mark.slow
def test_wear_figure_shows_laws_end_value_and_residuals(sample_archive):
    corrected, friction = (
        archived_correction(sample_archive, SAMPLE_IDS[0]),
        archived_friction(sample_archive, SAMPLE_IDS[0]),
    )
    curves = [
        fitted_curves(corrected.run, fit_wear(corrected, law, friction), friction) for law in ("archard", "sarkar")
    ]
    figure = plot_wear(corrected, curves)
    assert labels(figure) >= {"corrected pin wear", "Archard, fitted", "Sarkar, fitted"}
    upper, lower = figure.axes
    assert upper.get_ylabel() == "pin wear depth / µm"
    assert lower.get_xlabel() == "sliding distance s / m"
    archard = next(line for line in upper.lines if line.get_label() == "Archard, fitted")
    assert archard.get_ydata()[-1] == pytest.approx(curves[0].bands["wear_depth"].best[-1] * 1e6)


def test_figures_of_a_run_without_end_value_and_friction_say_what_is_missing(sample_archive):
    raw = sample_archive.raw(SAMPLE_IDS[0])
    end = raw.manifest.end_values.model_copy(update={"pin_scar_diameter": None})
    bare = replace(
        raw,
        manifest=raw.manifest.model_copy(update={"end_values": end}),
        columns={name: raw.columns[name] for name in ("time", "sliding_distance", "depth")},
    )
    in_two_steps = Recipe(wear=WearRecipe(correction="two-step"))
    assert "missing a post-test" in plot_depth(correct_drift(bare, in_two_steps)).axes[0].texts[0].get_text()
    assert "has no friction signal" in plot_friction(bare, fit_friction(bare)).axes[0].texts[0].get_text()


@pytest.mark.slow
def test_depth_figure_draws_wander_where_there_is_some(sample_archive, tmp_path):
    run = sample_archive.raw(SAMPLE_IDS[0])
    wave = 1e-6 * np.sin(12 * np.pi * run.sliding_distance / run.sliding_distance[-1])
    wavy, archive = replace(run, columns={**run.columns, "depth": run.columns["depth"] + wave}), Archive(tmp_path)
    archive.add(wavy)
    advance(archive, run.id, "drift_correction", Recipe())
    assert WANDER_NAME not in labels(plot_depth(archived_correction(sample_archive, run.id)))
    figure = plot_depth(archived_correction(archive, run.id))
    drawn = next(line for line in figure.axes[0].lines if line.get_label() == WANDER_NAME)
    kept = archived_correction(archive, run.id).wander
    assert np.allclose(drawn.get_ydata(), np.interp(drawn.get_xdata(), run.sliding_distance, 1e6 * kept))
    assert np.corrcoef(kept, wave)[0, 1] > 0.7  # offset, drift and wear take some of a wave


def test_a_long_sentence_leaves_the_figure_its_width(sample_archive):
    raw = sample_archive.raw(SAMPLE_IDS[0])
    fit = fit_friction(raw).model_copy(update={"outcome": "steady-only", "notes": (100 * "so ", "mean of the half")})
    (words,) = plot_friction(raw, fit).axes[0].texts
    assert max(map(len, words.get_text().splitlines())) <= 90


def test_friction_without_a_known_distance_is_one_panel_against_time(sample_archive):
    raw = sample_archive.raw(SAMPLE_IDS[0])
    run = replace(
        raw,
        columns={**raw.columns, "sliding_distance": np.full(len(raw), np.nan)},
        origins={**raw.origins, "sliding_distance": "unknown"},
    )
    fit = fit_friction(run)
    (ax,) = plot_friction(run, fit).axes
    assert ax.get_xlabel() == "time / s"
    steady = next(line for line in ax.lines if line.get_label() == "steady-state value b")
    assert set(steady.get_ydata()) == {fit.steady_state.value}
    assert ax.texts[0].get_text().endswith("sliding distance unknown")
    assert "\n" not in ax.texts[0].get_text()


def reciprocating(raw):
    """Let the friction of a run go there and back, 25 samples a stroke."""
    there = np.where(np.arange(len(raw)) // 25 % 2, -1.0, 1.0)
    stroke = {"stroke": Quantity(value=5e-3, unit="m")}
    manifest = raw.manifest.model_copy(update={"conditions": raw.manifest.conditions.model_copy(update=stroke)})
    columns = {name: raw.columns[name] * there for name in ("friction_force", "friction_coefficient")}
    return replace(raw, manifest=manifest, columns={**raw.columns, **columns})


def test_figures_say_what_was_cleaned_up(sample_archive):
    raw = reciprocating(sample_archive.raw(SAMPLE_IDS[0]))
    cleaned = clean_run(raw, Recipe(clean_up=(*AUTOMATIC, Invert(signals=("depth",)))))
    fit = fit_friction(cleaned.run)
    assert "measured, preprocessed: one value per stroke" in labels(plot_friction(cleaned.run, fit, cleaned.record))
    assert "measured" in labels(plot_friction(cleaned.run, fit))
    assert "sensor reading, preprocessed" in labels(plot_depth(correct_drift(cleaned.run), cleaned.record))


def spoilt(raw):
    """Turn depth over, add a sentinel and a spell without a sensor."""
    columns = {**raw.columns, "depth": -raw.columns["depth"], "relative_humidity": np.full(len(raw), 0.4)}
    columns["depth"][[100, 200]] = 9e9
    columns["relative_humidity"][300:600] = -10.6
    return replace(raw, columns=columns, origins={**raw.origins, "relative_humidity": "measured"})


MENDED = Recipe(clean_up=(*AUTOMATIC, Invert(signals=("depth",))))


def test_clean_up_figure_shows_each_changed_signal_raw_and_cleaned(sample_archive):
    raw = spoilt(sample_archive.raw(SAMPLE_IDS[0]))
    cleaned = clean_run(raw, MENDED)
    figure = plot_clean_up(raw, cleaned.run, cleaned.record)
    assert labels(figure) == {"as recorded", "preprocessed"}
    depth, humidity = figure.axes
    assert (depth.get_ylabel(), humidity.get_ylabel()) == ("depth / µm", "humidity / %")
    assert depth.texts[0].get_text().startswith("depth: 2 samples masked: ")
    assert humidity.get_title(loc="left").startswith("relative humidity: 300 samples masked: ")
    assert humidity.get_xlabel() == "time / s"
    end = 1e6 * cleaned.run.columns["depth"][-1]
    low, high = depth.get_ylim()
    assert low < -end < end < high < 10 * end
    assert np.isnan(humidity.lines[1].get_ydata()).sum() == 1


def test_raw_signal_that_would_flatten_the_cleaned_one_is_off_the_scale(sample_archive):
    truth = sample_archive.raw(SAMPLE_IDS[0])
    raw = replace(truth, columns={**truth.columns, "time": truth.columns["time"] + 1.6e9})
    cleaned = clean_run(raw)
    figure = plot_clean_up(raw, cleaned.run, cleaned.record)
    assert labels(figure) == {"preprocessed"}
    assert "as recorded (off scale)" in [text.get_text() for text in figure.axes[0].texts]


def test_clean_up_figure_has_at_most_six_panels(sample_archive):
    run = sample_archive.raw(SAMPLE_IDS[0])
    names = [name for name in SIGNALS if name != "time"]
    raw = replace(run, columns=dict.fromkeys(SIGNALS, np.arange(1.0, 1001.0)))
    after = replace(raw, columns={**raw.columns, **dict.fromkeys(names, np.arange(2.0, 1002.0))})
    record = CleanUp(changes=[Change(step="mask", signal=name, samples=1, what=99 * "so ", why="") for name in names])
    figure = plot_clean_up(raw, after, record)
    assert len(figure.axes) == 6
    assert figure.axes[0].get_title(loc="left") == f"{run.id}: preprocessing, 6 of {len(names)} signals"
    assert figure.axes[1].get_title(loc="left").endswith(" …")


@pytest.mark.slow
def test_clean_up_figure_is_saved_where_something_was_changed_and_goes_with_it(sample_archive, tmp_path):
    archive, raw = Archive(tmp_path), spoilt(sample_archive.raw(SAMPLE_IDS[0]))
    archive.add(raw)
    path = tmp_path / "figures" / f"{raw.id}-clean-up.png"
    for recipe, drawn in ((MENDED, True), (Recipe(clean_up=()), False)):
        advance(archive, raw.id, "clean_up", recipe)
        advance(archive, raw.id, "drift_correction", recipe)
        assert (path in save_run_figures(archive, raw.id)) == drawn
        assert path.exists() == drawn


@pytest.mark.slow
def test_same_figure_gives_the_same_bytes(sample_archive, tmp_path):
    corrected = archived_correction(sample_archive, SAMPLE_IDS[0])
    for name in ("first.svg", "second.svg"):
        save_figure(plot_depth(corrected), tmp_path / name)
    assert (tmp_path / "first.svg").read_bytes() == (tmp_path / "second.svg").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["there.png", "there.svg"])
def test_settings_of_a_matplotlibrc_have_no_effect(sample_archive, tmp_path, name):
    """TeX need not be installed, and a template of slides is not what a report is drawn in."""
    theirs = {"text.usetex": True, "axes.facecolor": "black", "figure.dpi": 30, "savefig.transparent": True}
    raw = sample_archive.raw(SAMPLE_IDS[0])
    friction = archived_friction(sample_archive, SAMPLE_IDS[0])
    ours, other = (tmp_path / place / name for place in ("ours", "other"))
    for path, settings in ((ours, {}), (other, theirs)):
        with rc_context(settings):
            save_figure(plot_friction(raw, friction), path)
    assert ours.read_bytes() == other.read_bytes()


THEIRS = (
    "text.usetex: True\ntext.latex.preamble: \\\\nonsense\naxes.facecolor: black\nsavefig.dpi: 30\nbackend: TkAgg\n"
)
RUN = "import sys; from tribopipe.cli.entry_point import main; sys.exit(main())"


@pytest.mark.slow
@pytest.mark.parametrize("place", ["current folder", "MPLCONFIGDIR", "home"])
def test_a_matplotlibrc_has_no_effect_on_process(short_runs, archive, run_cli, tmp_path, place):
    """TeX is asked for, which need not be there, in each place where matplotlib looks for its settings."""
    run, at, home = short_runs / "si3n4-air-200mN", tmp_path / "at", tmp_path / "home"
    ours, other = (Path(shutil.copytree(archive, tmp_path / name)) for name in ("ours", "other"))
    assert run_cli("process", run, "--archive", ours).exit_code == 0
    env = os.environ | ({} if place == "current folder" else {"HOME": str(home), "USERPROFILE": str(home)})
    for name in ("MATPLOTLIBRC", "MPLCONFIGDIR", "XDG_CONFIG_HOME", "XDG_CACHE_HOME"):
        env.pop(name, None)
    settings = {"current folder": [at], "MPLCONFIGDIR": [at / "theirs"]}.get(
        place, [home / ".config" / "matplotlib", home / ".matplotlib"]
    )
    at.mkdir()
    for folder in settings:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "matplotlibrc").write_text(THEIRS, encoding="utf-8")
    if place == "MPLCONFIGDIR":
        env["MPLCONFIGDIR"] = str(at / "theirs")
    code = "import matplotlib; print(matplotlib.matplotlib_fname())"
    # That of the home lies in another place on each system.
    assert at / subprocess_in(at, env, "-c", code).stdout.strip() in [folder / "matplotlibrc" for folder in settings]
    done = subprocess_in(at, env, "-c", RUN, "process", str(run), "--archive", str(other))
    assert done.returncode == 0, done.stderr
    assert not re.search("usetex|LaTeX|backend|warning|error", done.stderr, re.IGNORECASE)
    drawn, expected = ({p.name: p.read_bytes() for p in (folder / "figures").iterdir()} for folder in (other, ours))
    assert drawn.keys() == expected.keys() != set()
    assert drawn == expected


def subprocess_in(folder: Path, env: dict[str, str], *words: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a folder."""
    return subprocess.run([sys.executable, *words], cwd=folder, env=env, capture_output=True, encoding="utf-8")


def test_thinning_keeps_the_extremes():
    x = np.arange(100_000.0)
    y = np.sin(x / 3000)
    y[54_321], y[77_777] = 9.0, -9.0
    thin_x, thin_y = thinned(x, y)
    assert len(thin_x) < 2000
    assert (thin_y.max(), thin_y.min()) == (9.0, -9.0)
    assert np.all(np.diff(thin_x) > 0)


def test_figure_shows_itself_in_a_notebook(sample_archive):
    corrected = archived_correction(sample_archive, SAMPLE_IDS[0])
    assert plot_depth(corrected)._repr_png_().startswith(b"\x89PNG")


# --- for print ---


@pytest.fixture(scope="module")
def printed(sample_archive, tmp_path_factory) -> Path:
    """Figures of a run as PDF, SVG and PNG for print, with their captions."""
    folder = tmp_path_factory.mktemp("printed")
    shutil.copy(sample_archive.path(SAMPLE_IDS[0]), folder)
    save_run_figures(Archive(folder), SAMPLE_IDS[0], ["pdf", "svg", "png"])
    return folder / "figures"


@pytest.mark.slow
def test_figures_for_print_have_their_captions_as_text(printed):
    names = {path.name.removeprefix(f"{SAMPLE_IDS[0]}-") for path in printed.iterdir()}
    assert names == {
        f"{what}.{kind}" for what in ("depth", "friction", "wear") for kind in ("pdf", "svg", "png", "txt")
    }
    for what in ("depth", "friction", "wear"):
        text = (printed / f"{SAMPLE_IDS[0]}-{what}.txt").read_text(encoding="utf-8")
        assert text == f"{RUN_CAPTIONS[what]}\n"


@pytest.mark.slow
def test_png_for_print_has_600_dots_per_inch(printed):
    for path in printed.glob("*.png"):
        with Image.open(path) as picture:
            assert picture.info["dpi"] == pytest.approx((600, 600), abs=0.1)
    for path in printed.glob("*.pdf"):
        assert path.read_bytes().startswith(b"%PDF")
        assert b"/Type3" not in path.read_bytes()


@pytest.mark.slow
def test_what_is_missing_of_the_formats_named_is_seen(printed):
    store = Archive(printed.parent)
    assert run_is_drawn(store, SAMPLE_IDS[0], ["pdf", "svg"])
    (printed / f"{SAMPLE_IDS[0]}-depth.svg").unlink()
    assert not run_is_drawn(store, SAMPLE_IDS[0], ["pdf", "svg"])
    assert run_is_drawn(store, SAMPLE_IDS[0], ["pdf"])


def test_an_unknown_format_is_wrong_usage(run_cli, tmp_path):
    asked = run_cli("process", tmp_path, "--figure-format", "gif")
    assert asked.exit_code == 2
    assert "gif" in asked.stderr


@pytest.mark.parametrize("run_id", others_slow(FURTHER_IDS))
def test_drawn_drift_is_the_line_that_was_found_whatever_the_sensor_reads_of_the_approach(further_run, run_id):
    corrected = archived_correction(further_run(run_id), run_id)
    time = corrected.run.columns["time"]
    (panel,) = depth_panels(time, corrected)
    drift = next(curve for curve in panel.curves if curve.role == "drift")
    found = corrected.correction.drift_rate
    slope = float(np.polyfit(time, drift.y, 1)[0])
    assert slope == pytest.approx(found.value, abs=0.5 * found.standard_uncertainty)
    assert np.ptp(drift.y - slope * time) < 0.2e-6


def test_a_negative_drift_has_the_minus_sign_of_the_axes(sample_archive):
    corrected = archived_correction(sample_archive, SAMPLE_IDS[0])
    rate = corrected.correction.drift_rate.model_copy(update={"value": -1e-10})
    figure = plot_depth(replace(corrected, correction=corrected.correction.model_copy(update={"drift_rate": rate})))
    assert figure.axes[0].texts[0].get_text().startswith("drift −6")
    assert figure.axes[0].get_title(loc="left") == f"{SAMPLE_IDS[0]}: depth signal"


def test_words_above_a_depth_signal_name_the_body_as_its_run_does(further_run):
    corrected = archived_correction(further_run("al2o3-reciprocating-5N"), "al2o3-reciprocating-5N")
    alone = corrected.correction.model_copy(update={"anchor": None, "end_wear_depth": None})
    told = plot_depth(replace(corrected, correction=alone)).axes[0].texts[0].get_text()
    assert "the wear of the ball was not measured" in " ".join(told.split())


def test_only_measured_friction_is_drawn_as_excluded(sample_archive):
    raw = sample_archive.raw(SAMPLE_IDS[0])
    fit = fit_friction(raw)
    x = raw.columns["sliding_distance"]
    later = (Quantity(value=10.0, unit="m"), fit.window[1])
    late = fit.model_copy(update={"window": later})
    above, _ = friction_panels(x, raw, late)
    assert above.left_out == (x[0], pytest.approx(10.0, abs=0.1))
    mu = np.where(x < 10.0, np.nan, raw.columns["friction_coefficient"])
    above, _ = friction_panels(x, replace(raw, columns={**raw.columns, "friction_coefficient": mu}), late)
    assert above.left_out is None


@pytest.mark.slow
def test_a_report_begins_with_a_table_of_the_results_of_each_body(further_run):
    archive = further_run("al2o3-reciprocating-5N")
    table = results_table(archive.outline("al2o3-reciprocating-5N"))
    assert table.columns == ("quantity", "ball", "flat")
    named = {row[0]: row[1:] for row in table.rows}
    assert named["scar diameter"] == ("0.5801 ± 0.0014 mm", "–")
    assert list(named) == [
        *("scar diameter", "wear volume", "wear depth", "specific wear rate"),
        *("k_D (Archard's law)", "95 % CI", "k_D (Sarkar's law)"),
    ]
    assert all("mm³/(N·mm)" in cell for cell in named["k_D (Archard's law)"])
    html = run_report(archive, ["al2o3-reciprocating-5N"]).replace("\u00a0", " ")
    summary = html[html.index('<section id="summary">') : html.index('<section class="run"')]
    assert summary.count("<table") == 1
    assert named["wear volume"][0] in summary
