"""Runs of a study in which a sensor recorded the wear: curve, shape and measurements compared with a law.

Whether the curve has the shape of the law, whatever its k_D, zero offset and drift: residuals of the pooled reading
are divided by their standard deviation, and what k_D, zero offsets and drift can describe is projected out of them and
out of every alternative. What is left is white noise if the law holds, so that the gain of an alternative is χ²
(trend) or, where its place is searched for, drawn. Whether the way of spreading the load matters: k_D by both wear
engines from the same data.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import Quantity, meters, wear_coefficient
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.depth_reading import engine_of
from tribopipe.evaluation.measurements.kinds import end_wear
from tribopipe.evaluation.study.member import Member, PosedRun, RunDraws
from tribopipe.evaluation.study.verdict import (
    DECISIVE,
    Comparison,
    Judgment,
    KnownCoefficient,
    Question,
    body_verdict,
    decide,
    end_of_life,
)
from tribopipe.evaluation.wear.depth_problem import DepthProblem
from tribopipe.evaluation.wear.findings import shape_is_rejected, wear_findings
from tribopipe.evaluation.wear.law_parameters import with_fitted_law
from tribopipe.evaluation.wear.problem import PRESSURE, WearProblem
from tribopipe.evaluation.wear.uncertainty import solve_draws
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.physics.friction_path import MeasuredFriction
from tribopipe.physics.hertz import HARDNESS_UNIT, hertz_radius
from tribopipe.results.study import (
    ChangePoint,
    EndOfLife,
    EngineComparison,
    Exponent,
    LawComparison,
    MeasuredCurve,
    StudyCurve,
    Trend,
    Verdict,
)

_DRAWS = 1_000
"""Draws that give a standard uncertainty to about 2 %."""


def compare_engines(draws: RunDraws) -> EngineComparison | None:
    """Fit a run by both engines on the same draws of the same data; none unless the pin is a whole sphere.

    A flat pin is worn alike by both, and a truncated sphere by the GIWM only.
    """
    problem = draws.run.problem
    if problem.contact.sliding_tip.shape != "spherical":
        return None
    some = draws.kept(np.arange(len(draws.coefficient)) < _DRAWS)
    # What is not known of the pressure is what the two differ in.
    values = {name: drawn for name, drawn in some.values.items() if name != PRESSURE}
    found = {}
    engines: tuple[WearEngine, ...] = ("giwm", "local")
    for engine in engines:
        posed = _by_engine(problem, engine)
        drawn = solve_draws(posed, values, some.noise)
        found[engine] = wear_coefficient(posed.coefficient(), float(np.nanstd(drawn)))
    giwm, local = found["giwm"], found["local"]
    uncertain = max(giwm.u_or_zero, local.u_or_zero)
    # A doubt that is no input is one that the shape of the reading has removed, or too small to be any.
    doubtful = problem.engine == "local" or PRESSURE in problem.inputs
    trusted: WearEngine | None = "local" if doubtful and abs(local.value - giwm.value) > uncertain else None
    return EngineComparison(giwm=giwm, local=local, trusted=trusted)


def _by_engine(problem: WearProblem, engine: WearEngine) -> WearProblem:
    """Return the fit by an engine, of what the fit itself uses: a reading that one trusts may be none to the other."""
    if isinstance(problem, DepthProblem):
        return replace(problem, engine=engine, given_basis=problem.basis)
    return replace(problem, engine=engine)


def engine_notes(compared: EngineComparison | None) -> tuple[str, ...]:
    """Report where the two differ, and which to trust."""
    if compared is None or compared.trusted is None:
        return ()
    giwm, local = (k.shown(WEAR_COEFFICIENT) for k in (compared.giwm, compared.local))
    return (
        f"k_D is {local} with local contact pressure and {giwm} with the GIWM; the two differ by more than their "
        "standard uncertainty; use the local value: the GIWM assumes uniform pressure, while the pressure at the "
        "center is 1.5 times the mean at the start and becomes uniform only at wear depths that are large compared "
        "with the elastic approach",
    )


_PLAYED = 4_000
"""Draws of pure noise that a searched gain is held against."""
_START = 1e-9
"""Effective distance, m, of what is recorded before any sliding."""
_EDGE = 4
"""Stretches at either end in which no change is looked for."""
_PREFERENCE = 2.0
"""Difference of AIC below which two models are about as good (K. P. Burnham, D. R. Anderson, 2002, 2.6)."""
_CLEAR_PREFERENCE = 10.0
"""That above which one has essentially no support: the noise of a measured friction shifts AIC by several units."""


class Shape:
    """Residuals of the depth signal of one run after subtraction of wear, zero offsets and drift."""

    def __init__(self, run: PosedRun) -> None:
        problem = run.joint
        self.run, self.problem = run, problem
        free = float(problem.solve(problem.values))
        self.coefficient = free if free > 0 else run.coefficient
        count = len(problem.distance)
        depth, slope = problem.model(np.log(self.coefficient), problem.values)
        self.slope = slope[:count]
        self.root = problem.root_weights[:count]
        nuisance = np.column_stack([self.slope * self.root, problem.linear[:count], problem.law_columns[:count]])
        self._basis = np.linalg.qr(nuisance)[0]
        self.residual = self.left_of((problem.rows(problem.values) - depth)[:count])

    def left_of(self, rows: Column) -> Column:
        """Return what nothing else explains of a column, m, in standard deviations."""
        weighted = rows * self.root
        return np.asarray(weighted - self._basis @ (self._basis.T @ weighted))

    @property
    def sum_of_squares(self) -> float:
        """χ² of the shape."""
        return float(self.residual @ self.residual)

    def aic(self) -> float | None:
        """Return AICc = n·ln(χ²/n) + 2p + 2p(p + 1)/(n − p − 1) (C. M. Hurvich, C.-L. Tsai, Biometrika 76 (1989) 297).

        The p parameters are k_D, zero offsets, drift, the variance and all parameters of the law. They are fitted here
        even where the study gives them. None if the run does not determine them.
        """
        own = len(self.problem.law.parameters())
        shape = self._with_free_law() if own else self
        count, fitted = len(self.residual), 2 + self.problem.linear.shape[1] + own
        if shape is None or count <= fitted + 1:
            return None
        penalty = 2 * fitted + 2 * fitted * (fitted + 1) / (count - fitted - 1)
        return float(count * math.log(shape.sum_of_squares / count) + penalty)

    def _with_free_law(self) -> "Shape | None":
        given = self.problem.law.inputs()
        inputs = {name: one for name, one in self.problem.inputs.items() if name not in given}
        try:
            return Shape(replace(self.run, joint=with_fitted_law(replace(self.problem, inputs=inputs))))
        except FitError:
            return None

    def trend(self) -> Trend:
        """Look for what is smooth in the residuals: the next powers of √s."""
        from scipy.stats import chi2

        share = np.sqrt(self.problem.distance / self.problem.distance[-1])
        columns = np.column_stack([share**3, share**4])
        left = np.column_stack([self.left_of(column) for column in columns.T])
        amount, *_ = np.linalg.lstsq(left, self.residual)
        gain = float(np.sum((left @ amount) ** 2))
        amplitude = math.sqrt(float(np.average((left @ amount / self.root) ** 2, weights=self.problem.weights)))
        return Trend(p_value=float(chi2.sf(gain, 2)), amplitude=Quantity(value=amplitude, unit="m"))

    def change_point(self, seed: int = 1) -> ChangePoint | None:
        """Look for the place after which another k_D holds; None if the run has too few stretches.

        ``seed`` is that of the noise which the gain is held against.
        """
        problem = self.problem
        effective = problem.effective_distance(problem.values)
        places = np.arange(_EDGE, len(effective) - _EDGE)
        if not len(places):
            return None
        slid = np.maximum(effective, _START)
        columns = [self.slope * np.maximum(0.0, 1 - effective[place] / slid) for place in places]
        left = np.column_stack([self.left_of(column) for column in columns])
        left /= np.linalg.norm(left, axis=0)
        gains = (left.T @ self.residual) ** 2
        best = int(np.argmax(gains))
        # The columns are orthogonal to what was projected out, so plain noise is as good as projected noise.
        noise = np.random.Generator(np.random.PCG64(seed)).standard_normal((_PLAYED, len(effective)))
        played = np.max((noise @ left) ** 2, axis=1)
        at = float(problem.distance[places[best]])
        return ChangePoint(
            sliding_distance=Quantity(value=at, unit="m"),
            rate_ratio=self._rate_ratio(float(effective[places[best]]), effective),
            p_value=float((np.count_nonzero(played >= gains[best]) + 1) / (_PLAYED + 1)),
        )

    def _rate_ratio(self, change: float, effective: Column) -> float:
        """Return k_D after over k_D before a change at an effective distance, by Gauss–Newton with drift left free."""
        problem = self.problem
        values, load = problem.values, problem.values["normal_load"]
        pin = problem.pin(values)
        count = len(effective)
        # The disc's wear as without the change: it is small.
        disc = problem.model(np.log(self.coefficient), values)[0][:count] - problem.depth(self.coefficient, values)
        reading, free = problem.rows(values)[:count] - disc, np.linalg.qr(problem.linear[:count])[0]
        before, after = np.minimum(effective, change), np.maximum(effective - change, 0.0)
        log_k = np.full(2, np.log(self.coefficient))
        for _ in range(30):
            k = np.exp(log_k)
            state = pin.worn(load * (k[0] * before + k[1] * after))
            slopes = load * np.column_stack([k[0] * before, k[1] * after]) / state.area[:, None]
            rows = np.column_stack([reading - state.depth, slopes]) * self.root[:, None]
            rows -= free @ (free.T @ rows)
            step, *_ = np.linalg.lstsq(rows[:, 1:], rows[:, 0])
            log_k = log_k + np.clip(step, -0.5, 0.5)
        return float(np.exp(log_k[1] - log_k[0]))


def compare_laws(shapes: Mapping[LawName, Shape]) -> LawComparison | None:
    """Compare the laws of a study by Akaike's criterion on the shape of one run; None for fewer than two laws."""
    found = {law: aic for law, shape in shapes.items() if (aic := shape.aic()) is not None}
    if len(found) < 2:
        return None
    best, *others = sorted(found, key=lambda law: found[law])
    noisy = {law for law, shape in shapes.items() if isinstance(shape.problem.friction, MeasuredFriction)}

    def least(other: LawName) -> float:
        return _CLEAR_PREFERENCE if noisy & {best, other} else _PREFERENCE

    return LawComparison(
        delta_aic={law: aic - found[best] for law, aic in found.items()},
        preferred=best if all(found[law] - found[best] >= least(law) for law in others) else None,
    )


