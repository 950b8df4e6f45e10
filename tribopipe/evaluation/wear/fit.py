"""The wear coefficients k_D of the bodies of one run, whatever its contact.

Where the depth signal of a test gives its wear, k_D is found from it and from post-test measurements together
(curve_fit), else from measurements of the bodies alone (measurement_fit), or from the volume that a pin or its
counterbody has lost (volume_fit). What all have is written here. The interval is that of a Monte Carlo (JCGM 101:2008)
in which every systematic input is drawn once per run.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, Protocol

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import between, wear_coefficient
from tribopipe.documents.recipe import FrictionSource, LawName, MonteCarloRecipe, Recipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.wear.coating import coating_findings
from tribopipe.evaluation.wear.curve_fit import curve_fit
from tribopipe.evaluation.wear.inputs import default_notes
from tribopipe.evaluation.wear.measurement_fit import VolumeFit, correlation, measurement_fit, volume_fit
from tribopipe.evaluation.wear.prediction import fitted_curves, run_scenario
from tribopipe.evaluation.wear.problem import depths_by_signal
from tribopipe.evaluation.wear.scenario import known_wear
from tribopipe.physics.friction_path import ExponentialFriction, FrictionPath
from tribopipe.physics.law_functions import law_of_function
from tribopipe.physics.laws import law_named
from tribopipe.physics.uncertainty import Distribution, first_order_holds, propagate_together
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.finding import Finding, reworded
from tribopipe.results.input_quantities import Inputs
from tribopipe.results.run import CorrectedRun, RawRun
from tribopipe.results.wear_fit import BodyWear, MonteCarlo, WearFit


class Answer(Protocol):
    """Options of a fit, for all methods."""

    @property
    def inputs(self) -> Inputs:
        """Everything uncertain that it depends on."""

    @property
    def friction(self) -> FrictionPath | None:
        """Friction along the test."""

    def result(self) -> WearFit:
        """Return what was found, k_D of each body by first-order propagation."""

    def draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D of each body, m²/N: (draws, bodies)."""


def fit_wear(
    corrected: CorrectedRun | RawRun,
    model: LawName | Callable[..., Any] = "archard",
    friction: FrictionFit | None = None,
    recipe: Recipe | None = None,
) -> WearFit:
    """Identify k_D of the bodies of one run, whatever its contact, under a wear law.

    Sarkar's law takes μ from ``friction`` (Eq. 7), or from the measured curve where the recipe states it. A run that
    does not have depth, post-test measurement or friction passes through, and the result states what is missing.

    Parameters
    ----------
    corrected
        The run, its depth corrected for drift; one as it was read is corrected first.
    model
        Name of the wear law, or a function f of the sliding distance, m, for dh/ds = k_D·p·f(s, …)
        (``tribopipe.physics.law_functions``).
    friction
        Fit of the friction coefficient, for laws that need it.
    recipe
        How to fit.

    Returns
    -------
    WearFit
        k_D of each body, m²/N.

    Raises
    ------
    FitError
        Where the run shows no wear to fit.
    """
    recipe = recipe or Recipe()
    corrected = _corrected(corrected, recipe)
    name = model if isinstance(model, str) else law_of_function(model)
    fit = _fitted(corrected, name, friction, recipe)
    return fit.fitted_to(corrected, lambda: fitted_curves(corrected.run, fit, friction, recipe))


def _corrected(run: CorrectedRun | RawRun, recipe: Recipe) -> CorrectedRun:
    """Return a run corrected for drift. Raises ``TypeError`` where it is no run at all."""
    if isinstance(run, RawRun):
        return correct_drift(run, recipe)
    if isinstance(run, CorrectedRun):
        return run
    raise TypeError(
        f"fit_wear: found {type(run).__name__} {str(run)[:60]!r}; expected a run; call tribopipe.read_run(folder), or "
        "use archive[run_id].corrected"
    )


def _fitted(corrected: CorrectedRun, model: LawName, friction: FrictionFit | None, recipe: Recipe) -> WearFit:
    manifest = corrected.run.manifest
    common: dict[str, Any] = {
        "model": model,
        "distance_per_rotation": None if manifest.slip is None else recipe.wear.distance_per_rotation,
    }
    by_curve = manifest.contact is None or manifest.contact.sensor_tells
    found: Answer | tuple[str, ...] = (curve_fit if by_curve else measurement_fit)(corrected, model, friction, recipe)
    volumes = _by_volume(corrected, model, friction, recipe) if by_curve else None
    if isinstance(found, tuple) and volumes is not None:
        found = volumes
    if isinstance(found, tuple):
        return WearFit(engine=recipe.wear.engine or "giwm", outcome="not fitted", missing=found, **common)
    source: FrictionSource | None = None
    if law_named(model).needs_friction:
        source = "fitted" if isinstance(found.friction, ExponentialFriction) else "measured"
    unfitted = friction.notes if friction and source == "measured" and recipe.wear.friction == "fitted" else ()
    fit = found.result()
    notes = (*fit.notes, *default_notes(found.inputs), *unfitted)
    fit = fit.model_copy(update={**common, "friction": source, "notes": notes})
    fit = _with_monte_carlo(fit, found, recipe.monte_carlo, several=len(manifest.described.fitted_bodies) > 1)
    if isinstance(volumes, VolumeFit) and found is not volumes and fit.engine == "volume":
        fit = _with_counterbody(fit, volumes)
    coatings = tuple(_worn_coatings(corrected.run, fit, friction, recipe))
    return reworded(fit.model_copy(update={"findings": (*fit.findings, *coatings)}), manifest.worded)


