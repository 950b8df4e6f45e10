"""Ways in which what a lab writes goes wrong, drawn at random: documents and tables by their structure, and texts."""

import gzip
import random
import re
import sys
from collections.abc import Callable, Sequence
from copy import deepcopy
from importlib import import_module
from pathlib import Path
from typing import Any

from tribopipe.readers.draft.known_values import toml, toml_key

Document = dict[str, Any]
Draw = random.Random
_TESTS = str(Path(__file__).parents[2] / "tests")

NAMES = (
    *("../../etc/passwd", "/etc/passwd", "C:\\data\\x.csv", "C:x", "\\\\host\\share\\x", "~/x", "~", ".", "..", "./"),
    *(
        "signals.csv/",
        "signals.csv/.",
        "run.toml",
        "RUN.TOML",
        "nul",
        "con.txt",
        "a\0b",
        "a\nb",
        "\u202ecsv.x",
        "é" * 99,
    ),
    *("x" * 300, " signals.csv", "signals.csv ", "signals.csv:x", "file:///etc/passwd", "http://host/x.csv", "-rf", ""),
)
TEXTS = (
    *(
        "",
        " ",
        "nan",
        "inf",
        "-inf",
        "NaN mm",
        "1e999 m",
        "-1e-999 m",
        "1e-320 m",
        "1e300 N",
        "0 m",
        "-0 N",
        "+.5e+0 mm",
    ),
    *(
        "1,5 mm",
        "1 000 mm",
        "1_0 mm",
        "0x1p3 m",
        "١٢ mm",
        "1 ｍｍ",
        "1 µm",
        "1 μm",
        "1 um",
        "1 mm mm",
        "1 m^99",
        "1 9^9^9",
    ),
    *("1 mm^2", "1 degC", "-300 degC", "1e3 K", "100 %", "1e30 %", "5 furlong", "1 N/N", "1 /s", "1 )", "1 ((m))"),
    *(
        "\u0000",
        "\n",
        "a\r\nb",
        "\x1b[31m",
        "\u202e",
        "\ufeff",
        "\U0010ffff",
        "%s%n",
        "{0}",
        "' or 1=1",
        "<b>",
        "x" * 5000,
    ),
    *("9" * 5000 + " m", "1 " + " " * 20000 + "m", "1 " + "m" * 20000, "tribopipe.run/2", "0001-01-01T00:00:00+14:00"),
    *NAMES,
)
VALUES = (
    *(
        "nan",
        "inf",
        "-inf",
        "-0.0",
        "1e308",
        "5e-324",
        "1e999999",
        "0",
        "-1",
        "true",
        "0xFFFFFFFFFFFFFFFFFFFF",
        "9" * 30,
    ),
    *(
        "9" * 5000,
        "1_000",
        "[]",
        "{}",
        "[[]]",
        "[" * 50 + "]" * 50,
        "{ a = " * 50 + "1" + " }" * 50,
        '""',
        "''",
        '"""a"""',
    ),
    *(
        "1979-05-27",
        "07:32:00",
        "0001-01-01T00:00:00+23:59",
        "9999-12-31T23:59:59-23:59",
        '{ value = "1 m" }',
        "[1, 'a']",
    ),
    *(
        '{ value = 1, unit = "m" }',
        '{ value = "1 m", standard_uncertainty = "1e999 %" }',
        '{ values = ["1 um", "2 um"] }',
    ),
    *('{ value = 1e308, unit = "m", standard_uncertainty = 1e308 }', "{ values = [] }", '{ file = "signals.csv" }'),
)
FIELDS = (
    *(
        "",
        "nan",
        "NaN",
        "inf",
        "-inf",
        "1e999",
        "1e308",
        "-1e308",
        "5e-324",
        "1e-999",
        "1_0",
        "0x1",
        "1,5",
        "1.5.5",
        "--1",
    ),
    *(
        "٣",
        "１",
        "−1",
        "1e",
        "e5",
        ".",
        "-",
        "#N/A",
        "overflow",
        "9" * 400,
        "9" * 5000,
        "x" * 2000,
        '"',
        '"a"b',
        "\0",
        "\x1a",
    ),
    *("\ufeff", "a\tb", "[um]", "1 um", "2024-02-30", "25:61:61", "TRUE", "=1+1", "'", "\u2028", "\x85", " 1 ", "+1"),
)
UNITS = (
    *(
        "m",
        "mm",
        "um",
        "µm",
        "nm",
        "N",
        "mN",
        "gf",
        "kg",
        "mg",
        "K",
        "degC",
        "%",
        "1",
        "",
        "s",
        "Hz",
        "rpm",
        "GPa",
        "m/s",
    ),
    *("g/cm^3", "mm^3", "mm^3/(N*mm)", "furlong", "m^99", "m^-0.5", "m/0", "(", "1e3 m", "deg", "rev", "V", "count"),
)
LOOKALIKES = dict(zip("aceopxymsN0.-µ1=", "асеорхумѕΝО·−μl＝", strict=True))
ENCODINGS = (
    "utf-16",
    "utf-16-le",
    "utf-16-be",
    "utf-8-sig",
    "utf-32",
    "cp1252",
    "latin-1",
    "shift_jis",
    "utf-7",
    "cp037",
)
_MANY_PLACES = 2000
"""Of a document that was made large already, which would become endless."""
_LONGEST_LINE = 1 << 18
SEPARATORS = (",", ";", "\t", "|", " ", "  ", ":", "\u00a0", ", ", "")