_LATER_PART = 0.25
"""Share of the distance after which the local exponent is taken."""


def one_engine(recipe: Recipe, fit: Sequence[Member]) -> Recipe:
    """Return the recipe with one engine for all runs: the GIWM where it is right for each of those fitted."""
    runs = [member.corrected.run for member in fit]
    engines = {engine_of(run.manifest.described.sliding_tip, end_wear(run, recipe.uncertainty), recipe) for run in runs}
    engine: WearEngine = "giwm" if engines == {"giwm"} else engines.difference({"giwm"}).pop()
    return recipe.model_copy(update={"wear": recipe.wear.model_copy(update={"engine": engine})})


def judge_recorded(draws: RunDraws, asked: Question, shape: Shape) -> Judgment:
    """Hold a law against the curve of a run and its end."""
    run = draws.run
    best, coefficients = asked.of(run.bodies[0])
    comparison = compare(draws, best, coefficients)
    engines = compare_engines(draws) if asked.role == "fitted" else None
    decisive = DECISIVE / len(asked.bodies)
    outcome = _withheld(decide(comparison, lambda factor: run.predicted(best * factor), decisive), run)
    known = KnownCoefficient(run.coefficient, draws.coefficient, best, coefficients)
    places = [meters(place) for place in run.places.tolist()]
    body = body_verdict(comparison, outcome, "wear_depth", places, known).model_copy(
        update={
            "trend": shape.trend(),
            "exponent": exponent(draws, comparison, run.predicted(run.coefficient)),
            "change_point": shape.change_point(asked.recipe.monte_carlo.seed),
            "engines": engines,
        }
    )
    wanted = asked.study.end_of_life
    return Judgment(
        bodies={run.bodies[0]: body},
        curves=(_curve(asked, run, comparison),),
        end_of_life=None if wanted is None else life_of_pin(draws, coefficients, wanted.value),
        notes=(*engine_notes(engines), *_extrapolations(run, comparison)),
        findings=tuple(wear_findings(run.problem)) if isinstance(run.problem, DepthProblem) else (),
    )


