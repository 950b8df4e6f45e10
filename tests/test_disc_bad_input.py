"""Bad twin-disc input: one sentence that names the key and how to mend it; the archive as it was."""

import shutil
import tomllib

import pytest
from folders import SAMPLES, edit_rows, replace_in, set_key, tree_bytes
from test_bad_input import assert_refused

RUN, PIN = "si3n4-twin-disc-4pct-100k", "si3n4-air-200mN"
SLIP = 'slip = { value = "4 %", standard_uncertainty = "0.04 %" }'


@pytest.fixture(autouse=True)
def _draws(few_draws):
    """Few of them."""


@pytest.fixture
def discs(tmp_path):
    return shutil.copytree(SAMPLES / RUN, tmp_path / "discs")


@pytest.fixture
def pin(tmp_path):
    return shutil.copytree(SAMPLES / PIN, tmp_path / "pin")


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    from tribopipe.archive.store import Archive
    from tribopipe.documents.recipe import Recipe
    from tribopipe.pipeline.stages import advance, ingest

    folder = tmp_path_factory.mktemp("held") / "archive"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 200)
        for run_id in (RUN, PIN):
            ingest(SAMPLES / run_id, Archive(folder))
            advance(Archive(folder), run_id, "wear_fit_archard", Recipe())
    return folder


def sub(pattern: str, text: str):
    return lambda run: replace_in(run / "run.toml", pattern, text)


def key(name: str, value: str):
    return lambda run: set_key(run, name, value)


def end(line: str):
    """Add to the end values."""
    return sub(r"(?m)^\[end_values\]$", f"[end_values]\n{line}")


def stop(*lines: str):
    return sub(r"(?m)^\[sensors\]$", "[[interruptions]]\n" + "\n".join(lines) + "\n\n[sensors]")


def conditions(line: str):
    return sub(r"(?m)^\[conditions\]$", f"[conditions]\n{line}")


