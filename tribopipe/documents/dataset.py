"""dataset.toml: what a lab states about runs it publishes, as repositories and DataCite ask for it.

Persistent identifiers of people, institutions, publications and licenses (ORCID, ROR, DOI, SPDX) are checked before
they are published.
"""

import re
from collections.abc import Mapping
from datetime import date
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field

from tribopipe.documents.record import Record

_ORCID = re.compile(r"(?:https?://(?:www\.)?orcid\.org/)?(\d{4})-?(\d{4})-?(\d{4})-?(\d{3}[\dXx])/?", re.ASCII)
_ROR = re.compile(r"(?:https?://ror\.org/)?(0[a-hj-km-np-tv-z0-9]{6}\d{2})/?", re.ASCII)
_DOI = re.compile(r"(?:https?://(?:dx\.)?doi\.org/|doi:\s*)?(10\.\d{4,9}/[!-~]{1,200})", re.ASCII | re.IGNORECASE)
_SPDX = re.compile(r"(?:https?://spdx\.org/licenses/)?([A-Za-z0-9][A-Za-z0-9.+-]{0,99}?)(?:\.html)?", re.ASCII)


def orcid_check_digit(digits: str) -> str:
    """Return the last character of an ORCID from the 15 digits before it: ISO 7064, MOD 11-2."""
    total = 0
    for digit in digits:
        total = (total + int(digit)) * 2
    rest = (12 - total % 11) % 11
    return "X" if rest == 10 else str(rest)


def orcid(text: str) -> str:
    """Return an ORCID as "0000-0002-1825-0097"; it may be written as a link.

    Raises ``ValueError`` where the text is none, or its check digit shows a mistyped one.
    """
    matched = _ORCID.fullmatch(text.strip())
    if matched is None:
        raise ValueError(f"found {text!r}; expected an ORCID iD such as '0000-0002-1825-0097'; look it up on orcid.org")
    found = "-".join(matched.groups()).upper()
    check = orcid_check_digit(found[:-1].replace("-", ""))
    if found[-1] != check:
        raise ValueError(
            f"found {text!r}, whose last digit is {found[-1]}, but the other digits require {check}; expected an "
            f"ORCID iD as shown on orcid.org; look for a mistyped digit"
        )
    return found


def ror(text: str) -> str:
    """Return the link of an institution in the registry ROR. Raises ``ValueError`` where the text is none."""
    matched = _ROR.fullmatch(text.strip())
    if matched is None:
        raise ValueError(
            f"found {text!r}; expected a ROR ID such as 'https://ror.org/04t3en479'; look up the institution on ror.org"
        )
    return f"https://ror.org/{matched[1]}"


def doi(text: str) -> str:
    """Return a DOI as "10.5281/zenodo.5720626", also from a link. Raises ``ValueError`` for any other text."""
    matched = _DOI.fullmatch(text.strip())
    if matched is None:
        raise ValueError(f"found {text!r}; expected a DOI such as '10.1038/s41597-022-01429-9'; copy it from the paper")
    return matched[1]


def spdx_licence(text: str) -> str:
    """Return the identifier of a license as SPDX writes it. Raises ``ValueError`` where SPDX does not list it."""
    from packaging.licenses import InvalidLicenseExpression, canonicalize_license_expression

    matched = _SPDX.fullmatch(text.strip())
    try:
        return str(canonicalize_license_expression(matched[1] if matched else ""))
    except InvalidLicenseExpression:
        raise ValueError(
            f"found {text!r}; expected a license identifier from spdx.org/licenses, such as 'CC-BY-4.0', 'CC0-1.0' or "
            "'ODbL-1.0'"
        ) from None


def _as_text(pattern: str, example: str) -> Any:
    return Field(json_schema_extra={"pattern": pattern, "examples": [example]})


