"""The page of commands, read from the commands themselves."""

import re
from collections.abc import Iterator
from typing import Any

import typer
from typer.main import get_command

from site_parts.markdown import code, indexed, plain, table, titled
from tribopipe.cli.app import app

_NAME = "tribopipe"
_NAMES = re.compile(r"([^\s,]+(?:(?:,| /) [^\s,]+)*)(?: <?(.*?)>?)?")
"""How `--help` writes a parameter: "-o, --output <path>"."""
_BOUNDS = r"[\d.]*(?:<=)?x[<>]=[\d.]+"
_EXTRAS = re.compile(rf"(.*?)\s*(?:\[(?:default: ([^;\]]+?))?(?:; )?({_BOUNDS})?(?:; )?(?:required)?\])?", re.DOTALL)
"""What `--help` says of a parameter: its meaning, its default, and between which numbers it has to be."""
_VALUES = {
    "": " ",
    "str": "text",
    "path": "path",
    "Path": "path",
    "int range": "whole number",
    "float range": "number",
    "list[str]": "text",
    "list[Path]": "path",
}


def commands_page() -> str:
    """Return the page of all commands: one table of them all, then each with its arguments and options."""
    commands = dict(_commands(get_command(app), _NAME))
    linked = {name: f"[{code(name.removeprefix(_NAME).strip())}](#{_label(name)})" for name in commands}
    rows = ((linked[name], plain(_sentence(command.help))) for name, command in commands.items())
    intro = f"Type {code(_NAME)} before each command. `--help` after a command lists its options.\n\n"
    sections = (_section(name, command) for name, command in commands.items())
    return titled(1, "Commands") + intro + table(("Command", "Purpose"), rows) + "\n" + "".join(sections)


def _commands(group: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Return each command with its whole name; of groups, what is in them."""
    for command in group.commands.values():
        if hasattr(command, "commands"):
            yield from _commands(command, f"{name} {command.name}")
        elif not command.hidden:
            yield f"{name} {command.name}", command


def _section(name: str, command: Any) -> str:
    context = typer.Context(command, info_name=name)
    shown = [one for one in command.get_params(context) if not one.hidden and one.name != "help"]
    written = [option for one in shown for option in one.opts if option.startswith("--")]
    arguments = [_row(one, context) for one in shown if one.param_type_name == "argument"]
    options = [_row(one, context) for one in shown if one.param_type_name == "option"]
    usage = " ".join((name, *(argument[0].strip("`") for argument in arguments), "[OPTIONS]"))
    text = titled(2, code(name), _label(name)) + indexed(f"{option}; {name}" for option in written)
    text += f"```text\n{usage}\n```\n\n{_prose(command.help)}\n\n"
    for title, rows in (("Argument", arguments), ("Option", options)):
        if rows:
            text += table((title, "Meaning", "Value", "Default"), rows) + "\n"
    return text


def _row(parameter: Any, context: typer.Context) -> tuple[str, str, str, str]:
    """Return name, meaning, values and default of a parameter, out of what `--help` says of it."""
    written, told = parameter.get_help_record(context)
    name, value = _parts(_NAMES, written)
    meaning, default, bounds = _parts(_EXTRAS, told)
    limits = bounds.replace("<=x<=", " to ").replace("x>=", "≥ ")
    left_out = "**required**" if parameter.required else code(default.strip("()"))
    return code(name), plain(meaning), f"{_value(value)} {limits}", left_out


def _parts(pattern: re.Pattern[str], text: str) -> tuple[str, ...]:
    found = pattern.fullmatch(text)
    if found is None:
        raise ValueError(f"found {text!r} in the help of a command; expected what {pattern.pattern} matches")
    return found.groups("")


def _value(kind: str) -> str:
    return _VALUES.get(kind) or " or ".join(map(code, kind.split("|")))


def _prose(text: str) -> str:
    return "\n\n".join(plain(" ".join(part.split())) for part in text.split("\n\n"))


def _sentence(text: str) -> str:
    return " ".join(text.split("\n\n")[0].split())


def _label(name: str) -> str:
    return name.replace(" ", "-")
