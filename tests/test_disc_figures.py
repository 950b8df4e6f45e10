"""Figures of twin-disc runs hold what the paper's Figures 9 and 12 do, are fit to print, and do not change."""

import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from disc_runs import fit_discs, known_pair
from folders import SAMPLES, replace_in
from printable import faults

from tribopipe.archive.store import Archive
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.study import Study
from tribopipe.documents.twin_disc import CurvedDisc, FlatDisc, TwinDisc
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.wear.prediction import fitted_curves
from tribopipe.evaluation.wear.scenario import Scenario
from tribopipe.pipeline.archived_results import archived_correction
from tribopipe.pipeline.stages import ingest, process
from tribopipe.pipeline.studies import run_study
from tribopipe.readers.harmonize import read_run
from tribopipe.results.evaluation import COVERAGE_FACTOR
from tribopipe.views.archived_figures import save_run_figures, save_study_figures
from tribopipe.views.run_figures import plot_contact, plot_depth, plot_friction, plot_wear, save_figure
from tribopipe.views.study_figures import plot_study_friction, plot_study_wear

sys.path.append(str(Path(__file__).parents[1] / "docs"))
from explained_figures import plot_disc_model

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("few_draws")]

SHORT, MIDDLE, LONG = (f"si3n4-twin-disc-4pct-{end}" for end in ("100k", "1000k", "2000k"))
FAST = ("si3n4-twin-disc-10pct-1000k-a", "si3n4-twin-disc-10pct-1000k-b")
FITTED = tuple(f"si3n4-twin-disc-4pct-{end}" for end in ("100k", "250k", "500k", "1000k"))
STUDY = Study(id="discs", fit=FITTED, predict=(LONG, *FAST), laws=("archard",))
CUBIC_MM, MICRO = 1e-9, 1e-6
"""m³ in 1 mm³, m in 1 µm."""


@pytest.fixture(scope="module")
def studied(request, tmp_path_factory) -> Archive:
    """A study of the sample runs, of which three were taken through the whole line; not to be written into."""
    request.getfixturevalue("few_draws")
    archive = Archive(tmp_path_factory.mktemp("discs") / "archive")
    outcomes = [*process([SAMPLES / run_id for run_id in (SHORT, MIDDLE, LONG)], archive)]
    outcomes += [ingest(SAMPLES / run_id, archive) for run_id in (*FITTED, *FAST)]
    outcomes += run_study(archive, STUDY, Recipe())
    assert [one for one in outcomes if one.status == "failed"] == []
    return archive


@pytest.fixture(scope="module")
def run():
    return read_run(SAMPLES / MIDDLE)


def measured(run, ends=None, stops=()):
    """Return a run as though other end values, or interruptions, had been written into its run.toml."""
    written = run.manifest.model_dump(mode="json", by_alias=True, exclude_none=True)
    written |= {"interruptions": list(stops)} | ({} if ends is None else {"end_values": ends})
    return replace(run, manifest=RunManifest.model_validate(written))


def volume(number):
    return {"value": f"{number} mm^3", "standard_uncertainty": "8 %"}


def curves_of(run, laws=("archard",)):
    friction = fit_friction(run)
    return [fitted_curves(run, fit_discs(run, law, friction), friction) for law in laws]


def labels(figure) -> list[str]:
    return [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def line(ax, label):
    return next(line for line in ax.lines if line.get_label() == label)


def bars(ax):
    """Return the places, values and half lengths of all error bars."""
    found = []
    for holder in ax.containers:
        for (x, low), (_, high) in holder[2][0].get_segments():
            found.append((x, (high + low) / 2, (high - low) / 2))
    return found


def test_every_archived_run_gets_its_four_figures(studied):
    written = save_run_figures(studied, LONG)
    assert [path.name for path in written] == [f"{LONG}-{w}.png" for w in ("depth", "friction", "wear", "contact")]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in written)


@pytest.mark.slow
def test_archived_figures_are_drawn_from_what_the_archive_holds(studied, run, tmp_path):
    save_run_figures(studied, MIDDLE, ["svg"])
    wear = (studied.folder / "figures" / f"{MIDDLE}-wear.svg").read_text(encoding="utf-8")
    assert "Archard, fitted" in wear
    assert "Sarkar, predicted from" in wear  # in two lines
    assert SHORT in wear
    (curves,) = curves_of(run)
    save_figure(plot_contact(archived_correction(studied, MIDDLE), curves), tmp_path / "contact.svg")
    assert (tmp_path / "contact.svg").read_bytes() == (
        studied.folder / "figures" / f"{MIDDLE}-contact.svg"
    ).read_bytes()


