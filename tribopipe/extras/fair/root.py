"""What a crate is as a whole: the root of its graph, and the files that are about it."""

import re
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from typing import NamedTuple

import orjson

from tribopipe.documents.dataset import Dataset
from tribopipe.extras.fair import people
from tribopipe.extras.fair.codebook import codebook
from tribopipe.extras.fair.datacite import datacite
from tribopipe.extras.fair.graph import Graph, Ref, local
from tribopipe.extras.fair.layout import DATASET
from tribopipe.extras.fair.parts import CSV, JSON
from tribopipe.extras.fair.provenance import PROFILE, software
from tribopipe.extras.fair.runs import Described
from tribopipe.results.json_schema import schema_text
from tribopipe.version import VERSION

_SCHEMA = re.compile(r"about/schemas/([^/]+)\.schema\.json")
_KEYWORDS = ("tribology", "wear", "friction", "tribometer")


class _Summary(NamedTuple):
    """What is stated about the crate in every form: as dataset.toml has it, or else made of what is in it."""

    title: str
    description: str
    keywords: list[str]
    published: str
    """Day, ISO 8601."""


def describe_root(
    graph: Graph, described: Sequence[Described], dataset: Dataset, document: bytes | None, *, one_author: bool
) -> None:
    """Report what the crate is, who made it and what is in it; put in the files about it.

    ``document`` is the dataset.toml that ``dataset`` was read from; ``one_author`` names the first creator alone as
    author, as notebooks ask for.
    """
    now = datetime.now(UTC).isoformat(timespec="seconds")
    summary, author = _summary(described, dataset, now), people.author(graph, dataset)
    creators = [people.person(graph, one) for one in dataset.creators]
    about = graph.folder_of(
        "about",
        list(_about(graph, summary, dataset, document)),
        name="About this data set",
        description="What the files mean: codebook, schemas, and what repositories ask for.",
        author=author,
    )
    graph.describe(
        name=summary.title,
        description=summary.description,
        datePublished=summary.published,
        license=people.licence(graph, dataset),
        creator=creators,
        author=author if one_author else creators,
        publisher=people.organisation(graph, dataset.publisher) if dataset.publisher else None,
        keywords=", ".join(summary.keywords),
        version=dataset.version,
        identifier=f"https://doi.org/{dataset.doi}" if dataset.doi else None,
        inLanguage=dataset.language,
        funder=[people.organisation(graph, one.funder) for one in dataset.funding],
        funding=[people.grant(graph, one) for one in dataset.funding],
        citation=[people.publication(graph, one) for one in dataset.publications],
        conformsTo=graph.thing(PROFILE, "CreativeWork", name="Process Run Crate", version=PROFILE.rpartition("/")[2]),
        hasPart=[*(one.folder for one in described), about],
        mentions=[*(action for one in described for action in one.actions), _export(graph, now)],
    )
    graph.describe_metadata(
        version="1.0",
        dateCreated=now,
        sdPublisher=graph.thing(local("publisher", "tribopipe"), "Organization", name="tribopipe"),
    )


def _summary(described: Sequence[Described], dataset: Dataset, now: str) -> _Summary:
    words = (word for one in described for word in one.keywords)
    return _Summary(
        title=dataset.title or _title(described),
        description=dataset.description or _description(described),
        keywords=list(dict.fromkeys([*dataset.keywords, *_KEYWORDS, *words])),
        published=dataset.published.isoformat() if dataset.published else now[:10],
    )


def _title(described: Sequence[Described]) -> str:
    studies = [one.id for one in described if one.study]
    named = studies or [one.id for one in described]
    return f"Tribometer runs: {', '.join(named[:3])}{' and others' if len(named) > 3 else ''}"


def _description(described: Sequence[Described]) -> str:
    studies = sum(one.study for one in described)
    runs = len(described) - studies
    beside = f" and {studies} {'study' if studies == 1 else 'studies'}" if studies else ""
    return f"{runs} tribometer {'run' if runs == 1 else 'runs'}{beside}, as recorded and as evaluated by tribopipe."


def _export(graph: Graph, now: str) -> Ref:
    return graph.thing(
        "#export",
        "CreateAction",
        name="Export of the data set",
        description=f"tribopipe {VERSION}",
        instrument=software(graph, VERSION),
        result={"@id": "./"},
        endTime=now,
    )


def _about(graph: Graph, summary: _Summary, dataset: Dataset, document: bytes | None) -> Iterator[Ref]:
    """Put in what describes the crate: schemas of its JSON files, the codebook, DataCite's fields, dataset.toml."""
    for name in sorted(graph.followed(_SCHEMA)):
        yield graph.file(
            f"about/schemas/{name}.schema.json",
            [schema_text(name).encode("utf-8")],
            description=f"JSON Schema of {name}",
            encodingFormat="application/schema+json",
        )
    meanings = codebook(graph.things("PropertyValue"))
    meant = "every column and key: unit, meaning, identifiers"
    yield graph.file("about/codebook.csv", meanings, description=meant, encodingFormat=CSV)
    fields = orjson.dumps(datacite(dataset, **summary._asdict()), option=orjson.OPT_INDENT_2)
    yield graph.file("about/datacite.json", [fields, b"\n"], description="fields of DataCite", encodingFormat=JSON)
    if document is not None:
        said = "description by the laboratory"
        yield graph.file(DATASET, [document], description=said, encodingFormat="application/toml")
