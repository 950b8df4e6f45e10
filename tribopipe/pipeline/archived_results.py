"""Results of archived runs as later steps, reports and pages take them, and runs to predict others from.

These are found in the catalog, so that a large archive takes no longer.
"""

from collections.abc import Iterable, Mapping
from itertools import product

from tribopipe.archive.catalog.catalog import Catalogue
from tribopipe.archive.catalog.listing import ListedRun, of_law
from tribopipe.archive.step_names import WEAR_FITS
from tribopipe.archive.store import Archive, ArchivedRun
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.study import bodies
from tribopipe.evaluation.study.member import Member
from tribopipe.evaluation.wear.local import archards_wear
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import CorrectedRun
from tribopipe.results.wear_fit import NO_FRICTION, WearFit


def archived_correction(archive: Archive, run_id: str) -> CorrectedRun:
    """Return the corrected run as the archive holds it. Raises ``ArchiveError`` where it was not corrected."""
    return ArchivedRun(archive, run_id).corrected


def archived_friction(archive: Archive, run_id: str) -> FrictionFit | None:
    """Return the friction fit as the archive holds it; none where it was not done."""
    return archive.result(run_id, "friction_fit", FrictionFit)


def archived_member(archive: Archive, run_id: str) -> Member:
    """Return a corrected run with its friction, as a study takes it. Raises ``ArchiveError`` where not corrected."""
    return Member(archived_correction(archive, run_id), archived_friction(archive, run_id))


def archived_fit(archive: Archive, run_id: str, law: LawName) -> WearFit:
    """Return the wear fit as the archive holds it. Raises ``ArchiveError`` where it was not done."""
    return archive.needed_result(run_id, WEAR_FITS[law], WearFit)


def archived_coefficients(archive: Archive, run_id: str, law: LawName) -> Mapping[str, Quantity]:
    """Return k_D of each body of a run that wears, as its fit found it and as Archard's law has it.

    Raises ``FitError`` where nothing was fitted.
    """
    fit = archive.result(run_id, WEAR_FITS[law], WearFit)
    if fit is not None and (known := archards_wear(fit)) is not None:
        return known.bodies
    raise FitError(
        f"{run_id}: found no k_D for the law {law} in the archive; expected k_D to compute the wear; run `tribopipe "
        f'fit --law {law} {run_id}`, or specify k_D with --wear-coefficient "13.5e-9 mm^3/(N*mm)"'
    )


_BODIES = (
    *("tribometer", "pin_material", "disc_material", "curved_disc_material", "flat_disc_material"),
    *("medium", "shape", "radius"),
)
"""Columns that are alike for comparable runs, and for few others."""


class References:
    """The runs of an archive that k_D is known of under some wear laws, as they are now."""

    def __init__(self, archive: Archive, laws: Iterable[LawName]) -> None:
        self._archive = archive
        catalogue = Catalogue(archive.folder)
        catalogue.refresh()
        self.unreadable = catalogue.unreadable
        """Files of the archive that cannot be read, each with one sentence why."""
        self._listed = {run.id: run for run in catalogue.runs()}
        self._known: dict[tuple[object, ...], list[ListedRun]] = {}
        for law, run in product(laws, sorted(self._listed.values(), key=_severity)):
            if not run["mark"] and run[f"k_d{of_law(law)}"] is not None:
                self._known.setdefault((law, *_alike(run)), []).append(run)
        self._bodies: dict[str, tuple[object, ...]] = {}

    def lightest(self, run_id: str, law: LawName) -> str | None:
        """Return the comparable run under the lightest load; among those of two discs, the one with the least slip.

        None where there is none, the run is itself the one, or has no friction for the law. A run marked bad never is.
        Raises ``ArchiveError`` where a run is not there, or cannot be read.
        """
        own = self._archive.result(run_id, WEAR_FITS[law], WearFit)
        if own is not None and NO_FRICTION in own.missing:
            return None  # nor could it be predicted under this law
        same, mine = self._bodies_of(run_id), self._listed.get(run_id)
        for run in self._known.get((law, *_alike(mine)), ()) if mine else ():
            if self._bodies_of(run.id) == same and self._is_fitted(run.id, law):
                return None if run.id == run_id else run.id
        return None

    def _bodies_of(self, run_id: str) -> tuple[object, ...]:
        if run_id not in self._bodies:
            self._bodies[run_id] = bodies(self._archive.manifest(run_id))
        return self._bodies[run_id]

    def _is_fitted(self, run_id: str, law: LawName) -> bool:
        fit = self._archive.result(run_id, WEAR_FITS[law], WearFit)
        return fit is not None and fit.outcome == "fitted"


def _alike(run: ListedRun) -> tuple[object, ...]:
    return tuple(run[name] for name in _BODIES)


def _severity(run: ListedRun) -> tuple[float, float]:
    return run.value("load") or 0.0, abs(run.value("slip") or 0.0)
