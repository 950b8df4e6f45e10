"""The command that opens the documentation: help."""

import sys
from typing import Annotated, Any

import typer

from tribopipe.cli.output import print_result, table

_NAMED = 4
"""Largest number of related pages that are named."""
_ALSO = 2
"""Largest number of pages named after the one that answers a question best."""


def topics() -> list[str]:
    """Return all help topics, for shell completion."""
    from tribopipe.cli.documentation import pages, sections

    return [*pages(), *sections()]


def show_help(
    context: typer.Context,
    asked: Annotated[
        list[str] | None,
        typer.Argument(
            help=(
                "Name of a page, command or key, code of an error or finding, or a question in plain words; default: "
                "list of pages."
            ),
            metavar="TOPIC",
            autocompletion=topics,
        ),
    ] = None,
) -> None:
    """Open a page of the documentation, explain a message, or find the page that answers a question."""
    if not asked:
        _list_pages()
        return
    together = _command_help(asked, context)  # "study run"
    texts = [together] if together and len(asked) > 1 else [_text_of(topic, context) for topic in asked]
    known = [text for text in texts if text is not None]
    if len(known) < len(texts):
        _answer(" ".join(asked), context)
        return
    for text in known:
        _print(text)


def _answer(question: str, context: typer.Context) -> None:
    """Show the pages that answer a question. Raises ``QueryError`` if none does."""
    from tribopipe.base.errors import QueryError
    from tribopipe.cli.documentation import entries, has_words_of, pages_for, title
    from tribopipe.cli.pages import paragraph

    is_question = len(question.split()) > 1 or has_words_of(question)  # one that is not may be a misspelled name
    found = pages_for(question) if is_question else []
    if not found:
        raise QueryError(
            f"found {question!r}; expected the name of a page, command, error or finding, or a question; "
            f"{_near(question, context)}"
        )
    best, *others = found[: 1 + _ALSO]
    entry = entries()[best]
    print_result(typer.style(title(best), bold=True))
    paragraph(entry.answer)
    if entry.command:
        print_result(f"\n    {typer.style(entry.command, bold=True)}")
    print_result(f"\nRead docs/{best}.md: `tribopipe help {best}`")
    if others:
        print_result("\nSee also:")
        for name in others:
            print_result(f"  tribopipe help {name}: {title(name)}")


def _list_pages() -> None:
    from tribopipe.cli.documentation import pages, title

    rows = [[name, title(name)] for name in pages()]
    table("Pages; open one with `tribopipe help PAGE`", ["page", "about"], rows)
    print_result("`tribopipe --help` lists the commands, `tribopipe COMMAND --help` the options of a command.")


def _text_of(topic: str, context: typer.Context) -> str | None:
    """Return the text on a topic, in Markdown except for commands; none if there is no such topic."""
    from tribopipe.cli.documentation import page, pages, sections

    called = topic.lower().removeprefix("docs/").removesuffix(".md")
    codes = {_plain(code): code for code in sections()}
    names = {_plain(name): name for name in pages()}
    if code := codes.get(_plain(called)):
        return f"### {code}\n\n{sections()[code]}\n"
    if name := names.get(_plain(called)):
        return page(name)
    return _command_help([called], context)


def _plain(name: str) -> str:
    """Return a name with _ replaced by -, for comparison."""
    return name.replace("_", "-")


def _near(topic: str, context: typer.Context) -> str:
    """Return what was probably meant, the pages that mention it, or how to list all pages."""
    from tribopipe.base.errors import did_you_mean
    from tribopipe.cli.documentation import pages, pages_about, sections

    about = pages_about(topic)[:_NAMED] if topic.strip() else []
    if about:
        return f"related pages: {', '.join(about)}"
    near = did_you_mean(topic, [*pages(), *sections(), *_commands(context)])
    return near if near.startswith("did") else "`tribopipe help` lists the pages"


def _command_help(words: list[str], context: typer.Context) -> str | None:
    """Return the --help text of a command, such as "fit" or "study run"; none if there is no such command."""
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
    """Print Markdown: formatted on a terminal, unchanged elsewhere."""
    if not sys.stdout.isatty() or not text.startswith("#"):
        typer.echo(text)
        return
    from rich.console import Console
    from rich.markdown import Markdown

    Console().print(Markdown(text))
