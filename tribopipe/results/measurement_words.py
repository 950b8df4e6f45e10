"""Post-test measurements in words, from their keys under ``[end_values]``."""

import re

from tribopipe.documents.contact_kinds import spoken

_KEY = re.compile(
    r"(?P<body>\w+?)_"
    r"(?P<measured>wear_depth|wear_volume|mass_loss|profile|track_width|scar_diameter|scar_length|scar_width)"
)


def measured_quantity(key: str) -> str:
    """Return what was measured: "scar diameter" for ``pin_scar_diameter``."""
    match = _KEY.fullmatch(key)
    return spoken(match["measured"] if match else key)


def measured_quantities(anchor: str) -> str:
    """Return measurements, joined by " + ", with their bodies: "scar diameter of the pin and profile of the disc"."""
    return " and ".join(map(_with_body, anchor.split(" + ")))


def _with_body(key: str) -> str:
    match = _KEY.fullmatch(key)
    return f"{spoken(match['measured'])} of the {spoken(match['body'])}" if match else spoken(key)