def _worn_coatings(run: RawRun, fit: WearFit, friction: FrictionFit | None, recipe: Recipe) -> Iterator[Finding]:
    """Report where coatings wore through by the fit; nothing next to a groove of unknown depth."""
    known = known_wear(fit)
    if known is None or run.manifest.contact is None:
        return
    scenario = run_scenario(run, fit.model, known, friction, recipe)
    with suppress(ContactError):
        if not scenario.known.left_out:
            yield from coating_findings(scenario, float(np.nanmax(run.progress)))


def _by_volume(
    corrected: CorrectedRun, model: LawName, friction: FrictionFit | None, recipe: Recipe
) -> VolumeFit | tuple[str, ...] | None:
    """Return k_D by volumes, or what is missing; none without volumes or bodies, or where another engine is wanted."""
    run = corrected.run
    if run.manifest.contact is None or recipe.wear.engine not in (None, "volume"):
        return None
    return volume_fit(run, model, friction, recipe, depths_by_signal(corrected, recipe))


def _with_counterbody(fit: WearFit, volumes: VolumeFit) -> WearFit:
    """Add k_D of the bodies that the depth signal does not give, by their volumes."""
    others = volumes.of(*(body for body in volumes.bodies if body not in fit.bodies))
    if others is None:
        return fit
    bodies = fit.bodies | others.result().bodies
    return fit.model_copy(update={"bodies": bodies, "correlation": _by_shared_lines(*bodies.values())})


def _by_shared_lines(one: BodyWear, other: BodyWear) -> float | None:
    """Return the correlation of two k_D by what their budgets have in common."""
    shares = [{line.name: line.relative for line in body.budget} for body in (one, other)]
    product = math.prod(math.hypot(*lines.values()) for lines in shares)
    common = shares[0].keys() & shares[1].keys()
    return math.fsum(shares[0][name] * shares[1][name] for name in common) / product if product > 0 else None


def _with_monte_carlo(fit: WearFit, found: Answer, how: MonteCarloRecipe, *, several: bool) -> WearFit:
    """Replace the first-order intervals by those of a Monte Carlo, and report where the two disagree."""
    if not how.significant_digits:
        return fit
    drawn = propagate_together(found.draw, digits=how.significant_digits, seed=how.seed)
    bodies: dict[str, BodyWear] = {}
    notes: list[str] = []
    for (name, body), distribution in zip(fit.bodies.items(), drawn, strict=True):
        bodies[name], doubts = _with_draws(body, distribution, how.significant_digits)
        notes += [f"{spoken(name)}: {doubt}" if several else doubt for doubt in doubts]
    together = correlation(np.cov([one.draws for one in drawn])) if len(drawn) > 1 else None
    return fit.model_copy(update={"bodies": bodies, "correlation": together, "notes": (*fit.notes, *notes)})


def _with_draws(body: BodyWear, found: Distribution, digits: int) -> tuple[BodyWear, tuple[str, ...]]:
    """Replace the first-order results for k_D of a body by those of the draws, and note disagreement (JCGM 101, 8)."""
    low, high = first_order = body.interval
    agrees = first_order_holds((low.value, high.value), found, digits)
    record = MonteCarlo(
        draws=len(found.draws),
        mean=wear_coefficient(found.mean),
        standard_uncertainty=wear_coefficient(found.standard_uncertainty),
        stable=found.stable,
        first_order_interval=first_order,
        agrees_with_first_order=agrees,
    )
    ends = between(first_order, WEAR_COEFFICIENT)
    note = f"first-order propagation and Monte Carlo disagree: the first-order 95 % CI would be {ends}"
    changed = {
        "wear_coefficient": body.wear_coefficient.model_copy(
            update={"standard_uncertainty": found.standard_uncertainty}
        ),
        "interval": (wear_coefficient(found.interval[0]), wear_coefficient(found.interval[1])),
        "monte_carlo": record,
    }
    return body.model_copy(update=changed), () if agrees else (note,)
