"""How runs were processed: every option that their steps were given, with its default."""

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from tribopipe.base.units import show
from tribopipe.documents.recipe import Recipe


class Option(NamedTuple):
    """One option as it was used."""

    name: str
    """As a recipe has it: "wear.correction"."""
    value: str
    default: str | None
    """None for what no recipe states, such as the run that a prediction comes from."""
    where: tuple[str, ...]
    """Steps that used this value, where not all used the same."""

    @property
    def changed(self) -> bool:
        """Whether it is another than the default."""
        return self.default is not None and self.value != self.default


def options_used(told: Mapping[str, Mapping[str, Any]]) -> list[Option]:
    """Return what steps, by what people call them, were given."""
    defaults = dict(_flat(Recipe().model_dump(mode="json", by_alias=True)))
    found: dict[str, dict[str, tuple[str, ...]]] = {}
    for step, options in told.items():
        for name, value in _flat(options):
            values = found.setdefault(name, {})
            values[value] = (*values.get(value, ()), step)
    return [
        Option(name, value, defaults.get(name), steps if len(values) > 1 or name not in defaults else ())
        for name, values in found.items()
        for value, steps in values.items()
    ]


def _flat(options: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    for name, value in options.items():
        if isinstance(value, Mapping) and "unit" not in value:
            yield from _flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", _written(value)


def _written(value: Any) -> str:
    """Write an option as a recipe would, in one line."""
    if isinstance(value, Mapping) and "unit" in value:
        return show(value["value"], value.get("standard_uncertainty"), value["unit"])
    if isinstance(value, list) and all(isinstance(one, Mapping) for one in value):
        return "; ".join(_step(one) for one in value) or "none"
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "none"
    return "–" if value is None else value if isinstance(value, str) else json.dumps(value)


def _step(step: Mapping[str, Any]) -> str:
    """Write a step of preprocessing with what it was given."""
    told = ", ".join(f"{name} = {_written(value)}" for name, value in step.items() if name != "step" and value)
    return f"{step.get('step', '')}{f' ({told})' if told else ''}"
