"""Reports as a laboratory sends them: letterhead, customer, samples, standard, signatures; without advice; as PDF."""

import re
import shutil
import subprocess
from dataclasses import replace
from datetime import date

import pytest
from hostile_runs import HOSTILE, SCRIPT
from test_report import LOADING, Page

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ManifestError, TribopipeError
from tribopipe.documents.block_on_ring import BlockOnRing
from tribopipe.documents.four_ball import FourBall
from tribopipe.documents.report_details import Customer, Laboratory, ReportDetails, Samples, Signatory, read_details
from tribopipe.views.html import rendering
from tribopipe.views.html.document import run_report
from tribopipe.views.html.particulars import STANDARDS, Addressed

RUN = "si3n4-air-200mN"
LAB = """
schema = "tribopipe.report/1"
[lab]
name = "Wear Laboratory"
address = "12 Wear Street\\n12345 Hertzburg"
contact = "lab@example.org"
accreditation = "no. T-000"
logo = "logo.svg"
[[signatories]]
name = "A. Sample"
role = "head of laboratory"
"""
ORDER = """
schema = "tribopipe.report/1"
number = "TR-2026/014"
issued = 2026-11-25
deviations = "humidity was not controlled"
[lab]
location = "Hall 2"
[customer]
name = "Example Bearings"
order = "4711"
[samples]
description = "three balls"
received = 2006-02-20
"""
LOGO = '<svg xmlns="http://www.w3.org/2000/svg"/>'
BROWSER = next(rendering._browsers(), None)


@pytest.fixture
def files(tmp_path):
    """Files of a laboratory, of its logo, and of an order."""
    for name, content in (("lab.toml", LAB), ("order.toml", ORDER), ("logo.svg", LOGO)):
        (tmp_path / name).write_text(content, encoding="utf-8")
    return [tmp_path / "lab.toml", tmp_path / "order.toml"]


@pytest.fixture(scope="module")
def tested(filled, tmp_path_factory) -> Archive:
    folder = tmp_path_factory.mktemp("tested") / "archive"
    folder.mkdir()
    shutil.copy(filled / f"{RUN}.h5", folder)
    return Archive(folder)


def report(archive: Archive, **how) -> Page:
    return Page(run_report(archive, [RUN], addressed=Addressed(**how)))


# --- what is read ---


def test_later_files_add_to_earlier_ones(files):
    details, logo, kind = read_details(files)
    assert details.lab.name == "Wear Laboratory"
    assert details.lab.location == "Hall 2"
    assert details.number == "TR-2026/014"
    assert details.issued == date(2026, 11, 25)
    assert (logo, kind) == (LOGO.encode(), "image/svg+xml")


def test_of_a_key_in_two_files_the_later_counts(files, tmp_path):
    more = tmp_path / "more.toml"
    more.write_text('schema = "tribopipe.report/1"\nnumber = "2"\n[lab]\nname = "Other"\n', encoding="utf-8")
    details, *_ = read_details([*files, more])
    assert (details.number, details.lab.name, details.lab.contact) == ("2", "Other", "lab@example.org")


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ('labs = "x"', "labs"),
        ('issued = "yesterday"', "issued"),
        ('standard = "g999"', "standard"),
        ('follows = "some"', "follows"),
        ('[lab]\naddress = "no name"', "lab.name"),
        ("[[signatories]]\nrole = 'x'", "signatories"),
        ('[lab]\nname = "a"\nlogo = "none.png"', "none.png"),
        ('[lab]\nname = "a"\nlogo = "logo.tif"', "logo.tif"),
        ('[lab]\nname = "a"\nlogo = "large.png"', "large.png"),
    ],
)
def test_what_is_wrong_is_named(tmp_path, wrong, told):
    (tmp_path / "large.png").write_bytes(bytes((1 << 20) + 1))
    (tmp_path / "logo.tif").write_bytes(b"II")
    path = tmp_path / "report.toml"
    path.write_text(f'schema = "tribopipe.report/1"\n{wrong}\n', encoding="utf-8")
    with pytest.raises(ManifestError, match=told):
        read_details([path])


# --- what is shown ---


