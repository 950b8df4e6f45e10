"""Every figure that `process`, `study run` and `report` draw of the sample runs is fit to print."""

import shutil

import pytest
from folders import ALL_IDS, SAMPLES
from matplotlib.figure import Figure
from printable import faults, letter_sizes

from tribopipe.archive.store import Archive
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline.studies import find_studies, load_studies, process_studies
from tribopipe.views.archived_figures import run_figures, study_figures

STUDIES = [path.name.removesuffix(".study.toml") for path in sorted(SAMPLES.glob("*.study.toml"))]


@pytest.fixture(scope="module")
def archive(sample_archive, disc_archive, further_archive, tmp_path_factory) -> Archive:
    """What `process sample_runs` leaves, made with fewer draws."""
    folder = tmp_path_factory.mktemp("all") / "archive"
    for one in (sample_archive, disc_archive, further_archive):
        shutil.copytree(one.folder, folder, dirs_exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 2_000)
        outcomes = list(process_studies(Archive(folder), load_studies(find_studies(SAMPLES)), Recipe()))
    assert [outcome for outcome in outcomes if outcome.status == "failed"] == []
    return Archive(folder)


@pytest.mark.slow
@pytest.mark.parametrize("run_id", ALL_IDS)
def test_figures_of_a_run(archive, run_id):
    figures = run_figures(archive, run_id)
    assert "wear" in figures
    assert {what: faults(figure) for what, figure in figures.items()} == {what: [] for what in figures}


@pytest.mark.slow
@pytest.mark.parametrize("study", STUDIES)
def test_figures_of_a_study(archive, study):
    figures = study_figures(archive, study)
    assert "wear-archard" in figures
    assert {what: faults(figure) for what, figure in figures.items()} == {what: [] for what in figures}


# --- that faults are seen ---


@pytest.fixture
def figure() -> Figure:
    return Figure(figsize=(3.0, 2.0))


def test_a_figure_without_faults(figure):
    ax = figure.subplots()
    ax.plot([0, 1], label="wear")
    ax.set_ylabel("depth")
    figure.tight_layout()
    assert faults(figure) == []


@pytest.mark.parametrize(
    ("place", "words", "size", "fault"),
    [
        ((0.5, 0.5), "wear volume", 8, "overlap: 'measured' and 'wear volume'"),
        ((0.9, 0.1), "cylindrical disc", 8, "cut off: 'cylindrical disc'"),
        ((0.1, 0.1), "tiny", 5, "letters of 5.0 pt: 'tiny'"),
        ((0.1, 0.1), r"$k_\mathrm{D}$", 8, r"letters of 5.6 pt: '$k_\\mathrm{D}$'"),
    ],
)
def test_each_fault_is_named(figure, place, words, size, fault):
    figure.text(0.5, 0.5, "measured", fontsize=8)
    figure.text(*place, words, fontsize=size)
    assert faults(figure) == [fault]


def test_a_legend_on_a_panel_is_named(figure):
    ax = figure.add_axes((0.3, 0.3, 0.6, 0.6), ylabel="depth", xticks=[], yticks=[])
    ax.plot([0, 1], label="wear")
    figure.legend(loc="center")
    assert faults(figure) == ["a legend lies on 'depth'"]


def test_ticks_out_of_range_are_no_texts(figure):
    ax = figure.add_axes((0.2, 0.2, 0.6, 0.6))
    ax.set_xticks([0.5, 99.0], ["near", "far, far away, and not drawn"])
    ax.set_xlim(0, 1)
    assert faults(figure) == []


def test_subscripts_have_seven_tenths_of_the_size(figure):
    assert letter_sizes(figure.text(0, 0, "pressure\n$p_0$ in MPa", fontsize=10)) == {10.0, 7.0}
