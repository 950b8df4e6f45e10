"""Reports as someone gets them by mail: what they say, that they hold it all, and that what a lab wrote stays text."""

import re
import shutil
from collections import Counter
from dataclasses import dataclass, field, replace
from html.parser import HTMLParser
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from folders import SAMPLES, replace_in
from hostile_runs import HOSTILE, QUICK, SCRIPT, hostile_archive
from study_runs import AGAIN, HEAVY, LIGHT, NO_END

from tribopipe.archive.store import Archive
from tribopipe.base.errors import ArchiveError
from tribopipe.base.units import pretty, show
from tribopipe.cli.process_table import show_processed
from tribopipe.documents.manifest import read_manifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.recipe import Recipe, WearRecipe
from tribopipe.documents.study import Study
from tribopipe.pipeline.stages import advance, ingest
from tribopipe.pipeline.studies import run_study
from tribopipe.results.evaluation import FrictionFit
from tribopipe.results.study import AGREEMENT
from tribopipe.views.canvas import ShownFigure
from tribopipe.views.html.document import Stated, merged, options_used, run_report, study_report
from tribopipe.views.html.document import test_sentence as sentence_on_tests
from tribopipe.views.html.rendering import _symbols, inline_svg, mathml
from tribopipe.views.page import probability
from tribopipe.views.required_report_items import _mean, reporting_items
from tribopipe.views.run_page import run_page
from tribopipe.views.study_page import study_page

pytestmark = pytest.mark.usefixtures("few_draws")
VOID = {"meta", "br", "img"}
LOADING = {"script", "iframe", "object", "embed", "link", "base", "form", "img", "foreignobject", "animate", "set"}


@dataclass
class Element:
    """One element, with its attributes and all text within it."""

    tag: str
    attributes: dict[str, str]
    text: str = ""
    children: list["Element"] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.classes = self.attributes.get("class", "").split()


class Page(HTMLParser):
    """A document taken apart; fails where elements are not closed in the order in which they were opened."""

    def __init__(self, document: str) -> None:
        super().__init__(convert_charrefs=True)
        self.stack: list[Element] = []
        self.elements: list[Element] = []
        self.feed(document)
        self.close()
        assert self.stack == []

    def handle_starttag(self, tag, attrs):
        assert len(attrs) == len(dict(attrs)), (tag, attrs)
        element = Element(tag, {name: value or "" for name, value in attrs})
        self.elements.append(element)
        if self.stack:
            self.stack[-1].children.append(element)
        if tag not in VOID:
            self.stack.append(element)

    def handle_endtag(self, tag):
        assert self.stack.pop().tag == tag

    def handle_data(self, data):
        for element in self.stack:
            element.text += data

    def all(self, *tags: str) -> list[Element]:
        return [element for element in self.elements if element.tag in tags]

    @property
    def text(self) -> str:
        (body,) = self.all("body")
        return " ".join(body.text.split())


def assert_inert(page: Page) -> None:
    """Nothing in the page runs, and nothing is loaded from anywhere."""
    assert not {element.tag for element in page.elements} & LOADING
    for element in page.elements:
        for name, value in element.attributes.items():
            assert not name.startswith("on"), element
            assert "javascript:" not in value.lower() or name == "aria-label", element
            assert name != "src", element
            if name == "href":
                assert value.startswith(("#", "data:image/png;base64,")), element
            assert not re.search(r"url\((?!#)", value), element
    for style in page.all("style"):
        assert not re.search(r"url\(|@import|expression", style.text)
    (policy,) = [meta for meta in page.all("meta") if "http-equiv" in meta.attributes]
    assert policy.attributes["http-equiv"] == "Content-Security-Policy"
    assert policy.attributes["content"].startswith("default-src 'none'; style-src 'unsafe-inline'; img-src data:")


