"""The command that opens the documentation: help."""

import sys
from typing import Annotated, Any

import typer

from tribopipe.cli.output import print_result, table

_NAMED = 4
"""As many pages are named of those that speak of something."""


def topics() -> list[str]:
    """Name all that there is help on, for shells to complete."""
    from tribopipe.cli.manual import pages, sections

    return [*pages(), *sections()]


def show_help(
    context: typer.Context,
    asked: Annotated[
        list[str] | None,
        typer.Argument(
            help="Page, command, or what an error or a finding names; none lists the pages.",
            metavar="TOPIC",
            autocompletion=topics,
        ),
    ] = None,
) -> None:
    """Open a page of the documentation, or explain a message."""
    if not asked:
        _list_pages()
        return
    together = _command_help(asked, context)  # "study run"
    for text in [together] if together and len(asked) > 1 else [_text_of(topic, context) for topic in asked]:
        _print(text)


def _list_pages() -> None:
    from tribopipe.cli.manual import page, pages

    rows = [[name, page(name).partition("\n")[0].lstrip("# ")] for name in pages()]
    table("Pages, opened by `tribopipe help PAGE`", ["page", "about"], rows)
    print_result("`tribopipe --help` lists the commands, `tribopipe COMMAND --help` the options of one.")


def _text_of(topic: str, context: typer.Context) -> str:
    """Return the text on a topic, Markdown but for commands. Raises ``QueryError`` where there is none."""
    from tribopipe.base.errors import QueryError
    from tribopipe.cli.manual import page, pages, sections

    called = topic.lower().removeprefix("docs/").removesuffix(".md")
    codes = {_plain(code): code for code in sections()}
    names = {_plain(name): name for name in pages()}
    if code := codes.get(_plain(called)):
        return f"### {code}\n\n{sections()[code]}\n"
    if name := names.get(_plain(called)):
        return page(name)
    text = _command_help([called], context)
    if text is None:
        raise QueryError(f"found {topic!r}; expected a page, a command, an error or a finding; {_near(topic, context)}")
    return text


def _plain(name: str) -> str:
    """Return a name by which it does not matter whether it is written with - or _."""
    return name.replace("_", "-")


def _near(topic: str, context: typer.Context) -> str:
    """Say what was probably meant, which pages speak of it, or how all are listed."""
    from tribopipe.base.errors import did_you_mean
    from tribopipe.cli.manual import pages, pages_about, sections

    about = pages_about(topic)[:_NAMED] if topic.strip() else []
    if about:
        return f"pages that speak of it: {', '.join(about)}"
    near = did_you_mean(topic, [*pages(), *sections(), *_commands(context)])
    return near if near.startswith("did") else "`tribopipe help` lists the pages"


def _command_help(words: list[str], context: typer.Context) -> str | None:
    """Return what --help says of a command, such as "fit" or "study run"; none where there is no such command."""
    place: Any = context.find_root()
    for word in words:
        command = getattr(place.command, "commands", {}).get(word)
        if command is None:
            return None
        place = typer.Context(command, info_name=word, parent=place)
    with place:
        return str(place.command.get_help(place))


def _commands(context: typer.Context) -> dict[str, Any]:
    group: Any = context.find_root().command
    return dict(group.commands)


def _print(text: str) -> None:
    """Print Markdown: laid out on a terminal, as it is elsewhere."""
    if not sys.stdout.isatty() or not text.startswith("#"):
        typer.echo(text)
        return
    from rich.console import Console
    from rich.markdown import Markdown

    Console().print(Markdown(text))


COMMANDS = {"help": show_help}
