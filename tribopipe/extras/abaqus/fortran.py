"""Fixed-form Fortran: numbers that are read back to the last digit, comments, and lines that fit on a card."""

import textwrap
from collections.abc import Iterable
from functools import partial

from tribopipe.base.units import WEAR_COEFFICIENT, from_si

CARD = 72
"""Columns that a compiler reads."""


def literal(value: float) -> str:
    """Write a double precision constant: the shortest that is read back as the same number."""
    mantissa, _, power = repr(float(value)).partition("e")
    return f"{mantissa if '.' in mantissa else mantissa + '.0'}D{int(power or 0)}"


_MM = {"m": "mm", "Pa": "MPa", "m/s": "mm/s", "m^2/N": WEAR_COEFFICIENT}


def in_mm(value: float, si_unit: str) -> float:
    """Convert from SI to mm, N, MPa and s; a number stated in decimal keeps its digits."""
    return float(f"{from_si(value, si_unit, _MM[si_unit]):.15g}")


def number_in_mm(value: float, si_unit: str) -> str:
    """Write a constant in mm, N, MPa and s."""
    return literal(in_mm(value, si_unit))


def comment(paragraphs: Iterable[str], sign: str = "C     ") -> str:
    """Write paragraphs as comment lines, with an empty one between them; ASCII, with ? for what is missing."""
    wrap = partial(textwrap.wrap, width=CARD, initial_indent=sign, subsequent_indent=sign, break_on_hyphens=False)
    return f"\n{sign.rstrip()}\n".join("\n".join(wrap(_plain(paragraph))) for paragraph in paragraphs) + "\n"


def _plain(text: str) -> str:
    return text.translate(_SPELLED).encode("ascii", "replace").decode("ascii")


_SPELLED = str.maketrans(
    {"·": " ", "×": "x", "−": "-", "–": "-", "±": "+/-", "μ": "mu", "µ": "u", "³": "^3", "²": "^2", "ν": "nu"}
)
