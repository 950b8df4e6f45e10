"""What a reading would show were one of its priors wider, from the posterior itself: nothing is fitted again.

Where the prior of a coefficient a is N(0, σ²) and is to be N(0, (c·σ)²), each way is multiplied by the ratio of both,

exp(−½·d·a²)/c, d = (c⁻² − 1)/σ²,

which leaves it a Gaussian: of precision larger by d, and of evidence larger by the mean of that ratio.
"""

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column
from tribopipe.physics.depth_model.posterior import DepthPosterior

Prior = Literal["drift", "settling"]
"""Of the drift over the test where the sensor alone gives the wear, and of the amplitude of a settling."""


def widened(posterior: DepthPosterior, prior: Prior, factor: float = 2.0) -> DepthPosterior:
    """Return a posterior as it would be were a prior a factor wider.

    Parameters
    ----------
    posterior
        Of a reading.
    prior
        Which prior; where the reading has none of the kind, the posterior comes back as it is.
    factor
        By which its standard deviation is larger.

    Returns
    -------
    DepthPosterior
        Exact, but for ways that were too improbable to be kept.
    """
    ways, anchor = posterior.ways, posterior.anchor
    places, deviations = _drift(posterior) if prior == "drift" else _settling(posterior)
    every = np.arange(len(places))
    change = (factor**-2.0 - 1) / deviations**2
    mean, column = ways.mean[every, places], ways.covariance[every, :, places]
    left = 1 + change * column[every, places]
    means = ways.mean - column * (change * mean / left)[:, None]
    covariances = ways.covariance - column[:, :, None] * column[:, None, :] * (change / left)[:, None, None]
    log_ratio = -0.5 * (np.log(left) + change * mean**2 / left)
    log_ratio[np.isfinite(deviations)] -= np.log(factor)
    alone = ways.log_evidence + log_ratio
    anchored = alone if anchor is None else alone + anchor.log_evidence(means[:, 0], covariances[:, 0, 0])
    return replace(
        posterior,
        ways=replace(ways, log_evidence=alone, log_anchored=anchored, mean=means, covariance=covariances),
    )


def _drift(posterior: DepthPosterior) -> tuple[NDArray[np.intp], Column]:
    """Return for each way which coefficient is the drift, and its prior standard deviation, infinite where flat."""
    reading, count = posterior.reading, len(posterior.ways.noise)
    free = 0 if reading.free is None else reading.free.shape[1]
    deviation = np.inf if reading.drift_deviation is None else reading.drift_deviation
    return np.full(count, 1 + reading.offsets.shape[1] + free), np.full(count, deviation)


def _settling(posterior: DepthPosterior) -> tuple[NDArray[np.intp], Column]:
    """Return the same of the amplitude of the settling, infinite where a way has none."""
    reading, ways = posterior.reading, posterior.ways
    deviations = [
        np.inf if one.column is None else one.deviation * reading.scale for one in reading.optional.alternatives
    ]
    return np.full(len(ways.noise), ways.mean.shape[1] - 1), np.array(deviations)[ways.alternative]
