"""Draw the architecture from the layers that import-linter keeps in pyproject.toml: `python docs/make_layers.py`."""

import ast
import tomllib
from html import escape
from importlib.util import find_spec
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent
PICTURE = HERE / "figures" / "layers.svg"
WIDTH, HEIGHT, GAP, MARGIN = 900, 30, 8, 12
STYLE = """\
text { font: 13px system-ui, sans-serif; fill: #1a1a1a; text-anchor: middle; dominant-baseline: central }
rect { fill: #eef3f8; stroke: #0072b2 } .added { fill: #fdf3dc; stroke: #b07800 }
.says { text-anchor: start; fill: #555 }
@media (prefers-color-scheme: dark) {
  text { fill: #eee } rect { fill: #1d2b38; stroke: #56b4e9 } .added { fill: #3a2f14; stroke: #e69f00 }
  .says { fill: #aaa }
}"""
ADDED_TO = ("tribopipe.readers", "tribopipe.physics", "tribopipe.evaluation")
"""Where other packages add readers, wear laws and checks."""


def layers() -> list[list[str]]:
    """Return the modules of each layer, the uppermost first: each imports from those below it alone."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    rows = next(contract["layers"] for contract in contracts if contract["name"] == "Imports run one way")
    return [row.split(" | ") for row in rows]


def picture() -> str:
    """Return the layers as SVG, modules of a layer beside each other; what a module is for is its title."""
    rows = layers()
    height = 2 * MARGIN + len(rows) * (HEIGHT + GAP) + HEIGHT
    boxes = "\n".join(box for place, row in enumerate(rows) for box in _row(row, MARGIN + place * (HEIGHT + GAP)))
    below = MARGIN + len(rows) * (HEIGHT + GAP) + HEIGHT / 2
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img">\n'
        "<title>Layers of tribopipe: each module imports only from the layers below</title>\n"
        f"<style>\n{STYLE}\n</style>\n"
        f'{boxes}\n<text class="says" x="{MARGIN}" y="{below:g}">Each module imports only from the layers below. '
        "Other packages can extend the modules in yellow.</text>\n</svg>\n"
    )


def _row(modules: list[str], top: int) -> list[str]:
    width = (WIDTH - 2 * MARGIN - GAP * (len(modules) - 1)) / len(modules)
    return [_box(module, MARGIN + place * (width + GAP), top, width) for place, module in enumerate(modules)]


def _box(module: str, left: float, top: int, width: float) -> str:
    kind = ' class="added"' if module in ADDED_TO else ""
    name, middle = module.removeprefix("tribopipe."), left + width / 2
    return (
        f"<g><title>{escape(purpose(module))}</title>"
        f'<rect{kind} x="{left:.1f}" y="{top}" width="{width:.1f}" height="{HEIGHT}" rx="4"/>'
        f'<text x="{middle:.1f}" y="{top + HEIGHT / 2:g}">{name}</text></g>'
    )


def purpose(module: str) -> str:
    """Return the first line that a module says of itself."""
    source = Path(find_spec(module).origin).read_text(encoding="utf-8")
    return (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8", newline="\n")
