"""How the documentation is built: `python -m sphinx -W -n -b html docs build/docs`.

Sphinx renders the docstrings and checks every link and name; MyST has it read the pages as Markdown, which reads well
in the repository too; furo is a theme for narrow, wide, light and dark screens. Nothing is loaded from the network.
Screenshots are on the pages where `python docs/make_screenshots.py` took them before.
"""

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from tribopipe.documents.record import Record
from tribopipe.version import VERSION

HERE = Path(__file__).parent
_ANNOTATED = re.compile(r"Annotated\[(\w+), .*?\)\]")
_NAMING_A_FILE = re.compile(r"\[((?:[\w-]+/)*[\w-]+\.md)\]\(\1(#[\w-]+)?\)")
sys.path.insert(0, str(HERE))

from site_parts.mathml import as_mathml  # noqa: E402
from site_parts.offline import refuse_network  # noqa: E402
from site_parts.pages import write_reference  # noqa: E402
from site_parts.questions import questions_json  # noqa: E402
from site_parts.screenshots import as_far_as_taken  # noqa: E402

if TYPE_CHECKING:
    from sphinx.application import Sphinx

project = "tribopipe"
author = "The tribopipe developers"
project_copyright = "The tribopipe developers, MIT license"
version = release = VERSION

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx_copybutton"]
exclude_patterns = ["**/.ipynb_checkpoints"]
nitpicky = True
# Names of other libraries, whose inventories would have to come from the network, and type variables.
_OTHERS = (
    r"(collections|datetime|h5py|matplotlib|np|numpy|os|pandas|pathlib|pydantic|typing)\..*|Figure|DataFrame|Series.*"
)
_VARIABLES = r"tribopipe\.(archive\.run_files\.R|base\.tasks\.(Task|Answer))"
# What each kind of contact answers, which no user calls.
_PROTOCOLS = r"tribopipe\.contacts\.wear\.(ContactWear|State)"
nitpick_ignore_regex = [("py:.*", f"{_OTHERS}|{_VARIABLES}|{_PROTOCOLS}")]

myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
copybutton_exclude = ".linenos, .gp, .go"

autodoc_member_order = "bysource"
autodoc_default_options = {"exclude-members": "model_config"}
autodoc_typehints_format = "short"
maximum_signature_line_length = 78
add_module_names = False
default_role = "code"
smartquotes = False

html_theme = "furo"
html_title = f"tribopipe {VERSION}"
html_static_path = ["_static"]
html_css_files = ["tribopipe.css"]
html_context = {"questions": questions_json()}
html_math_renderer = "mathml"
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}


def with_plain_signatures(
    _app: "Sphinx", _what: str, _name: str, thing: object, _options: object, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Leave out of signatures how an argument is checked, and the fields of a record: they stand in a table."""
    if isinstance(thing, type) and issubclass(thing, Record):
        return "", None
    return signature and _ANNOTATED.sub(r"\1", signature), returned


def with_titles(_app: "Sphinx", _page: str, text: list[str]) -> None:
    """Have links that name a file, as they read well in the repository, show the title of its page."""
    text[0] = _NAMING_A_FILE.sub(r"[](\1\2)", text[0])


def with_screenshots(app: "Sphinx", _page: str, text: list[str]) -> None:
    """Show the screenshots that were taken."""
    text[0] = as_far_as_taken(text[0], Path(app.srcdir))


def with_questions(app: "Sphinx", page: str, _template: str, _context: object, _tree: object) -> None:
    """Have the page of search results put those pages first that answer a question."""
    if page == "search":
        app.add_js_file("questions.js")


def load_nothing(app: "Sphinx", error: Exception | None) -> None:
    """Raise ``ExtensionError`` where a built page would load something from the network."""
    if error is None:
        refuse_network(Path(app.outdir))


def setup(app: "Sphinx") -> None:
    """Have the reference written before pages are read, and equations as MathML."""
    app.connect("builder-inited", lambda _: write_reference(HERE))
    app.connect("source-read", with_titles)
    app.connect("source-read", with_screenshots)
    app.connect("autodoc-process-signature", with_plain_signatures)
    app.connect("html-page-context", with_questions)
    app.connect("build-finished", load_nothing)
    as_mathml(app)
