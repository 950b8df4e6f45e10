"""Page of one study: k_D under each law, and the agreement of each run with it."""

from collections.abc import Iterator
from itertools import chain

from tribopipe.archive.store import Archive
from tribopipe.base.units import WEAR_COEFFICIENT, pretty, signed
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import between
from tribopipe.physics.laws import law_heading, law_label, law_title
from tribopipe.results.study import (
    AGREEMENT,
    BetweenRuns,
    BodyVerdict,
    LawComparison,
    LawResult,
    RunVerdict,
    StudiedBody,
    StudyResult,
)
from tribopipe.results.wear_fit import by
from tribopipe.version import VERSION
from tribopipe.views.page import (
    NOTHING,
    AgreementLine,
    LawPage,
    StudyPage,
    TextTable,
    bare,
    interval,
    probability,
    shown,
)


def study_page(archive: Archive, study_id: str) -> StudyPage:
    """Return the archived results of a study, without its curves.

    Raises ``ArchiveError`` if there is no such study, or its file is damaged.
    """
    stored = archive.study_outline(study_id)
    return study_page_of(stored.result, stored.program_version, stored.date, stored.inputs_sha256)


def study_page_of(
    result: StudyResult, program_version: str = VERSION, date: str = "", inputs_sha256: str = ""
) -> StudyPage:
    """Return the results of a study; date and fingerprint are empty if it is not archived."""
    runs = result.laws[0].runs if result.laws else ()
    return StudyPage(
        id=result.id,
        title=result.title or result.id,
        fitted=tuple(run.id for run in runs if run.role == "fitted"),
        predicted=tuple(run.id for run in runs if run.role == "predicted"),
        laws=tuple(map(_law, result.laws)),
        sentences=tuple(_sentences(result)),
        program_version=program_version,
        date=date,
        inputs_sha256=inputs_sha256,
    )


def _sentences(result: StudyResult) -> Iterator[str]:
    for run_id, comparison in result.comparisons.items():
        yield f"{run_id}: {_compared(comparison)}"
        for law in result.laws:
            if law.model not in comparison.delta_aic:
                yield (
                    f"{run_id}: {law_title(law.model)} is not compared, since its parameters cannot be determined "
                    "from the run"
                )
    for left_out in result.left_out:
        yield f"excluded: {left_out.id} ({left_out.reason})"
    for note in result.notes:
        yield f"note: {note}"


def _compared(comparison: LawComparison) -> str:
    """State which law AIC favors, or between which it does not discriminate."""
    ordered = sorted(comparison.delta_aic.items(), key=lambda one: one[1])
    differences = ", ".join(f"{law_label(law)} {delta:.1f}" for law, delta in ordered)
    alike = max(2, sum(delta < 2 for _, delta in ordered))
    found = (
        f"favors {law_title(comparison.preferred)}"
        if comparison.preferred
        else f"does not discriminate between {' and '.join(law_title(law) for law, _ in ordered[:alike])}"
    )
    return f"AIC {found} (AIC minus the lowest: {differences})"


def _law(law: LawResult) -> LawPage:
    counted = "" if law.distance_per_rotation is None else f", {law.distance_per_rotation}"
    found = "; ".join(f"{spoken(name)} k_D = {_with_interval(body)}" for name, body in law.bodies.items())
    scatter = (
        said for name, body in law.bodies.items() for said in _scatter(f"k_D of the {spoken(name)}", body.between_runs)
    )
    return LawPage(
        model=law.model,
        heading=law_heading(law.model),
        title=f"{law_heading(law.model)}{by(law.engine)}{counted}: {found}",
        tables=tuple(table for table in (_verdicts(law), _shapes(law), _engines(law)) if table.rows),
        sentences=(*scatter, *_exponent(law), *_lives(law)),
        agreement=tuple(map(_agreement_line, law.runs)),
    )


def _with_interval(found: StudiedBody) -> str:
    ends = interval(found.interval, WEAR_COEFFICIENT)
    return f"{found.wear_coefficient.shown(WEAR_COEFFICIENT)}, 95 % CI: {ends}"


def _agreement_line(verdict: RunVerdict) -> AgreementLine:
    warnings = (
        f"warning: {one.remedy if one.message in verdict.sentence else one}"
        for one in verdict.findings
        if one.severity == "warning"
    )
    agreement, notes = AGREEMENT[verdict.outcome], (*warnings, *verdict.notes)
    return AgreementLine(verdict.id, verdict.role, agreement, verdict.sentence, notes)


def _scatter(what: str, between: BetweenRuns | None) -> Iterator[str]:
    if between is None:
        return
    yield (
        f"between-run scatter of {what} ({between.runs} runs): {100 * between.scatter:.1f} %; "
        f"within a run: {100 * between.within:.1f} %; test for a common k_D: p = {probability(between.p_value)}"
    )
    for run_id in between.outliers:
        yield f'{run_id}: outlier; to exclude it: `tribopipe mark-bad {run_id} --reason "…"`'


