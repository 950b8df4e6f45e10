"""The conformance kit: all our readers keep its rules, each rule is broken by somebody, and the docs are true."""

import re
import sys
import tomllib
import types
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest
from reader_examples import EXAMPLES, GENERIC
from sweeps import others_slow

from tribopipe.base.errors import ReaderError
from tribopipe.readers import conformance
from tribopipe.readers.conformance import CLAIMED, ConformanceError, Example, check_reader
from tribopipe.readers.reader import Hints, Match, ReadColumn, ReadTable, readers
from tribopipe.results.run import SourceFile

DOCS = Path(__file__).parents[1] / "docs" / "readers.md"


FORMATS = list(EXAMPLES)


def others_than(name: str) -> list[Example]:
    return [example for other, examples in EXAMPLES.items() if other != name for example in examples]


@pytest.mark.parametrize("name", others_slow(FORMATS, first=6))
def test_reader_keeps_the_rules(name):
    check_reader(readers()[name], EXAMPLES[name], others=others_than(name), generic=name in GENERIC, quick=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", FORMATS)
def test_reader_keeps_the_rules_at_every_byte(name):
    check_reader(readers()[name], EXAMPLES[name], others=others_than(name), generic=name in GENERIC)


@pytest.mark.parametrize("name", EXAMPLES)
def test_no_false_claim(name):
    for example in EXAMPLES[name]:
        found = {other: reader.match(example.source).confidence for other, reader in readers().items()}
        assert max(found, key=found.__getitem__) == name
        claims = {other for other, confidence in found.items() if confidence >= CLAIMED}
        assert claims <= {name} | GENERIC


REAL = Path(__file__).resolve().parents[2] / "shared" / "realdata"
REAL_FILES = {
    "winducom-dwf-al10cu/*/*.dwf": "ducom-winducom",
    "newport-rheofriction/*/*.txt": "newport-rheofriction",
    "pcs-ehd-labview/*/*/demo_[12].txt": "labview-lvm",
    "pcs-ehd-labview/*/*/demo_3.txt": "pcs-instruments",
    "pinondiskapp-es/data/celda_sim.csv": "load-cell-frames",
    "pinondiskapp-es/data/test.txt": "delimited",
    "nanotribometer-silicone-percycle/*.csv": "delimited",
    "profil-surfacetopography/*/*/dektak-1.csv": "dektak",
    "profil-surfacetopography/*/*/gwyddion-export-*.txt": "gwyddion-text",
    "profil-surfacetopography/*/*/xy-*.txt": "points",
    "profil-roller-bearing-cr/*-?.txt": "points",
    "profil-nanovea-st400/*/*.txt": "points",
}


@pytest.mark.slow
@pytest.mark.parametrize("pattern", REAL_FILES)
def test_no_false_claim_among_real_files(pattern):
    paths = sorted(REAL.glob(pattern))
    if not paths:
        pytest.skip(f"real data not here: {pattern}")
    for path in paths:
        source = SourceFile(path.name, path.read_bytes())
        found = {name: reader.match(source).confidence for name, reader in readers().items()}
        assert max(found, key=found.__getitem__) == REAL_FILES[pattern]
        assert {name for name, confidence in found.items() if confidence >= CLAIMED} <= {REAL_FILES[pattern]} | GENERIC


# --- readers that break one rule each ---

SIMPLE = b"simple\nt s;F N\n" + b"".join(b"%d.25;%d.5;\n" % (number, 7 * number) for number in range(20))
EXAMPLE = Example(
    "run.simple",
    SIMPLE,
    rows=20,
    columns={"t": "s", "F": "N"},
    signals={"t": "time"},
    values={"F": [7 * number + 0.5 for number in range(20)]},
    facts={"operator": "N. N."},
    permuted=b"simple\nF N;t s\n" + b"".join(b"%d.5;%d.25;\n" % (7 * number, number) for number in range(20)),
)
OTHER = Example("other.txt", b"something;else\n1;2\n", rows=1, columns={})


@dataclass
class Simple:
    """A reader of a simple format that keeps every rule."""

    name: str = "simple"
    title: str = "Simple format of this test"
    holds: str = "signals"

    def match(self, source: SourceFile) -> Match:
        if source.content.startswith(b"simple\n"):
            return Match(0.95, "the first line is 'simple'")
        return Match(0.0, "the first line is not 'simple'")

    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        try:
            return self.parse(source.content.decode("utf-8" if hints.encoding is None else hints.encoding))
        except (LookupError, ValueError) as error:
            raise ReaderError(f"{source.name}: found {error}; expected the simple format; copy it again") from None

    def parse(self, text: str) -> ReadTable:
        first, names, *rows = text.splitlines()
        if first != "simple" or not rows:
            raise ValueError("no simple file")
        if rows[-1] and not rows[-1].endswith(";"):
            raise ValueError("a row that is cut")
        values = np.array([self.numbers(row) for row in rows])
        columns = [self.column(name, values[:, number]) for number, name in enumerate(names.split(";"))]
        return ReadTable(tuple(columns), f"{first}\n{names}\n", (), {"operator": "N. N."})

    def numbers(self, row: str) -> list[float]:
        first, second, end = row.split(";")
        if end:
            raise ValueError("a third field")
        return [float(first), float(second)]

    def column(self, name: str, values: Any) -> ReadColumn:
        bare, unit = name.split(" ")
        if (bare, unit) not in (("t", "s"), ("F", "N")):
            raise ValueError("unknown columns")
        return ReadColumn(bare, values, unit, "time" if bare == "t" else None)


def check(reader: Any) -> None:
    check_reader(reader, [EXAMPLE], others=[OTHER], quick=True)


def test_a_reader_that_keeps_every_rule_passes():
    check(Simple())


def with_match(confidence: float, why: str = "said so", *, own: bool = True) -> type:
    class Faulty(Simple):
        def match(self, source: SourceFile) -> Match:
            mine = source.content.startswith(b"simple\n") is own
            return Match(confidence, why) if mine else super().match(source)

    return Faulty


class MatchRaises(Simple):
    def match(self, source: SourceFile) -> Match:
        return (
            Match(0.95, f"the first byte is {source.content[0]}")
            if source.content[:1] != b"s"
            else super().match(source)
        )


class MatchGivesNumber(Simple):
    def match(self, source: SourceFile) -> Any:
        return super().match(source).confidence


class MatchIsSlow(Simple):
    def match(self, source: SourceFile) -> Match:
        if len(source.content) > 100_000:
            started = process_time()
            while process_time() < started + 0.1:
                pass
        return super().match(source)


class MatchByExtension(Simple):
    def match(self, source: SourceFile) -> Match:
        return super().match(source) if source.name.endswith(".simple") else Match(0.0, "another extension")


class Refuses(Simple):
    def parse(self, text: str) -> ReadTable:
        raise ValueError(text[:1])


class RaisesAnything(Simple):
    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        return self.parse(source.content.decode("utf-8" if hints.encoding is None else hints.encoding))


class HidesTheFile(Simple):
    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        try:
            return super().read(source, hints)
        except ReaderError:
            raise ReaderError("something is wrong") from None


class ReadsProse(Simple):
    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        if source.content.startswith(b"Dear"):
            return super().read(EXAMPLE.source, hints)
        return super().read(source, hints)


class KeepsCutNumbers(Simple):
    def parse(self, text: str) -> ReadTable:
        return super().parse(text if text.endswith("\n") else text.rstrip(";") + ";")


class FillsUp(Simple):
    def numbers(self, row: str) -> list[float]:
        return [*super().numbers(row)] if row.count(";") == 2 else [0.0, 0.0]

    def parse(self, text: str) -> ReadTable:
        return super().parse(text if text.endswith(";\n") else text + ";;;")


class GuessesEncoding(Simple):
    def read(self, source: SourceFile, hints: Hints) -> ReadTable:
        content = source.content.replace(b"\x81", b"9")
        return super().read(SourceFile(source.name, content), hints)


class BindsOrder(Simple):
    def parse(self, text: str) -> ReadTable:
        table = super().parse(text)
        return replace(table, columns=tuple(replace(c, name=n) for c, n in zip(table.columns, "tF", strict=True)))


class Counts(Simple):
    calls = 0

    def parse(self, text: str) -> ReadTable:
        Counts.calls += 1
        return replace(super().parse(text), notes=(f"read {Counts.calls} times",))


def changing(change: Any) -> type:
    """A reader that changes each table it has read."""

    class Faulty(Simple):
        def parse(self, text: str) -> ReadTable:
            return change(super().parse(text))

    return Faulty


def first_column(**changes: Any) -> type:
    return changing(lambda table: replace(table, columns=(replace(table.columns[0], **changes), *table.columns[1:])))


FAULTY = {
    "found no reader; expected name, title": object,
    "name 'Simple Format' contains characters other than": lambda: Simple(name="Simple Format"),
    "title '' is not one line": lambda: Simple(title=""),
    "holds 'pictures' is unknown": lambda: Simple(holds="pictures"),
    "match raised IndexError": MatchRaises,
    "match gave no Match with a confidence": MatchGivesNumber,
    "a confidence from 0 to 1": with_match(1.5),
    "match gave no reason": with_match(0.95, ""),
    "match took more than": MatchIsSlow,
    "confidence below 0.9 in a file of the format": with_match(0.6),
    "in a file of the format (as 'run'": MatchByExtension,
    "in a file of a different format (other.txt)": with_match(0.5, own=False),
    "in a file of no known format (an empty file": with_match(0.5, own=False),
    "a file of the format is rejected": Refuses,
    "read raised UnicodeDecodeError instead of": RaisesAnything,
    "an error does not name the file": HidesTheFile,
    "a file of no known format is read (prose)": ReadsProse,
    "read gave no ReadTable with columns": changing(lambda _table: ReadTable(())),
    "a column's name is empty or padded": first_column(name=" t"),
    "two columns have the same name": first_column(name="F"),
    "columns differ in length": first_column(values=np.zeros(3)),
    "values are int64, neither float64 nor": first_column(values=np.arange(20)),
    "values are objects other than strings": first_column(values=np.array([1] * 20, dtype=object)),
    "first_bad does not indicate": first_column(first_bad=(3, "x")),
    "unit 'furlongs!' is unknown": first_column(unit="furlongs!"),
    "axis 'w' is unknown": first_column(axis="w"),
    "a profile has no axis z": first_column(axis="z"),
    "signal 'wear' is unknown": first_column(signal="wear"),
    "unit 'mm' is not a unit of time": first_column(unit="mm"),
    "fact started is not a string": changing(lambda table: replace(table, facts={"started": 5})),
    "facts: started:": changing(lambda table: replace(table, facts={"started": "yesterday"})),
    "facts: conditions.wind:": changing(lambda table: replace(table, facts={"conditions.wind": "5 m/s"})),
    "the fact operator is None": changing(lambda table: replace(table, facts={})),
    "header and notes are not strings": changing(lambda table: replace(table, notes=(5,))),
    "the header is not a verbatim": changing(lambda table: replace(table, header="a simple file\n")),
    "columns are ['F']": changing(lambda table: replace(table, columns=table.columns[1:])),
    "units are {'t': 'ms'}": first_column(unit="ms"),
    "'t' is not the time": first_column(signal=None),
    "the numbers of 'F' differ from those in the file": changing(
        lambda table: replace(table, columns=(table.columns[0], replace(table.columns[1], values=np.zeros(20))))
    ),
    "19 rows instead of 20": changing(
        lambda table: replace(table, columns=tuple(replace(c, values=c.values[:-1]) for c in table.columns))
    ),
    "reading twice gives different results": Counts,
    "a truncated file gives numbers that differ": KeepsCutNumbers,
    "a truncated file gives numbers that differ from": FillsUp,
    "a file written differently gives different numbers": GuessesEncoding,
    "permuted columns change numbers": BindsOrder,
}


@pytest.mark.parametrize("rule", FAULTY)
def test_a_reader_that_breaks_a_rule_is_caught(rule, monkeypatch):
    monkeypatch.setattr(conformance, "MATCH_SECONDS", 0.09)
    with pytest.raises(ConformanceError) as caught:
        check(FAULTY[rule]())
    assert rule in str(caught.value)


def test_every_violation_is_listed_once():
    with pytest.raises(ConformanceError) as caught:
        check(Simple(name="Not so", title=""))
    assert re.fullmatch(r"Not so: 2 rules broken:\n- name .*\n- title .*", str(caught.value))


def test_no_examples_no_pass():
    with pytest.raises(ConformanceError, match="no examples given"):
        check_reader(Simple(), [])


# --- the worked example of the docs ---


def test_the_worked_example_of_the_docs(monkeypatch):
    section = DOCS.read_text(encoding="utf-8").partition("# A reader as a plug-in")[2]
    reader, test = re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    declared = tomllib.loads(re.search(r"```toml\n(.*?)```", section, re.DOTALL)[1])
    module = types.ModuleType("acme_tribo")
    monkeypatch.setitem(sys.modules, "acme_tribo", module)
    exec(compile(reader, "acme_tribo.py", "exec"), module.__dict__)  # noqa: S102 - our own docs
    found: dict[str, Any] = {}
    exec(compile(test, "test_acme_tribo.py", "exec"), found)  # noqa: S102 - our own docs
    found["test_reader"]()
    assert declared["project"]["entry-points"]["tribopipe.readers"] == {"acme-tribo": "acme_tribo:AcmeReader"}