@pytest.mark.slow
def test_a_report_states_all_particulars_of_iso_17025(tested, files):
    details, logo, kind = read_details(files)
    page = report(tested, details=details, logo=logo, logo_type=kind)
    stated = (
        *("Wear Laboratory", "12 Wear Street", "12345 Hertzburg", "lab@example.org", "no. T-000", "Hall 2"),
        *("TR-2026/014", "2026-11-25", "Example Bearings", "4711", "three balls", "2006-02-20"),
        *("A. Sample, head of laboratory", "End of report TR-2026/014", "Deviations: humidity was not controlled"),
        "The results relate only to the items tested.",
        "ASTM G99, Wear and Friction Testing with a Pin-on-Disk or Ball-on-Disk Apparatus",
    )
    assert [text for text in stated if text not in page.text] == []
    (image,) = page.all("img")
    assert image.attributes["src"].startswith("data:image/svg+xml;base64,")
    assert "TR-2026\\2f 014" in page.all("style")[0].text  # on every printed page


@pytest.mark.slow
def test_what_is_missing_is_named_with_its_key(tested):
    page = report(tested, details=ReportDetails(schema="tribopipe.report/1"))
    keys = [code.text for missing in page.all("span", "p") if "missing" in missing.classes for code in missing.children]
    expected = ["lab.name", "number", "customer.name", "samples.description", "samples.received", "issued"]
    assert [key for key in keys if key in expected] == expected
    assert "[[signatories]]" in keys


@pytest.mark.slow
def test_a_customer_gets_no_advice_to_the_laboratory(tested, files, tmp_path):
    shutil.copytree(tested.folder, tmp_path / "archive")
    archive = Archive(tmp_path / "archive")
    from tribopipe.documents.annotation import Annotation

    archive.annotate(RUN, Annotation(kind="tag", text="internal-tag", date="2026-01-01"))
    archive.annotate(RUN, Annotation(kind="note", text="internal note", date="2026-01-01"))
    details, *_ = read_details(files)
    ours, theirs = report(archive, details=details), report(archive, details=details, for_customer=True)
    for text in ("internal-tag", "internal note", "missing: add", "run.toml", "Options"):
        assert text in ours.text
    for text in ("internal-tag", "internal note", "missing: add", "Options of all steps"):
        assert text not in theirs.text
    assert "not reported" in theirs.text
    assert theirs.text.count("Uncertainty") == ours.text.count("Uncertainty")
    sparse = report(archive, details=ReportDetails(schema="tribopipe.report/1"), for_customer=True)
    assert "missing" not in sparse.text


@pytest.mark.slow
def test_without_details_a_report_has_none_of_it(tested):
    page = report(tested)
    assert "Authorization" not in page.text
    assert not page.all("img")
    assert not {element.tag for element in page.elements} & LOADING


@pytest.mark.slow
def test_what_a_lab_writes_stays_text(tested):
    details = ReportDetails(
        schema="tribopipe.report/1",
        title=HOSTILE,
        number=HOSTILE,
        deviations=HOSTILE,
        external=HOSTILE,
        lab=Laboratory(name=HOSTILE, address=HOSTILE, location=HOSTILE),
        customer=Customer(name=HOSTILE, order=HOSTILE),
        samples=Samples(description=HOSTILE, condition=HOSTILE, sampling=HOSTILE),
        signatories=(Signatory(name=HOSTILE, role=HOSTILE),),
    )
    document = run_report(tested, [RUN], addressed=Addressed(details))
    assert SCRIPT not in document
    page = Page(document)
    assert not {element.tag for element in page.elements} & LOADING
    assert page.text.count("alert(1)") >= 10


# --- standards ---


def reciprocating(archive: Archive):
    manifest = archive.manifest(RUN)
    conditions = manifest.conditions.model_copy(update={"stroke": manifest.contact.pin.radius, "track_radius": None})
    return manifest.model_copy(update={"conditions": conditions})


