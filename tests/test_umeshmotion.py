"""The user subroutine for ABAQUS: what is written, that it compiles, and that it wears as tribopipe does."""

import json
import math
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from folders import DISC_PAIR, SAMPLES, replace_in
from hypothesis import given, settings
from hypothesis import strategies as st
from sweeps import others_slow

from tribopipe.base.errors import ContactError, FitError
from tribopipe.documents.manifest import read_manifest
from tribopipe.documents.quantity import wear_coefficient
from tribopipe.extras.abaqus.case import KnownWear, WearCase, fitted_wear
from tribopipe.extras.abaqus.fortran import CARD, comment, literal
from tribopipe.extras.abaqus.texts import texts
from tribopipe.physics.friction_path import ExponentialFriction, junction_factor
from tribopipe.physics.local.rings import Rings
from tribopipe.results.wear_fit import BodyWear, ConventionCoefficients, WearFit

GFORTRAN = shutil.which("gfortran")
needs_gfortran = pytest.mark.skipif(GFORTRAN is None, reason="needs gfortran")
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-Wno-unused-dummy-argument"]
"""All of them but the one for arguments of UMESHMOTION that are not used: their list is ABAQUS's."""
PIN, DISCS = "si3n4-air-200mN", "si3n4-twin-disc-4pct-1000k"
MANIFESTS = {run_id: read_manifest(SAMPLES / run_id / "run.toml")[0] for run_id in (PIN, DISCS)}
K_D = 13.5e-15
SPEED = {PIN: 0.4, DISCS: 0.032}
MU = ExponentialFriction(0.226, 0.496, 32.877)
INCREMENTS = 1000


def case_of(run_id: str, friction: ExponentialFriction | None = None, **changed) -> WearCase:
    manifest = MANIFESTS[run_id]
    said = {
        "contact": manifest.contact,
        "normal_load": manifest.conditions.normal_load.value,
        "known": KnownWear(run_id, wear_coefficient(K_D, 0.03 * K_D), "It is a test's."),
        "speed": SPEED[run_id],
        "duration": 1250.0,
        "friction": friction,
    }
    return WearCase(**said | changed)


def in_a_row(source: str) -> str:
    """The words of its comments, however they are wrapped."""
    return " ".join(source.replace("\nC     ", " ").split())


# --- what is written ---


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_survive_in_double_precision_constants(value):
    written = literal(value)
    assert float(written.replace("D", "E")) == value
    assert "." in written.partition("D")[0]


SIZES = st.floats(-9.0, 9.0).map(lambda power: 10.0**power)


@settings(max_examples=30)
@given(
    run_id=st.sampled_from([PIN, DISCS]),
    friction=st.none() | st.builds(ExponentialFriction, st.floats(-1, 1), st.floats(0, 1), SIZES),
    sizes=st.tuples(SIZES, SIZES, st.floats(1e-6, 1e8)),  # of k_D and speed, over usual ones, and increments
    jtyp=st.sampled_from(["0", "1", "none"]),
    told=st.text(max_size=300),
)
def test_every_line_is_ascii_and_fits_on_a_card(run_id, friction, sizes, jtyp, told):
    k_d, speed, increments = sizes
    changed = {"known": KnownWear("x" * 100, wear_coefficient(K_D * k_d), told, (told,)), "speed": speed}
    limit = case_of(run_id, friction, duration=0.0, **changed).step_limit
    case = case_of(run_id, friction, duration=increments * limit, **changed)
    for name, text in texts(case, jtyp).items():
        assert text.isascii(), name
        assert [line for line in text.splitlines() if len(line) > CARD] == [], name
        assert text.endswith("\n")
        assert "\r" not in text


def test_units_in_comments_are_spelled_in_ascii():
    assert comment(["k_D in mm³/(N·mm), 1 ± 2 µm", "Größe"]) == (
        "C     k_D in mm^3/(N mm), 1 +/- 2 um\nC\nC     Gr??e\n"
    )


