"""What the steps of a run found, as plots take it; columns and curves are read as they are drawn."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Generic, TypeVar

from tribopipe.archive.steps import StepName
from tribopipe.browse.samples import RunFile
from tribopipe.documents.signals import SIGNALS
from tribopipe.results.evaluation import DriftCorrection
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_curves import Band, WearCurves
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction
from tribopipe.views.plot import Panel
from tribopipe.views.run_plots import CORRECTED, RAW, WANDER

K = TypeVar("K", bound=str)
V = TypeVar("V")


class ReadOnDemand(Mapping[K, V], Generic[K, V]):
    """Values of some names, each read whenever it is asked for."""

    def __init__(self, names: Iterable[K], read: Callable[[K], V]) -> None:
        self._names, self._read = tuple(names), read

    def __getitem__(self, name: K) -> V:
        if name not in self._names:
            raise KeyError(name)
        return self._read(name)

    def __iter__(self) -> Iterator[K]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


def raw_run(run: RunFile, *, recorded: bool = False) -> RawRun:
    """Return a run, by the name of its file, with its preprocessed signals, or as recorded."""
    found = {name: RAW + name if recorded else run.signal_path(name) for name in SIGNALS}
    paths = {name: path for name, path in found.items() if path and path in run.datasets}
    columns = ReadOnDemand(paths, lambda name: run.sampled(paths[name]))
    manifest = run.outline.manifest.model_copy(update={"id": run.id})
    return RawRun(manifest, columns, run.outline.origins, {}, {}, ())


def corrected_run(run: RunFile) -> CorrectedRun:
    """Return a run with its drift-corrected wear; without wear if drift was not corrected."""
    correction = run.result("drift_correction", DriftCorrection) or DriftCorrection(outcome="uncorrected")
    return CorrectedRun(raw_run(run), correction, run.curve(CORRECTED), run.curve(WANDER))


def wear_curves(run: RunFile, steps: Mapping[str, StepName]) -> list[WearCurves]:
    """Return wear by each law that has curves."""
    return [curves for step in steps.values() if (curves := _curves(run, step)) is not None]


def _curves(run: RunFile, step: StepName) -> WearCurves | None:
    result = run.result(step, WearFit) or run.result(step, WearPrediction)
    data, end = f"/entry/{step}/data/", "_lower"
    names = [path[len(data) : -len(end)] for path in run.datasets if path.startswith(data) and path.endswith(end)]

    def read(name: str) -> Band:
        best, lower, upper = (run.sampled(f"{data}{name}{edge}") for edge in ("", "_lower", "_upper"))
        return Band(best, lower, upper, unit="")

    return WearCurves(result, ReadOnDemand(names, read)) if result is not None and names else None


def located(run: RunFile, panels: Iterable[Panel]) -> tuple[Panel, ...]:
    """Return panels with the paths of the datasets that their curves are; none of those that the file does not hold."""

    def path(name: str | None) -> str | None:
        signal = next((known for known in SIGNALS if known == name), None)
        found = name if signal is None else run.signal_path(signal)
        return found if found in run.datasets else None

    return tuple(
        replace(panel, curves=tuple(replace(curve, path=path(curve.path)) for curve in panel.curves))
        for panel in panels
    )
