"""The command that follows a test while it is running: live."""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tribopipe.cli.options import Law, RecipeFile, load_archive, load_recipe, parsed
from tribopipe.cli.output import FAILED, keep_stdout_for_json, print_json, print_result, record_json, say, seen

if TYPE_CHECKING:
    from tribopipe.documents.manifest import RunManifest
    from tribopipe.extras.live.problem import Known
    from tribopipe.extras.live.session import LiveUpdate, Session

_NAP = 0.1
"""Interval at which an interrupt is checked for while waiting, s."""
_LONG = 60.0
"""Time without a new sample after which a test may have stopped, s."""
_LONGER = 5.0
"""Ratio to the longest earlier pause."""
Tell = Callable[["LiveUpdate"], None]


def live(
    run: Annotated[Path, typer.Argument(help="Run folder with a run.toml and signals that are still being recorded.")],
    law: Law = "archard",
    recipe: RecipeFile = None,
    to: Annotated[
        str | None,
        typer.Option(
            "--to", help="Planned sliding distance, for example '500 m'; overrides conditions.sliding_distance."
        ),
    ] = None,
    drift: Annotated[
        str | None, typer.Option("--drift", help="Drift of the sensor if known, for example '0 +- 5 nm/min'.")
    ] = None,
    disc_wear: Annotated[
        str | None,
        typer.Option(
            "--disc-wear", help="Expected wear depth of the disc at the planned end, for example '0.15 +- 0.1 um'."
        ),
    ] = None,
    drift_from: Annotated[
        Path | None,
        typer.Option(
            "--drift-from", help="Archive of earlier runs on this instrument, from which its drift is estimated."
        ),
    ] = None,
    wear_from: Annotated[
        Path | None,
        typer.Option(
            "--wear-from", help="Archive of earlier runs with the same bodies, from which their k_D is estimated."
        ),
    ] = None,
    every: Annotated[float, typer.Option("--every", help="Time between updates in seconds.", min=0.1)] = 5.0,
    until_still: Annotated[
        float | None, typer.Option("--until-still", help="Idle time in seconds after which to stop.", min=0.0)
    ] = None,
    once: Annotated[bool, typer.Option("--once", help="Show the current state and exit.")] = False,
    figure: Annotated[Path | None, typer.Option("--figure", help="Figure to update, for example live.svg.")] = None,
    as_json: Annotated[
        bool,
        typer.Option("--json", callback=keep_stdout_for_json, help="Print one JSON line per update."),
    ] = False,
) -> None:
    """Follow a test while it runs: current k_D and warnings.

    Nothing is archived; process the run when it has ended. Exit code 1 after an alarm.
    """
    from tribopipe.documents.manifest import manifest_path, read_manifest
    from tribopipe.evaluation.wear.inputs import law_as_given
    from tribopipe.extras.live.problem import Asked
    from tribopipe.extras.live.session import Session
    from tribopipe.pipeline.output_paths import made_here, require_free
    from tribopipe.results.run import RawRun

    require_free([] if figure is None else [figure], own=made_here, beside_run=True)
    told = load_recipe(recipe)
    law_as_given(law, told)  # rather than wait for a test that this law cannot be fitted to
    where = manifest_path(run)
    manifest, _ = read_manifest(where)
    planned = manifest.conditions.sliding_distance
    end = parsed("--to", to, "distance") if to is not None else None if planned is None else planned.value
    known = _known(manifest, law, (drift, disc_wear), (drift_from, wear_from))
    asked = Asked(RawRun(manifest, {}, {}, {}, {}, ()), law, told, known, end)
    session = Session(where.parent, asked)
    for note in known.notes:
        say(note)
    with _until_interrupted() as goes_on, _display(session, as_json=as_json) as tell:
        for update in [session.look()] if once else _looks(session, every, until_still, goes_on):
            tell(update)
            if figure is not None and session.grew:
                _draw(session, update, figure)
    say(f"add any post-test measurement to run.toml, then evaluate the run with `tribopipe process {run}`")
    if session.alarmed:
        raise typer.Exit(FAILED)


