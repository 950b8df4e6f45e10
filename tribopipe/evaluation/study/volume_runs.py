"""Runs of a study without a depth signal: volumes that a pin and its counterbody have lost, held against a law.

Each body loses V = k_D·F_N·S, whatever its shape, so that k_D of a run is in proportion to the volume. The law is held
against the volume of each body at the end. What all volumes depend on, such as the density or the radius of the tip, is
off by the same in all runs.
"""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.random import Generator

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.contacts.kinds import Terms, wear_of
from tribopipe.documents.contact import Contact
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.recipe import LawName, Recipe
from tribopipe.evaluation.load_and_friction import applied_load
from tribopipe.evaluation.measurements.body_wear import BodyWear, surest
from tribopipe.evaluation.measurements.kinds import worn_bodies
from tribopipe.evaluation.measurements.readings import SignalDepths
from tribopipe.evaluation.measurements.specific_wear import with_exact_dimensions, without_unseen_groove
from tribopipe.evaluation.study.member import BodyDraws, Member
from tribopipe.evaluation.study.verdict import (
    CURVE_DRAWS,
    CURVE_PLACES,
    DECISIVE,
    Comparison,
    Judgment,
    KnownCoefficient,
    Question,
    body_verdict,
    decide,
    end_of_life,
    volume_curve,
)
from tribopipe.evaluation.wear.inputs import PIN_SHARED, draw_values
from tribopipe.evaluation.wear.measurement_fit import VolumeFit, scale_of, unseen_groove_of, volume_fit, volume_of
from tribopipe.evaluation.wear.problem import depths_by_signal
from tribopipe.physics.calculation_methods import WearEngine
from tribopipe.results.input_quantities import Input, Inputs, Source
from tribopipe.results.run import RawRun
from tribopipe.results.study import BodyVerdict, EndOfLife, StudyCurve
from tribopipe.results.wear_fit import Contribution

_RELATIVE = ("_wear_volume", "_track_area", "_profile", "_profile_difference")
"""Ends of the names of measurements that are as uncertain relative to themselves in a longer test."""
_NOT_PLACED = "track_radius or stroke is missing, so the distance to the wear depth is not calculated"