def assert_readable(page: Page) -> None:
    """Headings in order, tables with captions and scopes, figures with names, references to what is there."""
    levels = [int(heading.tag[1]) for heading in page.all("h1", "h2", "h3", "h4", "h5", "h6")]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(later <= earlier + 1 for earlier, later in pairwise(levels))
    for table in page.all("table"):
        assert table.children[0].tag == "caption"
        assert table.children[1].tag == "thead"
    assert all("scope" in head.attributes for head in page.all("th"))
    assert all(svg.attributes["role"] == "img" and svg.attributes["aria-label"] for svg in page.all("svg"))
    assert [html.attributes["lang"] for html in page.all("html")] == ["en"]
    ids = Counter(element.attributes["id"] for element in page.elements if "id" in element.attributes)
    assert max(ids.values()) == 1
    told = [value for element in page.elements for value in element.attributes.values()]
    assert {name for value in told for name in re.findall(r"url\(#([^)]*)\)", value)} <= set(ids)
    links = [element.attributes["href"] for element in page.elements if "href" in element.attributes]
    assert {link[1:] for link in links if link.startswith("#")} <= set(ids)


def flat(text: str) -> str:
    """Write symbols as their text is once the subscript is an element."""
    return " ".join(re.sub(r"\b([kEFRKha])_(D|n|N|P|Ic|end|d|p|s|x|z|c)\b", r"\1\2", text).split())


# --- a study ---


@pytest.fixture(scope="module")
def studied(filled, tmp_path_factory) -> Archive:
    """Two runs that identify k_D, one that is predicted, and one without an end value, which nothing is fitted to."""
    folder = tmp_path_factory.mktemp("studied") / "archive"
    folder.mkdir()
    for run_id in (LIGHT, AGAIN, HEAVY, NO_END):
        shutil.copy(filled / f"{run_id}.h5", folder)
    archive = Archive(folder)
    advance(archive, LIGHT, "specific_wear", QUICK)
    for law in ("archard", "sarkar"):
        advance(archive, LIGHT, f"wear_fit_{law}", QUICK)
    study = Study(id="air", title="Three runs in air", fit=(LIGHT, AGAIN), predict=(HEAVY,))
    assert [outcome for outcome in run_study(archive, study, QUICK) if outcome.status == "failed"] == []
    return archive


@pytest.fixture(scope="module")
def study_text(studied) -> str:
    return study_report(studied, "air")


@pytest.fixture(scope="module")
def study_html(study_text) -> Page:
    return Page(study_text)


@pytest.mark.slow
def test_study_report_is_inert_and_readable(study_html):
    assert_inert(study_html)
    assert_readable(study_html)
    assert "http" not in study_html.text
    assert [title.text for title in study_html.all("title")] == ["Three runs in air"]


def test_study_report_says_k_d_and_verdicts_as_the_archive_holds_them(studied, study_html):
    page = study_page(studied, "air")
    for law in page.laws:
        assert flat(law.title) in study_html.text
        for line in law.agreement:
            assert flat(line.sentence) in study_html.text
        for table in law.tables:
            for row in table.rows:
                assert all(flat(cell) in study_html.text for cell in row)
    assert all(flat(sentence)[1:] in study_html.text for sentence in page.sentences)
    verdicts = [span.text.strip() for span in study_html.all("span") if "outcome" in span.classes]
    told = [line.outcome for law in page.laws for line in law.agreement]
    assert Counter(verdicts) == Counter(told + told)


_UNITS = {
    "m": ("um", "mm", "m", "nm"),
    "N": ("mN", "N"),
    "m^3": ("mm^3", "um^3"),
    "m/s": ("nm/min", "mm/s", "m/s"),
    "m^2/N": ("mm^3/(N*mm)", "mm^3/(N*m)"),
    "Pa": ("GPa", "MPa"),
    "1": ("1", "%"),
}
_WITH_U = re.compile(r"\(?-?[\d.]+ ± [\d.]+(?:\)×10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")


