"""What the entry of an archived file holds: of a run, by the kind of its tribometer, and of a study.

See ``tribopipe.archive.runfile`` and ``tribopipe.archive.studyfile``. A run has parts that are written once, as it was
ingested, and steps that it has been through.
"""

from collections.abc import Iterator
from functools import cache

from tribopipe.archive.definitions.parts import (
    Definition,
    FieldPart,
    GroupPart,
    Part,
    banded,
    columns,
    defined,
    document,
    drawn_against,
    process,
    shown_fields,
    text,
)
from tribopipe.archive.formats import RUN_FORMAT, STUDY, STUDY_FORMAT, run_name
from tribopipe.archive.local_wear_tables import PLACES, local_wear_units, track_units
from tribopipe.archive.step_names import LOCAL_WEAR, PREDICTIONS, STEPS, WEAR_FITS, StepName
from tribopipe.documents.contact import ROTATIONS, Contact, Specimen
from tribopipe.documents.contact_kinds import ASSUMED, contacts, variants
from tribopipe.documents.manifest import Conditions, EndValues, foreign_keys
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SENSED, SIGNALS
from tribopipe.results.wear_prediction import OUTCOMES


def as_ingested(tribometer: str | None) -> Iterator[Part]:
    """Declare the parts that are written once."""
    yield text("title", "Title of the run.")
    yield defined(run_name(tribometer))
    yield FieldPart("start_time", "Start of the test.", "NX_DATE_TIME")
    yield text("identifier_run", "ID of the run, unique in its archive.")
    yield _archived()
    yield GroupPart("user", "NXuser", "Person who ran the test.", (text("name", "Name."),))
    yield _instrument()
    yield from _bodies(tribometer)
    yield _stated("conditions", Conditions, "Test conditions.", tribometer)
    yield _stated("end_values", EndValues, "Post-test measurements of the bodies.", tribometer)
    yield _source_files()
    yield document("manifest", "Content of run.toml as JSON.")
    yield document("findings", "Findings of the checks at ingest.")
    yield _raw(tribometer)
    yield _recorded()
    yield _extra_columns()
    yield _profiles()


def contact_class(tribometer: str | None) -> type[Contact]:
    """Return the class of a kind of contact; that of a pin on a disc without a contact."""
    return ASSUMED if tribometer is None else contacts()[tribometer]


def axis_of(tribometer: str | None) -> str:
    """Name the signal that curves are drawn against."""
    return contact_class(tribometer).progress.signal


def signals(*attributes: str, needed: str = "") -> Iterator[FieldPart]:
    """Declare the measured signals, none required but the ``needed`` one."""
    for name, signal in SIGNALS.items():
        yield FieldPart(
            name, f"{signal.meaning.capitalize()}.", "NX_FLOAT", (signal.unit,), name == needed, attributes=attributes
        )


def _archived() -> GroupPart:
    members = (
        text("format", "Format of the file."),
        text("raw_sha256", "SHA-256 of the run as ingested."),
        document("environment", "Software versions at ingest.", required=False),
    )
    return GroupPart("archived", "NXcollection", "Archive format and fingerprint of the run.", members, required=True)


def _instrument() -> GroupPart:
    sensors = (
        GroupPart(signal, "NXsensor", f"Sensor of {signal.replace('_', ' ')}.", (text("name", "Measured quantity."),))
        for signal in SENSED
    )
    members: tuple[Part, ...] = (text("name", "Name of the tribometer."), *sensors)
    return GroupPart("instrument", "NXinstrument", "The tribometer.", members, required=True)


def _bodies(tribometer: str | None) -> Iterator[GroupPart]:
    fields = [one.model_fields for one in variants(tribometer)]
    for name, told in {name: told for one in fields for name, told in one.items()}.items():
        if isinstance(told.annotation, type) and issubclass(told.annotation, Specimen):
            own = tuple(shown_fields(told.annotation))
            properties = GroupPart("properties", "NXcollection", "Material, shape and surface.", own, required=True)
            members = (text("name", "Material and body."), properties)
            always = all(name in one for one in fields)
            yield GroupPart(name, "NXsample", told.description or "", members, required=always)


def _stated(name: str, record: type[Record], doc: str, tribometer: str | None) -> GroupPart:
    """Declare what run.toml may state of a tribometer of this kind."""
    foreign = () if tribometer is None else foreign_keys(contacts()[tribometer])
    fields = tuple(part for part in shown_fields(record) if part.name.removesuffix("_errors") not in foreign)
    return GroupPart(name, "NXcollection", doc, fields, required=True)


_FILE = (
    text("file_name", "Name of the file."),
    text("type", "Type of content."),
    FieldPart("data", "Content of the file, byte for byte.", "NX_BINARY", required=True),
    text("checksum", "SHA-256 of the bytes."),
    text("algorithm", "sha256."),
)