def few(draw: Draw) -> range:
    """Draw how many things go wrong in one case; most often one."""
    return range(draw.choice((1, 1, 2, 3)))


def of_tests(module: str) -> Any:
    """Give a module of the tests: its examples of all formats serve here, too, and its changes of bytes."""
    if _TESTS not in sys.path:
        sys.path.append(_TESTS)
    return import_module(module)


def changed_bytes(draw: Draw, content: bytes, other: bytes) -> bytes:
    """Change a file in some places, whatever it holds; parts of another one may get into it."""
    changed: bytes = of_tests("fuzz_readers").mutated(draw, content, other)
    return changed


# --- documents ---


def changed_document(draw: Draw, document: Document) -> bytes:
    """Change a document in some places of its structure, and write it."""
    changed = deepcopy(document)
    for _ in few(draw):
        places = _places(changed)
        if 0 < len(places) < _MANY_PLACES:
            draw.choice(_CHANGES)(draw, places)
    lines = (f"{toml_key(key)} = {toml(value)}" for key, value in changed.items())
    return ("\n".join(lines) + "\n").encode("utf-8", "surrogatepass")


Place = tuple[Any, Any]
"""A table or list, and a key or index of it."""


def _places(node: Any) -> Sequence[Place]:
    keys = list(node) if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    return [place for key in keys for place in ((node, key), *_places(node[key]))]


def _odd(draw: Draw, places: Sequence[Place]) -> None:
    holder, key = draw.choice(places)
    holder[key] = draw.choice((*TEXTS, 0, -1, 1, True, 2**62, -0.0, 1e308, 5e-324, 0.5, [], {}, [[]], [""], {"": ""}))


def _other_unit(draw: Draw, places: Sequence[Place]) -> None:
    holder, key = draw.choice([(h, k) for h, k in places if isinstance(h[k], str) and h[k][:1].isdigit()] or places)
    number = str(holder[key]).partition(" ")[0]
    power = draw.choice(("", "", "e3", "e-3", "e9", "e-9", "e30", "e-30", "e300", "e-300"))
    holder[key] = f"{draw.choice(('', '-', '+'))}{number}{power} {draw.choice(UNITS)}"


def _scaled(draw: Draw, places: Sequence[Place]) -> None:
    numbers = [(h, k) for h, k in places if isinstance(h[k], int | float) and not isinstance(h[k], bool)]
    if numbers:
        holder, key = draw.choice(numbers)
        holder[key] = holder[key] * draw.choice((-1, 0, 1e-300, 1e-9, 1e3, 1e15, 10**18 if holder[key] < 9 else 1))