Orcid = Annotated[str, AfterValidator(orcid), _as_text(r"\d{4}-?\d{4}-?\d{4}-?\d{3}[\dXx]/?$", "0000-0002-1825-0097")]
Ror = Annotated[str, AfterValidator(ror), _as_text("0[a-z0-9]{6}[0-9]{2}/?$", "https://ror.org/04t3en479")]
Doi = Annotated[str, AfterValidator(doi), _as_text(r"10\.\d{4,9}/\S+$", "10.1038/s41597-022-01429-9")]
Licence = Annotated[str, AfterValidator(spdx_licence), _as_text(r"[A-Za-z0-9.+-]+$", "CC-BY-4.0")]


DATASET_NAME = "dataset.toml"
_Line = Annotated[str, Field(min_length=1, max_length=5000)]


def _by_name(written: Any) -> Any:
    return {"name": written} if isinstance(written, str) else written


class Organisation(Record):
    """An institution; its name is sufficient."""

    name: _Line
    """Official name."""
    ror: Ror | None = None
    """Link in the registry of research organizations, ror.org."""


Institution = Annotated[Organisation, BeforeValidator(_by_name, json_schema_input_type=str | Organisation)]


class Person(Record):
    """A person who contributed to the data."""

    family_name: _Line
    """Family name."""
    given_name: _Line | None = None
    """Given names."""
    orcid: Orcid | None = None
    """ORCID, as digits or as a link."""
    affiliation: Institution | None = None
    """Affiliations."""
    operator: tuple[_Line, ...] = ()
    """Name under which run.toml lists this person as the operator of a test."""

    @property
    def name(self) -> str:
        """Full name, given names first."""
        return " ".join(part for part in (self.given_name, self.family_name) if part)


class Apparatus(Record):
    """Data of a tribometer that run.toml does not contain."""

    name: _Line
    """Name, as in the key instrument of run.toml."""
    manufacturer: _Line | None = None
    """Manufacturer."""
    model: _Line | None = None
    """Type."""
    serial_number: _Line | None = None
    """Serial number."""
    identifier: Annotated[str, Field(pattern=r"^https?://\S+$")] | None = None
    """Persistent identifier, such as a PIDINST handle."""


class Funding(Record):
    """Funder."""

    funder: Institution
    """Organization that awarded the grant."""
    award: _Line | None = None
    """Number of the grant."""
    title: _Line | None = None
    """Title of the grant."""


class Publication(Record):
    """A paper that the data belong to."""

    doi: Doi
    """DOI, as digits or as a link."""
    citation: _Line | None = None
    """Citation of the paper."""


class Dataset(Record):
    """Runs that are published together."""

    schema_version: Literal["tribopipe.dataset/1"] = Field(alias="schema")
    """Version of this document."""
    title: _Line | None = None
    """Title of the data set, as in a citation."""
    description: _Line | None = None
    """Description of the work and its purpose, in a few sentences."""
    creators: tuple[Person, ...] = ()
    """Authors, in the order of the citation."""
    licence: Licence | None = None
    """License: an identifier from spdx.org/licenses, such as "CC-BY-4.0"."""
    keywords: tuple[_Line, ...] = ()
    """Keywords in addition to those from the runs."""
    version: _Line | None = None
    """Version of the data set."""
    published: date | None = None
    """Day of publication; that of the export by default."""
    publisher: Institution | None = None
    """Repository or institution that publishes it."""
    doi: Doi | None = None
    """DOI of the data set, if it already has one."""
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
        """Return the creator whom run.toml names as operator; None if it is nobody of them."""
        known = {name.casefold(): person for person in self.creators for name in (person.name, *person.operator)}
        return known.get((operator or "").casefold())

    def apparatus(self, name: str | None) -> Apparatus | None:
        """Return what is stated about an instrument of run.toml; None if nothing is."""
        return next((one for one in self.instruments if one.name == name), None)


NOTHING_SAID = Dataset(schema="tribopipe.dataset/1")
"""Metadata of an export without dataset.toml."""