def test_comments_have_the_numbers_of_the_run():
    said = in_a_row(texts(case_of(PIN, MU))["umeshmotion.f"])
    for part in (
        "k_D = 1.35e-08 mm^3/(N mm) with a standard uncertainty of 4e-10 mm^3/(N mm). It is a test's.",
        "Sarkar's law: a node recedes at k_D p v sqrt(1 + 3 mu^2).",
        "A = 0.226, b = 0.496 and c = 32877 mm",
        "V = 400 mm/s",
        "EC = 161290 MPa",
        "NOT RUN IN ABAQUS",
        "Units: mm, N, MPa, s.",
        "written by tribopipe 0.",
    ):
        assert part in said


def test_signature_is_that_of_abaqus():
    for run_id in (PIN, DISCS):
        source = texts(case_of(run_id))["umeshmotion.f"]
        joined = source.replace("\n     *", "").replace(" ", "")
        assert (
            "SUBROUTINEUMESHMOTION(UREF,ULOCAL,NODE,NNDOF,LNODETYPE,ALOCAL,NDIM,TIME,DTIME,PNEWDT,KSTEP,KINC,"
            "KMESHSWEEP,JMATYP,JGVBLOCK,LSMOOTH)"
        ) in joined
        assert source.index("CALL GETNODETOELEMCONN") < source.index("CALL GETVRMAVGATNODE")


@pytest.mark.parametrize(
    ("jtyp", "call"), [("0", "(NODE,JTYP,'CSTRESS'"), ("1", "(NODE,JTYP,'CSTRESS'"), ("none", "(NODE,'CSTRESS'")]
)
def test_jtyp_is_passed_as_asked(jtyp, call):
    source = texts(case_of(PIN), jtyp)["umeshmotion.f"]
    assert f"CALL GETVRMAVGATNODE{call}" in source
    assert (f"JTYP = {jtyp}" in source) == (jtyp != "none")


@pytest.mark.parametrize("run_id", [PIN, DISCS])
def test_step_holds_its_keywords_and_no_empty_line(run_id):
    lines = texts(case_of(run_id))["umeshmotion.inp"].splitlines()
    assert "" not in lines
    cards = [line for line in lines if not line.startswith("**")]
    assert cards[0].startswith("*STEP, NAME=WEAR, NLGEOM=YES, INC=")
    assert cards[1] == "*STATIC"
    first, duration, shortest, longest = (float(number) for number in cards[2].split(","))
    limit = case_of(run_id).step_limit
    assert 0.999 * limit < longest <= limit
    assert (first, duration) == (longest, 1250)
    assert shortest < 0.01 * longest
    assert int(cards[0].rpartition("=")[2]) >= duration / longest
    assert "*ADAPTIVE MESH CONSTRAINT, TYPE=VELOCITY, USER" in cards
    assert any(card.startswith("*ADAPTIVE MESH, ELSET=") for card in cards)


def test_longest_increment_is_that_of_the_contact_solver():
    case = case_of(PIN, element_size=1e-6)
    assert case.step_limit == pytest.approx(1.2 * 1e-6 / (K_D * case.modulus * 0.4), rel=1e-12)
    surface = rings(case, 1e-6)
    stable = surface.stable_amount(surface.press(np.zeros_like(surface.gap)))
    assert 0.9 < K_D * case.speed * case.step_limit / stable < 1
    assert roughness_after(surface, K_D * case.speed * case.step_limit) < 0.05
    assert roughness_after(surface, 1.5 * K_D * case.speed * case.step_limit) > 0.2
    assert case_of(PIN, MU).step_limit == pytest.approx(case_of(PIN).step_limit / float(junction_factor(0.722)))


def roughness_after(surface: Rings, amount: float) -> float:
    """Of the pressure after twenty explicit steps."""
    worn, contact = np.zeros_like(surface.gap), surface.press(np.zeros_like(surface.gap))
    for _ in range(20):
        worn = worn + amount * contact.pressure
        contact = surface.press(worn, start=contact)
    return surface.roughness(contact)


def test_longest_increment_of_discs_is_that_of_stripes():
    case = case_of(DISCS, element_size=2e-6)
    assert case.motion.turns == pytest.approx(0.032 / (2 * math.pi * 4e-3), rel=1e-12)
    stripes = 4 * 2e-6 / (math.pi * case.modulus * 2 * case.start.half_length)
    assert 0.9 < K_D * case.motion.turns * case.step_limit / stripes < 1