def _known(
    manifest: "RunManifest",
    law: Law,
    given: tuple[str | None, str | None],
    archives: tuple[Path | None, Path | None],
) -> "Known":
    """Return drift, disc wear and k_D, and the runs they come from. Values on the command line take precedence."""
    from tribopipe.base.units import WEAR_COEFFICIENT
    from tribopipe.extras.live.priors import archived_coefficient, archived_drift, quantity_given
    from tribopipe.extras.live.problem import Known

    drift, disc = (
        None if text is None else quantity_given(option, text, kind)
        for option, text, kind in zip(("--drift", "--disc-wear"), given, ("drift rate", "length"), strict=True)
    )
    notes, k = list(() if manifest.contact is None else manifest.contact.limits), None
    drift_from, wear_from = (None if folder is None else load_archive(folder) for folder in archives)
    if drift is None and drift_from is not None:
        found = archived_drift(drift_from, manifest)
        drift = found.quantity
        notes.append(f"expected drift {drift.shown('nm/min')}, from {', '.join(found.runs)}")
    if wear_from is not None:
        found = archived_coefficient(wear_from, manifest, law)
        k = found.quantity
        notes.append(f"expected k_D {k.shown(WEAR_COEFFICIENT)}, from {', '.join(found.runs)}")
    return Known(drift, disc, k, tuple(notes))


def _looks(
    session: "Session", every: float, until_still: float | None, goes_on: Callable[[], bool]
) -> "Iterator[LiveUpdate]":
    """Yield updates until there is no new sample for the idle time, or until interrupted."""
    grown, longest = time.monotonic(), 0.0
    while goes_on():
        yield session.look()
        still = time.monotonic() - grown
        if session.grew:
            grown, longest = time.monotonic(), max(longest, still)
        elif until_still is not None and still >= until_still:
            yield session.still(still)
            return
        elif still > max(_LONG, _LONGER * longest):
            yield session.still(still)
        _wait(every, goes_on)


def _wait(seconds: float, goes_on: Callable[[], bool]) -> None:
    end = time.monotonic() + seconds
    while goes_on() and (left := end - time.monotonic()) > 0:
        time.sleep(min(_NAP, left))


@contextmanager
def _until_interrupted() -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether to continue: Ctrl-C stops after this update, a second one at once."""
    interrupts: list[int] = []
    before = signal.getsignal(signal.SIGINT)

    def note(number: int, _: object) -> None:
        interrupts.append(number)
        signal.signal(signal.SIGINT, before)

    if before is not signal.SIG_IGN:  # as nohup has it
        signal.signal(signal.SIGINT, note)
    try:
        yield lambda: not interrupts
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _display(session: "Session", *, as_json: bool) -> Iterator[Tell]:
    """Yield a function that shows an update: as lines, or on a terminal as a display that is refreshed."""
    if as_json or not sys.stderr.isatty():
        yield lambda update: _tell_lines(session, update, as_json=as_json)
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    from tribopipe.base.process_lifecycle import undone_by

    def tell(update: "LiveUpdate") -> None:
        for alarm in update.alarms:
            shown.console.print(Text(f"ALARM: {seen(str(alarm))}", style="bold red"))
        shown.update(Text("\n".join(map(seen, _lines(update)))), refresh=True)

    with undone_by(_show_cursor), Live(console=Console(stderr=True), auto_refresh=False) as shown:
        yield tell


def _show_cursor() -> None:
    os.write(sys.stderr.fileno(), b"\r\x1b[?25h")


def _tell_lines(session: "Session", update: "LiveUpdate", *, as_json: bool) -> None:
    """Report an update with new content."""
    if as_json and (session.grew or update.alarms):
        print_json(record_json(update), indent=None)
    elif session.grew:
        print_result("; ".join(_lines(update)))
    for alarm in update.alarms:
        say(f"ALARM: {alarm}")


def _lines(update: "LiveUpdate") -> Iterator[str]:
    """Yield the lines of an update as text."""
    from tribopipe.base.units import WEAR_COEFFICIENT
    from tribopipe.documents.quantity import between

    far = "no samples yet" if update.sliding_distance is None else update.sliding_distance.shown("m")
    yield f"{update.id}: {far}"
    found = update.estimate
    if found is None:
        yield update.reason or ""
        return
    interval = between(found.interval, WEAR_COEFFICIENT)
    yield f"k_D = {found.wear_coefficient.shown(WEAR_COEFFICIENT)}, 95 % CI: {interval}"
    yield f"wear depth {found.wear_depth.shown('um')}, 95 % CI: {between(found.wear_depth_interval, 'um')}"
    if found.planned_distance and found.predicted_depth and found.predicted_interval:
        ahead = f"{found.predicted_depth.shown('um')}, 95 % CI: {between(found.predicted_interval, 'um')}"
        yield f"expected at {found.planned_distance.shown('m')}: {ahead}"
    yield f"drift {found.drift_rate.shown('nm/min')}"


def _draw(session: "Session", update: "LiveUpdate", path: Path) -> None:
    """Update the figure, if there is something to draw."""
    from tribopipe.extras.live.figure import plot_live
    from tribopipe.views.run_figures import save_figure

    if session.posterior is not None and update.estimate is not None:
        save_figure(plot_live(update.id, session.posterior, update.estimate, session.state.means), path)
