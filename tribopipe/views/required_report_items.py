"""Items customarily reported for sliding wear tests, as in ASTM G99, and those that are missing for a run.

The list is tribopipe's own wording of what the practice for pin-on-disc tests asks a report to hold; for two discs it
is the same where it applies. Each item that is missing comes with the key that would report it.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tribopipe.archive.store import Archive
from tribopipe.base.column_formatting import moment
from tribopipe.base.units import KINDS, show, show_force
from tribopipe.documents.contact import ROTATIONS, SLIDING, Specimen
from tribopipe.documents.contact_kinds import spoken
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.signals import SIGNALS, SignalName
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.run import RawRun
from tribopipe.results.specific_wear import BodyWearRate, SpecificWear, measured_quantity
from tribopipe.views.page import duration, shown

_ASKED = {
    "material": "material",
    "form": "form and size",
    "surface_roughness": "surface roughness Ra",
    "vickers_hardness": "hardness",
}
"""Items to report for each body."""
_REPEAT = ("repeat the test, and list all replicates in", "of study.toml")


@dataclass(frozen=True)
class ReportingItem:
    """One item of a report."""

    subject: str
    """Subject of the item: "pin", "test", "result"…"""
    name: str
    """Name of the item, such as "surface roughness"."""
    value: str | None
    """Displayed value; None if it is missing."""
    key: str
    """Key in which to state it, if it is missing."""
    do: str = "add"
    """What to do with the key."""
    place: str = "to run.toml"
    """Where to do it."""


def reporting_items(archive: Archive, run_id: str, replicates: str | None = None) -> list[ReportingItem]:
    """Return all items with the values of a run, and ``replicates``, the number of similar runs and their scatter.

    Raises ``ArchiveError`` if the run is not in the archive.
    """
    run = archive.cleaned(run_id)
    return [
        *_bodies(run.manifest),
        *_MOTION[run.manifest.progress.signal](run),
        ReportingItem("test", "duration", _duration(run), "signals.columns.time"),
        *_surroundings(run),
        *_scar(run.manifest),
        *_volumes(run.manifest, archive.result(run_id, "specific_wear", SpecificWear)),
        *_friction(archive.result(run_id, "friction_fit", FrictionFit)),
        ReportingItem("result", "replicates and their scatter", replicates, "fit", *_REPEAT),
        *_circumstances(run.manifest),
    ]


def _bodies(manifest: RunManifest) -> Iterator[ReportingItem]:
    for name in manifest.contact_class.body_names:
        told, size = _told(manifest.bodies.get(name)), manifest.contact_class.specimen(name).sizes()
        for key, label in _ASKED.items():
            place = (size or ("diameter",))[-1] if key == "form" else key
            yield ReportingItem(spoken(name), label, told.get(key), f"contact.{name}.{place}")


def _told(body: Specimen | None) -> dict[str, str | None]:
    if body is None:
        return {}
    hardness = body.vickers_hardness
    return {
        "material": body.material,
        "form": _form(body),
        "surface_roughness": shown(body.surface_roughness, "um"),
        "vickers_hardness": None if hardness is None else f"{hardness:g} HV",
    }


def _form(body: Specimen) -> str | None:
    size = None if body.diameter is None else f"diameter {body.diameter.shown('mm')}"
    sizes = {key: getattr(body, key) for key in body.sizes()}
    own = [f"{spoken(key)} {value.shown('mm')}" for key, value in sizes.items() if isinstance(value, Quantity)]
    return ", ".join(filter(None, [getattr(body, "shape", None), *own, size])) or None


def _sliding(run: RawRun) -> Iterator[ReportingItem]:
    conditions = run.manifest.conditions
    track, stroke = conditions.track_radius, conditions.stroke
    load = show_force(conditions.normal_load.value, conditions.normal_load.standard_uncertainty)
    speed = shown(conditions.nominal_speed, "mm/s") or _mean(run, "sliding_speed")
    path = f"stroke {stroke.shown('mm')}" if stroke else f"track radius {track.shown('mm')}" if track else None
    yield ReportingItem("test", "normal load", load, "conditions.normal_load")
    yield ReportingItem("test", "sliding speed", speed, "conditions.sliding_speed")
    yield ReportingItem("test", "sliding distance", _last(run, "sliding_distance"), "conditions.sliding_distance")
    yield ReportingItem("test", "track radius or stroke", path, "conditions.track_radius")
    for key, unit in (("rotational_speed", "rpm"), ("frequency", "Hz")):
        if value := shown(getattr(conditions, key), unit):
            yield ReportingItem("test", spoken(key), value, f"conditions.{key}")


def _rolling(run: RawRun) -> Iterator[ReportingItem]:
    conditions = run.manifest.conditions
    load = show_force(conditions.normal_load.value, conditions.normal_load.standard_uncertainty)
    speed = shown(conditions.curved_disc_speed, "mm/s")
    turned = f"{np.nanmax(run.columns['rotations']):,.0f}"
    yield ReportingItem("test", "normal load", load, "conditions.normal_load")
    yield ReportingItem("test", "speed of the crowned disc", speed, "conditions.curved_disc_speed")
    yield ReportingItem("test", "slip", shown(run.manifest.slip, "%"), "conditions.slip")
    yield ReportingItem("test", "rotations of the crowned disc", turned, "conditions.rotations")
    yield ReportingItem("test", "slip distance", _last(run, "sliding_distance"), "conditions.curved_disc_speed")


_MOTION = {SLIDING.signal: _sliding, ROTATIONS.signal: _rolling}
"""Items on load and motion by what wear grows along."""


def _surroundings(run: RawRun) -> Iterator[ReportingItem]:
    conditions = run.manifest.conditions
    temperature = shown(conditions.temperature, "degC") or _mean(run, "temperature")
    humidity = shown(conditions.relative_humidity, "%") or _mean(run, "relative_humidity")
    yield ReportingItem("test", "environment or lubricant", conditions.medium, "conditions.medium")
    yield ReportingItem("test", "temperature", temperature, "conditions.temperature")
    yield ReportingItem("test", "relative humidity", humidity, "conditions.relative_humidity")


def _scar(manifest: RunManifest) -> Iterator[ReportingItem]:
    """Yield the scar on a round pin, the result of a four-ball test (ASTM D4172, section 4)."""
    pin = manifest.pin
    if pin is None or pin.constant_area:
        return
    label = "width" if pin.line else "mean diameter"
    name, key = f"{label} of the scar on the pin", f"end_values.{pin.usual_measurement}"
    scar = shown(manifest.end_values.mean_pin_scar, "mm")
    yield ReportingItem("result", manifest.worded(name), scar, manifest.worded(key))


def _volumes(manifest: RunManifest, worn: SpecificWear | None) -> Iterator[ReportingItem]:
    found = {} if worn is None else worn.bodies
    for role in manifest.contact_class.roles:
        volume, key = _volume(manifest, found.get(role)), _volume_key(manifest, role)
        yield ReportingItem("result", manifest.worded(f"wear volume of the {spoken(role)}"), volume, key)


def _volume(manifest: RunManifest, worn: BodyWearRate | None) -> str | None:
    """Format a volume with its method of measurement."""
    if worn is None or worn.volume is None:
        return None
    by = worn.volume_by or ""
    measured = getattr(manifest.end_values, by, None)
    method = measured.method if isinstance(measured, EndValue) else None
    return f"{worn.volume.shown('mm^3')} from the {measured_quantity(by)}" + (f", {method}" if method else "")


def _volume_key(manifest: RunManifest, name: str) -> str:
    """Name what is missing for a volume: the track's length if its cross-section was measured, else a measurement."""
    ended, conditions, contact = manifest.end_values, manifest.conditions, manifest.contact_class
    across = (ended.disc_profile, ended.disc_wear_depth, ended.disc_track_width, ended.disc_track_area)
    if name == contact.roles[1] and any(across) and conditions.track_radius is None and conditions.stroke is None:
        return "conditions.track_radius"
    if name != contact.tip_role:
        return manifest.worded(f"end_values.{name}_wear_volume")
    measured = "pin_scar_diameter" if manifest.pin is None else manifest.pin.usual_measurement
    return manifest.worded(f"end_values.{measured}")


