"""The run that another one is predicted from, found in the catalogue, so that a large archive takes no longer."""

from collections.abc import Mapping

from tribopipe.archive.catalogue.catalogue import Catalogue
from tribopipe.archive.catalogue.listed import ListedRun
from tribopipe.archive.steps import WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.records.base import Record
from tribopipe.records.disc_results import TwinDiscFit
from tribopipe.records.recipe import LawName
from tribopipe.records.results import WearFit
from tribopipe.study.bodies import bodies

_BODIES = (
    *("tribometer", "pin_material", "disc_material", "curved_disc_material", "flat_disc_material"),
    *("medium", "shape", "radius"),
)
"""Columns that are alike for comparable runs, and for few others."""
_K_D: Mapping[LawName, tuple[str, str]] = {
    "archard": ("k_d", "k_d_flat"),
    "sarkar": ("k_d_sarkar", "k_d_sarkar_flat"),
}


def lightest(archive: Archive, run_id: str, law: LawName) -> str | None:
    """Return the comparable run under the lightest load that k_D is known of, as `tribopipe process` predicts from it.

    None where there is no other, or the run is itself the one. Raises ``ArchiveError`` where a run cannot be read.
    """
    catalogue = Catalogue(archive.folder)
    catalogue.refresh()
    listed = catalogue.runs()
    mine = next((run for run in listed if run.id == run_id), None)
    same = bodies(archive.manifest(run_id))
    for run in sorted((run for run in listed if mine and _may_be(run, mine, law)), key=_severity):
        if bodies(archive.manifest(run.id)) == same and _is_fitted(archive, run.id, law):
            return run.id if run.id != run_id else None
    return None


def _may_be(run: ListedRun, mine: ListedRun, law: LawName) -> bool:
    known = any(run[name] is not None for name in _K_D[law]) and not run["mark"]
    return known and all(run[name] == mine[name] for name in _BODIES)


def _severity(run: ListedRun) -> tuple[float, float]:
    return run.value("load") or 0.0, abs(run.value("slip") or 0.0)


def _is_fitted(archive: Archive, run_id: str, law: LawName) -> bool:
    fit = archive.result(run_id, WEAR_FITS[law], Record)
    return isinstance(fit, WearFit | TwinDiscFit) and fit.outcome == "fitted"
