"""Every number that commands print of the sample runs is the one that is committed, or its change is intended."""

import json

import pytest
from folders import ALL_IDS
from goldens import COMMANDS, FOLDER, LONGEST, PIN, PLACEHOLDER, RENEW, changes, differences, made, plain
from test_cli_contract import FLAGS


def assert_same(goldens: dict) -> None:
    if found := changes(goldens):
        told = f"{len(found)} values changed; `{RENEW}` writes them anew where that is intended:"
        pytest.fail("\n".join([told, *found]), pytrace=False)


def test_one_sample_and_a_few_commands_give_the_committed_numbers():
    assert_same(made([PIN], ["predict-published", "predict-folder", "live"]))


@pytest.mark.slow
def test_every_sample_and_every_command_give_the_committed_numbers():
    goldens = made(ALL_IDS, list(COMMANDS))
    assert goldens.keys() == {path.stem for path in FOLDER.glob("*.json")}
    assert_same(goldens)


def test_every_command_with_json_has_a_golden():
    with_json = {command for command, flags in FLAGS.items() if "--json" in flags}
    taken = {"process", *COMMANDS.values()}
    assert {command for command in with_json if not any(f"{one} ".startswith(f"{command} ") for one in taken)} == set()


def test_goldens_are_small():
    assert sum(path.stat().st_size for path in FOLDER.glob("*.json")) < 500_000


def test_change_names_its_key_and_both_values():
    old = {"runs": {"a": {"k": {"m^2/N": 1.0, "u": 0.1}, "notes": ["x"]}, "b": 1}}
    new = {"runs": {"a": {"k": {"m^2/N": 1.5, "u": 0.1}, "notes": ["y"]}, "c": True}}
    assert list(differences(old, new)) == [
        "runs.a.k.m^2/N: 1.0 -> 1.5",
        'runs.a.notes[0]: "x" -> "y"',
        "runs.b: 1 -> nothing",
        "runs.c: nothing -> true",
    ]


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        (1.0, 1.0 + 1e-7, True),
        (1.0, 1.0 + 1e-5, False),
        (1, 1.0, True),
        (0, False, False),
        ({"m": 1e-9, "u": 1.0}, {"m": 2e-9, "u": 1.0}, True),
        ({"m": 1e-9}, {"m": 2e-9}, False),
        ([1.0], [1.0, 2.0], False),
    ],
)
def test_numbers_are_the_same_within_rounding(old, new, same):
    assert (not list(differences(old, new))) == same


def test_document_is_told_shortly():
    quantity = {"value": 1.23456789012e-9, "unit": "m", "standard_uncertainty": None, "method": "stylus"}
    runs = [{"id": "a", "depth": quantity, "missing": []}, {"id": "b", "program_version": "0.1.0"}]
    assert plain(
        {"runs": runs, "curve": [float(value) for value in range(LONGEST + 2)], "at": "2026-01-01T10:00:00"}
    ) == {
        "runs": {"a": {"depth": {"m": 1.23456789e-9, "method": "stylus"}}, "b": {"program_version": PLACEHOLDER}},
        "curve": {"count": 10, "first": 0.0, "last": 9.0, "mean": 4.5},
        "at": PLACEHOLDER,
    }


def test_goldens_have_one_number_a_line():
    for path in FOLDER.glob("*.json"):
        text = path.read_text(encoding="utf-8")
        assert text == json.dumps(json.loads(text), indent=1, sort_keys=True, ensure_ascii=False) + "\n"
