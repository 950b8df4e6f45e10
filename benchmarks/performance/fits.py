"""(c) The fits of friction and of k_D beside one `scipy.optimize.curve_fit` of the same curve to the same samples.

Ours of friction tells the loading ramp, the running-in, a constant and a straight line apart, and counts independent
samples. Ours of k_D is posed anew from the corrected run: zero offset, end reading and noise of the sensor, then least
squares on all samples and the first-order budget of all inputs. `fit_wear` adds the model of the whole depth reading,
under one law or both; the Monte Carlo is case (d) and is left out here. `curve_fit` starts at what is typical.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from case import Growth, Pair, Row, Setting, Work
from labs import SAMPLES
from scipy.optimize import curve_fit

from tribopipe.base.arrays import Column
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.friction import fit_friction
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.evaluation.wear.problem import WearProblem, wear_problem
from tribopipe.evaluation.wear.uncertainty import budget
from tribopipe.extras.simulate import VirtualTest
from tribopipe.extras.sweep.virtual_tests import recorded_run
from tribopipe.physics.pin_on_disc import PinContact
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import CorrectedRun

SAMPLE = "si3n4-air-200mN"
SAMPLES_A_RUN = 12_500
TYPICAL = 1e-15
"""m²/N, 1e-9 mm³/(N mm): amid what is found of dry ceramics and metals, for a search to start from."""
_LONGEST = 1_250_000
_FRICTION, _WEAR = "friction fit", "k_D fit with uncertainty budget"
_WHOLE, _BOTH = "k_D fit to the complete depth signal", "k_D fit to the complete depth signal, with both laws"
NO_DRAWS = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))


def rows(setting: Setting) -> Iterator[Row]:
    """Yield both fits and their growth."""
    run = TestRun(SAMPLES_A_RUN)
    peer = "curve_fit with Eq. 7 of the paper"
    yield Pair(_FRICTION, run.friction, run.friction_by_scipy, peer, at_most=3, clock=time.process_time)
    peer = "curve_fit with the exact wear curve"
    yield Pair(_WEAR, run.wear, run.wear_by_scipy, peer, at_most=2, clock=time.process_time)
    yield Pair(_WHOLE, run.whole_wear, run.wear_by_scipy, peer, clock=time.process_time)
    yield Pair(_BOTH, run.both_laws, run.wear_by_scipy, peer, clock=time.process_time)
    sizes = setting.decades(_LONGEST, small=SAMPLES_A_RUN * 2)
    for what, fit in ((_FRICTION, friction_of), (_WHOLE, wear_of)):
        yield Growth(what, sizes, fit, at_most=1.1, clock=time.process_time)


def friction_of(samples: int) -> Work:
    """Return the friction fit of so many samples."""
    return TestRun(samples).friction


def wear_of(samples: int) -> Work:
    """Return the fit of k_D to so many samples."""
    return TestRun(samples).whole_wear


@dataclass(frozen=True)
class TestRun:
    """A sample run recorded at another rate."""

    samples: int

    @cached_property
    def corrected(self) -> CorrectedRun:
        """The run, corrected for drift."""
        series, run = SAMPLES[SAMPLE]
        duration = series.sliding_distance.value / series.sliding_speed.value
        rate = Quantity(value=self.samples / duration, unit="Hz")
        series = series.model_copy(update={"sensors": series.sensors.model_copy(update={"sampling_rate": rate})})
        return correct_drift(recorded_run(series, VirtualTest(series, run)))

    @property
    def problem(self) -> WearProblem:
        """The fit of k_D, posed anew."""
        problem = wear_problem(self.corrected, "archard", None, NO_DRAWS)
        if not isinstance(problem, WearProblem):
            raise TypeError(problem)
        return problem

    def friction(self) -> object:
        """Fit Eq. 7."""
        return fit_friction(self.corrected.run)

    def friction_by_scipy(self) -> object:
        """Fit Eq. 7 as a user would by hand."""
        run = self.corrected.run
        return curve_fit(_decay, run.sliding_distance, run.columns["friction_coefficient"], (0.1, 0.5, 10.0))

    def wear(self) -> object:
        """Fit k_D, and tell what its uncertainty is made of."""
        problem = self.problem
        return budget(problem.condensed(), problem.coefficient())

    def whole_wear(self) -> object:
        """Fit k_D by the whole reading."""
        return fit_wear(self.corrected, "archard", None, NO_DRAWS)

    def both_laws(self) -> object:
        """Fit k_D by the whole reading under either law."""
        return [fit_wear(self.corrected, law, self._friction, NO_DRAWS) for law in ("archard", "sarkar")]

    def wear_by_scipy(self) -> object:
        """Fit k_D as a user would who has the curve and the corrected wear."""
        pin, unit, measured = self._given
        return curve_fit(lambda volume, k: pin.worn(k * volume).depth, unit, measured, (TYPICAL,))

    @cached_property
    def _friction(self) -> FrictionFit:
        return fit_friction(self.corrected.run)

    @cached_property
    def _given(self) -> tuple[PinContact, Column, Column]:
        problem = self.problem
        values = problem.values
        return problem.pin(values), problem.unit_volume(values), problem.pin_wear(values)


def _decay(distance: Column, amplitude: float, steady: float, running_in: float) -> Column:
    return np.asarray(amplitude * np.exp(-distance / running_in) + steady)
