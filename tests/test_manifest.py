"""run.toml and its kin: read whole or refused in one sentence, described by schemas that say the same."""

import copy
import json
import re
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from folders import DISC_IDS, FURTHER_IDS, ROOT, SAMPLE_IDS, SAMPLES
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.base.errors import ManifestError
from tribopipe.documents.contact_kinds import SHIPPED
from tribopipe.documents.manifest import RunManifest, read_manifest
from tribopipe.documents.plan import Plan
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import load_toml, read_document
from tribopipe.documents.toml import parse_toml
from tribopipe.extras.simulate import simulate_plan
from tribopipe.results.json_schema import SCHEMAS, schema_text

RUNS = sorted(SAMPLES.glob("*/run.toml"))
ONE = SAMPLES / "si3n4-air-200mN" / "run.toml"
DOCUMENT = tomllib.loads(ONE.read_text(encoding="utf-8"))


@cache
def run_schema() -> jsonschema.Draft202012Validator:
    schema = json.loads(schema_text("run"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def as_json(document: object) -> object:
    """Write dates as JSON does."""
    return json.loads(json.dumps(document, default=lambda date: date.isoformat()))


def with_value(path: tuple, value: object, of: dict = DOCUMENT) -> dict:
    document = copy.deepcopy(of)
    table = document
    for step in path[:-1]:
        table = table[step]
    table[path[-1]] = value
    return document


# --- records ---


def test_there_are_sample_runs_of_each_kind():
    assert (len(SAMPLE_IDS), len(DISC_IDS)) == (7, 7)
    assert {read_manifest(path)[0].contact.kind for path in RUNS} == set(SHIPPED)


@pytest.mark.parametrize("path", RUNS, ids=lambda path: path.parent.name)
def test_manifest_comes_back_from_json_as_it_was(path):
    manifest, content = read_manifest(path)
    assert content == path.read_bytes()
    assert RunManifest.model_validate_json(manifest.model_dump_json(by_alias=True)) == manifest


@pytest.mark.parametrize("record", [Recipe(), load_toml(SAMPLES / "plan.toml", Plan)], ids=["recipe", "plan"])
def test_other_documents_come_back_from_json_as_they_were(record):
    assert type(record).model_validate_json(record.model_dump_json(by_alias=True)) == record


def test_quantities_are_in_si_with_their_uncertainty():
    manifest, _ = read_manifest(ONE)
    pin, load = manifest.contact.pin, manifest.conditions.normal_load
    assert (load.value, load.unit, load.standard_uncertainty) == (0.2, "N", 0.002)
    assert (pin.radius.value, pin.radius.standard_uncertainty) == (0.794e-3, 1.588e-6)
    assert pin.density.value == 3200.0
    assert manifest.end_values.pin_scar_diameter.method == "white-light"


def test_byte_order_mark_and_windows_line_ends_are_taken(tmp_path):
    path = tmp_path / "run.toml"
    path.write_bytes(b"\xef\xbb\xbf" + ONE.read_bytes().replace(b"\n", b"\r\n"))
    assert read_manifest(path)[0] == read_manifest(ONE)[0]


def test_records_cannot_change():
    manifest, _ = read_manifest(ONE)
    with pytest.raises(ValidationError, match="frozen"):
        manifest.id = "other"
    with pytest.raises(ValidationError, match="frozen"):
        manifest.contact.pin.radius.value = 1.0


TABLES = [
    (),
    ("contact",),
    ("contact", "pin"),
    ("contact", "disc"),
    ("conditions",),
    ("conditions", "normal_load"),
    ("signals", 0),
    ("signals", 0, "columns"),
    ("signals", 0, "columns", "depth"),
    ("end_values",),
    ("end_values", "pin_scar_diameter"),
]


@pytest.mark.slow
@pytest.mark.parametrize("table", TABLES, ids=lambda table: ".".join(map(str, table)) or "top")
def test_unknown_key_is_refused_in_every_table(table):
    document = with_value((*table, "surprise"), "here")
    with pytest.raises(ManifestError, match=r"^where: .*surprise: unknown key; "):
        read_document(document, RunManifest, where="where")
    assert not run_schema().is_valid(as_json(document))


QUANTITIES = [
    ("contact", "pin", "radius"),
    ("contact", "disc", "youngs_modulus"),
    ("contact", "disc", "density"),
    ("conditions", "normal_load"),
    ("conditions", "sliding_speed"),
    ("end_values", "disc_wear_depth"),
]


@pytest.mark.parametrize("path", QUANTITIES, ids=".".join)
def test_bare_number_is_refused_where_a_unit_belongs(path):
    document = with_value(path, 0.794)
    with pytest.raises(
        ManifestError, match=rf"^where: {'.'.join(path)}: found the number 0.794 without a unit; expected a value"
    ):
        read_document(document, RunManifest, where="where")
    assert not run_schema().is_valid(as_json(document))


def test_first_problem_is_told_and_the_rest_counted():
    document = with_value(("contact", "pin", "radius"), 0.794)
    document["conditions"]["normal_load"] = 200
    del document["id"]
    with pytest.raises(ManifestError, match=r"^where: id: missing; add this key \(and 2 more\)$"):
        read_document(document, RunManifest, where="where")


@pytest.mark.parametrize(
    ("written", "found"),
    [
        ("-1.4 mm", "'-1.4 mm'"),
        ({"value": "-800 um", "standard_uncertainty": "4 um"}, "'-800 um'"),
        ({"values": ["384 um", "-0.38 mm"]}, "'-0.38 mm'"),
        ({"value": -1.4e-3, "unit": "m"}, "-1400 µm"),
    ],
)
def test_a_negative_size_is_shown_as_it_is_written(written, found):
    document = with_value(("end_values", "pin_scar_diameter"), written)
    message = f"where: end_values.pin_scar_diameter: found {found}; expected zero or a positive value"
    with pytest.raises(ManifestError, match=rf"^{re.escape(message)}"):
        read_document(document, RunManifest, where="where")


def test_a_load_of_zero_is_shown_as_it_is_written():
    with pytest.raises(ManifestError, match="found '0 N'; expected a positive value"):
        read_document(with_value(("conditions", "normal_load"), "0 N"), RunManifest, where="where")


@pytest.mark.parametrize(
    ("written", "message"),
    [
        (45, 'found 45, that is, 4500 %; expected at most 100 %; write "45 %", if that is meant'),
        ("120 %", "found 1.2, that is, 120 %; expected at most 100 %; correct the value"),
        ("45", 'found 45, that is, 4500 %; expected at most 100 %; write "45 %", if that is meant'),
        ("45000 %", "found 450, that is, 45000 %; expected at most 100 %; correct the value"),
    ],
)
def test_a_humidity_above_100_percent_is_refused_with_the_likely_meaning(written, message):
    document = with_value(("conditions", "relative_humidity"), written)
    with pytest.raises(ManifestError, match=rf"^where: conditions.relative_humidity: {re.escape(message)}"):
        read_document(document, RunManifest, where="where")


@pytest.mark.parametrize("written", ["45 %", 0.45, "100 %", 1])
def test_a_humidity_of_up_to_100_percent_is_taken(written):
    document = with_value(("conditions", "relative_humidity"), written)
    read = read_document(document, RunManifest, where="where")
    assert read.conditions.relative_humidity.value == (0.45 if written in ("45 %", 0.45) else 1)


def test_a_missing_key_is_shown_with_an_example():
    document = copy.deepcopy(DOCUMENT)
    del document["conditions"]["normal_load"]
    with pytest.raises(ManifestError, match=r'normal_load: missing; add this key, such as normal_load = "200 mN"$'):
        read_document(document, RunManifest, where="where")
    document = copy.deepcopy(DOCUMENT)
    del document["contact"]["pin"]["poisson_ratio"]
    with pytest.raises(ManifestError, match=r"add this key, such as poisson_ratio = 0\.24$"):
        read_document(document, RunManifest, where="where")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        (("conditions", "load"), "5 N", r"conditions\.load: unknown key; did you mean 'normal_load'\?"),
        (("conditions", "speed"), "5 m/s", "did you mean 'sliding_speed' or 'rotational_speed'"),
        (
            ("signals",),
            {"file": "signals.csv"},
            r"signals: found \[signals\], a single table; .*; write \[\[signals\]\]",
        ),
        (("contact", "kind"), "reciprocating", r"contact\.disc: unknown key; available: flat, kind, pin"),
    ],
)
def test_a_key_that_does_not_belong_there_gets_the_remedy_that_is_meant(key, value, message):
    with pytest.raises(ManifestError, match=message):
        read_document(with_value(key, value), RunManifest, where="where")


