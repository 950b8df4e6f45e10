"""A study of pins: k_D of the fitted runs, every run's prediction, and a verdict on each."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import ContactError
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.documents.study import Study
from tribopipe.evaluation.depth_reading import engine_of
from tribopipe.evaluation.measurements.pin_on_disc import end_wear
from tribopipe.evaluation.study.combine import Combination, combine
from tribopipe.evaluation.study.engines import compare_engines, engine_notes
from tribopipe.evaluation.study.life import end_of_life
from tribopipe.evaluation.study.member import Member, PosedRun, RunDraws, chosen
from tribopipe.evaluation.study.shape import Shape, compare_laws
from tribopipe.evaluation.study.verdict import Comparison, compare, decide, exponent, ratio, sentence, single_run_note
from tribopipe.evaluation.wear.depth_problem import DepthProblem
from tribopipe.evaluation.wear.findings import shape_is_rejected, wear_findings
from tribopipe.evaluation.wear.inputs import PIN_SHARED, default_notes
from tribopipe.physics.conventions import WearEngine
from tribopipe.physics.hertz import HARDNESS_UNIT, contact_modulus, hertz_radius
from tribopipe.physics.laws import law_named
from tribopipe.physics.uncertainty import propagate
from tribopipe.results.agreement import (
    BodyVerdict,
    EndOfLife,
    LawComparison,
    LawResult,
    LeftOut,
    Role,
    RunVerdict,
    StudiedBody,
    StudyResult,
    Verdict,
)
from tribopipe.results.study_curves import Evaluation, MeasuredCurve, StudyCurve


def evaluate_pins(
    study: Study, members: Mapping[str, Member], recipe: Recipe | None = None, left_out: Sequence[LeftOut] = ()
) -> Evaluation:
    """Evaluate a study of pins on its runs, ``members`` by id; runs left out are only named.

    Raises ``FitError`` where no run is left to fit, where runs differ in bodies or medium, or where a run lacks
    something that the law needs.
    """
    recipe = recipe or Recipe()
    fit, predict = chosen(study, members, left_out)
    recipe = _one_engine(recipe, fit)
    laws, curves, shapes = [], [], {}
    for law in study.laws:
        found = _Law(study, law, recipe, fit, predict)
        laws.append(found.result())
        curves += found.curves
        shapes[law] = found.shapes
    comparisons: dict[str, LawComparison] = {}
    if {"archard", "sarkar"} <= set(shapes):
        comparisons = {i: compare_laws(shapes["archard"][i], shapes["sarkar"][i]) for i in shapes["archard"]}
    result = StudyResult(
        id=study.id,
        title=study.title,
        tribometer=fit[0].corrected.run.manifest.described.kind,
        correction=recipe.wear.correction,
        laws=tuple(laws),
        comparisons=comparisons,
        left_out=tuple(left_out),
        notes=(*_limits([*fit, *predict]), *single_run_note([member.id for member in fit])),
    )
    return Evaluation(result, tuple(curves))


def _limits(members: Sequence[Member]) -> tuple[str, ...]:
    """Return what the contacts of runs assume, each once."""
    contacts = (member.corrected.run.manifest.described for member in members)
    return tuple(dict.fromkeys(limit for contact in contacts for limit in contact.limits))


def _one_engine(recipe: Recipe, fit: Sequence[Member]) -> Recipe:
    """Return the recipe with one engine for all runs: the GIWM where it is right for each of those fitted."""
    runs = [member.corrected.run for member in fit]
    engines = {engine_of(run.manifest.sliding_pin.pin, end_wear(run, recipe.uncertainty), recipe) for run in runs}
    engine: WearEngine = "giwm" if engines == {"giwm"} else engines.difference({"giwm"}).pop()
    return recipe.model_copy(update={"wear": recipe.wear.model_copy(update={"engine": engine})})


class _Law:
    """One law of a study."""

    def __init__(
        self, study: Study, law: LawName, recipe: Recipe, fit: Sequence[Member], predict: Sequence[Member]
    ) -> None:
        self.study, self.law, self.recipe = study, law, recipe
        self.fitted = [member.pose(law, recipe) for member in fit]
        self.predicted = [member.pose(law, recipe) for member in predict]
        self.shapes = {run.member.id: Shape(run) for run in (*self.fitted, *self.predicted)}
        self.curves: list[StudyCurve] = []
        self._first: list[tuple[Generator, dict[str, Column], list[RunDraws], Column]] = []
        self._combination: Combination | None = None

    def result(self) -> LawResult:
        """Identify k_D, and hold the law against every run."""
        how = self.recipe.monte_carlo
        found = propagate(self._draw, digits=max(1, how.significant_digits), seed=how.seed)
        rng, shared, fitted, following = self._first[0]
        combination = self._combined(fitted)
        best = self._best(combination)
        judged = [self._judge(one, "fitted", best, following) for one in fitted]
        judged += [
            self._judge(run.draw(rng, len(following), shared), "predicted", best, following) for run in self.predicted
        ]
        studied = StudiedBody(
            wear_coefficient=wear_coefficient(best, found.standard_uncertainty),
            interval=(wear_coefficient(found.interval[0]), wear_coefficient(found.interval[1])),
            between_runs=combination.summary,
        )
        return LawResult(
            model=self.law,
            engine=self.fitted[0].problem.engine,
            bodies={self.fitted[0].body: studied},
            draws=len(found.draws),
            rejected=found.rejected,
            runs=tuple(judged),
        )

    def _draw(self, rng: Generator, count: int) -> Column:
        """Draw k_D of the study: the model of JCGM 101."""
        shared = self._shared(rng, count)
        drawn = [run.draw(rng, count, shared) for run in self.fitted]
        mean, following = self._combined(drawn).draw(np.column_stack([one.coefficient for one in drawn]), rng)
        if not self._first:
            accepted = np.isfinite(mean)
            kept = {name: errors[accepted] for name, errors in shared.items()}
            self._first.append((rng, kept, [one.kept(accepted) for one in drawn], following[accepted]))
        return mean

    def _shared(self, rng: Generator, count: int) -> dict[str, Column]:
        names = [name for name in self.study.shared if name in PIN_SHARED]
        # Discs that nobody looked at are as good as the same.
        return {name: rng.standard_normal(count) for name in (*names, "unseen_groove", *law_named(self.law).inputs())}

    def _combined(self, drawn: Sequence[RunDraws]) -> Combination:
        if self._combination is None:
            draws = np.column_stack([one.coefficient for one in drawn])
            solved = draws[np.all(np.isfinite(draws), axis=1)]
            ids = [run.member.id for run in self.fitted]
            self._combination = combine(ids, [run.coefficient for run in self.fitted], solved)
        return self._combination

    def _best(self, combination: Combination) -> float:
        return float(np.sqrt([run.coefficient for run in self.fitted]) @ combination.weights) ** 2

    def _judge(self, draws: RunDraws, role: Role, best: float, coefficients: Column) -> RunVerdict:
        try:
            return self._verdict(draws, role, best, coefficients)
        except ContactError as error:
            raise ContactError(f"{draws.run.member.id}: {error}") from None

    def _verdict(self, draws: RunDraws, role: Role, best: float, coefficients: Column) -> RunVerdict:
        run, comparison = draws.run, compare(draws, best, coefficients)
        self.curves.append(_curve(self.law, role, run, comparison))
        manifest = run.member.corrected.run.manifest
        engines = compare_engines(draws) if role == "fitted" else None
        outcome = _withheld(decide(comparison, lambda factor: run.predicted(best * factor)), run)
        body = self._body(draws, comparison, best, coefficients)
        verdict = RunVerdict(
            id=run.member.id,
            role=role,
            normal_load=manifest.conditions.normal_load,
            end=_metres(run.problem.trace.slid),
            outcome=outcome,
            sentence="",
            notes=(*engine_notes(engines), *_extrapolations(run, comparison), *default_notes(run.problem.inputs)),
            findings=tuple(wear_findings(run.problem)) if isinstance(run.problem, DepthProblem) else (),
            bodies={run.body: body.model_copy(update={"outcome": outcome, "engines": engines})},
            end_of_life=self._end_of_life(draws, coefficients),
        )
        return verdict.model_copy(update={"sentence": sentence(self.law, verdict)})

    def _body(self, draws: RunDraws, comparison: Comparison, best: float, coefficients: Column) -> BodyVerdict:
        run, along = draws.run, comparison.along(0.05)
        worst, shape = int(np.argmax(np.abs(along))), self.shapes[run.member.id]
        return BodyVerdict(
            outcome="not decidable",
            what="wear_depth",
            measured=_metres(comparison.measured[-1], float(np.std(comparison.measured_draws[:, -1]))),
            predicted=_metres(comparison.predicted[-1], float(np.std(comparison.predicted_draws[:, -1]))),
            predicted_interval=_ends(comparison.law_band()),
            measurement_interval=_ends(comparison.measurement_band()),
            e_n=float(comparison.deviation[-1] / comparison.limits(0.05)[-1]),
            e_n_all=float(along[worst]),
            e_n_all_at=_metres(run.places[worst]),
            wear_coefficient=wear_coefficient(run.coefficient, float(np.std(draws.coefficient))),
            coefficient_ratio=ratio(run.coefficient, draws.coefficient, best, coefficients),
            trend=shape.trend(),
            exponent=exponent(draws, comparison, run.predicted(run.coefficient)),
            change_point=shape.change_point(self.recipe.monte_carlo.seed),
        )

    def _end_of_life(self, draws: RunDraws, coefficients: Column) -> EndOfLife | None:
        wanted = self.study.end_of_life
        return None if wanted is None else end_of_life(draws, coefficients, wanted.value)


def _withheld(outcome: Verdict, run: PosedRun) -> Verdict:
    """Return the outcome; a curve that steps, or whose shape rejects a law, does not support it by its end."""
    problem = run.problem
    doubtful = isinstance(problem, DepthProblem) and (
        problem.basis == "measurement" or bool(problem.record.steps) or shape_is_rejected(problem.posterior)
    )
    return "not decidable" if outcome == "supported" and doubtful else outcome


def _metres(value: float, spread: float | None = None) -> Quantity:
    return Quantity(value=float(value), unit="m", standard_uncertainty=spread)


def _ends(band: tuple[Column, Column]) -> tuple[Quantity, Quantity]:
    low, high = (float(side[-1]) for side in band)
    return _metres(max(low, 0.0)), _metres(high)


def _curve(law: LawName, role: Role, run: PosedRun, comparison: Comparison) -> StudyCurve:
    lower, upper = comparison.law_band()
    measurement_lower, measurement_upper = comparison.measurement_band()
    measured = MeasuredCurve(comparison.measured, measurement_lower, measurement_upper)
    return StudyCurve(
        run.member.id,
        law,
        role,
        run.body,
        "wear_depth",
        run.problem.contact.progress.signal,
        run.places,
        comparison.predicted,
        lower,
        upper,
        measured,
    )


def _extrapolations(run: PosedRun, comparison: Comparison) -> list[str]:
    """Say where the contact leaves what the wear model describes."""
    contact, values = run.problem.contact, run.problem.values
    notes: list[str] = []
    if contact.pin.shape != "spherical":
        return notes
    load, radius = values["normal_load"], values["pin_radius"]
    pin = run.problem.pin(values)
    worn = float(pin.worn(pin.volume(comparison.predicted[-1])).radius)
    if worn > radius / 2:
        notes.append(
            f"extrapolation: the predicted contact radius of {_metres(worn).shown('um')} is more than half the tip "
            f"radius of {_metres(radius).shown('um')}, beyond what the model was tested for"
        )
    modulus = contact_modulus(
        pin_modulus=values["pin_modulus"],
        pin_ratio=contact.pin.poisson_ratio.value,
        disc_modulus=values["disc_modulus"],
        disc_ratio=contact.counterbody.poisson_ratio.value,
    )
    start = float(hertz_radius(normal_load=load, pin_radius=radius, modulus=modulus))
    pressure = 1.5 * load / (np.pi * start**2)
    hardness = [
        body.vickers_hardness for body in (contact.pin, contact.counterbody) if body.vickers_hardness is not None
    ]
    if hardness and pressure > min(hardness) * HARDNESS_UNIT:
        found, softer = (
            Quantity(value=value, unit="Pa").shown("GPa") for value in (pressure, min(hardness) * HARDNESS_UNIT)
        )
        notes.append(
            f"extrapolation: Hertz's pressure of {found} at the start exceeds the hardness of the softer body, "
            f"{softer}: it yields before it wears"
        )
    return notes
