"""Make the figures of README.md from sample_runs: `python docs/make_figures.py`."""

from pathlib import Path
from tempfile import TemporaryDirectory

from tribopipe.archive.store import Archive
from tribopipe.pipeline import find_runs, process
from tribopipe.report.archived import save_run_figures

HERE = Path(__file__).parent
SHOWN = {"si3n4-air-200mN": ("depth", "friction"), "si3n4-air-800mN": ("wear",)}


def main() -> None:
    """Process the Si3N4 runs and keep the figures that the README shows, as SVG."""
    runs = [run for run in find_runs(HERE.parent / "sample_runs") if run.name.startswith("si3n4")]
    with TemporaryDirectory() as folder:
        archive = Archive(Path(folder))
        for outcome in process(runs, archive):
            if outcome.error is not None:
                raise outcome.error
        for run_id, wanted in SHOWN.items():
            for written in save_run_figures(archive, run_id, ".svg"):
                if written.stem.removeprefix(f"{run_id}-") in wanted:
                    (HERE / "figures" / written.name).write_bytes(written.read_bytes())


if __name__ == "__main__":
    main()
