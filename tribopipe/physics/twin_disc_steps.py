"""The paper's explicit steps for two discs, as printed (Fig. 8, Eq. 10–13; Fig. A, Eq. 14–16), a rotation at a time.

It starts from Hertz's ellipse, with p₀ = F_N/(π·a_x·a_z) and u₀ by Eq. 10. Each step first lets both discs recede by
k·p times the distance they slide (tribopipe.physics.twin_disc has the ways of counting that), and then takes

    a_x = √(2r₁ₓ·h − h²) with h = h₁ + h₂ + u,   r₁ = r₁z − h₁,   r₂ = r₂z − h₂,   a_z and p by Eq. 15 and 16

and the speeds v = 2πnr of radii so changed. Wear on one disc only is k₂ = 0. What the paper leaves open: u is renewed
by Eq. 10 in every step, with a_x and a_z of that step, and enters the next one.
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.errors import ContactError
from tribopipe.physics.conventions import DistanceConvention
from tribopipe.physics.hertz_ellipse import hertz_ellipse
from tribopipe.physics.twin_disc import DiscPair, DiscWear


def published_wear(
    discs: DiscPair, rotation_steps: ArrayLike, curved_coefficient: float, flat_coefficient: float = 0.0
) -> DiscWear:
    """Return the discs before the first and after each step, for numbers of rotations a step and k₁, k₂ in m²/N.

    Arguments of ``discs`` must be single numbers. Raises ``ContactError`` where a step wears the crown past its radius.
    """
    steps = np.asarray(rotation_steps, dtype=float).tolist()
    states = np.array(list(_states(discs, steps, curved_coefficient, flat_coefficient)))
    return DiscWear(*states.T)


def _states(
    discs: DiscPair, steps: list[float], curved_coefficient: float, flat_coefficient: float
) -> Iterator[tuple[float, ...]]:
    """Yield the fields of ``DiscWear`` in their order."""
    load, crown, curved, flat, modulus, _ = (float(value.item()) for value in discs.inputs)
    ratio = float(discs.rotation_ratio.item())
    start = hertz_ellipse(normal_load=load, radius_x=crown, radius_z=curved * flat / (curved + flat), modulus=modulus)
    a_x, a_z, p = start.half_width, start.half_length, start.mean_pressure
    r_1, r_2 = curved, flat
    h_1 = h_2 = volume_1 = volume_2 = slid = 0.0
    for turns in (*steps, 0.0):
        u = load / (2 * modulus * math.sqrt(a_x * a_z))
        slip = 2 * math.pi * (ratio * r_2 - r_1)
        rate_1, rate_2 = _work(discs.distance, load, a_x, a_z, p, slip, r_1, r_2, ratio)
        rate_1, rate_2 = curved_coefficient * rate_1, flat_coefficient * rate_2
        yield (h_1, h_2, volume_1, volume_2, a_x, a_z, p, slip / (2 * math.pi * r_1), slid, rate_1, rate_2)
        h_1, h_2 = h_1 + rate_1 * turns, h_2 + rate_2 * turns
        volume_1 += 4 * math.pi * r_1 * a_x * rate_1 * turns
        volume_2 += 4 * math.pi * r_2 * a_x * rate_2 * turns
        slid += abs(slip) * turns
        total = h_1 + h_2 + u
        if total >= min(crown, curved, flat):
            raise ContactError(
                "published scheme: found a step that wears the crown or a disc away; expected small steps; use more of "
                "them with --steps, or use the exact scheme"
            )
        a_x = math.sqrt(2 * crown * total - total * total)
        r_1, r_2 = curved - h_1, flat - h_2
        line_load, equivalent = load / (2 * a_x), r_1 * r_2 / (r_1 + r_2)
        a_z = discs.kappa * math.sqrt(4 * line_load * equivalent / (math.pi * modulus))
        p = math.pi / 4 * math.sqrt(line_load * modulus / (math.pi * equivalent))


def _work(
    distance: DistanceConvention,
    load: float,
    a_x: float,
    a_z: float,
    p: float,
    slip: float,
    r_1: float,
    r_2: float,
    ratio: float,
) -> tuple[float, float]:
    """Return pressure times the sliding distance in one rotation of the crowned disc, for both discs, N/m."""
    if distance == "volume-conserving":
        through = load / (2 * a_x) * abs(slip) / (2 * math.pi)
        return through / r_1, through / r_2
    per_turn = 2 * a_z * (slip != 0) if distance in ("contact-width", "line-load") else abs(slip)
    return p * per_turn, p * per_turn * ratio
