"""Reports of runs and studies: self-contained HTML documents without scripts.

It states what was tested in a sentence, what several runs state of the same things in one table, and every option that
steps were given, with its default.
"""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from markupsafe import Markup

from tribopipe.archive.outline import RunOutline
from tribopipe.archive.step_names import LOCAL_WEAR, PREDICTIONS, WEAR_FITS
from tribopipe.archive.store import Archive
from tribopipe.base.units import show, show_force
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe
from tribopipe.results.study import StudyResult
from tribopipe.results.wear_fit import fits_of
from tribopipe.views.archived_figures import RUN_CAPTIONS, run_figures, study_caption, study_figures
from tribopipe.views.html.particulars import NOBODY, Addressed
from tribopipe.views.html.rendering import inline_svg, rendered
from tribopipe.views.methods import PAPER, Evidence, methods_used, references_of
from tribopipe.views.page import RunPage, StudyPage, TextTable
from tribopipe.views.required_report_items import ReportingItem, reporting_items
from tribopipe.views.run_page import results_table, run_page
from tribopipe.views.study_page import study_page

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Stated(NamedTuple):
    """The value of one item in a run; None if it is missing."""

    subject: str
    name: str
    value: str | None


class Merged(NamedTuple):
    """The values of one item in several runs."""

    subject: str
    name: str
    values: Mapping[str | None, tuple[str, ...]]
    """Ids of runs by value; under None, those without a value."""


def merged(by_run: Mapping[str, Iterable[Stated]]) -> list[Merged]:
    """Merge the values of runs by subject and item, in the order of first appearance."""
    found: dict[str, dict[str, dict[str | None, tuple[str, ...]]]] = {}
    for run_id, stated in by_run.items():
        for subject, name, value in stated:
            values = found.setdefault(subject, {}).setdefault(name, {})
            values[value] = (*values.get(value, ()), run_id)
    return [Merged(subject, name, values) for subject, names in found.items() for name, values in names.items()]


class Option(NamedTuple):
    """One option as it was used."""

    name: str
    """Name in a recipe: "wear.correction"."""
    value: str
    default: str | None
    """None if it is not part of a recipe, such as the reference run of a prediction."""
    where: tuple[str, ...]
    """Steps that used this value, if not all used the same."""

    @property
    def changed(self) -> bool:
        """Whether it differs from the default."""
        return self.default is not None and self.value != self.default


def options_used(told: Mapping[str, Mapping[str, Any]]) -> list[Option]:
    """Return the options of steps, by the displayed names of the steps."""
    defaults = dict(_flat(Recipe().model_dump(mode="json", by_alias=True)))
    found: dict[str, dict[str, tuple[str, ...]]] = {}
    for step, options in told.items():
        for name, value in _flat(options):
            values = found.setdefault(name, {})
            values[value] = (*values.get(value, ()), step)
    return [
        Option(name, value, defaults.get(name), steps if len(values) > 1 or name not in defaults else ())
        for name, values in found.items()
        for value, steps in values.items()
    ]


def _flat(options: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, str]]:
    for name, value in options.items():
        if isinstance(value, Mapping) and "unit" not in value:
            yield from _flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", _written(value)


def _written(value: Any) -> str:
    """Format an option as in a recipe, on one line."""
    if isinstance(value, Mapping) and "unit" in value:
        return show(value["value"], value.get("standard_uncertainty"), value["unit"])
    if isinstance(value, list) and all(isinstance(one, Mapping) for one in value):
        return "; ".join(_preprocessing_step(one) for one in value) or "none"
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "none"
    return "–" if value is None else value if isinstance(value, str) else json.dumps(value)


def _preprocessing_step(step: Mapping[str, Any]) -> str:
    """Format a step of preprocessing with its options."""
    told = ", ".join(f"{name} = {_written(value)}" for name, value in step.items() if name != "step" and value)
    return f"{step.get('step', '')}{f' ({told})' if told else ''}"


def test_sentence(runs: Sequence[RunOutline]) -> str:
    """Return a sentence on what was tested: bodies, environment, loads, sliding distances and speeds."""
    runs = sorted(runs, key=lambda run: run.manifest.conditions.normal_load.value)  # one order for all of them
    bodies = _several(" on ".join(_bodies_of(run)) for run in runs if run.manifest.bodies)
    media = _several(run.manifest.conditions.medium for run in runs if run.manifest.conditions.medium)
    loads = _several(map(load_of, runs))
    parts = [
        bodies or "unspecified bodies",
        f" in {media}" if media else "",
        f", under a load of {loads}",
        _course_of(runs),
    ]
    return "".join(parts) + "."


def conditions(run: RunOutline) -> str:
    """Return the load of a run, and for two discs also slip and rotations."""
    found = run.manifest.slip
    return load_of(run) if found is None else f"{load_of(run)}, {_slip_words(found)} slip, {_rotations(run)} rotations"


def load_of(run: RunOutline) -> str:
    """Format the nominal load of a run without its uncertainty."""
    return show_force(run.manifest.conditions.normal_load.value)


def _bodies_of(run: RunOutline) -> list[str]:
    return [f"a {spoken(name)} of {body.material}" for name, body in run.manifest.bodies.items()]