# --- interruptions and sensors ---

STOPS: list[dict] = [
    {"sliding_distance": "100 m", "pin_wear_depth": {"value": "10 um", "standard_uncertainty": "0.1 um"}},
    {"sliding_distance": "0.25 km", "remounted": True, "pin_scar_diameter": "320 um"},
]


def with_stop(number: int, **changes: object) -> dict:
    """The document with two interruptions, one of them changed."""
    stops = copy.deepcopy(STOPS)
    stops[number] |= changes
    return with_value(("interruptions",), stops)


def test_interruptions_are_read_in_their_order():
    document = with_stop(0)
    stops = read_document(document, RunManifest, where="where").interruptions
    run_schema().validate(as_json(document))
    assert [stop.sliding_distance.value for stop in stops] == [100.0, 250.0]
    assert [stop.remounted for stop in stops] == [False, True]
    assert (stops[0].pin_wear_depth.value, stops[0].pin_wear_depth.standard_uncertainty) == pytest.approx(
        (10e-6, 0.1e-6), rel=1e-12
    )
    assert stops[1].pin_scar_diameter.value == pytest.approx(320e-6, rel=1e-12)
    assert (stops[0].pin_scar_diameter, stops[1].pin_wear_depth) == (None, None)


def test_run_without_interruptions_has_none():
    assert read_document(DOCUMENT, RunManifest, where="where").interruptions == ()


