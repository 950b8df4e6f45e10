"""What the model of a depth reading found, as a record."""

import numpy as np

from tribopipe.documents.quantity import Quantity
from tribopipe.physics.depth_model.posterior import DepthPosterior
from tribopipe.physics.depth_model.terms import SETTLING_TIMES
from tribopipe.results.evaluation import DepthModel

_PROBABLE = 0.5
_COVERAGE = np.array([0.025, 0.975])
"""Cumulative probabilities of the ends of a 95 % interval."""


def depth_model(posterior: DepthPosterior, duration: float, scale: Quantity) -> DepthModel:
    """Return what a posterior states about everything but wear.

    Parameters
    ----------
    posterior
        Of the reading by the best estimate of the sensor's scale.
    duration
        Sliding time, s.
    scale
        Scale of the sensor, whose uncertainty the posterior knows nothing of: it is in that of offset, drift and
        settling, since where the end of the wear is known, they take what the reading is too large or too small by.
    """
    reading, (mean, statistical) = posterior.reading, posterior.terms
    by_scale = (scale.standard_uncertainty or 0.0) / scale.value * np.abs(posterior.terms_per_scale)
    deviation = np.hypot(statistical, by_scale)
    offsets = reading.offsets.shape[1]
    line = offsets + (0 if reading.free is None else reading.free.shape[1])
    first = line + 1 + len(reading.known)
    constants = reading.optional.time_constants
    amplitudes = mean[first:]
    settles = np.array([constant is not None for constant in constants])
    probability = posterior.settling_probability
    low, high = posterior.term_quantiles(line, _COVERAGE, float(by_scale[line])) / duration
    return DepthModel(
        zero_offsets=tuple(_metres(mean[place], deviation[place]) for place in range(offsets)),
        drift_rate=Quantity(
            value=float(mean[line] / duration), unit="m/s", standard_uncertainty=float(deviation[line] / duration)
        ),
        drift_interval=(Quantity(value=float(low), unit="m/s"), Quantity(value=float(high), unit="m/s")),
        settling_probability=probability,
        settling=_metres(float(np.sum(amplitudes[settles])), float(np.sqrt(np.sum(deviation[first:][settles] ** 2)))),
        settling_time=_settling_time(posterior, duration) if probability > _PROBABLE else None,
        thermal_probability=None if np.all(settles) else posterior.thermal_probability,
        thermal_shift=None if np.all(settles) else _metres(amplitudes[~settles][0], deviation[first:][~settles][0]),
        wander=_metres(float(np.sqrt(np.average(posterior.wander**2, weights=reading.samples)))),
        noise=_metres(posterior.noise),
        blocks=len(reading.time),
        end_depth=_metres(*posterior.together),
        end_depth_by_reading=_metres(*posterior.alone),
        evidence=float(np.clip(posterior.log_odds, -99.0, 99.0)),
    )


def _settling_time(posterior: DepthPosterior, duration: float) -> Quantity:
    alternatives = posterior.reading.optional.alternatives
    settling = [-1 if one.column is None else one.column for one in alternatives]
    place = np.array(settling)[posterior.ways.alternative]
    constants = np.array(SETTLING_TIMES)
    times, weights = constants[place[place >= 0]], posterior.weights[place >= 0]
    mean = float(np.average(times, weights=weights))
    spread = float(np.sqrt(np.average((times - mean) ** 2, weights=weights)))
    return Quantity(value=mean * duration, unit="s", standard_uncertainty=spread * duration)


def _metres(value: float, spread: float | None = None) -> Quantity:
    return Quantity(value=float(value), unit="m", standard_uncertainty=None if spread is None else float(spread))