def test_wear_of_each_disc_stands_beside_the_laws_and_what_was_measured(run):
    curves = curves_of(run, ("archard", "sarkar"))
    figure = plot_wear(correct_drift(run), curves)
    assert faults(figure) == []
    assert labels(figure) == ["Archard, fitted", "Sarkar, fitted", "measured, 95 % CI"]
    assert [ax.texts[0].get_text() for ax in figure.axes] == ["(a) crowned disc", "(b) cylindrical disc"]
    assert figure.axes[0].get_ylabel() == "wear volume / $10^{-3}$ mm³"
    assert {ax.get_xlabel() for ax in figure.axes} == {"rotations of the crowned disc / $10^{6}$"}
    ends = run.manifest.end_values
    for ax, disc, end in zip(
        figure.axes, ("curved", "flat"), (ends.curved_disc_wear_volume, ends.flat_disc_wear_volume), strict=True
    ):
        for one, name in zip(curves, ("Archard", "Sarkar"), strict=True):
            drawn, band = line(ax, f"{name}, fitted"), one.bands[f"{disc}_volume"]
            x, y = drawn.get_data()
            assert len(x) > 100
            assert x[-1] == pytest.approx(1.0, rel=1e-3)
            assert y == pytest.approx(np.interp(x, run.columns["rotations"] / 1e6, band.best) / CUBIC_MM * 1e3)
        edges = ax.collections[0].get_paths()[0].vertices[:, 1]
        assert edges.max() == pytest.approx(curves[0].bands[f"{disc}_volume"].upper.max() / CUBIC_MM * 1e3)
        expected = (1.0, end.value / CUBIC_MM * 1e3, COVERAGE_FACTOR * end.standard_uncertainty / CUBIC_MM * 1e3)
        assert bars(ax) == [pytest.approx(expected, rel=1e-3)]


def test_wear_figure_says_both_coefficients_of_each_law(run):
    (curves,) = curves_of(run)
    words = plot_wear(correct_drift(run), [curves]).axes[0].texts[-1].get_text()
    assert words.startswith("Archard, full-slip:\n$k_\\mathrm{D}$ / mm³/(N·mm) = ")
    for found, disc in zip(curves.result.bodies.values(), ("crowned disc", "cylindrical disc"), strict=True):
        assert f"{found.wear_coefficient.shown('mm^3/(N*mm)').removesuffix(' mm³/(N·mm)')} ({disc})" in words


def test_interruptions_are_drawn_with_residuals_of_all_that_was_measured(run):
    stops = [
        {"rotations": 1e5, "curved_disc_wear_volume": volume(1.7e-4), "flat_disc_wear_volume": volume(9e-5)},
        {"rotations": 4e5, "curved_disc_wear_volume": volume(9.3e-4), "flat_disc_track_width": "136 um"},
    ]
    stopped = measured(run, stops=stops)
    (curves,) = curves_of(stopped)
    figure = plot_wear(correct_drift(stopped), [curves])
    assert faults(figure) == []
    upper, lower = figure.axes[:2], figure.axes[2:]
    assert [len(bars(ax)) for ax in upper] == [3, 2]
    assert lower[0].get_ylabel() == "residual / u"
    assert {"residual of wear volume", "residual of track width"} <= set(labels(figure))
    residuals = [
        (one.place / 1e6, (one.measured.value - one.fitted.value) / one.measured.standard_uncertainty)
        for one in curves.result.measurements
    ]
    drawn = [
        tuple(mark.get_xydata()[0])
        for ax in lower
        for mark in ax.lines
        if mark.get_linestyle() == "None" and len(mark.get_xdata())
    ]
    assert len(drawn) == 6
    assert sorted(drawn) == [pytest.approx(one) for one in sorted(residuals)]


