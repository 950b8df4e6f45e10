"""The vocabulary of measured signals: every column tribopipe gives a meaning to."""

from typing import Literal, NamedTuple, get_args

from tribopipe.base.units import KINDS

SignalName = Literal[
    "time",
    "rotations",
    "sliding_distance",
    "sliding_speed",
    "normal_force",
    "friction_force",
    "friction_coefficient",
    "depth",
    "temperature",
    "relative_humidity",
]


class Signal(NamedTuple):
    """One measured signal: its kind of number and what it means."""

    kind: str
    meaning: str

    @property
    def unit(self) -> str:
        """SI unit of the column."""
        return KINDS[self.kind].si

    @property
    def axis(self) -> str:
        """Label of an axis in viewers of HDF5, which show no unit next to it."""
        return self.meaning if self.unit == "1" else f"{self.meaning} ({self.unit})"


SIGNALS: dict[SignalName, Signal] = {
    "time": Signal("time", "time since the start of the test"),
    "rotations": Signal(
        "count", "rotations of the (crowned) disc or ring, or reciprocating cycles, since the start of the test"
    ),
    "sliding_distance": Signal("distance", "sliding distance since the start of the test"),
    "sliding_speed": Signal("speed", "relative speed of the two surfaces"),
    "normal_force": Signal("force", "normal load between the two bodies"),
    "friction_force": Signal("force", "force along the direction of sliding"),
    "friction_coefficient": Signal("ratio", "friction force over normal force"),
    "depth": Signal("length", "signal of the displacement sensor: wear of both bodies, offset and drift"),
    "temperature": Signal("temperature", "temperature at the test rig"),
    "relative_humidity": Signal("percentage", "relative humidity at the test rig"),
}
AXES: tuple[SignalName, ...] = ("time", "rotations", "sliding_distance")
"""Signals that grow during a test: axes of the others."""
SENSED: tuple[SignalName, ...] = ("depth", "normal_force", "friction_force", "temperature", "relative_humidity")
"""Signals that a sensor of their own reads."""

if set(SIGNALS) != set(get_args(SignalName)):
    raise AssertionError("SIGNALS and SignalName list different signals")
