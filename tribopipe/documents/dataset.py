"""dataset.toml: what a lab states about runs it publishes, as repositories and DataCite ask for it."""

from collections.abc import Mapping
from datetime import date
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from tribopipe.documents.identifiers import Doi, Licence, Orcid, Ror
from tribopipe.documents.record import Record

DATASET_NAME = "dataset.toml"
_Line = Annotated[str, Field(min_length=1, max_length=5000)]


def _by_name(written: Any) -> Any:
    return {"name": written} if isinstance(written, str) else written


class Organisation(Record):
    """An institution; where only its name is known, the name alone stands for it."""

    name: _Line
    """Name as it writes itself."""
    ror: Ror | None = None
    """Its link in the registry of research organisations, ror.org."""


Institution = Annotated[Organisation, BeforeValidator(_by_name, json_schema_input_type=str | Organisation)]


class Person(Record):
    """Someone who made the data."""

    family_name: _Line
    """Family name."""
    given_name: _Line | None = None
    """Given names."""
    orcid: Orcid | None = None
    """ORCID, as digits or as a link."""
    affiliation: Institution | None = None
    """Where they work."""
    operator: tuple[_Line, ...] = ()
    """What run.toml calls them as operator, by which they are known as those who ran a test."""

    @property
    def name(self) -> str:
        """Full name, given names first."""
        return " ".join(part for part in (self.given_name, self.family_name) if part)


class Apparatus(Record):
    """A tribometer, as far as run.toml does not determine it."""

    name: _Line
    """Its name, as run.toml has it as instrument."""
    manufacturer: _Line | None = None
    """Who built it."""
    model: _Line | None = None
    """Type."""
    serial_number: _Line | None = None
    """Which one of its type."""
    identifier: Annotated[str, Field(pattern=r"^https?://\S+$")] | None = None
    """Link that stays, such as a handle by PIDINST."""


class Funding(Record):
    """Who paid."""

    funder: Institution
    """Who gave the grant."""
    award: _Line | None = None
    """Number of the grant."""
    title: _Line | None = None
    """Title of the grant."""


class Publication(Record):
    """A paper that the data belong to."""

    doi: Doi
    """DOI, as digits or as a link."""
    citation: _Line | None = None
    """The paper as it is cited."""


class Dataset(Record):
    """Runs that are published together."""

    schema_version: Literal["tribopipe.dataset/1"] = Field(alias="schema")
    """Version of this document."""
    title: _Line | None = None
    """Title under which it is cited."""
    description: _Line | None = None
    """What was done and why, in a few sentences."""
    creators: tuple[Person, ...] = ()
    """Who is to be cited, in order."""
    licence: Licence | None = None
    """Under which others may use it, as spdx.org/licenses writes it: "CC-BY-4.0"."""
    keywords: tuple[_Line, ...] = ()
    """Next to those that the runs give."""
    version: _Line | None = None
    """Version of the data set."""
    published: date | None = None
    """Day of publication; that of the export by default."""
    publisher: Institution | None = None
    """Repository or institution that publishes it."""
    doi: Doi | None = None
    """DOI of the data set, where it has one already."""
    language: Annotated[str, Field(pattern="^[a-z]{2,3}$")] = "en"
    """Language of the texts, ISO 639."""
    instruments: tuple[Apparatus, ...] = ()
    """Tribometers."""
    funding: tuple[Funding, ...] = ()
    """Grants."""
    publications: tuple[Publication, ...] = ()
    """Papers that the data belong to."""

    def lacking(self) -> list[str]:
        """Name what repositories ask for and the document does not state, as its keys."""
        wanted: Mapping[str, object] = {
            "title": self.title,
            "description": self.description,
            "licence": self.licence,
            "creators": self.creators,
        }
        without = [f"the orcid of {person.name}" for person in self.creators if person.orcid is None]
        return [*(key for key, said in wanted.items() if not said), *without]

    def operated_by(self, operator: str | None) -> Person | None:
        """Return the creator whom run.toml names as operator; none where it is nobody of them."""
        known = {name.casefold(): person for person in self.creators for name in (person.name, *person.operator)}
        return known.get((operator or "").casefold())

    def apparatus(self, name: str | None) -> Apparatus | None:
        """Return what is stated about an instrument of run.toml; none where nothing is."""
        return next((one for one in self.instruments if one.name == name), None)


NOTHING_SAID = Dataset(schema="tribopipe.dataset/1")
"""What an export has where there is no dataset.toml."""
