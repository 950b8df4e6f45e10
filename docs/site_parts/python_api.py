"""Pages of Python names, whose signatures and docstrings are rendered by autodoc."""

import inspect
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import Any, get_args, get_type_hints

from matplotlib.figure import Figure
from pandas import DataFrame, Series

import tribopipe
from site_parts.documents import place_of
from site_parts.markdown import titled
from tribopipe.documents.record import Record

GROUPS = {
    "Read and check": ("read_run", "check_run", "clean_run"),
    "Evaluate": ("correct_drift", "fit_friction", "fit_wear", "fitted_curves"),
    "Predict": ("predict_wear", "wear_scenario", "KnownWear", "Scenario"),
    "Local wear": ("wear_locally", "LocalOptions"),
    "Studies": ("evaluate", "Member", "Study"),
    "Archive": ("open_archive", "Archive", "process"),
    "Figures": (
        "plot_depth",
        "plot_friction",
        "plot_wear",
        "plot_clean_up",
        "plot_contact",
        "plot_local_wear",
        "save_figure",
    ),
    "Records and errors": ("Quantity", "Recipe", "TribopipeError"),
}
_INTRO = """\
The public names of the package `tribopipe`. All numbers are in SI units. The types of arguments and return values are
described under [Python types](python_types.md).

```python
import tribopipe

run = tribopipe.read_run("sample_runs/si3n4-air-200mN")
corrected = tribopipe.correct_drift(run)
fit = tribopipe.fit_wear(corrected, "archard", tribopipe.fit_friction(run))
print(fit)
```

"""


def python_page() -> str:
    """Return the page of all public names. Raises ``ValueError`` where one is in no group, or in two."""
    grouped = [name for names in GROUPS.values() for name in names]
    if sorted(grouped) != sorted(name for name in tribopipe.__all__ if not name.startswith("__")):
        raise ValueError("docs/site_parts/python_api.py: GROUPS and tribopipe.__all__ name different things")
    text = titled(1, "Python", "python") + _INTRO
    for title, names in GROUPS.items():
        directives = (_directive(getattr(tribopipe, name), f"tribopipe.{name}") for name in names)
        text += titled(2, title) + _rendered(directives)
    return text


def types_page() -> str:
    """Return the page of the classes that public names take and return, and those that these hold."""
    public = [getattr(tribopipe, name) for names in GROUPS.values() for name in names]
    found = [one for one in _reached(public) if one not in public]
    text = titled(1, "Python types", "python-types")
    text += "Types of the arguments and return values of [public functions](python.md).\n\n"
    for one in sorted(found, key=lambda one: one.__name__):
        text += titled(2, one.__name__) + _rendered([_directive(one, f"{one.__module__}.{one.__name__}")])
    return text


def _rendered(directives: Iterable[str]) -> str:
    return "```{eval-rst}\n" + "".join(directives) + "```\n\n"


def _directive(thing: Any, name: str) -> str:
    if not isinstance(thing, type):
        return f".. autofunction:: {name}\n\n"
    # A family of records has the fields of its first member that documents hold.
    records = [thing, *thing.__subclasses__()] if issubclass(thing, Record) else []
    place = next((found for record in records if (found := place_of(record))), None)
    if place is not None:
        return f".. autoclass:: {name}\n\n   Fields: :ref:`{place.replace('-', ' ')} <{place}>`.\n\n"
    return f".. autoclass:: {name}\n   :members:\n\n"


def _reached(public: Iterable[Any]) -> list[type]:
    """Return the classes of tribopipe that signatures and fields name, directly or through each other."""
    found: list[type] = []
    left = list(public)
    while left:
        for hint in _hints(left.pop()):
            for named in _classes(hint):
                if named not in found:
                    found.append(named)
                    left.append(named)
    return found


def _hints(thing: Any) -> Iterator[Any]:
    """Give the types in a signature; of a class, those of its fields and public methods."""
    if isinstance(thing, type) and issubclass(thing, Record) and place_of(thing):
        return  # its fields are told elsewhere
    known = {"Figure": Figure, "DataFrame": DataFrame, "Series": Series}
    yield from get_type_hints(thing, localns=known).values()
    if isinstance(thing, type):
        for name, member in vars(thing).items():
            method = inspect.unwrap(_function_of(member))
            if not name.startswith("_") and inspect.isfunction(method):
                yield from get_type_hints(method, localns=known).values()


def _function_of(member: Any) -> Any:
    """Return the function behind a property, a class method or a static method; of anything else, itself."""
    if isinstance(member, property):
        return member.fget
    return member.func if isinstance(member, cached_property) else getattr(member, "__func__", member)


def _classes(hint: Any) -> Iterator[type]:
    if isinstance(hint, type) and hint.__module__.startswith("tribopipe."):
        yield hint
    for inner in hint if isinstance(hint, list) else get_args(hint):
        yield from _classes(inner)
