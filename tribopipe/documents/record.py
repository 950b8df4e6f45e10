"""The ground every record stands on, and how a document that breaks its rules is reported.

A document may name what packages add: of documents that people write, only what is installed; of what is read back,
any such name.
"""

import json
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError, ValidationInfo
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from tribopipe.base.errors import ManifestError, did_you_mean, unknown_name
from tribopipe.base.plugins import names, not_installed
from tribopipe.documents.toml import parse_toml, read_bytes, shortened, written_key

WRITTEN_BY_PEOPLE = {"written_by_people": True}
"""Context in which a document is validated that people write."""


@dataclass(frozen=True)
class InstalledName:
    """Declare that a text names something of a group of entry points.

    An archive may come from a machine where more is installed, so that results are read whatever they name.
    """

    group: str
    what: str
    pattern: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of the text, which is then held against the names."""
        return core_schema.with_info_after_validator_function(self._checked, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return a schema that names what is installed here."""
        return {"type": "string", "enum": self.names()}

    def names(self) -> list[str]:
        """Return the names of what is installed."""
        return names(self.group)

    def _checked(self, name: str, info: ValidationInfo) -> str:
        if info.context == WRITTEN_BY_PEOPLE and name not in self.names():
            raise ValueError(not_installed(self.group, self.what, name))
        if not re.fullmatch(self.pattern, name):
            raise ValueError(
                f"found {name!r}, which is not a valid name for a {self.what}; expected lowercase letters, digits and "
                "_, not ending in flat; rename it"
            )
        return name


class Record(BaseModel):
    """A document that cannot change, refuses unknown keys, and describes each of its fields."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        use_attribute_docstrings=True,
        validate_default=True,
        populate_by_name=True,
    )

    def __repr__(self) -> str:
        """Return the record in one line: its own line where it has one, else its fields."""
        if type(self).__str__ is BaseModel.__str__:
            return super().__repr__()
        said = str(self)
        return f"<{type(self).__name__}: {said if len(said) <= _WIDEST else said[: _WIDEST - 1] + '…'}>"

    def __dir__(self) -> list[str]:
        """Return the names of the record's own, so that completion does not offer those of pydantic."""
        own = type(self).model_fields
        return [name for name in super().__dir__() if name in own or name not in _OF_ALL_RECORDS]

    if not TYPE_CHECKING:  # A type checker would take every name for an attribute.

        def __getattr__(self, name: str) -> Any:
            """Raise ``UnknownNameError``, which names the nearest attribute and all that there are."""
            if name.startswith("_") or hasattr(type(self), name):
                return super().__getattr__(name)
            own = [known for known in dir(self) if not known.startswith("_")]
            raise unknown_name(type(self).__name__, name, own)

    @classmethod
    def kinds(cls) -> "tuple[type[Record], ...]":
        """Return the records that a field of this type may hold: itself, unless other packages add kinds of it."""
        return (cls,)

    @classmethod
    def worded_for(cls, document: Mapping[str, Any], text: str) -> str:  # noqa: ARG003 - for those that need it
        """Return a message about a document in the names that it uses itself."""
        return text

    @classmethod
    def known_in(cls, document: Mapping[str, Any], keys: Collection[str]) -> set[str]:  # noqa: ARG003 - as above
        """Return those keys that make sense in a document, in the names that it uses itself."""
        return set(keys)


_WIDEST = 160
"""Letters of a record in one line."""
_OF_ALL_RECORDS = frozenset(name for name in dir(Record) if not name.startswith("__"))
R = TypeVar("R", bound=Record)


def load_toml(path: Path, record: type[R]) -> R:
    """Read a TOML file as a record.

    Raises ``ManifestError`` with file, key (or line), what was found and expected.
    """
    return read_document(parse_toml(path, read_bytes(path)), record, where=str(path))