def known_uncertainties(archive: Archive) -> set[str]:
    """Write every quantity of the archive with its standard uncertainty, in each unit in which it may be shown."""
    runs = [archive.outline(run_id) for run_id in archive.ids()]
    records = [archive.study("air").result, *(run.manifest for run in runs)]
    records += [step.result for run in runs for step in archive.steps(run.manifest.id).values()]
    return {
        show(one["value"], one["standard_uncertainty"], one["unit"], unit).removesuffix(pretty(unit)).strip()
        for record in records
        for one in quantities(record.model_dump())
        for unit in _UNITS.get(one["unit"], (one["unit"],))
    }


def quantities(node) -> list[dict]:
    """Return all quantities with a standard uncertainty within what a record holds."""
    if isinstance(node, dict):
        own = [node] if node.get("standard_uncertainty") and "unit" in node else []
        return own + [one for part in node.values() for one in quantities(part)]
    return [one for part in node for one in quantities(part)] if isinstance(node, list | tuple) else []


@pytest.mark.slow
def test_what_follows_a_plus_minus_is_a_standard_uncertainty(studied, study_html, run_cli):
    known = known_uncertainties(studied) | {initial_friction(studied, run_id) for run_id in (LIGHT, AGAIN)}
    text = study_html.text
    for svg in study_html.all("svg"):  # where formulas have each letter on its own
        text = text.replace(" ".join(svg.text.split()), "")
    pages = {"report": text, "study": repr(study_page(studied, "air"))}
    pages |= {run_id: repr(run_page(studied, run_id)) for run_id in (LIGHT, HEAVY, NO_END)}
    shown = (("study", "show", "air"), ("show", LIGHT), ("show", LIGHT, "-v"), ("show", NO_END, "-v"))
    pages |= {" ".join(words): run_cli(*words, "--archive", studied.folder).stdout for words in shown}
    found = {name: set(_WITH_U.findall(text)) for name, text in pages.items()}
    assert all(len(one) > 5 for one in found.values())
    others = {name: found[name] - known for name in pages}
    assert others == {name: set() for name in pages}


@pytest.mark.slow
def test_what_follows_a_plus_minus_in_tables_is_a_standard_uncertainty(studied, run_cli, capsys):
    records = [studied.study("air").result, *(studied.outline(run_id).manifest for run_id in studied.ids())]
    records += [step.result for run_id in studied.ids() for step in studied.steps(run_id).values()]
    known = [one for record in records for one in quantities(record.model_dump())]
    listed = run_cli("ls", "--archive", studied.folder, "--columns", ",".join(_WITH_U_IN_LS)).stdout
    show_processed(studied, studied.ids(), [studied.study("air").result])
    tables = {"ls": listed, "process": capsys.readouterr().out}
    for name, text in tables.items():
        pairs = _PAIR.findall(text)
        assert len(pairs) > 1, text
        assert "± is one standard uncertainty" in text, name
        assert [pair for pair in pairs if not any(is_rounded(pair, one) for one in known)] == [], (name, text)


_PAIR = re.compile(r"(-?\d+(?:\.\d+)?) ± (\d+(?:\.\d+)?)")
_WITH_U_IN_LS = ("id", "load", "friction", "k_d", "k_d_sarkar", "end_depth", "predicted_depth", "wear_volume")


def is_rounded(pair: tuple[str, str], quantity: dict) -> bool:
    """Whether a number with an uncertainty is a quantity in some power of ten of its unit, rounded."""
    value, spread = map(float, pair)
    half = 0.51 * 10.0 ** -len(pair[1].partition(".")[2])
    scale = 10.0 ** np.round(np.log10(spread / quantity["standard_uncertainty"])) if spread else 0.0
    found = scale * quantity["value"], scale * quantity["standard_uncertainty"]
    return bool(np.all(np.abs(np.subtract((value, spread), found)) <= half))


def initial_friction(archive: Archive, run_id: str) -> str:
    """Write μ at the start, A + b, whose uncertainties are correlated."""
    fit = archive.result(run_id, "friction_fit", FrictionFit)
    return show(fit.amplitude.value + fit.steady_state.value, np.sum(np.asarray(fit.covariance)[:2, :2]) ** 0.5, "1")


