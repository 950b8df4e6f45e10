"""Who made a data set, who paid, who publishes it, and under which license, as entities of a crate."""

from urllib.parse import quote

from tribopipe.documents.dataset import Dataset, Funding, Organisation, Person, Publication
from tribopipe.extras.fair.graph import Graph, Ref, local

_NOT_SAID = "No license is given: to use the data, ask their creators."


def person(graph: Graph, one: Person) -> Ref:
    """Describe a creator; an ORCID is their identifier."""
    identifier = f"https://orcid.org/{one.orcid}" if one.orcid else local("person", one.name)
    affiliation = organisation(graph, one.affiliation) if one.affiliation else None
    return graph.thing(
        identifier,
        "Person",
        name=one.name,
        givenName=one.given_name,
        familyName=one.family_name,
        affiliation=affiliation,
        identifier=identifier if one.orcid else None,
    )


def author(graph: Graph, dataset: Dataset) -> Ref | None:
    """Describe the first creator, for what takes one author alone."""
    return person(graph, dataset.creators[0]) if dataset.creators else None


def operator(graph: Graph, dataset: Dataset, name: str | None) -> Ref | None:
    """Describe who ran a test: a creator, or else somebody of whom run.toml states the name alone."""
    if not name:
        return None
    known = dataset.operated_by(name)
    return person(graph, known) if known else graph.thing(local("person", name), "Person", name=name)


def organisation(graph: Graph, one: Organisation) -> Ref:
    """Describe an institution; a ROR is its identifier."""
    return graph.thing(one.ror or local("organisation", one.name), "Organization", name=one.name, url=one.ror)


def licence(graph: Graph, dataset: Dataset) -> Ref:
    """Describe the license, or report that there is none."""
    if dataset.licence is None:
        return graph.thing("#no-licence", "CreativeWork", name="No license given", description=_NOT_SAID)
    iri = f"https://spdx.org/licenses/{dataset.licence}"
    description = f"The license that SPDX lists as {dataset.licence}."
    return graph.thing(
        iri, "CreativeWork", name=dataset.licence, description=description, identifier=dataset.licence, url=iri
    )


def grant(graph: Graph, one: Funding) -> Ref:
    """Describe a grant."""
    funder = organisation(graph, one.funder)
    name = one.title or one.award or f"Grant of {one.funder.name}"
    return graph.thing(local("grant", one.funder.name, name), "Grant", name=name, identifier=one.award, funder=funder)


def publication(graph: Graph, one: Publication) -> Ref:
    """Describe a paper that the data belong to."""
    iri = f"https://doi.org/{quote(one.doi, safe='/;()')}"
    return graph.thing(iri, "ScholarlyArticle", name=one.citation or one.doi, identifier=iri, url=iri)