NO_SLIP = r"(?m)^slip = .*\n"
CASES = {
    "slip of zero": (key("slip", '"0 %"'), ("conditions.slip", "both discs at the same speed", "check both speeds")),
    "slip of minus zero": (key("slip", '"-0 %"'), ("conditions.slip", "expected a nonzero slip")),
    "slip of -100 %": (key("slip", '"-100 %"'), ("conditions.slip", "a slip greater than -100 %", "(v2 - v1)/v1")),
    "slip of -300 %": (key("slip", '"-300 %"'), ("conditions.slip", "-300", "a slip greater than -100 %")),
    "slip that is no ratio": (key("slip", '"4 mm"'), ("conditions.slip", "'mm'", "'%'")),
    "slip that is not a number": (key("slip", "nan"), ("conditions.slip", "nan")),
    "neither slip nor speeds": (
        sub(NO_SLIP, ""),
        ("conditions.slip: missing", 'add slip = "4 %"', "curved_disc_speed and flat_disc_speed"),
    ),
    "equal speeds": (sub(NO_SLIP, 'flat_disc_speed = "800 mm/s"\n'), ("conditions.slip", "both discs at the same")),
    "slip beside the speed": (
        conditions('flat_disc_speed = "832 mm/s"'),
        ("conditions.slip", "in addition to flat_disc_speed", "remove the other"),
    ),
    "load of zero": (key("normal_load", '"0 mN"'), ("conditions.normal_load", "found")),
    "load below zero": (key("normal_load", '"-250 mN"'), ("conditions.normal_load", "'-250 mN'", "check sign")),
    "wear deeper than the crown radius": (
        end('curved_disc_wear_depth = "4 mm"'),
        ("end_values.curved_disc_wear_depth", "not less than the crown radius of", "check the units of both values"),
    ),
    "cylindrical disc worn deeper than the crown radius": (
        end('flat_disc_wear_depth = "5 mm"'),
        ("end_values.flat_disc_wear_depth", "crown radius"),
    ),
    "track wider than twice the crown": (
        end('curved_disc_track_width = "8 mm"'),
        ("end_values.curved_disc_track_width", "not less than twice the crown radius of"),
    ),
    "track on the cylindrical disc wider than twice the crown": (
        end('flat_disc_track_width = "9 mm"'),
        ("end_values.flat_disc_track_width", "twice the crown"),
    ),
    "track wider than the disc": (
        lambda run: (
            sub(r"(?m)^\[contact.flat_disc\]$", '[contact.flat_disc]\nwidth = "0.1 mm"')(run),
            end('flat_disc_track_width = "150 um"')(run),
        ),
        ("end_values.flat_disc_track_width", "more than the disc width", "check the units of both values"),
    ),
    "volume below zero": (
        key("curved_disc_wear_volume", '"-0.001 mm^3"'),
        ("curved_disc_wear_volume", "-0.001 mm", "wear is a loss"),
    ),
    "volume that is a depth": (key("flat_disc_wear_volume", '"1 um"'), ("flat_disc_wear_volume", "'um'", "'mm^3'")),
    "profile and volume": (
        end(
            'curved_disc_profile = { file = "a.csv", position = { column = "x", unit = "mm" }, '
            'height = { column = "z", unit = "um" } }'
        ),
        ("curved_disc_wear_volume", "in addition to curved_disc_profile", "remove the other"),
    ),
    "profile that is not there": (
        lambda run: (
            sub("(?m)^curved_disc_wear_volume = .*\n", "")(run),
            end(
                'curved_disc_profile = { file = "a.csv", position = { column = "x", unit = "mm" }, '
                'height = { column = "z", unit = "um" } }'
            )(run),
        ),
        ("a.csv",),
    ),
    "sliding speed": (
        conditions('sliding_speed = "400 mm/s"'),
        ("conditions.sliding_speed: found a key that does not apply to twin-disc runs", "remove the key"),
    ),
    "sliding distance": (conditions('sliding_distance = "400 m"'), ("conditions.sliding_distance", "twin-disc run")),
    "depth of a pin": (end('pin_wear_depth = "3 um"'), ("end_values.pin_wear_depth", "twin-disc run")),
    "scar of a pin": (end('pin_scar_diameter = "300 um"'), ("end_values.pin_scar_diameter", "twin-disc run")),
    "depth of a pin's disc": (end('disc_wear_depth = "3 um"'), ("end_values.disc_wear_depth", "twin-disc run")),
    "pin among the bodies": (
        sub(r"(?m)^\[contact.flat_disc\]$", '[contact.pin]\nshape = "spherical"\n\n[contact.flat_disc]'),
        ("contact", "pin: unknown key"),
    ),
    "interruption without rotations": (
        stop('curved_disc_wear_depth = "0.1 um"'),
        ("interruptions[0].rotations: missing; add this key",),
    ),
    "interruption at a distance": (
        stop('sliding_distance = "100 m"', 'curved_disc_wear_depth = "0.1 um"'),
        ("interruptions[0]",),
    ),
    "interruption deeper than the crown": (
        stop("rotations = 1000", 'curved_disc_wear_depth = "4.5 mm"'),
        ("interruptions[0].curved_disc_wear_depth", "crown radius"),
    ),
    "interruption of a pin": (
        stop("rotations = 1000", 'pin_wear_depth = "1 um"'),
        ("interruptions[0].pin_wear_depth", "twin-disc run"),
    ),
    "interruption below zero": (
        stop("rotations = 1000", 'curved_disc_wear_volume = "-1 mm^3"'),
        ("curved_disc_wear_volume", "wear is a loss"),
    ),
    "no crown radius": (sub("(?m)^crown_radius = .*\n", ""), ("contact", "crown_radius: missing", "add this key")),
    "crown radius of zero": (key("crown_radius", '"0 mm"'), ("crown_radius", "found '0 mm'", "check sign")),
    "rolling radius below zero": (key("rolling_radius", '"-4 mm"'), ("rolling_radius", "'-4 mm'", "check sign")),
    "unknown tribometer": (key("kind", '"ball-cratering"'), ("contact", "ball-cratering")),
    **{
        f"rotations {written}": (
            key("rotations", written),
            ("conditions.rotations", "expected a whole number of rotations"),
        )
        for written in ('"many"', "0", "-5", "2.5", "nan", "inf", "true", '"1e6"', "[1]")
    },
    **{
        f"interruption after rotations {written}": (
            stop(f"rotations = {written}", 'curved_disc_wear_depth = "0.1 um"'),
            ("interruptions[0].rotations", "expected a whole number of rotations"),
        )
        for written in ('"half"', "0", "-5", "2.5", "true")
    },
}


@pytest.mark.parametrize("case", CASES)
def test_bad_run_is_refused_and_the_archive_stays_as_it_was(run_cli, discs, held, case):
    spoil, words = CASES[case]
    set_key(discs, "id", '"spoilt"')
    spoil(discs)
    before = tree_bytes(held)
    assert_refused(run_cli("ingest", discs, "--archive", held), *words)
    assert tree_bytes(held) == before


