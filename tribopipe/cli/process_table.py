"""What `process` shows at the end: a row per run, a row per study, and a summary of problems."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from tribopipe.base.column_formatting import NOTHING, Number, in_power, power_for, rounded_value
from tribopipe.base.errors import counted
from tribopipe.base.units import SPECIFIC_WEAR_RATE, WEAR_COEFFICIENT, pretty
from tribopipe.cli.listing import Cells, chosen_columns, rows_of
from tribopipe.cli.output import line_width, print_result, say, table
from tribopipe.cli.overview import Problems, by_kind, number, short_lines, shortened
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.physics.laws import law_heading, law_label
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.finding import Finding, findings_of
from tribopipe.results.specific_wear import SpecificWear
from tribopipe.results.study import AGREEMENT, tally
from tribopipe.results.wear_fit import fits_of

if TYPE_CHECKING:
    from tribopipe.archive.outline import RunOutline
    from tribopipe.archive.store import Archive
    from tribopipe.documents.quantity import Quantity
    from tribopipe.physics.calculation_methods import WearEngine
    from tribopipe.results.study import LawResult, StudyResult

_LINES = 30
"""Number of lines to fill on a terminal."""
_FEWEST_RUNS, _STUDIES, _PROBLEMS = 5, 5, 3
"""Smallest number of runs, and largest numbers of studies and problems, shown on a terminal."""
_ENGINES: "Mapping[WearEngine | None, str]" = {None: NOTHING, "giwm": "GIWM", "volume": "volume", "local": "local"}
UNCOMPARED = {"radius_unchecked"}
"""Codes of notes on inputs that affect k_D and cannot be checked against other data of the run."""


class RunRow(NamedTuple):
    """One run in one line."""

    id: str
    load: "Quantity | None"
    law: str
    """Name of the wear law of k_D; empty if there is none."""
    engine: "WearEngine | None"
    """Engine that k_D was found by."""
    coefficients: "Mapping[str, Quantity]"
    """k_D of each body."""
    convention: str | None
    """Sliding distance per rotation that k_D of two discs is based on; None for other contacts."""
    named: tuple[str, ...]
    """Bodies whose k_D is shown by name; none if only the first body has one."""
    rate: "Quantity | None"
    """Specific wear rate, of a run without k_D."""
    friction: "Quantity | None"
    agreement: str
    flags: str
    missing: tuple[str, ...]
    """Why there is no k_D."""
    problems: tuple[Finding, ...]


def run_row(outline: "RunOutline", studies: "Sequence[StudyResult]", failed: Iterable[str] = ()) -> RunRow:
    """Return the row of a run."""
    results = {name: step.result for name, step in outline.steps.items()}
    fits = list(fits_of(results.values()))
    fit = next((one for one in fits if one.bodies), None)
    friction, cleaned, contact = results.get("friction_fit"), results.get("clean_up"), outline.manifest.contact
    problems = tuple(
        one
        for one in (*outline.findings, *findings_of(results.values()))
        if one.severity != "note" or one.code in UNCOMPARED
    )
    warned = sum(one.severity != "note" for one in problems)
    flags = (
        "failed" if outline.manifest.id in failed else "",
        "bad" if outline.marks and outline.marks[-1].kind == "bad" else "",
        counted(warned, "warning") if warned else "",
        "preprocessed" if isinstance(cleaned, CleanUp) and cleaned.changes else "",
    )
    return RunRow(
        outline.manifest.id,
        outline.manifest.conditions.normal_load,
        "" if fit is None else fit.model,
        None if fit is None else fit.engine,
        {} if fit is None else {name: body.wear_coefficient for name, body in fit.bodies.items()},
        None if fit is None else fit.distance_per_rotation,
        () if fit is None or contact is None or [*fit.bodies] == [*contact.body_names[:1]] else tuple(fit.bodies),
        _rate(results.get("specific_wear")) if fit is None else None,
        (friction.steady_state or friction.mean) if isinstance(friction, FrictionFit) else None,
        _agreement(outline.manifest.id, "" if fit is None else fit.model, studies),
        ", ".join(filter(None, flags)),
        fits[0].missing if fits and fit is None else (),
        problems,
    )


def _rate(wear: object) -> "Quantity | None":
    """Return the specific wear rate of the first body that has one."""
    rates = (body.specific_wear_rate for body in wear.bodies.values()) if isinstance(wear, SpecificWear) else iter(())
    return next((rate for rate in rates if rate is not None), None)


def _agreement(run_id: str, law: str, studies: "Sequence[StudyResult]") -> str:
    """Return the agreement of a run with the law recommended for it, from the first study that includes both."""
    for study in studies:
        for result in study.laws:
            for verdict in result.runs:
                if result.model == law and run_id in result.outliers:
                    return "outlier"
                if result.model == law and verdict.id == run_id:
                    fitted = verdict.role == "fitted" and verdict.outcome == "supported"
                    return "fitted" if fitted else AGREEMENT[verdict.outcome]
    return ""


def show_processed(
    archive: "Archive", ids: Sequence[str], studies: "Sequence[StudyResult]", failed: Iterable[str] = ()
) -> list[RunRow]:
    """Show runs and studies, and return the line of each run."""
    rows = [run_row(archive.outline(run_id), studies, failed) for run_id in ids]
    families: dict[tuple[str, ...], list[RunRow]] = {}
    for row in rows:
        families.setdefault(row.named, []).append(row)
    shown_studies = studies if line_width() is None else studies[:_STUDIES]
    power = power_for([*_all_coefficients(rows), *(_number(one) for study in studies for one in _of_study(study))])
    captions = _captions(rows, power)
    differ = len({row.engine for row in rows} - {None}) > 1
    room = _room(len(families), studies, len(_problems(rows)) + len(_missing(rows)), len(captions))
    print_result("\n".join(captions))
    for place, (family, members) in enumerate(families.items()):
        taken, room = members if room is None else members[:room], None if room is None else room - len(members)
        if taken and place:
            print_result("")
        if taken:
            _show_family(family, taken, power, engines=differ)
    if room is not None and room < 0:
        print_result(f"and {-room} more: `tribopipe ls --all`")
    if shown_studies:
        print_result("")
        _show_studies(shown_studies, power)
    if len(shown_studies) < len(studies):
        print_result(f"and {len(studies) - len(shown_studies)} more: `tribopipe study show`")
    return rows


def _room(families: int, studies: "Sequence[StudyResult]", problems: int, captions: int) -> int | None:
    """Return the number of runs that fit on a terminal; None if there is no limit."""
    if line_width() is None:
        return None
    others = (3 + min(len(studies), _STUDIES + 1) if studies else 0) + min(problems, _PROBLEMS)
    blank_and_summary, heads = 2, 3 * families - 1
    return max(_FEWEST_RUNS, _LINES - captions - blank_and_summary - heads - others)


def _captions(rows: Sequence[RunRow], power: int | None) -> list[str]:
    """Return what is above the tables; conventions are named, since k_D differs by orders of magnitude between them."""
    conventions = " or ".join(sorted({row.convention for row in rows if row.convention is not None}))
    discs = f"k_D of twin discs: {conventions} convention for the sliding distance"
    return [_caption(rows, power), *([discs] if conventions else [])]


def _caption(rows: Sequence[RunRow], power: int | None) -> str:
    laws = {row.law for row in rows if row.law}
    count = counted(len(rows), "run")
    if not laws:
        return count
    law = f" from {law_heading(laws.pop())}" if len(laws) == 1 else ""
    unit = in_power([], power).unit(pretty(WEAR_COEFFICIENT))
    return f"{count}; k_D{law} in {unit}, ± is one standard uncertainty"


def _all_coefficients(rows: Sequence[RunRow]) -> "list[Number | None]":
    return [_number(one) for row in rows for one in row.coefficients.values()]


def _number(quantity: "Quantity | None", unit: str = WEAR_COEFFICIENT) -> Number | None:
    return None if quantity is None else number(quantity, unit)


def _show_family(bodies: tuple[str, ...], rows: Sequence[RunRow], power: int | None, *, engines: bool) -> None:
    """Show runs with k_D of the same bodies, and by which engine if not all runs have the same."""
    first, *others = (
        in_power([_number(row.coefficients.get(name)) for row in rows], power).cells for name in bodies or ("",)
    )
    if not bodies:
        first = in_power([_number(next(iter(row.coefficients.values()), None)) for row in rows], power).cells
    laws = {row.law for row in rows if row.law}
    columns = [
        Cells("run", "run", [row.id for row in rows]),
        _loads(rows),
        Cells("k_d", f"k_D, {_short(bodies[0])}" if bodies else "k_D", first),
        *(Cells(name, f"k_D, {_short(name)}", cells) for name, cells in zip(bodies[1:], others, strict=True)),
        _rates(rows),
        *([Cells("law", "law", [law_label(row.law) if row.law else NOTHING for row in rows])] if len(laws) > 1 else []),
        *([Cells("engine", "engine", [_ENGINES[row.engine] for row in rows])] if engines else []),
        Cells("friction", "μ", [_rounded(row.friction) for row in rows]),
        Cells("agreement", "agreement", [row.agreement or NOTHING for row in rows]),
        Cells("flags", "flags", [row.flags for row in rows]),
    ]
    ranked = ("run", "k_d", "rate", "agreement", "load", "law", "flags", "friction", *bodies[1:], "engine")
    _show(columns, ranked)


def _short(body: str) -> str:
    """Return the short name of a body for the header of a narrow column."""
    return spoken(body).removesuffix(" disc")


def _show(columns: Sequence[Cells], ranked: Iterable[str]) -> None:
    """Show the columns that are not empty, as many as fit, in the order of their rank."""
    known = {one.name: one for one in columns if set(one.cells) - {"", NOTHING}}
    shown = chosen_columns({name: known[name] for name in ranked if name in known}, list(known))
    table("", [one.heading for one in shown], rows_of(shown), spaced=False)


def _loads(rows: Sequence[RunRow]) -> Cells:
    """Return loads in one unit: in N if none is below 1 N."""
    known = [row.load.value for row in rows if row.load is not None]
    unit = "N" if known and min(known) >= 1 else "mN"
    return Cells("load", f"load, {unit}", [_rounded(row.load, unit) for row in rows])


def _rates(rows: Sequence[RunRow]) -> Cells:
    """Return specific wear rates of runs without k_D, with their own power of ten."""
    numbers = [_number(row.rate, SPECIFIC_WEAR_RATE) for row in rows]
    cells = in_power(numbers, power_for(numbers))
    return Cells("rate", f"wear rate, {cells.unit(pretty(SPECIFIC_WEAR_RATE))}", cells.cells)


def _rounded(quantity: "Quantity | None", unit: str = "1") -> str:
    found = _number(quantity, unit)
    return NOTHING if found is None else rounded_value(found)


def _of_study(study: "StudyResult") -> "Iterator[Quantity]":
    if study.laws:
        yield from (body.wear_coefficient for body in study.laws[0].bodies.values())


def _show_studies(studies: "Sequence[StudyResult]", power: int | None) -> None:
    """Show a row for each study, with its first law."""
    laws: list[LawResult | None] = [study.laws[0] if study.laws else None for study in studies]
    bodies = max(len(law.bodies) if law else 0 for law in laws)
    known = [list(_of_study(study)) for study in studies]
    coefficients = [
        in_power([_number(one[at] if at < len(one) else None) for one in known], power).cells for at in range(bodies)
    ]
    columns = [
        Cells("study", "study", [study.id for study in studies]),
        *([Cells("law", "law", [law_label(law.model) if law else "" for law in laws])]
          if len({law.model for law in laws if law}) > 1 else []),
        *(Cells(f"k_d {at}", "k_D" if at == 0 else "k_D, 2nd body", cells) for at, cells in enumerate(coefficients)),
        Cells("agreement", "agreement of predicted runs", [tally(law) or NOTHING if law else NOTHING for law in laws]),
    ]  # fmt: skip
    _show(columns, ("study", "k_d 0", "agreement", "law", *(f"k_d {at}" for at in range(1, bodies))))


def _problems(rows: Sequence[RunRow]) -> Problems:
    return by_kind((row.id, finding) for row in rows for finding in row.problems)


def _missing(rows: Sequence[RunRow]) -> dict[str, list[str]]:
    """Return the runs without k_D, by what is missing."""
    missing: dict[str, list[str]] = {}
    for row in rows:
        if row.missing:
            missing.setdefault(" and ".join(row.missing), []).append(row.id)
    return missing


def say_problems(rows: Sequence[RunRow]) -> None:
    """Print one line per problem: the problem, and the runs that have it."""
    width = line_width(on_stderr=True)
    for what, ids in _missing(rows).items():
        say(shortened(f"no k_D, missing {what}: ", ids, width))
    for line in short_lines(_problems(rows), width, _PROBLEMS):
        say(line)
