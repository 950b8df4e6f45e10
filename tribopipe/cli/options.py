"""Options and command groups shared by several commands, and how values of options are read."""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, TypeVar

import typer
from typer.core import TyperGroup

from tribopipe.cli.output import keep_stdout_for_json, say
from tribopipe.physics.calculation_methods import WearEngine

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.base.executor import Crew
    from tribopipe.documents.contact import Progress
    from tribopipe.documents.quantity import Quantity
    from tribopipe.documents.recipe import Recipe
    from tribopipe.physics.friction_path import FrictionPath


DEFAULT_ARCHIVE = Path("archive")
RUN_TOML = "run.toml"
"""Name of the manifest, repeated here so that its reader is not loaded."""
_FRICTION = re.compile(r"A\s*=\s*(\S{1,40})[\s,;]{1,40}b\s*=\s*(\S{1,40})[\s,;]{1,40}c\s*=\s*(.+)", re.DOTALL)


def archived_ids(context: typer.Context) -> list[str]:
    """Complete ids from the archive specified so far, or the one in the current folder."""
    found = Path(context.params.get("archive") or DEFAULT_ARCHIVE).glob("*.h5")
    return sorted(path.stem for path in found if path.stem.isprintable())


def archived_studies(context: typer.Context) -> list[str]:
    """Complete ids of archived studies."""
    folder = Path(context.params.get("archive") or DEFAULT_ARCHIVE) / "studies"
    return sorted(path.stem for path in folder.glob("*.h5"))


def archived_names(context: typer.Context) -> list[str]:
    """Complete ids of archived runs and studies."""
    return [*archived_ids(context), *archived_studies(context)]


def on_this_computer(archive: Path | None) -> Path | None:
    """Return the folder of an archive. Raises ``ArchiveError`` for an address, before anything is done."""
    if archive is not None and _may_be_address(archive):
        from tribopipe.archive.remote import archive_path, refuse_writing

        refuse_writing(archive_path(archive))
    return archive


def _local_or_remote(archive: Path) -> Path:
    """Return the folder of an archive, or its path on remote storage."""
    if not _may_be_address(archive):
        return archive
    from tribopipe.archive.remote import archive_path

    return archive_path(archive)


def _may_be_address(archive: Path) -> bool:
    return ":" in str(archive)


ArchiveFolder = Annotated[
    Path, typer.Option("--archive", help="Archive folder.", file_okay=True, callback=on_this_computer)
]
ReadableArchive = Annotated[
    Path,
    typer.Option(
        "--archive",
        help="Archive folder, or address of a remote archive, for example https://host/archive.",
        file_okay=True,
        callback=_local_or_remote,
    ),
]
AsJson = Annotated[
    bool, typer.Option("--json", callback=keep_stdout_for_json, help="Print one JSON document on stdout.")
]
Verbose = Annotated[
    int, typer.Option("--verbose", "-v", count=True, help="Show tables with -v, and all details with -vv.")
]
ArchivedIds = Annotated[
    list[str], typer.Argument(help="IDs of archived runs.", metavar="ID", autocompletion=archived_ids)
]
Replace = Annotated[bool, typer.Option("--force", help="Replace existing files.")]
Figures = Annotated[bool, typer.Option(help="Save figures next to the archive.")]
Template = Annotated[Path | None, typer.Option("--template", help="TOML file with settings common to all runs.")]
Force = Annotated[bool, typer.Option("--force", help="Repeat steps even if inputs and options are unchanged.")]
Amend = Annotated[
    bool,
    typer.Option(
        "--amend",
        help="Accept a run.toml that has changed since the run was archived; the earlier version is kept.",
    ),
]
FIGURE_FORMATS = ("pdf", "svg", "png")


def _figure_format(text: str) -> str:
    if text not in FIGURE_FORMATS:
        raise typer.BadParameter(f"found {text!r}; expected one of {', '.join(FIGURE_FORMATS)}")
    return text


FigureFormats = Annotated[
    list[str] | None,
    typer.Option(
        "--figure-format",
        "--format",
        parser=_figure_format,
        metavar="FORMAT",
        help="Format of figures for print: pdf, svg, or png at 600 dpi; captions are saved as text; may be repeated.",
    ),
]
RecipeFile = Annotated[Path | None, typer.Option("--recipe", help="TOML file with processing options.")]
RunIds = Annotated[
    list[str] | None,
    typer.Argument(
        help="IDs of archived runs; default: all runs without this step.",
        metavar="ID",
        autocompletion=archived_ids,
    ),
]