def test_study_report_holds_budgets_figures_and_equations(study_html):
    captions = [caption.text for caption in study_html.all("caption")]
    assert [caption.split()[2] for caption in captions if "budget" in caption.lower()] == [f"{LIGHT},"] * 2
    assert [f"Table {number}." for number in range(1, len(captions) + 1)] == [
        caption.partition(". ")[0] + "." for caption in captions
    ]
    figures = [caption.text.partition(".")[0] for caption in study_html.all("figcaption")]
    assert figures == [f"Figure {number}" for number in range(1, 5)]
    assert len(study_html.all("svg")) == 4
    numbers = [span.text for span in study_html.all("span") if "number" in span.classes]
    assert numbers == ["(Eq. 7)", "(Eq. 1)", "(Eq. 2)", "(Eq. 3)", "(Eq. 4)", "(Eq. 5)", "(Eq. 6)"]
    assert "A predictive modeling scheme for wear in tribometers" in study_html.text
    assert "JCGM 101:2008" in study_html.text


def test_study_report_traces_back_to_the_source_files(studied, study_html):
    for run_id in (LIGHT, AGAIN, HEAVY):
        page = run_page(studied, run_id)
        assert page.raw_sha256 in study_html.text
        assert all(source.sha256 in study_html.text for source in page.sources)
    assert study_page(studied, "air").inputs_sha256[:16] in study_html.text
    assert "Options other than the defaults: monte_carlo.significant_digits." in study_html.text


def test_reporting_items_are_reported_or_missing_with_their_key(studied, study_html):
    (table,) = [one for one in study_html.all("table") if "ASTM G99" in one.children[0].text]
    told = " ".join(table.text.split())
    for item in reporting_items(studied, LIGHT):
        assert item.name in told
        assert item.value is None or item.value in told
    assert "missing: add conditions.relative_humidity to run.toml" in told
    assert "missing: add conditions.track_radius to run.toml" in told
    assert f"200.0 ± 2.0 mN ({LIGHT}, {AGAIN})" in told
    assert "2 runs; between-run scatter of k_D:" in told


@pytest.mark.slow
def test_the_same_archive_gives_the_same_report(studied, study_text):
    assert study_report(studied, "air") == study_text


def test_a_run_taken_out_of_the_archive_is_named(studied, tmp_path):
    copied = Archive(Path(shutil.copytree(studied.folder, tmp_path / "archive")))
    copied.path(HEAVY).unlink()
    with pytest.raises(ArchiveError, match=f"found no run '{HEAVY}'"):
        study_report(copied, "air")


# --- runs ---


@pytest.mark.slow
def test_run_report_says_what_each_step_found(studied):
    page = Page(run_report(studied, [LIGHT]))
    assert_inert(page)
    assert_readable(page)
    for stage in run_page(studied, LIGHT).stages:
        assert flat(stage.sentence)[1:] in page.text
        assert all(flat(fact.value) in page.text for fact in stage.facts)
    assert [svg.attributes["aria-label"].partition(":")[0] for svg in page.all("svg")] == [LIGHT] * 3
    assert {f"figure-{number}-0" for number in (1, 2, 3)} < {element.attributes.get("id") for element in page.elements}


@pytest.mark.slow
def test_report_of_several_runs_has_each_in_its_contents(studied):
    page = Page(run_report(studied, [LIGHT, NO_END, LIGHT]))
    assert_inert(page)
    assert_readable(page)
    (contents,) = page.all("nav")
    assert re.findall(r"Run (\S+)", contents.text) == [LIGHT, NO_END]