def quoted(text: str) -> str:
    """Write a TOML string: its escapes are JSON's, and DEL has to be escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def read_document(document: Mapping[str, Any], record: type[R], *, where: str) -> R:
    """Validate a document; ``ManifestError`` names the first thing wrong and counts the rest."""
    try:
        return record.model_validate(document, context=WRITTEN_BY_PEOPLE)
    except ValidationError as error:
        problem = record.worded_for(document, first_problem(error, record, partial(record.known_in, document)))
        raise ManifestError(f"{where}: {problem}") from None


def first_problem(
    error: ValidationError, record: type[Record], known: Callable[[Collection[str]], set[str]] = set
) -> str:
    """Put the first problem of a validation in one sentence; ``known`` are the keys that it may offer."""
    problems = error.errors(include_url=False)
    # A mistyped key is both unknown and missing: the unknown one says more.
    first = next((problem for problem in problems if problem["type"] == "extra_forbidden"), problems[0])
    more = f" (and {len(problems) - 1} more)" if len(problems) > 1 else ""
    tags = {*_union_tags(record), "[key]"}
    location = tuple(step for step in first["loc"] if step not in tags)
    if "discriminator" in first.get("ctx", {}):
        location += (first["ctx"]["discriminator"].strip("'"),)
    key = _dotted(location)
    said = _sentence(first, location, record, known)
    return f"{key}: {said}{more}" if key else said


def _dotted(location: tuple[int | str, ...]) -> str:
    text = ""
    for step in location:
        text += f"[{step}]" if isinstance(step, int) else f".{written_key(step)}" if text else written_key(step)
    return text


def _sentence(
    problem: Any, location: tuple[int | str, ...], record: type[Record], known_in: Callable[[Collection[str]], set[str]]
) -> str:
    kind, found = problem["type"], problem["input"]
    if kind == "extra_forbidden":
        # A key that is none here may be one of another member of a union.
        keys = known_in(_keys_at(record, location[:-1]))
        return f"unknown key; {did_you_mean(str(location[-1]), keys - {str(location[-1])})}"
    if kind == "missing":
        return f"missing; add this key{_such_as(record, location)}"
    if kind == "tuple_type" and isinstance(found, Mapping):
        return f"found [{_dotted(location)}], a single table; expected a list of tables; write [[{_dotted(location)}]]"
    context = problem.get("ctx", {})
    if kind == "literal_error" and problem["loc"][-1] == "[key]":
        known = re.findall(r"'([^']*)'", context["expected"])
        return f"unknown key; {did_you_mean(str(found), known)}"
    if kind in ("union_tag_invalid", "union_tag_not_found", "literal_error"):
        expected = context.get("expected_tags") or context.get("expected", "")
        tag = context.get("discriminator", "").strip("'")
        named = found.get(tag, found) if isinstance(found, Mapping) else found
        return f"found {_brief(named)}; expected {expected or 'a known kind'}"
    message = str(problem["msg"]).removeprefix("Value error, ").removeprefix("Assertion failed, ")
    if kind == "value_error":
        return message
    return f"found {_brief(found)}; {message[:1].lower()}{message[1:]}"


def _brief(found: object) -> str:
    return shortened(repr(found))


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, Record):
        return list(annotation.kinds())
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if get_origin(annotation) in (Union, UnionType) or get_origin(annotation) is not None:
        return [model for argument in get_args(annotation) for model in _models(argument)]
    return []


def _union_tags(record: type[Record]) -> set[str]:
    """Discriminator values appear in pydantic's locations but are no keys of the document."""
    tags: set[str] = set()
    queue: list[type[BaseModel]] = [record]
    seen: set[type[BaseModel]] = set()
    while queue:
        model = queue.pop()
        if model in seen:
            continue
        seen.add(model)
        for field in model.model_fields.values():
            queue += _models(field.annotation)
            for told, union in [(field, field.annotation), *_annotated(field.annotation)]:
                if isinstance(told.discriminator, str):
                    for choice in _models(union):
                        tags.update(get_args(choice.model_fields[told.discriminator].annotation))
    return tags


def _annotated(annotation: Any) -> list[tuple[FieldInfo, Any]]:
    """Return the types within a type, such as the members of a tuple."""
    inner = get_args(annotation)
    here = [(told, inner[0]) for told in inner[1:] if isinstance(told, FieldInfo)]
    return here + [found for one in inner for found in _annotated(one)]


def _such_as(record: type[Record], location: tuple[int | str, ...]) -> str:
    """Give the example of a key, where its schema has one."""
    name = str(location[-1])
    for model in _models_at(record, location[:-1]):
        field = model.model_json_schema()["properties"].get(name, {})
        for example in field.get("examples", ()):
            value = example if re.fullmatch(r"[\d.]+", str(example)) else json.dumps(example)
            return f", such as {written_key(name)} = {value}"
    return ""


def _keys_at(record: type[Record], location: tuple[int | str, ...]) -> set[str]:
    models = _models_at(record, location)
    return {field.alias or name for model in models for name, field in model.model_fields.items()}


def _models_at(record: type[Record], location: tuple[int | str, ...]) -> list[type[BaseModel]]:
    models: list[type[BaseModel]] = [record]
    for step in location:
        if isinstance(step, int):
            continue
        models = [
            inner
            for model in models
            for name, field in model.model_fields.items()
            if step in (name, field.alias)
            for inner in _models(field.annotation)
        ]
    return models
