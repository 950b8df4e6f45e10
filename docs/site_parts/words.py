"""What a JSON Schema lets be written for a key, in words."""

from collections.abc import Callable
from typing import Any

from site_parts.markdown import code
from tribopipe.base.units import KINDS, show
from tribopipe.documents.signals import SIGNALS

Schema = dict[str, Any]
Told = Callable[[str], str]
"""What is said of another table, by the name of its definition."""
_KIND_BY_EXAMPLE = {kind.example: name for name, kind in KINDS.items()}
_PLAIN = {"integer": "whole number", "boolean": "`true` or `false`", "object": "table", "null": "`null`"}
_BOUNDS = {"minimum": "≥", "exclusiveMinimum": ">", "maximum": "≤", "exclusiveMaximum": "<"}


def words(schema: Schema, told: Told) -> str:
    """Say what a schema lets be written; ``told`` names other tables."""
    if "$ref" in schema:
        return told(name_of(schema))
    if quantity := _quantity(schema):
        return quantity
    if "const" in schema or "enum" in schema:
        return _one_of(schema.get("enum", [schema.get("const")]))
    if choices := schema.get("oneOf") or schema.get("anyOf"):
        return _either([words(choice, told) for choice in choices if choice.get("type") != "null"])
    return _of_type(schema, told)


def kind_of(schema: Schema) -> str | None:
    """Return the kind of number that a key holds, such as "length"; none where it holds something else."""
    choices = [choice for choice in schema.get("anyOf", ()) if choice.get("type") != "null"]
    if len(choices) == 1:
        return kind_of(choices[0])
    tables = [choice for choice in choices if "standard_uncertainty" in choice.get("properties", ())]
    return _KIND_BY_EXAMPLE[choices[0]["examples"][0]] if tables else None


def name_of(schema: Schema) -> str:
    """Return the name of the definition that is referred to."""
    return str(schema["$ref"]).rsplit("/", 1)[-1]


def toml(value: Any) -> str:
    """Write a value as a document has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict) and "unit" in value:
        return str(value["value"]) if value["unit"] == "1" else f'"{value["value"]:.15g} {value["unit"]}"'
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return str(value)


def default(schema: Schema) -> str:
    """Return the default of a key, or an empty text."""
    value = schema.get("default")
    if value in (None, [], {}) or (isinstance(value, dict) and "unit" not in value):
        return ""
    if isinstance(value, dict) and (kind := kind_of(schema)):
        return code(f'"{show(value["value"], None, value["unit"], KINDS[kind].shown)}"')
    if isinstance(value, list) and isinstance(value[0], dict):
        return ", ".join(code(next(iter(item.values()))) for item in value)
    return code(toml(value))


def _quantity(schema: Schema) -> str | None:
    kind = kind_of(schema)
    return f"[{kind}](quantities.md#{kind.replace(' ', '-')})" if kind else None


def _one_of(values: list[Any]) -> str:
    if set(values) == set(SIGNALS):
        return "[signal](quantities.md#signals)"
    return _either([code(toml(value)) for value in values])


def _either(choices: list[str]) -> str:
    *others, last = dict.fromkeys(choices)
    return f"{', '.join(others)} or {last}" if others else last


def _of_type(schema: Schema, told: Told) -> str:
    if "prefixItems" in schema:
        return f"two values: {_either([words(item, told) for item in schema['prefixItems']])}"
    if "items" in schema:
        return f"list of {words(schema['items'], told)}"
    if isinstance(inner := schema.get("additionalProperties"), dict):
        names = schema.get("propertyNames", {})
        return f"table: {words(names, told) if 'enum' in names else 'name'} = {words(inner, told)}"
    kind = schema.get("type")
    if kind == "string":
        return "date and time" if schema.get("format") == "date-time" else "text"
    if kind in ("number", "integer"):
        return " ".join((_PLAIN["integer"] if _is_whole(schema) else "number", *_bounds(schema)))
    return _PLAIN.get(str(kind), "any value")


def _is_whole(schema: Schema) -> bool:
    return schema["type"] == "integer" or schema.get("multipleOf") == 1


def _bounds(schema: Schema) -> list[str]:
    return [f"{sign} {schema[name]:g}" for name, sign in _BOUNDS.items() if name in schema]
