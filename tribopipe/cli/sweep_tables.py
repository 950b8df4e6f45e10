"""Results of a sweep as tables."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeVar

from tribopipe.base.units import WEAR_COEFFICIENT, pretty
from tribopipe.cli.output import print_result, table
from tribopipe.documents.quantity import between, in_unit

if TYPE_CHECKING:
    from tribopipe.documents.quantity import Quantity
    from tribopipe.documents.sweep import Sweep
    from tribopipe.extras.sweep.cases import Case, Ensemble, Found, Head, Row
    from tribopipe.extras.sweep.subject import Cell
    from tribopipe.extras.sweep.summary import ChoiceSpread, Coverage, Scatter, Summary

S = TypeVar("S", bound="Summary")
_MOST_ROWS = 40
_ENDS = ("interval_lower", "interval_upper")
"""Ends of the interval, which are shown in one cell."""
_WORDS = {"end_wear_depth": "final wear depth"}
_UNITS = {
    "wear_coefficient": WEAR_COEFFICIENT,
    "end_wear_depth": "um",
    "wear_depth": "um",
    "wear_volume": "mm^3",
    "mean_pressure": "MPa",
}
"""Display units, if they are not SI."""


def show_rows(asked: "Sweep", ensemble: "Ensemble", found: "Found") -> None:
    """Show the rows, unless they are draws, which are only summarized, or too many."""
    from tribopipe.extras.sweep.cases import answers

    told = list(answers(ensemble, found))
    if asked.draws or len(told) > _MOST_ROWS:
        title = f"{asked.title}: " if asked.title else ""
        print_result(f"{title}{len(told)} rows (saved with --out FILE.csv, printed with --json); summary:")
        return
    cells = [_cells(ensemble, case, row) for case, row in told]
    if cells:
        table(asked.title or "", list(cells[0]), [list(one.values()) for one in cells])


def _cells(ensemble: "Ensemble", case: "Case", row: "Row") -> dict[str, str]:
    """Return a row by the headers of its columns."""
    numbers = [head.name for head in ensemble.numbers]
    return {
        **{_plain(head.name): _cell(head, case.labels[head.name]) for head in ensemble.labels},
        "body": row.body or "–",
        "outcome": f"{row.outcome}: {row.why}" if row.why else row.outcome,
        **{_plain(name): _shown(row.found.get(name), name) for name in numbers if name not in _ENDS},
        **({"95 % CI": _interval(row)} if set(_ENDS) <= set(numbers) else {}),
    }


def _plain(name: str) -> str:
    """Return the displayed name of a column: a key without its document, or words."""
    return name.partition(".")[2] or _WORDS.get(name, name.replace("_", " "))


def _cell(head: "Head", cell: "Cell") -> str:
    if isinstance(cell, str):
        return cell
    return head.written.get(cell) or f"{cell:.5g}{'' if head.unit in (None, '1') else f' {head.unit}'}"


def _shown(quantity: "Quantity | None", name: str) -> str:
    return in_unit(quantity, _UNITS.get(name), "–")


def _interval(row: "Row") -> str:
    """Format an interval of k_D, whose unit is shown next to it."""
    if not row.found.keys() >= set(_ENDS):
        return "–"
    low, high = (row.found[name] for name in _ENDS)
    return between((low, high), WEAR_COEFFICIENT).removesuffix(f" {pretty(WEAR_COEFFICIENT)}")


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:.2g} %"


def show_summaries(labels: "Sequence[Head]", summaries: "Sequence[Summary]") -> None:
    """Show the summaries."""
    from tribopipe.extras.sweep.summary import ChoiceSpread, Coverage, Scatter

    for kind, title, cells in (
        (ChoiceSpread, _SPREADS, _spread_cells),
        (Scatter, _SCATTERS, _scatter_cells),
        (Coverage, _COVERAGES, _coverage_cells),
    ):
        mine = [one for one in summaries if isinstance(one, kind)]
        _show(title, labels, mine, cells)  # type: ignore[arg-type]


_SPREADS = "k_D in mm³/(N·mm) for all choices: half range, stated standard uncertainty u and effect of each choice"
_SCATTERS = "Monte Carlo results; ± is the standard deviation of the samples"
_COVERAGES = "k_D from virtual tests compared with the true k_D; ranges are exact binomial 95 % intervals"


def _show(title: str, labels: "Sequence[Head]", some: Sequence[S], cells: "Callable[[S], dict[str, str]]") -> None:
    if not some:
        return
    heads = {head.name: head for head in labels}
    told = [cells(one) for one in some]
    rows = [
        [
            *(_cell(heads[name], cell) if name in heads else str(cell) for name, cell in one.labels.items()),
            *found.values(),
        ]
        for one, found in zip(some, told, strict=True)
    ]
    table(title, [*map(_plain, some[0].labels), *told[0]], rows)


def _spread_cells(one: "ChoiceSpread") -> dict[str, str]:
    return {
        "fitted": f"{one.fitted} of {one.of}",
        "smallest": one.least.shown(WEAR_COEFFICIENT),
        "largest": one.greatest.shown(WEAR_COEFFICIENT),
        "half range": _percent(one.half_range),
        "stated u": _percent(one.stated),
        **{f"effect of {_plain(path)}": _percent(share) for path, share in one.effects.items()},
    }


def _scatter_cells(one: "Scatter") -> dict[str, str]:
    return {
        "samples": f"{one.predicted} of {one.of}",
        "quantity": _plain(one.quantity),
        "mean": _shown(one.mean, one.quantity),
        "95 % of the samples": between(one.interval, _UNITS.get(one.quantity, one.interval[0].unit)),
    }


def _coverage_cells(one: "Coverage") -> dict[str, str]:
    return {
        "fitted": f"{one.fitted} of {one.held.of}",
        "intervals containing the true k_D": str(one.held),
        **({} if one.limit is None else {f"within {100 * one.limit:g} %": str(one.within)}),
        "bias": _percent(one.bias),
        "scatter": _percent(one.scatter),
        "stated u": _percent(one.stated),
    }
