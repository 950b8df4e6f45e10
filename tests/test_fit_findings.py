"""What speaks against a k_D is said in the same words wherever the k_D is shown."""

import re

import numpy as np
import pytest
from folders import replace_in

from tribopipe.archive.store import Archive
from tribopipe.browse.answers import run_answer
from tribopipe.browse.file_cache import Kept, RunFile
from tribopipe.browse.plots import run_plots
from tribopipe.evaluation.drift import correct_drift
from tribopipe.evaluation.wear.fit import fit_wear
from tribopipe.pipeline.stages import process
from tribopipe.readers.harmonize import read_run
from tribopipe.results.evaluation import DepthModel, DriftCorrection
from tribopipe.results.finding import Finding, first_of_each_code
from tribopipe.results.wear_fit import WearFit
from tribopipe.views.archived_figures import run_figures
from tribopipe.views.html.document import run_report
from tribopipe.views.run_figures import basis_words
from tribopipe.views.run_page import run_page

CODE = "reading_contradicts_measurement"

POLYMER = """
schema = "tribopipe.run/1"
id = "creep"
[contact]
kind = "pin-on-disc"
pin = { shape = "flat", radius = "4 mm", material = "PEEK", youngs_modulus = "3.7 GPa", poisson_ratio = 0.4 }
disc = { material = "steel", youngs_modulus = "210 GPa", poisson_ratio = 0.3 }
[conditions]
normal_load = "100 N"
sliding_speed = "0.2 m/s"
[[signals]]
file = "signals.csv"
"""

pytestmark = pytest.mark.usefixtures("few_draws")


def finding(code: str, message: str = "found x", severity: str = "warning") -> Finding:
    return Finding(severity=severity, code=code, where="depth", message=message, remedy="do y")


@pytest.fixture
def contradicted(other_run):
    """A run folder whose scar is too small for its depth reading."""
    replace_in(
        other_run / "run.toml", r'pin_scar_diameter = \{ value = "[\d.]+ um"', 'pin_scar_diameter = { value = "150 um"'
    )
    return other_run


@pytest.mark.slow
def test_finding_of_a_fit_is_seen_on_every_surface(run_cli, contradicted, tmp_path):
    place = ("--archive", tmp_path / "found")
    processed = run_cli("process", contradicted, *place)
    (run_id,) = Archive(tmp_path / "found").ids()
    fit = Archive(tmp_path / "found").result(run_id, "wear_fit_archard", WearFit)
    (said,) = [str(one) for one in fit.findings if one.code == CODE]
    assert processed.stderr.count(f"{run_id}: warning: {said}\n") == 1
    assert len(re.findall(r"warning: depth: .* from the post-test measurement alone", processed.stderr)) == 1
    for more in ((), ("--force",)):
        assert f"{run_id}: warning: {said}\n" in run_cli("fit", run_id, *place, *more).stderr
    shown = run_cli("show", run_id, "-v", *place)
    assert f"warning: {said}" in shown.stderr + shown.stdout
    page = run_page(Archive(tmp_path / "found"), run_id)
    assert [one.code for one in page.findings].count(CODE) == 1
    on_the_web = run_answer(run_id, page, [], [])["findings"]
    assert {"severity": "warning", "text": said, "help": CODE} in on_the_web
    assert run_cli("report", run_id, *place, "--output", tmp_path / "report.html").exit_code == 0
    assert "from the post-test measurement alone" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_wear_curve_on_every_surface_says_what_k_d_is_by(contradicted, tmp_path):
    archive = Archive(tmp_path / "found")
    list(process([contradicted], archive))
    (run_id,) = archive.ids()
    fit = archive.result(run_id, "wear_fit_archard", WearFit)
    (message,) = [one.message for one in fit.findings if one.code == CODE]
    assert message.endswith("the depth signal is not used, and k_D is based on the measurement")
    figure = run_figures(archive, run_id)["wear"]
    above = figure.axes[0].texts[0].get_text()
    assert message in above.replace("\n", " ")
    assert max(map(len, above.splitlines())) <= 90
    (wear,) = [offer for offer in run_plots(RunFile(archive, run_id, Kept())) if offer.name == "wear"]
    assert wear.drawing().words == f"depth: {message}"
    report = re.sub(r"<[^>]*>|\s+", " ", run_report(archive, [run_id]))
    assert re.sub(r"\s+", "", report).count("thedepthsignalisnotused,andk") >= 2


def test_the_first_finding_of_each_code_counts():
    first, same, other = finding("a", "found 1"), finding("a", "found 2"), finding("b")
    assert first_of_each_code([first, same, other]) == (first, other)


@pytest.mark.parametrize(
    ("findings", "words"),
    [
        ((finding(CODE, "found 1"), finding("curve_shape")), ["depth: found 1"]),
        ((finding("no_post_test_measurement", "found none"),), ["depth: found none"]),
        ((finding("curve_shape"),), []),
    ],
)
def test_words_beside_a_wear_curve_are_those_of_the_findings_on_its_basis(findings, words):
    by_both_laws = [WearFit(model=law, outcome="fitted", findings=findings) for law in ("archard", "sarkar")]
    assert basis_words(by_both_laws) == words


def test_drift_page_shows_both_rates_and_what_the_model_finds(archive):
    page = run_page(Archive(archive), "si3n4-air-200mN")
    (drift,) = [stage for stage in page.stages if stage.name == "drift_correction"]
    correction = Archive(archive).result("si3n4-air-200mN", "drift_correction", DriftCorrection)
    told = {fact.name: fact.value for fact in drift.facts}
    assert isinstance(correction.model, DepthModel)
    assert told["drift rate"] == correction.drift_rate.shown("nm/min")
    assert told["drift rate (two-step correction)"] == correction.two_step_rate.shown("nm/min")
    assert told["probability of settling"] == f"{correction.model.settling_probability:.2f}"
    assert told["low-frequency fluctuations (RMS)"] == correction.model.wander.shown("nm")


def test_settling_without_a_post_test_measurement_asks_for_one(tmp_path):
    time = np.linspace(0.0, 3000.0, 601)
    depth = 5 + 0.02 * time + 25 * -np.expm1(-time / 300) + 0.3 * np.random.default_rng(1).normal(size=601)
    (tmp_path / "run.toml").write_text(POLYMER, encoding="utf-8")
    np.savetxt(
        tmp_path / "signals.csv",
        np.column_stack([time, depth]),
        delimiter=",",
        header="time [s],depth [um]",
        comments="",
    )
    run = read_run(tmp_path)
    fit = fit_wear(correct_drift(run), "archard")
    (found,) = [one for one in fit.findings if one.code == "reading_settles"]
    assert found.remedy.startswith("measure the scar or the mass loss")


def test_width_of_a_scar_alone_is_told_apart_from_no_measurement(other_run):
    replace_in(other_run / "run.toml", "(?m)^pin_scar_diameter = .*", 'pin_scar_width = "440 um"')
    run = read_run(other_run)
    fit = fit_wear(correct_drift(run), "archard")
    assert str(fit).count("fitted, not measured") == 1
    (found,) = [one for one in fit.findings if one.code == "no_post_test_measurement"]
    assert found.message.startswith("found only the width of the scar on the pin")
    assert found.remedy.endswith("end_values.pin_scar_length")
