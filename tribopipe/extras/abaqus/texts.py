"""The files: the subroutine, the step for an input file, a harness that drives the subroutine, and what to know."""

import math
from collections.abc import Mapping
from importlib.resources import files
from itertools import chain
from string import Template
from typing import Literal

from tribopipe.extras.abaqus import explanations as told
from tribopipe.extras.abaqus.case import WearCase
from tribopipe.extras.abaqus.example import Example
from tribopipe.extras.abaqus.fortran import comment, in_mm, literal, number_in_mm
from tribopipe.extras.abaqus.motions import README
from tribopipe.physics.friction_path import ExponentialFriction

Jtyp = Literal["0", "1", "none"]
"""How GETVRMAVGATNODE averages at a node; none leaves the argument out."""
_MARGIN = 1.5
"""Increments allowed, over those that the longest stable ones take."""
_FINEST = 1e-3
"""Shortest increment allowed, over the longest."""
_INCREMENTS = 3
"""Driven in the example."""


def texts(case: WearCase, jtyp: Jtyp = "0") -> dict[str, str]:
    """Return every file by its name, in mm, N, MPa and s, all ASCII and no line longer than a card."""
    average = {
        "jtyp_value": "" if jtyp == "none" else f"      JTYP = {jtyp}\n",
        "jtyp_argument": "" if jtyp == "none" else "JTYP,",
    }
    nodes = case.motion.example
    found = {
        told.SUBROUTINE: _subroutine(case, average),
        told.STEP: _step(case),
        README: _readme(case),
        "harness/harness.f": _filled("harness.f", average),
        "harness/ABA_PARAM.INC": _filled("ABA_PARAM.INC"),
        "harness/pressures.txt": _pressures(case, nodes),
    }
    return found | ({"harness/streamlines.dat": _streamlines(nodes)} if case.motion.on_lines else {})


def _filled(template: str, values: Mapping[str, str] | None = None) -> str:
    text = files("tribopipe.extras.abaqus").joinpath("templates", template).read_text(encoding="ascii")
    return Template(text).substitute(values or {})


def _subroutine(case: WearCase, average: Mapping[str, str]) -> str:
    words = told.law_told(case), told.increments_told(case), told.use_told(case)
    parts = [
        comment([told.title(case, "Wear"), told.HONEST, *chain.from_iterable(words)]),
        "C\n",
        _filled(case.motion.template, _numbers(case) | _law(case)),
        _filled("control.f"),
        *map(_filled, case.motion.further_templates),
        _filled("pressure.f", average),
    ]
    return "".join(parts)


def _numbers(case: WearCase) -> dict[str, str]:
    return {
        "wear_coefficient": number_in_mm(case.known.coefficient.value, "m^2/N"),
        "speed": number_in_mm(case.speed, "m/s"),
        "turns": literal(case.motion.turns),
        "contact_length": number_in_mm(2 * case.start.half_length, "m"),
        "modulus": number_in_mm(case.modulus, "Pa"),
        "element": number_in_mm(case.element, "m"),
    }


def _law(case: WearCase) -> dict[str, str]:
    if case.friction is None:
        return {"law_parameters": "", "law": "", "largest_factor": ""}
    return {"law_parameters": _friction(case, case.friction), "law": _filled("sarkar.f"), "largest_factor": "*FMAX"}


def _friction(case: WearCase, friction: ExponentialFriction) -> str:
    template, speed = case.motion.speed_template, {"speed": number_in_mm(case.speed, "m/s")}
    numbers = {
        "slip_speed": _filled(template, speed) if template else "",
        "amplitude": literal(float(friction.amplitude)),
        "steady_state": literal(float(friction.steady_state)),
        "running_in_distance": number_in_mm(float(friction.running_in_distance), "m"),
        "largest_factor": literal(case.largest_factor),
    }
    return _filled("sarkar_parameters.f", numbers)


def _step(case: WearCase) -> str:
    head = (told.title(case, "Wear step"), told.HONEST, *told.step_told(case), *told.increments_told(case))
    longest = _cut_off(case.step_limit)
    numbers = {
        "most_increments": f"{math.ceil(case.increments * _MARGIN) + 1}",
        "longest_increment": longest,
        "duration": f"{case.duration:.9g}",
        "shortest_increment": _cut_off(case.step_limit * _FINEST),
    }
    return comment(head, sign="** ") + _filled("step.inp", numbers)


def _cut_off(number: float) -> str:
    """Write a number with four digits, never more than it is."""
    mantissa, _, power = f"{number:.15e}".partition("e")
    return f"{mantissa[:5]}e{power}"


def _readme(case: WearCase) -> str:
    rate = case.known.coefficient.value * case.motion.dose * case.factor(case.speed * case.step_limit / 2)
    words = (
        told.files_told(),
        told.law_told(case),
        told.increments_told(case),
        told.use_told(case),
        told.drive_told(case, rate * case.step_limit),
    )
    return comment([told.title(case, "UMESHMOTION"), told.HONEST, *chain.from_iterable(words)], sign="")


def _pressures(case: WearCase, nodes: Example) -> str:
    labels = [str(number) for number in range(1, nodes.pressure.size + 1)]
    pressures = [repr(in_mm(float(pressure), "Pa")) for pressure in nodes.pressure]
    increment = [repr(case.step_limit), *pressures]
    rows = [f"{len(labels)} {_INCREMENTS} {case.motion.drives}", *labels, *(increment * _INCREMENTS)]
    return "".join(f"{row}\n" for row in rows)


def _streamlines(nodes: Example) -> str:
    rows = [
        f"{number} {line} {in_mm(float(length), 'm')!r}"
        for number, (line, length) in enumerate(zip(nodes.streamline, nodes.length, strict=True), 1)
    ]
    return "".join(f"{row}\n" for row in (str(len(rows)), *rows))