def test_loads_and_speeds_of_several_runs_are_in_the_same_order(studied):
    light, heavy = (studied.outline(one) for one in (LIGHT, HEAVY))
    slow = heavy.manifest.conditions.model_copy(update={"sliding_speed": Quantity(value=0.1, unit="m/s")})
    slower = replace(heavy, manifest=heavy.manifest.model_copy(update={"conditions": slow}))
    for runs in ([light, slower], [slower, light]):
        assert re.search(r"under a load of \S+ mN and \S+ mN, .* at 400 mm/s and 100 mm/s\.", sentence_on_tests(runs))


def test_an_id_at_the_start_of_a_sentence_stays_as_it_is(studied, monkeypatch):
    sentences = ("pod: AIC favors Archard's law", "note: only one run")
    monkeypatch.setattr("tribopipe.views.study_page._sentences", lambda _: sentences)
    page = Page(study_report(studied, "air"))
    assert "pod: AIC favors" in page.text
    assert "Note: only one run" in page.text


@pytest.mark.slow
def test_run_without_a_fit_says_what_it_lacks(studied):
    in_two_steps = QUICK.model_copy(update={"wear": WearRecipe(correction="two-step")})
    advance(studied, NO_END, "wear_fit_archard", in_two_steps)
    page = Page(run_report(studied, [NO_END]))
    assert_readable(page)
    assert "no wear coefficient: missing a post-test measurement of the pin" in page.text
    assert "kD not determined. Missing: a post-test measurement of the pin" in page.text
    assert "missing: add end_values.pin_scar_diameter to run.toml" in page.text
    assert "Drift of the depth sensor" not in page.text
    assert "(Eq. 3)" not in page.text


@pytest.mark.slow
def test_run_report_counts_findings_and_calls_a_warning_a_warning(studied):
    advance(studied, NO_END, "wear_fit_archard", QUICK)
    found = [finding.severity for finding in run_page(studied, NO_END).findings]
    assert "warning" in found
    page = Page(run_report(studied, [NO_END]))
    counts = [(found.count(name), name) for name in ("warning", "note") if name in found]
    told = ", ".join(f"{count} {name}{'s' * (count > 1)}" for count, name in counts)
    assert f"{told}; see below." in page.text
    assert "Note: warning:" not in page.text
    assert "Warning: end_values: found no post-test measurement" in page.text


def test_small_p_values_have_a_power_of_ten():
    assert [probability(p) for p in (0.5, 0.00014, 1.861e-21, 0.0)] == ["0.5", "0.00014", "1.9×10⁻²¹", "0"]


def test_run_as_recorded_is_reported_without_results(sample_run, tmp_path):
    archive = Archive(tmp_path / "archive")
    replace_in(sample_run / "run.toml", r"(?s)\[contact\].*?(?=\[conditions\])", "")
    replace_in(sample_run / "run.toml", r"(?s)\[end_values\].*?(?=\[sensors\])", "")
    run_id = ingest(sample_run, archive).run_id
    page = Page(run_report(archive, [run_id]))
    assert_inert(page)
    assert_readable(page)
    assert "Not evaluated yet" in page.text
    assert "missing: add contact.pin.material to run.toml" in page.text
    assert page.all("svg") == []


def test_mean_speed_of_strokes_counts_both_directions(bare_run):
    signed = replace(
        bare_run, columns={"sliding_speed": np.array([0.1, -0.1, np.nan])}, origins={"sliding_speed": "measured"}
    )
    assert _mean(signed, "sliding_speed") == "100 mm/s, mean of the recording"


@pytest.mark.slow
def test_two_discs_have_their_own_items_and_equations(disc_pair):
    page = Page(run_report(disc_pair, ["si3n4-twin-disc-4pct-100k"]))
    assert_inert(page)
    assert_readable(page)
    assert "wear volume of the crowned disc" in page.text
    assert "(Eq. 14 a)" in page.text
    assert "(Eq. 11)" not in page.text


