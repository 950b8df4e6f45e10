"""What the file of a run holds of the steps it has been through."""

from collections.abc import Iterator

from tribopipe.archive.definitions.common import banded, columns, document, drawn_against, process, text
from tribopipe.archive.definitions.ingested import axis_of, signals
from tribopipe.archive.definitions.parts import FieldPart, GroupPart, Part
from tribopipe.archive.definitions.summaries import shown_fields
from tribopipe.archive.local_wear_tables import PLACES, local_wear_units
from tribopipe.archive.steps import LOCAL_WEAR, PREDICTIONS, STEPS, WEAR_FITS, StepName
from tribopipe.documents.contact_kinds import contacts
from tribopipe.documents.record import Record
from tribopipe.results.wear_prediction import OUTCOMES

LAWS = ("archard", "sarkar", "LAW")
"""tribopipe's own; the name of any other stands where LAW does."""
_UNDER_LAWS = (WEAR_FITS, PREDICTIONS, LOCAL_WEAR)
_TABLES = {
    "course": "Contact and wear during the test, with the Global Incremental Wear Model.",
    "fields": "Pressure and wear at each place of the surface.",
    "unworn_surface": "Gap between the two bodies before the test.",
}


def steps(tribometer: str | None) -> Iterator[GroupPart]:
    """Declare every step, none of which has to be there."""
    for name in STEPS:
        if _law(name) is None:
            yield _step(name, tribometer)
    for under in _UNDER_LAWS:
        for law in LAWS:
            yield _step(under[law], tribometer)


def _law(name: StepName) -> str | None:
    """Return the wear law of a step; none for steps without a law."""
    return next((law for under in _UNDER_LAWS if (law := under.law_of(name)) is not None), None)


def _step(name: StepName, tribometer: str | None) -> GroupPart:
    records, law = STEPS[name].records, _law(name)
    record = records[-1] if tribometer == "twin-disc" else records[0]
    hashes = (text("inputs_sha256", "Hash of all inputs."), text("result_sha256", "Hash of the result."))
    members = (
        FieldPart("sequence_index", "Place among the steps, from 1.", "NX_POSINT", required=True),
        GroupPart("fingerprints", "NXparameters", "SHA-256 by which a step is known.", hashes, required=True),
        document("result", "Result with all digits."),
        document("options", "Options of the step."),
        document("stands_on", "SHA-256 of each part that it was made from.", required=False),
        GroupPart("parameters", "NXparameters", "The result, field by field.", _own(record, tribometer), required=True),
    )
    doc = (record.__doc__ or "").partition("\n")[0] + ("" if law is None else f" By the law of {law.capitalize()}.")
    return process(name, doc, *members, *_curves(name, tribometer))


def _own(record: type[Record], tribometer: str | None) -> tuple[FieldPart, ...]:
    """Declare what is shown of a result, but what is of the bodies of another tribometer."""
    shown = shown_fields(record)
    if tribometer is None:
        return tuple(shown)
    own = {*contacts()[tribometer].body_names, *contacts()[tribometer].roles}
    return tuple(part for part in shown if _body_of(part.name) in (None, *own))


def _body_of(field: str) -> str | None:
    """Return the body of which a field is, by the longest name that it begins with; none of a field of no body."""
    bodies = {name for kind in contacts().values() for name in (*kind.body_names, *kind.roles)}
    return max((name for name in bodies if f"{field}_".startswith(f"{name}_")), key=len, default=None)


def _curves(name: StepName, tribometer: str | None) -> Iterator[GroupPart]:
    if LOCAL_WEAR.law_of(name) is not None:
        yield from _local_wear(discs=tribometer == "twin-disc")
    elif name == "clean_up":
        yield GroupPart("data", "NXdata", "Signals that came out changed.", tuple(signals()))
    elif drawn := _drawn(name, tribometer):
        curves = columns(drawn, required=name != "drift_correction")
        members: tuple[Part, ...] = (*curves, drawn_against(axis_of(tribometer)))
        yield GroupPart("data", "NXdata", "Curves over the samples of the run.", members)


def _drawn(name: StepName, tribometer: str | None) -> dict[str, str]:
    """Return the curves of a step by their names with their SI unit."""
    discs = tribometer == "twin-disc"
    if _law(name) is not None:
        return banded(OUTCOMES) if discs else banded({"wear_depth": "m"})
    if name == "drift_correction":
        return {"wear_depth": "m", "wander": "m"} | ({} if discs else {"pin_wear_depth": "m"})
    return {"friction_coefficient": "1"} if name == "friction_fit" else {}


def _local_wear(*, discs: bool) -> Iterator[GroupPart]:
    places = tuple(columns({name: "m" for axes in PLACES.values() for name in axes}, required=False))
    for table, units in local_wear_units(discs).items():
        members = tuple(columns(units))
        yield GroupPart(table, "NXdata", _TABLES[table], members if table == "course" else (*members, *places))
