"""A run or a study on less than a screen: bodies, conditions, results, k_D under each law, and problems."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from tribopipe.archive.step_names import PREDICTIONS
from tribopipe.base.column_formatting import NOTHING, Number, in_power, power_for, rounded_value
from tribopipe.base.errors import ArchiveError, counted
from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT, from_si, interval_from_si, pretty, signed
from tribopipe.cli.listing import Cells, chosen_columns, rows_of
from tribopipe.cli.output import line_width, print_result, table
from tribopipe.cli.pages import heading, paragraph, show_facts, show_head
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.quantity import Quantity, between, in_unit
from tribopipe.physics.laws import law_heading, law_title
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.finding import Finding, title
from tribopipe.results.specific_wear import SpecificWear
from tribopipe.results.study import AGREEMENT, BodyVerdict, LawResult, RunVerdict, StudyResult
from tribopipe.results.wear_fit import WearFit, by, fits_of
from tribopipe.results.wear_prediction import WearPrediction
from tribopipe.views.page import Fact, RunPage
from tribopipe.views.run_page import run_page

if TYPE_CHECKING:
    from tribopipe.archive.outline import RunOutline
    from tribopipe.archive.store import Archive


def number(quantity: Quantity, unit: str) -> Number:
    """Return a quantity as a value and its standard uncertainty, in a unit."""
    u = quantity.standard_uncertainty
    value = float(from_si(quantity.value, quantity.unit, unit))
    return value, None if u is None else float(interval_from_si(u, quantity.unit, unit))


Problems: TypeAlias = dict[tuple[str, str], list[str]]
"""Runs by severity and code of their findings."""


def by_kind(found: Iterable[tuple[str, Finding]]) -> Problems:
    """Return the runs that have each problem, each once."""
    problems: Problems = {}
    for run_id, finding in found:
        ids = problems.setdefault((finding.severity, finding.code), [])
        if run_id not in ids:
            ids.append(run_id)
    return problems


def short_lines(problems: Problems, width: int | None, most: int) -> list[str]:
    """Format problems as at most ``most`` lines that fit a width; the last one counts the remaining problems."""
    shown = list(problems.items()) if len(problems) <= most else list(problems.items())[: most - 1]
    lines = [shortened(f"{severity}: {title(code)}: ", ids, width) for (severity, code), ids in shown]
    if len(shown) < len(problems):
        lines.append(f"and {len(problems) - len(shown)} more: `tribopipe show RUN`, or -v")
    return lines


def shortened(what: str, ids: Sequence[str], width: int | None) -> str:
    """Name as many runs as fit on a line, and count the others."""
    for named in range(len(ids), 0, -1):
        left = f" and {len(ids) - named} more" if named < len(ids) else ""
        line = f"{what}{', '.join(ids[:named])}{left}"
        if width is None or len(line) <= width:
            return line
    return f"{what}{ids[0] if len(ids) == 1 else counted(len(ids), 'run')}"


_OF_BODIES = ("material", "shape", "radius", "radius of the flat", "crown radius", "diameter")
"""Properties of a body to show; of radius and diameter, only the first."""
_WARNINGS, _REMARKS = 4, 2
"""Largest number of findings and remarks that are named."""


def show_run_overview(store: "Archive", run_id: str) -> None:
    """Show a summary of a run."""
    page, outline = run_page(store, run_id), store.outline(run_id)
    show_head(page)
    tested, found = list(_tested(page, outline)), list(_found(store, outline))
    width = max((len(fact.name) for fact in (*tested, *found)), default=0)
    print_result("")
    show_facts(tested, width)
    if found:
        heading("Results", "(± is one standard uncertainty)")
        show_facts(found, width)
    _show_warnings(page, outline)
    print_result(f"\n{store.path(run_id)}")
    print_result(f"All details: `tribopipe show {run_id} -v`")


def _tested(page: RunPage, outline: "RunOutline") -> Iterator[Fact]:
    groups = {group.title: group.facts for group in page.facts}
    for name in outline.manifest.bodies:
        facts = {fact.name: fact.value for fact in groups.get(spoken(name).capitalize(), ())}
        words = [facts[one] if one in _OF_BODIES[:2] else f"{one} {facts[one]}" for one in _OF_BODIES if one in facts]
        yield Fact(spoken(name), ", ".join(words[:3]))
    for group in ("Conditions", "Recorded", "Post-test measurements"):
        if groups.get(group):
            yield Fact(group.lower(), "; ".join(f"{fact.name} {fact.value}" for fact in groups[group]))
    cleaned = next((step.result for name, step in outline.steps.items() if name == "clean_up"), None)
    if isinstance(cleaned, CleanUp) and cleaned.changes:
        yield Fact("preprocessing", ", ".join(dict.fromkeys(change.step for change in cleaned.changes)))
    for remark in page.remarks[-_REMARKS:]:
        yield Fact(remark.kind, f"{remark.text} ({remark.date[:10]})")
    if page.studies:
        yield Fact("studies", ", ".join(page.studies))


def _found(store: "Archive", outline: "RunOutline") -> Iterator[Fact]:
    results = {name: step.result for name, step in outline.steps.items()}
    friction, drift, wear = (results.get(name) for name in ("friction_fit", "drift_correction", "specific_wear"))
    if isinstance(friction, FrictionFit):
        yield from _of_friction(friction)
    if isinstance(drift, DriftCorrection) and drift.drift_rate is not None:
        yield Fact("drift", drift.drift_rate.shown("nm/min"))
    if isinstance(wear, SpecificWear):
        yield from _of_wear(wear, outline)
    for fit in fits_of(results.values()):
        yield from _of_fit(fit, outline)
        predicted = results.get(PREDICTIONS[fit.model])
        if isinstance(predicted, WearPrediction):
            yield from _of_prediction(predicted, outline)
    yield from _of_studies(store, outline)


def _of_friction(friction: FrictionFit) -> Iterator[Fact]:
    if friction.steady_state is not None:
        yield Fact("steady-state μ", str(friction.steady_state))
    if friction.mean is not None:
        yield Fact("mean μ", str(friction.mean))
    if friction.running_in_distance is not None:
        yield Fact("running-in distance c", friction.running_in_distance.shown("m"))


def _of_wear(wear: SpecificWear, outline: "RunOutline") -> Iterator[Fact]:
    for name, body in wear.bodies.items():
        told = (
            in_unit(body.volume, "mm^3", ""),
            f"wear depth {body.depth.shown('um')}" if body.depth else "",
            in_unit(body.specific_wear_rate, SPECIFIC_WEAR_RATE, ""),
        )
        if any(told):
            yield Fact(outline.manifest.worded(f"wear of the {spoken(name)}"), "; ".join(filter(None, told)))


def _of_fit(fit: WearFit, outline: "RunOutline") -> Iterator[Fact]:
    counted = "" if fit.distance_per_rotation is None else f", {fit.distance_per_rotation}"
    law = f"{law_title(fit.model)}{by(fit.engine)}{counted}"
    for name, body in fit.bodies.items():
        of = outline.manifest.worded(f"k_D of the {spoken(name)}")
        yield Fact(of, f"{body.wear_coefficient.shown(WEAR_COEFFICIENT)}, {law}")
        yield Fact("  95 % CI", between(body.interval, WEAR_COEFFICIENT))
    if fit.parameters:
        yield Fact("  parameters", ", ".join(map(str, fit.parameters)))
    if not fit.bodies and fit.missing:
        yield Fact("k_D", f"not determined ({law}): missing {' and '.join(fit.missing)}")


def _of_prediction(predicted: WearPrediction, outline: "RunOutline") -> Iterator[Fact]:
    end = predicted.prediction[0]
    bodies = "; ".join(f"{outline.manifest.worded(spoken(name))} {body}" for name, body in end.bodies.items())
    source = f" from {predicted.reference}" if predicted.reference else ""
    yield Fact("  predicted wear", f"{bodies}{source}")


def _of_studies(store: "Archive", outline: "RunOutline") -> Iterator[Fact]:
    """Yield the agreement of the run with each law of each study; damaged studies are skipped."""
    run_id = outline.manifest.id
    for study_id in store.studies_of(run_id):
        with suppress(ArchiveError):
            laws = store.study_outline(study_id).result.laws
            words = [
                f"{AGREEMENT[one.outcome]} with {law_heading(law.model)} ({one.role})"
                for law in laws
                for one in law.runs
                if one.id == run_id
            ]
            if words:
                yield Fact("agreement", f"{'; '.join(words)}: study {study_id}")


def _show_warnings(page: RunPage, outline: "RunOutline") -> None:
    """Name the errors and warnings on the run; -v shows each in full."""
    worded, told = outline.manifest.worded, [one for one in page.findings if one.severity != "note"]
    named = [f"{one.severity}: {one.where}: {worded(title(one.code))}" for one in told]
    notes = len(page.findings) - len(named)
    if notes:
        named.append(counted(notes, "note"))
    if not named:
        return
    heading("Findings")
    shown = named if len(named) <= _WARNINGS else named[: _WARNINGS - 1]
    for line in shown:
        paragraph(line)
    if len(shown) < len(named):
        paragraph(f"and {len(named) - len(shown)} more")


_LINES, _ABOUT_A_LAW = 30, 6
"""Number of lines to fill on a terminal, and of those under each law that are not rows."""
_FEWEST, _LEFT_OUT, _PROBLEMS = 4, 3, 3
"""Smallest number of rows shown, and largest numbers of excluded runs and of problems."""


class _Row(NamedTuple):
    run: RunVerdict
    name: str
    body: BodyVerdict


def show_study_overview(result: StudyResult, archived: bool = True) -> None:
    """Show a summary of a study; if it is ``archived``, `study show` has more details."""
    heading(result.id, apart=False)
    paragraph("" if result.title in (None, result.id) else str(result.title))
    for law in result.laws:
        _show_law(law, _rows_per_law(len(result.laws)))
    print_result("")
    for one in result.left_out[:_LEFT_OUT]:
        print_result(f"excluded: {one.id} ({one.reason})")
    if len(result.left_out) > _LEFT_OUT:
        print_result(f"and {len(result.left_out) - _LEFT_OUT} more runs excluded")
    verdicts = [run for law in result.laws for run in law.runs]
    warned = by_kind((run.id, one) for run in verdicts for one in run.findings if one.severity != "note")
    for line in short_lines(warned, line_width(), _PROBLEMS):
        print_result(line)
    for note in result.notes:
        if note.startswith("warning: "):
            print_result(note)
    _show_extrapolations(verdicts)
    quiet = [one for run in verdicts for one in run.findings if one.severity == "note"]
    notes = len(result.notes) + len(quiet) + sum(len(run.notes) for run in verdicts)
    more = f"{counted(notes, 'note')}, shapes" if notes else "Shapes"
    how = f"`tribopipe study show {result.id} -v`" if archived else "-v"
    print_result(f"{more} of the curves and intervals: {how}")


def _show_extrapolations(verdicts: Sequence[RunVerdict]) -> None:
    """Name the runs that are predicted outside the range in which the model was tested."""
    beyond = dict.fromkeys(run.id for run in verdicts for note in run.notes if note.startswith("extrapolation"))
    if beyond:
        print_result(f"extrapolation, see the notes: {', '.join(beyond)}")


def _rows_per_law(laws: int) -> int | None:
    return None if line_width() is None else max(_FEWEST, (_LINES - 4 - _ABOUT_A_LAW * laws) // max(1, laws))


def _show_law(law: LawResult, room: int | None) -> None:
    counted = "" if law.distance_per_rotation is None else f", {law.distance_per_rotation}"
    heading(f"{law_heading(law.model)}{by(law.engine)}{counted}")
    for name, body in law.bodies.items():
        interval = between(body.interval, WEAR_COEFFICIENT)
        paragraph(f"k_D of the {spoken(name)} {body.wear_coefficient.shown(WEAR_COEFFICIENT)}; 95 % CI: {interval}")
    rows = [_Row(run, name, body) for run in law.runs for name, body in run.bodies.items()]
    if not rows:
        return
    taken = rows if room is None or len(rows) <= room else rows[: room - 1]
    columns = {one.name: one for one in _verdict_columns(taken)}
    ranked = [
        name
        for name in ("run", "body", "agreement", "E_n", "measured", "law", "role", "slip", "load")
        if name in columns
    ]
    shown = chosen_columns({name: columns[name] for name in ranked}, list(columns))
    table("", [one.heading for one in shown], rows_of(shown), spaced=False)
    if len(taken) < len(rows):
        print_result(f"and {len(rows) - len(taken)} more")
    for run_id in law.outliers:
        print_result(f'{run_id}: outlier; to exclude it: `tribopipe mark-bad {run_id} --reason "…"`')


def _verdict_columns(rows: Sequence[_Row]) -> Iterator[Cells]:
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
    """Return measured and predicted values in one unit, or each with its own unit if the quantities differ."""
    pairs = [(row.body.measured, row.body.predicted) for row in rows]
    units = {_UNITS.get(row.body.measured.unit, row.body.measured.unit) for row in rows}
    for at, head in enumerate(("measured", "model")):
        name = "measured" if at == 0 else "law"
        if len(units) > 1:
            yield Cells(name, head, [pair[at].shown(_UNITS.get(pair[at].unit)) for pair in pairs])
            continue
        unit = next(iter(units))
        power = power_for([number(one, unit) for pair in pairs for one in pair])
        cells = in_power([number(pair[at], unit) for pair in pairs], power)
        yield Cells(name, f"{head}, {cells.unit(pretty(unit))}", cells.cells)


_UNITS = {"m": "um", "m^3": "mm^3"}
