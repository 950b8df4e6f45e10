"""What a further test would buy: which uncertainty to reduce, how far to slide, how often to repeat."""

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import LawName
from tribopipe.documents.record import Record
from tribopipe.results.input_quantities import input_label


class Lever(Record):
    """One input of k_D and what it costs."""

    name: str
    """Input."""
    value: Quantity | None = None
    """Its value and standard uncertainty; none for the noise of the depth signal."""
    shown_in: str | None = None
    """Unit in which people read it."""
    relative: float
    """Standard uncertainty of k_D from this input alone, over k_D."""
    share: float
    """Its part of the variance of k_D."""
    if_halved: float
    """Half width of the 95 % interval of k_D over k_D, were this input twice as well known."""


class Design(Record):
    """What it would take to know k_D of a run to a wanted interval, by first-order propagation."""

    id: str
    """Run that is planned from."""
    model: LawName
    """Wear law."""
    of: str = "k_D"
    """Whose k_D, where there are two."""
    half_width: float
    """Half width of the 95 % interval of k_D over k_D, as it is."""
    wanted: float
    """The same as wanted."""
    levers: tuple[Lever, ...]
    """Inputs, the most rewarding first."""
    sliding_distance: Quantity | None = None
    """How far one test would have to slide; none if no length is sufficient."""
    rotations: Quantity | None = None
    """How many rotations one test of two discs would take; none if no number is sufficient, or for a pin."""
    by_distance: float
    """Half width that no longer test gets below."""
    replicates: int | None = None
    """Number of tests like this one that would be sufficient; none if no number is."""
    by_replicates: float
    """Half width that no number of replicates gets below: what all runs share."""
    scatter: float | None = None
    """Scatter of k_D between runs over k_D that was counted with; none where it is not known."""

    def __str__(self) -> str:
        best = self.levers[0]
        label = input_label(best.name)
        lines = [
            f"{self.id}, {self.model}: {self.of} is known to ±{self.half_width:.1%}, wanted ±{self.wanted:.1%} (95 %)",
            f"  largest contribution: {label}, {best.share:.0%} of the variance; halved, ±{best.if_halved:.1%}",
        ]
        if self.half_width <= self.wanted:
            return "\n".join([*lines, "  no further test is needed"])
        if self.sliding_distance is not None:
            lines.append(f"  one test of {self.sliding_distance.value:,.0f} m would be sufficient")
        elif self.rotations is not None:
            lines.append(f"  one test of {self.rotations.value:,.0f} rotations would be sufficient")
        else:
            lines.append(f"  a longer test is not sufficient: at best ±{self.by_distance:.1%}")
        if self.replicates is not None:
            lines.append(f"  {self.replicates} tests like this one would be sufficient")
        else:
            lines.append(f"  replicates are not sufficient: all runs share ±{self.by_replicates:.1%}")
        if self.scatter is None:
            lines.append("  the scatter between runs is unknown and not included: more replicates may be needed")
        return "\n".join(lines)
