"""One study on a page: k_D under each law, a verdict for each run, and what else is said of them."""

from collections.abc import Iterator, Sequence

from tribopipe.archive.store import Archive
from tribopipe.base.units import WEAR_COEFFICIENT
from tribopipe.documents.quantity import Quantity
from tribopipe.physics.laws import law_heading, law_title
from tribopipe.results.agreement import BetweenRuns, EndOfLife, LawResult, RunVerdict, StudyResult
from tribopipe.results.disc_agreement import (
    RotationsToDepth,
    StudiedDisc,
    TwinDiscLawResult,
    TwinDiscStudyResult,
    TwinDiscVerdict,
)
from tribopipe.results.wear_fit import by, spoken
from tribopipe.version import VERSION
from tribopipe.views.labeled_values import NOTHING, bare, interval, shown
from tribopipe.views.page import LawPage, StudyPage, TextTable, VerdictLine

_COLUMNS = (
    *("run", "role", "load", "measured, µm", "by the law, µm", "95 % interval", "E_n", "along"),
    *("k_D / study's", "verdict"),
)
_DISC_COLUMNS = (
    *("run", "role", "slip", "rotations", "disc", "measured", "by the law", "95 % interval", "E_n"),
    *("k_D / study's", "verdict"),
)
Result = StudyResult | TwinDiscStudyResult


def study_page(archive: Archive, study_id: str) -> StudyPage:
    """Return what the archive holds of a study, but its curves.

    Raises ``ArchiveError`` where there is no such study, or its file is damaged.
    """
    stored = archive.study_outline(study_id)
    return study_page_of(stored.result, stored.program_version, stored.date, stored.inputs_sha256)


def study_page_of(result: Result, program_version: str = VERSION, date: str = "", inputs_sha256: str = "") -> StudyPage:
    """Return what a study has found; date and fingerprint are empty of one that is not archived."""
    runs: Sequence[RunVerdict | TwinDiscVerdict] = result.laws[0].runs if result.laws else ()
    return StudyPage(
        id=result.id,
        title=result.title or result.id,
        fitted=tuple(run.id for run in runs if run.role == "fitted"),
        predicted=tuple(run.id for run in runs if run.role == "predicted"),
        laws=tuple(_law(law) if isinstance(law, LawResult) else _disc_law(law) for law in result.laws),
        sentences=tuple(_sentences(result)),
        program_version=program_version,
        date=date,
        inputs_sha256=inputs_sha256,
    )


def _sentences(result: Result) -> Iterator[str]:
    for run_id, comparison in result.comparisons.items() if isinstance(result, StudyResult) else ():
        better = law_title(comparison.preferred) if comparison.preferred else "neither law"
        yield f"{run_id}: its shape prefers {better} (AIC of Sarkar's minus Archard's {comparison.delta_aic:+.1f})"
    for left_out in result.left_out:
        yield f"left out: {left_out.id} ({left_out.reason})"
    for note in result.notes:
        yield f"note: {note}"


def _law(law: LawResult) -> LawPage:
    found = f"k_D = {_with_interval(law)}"
    return LawPage(
        model=law.model,
        heading=law_heading(law.model),
        title=f"{law_heading(law.model)}{by(law.engine)}: {found}",
        tables=tuple(table for table in (_verdicts(law), _shapes(law), _engines(law)) if table.rows),
        sentences=(*_scatter("k_D", law.between_runs), *_lives(law)),
        verdicts=tuple(map(_verdict_line, law.runs)),
    )


def _with_interval(found: LawResult | StudiedDisc) -> str:
    ends = interval(found.interval, WEAR_COEFFICIENT)
    return f"{found.wear_coefficient.shown(WEAR_COEFFICIENT)}, 95 % interval {ends}"


def _verdict_line(verdict: RunVerdict | TwinDiscVerdict) -> VerdictLine:
    findings = verdict.findings if isinstance(verdict, RunVerdict) else ()
    warnings = (f"warning: {one}" for one in findings if one.severity == "warning")
    return VerdictLine(verdict.id, verdict.role, verdict.outcome, verdict.sentence, (*warnings, *verdict.notes))


def _scatter(what: str, between: BetweenRuns | None) -> Iterator[str]:
    if between is None:
        return
    yield (
        f"scatter of {what} between the {between.runs} runs {between.scatter:.1%}, within a run {between.within:.1%}; "
        f"probability of so much disagreement under one k_D {between.p_value:.2g}"
    )
    for run_id in between.outliers:
        yield f'{run_id}: outlier; `tribopipe mark-bad {run_id} --reason "…"` would leave it out'


