"""Pages of the documents that people write, and of the records that tribopipe writes, read from their JSON Schemas."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from site_parts.markdown import code, indexed, plain, table, titled
from site_parts.words import Schema, default, name_of, words
from tribopipe.documents.record import Record
from tribopipe.results.json_schema import SCHEMAS

_REPOSITORY = Path(__file__).parents[2]
_TOP = "Top level"


@dataclass(frozen=True)
class Document:
    """A document that people write, and what a reader should know about it in addition to its keys."""

    name: str
    """As people call it: run.toml."""
    intro: str
    example: str | None = None
    """A file of the repository."""


DOCUMENTS = {
    "run": Document(
        "run.toml",
        "Describes one test: specimens, conditions, recorded signals and post-test measurements. "
        "[tribopipe new](../new_run.md) creates this file in the folder of the test. See also "
        "[post-test measurements](../end_values.md) and [twin-disc tests](../twin_disc.md).",
        "sample_runs/si3n4-air-200mN/run.toml",
    ),
    "template": Document(
        "lab.toml, a template",
        "The entries that are the same for all runs of a lab. [tribopipe new](../new_run.md) and "
        "[tribopipe watch](../watch.md) copy them into each run.toml.",
    ),
    "reader": Document(
        "Reader description",
        "Describes a text format that tribopipe does not recognize, such as that of a custom-built instrument. "
        "[Read an export in an unknown format](../readers.md) explains an example.",
    ),
    "recipe": Document(
        "recipe.toml",
        "Defines how runs are processed. `correct-drift`, `fit`, `predict`, `process` and other commands accept "
        "`--recipe recipe.toml`. [Preprocessing](../clean_up.md) and [uncertainty of k_D](../uncertainty.md) explain "
        "the settings.",
    ),
    "study": Document(
        "study.toml",
        "Lists the runs from which k_D is identified and those that are predicted with it: [studies](../studies.md).",
        "sample_runs/si3n4-air.study.toml",
    ),
    "sweep": Document(
        "sweep.toml",
        "Defines a computation that is repeated for every combination of values. The page on [sweeps](../sweep.md) "
        "contains an example of each kind.",
    ),
    "plan": Document(
        "plan.toml",
        "Describes simulated tests: `tribopipe simulate FOLDER --plan plan.toml`. "
        "{download}`sample_runs/plan.toml <../../sample_runs/plan.toml>` is a complete example.",
    ),
    "dataset": Document(
        "dataset.toml",
        "Metadata of published runs, such as title, people and license. The file is next to the archive folder, and "
        "[tribopipe export dataset](commands.md#tribopipe-export-dataset) includes the metadata in every export.",
    ),
    "report": Document(
        "report.toml",
        "Particulars of a test report: laboratory, customer, samples, standard and signatories. "
        "`tribopipe report --details report.toml` includes them in the report: [reports](../report.md).",
    ),
}
RESULTS = [name for name in SCHEMAS if name not in DOCUMENTS]


@dataclass(frozen=True)
class _Part:
    """A table of a document."""

    path: str
    """Where it stands, as the document writes it: [conditions]."""
    schema: Schema

    variant: str | None = None
    """What tells it from other tables at the same place: pin-on-disc."""

    @property
    def title(self) -> str:
        """Heading of its section."""
        place = self.path if self.path == _TOP else code(self.path)
        return f"{place} {self.variant}" if self.variant else place

    @property
    def slug(self) -> str:
        """Its title as a part of an address."""
        return re.sub(r"[^a-z0-9]+", "-", self.title.lower()).strip("-")


@dataclass
class _Parts:
    """The tables of a document in the order they are met, each once."""

    label: str
    whole: _Part
    definitions: dict[str, Schema]
    found: dict[str, _Part] = field(default_factory=dict)

    def add(self, path: str, name: str) -> None:
        """Add a table by its place and the name of its definition."""
        schema = self.definitions[name]
        kinds = [str(rules["const"]) for rules in schema.get("properties", {}).values() if "const" in rules]
        is_second = any(part.path == path for part in self.found.values())
        self.found[name] = _Part(path, schema, kinds[0] if kinds else f"({name})" if is_second else None)

    def told(self, name: str) -> str:
        """Link to a table by the name of its definition."""
        if name == "Quantity":
            return "[quantity](quantities.md)"
        part = self.found[name]
        return f"[{code(part.variant or part.path)}](#{self.label_of(part)})"

    def label_of(self, part: _Part) -> str:
        """Return what other pages find a table by."""
        return f"{self.label}-{part.slug}"


def document_page(name: str) -> str:
    """Return the page of a document: an example, then the keys of each of its tables."""
    document = DOCUMENTS[name]
    text = titled(1, document.name, f"document-{name}") + f"{document.intro}\n\n"
    text += (
        f"JSON Schema for editors: {{download}}`{name}.schema.json <../../schemas/{name}.schema.json>`. "
        "Keys marked **required** must be present.\n\n"
    )
    if document.example is not None:
        content = (_REPOSITORY / document.example).read_text(encoding="utf-8")
        text += f"```toml\n{content}```\n\n"
    return text + _tables(name, document.name.split(",")[0])


def results_page() -> str:
    """Return the page of the records that tribopipe writes."""
    text = titled(1, "Results", "results") + (
        "Results of steps and studies, as printed by `--json` and stored in the archive as the `result` of each step, "
        "and the `truth.json` of simulated runs. Each quantity is a table with `value`, `unit` (SI) and "
        "`standard_uncertainty`.\n\n"
    )
    return text + "".join(titled(2, name.replace("-", " ").capitalize()) + _tables(name, name) for name in RESULTS)


def place_of(record: type[Record]) -> str | None:
    """Return the label of the table of a record's keys, none where no page has one."""
    for name, whole in SCHEMAS.items():
        if whole is record:
            return f"{name}-top-level"
    for name, whole in SCHEMAS.items():
        parts = _parts(name, whole)
        if record.__name__ in parts.found:
            return parts.label_of(parts.found[record.__name__])
    return None