@pytest.mark.slow
@pytest.mark.parametrize("run_id", ["si3n4-air-200mN", "si3n4-twin-disc-4pct-100k"])
def test_every_missing_item_names_a_key_that_run_toml_has(run_id, tmp_path):
    manifest, _ = read_manifest(SAMPLES / run_id / "run.toml")
    archive = Archive(tmp_path)
    ingest(SAMPLES / run_id, archive)
    for item in reporting_items(archive, run_id):
        part, name = manifest, item.key
        while "." in name and not name.startswith("signals."):
            step, _, name = name.partition(".")
            part = getattr(part, step)
        known = {"fit", "signals.columns.friction_force", "signals.columns.time", *type(part).model_fields}
        assert name in known, item


# --- what a lab wrote ---


@pytest.fixture
def hostile(short_runs, tmp_path) -> Archive:
    return hostile_archive(short_runs / "si3n4-air-200mN", tmp_path / "archive")


@pytest.mark.slow
def test_what_a_lab_wrote_stays_text(hostile):
    shown = " ".join(HOSTILE.split())
    for document in (run_report(hostile, ["si3n4-air-200mN"]), study_report(hostile, "x")):
        page = Page(document)
        assert_inert(page)
        assert_readable(page)
        assert page.text.count(shown) >= 12
        assert [title.text for title in page.all("title")] == [HOSTILE]
        assert f"si3n4-air-200mN is marked bad: {shown}" in page.text
        assert "a\ufffdb\ufffd[31m\ufffdturned" in page.text


@pytest.mark.filterwarnings("ignore:Glyph 11")
def test_markup_in_a_figure_stays_text():
    figure = ShownFigure()
    figure.suptitle(HOSTILE.replace("$", "") + "\x0b", gid=HOSTILE)
    figure.add_subplot().plot([0, 1], label="x", gid='"><script>', url="https://example.org")
    page = Page(f"<body>{inline_svg(figure, 'one', HOSTILE)}</body>")
    assert SCRIPT in page.text
    assert not {element.tag for element in page.elements} & (LOADING | {"a", "metadata", "style"})
    assert all(element.attributes.get("href", "#").startswith("#") for element in page.elements)


def test_pictures_within_a_figure_come_along():
    figure = ShownFigure()
    figure.add_subplot().pcolormesh(np.eye(3), rasterized=True)
    (picture,) = Page(inline_svg(figure, "one", "a map")).all("image")
    assert picture.attributes["href"].startswith("data:image/png;base64,iVBOR")


# --- its parts ---


def test_equations_are_mathml():
    assert mathml(r"k_D = \frac{V}{F_N^2}, \quad \text{<b>}") == (
        '<math display="block"><mrow><msub><mi>k</mi><mi>D</mi></msub><mo>=</mo><mfrac><mrow><mi>V</mi></mrow><mrow>'
        "<msubsup><mi>F</mi><mi>N</mi><mn>2</mn></msubsup></mrow></mfrac><mo>,</mo>"
        '<mspace width="1.5em"></mspace><mtext>&lt;b&gt;</mtext></mrow></math>'
    )


def test_parentheses_are_as_tall_as_a_letter_unless_a_fraction_is_between_them():
    assert mathml("( t )").count('<mo stretchy="false">') == 2
    assert "<mo>(</mo><mfrac>" in mathml(r"\left( \frac{b}{2} \right)")


def test_symbols_of_the_methods_have_subscripts():
    assert _symbols("h_d and h_p of k_D") == "h<sub>d</sub> and h<sub>p</sub> of k<sub>D</sub>"


def test_numbers_stay_on_one_line_with_uncertainty_and_unit():
    told = _symbols("k_D = (7.47 ± 0.12)×10⁻⁹ mm³/(N·mm), 95 % CI: (7.23 to 7.70)×10⁻⁹ mm³/(N·mm), 2 runs to go")
    assert told.replace("\u00a0", "_") == (
        "k<sub>D</sub> = (7.47_±_0.12)×10⁻⁹_mm³/(N·mm), 95_% CI: (7.23_to_7.70)×10⁻⁹_mm³/(N·mm), 2 runs to go"
    )