@pytest.mark.parametrize(
    ("changed", "said"),
    [({"known": KnownWear(PIN, wear_coefficient(0.0), "None.")}, "a k_D of 0"), ({"speed": 1e6}, "increments")],
)
def test_what_cannot_be_stepped_is_refused(changed, said):
    with pytest.raises(ContactError, match=said):
        case_of(PIN, **changed)


def disc_fit(convention: str, **found) -> WearFit:
    k_d = wear_coefficient(5e-18, 1e-18)
    disc = BodyWear(wear_coefficient=k_d, interval=(k_d, k_d))
    said = {
        "model": "archard",
        "outcome": "fitted",
        "distance_per_rotation": convention,
        "bodies": {"curved_disc": disc},
    }
    return WearFit(**said | found)


def test_k_d_is_taken_for_what_eq_9_means():
    same = ConventionCoefficients(
        distance_per_rotation="volume-conserving",
        bodies={"curved_disc": wear_coefficient(1e-14)},
    )
    assert fitted_wear(DISCS, disc_fit("volume-conserving")).coefficient == wear_coefficient(5e-18, 1e-18)
    turned = fitted_wear(DISCS, disc_fit("full-slip", equivalents=(same,)))
    assert turned.coefficient == wear_coefficient(1e-14, 0.2e-14)
    assert "(5e-12 mm^3/(N mm))" in turned.origin
    assert turned.notes == ()
    with pytest.raises(FitError, match='distance_per_rotation = "volume-conserving"'):
        fitted_wear(DISCS, disc_fit("full-slip"))
    with pytest.raises(FitError, match="missing: end values"):
        fitted_wear(DISCS, disc_fit("full-slip", outcome="not fitted", bodies={}, missing=("end values",)))


# --- that it compiles, and wears as tribopipe does ---


def written(case: WearCase, folder: Path, jtyp: str = "0") -> Path:
    for name, text in texts(case, jtyp).items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="ascii", newline="\n")
    return folder / "harness"


def gfortran(harness: Path) -> subprocess.CompletedProcess:
    command = [GFORTRAN, *WARNINGS, "-o", "drive", "harness.f"]
    return subprocess.run(command, cwd=harness, capture_output=True, text=True, encoding="utf-8")


def compiled(case: WearCase, folder: Path, jtyp: str = "0") -> Path:
    harness = written(case, folder, jtyp)
    done = gfortran(harness)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    return harness


def drive(harness: Path, told: str) -> subprocess.CompletedProcess:
    command = [harness / "drive"]
    return subprocess.run(command, cwd=harness, input=told, capture_output=True, text=True, encoding="ascii")


def driven(harness: Path, steps: np.ndarray, pressures: np.ndarray, dimensions: int = 2) -> tuple:
    """PNEWDT and the wear of each node, mm, in increments of these lengths, s, under these pressures, Pa."""
    nodes = pressures.shape[1]
    increments = zip(steps.tolist(), (pressures * 1e-6).tolist(), strict=True)
    rows = [f"{nodes} {len(steps)} {dimensions}", " ".join(str(number + 1) for number in range(nodes))]
    rows += [" ".join(map(repr, [step, *pressed])) for step, pressed in increments]
    done = drive(harness, "\n".join(rows) + "\n")
    assert done.returncode == 0
    table = np.array([line.split() for line in done.stdout.splitlines()], dtype=float)
    return table[:, 0], table[:, 1:]


def rings(case: WearCase, width: float) -> Rings:
    edges = np.arange(0.0, 5 * case.start.half_width, width)
    middle = (edges[1:] + edges[:-1]) / 2
    gap = middle**2 / (2 * case.contact.pin.radius.value)
    return Rings(normal_load=case.normal_load, modulus=case.modulus, edges=edges, gap=gap)


