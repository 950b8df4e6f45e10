"""Reports of runs and of a study: one HTML document that holds all it shows, and neither runs nor loads anything."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from markupsafe import Markup

from tribopipe.archive.outline import RunOutline
from tribopipe.archive.steps import LOCAL_WEAR, PREDICTIONS, WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.results.agreement import StudyResult
from tribopipe.views.archived_figures import run_figures
from tribopipe.views.archived_study_figures import study_figures
from tribopipe.views.astm_g99 import ReportingItem, reporting_items
from tribopipe.views.html.captions import RUN_CAPTIONS, study_caption
from tribopipe.views.html.merging import Merged, Stated, merged
from tribopipe.views.html.options import options_used
from tribopipe.views.html.particulars import NOBODY, Addressed
from tribopipe.views.html.rendering import rendered
from tribopipe.views.html.svg import inline_svg
from tribopipe.views.html.tested import conditions, tested
from tribopipe.views.methods import PAPER, Evidence, methods_used, references_of
from tribopipe.views.page import RunPage, StudyPage
from tribopipe.views.run_page import run_page
from tribopipe.views.study_page import study_page

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class _FigureCard(NamedTuple):
    """A figure with its number and caption."""

    number: int
    caption: str
    svg: Markup
    width: float
    """Inches."""


@dataclass(frozen=True)
class _RunCard:
    """All that is shown of one run."""

    page: RunPage
    outline: RunOutline
    reporting: list[ReportingItem]
    figures: tuple[_FigureCard, ...] = ()

    @property
    def facts(self) -> list[Merged]:
        """What run.toml states, as in a table of several runs."""
        return merged({self.page.id: _facts(self.page)})

    @property
    def conditions(self) -> str:
        """Its load; slip and rotations too of two discs."""
        return conditions(self.outline)


class _Check(NamedTuple):
    """One item that a report customarily states, by all runs."""

    merged: Merged
    item: ReportingItem
    """One of the runs', one without it if there is any."""


GoOn: TypeAlias = Callable[[], object]


def _go_on() -> None: ...


def run_report(archive: Archive, ids: Sequence[str], go_on: GoOn = _go_on, addressed: Addressed = NOBODY) -> str:
    """Return a report of runs as one HTML document, the same for the same content of the archive.

    ``addressed`` holds the particulars of the report. ``go_on`` is called before each figure; whatever it raises ends
    the work.
    Raises ``ArchiveError`` where a run is not in the archive, or its file is damaged.
    """
    numbers = count(1)
    runs = [_run_card(archive, run_id, numbers, go_on) for run_id in dict.fromkeys(ids)]
    title = runs[0].page.title if len(runs) == 1 else f"{len(runs)} runs"
    return _report("runs.html", title, runs, addressed)


def study_report(archive: Archive, study_id: str, go_on: GoOn = _go_on, addressed: Addressed = NOBODY) -> str:
    """Return a report of a study as one HTML document; the same archive gives the same document.

    ``addressed`` holds the particulars of the report. ``go_on`` is called before each figure; whatever it raises ends
    the work.
    Raises ``ArchiveError`` where the study or one of its runs is not in the archive, or its file is damaged.
    """
    page, stored = study_page(archive, study_id), archive.study_outline(study_id)
    figures = study_figures(archive, study_id)
    discs = any(law.distance_per_rotation is not None for law in stored.result.laws)
    captions = {what: study_caption(what, discs=discs) for what in figures}
    runs = [_study_run(archive, run_id, stored.result) for run_id in (*page.fitted, *page.predicted)]
    return _report(
        "study.html",
        page.title,
        runs,
        addressed,
        study=page,
        result=stored.result,
        options={"study": stored.options},
        figures=list(_cards(figures, captions, page.id, count(1), go_on)),
        facts=merged({run.page.id: _facts(run.page) for run in runs}),
    )


