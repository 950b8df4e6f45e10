"""Findings of the checks of a run, their short titles, and their wording with the names of the contact."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Literal, TypeVar

from tribopipe.documents.record import Record

Severity = Literal["error", "warning", "note"]


class Finding(Record):
    """One thing a person should know about a run before trusting it."""

    severity: Severity
    """Error: the run is refused. Warning: look before you trust it. Note: good to know."""
    code: str
    """Name of the check, by which scripts distinguish findings."""
    where: str
    """Key of run.toml, or the signal."""
    message: str
    """Observation and expectation."""
    remedy: str
    """Remedy."""

    def __str__(self) -> str:
        return f"{self.where}: {self.message}; {self.remedy}"


def first_of_each_code(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return the first finding of each code at each place: two laws fitted to one reading share what speaks against it.

    Parameters
    ----------
    findings
        Findings of the fits of one run, the main law first.

    Returns
    -------
    tuple of Finding
        In the same order.
    """
    firsts: dict[tuple[str, str], Finding] = {}
    for finding in findings:
        firsts.setdefault((finding.code, finding.where), finding)
    return tuple(firsts.values())


def findings_of(results: Iterable[object]) -> tuple[Finding, ...]:
    """Return the findings against the results of a run, without duplicates of code and place."""
    return first_of_each_code(finding for result in results for finding in getattr(result, "findings", ()))


TITLES: Mapping[str, str] = {
    "implausible_density": "density implausible for a solid",
    "implausible_modulus": "implausible Young's modulus",
    "modulus_unit": "Young's modulus in the wrong unit",
    "material_properties": "properties outside the range for the material",
    "radius_or_diameter": "pin radius may be a diameter",
    "radius_unchecked": "pin radius cannot be checked",
    "initial_yielding": "yielding at the start of the test",
    "rate_not_steady": "overall and steady-state wear rates differ",
    "implausible_wear": "implausible wear rate",
    "scar_or_radius": "scar size may be a radius",
    "profile_width": "width and depth of a wear track do not match",
    "profile_height": "heights of a profile may be in the wrong unit",
    "elastic_scar": "scar or track partly due to elastic deformation",
    "scar_not_round": "scar measured in an unknown direction",
    "uneven_scars": "readings of the scar differ widely",
    "stroke_within_scar": "stroke shorter than the contact",
    "wear_decreases": "less wear at a later interruption",
    "material_gained": "material gained",
    "coating_worn_through": "coating worn through",
    "implausible_conditions": "implausible size, load or speed",
    "future_start": "start date in the future",
    "missing_input": "inputs for k_D missing",
    "reader_assumption": "file read with assumptions",
    "units_disagree": "unit differs from that in the file",
    "unused_signal": "recorded signal not used",
    "worn_before": "specimens possibly worn before the test",
    "friction_lever": "friction force with unknown lever arm",
    "unstated_uncertainty": "default uncertainties used",
    "impossible_measurement": "impossible post-test measurement",
    "no_wear_in_profile": "no wear track found in a profile",
    "gap_in_profile": "heights missing in a wear track",
    "map_radius_differs": "tip radius differs from that in the height map",
    "measurements_disagree": "post-test measurements disagree",
    "no_samples": "no samples",
    "empty_channel": "empty channel",
    "axis_incomplete": "time or distance missing for some samples",
    "axis_backward": "time or distance decreases",
    "counter_glitch": "counter glitches",
    "axis_constant": "time or distance does not increase",
    "distance_unknown": "sliding distance unknown",
    "samples_averaged": "block means evaluated",
    "signals_preprocessed": "signals preprocessed",
    "load_sign": "measured load with the wrong sign",
    "load_not_nominal": "measured and nominal load differ",
    "load_unit": "measured load in the wrong unit",
    "conditions_change": "conditions change during the test",
    "conditions_differ": "recorded and stated conditions differ",
    "stated_speeds_differ": "stated speeds inconsistent",
    "track_beyond_disc": "wear track outside the disc",
    "channels_disagree": "channels inconsistent with each other",
    "strokes_differ": "recorded and stated strokes differ",
    "runout_differs": "runout at an unexpected frequency",
    "strokes_unused": "friction per stroke not evaluated",
    "no_friction_per_stroke": "friction per stroke not available",
    "missing_samples": "samples missing",
    "repeated_samples": "samples repeated",
    "recording_gap": "gap in the recording",
    "dead_channel": "channel constant or zero",
    "clipped_signal": "signal at the end of its range",
    "contact_lost": "no friction during part of the test",
    "running_in_repeats": "running-in occurs twice",
    "friction_offset": "offset in the friction force",
    "uncertain_zero": "zero of a force uncertain",
    "friction_sign": "friction changes sign",
    "implausible_friction": "implausible friction coefficient",
    "interruption_after_end": "interruption after the end of the test",
    "implausible_depth": "implausible depth signal",
    "distance_not_planned": "actual and planned distance differ",
    "axis_offset": "time or distance does not start at zero",
    "no_post_test_measurement": "k_D from the depth signal alone",
    "reading_contradicts_measurement": "depth signal contradicts the post-test measurement",
    "disc_by_depth_signal": "disc wear from depth signal",
    "disc_not_measured": "disc not measured",
    "track_length_unknown": "length of the wear track unknown",
    "two_step_differs": "two-step correction gives a different k_D",
    "wear_rate_changes": "wear rate changes during the test",
    "reading_settles": "settling in the depth signal",
    "reading_follows_temperature": "depth signal changes with temperature",
    "curve_shape": "depth signal not explained by the model",
    "depth_steps": "steps in the depth signal",
    "depth_spikes": "spikes in the depth signal",
    "depends_on_drift_prior": "k_D depends on the assumed drift",
    "depends_on_settling_prior": "k_D depends on the assumed settling",
    "depends_on_engine": "k_D depends on the assumed pressure distribution",
}
"""Titles by code of the finding."""


def title(code: str) -> str:
    """Return what a finding is called; the code in words where another package has found it."""
    return TITLES.get(code) or code.replace("_", " ").replace("-", " ")


R = TypeVar("R", bound=Record)


def reworded(result: R, worded: Callable[[str], str]) -> R:
    """Return a result whose sentences are those that ``worded`` makes of them."""
    changed: dict[str, Any] = {}
    if notes := getattr(result, "notes", ()):
        changed["notes"] = tuple(map(worded, notes))
    if findings := getattr(result, "findings", ()):
        changed["findings"] = tuple(
            one.model_copy(update={part: worded(getattr(one, part)) for part in ("where", "message", "remedy")})
            for one in findings
        )
    if anchor := getattr(result, "anchor", None):
        changed["anchor"] = worded(anchor)
    return result.model_copy(update=changed) if changed else result
