"""Doubts about the wear coefficient of a run: one sentence each, with a code and a remedy.

`rate_change` distinguishes a wear rate that changes once from slow sensor drift.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tribopipe.base.errors import counted
from tribopipe.base.units import WEAR_COEFFICIENT, show
from tribopipe.documents.quantity import Quantity, wear_coefficient
from tribopipe.documents.recipe import Recipe
from tribopipe.evaluation.depth_reading import DECISIVE, MOST_DEVIATION
from tribopipe.evaluation.measurements.kinds import worn_bodies
from tribopipe.evaluation.wear.depth_problem import DepthProblem
from tribopipe.evaluation.wear.problem import PRESSURE
from tribopipe.physics.depth_model.mixture import log_evidence_of_noise
from tribopipe.physics.depth_model.posterior import SLOPE_STEP, DepthPosterior, regressions_of
from tribopipe.physics.depth_model.prior_sensitivity import Prior, widened
from tribopipe.physics.depth_model.terms import AMPLITUDES
from tribopipe.results.finding import Finding
from tribopipe.results.run import RawRun

_PLACES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
_LAST_PLACE = 0.98
_FARTHEST_RATIOS = (1e-3, 1e2)
_STOPPED = 0.05
"""k_D after over k_D before, below which wear has stopped, as far as a depth signal shows."""
_RATIOS = (0.1, 0.2, 0.33, 0.5, 0.67, 1.5, 2.0, 3.0, 5.0, 10.0)
_CLEARLY = 3.0
"""ln of the odds against wander from which on a change is named."""
_WORN = 3.0
"""Standard uncertainties from which on a lost volume is wear."""


@dataclass(frozen=True)
class RateChange:
    """Change of k_D at one sliding distance."""

    distance: float
    """Sliding distance of the change, m."""
    ratio: float
    """k_D after over k_D before."""


def rate_change(problem: DepthProblem) -> RateChange | None:
    """Return where k_D changes, if a change once is a better account of a reading than wander; else none."""
    evidence = _evidence_of_change(problem)
    found = {by: evidence(*by) for by in product(_PLACES, _RATIOS)}
    averaged = float(np.logaddexp.reduce(list(found.values()))) - np.log(len(found))
    place, ratio, peak = _best_change(evidence, max(found, key=lambda by: found[by]))
    # A clear change is a peak between the places and ratios tried, and is judged by Schwarz's criterion.
    together = max(averaged, peak - np.log(len(problem.reading.time)))
    others = problem.posterior.log_evidence
    return RateChange(place * problem.trace.slid, ratio) if together > others + _CLEARLY else None


def _best_change(evidence: Callable[[float, float], float], first: tuple[float, float]) -> tuple[float, float, float]:
    """Return place and ratio of the change with the largest evidence near a first one, and its evidence."""
    from scipy.optimize import minimize

    best = minimize(
        lambda by: -evidence(by[0], np.exp(by[1])),
        (first[0], np.log(first[1])),
        method="Nelder-Mead",
        bounds=((_PLACES[0], _LAST_PLACE), np.log(_FARTHEST_RATIOS)),
        options={"xatol": 1e-3, "fatol": 0.1},
    )
    return float(best.x[0]), float(np.exp(best.x[1])), float(-best.fun)


def _evidence_of_change(problem: DepthProblem) -> Callable[[float, float], float]:
    """Return a function of a place, as a share of the distance, and of k_D after over k_D before.

    It gives the evidence that k_D changes so, and that the reading is the sum of wear, a straight line and noise.
    """
    reference = problem.posterior.reference
    plain = regressions_of(problem.reading, reference)[0]
    # Of the optional columns, none of which is in that sum, one is left.
    normal = plain.normal[:, : len(plain.known_mean) + 1]
    still = replace(plain, normal=normal, alternatives=plain.alternatives[:1])
    pin, nodes, step = problem.pin(problem.values), problem.samples.nodes, SLOPE_STEP * reference
    volumes = pin.volume(np.array([[reference], [reference - step], [reference + step]]))
    slid = problem.trace.slid
    effective = problem.effective_distance(problem.values, np.append(nodes.distance, slid))
    effective, whole = effective[:-1], effective[-1]

    def evidence(place: float, ratio: float) -> float:
        change = problem.effective_distance(problem.values, np.asarray([place * slid]))
        worn = np.minimum(effective, change) + ratio * np.maximum(effective - change, 0.0)
        share = worn / (change + ratio * (whole - change))
        course, low, high = nodes.averaged(pin.worn(volumes * share).depth)
        flat = np.column_stack([(high - low) / (2 * step), still.flat[:, 1:]])
        return log_evidence_of_noise(replace(still, reading=problem.reading.depth - course, flat=flat))

    return evidence


_PROBABLE = 0.8
_FAR = 3.0
"""Standard uncertainties from which on a k_D of another engine is another k_D."""


def wear_findings(problem: DepthProblem, two_step: Quantity | None = None) -> Iterator[Finding]:
    """Return what speaks against k_D of a run, the gravest first; ``two_step`` is k_D where that is of two steps."""
    if not problem.measured_after:
        yield _by_sensor_alone(problem)
    elif abs(problem.deviation) > MOST_DEVIATION:
        yield _reading_not_trusted(problem, two_step)
    if problem.contradicting_stop is not None:
        yield _stop_contradicts(problem.law.title, *problem.contradicting_stop)
    if two_step is not None:
        yield from _two_step_differs(problem, two_step)
    if shape_is_rejected(problem.posterior):
        yield _misfit(problem)
    yield from _events(problem)
    if problem.end.disc is not None and problem.end.groove_by_signal:
        yield _groove_by_signal(problem.end.disc.quantity)
    if problem.by_unseen_groove:
        yield unseen_groove(problem.run, problem.by_unseen_groove, problem.recipe)


def prior_findings(problem: DepthProblem, coefficient: Quantity) -> Iterator[Finding]:
    """Note priors on which k_D of a run depends: it would move by more than its standard uncertainty by a wider one."""
    if problem.basis == "measurement":
        return
    for prior, (code, named, remedy) in _priors(problem).items():
        found = problem.coefficient_by(widened(problem.posterior, prior))
        apart = abs(found - problem.coefficient()) / (coefficient.standard_uncertainty or np.inf)
        if apart > 1:
            shown = wear_coefficient(found).shown(WEAR_COEFFICIENT)
            yield Finding(
                severity="note",
                code=code,
                where="depth",
                message=(
                    f"k_D would be {shown} under {problem.law.title}, a shift of {apart:.1f} standard uncertainties, "
                    f"if the prior for {named} were twice as wide"
                ),
                remedy=remedy,
            )


def engine_findings(problem: DepthProblem, coefficient: Quantity) -> Iterator[Finding]:
    """Report a k_D that local pressure would shift by more than its standard uncertainty.

    As a warning where the shift is far beyond the uncertainty, which includes it as a possible one, or where the shape
    of the reading is that of local pressure.
    """
    if PRESSURE not in problem.inputs:
        return
    other = problem.by_local_pressure
    local = wear_coefficient(other.coefficient())
    apart = abs(local.value - coefficient.value) / (coefficient.standard_uncertainty or np.inf)
    if apart > 1:
        favored = other.basis != "measurement" and problem.evidence_of_local_pressure > DECISIVE
        why = (
            "the shape of the depth signal agrees better with it"
            if favored
            else "the wear depth is small compared with the elastic approach"
        )
        yield Finding(
            severity="warning" if favored or apart > _FAR else "note",
            code="depends_on_engine",
            where="depth",
            message=(
                f"k_D would be {local.shown(WEAR_COEFFICIENT)} under {problem.law.title} with local contact "
                f"pressure, a shift of {apart:.1f} standard uncertainties; {why}"
            ),
            remedy="use --engine local" if favored else "run a longer test, or use --engine local",
        )


def _priors(problem: DepthProblem) -> dict[Prior, tuple[str, str, str]]:
    """Return by what code each prior of a run is reported, what it is, and how to depend less on it."""
    shares = ", ".join(f"{100 * share:g}" for share in AMPLITUDES)
    found: dict[Prior, tuple[str, str, str]] = {
        "settling": (
            "depends_on_settling_prior",
            f"settling ({shares} % of the wear)",
            "make a more accurate post-test measurement of the wear, or record the temperature",
        )
    }
    if problem.reading.drift_deviation is not None:
        drift = f"drift (0 ± {Quantity(value=problem.reading.drift_deviation, unit='m').shown('nm')} over the test)"
        remedy = "measure the scar, or state the drift of your sensor as prior under [drift] in a recipe"
        found["drift"] = ("depends_on_drift_prior", drift, remedy)
    return found


def _two_step_differs(problem: DepthProblem, two_step: Quantity) -> Iterator[Finding]:
    found = problem.coefficient()
    spread = problem.random_uncertainty(found) * found + two_step.u_or_zero
    if abs(two_step.value - found) > MOST_DEVIATION * spread:
        yield _finding(
            "two_step_differs",
            f"k_D under {problem.law.title} is {two_step.shown(WEAR_COEFFICIENT)} from the two-step correction and "
            f"{wear_coefficient(found).shown(WEAR_COEFFICIENT)} from the fit to the complete depth signal",
            'use the default correction, correction = "model"',
        )


def _events(problem: DepthProblem) -> Iterator[Finding]:
    """Name steps and spikes of the reading."""
    record = problem.record
    if record.steps:
        where = ", ".join(show(float(f"{place:.4g}"), None, "m") for place in record.steps)
        yield _finding(
            "depth_steps",
            f"found a step in the depth signal at {where}; the fit uses a new zero offset after the step",
            "check for a shock or a displaced sensor; if the specimens were removed, add [[interruptions]] with "
            "remounted = true",
        )
    if record.spikes:
        yield Finding(
            severity="note",
            code="depth_spikes",
            where="depth",
            message=f"found {counted(record.spikes, 'spike')}, excluded from the fit",
            remedy='to exclude the spikes from the figures as well, add [[clean_up]] step = "despike" to a recipe',
        )


def shape_is_rejected(posterior: DepthPosterior) -> bool:
    """Return whether a reading is more than wear by its law, a line and noise."""
    return posterior.log_odds > DECISIVE


def _by_sensor_alone(problem: DepthProblem) -> Finding:
    drift = Quantity(value=problem.recipe.drift.prior.value, unit="m").shown("nm")
    source = "depth sensor alone" if problem.end.disc is None else "depth signal minus the wear depth of the disc"
    found, remedy = "no post-test measurement of the pin", problem.contact.sliding_tip.how_to_measure
    if problem.run.manifest.end_values.pin_scar_width is not None:
        found = "only the width of the scar on the pin, which is as wide as the track, whichever of both has worn"
        remedy = "measure the length of the scar in the sliding direction and state it as end_values.pin_scar_length"
    return Finding(
        severity="warning",
        code="no_post_test_measurement",
        where="end_values",
        message=f"found {found}; k_D is based on the {source}, with an assumed drift of 0 ± {drift} over the test",
        remedy=remedy,
    )


def _groove_by_signal(depth: Quantity) -> Finding:
    """Report a groove that nobody measured, and that only the depth signal shows."""
    return Finding(
        severity="warning",
        code="disc_by_depth_signal",
        where="end_values",
        message=(
            "found no measured wear depth of the disc; the depth signal minus the wear depth of the pin, "
            f"{depth.shown('um')}, is taken as the wear depth of the disc, on which k_D of both depends"
        ),
        remedy=(
            "measure the depth of the wear track and state it as end_values.disc_wear_depth; if no track is visible, "
            "state 0 nm with its uncertainty, and check for thermal drift, wrong units, and a radius given as a "
            "diameter"
        ),
    )


def unseen_groove(run: RawRun, relative: float, recipe: Recipe) -> Finding:
    """Report a scar or a depth reading of a pin on a counterbody whose groove nobody measured.

    It is a warning where the bodies differ: in a softer one the groove may be many times as deep as the pin is worn.
    It widens the scar and deepens the reading alike, so that neither contradicts the other.
    """
    _, track = worn_bodies(run, recipe.uncertainty).bodies.values()
    for way in track:
        lost = way.volume
        if way.hides_groove and lost is not None and lost.value > _WORN * lost.u_or_zero:
            return _track_length_unknown(way.name, lost, relative, recipe)
    contact = run.manifest.described
    alike = contact.sliding_tip.material == contact.counterbody.material
    beyond = "" if alike else "; the groove can be much deeper if the disc is softer than the pin"
    return Finding(
        severity="note" if alike else "warning",
        code="disc_not_measured",
        where="end_values",
        message=(
            "found no measured wear depth of the disc; the uncertainty of k_D includes "
            f"{100 * relative:.2g} % for an unmeasured groove whose depth is "
            f"{100 * recipe.uncertainty.unseen_groove:.0f} % of the wear depth of the pin{beyond}"
        ),
        remedy=(
            "measure the depth of the wear track and state it as end_values.disc_wear_depth; if no track is visible, "
            "state 0 nm with its uncertainty"
        ),
    )


def _track_length_unknown(name: str, lost: Quantity, relative: float, recipe: Recipe) -> Finding:
    """Report a disc whose lost volume gives no depth of its groove."""
    return Finding(
        severity="warning",
        code="track_length_unknown",
        where="conditions.track_radius",
        message=(
            f"found a wear volume of the disc, {lost.shown('mm^3')} from {name}, without the length of the wear track, "
            "so the depth of the groove is unknown; k_D of the pin is calculated for an unworn disc, and its "
            f"uncertainty includes {100 * relative:.2g} % for a groove whose depth is "
            f"{100 * recipe.uncertainty.unseen_groove:.0f} % of the wear depth of the pin; the groove can "
            "be much deeper"
        ),
        remedy='add track_radius, such as "6 mm", or stroke for a reciprocating pin',
    )


def _reading_not_trusted(problem: DepthProblem, two_step: Quantity | None) -> Finding:
    ways = {name: wear_coefficient(*found) for name, found in problem.coefficients_by_ways().items()}
    reading, measured = (ways[name].shown(WEAR_COEFFICIENT) for name in ("reading", "measurement"))
    return Finding(
        severity="warning",
        code="reading_contradicts_measurement",
        where="depth",
        message=(
            f"under {problem.law.title}, k_D is {reading} from the depth signal alone and {measured} from the "
            f"post-test measurement alone, {abs(problem.deviation):.1f} standard uncertainties apart: "
            f"{_consequence(two_step)}"
        ),
        remedy="check for thermal drift, wear of the counterbody, wrong units, and a radius given as a diameter",
    )


def _stop_contradicts(law: str, place: float, deviation: float) -> Finding:
    return _finding(
        "wear_rate_changes",
        f"under {law}, the pin wear measured after {show(float(f'{place:.4g}'), None, 'm')} is {abs(deviation):.1f} "
        f"standard uncertainties {'larger' if deviation > 0 else 'smaller'} than expected from the measurement at the "
        "end; k_D is based on the measurement at the end and is the mean over the test",
        "check both measurements; if they are correct, split the test at this distance, or fit a law with running-in",
    )


def _consequence(two_step: Quantity | None) -> str:
    if two_step is None:
        return "the depth signal is not used, and k_D is based on the measurement"
    return "the two-step correction attributes the difference to drift"


_MEASURE = (
    "measure the scar or the mass loss: creep and thermal expansion need not be exponential, and k_D from the depth "
    "signal alone may be wrong by more than its uncertainty"
)


def _misfit(problem: DepthProblem) -> Finding:
    posterior, law = problem.posterior, problem.law.title
    change = rate_change(problem)
    if change is not None:
        return _rate_changes(problem, change)
    size = _size(problem)
    settles = posterior.settling_probability > _PROBABLE
    if posterior.thermal_probability > _PROBABLE:
        follows = "changes with temperature and settles" if settles else "changes with temperature"
        return _finding(
            "reading_follows_temperature",
            f"in addition to wear, the depth signal {follows} by {size} ({law}); the fit accounts for this",
            "keep the room temperature constant, or let the rig warm up before the test",
        )
    if settles:
        return _finding(
            "reading_settles",
            f"in addition to wear, the depth signal settles exponentially by {size} ({law}); the fit accounts for this",
            "let the rig warm up before the test, or record the temperature" if problem.measured_after else _MEASURE,
        )
    reliable = (
        "the post-test measurement is the more reliable one"
        if problem.measured_after
        else "measure the scar, since k_D from the depth signal alone may be wrong by more than its uncertainty"
    )
    return _finding(
        "curve_shape",
        f"neither {law} nor linear drift explains {size} of the depth signal",
        f"check for thermal drift, running-in, and wear of the counterbody; {reliable}",
    )


def _rate_changes(problem: DepthProblem, change: RateChange) -> Finding:
    where = show(float(f"{change.distance:.2g}"), None, "m")
    if change.ratio < _STOPPED:
        return _finding(
            "wear_rate_changes",
            f"under {problem.law.title}, wear stops after about {where}; k_D is too small if sliding stopped there",
            "check whether the motor stopped or the contact was lost, and delete the rows after this distance if so; "
            "otherwise, check whether the sensor reached the end of its range",
        )
    changes = f"under {problem.law.title}, k_D after about {where} is {change.ratio:.3g} times the earlier value"
    if problem.measured_after:
        mean, remedy = "the reported k_D is the mean over the test", "split the test at this distance"
    else:
        mean = "the reported k_D, from the depth signal alone, is not the mean over the test"
        remedy = "measure the scar, from which the mean follows"
    return _finding("wear_rate_changes", f"{changes}; {mean}", f"{remedy}, or fit a law with running-in")


def _size(problem: DepthProblem) -> str:
    return show(float(f"{problem.posterior.range_beyond_line:.2g}"), None, "m", "um")


def _finding(code: str, message: str, remedy: str) -> Finding:
    return Finding(severity="warning", code=code, where="depth", message=message, remedy=remedy)
