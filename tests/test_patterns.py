"""Patterns take a time that grows no faster than what they read: each of those below took the square of it, or more."""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from backtracking import ambiguity
from hanging import ends_soon
from own_patterns import LONGEST, Walked, own_patterns
from sweeps import others_slow

from tribopipe.archive.definitions.nxdl import definitions
from tribopipe.base.errors import ManifestError
from tribopipe.cli.options import friction_path
from tribopipe.documents.contact import _CALLED
from tribopipe.documents.toml import parse_toml
from tribopipe.evaluation.checks import channels, material_ranges
from tribopipe.extras.live.priors import _GIVEN
from tribopipe.physics.calculation_methods import LAW_PATTERN
from tribopipe.readers.formats import rtec
from tribopipe.readers.formats.anton_paar import _SETTING
from tribopipe.readers.formats.gwyddion import _COMMENT
from tribopipe.readers.formats.serial_frames import _FRAME
from tribopipe.readers.formats.umt import _INSTRUMENT
from tribopipe.readers.formats.winducom import _ROW
from tribopipe.readers.headed_tables import bare_key
from tribopipe.readers.tables import is_placeholder, split_name

LONG = 1 << 18
"""Characters; by the square, minutes or hours."""


def _partial_names() -> list[str]:
    """Names in the definitions of archives of which a part is in capital letters."""
    found, new = set(), [definition.entry for definition in definitions().values()]
    while new:
        part = new.pop()
        new += getattr(part, "members", ())
        found.add(getattr(part, "name", ""))
    return sorted(re.sub("[A-Z]+", r"\\w+", name) for name in found if name != name.lower())


BUILT = {
    "archive/definitions/parts.py": [(name, "fullmatch") for name in _partial_names()],
    "cli/documentation.py": [(r"(?<!\w)two\ words(?!\w)", "findall")],
    "documents/contact.py": [
        (pattern, call)
        for one in _CALLED.values()
        for pattern, call in ((one.key, "sub"), (one.body, "sub"), (one.table, "sub"))
    ],
    "documents/record.py": [(LAW_PATTERN, "fullmatch")],
    "evaluation/checks/channels.py": [(names, "fullmatch") for _, names in channels._EXTRAS.values()],
    "evaluation/checks/material_ranges.py": [(one.names, "search") for one in material_ranges.CLASSES],
    "readers/formats/rtec.py": [(f"(?i){pattern}", "fullmatch") for pattern, _ in rtec._MEANINGS],
    # Each part of one with * is sought once: fnmatch writes (?>.*?part).
    "archive/catalog/query.py": [(r"(?s:a.b.*)\Z", "match")],
    # Written by a lab, and searched for in bounded time: tests/test_described.py.
    "documents/reader_profile.py": [],
    "readers/subprocess_readers/regex_search.py": [],
}
"""What patterns are made of while tribopipe runs."""


@pytest.fixture(scope="module")
def walked() -> Walked:
    return own_patterns()


@pytest.mark.slow
def test_no_pattern_can_read_a_long_text_in_many_ways(walked):
    assert len(walked.patterns) > 150
    found = {f"{one.where}, {one.call}": word for one in walked.patterns if (word := ambiguity(one.pattern, one.call))}
    unbounded = {where: word for where, word in found.items() if where.rpartition(",")[0] not in LONGEST}
    assert unbounded == {}
    assert {where.rpartition(",")[0] for where in found} == LONGEST.keys()


@pytest.mark.slow
def test_no_pattern_made_while_tribopipe_runs_can(walked):
    assert {where.partition(":")[0] for where in walked.built} == BUILT.keys()
    patterns = [(re.compile(pattern), call) for made in BUILT.values() for pattern, call in made]
    assert len(patterns) > 20
    assert [one.pattern for one, call in patterns if ambiguity(one, call)] == []


@pytest.mark.parametrize(
    ("pattern", "call"),
    [
        (r"\s*\[", "search"),
        (r"\s+$", "sub"),
        (r"\d+\b", "findall"),
        (r"(a+)+b", "match"),
        (r"(?:na|n\.?a)*;", "match"),
        (r"(a*)*b", "match"),
        (r"(?i)(?:nil|NI.)*!", "match"),
        (r"#\s*[^:]+:", "match"),
        (r"\s*(.*)", "fullmatch"),
        (r".*a.*b", "match"),
        (r"(?=a*b)a", "search"),
        (r"<[^>]*>", "sub"),
    ],
)
def test_careless_patterns_are_found(pattern, call):
    assert ambiguity(re.compile(pattern), call)