def earlier_manifests() -> GroupPart:
    """Declare what is kept of a run that was amended."""
    members = (
        *_FILE,
        text("description", "Changes made by the amendment."),
        FieldPart("date", "Date of the amendment.", "NX_DATE_TIME", required=True),
        text("identifier_raw", "Fingerprint of the run as ingested with this run.toml."),
    )
    file = GroupPart("", "NXnote", "One run.toml.", members, required=True)
    amended = FieldPart("amended", "Date of the last amendment.", "NX_DATE_TIME", required=True)
    return GroupPart("earlier_manifests", "NXcollection", "Earlier versions of run.toml.", (file, amended))


def _source_files() -> GroupPart:
    described = text("description", "Header of the file.", required=False)
    file = GroupPart("", "NXnote", "One file.", (*_FILE, described), required=True)
    return GroupPart("source_files", "NXcollection", "The files of the run folder.", (file,), required=True)


def _raw(tribometer: str | None) -> GroupPart:
    members = tuple(signals("origin", "long_name", needed=axis_of(tribometer)))
    doc = "The signals; ``origin`` states whether a signal was measured or what it was derived from."
    return GroupPart("raw", "NXdata", doc, members, required=True)


def _recorded() -> GroupPart:
    first = FieldPart("first_of_mean", "Index of the first sample of each mean, from 0.", "NX_INT", required=True)
    doc = "All samples of a long run; ``raw`` contains their means, ``mean_of`` the number of samples per mean."
    return GroupPart("recorded", "NXdata", doc, (*signals("long_name"), first), attributes=("mean_of",))


def _extra_columns() -> GroupPart:
    column = FieldPart("column_NUMBER", "Column.", "NX_CHAR_OR_NUMBER", attributes=("column_name", "column_unit"))
    doc = "Other columns of the instrument files, with their original names and units."
    return GroupPart("extra_columns", "NXcollection", doc, (column,))


def _profiles() -> GroupPart:
    docs = {"position": "Position across the wear track.", "height": "Height, positive outward from the body."}
    lines = (
        FieldPart(name, doc, "NX_FLOAT", ("m",), required=True, attributes=("long_name",)) for name, doc in docs.items()
    )
    across = FieldPart(
        "across", "Position of a scan line in its height map.", "NX_FLOAT", ("m",), attributes=("long_name",)
    )
    scan = text("scan", "Name of that height map.", required=False)
    parts = (text("title", "Source of the profile."), *lines, across, scan)
    one = GroupPart("", "NXdata", "One profile.", parts, required=True)
    return GroupPart("profiles", "NXcollection", "Profiles across wear tracks and worn tips.", (one,))


