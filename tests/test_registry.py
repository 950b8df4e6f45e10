"""The registry of readers: lazy, tolerant of broken plugins, strict about what is unclear."""

import subprocess
import sys
import tomllib
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from tribopipe.base.errors import ReaderError
from tribopipe.base.plugins import own_first
from tribopipe.readers import reader as registry
from tribopipe.readers.delimited import DelimitedReader
from tribopipe.readers.formats.winducom import WinducomReader
from tribopipe.readers.reader import Hints, Match, Reader, ReadTable
from tribopipe.results.run import SourceFile

BUILT_IN = {
    "delimited": "tribopipe.readers.delimited:DelimitedReader",
    "ducom-winducom": "tribopipe.readers.formats.winducom:WinducomReader",
}
WINDUCOM = b"          TIME;          FF;\r        0,9150;        4,80;;\r"


class Sure:
    """A plugin that takes every file."""

    name = "sure"
    title = "Takes everything"
    holds = "signals"

    def match(self, source: SourceFile) -> Match:
        return Match(0.95, f"{source.name} is a file")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        return ReadTable((), header=f"{source} {hints}")


class Impostor(Sure):
    name = "delimited"


class SureProfile(Sure):
    name = "sure-profile"
    holds = "profile"


class Crashing(Sure):
    name = "crashing"

    def match(self, source: SourceFile) -> Match:
        raise RuntimeError(source.name)


class NoReader:
    name = "nothing"


@pytest.fixture
def installed(monkeypatch):
    """Install entry points for one test."""

    def install(**plugins: str) -> None:
        declared = {name.replace("_", "-"): value for name, value in plugins.items()}
        entries = [EntryPoint(name, value, registry.GROUP) for name, value in (BUILT_IN | declared).items()]
        monkeypatch.setattr("tribopipe.base.plugins.declared", lambda _: own_first(entries))
        registry._loaded.cache_clear()

    yield install
    registry._loaded.cache_clear()


def here(cls: type) -> str:
    return f"{__name__}:{cls.__name__}"


def test_pyproject_declares_the_built_in_readers():
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = project["entry-points"][registry.GROUP]
    assert declared.items() >= BUILT_IN.items()
    for name, value in declared.items():
        reader = EntryPoint(name, value, registry.GROUP).load()()
        assert isinstance(reader, Reader)
        assert reader.name == name


def test_all_readers_by_name(installed):
    installed(sure=here(Sure))
    found = registry.readers()
    assert list(found) == ["delimited", "ducom-winducom", "sure"]
    found.clear()
    assert registry.readers()


def test_reader_by_name(installed):
    installed()
    assert isinstance(registry.reader_named("ducom-winducom"), WinducomReader)
    with pytest.raises(ReaderError, match=r"unknown reader 'delimted'.*did you mean 'delimited'\?"):
        registry.reader_named("delimted")


def test_broken_plugin_is_left_out_with_a_warning(installed):
    installed(broken="no_such_package:Reader")
    with pytest.warns(UserWarning, match="'broken' skipped.*no_such_package"):
        assert list(registry.readers()) == ["delimited", "ducom-winducom"]


def test_plugin_that_is_no_reader_is_left_out_with_a_warning(installed):
    installed(nothing=here(NoReader))
    with pytest.warns(UserWarning, match="'nothing' skipped.*has no name, title, holds, match or read"):
        assert "nothing" not in registry.readers()


def test_plugin_cannot_take_the_name_of_a_built_in_reader(installed):
    installed(a_delimited=here(Impostor))
    with pytest.warns(UserWarning, match="skipped, because a reader with the name 'delimited'"):
        assert isinstance(registry.readers()["delimited"], DelimitedReader)


def test_format_is_found_by_content(installed):
    installed()
    assert registry.detect(SourceFile("a.csv", WINDUCOM)).name == "ducom-winducom"
    assert registry.detect(SourceFile("a.dwf", b"Time;Depth\n1;2\n")).name == "delimited"


def test_unknown_format_is_refused(installed):
    installed()
    with pytest.raises(
        ReaderError, match=r"a\.csv: found no known format; read as a plain table: found a zero byte at offset"
    ):
        registry.detect(SourceFile("a.csv", b"\x00\x01\x02"))


def test_unknown_format_names_the_nearest(installed):
    installed()
    with pytest.raises(
        ReaderError, match=r"plain table: most rows do not have as many fields .* expected a format listed"
    ):
        registry.detect(SourceFile("a.csv", b"Time,Depth,Ft,Fn,T\n1,2,3\n3,4,5\n5,6,7\n"))


def test_a_file_known_to_hold_nothing_is_refused_by_name():
    with pytest.raises(ReaderError, match=r"found a 'Mapper Spacer Calibration File'; expected a tribometer rec"):
        registry.detect(SourceFile("a.txt", b"Mapper Spacer Calibration File\r\nFilm\tR\tG\tB\r\n-10\t35\t64\t171\r\n"))


def test_tie_names_both(installed):
    installed(sure=here(Sure))
    with pytest.raises(ReaderError, match=r"a\.csv: found a file that the readers ducom-winducom and sure recognize"):
        registry.detect(SourceFile("a.csv", WINDUCOM))
    assert registry.detect(SourceFile("a.csv", b"Time;Depth\n1;2\n")).name == "sure"


def test_candidates_stand_in_the_order_of_their_confidence(installed):
    installed(sure=here(Sure), profile=here(SureProfile))
    source = SourceFile("a.csv", b"Time;Depth\n1;2\n")
    found = registry.candidates(source)
    assert [reader.name for reader, _ in found][2:] == ["delimited", "ducom-winducom"]
    assert [match.confidence for _, match in found] == sorted((match.confidence for _, match in found), reverse=True)
    assert [reader.name for reader, _ in registry.candidates(source, "profile")] == ["sure-profile"]
    assert [registry.is_sure(match) for _, match in found] == [True, True, True, False]


def test_only_readers_for_what_a_file_should_hold_are_asked(installed):
    installed(sure=here(Sure), profile=here(SureProfile))
    source = SourceFile("a.csv", b"Time;Depth\n1;2\n")
    assert registry.detect(source, "profile").name == "sure-profile"
    assert registry.detect(source, "signals").name == "sure"
    with pytest.raises(ReaderError, match="sure-profile and sure recognize"):
        registry.detect(source)


def test_plugin_that_crashes_while_judging_is_passed_over(installed):
    installed(crashing=here(Crashing))
    with pytest.warns(UserWarning, match="'crashing' failed"):
        assert registry.detect(SourceFile("a.csv", WINDUCOM)).name == "ducom-winducom"


@pytest.mark.slow
def test_importing_the_registry_loads_neither_readers_nor_pandas():
    code = "import sys, tribopipe.readers.reader, tribopipe.readers.delimited; print('pandas' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