def _tables(name: str, document: str) -> str:
    record = SCHEMAS[name]
    parts = _parts(name, record)
    return "".join(_table(part, parts, document) for part in (parts.whole, *parts.found.values()))


@cache
def _parts(name: str, record: type[Record]) -> _Parts:
    schema = record.model_json_schema(by_alias=True)
    parts = _Parts(name, _Part(_TOP, schema), schema.get("$defs", {}))
    for path, inner in _inner(schema, parts.definitions, (), is_toml=name in DOCUMENTS):
        if inner not in parts.found:
            parts.add(path, inner)
    return parts


def _inner(
    schema: Schema, definitions: dict[str, Schema], path: tuple[str, ...], *, is_toml: bool
) -> Iterator[tuple[str, str]]:
    """Give each table within a table by its place and the name of its definition, depth first."""
    for key, rules in schema.get("properties", {}).items():
        for steps, name, many in _referred(rules, (*path, key)):
            if name != "Quantity":
                yield _written(".".join(steps), many=many, is_toml=is_toml), name
                yield from _inner(definitions[name], definitions, steps, is_toml=is_toml)


def _referred(
    rules: Schema, path: tuple[str, ...], *, many: bool = False
) -> Iterator[tuple[tuple[str, ...], str, bool]]:
    """Give the definitions that a key refers to, with the path to them and whether there may be many."""
    if "$ref" in rules:
        yield path, name_of(rules), many
    for choice in (*rules.get("anyOf", ()), *rules.get("oneOf", ()), *rules.get("prefixItems", ())):
        yield from _referred(choice, path, many=many)
    if "items" in rules:
        yield from _referred(rules["items"], path, many=True)
    if isinstance(inner := rules.get("additionalProperties"), dict):
        yield from _referred(inner, (*path, "…"))


def _written(dotted: str, *, many: bool, is_toml: bool) -> str:
    if not is_toml:
        return dotted
    return f"[[{dotted}]]" if many else f"[{dotted}]"


def _table(part: _Part, parts: _Parts, document: str) -> str:
    keys, label = part.schema.get("properties", {}), parts.label_of(part)
    rows = [
        (
            f"{code(key)}{{#key-{label}-{key}}}",
            _meaning(rules, parts),
            words(rules, parts.told),
            "**required**" if key in part.schema.get("required", ()) else default(rules),
        )
        for key, rules in keys.items()
    ]
    return (
        titled(3 if parts.label in RESULTS else 2, part.title, label)
        + indexed(f"{key}; {document}" for key in keys)
        + f"{plain(_described(part.schema))}\n\n"
        + table(("Key", "Meaning", "Type", "Default"), rows)
        + "\n"
    )


def _meaning(rules: Schema, parts: _Parts) -> str:
    """Return the meaning of a key; of a table without a description here, the description of the table itself."""
    if "description" not in rules and "$ref" in rules:
        return plain(_described(parts.definitions[name_of(rules)]))
    return plain(_described(rules))


def _described(schema: Schema) -> str:
    return str(schema.get("description", "")).replace("``", "`")