def compare(draws: RunDraws, coefficient: float, coefficients: Column) -> Comparison:
    """Compare a run with a law whose k_D is known with draws.

    What a law is off by along the curve hardly changes k_D where it is less than u of the wear at the end: a sensor
    of little noise resolves that the elastic deflection is not quite that of the model.
    """
    measured = draws.measured()
    return Comparison(
        draws.run.measured(),
        draws.run.predicted(coefficient),
        measured,
        draws.predicted(coefficients),
        least=float(np.std(measured[:, -1])),
    )


def life_of_pin(draws: RunDraws, coefficients: Column, depth: float) -> EndOfLife | None:
    """Return where a pin reaches a depth, m. Raises ``ContactError`` for a depth past the tip."""
    problem, values = draws.run.problem, draws.values
    wearing = (coefficients > 0)[:, None]
    reached = problem.effective_to(depth, np.where(wearing, coefficients[:, None], 1.0), values)
    wanted = np.where(wearing, reached, np.nan)
    return end_of_life(depth, wanted, lambda reached: problem.effective_distance(values, reached), "m")


def exponent(draws: RunDraws, comparison: Comparison, own: Column) -> Exponent | None:
    """Return the local exponent of h(s) late in the run; None if the curve does not rise above zero there."""
    places = draws.run.places[:-1]
    late = places > _LATER_PART * places[-1]
    measured, drawn = comparison.measured[:-1][late], comparison.measured_draws[:, :-1][:, late]
    risen = np.all(drawn > 0, axis=1)
    if np.any(measured <= 0) or np.count_nonzero(risen) < len(risen) / 2:
        return None
    x = np.log(places[late])
    x = x - np.mean(x)
    pull = x / (x @ x)
    spread = float(np.std(np.log(drawn[risen]) @ pull))
    return Exponent(
        measured=Quantity(value=float(np.log(measured) @ pull), unit="1", standard_uncertainty=spread),
        by_law=float(np.log(own[:-1][late]) @ pull),
    )


