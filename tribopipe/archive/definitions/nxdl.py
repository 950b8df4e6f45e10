"""All definitions that archived files follow, by name, and as NXDL, the XML that NeXus' own tools read."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from tribopipe.archive.definitions.entries import run_definition, study_definition
from tribopipe.archive.definitions.parts import Definition, FieldPart, GroupPart, LinkPart, Part, is_partial
from tribopipe.base.files import write_file
from tribopipe.documents.contact_kinds import contacts


@cache
def definitions() -> Mapping[str, Definition]:
    """Return each definition by its name."""
    found = (*map(run_definition, (*contacts(), None)), study_definition())
    return {definition.name: definition for definition in found}


_SPACE: Final = "http://definition.nexusformat.org/nxdl/3.1"
_INSTANCE: Final = "http://www.w3.org/2001/XMLSchema-instance"
_CATEGORIES = {
    "m": "NX_LENGTH",
    "um": "NX_LENGTH",
    "Pa": "NX_PRESSURE",
    "m^2": "NX_AREA",
    "m^3": "NX_VOLUME",
    "s": "NX_TIME",
    "kg": "NX_MASS",
    "kg/m^3": "NX_MASS_DENSITY",
    "K": "NX_TEMPERATURE",
    "1/s": "NX_FREQUENCY",
    "1": "NX_DIMENSIONLESS",
}
"""NeXus' name for what a unit measures; where it has none, the unit itself stands as an example of such."""


def definition_files() -> dict[str, Definition]:
    """Return which definition each file holds."""
    return {f"{name}.nxdl.xml": definition for name, definition in definitions().items()}


def write_definitions(folder: Path) -> list[Path]:
    """Write every definition into a folder and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {folder / file: nxdl_text(definition) for file, definition in definition_files().items()}
    for path, text in texts.items():
        write_file(path, text.encode("utf-8"))
    return list(texts)


def nxdl_text(definition: Definition) -> str:
    """Return a definition as the file holds it."""
    root = Element(
        "definition",
        {
            "xmlns": _SPACE,
            "xmlns:xsi": _INSTANCE,
            "xsi:schemaLocation": f"{_SPACE} ../nxdl.xsd",
            "name": definition.name,
            "type": "group",
            "category": "application",
            "extends": "NXobject",
        },
    )
    _say(root, f"{definition.doc}\n\nVersion {definition.version}, written by tribopipe schema export.")
    _add_group(root, definition.entry)
    indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{tostring(root, encoding="unicode")}\n'


def _add(parent: Element, part: Part) -> None:
    if isinstance(part, GroupPart):
        _add_group(parent, part)
    elif isinstance(part, FieldPart):
        _add_field(parent, part)
    else:
        SubElement(parent, "link", {"name": part.name, "target": part.target})


def _add_group(parent: Element, part: GroupPart) -> None:
    made = SubElement(parent, "group", {**_named(part), "type": part.nx_class, **_occurs(part)})
    _say(made, part.doc)
    if is_partial(part.name):
        return  # no tool reads on in a group whose name it does not know
    _add_attributes(made, ("signal", "axes", *part.attributes) if part.nx_class == "NXdata" else part.attributes)
    for kind in (GroupPart, FieldPart, LinkPart):
        for member in part.members:
            if isinstance(member, kind):
                _add(made, member)


def _add_field(parent: Element, part: FieldPart) -> None:
    units = {"units": _units(part.units)} if part.units else {}
    made = SubElement(parent, "field", {**_named(part), "type": part.kind, **units, **_occurs(part)})
    _say(made, part.doc)
    _add_attributes(made, part.attributes)
    if part.values:
        listed = SubElement(made, "enumeration")
        for value in part.values:
            SubElement(listed, "item", {"value": value})


def _named(part: FieldPart | GroupPart) -> dict[str, str]:
    if not part.name:
        return {}
    return {"name": part.name} | ({"nameType": "partial"} if is_partial(part.name) else {})


def _add_attributes(parent: Element, names: Sequence[str]) -> None:
    for name in names:
        SubElement(parent, "attribute", {"name": name})


def _occurs(part: FieldPart | GroupPart) -> dict[str, str]:
    return {} if part.required else {"optional": "true"}


def _units(units: Sequence[str]) -> str:
    return _CATEGORIES.get(units[0], units[0]) if len(units) == 1 else "NX_ANY"


def _say(parent: Element, doc: str) -> None:
    SubElement(parent, "doc").text = doc