@pytest.mark.parametrize(
    ("second", "shown"), [("50 m", "100 m, 50 m"), ("100 m", "100 m, 100 m"), ("100000 mm", "100 m, 100 m")]
)
def test_interruptions_that_do_not_follow_each_other_are_refused(second, shown):
    with pytest.raises(ManifestError, match=rf"^where: interruptions: found {shown}; expected increasing values"):
        read_document(with_stop(1, sliding_distance=second), RunManifest, where="where")


@pytest.mark.parametrize(
    ("key", "value", "found"),
    [
        ("pin_scar_diameter", "1.588 mm", "found 1588 µm, not less than the pin diameter"),
        ("pin_wear_depth", "0.8 mm", "found 800 µm, not less than the pin radius"),
        ("disc_wear_depth", "0.8 mm", "found 800 µm, not less than the pin radius"),
    ],
)
@pytest.mark.parametrize("number", [0, 1])
def test_impossible_wear_at_an_interruption_is_named_with_its_place(number, key, value, found):
    with pytest.raises(ManifestError, match=rf"^where: interruptions\[{number}\]\.{key}: {found}"):
        read_document(with_stop(number, **{key: value}), RunManifest, where="where")


def test_scar_of_a_flat_pin_at_an_interruption_is_named_with_its_place():
    document = with_stop(1)
    document["contact"]["pin"]["shape"] = "flat"
    document["end_values"] = {}
    with pytest.raises(
        ManifestError, match=r"^where: interruptions\[1\]\.pin_scar_diameter: found a scar size for a flat pin"
    ):
        read_document(document, RunManifest, where="where")


def test_negative_wear_at_an_interruption_is_named_with_its_place():
    with pytest.raises(ManifestError, match=r"^where: interruptions\[0\].*pin_wear_depth: found .*; expected zero or"):
        read_document(with_stop(0, pin_wear_depth="-1 um"), RunManifest, where="where")


def test_unknown_key_at_an_interruption_is_refused_with_its_place_and_the_nearest_one():
    document = with_stop(1, remount=True)
    with pytest.raises(ManifestError, match=r"^where: interruptions\[1\]\.remount: unknown key; .*remounted"):
        read_document(document, RunManifest, where="where")
    assert not run_schema().is_valid(as_json(document))


