"""Wear laws: how fast a surface recedes under pressure and friction, and along its way.

Each law is written dh/ds = k_D · p · f with the dimensional wear coefficient k_D = k/H, m²/N, and a factor f of the
sliding distance s, of the friction coefficient μ(s) where the law needs it, and of parameters of its own. So a law is
known by its effective distance S(s) = ∫₀ˢ f ds': the distance over which Archard's law would wear as much.

A package adds a law by an entry point in the group ``tribopipe.laws`` whose value is a class derived from ``WearLaw``;
those in tribopipe.physics.wear_laws, each in a file of its own, are declared the same way.

The integral of a law that knows no closed form is taken by Simpson's rule.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cache
from importlib.metadata import EntryPoint
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple, Self, get_args, get_type_hints

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tribopipe.base.arrays import Column, Values
from tribopipe.base.errors import FitError
from tribopipe.base.plugins import Plugins, added, names, not_installed
from tribopipe.base.units import KINDS
from tribopipe.physics.calculation_methods import LAW_GROUP, LAW_PATTERN
from tribopipe.physics.friction_path import FrictionPath, MeasuredFriction

_PANELS = 1000


def integral(factor: Callable[[Column], Column], distance: ArrayLike, friction: FrictionPath | None) -> Column:
    """Return ∫₀ˢ f ds' at sliding distances in m, by Simpson's rule and a cubic between knots.

    Knots are evenly spaced in √s, since wear begins fast, and at every sample of a measured friction. Before the start
    f keeps the value that it starts from. Draws of f, one a row, give as many rows.
    """
    s = np.asarray(distance, dtype=float)
    knots = _knots(float(np.max(s, initial=0.0)), friction)
    width = np.diff(knots)
    if not len(width):
        return np.asarray(s * factor(s))
    f, middle = factor(knots), factor((knots[1:] + knots[:-1]) / 2)
    panels = width * (f[..., :-1] + 4 * middle + f[..., 1:]) / 6
    up_to = np.concatenate([np.zeros((*panels.shape[:-1], 1)), np.cumsum(panels, axis=-1)], axis=-1)
    at = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(width) - 1)
    share, rise = np.maximum(s - knots[at], 0.0) / width[at], values_at(panels, at)
    # Hermite's cubic, whose slopes are f, is a straight line and what it has beyond that.
    left, right = values_at(f, at) * width[at] - rise, values_at(f, at + 1) * width[at] - rise
    beyond = share * (1 - share) * ((1 - share) * left - share * right)
    before_start = np.minimum(s, 0.0) * values_at(f, np.zeros_like(at))
    return np.asarray(values_at(up_to, at) + share * rise + beyond + before_start)


def _knots(end: float, friction: FrictionPath | None) -> Column:
    even = end * np.linspace(0.0, 1.0, _PANELS + 1) ** 2
    if isinstance(friction, MeasuredFriction):
        return np.unique(np.concatenate([even, np.clip(friction.distance, 0.0, end)]))
    return np.unique(even)


def values_at(values: Column, places: NDArray[np.intp]) -> Column:
    """Return the values at places: of each row at its own, where there are several rows."""
    if values.ndim == 1:
        return np.asarray(values[places])
    wide = np.broadcast_to(places, (len(values), np.shape(places)[-1] if np.ndim(places) else 1))
    return np.take_along_axis(values, wide, axis=1)


class LawParameter(NamedTuple):
    """A parameter of a law in addition to k_D."""

    meaning: str
    kind: str
    """Kind of number, by which its unit is known: "ratio", "distance"…"""
    low: float
    high: float
    """Between which it is sought, SI."""


@dataclass(frozen=True)
class WearLaw(ABC):
    """One wear law. Its fields are its parameters in addition to k_D: numbers, or columns of as many draws.

    Each is annotated with a ``LawParameter``, and a fit of it starts at its default.
    """

    name: ClassVar[str]
    """Name in commands, recipes and results: lowercase letters, digits and _."""
    title: ClassVar[str]
    """Title within a sentence, such as "Archard's law"."""
    rate: ClassVar[str]
    """dh/ds as one would write it down."""
    citation: ClassVar[str]
    """Reference."""
    needs_friction: ClassVar[bool] = False
    """Whether μ enters."""

    @abstractmethod
    def rate_factor(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return f of dh/ds = k_D·p·f at sliding distances in m; friction is there where the law needs it."""

    def effective_distance(self, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        """Return S(s) = ∫₀ˢ f ds', m: by quadrature, unless a law knows it in closed form."""
        return integral(lambda s: self.rate_factor(s, friction), distance, friction)

    @classmethod
    def parameters(cls) -> dict[str, LawParameter]:
        """Return the parameters in addition to k_D by name."""
        return _parameters(cls)

    def scale_of(self, parameter: str, value: float) -> float:
        """Return by how much a parameter has to change to matter: its value, or its start where it may be 0."""
        known, start = self.parameters()[parameter], type(self)().values()[parameter]
        return abs(value) if known.low > 0 else max(abs(value), abs(start) or known.high - known.low)

    @staticmethod
    def input_of(parameter: str) -> str:
        """Return what a parameter is called among the inputs of a fit."""
        return f"law_{parameter}"

    @classmethod
    def inputs(cls) -> tuple[str, ...]:
        """Return what all parameters are called among the inputs of a fit."""
        return tuple(map(cls.input_of, cls.parameters()))

    def values(self) -> dict[str, float]:
        """Return the parameters as they are set, SI."""
        return {name: float(getattr(self, name)) for name in self.parameters()}

    def at(self, values: Values) -> Self:
        """Return the law with those parameters that are among the inputs of a fit, within their bounds."""
        found = {
            name: np.clip(values[self.input_of(name)], known.low, known.high)
            for name, known in self.parameters().items()
            if self.input_of(name) in values
        }
        return replace(self, **found) if found else self


@cache
def _parameters(law: type[WearLaw]) -> dict[str, LawParameter]:
    hints = get_type_hints(law, include_extras=True)
    return {one.name: _parameter(hints[one.name]) for one in fields(law)}


def _parameter(hint: Any) -> LawParameter:
    return next(said for said in get_args(hint) if isinstance(said, LawParameter))


def required(law: WearLaw, friction: FrictionPath | None) -> FrictionPath:
    """Return the friction along the way. Raises ``FitError`` where there is none for a law that needs it."""
    if friction is None:
        raise FitError(
            f"{_capitalized(law.title)}: found no friction coefficient; expected μ(s), fitted or specified; specify "
            'μ(s) with --friction "A=0.2 b=0.4 c=50 m", or use Archard\'s law'
        )
    return friction


def _made(entry: EntryPoint) -> WearLaw:
    law = entry.load()()
    if not isinstance(law, WearLaw) or law.name != entry.name or not re.fullmatch(LAW_PATTERN, law.name):
        raise TypeError(f"is not a WearLaw named {entry.name}, a name in lowercase letters, digits and _")
    if unknown := {known.kind for known in law.parameters().values()} - set(KINDS):
        raise TypeError(f"has a parameter of the unknown kind {min(unknown)!r}; the kinds are {', '.join(KINDS)}")
    return law


LAWS: Mapping[str, WearLaw] = Plugins(LAW_GROUP, "wear law", _made, attrgetter("name"))
"""Installed laws by name, each with the start values of its parameters."""


_OF_SESSION: dict[str, WearLaw] = {}
"""Laws made from functions in this process, unavailable to commands and archives."""


def add_law(law: WearLaw) -> None:
    """Have a law be known by its name as long as this process runs."""
    _OF_SESSION[law.name] = law


def law_named(name: str) -> WearLaw:
    """Return a law. Raises ``FitError``, which names the nearest, where it is not installed on this machine."""
    if name in _OF_SESSION:
        return _OF_SESSION[name]
    if name not in LAWS and name in names(LAW_GROUP):
        raise FitError(
            f"found the wear law {name!r}, which cannot be loaded; expected a working plug-in; see the warning for "
            "the reason, and repair or reinstall the package"
        )
    if name not in LAWS:
        raise FitError(not_installed(LAW_GROUP, "wear law", name))
    return LAWS[name]


def law_package(name: str) -> str | None:
    """Return the package that adds a law, with its version; not one of tribopipe own or of one not installed here."""
    package = next((entry.dist for entry in added(LAW_GROUP) if entry.name == name), None)
    return None if package is None else f"{package.name} {package.version}"


def law_title(name: str) -> str:
    """Return what a law is called within a sentence, installed here or not."""
    known = _OF_SESSION.get(name) or LAWS.get(name)
    return known.title if known is not None else f"the law {name}, which is not installed"


def law_heading(name: str) -> str:
    """Return what a law is called where a sentence begins."""
    return _capitalized(law_title(name))


def _capitalized(title: str) -> str:
    return title[:1].upper() + title[1:]


def law_label(name: str) -> str:
    """Return what a law is called in the head of a column or in a key, such as Archard."""
    return name.replace("_", " ").capitalize()
