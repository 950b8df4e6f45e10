"""Figures of a study hold what the paper's Figures 1, 3, 4, 5 and 6 do, are fit to print, and do not change."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from printable import faults

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.documents.annotation import Mark
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.study.k_d_along_test import effective_coefficient
from tribopipe.evaluation.study.member import Member
from tribopipe.pipeline.archived_results import archived_correction, archived_friction
from tribopipe.pipeline.studies import run_study
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.results.study import AGREEMENT
from tribopipe.views.archived_figures import save_study_figures
from tribopipe.views.study_figures import plot_study_coefficient, plot_study_friction, plot_study_wear

pytestmark = pytest.mark.slow

SI3N4 = Study(id="si3n4", fit=("si3n4-air-200mN",), predict=("si3n4-air-400mN", "si3n4-air-800mN"))
WC_CO = Study(
    id="wc-co",
    fit=("wc-co-water-400mN",),
    predict=("wc-co-water-800mN", "wc-co-water-1200mN", "wc-co-water-1600mN"),
)
UNIT = 1e-6
"""m²/N in 1 mm³/(N·mm)."""


@pytest.fixture(scope="module")
def studied(sample_archive, tmp_path_factory) -> Archive:
    """All sample runs taken through the whole line, and a study of each material; not to be written into."""
    folder = tmp_path_factory.mktemp("studied") / "archive"
    shutil.copytree(sample_archive.folder, folder)
    archive = Archive(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 2_000)
        for study in (SI3N4, WC_CO):
            assert [one for one in run_study(archive, study, Recipe()) if one.status == "failed"] == []
    return archive


@pytest.fixture(scope="module")
def members(studied) -> dict[str, Member]:
    ids = studied.ids()
    return {i: Member(archived_correction(studied, i), archived_friction(studied, i)) for i in ids}


@pytest.fixture(scope="module")
def effective(members):
    return {i: effective_coefficient(member.pose("sarkar", Recipe())) for i, member in members.items()}


def wear_figure(studied, study, law="archard"):
    stored = studied.study(study.id)
    runs = [archived_correction(studied, run_id) for run_id in (*study.fit, *study.predict)]
    measured = {one.id: (one.run.sliding_distance, one.pin_wear_depth) for one in runs}
    return plot_study_wear(stored.result, law, stored.curves, measured)


def coefficient_figure(studied, effective, study):
    ids = (*study.fit, *study.predict)
    return plot_study_coefficient(studied.study(study.id).result, [effective[run_id] for run_id in ids])


def labels(figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def laws_drawn(ax):
    """Lines that begin in the origin: those of a law."""
    return [line for line in ax.lines if len(line.get_xdata()) and line.get_xydata()[0].tolist() == [0.0, 0.0]]


def first_runs(studied, study, count: int):
    """Return a study's result as though it had only its first runs."""
    result = studied.study(study.id).result
    return result.model_copy(
        update={"laws": tuple(law.model_copy(update={"runs": law.runs[:count]}) for law in result.laws)}
    )


def with_replicates(result, curves):
    """Return a study's result and curves as though two of its runs had been repeated."""
    ids = [run.id for run in result.laws[0].runs[:2]]
    laws = []
    for law in result.laws:
        again = [run.model_copy(update={"id": f"{run.id}-again"}) for run in law.runs if run.id in ids]
        laws.append(law.model_copy(update={"runs": (*law.runs, *again)}))
    more = [replace(curve, run_id=f"{curve.run_id}-again") for curve in curves if curve.run_id in ids]
    return result.model_copy(update={"laws": tuple(laws)}), [*curves, *more]


@pytest.fixture(scope="module")
def drawn(studied, tmp_path_factory) -> list[Path]:
    """Every figure of the study of Si3N4."""
    return save_study_figures(studied, "si3n4", into=tmp_path_factory.mktemp("drawn"))


@pytest.mark.slow
def test_one_call_draws_every_figure_of_a_study_as_vector_and_picture(drawn):
    whats = ("wear-archard", "wear-sarkar", "friction", "coefficient")
    assert [path.name for path in drawn] == [f"si3n4-{what}{end}" for what in whats for end in (".svg", ".png")]
    for path in drawn:
        assert path.read_bytes().startswith(b"\x89PNG" if path.suffix == ".png" else b"<?xml")


