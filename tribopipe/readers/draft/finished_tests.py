"""Finished tests of which nothing was recorded: a run folder of each row of a table.

    run;normal load [N];sliding speed [m/s];sliding distance [m];ball diameter [mm];pin_scar_diameter [um];lab book
    A1;5;0.1;500;6;412;page 12

run.toml is filled from the row. The file of signals holds the start and the end of the test, by its distance and speed;
nothing else is put in the place of a recording. Columns that are no key of run.toml are kept in its comment.
"""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from tribopipe.base.errors import ManifestError, ReaderError
from tribopipe.documents.manifest import Conditions
from tribopipe.documents.quantity import read_quantity
from tribopipe.documents.template import read_template
from tribopipe.readers.draft.ends_table import EndsRow, read_ends
from tribopipe.readers.draft.folder import NewRun, RunPlan, Wanted, fit_for_id, make_planned, planned, refuse_places
from tribopipe.readers.draft.gathering import gather
from tribopipe.readers.draft.known_values import Given, Known, nested
from tribopipe.readers.draft.questions import Ask, Say

_FILE = "signals.csv"
_SHAPE = "contact.pin.shape"
_ALIKE = 0.02
"""How far two values of one quantity in a row may be apart, relative to one of them."""


def make_of_rows(wanted: Wanted, ask: Ask | None = None, say: Say = print) -> list[NewRun]:
    """Make a run folder of each row of a table.

    Raises ``ManifestError`` with file and line where a row is incomplete or contradicts itself, and then leaves nothing
    behind.
    """
    if len(wanted.files) != 1:
        raise ReaderError(
            f"--each-row: found {len(wanted.files)} files; expected one table, .csv or .xlsx; name one at a time"
        )
    table = read_ends(wanted.files[0])
    for name in table.unused:
        say(f"{table.name}: column {name!r} is no key of run.toml and is kept in the comment of each run")
    with TemporaryDirectory() as folder:
        plans = [
            plan for row in table.rows for plan in _plans(wanted, row, f"{table.name}, line {row.line}", Path(folder))
        ]
    refuse_places(plans)
    return make_planned(plans, wanted, ask, say)


def _plans(wanted: Wanted, row: EndsRow, where: str, folder: Path) -> list[RunPlan]:
    measured = {**row.values, **_comment(row, where)}
    template = read_template(wanted.template) if wanted.template else {}
    known = gather(template, "", wanted.settings, [], measured)
    _refuse_two_sizes(row, where)
    if row.is_ball and _SHAPE not in known.given:
        measured[_SHAPE] = Given("spherical", f"from {where}, a ball")
    signals = folder / _FILE
    signals.write_text(_start_and_end(known, where), encoding="utf-8")
    return planned(replace(wanted, files=[signals], id=fit_for_id(f"{row.run}.csv"), measured=measured))


def _comment(row: EndsRow, where: str) -> dict[str, Given]:
    """Return the comment of a run, with the fields that have no key of their own."""
    given = row.values.get("comment")
    parts = [*([str(given.value)] if given else []), *(f"{name}: {field}" for name, field in row.other.items())]
    return {"comment": Given("; ".join(parts), f"from {where}")} if parts else {}


def _start_and_end(known: Known, where: str) -> str:
    """Write start and end of a test, by its distance and speed; no more is known of its course."""
    conditions = Conditions.model_validate(nested(known.completed().values)["conditions"])
    distance, speed = conditions.sliding_distance, conditions.nominal_speed
    if distance is None or speed is None:
        missing = "sliding_distance" if distance is None else "sliding_speed (or rotational_speed and track_radius)"
        raise ManifestError(
            f"{where}: found no {missing}; expected distance and speed of each test; add a column or fill in "
            "the field, or state it in the template if all tests have the same"
        )
    _refuse_two_speeds(conditions, where)
    return f"time [s],sliding distance [m]\n0,0\n{distance.value / speed.value:.12g},{distance.value:.12g}\n"


def _refuse_two_speeds(conditions: Conditions, where: str) -> None:
    stated, other = conditions.sliding_speed, conditions.model_copy(update={"sliding_speed": None}).nominal_speed
    if stated is not None and other is not None and abs(stated.value - other.value) > _ALIKE * stated.value:
        motion = "rotational_speed and track_radius" if conditions.track_radius else "stroke and frequency"
        raise ManifestError(
            f"{where}: found a sliding_speed of {stated.shown('mm/s')}, but {other.shown('mm/s')} from {motion}; "
            "expected the same; correct one"
        )


def _refuse_two_sizes(row: EndsRow, where: str) -> None:
    sizes = [
        row.values[f"contact.pin.{name}"] for name in ("diameter", "radius") if f"contact.pin.{name}" in row.values
    ]
    if len(sizes) == 2:
        diameter, radius = (read_quantity(size.value, "length") for size in sizes)
        if abs(diameter.value / 2 - radius.value) > _ALIKE * radius.value:
            raise ManifestError(
                f"{where}: found a ball of {diameter.shown('mm')} in diameter with a radius of {radius.shown('mm')}; "
                "expected half the diameter; correct one, or delete its column"
            )
