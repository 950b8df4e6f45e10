"""Sweeps: every combination, each computed as a single fit or prediction is, kept and taken up again."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from folders import SAMPLES, tree_bytes
from hypothesis import given, settings
from hypothesis import strategies as st

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ManifestError
from tribopipe.documents.plan import Plan
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.record import load_toml, read_document
from tribopipe.documents.sweep import Sweep
from tribopipe.evaluation.wear.prediction import predict_wear
from tribopipe.evaluation.wear.scenario import KnownWear, Scenario
from tribopipe.extras.simulate import VirtualTest, VirtualTwinDiscTest
from tribopipe.extras.sweep.cases import Case, Ensemble, Head, Row, combinations, read_rows, write_rows
from tribopipe.extras.sweep.choices import Choice
from tribopipe.extras.sweep.subject import Parameter, Subject, Value, parameters
from tribopipe.extras.sweep.summary import Share, summarised
from tribopipe.extras.sweep.virtual_tests import recorded_run
from tribopipe.pipeline.stages import advance
from tribopipe.readers.harmonize import read_run
from tribopipe.results.wear_fit import WearFit

RUN = "si3n4-air-200mN"
FIRST_ORDER = 'schema = "tribopipe.recipe/1"\n[monte_carlo]\nsignificant_digits = 0\n'
CHOICES = """
schema = "tribopipe.sweep/1"
[choices]
[vary]
law = ["archard", "sarkar"]
[vary.recipe]
wear.correction = ["two-step", "model"]
drift.window = [0.02, 0.05]
"""
FEW = CHOICES.replace("[0.02, 0.05]", "[0.05]")
LIFE = f"""
schema = "tribopipe.sweep/1"
[predictions]
run = "{RUN}"
at = ["1 km"]
depth = ["50 um"]
[vary.run]
conditions.normal_load = ["200 mN", "400 mN"]
"""
TESTS = f"""
schema = "tribopipe.sweep/1"
repeats = 2
[virtual_tests]
plan = "plan.toml"
runs = ["{RUN}"]
within = "5 %"
[vary.series]
sliding_distance = ["20 m", "30 m"]
[vary.run]
drift_rate = {{ uniform = ["-15 nm/min", "15 nm/min"] }}
"""


@pytest.fixture
def swept(archive, run_cli, tmp_path):
    """Write a sweep beside an archive, a plan and a recipe to first order, and run it."""
    assert archive.parent == tmp_path
    (tmp_path / "plan.toml").write_bytes((SAMPLES / "plan.toml").read_bytes())
    (tmp_path / "recipe.toml").write_text(FIRST_ORDER, encoding="utf-8")

    def run(text: str, *options: object):
        (tmp_path / "sweep.toml").write_text(text, encoding="utf-8")
        return run_cli("sweep", "sweep.toml", "--recipe", "recipe.toml", *options, cwd=tmp_path)

    return run


def table_of(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


# --- combinations ---

cells = st.lists(st.integers(0, 50), min_size=1, max_size=4, unique=True)


@given(st.lists(cells, max_size=4), st.integers(1, 3), st.integers(0, 2**40))
def test_every_combination_comes_once_for_each_repeat_the_last_key_fastest(grid, repeats, seed):
    varied = [
        Parameter(f"key.{place}", tuple(Value(cell, float(cell), None) for cell in values))
        for place, values in enumerate(grid)
    ]
    found = [(*one.settings.values(), one.repeat) for one in combinations(varied, repeats, seed)]
    assert len(set(found)) == len(found) == repeats * np.prod([len(values) for values in grid], dtype=int)
    ranks = [[values.index(cell) for values, cell in zip(grid, one, strict=False)] + [one[-1]] for one in found]
    assert ranks == sorted(ranks)


DRAWN = {"uniform": [0.01, 0.05]}


def drawn(seed: int, **others: object) -> list[float]:
    sweep = Sweep.model_validate(
        {"choices": {}, "repeats": 3, "vary": {"recipe": {"drift": {"window": DRAWN}, **others}}}
    )
    subject = Subject(Choice, Choice(recipe=Recipe()).model_dump(mode="json", by_alias=True), "here")
    found = combinations(parameters(sweep.vary, subject), 3, seed)
    return [one.settings["recipe.drift.window"] for one in found]


@settings(max_examples=20)
@given(st.integers(0, 2**40))
def test_draws_depend_on_seed_repeat_and_key_alone(seed):
    alone = drawn(seed)
    assert len(set(alone)) == 3
    assert all(0.01 <= one <= 0.05 for one in alone)
    assert drawn(seed, wear={"correction": ["two-step", "model"]}) == alone * 2
    assert drawn(seed + 1) != alone


def test_normal_draws_have_their_mean_and_deviation():
    subject = Subject(Choice, Choice(recipe=Recipe()).model_dump(mode="json", by_alias=True), "here")
    told = {"recipe": {"friction": {"start": {"normal": "10 m", "standard_uncertainty": "20 %"}}}}
    sweep = Sweep.model_validate({"choices": {}, "repeats": 1, "vary": told})
    (parameter,) = parameters(sweep.vary, subject)
    values = [parameter.draw(1, repeat).cell for repeat in range(200)]
    assert np.mean(values) == pytest.approx(10, abs=0.5)
    assert np.std(values) == pytest.approx(2, rel=0.2)


def test_how_well_a_quantity_is_known_can_be_drawn():
    limit = {"value": 2e-7, "unit": "m", "standard_uncertainty": 1e-8}
    subject = Subject(Choice, {"recipe": {"drift": {"prior": limit}}}, "here")
    path = "recipe.drift.prior.standard_uncertainty"
    sweep = Sweep.model_validate({"choices": {}, "repeats": 1, "vary": {path: {"uniform": ["1 nm", "5 nm"]}}})
    (one,) = combinations(parameters(sweep.vary, subject), 1, 1)
    drawn = subject.changed(one.settings).recipe.drift.prior
    assert drawn.value == 2e-7
    assert drawn.standard_uncertainty == one.cells[path]
    assert 1e-9 <= one.cells[path] <= 5e-9


def test_a_quantity_keeps_the_relative_uncertainty_of_what_it_replaces():
    load = {"value": 2e-7, "unit": "m", "standard_uncertainty": 1e-8}
    subject = Subject(Choice, {"recipe": {"drift": {"prior": load}}}, "here")
    path = "recipe.drift.prior"
    assert subject.value(path, "400 nm").given == {"value": 4e-7, "unit": "m", "standard_uncertainty": 2e-8}
    own = {"value": "400 nm", "standard_uncertainty": "1 nm"}
    assert subject.value(path, own).given["standard_uncertainty"] == 1e-9
    better = subject.changed({f"{path}.standard_uncertainty": "1 %"}).recipe.drift.prior
    assert (better.value, better.standard_uncertainty) == (2e-7, pytest.approx(2e-9))
    assert subject.value(f"{path}.standard_uncertainty", "1 %").unit == "m"
    with pytest.raises(ManifestError, match="without a unit"):
        subject.value(f"{path}.standard_uncertainty", 2e-9)
    assert subject.base["recipe"]["drift"]["prior"] == load


# --- each case is what a single command finds ---


@pytest.mark.slow
def test_choices_are_what_single_fits_find_and_the_archive_stays(swept, archive, tmp_path):
    before = tree_bytes(archive)
    told = swept(FEW, "--json", "-o", "table.csv")
    assert told.exit_code == 0
    assert tree_bytes(archive) == before
    document = json.loads(told.stdout)
    assert len(document["rows"]) == 4
    store, recipe = Archive(archive), Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))
    row = next(
        row
        for row in document["rows"]
        if (row["case"]["law"], row["case"]["recipe.wear.correction"], row["case"]["recipe.drift.window"])
        == ("sarkar", "model", 0.05)
    )
    changed = recipe.model_copy(
        update={
            "drift": recipe.drift.model_copy(update={"window": 0.05}),
            "wear": recipe.wear.model_copy(update={"correction": "model"}),
        }
    )
    fit = advance(store, RUN, "wear_fit_sarkar", changed).result
    assert isinstance(fit, WearFit)
    assert row["wear_coefficient"] == fit.first.wear_coefficient.model_dump()
    assert row["interval_lower"]["value"] == fit.first.interval[0].value
    spreads = {one["labels"]["law"]: one for one in document["summary"]}
    values = [one["wear_coefficient"]["value"] for one in document["rows"] if one["case"]["law"] == "archard"]
    assert spreads["archard"]["least"]["value"] == min(values)
    assert spreads["archard"]["effects"]["recipe.wear.correction"] == pytest.approx(
        abs(values[0] - values[1]) / np.mean(values)
    )
    assert [float(line["wear_coefficient [m^2/N]"]) for line in table_of(tmp_path / "table.csv")][:2] == values


def test_predictions_are_what_predict_finds(swept, archive):
    rows = json.loads(swept(LIFE, "--json").stdout)["rows"]
    store = Archive(archive)
    fit, manifest = store.result(RUN, "wear_fit_archard", WearFit), store.manifest(RUN)
    load = Quantity(value=0.4, unit="N", standard_uncertainty=0.4 * 0.01)
    scenario = Scenario(manifest.described, load, KnownWear({"pin": fit.first.wear_coefficient}))
    expected = predict_wear(scenario, [1000.0], depths=[50e-6])
    assert [row["outcome"] for row in rows] == ["at 1000 m", "worn to 50 µm"] * 2
    assert rows[2]["wear_depth"] == expected.prediction[0].contact.approach.model_dump()
    assert rows[3]["sliding_distance"] == expected.reached[0].sliding_distance.model_dump()


@pytest.mark.slow
def test_drawn_predictions_scatter_as_first_order_has_it(swept):
    text = f"""
    schema = "tribopipe.sweep/1"
    repeats = 80
    [predictions]
    run = "{RUN}"
    at = ["1 km"]
    [vary]
    wear_coefficient = {{ normal = "13.5e-9 mm^3/(N*mm)", standard_uncertainty = "2 %" }}
    """
    (scatter,) = json.loads(swept(text, "--json").stdout)["summary"]
    depth = scatter["mean"]
    assert depth["standard_uncertainty"] / depth["value"] == pytest.approx(0.01, rel=0.3)  # h ∝ √k_D
    low, high = (end["value"] for end in scatter["interval"])
    assert (high - low) / depth["value"] == pytest.approx(2 * 1.96 * 0.01, rel=0.3)


@pytest.mark.parametrize("kind", ["pin", "discs"])
def test_a_run_in_memory_is_what_its_folder_would_be_ingested_as(kind, tmp_path):
    plan = load_toml(SAMPLES / "plan.toml", Plan)
    if kind == "pin":
        series = plan.series[0].model_copy(update={"sliding_distance": Quantity(value=20.0, unit="m")})
        run = series.runs[0]
        VirtualTest(series, run).write(tmp_path / run.id)
        made = recorded_run(series, VirtualTest(series, run))
    else:
        discs = plan.twin_disc_series[0]
        one = discs.runs[0]
        VirtualTwinDiscTest(discs, one).write(tmp_path / one.id)
        made = recorded_run(discs, VirtualTwinDiscTest(discs, one))
    ingested = read_run(tmp_path / made.id)
    assert made.columns.keys() == ingested.columns.keys()
    assert made.origins == ingested.origins
    assert made.manifest.conditions == ingested.manifest.conditions
    for name, column in ingested.columns.items():
        np.testing.assert_allclose(made.columns[name], column, rtol=1e-3, atol=1e-4, err_msg=name)


@pytest.mark.slow
def test_virtual_tests_are_held_against_their_truth(swept):
    told = swept(TESTS, "--json")
    assert told.exit_code == 0
    document = json.loads(told.stdout)
    assert {row["true_wear_coefficient"]["value"] for row in document["rows"]} == {13.5e-15}
    held = [one["held"]["of"] for one in document["summary"]]
    assert held == [2, 2]
    rates = [row["case"]["run.drift_rate"] for row in document["rows"]]
    assert rates[:2] == rates[2:]
    assert len({row["wear_coefficient"]["value"] for row in document["rows"]}) == 4


def test_the_share_of_intervals_that_hold_has_the_interval_of_clopper_and_pearson():
    assert Share.counted(3, 3).interval == pytest.approx((0.025 ** (1 / 3), 1.0))
    assert Share.counted(0, 0).interval == (0.0, 1.0)


def test_tests_without_a_k_d_hold_nothing():
    sweep = Sweep.model_validate({"virtual_tests": {"plan": "plan.toml"}, "repeats": 2})
    found = {name: Quantity(value=value, unit="m^2/N") for name, value in HELD.items()}
    rows = {"a": [Row("pin", "fitted", found)], "b": [Row("", "not fitted", {}, "no wear")]}
    cases = [Case({"run": "x", "repeat": float(place)}, name, list) for place, name in enumerate(rows)]
    (coverage,) = summarised(sweep, Ensemble((Head("run"), Head("repeat")), (), cases), rows)
    assert (coverage.fitted, coverage.held.count, coverage.held.of) == (1, 1, 2)


HELD = {"wear_coefficient": 2.0, "interval_lower": 1.0, "interval_upper": 3.0, "true_wear_coefficient": 1.5}


# --- the table ---


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(allow_nan=False, allow_infinity=False), st.text()), min_size=1, max_size=5))
def test_rows_come_back_from_their_file_to_the_last_bit(tmp_path_factory, told):
    path = tmp_path_factory.mktemp("rows") / "rows.csv"
    heads = (Head("depth", "m", uncertain=True),)
    found = {
        f"{place:016x}": [
            Row("pin", "fitted", {"depth": Quantity(value=value, unit="m", standard_uncertainty=abs(value))}, why)
        ]
        for place, (value, why) in enumerate(told)
        if not why.startswith(("=", "+", "-", "@", "\t", "\r")) and why.isprintable()
    }
    cases = [Case({"run": "x"}, name, list) for name in found]
    ensemble = Ensemble((Head("run"),), heads, cases)
    write_rows(path, ensemble, found)
    assert read_rows(path, ensemble) == found


@pytest.mark.slow
def test_a_table_is_taken_up_where_it_ends(swept, tmp_path):
    swept(TESTS, "-o", "table.csv")
    path = tmp_path / "table.csv"
    whole = path.read_bytes()
    lines = whole.splitlines(keepends=True)
    assert len(lines) == 5
    path.write_bytes(b"".join([*lines[:2], *lines[3:4]]))
    told = swept(TESTS, "-o", "table.csv")
    assert "2 of 4 cases are already computed" in told.stderr
    assert path.read_bytes() == whole
    again = swept(TESTS, "-o", "table.csv", "--dry-run", "--json")
    assert json.loads(again.stdout) == {"cases": 4, "missing": 0}
    fewer = swept(TESTS.replace(', "30 m"', ""), "-o", "table.csv", "--dry-run")
    assert "ignored the rows of 2 cases" in fewer.stderr


@pytest.mark.slow
def test_shards_make_one_table(swept, tmp_path):
    swept(TESTS, "-o", "whole.csv")
    for shard in (1, 2):
        swept(TESTS, "-o", f"{shard}.csv", "--shard", f"{shard}/2")
    swept(TESTS, "-o", "1.csv", "--shard", "2/2")
    assert (tmp_path / "1.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()
    swept(TESTS, "-o", "1.csv", "--shard", "1/2", "--force")
    assert len(table_of(tmp_path / "1.csv")) == 2
    told = swept(TESTS, "-o", "all.csv", "--reuse", "1.csv", "--reuse", "2.csv")
    assert "4 of 4 cases are already computed" in told.stderr
    assert (tmp_path / "all.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize("crew", [["-j", "2"], ["--scheduler", "local", "-j", "2"]], ids=" ".join)
def test_the_table_is_the_same_whoever_makes_it(swept, tmp_path, crew):
    swept(TESTS, "-o", "alone.csv")
    swept(TESTS, "-o", "crew.csv", *crew)
    assert (tmp_path / "crew.csv").read_bytes() == (tmp_path / "alone.csv").read_bytes()


def test_a_case_that_fails_is_a_row_that_says_why_and_is_tried_again(swept, tmp_path):
    text = LIFE.replace('["200 mN", "400 mN"]', '["200 mN", "4 kN"]')
    told = swept(text, "-o", "table.csv")
    assert told.exit_code == 3
    assert told.stderr.count("error:") == 1
    *sound, failed = table_of(tmp_path / "table.csv")
    assert [row["outcome"] for row in sound] == ["at 1000 m", "worn to 50 µm"]
    assert failed["outcome"] == "failed"
    assert failed["why"] in told.stderr
    again = swept(text, "-o", "table.csv", "--dry-run", "--json")
    assert json.loads(again.stdout) == {"cases": 2, "missing": 1}
    only = swept(LIFE.replace('["200 mN", "400 mN"]', '["4 kN"]'))
    assert only.exit_code == 1


def test_another_table_is_not_overwritten_unasked(swept, tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("mine\n", encoding="utf-8")
    told = swept(LIFE, "-o", "table.csv")
    assert told.exit_code == 1
    assert "found the table of another sweep" in told.stderr
    assert path.read_text(encoding="utf-8") == "mine\n"
    assert swept(LIFE, "-o", "table.csv", "--force").exit_code == 0


@pytest.mark.slow
def test_people_are_shown_a_table_and_what_it_comes_to(swept):
    shown = swept(FEW).output
    assert "half range" in shown
    assert "effect of wear.correction" in shown
    assert "1000 m" in swept(LIFE).output


@pytest.mark.slow
def test_a_figure_has_a_panel_for_each_thing_asked(swept, tmp_path):
    two = LIFE + 'contact.pin.radius = ["0.5 mm", "1 mm"]\n'
    assert swept(two, "--figure", "life.svg").exit_code == 0
    drawn = (tmp_path / "life.svg").read_text(encoding="utf-8")
    for said in ("at 1000 m", "worn to 50 µm", "wear depth / µm", "sliding distance / m", "0.5 mm"):
        assert said in drawn
    assert swept(LIFE, "--figure", "life.doc").exit_code == 2
    nothing = swept(LIFE.replace(', "400 mN"', ""), "--figure", "life.svg")
    assert nothing.exit_code == 1
    assert "found no values for the x-axis" in nothing.stderr


# --- what is wrong is told in one sentence ---

WRONG = {
    "unknown key": (CHOICES.replace("drift.window", "drift.windw"), "did you mean 'window'"),
    "unknown document": (CHOICES.replace("vary.recipe", "vary.recip"), "did you mean 'recipe'"),
    "wrong value": (CHOICES.replace("0.05", "0.7"), "found 0.7; input should be less than 0.5"),
    "no list": (CHOICES.replace("[0.02, 0.05]", "0.02"), "expected a list of values"),
    "twice": (CHOICES.replace("[0.02, 0.05]", "[0.02, 0.02]"), "found 0.02 twice"),
    "no kind": (CHOICES.replace("[choices]", ""), "found none of choices"),
    "two kinds": (CHOICES + "[predictions]\nrun = 'x'\n", "found choices and predictions"),
    "nothing drawn": ("repeats = 3\n" + CHOICES, "although no value is random"),
    "no repeats": (TESTS.replace("repeats = 2", ""), "repeats: missing"),
    "a seed": (TESTS + "seed = [1, 2]\n", "expected no seed, since each repeat has its own"),
    "no plan": (TESTS.replace("plan.toml", "plans.toml"), "no such file"),
    "no such run": (TESTS.replace(f'"{RUN}"', '"si3n4-air-20mN"'), f"did you mean '{RUN}'"),
    "not archived": (LIFE.replace(RUN, "si3n4-air-20mN"), f"did you mean '{RUN}'"),
    "wrong way round": (TESTS.replace('"-15 nm/min", "15', '"15 nm/min", "-15'), "a minimum less than the maximum"),
    "half a range": (TESTS.replace('"-15 nm/min", ', ""), "expected [minimum, maximum]"),
    "odd distribution": (TESTS.replace("uniform = [", "normal = 1, uniform = ["), "expected { uniform"),
    "drawn words": (TESTS + "id = { uniform = ['a', 'b'] }\n", "a key that is not numeric"),
    "wrong unit": (LIFE.replace('"1 km"', '"1 s"'), "predictions.at: found the unit 's'"),
    "endless": (TESTS.replace("repeats = 2", "repeats = 2000000"), "expected at most 1000000"),
}


@pytest.mark.parametrize(("text", "said"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_told_in_one_sentence(swept, text, said):
    told = swept(text)
    assert told.exit_code == 1
    assert told.stderr.startswith("error: ")
    assert told.stderr.count("\n") == 1
    assert said in told.stderr


def test_a_run_folder_needs_a_k_d():
    with pytest.raises(ManifestError, match="wear_coefficient: missing"):
        read_document({"predictions": {"folder": "run"}}, Sweep, where="sweep.toml")


def test_a_run_folder_is_predicted_without_an_archive(swept, short_runs):
    text = LIFE.replace(f'run = "{RUN}"', f"folder = '{short_runs / RUN}'\nwear_coefficient = '13.5e-9 mm^3/(N*mm)'")
    told = swept(text, "--archive", "nowhere", "--json")
    assert told.exit_code == 0
    assert len(json.loads(told.stdout)["rows"]) == 4


STEEL = 'material = "100Cr6"\nyoungs_modulus = "210 GPa"\npoisson_ratio = 0.3\n'
HEAD = 'schema = "tribopipe.run/1"\nid = "run"\n[contact]\nkind = "{kind}"\n'
END = '[conditions]\nnormal_load = "100 N"\nrotational_speed = "200 rpm"\n[[signals]]\nfile = "signals.csv"\n'
SIZED = {
    "contact.ring.diameter": HEAD.format(kind="block-on-ring")
    + f'[contact.block]\nwidth = "6.35 mm"\n{STEEL}[contact.ring]\ndiameter = "SIZE"\n{STEEL}{END}',
    "contact.ball.diameter": HEAD.format(kind="four-ball") + f'[contact.ball]\ndiameter = "SIZE"\n{STEEL}{END}',
}
OF_A_FOLDER = """
schema = "tribopipe.sweep/1"
[predictions]
folder = "sized"
at = ["500 m"]
wear_coefficient = "1e-10 mm^3/(N*mm)"
[vary.run]
{varied}
"""


@pytest.mark.parametrize("key", SIZED)
def test_what_follows_from_a_varied_size_follows_anew(swept, tmp_path, key):
    def rows(size: str, varied: str) -> list[dict]:
        (tmp_path / "sized").mkdir(exist_ok=True)
        (tmp_path / "sized" / "run.toml").write_text(SIZED[key].replace("SIZE", size), encoding="utf-8")
        told = swept(OF_A_FOLDER.format(varied=varied), "--archive", "nowhere", "--json")
        assert told.exit_code == 0, told.stderr
        return json.loads(told.stdout)["rows"]

    varied = rows("12 mm", f'{key} = ["12 mm", "24 mm"]')
    stated = [
        *rows("12 mm", 'conditions.normal_load = ["100 N"]'),
        *rows("24 mm", 'conditions.normal_load = ["100 N"]'),
    ]
    numbers = ("wear_depth", "time", "mean_pressure")
    for one, other in zip(varied, stated, strict=True):
        assert {name: one[name] for name in numbers} == {name: other[name] for name in numbers}
    assert varied[0]["wear_depth"] != varied[1]["wear_depth"]


def test_what_is_stated_twice_is_not_taken_for_derived(swept, tmp_path):
    key = "contact.ring.diameter"
    both = SIZED[key].replace('diameter = "SIZE"', 'diameter = "12 mm"\nradius = "6 mm"')
    (tmp_path / "sized").mkdir()
    (tmp_path / "sized" / "run.toml").write_text(both, encoding="utf-8")
    told = swept(OF_A_FOLDER.format(varied=f'{key} = ["24 mm"]'), "--archive", "nowhere")
    assert told.exit_code == 1
    assert "ring.radius: found 6 mm for a ring diameter of 24 mm" in told.stderr


def test_a_run_of_an_archive_ends_where_its_last_sample_is(archive):
    run = Archive(archive).cleaned(RUN)
    columns = {name: np.append(values, np.nan) for name, values in run.columns.items()}
    assert replace(run, columns=columns).end == run.end == run.progress[-1]