def _lives(law: LawResult | TwinDiscLawResult) -> Iterator[str]:
    for verdict in law.runs:
        life = verdict.end_of_life
        if life is not None:
            reached, place, unit = _end(life)
            ends = interval(life.interval, unit)
            yield f"{verdict.id}: {reached} {life.wear_depth.shown('um')} {place} (95 % interval {ends})"


def _end(life: EndOfLife | RotationsToDepth) -> tuple[str, str, str]:
    """Say what reaches the wanted depth and where, and the unit that is counted in."""
    if isinstance(life, EndOfLife):
        return "reaches", f"at {life.sliding_distance.shown('m')}", "m"
    return "its curved disc reaches", f"after {life.rotations} rotations", "1"


def _verdicts(law: LawResult) -> TextTable:
    return TextTable("verdict on each run", _COLUMNS, tuple(map(_verdict_row, law.runs)))


def _verdict_row(verdict: RunVerdict) -> tuple[str, ...]:
    return (
        verdict.id,
        verdict.role,
        shown(verdict.normal_load) or NOTHING,
        bare(verdict.measured_depth, "um"),
        bare(verdict.predicted_depth, "um"),
        _bare_interval(verdict.predicted_interval, "um"),
        f"{verdict.e_n:+.2f}",
        f"{verdict.e_n_curve:+.2f}",
        str(verdict.coefficient_ratio),
        verdict.outcome,
    )


def _bare_interval(ends: tuple[Quantity, Quantity], unit: str) -> str:
    return " to ".join(bare(end, unit) for end in ends)


def _shapes(law: LawResult) -> TextTable:
    """Return how the shape of each wear curve keeps to the law."""
    columns = (
        "run",
        "exponent n of h ∝ sⁿ",
        "by the law",
        "residual trend",
        "rate may change at",
        "k_D after / before",
    )
    return TextTable("shape of each wear curve", columns, tuple(row for run in law.runs for row in _shape_row(run)))


def _shape_row(verdict: RunVerdict) -> Iterator[tuple[str, ...]]:
    exponent, trend, change = verdict.exponent, verdict.trend, verdict.change_point
    if exponent is None and trend is None and change is None:
        return
    yield (
        verdict.id,
        *((NOTHING, NOTHING) if exponent is None else (str(exponent.measured), f"{exponent.by_law:.3f}")),
        NOTHING if trend is None else f"{shown(trend.amplitude)}, p = {trend.p_value:.2g}",
        *(
            (NOTHING, NOTHING)
            if change is None
            else (change.sliding_distance.shown("m"), f"{change.rate_ratio:.2f}, p = {change.p_value:.2g}")
        ),
    )


def _engines(law: LawResult) -> TextTable:
    """Return k_D of the runs that were also fitted with local pressure."""
    rows = [
        (
            run.id,
            run.engines.giwm.shown(WEAR_COEFFICIENT),
            run.engines.local.shown(WEAR_COEFFICIENT),
            run.engines.trusted or NOTHING,
        )
        for run in law.runs
        if run.engines is not None
    ]
    return TextTable("k_D by even and by local pressure", ("run", "even (GIWM)", "local", "trusted"), tuple(rows))


def _disc_law(law: TwinDiscLawResult) -> LawPage:
    found = "; ".join(f"{spoken(disc.disc)} k_D = {_with_interval(disc)}" for disc in law.discs)
    rows = tuple(row for verdict in law.runs for row in _disc_rows(verdict))
    scatter = (said for disc in law.discs for said in _scatter(f"k_D of the {spoken(disc.disc)}", disc.between_runs))
    return LawPage(
        model=law.model,
        heading=law_heading(law.model),
        title=f"{law_heading(law.model)}, {law.distance_per_rotation}: {found}",
        tables=(TextTable("verdict on each run", _DISC_COLUMNS, rows),),
        sentences=(*scatter, *_lives(law)),
        verdicts=tuple(map(_verdict_line, law.runs)),
    )


def _disc_rows(verdict: TwinDiscVerdict) -> Iterator[tuple[str, ...]]:
    """Return a row for each disc; what belongs to the run stands in the first."""
    run = (verdict.id, verdict.role, verdict.slip.shown("%"), f"{verdict.rotations.value:,.0f}")
    for number, disc in enumerate(verdict.discs):
        unit = "mm^3" if disc.what == "wear_volume" else "um"
        yield (
            *(run if number == 0 else [""] * len(run)),
            spoken(disc.disc).removesuffix(" disc"),
            disc.measured.shown(unit),
            disc.predicted.shown(unit),
            _bare_interval(disc.predicted_interval, unit),
            f"{disc.e_n:+.2f}",
            str(disc.coefficient_ratio),
            disc.outcome,
        )
