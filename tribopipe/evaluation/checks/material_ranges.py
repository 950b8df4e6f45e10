"""Classes of materials by name, with the ranges that modulus, density and hardness lie in, and typical values.

Ranges are those of M. F. Ashby, Materials Selection in Mechanical Design (4th ed., 2011), Appendix A, and of ASM
Handbook, Vol. 18 (2017), rounded outwards so that porous, filled and coated grades lie within: they are to find a wrong
unit or a digit too many, not to judge a material. Typical values are those of dense, unfilled grades.
"""

import re
from typing import NamedTuple

LIGHTEST_SOLID, DENSEST_SOLID = 30.0, 23_000.0
"""kg/m³: lighter than any foam a specimen is made of; denser than osmium (22 590)."""
Range = tuple[float, float]


class MaterialClass(NamedTuple):
    """A class of materials: how it is called, what its names look like, and its ranges."""

    title: str
    names: str
    """Regular expression of its names, in small letters."""
    modulus: Range
    """Young's modulus, GPa."""
    density: Range
    """g/cm³."""
    hardness: Range | None = None
    """Vickers hardness HV; None if it has no meaning."""


_STEEL = (
    r"steel|stahl|\b1\.[2-4]\d{3}\b"
    r"|\b(x?\d{1,3}cr|aisi|sae|suj|gcr15|en ?31\b|m50|m2\b|440c|316l?|304l?|52100|42crmo|c45|s[23]\d5|st ?\d\d)"
)
_ALUMINIUM = r"\balumini?um\b(?! ?(oxide|nitride|bronze))|\b(al|aa|en aw|aw)[- ]?[2-7]\d{3}|\balsi|\balmg|\balcu|\balzn"
CLASSES = (
    MaterialClass("silicon nitride", r"si3n4|silicon nitride|sialon", (150, 340), (2.3, 3.6), (800, 2200)),
    MaterialClass(
        "alumina", r"al2o3|alumina\b|alumini?um oxide|corundum|sapphire", (200, 480), (3.2, 4.1), (900, 2800)
    ),
    MaterialClass("zirconia", r"zro2|zirconia|tzp", (150, 270), (5.3, 6.3), (900, 1600)),
    MaterialClass("silicon carbide", r"\bs?s?i?sic\b|silicon carbide", (240, 490), (2.5, 3.3), (1500, 3500)),
    MaterialClass(
        "cemented carbide", r"\bwc\b|tungsten carbide|cemented carbide|hard ?metal", (250, 750), (9.5, 16), (500, 2800)
    ),
    MaterialClass("boron carbide", r"\bb4c\b|boron carbide", (350, 490), (2.3, 2.6), (2400, 4200)),
    MaterialClass("diamond-like carbon", r"\bdlc\b|diamond[- ]like|\bt?a-c\b", (30, 900), (0.9, 8.3), (300, 9000)),
    MaterialClass("diamond", r"\bdiamond\b(?![- ]like)|\bpcd\b", (600, 1300), (3.2, 4.2), (4000, 15000)),
    MaterialClass("cast iron", r"cast iron|\bgg-?\d\d|\bgj[lsv]\b|en-gj", (60, 190), (6.7, 7.6), (100, 950)),
    MaterialClass("steel", _STEEL, (175, 240), (7.4, 8.4), (80, 1100)),
    MaterialClass("cobalt-chromium alloy", r"\bco-?cr|stellite", (185, 265), (7.7, 9.3), (180, 1000)),
    MaterialClass(
        "copper alloy", r"bronze|brass|copper|\bcu(sn|zn|al|pb|ni|be)|\bal10cu", (65, 155), (5.8, 9.4), (30, 450)
    ),
    MaterialClass("aluminum alloy", _ALUMINIUM, (60, 110), (2.5, 3.0), (15, 260)),
    MaterialClass(
        "titanium alloy", r"\bti-?6al|titanium(?! ?(nitride|carbide))|\bcp-?ti\b", (50, 130), (4.2, 5.0), (60, 500)
    ),
    MaterialClass(
        "glass", r"\bglass\b|bk7|soda[- ]lime|silica|borosilicate|quartz", (45, 115), (2.0, 4.0), (300, 1200)
    ),
    MaterialClass("PTFE", r"ptfe|teflon|polytetrafluor", (0.2, 4), (1.6, 4.0), (1, 15)),
    MaterialClass("PEEK", r"peek\b|polyether ?ether", (2, 30), (1.2, 1.8), (15, 60)),
    MaterialClass("polyamide", r"\bpa-?(6|11|12|46|66)|nylon|polyamide(?!-?imide)", (0.4, 20), (1.0, 1.8), (4, 35)),
    MaterialClass("polyethylene", r"(u?hmw-?|hd)pe\b|polyethylene", (0.1, 2.5), (0.9, 1.3), (2, 12)),
    MaterialClass("PPS", r"\bpps\b|polyphenylene sul", (2, 30), (1.2, 2.2), (10, 60)),
    MaterialClass("POM", r"\bpom\b|acetal|delrin|polyoxymethylene", (1.0, 14), (1.3, 1.8), (8, 35)),
    MaterialClass("rubber", r"rubber|elastomer|\b(h?nbr|fkm|epdm|sbr|pdms)\b|silicone", (1e-4, 0.3), (0.8, 2.5)),
)
"""A name that fits several, such as PPS with PTFE, may have the numbers of any of them."""