def law_names() -> list[str]:
    """Complete the names of wear laws, including those of other packages."""
    from tribopipe.base.plugins import declared

    return list(dict.fromkeys(entry.name for entry in declared("tribopipe.laws")))


def _law(text: str) -> str:
    if text not in law_names():
        from tribopipe.base.plugins import not_installed
        from tribopipe.physics.calculation_methods import LAW_GROUP

        raise typer.BadParameter(not_installed(LAW_GROUP, "wear law", text))
    return text


Law = Annotated[
    str,
    typer.Option(
        "--law",
        "--model",
        parser=_law,
        metavar="LAW",
        autocompletion=law_names,
        help="Wear law: archard, sarkar, dissipated_energy, running_in, or a law from another package.",
    ),
]
Friction = Annotated[
    str | None, typer.Option(help='μ(s) for a law that includes friction, for example "A=0.226 b=0.496 c=32.877 m".')
]
Speed = Annotated[
    str | None, typer.Option(help="Sliding speed, or speed of the crowned disc; default: that of the run.")
]
Pressure = Annotated[
    WearEngine | None,
    typer.Option(
        "--engine",
        help="Wear model of the pin: GIWM, wear volume or local wear; overrides the recipe.",
    ),
]


def load_archive(folder: Path, *, must_exist: bool = True) -> "Archive":
    """Open an archive folder. Raises ``ArchiveError`` if it must exist and does not."""
    from tribopipe.archive.store import Archive

    if must_exist or folder.is_dir():
        require_archive(folder)
    return Archive(folder)


def require_archive(folder: Path) -> None:
    """Raise ``ArchiveError`` if there is no archive folder, or a run folder in its place."""
    from tribopipe.base.errors import ArchiveError

    if (folder / RUN_TOML).is_file():
        raise ArchiveError(
            f"{folder}: found a run folder; expected a folder of archived runs; specify the archive with --archive"
        )
    if not folder.is_dir():
        raise ArchiveError(
            f"{folder}: found no archive in this folder; expected a folder of archived runs; run `tribopipe ingest` "
            "first, or specify the archive with --archive"
        )


def load_recipe(path: Path | None, engine: WearEngine | None = None) -> "Recipe":
    """Read a recipe, by default the default recipe, with another engine if one is specified."""
    from tribopipe.documents.recipe import Recipe
    from tribopipe.documents.record import load_toml

    recipe = Recipe() if path is None else load_toml(path, Recipe)
    if engine is None:
        return recipe
    return recipe.model_copy(update={"wear": recipe.wear.model_copy(update={"engine": engine})})


def chosen_ids(archive: "Archive", ids: list[str] | None) -> list[str]:
    """Return the requested ids, or all. Raises ``ArchiveError`` if there is none."""
    from tribopipe.base.errors import ArchiveError

    chosen = ids or archive.ids()
    if not chosen:
        raise ArchiveError(
            f"{archive.folder}: found no runs; expected at least one archived run; run `tribopipe ingest` first"
        )
    return chosen


def parsed(option: str, text: str, kind: str) -> float:
    """Read an option in SI units."""
    from tribopipe.base.errors import UnitError
    from tribopipe.base.units import parse

    try:
        return parse(text, kind)
    except UnitError as error:
        raise UnitError(f"{option}: {error}") from None


def place(option: str, text: str, progress: "Progress") -> float:
    """Read a position along the progress of a contact in SI units: a sliding distance, or rotations."""
    from tribopipe.base.errors import UnitError

    if progress.kind != "count":
        return parsed(option, text, progress.kind)
    try:
        turns = parsed(option, text, progress.kind)
    except UnitError:
        turns = -1.0
    if turns < 0:
        raise UnitError(
            f"{option}: found {text!r}; expected zero or more {progress.words} of the crowned disc, such as "
            f"{progress.example!r}"
        )
    return turns