@pytest.mark.parametrize(
    ("ends", "label", "outcome", "factor"),
    [
        ({"curved_disc_wear_depth": "0.8 um", "flat_disc_wear_depth": "0.36 um"}, "wear depth / µm", "curved_depth", 1),
        ({"curved_disc_track_width": "196 um"}, "track width / µm", "half_width", 2),
    ],
)
def test_runs_without_volumes_are_drawn_by_what_was_measured(run, ends, label, outcome, factor):
    without = measured(run, ends)
    (curves,) = curves_of(without)
    figure = plot_wear(correct_drift(without), [curves])
    assert figure.axes[0].get_ylabel() == label
    drawn = line(figure.axes[0], "Archard, fitted").get_ydata()
    assert drawn[-1] == pytest.approx(factor * curves.bands[outcome].best[-1] / MICRO)
    ((_, value, _),) = bars(figure.axes[0])
    assert value == pytest.approx(drawn[-1], rel=1e-2)


def test_flat_disc_that_counts_as_unworn_is_not_drawn(run):
    alone = measured(run, {"curved_disc_wear_volume": volume(2.9e-3)})
    (curves,) = curves_of(alone)
    wear = plot_wear(correct_drift(alone), [curves])
    assert len(wear.axes) == 1
    assert wear.axes[0].get_title(loc="left") == f"{run.id}: wear of the crowned disc"
    contact = plot_contact(correct_drift(alone), curves)
    assert labels(contact) == ["depth signal, corrected", "crowned disc", "Archard, fitted"]


def test_contact_figure_has_the_four_panels_of_figure_9(run):
    corrected, (curves,) = correct_drift(run), curves_of(run)
    figure = plot_contact(corrected, curves)
    assert faults(figure) == []
    assert [ax.get_ylabel() for ax in figure.axes] == [
        "wear depth / µm",
        "mean pressure p / GPa",
        "half-width $a_x$ / µm",
        "half-length $a_z$ / µm",
    ]
    assert [ax.texts[0].get_text() for ax in figure.axes] == ["(a)", "(b)", "(c)", "(d)"]
    assert {ax.get_xlabel() for ax in figure.axes[2:]} == {"rotations of the crowned disc / $10^{6}$"}
    depths = {"both discs": "depth", "crowned disc": "curved_depth", "cylindrical disc": "flat_depth"}
    assert labels(figure) == ["depth signal, corrected", *depths, "Archard, fitted"]
    first, *others = figure.axes
    signal = line(first, "depth signal, corrected")
    assert signal.get_ydata().max() == pytest.approx(np.nanmax(corrected.wear_depth) / MICRO)
    for label, outcome in depths.items():
        drawn = line(first, label).get_ydata()
        assert (drawn[0], drawn[-1]) == pytest.approx(curves.bands[outcome].best[[0, -1]] / MICRO)
    assert len({str(line(first, label)._unscaled_dash_pattern) for label in depths}) == 3
    for ax, (outcome, unit) in zip(
        others, {"pressure": 1e9, "half_width": MICRO, "half_length": MICRO}.items(), strict=True
    ):
        drawn = ax.lines[0].get_ydata()
        assert (drawn[0], drawn[-1]) == pytest.approx(curves.bands[outcome].best[[0, -1]] / unit)


def test_contact_without_depth_signal_keeps_the_law(run):
    columns = {name: column for name, column in run.columns.items() if name != "depth"}
    bare = replace(run, columns=columns)
    figure = plot_contact(correct_drift(bare), curves_of(bare)[0])
    assert labels(figure) == ["both discs", "crowned disc", "cylindrical disc", "Archard, fitted"]


@pytest.mark.slow
def test_run_without_depth_signal_has_no_depth_figure(tmp_path):
    folder = Path(shutil.copytree(SAMPLES / SHORT, tmp_path / SHORT))
    replace_in(folder / "run.toml", r"(?m)^depth = .*\n", "")
    replace_in(folder / "signals.csv", r"Depth \[um\]", "Temper [-]")
    archive = Archive(tmp_path / "archive")
    assert [one for one in process([folder], archive) if one.status == "failed"] == []
    written = save_run_figures(archive, SHORT)
    assert [path.stem.removeprefix(f"{SHORT}-") for path in written] == ["friction", "wear", "contact"]