class Typical(NamedTuple):
    """Typical properties of a class of materials."""

    modulus: float
    """Young's modulus, GPa."""
    poisson_ratio: float
    density: float
    """g/cm³."""


_TYPICAL = {
    "silicon nitride": Typical(305, 0.27, 3.2),
    "alumina": Typical(380, 0.22, 3.9),
    "zirconia": Typical(205, 0.31, 6),
    "silicon carbide": Typical(410, 0.17, 3.15),
    "cemented carbide": Typical(620, 0.22, 14.9),
    "boron carbide": Typical(450, 0.17, 2.5),
    "diamond": Typical(1100, 0.1, 3.5),
    "cast iron": Typical(120, 0.26, 7.2),
    "steel": Typical(210, 0.3, 7.85),
    "cobalt-chromium alloy": Typical(230, 0.3, 8.4),
    "copper alloy": Typical(110, 0.34, 8.6),
    "aluminum alloy": Typical(71, 0.33, 2.75),
    "titanium alloy": Typical(114, 0.34, 4.43),
    "glass": Typical(70, 0.21, 2.4),
    "PTFE": Typical(0.5, 0.46, 2.2),
    "PEEK": Typical(3.7, 0.4, 1.3),
    "polyamide": Typical(2.5, 0.4, 1.14),
    "polyethylene": Typical(0.8, 0.46, 0.94),
    "PPS": Typical(3.6, 0.38, 1.35),
    "POM": Typical(2.9, 0.38, 1.41),
}
"""By the title of the class; the members of the others differ too much."""
_FILLED = re.compile(r"\+|%|[cg]f ?\d|\d ?[cg]f\b|\b[cg]f\b|fill|fib(er|re)|composite|coat")
"""What names of materials have that are not those of their class alone."""

_SUBSCRIPTS = str.maketrans("₀₁₂₃₄₅₆₇₈₉", "0123456789")


class Expected(NamedTuple):
    """Expected properties of a material."""

    title: str
    modulus: Range
    density: Range
    hardness: Range | None


def expected_of(material: str) -> Expected | None:
    """Return the ranges for a material as a lab calls it, such as "Si₃N₄"; None for an unknown name."""
    found = _classes(material)
    if not found:
        return None
    hardness = [one.hardness for one in found if one.hardness is not None]
    return Expected(
        " or ".join(one.title for one in found),
        _union([one.modulus for one in found]),
        _union([one.density for one in found]),
        _union(hardness) if len(hardness) == len(found) else None,
    )


def typical_of(material: str) -> tuple[str, Typical] | None:
    """Return the class of a material as a lab calls it, and what is typical of it.

    None for an unknown name, for one that fits several classes, and for filled and coated materials.
    """
    titles = [one.title for one in _classes(material)]
    if len(titles) != 1 or titles[0] not in _TYPICAL or _FILLED.search(material.lower()):
        return None
    return titles[0], _TYPICAL[titles[0]]


def _classes(material: str) -> list[MaterialClass]:
    name = material.translate(_SUBSCRIPTS).lower()
    return [one for one in CLASSES if re.search(one.names, name)]


def _union(ranges: list[Range]) -> Range:
    return min(low for low, _ in ranges), max(high for _, high in ranges)