def test_the_standard_is_that_of_the_motion_unless_it_is_named(tested):
    circle, strokes = tested.manifest(RUN), reciprocating(tested)
    named = ReportDetails(schema="tribopipe.report/1", standard="g133")
    assert Addressed().standard_of([circle]) is STANDARDS["g99"]
    assert Addressed().standard_of([strokes]) is STANDARDS["g133"]
    assert Addressed().standard_of([circle, strokes]) is STANDARDS["g99"]
    assert Addressed(named).standard_of([circle]) is STANDARDS["g133"]
    ring, balls = BlockOnRing.model_construct(kind="block-on-ring"), FourBall.model_construct(kind="four-ball")
    for contact, standard in ((ring, "g77"), (balls, "d4172")):
        assert Addressed().standard_of([circle.model_copy(update={"contact": contact})]) is STANDARDS[standard]
    assert replace(Addressed(named), standard="g99").standard_of([strokes]) is STANDARDS["g99"]


@pytest.mark.slow
def test_a_report_states_in_which_way_a_standard_was_followed(tested):
    said = {
        "procedure": "followed the procedure of ASTM G99 with the materials and parameters stated in this report",
        "all particulars": "followed ASTM G99 in all particulars.",
    }
    for way, text in said.items():
        assert text in report(tested, details=ReportDetails(schema="tribopipe.report/1", follows=way)).text
    excepted = ReportDetails(schema="tribopipe.report/1", follows="all particulars", deviations="10 °C")
    assert "followed ASTM G99 in all particulars, except: 10 °C" in report(tested, details=excepted).text


# --- files ---


@pytest.mark.slow
def test_the_command_writes_what_is_asked_for(tested, files, run_cli, tmp_path):
    words = ["report", RUN, "--archive", tested.folder, "--details", files[0], "--details", files[1]]
    result = run_cli(*words, "--customer", "--standard", "g133", "-o", tmp_path / "out.html")
    assert result.exit_code == 0
    text = Page((tmp_path / "out.html").read_text(encoding="utf-8")).text
    assert "Example Bearings" in text
    assert "Reporting items customary under ASTM G133" in text


@pytest.mark.slow
def test_without_a_browser_the_way_out_is_said(tested, run_cli, tmp_path, monkeypatch):
    monkeypatch.setattr(rendering, "_browsers", lambda: iter(()))
    result = run_cli("report", RUN, "--archive", tested.folder, "-o", tmp_path / "out.pdf")
    assert result.exit_code == 1
    assert "expected one of them to create the PDF" in result.stderr
    assert not (tmp_path / "out.pdf").exists()


@pytest.mark.skipif(shutil.which("false") is None, reason="no program that fails")
def test_a_browser_that_prints_nothing_is_named(monkeypatch):
    monkeypatch.setattr(rendering, "_browsers", lambda: iter([shutil.which("false")]))
    with pytest.raises(TribopipeError, match="found no PDF"):
        rendering.printed("<p>")


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no browser is installed")
def test_a_browser_makes_a_pdf(tested, files, run_cli, tmp_path):
    for words in (["--pdf", "-o", tmp_path / "a"], ["-o", tmp_path / "b.pdf"]):
        result = run_cli("report", RUN, "--archive", tested.folder, "--details", files[0], *words)
        assert result.exit_code == 0, result.stderr
        content = words[-1].read_bytes()
        assert content.startswith(b"%PDF-")
        assert content.count(b"/Type /Page\n") >= 5


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None or shutil.which("pdftotext") is None, reason="no browser, or no pdftotext")
def test_a_pdf_has_all_of_the_report_and_numbers_its_pages(tested, files, run_cli, tmp_path):
    for name in ("a.html", "a.pdf"):
        result = run_cli("report", RUN, "--archive", tested.folder, "--details", files[0], "-o", tmp_path / name)
        assert result.exit_code == 0, result.stderr
    text = subprocess.run(
        ["pdftotext", "-layout", tmp_path / "a.pdf", "-"], capture_output=True, encoding="utf-8", check=True
    ).stdout
    *pages, rest = text.split("\f")
    assert rest == ""
    assert len(pages) >= 5
    found = [re.search(r"(\d+) ?/ ?(\d+)$", page.rstrip()) for page in pages]
    assert [one and one.groups() for one in found] == [(f"{n}", f"{len(pages)}") for n in range(1, len(pages) + 1)]
    whole = " ".join(text.split())
    html = Page((tmp_path / "a.html").read_text(encoding="utf-8"))
    headings = [" ".join(one.text.split()) for level in ("h1", "h2", "figcaption") for one in html.all(level)]
    assert [heading for heading in headings if heading not in whole] == []
