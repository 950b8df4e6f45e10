"""What the columns of tables mean, by their names."""

from collections.abc import Mapping

from tribopipe.documents.signals import SIGNALS
from tribopipe.physics.laws import LAWS, law_title

_ENDS: Mapping[str, str] = {
    "_lower": "lower end of the 95 % band of",
    "_upper": "upper end of the 95 % band of",
    "_errors": "standard uncertainty of",
}
_MEANINGS: Mapping[str, str] = {
    **{name: signal.meaning for name, signal in SIGNALS.items()},
    "wear_depth": "wear of both bodies, corrected for drift, or by a wear law",
    "pin_wear_depth": "the pin's part of the wear",
    "fitted_friction_coefficient": "friction coefficient by the exponential fit",
    **{law: f"wear by {law_title(law)}" for law in LAWS},
    "curved_depth": "wear depth of the crowned disc",
    "flat_depth": "wear depth of the cylindrical disc",
    "curved_volume": "wear volume of the crowned disc",
    "flat_volume": "wear volume of the cylindrical disc",
    "half_width": "half axis of the contact across rolling",
    "half_length": "half axis of the contact along rolling",
    "pressure": "contact pressure",
    "measured": "measured wear",
    "predicted": "wear by the law",
    "lower": "lower end of the 95 % band of the prediction",
    "upper": "upper end of the 95 % band of the prediction",
    "measurement": "the measurement",
    "position": "place across the wear",
    "height": "height, upwards out of the body",
    "radius": "distance from the middle of the contact",
    "across": "place across rolling",
    "along": "place along rolling",
    "wear": "depth worn at a place",
    "gap": "gap between the unworn surfaces",
}


def meaning(column: str) -> str | None:
    """Return what a column holds, by its name without unit; none for those that only the instrument knows."""
    if column in _MEANINGS:
        return _MEANINGS[column]
    for end, said in _ENDS.items():
        if column.endswith(end) and column.removesuffix(end) in _MEANINGS:
            return f"{said} {_MEANINGS[column.removesuffix(end)]}"
    return None
