"""report.toml: the particulars of a test report, such as laboratory, customer, samples and signatories."""

from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from tribopipe.base.errors import ManifestError
from tribopipe.base.files import read_file
from tribopipe.documents.record import Record, read_document
from tribopipe.documents.toml import parse_toml, read_bytes

_Line = Annotated[str, Field(min_length=1, max_length=500)]
_Text = Annotated[str, Field(min_length=1, max_length=5000)]
_LOGO_TYPES = {".png": "image/png", ".svg": "image/svg+xml", ".jpg": "image/jpeg", ".jpeg": "image/jpeg"}
_LARGEST_LOGO = 1 << 20
StandardName = Literal["g99", "g133", "g77", "d4172", "d5183", "d6425", "iso20808", "iso7148"]


class Laboratory(Record):
    """The laboratory."""

    name: _Line
    """Name of the laboratory."""
    address: _Text | None = None
    """Postal address, one or more lines."""
    location: _Text | None = None
    """Place of the tests, if different from the laboratory."""
    contact: _Line | None = None
    """Telephone, e-mail or web address."""
    accreditation: _Line | None = None
    """Accreditation and its number."""
    logo: _Line | None = None
    """Name of a PNG, JPEG or SVG file in the folder of this document."""


class Customer(Record):
    """The customer."""

    name: _Line
    """Name of the customer."""
    address: _Text | None = None
    """Address or other contact."""
    order: _Line | None = None
    """Number of the order."""


class Samples(Record):
    """The samples received."""

    description: _Text | None = None
    """The specimens, and the identification of each."""
    received: date | None = None
    """Date of receipt."""
    condition: _Text | None = None
    """Condition on receipt."""
    sampling: _Text | None = None
    """Sampling plan and method, if the laboratory took the samples."""


class Signatory(Record):
    """A person who authorizes the report."""

    name: _Line
    """Name of the person."""
    role: _Line | None = None
    """Function in the laboratory."""


class ReportDetails(Record):
    """Particulars of a test report, as ISO/IEC 17025:2017, 7.8.2 requires them."""

    schema_version: Literal["tribopipe.report/1"] = Field(alias="schema")
    """Version of this document."""
    title: _Line | None = None
    """Title of the report."""
    number: _Line | None = None
    """Number of the report, printed on every page."""
    issued: date | None = None
    """Date of issue."""
    standard: StandardName | None = None
    """Standard test method; by default that of the contact: G99, G133, G77 or D4172."""
    follows: Literal["all particulars", "procedure"] = "procedure"
    """Whether the tests used the parameters of the standard, or its procedure with other parameters."""
    deviations: _Text | None = None
    """Additions to, deviations from, or exclusions from the standard."""
    external: _Text | None = None
    """Results from external providers."""
    lab: Laboratory | None = None
    """The laboratory."""
    customer: Customer | None = None
    """The customer."""
    samples: Samples | None = None
    """The samples received."""
    signatories: tuple[Signatory, ...] = Field(default=(), max_length=20)
    """Persons who authorize the report."""


def read_details(paths: Sequence[Path]) -> tuple[ReportDetails, bytes | None, str]:
    """Read the details of a report from one file, or several, of which later ones add to earlier ones.

    Parameters
    ----------
    paths
        TOML files, at least one, such as one of the laboratory and one of the order.

    Returns
    -------
    details
        All keys; where two files state one, the later file's.
    logo
        Content of the logo's file; None if none is named.
    logo_type
        Its media type.

    Raises
    ------
    ManifestError
        Where a file cannot be read, a key is unknown or wrong, or the logo is no picture of up to 1 MB.
    """
    together: dict[str, Any] = {}
    beside = paths[0].parent
    for path in paths:
        document = parse_toml(path, read_bytes(path))
        together = _added(together, document)
        if isinstance(lab := document.get("lab"), Mapping) and "logo" in lab:
            beside = path.parent
    details = read_document(together, ReportDetails, where=", ".join(map(str, paths)))
    logo = details.lab and details.lab.logo
    return (details, None, "") if not logo else (details, *_picture(beside / logo))


def _added(earlier: Mapping[str, Any], later: Mapping[str, Any]) -> dict[str, Any]:
    both = {key: {**earlier[key], **later[key]} for key in earlier if _are_tables(earlier[key], later.get(key))}
    return {**earlier, **later, **both}


def _are_tables(*values: object) -> bool:
    return all(isinstance(value, Mapping) for value in values)


def _picture(path: Path) -> tuple[bytes, str]:
    kind = _LOGO_TYPES.get(path.suffix.lower())
    if kind is None:
        raise ManifestError(
            f"{path}: found {path.suffix or 'no suffix'!r}; expected a logo in .png, .jpg or .svg format"
        )
    try:
        content = read_file(path)
    except OSError as error:
        raise ManifestError(
            f"{path}: cannot be read ({error.strerror}); expected a logo file; check lab.logo"
        ) from None
    if len(content) > _LARGEST_LOGO:
        raise ManifestError(f"{path}: found a logo of {len(content):,} bytes; expected at most {_LARGEST_LOGO:,}")
    return content, kind