def test_depth_is_drawn_against_rotations_and_friction_against_slip(run):
    depth = plot_depth(correct_drift(run))
    assert depth.axes[0].get_xlabel() == "rotations of the crowned disc / $10^{6}$"
    assert depth.axes[0].get_xlim()[1] == pytest.approx(1.01, abs=0.01)
    assert "corrected wear, both discs" in labels(depth)
    assert plot_friction(run, fit_friction(run)).axes[1].get_xlabel() == "slip distance s / m"


def test_friction_of_a_study_names_runs_by_load_and_slip():
    runs = [read_run(SAMPLES / run_id) for run_id in (FAST[0], SHORT, FAST[1])]
    figure = plot_study_friction([Member(correct_drift(run), fit_friction(run)) for run in runs])
    assert [ax.get_title(loc="left") for ax in figure.axes] == [
        "(a) 250 mN, 4 % slip",
        f"(b) 250 mN, 10 % slip\n{FAST[0]}",
        f"(c) 250 mN, 10 % slip\n{FAST[1]}",
    ]
    assert {ax.get_xlabel() for ax in figure.axes} == {"slip distance s / m"}


def scenario(distance, flat=0.0):
    """Table 3's case with radii of 4 mm."""
    body = {"material": "ZrO2", "youngs_modulus": "152 GPa", "poisson_ratio": 0.32, "rolling_radius": "4 mm"}
    discs = {
        "curved_disc": CurvedDisc.model_validate({**body, "crown_radius": "4 mm"}),
        "flat_disc": FlatDisc.model_validate(body),
    }
    coefficients = (Quantity(value=value, unit="m^2/N") for value in (1e-16, flat))
    return Scenario(
        contact=TwinDisc(kind="twin-disc", **discs),
        normal_load=Quantity(value=0.3, unit="N"),
        slip=Quantity(value=0.1, unit="1"),
        known=known_pair(*coefficients, distance=distance),
    )


def test_model_is_drawn_beside_the_papers_steps():
    case = scenario("contact-width", flat=5e-17)
    figure = plot_disc_model({"contact-width": case}, 2e6, 2000)
    assert labels(figure) == ["contact-width", "published scheme"]
    grid = np.linspace(0, 2e6, 2001)
    steps = case.published(grid, 2000)
    places = dict(zip(figure.axes, ("depth", "pressure", "half_width", "half_length"), strict=True))
    for ax, outcome in places.items():
        exact, dots = line(ax, "contact-width"), line(ax, "published scheme")
        worn = case.worn(exact.get_xdata() * 1e6)
        states = [one[outcome] for one in (worn, steps)]
        unit = 1e9 if outcome == "pressure" else MICRO
        assert exact.get_ydata() == pytest.approx(states[0] / unit)
        at = np.searchsorted(grid, dots.get_xdata() * 1e6 - 1)
        assert (at[0], at[-1]) == (0, 2000)
        assert dots.get_ydata() == pytest.approx(states[1][at] / unit)
        assert ax.get_yscale() == "linear"


@pytest.mark.slow
def test_scenarios_that_wear_at_different_rates_share_logarithmic_axes():
    cases = {distance: scenario(distance) for distance in ("full-slip", "contact-width", "volume-conserving")}
    figure = plot_disc_model(cases, 2e6)
    assert faults(figure) == []
    assert labels(figure) == list(cases)
    assert {ax.get_xscale() for ax in figure.axes} == {"log"}
    assert [ax.get_yscale() for ax in figure.axes] == ["log", "linear", "log", "linear"]
    assert figure.axes[2].get_xlabel() == "rotations of the crowned disc"
    for name, case in cases.items():
        assert line(figure.axes[0], name).get_ydata()[-1] == pytest.approx(
            case.worn(np.asarray(2e6))["curved_depth"] / MICRO
        )


def study_figure(studied):
    stored = studied.study("discs")
    return plot_study_wear(stored.result, "archard", stored.curves), stored