def _exponent(law: LawResult) -> Iterator[str]:
    found = law.pressure_exponent
    if found is None:
        return
    low, high = (end.value for end in found.interval)
    agrees = (
        "consistent with m = 1, which the law assumes" if low <= 1 <= high else "k_D depends on the contact pressure"
    )
    yield (
        f"wear rate of the {spoken(next(iter(law.bodies)))} ∝ p^m ({found.runs} runs): m = {found.exponent}, "
        f"95 % CI: {interval(found.interval, '1')}; {agrees}"
    )


def _lives(law: LawResult) -> Iterator[str]:
    for verdict in law.runs:
        life = verdict.end_of_life
        if life is not None:
            first, unit = spoken(next(iter(verdict.bodies))), life.place.unit
            place = f"after {life.place} rotations" if unit == "1" else f"at {life.place.shown(unit)}"
            ends = interval(life.interval, unit)
            reached = f"the {first} reaches a wear depth of {life.wear_depth.shown('um')} {place}"
            yield f"{verdict.id}: {reached} (95 % CI: {ends})"


def _verdicts(law: LawResult) -> TextTable:
    """Return a row for each body of each run; the cells of the run itself are in its first row."""
    units = {_unit(body) for run in law.runs for body in run.bodies.values()}
    unit = units.pop() if len(units) == 1 else None
    rows = [
        dict(chain(_of_run(run) if number == 0 else (), named, _of_body(body, unit)))
        for run in law.runs
        for number, (name, body) in enumerate(run.bodies.items())
        for named in [[("body", spoken(name))] if len(law.bodies) > 1 else []]
    ]
    return TextTable.of_rows("agreement of each run with the model", rows, "")


def _unit(body: BodyVerdict) -> str:
    return "mm^3" if body.what == "wear_volume" else "um"


def _of_run(verdict: RunVerdict) -> Iterator[tuple[str, str]]:
    """Yield the cells of a run, each with its column header."""
    yield "run", verdict.id
    yield "role", verdict.role
    yield "load", shown(verdict.normal_load) or NOTHING
    if verdict.slip is not None:
        yield "slip", verdict.slip.shown("%")
    if verdict.end.unit == "1":
        yield "rotations", f"{verdict.end.value:,.0f}"


def _of_body(body: BodyVerdict, unit: str | None) -> Iterator[tuple[str, str]]:
    """Yield the cells of a body with their column headers, which include the unit if all bodies have the same."""
    shown_in, end = (_unit(body), "") if unit is None else (unit, f", {pretty(unit)}")
    measured, by_law = (
        one.shown(shown_in) if unit is None else bare(one, unit) for one in (body.measured, body.predicted)
    )
    yield f"measured{end}", measured
    yield f"model{end}", by_law
    yield "95 % CI", between(body.predicted_interval, shown_in).removesuffix(f" {pretty(shown_in)}")
    yield "E_n", signed(body.e_n, 2)
    yield "E_n, curve", signed(body.e_n_all, 2)
    yield "k_D / study k_D", str(body.coefficient_ratio)
    yield "agreement", AGREEMENT[body.outcome]


def _shapes(law: LawResult) -> TextTable:
    """Return a table that compares the shape of each wear curve with the law."""
    columns = (
        "run",
        "measured exponent n of h ∝ sⁿ",
        "exponent predicted by the law",
        "residual trend",
        "distance at a possible change in wear rate",
        "k_D after / before the change",
    )
    return TextTable("shape of each wear curve", columns, tuple(row for run in law.runs for row in _shape_row(run)))


def _shape_row(verdict: RunVerdict) -> Iterator[tuple[str, ...]]:
    for body in verdict.bodies.values():
        exponent, trend, change = body.exponent, body.trend, body.change_point
        if exponent is None and trend is None and change is None:
            continue
        yield (
            verdict.id,
            *((NOTHING, NOTHING) if exponent is None else (str(exponent.measured), f"{exponent.by_law:.3f}")),
            NOTHING if trend is None else f"{shown(trend.amplitude)}, p = {probability(trend.p_value)}",
            *(
                (NOTHING, NOTHING)
                if change is None
                else (change.sliding_distance.shown("m"), f"{change.rate_ratio:.2f}, p = {probability(change.p_value)}")
            ),
        )


def _engines(law: LawResult) -> TextTable:
    """Return a table of k_D of the runs that were also fitted with local contact pressure."""
    rows = [
        (
            run.id,
            body.engines.giwm.shown(WEAR_COEFFICIENT),
            body.engines.local.shown(WEAR_COEFFICIENT),
            body.engines.trusted or NOTHING,
        )
        for run in law.runs
        for body in run.bodies.values()
        if body.engines is not None
    ]
    return TextTable(
        "k_D with uniform and with local contact pressure",
        ("run", "uniform (GIWM)", "local", "recommended"),
        tuple(rows),
    )
