"""From tribometer run folders to wear laws that can be trusted.

>>> import tribopipe
>>> run = tribopipe.read_run("sample_runs/si3n4-air-200mN")
>>> corrected = tribopipe.correct_drift(run)
>>> friction = tribopipe.fit_friction(run)
>>> fit = tribopipe.fit_wear(corrected, "sarkar", friction)
>>> print(fit)  # doctest: +ELLIPSIS
sarkar: k_D = ...
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tribopipe.version import VERSION

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive, open_archive
    from tribopipe.checks.registry import check_run
    from tribopipe.clean_up.cleaning import clean_run
    from tribopipe.drift import correct_drift
    from tribopipe.errors import TribopipeError
    from tribopipe.friction import fit_friction
    from tribopipe.ingest.harmonise import read_run
    from tribopipe.pipeline import process
    from tribopipe.records.quantity import Quantity
    from tribopipe.records.recipe import Recipe
    from tribopipe.records.study import Study
    from tribopipe.report.clean_up_figures import plot_clean_up
    from tribopipe.report.disc_figures import plot_disc_contact, plot_disc_wear
    from tribopipe.report.figures import plot_depth, plot_friction, plot_wear, save_figure
    from tribopipe.report.local_wear_figures import plot_local_discs, plot_local_pin
    from tribopipe.study.discs import evaluate_discs
    from tribopipe.study.evaluate import evaluate
    from tribopipe.study.member import Member
    from tribopipe.wear.curves import fitted_curve
    from tribopipe.wear.identify import fit_wear
    from tribopipe.wear.local import LocalOptions, wear_locally
    from tribopipe.wear.predict import WearScenario, predict_wear
    from tribopipe.wear.twin_disc.curves import fitted_discs
    from tribopipe.wear.twin_disc.identify import fit_discs
    from tribopipe.wear.twin_disc.predict import DiscScenario, predict_discs

__version__ = VERSION

__all__ = [
    "Archive",
    "DiscScenario",
    "LocalOptions",
    "Member",
    "Quantity",
    "Recipe",
    "Study",
    "TribopipeError",
    "WearScenario",
    "__version__",
    "check_run",
    "clean_run",
    "correct_drift",
    "evaluate",
    "evaluate_discs",
    "fit_discs",
    "fit_friction",
    "fit_wear",
    "fitted_curve",
    "fitted_discs",
    "open_archive",
    "plot_clean_up",
    "plot_depth",
    "plot_disc_contact",
    "plot_disc_wear",
    "plot_friction",
    "plot_local_discs",
    "plot_local_pin",
    "plot_wear",
    "predict_discs",
    "predict_wear",
    "process",
    "read_run",
    "save_figure",
    "wear_locally",
]

_HOMES = {
    "archive.store": ("Archive", "open_archive"),
    "checks.registry": ("check_run",),
    "clean_up.cleaning": ("clean_run",),
    "drift": ("correct_drift",),
    "errors": ("TribopipeError",),
    "friction": ("fit_friction",),
    "ingest.harmonise": ("read_run",),
    "pipeline": ("process",),
    "records.quantity": ("Quantity",),
    "records.recipe": ("Recipe",),
    "records.study": ("Study",),
    "report.clean_up_figures": ("plot_clean_up",),
    "report.disc_figures": ("plot_disc_contact", "plot_disc_wear"),
    "report.figures": ("plot_depth", "plot_friction", "plot_wear", "save_figure"),
    "report.local_wear_figures": ("plot_local_discs", "plot_local_pin"),
    "study.discs": ("evaluate_discs",),
    "study.evaluate": ("evaluate",),
    "study.member": ("Member",),
    "wear.curves": ("fitted_curve",),
    "wear.identify": ("fit_wear",),
    "wear.local": ("LocalOptions", "wear_locally"),
    "wear.predict": ("WearScenario", "predict_wear"),
    "wear.twin_disc.curves": ("fitted_discs",),
    "wear.twin_disc.identify": ("fit_discs",),
    "wear.twin_disc.predict": ("DiscScenario", "predict_discs"),
}


def _imported(name: str) -> Any:
    """Import what is asked for when it is asked for: `tribopipe --help` needs no numpy."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"tribopipe.{module}"), name)
    raise AttributeError(f"module 'tribopipe' has no attribute {name!r}")


if not TYPE_CHECKING:  # A type checker would take every name, misspelt ones too, for one of this module.
    __getattr__ = _imported


def __dir__() -> list[str]:
    return __all__
