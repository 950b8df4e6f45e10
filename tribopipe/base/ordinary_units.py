"""Units that most recordings have, in SI: with these alone, a run is read without loading the library of all units.

Each is what that library, pint, makes of it, to the last digit.
"""

from collections.abc import Mapping

_IN_SI: Mapping[str, Mapping[str, str]] = {
    "": {"%": "0.01", "count": "1"},
    "[length]^1": {"m": "1", "cm": "0.01", "mm": "0.001", "um": "0.000001", "nm": "1E-9", "km": "1E+3", "in": "0.0254"},
    "[length]^2": {"m^2": "1", "mm^2": "0.000001", "um^2": "1E-12"},
    "[length]^3": {"m^3": "1", "mm^3": "1E-9", "um^3": "1E-18"},
    "[time]^1": {"s": "1", "ms": "0.001", "min": "60", "h": "3600"},
    "[length]^1 [time]^-1": {"m/s": "1", "mm/s": "0.001", "m/min": "0.01666666666666666666666666667"}
    | {"nm/min": "1.666666666666666666666666667E-11"},
    "[time]^-1": {"Hz": "1", "1/s": "1", "rad/s": "1", "rpm": "0.1047197551196597746154214461"},
    "[mass]^1": {"kg": "1", "g": "0.001", "mg": "0.000001", "ug": "1E-9"},
    "[length]^-3 [mass]^1": {"kg/m^3": "1", "g/cm^3": "1E+3"},
    "[length]^1 [mass]^1 [time]^-2": {"N": "1", "mN": "0.001", "kN": "1E+3"},
    "[length]^2 [mass]^1 [time]^-2": {"N*m": "1", "mN*m": "0.001", "N*mm": "0.001", "N*cm": "0.01"},
    "[length]^-1 [mass]^1 [time]^-2": {"Pa": "1", "kPa": "1E+3", "MPa": "1E+6", "GPa": "1E+9"},
    "[length]^-0.5 [mass]^1 [time]^-2": {"Pa*m^0.5": "1", "MPa*m^0.5": "1E+6"},
    "[length]^1 [mass]^-1 [time]^2": {"m^2/N": "1", "mm^2/N": "0.000001", "mm^3/(N*mm)": "0.000001"}
    | {"mm^3/(N*m)": "1E-9"},
    "[temperature]^1": {"K": "1", "degC": "1"},
    "[current]^-1 [length]^2 [mass]^1 [time]^-3": {"V": "1", "mV": "0.001"},
}
"""SI value of one, by dimension and unit."""
ORDINARY = {unit: (dimension, value) for dimension, units in _IN_SI.items() for unit, value in units.items()}
"""Dimension and SI value of one, by unit."""
OFFSETS: Mapping[str, str] = {"degC": "273.15"}
"""SI value of zero, where that is not zero."""
