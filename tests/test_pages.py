"""Pages of runs and studies as text: all that is known stands there, and is read without the curves."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from archived_files import edited
from folders import replace_in, set_key

from tribopipe.archive import nexus
from tribopipe.archive.step_names import STEPS, StepOutline
from tribopipe.archive.store import Archive
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.documents.contact import Pin
from tribopipe.documents.manifest import Conditions, EndValues, Interruption, RunManifest, StatedFriction
from tribopipe.documents.preprocessing import Change, CleanUp
from tribopipe.documents.quantity import EndValue, Quantity
from tribopipe.documents.twin_disc import CurvedDisc, FlatDisc
from tribopipe.pipeline.stages import ingest
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.finding import Finding
from tribopipe.results.local_wear import LocalDiscPoint, LocalPinPoint, LocalWearResult
from tribopipe.results.specific_wear import SpecificWear
from tribopipe.results.study import (
    BetweenRuns,
    BodyVerdict,
    ChangePoint,
    EndOfLife,
    EngineComparison,
    Exponent,
    LawComparison,
    LawResult,
    LeftOut,
    RunVerdict,
    StudiedBody,
    StudyResult,
    Trend,
)
from tribopipe.results.wear_fit import (
    BodyWear,
    Contribution,
    ConventionCoefficients,
    FittedValue,
    HertzStart,
    MonteCarlo,
    WearFit,
)
from tribopipe.results.wear_prediction import (
    PredictedBody,
    PredictedContact,
    PredictedPoint,
    UsedCoefficient,
    WearPrediction,
)
from tribopipe.views.page import Fact, StagePage, duration, interval, record_facts, shown
from tribopipe.views.run_page import _SECTIONS, _recorded, run_page, stage_pages, step_title
from tribopipe.views.study_page import study_page_of

RUN = "si3n4-air-200mN"
DATE = "2026-07-01T10:00:00+00:00"
NASTY = '<script>alert("1")</script> \x1b[31m'


def q(value: float, unit: str, spread: float | None = None) -> Quantity:
    return Quantity(value=value, unit=unit, standard_uncertainty=spread)


K = q(1.35e-14, "m^2/N", 3e-16)
ENDS = (q(1.3e-14, "m^2/N"), q(1.4e-14, "m^2/N"))


def facts_of(page, title: str) -> dict[str, str]:
    """The facts of a group, or of a stage."""
    if isinstance(page, StagePage):
        return {fact.name: fact.value for fact in page.facts}
    (group,) = [group for group in page.facts if group.title == title]
    return {fact.name: fact.value for fact in group.facts}


def stage(result, name: str, *before: tuple[str, object]) -> StagePage:
    """The page of a result, others being there before it."""
    steps = {
        step: StepOutline(step, found, "in", {}, "0.1.0", DATE, result_sha256="out")
        for step, found in (*before, (name, result))
    }
    return stage_pages(steps)[-1]


def table(page: StagePage, title: str) -> tuple[tuple[str, ...], ...]:
    (found,) = [table for table in page.tables if table.title == title]
    assert {len(row) for row in found.rows} == {len(found.columns)}
    return found.rows


# --- a run ---


def test_long_distances_are_shown_without_a_computer_exponent(archive):
    outline = Archive(archive).outline(RUN)
    recorded = _recorded(replace(outline, ends={**outline.ends, "sliding_distance": 17970.0}))
    assert Fact("sliding distance", "17970 m") in recorded


def test_page_has_what_was_tested_and_how(archive):
    page = run_page(Archive(archive), RUN)
    assert [group.title for group in page.facts] == [
        *("Pin", "Disc", "Conditions", "Instrument", "Recorded", "Signals", "Post-test measurements", "Computed with")
    ]
    assert facts_of(page, "Pin")["radius"] == "0.7940 ± 0.0016 mm"
    assert facts_of(page, "Pin")["Young's modulus"] == "304.0 ± 6.1 GPa"
    assert facts_of(page, "Disc")["roughness Ra"] == "0.11 µm"
    assert facts_of(page, "Conditions")["normal load"] == "200.0 ± 2.0 mN"
    assert facts_of(page, "Recorded") == {"samples": "1,251", "duration": "125 s", "sliding distance": "50 m"}
    assert facts_of(page, "Signals")["sliding distance"] == "derived from nominal speed"
    assert facts_of(page, "Post-test measurements")["pin scar diameter"].endswith("µm, white-light")
    assert (page.id, page.tribometer, page.bad, page.tags, page.studies) == (RUN, "pin-on-disc", None, (), ())


def test_environment_is_told_once_or_for_the_steps_that_had_another(archive):
    store = Archive(archive)
    (told,) = facts_of(run_page(store, RUN), "Computed with").items()
    assert told[0] == "all steps"
    assert f"numpy {np.__version__}" in told[1]
    with edited(store.path(RUN)) as file:
        file["entry/friction_fit/environment/data"][()] = '{"numpy": "1.0"}'
        del file["entry/archived/environment"]
    *_, friction = facts = facts_of(run_page(store, RUN), "Computed with")
    assert facts[friction] == "numpy 1.0"
    assert (friction, len(facts)) == ("friction fit", 2)


def test_page_has_every_step_and_every_source(archive):
    store = Archive(archive)
    page = run_page(store, RUN)
    assert [stage.name for stage in page.stages] == store.step_names(RUN)
    for found in page.stages:
        step = store.step(RUN, found.name)
        assert found.title == step_title(found.name)
        assert found.path == f"/entry/{found.name}"
        assert (found.inputs_sha256, found.result_sha256) == (step.inputs_sha256, step.result_sha256)
        assert (found.program_version, found.date, found.options) == (step.program_version, step.date, step.options)
    raw = store.raw(RUN)
    assert [(one.number, one.name, one.size, one.sha256) for one in page.sources] == [
        (number, source.name, len(source.content), source.sha256) for number, source in enumerate(raw.sources)
    ]
    assert page.raw_sha256 == store.raw_sha256(RUN)


def test_page_needs_no_curve(archive, monkeypatch):
    def fail(*_: object) -> None:
        raise AssertionError("curves were read")

    whole = run_page(Archive(archive), RUN)
    monkeypatch.setattr(nexus, "floats", fail)
    assert run_page(Archive(archive), RUN) == whole


def test_page_of_two_discs_has_both(short_discs):
    page = run_page(short_discs, short_discs.ids()[0])
    assert [group.title for group in page.facts][:2] == ["Crowned disc", "Cylindrical disc"]
    assert facts_of(page, "Crowned disc")["crown radius"].endswith(" mm")
    assert facts_of(page, "Conditions")["slip"].endswith(" %")
    assert facts_of(page, "Recorded")["rotations"]
    assert page.tribometer == "twin-disc"


@pytest.fixture
def short_discs(tmp_path) -> Archive:
    """An archive of one ingested twin-disc run."""
    from folders import SAMPLES

    store = Archive(tmp_path / "discs")
    assert ingest(SAMPLES / "si3n4-twin-disc-4pct-100k", store).error is None
    return store


def test_page_of_a_run_that_was_only_ingested(sample_run, tmp_path):
    store = Archive(tmp_path / "a")
    run_id = ingest(sample_run, store).run_id
    page = run_page(store, run_id)
    assert (page.stages, page.findings) == ((), tuple(store.findings(run_id)))


def test_page_without_contact_tells_the_rest(sample_run, tmp_path):
    replace_in(sample_run / "run.toml", r"(?s)\[contact\].*?(?=\[conditions\])", "")
    replace_in(sample_run / "run.toml", r"(?s)\[end_values\].*", "")
    store = Archive(tmp_path / "a")
    outcome = ingest(sample_run, store)
    assert outcome.error is None
    page = run_page(store, outcome.run_id)
    assert page.tribometer is None
    titles = [group.title for group in page.facts]
    assert titles == ["Conditions", "Instrument", "Recorded", "Signals", "Computed with"]


def test_texts_come_as_the_lab_wrote_them(sample_run, tmp_path):
    for key in ("title", "instrument"):
        set_key(sample_run, key, '"<script>alert(\\"1\\")</script> \\u001b[31m"')
    replace_in(sample_run / "run.toml", '(?m)^id = "', "operator = 'O<b>'\ncomment = '=1+1'\nid = \"")
    store = Archive(tmp_path / "a")
    page = run_page(store, ingest(sample_run, store).run_id)
    assert page.title == NASTY
    told = facts_of(page, "Instrument")
    assert (told["instrument"], told["operator"], told["comment"]) == (NASTY, "O<b>", "=1+1")


@pytest.mark.slow
def test_remarks_are_marks_tags_and_notes_in_order(archive):
    store = Archive(archive)
    store.mark(RUN, Mark(kind="bad", reason="slipped", date="2026-07-02T10:00:00+00:00", operator="anna"))
    store.annotate(RUN, Annotation(kind="tag", text="run-in", date=DATE))
    store.annotate(RUN, Annotation(kind="note", text="odd noise", date="2026-07-03T10:00:00+00:00", operator="otto"))
    page = run_page(store, RUN)
    assert (page.bad, page.tags) == ("slipped", ("run-in",))
    assert [(one.kind, one.text, one.operator) for one in page.remarks] == [
        ("tag", "run-in", None),
        ("bad", "slipped", "anna"),
        ("note", "odd noise", "otto"),
    ]
    store.mark(RUN, Mark(kind="good", reason="it did not", date="2026-07-04T10:00:00+00:00"))
    assert run_page(store, RUN).bad is None


# --- facts ---

LENGTH = q(1e-3, "m", 1e-5)
STATED = StatedFriction(amplitude=q(0.2, "1"), steady_state=q(0.5, "1"), running_in_distance=q(30, "m"))
FULL = {"friction": STATED, "medium": "air", "rotations": 2e6, "remounted": True}


@pytest.mark.parametrize("record", [Pin, CurvedDisc, FlatDisc, Conditions, EndValues, Interruption])
def test_every_field_of_run_toml_becomes_a_fact(record):
    names = list(record.model_fields)
    filled = record.model_construct(**{name: FULL.get(name, LENGTH) for name in names})
    told = {fact.name: fact.value for fact in record_facts(filled)}
    assert len(told) == len(names)
    assert told.get("rotations", "2,000,000") == "2,000,000"


def test_stated_friction_and_speed_are_told(bare_run):
    document = bare_run.manifest.model_dump(mode="json", by_alias=True)
    document["conditions"] = {
        "normal_load": "2 N",
        "rotational_speed": "60 rpm",
        "track_radius": "10 mm",
        "temperature": "23 degC",
        "relative_humidity": "45 %",
        "friction": STATED.model_dump(),
    }
    conditions = RunManifest.model_validate(document).conditions
    told = {fact.name: fact.value for fact in record_facts(conditions)}
    assert list(told.items()) == list(
        {
            "normal load": "2 N",
            "rotational speed": "60 rpm",
            "track radius": "10 mm",
            "temperature": "23 °C",
            "relative humidity": "45 %",
            "stated friction coefficient": "A = 0.2, b = 0.5, c = 30 m",
        }.items()
    )


def test_end_values_tell_method_and_readings():
    depth = EndValue(value=2e-6, unit="m", standard_uncertainty=1e-7, method="stylus", readings=(1.9e-6, 2.1e-6))
    (fact,) = record_facts(EndValues(pin_wear_depth=depth))
    assert (fact.name, fact.value) == ("pin wear depth", "2.00 ± 0.10 µm, stylus, mean of 2 readings: 1.9, 2.1")


def test_units_are_those_people_read():
    assert shown(q(0.2, "N")) == "200 mN"
    assert shown(q(2.0, "N")) == "2 N"
    assert shown(q(296.15, "K")) == "23 °C"
    assert shown(q(1e-9, "m^3")) == "1 mm³"
    assert shown(None) is None
    assert interval((q(1e-6, "m"), q(2e-6, "m")), "um") == "1.00 to 2.00 µm"
    assert interval((q(1.0, "m"), None), "m") == "1 m or more"
    assert [duration(q(s, "s")) for s in (59.0, 1200.0, 36_000.0)] == ["59 s", "20 min", "10 h"]


# --- steps ---


def test_every_step_has_a_title_and_every_kind_of_result_is_told():
    assert len(set(map(step_title, STEPS))) == len(STEPS)
    assert set(_SECTIONS) == {record for kind in STEPS.values() for record in kind.records}


def test_wear_fit_tells_budget_draws_and_what_k_d_is_by_each_way():
    drawn = MonteCarlo(
        draws=20_000,
        mean=K,
        standard_uncertainty=q(3e-16, "m^2/N"),
        stable=False,
        first_order_interval=ENDS,
        agrees_with_first_order=False,
    )
    budget = (
        Contribution(name="normal load", value=q(0.2, "N", 0.002), shown_in="mN", source="manifest", relative=-0.01),
        Contribution(name="noise of the depth signal", source="fit", relative=0.0008),
        Contribution(name="disc modulus", value=q(304e9, "Pa"), shown_in="GPa", source="default", relative=-4e-5),
    )
    fit = WearFit(
        model="archard", outcome="fitted", notes=("beware",), basis="measurement", deviation=4.2,
        bodies={"pin": BodyWear(
            wear_coefficient=K, interval=ENDS, budget=budget, monte_carlo=drawn, fitted_end_depth=q(2.35e-5, "m"),
            by_reading=q(1.6e-14, "m^2/N", 5e-16), by_measurement=K,
        )},
    )  # fmt: skip
    page = stage(fit, "wear_fit_archard")
    told = facts_of(page, "")
    assert told["k_D of the pin (Archard's law)"] == "(1.350 ± 0.030)×10⁻⁸ mm³/(N·mm)"
    assert told["95 % CI"] == "(1.300 to 1.400)×10⁻⁸ mm³/(N·mm)"
    assert page.notes == ("beware",)
    assert table(page, "uncertainty budget of k_D of the pin") == (
        ("normal load", "200.0 ± 2.0 mN", "run.toml", "normal", "−1.00", "1.00 %", "99.4 %"),
        ("noise of the depth signal", "–", "fit", "normal", "–", "0.08 %", "0.6 %"),
        ("Young's modulus of the disc", "304 GPa", "default", "normal", "–", "0.00 %", "0.0 %"),
    )
    narrow = next(one for one in page.tables if one.title == "uncertainty budget of k_D of the pin").without_spare()
    assert narrow.columns == ("input", "value", "source", "contribution", "share of variance")
    assert narrow.rows[0] == ("normal load", "200.0 ± 2.0 mN", "run.toml", "1.00 %", "99.4 %")
    first, second = table(page, "k_D of the pin: Monte Carlo and first-order")
    assert (first[0], first[3], second[3]) == ("Monte Carlo, 20,000 draws (not converged)", "do not agree", "")
    reading, measured, reported, apart = table(page, "k_D of the pin from depth signal and measurement")
    assert reading == ("depth signal alone", "(1.600 ± 0.050)×10⁻⁸ mm³/(N·mm)", "not used")
    assert (measured[1], reported[1:]) == (reported[1], ("(1.350 ± 0.030)×10⁻⁸ mm³/(N·mm)", "measurement"))
    assert apart[1] == "4.2 standard uncertainties"


def test_run_that_could_not_be_fitted_says_why():
    page = stage(WearFit(model="sarkar", outcome="not fitted", missing=("depth", "friction")), "wear_fit_sarkar")
    assert page.sentence.endswith("missing depth and friction")
    assert page.tables == ()
    assert not any(name.startswith("k_D") for name in facts_of(page, ""))


@pytest.mark.parametrize(
    ("fit", "sentence"),
    [
        (FrictionFit(outcome="none", notes=("not recorded",)), "friction not fitted"),
        (
            FrictionFit(outcome="steady-only", notes=("flat",), steady_state=q(0.5, "1")),
            "μ = 0.5, steady-state value only",
        ),
        (
            FrictionFit(
                outcome="exponential", amplitude=q(0.2, "1"), steady_state=q(0.5, "1"),
                running_in_distance=q(30, "m"), window=(q(0, "m"), q(50, "m")), notes=("hot",),
            ),
            "μ(s) = A·exp(−s/c) + b with A = 0.2, b = 0.5, c = 30 m",
        ),
    ],
)  # fmt: skip
def test_friction_says_what_was_found_and_why_apart(fit, sentence):
    page = stage(fit, "friction_fit")
    assert (page.sentence, page.notes) == (sentence, fit.notes)


def test_clean_up_tells_every_change():
    change = Change(step="mask", signal="normal_force", samples=1200, what="12 masked", why="no load cell reads that")
    page = stage(CleanUp(changes=(change,), left_out=("temperature",)), "clean_up")
    assert page.sentence == "normal_force: 12 masked"
    assert table(page, "changes") == (("normal force", "mask", "1,200", "12 masked", change.why),)
    assert facts_of(page, "") == {"excluded": "temperature"}
    assert stage(CleanUp(), "clean_up").sentence == "nothing to do"


def test_specific_wear_without_any_volume_says_so():
    page = stage(SpecificWear(outcome="not evaluated", notes=("nothing was measured",)), "specific_wear")
    assert (page.sentence, page.notes, page.tables) == ("no specific wear rate", ("nothing was measured",), ())


DISC_FIT = WearFit(
    model="archard",
    outcome="fitted",
    distance_per_rotation="full-slip",
    start=HertzStart(half_width=q(1.8e-5, "m"), half_length=q(1.1e-5, "m"), peak_pressure=q(5e8, "Pa")),
    bodies={name: BodyWear(wear_coefficient=K, interval=ENDS) for name in ("curved_disc", "flat_disc")},
    correlation=0.25,
    p_value=0.4,
    measurements=(
        FittedValue(name="curved_disc_wear_volume", place=1e6, measured=q(1e-12, "m^3"), fitted=q(1e-12, "m^3")),
        FittedValue(name="flat_disc_track_width", place=1e6, measured=q(1e-4, "m"), fitted=q(1.1e-4, "m")),
    ),
    equivalents=(ConventionCoefficients(distance_per_rotation="line-load", bodies={"curved_disc": K, "flat_disc": K}),),
)


def test_disc_fit_tells_both_discs():
    page = stage(DISC_FIT, "wear_fit_archard")
    told = facts_of(page, "")
    assert (
        told["k_D of the crowned disc (Archard's law)"]
        == told["k_D of the cylindrical disc (Archard's law)"]
        == "(1.350 ± 0.030)×10⁻⁸ mm³/(N·mm)"
    )
    assert (told["correlation between the two k_D values"], told["peak pressure of the unworn contact"]) == (
        "0.25",
        "500 MPa",
    )
    volume, width = table(page, "measured values and the fitted law")
    assert volume == ("wear volume of the crowned disc", "1,000,000", "0.001 mm³", "0.001 mm³")
    assert width[2:] == ("100 µm", "110 µm")
    assert table(page, "k_D with other sliding-distance conventions")[0][0] == "line-load"


def touching(approach, half_width, half_length, pressure):
    return PredictedContact(
        approach=q(approach, "m"), half_width=half_width, half_length=q(half_length, "m"),
        mean_pressure=q(pressure, "Pa"),
    )  # fmt: skip


def test_predictions_tell_every_place():
    point = PredictedPoint(
        sliding_distance=q(50, "m"), time=q(125, "s"), bodies={"pin": PredictedBody(wear_depth=q(5e-6, "m"))},
        contact=touching(5e-6, q(9e-5, "m"), 9e-5, 8e6),
    )  # fmt: skip
    pin = WearPrediction(
        model="archard", scheme="published", bodies={"pin": UsedCoefficient(wear_coefficient=K)}, reference="other",
        normal_load=q(0.2, "N"), conditions={"pin_radius": q(7.9e-4, "m")}, steps=100, step_error=0.012,
        notes=("far",), prediction=(point,), reached=(point,),
    )  # fmt: skip
    page = stage(pin, "prediction_archard")
    assert "\n" not in page.sentence
    assert table(page, "predicted") == (("50 m", "125 s", "5 µm", "180 µm", "8 MPa"),)
    assert table(page, "predicted") == table(page, "points at which the specified wear depths are reached")
    assert facts_of(page, "")["relative error due to the step size"] == "+1.20 %"


def test_disc_predictions_tell_every_place():
    worn = PredictedBody(wear_depth=q(1e-6, "m"), wear_volume=q(1e-12, "m^3"))
    point = PredictedPoint(
        rotations=q(2e6, "1"), sliding_distance=q(2000, "m"), slip=q(0.04, "1"),
        contact=touching(2e-6, q(1e-4, "m", 1e-6), 1e-5, 1e8), bodies={"curved_disc": worn, "flat_disc": worn},
    )  # fmt: skip
    used = UsedCoefficient(wear_coefficient=K)
    prediction = WearPrediction(
        model="sarkar", scheme="exact", distance_per_rotation="full-slip", normal_load=q(0.25, "N"),
        bodies={"curved_disc": used, "flat_disc": used}, conditions={"slip": q(0.04, "1")}, start=DISC_FIT.start,
        prediction=(point,),
    )  # fmt: skip
    page = stage(prediction, "prediction_sarkar")
    (row,) = table(page, "predicted")
    assert row == (
        "2,000,000",
        "–",
        "1 µm",
        "1 µm",
        "0.001 mm³",
        "0.001 mm³",
        "200.0 ± 2.0 µm",
        "20 µm",
        "100 MPa",
        "4 %",
    )
    assert [one.title for one in page.tables] == ["predicted"]


def local_result(points: tuple) -> LocalWearResult:
    return LocalWearResult(
        model="archard", engine="rings", scheme="implicit", wear_coefficient=K, normal_load=q(0.2, "N"),
        steps_per_decade=50, update_mesh_every=0, grid=(64, 32), finest=q(1e-7, "m"), points=points,
    )  # fmt: skip


def test_local_wear_stands_beside_the_global_model():
    pressures = {f"{name}_pressure": q(1e8, "Pa") for name in ("peak", "middle", "mean")}
    depths = {"wear_depth": q(1e-6, "m"), "giwm_depth": q(1e-6, "m"), "difference": 0.01}
    pin = LocalPinPoint(
        **depths, **pressures, sliding_distance=q(1, "m"), contact_radius=q(1e-5, "m"), wear_volume=q(1e-12, "m^3")
    )
    page = stage(local_result((pin,)), "local_wear_archard")
    (row,) = table(page, "local wear of the pin and contact pressure")
    assert row[:4] == ("1 m", "1 µm", "1 µm", "+1.00 %")
    assert facts_of(page, "")["grid points"] == "64 × 32"
    parts = {f"{disc}_disc_wear_{what}": q(1e-12, unit) for disc in ("curved", "flat")
             for what, unit in (("depth", "m"), ("volume", "m^3"))}  # fmt: skip
    discs = LocalDiscPoint(
        **(depths | {"difference": None}), **pressures, **parts, rotations=q(10, "1"), slip_rotations=q(1, "1"),
        half_width=q(1e-5, "m"), half_length=q(1e-5, "m"),
    )  # fmt: skip
    (row,) = table(stage(local_result((discs,)), "local_wear_archard"), "local wear of both discs and contact pressure")
    assert (row[0], row[3]) == ("10", "–")


# --- studies ---


def verdict(run_id: str = "a", **changes) -> RunVerdict:
    told = {
        "id": run_id, "role": "predicted", "normal_load": q(0.2, "N", 0.002), "outcome": "over-predicts",
        "sentence": "It does not.", "notes": ("far off",), "end": q(500, "m"),
    }  # fmt: skip
    of_pin = {
        "outcome": "over-predicts", "what": "wear_depth", "measured": q(2e-5, "m"), "predicted": q(3e-5, "m"),
        "predicted_interval": (q(2.9e-5, "m"), q(3.1e-5, "m")), "measurement_interval": (q(2e-5, "m"), q(4e-5, "m")),
        "e_n": -9.0, "e_n_all": -8.0, "e_n_all_at": q(400, "m"), "wear_coefficient": K,
        "coefficient_ratio": q(0.5, "1", 0.01),
    }  # fmt: skip
    pin = BodyVerdict(**of_pin | {name: value for name, value in changes.items() if name in BodyVerdict.model_fields})
    of_run = {name: value for name, value in changes.items() if name in RunVerdict.model_fields}
    return RunVerdict(**told | of_run, bodies={"pin": pin})


def test_study_page_tells_warnings_on_a_curve_but_no_notes():
    said = {"where": "depth", "message": "found x", "remedy": "do y"}
    findings = (Finding(severity="warning", code="curve_shape", **said), Finding(severity="note", code="s", **said))
    (line,) = study_page_of(study(verdict("a", findings=findings, notes=("far off",)))).laws[0].agreement
    assert line.notes == ("warning: depth: found x; do y", "far off")


def test_study_page_does_not_repeat_a_warning_that_the_sentence_states():
    finding = Finding(severity="warning", code="curve_shape", where="depth", message="found x", remedy="do y")
    stated = verdict("a", findings=(finding,), notes=(), sentence="It is inconclusive: found x.")
    (line,) = study_page_of(study(stated)).laws[0].agreement
    assert line.notes == ("warning: do y",)


def study(*runs: RunVerdict) -> StudyResult:
    law = LawResult(
        model="archard", bodies={"pin": StudiedBody(wear_coefficient=K, interval=ENDS)}, draws=9, rejected=0, runs=runs
    )
    return StudyResult(id="s", tribometer="pin-on-disc", correction="model", laws=(law,))


def test_study_page_tells_verdicts_and_all_else():
    runs = (
        verdict(
            "a",
            role="fitted",
            outcome="supported",
            exponent=Exponent(measured=q(0.5, "1", 0.01), by_law=0.502),
            trend=Trend(p_value=0.7, amplitude=q(5e-9, "m")),
            change_point=ChangePoint(sliding_distance=q(300, "m"), rate_ratio=0.93, p_value=0.2),
            engines=EngineComparison(giwm=K, local=K, trusted=None),
            end_of_life=EndOfLife(wear_depth=q(4e-5, "m"), place=q(1400, "m"), interval=(q(1300, "m"), None)),
        ),
        verdict("b"),
    )
    between = BetweenRuns(runs=2, scatter=0.1, within=0.02, p_value=0.03, weights=(0.5, 0.5), outliers=("b",))
    pin = StudiedBody(wear_coefficient=K, interval=ENDS, between_runs=between)
    law = LawResult(model="archard", bodies={"pin": pin}, draws=9, rejected=0, runs=runs)
    result = StudyResult(
        id="air",
        tribometer="pin-on-disc",
        correction="two-step",
        laws=(law,),
        comparisons={"a": LawComparison(delta_aic={"archard": 0.0, "sarkar": 18.0}, preferred="archard")},
        left_out=(LeftOut(id="c", reason="marked bad"),),
        notes=("one run only",),
    )
    page = study_page_of(result)
    assert (page.id, page.title, page.fitted, page.predicted) == ("air", "air", ("a",), ("b",))
    (told,) = page.laws
    assert told.title == (
        "Archard's law: pin k_D = (1.350 ± 0.030)×10⁻⁸ mm³/(N·mm), 95 % CI: (1.300 to 1.400)×10⁻⁸ mm³/(N·mm)"
    )
    verdicts, shapes, engines = told.tables
    assert verdicts.rows[1] == (
        *("b", "predicted", "200.0 ± 2.0 mN", "20", "30", "29.00 to 31.00", "-9.00", "-8.00"),
        *("0.500 ± 0.010", "over-predicted"),
    )
    assert shapes.rows == (("a", "0.500 ± 0.010", "0.502", "0.005 µm, p = 0.7", "300 m", "0.93, p = 0.2"),)
    assert len(engines.rows) == 1
    assert told.sentences[0].startswith("between-run scatter of k_D of the pin (2 runs): 10.0 %; within a run: 2.0 %; ")
    assert told.sentences[1].startswith("b: outlier; to exclude it: `tribopipe mark-bad b ")
    assert told.sentences[2] == "a: the pin reaches a wear depth of 40 µm at 1400 m (95 % CI: 1300 m or more)"
    assert [(one.run_id, one.role, one.outcome, one.notes) for one in told.agreement] == [
        ("a", "fitted", "consistent", ("far off",)),
        ("b", "predicted", "over-predicted", ("far off",)),
    ]
    assert page.sentences == (
        "a: AIC favors Archard's law (AIC minus the lowest: Archard 0.0, Sarkar 18.0)",
        "excluded: c (marked bad)",
        "note: one run only",
    )


def test_study_page_of_discs_has_a_row_for_each():
    disc = BodyVerdict(
        outcome="supported", what="wear_volume", measured=q(1e-12, "m^3"),
        predicted=q(1.1e-12, "m^3"), predicted_interval=(q(1e-12, "m^3"), q(1.2e-12, "m^3")),
        measurement_interval=(q(1e-12, "m^3"), q(1.2e-12, "m^3")), e_n=0.3, e_n_all=0.3, e_n_all_at="volume",
        wear_coefficient=K, coefficient_ratio=q(1.0, "1"),
    )  # fmt: skip
    width = {"what": "track_width", "measured": q(1e-4, "m"), "predicted": q(1e-4, "m")}
    width |= {"predicted_interval": (q(9e-5, "m"), q(1.1e-4, "m"))}
    run = RunVerdict(
        id="d", role="fitted", normal_load=q(0.25, "N"), slip=q(0.04, "1"), end=q(1e6, "1"),
        outcome="supported", sentence="It holds.",
        bodies={"curved_disc": disc, "flat_disc": disc.model_copy(update=width)},
        end_of_life=EndOfLife(wear_depth=q(1e-6, "m"), place=q(5e5, "1"), interval=(q(4e5, "1"), None)),
    )  # fmt: skip
    law = LawResult(
        model="archard", distance_per_rotation="full-slip", draws=9, rejected=0, runs=(run,),
        bodies={name: StudiedBody(wear_coefficient=K, interval=ENDS) for name in ("curved_disc", "flat_disc")},
    )  # fmt: skip
    page = study_page_of(
        StudyResult(id="discs", title="Discs", tribometer="twin-disc", laws=(law,)), "0.1.0", DATE, "f"
    )
    (told,) = page.laws
    assert told.title.startswith("Archard's law, full-slip: crowned disc k_D = ")
    curved, flat = told.tables[0].rows
    disc = ("crowned disc", "0.001 mm³", "0.0011 mm³", "0.001000 to 0.001200")
    assert curved[:9] == ("d", "fitted", "250 mN", "4 %", "1,000,000", *disc)
    assert flat[:9] == ("", "", "", "", "", "cylindrical disc", "100 µm", "100 µm", "90.0 to 110.0")
    assert told.sentences[0].startswith(
        "d: the crowned disc reaches a wear depth of 1 µm after 5×10⁵ rotations (95 % CI: 4"
    )
    assert (page.title, page.date, page.inputs_sha256) == ("Discs", DATE, "f")
    assert asdict(page)["laws"][0]["agreement"][0]["sentence"] == "It holds."
