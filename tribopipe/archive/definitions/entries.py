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
from tribopipe.archive.local_wear_tables import PLACES, local_wear_units
from tribopipe.archive.steps import LOCAL_WEAR, PREDICTIONS, STEPS, WEAR_FITS, StepName
from tribopipe.documents.contact import SLIDING, Specimen
from tribopipe.documents.contact_kinds import contacts
from tribopipe.documents.manifest import Conditions, EndValues, foreign_keys
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SENSED, SIGNALS
from tribopipe.results.wear_prediction import OUTCOMES


def as_ingested(tribometer: str | None) -> Iterator[Part]:
    """Declare the parts that are written once."""
    yield text("title", "One line about the run.")
    yield defined(run_name(tribometer))
    yield FieldPart("start_time", "Start of the test.", "NX_DATE_TIME")
    yield text("identifier_run", "Id of the run, unique in its archive.")
    yield _archived()
    yield GroupPart("user", "NXuser", "Who ran the test.", (text("name", "Name."),))
    yield _instrument()
    yield from _bodies(tribometer)
    yield _stated("conditions", Conditions, "How the test was run.", tribometer)
    yield _stated("end_values", EndValues, "What was measured on the bodies after the test.", tribometer)
    yield _source_files()
    yield document("manifest", "run.toml, all that is stated about the run.")
    yield document("findings", "What the checks found when the run was ingested.")
    yield _raw(tribometer)
    yield _recorded()
    yield _extra_columns()
    yield _profiles()


def axis_of(tribometer: str | None) -> str:
    """Name the signal that curves are drawn against."""
    return (SLIDING if tribometer is None else contacts()[tribometer].progress).signal


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
        document("environment", "What the run was ingested with.", required=False),
    )
    return GroupPart("archived", "NXcollection", "How the run was archived.", members, required=True)


def _instrument() -> GroupPart:
    sensors = (
        GroupPart(signal, "NXsensor", f"Sensor of {signal.replace('_', ' ')}.", (text("name", "What it reads."),))
        for signal in SENSED
    )
    members: tuple[Part, ...] = (text("name", "Name of the tribometer."), *sensors)
    return GroupPart("instrument", "NXinstrument", "The tribometer.", members, required=True)


def _bodies(tribometer: str | None) -> Iterator[GroupPart]:
    described = {} if tribometer is None else contacts()[tribometer].model_fields
    for name, told in described.items():
        if isinstance(told.annotation, type) and issubclass(told.annotation, Specimen):
            fields = tuple(shown_fields(told.annotation))
            properties = GroupPart("properties", "NXcollection", "Material, shape and surface.", fields, required=True)
            members = (text("name", "Material and body."), properties)
            yield GroupPart(name, "NXsample", told.description or "", members, required=True)


def _stated(name: str, record: type[Record], doc: str, tribometer: str | None) -> GroupPart:
    """Declare what run.toml may state of a tribometer of this kind."""
    foreign = () if tribometer is None else foreign_keys(contacts()[tribometer])
    fields = tuple(part for part in shown_fields(record) if part.name.removesuffix("_errors") not in foreign)
    return GroupPart(name, "NXcollection", doc, fields, required=True)


_FILE = (
    text("file_name", "Name of the file."),
    text("type", "Kind of its content."),
    FieldPart("data", "Its bytes as they came.", "NX_BINARY", required=True),
    text("checksum", "SHA-256 of the bytes."),
    text("algorithm", "sha256."),
)


def earlier_manifests() -> GroupPart:
    """Declare what is kept of a run that was amended."""
    members = (
        *_FILE,
        text("description", "What has changed since."),
        FieldPart("date", "When another one took its place.", "NX_DATE_TIME", required=True),
        text("identifier_raw", "Fingerprint of the run as it was ingested with it."),
    )
    file = GroupPart("", "NXnote", "One run.toml.", members, required=True)
    amended = FieldPart("amended", "When the run was amended last.", "NX_DATE_TIME", required=True)
    return GroupPart("earlier_manifests", "NXcollection", "run.toml before the amendment.", (file, amended))


def _source_files() -> GroupPart:
    described = text("description", "What stands above its numbers.", required=False)
    file = GroupPart("", "NXnote", "One file.", (*_FILE, described), required=True)
    return GroupPart("source_files", "NXcollection", "The files of the run folder.", (file,), required=True)


def _raw(tribometer: str | None) -> GroupPart:
    members = tuple(signals("origin", "long_name", needed=axis_of(tribometer)))
    doc = "The signals; ``origin`` states whether each was measured, or what it is derived from."
    return GroupPart("raw", "NXdata", doc, members, required=True)


def _recorded() -> GroupPart:
    first = FieldPart("first_of_mean", "Number of the first sample of each mean, from 0.", "NX_INT", required=True)
    doc = "Every sample of a long run, of which ``raw`` holds means; ``mean_of`` is the number of samples per mean."
    return GroupPart("recorded", "NXdata", doc, (*signals("long_name"), first), attributes=("mean_of",))


def _extra_columns() -> GroupPart:
    column = FieldPart("column_NUMBER", "Column.", "NX_CHAR_OR_NUMBER", attributes=("column_name", "column_unit"))
    doc = "Other columns of the instrument files, with their name and unit there."
    return GroupPart("extra_columns", "NXcollection", doc, (column,))


def _profiles() -> GroupPart:
    docs = {"position": "Position across the track.", "height": "Height, upwards out of the body."}
    lines = (
        FieldPart(name, doc, "NX_FLOAT", ("m",), required=True, attributes=("long_name",)) for name, doc in docs.items()
    )
    one = GroupPart("", "NXdata", "One profile.", (text("title", "What it was read from."), *lines), required=True)
    return GroupPart("profiles", "NXcollection", "Profiles across wear tracks and worn tips.", (one,))


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
