"""Summary of a sweep: spread over choices, distribution of predictions, results of virtual tests."""

import math
import statistics
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record
from tribopipe.documents.sweep import Sweep
from tribopipe.extras.sweep.cases import Answer, Case, Ensemble, Found, answers
from tribopipe.extras.sweep.choices import COEFFICIENT
from tribopipe.extras.sweep.predictions import asked_for
from tribopipe.extras.sweep.subject import Cell
from tribopipe.extras.sweep.virtual_tests import TRUTH
from tribopipe.physics.uncertainty import TAILS

Labels = Mapping[str, Cell]


class Share(Record):
    """Count out of a total, with the exact binomial 95 % interval of the probability (Clopper and Pearson)."""

    count: int
    """Count."""
    of: int
    """Total number."""
    interval: tuple[float, float]
    """95 % interval."""

    @classmethod
    def counted(cls, count: int, of: int) -> "Share":
        """Count; of none, nothing is known."""
        from scipy.stats import binomtest

        if not of:
            return cls(count=0, of=0, interval=(0.0, 1.0))
        within = binomtest(count, of).proportion_ci(0.95)
        return cls(count=count, of=of, interval=(float(within.low), float(within.high)))

    def __str__(self) -> str:
        if not self.of:
            return "–"
        low, high = self.interval
        return f"{self.count} of {self.of} ({100 * low:.0f}–{100 * high:.0f} %)"


class ChoiceSpread(Record):
    """k_D of one body of a run over all ways of evaluating it under one law."""

    labels: dict[str, str | float]
    """Run, body and law."""
    fitted: int
    """Number of combinations with a k_D."""
    of: int
    """Total number."""
    least: Quantity
    """Smallest k_D."""
    greatest: Quantity
    """Largest k_D."""
    stated: float
    """Standard uncertainty over k_D, the median of those stated."""
    effects: dict[str, float]
    """Largest change of the mean k_D with each choice, relative to the mean of all."""

    @property
    def half_range(self) -> float:
        """Half of what lies between smallest and largest k_D, over their mean."""
        low, high = self.least.value, self.greatest.value
        return (high - low) / (high + low)


class Scatter(Record):
    """Distribution of a prediction over the draws of one combination."""

    labels: dict[str, str | float]
    """Keys that are not drawn, body, and place or depth of the prediction."""
    predicted: int
    """Number of draws with a prediction."""
    of: int
    """Total number."""
    quantity: str
    """Predicted quantity."""
    mean: Quantity
    """Mean, and standard deviation as its uncertainty."""
    interval: tuple[Quantity, Quantity]
    """95 % of the draws lie between."""


class Coverage(Record):
    """Results of the virtual tests of one combination, compared with the true values."""

    labels: dict[str, str | float]
    """Keys that are not drawn, and body."""
    fitted: int
    """Number of tests with a k_D."""
    held: Share
    """Number of 95 % intervals that contain the true k_D; a test without a k_D does not count as one."""
    within: Share | None
    """Number of tests within the target deviation from the true k_D."""
    limit: float | None
    """Target deviation, relative to the true k_D."""
    bias: float | None
    """Mean deviation of k_D from the true one, over it."""
    scatter: float | None
    """Standard deviation of k_D between tests, over the true one."""
    stated: float | None
    """Standard uncertainty of k_D that a test states, over k_D: the median."""


Summary = ChoiceSpread | Scatter | Coverage


def summarised(sweep: Sweep, ensemble: Ensemble, found: Found) -> list[Summary]:
    """Return a summary of each group of rows; nothing of predictions without draws, where rows have it all."""
    drawn = {path for path, values in sweep.vary.items() if not isinstance(values, tuple)} | {"repeat"}
    told = list(answers(ensemble, found))
    if sweep.choices is not None:
        varied = [path for path in sweep.vary if path not in drawn | {"law"}]
        return list(_spreads(told, ("run", "law"), varied))
    kept = tuple(head.name for head in ensemble.labels if head.name not in drawn)
    if sweep.virtual_tests is not None:
        within = sweep.virtual_tests.within
        return list(_coverages(told, kept, None if within is None else within.value))
    return list(_scatters(told, kept)) if sweep.draws else []


