"""What was archived by an earlier method is done again, and both values are shown."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tribopipe.archive.step_names import METHODS, STEPS, method_number
from tribopipe.archive.store import Archive
from tribopipe.documents.quantity import change, wear_coefficient
from tribopipe.pipeline import step_definitions
from tribopipe.pipeline.stages import process
from tribopipe.results.main_values import changes, headline
from tribopipe.results.wear_fit import BodyWear, WearFit

RUN = "si3n4-air-200mN"
SHARE = 0.8
"""Of its k_D that a later method finds."""

pytestmark = pytest.mark.usefixtures("few_draws")


@pytest.fixture
def later_method(monkeypatch):
    """A wear fit that gives a smaller k_D, under a number of its own."""
    fit = step_definitions.fit_wear

    def smaller(*args):
        found = fit(*args)
        k_d = found.first.wear_coefficient
        pin = found.first.model_copy(update={"wear_coefficient": wear_coefficient(SHARE * k_d.value, 0.01 * k_d.value)})
        return found.model_copy(update={"bodies": {"pin": pin}})

    monkeypatch.setattr(step_definitions, "fit_wear", smaller)
    monkeypatch.setitem(METHODS, "wear_fit", METHODS["wear_fit"] + 1)


def k_d(archive, law: str):
    return Archive(archive).result(RUN, f"wear_fit_{law}", WearFit).first.wear_coefficient


def test_every_step_has_a_method():
    assert {name: method_number(name) for name in STEPS}.keys() == set(STEPS)
    assert method_number("wear_fit_running_in") == METHODS["wear_fit"]


def test_same_method_leaves_everything_as_it_is(short_runs, archive):
    assert {outcome.status for outcome in process([short_runs / RUN], Archive(archive))} == {"unchanged"}


def test_method_is_archived_with_its_step(archive):
    steps = Archive(archive).outline(RUN).steps
    assert {name: step.options["method"] for name, step in steps.items()} == {
        name: method_number(name) for name in steps
    }


@pytest.mark.slow
@pytest.mark.usefixtures("later_method")
def test_process_shows_the_earlier_value_and_the_new_one(run_cli, short_runs, archive):
    before = {law: k_d(archive, law) for law in ("archard", "sarkar")}
    result = run_cli("process", short_runs / RUN, "--archive", archive, "--no-figures", "--json")
    assert result.exit_code == 0
    steps = {step["step"]: step for step in json.loads(result.stdout)["steps"]}
    for law, earlier in before.items():
        now = k_d(archive, law)
        assert now.value == pytest.approx(SHARE * earlier.value)
        assert steps[f"wear_fit_{law}"]["previous"] == {"pin": earlier.model_dump(mode="json")}
        assert f"{RUN}: {law}: k_D of the pin {change(earlier, now, 'mm^3/(N*mm)')}\n" in result.stderr
    others = [step for name, step in steps.items() if name is None or not name.startswith("wear_fit")]
    assert {(step["status"], step["previous"]) for step in others} == {("unchanged", None)}


@pytest.mark.slow
@pytest.mark.usefixtures("later_method")
def test_fit_shows_the_earlier_value_too(run_cli, archive):
    earlier = k_d(archive, "archard")
    result = run_cli("fit", RUN, "--archive", archive)
    assert (
        f"{RUN}: archard: k_D of the pin {change(earlier, k_d(archive, 'archard'), 'mm^3/(N*mm)')}\n" in result.stderr
    )


@pytest.mark.slow
def test_earlier_fit_is_shown_though_another_drift_correction_has_dropped_it(run_cli, archive):
    earlier = k_d(archive, "archard")
    (archive.parent / "recipe.toml").write_text('[wear]\ncorrection = "two-step"\n', encoding="utf-8")
    result = run_cli("fit", RUN, "--archive", archive, "--recipe", archive.parent / "recipe.toml")
    now = k_d(archive, "archard")
    assert now != earlier
    assert f"{RUN}: drift rate " in result.stderr
    assert f"{RUN}: archard: k_D of the pin {change(earlier, now, 'mm^3/(N*mm)')}\n" in result.stderr


@pytest.mark.slow
def test_result_that_is_done_again_and_stays_is_not_shown(run_cli, short_runs, archive):
    again = ("process", short_runs / RUN, "--archive", archive, "--no-figures", "--force", "--json")
    run_cli(*again)  # with as many draws as the next time
    result = run_cli(*again)
    assert {str(step["previous"]) for step in json.loads(result.stdout)["steps"]} == {"None"}
    assert "→" not in result.stderr


@pytest.mark.slow
def test_study_is_evaluated_again_by_a_later_method(run_cli, archive, monkeypatch):
    study = archive.parent / "study.toml"
    study.write_text(f'id = "alone"\nfit = ["{RUN}"]\nlaws = ["archard"]\n', encoding="utf-8")
    run_cli("study", "run", study, "--archive", archive, "--no-figures")
    before = Archive(archive).study_outline("alone").inputs_sha256
    monkeypatch.setitem(METHODS, "drift_correction", METHODS["drift_correction"] + 1)
    run_cli("study", "run", study, "--archive", archive, "--no-figures")
    assert Archive(archive).study_outline("alone").inputs_sha256 != before


@given(st.floats(1e-16, 1e-12), st.floats(0.002, 0.3), st.floats(0.2, 5.0))
def test_line_names_both_values_unless_their_digits_are_the_same(value, share, factor):
    earlier, now = (wear_coefficient(k, share * value) for k in (value, factor * value))
    fit = WearFit(
        model="archard", outcome="fitted", bodies={"pin": BodyWear(wear_coefficient=now, interval=(now, now))}
    )
    lines = list(changes({"pin": earlier}, fit))
    shown = [one.shown("mm^3/(N*mm)") for one in (earlier, now)]
    assert lines == ([] if shown[0] == shown[1] else [f"archard: k_D of the pin {change(earlier, now, 'mm^3/(N*mm)')}"])
    for told in lines:
        assert told.count("mm³/(N·mm)") == 1


def test_value_that_is_gone_is_shown_as_none():
    fit = WearFit(model="archard", outcome="not fitted", missing=("an end value",))
    (line,) = changes(headline(fit) | {"pin": wear_coefficient(5.95e-16, 0.16e-16)}, fit)
    assert line == "archard: k_D of the pin (5.95 ± 0.16)×10⁻¹⁰ mm³/(N·mm) → none"
