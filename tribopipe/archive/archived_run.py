"""One run of an archive as Python sees it: ``archive["si3n4-air-200mN"]``."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from tribopipe.archive.steps import PREDICTIONS, WEAR_FITS, Step, StepsByLaw, step_in_words
from tribopipe.documents.manifest import RunManifest
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.finding import Finding
from tribopipe.results.interactive import Tabular, UnitColumn, views
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_curves import Band, WearCurves
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive


class ArchivedRun(Tabular):
    """A run in an archive. Nothing of it is kept in memory: each attribute reads what is there."""

    def __init__(self, archive: "Archive", run_id: str) -> None:
        self.archive, self._id = archive, run_id

    @property
    def id(self) -> str:
        """Name of the run."""
        return self._id

    @property
    def manifest(self) -> RunManifest:
        """What run.toml states."""
        return self.archive.manifest(self.id)

    @property
    def raw(self) -> RawRun:
        """The run as it was ingested."""
        return self.archive.raw(self.id)

    @property
    def run(self) -> RawRun:
        """The run with its signals preprocessed; as ingested where they were not."""
        return self.archive.cleaned(self.id)

    @property
    def corrected(self) -> CorrectedRun:
        """The run corrected for drift. Raises ``ArchiveError`` where it has not been through that step."""
        correction = self.archive.needed_result(self.id, "drift_correction", DriftCorrection)
        step = self.archive.step(self.id, "drift_correction")
        curves = {} if step is None else {name: values for name, (values, _) in step.curves.items()}
        return CorrectedRun(self.run, correction, curves.get("wear_depth"), curves.get("wander"))

    @property
    def friction(self) -> FrictionFit | None:
        """Fit of the friction coefficient; none where it was not done."""
        fit = self.archive.result(self.id, "friction_fit", FrictionFit)
        return None if fit is None else fit.fitted_to(self.run)

    @property
    def fits(self) -> dict[str, WearFit]:
        """Wear fit under each law that was fitted, by the name of the law."""
        steps = self._under(WEAR_FITS)
        return {
            law: self._drawable(step.result, step) for law, step in steps.items() if isinstance(step.result, WearFit)
        }

    @property
    def predictions(self) -> dict[str, WearPrediction]:
        """Predicted wear under each law that was predicted by, by the name of the law."""
        steps = self._under(PREDICTIONS)
        return {law: step.result for law, step in steps.items() if isinstance(step.result, WearPrediction)}

    @property
    def findings(self) -> list[Finding]:
        """What the checks found when the run was ingested."""
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


def archived_curves(step: Step | None) -> WearCurves | None:
    """Return the fitted or predicted wear curves of a step; none if the step has no curves."""
    if step is None or not step.curves or not isinstance(step.result, WearFit | WearPrediction):
        return None
    names = [name for name in step.curves if f"{name}_lower" in step.curves]
    lines = {name: [step.curves[f"{name}{end}"][0] for end in ("", "_lower", "_upper")] for name in names}
    return WearCurves(step.result, {name: Band(*three, unit=step.curves[name][1]) for name, three in lines.items()})
