"""A study on less than a screen: k_D under each law, and how each run agrees with it."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from tribopipe.base.number_columns import NOTHING, in_power, power_for, rounded_value
from tribopipe.base.units import WEAR_COEFFICIENT, pretty, signed
from tribopipe.cli.output import line_width, print_result, table
from tribopipe.cli.pages import heading, paragraph
from tribopipe.cli.problems import by_kind, short_lines
from tribopipe.cli.quantity_columns import number
from tribopipe.cli.run_columns import Cells, chosen_columns, rows_of
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import between
from tribopipe.physics.laws import law_heading
from tribopipe.results.agreement import AGREEMENT, BodyVerdict, LawResult, RunVerdict, StudyResult
from tribopipe.results.wear_fit import by

_LINES, _ABOUT_A_LAW = 30, 6
"""As many lines are filled on a terminal, and as many are not rows under each law."""
_FEWEST, _LEFT_OUT, _PROBLEMS = 4, 3, 3
"""As many rows are shown at least, and runs that were left out and problems at most."""


class _Row(NamedTuple):
    run: RunVerdict
    name: str
    body: BodyVerdict


def show_study_overview(result: StudyResult, archived: bool = True) -> None:
    """Show a study to people in short; ``archived`` states that `study show` has more of it."""
    heading(result.id, apart=False)
    paragraph("" if result.title in (None, result.id) else str(result.title))
    for law in result.laws:
        _show_law(law, _room(len(result.laws)))
    print_result("")
    for one in result.left_out[:_LEFT_OUT]:
        print_result(f"left out: {one.id} ({one.reason})")
    if len(result.left_out) > _LEFT_OUT:
        print_result(f"and {len(result.left_out) - _LEFT_OUT} more left out")
    verdicts = [run for law in result.laws for run in law.runs]
    warned = by_kind((run.id, one) for run in verdicts for one in run.findings if one.severity != "note")
    for line in short_lines(warned, line_width(), _PROBLEMS):
        print_result(line)
    _show_extrapolations(verdicts)
    quiet = [one for run in verdicts for one in run.findings if one.severity == "note"]
    notes = len(result.notes) + len(quiet) + sum(len(run.notes) for run in verdicts)
    more = f"{notes} note{'' if notes == 1 else 's'}, shapes" if notes else "Shapes"
    how = f"`tribopipe study show {result.id} -v`" if archived else "-v"
    print_result(f"{more} of the curves and intervals: {how}")


def _show_extrapolations(verdicts: Sequence[RunVerdict]) -> None:
    """Name the runs that are predicted outside what the model was tested for."""
    beyond = dict.fromkeys(run.id for run in verdicts for note in run.notes if note.startswith("extrapolation"))
    if beyond:
        print_result(f"extrapolation, see the notes: {', '.join(beyond)}")


def _room(laws: int) -> int | None:
    return None if line_width() is None else max(_FEWEST, (_LINES - 4 - _ABOUT_A_LAW * laws) // max(1, laws))


def _show_law(law: LawResult, room: int | None) -> None:
    counted = "" if law.distance_per_rotation is None else f", {law.distance_per_rotation}"
    heading(f"{law_heading(law.model)}{by(law.engine)}{counted}")
    for name, body in law.bodies.items():
        interval = between(body.interval, WEAR_COEFFICIENT)
        paragraph(f"k_D of the {spoken(name)} {body.wear_coefficient.shown(WEAR_COEFFICIENT)}; 95 % CI {interval}")
    rows = [_Row(run, name, body) for run in law.runs for name, body in run.bodies.items()]
    if not rows:
        return
    taken = rows if room is None or len(rows) <= room else rows[: room - 1]
    columns = {one.name: one for one in _columns(taken)}
    ranked = [
        name
        for name in ("run", "body", "agreement", "E_n", "measured", "law", "role", "slip", "load")
        if name in columns
    ]
    shown = chosen_columns({name: columns[name] for name in ranked}, list(columns))
    table("", [one.heading for one in shown], rows_of(shown), spaced=False)
    if len(taken) < len(rows):
        print_result(f"and {len(rows) - len(taken)} more")


def _columns(rows: Sequence[_Row]) -> Iterator[Cells]:
    yield Cells("run", "run", [row.run.id for row in rows])
    if len({row.name for row in rows}) > 1:
        yield Cells("body", "body", [spoken(row.name) for row in rows])
    yield Cells("role", "role", [row.run.role for row in rows])
    loads = [row.run.normal_load for row in rows]
    unit = "N" if min(load.value for load in loads) >= 1 else "mN"
    yield Cells("load", f"load, {unit}", [rounded_value(number(load, unit)) for load in loads])
    if any(row.run.slip is not None for row in rows):
        yield Cells("slip", "slip", [row.run.slip.shown("%") if row.run.slip else NOTHING for row in rows])
    yield from _compared(rows)
    yield Cells("E_n", "E_n", [f"{signed(row.body.e_n, 2):>6}" for row in rows])
    yield Cells("agreement", "agreement", [AGREEMENT[row.body.outcome] for row in rows])


def _compared(rows: Sequence[_Row]) -> Iterator[Cells]:
    """Give what was measured and what the law gives, in one unit, or each with its own where not all are alike."""
    pairs = [(row.body.measured, row.body.predicted) for row in rows]
    units = {_UNITS.get(row.body.measured.unit, row.body.measured.unit) for row in rows}
    for at, head in enumerate(("measured", "by the law")):
        name = "measured" if at == 0 else "law"
        if len(units) > 1:
            yield Cells(name, head, [pair[at].shown(_UNITS.get(pair[at].unit)) for pair in pairs])
            continue
        unit = next(iter(units))
        power = power_for([number(one, unit) for pair in pairs for one in pair])
        cells = in_power([number(pair[at], unit) for pair in pairs], power)
        yield Cells(name, f"{head}, {cells.unit(pretty(unit))}", cells.cells)


_UNITS = {"m": "um", "m^3": "mm^3"}
