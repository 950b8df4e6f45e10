"""Patterns take a time that grows no faster than what they read: each of these took the square of it, or its cube."""

from pathlib import Path

import pytest

from tribopipe.base.errors import ManifestError
from tribopipe.documents.toml import parse_toml
from tribopipe.readers.formats.anton_paar import _SETTING
from tribopipe.readers.formats.serial_frames import _FRAME
from tribopipe.readers.headed_tables import bare_key

LONG = 1 << 18
"""Characters; by the square, minutes or hours."""


@pytest.mark.parametrize("blank", [" ", "\t", "\n"])
def test_blanks_in_a_header_cell(blank):
    assert bare_key("Friction" + LONG * blank + "Force [N]") == "frictionforce"
    assert bare_key("Load" + LONG * blank + "[N]") == "load"


@pytest.mark.parametrize("text", [LONG * '\\"', LONG * '"\\', LONG * '"a\\', LONG * '"\\"\\', LONG * '" '])
def test_quotes_in_a_document(text):
    with pytest.raises(ManifestError, match="no valid TOML"):
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