@pytest.mark.parametrize(
    ("pattern", "call"),
    [
        (r"(?<!\s)\s*\[", "search"),
        (r"\s+", "sub"),
        (r"\ba+b", "search"),
        (r"(?s)\s*(.*)", "fullmatch"),
        (r"[^\n]*\n|[^\n]+", "findall"),
        (r"x*+y", "match"),
        (r"(?:[^()]|\([^()]*\))*\)", "match"),
        (r"(?:a?){50}b", "match"),
        (r"<[^<>]*>", "sub"),
    ],
)
def test_sound_patterns_are_not(pattern, call):
    assert ambiguity(re.compile(pattern), call) is None


def _raises(work: Callable[[str], object], text: str) -> None:
    with pytest.raises(Exception, match="found"):
        work(text)


LINEAR = {
    "a row of placeholders": (_ROW.fullmatch, "NA;", 40),
    "a comment of blanks": (_COMMENT.match, " ", LONG),
    "a setting of tabs": (_SETTING.fullmatch, "\t", LONG),
    "an instrument and blanks": (_INSTRUMENT.match, " ", LONG),
    "expected values": (_GIVEN.fullmatch, "+-", LONG),
    "a friction path": (partial(_raises, friction_path), ";", LONG),
}


@pytest.mark.parametrize(("call", "repeated", "count"), LINEAR.values(), ids=LINEAR)
def test_what_took_minutes(call, repeated, count):
    start = {" ": "# Created by UMT", "\t": "Radius", ";": "A=1"}.get(repeated, "")
    call(f"{start}{count * repeated}\n!")
    call(f"{count * repeated}\n!")
    call(f"{start[2:]}{count * repeated}\n!")


def test_what_patterns_found_they_still_find():
    assert is_placeholder("NA")
    assert is_placeholder("n.a.")
    assert _ROW.fullmatch(" 0,9150; NA; ;;\r\n")
    assert _INSTRUMENT.match("Created by CETR UMT-3  ver 2.1\r\n")[1] == "CETR UMT-3"
    assert _SETTING.fullmatch("Radius\t : \t6 [mm]")["value"] == "6 [mm]"
    assert _COMMENT.match("# : x")["said"] == "x"
    assert split_name("Load / [N]") == ("Load", "N")
    assert split_name("F (x) (N/(m*s))") == ("F (x)", "N/(m*s)")
    assert split_name("Depth\t / um") == ("Depth", "um")


@pytest.mark.parametrize("repeated", ["(", "()", "[", "(a) ", " / ", "[]("])
def test_brackets_in_a_name(repeated):
    name = (1000 * repeated)[:1000]
    with ends_soon():
        assert split_name(name)[0]


@pytest.mark.parametrize("blank", [" ", "\t", "\n"])
def test_blanks_in_a_header_cell(blank):
    assert bare_key("Friction" + LONG * blank + "Force [N]") == "frictionforce"
    assert bare_key("Load" + LONG * blank + "[N]") == "load"


@pytest.mark.parametrize(
    "text", others_slow([LONG * '\\"', LONG * '"\\', LONG * '"a\\', LONG * '"\\"\\', LONG * '" '], first=2)
)
def test_quotes_in_a_document(text):
    with pytest.raises(ManifestError, match="invalid TOML"):
        parse_toml(Path("run.toml"), text.encode())


@pytest.mark.parametrize("key", ["x." * 25 + "x = 1", '[ "a\\"b" . ' + "'c' . " * 22 + "d ]"])
def test_dotted_keys_without_end_are_found(key):
    with pytest.raises(ManifestError, match="line 2: found a key of more than 20 parts"):
        parse_toml(Path("run.toml"), f'# "\n{key}\n'.encode())


@pytest.mark.parametrize("blank", [" ", "\t"])
def test_blanks_in_a_line_of_an_export(blank):
    assert _SETTING.fullmatch(LONG * blank) is None
    assert _SETTING.fullmatch("Radius" + LONG * " " + "x") is None
    assert _SETTING.fullmatch(f"Radius{blank}: 6 [mm]")["value"] == "6 [mm]"
    assert _SETTING.fullmatch("Normal load\t5 N")["key"] == "Normal load"


def test_blanks_in_a_frame():
    assert _FRAME.fullmatch(LONG * b" ") is None
    assert _FRAME.fullmatch(b"   -  0.072KGM\r\n")["sign"] == b"-"