def _withheld(outcome: Verdict, run: PosedRun) -> Verdict:
    """Return the outcome; a curve that steps, or whose shape rejects a law, does not support it by its end."""
    problem = run.problem
    doubtful = isinstance(problem, DepthProblem) and (
        problem.basis == "measurement" or bool(problem.record.steps) or shape_is_rejected(problem.posterior)
    )
    return "not decidable" if outcome == "supported" and doubtful else outcome


def _curve(asked: Question, run: PosedRun, comparison: Comparison) -> StudyCurve:
    return StudyCurve(
        run.member.id,
        asked.law,
        asked.role,
        run.bodies[0],
        "wear_depth",
        run.problem.contact.progress.signal,
        run.places,
        comparison.predicted,
        *comparison.law_band(),
        MeasuredCurve(comparison.measured, *comparison.measurement_band()),
    )


def _extrapolations(run: PosedRun, comparison: Comparison) -> list[str]:
    """Report where the contact leaves what the wear model describes."""
    contact, values = run.problem.contact, run.problem.values
    notes: list[str] = []
    if contact.sliding_tip.shape != "spherical":
        return notes
    load, radius = values["normal_load"], values["pin_radius"]
    pin = run.problem.pin(values)
    worn = float(pin.worn(pin.volume(comparison.predicted[-1])).radius)
    if worn > radius / 2:
        notes.append(
            f"extrapolation: the predicted contact radius of {meters(worn).shown('um')} is more than half the tip "
            f"radius of {meters(radius).shown('um')}, beyond the range in which the model was tested"
        )
    modulus = contact.reduced_modulus(values["pin_modulus"], values["disc_modulus"])
    start = float(hertz_radius(normal_load=load, pin_radius=radius, modulus=modulus))
    pressure = 1.5 * load / (np.pi * start**2)
    bodies = contact.bodies.values()
    hardness = [body.vickers_hardness for body in bodies if body.vickers_hardness is not None]
    if hardness and pressure > min(hardness) * HARDNESS_UNIT:
        found, softer = (
            Quantity(value=value, unit="Pa").shown("GPa") for value in (pressure, min(hardness) * HARDNESS_UNIT)
        )
        notes.append(
            f"extrapolation: the Hertzian pressure of {found} at the start exceeds the hardness of the softer body, "
            f"{softer}: the material yields before it wears"
        )
    return notes
