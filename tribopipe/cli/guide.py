"""The command that opens the documentation: help."""

import sys
from typing import Annotated, Any

import typer

from tribopipe.cli.output import say, table


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
            metavar="[TOPIC]...",
            autocompletion=topics,
        ),
    ] = None,
) -> None:
    """Open a page of the documentation, or what it says of an error, a finding or a command."""
    if not asked:
        _list_pages()
    for text in [_text_of(topic, context) for topic in asked or ()]:
        _print(text)


def _list_pages() -> None:
    from tribopipe.cli.manual import page, pages

    rows = [[name, page(name).partition("\n")[0].lstrip("# ")] for name in pages()]
    table("Pages, opened by `tribopipe help PAGE`", ["page", "about"], rows)
    say("`tribopipe --help` lists the commands, `tribopipe COMMAND --help` the options of one.")


def _text_of(topic: str, context: typer.Context) -> str:
    """Return the text on a topic, Markdown but for commands. Raises ``QueryError`` where there is none."""
    from tribopipe.cli.manual import page, pages, sections
    from tribopipe.errors import QueryError, did_you_mean

    if topic in sections():
        return f"### {topic}\n\n{sections()[topic]}\n"
    name = topic.removesuffix(".md").removeprefix("docs/").replace("-", "_")
    if name in pages():
        return page(name)
    commands = _commands(context)
    if topic in commands:
        with typer.Context(commands[topic], info_name=topic, parent=context.parent) as own:
            return str(commands[topic].get_help(own))
    known = did_you_mean(topic, [*pages(), *sections(), *commands])
    raise QueryError(f"found {topic!r}; expected a page, a command, an error or a finding; {known}")


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
