"""`tribopipe browse` in Chromium, as a person uses it: from the table to a run, a zoom, a comparison, a file."""

import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

import pytest
from folders import SAMPLES
from hostile_runs import hostile_archive
from serving import Address, served

from tribopipe.archive.store import Archive
from tribopipe.documents.recipe import Recipe
from tribopipe.pipeline.studies import find_studies, load_studies, process_studies

pytest.importorskip("playwright.sync_api")

from axe_playwright_python.sync_playwright import Axe
from browsing import browser, chromium, complaints
from playwright.sync_api import Browser, Page, expect

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(chromium() is None and "CI" not in os.environ, reason="needs Chromium"),
]
expect.set_options(timeout=20_000)  # ms; on a busy machine, a page takes longer than the default of 5 s
RUN, OTHER, STUDY = "si3n4-air-200mN", "si3n4-air-400mN", "si3n4-air"
PAGES = {
    "table": "/",
    "run": f"/runs/{RUN}",
    "discs": "/runs/si3n4-twin-disc-4pct-1000k",
    "compare": f"/compare?runs={RUN},{OTHER}",
    "scatter": "/scatter?x=friction&y=k_d&logy=1",
    "study": f"/studies/{STUDY}",
    "viewer": f"/file?file={RUN}.h5",
    "studies": "/studies",
    "report": f"/api/studies/{STUDY}/report",
}
PICTURES = Path(os.environ["SCREENSHOTS"]) if "SCREENSHOTS" in os.environ else None
"""Where CI keeps what the pages look like."""


@pytest.fixture(scope="module")
def folder(sample_archive, disc_archive, tmp_path_factory) -> Path:
    """What the README's first command leaves, made with fewer draws."""
    both = tmp_path_factory.mktemp("browsed") / "archive"
    for archive in (sample_archive, disc_archive):
        shutil.copytree(archive.folder, both, dirs_exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tribopipe.physics.uncertainty.BLOCK", 2_000)
        outcomes = list(process_studies(Archive(both), load_studies(find_studies(SAMPLES)), Recipe()))
    assert [outcome for outcome in outcomes if outcome.status == "failed"] == []
    return both


@pytest.fixture(scope="module")
def site(folder) -> Iterator[Address]:
    with served(folder) as address:
        yield address


@pytest.fixture(scope="module")
def chrome() -> Iterator[Browser]:
    with browser() as started:
        yield started


@pytest.fixture
def page(chrome) -> Iterator[Page]:
    """A page of which nothing may be complained."""
    shown = chrome.new_page(viewport={"width": 1280, "height": 800})
    heard = complaints(shown)
    yield shown
    shown.close()
    assert heard == []


def picture(page: Page, name: str) -> None:
    if PICTURES is not None:
        PICTURES.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=PICTURES / f"{name}.png")


def settle(page: Page) -> None:
    """Wait until nothing is loading and every plot in view is drawn."""
    page.wait_for_load_state("networkidle")
    expect(page.locator("[aria-busy=true]")).to_have_count(0)


def expect_run(page: Page, run_id: str) -> None:
    """See the page of a run, whatever its title."""
    expect(page).to_have_title(re.compile(re.escape(run_id)))
    expect(page.get_by_role("heading", level=1)).to_be_visible()


def test_from_the_table_to_a_file(page, site, folder, tmp_path):
    page.goto(site.of())
    expect(page.get_by_role("status").filter(has_text="14 of 14 runs")).to_be_visible()
    page.get_by_label("Filter", exact=True).last.fill("material=Si3N4 load>300mN tribometer=pin-on-disc")
    page.get_by_role("button", name="Apply").click()
    expect(page.get_by_role("status").filter(has_text="2 of 14 runs")).to_be_visible()
    assert "where=" in page.url

    page.get_by_role("link", name=OTHER).click()
    expect_run(page, OTHER)
    settle(page)
    zoom(page)

    page.goto(site.of())
    for run_id in (RUN, OTHER):
        page.get_by_role("checkbox", name=f"Select {run_id}").check()
    page.get_by_role("link", name="Compare 2").click()
    settle(page)
    expect(page.locator(".uplot").first).to_be_visible()
    assert f"runs={RUN}" in page.url

    page.goto(site.of(f"/runs/{RUN}"))
    settle(page)
    page.get_by_role("heading", name="Source files").click()
    with page.expect_download() as started:
        page.get_by_role("link", name="signals.csv").click()
    started.value.save_as(tmp_path / "signals.csv")
    assert (tmp_path / "signals.csv").read_bytes() == (SAMPLES / RUN / "signals.csv").read_bytes()
    page.get_by_role("button", name="Download").click()
    with page.expect_download() as started:
        page.get_by_role("link", name=re.compile("HDF5")).click()
    started.value.save_as(tmp_path / "run.h5")
    assert digest(tmp_path / "run.h5") == digest(folder / f"{RUN}.h5")


