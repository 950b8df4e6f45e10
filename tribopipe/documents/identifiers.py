"""Persistent identifiers of people, institutions, publications and licenses, checked before they are published."""

import re
from typing import Annotated, Any

from pydantic import AfterValidator, Field

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
        raise ValueError(f"found {text!r}; expected an ORCID such as '0000-0002-1825-0097'; look it up on orcid.org")
    found = "-".join(matched.groups()).upper()
    check = orcid_check_digit(found[:-1].replace("-", ""))
    if found[-1] != check:
        raise ValueError(
            f"found {text!r}, whose last digit is {found[-1]}, but the other digits require {check}; expected an ORCID "
            "as orcid.org shows it; look for a mistyped digit"
        )
    return found


def ror(text: str) -> str:
    """Return the link of an institution in the registry ROR. Raises ``ValueError`` where the text is none."""
    matched = _ROR.fullmatch(text.strip())
    if matched is None:
        raise ValueError(f"found {text!r}; expected a ROR such as 'https://ror.org/04t3en479'; look it up on ror.org")
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
            f"found {text!r}; expected a license of spdx.org/licenses, such as 'CC-BY-4.0', 'CC0-1.0' or 'ODbL-1.0'"
        ) from None


def _as_text(pattern: str, example: str) -> Any:
    return Field(json_schema_extra={"pattern": pattern, "examples": [example]})


Orcid = Annotated[str, AfterValidator(orcid), _as_text(r"\d{4}-?\d{4}-?\d{4}-?\d{3}[\dXx]/?$", "0000-0002-1825-0097")]
Ror = Annotated[str, AfterValidator(ror), _as_text("0[a-z0-9]{6}[0-9]{2}/?$", "https://ror.org/04t3en479")]
Doi = Annotated[str, AfterValidator(doi), _as_text(r"10\.\d{4,9}/\S+$", "10.1038/s41597-022-01429-9")]
Licence = Annotated[str, AfterValidator(spdx_licence), _as_text(r"[A-Za-z0-9.+-]+$", "CC-BY-4.0")]