@pytest.mark.slow
def test_same_study_gives_the_same_bytes(studied, drawn, tmp_path):
    again = save_study_figures(studied, "si3n4", ["svg"], tmp_path)
    once = [path for path in drawn if path.suffix == ".svg"]
    assert [path.read_bytes() for path in once] == [path.read_bytes() for path in again]


@pytest.mark.slow
def test_pdf_carries_fonts_that_journals_take(studied, tmp_path):
    written = save_study_figures(studied, "si3n4", ["pdf"], tmp_path)
    assert all(b"/Type3" not in path.read_bytes() for path in written)


def test_wear_figure_says_of_each_load_what_the_law_makes_of_it(studied):
    figure = wear_figure(studied, SI3N4)
    law = studied.study("si3n4").result.law("archard")
    outcomes = [run.outcome for run in law.runs[:0:-1]]
    loads = [f"{load} mN, {AGREEMENT[outcome]}" for load, outcome in zip((800, 400), outcomes, strict=True)]
    assert labels(figure)[:3] == [*loads, "200 mN, fitted"]
    (ax,) = figure.axes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("sliding distance s / m", "pin wear depth / µm")
    assert figure.get_suptitle().startswith("Archard's law, fitted at 200 mN\n")
    found, spread = (
        x / UNIT * 1e9 for x in (law.first.wear_coefficient.value, law.first.wear_coefficient.standard_uncertainty)
    )
    words = f"({found:.2f} ± {spread:.2f})×$10^{{-9}}$ mm³/(N·mm)"
    assert figure.get_suptitle().endswith(words)


@pytest.mark.parametrize(("study", "law"), [(SI3N4, "archard"), (SI3N4, "sarkar"), (WC_CO, "archard")])
def test_wear_figure_holds_each_run_with_law_bands_and_end_value(studied, study, law):
    (ax,) = wear_figure(studied, study, law).axes
    stored = studied.study(study.id)
    curves = {curve.run_id: curve for curve in stored.curves if curve.model == law}
    runs = stored.result.law(law).runs
    lines = laws_drawn(ax)
    assert [line.get_ydata()[-1] for line in lines] == pytest.approx([curves[i.id].predicted[-1] * 1e6 for i in runs])
    assert len(ax.collections) >= len(runs)
    for band, run in zip(ax.collections, runs, strict=False):
        edge = band.get_paths()[0].vertices[:, 1]
        assert edge.max() == pytest.approx(curves[run.id].upper.max() * 1e6)
    ends = [holder for holder in ax.containers if len(holder[0].get_xdata())]
    for end, run in zip(ends, runs, strict=True):
        assert end[0].get_ydata()[0] == pytest.approx(run.first.measured.value * 1e6)
        low, high = end[2][0].get_segments()[0][:, 1]
        expanded = COVERAGE_FACTOR * run.first.measured.standard_uncertainty * 1e6
        assert (high - low) / 2 == pytest.approx(expanded)


@pytest.mark.parametrize("study", [SI3N4, WC_CO])
def test_runs_differ_in_colour_in_line_style_and_in_marker(studied, study):
    figure = wear_figure(studied, study)
    lines = laws_drawn(figure.axes[0])
    handles = figure.legends[0].legend_handles[: len(lines)]
    assert len({line.get_color() for line in lines}) == len(lines)
    assert len({str(line._unscaled_dash_pattern) for line in lines}) == len(lines)
    assert len({handle.get_marker() for handle in handles}) == len(lines)
    assert [line.get_linestyle() == "-" for line in lines] == [True] + [False] * (len(lines) - 1)


def test_wear_without_the_measured_curves_keeps_their_averages(studied):
    stored = studied.study("si3n4")
    figure = plot_study_wear(stored.result, "archard", stored.curves)
    assert "measured" not in labels(figure)
    assert "measured, averaged" in labels(figure)


