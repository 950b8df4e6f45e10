"""The files that are written: the subroutine, the step for an input file, a harness, and their explanations.

The texts in them state the law, k_D and its source, the longest increments, and how to use them.
"""

import math
from collections.abc import Iterator, Mapping
from importlib.resources import files
from itertools import chain
from string import Template
from typing import Literal

from tribopipe.documents.contact import Specimen
from tribopipe.documents.quantity import Quantity
from tribopipe.extras.abaqus.case import README, Example, WearCase
from tribopipe.extras.abaqus.fortran import comment, in_mm, literal, number_in_mm
from tribopipe.physics.friction_path import ExponentialFriction
from tribopipe.version import VERSION

SUBROUTINE, STEP = "umeshmotion.f", "umeshmotion.inp"
HONEST = (
    "NOT RUN IN ABAQUS. Subroutines from this template were compiled with gfortran and run with the harness next to "
    "this file; their increments were compared with those of the contact solver of tribopipe. No other tests were run."
)
_K_D = "mm^3/(N mm)"


def title(case: WearCase, what: str) -> str:
    """Return the title of a file: its content, its run and the version that wrote it."""
    return f"{what} of run {case.known.run_id}, written by tribopipe {VERSION}. Units: mm, N, MPa, s."


def law_lines(case: WearCase) -> Iterator[str]:
    """Give the wear law and the k_D of the nodes."""
    factor = "" if case.friction is None else " sqrt(1 + 3 mu^2)"
    yield f"{case.law.title()}'s law: a node recedes at {case.motion.rate}{factor}."
    yield f"k_D = {_stated(case.known.coefficient)}. {case.known.origin}"
    yield from (f"Note: {note}" for note in (*case.contact.limits, *case.known.notes))
    if case.friction is not None:
        yield (
            f"mu(s) = A exp(-s/c) + b with A = {case.friction.amplitude:.6g}, b = {case.friction.steady_state:.6g} and "
            f"c = {in_mm(float(case.friction.running_in_distance), 'm'):.6g} mm, at the sliding distance in the "
            "middle of the increment: TIME(1) is assumed to be the step time at the end of the increment."
        )
    if case.motion.words:
        yield case.motion.words


def _stated(coefficient: Quantity) -> str:
    value, spread = in_mm(coefficient.value, "m^2/N"), coefficient.standard_uncertainty
    if spread is None:
        return f"{value:.6g} {_K_D}, with unknown standard uncertainty"
    return f"{value:.6g} {_K_D} with a standard uncertainty of {in_mm(spread, 'm^2/N'):.2g} {_K_D}"


def increments_lines(case: WearCase) -> Iterator[str]:
    """Give the longest stable increment, as a formula and with its values."""
    factors = ["WK", "EC", *case.motion.factors, *(["FMAX"] if case.friction else [])]
    numbers = [f"HEL = {in_mm(case.element, 'm'):.4g} mm", f"EC = {in_mm(case.modulus, 'Pa'):.6g} MPa"]
    numbers += case.motion.numbers
    numbers += [f"FMAX = {case.largest_factor:.4g}"] if case.friction else []
    yield (
        "Increments: the mesh is moved explicitly, so the pressure develops a checkerboard pattern unless DTIME "
        f"<= 1.2 h_el/(k_D E_c v), here 1.2 HEL/({' '.join(factors)}). With {', '.join(numbers)}, the limit is "
        f"{case.step_limit:.4g} s, or {math.ceil(case.increments):,} increments in the {case.duration:.6g} s of the "
        "test. PNEWDT keeps increments below this limit; set HEL to the element size of your mesh."
    )


def use_lines(case: WearCase) -> Iterator[str]:
    """Give the requirements of the subroutine on the model."""
    yield (
        "Use: *ADAPTIVE MESH CONSTRAINT, TYPE=VELOCITY, USER on the nodes of the wearing surface, which must be the "
        "slave (secondary) surface of the contact, where CSTRESS is available. UREF is not used, since its "
        "value may be ramped during a step."
    )
    if case.motion.use:
        yield case.motion.use
    yield (
        "At corners and edges of the mesh domain (LNODETYPE 3 and 4), such as the node on the axis, check the "
        "direction in which nodes move: ABAQUS chooses the local directions there."
    )


def step_lines(case: WearCase) -> Iterator[str]:
    """Give the requirements of the step on the model."""
    body = _wearing(case)
    modulus = in_mm(case.modulus * (1 - body.poisson_ratio.value**2), "Pa")
    yield (
        "Apply the load in an earlier step, and keep the load constant in this one. Define two sets: WEAR_MESH, the "
        "solid elements of the adaptive mesh domain, and WEAR_NODES, the nodes of the wearing surface. The time "
        "period of this step is the duration of the test."
    )
    yield (
        f"If the counterbody is rigid in your model, set the wearing body to E = {modulus:.6g} MPa, which is E_c (1 "
        f"- nu^2) with its Poisson's ratio nu = {body.poisson_ratio.value:g}, so that the contact is as stiff as that "
        "of both bodies."
    )


def _wearing(case: WearCase) -> Specimen:
    return case.contact.bodies[case.contact.fitted_bodies[0]]


def files_lines() -> Iterator[str]:
    """List the files."""
    yield f"{SUBROUTINE}: the subroutine; on Windows, rename it to umeshmotion.for."
    yield f"{STEP}: the step to include in the input file."
    yield "harness: runs the subroutine without ABAQUS; never copy its ABA_PARAM.INC to a job folder."


def run_lines(case: WearCase, first_wear: float) -> Iterator[str]:
    """Give the commands for job and harness, and the output expected from the harness."""
    yield "In ABAQUS:"
    yield f"  abaqus job=NAME user={SUBROUTINE}{case.motion.arguments}"
    yield "Without ABAQUS, in the folder harness:"
    yield "  gfortran -Wall -Wextra -Wno-unused-dummy-argument harness.f"
    yield "  ./a.out < pressures.txt"
    yield (
        "This prints PNEWDT and the wear of each node in mm, one line per increment, under the pressure of the unworn "
        f"contact: {in_mm(first_wear, 'm'):.6g} mm at the first node in the first increment. The disabled warning "
        "concerns unused arguments of UMESHMOTION, whose argument list is prescribed by ABAQUS."
    )
    yield (
        "If nothing wears, check that the surface is the slave surface and that its nodes are in the mesh domain: the "
        "utility routine does not distinguish zero pressure from unavailable pressure."
    )
    yield (
        "ABAQUS does not solve the contact again after moving the mesh. For twin discs, the wear was 11 % lower than "
        "with a new solution, and the difference increased with wear. It disappears if the mesh nodes are moved by "
        "the accumulated wear and the analysis is continued in another step (Figs. 10 and 11 of the paper)."
    )
    if case.motion.data:
        yield case.motion.data


Jtyp = Literal["0", "1", "none"]
"""Averaging argument of GETVRMAVGATNODE; none omits it."""
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
        SUBROUTINE: _subroutine(case, average),
        STEP: _step(case),
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
    words = law_lines(case), increments_lines(case), use_lines(case)
    parts = [
        comment([title(case, "Wear"), HONEST, *chain.from_iterable(words)]),
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
    head = (title(case, "Wear step"), HONEST, *step_lines(case), *increments_lines(case))
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
        files_lines(),
        law_lines(case),
        increments_lines(case),
        use_lines(case),
        run_lines(case, rate * case.step_limit),
    )
    return comment([title(case, "UMESHMOTION"), HONEST, *chain.from_iterable(words)], sign="")


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