def _groups(some: Sequence[Answer], key: Callable[[Answer], Labels]) -> Iterator[tuple[Labels, list[Answer]]]:
    groups: dict[tuple[Cell, ...], tuple[Labels, list[Answer]]] = {}
    for answer in some:
        labels = key(answer)
        groups.setdefault(tuple(labels.values()), (labels, []))[1].append(answer)
    return iter(groups.values())


def _named(case: Case, names: Sequence[str]) -> dict[str, Cell]:
    return {name: case.labels[name] for name in names if name in case.labels}


def _by_body(some: Sequence[Answer], names: Sequence[str]) -> Iterator[tuple[Labels, list[Answer], int]]:
    """Give the rows of each body of each group that have numbers, and the number of cases of the group."""
    for labels, group in _groups(some, lambda answer: _named(answer.case, names)):
        cases = len({id(answer.case) for answer in group})
        bodies = list(dict.fromkeys(answer.row.body for answer in group if answer.row.found)) or [""]
        for body in bodies:
            yield {**labels, "body": body}, [one for one in group if one.row.found and one.row.body == body], cases


def _coefficients(some: Sequence[Answer]) -> list[Quantity]:
    return [answer.row.found[COEFFICIENT.name] for answer in some]


def _stated(found: Sequence[Quantity]) -> float:
    return statistics.median(one.u_or_zero / one.value if one.value else math.inf for one in found)


def _spreads(some: Sequence[Answer], names: Sequence[str], varied: Sequence[str]) -> Iterator[ChoiceSpread]:
    for labels, mine, cases in _by_body(some, names):
        found = _coefficients(mine)
        if found:
            yield ChoiceSpread(
                labels=dict(labels),
                fitted=len(found),
                of=cases,
                least=min(found, key=lambda one: one.value),
                greatest=max(found, key=lambda one: one.value),
                stated=_stated(found),
                effects={path: _effect(mine, path) for path in varied},
            )


def _effect(some: Sequence[Answer], path: str) -> float:
    """Return by how much the mean k_D differs between the values of one choice, over the mean of all."""
    means = [
        statistics.fmean(one.value for one in _coefficients(group))
        for _, group in _groups(some, lambda answer: _named(answer.case, [path]))
    ]
    return (max(means) - min(means)) / statistics.fmean(means)


def _coverages(some: Sequence[Answer], names: Sequence[str], within: float | None) -> Iterator[Coverage]:
    for labels, mine, tests in _by_body(some, names):
        found = _coefficients(mine)
        truths = [answer.row.found[TRUTH.name].value for answer in mine]
        off = [one.value / true - 1 for one, true in zip(found, truths, strict=True)]
        close = None if within is None else Share.counted(sum(abs(one) <= within for one in off), tests)
        yield Coverage(
            labels=dict(labels),
            fitted=len(found),
            held=Share.counted(sum(map(_holds, mine)), tests),
            within=close,
            limit=within,
            bias=statistics.fmean(off) if off else None,
            scatter=statistics.stdev(off) if len(off) > 1 else None,
            stated=_stated(found) if found else None,
        )


def _holds(answer: Answer) -> bool:
    low, high, true = (answer.row.found[name].value for name in ("interval_lower", "interval_upper", TRUTH.name))
    return low <= true <= high


def _scatters(some: Sequence[Answer], names: Sequence[str]) -> Iterator[Scatter]:
    """Give what draws make of the depth at each place, and of the place where each depth is reached."""
    for labels, group in _groups(some, lambda answer: _named(answer.case, names)):
        cases = len({id(answer.case) for answer in group})
        told = [answer for answer in group if answer.row.found]
        for what, mine in _groups(told, lambda answer: {"body": answer.row.body, "outcome": answer.row.outcome}):
            name = asked_for(mine[0].row)
            values = np.asarray([answer.row.found[name].value for answer in mine])
            unit = mine[0].row.found[name].unit
            low, high = (Quantity(value=float(end), unit=unit) for end in np.quantile(values, TAILS))
            spread = float(np.std(values, ddof=1)) if len(values) > 1 else None
            yield Scatter(
                labels={**labels, **what},
                predicted=len(values),
                of=cases,
                quantity=name,
                mean=Quantity(value=float(np.mean(values)), unit=unit, standard_uncertainty=spread),
                interval=(low, high),
            )
