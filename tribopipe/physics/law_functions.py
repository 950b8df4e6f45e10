"""Wear laws made of a function, to try one in Python before it becomes a package: dh/ds = k_D·p·f(s, …).

    def running_in(s, excess=1.0, length: "m" = 10.0):
        return 1 + excess * np.exp(-s / length)

The first argument is the sliding distance, m. One called ``friction`` is the friction coefficient there. Every other
one is a parameter that is fitted with k_D; the search starts at its default. Its annotation is its SI unit, "1" unless
stated, or a ``LawParameter``, which also states between which bounds it is sought; else that is a hundredth to a
hundred times the default.

Such a law is known in this process alone: no archive and no command takes it.
"""

import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import field, make_dataclass
from typing import Annotated, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike

from tribopipe.base.arrays import Column
from tribopipe.base.errors import FitError
from tribopipe.base.plugins import names
from tribopipe.base.units import KINDS
from tribopipe.physics.calculation_methods import LAW_GROUP, LAW_PATTERN
from tribopipe.physics.friction_path import FrictionPath
from tribopipe.physics.laws import LawParameter, WearLaw, add_law

_FRICTION = "friction"
_RANGE = 100.0
"""Range of a parameter, as a factor of its default."""
_KNOWN: "WeakKeyDictionary[Callable[..., Any], str]" = WeakKeyDictionary()
_TAKEN: set[str] = set()


def law_of_function(function: Callable[..., Any]) -> str:
    """Make a wear law of a function, and return the name by which it is known as long as this process runs.

    The same function is the same law. Another one of the same name gets a number, so that earlier fits keep their law.

    Parameters
    ----------
    function
        f of the sliding distance, m, and of parameters with defaults, as the first lines of this module state.

    Returns
    -------
    str
        Name of the law.

    Raises
    ------
    FitError
        Where the function cannot be a law.
    """
    if function in _KNOWN:
        return _KNOWN[function]
    title = getattr(function, "__name__", type(function).__name__)
    needs_friction, parameters = _parameters(title, function)
    name = _free_name(title)

    def rate_factor(self: WearLaw, distance: ArrayLike, friction: FrictionPath | None) -> Column:
        return _called(title, function, distance, friction, {key: getattr(self, key) for key in parameters})

    made: type[WearLaw] = make_dataclass(
        name,
        [(key, Annotated[Any, known], field(default=start)) for key, (known, start) in parameters.items()],
        bases=(WearLaw,),
        namespace={
            "name": name,
            "title": f"{title}()",
            "rate": f"k_D·p·{title}(s)",
            "citation": "a function of this session",
            "needs_friction": needs_friction,
            "rate_factor": rate_factor,
        },
        frozen=True,
    )
    law = made()
    _try(title, law)
    add_law(law)
    _KNOWN[function] = name
    _TAKEN.add(name)
    return name


def _free_name(title: str) -> str:
    plain = re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_")
    plain = plain if re.fullmatch(LAW_PATTERN, plain) else f"law_{plain}_f"
    taken, number, name = {*names(LAW_GROUP), *_TAKEN}, 2, plain
    while name in taken:
        name, number = f"{plain}_{number}", number + 1
    return name


def _parameters(title: str, function: Callable[..., Any]) -> tuple[bool, dict[str, tuple[LawParameter, float]]]:
    """Return whether a function takes the friction coefficient, and its parameters with where each search starts."""
    try:
        found = list(inspect.signature(function).parameters.values())
    except (TypeError, ValueError):
        found = []
    if not found or any(one.kind not in (one.POSITIONAL_OR_KEYWORD, one.KEYWORD_ONLY) for one in found):
        raise FitError(
            f"{title}: found a function whose arguments cannot be determined; expected f(s, parameter=start, …); "
            "define it in that form"
        )
    _, *others = found
    rest = [one for one in others if one.name != _FRICTION]
    return len(rest) < len(others), {one.name: _parameter(title, one) for one in rest}


def _parameter(title: str, one: inspect.Parameter) -> tuple[LawParameter, float]:
    start, said = one.default, one.annotation
    if isinstance(start, bool) or not isinstance(start, int | float):
        raise FitError(
            f"{title}: found the argument {one.name!r} without a default; expected a default, used as the starting "
            f"value of the fit; write {one.name}=1.0"
        )
    if isinstance(said, LawParameter):
        return said, float(start)
    if not start > 0:
        raise FitError(
            f"{title}: found {one.name} = {start:g} as the starting value; expected a positive number, or bounds for "
            f"the fit; annotate the argument: {one.name}: "
            'LawParameter("…", "ratio", low=…, high=…)'
        )
    kind = _kind(title, one)
    return LawParameter(one.name, kind, low=start / _RANGE, high=start * _RANGE), float(start)


def _kind(title: str, one: inspect.Parameter) -> str:
    """Return the kind of number of a parameter, by the SI unit that its annotation is."""
    said = one.annotation
    if said in (one.empty, float, int):
        return "ratio"
    unit = str(said).strip("'\"")
    kinds = [kind for kind, known in KINDS.items() if unit in (known.si, kind)]
    if unit in ("float", "int"):
        return "ratio"
    if not kinds:
        known = ", ".join(dict.fromkeys(kind.si for kind in KINDS.values()))
        raise FitError(
            f"{title}: found {said!r} as the unit of {one.name}; expected one of {known}; annotate the argument "
            "with an SI unit"
        )
    return "distance" if "distance" in kinds else kinds[0]


def _called(
    title: str,
    function: Callable[..., Any],
    distance: ArrayLike,
    friction: FrictionPath | None,
    parameters: Mapping[str, Any],
) -> Column:
    s = np.asarray(distance, dtype=float)
    beside = {} if friction is None else {_FRICTION: friction.coefficient(s)}
    taken = inspect.signature(function).parameters
    try:
        with np.errstate(all="ignore"):  # what is not finite is refused, or fits no run
            found = function(s, **{key: value for key, value in beside.items() if key in taken}, **parameters)
    except (TypeError, ValueError) as error:
        raise FitError(
            f"{title}: cannot be computed for arrays ({error}); expected a function that accepts them; use NumPy "
            "functions such as np.exp and np.where"
        ) from error
    return np.asarray(found, dtype=float) + np.zeros(s.shape)


def _try(title: str, law: WearLaw) -> None:
    """Raise ``FitError`` where a law gives no factor at some distances, or none for draws of its parameters."""
    s, draws = np.array([0.0, 1.0, 10.0]), {name: np.full((2, 1), value) for name, value in law.values().items()}
    if law.needs_friction:
        return  # of which nothing is known yet
    for values, shape in (({}, (3,)), (draws, (2, 3) if draws else (3,))):
        moved = law.at({law.input_of(name): value for name, value in values.items()})
        found = moved.rate_factor(s, None)
        if found.shape != shape or not np.all(np.isfinite(found)):
            raise FitError(
                f"{title}: found {np.array2string(found, threshold=6)} at {s.tolist()} m; expected one finite factor "
                "at each distance; check the values that the function returns, including the value at 0 m"
            )
