"""What DataCite asks of a data set, as JSON that repositories take with the files (schema.datacite.org, 4)."""

from collections.abc import Sequence
from typing import Any

from tribopipe.documents.dataset import Dataset, Funding, Organisation, Person
from tribopipe.version import VERSION

_UNKNOWN = ":unav"
"""DataCite's own word for what is not known."""


def datacite(
    dataset: Dataset, *, title: str, description: str, keywords: Sequence[str], published: str
) -> dict[str, Any]:
    """Return the fields of DataCite; required fields that are not stated is ":unav"."""
    said = {
        "schemaVersion": "http://datacite.org/schema/kernel-4",
        "types": {"resourceTypeGeneral": "Dataset", "resourceType": "Tribometer runs"},
        "doi": dataset.doi,
        "titles": [{"title": title}],
        "creators": [_creator(person) for person in dataset.creators] or [{"name": _UNKNOWN}],
        "publisher": _organisation(dataset.publisher) if dataset.publisher else {"name": _UNKNOWN},
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
        said["affiliation"] = [_affiliation(person.affiliation)]
    return said


def _affiliation(one: Organisation) -> dict[str, str]:
    if one.ror is None:
        return {"name": one.name}
    scheme = {"affiliationIdentifierScheme": "ROR", "schemeUri": "https://ror.org"}
    return {"name": one.name, "affiliationIdentifier": one.ror, **scheme}


def _organisation(one: Organisation) -> dict[str, str]:
    if one.ror is None:
        return {"name": one.name}
    scheme = {"publisherIdentifierScheme": "ROR", "schemeUri": "https://ror.org"}
    return {"name": one.name, "publisherIdentifier": one.ror, **scheme}


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