def zoom(page: Page) -> None:
    """Drag over the middle of the first plot; the address says what is looked at, and the server is asked for it."""
    plot = page.locator(".u-over").first
    plot.scroll_into_view_if_needed()
    box = plot.bounding_box()
    assert box is not None
    with page.expect_response(re.compile("/plots/.*from=")):
        page.mouse.move(box["x"] + box["width"] * 0.3, box["y"] + box["height"] / 2)
        page.mouse.down()
        page.mouse.move(box["x"] + box["width"] * 0.6, box["y"] + box["height"] / 2, steps=4)
        page.mouse.up()
    settle(page)
    asked = re.search(r"from=([\d.]+)&to=([\d.]+)", page.url)
    assert asked is not None
    start, end = map(float, asked.groups())
    assert 100 < start < end < 350  # of 500 m


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_each_run_in_the_table_has_its_curve(page, site):
    page.goto(site.of())
    expect(page.locator("td.sparkline svg[role=img] polyline")).to_have_count(14)
    row = page.get_by_role("row").filter(has=page.get_by_role("link", name=RUN))
    expect(row.get_by_role("img", name="pin wear depth / µm")).to_be_visible()


def test_scatter_plot_leads_to_runs_by_keyboard(page, site):
    page.goto(site.of("/scatter?x=load&y=k_d"))
    points = page.locator(".scatter-point")
    expect(points).to_have_count(14)
    page.get_by_label("Horizontal axis").first.select_option("predicted_depth")
    expect(page.get_by_text("runs have no predicted wear depth.")).to_be_visible()
    page.get_by_label("Horizontal axis").first.select_option("friction")
    vertical = page.get_by_role("checkbox", name="logarithmic vertical axis")
    expect(vertical).to_be_checked()  # k_D of the samples spans decades
    expect(page.get_by_role("checkbox", name="logarithmic horizontal axis")).not_to_be_checked()
    vertical.uncheck()
    assert "logy=0" in page.url
    vertical.check()
    assert "logy=1" in page.url
    legend = page.get_by_role("list", name="Materials")
    expect(legend.get_by_role("button")).to_have_count(2)
    legend.get_by_role("button", name="Si3N4 on Si3N4 (10)").click()
    expect(points).to_have_count(4)
    points.first.focus()
    page.keyboard.press("ArrowRight")
    assert page.evaluate("document.activeElement.getAttribute('tabindex')") == "0"
    chosen = page.evaluate("document.activeElement.getAttribute('href')").removeprefix("/runs/")
    page.keyboard.press("Enter")
    expect_run(page, chosen)


def test_twelve_runs_are_compared_by_what_differs(page, site, folder):
    runs = sorted(path.stem for path in folder.glob("*.h5"))[:12]
    page.goto(site.of(f"/compare?runs={','.join(runs)}"))
    settle(page)
    assert page.locator(".uplot").first.bounding_box()["y"] < 500  # what is above leaves the plot in the first screen
    table = page.get_by_role("region", name="Values of the runs side by side")
    rows = table.locator("tbody tr")
    expect(page.get_by_label("Differences only")).to_be_checked()
    few = rows.count()
    page.get_by_label("Differences only").uncheck()
    expect(table.locator("tbody tr.is-same").first).to_be_visible()
    assert rows.count() > few
    table.locator("thead").scroll_into_view_if_needed()
    table.evaluate("box => box.scrollTo(1e6, 0)")
    expect(table.get_by_role("link", name=runs[-1])).to_be_in_viewport(ratio=1)
    expect(table.get_by_role("rowheader").first).to_be_in_viewport()

    legend = page.get_by_role("list", name=re.compile("Lines of pin wear depth"))
    pins = [run for run in runs if "twin" not in run]
    expect(legend.get_by_role("button")).to_have_count(len(pins))
    legend.get_by_role("button", name=pins[0]).click()
    expect(legend.get_by_role("button", name=pins[0])).to_have_attribute("aria-pressed", "false")


@pytest.mark.parametrize("run_id", [OTHER, "si3n4-twin-disc-4pct-1000k"])
def test_run_page_has_three_screens_until_its_parts_are_opened(page, site, run_id):
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto(site.of(f"/runs/{run_id}"))
    settle(page)
    expect(page.locator(".uplot").first).to_be_visible()
    assert page.evaluate("document.documentElement.scrollHeight") <= 3 * 900
    assert page.locator("main").inner_text().count("k_D") <= 3
    expect(page.get_by_text("Status: wear coefficient identified")).to_be_visible()

    archard = "Wear coefficient (Archard's law)"
    page.get_by_role("navigation", name="On this page").get_by_role("link", name=archard).click()
    expect(page.get_by_role("table", name=re.compile("budget of k_D")).first).to_be_visible()
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    assert page.locator("details.folded:not([open])").count() == 0


PRINTED = {
    "run": (PAGES["run"], 8),
    "study": (PAGES["study"], 9),
    "compare": (f"/compare?runs={RUN},{OTHER}", 1),
}


