"""What was measured, as the tables of a page."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from case import Growth, Pair
from clock import Times
from weight import Weight

_FAR_FASTER = 0.1
_GROUPED_FROM = 10_000


class Timed(NamedTuple):
    """A pair and what it took."""

    pair: Pair
    ours: Times
    peer: Times
    weights: tuple[Weight | None, Weight | None]
    """Ours and the peer's."""

    @property
    def holds(self) -> bool:
        """Say whether the ratio is within its bounds."""
        ours, peer = self.ours.median, self.peer.median
        most, least = self.pair.at_most, self.pair.at_least
        return (most is None or ours <= most * peer + self.pair.allowance) and (least is None or peer >= least * ours)

    @property
    def asked(self) -> str:
        """Say the bound; nothing where there is none."""
        if self.pair.at_least is not None:
            return f"≥ {self.pair.at_least:g} times as fast"
        if self.pair.at_most is None:
            return ""
        more = f", and {self.pair.allowance:g} s more" if self.pair.allowance else ""
        return f"≤ {self.pair.at_most:g}{more}"

    @property
    def ratio(self) -> str:
        """Say how both compare, the way that is asked for; of what is far faster, how many times."""
        ratio = self.ours.median / self.peer.median
        turned = self.pair.at_least is not None or ratio < _FAR_FASTER
        return f"{_grouped(float(f'{1 / ratio:.4g}'))} times as fast" if turned else f"{ratio:.3g}"


class Grown(NamedTuple):
    """A growth and what its sizes took."""

    growth: Growth
    times: Sequence[Times]
    exponent: float
    weight: Weight | None
    """Of the largest size."""

    @property
    def holds(self) -> bool:
        """Say whether the exponent is within its bound."""
        return self.exponent <= (self.growth.at_most or self.exponent)

    @property
    def asked(self) -> str:
        """Say the bound; nothing where there is none."""
        return "" if self.growth.at_most is None else f"≤ {self.growth.at_most:g}"


CASES = ("case", "tribopipe", "alternative", "description of the alternative", "ratio", "limit", "limit met")
GROWTH = ("case", "sizes", "times", "exponent", "limit", "limit met")
MEMORY = ("case", "tribopipe", "alternative")


def of_cases(pairs: Iterable[tuple[str, Timed]]) -> list[Sequence[str]]:
    """Return the rows of the table of cases."""
    return [
        (f"({letter}) {one.pair.what}", str(one.ours), str(one.peer), one.pair.beside, one.ratio, *_held(one))
        for letter, one in pairs
    ]


def of_growth(grown: Iterable[tuple[str, Grown]]) -> list[Sequence[str]]:
    """Return the rows of the table of growth."""
    return [
        (
            f"({letter}) {one.growth.what}",
            " · ".join(_grouped(size) for size in one.growth.sizes) + f" {one.growth.of}",
            " · ".join(time.short for time in one.times),
            f"{one.exponent:.2f}",
            *_held(one),
        )
        for letter, one in grown
    ]


def of_memory(pairs: Iterable[tuple[str, Timed]], grown: Iterable[tuple[str, Grown]]) -> list[Sequence[str]]:
    """Return the rows of the table of peak memory."""
    rows: list[Sequence[str]] = [(f"({letter}) {one.pair.what}", *map(_told, one.weights)) for letter, one in pairs]
    rows += [
        (f"({letter}) {one.growth.what}, {_grouped(one.growth.sizes[-1])} {one.growth.of}", _told(one.weight), "")
        for letter, one in grown
    ]
    return rows


def _grouped(number: float) -> str:
    """Write a number with thousands separators from five digits on, as in the documentation."""
    return f"{number:,.10g}" if number >= _GROUPED_FROM else f"{number:.10g}"


def _told(weight: Weight | None) -> str:
    return "" if weight is None else str(weight)


def _held(one: Timed | Grown) -> tuple[str, str]:
    return one.asked, ("yes" if one.holds else "NO") if one.asked else ""
