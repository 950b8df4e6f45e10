"""Completion of the command line in shells.

Typer's own completion imports pydantic and rich to parse the whole line, which is too slow. This module follows the
commands by their names, and asks Typer only for the values of one parameter. The scripts that call it are those of
Typer, installed by `tribopipe --install-completion`.
"""

import shlex
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import typer

_ASKED = "_TRIBOPIPE_COMPLETE"
"""Set by the scripts of shells: "complete_bash" and the like."""
SHELLS = ("bash", "zsh", "fish", "powershell", "pwsh")


class Choice(NamedTuple):
    """One completion of a word."""

    value: str
    help: str = ""


class Line(NamedTuple):
    """A command line so far."""

    words: list[str]
    """Complete words, without the name of the program."""
    begun: str
    """The incomplete word."""


class _Place(NamedTuple):
    """Position within a command line."""

    command: Any
    context: typer.Context
    """With the options of the command that have been given a value so far."""
    arguments: int
    """Number of arguments so far."""
    open_option: Any
    """An option whose value comes next."""


def answer(told: Mapping[str, str]) -> None:
    """Answer a supported shell, and exit; Typer handles the others."""
    from tribopipe.cli.app import app

    shell = told[_ASKED].removeprefix("complete_")
    if shell in SHELLS:
        printed, code = complete(typer.main.get_command(app), shell, told)
        typer.echo(printed.encode("utf-8"))
        sys.exit(code)


def complete(root: Any, shell: str, told: Mapping[str, str]) -> tuple[str, int]:
    """Return what to print for a shell, and the exit code, from the variables set by its script."""
    found = choices(root, line_of(shell, told))
    if told.get("_TYPER_COMPLETE_FISH_ACTION") == "is-args":
        return "", int(not found)
    return _WRITTEN.get(shell, _for_powershell)(found), 0


def line_of(shell: str, told: Mapping[str, str]) -> Line:
    """Return the command line so far, as given by the script of a shell."""
    if shell == "bash":
        words, place = _split(told.get("COMP_WORDS", "")), int(told.get("COMP_CWORD", "0"))
        return Line([word for word in words[1:place] if word != "="], "".join(words[place : place + 1]).lstrip("="))
    text = told.get("_TYPER_COMPLETE_ARGS", "")
    words = _split(text)[1:]
    if shell in ("powershell", "pwsh"):
        begun = told.get("_TYPER_COMPLETE_WORD_TO_COMPLETE", "")
        return Line(words[:-1] if begun else words, begun)
    return Line(words, "") if text.endswith(" ") or not words else Line(words[:-1], words[-1])


def _split(text: str) -> list[str]:
    try:
        return shlex.split(text)
    except ValueError:  # within quotes that are still open
        return text.split()


def choices(root: Any, line: Line) -> list[Choice]:
    """Return the completions of a word; none if the shell should complete file names."""
    place = _place(root, line.words)
    if place.open_option is not None:
        return _values(place.open_option, place.context, line.begun)
    if line.begun.startswith("-"):
        return _beginning(line.begun, _options(place))
    if hasattr(place.command, "commands"):
        names = place.command.commands.items()
        return _beginning(line.begun, (Choice(name, one.get_short_help_str()) for name, one in names))
    arguments = [one for one in place.command.params if one.param_type_name == "argument"]
    wanted = arguments[place.arguments : place.arguments + 1] or [one for one in arguments[-1:] if one.nargs == -1]
    return [choice for argument in wanted for choice in _values(argument, place.context, line.begun)]


def _place(command: Any, words: Sequence[str]) -> _Place:
    place = _Place(command, typer.Context(command, info_name="tribopipe"), 0, None)
    for word in words:
        place = _after(place, word)
    return place


def _after(place: _Place, word: str) -> _Place:
    """Return the position after one more word."""
    if place.open_option is not None:
        place.context.params[place.open_option.name] = word
        return place._replace(open_option=None)
    if word.startswith("-"):
        return place._replace(open_option=_taking_a_value(place, word))
    within = getattr(place.command, "commands", {}).get(word)
    if within is not None:
        return _Place(within, typer.Context(within, info_name=word, parent=place.context), 0, None)
    return place._replace(arguments=place.arguments + 1)


def _taking_a_value(place: _Place, word: str) -> Any:
    """Return the option with this name if it requires a value; none otherwise."""
    known = place.command.get_params(place.context)
    return next((one for one in known if word in one.opts and not getattr(one, "is_flag", False)), None)


def _values(parameter: Any, context: typer.Context, begun: str) -> list[Choice]:
    found = parameter.shell_complete(context, begun)
    return [Choice(item.value, item.help or "") for item in found if item.type == "plain"]


def _options(place: _Place) -> Iterable[Choice]:
    for one in place.command.get_params(place.context):
        if one.param_type_name == "option" and not one.hidden:
            yield from (Choice(name, one.help or "") for name in (*one.opts, *one.secondary_opts))


def _beginning(begun: str, found: Iterable[Choice]) -> list[Choice]:
    return [choice for choice in found if choice.value.startswith(begun)]


def _for_bash(found: Sequence[Choice]) -> str:
    return "\n".join(choice.value for choice in found)


def _for_zsh(found: Sequence[Choice]) -> str:
    if not found:
        return "_files"
    told = "\n".join(":".join(f'"{_safe(part)}"' for part in choice if part) for choice in found)
    return f"_arguments '*: :(({told}))'"


def _safe(text: str) -> str:
    """Quote a text so that zsh, which evaluates it, leaves it unchanged."""
    for sign, written in (('"', '""'), ("'", "''"), ("$", r"\$"), ("`", r"\`"), (":", r"\\:")):
        text = text.replace(sign, written)
    return text


def _for_fish(found: Sequence[Choice]) -> str:
    return "\n".join("\t".join(" ".join(part.split()) for part in choice if part) for choice in found)


def _for_powershell(found: Sequence[Choice]) -> str:
    return "\n".join(f"{choice.value}:::{' '.join(choice.help.split()) or ' '}" for choice in found)


_WRITTEN = {"bash": _for_bash, "zsh": _for_zsh, "fish": _for_fish}
