"""Figures of local wear hold what they should, fit on paper, and are kept beside the archive."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from local_wear_runs import DISCS, PIN, disc_curves, pin_curves
from printable import faults

from tribopipe.archive.local_wear_tables import archived_local_wear
from tribopipe.archive.store import Archive
from tribopipe.browse.file_cache import Kept, RunFile
from tribopipe.browse.plots import run_plots
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.wear.local import LocalOptions
from tribopipe.pipeline.stages import wear_archived_locally
from tribopipe.views.archived_figures import save_run_figures
from tribopipe.views.local_wear_figures import (
    local_wear_figures,
    plot_local_wear,
    plot_pin_profiles,
    plot_pressure_maps,
)
from tribopipe.views.run_figures import save_figures

sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))
from economy import EngineCurve, plot_engines


def labels(figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def line(ax, label):
    return next(line for line in ax.lines if line.get_label() == label)


def test_depth_of_a_pin_stands_beside_the_giwm_and_their_difference():
    curves = pin_curves()
    figure = plot_local_wear(curves, PIN)
    depth, pressure, radius, difference = figure.axes
    np.testing.assert_allclose(line(depth, "local").get_xdata(), curves.along)
    np.testing.assert_allclose(line(depth, "local").get_ydata(), 1e6 * curves.course.depth)
    np.testing.assert_allclose(line(depth, "GIWM").get_ydata(), 1e6 * curves.giwm["giwm"].depth)
    np.testing.assert_allclose(line(pressure, "local").get_ydata(), 1e-6 * curves.mean_pressure)
    np.testing.assert_allclose(line(pressure, "local, at the center").get_ydata(), 1e-6 * curves.middle_pressure)
    np.testing.assert_allclose(line(radius, "local").get_ydata(), 1e6 * curves.course.half_width)
    shares = difference.lines[0].get_ydata()
    assert shares[0] > 40
    assert 0 < shares[-1] < 0.1
    labels_of_axes = [ax.get_ylabel() for ax in figure.axes]
    assert labels_of_axes == ["wear depth / µm", "pressure p / MPa", "contact radius a / µm", "local − GIWM / %"]
    assert {ax.get_xscale() for ax in figure.axes} == {"log"}


def test_small_multiples_show_pressure_and_worn_tip_of_a_pin():
    curves = pin_curves()
    figure = plot_pin_profiles(curves, PIN)
    tops, tips = figure.axes[:5], figure.axes[5:]
    assert [ax.get_title() for ax in tops] == ["unworn", "10 mm", "100 mm", "10 m", "500 m"]
    for ax in tops:
        x, p = ax.lines[0].get_data()
        np.testing.assert_allclose(x, -x[::-1])
        np.testing.assert_allclose(p, p[::-1])
    before, after = (line(tips[-1], label).get_ydata() for label in ("tip before the test", "worn tip"))
    assert np.min(after) == pytest.approx(1e6 * curves.course.depth[-1], rel=1e-2)
    assert np.all(after >= before)
    assert tops[0].lines[0].get_ydata().max() == pytest.approx(1e-6 * curves.course.peak_pressure[0])


@pytest.mark.slow
def test_discs_have_the_four_panels_of_figure_9():
    curves = disc_curves()
    figure = plot_local_wear(curves, DISCS)
    assert [ax.get_ylabel() for ax in figure.axes] == [
        "wear depth / µm",
        "pressure p / MPa",
        "half-width $a_x$ / µm",
        "half-length $a_z$ / µm",
    ]
    assert labels(figure) == ["local", "GIWM", "GIWM, Eq. 11 as published", "local, at the center"]
    for ax, values in zip(figure.axes, (curves.course.depth * 1e6, curves.mean_pressure * 1e-6), strict=False):
        np.testing.assert_allclose(line(ax, "local").get_ydata(), values)
    printed, conserving = (curves.giwm[name].depth[-1] for name in ("giwm_as_printed", "giwm"))
    assert printed < conserving < curves.course.depth[-1]


def test_maps_show_the_whole_contact_widen_and_shorten():
    curves = disc_curves()
    figure = plot_pressure_maps(curves, DISCS)
    maps = [ax for ax in figure.axes if ax.get_title(loc="left")]
    assert [ax.get_title(loc="left") for ax in maps] == [
        "unworn",
        "10000 rotations",
        *(f"1×10{n} rotations" for n in "⁵⁶"),
    ]
    seen = [ax.collections[0].get_array() for ax in maps]
    for pressure in seen:
        np.testing.assert_array_equal(pressure.filled(0), pressure.filled(0)[::-1, ::-1])
    assert (~seen[-1].mask).any(axis=0).sum() > 2 * (~seen[0].mask).any(axis=0).sum()
    assert (~seen[-1].mask).any(axis=1).sum() < (~seen[0].mask).any(axis=1).sum()


def test_engines_stand_beside_each_other_with_their_drift_from_the_first():
    rotations = np.linspace(0.0, 2e6, 9)
    depth = 1e-6 * np.sqrt(rotations / 2e6)
    first = EngineCurve("Wear-Processor", rotations, depth, np.full(9, 2e8))
    other = EngineCurve("UMESHMOTION mode", rotations[::2], 0.9 * depth[::2], np.full(5, 1e8))
    figure = plot_engines([first, other], "Table 3")
    assert labels(figure) == ["Wear-Processor", "UMESHMOTION mode"]
    pressure, wear, drift = figure.axes
    assert drift.get_ylabel() == "depth deviation / %"
    np.testing.assert_allclose(line(pressure, "UMESHMOTION mode").get_ydata(), 100.0)
    np.testing.assert_allclose(line(wear, "Wear-Processor").get_data(), (rotations / 1e6, depth * 1e6))
    np.testing.assert_allclose(line(drift, "UMESHMOTION mode").get_ydata(), -10.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "drawn",
    [
        lambda: plot_local_wear(pin_curves(), PIN),
        lambda: plot_pin_profiles(pin_curves(), PIN),
        lambda: plot_local_wear(disc_curves(), DISCS),
        lambda: plot_pressure_maps(disc_curves(), DISCS),
    ],
)
def test_nothing_is_cut_off_or_overlaps(drawn):
    assert faults(drawn()) == []


@pytest.mark.slow
def test_figures_are_the_same_each_time(tmp_path):
    for name in ("first", "second"):
        figures = local_wear_figures(pin_curves(), PIN)
        save_figures(tmp_path / name, {f"{what}.svg": figure for what, figure in figures.items()})
    for path in (tmp_path / "first").iterdir():
        assert path.read_bytes() == (tmp_path / "second" / path.name).read_bytes()


@pytest.mark.slow
def test_maps_of_finite_elements_have_their_middle_once():
    curves = disc_curves()
    from_zero = tuple(axis - axis[0] for axis in curves.course.places)
    nodes = replace(curves, course=replace(curves.course, places=from_zero))
    figure = plot_pressure_maps(nodes, DISCS)
    assert figure.axes[0].collections[0].get_array().shape[1] == 2 * from_zero[0].size - 1


@pytest.mark.slow
def test_archived_run_gets_its_figures(archive):
    store = Archive(archive)
    wear_archived_locally(store, PIN, "archard", Recipe(), LocalOptions(), at=[1.0, 50.0])
    written = [path.name for path in save_run_figures(store, PIN)]
    assert written[-2:] == [f"{PIN}-local-wear.png", f"{PIN}-local-pressure.png"]
    run = RunFile(store, PIN, Kept())
    (offer,) = [one for one in run_plots(run) if one.name == "local-wear-archard"]
    panels = offer.drawing().panels
    figure = plot_local_wear(archived_local_wear(store.steps(PIN)["local_wear_archard"]), PIN)
    assert [panel.label for panel in panels] == [ax.get_ylabel() for ax in figure.axes]
    np.testing.assert_allclose(1e6 * panels[0].curves[1].y, line(figure.axes[0], "GIWM").get_ydata())
    assert {curve.path for panel in panels for curve in panel.curves} - {None} <= run.datasets.keys()