def test_interruptions_that_do_not_follow_each_other_are_refused(run_cli, discs, tmp_path):
    for turns in (5000, 5000):
        stop(f"rotations = {turns}", 'curved_disc_wear_depth = "0.1 um"')(discs)
    words = ("interruptions: found 5,000 rotations, 5,000 rotations", "expected increasing values")
    assert_refused(run_cli("ingest", discs, "--archive", tmp_path / "archive"), *words)
    assert not (tmp_path / "archive").exists()


PIN_CASES = {
    "slip": (
        conditions('slip = "4 %"'),
        ("conditions.slip: found a key that does not apply to pin-on-disc runs", "remove the key"),
    ),
    "rotations": (conditions("rotations = 1000"), ("conditions.rotations", "pin-on-disc run")),
    "speed of a disc": (conditions('flat_disc_speed = "1 m/s"'), ("conditions.flat_disc_speed", "pin-on-disc run")),
    "volume of a disc": (end('curved_disc_wear_volume = "1 mm^3"'), ("curved_disc_wear_volume", "pin-on-disc run")),
    "width of a track": (end('flat_disc_track_width = "1 mm"'), ("flat_disc_track_width", "pin-on-disc run")),
    "interruption of discs": (
        stop('sliding_distance = "10 m"', 'flat_disc_track_width = "1 mm"'),
        ("interruptions[0].flat_disc_track_width", "pin-on-disc run"),
    ),
    "interruption after rotations": (
        stop("rotations = 100", 'pin_wear_depth = "1 um"'),
        ("interruptions[0]", "rotations"),
    ),
    "crown radius": (
        sub(r"(?m)^\[contact.pin\]$", '[contact.pin]\ncrown_radius = "4 mm"'),
        ("crown_radius: unknown key",),
    ),
}


@pytest.mark.parametrize("case", PIN_CASES)
def test_keys_of_discs_are_refused_in_a_run_of_a_pin(run_cli, pin, tmp_path, case):
    spoil, words = PIN_CASES[case]
    spoil(pin)
    assert_refused(run_cli("ingest", pin, "--archive", tmp_path / "archive"), *words)
    assert not (tmp_path / "archive").exists()


# --- the signals ---


def turns(edit):
    """Change the rotations of each row, by its number."""

    def changed(lines):
        rows = [line.split(",") for line in lines]
        for place, row in enumerate(rows[1:]):
            row[1] = str(edit(place, float(row[1])))
        return [",".join(row) for row in rows]

    return lambda run: edit_rows(run, changed)


COLUMNS = {
    "going back": (turns(lambda place, was: was - 50_000 if place > 30 else was), ("rotations",)),
    "below zero": (turns(lambda _, was: was - 50_000), ("rotations",)),
    "constant": (turns(lambda *_: 7.0), ("rotations",)),
    "words": (turns(lambda place, was: was if place % 2 else "many"), ("otations",)),
}


@pytest.mark.parametrize("case", COLUMNS)
def test_column_of_rotations_that_is_no_count_is_refused(run_cli, discs, tmp_path, case):
    spoil, words = COLUMNS[case]
    spoil(discs)
    result = run_cli("ingest", discs, "--archive", tmp_path / "archive")
    assert result.exit_code == 1, result.stderr
    assert all(word in result.stderr for word in words), result.stderr
    assert "Traceback" not in result.stderr
    assert not list((tmp_path / "archive").glob("*")) if (tmp_path / "archive").exists() else True


def test_neither_time_nor_rotations_is_refused(run_cli, discs, tmp_path):
    sub("(?m)^time = .*\n", "")(discs)
    sub("(?m)^rotations = {.*\n", "")(discs)
    edit_rows(discs, lambda lines: ["a,b" + lines[0].partition("[-]")[2], *lines[1:]])
    assert_refused(run_cli("ingest", discs, "--archive", tmp_path / "archive"), "rotations")


# --- predictions ---