def test_every_agreement_has_its_color_in_a_report():
    css = (files("tribopipe.views.html") / "templates" / "report.css").read_text()
    assert all(f".{word} " in css or f".{word}," in css for word in AGREEMENT.values())


def test_what_runs_state_is_put_together():
    found = merged(
        {
            "a": [Stated("test", "load", "1 N"), Stated("pin", "material", "x")],
            "b": [Stated("test", "load", "2 N"), Stated("test", "speed", None), Stated("pin", "material", "x")],
        }
    )
    assert found == [
        ("test", "load", {"1 N": ("a",), "2 N": ("b",)}),
        ("test", "speed", {None: ("b",)}),
        ("pin", "material", {"x": ("a", "b")}),
    ]


def test_options_say_what_differs_from_the_defaults():
    other = Recipe(wear=WearRecipe(correction="two-step")).model_dump(mode="json", by_alias=True)
    usual = Recipe().model_dump(mode="json", by_alias=True)
    told = {"one": {"wear": other["wear"], "drift": other["drift"]}, "other": {"wear": usual["wear"]}}
    found = options_used(told)
    (changed,) = [option for option in found if option.changed]
    assert changed == ("wear.correction", "two-step", "model", ("one",))
    prior = next(option for option in found if option.name == "drift.prior")
    assert prior == ("drift.prior", "2.5×10⁻⁷ m", "2.5×10⁻⁷ m", ())


# --- the command ---


@pytest.mark.slow
def test_command_writes_one_file_and_replaces_none_unless_told(run_cli, studied, tmp_path):
    name = f"{NO_END}.html"
    done = run_cli("report", NO_END, "--archive", studied.folder, cwd=tmp_path)
    assert (done.exit_code, done.stderr) == (0, f"{NO_END}: report written to {name}\n")
    written = (tmp_path / name).read_bytes()
    assert written == run_report(studied, [NO_END]).encode()
    (tmp_path / name).write_bytes(b"mine")
    again = run_cli("report", NO_END, "--archive", studied.folder, cwd=tmp_path)
    assert again.exit_code == 1
    assert again.stderr == f"error: {name}: found an existing file; expected a new file; use --force to replace it\n"
    assert (tmp_path / name).read_bytes() == b"mine"
    forced = run_cli("report", NO_END, "--archive", studied.folder, "--force", cwd=tmp_path)
    assert forced.exit_code == 0
    assert (tmp_path / name).read_bytes() == written


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["ari"], "found no run or study 'ari'; expected the ID of an archived run or study; did you mean 'air'?"),
        (["../air"], "found no run or study '../air'; expected the ID of an archived run or study"),
        (["air", LIGHT], "found the study 'air' among several IDs; expected only runs, or a single study"),
        ([LIGHT, "-o", "."], "found a folder; expected the path of a file"),
    ],
)
def test_command_says_in_one_sentence_what_is_wrong(run_cli, studied, tmp_path, arguments, told):
    failed = run_cli("report", *arguments, "--archive", studied.folder, cwd=tmp_path)
    assert failed.exit_code == 1
    assert failed.stderr.count("\n") == 1
    assert told in failed.stderr
    assert list(tmp_path.iterdir()) == []


def test_study_wins_over_a_run_of_its_id_unless_told(run_cli, studied, tmp_path, monkeypatch):
    folder = Path(shutil.copytree(studied.folder, tmp_path / "archive"))
    shutil.copy(folder / "studies" / "air.h5", folder / "studies" / f"{NO_END}.h5")
    monkeypatch.setattr("tribopipe.views.html.document.study_report", lambda _, name, **_how: f"study {name}")
    monkeypatch.setattr("tribopipe.views.html.document.run_report", lambda _, names, **_how: f"run {names[0]}")
    for options, kind in (([], "study"), (["--run"], "run")):
        run_cli("report", NO_END, *options, "--archive", folder, "-o", tmp_path / "r.html", "--force")
        assert (tmp_path / "r.html").read_text(encoding="utf-8") == f"{kind} {NO_END}"
