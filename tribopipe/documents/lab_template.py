"""lab.toml: what is the same in all runs of a lab, from which `tribopipe new` fills run.toml."""

from collections.abc import Collection, Container, Mapping
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, create_model
from pydantic.fields import FieldInfo

from tribopipe.base.errors import ManifestError
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import SHIPPED, kind_of, variants, with_a_pin
from tribopipe.documents.manifest import Conditions, EndValues, RunManifest, Sensors, SignalFile
from tribopipe.documents.record import Record, read_document
from tribopipe.documents.toml import parse_toml, read_bytes

_OF_ONE_RUN = ("id", "started", "interruptions")
_SECTIONS = ("schema_version", "contact", "conditions", "signals", "end_values", "sensors")


class _Part(Record):
    """Keys that have their descriptions from another record, so that none is looked for in the source."""

    model_config = ConfigDict(use_attribute_docstrings=False)

    @classmethod
    def known_in(cls, document: Mapping[str, Any], keys: Collection[str]) -> set[str]:
        """Return those keys that make sense with the contact of a template, in its names."""
        return RunManifest.known_in(document, keys)


def _optional(kind: Any, description: str | None, **rules: Any) -> Any:
    return (kind | None, Field(default=None, description=description, **rules))


def _as_it_is(key: FieldInfo) -> Any:
    return _optional(Annotated[key.annotation, *key.metadata] if key.metadata else key.annotation, key.description)


def _part_of(record: type[Record], without: Container[str] = (), **others: Any) -> type[Record]:
    """Make a record of the same keys, none of them needed; rules that bind several keys are left to run.toml."""
    keys = {name: _as_it_is(key) for name, key in record.model_fields.items() if name not in without}
    return create_model(f"{record.__name__}Template", __base__=_Part, __doc__=record.__doc__, **(keys | others))


def _contact(contact: type[Contact]) -> type[Record]:
    """Make the record of a kind of contact of which only the type of tribometer needs to be stated."""
    forms = variants(kind_of(contact))
    bodies: dict[str, Any] = {name: form.model_fields[name].annotation for form in forms for name in form.body_names}
    parts = {name: _optional(_part_of(body), body.__doc__) for name, body in bodies.items()}
    kind: Any = contact.model_fields["kind"]
    return _part_of(contact, without=bodies, kind=(kind.annotation, Field(description=kind.description)), **parts)


Template: type[Record] = _part_of(
    RunManifest,
    without=(*_OF_ONE_RUN, *_SECTIONS),
    schema_version=(Literal["tribopipe.template/1"], Field(alias="schema", description="Version of this document.")),
    contact=_optional(
        reduce(or_, map(_contact, SHIPPED.values())),
        "The two bodies; enter what is common to all runs.",
        discriminator="kind",
    ),
    conditions=_optional(_part_of(Conditions), "How tests are run."),
    signals=_optional(
        _part_of(SignalFile, without=("file", "files", "steps", "step_column")),
        "How every file is read, and what its columns mean.",
    ),
    end_values=_optional(_part_of(EndValues), "Post-test measurements on the specimens."),
    sensors=_optional(_part_of(Sensors), "Uncertainties of the sensors other than noise."),
)
"""Any part of a run.toml that is not of one run alone."""


def read_template(path: Path) -> dict[str, Any]:
    """Read a template as it is written; a ball in the place of a pin as a spherical pin of its diameter.

    Raises ``ManifestError`` with file, key (or line), what was found and what was expected.
    """
    document = parse_toml(path, read_bytes(path))
    read_document(document, Template, where=str(path))
    try:
        return document | {name: with_a_pin(part) for name, part in document.items() if name == "contact"}
    except ValueError as error:
        raise ManifestError(f"{path}: contact.{error}") from None
