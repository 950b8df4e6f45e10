"""Make the figures of README.md and docs/ from sample_runs: `python docs/make_figures.py`."""

from pathlib import Path
from tempfile import TemporaryDirectory

from tribopipe.archive.store import Archive
from tribopipe.pipeline import find_runs, process
from tribopipe.records.recipe import Recipe
from tribopipe.report.archived import save_run_figures
from tribopipe.report.studies import save_study_figures
from tribopipe.studies import load_studies, run_study

HERE = Path(__file__).parent
SAMPLES = HERE.parent / "sample_runs"
SHOWN = (
    "si3n4-air-200mN-depth",
    "si3n4-air-200mN-friction",
    "si3n4-air-wear-archard",
    "si3n4-air-wear-sarkar",
    "si3n4-air-friction",
    "si3n4-air-coefficient",
    "wc-co-water-wear-archard",
)


def main() -> None:
    """Process the sample runs and their studies, and keep the figures that are shown, as SVG."""
    with TemporaryDirectory() as folder:
        archive = Archive(Path(folder))
        for outcome in process(find_runs(SAMPLES), archive):
            if outcome.error is not None:
                raise outcome.error
        written = save_run_figures(archive, "si3n4-air-200mN", ".svg")
        for study in load_studies(sorted(SAMPLES.glob("*.study.toml"))):
            for outcome in run_study(archive, study, Recipe()):
                if outcome.error is not None:
                    raise outcome.error
            written += save_study_figures(archive, study.id, suffixes=(".svg",))
        for path in written:
            if path.stem in SHOWN:
                (HERE / "figures" / path.name).write_bytes(path.read_bytes())


if __name__ == "__main__":
    main()
