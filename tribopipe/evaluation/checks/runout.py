"""Check of the unit of time by the runout of a rotating test: its frequency is that of the stated speed."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tribopipe.base.arrays import Column
from tribopipe.documents.signals import SignalName
from tribopipe.evaluation.checks.registry import Trouble, check
from tribopipe.physics.axis_faults import continuous
from tribopipe.results.run import RawRun

_UNITS = (60.0, 1 / 60, 1000.0, 1 / 1000)
"""Factors by which a frequency is off where time is in min, s or ms, and read as another one of these."""
_NEAR = 0.01
"""Relative difference within which a frequency is such a multiple."""
_MAINS = (50.0, 60.0, 100.0, 120.0)
"""Hz: frequencies that come from the mains."""
_FEWEST, _MOST = 256, 2**14
_AROUND = 50
"""Frequencies on each side by which the noise at one is known."""
_LINE, _NO_LINE = 100.0, 20.0
"""Power over that of the noise from which on a frequency is that of a motion, and up to which it is that of noise."""


class _Spectrum(NamedTuple):
    """Power over that of the noise, by multiples of the lowest frequency, Hz."""

    lowest: float
    power: Column

    @property
    def highest(self) -> int:
        """Multiple with the largest power, of those that no wander of the signal reaches."""
        return _AROUND + int(np.argmax(self.power[_AROUND:]))

    def at(self, frequency: float) -> float:
        """Return the power near a frequency, Hz; 0 beyond those that were sampled."""
        place = frequency / self.lowest
        near = self.power[max(0, int(place) - 1) : int(place) + 3] if place < len(self.power) else np.empty(0)
        return float(np.max(near, initial=0.0))


@check("warning")
def runout_differs(run: RawRun) -> Iterator[Trouble]:
    """Find runout at a frequency that the stated speed would have if time were in another unit: min read as s."""
    conditions, time = run.manifest.conditions, run.columns["time"]
    speed, cycle = conditions.nominal_speed, conditions.cycle
    if speed is None or cycle is None or conditions.stroke is not None or run.origins["time"] != "measured":
        return
    names: tuple[SignalName, ...] = ("depth", "friction_force", "friction_coefficient")
    expected = speed.value / cycle
    for name in names:
        recorded = name in run.columns and run.origins[name] == "measured"
        spectrum = _spectrum(time, run.columns[name]) if recorded else None
        if spectrum is not None and _in_another_unit(spectrum, expected):
            yield Trouble(
                "time",
                f"found that {name} varies periodically at {spectrum.highest * spectrum.lowest:.4g} Hz; expected "
                f"{expected:.4g} Hz, the rotational frequency calculated from the stated speed and track radius",
                "check the unit of the time column (min, s or ms) and the speed, from which the distance is computed",
            )
            return


def _spectrum(time: Column, values: Column) -> _Spectrum | None:
    """Return the power of a signal; None if it is too short or not evenly sampled."""
    count = min(len(values), _MOST)
    seen, place = values[:count], np.arange(count)
    clock = continuous(time)[:count]
    if count < _FEWEST or not np.all(np.isfinite(seen)) or not clock[-1] > clock[0]:
        return None
    step = float(clock[-1] - clock[0]) / (count - 1)
    if np.max(np.abs(clock - clock[0] - step * place)) > step:
        return None
    level = seen - np.polyval(np.polyfit(place, seen, 1), place)
    power = np.abs(np.fft.rfft(level * np.hanning(count))) ** 2
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(power, _AROUND, mode="reflect"), 2 * _AROUND + 1)
    noise = np.median(windows, axis=-1)
    above = np.divide(power, noise, out=np.zeros_like(power), where=noise > 0)
    above[: _AROUND // 10] = 0.0  # drift and wear
    return _Spectrum(1 / (count * step), above)


def _is_alias(spectrum: _Spectrum, frequency: float) -> bool:
    """Return whether the highest line is that of a frequency, known to half of _NEAR, which is sampled too slowly."""
    found, sampled = spectrum.highest * spectrum.lowest, 2 * len(spectrum.power) * spectrum.lowest
    misses = [(found - one + sampled / 2) % sampled - sampled / 2 for one in (frequency, -frequency)]
    return min(map(abs, misses)) < _NEAR / 2 * frequency + spectrum.lowest


def _in_another_unit(spectrum: _Spectrum, expected: float) -> bool:
    """Return whether a signal repeats at a frequency that is wrong by a unit of time, and not at the expected one."""
    found = spectrum.highest * spectrum.lowest
    near = max(_NEAR, 1 / max(1, spectrum.highest))
    by_unit = any(abs(found / (expected * unit) - 1) < near for unit in _UNITS)
    by_mains = any(abs(found / mains - 1) < near for mains in _MAINS)
    clear = spectrum.power[spectrum.highest] > _LINE and spectrum.at(expected) < _NO_LINE
    return by_unit and clear and not by_mains and not _is_alias(spectrum, expected)
