"""Files of every format, changed 100 000 times in a run folder: each is archived, or refused in one sentence.

In half of the cases, the table of a text file is changed (fields, columns, separators, decimal signs, names,
encodings); in the other half, its bytes. In binary files, bytes are changed. The originals are the example files of
each format in the tests. Workbooks and HDF5 files, 1 case in 200, are read in separate processes (0.3 s each).
"""

import random
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import NamedTuple

from fuzzing import Case, main
from mutations import changed_bytes, changed_table, of_tests

_READ_APART = ("workbook", "tribopipe-hdf5")
_BINARY = (*_READ_APART, "ni-tdms")
_SHARE_READ_APART = 1 / 200
_HEIGHTS = [0.25 * (n % 7) for n in range(40)]
_PROFILES: Mapping[str, Callable[[bytes], bytes]] = {
    "dektak": lambda head: head + b"".join(b"%.1f,%.2f,,\r\n" % (n + 1, z) for n, z in enumerate(_HEIGHTS)),
    "gwyddion-text": lambda head: (
        head[: head.index(b"\n1.00e") + 1] + (b"\t".join(b"%.2e" % z for z in _HEIGHTS) + b"\n") * 2
    ),
    "points": lambda head: head + b"".join(b"%.6f\t%.6f\r\n" % (n + 1, z) for n, z in enumerate(_HEIGHTS)),
}
"""Profiles take more points than the examples have."""
_HEAD = (
    'schema = "tribopipe.run/1"\nid = "{id}"\nconditions = {{ normal_load = "{load}", sliding_speed = "0.1 m/s" }}\n'
)
_LOAD = "5 N"
_SIGNALS = '[[signals]]\nfile = "{file}"\n'
_CONTACT = """[contact]
kind = "pin-on-disc"
pin = {{ shape = "flat", radius = "2 mm", material = "A", youngs_modulus = "200 GPa", poisson_ratio = 0.3 }}
disc = {{ material = "B", youngs_modulus = "200 GPa", poisson_ratio = 0.3 }}
"""
_LOADS = {"phoenix-compend": "59.84 N"}
"""Nominal loads of examples whose recorded load is not the usual one here."""
_COLUMNS = {
    "load-cell-frames": 'columns = { time = { column = "load", unit = "s" } }\n',
    "pcs-instruments": 'columns = { time = "Step Time" }\n',
    "newport-rheofriction": 'columns = { time = "time" }\n',
    "workbook": 'columns = { friction_force = "Ft" }\n',
    "delimited": 'columns = { depth = "Depth [um]" }\n',
}
_PLAIN = b"".join([b"Time [s],Friction force [N]\n", *(b"%.1f,%.2f\n" % (0.1 * n, n % 5) for n in range(30))])


class Seed(NamedTuple):
    """A run folder of a format."""

    format: str
    file: str
    """The one that is changed."""
    files: Mapping[str, bytes]


@cache
def seeds() -> tuple[Seed, ...]:
    """Give a run folder for each example of each format."""
    return tuple(
        _folder(name, number, example.name, example.content)
        for name, found in of_tests("reader_examples").EXAMPLES.items()
        for number, example in enumerate(found)
    )


def _head(run_id: str, load: str = _LOAD) -> str:
    return _HEAD.format(id=run_id, load=load)


def _folder(name: str, number: int, file: str, content: bytes) -> Seed:
    head = _head(f"{name}-{number}", _LOADS.get(name, _LOAD))
    if name in _PROFILES:
        content = _PROFILES[name](content)
        units = 'position = { column = "x", unit = "mm" }, height = { column = "z", unit = "um" }'
        named = f'{{ file = "{file}"{f", {units}" if name == "points" else ""} }}'
        written = f"{head}{_CONTACT.format()}{_SIGNALS.format(file='plain.csv')}[end_values]\ndisc_profile = {named}\n"
        return Seed(name, file, {"run.toml": written.encode(), "plain.csv": _PLAIN, file: content})
    written = head + _SIGNALS.format(file=file) + _COLUMNS.get(name, "")
    return Seed(name, file, {"run.toml": written.encode(), file: content})


def sound() -> Case:
    """Give a run that nothing is wrong with."""
    return Case(
        "plain",
        {"run.toml": (_head("plain") + _SIGNALS.format(file="plain.csv")).encode(), "plain.csv": _PLAIN},
    )


def unchanged() -> Iterator[Case]:
    """Give what cases are made of, with nothing changed."""
    for seed in seeds():
        yield Case(seed.format, seed.files)


def make(draw: random.Random) -> Case:
    """Change the file of one format."""
    apart = draw.random() < _SHARE_READ_APART
    seed = draw.choice([one for one in seeds() if (one.format in _READ_APART) == apart])
    content = seed.files[seed.file]
    if seed.format in _BINARY or draw.random() < 0.5:
        other = draw.choice(seeds())
        changed = changed_bytes(draw, content, other.files[other.file])
    else:
        changed = changed_table(draw, content)
    return Case(seed.format, {**seed.files, seed.file: changed})


if __name__ == "__main__":
    sys.exit(main("fuzz_signals", "Mutated signal files", __doc__, make, sound()))