def test_friction_figure_has_a_panel_for_each_run_with_its_parameters(members):
    runs = [members[run_id] for run_id in (*SI3N4.predict, *SI3N4.fit)]
    figure = plot_study_friction(runs)
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["(a) 200 mN", "(b) 400 mN", "(c) 800 mN"]
    assert figure.axes[0].get_ylabel() == "friction coefficient μ"
    assert {ax.get_xlabel() for ax in figure.axes} == {"sliding distance s / m"}
    assert len({(ax.get_xlim(), ax.get_ylim()) for ax in figure.axes}) == 1
    for ax, run_id in zip(figure.axes, (*SI3N4.fit, *SI3N4.predict), strict=True):
        fit = members[run_id].friction
        assert ax.texts[0].get_text() == f"A = {fit.amplitude}\nb = {fit.steady_state}\nc = {fit.running_in_distance}"
        fitted = ax.lines[1].get_ydata()
        assert fitted[-1] == pytest.approx(fit.steady_state.value + fit.amplitude.value * np.exp(-500 / c_of(fit)))
    assert labels(figure) == ["measured", "fit, μ = A·exp(−s/c) + b"]


def c_of(fit) -> float:
    return fit.running_in_distance.value


def test_friction_parameters_stand_clear_of_the_samples(members):
    figure = plot_study_friction([members[run_id] for run_id in (*WC_CO.fit, *WC_CO.predict)])
    figure.draw_without_rendering()
    for ax in figure.axes:
        highest = ax.transData.transform((0, max(line.get_ydata().max() for line in ax.lines)))[1]
        assert ax.texts[0].get_window_extent().y0 > highest


def test_friction_figure_leaves_out_a_run_without_friction(members):
    bare = Member(members["si3n4-air-400mN"].corrected, None)
    figure = plot_study_friction([members["si3n4-air-200mN"], bare, members["si3n4-air-800mN"]])
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["(a) 200 mN", "(b) 800 mN"]
    with pytest.raises(ValueError, match="no run with friction"):
        plot_study_friction([bare])


def test_coefficient_figure_holds_the_laws_against_the_windows_of_each_run(studied, effective):
    figure = coefficient_figure(studied, effective, SI3N4)
    *panels, bar = figure.axes
    titles = ["(a) 200 mN, fitted", "(b) 400 mN, predicted", "(c) 800 mN, predicted"]
    assert [ax.get_title(loc="left") for ax in panels] == titles
    assert len({(ax.get_xlim(), ax.get_ylim()) for ax in panels}) == 1
    assert panels[0].get_ylabel() == "effective $k_\\mathrm{D}$ / $10^{-9}$ mm³/(N·mm)"
    assert {ax.get_xlabel() for ax in panels} == {"friction coefficient μ"}
    assert bar.get_ylabel() == "sliding distance s / m"
    result = studied.study("si3n4").result
    archard, sarkar = (result.law(law).first.wear_coefficient.value / UNIT * 1e9 for law in ("archard", "sarkar"))
    for ax, run_id in zip(panels, (*SI3N4.fit, *SI3N4.predict), strict=True):
        points = ax.containers[0][0]
        assert points.get_xdata() == pytest.approx(effective[run_id].friction)
        assert points.get_ydata() == pytest.approx(effective[run_id].coefficient / UNIT * 1e9)
        level = next(line for line in ax.lines if str(line.get_label()).startswith("Archard"))
        assert level.get_ydata() == pytest.approx(np.full(100, archard))
        curve = next(line for line in ax.lines if str(line.get_label()).startswith("Sarkar"))
        assert curve.get_ydata() == pytest.approx(sarkar * np.sqrt(1 + 3 * curve.get_xdata() ** 2))


def test_coefficient_figure_owns_up_to_its_smoothing(studied, effective):
    bias = max(np.max(np.abs(effective[run_id].bias)) for run_id in (*SI3N4.fit, *SI3N4.predict))
    shown = labels(coefficient_figure(studied, effective, SI3N4))
    assert shown[:2] == ["measured, with standard uncertainty", f"(smoothing bias at most {100 * bias:.1f} %)"]
    assert "Sarkar, 95 % band" in shown


@pytest.mark.parametrize("study", [SI3N4, WC_CO])
def test_coefficient_figure_shows_every_window(studied, effective, study):
    *panels, _ = coefficient_figure(studied, effective, study).axes
    (left, right), (low, high) = panels[0].get_xlim(), panels[0].get_ylim()
    for ax in panels:
        x, y = ax.containers[0][0].get_data()
        assert np.all((left < x) & (x < right) & (low < y) & (y < high))