@pytest.mark.slow
@needs_gfortran
@pytest.mark.parametrize(
    ("run_id", "friction", "jtyp"), [(PIN, None, "0"), (PIN, MU, "none"), (DISCS, None, "none"), (DISCS, MU, "1")]
)
def test_example_runs_as_the_readme_says(tmp_path, run_id, friction, jtyp):
    case = case_of(run_id, friction)
    harness = compiled(case, tmp_path, jtyp)
    done = drive(harness, (harness / "pressures.txt").read_text(encoding="ascii"))
    assert done.returncode == 0
    first, *others = ([float(number) for number in line.split()] for line in done.stdout.splitlines())
    assert len(others) == 2
    readme = " ".join((tmp_path / "README.txt").read_text(encoding="ascii").split())
    assert f"{first[1]:.6g} mm at the first node in the first increment" in readme
    assert "NOT RUN IN ABAQUS" in readme


@needs_gfortran
@pytest.mark.parametrize("argument", ["NNDOF", "LSMOOTH"])
def test_wrong_argument_list_is_an_error(tmp_path, argument):
    harness = written(case_of(PIN), tmp_path)
    replace_in(tmp_path / "umeshmotion.f", rf",{argument}\b", "")
    done = gfortran(harness)
    assert done.returncode != 0
    assert "Error" in done.stderr


@pytest.mark.slow
@needs_gfortran
@pytest.mark.parametrize("friction", [None, MU], ids=["archard", "sarkar"])
def test_pin_wears_as_the_contact_solver_has_it(tmp_path, friction):
    """Explicit steps of a tenth of the longest stable one, each with the pressure of the contact solved for it."""
    case = case_of(PIN, friction)
    surface = rings(case, case.element)
    steps = np.full(INCREMENTS, 0.1 * case.step_limit)
    slid = case.speed * (np.cumsum(steps) - steps / 2)
    factors = np.ones(INCREMENTS) if friction is None else junction_factor(friction.coefficient(slid))
    worn, contact, pressures, wear = np.zeros_like(surface.gap), None, [], []
    for amount in K_D * case.speed * steps * factors:
        contact = surface.press(worn, start=contact)
        pressures.append(contact.pressure)
        wear.append(amount * surface.exposure(contact.pressure))
        worn = worn + wear[-1]
    ratio, found = driven(compiled(case, tmp_path), steps, np.array(pressures))
    assert np.abs(found - np.array(wear) * 1e3).max() <= 1e-15
    assert 2 < surface.extent(contact).half_width / case.start.half_width < 4.5
    assert surface.roughness(contact) < 0.05
    assert np.all(ratio >= 1)
    assert math.fsum((found @ surface.areas).tolist()) == pytest.approx(
        1e3 * K_D * case.normal_load * case.speed * float(steps @ factors), rel=1e-9
    )


@pytest.mark.slow
@needs_gfortran
@pytest.mark.parametrize("attempts", others_slow(["converge", "are repeated"], "converge"))
@pytest.mark.parametrize("friction", [None, MU], ids=["archard", "sarkar"])
def test_discs_wear_by_the_integral_along_streamlines(tmp_path, friction, attempts):
    """Elliptic pressure whose contact widens and shortens, as that of discs does while they wear.

    An increment that is tried again has the number it had, but another length.
    """
    case = case_of(DISCS, friction)
    harness = written(case, tmp_path)
    if attempts == "are repeated":
        replace_in(harness / "harness.f", ",1,KINC,1,JMATYP", ",1,1,1,JMATYP")
    assert gfortran(harness).returncode == 0
    table = np.loadtxt(harness / "streamlines.dat", skiprows=1)
    lines, lengths = table[:, 1].astype(int), table[:, 2] * 1e-3
    across = np.linspace(0, 1.5, lines.max())[lines - 1] * case.start.half_width
    along = np.tile(np.linspace(-1.2, 1.2, np.count_nonzero(lines == 1)), lines.max()) * case.start.half_length
    widened = np.linspace(1.0, 1.5, INCREMENTS)[:, None]
    inside = 1 - (across / case.start.half_width / widened) ** 2 - (along / case.start.half_length * widened) ** 2
    pressures = case.start.peak_pressure * np.sqrt(np.maximum(inside, 0.0))
    steps = case.step_limit * np.linspace(0.5, 0.9, INCREMENTS)
    slid = case.speed * (np.cumsum(steps) - steps / 2)
    factors = np.ones(INCREMENTS) if friction is None else junction_factor(friction.coefficient(slid))
    doses = np.stack(
        [(pressures * lengths)[:, lines == line].sum(axis=1) for line in range(1, lines.max() + 1)], axis=1
    )
    wear = K_D * case.motion.turns * (steps * factors)[:, None] * doses[:, lines - 1]
    _, found = driven(harness, steps, pressures, dimensions=3)
    assert np.abs(found - wear * 1e3).max() <= 1e-15
    assert found.max() > 1e-6


