"""Particulars of a report: laboratory, customer, samples, standard, dates (ISO/IEC 17025:2017, 7.8.2)."""

import base64
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from tribopipe.archive.outline import RunOutline
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.report_details import ReportDetails, Samples, StandardName


@dataclass(frozen=True)
class Standard:
    """A standard test method."""

    number: str
    """Number, such as ASTM G99."""
    title: str
    """Title."""
    own_parameters: str
    """Published results with which tests under its own parameters can be compared."""


STANDARDS: dict[str, Standard] = {
    "g99": Standard(
        "ASTM G99",
        "Wear and Friction Testing with a Pin-on-Disk or Ball-on-Disk Apparatus",
        "interlaboratory data of the standard",
    ),
    "g133": Standard(
        "ASTM G133", "Linearly Reciprocating Ball-on-Flat Sliding Wear", "results of procedures A and B of the standard"
    ),
    "g77": Standard(
        "ASTM G77",
        "Ranking Resistance of Materials to Sliding Wear Using Block-on-Ring Wear Test",
        "interlaboratory data of the standard",
    ),
    "d4172": Standard(
        "ASTM D4172",
        "Wear Preventive Characteristics of Lubricating Fluid (Four-Ball Method)",
        "results under test conditions A and B of the standard",
    ),
    "d5183": Standard(
        "ASTM D5183",
        "Determination of the Coefficient of Friction of Lubricants Using the Four-Ball Wear Test Machine",
        "results under the test conditions of the standard",
    ),
    "d6425": Standard(
        "ASTM D6425",
        "Measuring Friction and Wear Properties of Extreme Pressure (EP) Lubricating Oils Using SRV Test Machine",
        "interlaboratory data of the standard",
    ),
    "iso20808": Standard(
        "ISO 20808",
        "Fine ceramics: Determination of friction and wear characteristics of monolithic ceramics by ball-on-disc "
        "method",
        "results under the test conditions of the standard",
    ),
    "iso7148": Standard(
        "ISO 7148",
        "Plain bearings: Testing of the tribological behavior of bearing materials",
        "results under the test conditions of the standard",
    ),
}
"""Titles and the two ways of following G99 (section 5.2): the public pages of ASTM International and of ISO."""


@dataclass(frozen=True)
class Particular:
    """One line about the report."""

    name: str
    value: str | None
    """None if it is missing."""
    key: str
    """Its key in report.toml."""


@dataclass(frozen=True)
class Addressed:
    """Particulars of a report, and whether it is for a customer."""

    details: ReportDetails | None = None
    logo: bytes | None = None
    logo_type: str = ""
    standard: StandardName | None = None
    """Takes precedence over that in the details."""
    for_customer: bool = False
    """Without advice to the laboratory, its tags, notes and options."""

    @property
    def logo_address(self) -> str | None:
        """The logo as a data address."""
        return None if self.logo is None else f"data:{self.logo_type};base64,{base64.b64encode(self.logo).decode()}"

    @property
    def page_label(self) -> Markup:
        """The number of the report as CSS text: all characters except letters, digits and hyphens by their code."""
        number = (self.details and self.details.number) or ""
        return Markup(re.sub(r"[^A-Za-z0-9-]", lambda found: f"\\{ord(found[0]):x} ", number))  # noqa: S704, escaped

    def standard_of(self, manifests: Sequence[RunManifest]) -> Standard:
        """Return the requested standard, by default that of the contact, or G133 if all runs are reciprocating."""
        if asked := self.standard or (self.details and self.details.standard):
            return STANDARDS[asked]
        if all(manifest.conditions.stroke or manifest.conditions.frequency for manifest in manifests):
            return STANDARDS["g133"]
        return STANDARDS[next((one.contact.standard for one in manifests if one.contact is not None), "g99")]

    def particulars(self, runs: Sequence[RunOutline]) -> list[Particular]:
        """Return the entries of the report and, unless it is for a customer, the missing ones.

        Nothing is stated, and nothing missed, without details.
        """
        if self.details is None:
            return []
        manifests = [run.manifest for run in runs]
        lines = _lines(self.details, self.standard_of(manifests), manifests)
        return [line for line in lines if line.value is not None or not self.for_customer]


NOBODY = Addressed()
"""A report on tests only."""


def _lines(details: ReportDetails, standard: Standard, manifests: Sequence[RunManifest]) -> Iterator[Particular]:
    lab, customer, samples = details.lab, details.customer, details.samples or Samples()
    if lab is None or lab.address is None:
        yield Particular("laboratory", None, "lab.name" if lab is None else "lab.address")
    yield Particular("report number", details.number, "number")
    yield Particular("customer", _lines_of(customer.name, customer.address) if customer else None, "customer.name")
    if customer and customer.order:
        yield Particular("order", customer.order, "customer.order")
    yield Particular("samples", samples.description, "samples.description")
    yield Particular("samples received", _day(samples.received), "samples.received")
    for name in ("condition", "sampling"):
        if value := getattr(samples, name):
            yield Particular(name, value, f"samples.{name}")
    yield Particular("tests performed", _performed(manifests), "started")
    if lab and lab.location:
        yield Particular("location", lab.location, "lab.location")
    yield Particular("method", f"{standard.number}, {standard.title}", "standard")
    yield Particular("conformity", _followed(details, standard), "follows")
    if details.external:
        yield Particular("results from external providers", details.external, "external")
    yield Particular("issued", _day(details.issued), "issued")


def _followed(details: ReportDetails, standard: Standard) -> str:
    """State to what extent the tests followed the standard, in one of the two ways required by G99."""
    if details.follows == "all particulars":
        said = f"The tests followed {standard.number} in all particulars"
        return f"{said}, except: {details.deviations}" if details.deviations else f"{said}."
    said = (
        f"The tests followed the procedure of {standard.number} with the materials and parameters stated in this "
        f"report; their results cannot be compared with the {standard.own_parameters}."
    )
    return f"{said} Deviations: {details.deviations}" if details.deviations else said


def _performed(manifests: Sequence[RunManifest]) -> str | None:
    """Format the date of the tests, or the first and the last; None if the start of a run is missing."""
    days = sorted(manifest.started.date().isoformat() for manifest in manifests if manifest.started is not None)
    if len(days) < len(manifests):
        return None
    return days[0] if days[0] == days[-1] else f"{days[0]} to {days[-1]}"


def _day(day: object) -> str | None:
    return None if day is None else str(day)


def _lines_of(*texts: str | None) -> str:
    return "\n".join(text for text in texts if text)
