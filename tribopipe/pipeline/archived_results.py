"""Results of an archived run as later steps, reports and pages take them."""

from tribopipe.archive.archived_run import ArchivedRun
from tribopipe.archive.steps import WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.evaluation.wear.local import archards_wear
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import CorrectedRun
from tribopipe.results.wear_fit import WearFit


def archived_correction(archive: Archive, run_id: str) -> CorrectedRun:
    """Return the corrected run as the archive holds it. Raises ``ArchiveError`` where it was not corrected."""
    return ArchivedRun(archive, run_id).corrected


def archived_friction(archive: Archive, run_id: str) -> FrictionFit | None:
    """Return the friction fit as the archive holds it; none where it was not done."""
    return archive.result(run_id, "friction_fit", FrictionFit)


def archived_fit(archive: Archive, run_id: str, law: LawName) -> WearFit:
    """Return the wear fit as the archive holds it. Raises ``ArchiveError`` where it was not done."""
    return archive.needed_result(run_id, WEAR_FITS[law], WearFit)


def archived_coefficients(archive: Archive, run_id: str, law: LawName) -> list[Quantity]:
    """Return k_D of each body of a run that wears, as its fit found it and as Archard's law has it.

    Raises ``FitError`` where nothing was fitted.
    """
    fit = archive.result(run_id, WEAR_FITS[law], WearFit)
    if fit is not None and (known := archards_wear(fit)) is not None:
        return list(known.bodies.values())
    raise FitError(
        f"{run_id}: found no k_D under {law} in the archive; expected one to compute the wear; run `tribopipe fit "
        f'--law {law} {run_id}`, or give one with --wear-coefficient "13.5e-9 mm^3/(N*mm)"'
    )
