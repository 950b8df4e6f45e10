"""The `tribopipe` command."""

import codecs
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any

import typer

from tribopipe.cli import (
    browse,
    curation,
    datasets,
    export,
    formats,
    guide,
    inspect,
    integrity,
    listing,
    live,
    local_wear,
    new,
    predict,
    process,
    report,
    runs,
    steps,
    studies,
    sweep,
    watch,
)
from tribopipe.cli.options import HelpPanels
from tribopipe.cli.output import keep_stdout_for_json, safe


@contextmanager
def _safe_usage_errors() -> Iterator[None]:
    """Escape control characters in errors that quote the command line; Typer has no public base class of these."""
    try:
        yield
    except Exception as error:
        if isinstance(told := getattr(error, "message", None), str):
            error.message = safe(told)  # type: ignore[attr-defined]
        raise


class _Commands(HelpPanels):
    """All commands, with safe messages if the command line is invalid."""

    def make_context(self, *args: Any, **others: Any) -> Any:
        with _safe_usage_errors():
            return super().make_context(*args, **others)

    def invoke(self, ctx: Any) -> Any:
        with _safe_usage_errors():
            return super().invoke(ctx)


app = typer.Typer(
    name="tribopipe",
    cls=_Commands,
    help=(
        "Archive and evaluate tribometer tests, identify wear coefficients, and test wear laws.\n\nWithout a command, "
        "tribopipe shows the next steps for the current folder."
    ),
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def _tribopipe(
    context: typer.Context, version: bool = typer.Option(False, "--version", help="Show the version and exit.")
) -> None:
    keep_stdout_for_json(False)
    if version:
        typer.echo(f"tribopipe {import_module('tribopipe').__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        from tribopipe.cli.next_steps import say_next_steps

        say_next_steps()


_PANELS: dict[str, dict[str, Any]] = {
    "Workflow": {
        "new": new.new,
        "check": runs.check,
        "ingest": runs.ingest,
        "process": process.process,
        "correct-drift": steps.correct_drift,
        "fit": steps.fit,
        "predict": predict.predict,
        "watch": watch.watch,
        "live": live.live,
        "formats": formats.formats_app,
    },
    "Results": {
        "ls": listing.ls,
        "show": inspect.show,
        "report": report.report,
        "export": export.export_app,
        "browse": browse.browse,
    },
    "Studies": {
        "study": studies.study_app,
        "plan": studies.plan,
        "sweep": sweep.sweep,
    },
    "Archive maintenance": {
        "mark-bad": curation.mark_bad,
        "tag": curation.tag,
        "note": curation.note,
        "remove": curation.remove,
        "restore": curation.restore,
        "verify": integrity.verify,
        "reproduce": integrity.reproduce,
        "rescue": integrity.rescue,
        "import": datasets.import_crate,
    },
    "Simulation": {
        "demo": browse.demo,
        "simulate": runs.simulate,
        "local-wear": local_wear.local_wear,
    },
    "Help": {
        "help": guide.show_help,
        "schema": inspect.schema_app,
    },
}
"""Panels of the help, each with its commands in the order in which they are listed."""
for _panel, _commands in _PANELS.items():
    for _name, _command in _commands.items():
        if isinstance(_command, typer.Typer):
            app.add_typer(_command, name=_name, rich_help_panel=_panel)
        else:
            app.command(_name, rich_help_panel=_panel)(_command)


_PLAIN = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−–μ·…─", "-0123456789--u.~-")


def _plainly(error: UnicodeError) -> tuple[str, int]:
    """Write powers as ^-8 and Greek letters in Latin if the encoding of the console does not include them."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    plain = text.translate(_PLAIN).encode("ascii", "replace").decode("ascii")
    return ("^" if text[0] in "⁻⁰⁴⁵⁶⁷⁸⁹" else "") + plain, error.end


codecs.register_error("tribopipe-plain", _plainly)


def main() -> None:
    """Run the command; any error is printed as one sentence on stderr, with exit code 1."""
    for stream in (sys.stdout, sys.stderr):
        # A console that lacks μ or ⁻ shows a plain substitute rather than failing.
        getattr(stream, "reconfigure", lambda **_: None)(errors="tribopipe-plain")
    try:
        app()
    except Exception as error:  # noqa: BLE001 - nobody should see a traceback
        from tribopipe.base.failures import in_a_sentence
        from tribopipe.cli.output import say, say_where_to_read

        told = in_a_sentence(error)
        say(f"error: {told}")
        say_where_to_read([told.code])
        sys.exit(1)