K_1, K_2 = "4.6e-12 mm^3/(N*mm)", "2.0e-12 mm^3/(N*mm)"
GIVEN = ("--wear-coefficient", K_1, "--wear-coefficient", K_2)
ASKED = {
    "slip of zero": ((RUN, "--slip", "0 %"), 1, ("--slip", "0 %", "nonzero")),
    "slip of -100 %": ((RUN, "--slip", "-100 %"), 1, ("--slip", "greater than -100 %")),
    "slip that is none": ((RUN, "--slip", "much"), 1, ("--slip", "much")),
    "slip not a number": ((RUN, "--slip", "nan"), 1, ("--slip", "nan")),
    "load of zero": ((RUN, "--load", "0 mN"), 1, ("--load", "0 mN", "positive")),
    "crown of zero": ((RUN, "--crown-radius", "0 mm"), 1, ("--crown-radius", "0 mm")),
    "crown smaller than the contact": ((RUN, "--crown-radius", "1 nm"), 1, ("as large as the crown", "check load")),
    "rotations below zero": ((RUN, "--at", "-3"), 1, ("--at", "-3")),
    "rotations that are none": ((RUN, "--at", "x"), 1, ("--at", "'x'")),
    "rotations not a number": ((RUN, "--at", "nan"), 1, ("--at", "nan")),
    "rotations without end": ((RUN, "--at", "inf"), 1, ("--at", "inf")),
    "rotations in metres": ((RUN, "--at", "500 m"), 1, ("--at", "500 m")),
    "depth below zero": ((RUN, "--depth", "-1 um"), 1, ("--depth", "-1 um")),
    "depth beyond the crown": ((RUN, "--depth", "4 mm"), 1, ("crown",)),
    "wear beyond the crown": ((RUN, "--at", "1e13"), 1, ("crown", "check wear coefficients, load and rotations")),
    "radius of a pin": ((RUN, "--radius", "2 mm"), 2, ("--radius applies to a pin", "--crown-radius")),
    "three coefficients": (
        (RUN, *GIVEN, "--wear-coefficient", K_1),
        2,
        ("found too many values; expected one value for the curved_disc and one for the flat_disc",),
    ),
    "coefficient of zero": ((RUN, "--wear-coefficient", "0 mm^3/(N*mm)"), 1, ("--wear-coefficient", "positive")),
    "slip of a pin": ((PIN, "--slip", "4 %"), 2, ("--slip applies to two discs",)),
    "crown of a pin": ((PIN, "--crown-radius", "4 mm"), 2, ("--crown-radius applies to two discs", "--radius")),
    "two coefficients of a pin": (
        (PIN, *GIVEN),
        2,
        ("found too many values; expected one value for the pin and one for the disc",),
    ),
    "rotations of a pin": ((PIN, "--at", "1e6"), 1, ("--at", "1e6")),
    "convention of a pin": ((PIN, "--distance-per-rotation", "full-slip"), 2, ("--distance-per-rotation",)),
    "another convention than the fit's": (
        (RUN, "--distance-per-rotation", "contact-width"),
        1,
        ('fitted with distance_per_rotation = "full-slip"', 'expected "contact-width"'),
    ),
    "too many steps": ((RUN, "--at", "1e8", "--scheme", "published"), 1, ("steps", "--steps")),
    "onto a pin": (("--from", RUN, "--onto", PIN), 1, ("twin-disc", "pin-on-disc", "same materials")),
}


@pytest.mark.parametrize("case", ASKED)
def test_bad_prediction_is_refused_and_the_archive_stays_as_it_was(run_cli, held, case):
    arguments, code, words = ASKED[case]
    before = tree_bytes(held)
    result = run_cli("predict", *arguments, "--archive", held)
    assert result.exit_code == code, result.stderr
    said = " ".join(result.stderr.replace("│", " ").split())
    assert [word for word in words if word not in said] == [], said
    assert "Traceback" not in result.stderr
    if code == 1:
        assert len(result.stderr.splitlines()) == 1
    assert result.stdout == ""
    assert tree_bytes(held) == before


def test_folder_of_discs_without_k_d_is_refused(run_cli, discs):
    assert run_cli("predict", "--run", discs, "--at", "10").exit_code == 2


def test_crown_smaller_than_the_contact_is_flagged_or_refused(run_cli, discs, tmp_path):
    """10 nm of crown under 250 mN."""
    set_key(discs, "crown_radius", '"10 nm"')
    result = run_cli("process", discs, "--archive", tmp_path / "archive", "--no-figures")
    assert result.exit_code != 0
    assert "crown" in result.stderr
    assert "Traceback" not in result.stderr


def test_interruption_beyond_the_end_is_flagged_or_refused(run_cli, discs, tmp_path):
    stop("rotations = 900000", 'curved_disc_wear_depth = "0.1 um"')(discs)
    result = run_cli("ingest", discs, "--archive", tmp_path / "archive")
    assert "interruptions[0]" in result.stderr
    assert tomllib.loads((discs / "run.toml").read_text(encoding="utf-8"))["id"] == RUN
