"""Options that several commands share."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.records.recipe import Recipe

DEFAULT_ARCHIVE = Path("archive")


def archived_ids(context: typer.Context) -> list[str]:
    """Complete ids from the archive named so far, or the one in the current folder."""
    return sorted(path.stem for path in Path(context.params.get("archive") or DEFAULT_ARCHIVE).glob("*.h5"))


ArchiveFolder = Annotated[Path, typer.Option("--archive", help="Archive folder.", file_okay=True)]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout.")]
Force = Annotated[bool, typer.Option("--force", help="Redo steps whose inputs and options are unchanged.")]
RecipeFile = Annotated[Path | None, typer.Option("--recipe", help="TOML file that says how to process.")]
RunIds = Annotated[
    list[str] | None,
    typer.Argument(
        help="Ids of archived runs; none for every run that lacks the step.",
        metavar="[ID]...",
        autocompletion=archived_ids,
    ),
]
Law = Literal["archard", "sarkar"]
WearEngine = Literal["giwm", "local"]
Pressure = Annotated[
    WearEngine | None,
    typer.Option(
        "--engine",
        help="Pressure on a pin: even, by the Global Incremental Wear Model, or local; wins over a recipe.",
    ),
]


def load_archive(folder: Path, *, must_exist: bool = True) -> "Archive":
    """Open an archive folder. Raises ``ArchiveError`` where it should be there and is not."""
    from tribopipe.archive.store import Archive
    from tribopipe.errors import ArchiveError

    if must_exist and not folder.is_dir():
        raise ArchiveError(
            f"{folder}: found no archive there; expected a folder of archived runs; run `tribopipe ingest` "
            "first, or name the archive with --archive"
        )
    return Archive(folder)


def load_recipe(path: Path | None, engine: WearEngine | None = None) -> "Recipe":
    """Read a recipe, or take the default one, with another engine where one is named."""
    from tribopipe.records.base import load_toml
    from tribopipe.records.recipe import Recipe

    recipe = Recipe() if path is None else load_toml(path, Recipe)
    if engine is None:
        return recipe
    return recipe.model_copy(update={"wear": recipe.wear.model_copy(update={"engine": engine})})


def chosen_ids(archive: "Archive", ids: list[str] | None) -> list[str]:
    """Return the ids asked for, or all. Raises ``ArchiveError`` where there is none."""
    from tribopipe.errors import ArchiveError

    chosen = ids or archive.ids()
    if not chosen:
        raise ArchiveError(f"{archive.folder}: found no runs; expected at least one; run `tribopipe ingest` first")
    return chosen


def parsed(option: str, text: str, kind: str) -> float:
    """Read an option as SI."""
    from tribopipe.errors import UnitError
    from tribopipe.units import parse

    try:
        return parse(text, kind)
    except UnitError as error:
        raise UnitError(f"{option}: {error}") from None