def _lookalike(draw: Draw, places: Sequence[Place]) -> None:
    holder, key = draw.choice(places)
    sign = draw.choice(list(LOOKALIKES))
    if isinstance(holder[key], str):
        holder[key] = holder[key].replace(sign, LOOKALIKES[sign])
    elif isinstance(key, str):
        holder[key.replace(sign, LOOKALIKES[sign])] = holder.pop(key)


def _removed(draw: Draw, places: Sequence[Place]) -> None:
    holder, key = draw.choice(places)
    del holder[key]


def _exchanged(draw: Draw, places: Sequence[Place]) -> None:
    (one, key), (other, other_key) = draw.choice(places), draw.choice(places)
    one[key], other[other_key] = deepcopy(other[other_key]), deepcopy(one[key])


def _renamed(draw: Draw, places: Sequence[Place]) -> None:
    holder, key = draw.choice([(h, k) for h, k in places if isinstance(k, str)] or places)
    names = [k for _, k in places if isinstance(k, str)] + [
        "",
        "x",
        "__class__",
        "model_config",
        "a b",
        "\n",
        "x" * 500,
    ]
    if isinstance(holder, dict):
        holder[draw.choice((*names, f"{key}s", key[::-1], key.upper()))] = holder.pop(key)


def _wrapped(draw: Draw, places: Sequence[Place]) -> None:
    holder, key = draw.choice(places)
    inner = holder[key]
    holder[key] = draw.choice(([inner], [inner, inner], {"value": inner}, {"values": [inner, inner]}, {"file": inner}))


def _many(draw: Draw, places: Sequence[Place]) -> None:
    holder, key = draw.choice(places)
    count = draw.choice((2, 10, 200, 5000))
    if isinstance(holder[key], str | list):
        holder[key] = (holder[key] * count)[: 20 * count]
    elif isinstance(holder, dict):
        holder.update({f"{key}{number}": 1 for number in range(count)})


_CHANGES: tuple[Callable[[Draw, Sequence[Place]], None], ...] = (
    *(_odd, _odd, _other_unit, _other_unit, _scaled, _lookalike),
    *(_removed, _exchanged, _renamed, _wrapped, _many),
)


def changed_lines(draw: Draw, text: str) -> bytes:
    """Change the lines of a document: values, order, quotes, signs, encoding."""
    lines = text.splitlines(keepends=True)
    for _ in few(draw):
        lines = draw.choice((_value, _value, _shuffled, _doubled, _dropped, _unquoted))(draw, lines)
    return _encoded(draw, "".join(lines))


def _value(draw: Draw, lines: list[str]) -> list[str]:
    at = draw.randrange(len(lines) + 1)
    key, sign, _ = lines[at].partition("=") if at < len(lines) else ("x", "=", "")
    return [*lines[:at], f"{key}{sign} {draw.choice(VALUES)}\n", *lines[at + 1 :]]


def _shuffled(draw: Draw, lines: list[str]) -> list[str]:
    first = draw.randrange(len(lines) + 1)
    part = lines[first : first + draw.randint(2, 10)]
    draw.shuffle(part)
    return [*lines[:first], *part, *lines[first + len(part) :]]


def _doubled(draw: Draw, lines: list[str]) -> list[str]:
    first = draw.randrange(len(lines) + 1)
    count = draw.choice((1, 1, 5))
    return [*lines[: first + count], *lines[first : first + count] * draw.choice((1, 1, 50)), *lines[first + count :]]


def _dropped(draw: Draw, lines: list[str]) -> list[str]:
    first = draw.randrange(len(lines) + 1)
    return lines[:first] + lines[first + draw.choice((1, 1, 5, 1000)) :]


def _unquoted(draw: Draw, lines: list[str]) -> list[str]:
    sign, other = draw.choice('"[]{}=.,#'), draw.choice(("", "'", '"', '"""', "[", "]", "=", "\0", "\x7f"))
    at = draw.randrange(len(lines) + 1)
    return [*lines[:at], *(line.replace(sign, other, 1) for line in lines[at : at + 1]), *lines[at + 1 :]]


