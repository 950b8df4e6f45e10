"""Checks: each finds what it is for, and leaves alone what is nearly so."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from conftest import SAMPLES
from sweeps import others_slow
from tip_maps import WornBall

from tribopipe.base.errors import CheckError
from tribopipe.documents.manifest import RunManifest
from tribopipe.evaluation.checks import (  # noqa: F401 - importing registers their checks
    conditions,
    documents,
    end_values,
    samples,
)
from tribopipe.evaluation.checks.registry import CHECKS, check_run, refuse_errors
from tribopipe.readers.harmonize import read_run
from tribopipe.results.run import AT_A_LEVER, READ_IN, ExtraColumn, Profile, Recording


@pytest.fixture(scope="module")
def sound(short_runs):
    return read_run(short_runs / "si3n4-air-400mN")


def column(name, change):
    """Pass a copy of one column through a function."""

    def spoil(run):
        values = run.columns[name].copy()
        changed = change(values)
        return replace(run, columns={**run.columns, name: values if changed is None else changed})

    return spoil


def samples_set(name, where, value):
    def change(values):
        values[where] = value

    return column(name, change)


def without(*names):
    return lambda run: replace(run, columns={name: v for name, v in run.columns.items() if name not in names})


def first(count):
    return lambda run: replace(run, columns={name: values[:count] for name, values in run.columns.items()})


def manifest(**written):
    """Give keys of run.toml other values: contact__pin__radius="2 mm"; None takes a key out."""

    def spoil(run):
        document = run.manifest.model_dump(mode="json", by_alias=True, exclude_none=True)
        for path, value in written.items():
            *tables, last = path.split("__")
            table = document
            for name in tables:
                table = table[name]
            table.pop(last, None)
            if value is not None:
                table[last] = value
        return replace(run, manifest=RunManifest.model_validate(document))

    return spoil


def friction_times(factor):
    """Multiply the friction force, and with it the coefficient."""
    return both(*(column(name, lambda values: factor * values) for name in ("friction_force", "friction_coefficient")))


def measured(name):
    """Say that a derived column was measured."""
    return lambda run: replace(run, origins={**run.origins, name: "measured"})


def both(*spoils):
    def spoil(run):
        for one in spoils:
            run = one(run)
        return run

    return spoil


def started(**later):
    return manifest(started=(datetime.now(UTC) + timedelta(**later)).isoformat())


def nowhere(run):
    """Tell neither the sliding distance nor a speed."""
    unknown = np.full(len(run), np.nan)
    columns, origins = {**run.columns, "sliding_distance": unknown}, {**run.origins, "sliding_distance": "unknown"}
    return replace(run, columns=columns, origins=origins)


def there_and_back(length, offset=0.1):
    """Let friction change its sign with each stroke of so many samples, beside an offset in shares of friction."""

    def spoil(run):
        direction = np.where(np.arange(len(run)) // length % 2, -1, 1)
        friction = run.columns["friction_force"] * direction - offset * np.median(run.columns["friction_force"])
        found = {"friction_force": friction, "friction_coefficient": friction / run.columns["normal_force"]}
        return replace(run, columns={**run.columns, **found})

    return spoil


def zero_moving(by):
    """Take the load off at both ends, and let the zero of friction move by a share of friction in between."""

    def spoil(run):
        on = (np.arange(len(run)) >= 50) & (np.arange(len(run)) < len(run) - 50)
        zero = by * np.median(run.columns["friction_force"]) * np.linspace(0, 1, len(run))
        forces = {name: run.columns[name] * on for name in ("normal_force", "friction_force")}
        return replace(run, columns={**run.columns, **forces, "friction_force": forces["friction_force"] + zero})

    return spoil


def mapped(radius):
    """Have the scar measured as a map of a tip with a radius, m."""
    lines = WornBall(radius=radius, scar=0.25e-3, size=1.8).map()
    profiles = {f"end_values.pin_profile[{number}]": line for number, line in enumerate(lines)}
    return lambda run: replace(run, profiles=profiles)


def straight(depth):
    """A profile with a groove this deep in its middle, or none."""
    position = np.linspace(-3e-4, 3e-4, 600)
    return Profile(position, -depth * np.maximum(0.0, 1 - (position / 1e-4) ** 2))


def rough(scale):
    """A profile of a groove 1 µm deep in a polished surface where the scale is 1e-6; of another one in another unit."""
    even = straight(1.0)
    noise = 0.02 * np.random.default_rng(7).standard_normal(len(even.position))
    return Profile(even.position, scale * (even.height + noise))


def without_middle(width):
    """A profile of a groove without the heights in its middle."""
    whole = straight(1e-6)
    seen = np.abs(whole.position) > width / 2
    return Profile(whole.position[seen], whole.height[seen])


def volume(thousandths):
    return {"value": f"{thousandths}e-3 mm^3", "standard_uncertainty": "0.02e-3 mm^3"}


def weighings(*volumes):
    """The wear of the pin, 10⁻³ mm³, measured after each 10 m."""
    places = (f"{10 * number} m" for number in range(1, len(volumes) + 1))
    return [
        {"sliding_distance": place, "pin_wear_volume": volume(one)} for place, one in zip(places, volumes, strict=True)
    ]


def extra(name, unit, values):
    """Add a column without a meaning: its values, or what makes them of the time."""

    def spoil(run):
        made = values(run.columns["time"]) if callable(values) else np.full(len(run), float(values))
        return replace(run, extras={**run.extras, name: ExtraColumn(made, unit)})

    return spoil


def unsigned(run):
    """Take the sign off the friction."""
    names = ("friction_force", "friction_coefficient")
    return replace(run, columns={**run.columns, **{name: np.abs(run.columns[name]) for name in names}})


def appended(run, other):
    """Put the samples of another run behind those of a run."""
    columns = {name: np.concatenate([values, other.columns[name]]) for name, values in run.columns.items()}
    return replace(run, columns=columns)


def running_in(run, length=0.05):
    """Friction that runs in from 0.8 to 0.5 within a share of the run, with noise."""
    place = np.linspace(0, 1, len(run))
    mu = 0.5 + 0.3 * np.exp(-place / length) + 0.01 * np.random.default_rng(4).standard_normal(len(run))
    columns = {name: values for name, values in run.columns.items() if name not in ("depth", "friction_force")}
    return replace(run, columns=columns | {"friction_coefficient": mu})


def went_on(run):
    """A second test behind the first, while the clock runs on and friction is 0 for a moment between them."""
    second = column("time", lambda time: time + 1.01 * run.columns["time"][-1])(running_in(run))
    second = column("sliding_distance", lambda slid: slid + run.columns["sliding_distance"][-1])(second)
    return appended(running_in(run), samples_set("friction_coefficient", slice(5), 0.001)(second))


def rotating(unit, hum=None, rate=20.0, count=4000):
    """Friction at 20 Hz of a disc with a runout at 3.7 Hz, or another frequency; its time read in a wrong unit."""

    def spoil(run):
        time = np.arange(count) / rate
        turning = 0.05 * np.sin(2 * np.pi * (hum or 3.7) * time + 1)
        force = 0.2 * (0.6 + turning + 0.05 * np.random.default_rng(8).standard_normal(count))
        columns = {"time": time * unit, "sliding_distance": 0.4 * time * unit, "friction_force": force}
        stated = {"sliding_speed": "400 mm/s", "track_radius": f"{400 / (2 * np.pi * 3.7):.4g} mm"}
        run = manifest(**{f"conditions__{name}": value for name, value in stated.items()})(run)
        return replace(run, columns=columns | {"friction_coefficient": force / 0.4})

    return spoil


def twice(run):
    """Write each row two times."""
    return replace(run, columns={name: np.repeat(values, 2) for name, values in run.columns.items()})


def friction_after_restart(run):
    """Friction that is steady from a short peak at the restart on."""
    mu = np.full(len(run), 0.5)
    mu[:3] = 0.8
    return replace(run, columns={**run.columns, "friction_coefficient": mu})


def after_steps(*steps):
    """Take the run from a file in which these steps come before it."""
    return lambda run: replace(run, earlier_steps=steps)


NAN = float("nan")
AS_IT_IS = both()


def folded(run):
    """The run as means of five samples each."""
    return replace(run, recording=Recording(5 * len(run), 5, 5 * np.arange(len(run)), lambda: iter(())))


THERE_AND_BACK = both(manifest(conditions__stroke="5 mm"), there_and_back(60))
# For each check: its severity, what it must find, where, and what it must leave alone.
CASES = {
    "worn_before": (
        "warning",
        after_steps(1, 2),
        "signals",
        both(after_steps(1), manifest(contact__pin__shape="truncated-sphere", contact__pin__flat_radius="90 um")),
    ),
    "conditions_change": (
        "warning",
        column("normal_force", lambda load: load * np.where(np.arange(len(load)) < 600, 1.0, 1.2)),
        "normal_force",
        column("normal_force", lambda load: load * np.linspace(1, 1.2, len(load))),
    ),
    "conditions_differ": (
        "warning",
        both(manifest(conditions__track_radius="6 mm"), extra("Radius", "mm", 8)),
        "conditions.track_radius",
        both(manifest(conditions__track_radius="6.2 mm"), extra("Radius", "mm", 6)),
    ),
    "stated_speeds_differ": (
        "warning",
        manifest(conditions__track_radius="6 mm", conditions__rotational_speed="600 rpm"),
        "conditions.sliding_speed",
        manifest(conditions__track_radius="6 mm", conditions__rotational_speed="637 rpm"),
    ),
    "track_beyond_disc": (
        "warning",
        manifest(conditions__track_radius="6 mm", contact__disc__diameter="10 mm"),
        "conditions.track_radius",
        manifest(conditions__track_radius="4.9 mm", contact__disc__diameter="10 mm"),
    ),
    "channels_disagree": (
        "warning",
        extra("Mass", "g", 80),
        "Mass",
        extra("Mass", "g", 41),
    ),
    "strokes_differ": (
        "warning",
        both(manifest(conditions__sliding_speed=None, conditions__frequency="0.1 Hz"), THERE_AND_BACK),
        "conditions.frequency",
        THERE_AND_BACK,
    ),
    "strokes_unused": (
        "warning",
        both(
            there_and_back(60, offset=0),
            lambda run: replace(
                run, columns={**run.columns, "friction_coefficient": np.abs(run.columns["friction_coefficient"])}
            ),
        ),
        "friction_force",
        THERE_AND_BACK,
    ),
    "no_friction_per_stroke": (
        "note",
        both(THERE_AND_BACK, unsigned),
        "friction_coefficient",
        THERE_AND_BACK,
    ),
    "no_samples": ("error", first(1), "signals", first(2)),
    "empty_channel": (
        "error",
        samples_set("depth", slice(None), NAN),
        "depth",
        samples_set("depth", slice(1, None), NAN),
    ),
    "axis_incomplete": ("error", samples_set("time", 7, NAN), "time", samples_set("depth", 7, NAN)),
    "axis_backward": ("error", samples_set("time", 7, 0.5), "time", samples_set("time", 7, 0.6)),
    "counter_glitch": (
        "warning",
        both(measured("sliding_distance"), samples_set("sliding_distance", 20, 0.0)),
        "sliding_distance",
        samples_set("sliding_distance", slice(None), 3.0),
    ),
    "axis_constant": (
        "error",
        samples_set("sliding_distance", slice(None), 3.0),
        "sliding_distance",
        samples_set("sliding_distance", slice(-1), 3.0),
    ),
    "distance_unknown": ("warning", nowhere, "conditions", AS_IT_IS),
    "samples_averaged": ("note", folded, "signals", AS_IT_IS),
    "signals_preprocessed": ("note", column("normal_force", np.negative), "normal_force", AS_IT_IS),
    "load_sign": (
        "warning",
        column("normal_force", np.negative),
        "normal_force",
        samples_set("normal_force", slice(500), -0.4),
    ),
    "load_unit": (
        "error",
        manifest(conditions__normal_load="400 N"),
        "conditions.normal_load",
        column("normal_force", lambda load: load * 0.5),
    ),
    "modulus_unit": (
        "error",
        manifest(contact__pin__youngs_modulus="304 MPa"),
        "contact.pin.youngs_modulus",
        manifest(contact__pin__youngs_modulus="100 GPa"),
    ),
    "material_properties": (
        "warning",
        manifest(contact__disc__vickers_hardness=16.5),
        "contact.disc.vickers_hardness",
        manifest(contact__pin__material="our own", contact__pin__youngs_modulus="20 GPa"),
    ),
    "radius_or_diameter": (
        "warning",
        manifest(contact__pin__radius="1.588 mm"),
        "contact.pin.radius",
        manifest(contact__pin__diameter="1 mm"),
    ),
    "radius_unchecked": (
        "note",
        manifest(contact__pin__diameter=None),
        "contact.pin.radius",
        manifest(contact__pin__diameter="6 mm"),
    ),
    "initial_yielding": (
        "warning",
        both(manifest(conditions__normal_load="400 N"), without("normal_force")),
        "conditions.normal_load",
        both(manifest(conditions__normal_load="100 N"), without("normal_force")),
    ),
    "rate_not_steady": (
        "warning",
        manifest(interruptions=weighings(4.0, 4.7, 5.4, 6.1), end_values__pin_wear_volume=volume(6.8)),
        "interruptions, end_values of the pin",
        manifest(interruptions=weighings(1.0, 2.0, 3.0, 4.0), end_values__pin_wear_volume=volume(5.0)),
    ),
    "wear_decreases": (
        "warning",
        manifest(interruptions=weighings(4.0, 4.7, 2.7, 6.1), end_values__pin_wear_volume=volume(6.8)),
        "interruptions, end_values of the pin",
        manifest(interruptions=weighings(4.0, 4.7, 4.7, 6.1), end_values__pin_wear_volume=volume(6.8)),
    ),
    "scar_not_round": (
        "warning",
        manifest(end_values__disc_wear_depth="20 um"),
        "end_values.pin_scar_diameter",
        manifest(end_values__disc_wear_depth="2 um"),
    ),
    "implausible_wear": (
        "warning",
        manifest(end_values={"pin_wear_volume": "1e-14 mm^3"}),
        "end_values of the pin",
        manifest(end_values={"pin_wear_volume": "1e-10 mm^3"}),
    ),
    "scar_or_radius": (
        "warning",
        manifest(end_values__pin_scar_diameter="10 um"),
        "end_values.pin_scar_diameter",
        manifest(end_values__pin_scar_diameter="200 um"),
    ),
    "profile_width": (
        "warning",
        lambda run: replace(run, profiles={"end_values.disc_profile": straight(1e-3)}),
        "end_values.disc_profile",
        lambda run: replace(run, profiles={"end_values.disc_profile": straight(4e-6)}),
    ),
    "profile_height": (
        "warning",
        lambda run: replace(run, profiles={"end_values.disc_profile": rough(1e-9)}),
        "end_values.disc_profile",
        lambda run: replace(run, profiles={"end_values.disc_profile": rough(1e-6)}),
    ),
    "elastic_scar": (
        "warning",
        manifest(end_values__pin_scar_diameter="30 um"),
        "end_values.pin_scar_diameter",
        manifest(end_values__pin_scar_diameter="200 um"),
    ),
    "material_gained": (
        "warning",
        manifest(end_values__disc_wear_volume={"value": "-0.2 mm^3", "standard_uncertainty": "0.05 mm^3"}),
        "end_values of the disc",
        manifest(end_values__disc_wear_volume={"value": "-0.1 mm^3", "standard_uncertainty": "0.05 mm^3"}),
    ),
    "uneven_scars": (
        "warning",
        manifest(end_values__pin_scar_diameter={"values": ["150 um", "200 um", "170 um"]}),
        "end_values.pin_scar_diameter",
        manifest(end_values__pin_scar_diameter={"values": ["160 um", "200 um", "170 um"]}),
    ),
    "stroke_within_scar": (
        "warning",
        manifest(conditions__stroke="200 um", end_values__pin_scar_diameter="210 um"),
        "conditions.stroke",
        manifest(conditions__stroke="220 um", end_values__pin_scar_diameter="210 um"),
    ),
    "coating_worn_through": (
        "warning",
        manifest(contact__pin__coating_thickness="3 um", end_values__pin_scar_diameter="200 um"),
        "contact.pin.coating_thickness",
        manifest(contact__pin__coating_thickness="10 um", end_values__pin_scar_diameter="200 um"),
    ),
    "load_not_nominal": (
        "warning",
        column("normal_force", lambda load: load * 0.95),
        "normal_force",
        column("normal_force", lambda load: load * 1.02),
    ),
    "missing_samples": ("warning", samples_set("depth", 7, NAN), "depth", AS_IT_IS),
    "repeated_samples": ("warning", samples_set("time", 7, 0.6), "time", samples_set("time", 7, 0.601)),
    "recording_gap": (
        "warning",
        column("time", lambda time: time + 1.0 * (np.arange(len(time)) > 600)),
        "time",
        column("time", lambda time: time + 0.8 * (np.arange(len(time)) > 600)),
    ),
    "dead_channel": (
        "warning",
        samples_set("depth", slice(None), 1e-6),
        "depth",
        samples_set("depth", slice(1, None), 1e-6),
    ),
    "clipped_signal": (
        "warning",
        both(measured("depth"), column("depth", lambda depth: np.minimum(depth, np.percentile(depth, 90)))),
        "depth",
        both(measured("depth"), column("depth", lambda depth: np.round(depth, 6))),
    ),
    "contact_lost": (
        "warning",
        both(without("normal_force"), samples_set("friction_force", slice(100), 1e-4)),
        "friction_force",
        samples_set("friction_force", slice(100), 0.02),
    ),
    "running_in_repeats": (
        "warning",
        lambda run: appended(running_in(run), running_in(run)),
        "friction_coefficient",
        lambda run: appended(running_in(run), samples_set("friction_coefficient", slice(None), 0.5)(run)),
    ),
    "runout_differs": ("warning", rotating(1 / 60), "time", rotating(1.0)),
    "friction_offset": (
        "warning",
        both(manifest(conditions__stroke="5 mm"), there_and_back(60, offset=0.15)),
        "friction_force",
        both(manifest(conditions__stroke="5 mm"), there_and_back(60, offset=0.02)),
    ),
    "uncertain_zero": ("warning", zero_moving(0.2), "friction_force", zero_moving(0.01)),
    "friction_sign": (
        "warning",
        there_and_back(60),
        "friction_coefficient",
        both(manifest(conditions__stroke="5 mm"), there_and_back(60)),
    ),
    "implausible_friction": (
        "warning",
        column("friction_coefficient", np.negative),
        "friction_coefficient",
        column("friction_coefficient", lambda mu: mu / mu.max() * 1.9),
    ),
    "interruption_after_end": (
        "error",
        manifest(interruptions=[{"sliding_distance": "51 m", "pin_wear_depth": "5 um"}]),
        "interruptions[0].sliding_distance",
        manifest(interruptions=[{"sliding_distance": "49 m", "pin_wear_depth": "5 um"}]),
    ),
    "implausible_depth": (
        "warning",
        column("depth", lambda depth: depth * 1000),
        "depth",
        column("depth", lambda depth: depth * 1.3),
    ),
    "distance_not_planned": (
        "warning",
        manifest(conditions__sliding_distance="60 m"),
        "sliding_distance",
        manifest(conditions__sliding_distance="52 m"),
    ),
    "axis_offset": (
        "warning",
        column("time", lambda time: time + 10),
        "time",
        column("time", lambda time: time + 5),
    ),
    "implausible_density": (
        "error",
        manifest(contact__disc__density="3.21 kg/m^3"),
        "contact.disc.density",
        manifest(contact__disc__density="22.59 g/cm^3"),
    ),
    "implausible_modulus": (
        "warning",
        manifest(contact__pin__youngs_modulus="304 kPa"),
        "contact.pin.youngs_modulus",
        manifest(contact__pin__youngs_modulus="1220 GPa"),
    ),
    "implausible_conditions": (
        "warning",
        manifest(contact__pin__radius="0.794 m"),
        "contact.pin.radius",
        manifest(contact__pin__radius="50 mm"),
    ),
    "measurements_disagree": (
        "warning",
        manifest(end_values__pin_wear_depth={"value": "12 um", "standard_uncertainty": "0.2 um"}),
        "end_values",
        manifest(end_values__pin_wear_depth={"value": "10.4 um", "standard_uncertainty": "0.2 um"}),
    ),
    "impossible_measurement": (
        "error",
        manifest(contact__pin__density=None, end_values__pin_mass_loss="0.01 mg"),
        "end_values.pin_mass_loss",
        manifest(end_values__pin_mass_loss={"value": "0.0009 mg", "standard_uncertainty": "5 %"}),
    ),
    "map_radius_differs": ("warning", mapped(0.84e-3), "end_values.pin_profile", mapped(0.795e-3)),
    "no_wear_in_profile": (
        "note",
        lambda run: replace(run, profiles={"end_values.disc_profile": straight(0.0)}),
        "end_values.disc_profile",
        lambda run: replace(run, profiles={"end_values.disc_profile": straight(1e-6)}),
    ),
    "gap_in_profile": (
        "warning",
        lambda run: replace(run, profiles={"end_values.disc_profile": without_middle(3e-5)}),
        "end_values.disc_profile",
        lambda run: replace(run, profiles={"end_values.disc_profile": without_middle(2e-6)}),
    ),
    "future_start": ("warning", started(days=1), "started", started(minutes=-1)),
    "missing_input": (
        "note",
        without("depth"),
        "signals",
        manifest(end_values={"pin_wear_depth": "10 um"}),
    ),
    "reader_assumption": (
        "note",
        lambda run: replace(run, notes=("signals.csv: read as cp1252",)),
        "signals",
        AS_IT_IS,
    ),
    "friction_lever": (
        "warning",
        lambda run: replace(run, notes=(f"signals.csv: friction_force in N {AT_A_LEVER} 4.49 mm from the axis",)),
        "signals",
        lambda run: replace(run, notes=("signals.csv: friction_force in N*mm is treated as a torque about the axis",)),
    ),
    "units_disagree": (
        "warning",
        lambda run: replace(run, notes=(f"signals.csv: column 'h [mm]' is in mm in the file, but {READ_IN} um",)),
        "signals",
        AS_IT_IS,
    ),
    "unused_signal": (
        "warning",
        lambda run: replace(run, unused=("signals.csv: column 'Ff' seems to be friction_force and is not used",)),
        "signals",
        AS_IT_IS,
    ),
    "unstated_uncertainty": ("note", manifest(contact__pin__radius="0.794 mm"), "contact.pin.radius", AS_IT_IS),
}

# What else a check must find.
MORE = {
    "frequency 4 % off": (
        "strokes_differ",
        both(manifest(conditions__sliding_speed=None, conditions__frequency="0.08 Hz"), THERE_AND_BACK),
        "conditions.frequency",
    ),
    "peak speed of strokes": (
        "strokes_differ",
        both(manifest(conditions__sliding_speed="1.31 mm/s"), THERE_AND_BACK),
        "conditions.sliding_speed",
    ),
    "friction in mN as N": ("implausible_friction", friction_times(1000), "friction_coefficient"),
    "friction in kN as N": ("implausible_friction", friction_times(1 / 1000), "friction_coefficient"),
    "groove wider than the scar": (
        "scar_or_radius",
        manifest(end_values__disc_wear_depth="145 um"),
        "end_values.pin_scar_diameter, end_values.disc_wear_depth",
    ),
    "length and width of a scar interchanged": (
        "scar_or_radius",
        manifest(end_values={"pin_scar_length": "460 um", "pin_scar_width": "430 um"}),
        "end_values.pin_scar_length, end_values.pin_scar_width",
    ),
    "half the width of the track beside a length": (
        "scar_or_radius",
        manifest(end_values={"pin_scar_length": "460 um", "disc_track_width": "245 um"}),
        "end_values.pin_scar_length, end_values.disc_track_width",
    ),
    "profile in nm as µm": (
        "profile_width",
        both(
            manifest(end_values__pin_scar_diameter="60 um", end_values__disc_wear_depth=None),
            lambda run: replace(run, profiles={"end_values.disc_profile": straight(1e-9)}),
        ),
        "end_values.disc_profile",
    ),
    "fretting that is known by volumes": (
        "stroke_within_scar",
        manifest(
            conditions__stroke="0.3 mm",
            end_values={"pin_wear_volume": "0.004 mm^3", "disc_wear_volume": "0.004 mm^3"},
        ),
        "conditions.stroke",
    ),
    "cross-section of the track in mm² for µm²": (
        "scar_or_radius",
        manifest(
            conditions__track_radius="6 mm", end_values__disc_wear_depth=None, end_values__disc_track_area="50 mm^2"
        ),
        "end_values.pin_scar_diameter, end_values.disc_track_area",
    ),
    "mass in µg for mg": (
        "implausible_conditions",
        manifest(end_values__pin_mass_loss={"value": "0.14 ug", "standard_uncertainty": "2 %"}),
        "end_values.pin_mass_loss",
    ),
    "speed in mm/s as m/s": (
        "implausible_conditions",
        manifest(conditions__track_radius="4 mm", conditions__sliding_speed="20 m/s"),
        "conditions.sliding_speed",
    ),
    "strokes in mm/s as m/s": (
        "implausible_conditions",
        manifest(conditions__stroke="4 mm", conditions__sliding_speed="20 m/s"),
        "conditions.sliding_speed",
    ),
    "time in s read as min": ("runout_differs", rotating(60), "time"),
    "time in s read as ms": ("runout_differs", rotating(1e-3), "time"),
    "unloaded start beside a load that is on": (
        "contact_lost",
        samples_set("friction_force", slice(100), 1e-4),
        "friction_force",
    ),
    "unloaded start with a friction sensor that is not zeroed": (
        "contact_lost",
        both(without("normal_force"), samples_set("friction_force", slice(100), 0.02)),
        "friction_force",
    ),
    "unloaded end with a noisy friction sensor": (
        "contact_lost",
        both(without("normal_force"), samples_set("friction_force", slice(-100, None), 0.01 * np.cos(np.arange(100)))),
        "friction_force",
    ),
    "unloaded start of strokes whose friction has no sign": (
        "contact_lost",
        both(manifest(conditions__stroke="5 mm"), samples_set("friction_force", slice(100), 1e-4)),
        "friction_force",
    ),
    "two tests with an idle sensor between them": (
        "running_in_repeats",
        lambda run: appended(
            both(running_in, samples_set("friction_coefficient", slice(-5, None), 0.001))(run),
            both(running_in, samples_set("friction_coefficient", slice(5), 0.001))(run),
        ),
        "friction_coefficient",
    ),
    "two tests without a pause of the clock": ("running_in_repeats", went_on, "friction_coefficient"),
    "each row exported twice": ("repeated_samples", twice, "time"),
    "stop that counts as sliding": (
        "recording_gap",
        both(
            manifest(interruptions=[{"sliding_distance": "25 m", "pin_wear_depth": "5 um"}]),
            column("time", lambda time: time + 300.0 * (np.arange(len(time)) >= len(time) // 2)),
        ),
        "time",
    ),
    "stop far from the stated interruption": (
        "recording_gap",
        lambda run: stopped(both(INTERRUPTED, first(1000))(run)),
        "time",
    ),
    "recording exported twice": ("repeated_samples", lambda run: appended(run, run), "time"),
    "peaks of the load cell": (
        "load_not_nominal",
        samples_set("normal_force", slice(100, 120), 4.0),
        "normal_force",
    ),
    "motor that stands still": (
        "channels_disagree",
        both(
            manifest(conditions__track_radius="8 mm"),
            extra("Speed", "rpm", lambda time: 477.5 * (time < time[-1] / 2)),
        ),
        "Speed",
    ),
    "losses of the intervals": (
        "wear_decreases",
        manifest(interruptions=weighings(2.0, 2.1, 1.9, 2.05), end_values__pin_wear_volume=volume(2.0)),
        "interruptions, end_values of the pin",
    ),
    "depth sensor off at first": ("dead_channel", samples_set("depth", slice(300), 0.0), "depth"),
    "time in ms as s": ("implausible_conditions", column("time", lambda time: time * 1e5), "time"),
    "no time passes": ("axis_constant", samples_set("time", slice(None), 3.0), "time"),
    "no end value": ("missing_input", manifest(end_values={}), "end_values"),
    "position along the stroke as depth": (
        "implausible_depth",
        both(
            manifest(conditions__stroke="100 um"),
            column("depth", lambda depth: depth + 50e-6 * np.sin(np.linspace(0, 100 * np.pi, len(depth)))),
        ),
        "depth",
    ),
    "depth counts down": ("implausible_depth", column("depth", np.negative), "depth"),
    "depth in nm": ("implausible_depth", column("depth", lambda depth: depth / 1000), "depth"),
    "distance carried over": (
        "signals_preprocessed",
        both(measured("sliding_distance"), column("sliding_distance", lambda distance: distance + 100)),
        "sliding_distance",
    ),
    "speed with a hole": (
        "axis_incomplete",
        column("sliding_distance", lambda distance: np.append(distance[:-9], [NAN] * 9)),
        "sliding_distance",
    ),
    "speed with a hole that the distance bridges": (
        "axis_incomplete",
        lambda run: replace(
            run,
            columns={**run.columns, "sliding_speed": np.where(np.arange(len(run)) == 7, NAN, 0.4)},
            origins={
                **run.origins,
                "sliding_speed": "measured",
                "sliding_distance": "derived from measured speed",
            },
        ),
        "sliding_distance",
    ),
    "speed by the clock": (
        "distance_not_planned",
        both(measured("sliding_distance"), column("time", lambda time: time * 2)),
        "sliding_speed",
    ),
    "speed by the rotations": (
        "distance_not_planned",
        lambda run: replace(
            column("time", lambda time: time * 2)(run),
            origins={**run.origins, "sliding_distance": "derived from rotations"},
        ),
        "sliding_speed",
    ),
    "kg/m³ as g/cm³": (
        "implausible_density",
        manifest(contact__pin__density="3210 g/cm^3"),
        "contact.pin.density",
    ),
    "dead load": (
        "load_not_nominal",
        column("normal_force", lambda load: -1e-6 * np.cos(np.arange(len(load)))),
        "normal_force",
    ),
    "load upside down and too small": (
        "load_not_nominal",
        column("normal_force", lambda load: load / -2),
        "normal_force",
    ),
    "strokes beside a large offset": (
        "friction_sign",
        both(manifest(conditions__stroke="5 mm"), there_and_back(60, offset=-1.5)),
        "friction_coefficient",
    ),
    "strokes too short to be told": (
        "friction_sign",
        both(manifest(conditions__stroke="5 mm"), there_and_back(2)),
        "friction_coefficient",
    ),
    "load in kg": (
        "load_unit",
        column("normal_force", lambda load: load / 9.81),
        "conditions.normal_load",
    ),
    "wear below the scar's cap": (
        "measurements_disagree",
        manifest(end_values__pin_wear_depth={"value": "8 um", "standard_uncertainty": "0.2 um"}),
        "end_values",
    ),
    "nominal load in a column": (
        "conditions_change",
        extra("Nominal Load [N]", "N", lambda time: np.where(time < time[len(time) // 3], 0.4, 0.8)),
        "Nominal Load [N]",
    ),
    "clock without a time zone": (
        "future_start",
        manifest(started=f"{datetime.now(UTC) + timedelta(days=1):%Y-%m-%dT%H:%M:%S}"),
        "started",
    ),
}


def found_by(name, run):
    return [finding for finding in check_run(run) if finding.code == name]


def test_rows_before_the_test_are_left_out_of_the_distance_as_well(sound):
    """To delete them is not enough: the clock still counts them."""
    still = column("friction_force", lambda force: np.where(np.arange(len(force)) < 200, 0.0, force))
    later = column("friction_force", lambda force: np.where(np.arange(len(force)) > 700, 0.0, force))
    kept = both(without("normal_force"), measured("sliding_distance"))
    (begun,), (ended,) = (found_by("contact_lost", both(kept, one)(sound)) for one in (still, later))
    assert 'carried_over = "always"' in begun.remedy
    assert "carried_over" not in ended.remedy


def test_distance_by_the_nominal_speed_that_is_left_out_is_reported_where_it_is_long(sound):
    for still, reported in ((200, True), (10, False)):
        idle = column("friction_force", lambda force, n=still: np.where(np.arange(len(force)) < n, 0.0, force))
        found = found_by("contact_lost", both(without("normal_force"), idle)(sound))
        assert [("do not" in one.message, '"idle"' in one.remedy) for one in found] == [(True, True)] * reported


def unloaded_half(run):
    """Let the first half of the run go by without contact."""
    contact = np.arange(len(run)) > len(run) / 2
    columns = {name: run.columns[name] * contact for name in ("normal_force", "friction_force")}
    return replace(run, columns={**run.columns, **columns})


def stopped(run, pause=300.0):
    """Let the clock go on by so many seconds, half way, while nothing slides."""
    late = np.arange(len(run)) >= len(run) // 2
    return column("time", lambda time: time + pause * late)(measured("sliding_distance")(run))


INTERRUPTED = both(
    manifest(interruptions=[{"sliding_distance": "25 m", "pin_wear_depth": "5 um"}]), measured("sliding_distance")
)
# What is no trouble, or not the one that a check is for.
LESS = {
    "distance carried over, as the time shows": (
        "axis_offset",
        both(measured("sliding_distance"), column("sliding_distance", lambda distance: distance + 100)),
    ),
    "coating with low friction that wears through": (
        "contact_lost",
        column("friction_force", lambda force: np.where(np.arange(len(force)) < 400, 0.012, 0.3)),
    ),
    "low friction that wears through under a nominal load": (
        "contact_lost",
        both(
            without("normal_force"),
            column("friction_force", lambda force: np.where(np.arange(len(force)) < 400, 0.012, 0.3)),
        ),
    ),
    "steps of one test": (
        "running_in_repeats",
        lambda run: appended(running_in(run), both(running_in, friction_after_restart)(run)),
    ),
    "steps of one test in which friction rises on": (
        "running_in_repeats",
        lambda run: appended(
            *(
                samples_set("friction_coefficient", slice(None), np.linspace(0, 0.15, len(run)) + start)(
                    running_in(run)
                )
                for start in (0.5, 0.65)
            )
        ),
    ),
    "friction that rises again within a test": (
        "running_in_repeats",
        both(running_in, samples_set("friction_coefficient", slice(500, 800), 0.8)),
    ),
    "friction that runs in anew after a stated interruption": (
        "running_in_repeats",
        both(
            manifest(interruptions=[{"sliding_distance": "1 m", "pin_wear_depth": "1 um"}]),
            lambda run: appended(running_in(run), running_in(run)),
        ),
    ),
    "scar measured in both directions": (
        "scar_not_round",
        manifest(
            end_values__disc_wear_depth="5 um", end_values__pin_scar_diameter={"values": ["255 um", "305 um"] * 3}
        ),
    ),
    "worn scar beside a volume that is better known": (
        "scar_not_round",
        manifest(
            end_values__disc_wear_depth="20 um",
            end_values__pin_wear_volume={"value": "0.0003 mm^3", "standard_uncertainty": "1 %"},
        ),
    ),
    "hum beside a slow disc": ("runout_differs", rotating(1.0, hum=2.9)),
    "runout sampled so slowly that it seems to be that of minutes": (
        "runout_differs",
        rotating(1.0, rate=(3.7 - 3.7 / 60) / 20),
    ),
    "a wander about as slow as the disc in minutes": ("runout_differs", rotating(1.0, hum=1.05 * 3.7 / 60)),
    "clock that is slower than the samples": ("repeated_samples", column("time", np.floor)),
    "mass loss within the noise of the balance": (
        "implausible_conditions",
        manifest(end_values__pin_mass_loss={"value": "0.4 ug", "standard_uncertainty": "1 ug"}),
    ),
    "scar a little longer than wide": (
        "scar_or_radius",
        manifest(end_values={"pin_scar_length": "460 um", "pin_scar_width": "445 um"}),
    ),
    "groove as deep as the pin has worn": ("scar_or_radius", manifest(end_values__disc_wear_depth="15 um")),
    "superlubricity": ("implausible_friction", friction_times(1 / 300)),
    "friction that was not recorded": ("implausible_friction", friction_times(0)),
    "mean speed of strokes": (
        "strokes_differ",
        both(manifest(conditions__sliding_speed="0.85 mm/s"), THERE_AND_BACK),
    ),
    "stop at a stated interruption": ("recording_gap", both(INTERRUPTED, stopped)),
    "sensor at a lever whose ratio is stated": (
        "implausible_depth",
        both(manifest(sensors__depth_scale=0.5), column("depth", lambda depth: 2 * depth)),
    ),
    "sampling rate that changes after the start": (
        "recording_gap",
        column("time", lambda time: time + 5.0 * np.maximum(np.arange(len(time)) - 600, 0)),
    ),
    "speed of a test with a stop": ("distance_not_planned", stopped),
    "speed of a test with a recorded stop": (
        "distance_not_planned",
        both(
            measured("sliding_distance"),
            manifest(conditions__sliding_distance="38 m"),
            column("time", lambda time: np.arange(len(time)) * time[1]),
            column("sliding_distance", lambda s: np.interp(np.arange(len(s)), [0, 400, 700, len(s)], [0, 16, 16, 38])),
        ),
    ),
    "depth in steps of 1 µm": ("dead_channel", column("depth", lambda depth: 1e-6 * np.round(1e6 * depth))),
    "strokes under load": (
        "contact_lost",
        both(manifest(conditions__stroke="5 mm"), there_and_back(60, offset=0.9)),
    ),
    "two steps of one test": ("repeated_samples", lambda run: appended(run, column("depth", lambda d: d + 1e-5)(run))),
    "load in a long loading ramp": (
        "load_not_nominal",
        column("normal_force", lambda load: load * np.minimum(1, np.arange(len(load)) / 100)),
    ),
    "running-in before steady wear": (
        "wear_decreases",
        manifest(interruptions=weighings(4.0, 4.7, 5.4, 6.1), end_values__pin_wear_volume=volume(6.8)),
    ),
    "half of the run without contact": ("load_not_nominal", unloaded_half),
    "unzeroed load, half of the run without contact": (
        "load_sign",
        both(unloaded_half, column("normal_force", lambda load: load - 0.02)),
    ),
    "dead load": ("load_sign", column("normal_force", lambda load: -1e-6 * np.cos(np.arange(len(load))))),
    "load upside down": (
        "implausible_friction",
        both(column("normal_force", np.negative), column("friction_coefficient", np.negative)),
    ),
    "there and back": (
        "implausible_friction",
        both(manifest(conditions__stroke="5 mm"), there_and_back(60)),
    ),
}


@pytest.mark.parametrize("case", LESS)
def test_check_raises_no_false_alarm(sound, case):
    name, spoil = LESS[case]
    assert found_by(name, spoil(sound)) == []


def test_every_check_has_a_case():
    assert set(CASES) == set(CHECKS)


def test_sound_run_has_no_findings(sound):
    assert check_run(sound) == []


@pytest.mark.parametrize("name", CASES)
def test_check_finds(sound, name):
    severity, spoil, where, _ = CASES[name]
    findings = found_by(name, spoil(sound))
    assert where in [finding.where for finding in findings]
    assert {finding.severity for finding in findings} == {severity}
    assert all("found" in finding.message and "expected" in finding.message for finding in findings)


@pytest.mark.parametrize("name", others_slow(CASES, first=20))
def test_check_leaves_alone(sound, name):
    *_, nearly = CASES[name]
    assert found_by(name, nearly(sound)) == []


@pytest.mark.parametrize("case", MORE)
def test_check_also_finds(sound, case):
    name, spoil, where = MORE[case]
    assert [finding.where for finding in found_by(name, spoil(sound))] == [where]


def test_a_gap_is_placed_where_it_is_although_times_before_it_are_missing(sound):
    late = column("time", lambda time: time + 5.0 * (np.arange(len(time)) > 600))
    (gap,) = found_by("recording_gap", both(late, samples_set("time", slice(50, 60), NAN))(sound))
    assert "after sample 601;" in gap.message


@pytest.mark.parametrize(("factor", "named"), [(-1, True), (3, False)])
def test_remedy_for_a_depth_that_counts_down_names_the_step(sound, factor, named):
    (finding,) = found_by("implausible_depth", column("depth", lambda depth: factor * depth)(sound))
    assert ('"invert" with signals = ["depth"]' in str(finding)) == named


def drifting(amount, temperature=None):
    """Let the reading drift by so many meters, and the room by so many kelvins."""

    def spoil(run):
        share = np.linspace(0, 1, len(run))
        columns = {**run.columns, "depth": run.columns["depth"] + amount * share}
        if temperature is not None:
            columns["temperature"] = 295 + temperature * share
        return replace(run, columns=columns, origins={**dict.fromkeys(columns, "measured"), **run.origins})

    return spoil


@pytest.mark.parametrize(
    ("temperature", "words"),
    [
        (
            None,
            "thermal drift is likely: let the tribometer warm up before the test, and record the temperature; or check",
        ),
        (0.1, "thermal drift is likely: let the tribometer warm up before the test; or check"),
        (3.0, "thermal drift is likely, since the temperature changed by 3 K"),
    ],
)
def test_thermal_drift_is_named_before_sign_and_unit(sound, temperature, words):
    (finding,) = found_by("implausible_depth", drifting(20e-6, temperature)(sound))
    assert finding.remedy.startswith(words)
    assert "check the sign and unit" in finding.remedy


def test_thermal_drift_comes_last_where_it_cannot_be_so_large(sound):
    spoil = both(drifting(300e-6), manifest(end_values__pin_wear_depth="3 um"))
    (finding,) = found_by("implausible_depth", spoil(sound))
    assert finding.remedy.endswith("thermal drift is rarely that large")


@pytest.mark.parametrize(("dead", "warns"), [(0.6, True), (0.4, False)])
def test_friction_of_zero_through_most_of_a_test_is_named(sound, dead, warns):
    def without(values):
        values[: int(dead * len(values))] = 0.0

    found = found_by("dead_channel", column("friction_force", without)(sound))
    assert [(one.where, "found 0 in 60 % of the samples" in one.message) for one in found] == (
        [("friction_force", True)] if warns else []
    )


def test_scar_given_by_its_radius_is_named_beside_the_depth(sound):
    scar = sound.manifest.end_values.pin_scar_diameter
    deep = both(
        manifest(end_values__pin_scar_diameter="200 um"),
        column("depth", lambda depth: np.linspace(0, 200e-6**2 / (2 * 0.794e-3), len(depth))),
    )
    assert scar is not None
    (finding,) = found_by("implausible_depth", deep(sound))
    assert "pin_scar_diameter is not a radius" in finding.remedy


@pytest.mark.parametrize(
    ("changes", "deep", "words"),
    [
        ({"end_values__pin_scar_diameter": "200 um"}, 200e-6**2 / (2 * 0.794e-3), "pin_scar_diameter is not a radius"),
        ({"end_values__pin_scar_diameter": "400 um"}, 4e-8 / 0.794e-3, "contact.pin.radius is not a diameter"),
    ],
)
def test_size_that_would_fit_is_named_with_a_disc_that_wore_besides(sound, changes, deep, words):
    groove = 4e-6
    worn = both(
        manifest(end_values__disc_wear_depth=f"{1e6 * groove} um", **changes),
        column("depth", lambda depth: np.linspace(0, deep + groove, len(depth))),
    )
    (finding,) = found_by("implausible_depth", worn(sound))
    assert f"and that {words}" in finding.remedy


def test_errors_come_first_and_refuse_the_run(sound):
    spoil = both(samples_set("time", 7, 0.5), samples_set("depth", 7, NAN), manifest(contact__pin__density="3 kg/m^3"))
    findings = check_run(spoil(sound))
    assert [finding.severity for finding in findings] == ["error", "error", "warning"]
    with pytest.raises(CheckError, match=r"^si3n4-air-400mN: .*\(and 1 more; see `tribopipe check`\)$"):
        refuse_errors(sound, findings)
    refuse_errors(sound, findings[2:])


@pytest.mark.parametrize(("unit", "shown", "warns"), [("%", 4.1, False), ("%", 2.8, True), (None, 2.8, False)])
def test_recorded_slip_is_compared_with_the_stated_one(unit, shown, warns):
    discs = read_run(SAMPLES / "si3n4-twin-disc-4pct-1000k")
    found = found_by("conditions_differ", extra("Slip", unit, shown)(discs))
    assert [finding.where for finding in found] == (["conditions.slip"] if warns else [])


@pytest.mark.parametrize("recorded", [True, False])
def test_elastic_scar_names_the_larger_error_of_a_fit_with_a_depth_signal(sound, recorded):
    small = manifest(end_values__pin_scar_diameter="40 um")(sound)
    (finding,) = found_by("elastic_scar", small if recorded else without("depth")(small))
    assert ("several times this fraction" in finding.remedy) == recorded


def hertz_diameter(run):
    """Return the diameter of the unworn contact, m."""
    contact, load = run.manifest.described, run.manifest.conditions.normal_load.value
    return 2 * float(np.cbrt(3 * load * contact.pin.radius.value / (4 * contact.reduced_modulus())))


@pytest.mark.parametrize("share", [0.94, 0.99, 0.999])
def test_scar_that_may_be_as_small_as_the_unworn_contact_is_no_wear(sound, share):
    """One less than 3u below Hertz's diameter would else be neither too small nor elastic."""
    width = share * hertz_diameter(sound)
    scar = {"value": f"{1e6 * width} um", "standard_uncertainty": f"{0.03e6 * width} um"}
    run = manifest(end_values__pin_scar_diameter=scar)(sound)
    (finding,) = found_by("elastic_scar", run)
    assert "all of the wear volume calculated from the scar" in finding.message
    assert not found_by("scar_or_radius", run)


@pytest.mark.parametrize(("share", "part"), [(0.5, "all"), (1.2, "about 58 %"), (4.0, None)])
def test_track_as_wide_as_the_unworn_contact_is_no_wear(sound, share, part):
    width = share * hertz_diameter(sound)
    track = {"value": f"{1e6 * width} um", "standard_uncertainty": f"{0.01e6 * width} um"}
    unworn = {"value": "0 um", "standard_uncertainty": "10 nm"}
    known = {"pin_wear_depth": unworn, "disc_track_width": track}
    run = manifest(end_values=known, conditions__track_radius="8 mm")(sound)
    told = [finding.message for finding in found_by("elastic_scar", run)]
    assert len(told) == bool(part)
    assert all(f"{part} of the wear volume calculated from the track" in one for one in told)


@pytest.mark.parametrize(("levels", "warns"), [(8, False), (200, True)])
def test_a_plateau_of_a_coarse_reading_is_not_a_saturated_sensor(sound, levels, warns):
    def flattens(depth):
        reading = np.minimum(np.linspace(0, 2, len(depth)), 1.0)
        return np.round(reading * levels) / levels * 1e-5

    run = both(measured("depth"), column("depth", flattens))(sound)
    assert bool(found_by("clipped_signal", run)) == warns