def test_interruption_without_its_distance_is_refused():
    document = with_stop(0)
    del document["interruptions"][0]["sliding_distance"]
    with pytest.raises(ManifestError, match=r"^where: interruptions\[0\]\.sliding_distance: missing; add this key"):
        read_document(document, RunManifest, where="where")
    assert not run_schema().is_valid(as_json(document))


@pytest.mark.parametrize(
    ("written", "value", "spread"),
    [
        (1.02, 1.02, None),
        ({"value": 1.02, "standard_uncertainty": 0.01}, 1.02, 0.01),
        ({"value": 1.02, "standard_uncertainty": "0.5 %"}, 1.02, 0.005 * 1.02),
    ],
)
def test_depth_scale_is_taken_with_its_uncertainty(written, value, spread):
    document = with_value(("sensors",), {"depth_scale": written})
    scale = read_document(document, RunManifest, where="where").sensors.depth_scale
    run_schema().validate(as_json(document))
    assert (scale.value, scale.unit) == (value, "1")
    assert scale.standard_uncertainty == (spread if spread is None else pytest.approx(spread, rel=1e-12))


def test_depth_scale_left_out_is_one():
    document = copy.deepcopy(DOCUMENT)
    document.pop("sensors", None)
    scale = read_document(document, RunManifest, where="where").sensors.depth_scale
    assert (scale.value, scale.standard_uncertainty) == (1.0, None)


@pytest.mark.parametrize(
    ("sensors", "problem"),
    [
        ({"depth_scale": "1 mm"}, r"sensors\.depth_scale: "),
        ({"depth_scale": {"value": 1, "standard_uncertainty": -0.1}}, r"sensors\.depth_scale: found a negative"),
        ({"depth_scales": 1}, r"sensors\.depth_scales: unknown key; .*depth_scale"),
    ],
)
def test_depth_scale_that_is_none_is_refused(sensors, problem):
    with pytest.raises(ManifestError, match=f"^where: {problem}"):
        read_document(with_value(("sensors",), sensors), RunManifest, where="where")


# --- anything at all ---

LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["1 mm", "-1 mm", "0 N", "5 %", "1e999 mm", "pin-on-disc", "../a", "a\0b", "NaN", 10**400]),
)
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(
            st.one_of(
                st.text(max_size=5), st.sampled_from(["value", "unit", "standard_uncertainty", "kind", "column"])
            ),
            inner,
            max_size=3,
        ),
    ),
    max_leaves=5,
)


def paths_in(value: object, above: tuple = ()) -> list[tuple]:
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path for step, below in inner for path in [(*above, step), *paths_in(below, (*above, step))]]


def assert_taken_or_refused(record, where: str, read) -> None:
    """A document is read as a record that survives JSON, or refused in one sentence that says where."""
    try:
        found = read()
    except ManifestError as error:
        found = str(error)
    if isinstance(found, str):
        assert found.startswith(f"{where}: ")
        assert found.isprintable()
    else:
        assert record.model_validate_json(found.model_dump_json(by_alias=True)) == found


@pytest.mark.slow
@given(st.sampled_from(paths_in(DOCUMENT)), VALUES)
def test_any_value_anywhere_is_taken_or_refused(path, value):
    document = with_value(path, value)
    assert_taken_or_refused(RunManifest, "where", lambda: read_document(document, RunManifest, where="where"))


@pytest.mark.slow
@given(st.sampled_from([path for path in paths_in(with_stop(0)) if path[0] == "interruptions"]), VALUES)
def test_any_value_at_an_interruption_is_taken_or_refused(path, value):
    document = with_value(path, value, of=with_stop(0))
    assert_taken_or_refused(RunManifest, "where", lambda: read_document(document, RunManifest, where="where"))


@given(st.dictionaries(st.text(max_size=8), VALUES, max_size=4), st.sampled_from([RunManifest, Recipe, Plan]))
def test_any_document_is_taken_or_refused(document, record):
    assert_taken_or_refused(record, "where", lambda: read_document(document, record, where="where"))


