"""What names of files seem to say of the conditions: "9-Al10Cu-50N-140m-328rpm". Nobody's word, so never taken."""

import re
from collections.abc import Iterable
from pathlib import PurePath

from tribopipe.readers.draft.known_values import LOAD, Known

# A number with its unit; none behind a digit and a dash, which may be a decimal sign: "0-3N".
_HINT = re.compile(r"(?<![\d.,])(?<!\d[-_])(\d+(?:[.,]\d+)?) ?(mN|kN|N|rpm|mm/s|m/s|Hz)(?![A-Za-z0-9])")
_KEYS = {
    **dict.fromkeys(("mN", "kN", "N"), LOAD),
    **dict.fromkeys(("mm/s", "m/s"), "conditions.sliding_speed"),
    "rpm": "conditions.rotational_speed",
    "Hz": "conditions.frequency",
}


def doubt_names(known: Known, names: Iterable[str]) -> None:
    """Note as doubts what names of files, where they agree, seem to say of what is not known."""
    seen: dict[str, set[str]] = {}
    for name in names:
        for number, unit in _HINT.findall(PurePath(name).stem):
            seen.setdefault(_KEYS[unit], set()).add(f"{number.replace(',', '.')} {unit}")
    for key, values in seen.items():
        value = next(iter(values))
        if len(values) == 1 and key not in known.given and known.fits(key, value):
            known.doubt(key, value, "the name of the file seems to say so")
