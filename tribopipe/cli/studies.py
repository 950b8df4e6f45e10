"""Commands on several runs with one law: study new, study run, study show, study figures; plan."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    ArchiveFolder,
    AsJson,
    FigureFormats,
    Figures,
    Force,
    HelpPanels,
    Law,
    ReadableArchive,
    RecipeFile,
    Replace,
    Verbose,
    archived_ids,
    archived_studies,
    load_archive,
    load_recipe,
    parsed,
)
from tribopipe.cli.output import exit_with, finish, followed, print_json, print_result, record_json, say, table
from tribopipe.cli.pages import show_study_page

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tribopipe.archive.store import Archive
    from tribopipe.documents.manifest import RunManifest
    from tribopipe.documents.recipe import Recipe
    from tribopipe.results.run import RawRun
    from tribopipe.results.study import StudyResult

study_app = typer.Typer(
    cls=HelpPanels, help="Fit some runs, predict others, and test the wear law.", no_args_is_help=True
)


@study_app.command("new")
def new(
    paths: Annotated[list[Path] | None, typer.Argument(help="Run folders; default: all runs in the archive.")] = None,
    into: Annotated[Path, typer.Option("--into", help="Output folder.")] = Path(),
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    force: Replace = False,
) -> None:
    """Draft a study for each set of runs with the same bodies.

    The runs at the lightest load are fitted, the others are predicted.

    Runs that are marked bad, were aborted or have no data for k_D are excluded and listed. Writes study.toml, or
    <id>.study.toml for each of several; review and edit it before you run it.
    """
    from tribopipe.base.files import write_file
    from tribopipe.documents.study import STUDY_NAME, STUDY_SUFFIX
    from tribopipe.pipeline.output_paths import require_free
    from tribopipe.pipeline.studies import draft_studies, study_toml

    found = _read(paths) if paths else _archived(load_archive(archive))
    sound = [one for one in found if one.unfit is None]
    for one in found:
        if one.unfit is not None:
            say(f"{one.manifest.id}: excluded: {one.manifest.worded(one.unfit)}")
    drafts = draft_studies([one.manifest for one in sound], {one.manifest.id for one in sound if not one.friction})
    documents = {into / (STUDY_NAME if len(drafts) == 1 else f"{draft.id}{STUDY_SUFFIX}"): draft for draft in drafts}
    require_free(documents, force=force)
    into.mkdir(parents=True, exist_ok=True)
    for path, draft in documents.items():
        write_file(path, study_toml(draft).encode("utf-8"))
        print_result(f"{path}: fitted: {', '.join(draft.fit)}; predicted: {', '.join(draft.predict) or 'none'}")


class _Candidate(NamedTuple):
    """A run that may be used in a study."""

    manifest: "RunManifest"
    unfit: str | None
    """Reason why a study cannot use it."""
    friction: bool


def _candidate(run: "RawRun") -> _Candidate:
    from tribopipe.documents.recipe import Recipe
    from tribopipe.pipeline.studies import unfit_for_study

    return _Candidate(run.manifest, unfit_for_study(run, Recipe()), "friction_coefficient" in run.columns)


def _read(paths: "Sequence[Path]") -> list[_Candidate]:
    """Read run folders; those whose recording cannot be read are excluded."""
    from tribopipe.base.errors import ReaderError
    from tribopipe.documents.manifest import manifest_path, read_manifest
    from tribopipe.pipeline.stages import find_runs
    from tribopipe.readers.harmonize import read_run

    found = []
    for folder in (run for path in paths for run in find_runs(path)):
        manifest, _ = read_manifest(manifest_path(folder))
        try:
            found.append(_candidate(read_run(folder)))
        except ReaderError as error:
            found.append(_Candidate(manifest, str(error), friction=False))
    return found


def _archived(store: "Archive") -> list[_Candidate]:
    found = []
    for run_id in store.ids():
        mark = store.bad(run_id)
        if mark is None:
            found.append(_candidate(store.raw(run_id)))
        else:
            found.append(_Candidate(store.manifest(run_id), f"marked bad: {mark.reason}", friction=False))
    return found


@study_app.command("run")
def run(
    path: Annotated[Path, typer.Argument(help="Path of study.toml.", metavar="STUDY")],
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    force: Force = False,
    as_json: AsJson = False,
    figures: Figures = True,
    verbose: Verbose = 0,
) -> None:
    """Evaluate a study on archived runs, and archive it."""
    from tribopipe.pipeline.studies import load_studies, run_study
    from tribopipe.views.archived_figures import save_study_figures, study_is_drawn

    (study,) = load_studies([path])
    store = load_archive(archive)
    outcomes = followed(run_study(store, study, load_recipe(recipe), force=force), "study", None)
    if outcomes[0].error is None:
        if outcomes[0].status == "unchanged":
            say(f"{study.id}: unchanged, nothing to do")
        _show_study(store, study.id, in_full=bool(verbose) or as_json)
        if figures and not (outcomes[0].status == "unchanged" and study_is_drawn(store, study.id)):
            say(f"figures in {save_study_figures(store, study.id)[0].parent}")
        if as_json:
            print_json(record_json(store.study_outline(study.id).result))
    finish(outcomes)


@study_app.command("show")
def show(
    study_id: Annotated[
        str | None,
        typer.Argument(
            help="ID of an archived study; default: list all.", metavar="ID", autocompletion=archived_studies
        ),
    ] = None,
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    verbose: Verbose = 0,
    as_json: AsJson = False,
) -> None:
    """Show an archived study, or list all studies."""
    from tribopipe.base.errors import ArchiveError

    store = load_archive(archive)
    if study_id is not None:
        _show_study(store, study_id, in_full=bool(verbose) or as_json)
        if as_json:
            print_json(record_json(store.study_outline(study_id).result))
        return
    stored, unreadable = [], []
    for one in store.study_ids():
        try:
            stored.append(store.study_outline(one))
        except ArchiveError as error:
            unreadable.append(error)
    if as_json:
        print_json({"studies": [record_json(one.study) for one in stored]})
    elif stored or not unreadable:
        table(
            f"{len(stored)} {'study' if len(stored) == 1 else 'studies'} in {archive}",
            ["study", "fitted", "predicted", "agreement of predicted runs"],
            [[one.study.id, _named(one.study.fit), str(len(one.study.predict)), _tally(one.result)] for one in stored],
        )
    exit_with(unreadable, some_done=bool(stored))


def _show_study(store: "Archive", study_id: str, *, in_full: bool) -> None:
    from tribopipe.cli.overview import show_study_overview
    from tribopipe.views.study_page import study_page

    if in_full:
        show_study_page(study_page(store, study_id))
    else:
        show_study_overview(store.study_outline(study_id).result)


def _named(ids: "Sequence[str]") -> str:
    return ids[0] if len(ids) == 1 else f"{len(ids)} runs"


def _tally(result: "StudyResult") -> str:
    """Return the number of predicted runs by their agreement with each law."""
    from tribopipe.physics.laws import law_label
    from tribopipe.results.study import tally

    told = [f"{law_label(law.model)}: {tally(law)}" for law in result.laws if tally(law)]
    return "; ".join(told) or "–"


@study_app.command("figures")
def figures(
    ids: Annotated[
        list[str] | None,
        typer.Argument(help="IDs of studies; default: all.", metavar="ID", autocompletion=archived_studies),
    ] = None,
    into: Annotated[
        Path | None, typer.Option("--into", help="Output folder; default: figures/ in the archive.")
    ] = None,
    formats: FigureFormats = None,
    archive: ArchiveFolder = DEFAULT_ARCHIVE,
) -> None:
    """Draw the figures of a study: wear with each law, friction, k_D."""
    from tribopipe.pipeline.output_paths import require_folder
    from tribopipe.views.archived_figures import save_study_figures

    if into is not None:
        require_folder(into)
    store = load_archive(archive)
    for study_id in ids or store.study_ids():
        for path in save_study_figures(store, study_id, formats or (), into):
            print_result(str(path))


def show_together(
    store: "Archive",
    fit: "Sequence[str]",
    predict: "Sequence[str]",
    law: Law,
    recipe: "Recipe",
    *,
    verbose: int,
    as_json: bool,
) -> None:
    """Evaluate a study without a document, and show it without archiving it."""
    from tribopipe.cli.overview import show_study_overview
    from tribopipe.documents.record import read_document
    from tribopipe.documents.study import Study
    from tribopipe.pipeline.studies import evaluate_archived
    from tribopipe.views.study_page import study_page_of

    document = {"id": "together", "fit": fit, "predict": predict, "laws": [law]}
    result = evaluate_archived(store, read_document(document, Study, where="runs"), recipe).result
    if verbose or as_json:
        show_study_page(study_page_of(result))
    else:
        show_study_overview(result, archived=False)
    if as_json:
        print_json(record_json(result))


def plan(
    name: Annotated[
        str, typer.Argument(help="ID of an archived run or study.", metavar="ID", autocompletion=archived_ids)
    ],
    interval: Annotated[
        str, typer.Option("--interval", help='Target half-width of the 95 % interval for k_D, for example "10 %".')
    ],
    model: Law = "archard",
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    recipe: RecipeFile = None,
    as_json: AsJson = False,
) -> None:
    """Plan tests for a target uncertainty of k_D.

    Shows which input contributes most to the uncertainty, and the required sliding distance or number of replicates.
    """
    from tribopipe.base.errors import UnitError
    from tribopipe.pipeline.studies import plan_archived
    from tribopipe.results.input_quantities import input_label

    store, wanted = load_archive(archive), parsed("--interval", interval, "percentage")
    if wanted >= 1:
        raise UnitError(
            f"--interval: found {interval!r}, which is {100 * wanted:.0f} % of k_D; expected less than 100 %, such as "
            "'10 %'"
        )
    designs = plan_archived(store, name, model, wanted, load_recipe(recipe))
    for found in designs:
        print_result(str(found))
        if not found.levers:
            continue
        table(
            f"  contributions to the uncertainty of {found.of}",
            ["input", "value", "u of k_D", "share of variance", "half-width if u is halved"],
            [
                [
                    input_label(lever.name),
                    lever.value.shown(lever.shown_in) if lever.value else "–",
                    f"{100 * lever.relative:.2f} %",
                    f"{100 * lever.share:.0f} %",
                    f"±{100 * lever.if_halved:.1f} %",
                ]
                for lever in found.levers
            ],
        )
    if as_json:
        documents = [record_json(found) for found in designs]
        print_json(documents[0] if len(documents) == 1 else {"discs": documents})