BYTES = st.one_of(
    st.binary(max_size=20), st.text(max_size=20).map(str.encode), st.just(b"9" * 5000), st.just(b"[" * 5000)
)


@given(st.integers(0, len(ONE.read_bytes())), st.integers(0, 40), BYTES)
def test_any_bytes_are_taken_or_refused(start, length, put):
    content = ONE.read_bytes()[:start] + put + ONE.read_bytes()[start + length :]

    def read():
        return read_document(parse_toml(Path("run.toml"), content), RunManifest, where="run.toml")

    assert_taken_or_refused(RunManifest, "run.toml", read)


# --- what is committed ---


@pytest.mark.parametrize("path", RUNS, ids=lambda path: path.parent.name)
def test_schema_accepts_the_sample_runs(path):
    run_schema().validate(as_json(tomllib.loads(path.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("page", ["four_ball", "block_on_ring", "reciprocating"])
def test_schema_accepts_the_run_of_a_page(page):
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    (written,) = re.findall(r"```toml\n(schema = .*?)```", text, re.DOTALL)
    document = as_json(tomllib.loads(written))
    assert list(run_schema().iter_errors(document)) == []
    document["contact"]["pin" if page == "reciprocating" else "no"] = {}
    assert list(run_schema().iter_errors(document)) != []


@pytest.mark.slow
def test_schema_accepts_the_plan():
    document = as_json(tomllib.loads((SAMPLES / "plan.toml").read_text(encoding="utf-8")))
    jsonschema.validate(document, json.loads(schema_text("plan")), jsonschema.Draft202012Validator)


@pytest.mark.parametrize("name", SCHEMAS)
def test_committed_schema_is_the_generated_one(name):
    committed = (ROOT / "schemas" / f"{name}.schema.json").read_text(encoding="utf-8")
    assert committed == schema_text(name), "run `tribopipe schema export schemas`"


def test_no_committed_schema_is_left_over():
    committed = {path.name for path in (ROOT / "schemas").iterdir()}
    assert committed == {f"{name}.schema.json" for name in SCHEMAS} | {f"{name}.nxdl.xml" for name in definitions()}


def one_of_each_kind(paths: list[Path]) -> list[Any]:
    """Leave the other sample runs to the slow tests."""
    first = {SAMPLE_IDS[0], DISC_IDS[0], FURTHER_IDS[0]}
    return [
        pytest.param(path, id=path.parent.name, marks=() if path.parent.name in first else pytest.mark.slow)
        for path in paths
    ]


@pytest.mark.slow
@pytest.mark.parametrize("path", one_of_each_kind(RUNS))
def test_committed_sample_run_is_the_simulated_one(tmp_path, path):
    again = "run `tribopipe simulate sample_runs --plan sample_runs/plan.toml`"
    there, made = path.parent, tmp_path / path.parent.name
    plan = load_toml(SAMPLES / "plan.toml", Plan)
    series = [
        one.model_copy(update={"runs": tuple(run for run in one.runs if run.id == there.name)}) for one in plan.series
    ]
    simulate_plan(plan.model_copy(update={"series": tuple(series)}), tmp_path)
    for name in ("run.toml", "signals.csv"):
        assert (there / name).read_bytes() == (made / name).read_bytes(), again
    committed, truth = (json.loads((folder / "truth.json").read_bytes()) for folder in (there, made))
    ends = [key for key in truth if key.startswith("end_")]
    assert len(ends) == (5 if there.name in DISC_IDS else 3 if there.name in FURTHER_IDS else 2)
    for end in ends:
        # The last digit may differ from one processor to another.
        assert committed.pop(end)["value"] == pytest.approx(truth.pop(end)["value"], rel=1e-13), again
    assert committed == truth, again


def test_run_toml_of_the_readme_is_valid(tmp_path):
    (block,) = re.findall(r"```toml\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    path = tmp_path / "document.toml"
    path.write_text(block, encoding="utf-8")
    assert load_toml(path, RunManifest).id == "si3n4-air-200mN"
