"""What the file of a study holds: see ``tribopipe.archive.studyfile``."""

from functools import cache

from tribopipe.archive.definitions.common import defined, document, process, text
from tribopipe.archive.definitions.names import STUDY
from tribopipe.archive.definitions.parts import Definition, FieldPart, GroupPart
from tribopipe.archive.formats import STUDY_FORMAT
from tribopipe.documents.contact_kinds import contacts
from tribopipe.documents.signals import SIGNALS

_DOC = """Wear tests under one law: what some identify, others have to follow.

Curves are wear depths in µm or wear volumes in mm^3 of a body, against the sliding distance or the rotations."""


@cache
def study_definition() -> Definition:
    """Return what files of studies hold."""
    archived = (text("format", "Format of the file."), text("inputs_sha256", "SHA-256 of all it was made from."))
    members = (
        text("title", "One line about the study."),
        defined(STUDY),
        text("identifier_study", "Id of the study."),
        GroupPart("archived", "NXcollection", "How the study was archived.", archived, required=True),
        process("process", "How the study was computed.", required=True),
        document("study", "study.toml: which runs identify k_D, and which are predicted."),
        document("result", "Result with all digits."),
        document("options", "Recipe that was used."),
        document("stands_on", "SHA-256 of each run as ingested.", required=False),
        _curve(),
    )
    entry = GroupPart("entry", "NXentry", "One study.", members, required=True, attributes=("default",))
    return Definition(STUDY, STUDY_FORMAT.version, _DOC, entry)


def _curve() -> GroupPart:
    worn, kinds = ("um", "mm^3"), contacts().values()
    members = (
        text("title", "Title of the plot."),
        text("run_id", "The run."),
        text("model", "Wear law."),
        FieldPart("role", "What the run is for.", required=True, values=("fitted", "predicted")),
        FieldPart(
            "body",
            "Which body.",
            required=True,
            values=tuple(dict.fromkeys(name for one in kinds for name in one.fitted_bodies)),
        ),
        FieldPart("what", "What the curve is of.", required=True, values=("wear_depth", "wear_volume")),
        *(
            FieldPart(along.signal, f"Places along the test, {along.words}.", "NX_FLOAT", (SIGNALS[along.signal].unit,))
            for along in dict.fromkeys(one.progress for one in kinds)
        ),
        FieldPart("measured", "Wear as measured.", "NX_FLOAT", worn),
        FieldPart("predicted", "Wear by the law.", "NX_FLOAT", worn, required=True),
        FieldPart("lower", "Lower end of the 95 % interval of predicted.", "NX_FLOAT", worn, required=True),
        FieldPart("upper", "Upper end of the 95 % interval of predicted.", "NX_FLOAT", worn, required=True),
        FieldPart("measurement_lower", "Above it lie 97.5 % of measurements.", "NX_FLOAT", worn),
        FieldPart("measurement_upper", "Below it lie 97.5 % of measurements.", "NX_FLOAT", worn),
    )
    return GroupPart("", "NXdata", "One body of a run under one law.", members)