def _encoded(draw: Draw, text: str) -> bytes:
    """Write a text most often as it should be, else in another encoding or with other line ends."""
    if draw.random() < 0.9:
        return text.encode("utf-8", "surrogatepass")
    if draw.random() < 0.5:
        return text.replace("\n", draw.choice(("\r", "\r\n", "\n\n", "\r\r\n", "\u2028", "\x85", " "))).encode()
    content = text.encode(draw.choice(ENCODINGS), "replace")
    return content[draw.choice((0, 0, 1)) :]


# --- tables ---


def changed_table(draw: Draw, content: bytes) -> bytes:
    """Change a text table: rows, columns, fields, separators, decimal signs, names, encoding; or pack it."""
    if draw.random() < 0.01:
        return gzip.compress(content, mtime=0)
    lines = content.decode("latin-1").splitlines(keepends=True)
    for _ in few(draw):
        lines = draw.choice(_TABLE_CHANGES)(draw, lines)
    return _encoded(draw, "".join(lines)) if draw.random() < 0.1 else "".join(lines).encode("latin-1", "replace")


def _separator(lines: list[str]) -> str:
    text = "".join(lines[-3:])
    return max(("\t", ";", ",", " "), key=text.count)


def _field(draw: Draw, lines: list[str]) -> list[str]:
    if not lines:
        return lines
    separator, at = _separator(lines), draw.randrange(len(lines))
    cells = lines[at].split(separator)
    cells[draw.randrange(len(cells))] = draw.choice(FIELDS)
    return [*lines[:at], separator.join(cells), *lines[at + 1 :]]


def _column(draw: Draw, lines: list[str]) -> list[str]:
    """Give a whole column another value, remove it, or exchange it with another."""
    separator, how = _separator(lines), draw.randrange(4)
    one, other, field = draw.randrange(8), draw.randrange(8), draw.choice(FIELDS)
    return [separator.join(_changed_row(line.split(separator), how, one, other, field)) for line in lines]


def _changed_row(cells: list[str], how: int, one: int, other: int, field: str) -> list[str]:
    if max(one, other) >= len(cells):
        return cells
    if how == 0:
        cells[one], cells[other] = cells[other], cells[one]
    elif how == 1:
        del cells[one]
    elif how == 2:
        cells[one:one] = [field]
    elif not any(map(str.isalpha, cells[one])):
        cells[one] = field
    return cells


def _other_separator(draw: Draw, lines: list[str]) -> list[str]:
    old, new = _separator(lines), draw.choice(SEPARATORS)
    some = draw.choice((0.0, 0.0, 0.5, 0.95))
    return [line if draw.random() < some else line.replace(old, new) for line in lines]


def _other_decimal(draw: Draw, lines: list[str]) -> list[str]:
    some = draw.choice((0.0, 0.0, 0.5, 0.95))
    exchange = str.maketrans(".,", ",.")
    return [line if draw.random() < some else line.translate(exchange) for line in lines]


def _broken_header(draw: Draw, lines: list[str]) -> list[str]:
    named = [at for at, line in enumerate(lines) if re.search("[A-Za-z]{2}", line)]
    if not named:
        return lines
    at = draw.choice(named)
    word = draw.choice(re.findall(r"\w+", lines[at]) or [""])
    new = draw.choice((*FIELDS, *UNITS, "Time [s]", "depth", "Depth [um]", "9" * 20, str(2**60), "-1"))
    return [*lines[:at], lines[at].replace(word, new, 1), *lines[at + 1 :]]


def _repeated(draw: Draw, lines: list[str]) -> list[str]:
    """Repeat the text of a line within it, so that it has very many fields or one long one."""
    if not lines:
        return lines
    at = draw.randrange(len(lines))
    bare = lines[at].rstrip("\r\n")
    return [*lines[:at], (bare * draw.choice((2, 50, 2000)))[:_LONGEST_LINE] + lines[at][len(bare) :], *lines[at + 1 :]]


_TABLE_CHANGES: tuple[Callable[[Draw, list[str]], list[str]], ...] = (
    *(_field, _field, _field, _column, _column, _shuffled, _doubled, _dropped),
    *(_other_separator, _other_decimal, _broken_header, _broken_header, _repeated),
)
