"""What the file of a run holds of the run as it was ingested."""

from collections.abc import Iterator

from tribopipe.archive.definitions.common import defined, document, text
from tribopipe.archive.definitions.names import run_name
from tribopipe.archive.definitions.parts import FieldPart, GroupPart, Part
from tribopipe.archive.definitions.summaries import shown_fields
from tribopipe.documents.contact import SLIDING, Specimen
from tribopipe.documents.contact_kinds import contacts
from tribopipe.documents.manifest import Conditions, EndValues, foreign_keys
from tribopipe.documents.record import Record
from tribopipe.documents.signals import SENSED, SIGNALS


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
