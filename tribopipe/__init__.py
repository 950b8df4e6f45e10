"""Archive and evaluate tribometer tests, identify wear coefficients, and test wear laws.

>>> import tribopipe
>>> run = tribopipe.read_run("sample_runs/si3n4-air-200mN")
>>> corrected = tribopipe.correct_drift(run)
>>> friction = tribopipe.fit_friction(run)
>>> fit = tribopipe.fit_wear(corrected, "sarkar", friction)
>>> print(fit)  # doctest: +ELLIPSIS
sarkar: pin k_D = ...
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tribopipe.version import VERSION

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive, open_archive
    from tribopipe.base.errors import TribopipeError
    from tribopipe.documents.quantity import Quantity
    from tribopipe.documents.recipe import Recipe
    from tribopipe.documents.study import Study
    from tribopipe.evaluation.checks.registry import check_run
    from tribopipe.evaluation.drift import correct_drift
    from tribopipe.evaluation.friction import fit_friction
    from tribopipe.evaluation.preprocessing.cleaning import clean_run
    from tribopipe.evaluation.study.evaluate import evaluate
    from tribopipe.evaluation.study.member import Member
    from tribopipe.evaluation.wear.fit import fit_wear
    from tribopipe.evaluation.wear.local import LocalOptions, wear_locally
    from tribopipe.evaluation.wear.prediction import fitted_curves, predict_wear, wear_scenario
    from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
    from tribopipe.pipeline.stages import process
    from tribopipe.readers.harmonize import read_run
    from tribopipe.views.clean_up_figures import plot_clean_up
    from tribopipe.views.local_wear_figures import plot_local_wear
    from tribopipe.views.run_figures import plot_contact, plot_depth, plot_friction, plot_wear, save_figure

__version__ = VERSION

__all__ = [
    "Archive",
    "KnownWear",
    "LocalOptions",
    "Member",
    "Quantity",
    "Recipe",
    "Scenario",
    "Study",
    "TribopipeError",
    "__version__",
    "check_run",
    "clean_run",
    "correct_drift",
    "evaluate",
    "fit_friction",
    "fit_wear",
    "fitted_curves",
    "open_archive",
    "plot_clean_up",
    "plot_contact",
    "plot_depth",
    "plot_friction",
    "plot_local_wear",
    "plot_wear",
    "predict_wear",
    "process",
    "read_run",
    "save_figure",
    "wear_locally",
    "wear_scenario",
]

_HOMES = {
    "archive.store": ("Archive", "open_archive"),
    "evaluation.checks.registry": ("check_run",),
    "evaluation.preprocessing.cleaning": ("clean_run",),
    "evaluation.drift": ("correct_drift",),
    "base.errors": ("TribopipeError",),
    "evaluation.friction": ("fit_friction",),
    "readers.harmonize": ("read_run",),
    "pipeline.stages": ("process",),
    "documents.quantity": ("Quantity",),
    "documents.recipe": ("Recipe",),
    "documents.study": ("Study",),
    "views.clean_up_figures": ("plot_clean_up",),
    "views.run_figures": ("plot_contact", "plot_depth", "plot_friction", "plot_wear", "save_figure"),
    "views.local_wear_figures": ("plot_local_wear",),
    "evaluation.study.evaluate": ("evaluate",),
    "evaluation.study.member": ("Member",),
    "evaluation.wear.fit": ("fit_wear",),
    "evaluation.wear.local": ("LocalOptions", "wear_locally"),
    "evaluation.wear.prediction": ("fitted_curves", "predict_wear", "wear_scenario"),
    "evaluation.wear.scenario": ("KnownWear", "Scenario"),
}


def _imported(name: str) -> Any:
    """Import what is asked for when it is asked for: `tribopipe --help` needs no numpy."""
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"tribopipe.{module}"), name)
    if name.startswith("_"):
        raise AttributeError(f"module 'tribopipe' has no attribute {name!r}")
    from tribopipe.base.errors import unknown_name

    raise unknown_name("tribopipe", name, __all__)


if not TYPE_CHECKING:  # A type checker would take every name, misspelt ones too, for one of this module.
    __getattr__ = _imported


def __dir__() -> list[str]:
    return __all__
