"""Results of an archived run as later steps, reports and pages take them."""

from tribopipe.archive.steps import WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.base.errors import FitError
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record
from tribopipe.evaluation.wear.local import archards_discs
from tribopipe.results.disc_evaluation import TwinDiscFit
from tribopipe.results.evaluation import DriftCorrection, FrictionFit, WearFit
from tribopipe.results.run import CorrectedRun


def archived_correction(archive: Archive, run_id: str) -> CorrectedRun:
    """Return the corrected run as the archive holds it. Raises ``ArchiveError`` where it was not corrected."""
    correction = archive.needed_result(run_id, "drift_correction", DriftCorrection)
    step = archive.step(run_id, "drift_correction")
    curves = {} if step is None else {name: values for name, (values, _) in step.curves.items()}
    return CorrectedRun(archive.cleaned(run_id), correction, curves.get("wear_depth"), curves.get("wander"))


def archived_friction(archive: Archive, run_id: str) -> FrictionFit | None:
    """Return the friction fit as the archive holds it; none where it was not done."""
    return archive.result(run_id, "friction_fit", FrictionFit)


def archived_fit(archive: Archive, run_id: str, law: LawName) -> WearFit | TwinDiscFit:
    """Return the wear fit as the archive holds it. Raises ``ArchiveError`` where it was not done."""
    fit = archive.needed_result(run_id, WEAR_FITS[law], Record)
    return fit if isinstance(fit, TwinDiscFit) else archive.needed_result(run_id, WEAR_FITS[law], WearFit)


def archived_coefficients(archive: Archive, run_id: str, law: LawName) -> list[Quantity]:
    """Return k_D of a run as its fit found it, of discs both as Archard's law has them.

    Raises ``FitError`` where nothing was fitted.
    """
    fit = archive.result(run_id, WEAR_FITS[law], Record)
    if isinstance(fit, TwinDiscFit) and (discs := archards_discs(fit)) is not None:
        return [discs.curved, discs.flat]
    if isinstance(fit, WearFit) and fit.wear_coefficient is not None:
        return [fit.wear_coefficient]
    raise FitError(
        f"{run_id}: found no k_D under {law} in the archive; expected one to wear the run by; run `tribopipe fit "
        f'--law {law} {run_id}`, or give one, --wear-coefficient "13.5e-9 mm^3/(N*mm)"'
    )