def _friction(fit: FrictionFit | None) -> Iterator[ReportingItem]:
    steady = None if fit is None else shown(fit.steady_state, "1")
    yield ReportingItem("result", "initial friction coefficient", _start(fit), "signals.columns.friction_force")
    yield ReportingItem("result", "steady-state friction coefficient", steady, "signals.columns.friction_force")


def _start(fit: FrictionFit | None) -> str | None:
    """Format A + b with its uncertainty."""
    if fit is None or fit.steady_state is None:
        return None
    if fit.amplitude is None or fit.covariance is None:
        return "no running-in could be identified from the data"
    variance = fit.covariance[0][0] + 2 * fit.covariance[0][1] + fit.covariance[1][1]
    return show(fit.amplitude.value + fit.steady_state.value, max(variance, 0.0) ** 0.5, "1")


def _circumstances(manifest: RunManifest) -> Iterator[ReportingItem]:
    started = None if manifest.started is None else moment(manifest.started.replace(tzinfo=None))
    yield ReportingItem("record", "instrument", manifest.instrument, "instrument")
    yield ReportingItem("record", "date of the test", started, "started")
    yield ReportingItem("record", "operator", manifest.operator, "operator")
    yield ReportingItem("record", "composition, processing and cleaning", manifest.comment, "comment")


def _mean(run: RawRun, name: SignalName) -> str | None:
    """Format the mean size of a recorded signal, since a speed may have a sign; None if nothing was recorded."""
    values = run.columns.get(name)
    if values is None or run.origins[name] != "measured" or not np.any(np.isfinite(values)):
        return None
    kind = KINDS[SIGNALS[name].kind]
    return f"{show(float(np.nanmean(np.abs(values))), None, kind.si, kind.shown)}, mean of the recording"


def _duration(run: RawRun) -> str | None:
    """Format the time that was recorded; None if no time was."""
    time = run.columns.get("time")
    if time is None or not np.any(np.isfinite(time)):
        return None
    return duration(Quantity(value=float(np.nanmax(time) - np.nanmin(time)), unit="s"))


def _last(run: RawRun, name: SignalName) -> str | None:
    """Format the final value of a signal; None if it is unknown."""
    values = run.columns[name]
    return show(float(np.nanmax(values)), None, "m") if np.any(np.isfinite(values)) else None
