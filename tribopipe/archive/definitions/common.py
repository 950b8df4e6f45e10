"""Parts that files of runs and of studies share."""

from collections.abc import Iterator, Mapping
from typing import TypeVar

from tribopipe.archive.definitions.parts import FieldPart, GroupPart, LinkPart, Part

Name = TypeVar("Name", bound=str)


def text(name: str, doc: str, *, required: bool = True) -> FieldPart:
    """Declare a text."""
    return FieldPart(name, doc, required=required)


def defined(name: str) -> FieldPart:
    """Declare the field that names the definition; its version is that of the format of the file."""
    return FieldPart("definition", "This definition.", required=True, values=(name,), attributes=("version",))


def document(name: str, doc: str, *, required: bool = True) -> GroupPart:
    """Declare a JSON document, as ``nexus.document`` writes it."""
    members = (text("type", "application/json."), text("data", "The document."))
    return GroupPart(name, "NXnote", doc, members, required)


def process(name: str, doc: str, *members: Part, required: bool = False) -> GroupPart:
    """Declare a step of processing: what is known of every one, and its own members."""
    common = (
        text("program", "Program that computed it."),
        text("version", "Version of the program."),
        FieldPart("date", "When it was computed.", "NX_DATE_TIME", required=True),
        document("environment", "What it was computed with.", required=False),
    )
    return GroupPart(name, "NXprocess", doc, (*common, *members), required)


def columns(units: Mapping[str, str], *, required: bool = True) -> Iterator[FieldPart]:
    """Declare columns of numbers by their names with their units."""
    for name, unit in units.items():
        yield FieldPart(name, _in_words(name), "NX_FLOAT", (unit,), required)


def banded(units: Mapping[Name, str]) -> dict[str, str]:
    """Return the fields of curves with their units, and of both ends of their 95 % intervals."""
    return {f"{name}{end}": unit for name, unit in units.items() for end in ("", "_lower", "_upper")}


def drawn_against(axis: str) -> LinkPart:
    """Declare the axis of curves over the samples of a run."""
    return LinkPart(axis, f"/NXentry/raw:NXdata/{axis}")


def _in_words(name: str) -> str:
    for end in ("lower", "upper"):
        if name.endswith(f"_{end}"):
            return f"{end.capitalize()} end of the 95 % interval of {name.removesuffix(f'_{end}')}."
    return f"{name.replace('_', ' ').capitalize()}."