@dataclass(frozen=True)
class VolumeRun:
    """A run and a law."""

    member: Member
    problem: VolumeFit
    gains: Mapping[str, float]
    """By which power of its volume the relative uncertainty of each body's measurement decreases."""

    engine: ClassVar[WearEngine] = "volume"

    def is_placed(self, bodies: Collection[str]) -> bool:
        """Return whether depths follow from volumes: with a groove, they need the length of the track."""
        known = self.member.corrected.run.manifest.path is not None
        return known or all(body in self.contact.fitted_bodies for body in bodies)

    @property
    def bodies(self) -> tuple[str, ...]:
        """The bodies whose k_D is found."""
        return self.problem.bodies

    @property
    def by_volume(self) -> Collection[str]:
        """Those whose k_D is found by a volume."""
        return self.bodies

    @property
    def inputs(self) -> Inputs:
        """Everything uncertain that k_D depends on."""
        return self.problem.inputs

    @property
    def contact(self) -> Contact:
        """The contact as run.toml describes it."""
        return self.member.corrected.run.manifest.described

    @property
    def end(self) -> Quantity:
        """Sliding distance at the end of the test."""
        return Quantity(value=self.problem.slid, unit="m")

    @property
    def coefficients(self) -> Column:
        """k_D of each body by this run alone, m²/N; below zero for one that has gained."""
        return self.problem.coefficients(self.problem.values)

    @property
    def scale(self) -> Column:
        """k_D that the budget of each body is relative to, m²/N: without wear, what would have been noticed."""
        return self.problem.scale

    def of(self, bodies: Sequence[str]) -> "VolumeRun | None":
        """Return the run as some bodies have it; None if none of them was measured."""
        some = self.problem.of(*bodies)
        return None if some is None else replace(self, problem=some)

    def may_share(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return which inputs may be off by the same in several runs."""
        grooves = (name for name in map(unseen_groove_of, self.bodies) if name in self.inputs)
        return (*(name for name in names if name in PIN_SHARED), *map(scale_of, self.bodies), *grooves)

    def budgets(self, length: float | None = None) -> list[tuple[Contribution, ...]]:
        """Return what u of each k_D is made of, for a test ``length`` times as long where that is named."""
        inputs = dict(self.problem.inputs)
        for body in self.bodies:
            given = inputs[volume_of(body)]
            spread = given.spread * (length or 1.0) ** -self.gains[body]
            quantity = given.quantity.model_copy(update={"standard_uncertainty": spread})
            inputs[volume_of(body)] = replace(given, quantity=quantity)
        return replace(self.problem, inputs=inputs).budgets()

    def draw(
        self, rng: Generator, count: int, shared: Mapping[str, Column], drawn: Mapping[str, Column] | None = None
    ) -> "VolumeDraws":
        """Draw everything uncertain of this run; ``shared`` inputs are taken over from other runs of the study.

        Inputs that are ``drawn`` are as they are.
        """
        problem, drawn = self.problem, drawn or {}
        values = draw_values(problem.inputs, problem.friction_covariance, rng, count, shared)
        values |= {name: drawn[name] for name in values.keys() & drawn.keys()}
        return VolumeDraws(self, values, problem.coefficients(values))


class VolumeDraws(BodyDraws[VolumeRun]):
    """What is drawn of a run, volumes among the values."""


def posed_volumes(member: Member, law: LawName, recipe: Recipe) -> VolumeRun | None:
    """Pose the fit of a law to the volumes of a run; None if no volume is known.

    Raises ``FitError`` where the run is missing something that the law needs.
    """
    signal, friction = depths_by_signal(member.corrected, recipe), member.friction
    run = _with_pin_by_signal(member.corrected.run, signal)
    fit = volume_fit(run, law, friction, recipe, signal)
    if fit is None:
        return None
    own = recipe.model_copy(update={"uncertainty": without_unseen_groove(recipe.uncertainty)})
    seen, exact = (volume_fit(one, law, friction, own, signal) for one in (run, with_exact_dimensions(run)))
    if not (isinstance(fit, VolumeFit) and isinstance(seen, VolumeFit) and isinstance(exact, VolumeFit)):
        lacking = fit if isinstance(fit, tuple) else ("a wear volume",)
        raise FitError(
            f"{member.id}: found a run without {' and '.join(lacking)}; expected these data, which the wear law "
            "requires; remove the run from the study"
        )
    inputs = dict(fit.inputs)
    for body in fit.bodies:
        inputs |= _parted(
            body, fit.inputs[volume_of(body)], *(one.inputs.get(volume_of(body)) for one in (seen, exact))
        )
    return VolumeRun(member, replace(fit, inputs=inputs), _gains(run, signal, recipe))


def _parted(body: str, whole: Input, seen: Input | None, own: Input | None) -> dict[str, Input]:
    """Part the uncertainty of a volume into that of its own measurement and the relative ones of what all share.

    ``seen`` is the volume next to a groove that was measured, ``own`` one of exactly known dimensions as well.
    """
    value = whole.quantity.value
    if seen is None or own is None or not value or {seen.quantity.value, own.quantity.value} != {value}:
        return {}
    parts = {unseen_groove_of(body): _beyond(whole, seen, "default"), scale_of(body): _beyond(seen, own, "manifest")}
    shared = {name: part for name, part in parts.items() if part.spread}
    quantity = whole.quantity.model_copy(update={"standard_uncertainty": own.spread})
    return {volume_of(body): replace(whole, quantity=quantity), **shared} if shared else {}


def _beyond(whole: Input, part: Input, source: Source) -> Input:
    """Return a factor that makes a part of the uncertainty of a volume the whole."""
    relative = math.sqrt(max(0.0, whole.spread**2 - part.spread**2)) / abs(whole.quantity.value)
    return Input(Quantity(value=1.0, unit="1", standard_uncertainty=relative), source)


def _with_pin_by_signal(run: RawRun, signal: SignalDepths) -> RawRun:
    """Return a run whose pin counts as measured where the depth signal clearly shows its wear next to a groove."""
    if signal.pin is None or not signal.pin_is_certain:
        return run
    depth = EndValue.model_validate(signal.pin.model_dump(exclude_none=True))
    ends = run.manifest.end_values.model_copy(update={"pin_wear_depth": depth})
    return replace(run, manifest=run.manifest.model_copy(update={"end_values": ends}))


def _gains(run: RawRun, signal: SignalDepths, recipe: Recipe) -> dict[str, float]:
    """Return for each body by which power of the volume its relative uncertainty decreases in a longer test.

    A reading x, as uncertain as it is, of V ∝ xⁿ is so by 1/n: u(V)/V = n·u(x)/x. A volume that was measured as such
    is always as uncertain relative to itself.
    """
    worn = worn_bodies(run, without_unseen_groove(recipe.uncertainty), signal=signal).bodies
    best = {run.manifest.described.body_name(role): surest(ways, "volume") for role, ways in worn.items()}
    return {body: 0.0 if way is None else _gain(way) for body, way in best.items()}


def _gain(way: BodyWear) -> float:
    if way.pair is None or way.volume is None or way.name.endswith(_RELATIVE):
        return 0.0
    reading = next(one.quantity for one in (way.pair.pin, way.pair.disc) if one.name == way.name)
    of_reading, of_volume = (
        abs(one.u_or_zero * rest.value) for one, rest in ((reading, way.volume), (way.volume, reading))
    )
    return min(1.0, of_reading / of_volume) if of_volume else 0.0


def judge_volumes(draws: VolumeDraws, asked: Question) -> Judgment:
    """Hold a law against the volume that each body whose k_D the study found has lost."""
    wanted, placed = asked.study.end_of_life, draws.run.is_placed(asked.bodies)
    return Judgment(
        bodies={body: _body(place, draws, asked) for place, body in enumerate(draws.run.bodies)},
        curves=tuple(_curve(body, draws, asked) for body in draws.run.bodies),
        end_of_life=_life(draws, asked, wanted.value) if wanted is not None and placed else None,
        notes=() if wanted is None or placed else (_NOT_PLACED,),
    )


def _body(place: int, draws: VolumeDraws, asked: Question) -> BodyVerdict:
    run, problem = draws.run, draws.run.problem
    body, end = run.bodies[place], np.asarray([problem.slid])
    best, drawn = asked.of(body)
    work = problem.work(body, problem.values, end)
    comparison = Comparison(
        np.atleast_1d(problem.volume(body, problem.values)),
        best * work,
        np.asarray(problem.volume(body, draws.values)),
        drawn[:, None] * problem.work(body, draws.values, end),
    )
    outcome = decide(comparison, lambda factor: factor * best * work, DECISIVE / len(asked.bodies))
    own = KnownCoefficient(float(run.coefficients[place]), draws.coefficients[:, place], best, drawn)
    return body_verdict(comparison, outcome, "wear_volume", [run.end], own)


def _curve(body: str, draws: VolumeDraws, asked: Question) -> StudyCurve:
    """Return the volume of a body that the law gives along a run."""
    run, problem = draws.run, draws.run.problem
    best, drawn = asked.of(body)
    places = np.linspace(0.0, problem.slid, CURVE_PLACES)
    some = {name: column[:CURVE_DRAWS] for name, column in draws.values.items()}
    line = best * problem.work(body, problem.values, places)
    band = drawn[:CURVE_DRAWS, None] * problem.work(body, some, places)
    return volume_curve(run.member.id, body, asked, run.contact.progress.signal, places, line, band)


def _life(draws: VolumeDraws, asked: Question, depth: float) -> EndOfLife | None:
    """Return where the first body reaches a depth, m, by the shape that the volumes of both give them."""
    run, problem = draws.run.member.corrected.run, draws.run.problem
    wear = wear_of(draws.run.contact, Terms(engine="volume", path=run.manifest.path, worn=asked.bodies))
    rng = np.random.Generator(np.random.PCG64(asked.recipe.monte_carlo.seed))
    shape = draw_values(wear.inputs(applied_load(run, asked.recipe), asked.recipe), None, rng, len(asked.coefficients))
    none = np.zeros((len(asked.coefficients), 1))
    drawn = {body: np.maximum(asked.of(body)[1][:, None], 0.0) for body in asked.bodies}
    known = {name: drawn.get(body, none) for name, body in zip(wear.coefficients, wear.bodies, strict=True)}
    wanted = wear.progress_to({**shape, **draws.values, **known}, depth)
    wanted = np.where(drawn[asked.bodies[0]] > 0, wanted, np.inf)
    return end_of_life(depth, wanted, lambda reached: problem.effective(draws.values, reached), "m")
