"""What the file of a run holds, by the kind of its tribometer: see ``tribopipe.archive.runfile``."""

from functools import cache

from tribopipe.archive.definitions.common import banded, columns, document, drawn_against, text
from tribopipe.archive.definitions.computed import LAWS, steps
from tribopipe.archive.definitions.ingested import as_ingested, axis_of, earlier_manifests
from tribopipe.archive.definitions.names import run_name
from tribopipe.archive.definitions.parts import Definition, GroupPart, Part
from tribopipe.archive.formats import RUN_FORMAT
from tribopipe.documents.contact_kinds import contacts

_MORE = """

All numbers are in SI, those of the group ``wear`` in µm. k_D, the dimensional wear coefficient of the incremental
wear models, is in m^2/N: 1e-6 m^2/N are 1 mm^3/(N*mm), or 1000 mm^3/(N*m). Standard uncertainties are given by
``_errors``. What lies in ``raw``, ``recorded``, ``profiles`` and ``source_files`` is as it was ingested and never
changes; each NXprocess is a step that was computed from it, with all it stands on."""


@cache
def run_definition(tribometer: str | None) -> Definition:
    """Return what files of runs on a kind of tribometer hold; of runs without a contact where it is none."""
    later = (
        _wear_plot(tribometer),
        document("marks", "Who marked the run bad, or took that back, when and why.", required=False),
        document("annotations", "Tags and notes, each with who and when.", required=False),
        earlier_manifests(),
    )
    members = (*as_ingested(tribometer), *steps(tribometer), *later)
    entry = GroupPart("entry", "NXentry", "One run.", members, required=True, attributes=("default",))
    return Definition(run_name(tribometer), RUN_FORMAT.version, _what(tribometer) + _MORE, entry)


def _what(tribometer: str | None) -> str:
    if tribometer is None:
        return "Friction test whose two bodies are not described, and what was computed from it."
    return f"Wear test of {contacts()[tribometer].title}, and what was computed from it."


def _wear_plot(tribometer: str | None) -> GroupPart:
    corrected = {"wear_depth" if tribometer == "twin-disc" else "pin_wear_depth": "um"}
    curves = columns(corrected | banded(dict.fromkeys(LAWS, "um")), required=False)
    members: tuple[Part, ...] = (text("title", "Title of the plot."), *curves, drawn_against(axis_of(tribometer)))
    return GroupPart("wear", "NXdata", "Corrected wear and the laws fitted to it, for viewers.", members)
