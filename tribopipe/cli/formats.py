"""Commands about the formats of instruments: formats list, formats detect."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.base.errors import counted
from tribopipe.cli.options import AsJson, HelpPanels
from tribopipe.cli.output import exit_with, located, print_json, print_result, table

if TYPE_CHECKING:
    from tribopipe.readers.export_files import Export
    from tribopipe.readers.reader import ReadColumn

formats_app = typer.Typer(cls=HelpPanels, help="Show which instrument formats can be read.", no_args_is_help=True)
ReaderName = Annotated[
    str | None,
    typer.Option("--reader", help="Format, or a TOML file that describes a format; default: detected."),
]
SheetName = Annotated[
    str | None, typer.Option("--sheet", help="Sheet of a workbook, if several contain a test.", metavar="NAME")
]
# Packages that a reader's extra brings, by the extra's name.
_EXTRAS = {"excel": "python_calamine", "tdms": "nptdms", "surface": "SurfaceTopography"}
_NEEDS = {"workbook": "excel", "ni-tdms": "tdms", "surface-topography": "surface"}


@formats_app.command("list")
def list_formats(as_json: AsJson = False) -> None:
    """List the formats that can be read."""
    from tribopipe.readers.reader import readers

    found: list[dict[str, Any]] = [
        {
            "name": name,
            "title": reader.title,
            "holds": reader.holds,
            "suffixes": list(getattr(reader, "suffixes", ())),  # customary ones; files are known by their content
            "extra": _NEEDS.get(name),
            "ready": _ready(name),
        }
        for name, reader in sorted(readers().items())
    ]
    if as_json:
        print_json({"formats": found})
        return
    rows = [[one["name"], one["title"], one["holds"], _needed(one)] for one in found]
    table(f"{len(found)} formats", ["format", "description", "content", "requires"], rows)


def _ready(name: str) -> bool:
    from importlib.util import find_spec

    return name not in _NEEDS or find_spec(_EXTRAS[_NEEDS[name]]) is not None


def _needed(one: dict[str, Any]) -> str:
    if one["extra"] is None:
        return ""
    return f"tribopipe[{one['extra']}]" + ("" if one["ready"] else ", missing")


@formats_app.command("detect")
def detect_formats(
    files: Annotated[list[Path], typer.Argument(help="Instrument files.", metavar="FILE")],
    reader: ReaderName = None,
    sheet: SheetName = None,
    as_json: AsJson = False,
) -> None:
    """Detect the format of files and show their contents.

    Exit code 1 if no format is recognized.
    """
    from tribopipe.base.errors import TribopipeError
    from tribopipe.readers.export_files import chosen_reader, read_export
    from tribopipe.readers.reader import Hints

    errors: list[TribopipeError] = []
    told: list[dict[str, Any]] = []
    named = None if reader is None else chosen_reader(reader)
    for path in files:
        try:
            export = read_export(path, named, Hints(sheet=sheet))
        except TribopipeError as error:
            errors.append(located(path, error))
            told.append({"file": str(path), "error": str(errors[-1]), "candidates": _tried(path)})
            continue
        told.append(_document(path, export))
        _show(path, export)
    if as_json:
        print_json({"files": told})
    exit_with(errors, some_done=len(errors) < len(files))


def _tried(path: Path) -> list[dict[str, Any]]:
    """Show the readers that were tried on an unrecognized file, and why each rejected it."""
    from tribopipe.base.errors import TribopipeError
    from tribopipe.readers.export_files import open_export
    from tribopipe.readers.reader import candidates, is_sure

    try:
        found = candidates(open_export(path))
    except TribopipeError:
        return []
    if not any(is_sure(match) for _, match in found):
        rows = [[reader.name, _sure(match.confidence), match.why.partition(";")[0]] for reader, match in found]
        table(f"{path}: not recognized", ["format", "confidence", "reason"], rows)
    return [_candidate(reader.name, match.confidence, match.why) for reader, match in found]


def _candidate(name: str, confidence: float, why: str) -> dict[str, Any]:
    return {"format": name, "confidence": round(confidence, 3), "why": why}


def _sure(confidence: float) -> str:
    return f"{100 * confidence:.0f} %"


def _document(path: Path, export: "Export") -> dict[str, Any]:
    reader, others = export.reader, export.others
    return {
        "file": str(path),
        "format": reader.name,
        "title": reader.title,
        "holds": reader.holds,
        "confidence": round(export.match.confidence, 3),
        "why": export.match.why,
        "candidates": [_candidate(other.name, match.confidence, match.why) for other, match in others],
        "rows": export.rows,
        "columns": [_column(export, column) for column in export.table.columns],
        "facts": export.header.facts,
        "notes": _notes(export),
    }


def _notes(export: "Export") -> list[str]:
    from tribopipe.readers.column_meanings import definitions_note

    note = definitions_note(export.table.columns, export.friction) if export.reader.holds == "signals" else None
    return [*export.notes, *([note] if note else [])]


def _column(export: "Export", column: "ReadColumn") -> dict[str, Any]:
    from tribopipe.readers.export_files import range_of

    meaning, found = export.meanings.get(column.name), range_of(column)
    return {
        "name": column.name,
        "unit": column.unit,
        "proposed_unit": unit.unit if (unit := export.open_units.get(column.name)) else None,
        "signal": meaning.signal if meaning and not meaning.doubt else None,
        "axis": column.axis,
        "least": found.least,
        "largest": found.largest,
        "missing": found.missing,
    }


def _show(path: Path, export: "Export") -> None:
    """Show one file on stderr."""
    print_result(f"{path}: {export.reader.name}, {export.reader.title}")
    print_result(f"  confidence {_sure(export.match.confidence)}: {export.match.why}")
    for other, match in export.others:
        print_result(f"  alternative: {other.name}, confidence {_sure(match.confidence)}: {match.why}")
    for key, value in export.header.facts.items():
        print_result(f"  {key}: {value}")
    for note in _notes(export):
        print_result(f"  note: {note}")
    columns = ["column", "unit", "meaning", "minimum", "maximum", "missing"]
    table(
        f"  {counted(export.rows, 'row')}",
        columns,
        [_row(export, column) for column in export.table.columns],
    )


def _row(export: "Export", column: "ReadColumn") -> list[str]:
    from tribopipe.readers.export_files import range_of

    found = range_of(column)
    least, largest = ("–" if value is None else f"{value:.6g}" for value in found[:2])
    return [column.name, column.unit or "–", _meaning(export, column), least, largest, str(found.missing or "–")]


def _meaning(export: "Export", column: "ReadColumn") -> str:
    from tribopipe.readers.steps import step_column

    meaning, unit = export.meanings.get(column.name), export.open_units.get(column.name)
    proposed = f"; {unit.unit} is suggested by {unit.why}" if unit else ""
    if meaning is None:
        steps = step_column({one.name: one.values for one in export.table.columns})
        return (column.axis or ("step number" if column.name == steps else "–")) + proposed
    return f"{meaning.signal}, {meaning.by}" + (f"? {meaning.doubt}" if meaning.doubt else "") + proposed
