"""The texts in the files: the law, k_D and its source, the longest increments, and how to use them."""

import math
from collections.abc import Iterator

from tribopipe.documents.contact import Specimen
from tribopipe.documents.quantity import Quantity
from tribopipe.extras.abaqus.case import WearCase
from tribopipe.extras.abaqus.fortran import in_mm
from tribopipe.version import VERSION

SUBROUTINE, STEP = "umeshmotion.f", "umeshmotion.inp"
HONEST = (
    "NOT RUN IN ABAQUS. Subroutines of this text have been compiled with gfortran and driven by the harness next to "
    "this one, which compared their increments with those of the contact solver of tribopipe; nothing more."
)
_K_D = "mm^3/(N mm)"


def title(case: WearCase, what: str) -> str:
    """Report what a file is, of which run, and who wrote it."""
    return f"{what} of run {case.known.run_id}, written by tribopipe {VERSION}. Units: mm, N, MPa, s."


def law_told(case: WearCase) -> Iterator[str]:
    """State by which law and with which k_D nodes recede."""
    factor = "" if case.friction is None else " sqrt(1 + 3 mu^2)"
    yield f"{case.law.title()}'s law: a node recedes at {case.motion.rate}{factor}."
    yield f"k_D = {_stated(case.known.coefficient)}. {case.known.origin}"
    yield from (f"Note: {note}" for note in (*case.contact.limits, *case.known.notes))
    if case.friction is not None:
        yield (
            f"mu(s) = A exp(-s/c) + b with A = {case.friction.amplitude:.6g}, b = {case.friction.steady_state:.6g} and "
            f"c = {in_mm(float(case.friction.running_in_distance), 'm'):.6g} mm, at the sliding distance in the "
            "middle of the increment: TIME(1) is taken for the time of the step at the end of the increment."
        )
    if case.motion.words:
        yield case.motion.words


def _stated(coefficient: Quantity) -> str:
    value, spread = in_mm(coefficient.value, "m^2/N"), coefficient.standard_uncertainty
    if spread is None:
        return f"{value:.6g} {_K_D}, whose standard uncertainty is not known"
    return f"{value:.6g} {_K_D} with a standard uncertainty of {in_mm(spread, 'm^2/N'):.2g} {_K_D}"


def increments_told(case: WearCase) -> Iterator[str]:
    """Report how long increments may be, by formula and in numbers."""
    factors = ["WK", "EC", *case.motion.factors, *(["FMAX"] if case.friction else [])]
    numbers = [f"HEL = {in_mm(case.element, 'm'):.4g} mm", f"EC = {in_mm(case.modulus, 'Pa'):.6g} MPa"]
    numbers += case.motion.numbers
    numbers += [f"FMAX = {case.largest_factor:.4g}"] if case.friction else []
    yield (
        "Increments: the mesh is moved explicitly, so that the pressure becomes a checkerboard unless DTIME <= 1.2 "
        f"h_el/(k_D E_c v), here 1.2 HEL/({' '.join(factors)}). With {', '.join(numbers)} that is "
        f"{case.step_limit:.4g} s, and {math.ceil(case.increments):,} increments in the {case.duration:.6g} s of the "
        "test. PNEWDT keeps increments below it; set HEL to your mesh."
    )


def use_told(case: WearCase) -> Iterator[str]:
    """Report what the model around the subroutine has to be like."""
    yield (
        "Use: *ADAPTIVE MESH CONSTRAINT, TYPE=VELOCITY, USER on the nodes of the surface that wears, which has to be "
        "the slave (secondary) surface of the contact, since CSTRESS is had there. UREF is not used, since a step may "
        "ramp it."
    )
    if case.motion.use:
        yield case.motion.use
    yield (
        "At corners and edges of the mesh domain (LNODETYPE 3 and 4), such as the node on the axis, look at the "
        "direction in which nodes move: local directions there are the solver's choice."
    )


def step_told(case: WearCase) -> Iterator[str]:
    """Report what the step needs of the model."""
    body = _wearing(case)
    modulus = in_mm(case.modulus * (1 - body.poisson_ratio.value**2), "Pa")
    yield (
        "It follows a step that presses the bodies on each other, whose loads stay as they are. WEAR_MESH is the set "
        "of the solid elements that adapt, WEAR_NODES that of the nodes of the surface that wears: both are yours. The "
        "time of this step is that of the test."
    )
    yield (
        f"Where the counterbody is rigid in your model, give the wearing body E = {modulus:.6g} MPa, which is E_c (1 "
        f"- nu^2) with its Poisson's ratio nu = {body.poisson_ratio.value:g}, so that the contact is as stiff as that "
        "of both bodies."
    )


def _wearing(case: WearCase) -> Specimen:
    return case.contact.bodies[case.contact.fitted_bodies[0]]


def files_told() -> Iterator[str]:
    """Report what the files are."""
    yield f"{SUBROUTINE}: the subroutine; Windows wants it named umeshmotion.for."
    yield f"{STEP}: the step to put into an input file."
    yield "harness: drives the subroutine without ABAQUS; never copy its ABA_PARAM.INC next to a job."


def drive_told(case: WearCase, first_wear: float) -> Iterator[str]:
    """Report how to run job and harness, and what the harness should print."""
    yield "In ABAQUS:"
    yield f"  abaqus job=NAME user={SUBROUTINE}{case.motion.arguments}"
    yield "Without it, in the folder harness:"
    yield "  gfortran -Wall -Wextra -Wno-unused-dummy-argument harness.f"
    yield "  ./a.out < pressures.txt"
    yield (
        "That prints PNEWDT and the wear of each node in mm, one line per increment, under the pressure of the unworn "
        f"contact: {in_mm(first_wear, 'm'):.6g} mm of the first node in the first increment. The warning that is "
        "turned off is for arguments of UMESHMOTION that are not used: their list is ABAQUS's."
    )
    yield (
        "If nothing wears, see that the surface is the slave one and its nodes are in the mesh domain: the utility "
        "routine does not distinguish a pressure of zero from an unavailable one."
    )
    yield (
        "ABAQUS does not solve the contact again after moving the mesh. With twin discs this gave 11 % less wear than "
        "solving it again, growing with it; moving the nodes of the mesh by the wear so far and going on in "
        "another step brings it back (Figs. 10 and 11 of the paper)."
    )
    if case.motion.data:
        yield case.motion.data