LAWS = ("archard", "sarkar", "LAW")
"""tribopipe's own; the name of any other stands where LAW does."""
_UNDER_LAWS = (WEAR_FITS, PREDICTIONS, LOCAL_WEAR)
_TABLES = {
    "course": "Contact and wear during the test, calculated with the Global Incremental Wear Model.",
    "fields": "Pressure and wear at each point of the surface.",
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
    (record,), law = STEPS[name].records, _law(name)
    hashes = (text("inputs_sha256", "Hash of all inputs."), text("result_sha256", "Hash of the result."))
    members = (
        FieldPart("sequence_index", "Position in the sequence of steps, from 1.", "NX_POSINT", required=True),
        GroupPart("fingerprints", "NXparameters", "SHA-256 fingerprints of the step.", hashes, required=True),
        document("result", "Result with all digits."),
        document("options", "Options of the step."),
        document("stands_on", "SHA-256 of each input of the step.", required=False),
        GroupPart("parameters", "NXparameters", "The result, field by field.", _own(record, tribometer), required=True),
    )
    doc = (record.__doc__ or "").partition("\n")[0] + ("" if law is None else f" Wear law: {law.capitalize()}.")
    return process(name, doc, *members, *_curves(name, tribometer))


def _own(record: type[Record], tribometer: str | None) -> tuple[FieldPart, ...]:
    """Declare what is shown of a result, but what is of the bodies of another tribometer."""
    shown = shown_fields(record)
    if tribometer is None:
        return tuple(shown)
    own = {name for one in variants(tribometer) for name in (*one.body_names, *one.roles)}
    return tuple(part for part in shown if _body_of(part.name) in (None, *own))


def _body_of(field: str) -> str | None:
    """Return the body of which a field is, by the longest name that it begins with; none of a field of no body."""
    bodies = {name for kind in contacts().values() for name in (*kind.body_names, *kind.roles)}
    return max((name for name in bodies if f"{field}_".startswith(f"{name}_")), key=len, default=None)


def _curves(name: StepName, tribometer: str | None) -> Iterator[GroupPart]:
    if LOCAL_WEAR.law_of(name) is not None:
        yield from _local_wear(tribometer)
    elif name == "clean_up":
        yield GroupPart("data", "NXdata", "Signals changed in preprocessing.", tuple(signals()))
    elif drawn := _drawn(name, tribometer):
        curves = columns(drawn, required=name != "drift_correction")
        members: tuple[Part, ...] = (*curves, drawn_against(axis_of(tribometer)))
        yield GroupPart("data", "NXdata", "Curves over the samples of the run.", members)


def _drawn(name: StepName, tribometer: str | None) -> dict[str, str]:
    """Return the curves of a step by their names with their SI unit."""
    tip = contact_class(tribometer).tip_role
    if _law(name) is not None:
        return banded({"wear_depth": "m"}) if tip else banded(OUTCOMES)
    if name == "drift_correction":
        return {"wear_depth": "m", "wander": "m"} | ({f"{tip}_wear_depth": "m"} if tip else {})
    return {"friction_coefficient": "1"} if name == "friction_fit" else {}


def _local_wear(tribometer: str | None) -> Iterator[GroupPart]:
    places = tuple(columns({name: "m" for axes in PLACES.values() for name in axes}, required=False))
    discs = contact_class(tribometer).progress is ROTATIONS
    more = {"course": tuple(columns(track_units(discs), required=False))}
    for table, units in local_wear_units(discs).items():
        yield GroupPart(table, "NXdata", _TABLES[table], (*columns(units), *more.get(table, places)))


_MORE = """

All values are in SI units, except those of the group ``wear``, which are in µm. k_D, the dimensional wear coefficient
of the incremental wear models, is in m^2/N: 1e-6 m^2/N equals 1 mm^3/(N*mm), or 1000 mm^3/(N*m). Fields that end in
``_errors`` contain standard uncertainties. The groups ``raw``, ``recorded``, ``profiles`` and ``source_files`` contain
the run as ingested and never change; each NXprocess is a processing step that was computed from them."""


@cache
def run_definition(tribometer: str | None) -> Definition:
    """Return what files of runs on a kind of tribometer hold; of runs without a contact where it is none."""
    later = (
        _wear_plot(tribometer),
        document("marks", "Bad marks: who set or removed them, when and why.", required=False),
        document("annotations", "Tags and notes with author and date.", required=False),
        earlier_manifests(),
    )
    members = (*as_ingested(tribometer), *steps(tribometer), *later)
    entry = GroupPart("entry", "NXentry", "One run.", members, required=True, attributes=("default",))
    return Definition(run_name(tribometer), RUN_FORMAT.version, _what(tribometer) + _MORE, entry)


def _what(tribometer: str | None) -> str:
    if tribometer is None:
        return "Friction test without a description of the two bodies, and the results computed from it."
    return f"Wear test of {contacts()[tribometer].title}, and the results computed from it."


def _wear_plot(tribometer: str | None) -> GroupPart:
    tip = contact_class(tribometer).tip_role
    corrected = {f"{tip}_wear_depth" if tip else "wear_depth": "um"}
    curves = columns(corrected | banded(dict.fromkeys(LAWS, "um")), required=False)
    members: tuple[Part, ...] = (text("title", "Title of the plot."), *curves, drawn_against(axis_of(tribometer)))
    return GroupPart("wear", "NXdata", "Corrected wear and the fitted laws, for viewers.", members)


_DOC = """Study of wear tests: k_D is identified from some of the runs and used to predict the wear of the others.

Curves are wear depths in µm or wear volumes in mm^3 of a body, against the sliding distance or the rotations."""


@cache
def study_definition() -> Definition:
    """Return what files of studies hold."""
    archived = (text("format", "Format of the file."), text("inputs_sha256", "SHA-256 of all inputs."))
    members = (
        text("title", "Title of the study."),
        defined(STUDY),
        text("identifier_study", "ID of the study."),
        GroupPart("archived", "NXcollection", "Archive format and fingerprint of the study.", archived, required=True),
        process("process", "Program that computed the study.", required=True),
        document("study", "Content of study.toml: runs from which k_D is identified, and runs to be predicted."),
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
        text("run_id", "ID of the run."),
        text("model", "Wear law."),
        FieldPart("role", "Role of the run in the study.", required=True, values=("fitted", "predicted")),
        FieldPart(
            "body",
            "Body.",
            required=True,
            values=tuple(dict.fromkeys(name for one in kinds for name in one.fitted_bodies)),
        ),
        FieldPart("what", "Plotted quantity.", required=True, values=("wear_depth", "wear_volume")),
        *(
            FieldPart(
                along.signal, f"Position along the test: {along.words}.", "NX_FLOAT", (SIGNALS[along.signal].unit,)
            )
            for along in dict.fromkeys(one.progress for one in kinds)
        ),
        FieldPart("measured", "Measured wear.", "NX_FLOAT", worn),
        FieldPart("predicted", "Wear calculated with the law.", "NX_FLOAT", worn, required=True),
        FieldPart("lower", "Lower limit of the 95 % interval of predicted.", "NX_FLOAT", worn, required=True),
        FieldPart("upper", "Upper limit of the 95 % interval of predicted.", "NX_FLOAT", worn, required=True),
        FieldPart("measurement_lower", "Lower limit of the 95 % interval of measurements.", "NX_FLOAT", worn),
        FieldPart("measurement_upper", "Upper limit of the 95 % interval of measurements.", "NX_FLOAT", worn),
    )
    return GroupPart("", "NXdata", "One body of a run under one law.", members)