def _run_card(archive: Archive, run_id: str, numbers: Iterator[int], go_on: GoOn) -> _RunCard:
    page, outline = run_page(archive, run_id), archive.outline(run_id)
    figures = _cards(run_figures(archive, run_id), RUN_CAPTIONS, run_id, numbers, go_on)
    return _RunCard(page, outline, reporting_items(archive, run_id), tuple(figures))


def _study_run(archive: Archive, run_id: str, result: StudyResult) -> _RunCard:
    """Return a run with what the study stands on: of its wear fits those under the study's laws, no predictions."""
    page, outline = run_page(archive, run_id), archive.outline(run_id)
    others = {*PREDICTIONS.values(), *LOCAL_WEAR.values(), *WEAR_FITS.values()}
    others -= {WEAR_FITS[law.model] for law in result.laws}
    return _RunCard(
        replace(page, stages=tuple(stage for stage in page.stages if stage.name not in others)),
        replace(outline, steps={name: step for name, step in outline.steps.items() if name not in others}),
        reporting_items(archive, run_id, _replicates(result)),
    )


def _replicates(result: StudyResult) -> str | None:
    """Report how many runs identify k_D and how they scatter; nothing where it is one."""
    law = result.laws[0]
    found = [body.between_runs for body in law.bodies.values()]
    scatter = [f"{100 * one.scatter:.2g} %" for one in found if one is not None]
    runs = sum(run.role == "fitted" for run in law.runs)
    return f"{runs} runs, between which k_D scatters by {' and '.join(scatter)}" if scatter else None


def _facts(page: RunPage) -> Iterator[Stated]:
    return (Stated(group.title, fact.name, fact.value) for group in page.facts for fact in group.facts)


def _cards(
    figures: "Mapping[str, Figure]", captions: Mapping[str, str], name: str, numbers: Iterator[int], go_on: GoOn
) -> Iterator[_FigureCard]:
    for what, figure in figures.items():
        go_on()
        number = next(numbers)
        svg = inline_svg(figure, f"figure-{number}", f"{name}: {captions[what]}")
        yield _FigureCard(number, captions[what], svg, float(figure.get_figwidth()))


def _report(
    template: str,
    title: str,
    runs: Sequence[_RunCard],
    addressed: Addressed,
    *,
    study: StudyPage | None = None,
    result: StudyResult | None = None,
    options: Mapping[str, Mapping[str, Any]] | None = None,
    **shown: Any,
) -> str:
    """Fill a template with what both reports show, and what is shown in addition."""
    results = [step.result for run in runs for step in run.outline.steps.values()]
    methods = methods_used(Evidence([run.outline.manifest for run in runs], results, result))
    outlines, details = [run.outline for run in runs], addressed.details
    return rendered(
        template,
        title=(details and details.title) or title,
        details=details,
        logo=addressed.logo_address,
        page_label=addressed.page_label,
        internal=not addressed.for_customer,
        particulars=addressed.particulars(outlines),
        standard=addressed.standard_of([run.manifest for run in outlines]),
        study=study,
        runs=runs,
        tested=tested(outlines),
        methods=methods,
        references=references_of(methods),
        paper=PAPER,
        checks=_checks(runs),
        options=options_used({**_told(runs), **(options or {})}),
        **shown,
    )


def _told(runs: Sequence[_RunCard]) -> dict[str, Mapping[str, Any]]:
    """Return what each step of each run was given, by run and step."""
    return {f"{run.page.id}, {stage.title}": stage.options for run in runs for stage in run.page.stages}


def _checks(runs: Sequence[_RunCard]) -> list[_Check]:
    """Return the customary items of reports, with the values that the runs state."""
    stated = {run.page.id: [Stated(one.subject, one.name, one.value) for one in run.reporting] for run in runs}
    everything = sorted((one for run in runs for one in run.reporting), key=_is_missing)
    items = {(one.subject, one.name): one for one in everything}
    return [_Check(one, items[one.subject, one.name]) for one in merged(stated)]


def _is_missing(item: ReportingItem) -> bool:
    return item.value is None
