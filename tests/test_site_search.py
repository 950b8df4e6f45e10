"""The search of the documentation's site leads to the right page first, as `tribopipe help QUESTION` does."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from folders import ROOT
from test_questions import ASKED, OTHERS

from tribopipe.cli.documentation import entries, has_words_of, pages_for

SITE = ROOT / "build" / "docs"
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="no node, which runs the site's search")

STUB = """
const Search = {
  _index: { docnames: PAGES, titles: PAGES, filenames: PAGES },
  _parseQuery: (query) => [query],
  _performSearch: () => [["another", "", "", null, 5, "", "text"]],
  setIndex: () => {},
};
"""


def found(site: Path, questions: list[str]) -> dict[str, list[str]]:
    """Return the pages that a site finds, the first first."""
    command = ["node", str(ROOT / "tests" / "site_search.js"), str(site)]
    asked = subprocess.run(command, input=json.dumps(questions), capture_output=True, text=True, check=True)
    return json.loads(asked.stdout)


@needs_node
def test_the_site_puts_those_pages_first_that_help_names(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(ROOT / "docs")
    from site_parts.questions import questions_json

    script = (ROOT / "docs" / "_static" / "questions.js_t").read_text(encoding="utf-8")
    (tmp_path / "_static").mkdir()
    (tmp_path / "_static" / "questions.js").write_text(
        script.replace("{{ questions }}", questions_json()), encoding="utf-8"
    )
    stub = STUB.replace("PAGES", json.dumps(list(entries())))
    (tmp_path / "_static" / "searchtools.js").write_text(stub, encoding="utf-8")
    # Of words that are in no entry, `help` takes a similar one, and the site none.
    known = [question for question in [*ASKED, *OTHERS] if has_words_of(question)]
    assert len(known) > 25
    answers = found(tmp_path, [*known, "xyzzy", "constructor"])
    for question in known:
        assert answers[question] == [*pages_for(question)[:3], "another"], question
    assert answers["xyzzy"] == answers["constructor"] == ["another"]


@pytest.mark.slow
@needs_node
@pytest.mark.skipif(not (SITE / "searchindex.js").is_file(), reason="no build/docs, which .ci/run builds")
def test_plain_questions_lead_to_the_right_page_first():
    answers = found(SITE, list(ASKED))
    wrong = {question: answers[question][:3] for question, right in ASKED.items() if answers[question][:1] != [right]}
    assert len(ASKED) - len(wrong) >= 23, wrong