def test_study_has_a_panel_for_each_slip_with_the_law_along_its_longest_run(studied):
    figure, stored = study_figure(studied)
    assert figure.get_figwidth() == 7.2
    assert faults(figure) == []
    upper, lower = figure.axes[:2], figure.axes[2:]
    assert [ax.get_title(loc="left") for ax in upper] == ["(a) 250 mN, 4 % slip", "(b) 250 mN, 10 % slip"]
    assert upper[0].get_ylabel() == "wear volume / $10^{-3}$ mm³"
    assert lower[0].get_ylabel() == "measured /\npredicted"
    assert {ax.get_xlabel() for ax in lower} == {"rotations of the crowned disc / $10^{6}$"}
    assert len({(ax.get_xlim(), ax.get_ylim()) for ax in upper}) == 1
    for ax, run_id, last in zip(upper, (LONG, FAST[0]), (2.0, 1.0), strict=True):
        curves = {one.body: one for one in stored.curves if one.run_id == run_id}
        laws = [drawn for drawn in ax.lines if len(drawn.get_xdata()) > 2]
        assert len(laws) == len(ax.collections) - len(ax.containers) == 2
        for drawn, disc in zip(laws, ("curved_disc", "flat_disc"), strict=True):
            assert drawn.get_xdata()[-1] == pytest.approx(last, rel=1e-3)
            assert drawn.get_ydata() == pytest.approx(curves[disc].predicted / CUBIC_MM * 1e3)
        bands = [one for one in ax.collections if one.get_paths() and len(one.get_paths()[0].vertices) > 3]
        tops = [band.get_paths()[0].vertices[:, 1].max() for band in bands]
        assert tops == pytest.approx([curves[disc].upper.max() / CUBIC_MM * 1e3 for disc in curves])


def test_study_figure_holds_every_measured_volume_and_its_share_of_the_law(studied):
    figure, stored = study_figure(studied)
    runs = stored.result.law("archard").runs
    for place, slip in enumerate((0.04, 0.1)):
        ax, below = figure.axes[place::2]
        judged = [(run, disc) for run in runs if run.slip.value == pytest.approx(slip) for disc in run.bodies.values()]
        volumes = [
            (
                disc.measured.value / CUBIC_MM * 1e3,
                COVERAGE_FACTOR * disc.measured.standard_uncertainty / CUBIC_MM * 1e3,
            )
            for _, disc in judged
        ]
        assert sorted((value, half) for _, value, half in bars(ax)) == [pytest.approx(one) for one in sorted(volumes)]
        ratios = [disc.measured.value / disc.predicted.value for _, disc in judged]
        assert sorted(value for _, value, _ in bars(below)) == pytest.approx(sorted(ratios))
    fast = sorted({round(x, 6) for x, *_ in bars(figure.axes[1])})
    assert len(fast) == 2
    assert np.mean(fast) == pytest.approx(1.0, rel=1e-3)


def test_study_tells_discs_and_roles_apart_and_marks_where_the_law_is_called_off(studied):
    figure, stored = study_figure(studied)
    ax = figure.axes[0]
    laws = [drawn for drawn in ax.lines if len(drawn.get_xdata()) > 2]
    assert len({drawn.get_color() for drawn in laws}) == len({str(one._unscaled_dash_pattern) for one in laws}) == 2
    marks = [holder[0] for holder in ax.containers]
    assert {(mark.get_color(), mark.get_marker()) for mark in marks} == {
        (law.get_color(), marker) for law, marker in zip(laws, "os", strict=True)
    }
    opened = {mark.get_markerfacecolor() == "white": set() for mark in marks}
    for mark in marks:
        opened[mark.get_markerfacecolor() == "white"].add(round(float(mark.get_xdata()[0]), 2))
    assert opened == {False: {0.1, 0.25, 0.5, 1.0}, True: {2.0}}
    called_off = [run for run in stored.result.law("archard").runs if run.outcome == "under-predicts"]
    assert [run.id for run in called_off] == [LONG]
    crosses = [drawn for drawn in ax.lines if drawn.get_marker() == "x"]
    assert [cross.get_xdata()[0] for cross in crosses] == pytest.approx([2.0, 2.0], rel=1e-3)
    assert "under-predicted" in labels(figure)
    assert not any(drawn.get_marker() == "x" for drawn in figure.axes[1].lines)


@pytest.mark.parametrize(("outcome", "words"), [("over-predicts", "over-predicted"), ("not decidable", "inconclusive")])
def test_every_outcome_but_support_has_a_mark(studied, outcome, words):
    stored = studied.study("discs")
    *others, last = stored.result.law("archard").runs
    discs = {name: disc.model_copy(update={"outcome": outcome}) for name, disc in last.bodies.items()}
    result = changed(stored.result, runs=(*others, last.model_copy(update={"bodies": discs})))
    figure = plot_study_wear(result, "archard", stored.curves)
    assert {"under-predicted", words} <= set(labels(figure))
    assert faults(figure) == []