@pytest.mark.parametrize("name", PRINTED)
def test_the_key_for_printing_waits_for_plots_that_were_out_of_sight(page, site, name):
    path, plots = PRINTED[name]
    page.add_init_script("window.print = () => { document.body.dataset.asked = true }")
    page.goto(site.of(path))
    settle(page)
    page.keyboard.press("Control+p")
    expect(page.locator("body[data-asked]")).to_be_visible(timeout=60_000)
    assert page.locator(".uplot").count() == plots
    assert page.locator(".plot-skeleton, [aria-busy=true]").count() == 0
    assert page.locator("details.folded:not([open])").count() == 0


def test_h5web_opens_on_the_wear_curve(page, site):
    page.goto(site.of(f"/runs/{RUN}"))
    page.get_by_role("link", name=re.compile("Open in viewer", re.IGNORECASE)).first.click()
    expect(page.get_by_text(f"Wear of the pin, run {RUN}")).to_be_visible()
    expect(page.get_by_text("archard_lower").first).to_be_visible()


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_pages_have_no_serious_fault_of_access(chrome, site, name, theme):
    with chrome.new_context(viewport={"width": 1280, "height": 800}, color_scheme=theme) as context:
        page = context.new_page()
        heard = complaints(page)
        page.goto(site.of(PAGES[name]))
        settle(page)
        picture(page, f"{name}-{theme}")
        found = Axe().run(page).response["violations"]
        ours = [fault for fault in found if fault["impact"] in ("serious", "critical")]
        assert [(fault["id"], [node["target"] for node in fault["nodes"]]) for fault in ours] == []
        assert heard == []


@pytest.mark.parametrize("name", PAGES)
def test_a_phone_shows_the_pages_without_scrolling_sideways(chrome, site, name):
    with chrome.new_context(viewport={"width": 390, "height": 844}, device_scale_factor=2, has_touch=True) as context:
        page = context.new_page()
        page.goto(site.of(PAGES[name]))
        settle(page)
        picture(page, f"{name}-phone")
        assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_keyboard_alone_reaches_a_run(page, site):
    page.goto(site.of())
    expect(page.get_by_role("link", name=RUN)).to_be_visible()
    for _ in range(60):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.textContent") == RUN:
            break
    page.keyboard.press("Enter")
    expect_run(page, RUN)


def test_the_archive_is_watched(chrome, folder, tmp_path):
    archive = Path(shutil.copytree(folder, tmp_path / "archive"))
    with served(archive) as address:
        page = chrome.new_page()
        heard = complaints(page)
        page.goto(address.of())
        expect(page.get_by_role("status").filter(has_text="14 of 14 runs")).to_be_visible()
        (archive / f"{OTHER}.h5").unlink()
        expect(page.get_by_role("status").filter(has_text="13 of 13 runs")).to_be_visible()
        (archive / "wc-co-water-400mN.h5").write_bytes(b"\x89HDF no more")
        expect(page.get_by_text("wc-co-water-400mN.h5").first).to_be_visible()
        page.goto(address.of(f"/runs/{RUN}"))
        expect_run(page, RUN)
        assert heard == []
        (archive / f"{RUN}.h5").unlink()
        expect(page.get_by_text("found no").first).to_be_visible()
        page.close()


def test_an_empty_archive_says_what_to_do(page, tmp_path):
    (tmp_path / "archive").mkdir()
    with served(tmp_path / "archive") as address:
        page.goto(address.of())
        expect(page.get_by_text("tribopipe ingest").first).to_be_visible()
        for path in ("/studies", "/compare"):
            page.goto(address.of(path))
            settle(page)


@pytest.mark.parametrize("run_id", ["nobody", "a\"b'c", "a/b", "../etc", "%2e%2e", "<script>alert(1)</script>"])
def test_a_run_that_is_not_there_is_told(chrome, site, run_id):
    page = chrome.new_page()
    page.on("dialog", lambda dialog: pytest.fail(f"a script ran: {dialog.message}"))
    page.goto(site.of(f"/runs/{quote(run_id, safe='')}"))
    settle(page)
    expect(page.get_by_role("link", name="Runs").first).to_be_visible()
    expect(page.get_by_role("main")).not_to_be_empty()
    page.close()


@pytest.mark.parametrize(
    "path", ["/", "/runs/{run}", "/compare?runs={run}", "/studies", "/studies/x", "/file?file={run}.h5"]
)
def test_what_a_lab_wrote_is_shown_and_never_run(chrome, hostile, path):
    with chrome.new_context() as context:
        page = context.new_page()
        heard, foreign = complaints(page), []
        page.on("dialog", lambda dialog: heard.append(f"a script ran: {dialog.message}"))
        page.on("request", lambda asked: foreign.append(asked.url) if not asked.url.startswith(hostile.base) else None)
        page.goto(hostile.of(path.format(run=RUN)))
        settle(page)
        assert page.locator("#root script, #root iframe, #root img").count() == 0
        assert heard == []
        assert [url for url in foreign if not url.startswith(("data:", "blob:"))] == []


@pytest.fixture(scope="module")
def hostile(short_runs, tmp_path_factory) -> Iterator[Address]:
    archive = hostile_archive(short_runs / RUN, tmp_path_factory.mktemp("hostile") / "archive")
    with served(archive.folder) as address:
        yield address