def test_figures_of_one_run_fit_one_column(studied, members, effective):
    result = first_runs(studied, SI3N4, 1)
    friction = plot_study_friction([members[SI3N4.fit[0]]])
    coefficient = plot_study_coefficient(result, [effective[SI3N4.fit[0]]])
    assert friction.get_figwidth() == coefficient.get_figwidth() == 3.5
    assert friction.axes[0].get_title(loc="left") == "200 mN"
    wear = plot_study_wear(result, "archard", studied.study("si3n4").curves)
    assert labels(wear)[0] == "200 mN, fitted"
    assert "measured, 95 % CI (fitted run)" in labels(wear)
    assert "(bars shifted right)" not in labels(wear)
    for figure in (friction, coefficient, wear):
        assert faults(figure) == []


@pytest.mark.slow
def test_figures_of_five_runs_tell_replicates_apart(studied, effective):
    stored = studied.study("si3n4")
    result, curves = with_replicates(stored.result, stored.curves)
    wear = plot_study_wear(result, "archard", curves)
    assert len(laws_drawn(wear.axes[0])) == 5
    assert "200 mN, fitted\nsi3n4-air-200mN-again" in labels(wear)
    again = [replace(effective[i], run_id=f"{i}-again") for i in ("si3n4-air-200mN", "si3n4-air-400mN")]
    coefficient = plot_study_coefficient(result, [*(effective[i] for i in (*SI3N4.fit, *SI3N4.predict)), *again])
    assert len(coefficient.axes) == 6
    assert coefficient.axes[4].get_title(loc="left") == "(e) 800 mN, predicted"
    for figure in (wear, coefficient):
        assert faults(figure) == []


@pytest.mark.slow
@pytest.mark.parametrize("study", [SI3N4, WC_CO])
def test_figures_are_fit_to_print(studied, members, effective, study):
    figures = [
        wear_figure(studied, study, "archard"),
        wear_figure(studied, study, "sarkar"),
        plot_study_friction([members[run_id] for run_id in (*study.fit, *study.predict)]),
        coefficient_figure(studied, effective, study),
    ]
    for figure in figures:
        assert figure.get_figwidth() == 7.2
        assert faults(figure) == []


@pytest.mark.slow
def test_runs_left_out_are_not_drawn_and_archard_alone_needs_no_coefficient(studied, tmp_path):
    archive = Archive(tmp_path / "archive")
    shutil.copytree(studied.folder, archive.folder)
    archive.mark("si3n4-air-800mN", Mark(kind="bad", reason="specimen lost", date="2026-11-21T13:00:00Z"))
    study = SI3N4.model_copy(update={"id": "alone", "laws": ("archard",)})
    assert [one for one in run_study(archive, study, Recipe()) if one.status == "failed"] == []
    written = save_study_figures(archive, "alone", formats=["svg"])
    assert [path.name for path in written] == ["alone-wear-archard.svg", "alone-friction.svg"]
    assert {path.parent for path in written} == {archive.folder / "figures"}
    assert all("400 mN" in (text := path.read_text(encoding="utf-8")) and "800 mN" not in text for path in written)


@pytest.mark.slow
def test_study_that_finds_drift_itself_is_not_drawn_with_drift_found_otherwise(studied, tmp_path):
    archive = Archive(tmp_path / "archive")
    shutil.copytree(studied.folder, archive.folder)
    recipe = Recipe(wear=WearRecipe(correction="model"))
    study = SI3N4.model_copy(update={"id": "joint", "laws": ("sarkar",)})
    assert [one for one in run_study(archive, study, recipe) if one.status == "failed"] == []
    wear, _, coefficient = save_study_figures(archive, "joint", formats=["svg"])
    text = wear.read_text(encoding="utf-8")
    assert ">measured, averaged<" in text
    assert ">measured<" not in text
    assert "Archard" not in coefficient.read_text(encoding="utf-8")


def test_study_or_run_that_is_not_there_is_named(studied, tmp_path):
    with pytest.raises(ArchiveError, match="si3n5"):
        save_study_figures(studied, "si3n5", into=tmp_path)
    archive = Archive(tmp_path / "archive")
    shutil.copytree(studied.folder, archive.folder)
    archive.path("si3n4-air-400mN").unlink()
    with pytest.raises(ArchiveError, match="si3n4-air-400mN"):
        save_study_figures(archive, "si3n4", into=tmp_path)
