"""Figures hold what they say, look the same each time, and are drawn from whatever a run has."""

from dataclasses import replace

import numpy as np
import pytest
from folders import SAMPLE_IDS

from tribopipe.drift import correct_drift
from tribopipe.friction import fit_friction
from tribopipe.pipeline import archived_correction, archived_friction
from tribopipe.report.archived import save_run_figures
from tribopipe.report.decimation import thinned
from tribopipe.report.figures import plot_depth, plot_friction, plot_wear, save_figure
from tribopipe.wear.curves import fitted_curve
from tribopipe.wear.identify import fit_wear


@pytest.mark.parametrize("run_id", ["si3n4-air-800mN", "wc-co-water-400mN"])
def test_every_archived_run_gets_its_three_figures(sample_archive, run_id):
    written = save_run_figures(sample_archive, run_id)
    assert [path.name for path in written] == [f"{run_id}-{what}.png" for what in ("depth", "friction", "wear")]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in written)


def labels(figure) -> set[str]:
    return {text.get_text() for legend in figure.legends for text in legend.get_texts()}


def test_wear_figure_shows_laws_end_value_and_residuals(sample_archive):
    corrected, friction = (
        archived_correction(sample_archive, SAMPLE_IDS[0]),
        archived_friction(sample_archive, SAMPLE_IDS[0]),
    )
    curves = [
        fitted_curve(corrected.run, fit_wear(corrected, law, friction), friction) for law in ("archard", "sarkar")
    ]
    figure = plot_wear(corrected, curves)
    assert labels(figure) >= {"pin wear, corrected", "Archard, fitted", "Sarkar, fitted"}
    upper, lower = figure.axes
    assert upper.get_ylabel() == "pin wear depth / µm"
    assert lower.get_xlabel() == "sliding distance s / m"
    archard = next(line for line in upper.lines if line.get_label() == "Archard, fitted")
    assert archard.get_ydata()[-1] == pytest.approx(curves[0].wear_depth[-1] * 1e6)


def test_figures_of_a_run_without_end_value_and_friction_say_what_is_missing(sample_archive):
    raw = sample_archive.raw(SAMPLE_IDS[0])
    end = raw.manifest.end_values.model_copy(update={"pin_scar_diameter": None})
    bare = replace(
        raw,
        manifest=raw.manifest.model_copy(update={"end_values": end}),
        columns={name: raw.columns[name] for name in ("time", "sliding_distance", "depth")},
    )
    assert "lacks an end value" in plot_depth(correct_drift(bare)).axes[0].texts[0].get_text()
    assert "lacks a friction signal" in plot_friction(bare, fit_friction(bare)).axes[0].texts[0].get_text()


def test_a_long_sentence_leaves_the_figure_its_width(sample_archive):
    raw = sample_archive.raw(SAMPLE_IDS[0])
    fit = fit_friction(raw).model_copy(update={"outcome": "steady-only", "notes": (100 * "so ", "mean of the half")})
    (words,) = plot_friction(raw, fit).axes[0].texts
    assert max(map(len, words.get_text().splitlines())) <= 90


def test_same_figure_gives_the_same_bytes(sample_archive, tmp_path):
    corrected = archived_correction(sample_archive, SAMPLE_IDS[0])
    for name in ("first.svg", "second.svg"):
        save_figure(plot_depth(corrected), tmp_path / name)
    assert (tmp_path / "first.svg").read_bytes() == (tmp_path / "second.svg").read_bytes()


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
