"""What wear depends on: each number with its standard uncertainty and who stated it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from tribopipe.documents.quantity import Quantity

Source = Literal["manifest", "default"]
"""Who stated a standard uncertainty: the lab in run.toml, or the recipe."""


@dataclass(frozen=True)
class Input:
    """One number that wear depends on."""

    quantity: Quantity
    source: Literal["manifest", "default", "fit", "recipe"]
    above_zero: bool = False
    """Whether it must be: a draw of it that is not is drawn again."""

    @property
    def spread(self) -> float:
        """Standard uncertainty."""
        return self.quantity.standard_uncertainty or 0.0


Inputs = Mapping[str, Input]


def best_values(inputs: Inputs) -> dict[str, float]:
    """Return the best estimate of each input."""
    return {name: given.quantity.value for name, given in inputs.items()}


def stated_or_default(quantity: Quantity, default: float) -> tuple[Quantity, Source]:
    """Give a quantity the default standard uncertainty where the manifest states none."""
    if quantity.standard_uncertainty is not None:
        return quantity, "manifest"
    return quantity.model_copy(update={"standard_uncertainty": default}), "default"


def relative_input(quantity: Quantity, share: float, *, above_zero: bool = False) -> Input:
    """Return a quantity as an input; a missing standard uncertainty is set to a fraction of the value."""
    return Input(*stated_or_default(quantity, share * abs(quantity.value)), above_zero)
