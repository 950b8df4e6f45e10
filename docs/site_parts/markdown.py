"""The little of Markdown that generated pages are written in."""

from collections.abc import Iterable, Sequence


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table with a row for each sequence of cells."""
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(map(_cell, cells))} |\n" for cells in lines)


def code(text: str) -> str:
    """Return a text as it is typed."""
    return f"`{text}`" if text else ""


def plain(text: str) -> str:
    """Return a text in which nothing is markup but code between backticks."""
    outside = [_escaped(part) if at % 2 == 0 else f"`{part}`" for at, part in enumerate(text.split("`"))]
    return "".join(outside)


def titled(level: int, title: str, label: str | None = None) -> str:
    """Return a heading, with a label by which other pages find it."""
    return f"{f'({label})=' if label else ''}\n{'#' * level} {title}\n\n"


def indexed(entries: Iterable[str]) -> str:
    """Return entries of the index that lead to where this stands."""
    told = ", ".join(entries)
    return f"```{{index}} {told}\n```\n\n" if told else ""


def _escaped(text: str) -> str:
    for sign in "\\*_<[$":
        text = text.replace(sign, f"\\{sign}")
    return text


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
