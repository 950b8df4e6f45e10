"""The page of the archived file, read from the NeXus application definitions that files are held against."""

from collections.abc import Iterable, Iterator

from site_parts.markdown import code, plain, table, titled
from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.archive.definitions.parts import Definition, FieldPart, GroupPart, LinkPart, Part

_KINDS = {
    "NX_CHAR": "text",
    "NX_DATE_TIME": "date and time",
    "NX_FLOAT": "number",
    "NX_INT": "whole number",
    "NX_POSINT": "whole number",
    "NX_BINARY": "bytes",
    "NX_CHAR_OR_NUMBER": "numbers or texts",
}
_INTRO = """\
Each run is one HDF5 file, and each study is one file in `studies/`; all files follow the rules of
[NeXus](https://www.nexusformat.org). The permitted content is declared in the NeXus application definition whose name
is in the field `/entry/definition`. `tribopipe verify` checks files against this definition, and this page is generated
from it. Fields in **bold** are always present.

A group of the class NXnote contains a document: `data` is its text, and `type` its media type, `application/json`. A
group of the class NXdata contains columns of numbers; its attributes `signal` and `axes` define the default plot.

"""
_EVERY_STEP = """\
Processing steps are groups of the class NXprocess. Each contains the fields below, and those listed for the step.

"""


def archive_page() -> str:
    """Return the page of all groups and fields of archived files."""
    text, told = titled(1, "The archived file", "archive-layout") + _INTRO, list[Part]()
    for definition in definitions().values():
        text += _file(definition, told)
        told += definition.entry.members
    return text


def _file(definition: Definition, told: list[Part]) -> str:
    """Tell what files of one kind hold, but for groups that were told already."""
    title, _, more = definition.doc.partition("\n\n")
    new = [part for part in definition.entry.members if part not in told]
    groups = [part for part in new if isinstance(part, GroupPart)]
    fields = [part for part in new if not isinstance(part, GroupPart)]
    steps = [part for part in groups if part.nx_class == "NXprocess"]
    common = [member for member in steps[0].members if all(member in step.members for step in steps)] if steps else []
    text = titled(2, code(definition.name)) + f"{_prose(title)} {_nxdl(definition)}\n\n{_prose(more)}\n\n"
    text += titled(3, code("/entry")) + f"{_prose(definition.entry.doc)}\n\n" + _table(fields)
    if known := [part.name for part in definition.entry.members if part in told and isinstance(part, GroupPart)]:
        text += f"Described above: {', '.join(code(name) for name in known)}.\n\n"
    for part in groups:
        if part not in steps:
            text += _section([part], part.members)
    if len(steps) > 1:
        text += titled(3, "Every step") + _EVERY_STEP + _table(common)
    for alike in _alike(steps):
        text += _section(alike, [member for member in alike[0].members if member not in common or len(steps) == 1])
    return text


def _nxdl(definition: Definition) -> str:
    name = f"{definition.name}.nxdl.xml"
    return f"For NeXus tools: {{download}}`{name} <../../schemas/{name}>`."


def _alike(steps: list[GroupPart]) -> list[list[GroupPart]]:
    """Put together the steps that hold the same, as those under different wear laws do."""
    found: dict[tuple[Part, ...], list[GroupPart]] = {}
    for step in steps:
        found.setdefault(step.members, []).append(step)
    return list(found.values())


def _section(groups: list[GroupPart], members: Iterable[Part]) -> str:
    names = ", ".join(code(f"/entry/{group.name or 'NAME'}") for group in groups)
    text = titled(3, names) + f"{groups[0].nx_class}. {' '.join(_prose(group.doc) for group in groups)}\n\n"
    return text if _is_document(groups[0]) else text + _table(members, in_data=groups[0].nx_class == "NXdata")


def _table(members: Iterable[Part], *, in_data: bool = False) -> str:
    return table(("Field", "Meaning", "Type", "Unit"), _rows(members, "", in_data=in_data)) + "\n"


def _rows(members: Iterable[Part], path: str, *, in_data: bool) -> Iterator[tuple[str, str, str, str]]:
    """Give a row for each field, those of groups within after the group itself."""
    for part in members:
        name = f"{path}{part.name or 'NAME'}"
        if isinstance(part, LinkPart):
            yield (
                code(name),
                "link",
                "",
                f"To {code(part.target.replace(':NXdata', '').replace('/NXentry', '/entry'))}.",
            )
        elif isinstance(part, FieldPart):
            yield _shown(name, part), _prose(part.doc), _held(part, in_data=in_data), ", ".join(part.units)
        else:
            yield _shown(name, part), _prose(part.doc), part.nx_class, ""
            if not _is_document(part):
                yield from _rows(part.members, f"{name}/", in_data=part.nx_class == "NXdata")


def _held(part: FieldPart, *, in_data: bool) -> str:
    if part.values:
        return " or ".join(map(code, part.values))
    return "column" if in_data and part.kind == "NX_FLOAT" else _KINDS[part.kind]


def _shown(name: str, part: FieldPart | GroupPart) -> str:
    return f"**{code(name)}**" if part.required else code(name)


def _is_document(group: GroupPart) -> bool:
    return group.nx_class == "NXnote" and [member.name for member in group.members] == ["type", "data"]


def _prose(text: str) -> str:
    return plain(" ".join(text.replace("``", "`").split()))
