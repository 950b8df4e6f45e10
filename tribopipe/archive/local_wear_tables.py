"""Local wear as tables of a step: its course over sliding distance or rotations, and the fields over places."""

from collections.abc import Iterator

from tribopipe.archive.step_names import Step, Table
from tribopipe.base.arrays import Column
from tribopipe.physics.local.course import LocalWear
from tribopipe.results.local_wear import GlobalWear, LocalCurves, LocalWearResult

_COURSE = {
    "depth": "m",
    "peak_pressure": "Pa",
    "half_width": "m",
    "half_length": "m",
    "approach": "m",
}
"""What is stated about local wear at each place of its course, as ``LocalWear`` names it."""
_SUMS = {False: {"amount": "m^3/N", "volume": "m^3"}, True: {"amount": "m^2/N", "volume": "m^2"}}
"""The same of what has another unit under discs: there the volume is the cross-section of the track."""
_GLOBAL = {"depth": "m", "pressure": "Pa", "half_width": "m", "half_length": "m"}
_TRACK = {"track_depth": "m", "track_section": "m^2", "giwm_track_depth": "m"}
"""Wear of the counterbody of a pin where it wears."""
_FIELDS = {"pressure": "Pa", "wear": "m"}
_UNWORN = {"gap": "m"}
PLACES = {1: ("radius",), 2: ("across", "along")}
"""Names of the axes of a surface, by their number; all in m."""


def local_wear_tables(curves: LocalCurves) -> dict[str, Table]:
    """Return what the archive keeps of local wear with its result."""
    course = curves.course
    along = {"rotations": (curves.along, "1")} if curves.discs else {"sliding_distance": (curves.along, "m")}
    arrays = {name: (getattr(course, name), unit) for name, unit in (_COURSE | _SUMS[curves.discs]).items()}
    arrays |= {"mean_pressure": (curves.mean_pressure, "Pa")} | dict(_global_arrays(curves))
    arrays |= {name: (column, _TRACK[name]) for name, column in curves.track.items()}
    places = {name: (axis, "m") for name, axis in zip(PLACES[len(course.places)], course.places, strict=True)}
    fields = {"pressure": (course.pressure, _FIELDS["pressure"]), "wear": (course.worn, _FIELDS["wear"])}
    unworn = {"gap": (curves.gap, _UNWORN["gap"])}
    return {
        "course": Table(along, arrays),
        "fields": Table(along | places, fields),
        "unworn_surface": Table(places, unworn),
    }


def _global_arrays(curves: LocalCurves) -> Iterator[tuple[str, tuple[Column, str]]]:
    for model, wear in curves.giwm.items():
        for name, unit in _GLOBAL.items():
            yield f"{model}_{name}", (getattr(wear, name), unit)


def local_wear_units(discs: bool) -> dict[str, dict[str, str]]:
    """Return the columns and arrays of each table with their SI unit, but those of places: see ``PLACES``."""
    along = {"rotations": "1"} if discs else {"sliding_distance": "m"}
    models = ("giwm", "giwm_as_printed") if discs else ("giwm",)
    pressed = {f"{model}_{name}": unit for model in models for name, unit in _GLOBAL.items()}
    return {
        "course": along | _COURSE | _SUMS[discs] | {"mean_pressure": "Pa"} | pressed,
        "fields": along | _FIELDS,
        "unworn_surface": _UNWORN,
    }


def track_units(discs: bool) -> dict[str, str]:
    """Return the arrays of a course that only a counterbody that wears has, with their SI unit."""
    return {} if discs else _TRACK


def archived_local_wear(step: Step | None) -> LocalCurves | None:
    """Return local wear as a step holds it; none where it has not been computed."""
    if step is None or not isinstance(step.result, LocalWearResult):
        return None
    along, *places = (axis for axis, _ in step.tables["fields"].axes.values())
    course, fields = (
        {name: values for name, (values, _) in step.tables[table].arrays.items()} for table in ("course", "fields")
    )
    models = [name for name in ("giwm", "giwm_as_printed") if f"{name}_depth" in course]
    return LocalCurves(
        result=step.result,
        along=along,
        course=LocalWear(
            **{name: course[name] for name in _COURSE | _SUMS[False]},
            places=tuple(places),
            pressure=fields["pressure"],
            worn=fields["wear"],
        ),
        gap=step.tables["unworn_surface"].arrays["gap"][0],
        mean_pressure=course["mean_pressure"],
        giwm={model: GlobalWear(**{name: course[f"{model}_{name}"] for name in _GLOBAL}) for model in models},
        track={name: course[name] for name in _TRACK if name in course},
    )
