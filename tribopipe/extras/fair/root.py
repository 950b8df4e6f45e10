"""Root of the graph of a crate, and the files that describe the crate.

The codebook has every column of its tables and every number of its results in one table. DataCite's fields are JSON
that repositories take with the files (schema.datacite.org, 4).
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any, NamedTuple

import orjson

from tribopipe.documents.dataset import Dataset, Funding, Organisation, Person
from tribopipe.extras.fair import provenance
from tribopipe.extras.fair.files import CSV, JSON
from tribopipe.extras.fair.graph import DATASET, Graph, Ref, local
from tribopipe.extras.fair.provenance import PROFILE, software
from tribopipe.extras.fair.runs import Described
from tribopipe.extras.fair.vocabulary import UNITS
from tribopipe.results.json_schema import schema_text
from tribopipe.version import VERSION
from tribopipe.views.csv_files import csv_lines

_HEAD = ("name", "unit", "UCUM", "QUDT", "meaning", "TriboDataFAIR")
_STANDARD_UNCERTAINTY = re.compile(r"\.standard_uncertainty$")


def codebook(described: Iterable[Mapping[str, Any]]) -> Iterator[bytes]:
    """Return as CSV what the quantities of a crate mean; each name stands there once."""
    rows: dict[tuple[str, str], list[str]] = {}
    for one in described:
        name, unit = str(one["propertyID"]), str(one.get("unitText", ""))
        if not _STANDARD_UNCERTAINTY.search(name):
            rows.setdefault((name, unit), [name, unit, *_beside(one, unit)])
    yield csv_lines([_HEAD, *(rows[key] for key in sorted(rows))])


def _beside(one: Mapping[str, Any], unit: str) -> Iterator[str]:
    known = UNITS.get(unit)
    yield (known and known.ucum) or ""
    yield str(one.get("unitCode", ""))
    yield " ".join(str(one.get("description", "")).split())
    yield str(one.get("identifier", ""))


_UNKNOWN = ":unav"
"""DataCite's own word for what is not known."""


def datacite(
    dataset: Dataset, *, title: str, description: str, keywords: Sequence[str], published: str
) -> dict[str, Any]:
    """Return the DataCite fields; required fields that are not stated are ":unav"."""
    said = {
        "schemaVersion": "http://datacite.org/schema/kernel-4",
        "types": {"resourceTypeGeneral": "Dataset", "resourceType": "Tribometer runs"},
        "doi": dataset.doi,
        "titles": [{"title": title}],
        "creators": [_creator(person) for person in dataset.creators] or [{"name": _UNKNOWN}],
        "publisher": _organisation(dataset.publisher, "publisher") if dataset.publisher else {"name": _UNKNOWN},
        "publicationYear": published[:4],
        "dates": [{"date": published, "dateType": "Issued"}],
        "language": dataset.language,
        "version": dataset.version,
        "descriptions": [
            {"description": description, "descriptionType": "Abstract"},
            {"description": f"Evaluated and packed by tribopipe {VERSION}.", "descriptionType": "TechnicalInfo"},
        ],
        "subjects": [{"subject": keyword} for keyword in keywords],
        "rightsList": [_rights(dataset.licence)] if dataset.licence else [],
        "fundingReferences": [_funding(one) for one in dataset.funding],
        "relatedIdentifiers": [
            {"relatedIdentifier": one.doi, "relatedIdentifierType": "DOI", "relationType": "IsSupplementTo"}
            for one in dataset.publications
        ],
        "formats": ["application/x-hdf5", "text/csv", "application/json"],
    }
    return {name: value for name, value in said.items() if value not in (None, [])}


def _creator(person: Person) -> dict[str, Any]:
    given = f", {person.given_name}" if person.given_name else ""
    said: dict[str, Any] = {
        "name": f"{person.family_name}{given}",
        "nameType": "Personal",
        "familyName": person.family_name,
    }
    if person.given_name:
        said["givenName"] = person.given_name
    if person.orcid:
        link = f"https://orcid.org/{person.orcid}"
        said["nameIdentifiers"] = [
            {"nameIdentifier": link, "nameIdentifierScheme": "ORCID", "schemeUri": "https://orcid.org"}
        ]
    if person.affiliation:
        said["affiliation"] = [_organisation(person.affiliation, "affiliation")]
    return said


def _organisation(one: Organisation, role: str) -> dict[str, str]:
    if one.ror is None:
        return {"name": one.name}
    scheme = {f"{role}IdentifierScheme": "ROR", "schemeUri": "https://ror.org"}
    return {"name": one.name, f"{role}Identifier": one.ror, **scheme}


def _rights(licence: str) -> dict[str, str]:
    return {
        "rights": licence,
        "rightsUri": f"https://spdx.org/licenses/{licence}",
        "rightsIdentifier": licence,
        "rightsIdentifierScheme": "SPDX",
        "schemeUri": "https://spdx.org/licenses/",
    }


def _funding(one: Funding) -> dict[str, str]:
    said = {"funderName": one.funder.name, "awardNumber": one.award, "awardTitle": one.title}
    if one.funder.ror:
        said |= {"funderIdentifier": one.funder.ror, "funderIdentifierType": "ROR"}
    return {name: value for name, value in said.items() if value is not None}


_SCHEMA = re.compile(r"about/schemas/([^/]+)\.schema\.json")
_KEYWORDS = ("tribology", "wear", "friction", "tribometer")


class _Summary(NamedTuple):
    """Description of the crate for every format: from dataset.toml, or else from its content."""

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
    summary, author = _summary(described, dataset, now), provenance.author(graph, dataset)
    creators = [provenance.person(graph, one) for one in dataset.creators]
    about = graph.folder_of(
        "about",
        list(_about(graph, summary, dataset, document)),
        name="About this data set",
        description="Documentation of the files: codebook, schemas, and the metadata that repositories require.",
        author=author,
    )
    graph.describe(
        name=summary.title,
        description=summary.description,
        datePublished=summary.published,
        license=provenance.licence(graph, dataset),
        creator=creators,
        author=author if one_author else creators,
        publisher=provenance.organisation(graph, dataset.publisher) if dataset.publisher else None,
        keywords=", ".join(summary.keywords),
        version=dataset.version,
        identifier=f"https://doi.org/{dataset.doi}" if dataset.doi else None,
        inLanguage=dataset.language,
        funder=[provenance.organisation(graph, one.funder) for one in dataset.funding],
        funding=[provenance.grant(graph, one) for one in dataset.funding],
        citation=[provenance.publication(graph, one) for one in dataset.publications],
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
    meant = "all columns and keys: units, meanings, identifiers"
    yield graph.file("about/codebook.csv", meanings, description=meant, encodingFormat=CSV)
    fields = orjson.dumps(datacite(dataset, **summary._asdict()), option=orjson.OPT_INDENT_2)
    yield graph.file("about/datacite.json", [fields, b"\n"], description="DataCite fields", encodingFormat=JSON)
    if document is not None:
        said = "description by the laboratory"
        yield graph.file(DATASET, [document], description=said, encodingFormat="application/toml")