@needs_gfortran
def test_increments_that_are_too_long_are_shortened(tmp_path):
    case = case_of(PIN)
    steps = case.step_limit * np.array([2.0, 1.0001, 0.9999, 0.5, 1e-3])
    ratio, _ = driven(compiled(case, tmp_path), steps, np.full((5, 1), 1e9))
    assert ratio * steps == pytest.approx(case.step_limit * np.array([0.9, 0.9, 0.9999, 0.9, 0.9]), rel=1e-9)


@needs_gfortran
def test_streamlines_that_cannot_be_read_stop_the_job(tmp_path):
    harness = compiled(case_of(DISCS), tmp_path)
    (harness / "streamlines.dat").unlink()
    for table in (None, "0\n", "1\n0 1 0.001\n", "1\n1 99999999 0.001\n"):
        if table is not None:
            (harness / "streamlines.dat").write_text(table, encoding="ascii")
        assert drive(harness, "1 1 3\n1\n1 1\n").returncode == 1
        assert "streamlines.dat" in (harness / "messages.txt").read_text(encoding="ascii")


@needs_gfortran
def test_constants_are_read_back_to_the_last_digit(tmp_path):
    rng = np.random.default_rng(1)
    numbers = [
        *(rng.uniform(1, 10, 300) * 10.0 ** rng.integers(-300, 300, 300)).tolist(),
        0.1,
        1.0,
        13.5e-9,
        1e22,
        1e23,
    ]
    lines = [f"      WRITE(*,'(ES26.16E3)') {literal(number)}" for number in numbers]
    assert max(map(len, lines)) <= CARD
    (tmp_path / "numbers.f").write_text("\n".join([*lines, "      END", ""]), encoding="ascii")
    subprocess.run([GFORTRAN, *WARNINGS, "-o", "numbers", "numbers.f"], cwd=tmp_path, check=True)
    done = subprocess.run(["./numbers"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert [float(line) for line in done.stdout.splitlines()] == numbers


# --- the command ---


FILES = {"umeshmotion.f", "umeshmotion.inp", "README.txt", "harness/harness.f", "harness/ABA_PARAM.INC"}
FILES |= {"harness/pressures.txt"}
WITH_K_D = ["--wear-coefficient", "13.5e-9 mm^3/(N*mm)"]


def comments_of(folder: Path) -> str:
    return in_a_row((folder / "umeshmotion.f").read_text(encoding="ascii"))


def names_in(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_archived_run_is_exported_with_its_own_k_d(run_cli, archive, tmp_path):
    done = run_cli("export", "umeshmotion", PIN, "--archive", archive, "--json", cwd=tmp_path)
    assert done.exit_code == 0
    told = json.loads(done.stdout)
    assert names_in(tmp_path / f"umeshmotion-{PIN}") == FILES
    source = (tmp_path / f"umeshmotion-{PIN}" / "umeshmotion.f").read_text(encoding="ascii")
    value = told["wear_coefficient"]["value"] * 1e6
    assert f"k_D = {value:.6g} mm^3/(N mm) with a standard uncertainty" in " ".join(
        source.replace("\nC     ", " ").split()
    )
    assert told["law"] == "archard"
    assert "not tested in ABAQUS" in done.stderr


def test_sarkars_law_takes_the_fitted_friction(run_cli, archive, tmp_path):
    arguments = ["export", "umeshmotion", PIN, "--law", "sarkar", "--archive", archive, "--output", tmp_path / "out"]
    assert run_cli(*arguments).exit_code == 0
    assert "      RATE = RATE*SQRT(1.0D0+3.0D0*FMU*FMU)\n" in (tmp_path / "out/umeshmotion.f").read_text(
        encoding="ascii"
    )


def test_folder_of_discs_is_exported_with_a_given_k_d(run_cli, tmp_path):
    arguments = ["export", "umeshmotion", SAMPLES / DISCS, *WITH_K_D, "--output", tmp_path / "out"]
    done = run_cli(*arguments, "--until", "2e6", "--element-size", "2 um", "--jtyp", "none")
    assert done.exit_code == 0
    assert names_in(tmp_path / "out") == FILES | {"harness/streamlines.dat"}
    turns = 2e6 * 2 * math.pi * 4e-3 / 0.8
    assert f"{turns:.9g}" in (tmp_path / "out/umeshmotion.inp").read_text(encoding="ascii")
    assert "elements of 2 µm" in done.output


def test_nothing_is_replaced_unless_told_to(run_cli, tmp_path):
    arguments = ["export", "umeshmotion", SAMPLES / PIN, *WITH_K_D, "--output", tmp_path]
    (tmp_path / "README.txt").write_text("mine", encoding="ascii")
    refused = run_cli(*arguments)
    assert refused.exit_code == 1
    assert "--force" in refused.stderr
    assert names_in(tmp_path) == {"README.txt"}
    assert run_cli(*arguments, "--force").exit_code == 0
    assert names_in(tmp_path) == FILES


def test_k_d_of_discs_is_turned_into_that_of_eq_9(run_cli, disc_pair, tmp_path):
    done = run_cli(
        "export", "umeshmotion", DISC_PAIR[0], "--archive", disc_pair.folder, "--output", tmp_path / "out", "--json"
    )
    assert done.exit_code == 0
    told = json.loads(done.stdout)
    fit = disc_pair.step(DISC_PAIR[0], "wear_fit_archard").result
    (same,) = [one for one in fit.equivalents if one.distance_per_rotation == "volume-conserving"]
    assert told["wear_coefficient"]["value"] == same.bodies["curved_disc"].value
    own = fit.bodies["curved_disc"].wear_coefficient
    assert told["wear_coefficient"]["standard_uncertainty"] / same.bodies["curved_disc"].value == pytest.approx(
        own.standard_uncertainty / own.value
    )
    assert "cylindrical disc wore as well" in done.stderr
    assert "and converted to volume-conserving, as in Eq. 9" in comments_of(tmp_path / "out")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([SAMPLES / PIN], "--wear-coefficient"),
        ([SAMPLES / PIN, *WITH_K_D, "--jtyp", "2"], "--jtyp"),
        ([], "ID|RUN_FOLDER"),
    ],
)
def test_usage_errors(run_cli, tmp_path, arguments, said):
    done = run_cli("export", "umeshmotion", *arguments, cwd=tmp_path)
    assert done.exit_code == 2
    assert said in done.stderr
    assert names_in(tmp_path) == set()


def test_run_without_a_fit_says_how_to_fit(run_cli, sample_run, tmp_path):
    run_cli("ingest", sample_run, "--archive", tmp_path / "a")
    done = run_cli("export", "umeshmotion", "si3n4-air-400mN", "--archive", tmp_path / "a")
    assert done.exit_code == 1
    assert "run `tribopipe fit si3n4-air-400mN --law archard`" in done.stderr
    assert "Traceback" not in done.stderr


def test_friction_and_speed_that_are_missing_are_asked_for(run_cli, sample_run, tmp_path):
    given = ["export", "umeshmotion", sample_run, *WITH_K_D, "--output", tmp_path / "out"]
    assert "--friction" in run_cli(*given, "--law", "sarkar").stderr
    replace_in(sample_run / "run.toml", "(?m)^sliding_speed = .*\n", "")
    assert '--speed "400 mm/s"' in run_cli(*given).stderr
    assert run_cli(*given, "--speed", "200 mm/s").exit_code == 0
