"""Templates filled so that whatever a lab wrote stays text."""

import re
from datetime import datetime
from functools import cache, partial
from itertools import count
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from tribopipe.version import VERSION
from tribopipe.views.html.mathml import mathml

_UNSEEN = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]"
)
"""Characters that show as nothing, or turn the order of others around."""
_SYMBOL = re.compile(r"\b([kEFRKha])_(D|n|N|P|Ic|end|s|x|z|c)\b")
_LOWER_WORD = re.compile(r"[a-z]{2,}\b")


def rendered(template: str, **shown: Any) -> str:
    """Fill a template; it also gets the program and its version, and a count of its tables."""
    program, next_table = f"tribopipe {VERSION}", partial(next, count(1))
    return _environment().get_template(template).render(program=program, next_table=next_table, **shown)


@cache
def _environment() -> Environment:
    environment = Environment(
        loader=PackageLoader("tribopipe.views.html"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_visible,
    )
    environment.filters |= {"mathml": mathml, "moment": _moment, "sentence": _sentence, "symbols": _symbols}
    return environment


def _visible(value: Any) -> Any:
    """Make characters seen that would show as nothing; markup of tribopipe is left alone."""
    return _UNSEEN.sub("\ufffd", value) if isinstance(value, str) and not isinstance(value, Markup) else value


def _symbols(text: str) -> Markup:
    """Write k_D and its like with a subscript."""
    return Markup(_SYMBOL.sub(r"\1<sub>\2</sub>", str(escape(_visible(text)))))  # noqa: S704, escaped


def _moment(date: str) -> str:
    """Format an ISO 8601 date for readers; other texts are unchanged."""
    try:
        return f"{datetime.fromisoformat(date):%Y-%m-%d %H:%M %Z}".strip()
    except ValueError:
        return date


def _sentence(text: str) -> str:
    """Begin a text with a capital, but for symbols such as k_D and μ."""
    return text[:1].upper() + text[1:] if _LOWER_WORD.match(text) else text
