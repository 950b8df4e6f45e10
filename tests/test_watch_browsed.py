"""Runs of a watched folder appear in `tribopipe browse` by themselves, and nothing that a person has chosen is lost."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from serving import served
from watch_bench import Bench, export

pytest.importorskip("playwright.sync_api")

from axe_playwright_python.sync_playwright import Axe
from browsing import browser, chromium, complaints
from playwright.sync_api import Page, expect

pytestmark = [
    pytest.mark.usefixtures("few_draws"),
    pytest.mark.slow,
    pytest.mark.skipif(chromium() is None and "CI" not in os.environ, reason="needs Chromium"),
]
BEFORE = 20


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Bench:
    """A lab in which some exports were watched already."""
    bench = Bench(tmp_path_factory.mktemp("lab"))
    drop(bench, range(BEFORE))
    return bench


def drop(bench: Bench, numbers: range) -> None:
    for number in numbers:
        bench.put(f"test_{number:02}.csv", export(number, rows=30))
    assert [kind for kind, *_ in bench.settled()].count("done") == len(numbers)


@pytest.fixture
def page() -> Iterator[Page]:
    """A page of which nothing may be complained."""
    with browser() as chrome:
        shown = chrome.new_page(viewport={"width": 1280, "height": 640})
        heard = complaints(shown)
        yield shown
        assert heard == []


def test_new_runs_appear_by_themselves(bench, page):
    with served(bench.lab.archive) as address:
        page.goto(address.of("/?sort=-id"))
        count = page.get_by_role("status").filter(has_text="runs")
        expect(count).to_have_text(f"{BEFORE} of {BEFORE} runs")
        page.get_by_role("checkbox", name="Select test_05").check()
        page.get_by_label("Search").fill("test")
        box = page.get_by_role("region", name="Runs")
        box.evaluate("box => { box.scrollTop = 120; box.parentElement.dataset.kept = 'yes'; }")
        drop(bench, range(BEFORE, BEFORE + 3))
        expect(count).to_have_text(f"{BEFORE + 3} of {BEFORE + 3} runs", timeout=15_000)
        expect(page.get_by_role("checkbox", name=f"Select test_{BEFORE + 2}")).to_have_count(1)
        assert page.get_by_role("link", name="test_").first.text_content() == f"test_{BEFORE + 2}"
        assert box.evaluate("box => [box.scrollTop, box.parentElement.dataset.kept]") == [120, "yes"]
        expect(page.get_by_role("link", name="Compare 1")).to_be_visible()
        assert page.get_by_label("Search").input_value() == "test"
        assert Axe().run(page).violations_count == 0
        if "SCREENSHOTS" in os.environ:
            page.screenshot(path=Path(os.environ["SCREENSHOTS"]) / "watched.png")