def test_study_figure_says_both_coefficients(studied):
    figure, stored = study_figure(studied)
    words = figure.get_suptitle()
    assert words.startswith("Archard's law, full-slip, fitted to 4 runs\n")
    for found, disc in zip(
        stored.result.law("archard").bodies.values(), ("crowned disc", "cylindrical disc"), strict=True
    ):
        number = found.wear_coefficient.value / 1e-6 * 1e12
        spread = found.wear_coefficient.standard_uncertainty / 1e-6 * 1e12
        shown = Quantity(value=number, unit="1", standard_uncertainty=spread)
        assert f"({shown})×$10^{{-12}}$ mm³/(N·mm) ({disc})" in words


def changed(result, **update):
    """Return a study's result with its only law changed."""
    (law,) = result.laws
    return result.model_copy(update={"laws": (law.model_copy(update=update),)})


def test_study_of_one_slip_fits_one_column(studied):
    stored = studied.study("discs")
    runs = stored.result.law("archard").runs[:2]
    figure = plot_study_wear(changed(stored.result, runs=runs), "archard", stored.curves)
    assert figure.get_figwidth() == 3.5
    assert figure.axes[0].get_title(loc="left") == "250 mN, 4 % slip"
    assert faults(figure) == []


def test_one_sided_study_draws_the_curved_disc_alone(studied):
    stored = studied.study("discs")
    law = stored.result.law("archard")
    runs = tuple(run.model_copy(update={"bodies": {"curved_disc": run.first}}) for run in law.runs)
    alone = changed(stored.result, bodies={"curved_disc": law.first}, runs=runs)
    figure = plot_study_wear(alone, "archard", stored.curves)
    assert "cylindrical disc" not in labels(figure)
    assert "flat" not in figure.get_suptitle()
    assert all(len([one for one in ax.lines if len(one.get_xdata()) > 2]) == 1 for ax in figure.axes[:2])


def test_depths_are_not_drawn_for_volumes(studied):
    stored = studied.study("discs")
    first, *others = stored.result.law("archard").runs
    deep = first.model_copy(
        update={"bodies": {name: d.model_copy(update={"what": "wear_depth"}) for name, d in first.bodies.items()}}
    )
    figure = plot_study_wear(changed(stored.result, runs=(deep, *others)), "archard", stored.curves)
    assert "runs without measured volume: 1" in labels(figure)
    assert [len(bars(ax)) for ax in figure.axes[:2]] == [8, 4]


@pytest.mark.slow
def test_study_is_drawn_in_one_call_and_has_no_effective_coefficient(studied, tmp_path):
    written = save_study_figures(studied, "discs", into=tmp_path)
    assert [path.name for path in written] == [
        f"discs-{w}{s}" for w in ("wear-archard", "friction") for s in (".svg", ".png")
    ]


@pytest.mark.slow
def test_same_figures_give_the_same_bytes(studied, run, tmp_path):
    (curves,) = curves_of(run)
    for name in ("first", "second"):
        save_study_figures(studied, "discs", ["svg"], tmp_path / name)
        save_figure(plot_wear(correct_drift(run), [curves]), tmp_path / name / "wear.svg")
        save_figure(plot_contact(correct_drift(run), curves), tmp_path / name / "contact.svg")
        save_figure(plot_disc_model({"exact": scenario("full-slip")}, 1e5, 100), tmp_path / name / "model.svg")
    first, second = ({path.name: path.read_bytes() for path in (tmp_path / n).iterdir()} for n in ("first", "second"))
    assert len(first) == 7  # captions, too
    assert first == second


def test_titles_of_panels_do_not_collide():
    runs = [read_run(SAMPLES / run_id) for run_id in (SHORT, *FAST)]
    members = [Member(correct_drift(run), fit_friction(run)) for run in runs]
    figure = plot_study_friction([*members, *members[1:]])
    figure.draw_without_rendering()
    titles = [ax._left_title.get_window_extent() for ax in figure.axes]
    assert len(titles) == 5
    assert not any(one.overlaps(other) for n, one in enumerate(titles) for other in titles[:n])
    assert all(title.x1 <= figure.bbox.x1 for title in titles)