def quantity(option: str, text: str, kind: str) -> "Quantity":
    """Read an option as a positive quantity."""
    from tribopipe.base.errors import UnitError
    from tribopipe.base.units import KINDS
    from tribopipe.documents.quantity import Quantity

    value = parsed(option, text, kind)
    if not value > 0:
        raise UnitError(f"{option}: found {text!r}; expected a positive {kind}, such as {KINDS[kind].example!r}")
    return Quantity(value=value, unit=KINDS[kind].si)


def friction_path(text: str) -> "FrictionPath":
    """Read "A=0.226 b=0.496 c=32.877 m"."""
    from tribopipe.base.errors import UnitError
    from tribopipe.physics.friction_path import ExponentialFriction

    found = _FRICTION.fullmatch(text.strip())
    if found is None:
        raise UnitError(
            f'--friction: found {text!r}; expected the parameters A, b and c of Eq. 7, such as "A=0.226 b=0.496 '
            'c=32.877 m"'
        )
    amplitude, steady, distance = found.groups()
    running_in = parsed("--friction", distance, "distance")
    if not running_in > 0:
        raise UnitError(f"--friction: found c = {distance}; expected a positive distance")
    start, end = (parsed("--friction", ratio.rstrip(",;"), "ratio") for ratio in (amplitude, steady))
    return ExponentialFriction(start, end, running_in)


T = TypeVar("T")
_LOCAL = "local"
_SHARD = re.compile(r"([0-9]{1,9})/([0-9]{1,9})")


class Part(NamedTuple):
    """The part of a batch to process."""

    number: int
    """From 1."""
    of: int

    def chosen(self, items: Sequence[T]) -> list[T]:
        """Return every n-th run, starting with the first of this part."""
        return list(items[self.number - 1 :: self.of])


def _part(text: str) -> Part:
    found = _SHARD.fullmatch(text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise typer.BadParameter(f"found {text!r}; expected i/n with i from 1 to n, such as 3/8")
    return Part(int(found[1]), int(found[2]))


Jobs = Annotated[
    int | None,
    typer.Option("-j", "--jobs", min=0, help="Number of parallel processes; 0 for all cores.", show_default="1"),
]
JobsOnAllCores = Annotated[
    int | None,
    typer.Option(
        "-j", "--jobs", min=0, help="Number of parallel processes; 0 for all cores.", show_default="all cores"
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help='Dask scheduler, for example tcp://10.0.0.1:8786, or "local" for one on this computer.',
    ),
]
Shard = Annotated[
    Part | None,
    typer.Option("--shard", parser=_part, metavar="I/N", help="Process only every n-th run, starting with the i-th."),
]


def crew(jobs: int | None, scheduler: str | None, usual: int = 1) -> "Crew":
    """Return the workers of a batch, with this number of parallel processes by default; 0 for all cores.

    Raises ``BadParameter`` for a number of jobs with a scheduler, which has its own workers.
    """
    from tribopipe.base.executor import Crew

    if jobs is not None and scheduler not in (None, _LOCAL):
        raise typer.BadParameter(
            "found -j in addition to --scheduler, which has its own workers; expected only one of these options; "
            "remove -j"
        )
    if jobs is None:
        jobs = usual if scheduler is None else _cores()
    return Crew(jobs or _cores(), scheduler, say)


def seen_by(who: "Crew", path: Path) -> Path:
    """Return a path as the workers find it: those of a scheduler have other current folders."""
    return path if who.scheduler is None else path.absolute()


def _cores() -> int:
    """Return the number of cores that the queueing system allows for this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class HelpPanels(TyperGroup):
    """A group whose help lists commands by panel, without truncated sentences."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each panel, in the order of the panels."""
        panels: dict[str, list[tuple[str, str]]] = {}
        for name in self.list_commands(ctx):
            command: Any = self.get_command(ctx, name)
            if not command.hidden:
                panel = getattr(command, "rich_help_panel", None)
                panels.setdefault(panel if isinstance(panel, str) else "Commands", []).append(
                    (name, first_sentence(command.help or ""))
                )
        widest = max((len(name) for rows in panels.values() for name, _ in rows), default=0)
        for panel, rows in panels.items():
            with formatter.section(panel):
                formatter.write_dl([(name.ljust(widest), told) for name, told in rows])


def first_sentence(text: str) -> str:
    """Return the first sentence of a help text, on one line."""
    first = " ".join(text.split("\n\n", 1)[0].split())
    return f"{first.partition('. ')[0].rstrip('.')}."
