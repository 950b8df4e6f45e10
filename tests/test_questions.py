"""Questions as people type them: `tribopipe help` and the site lead to the right page first.

They were written before the index in docs/questions.toml, and not with its words.
"""

import pytest
from folders import ROOT

from tribopipe.cli.documentation import entries, page, pages, pages_for, stem, title, weights

ASKED = {
    "my disc wears but not the ball": "both_bodies",
    "how do i cite this": "cite",
    "export to excel": "spreadsheets",
    "what is k_D": "glossary",
    "thermal drift warm up": "depth_drifts",
    "decimal comma file": "new_run",
    "how many repeats": "replicates",
    "predict wear at another load": "process",
    "what does ± mean": "uncertainty",
    "file damaged": "reliability",
    "jupyter": "notebook",
    "origin": "spreadsheets",
    "run without scar measured": "amend",
    "twin disc slip": "twin_disc",
    "units of wear coefficient": "published_values",
    "reciprocating": "reciprocating",
    "friction coefficient noisy": "friction_trace",
    "compare two laws": "studies",
    "where are results stored": "archive",
    "undo a removed run": "archive",
    "share an archive with a colleague": "fair",
    "temperature drift": "depth_drifts",
    "several tests in one file": "new_run",
    "spike in depth signal": "clean_up",
    "cluster": "cluster",
}
OTHERS = {
    "how accurate is my wear coefficient": "uncertainty",
    "typo in run.toml after archiving": "amend",
    "my csv is not recognized": "readers",
    "install": "tutorial",
    "look at results in chrome": "browse",
    "i weighed the disc before and after": "end_values",
    "find all runs with steel": "listing",
    "friction is negative": "friction_trace",
    "why does wear change during running in": "giwm",
    "does it work with an oil film": "not_covered",
    "fretting": "not_covered",
    "latex table": "spreadsheets",
    "evaluate new files every night automatically": "watch",
    "computer ran out of memory": "long_runs",
    "finite element abaqus": "umeshmotion",
    "zenodo upload": "fair",
    "pdf for my supervisor": "report",
    "is archard valid for my data": "studies",
    "vary the load in a loop": "sweep",
    "generate fake data for testing": "simulate",
    "see wear while the test is running": "live",
    "error code 3": "shell",
    "how fast is it for 1000 runs": "performance",
    "hardness and dimensionless K": "published_values",
    "elabftw": "fair",
    "standard deviation between experiments": "replicates",
    "tab completion in the terminal": "shell",
    "only a microscope picture of the scar, no sensor": "scar_only",
    "python api": "notebook",
    "pressure is not uniform": "local_wear",
}


@pytest.mark.parametrize(("asked", "least"), [(ASKED, 25), (OTHERS, 30)], ids=["25 of users", "30 others"])
def test_plain_questions_lead_to_the_right_page_first(asked, least):
    found = {question: pages_for(question)[:3] for question in asked}
    wrong = {question: found[question] for question, right in asked.items() if found[question][:1] != [right]}
    assert len(asked) - len(wrong) >= least, wrong


def test_every_page_has_its_questions_and_each_leads_back_to_it():
    assert entries().keys() == set(pages())
    for name, entry in entries().items():
        assert all(name in pages_for(question)[:3] for question in entry.questions), name


def test_a_word_without_its_ending_is_one_word():
    assert {stem("spike"), stem("spikes")} == {"spik"}
    assert stem("running") == stem("run") == "run"
    assert stem("bed") == "bed"


def test_rare_words_count_for_more():
    known = weights()
    assert max(known["abaqu"].values()) > max(known["wear"].values())


def test_help_shows_page_answer_and_command(run_cli):
    shown = run_cli("help", "export", "to", "excel").stdout
    assert shown.splitlines()[0] == title("spreadsheets")
    assert "tribopipe export runs -o runs.xlsx" in shown
    assert "Read docs/spreadsheets.md: `tribopipe help spreadsheets`" in shown
    assert run_cli("help", "exprot to excle").stdout == shown


def test_names_of_pages_and_commands_go_before_questions(run_cli):
    assert run_cli("help", "cluster").stdout.rstrip() == page("cluster").rstrip()
    refused = run_cli("help", "xyzzy qwfpg")
    assert (refused.exit_code, refused.stdout) == (1, "")


def test_the_site_has_a_heading_for_each_question(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    from site_parts.questions import questions_page

    shown = questions_page()
    for name, entry in entries().items():
        assert all(f"\n## {question}\n" in shown.replace("\\", "") for question in entry.questions)
        assert f"](../{name}.md)" in shown