def _course_of(runs: Sequence[RunOutline]) -> str:
    """Return sliding distances and speeds of the runs."""
    slips = {run.manifest.id: found for run in runs if (found := run.manifest.slip) is not None}
    if slips:
        rolled = sorted(
            (run for run in runs if run.manifest.id in slips), key=lambda run: run.ends.get("rotations", 0.0)
        )
        turned = _several(map(_rotations, rolled))
        return f", at {_several(map(_slip_words, slips.values()))} slip, over {turned} rotations of the crowned disc"
    far = _several(show(run.ends["sliding_distance"], None, "m") for run in runs if "sliding_distance" in run.ends)
    speeds = [run.manifest.conditions.nominal_speed for run in runs]
    fast = _several(show(speed.value, None, "m/s", "mm/s") for speed in speeds if speed is not None)
    return (f", over {far}" if far else "") + (f" at {fast}" if fast else "")


def _slip_words(slip: Quantity) -> str:
    return show(slip.value, None, "1", "%")


def _rotations(run: RunOutline) -> str:
    return f"{run.ends.get('rotations', 0.0):,.0f}"


def _several(words: Iterable[str | None]) -> str:
    """Join distinct words: "a, b and c"."""
    each = [word for word in dict.fromkeys(words) if word]
    return " and ".join([", ".join(each[:-1]), each[-1]]) if len(each) > 1 else "".join(each)


class _FigureCard(NamedTuple):
    """A figure with its number and caption."""

    number: int
    caption: str
    svg: Markup
    width: float
    """Inches."""


@dataclass(frozen=True)
class _RunCard:
    """Everything that is shown of one run."""

    page: RunPage
    outline: RunOutline
    reporting: list[ReportingItem]
    figures: tuple[_FigureCard, ...] = ()

    @property
    def facts(self) -> list[Merged]:
        """Content of run.toml, for a table of several runs."""
        return merged({self.page.id: _facts(self.page)})

    @property
    def missing(self) -> str:
        """What is missing for k_D; empty if there is a k_D, or no law was fitted."""
        fits = list(fits_of(step.result for step in self.outline.steps.values()))
        return "" if any(fit.bodies for fit in fits) else " and ".join(fits[0].missing if fits else ())

    @property
    def results(self) -> TextTable:
        """Wear and k_D of each body."""
        return results_table(self.outline)

    @property
    def conditions(self) -> str:
        """Its load; for two discs also slip and rotations."""
        return conditions(self.outline)


class _Check(NamedTuple):
    """One item that is customarily reported, for all runs."""

    merged: Merged
    item: ReportingItem
    """The item of one run, preferably of a run for which it is missing."""


GoOn: TypeAlias = Callable[[], object]


def _go_on() -> None: ...


def run_report(archive: Archive, ids: Sequence[str], go_on: GoOn = _go_on, addressed: Addressed = NOBODY) -> str:
    """Return a report of runs as one HTML document; the same archive gives the same document.

    ``addressed`` contains the particulars of the report. ``go_on`` is called before each figure; an exception that it
    raises ends the work.
    Raises ``ArchiveError`` if a run is not in the archive, or its file is damaged.
    """
    numbers = count(1)
    runs = [_run_card(archive, run_id, numbers, go_on) for run_id in dict.fromkeys(ids)]
    title = runs[0].page.title if len(runs) == 1 else f"{len(runs)} runs"
    return _report("runs.html", title, runs, addressed)


def study_report(archive: Archive, study_id: str, go_on: GoOn = _go_on, addressed: Addressed = NOBODY) -> str:
    """Return a report of a study as one HTML document; the same archive gives the same document.

    ``addressed`` contains the particulars of the report. ``go_on`` is called before each figure; an exception that it
    raises ends the work.
    Raises ``ArchiveError`` if the study or one of its runs is not in the archive, or its file is damaged.
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
    """Return a run with the steps used in the study: wear fits with the study's laws only, and no predictions."""
    page, outline = run_page(archive, run_id), archive.outline(run_id)
    others = {*PREDICTIONS.values(), *LOCAL_WEAR.values(), *WEAR_FITS.values()}
    others -= {WEAR_FITS[law.model] for law in result.laws}
    return _RunCard(
        replace(page, stages=tuple(stage for stage in page.stages if stage.name not in others)),
        replace(outline, steps={name: step for name, step in outline.steps.items() if name not in others}),
        reporting_items(archive, run_id, _replicates(result)),
    )


def _replicates(result: StudyResult) -> str | None:
    """Return the number of runs that identify k_D and their scatter; None for a single run."""
    law = result.laws[0]
    found = [body.between_runs for body in law.bodies.values()]
    scatter = [f"{100 * one.scatter:.2g} %" for one in found if one is not None]
    runs = sum(run.role == "fitted" for run in law.runs)
    return f"{runs} runs; between-run scatter of k_D: {' and '.join(scatter)}" if scatter else None


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
    """Fill a template with the content common to both reports and additional content."""
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
        tested=test_sentence(outlines),
        methods=methods,
        references=references_of(methods),
        paper=PAPER,
        checks=_checks(runs),
        options=options_used({**_told(runs), **(options or {})}),
        **shown,
    )


def _told(runs: Sequence[_RunCard]) -> dict[str, Mapping[str, Any]]:
    """Return the options of each step of each run."""
    return {f"{run.page.id}, {stage.title}": stage.options for run in runs for stage in run.page.stages}


def _checks(runs: Sequence[_RunCard]) -> list[_Check]:
    """Return the items that are customarily reported, with the values of the runs."""
    stated = {run.page.id: [Stated(one.subject, one.name, one.value) for one in run.reporting] for run in runs}
    everything = sorted((one for run in runs for one in run.reporting), key=_is_missing)
    items = {(one.subject, one.name): one for one in everything}
    return [_Check(one, items[one.subject, one.name]) for one in merged(stated)]


def _is_missing(item: ReportingItem) -> bool:
    return item.value is None
