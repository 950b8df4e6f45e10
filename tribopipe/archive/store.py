"""An archive folder as Python sees it: ``archive["si3n4-air-200mN"]`` is a run, whose attributes read its file."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tribopipe.archive.outline import archived_curves
from tribopipe.archive.run_files import RunFiles
from tribopipe.archive.step_names import PREDICTIONS, WEAR_FITS, Step, StepsByLaw, step_in_words
from tribopipe.base.errors import unknown_name
from tribopipe.documents.manifest import RunManifest
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.finding import Finding
from tribopipe.results.interactive import Tabular, UnitColumn, views
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction

if TYPE_CHECKING:
    from pandas import DataFrame


class ArchivedRun(Tabular):
    """A run in an archive. Each attribute is read from the file when it is used."""

    def __init__(self, archive: "Archive", run_id: str) -> None:
        self.archive, self._id = archive, run_id

    @property
    def id(self) -> str:
        """Name of the run."""
        return self._id

    @property
    def manifest(self) -> RunManifest:
        """Content of run.toml."""
        return self.archive.manifest(self.id)

    @property
    def raw(self) -> RawRun:
        """The run as it was ingested."""
        return self.archive.raw(self.id)

    @property
    def run(self) -> RawRun:
        """The run with preprocessed signals; as ingested if there was no preprocessing."""
        return self.archive.cleaned(self.id)

    @property
    def corrected(self) -> CorrectedRun:
        """The run corrected for drift. Raises ``ArchiveError`` if it has no drift correction."""
        correction = self.archive.needed_result(self.id, "drift_correction", DriftCorrection)
        step = self.archive.step(self.id, "drift_correction")
        curves = {} if step is None else {name: values for name, (values, _) in step.curves.items()}
        names = ("wear_depth", "wander", "pin_wear_depth")
        return CorrectedRun(self.run, correction, *(curves.get(name) for name in names))

    @property
    def friction(self) -> FrictionFit | None:
        """Fit of the friction coefficient; none if the run has no such step."""
        fit = self.archive.result(self.id, "friction_fit", FrictionFit)
        return None if fit is None else fit.fitted_to(self.run)

    @property
    def fits(self) -> dict[str, WearFit]:
        """Wear fits by the name of the wear law."""
        steps = self._under(WEAR_FITS)
        return {
            law: self._drawable(step.result, step) for law, step in steps.items() if isinstance(step.result, WearFit)
        }

    @property
    def predictions(self) -> dict[str, WearPrediction]:
        """Predicted wear by the name of the wear law."""
        steps = self._under(PREDICTIONS)
        return {law: step.result for law, step in steps.items() if isinstance(step.result, WearPrediction)}

    @property
    def findings(self) -> list[Finding]:
        """Findings of the checks at ingest."""
        return self.archive.findings(self.id)

    @property
    def tags(self) -> tuple[str, ...]:
        """Tags that the run has now."""
        return self.archive.tags(self.id)

    def unit_columns(self) -> Mapping[str, UnitColumn]:
        """Return the signals, and the corrected wear where the run was corrected, each with its SI unit."""
        corrected = "drift_correction" in self.archive.step_names(self.id)
        return (self.corrected if corrected else self.run).unit_columns()

    def to_datatree(self) -> Any:
        """Return the tables of `tribopipe export csv` as an xarray DataTree, one group per table.

        Takes the package xarray: pip install "tribopipe[xarray]".
        """
        return views().datatree(self)

    def __len__(self) -> int:
        return self.archive.outline(self.id).samples

    def __str__(self) -> str:
        steps = ", ".join(map(step_in_words, self.archive.step_names(self.id)))
        return f"run {self.id}: {steps or 'ingested'}"

    def __repr__(self) -> str:
        return f"<{self}>"

    def _drawable(self, fit: WearFit, step: Step) -> WearFit:
        return fit.fitted_to(self.corrected, lambda: archived_curves(step))

    def _under(self, laws: StepsByLaw) -> dict[str, Step]:
        steps = self.archive.steps(self.id)
        return {law: step for name, step in steps.items() if (law := laws.law_of(name)) is not None}


class Archive(RunFiles):
    """The runs in a folder. Every call reads the files; nothing is kept in memory."""

    def __repr__(self) -> str:
        return f"Archive({str(self.folder)!r}, {len(self.ids())} runs)"

    def __getitem__(self, run_id: str) -> ArchivedRun:
        """Return a run. Raises ``UnknownNameError``, a ``KeyError``, where there is none of that id."""
        if run_id not in self:
            raise unknown_name(f"archive {self.folder}", run_id, self.ids(), "archive.ids() lists all")
        return ArchivedRun(self, run_id)

    if not TYPE_CHECKING:  # A type checker would take every name for an attribute.

        def __getattr__(self, name: str) -> Any:
            """Raise ``UnknownNameError``, which names what there is instead."""
            if name.startswith("_") or "folder" not in vars(self):  # the latter while it is unpickled
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            known = [known for known in dir(self) if not known.startswith("_")]
            raise unknown_name(f"archive {self.folder}", name, known, "runs are items: archive[run_id]")

    def values(self) -> Iterator[ArchivedRun]:
        """Yield all runs in natural order of their ids."""
        return (ArchivedRun(self, run_id) for run_id in self.ids())

    def items(self) -> Iterator[tuple[str, ArchivedRun]]:
        """Give each run with its id, in natural order."""
        return ((run.id, run) for run in self.values())

    def _ipython_key_completions_(self) -> list[str]:
        return self.ids()

    def table(self, where: str = "", sort: str = "id", columns: str | None = None) -> "DataFrame":
        """Return the runs as a pandas DataFrame.

        Parameters
        ----------
        where
            Query that selects runs, such as ``"material=Si3N4 load>300mN"``, as for `tribopipe ls`.
        sort
            Columns to sort by, such as ``"material,-k_d"``.
        columns
            Columns, such as ``"id,load,k_d"``; all by default.

        Returns
        -------
        pandas.DataFrame
            One row per run, numbers in SI, each with its standard uncertainty (``k_d``, ``u_k_d``); None or NaN where
            nothing is known. ``table.attrs["units"]`` has the unit of each column of numbers.

        Raises
        ------
        QueryError
            Where the query, the order or a column cannot be understood.
        """
        table: DataFrame = views().runs_table(self.folder, where, sort, columns)
        return table

    def _repr_html_(self) -> str:
        page: str = views().page(self)
        return page


def open_archive(folder: Path | str = "archive") -> Archive:
    """Return the archive in a folder, which need not exist yet."""
    return Archive(folder)
