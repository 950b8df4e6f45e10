"""Identities between the quantities of a test, by which channels and stated values can be held against each other.

    F_f/F_N = μ    m·g = F_N    2πR·n = v    2πR·N = s    2πR·∫n dt = s    ds/dt = v    dN/dt = n

N counts rotations, n is their rate. Quantities that grow, t, s and N, enter by their increments, so that it does not
matter where they start, and steps at which one of them falls are passed over.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from tribopipe.base.arrays import Column, Numbers

Role = Literal[
    "time",
    "sliding_distance",
    "sliding_speed",
    "track_radius",
    "rotational_speed",
    "rotations",
    "mass",
    "normal_force",
    "friction_force",
    "friction_coefficient",
]
"""Kinds of quantities; all in SI, so that the rotational speed is in rad/s."""
_GROWING: tuple[Role, ...] = ("time", "sliding_distance", "rotations")
_STANDARD_GRAVITY = 9.80665
_ON = 0.2
"""Share of the usual value above which a load, a speed or a friction coefficient is on."""


@dataclass(frozen=True)
class Identity:
    """Identity: the product on the left, times the factor, equals the product on the right."""

    formula: str
    left: tuple[Role, ...]
    right: tuple[Role, ...]
    factor: float = 1.0

    @property
    def roles(self) -> tuple[Role, ...]:
        """All quantities of it."""
        return (*self.left, *self.right)


IDENTITIES = (
    Identity("F_f/F_N = μ", ("friction_force",), ("normal_force", "friction_coefficient")),
    Identity("m·g = F_N", ("mass",), ("normal_force",), _STANDARD_GRAVITY),
    Identity("2πR·n = v", ("track_radius", "rotational_speed"), ("sliding_speed",)),
    Identity("2πR·N = s", ("track_radius", "rotations"), ("sliding_distance",), math.tau),
    Identity("2πR·∫n dt = s", ("track_radius", "rotational_speed", "time"), ("sliding_distance",)),
    Identity("ds/dt = v", ("sliding_distance",), ("sliding_speed", "time")),
    Identity("dN/dt = n", ("rotations",), ("rotational_speed", "time"), math.tau),
)


def ratios(values: Mapping[Role, Numbers]) -> Iterator[tuple[Identity, float]]:
    """Return the left side over the right side of each identity whose quantities are all there, 1 where it holds.

    Parameters
    ----------
    values
        Columns of one length, or single numbers, by what they are; of any units, which the ratio then carries.
    """
    for identity in IDENTITIES:
        if all(role in values for role in identity.roles):
            ratio = _ratio(identity, {role: values[role] for role in identity.roles})
            if ratio is not None:
                yield identity, ratio


def _ratio(identity: Identity, values: Mapping[Role, Numbers]) -> float | None:
    grows = any(role in _GROWING for role in identity.roles)
    parts = {role: _increments(role, each) if grows else np.abs(each) for role, each in values.items()}
    left = identity.factor * _product(parts, identity.left)
    right = _product(parts, identity.right)
    known = np.isfinite(left) & np.isfinite(right)
    sound = np.atleast_1d(
        np.logical_and.reduce([known, *(np.broadcast_to(_sound(*each), known.shape) for each in parts.items())])
    )
    left, right = np.broadcast_to(left, sound.shape)[sound], np.broadcast_to(right, sound.shape)[sound]
    if not len(right) or not np.any(right > 0):
        return None
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ratio = float(np.sum(left) / np.sum(right) if grows else np.median(left / right))
    return ratio if math.isfinite(ratio) else None


def _product(parts: Mapping[Role, Numbers], roles: tuple[Role, ...]) -> Column:
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray(math.prod(parts[role] for role in roles), dtype=float)


def _increments(role: Role, values: Numbers) -> Numbers:
    """Return steps of what grows, and the mean size of anything else over each step."""
    if not isinstance(values, np.ndarray):
        return abs(float(values))
    return np.diff(values) if role in _GROWING else (np.abs(values[1:]) + np.abs(values[:-1])) / 2


def _sound(role: Role, part: Numbers) -> NDArray[np.bool_]:
    """Report where what grows does not fall, and everything else is on."""
    values = np.asarray(part)
    if role in _GROWING or role in ("track_radius", "mass"):
        return np.asarray(values >= 0, dtype=bool)
    if role in ("sliding_speed", "rotational_speed"):
        return np.asarray(np.isfinite(values), dtype=bool)
    usual = float(np.nanpercentile(values, 90)) if np.any(np.isfinite(values)) else 0.0
    return np.asarray(values > _ON * usual, dtype=bool)


ROLES: tuple[Role, ...] = get_args(Role)
