"""Commands that show a run or a profile: show, schema."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from tribopipe.cli.options import (
    DEFAULT_ARCHIVE,
    AsJson,
    HelpPanels,
    ReadableArchive,
    Verbose,
    archived_ids,
    load_archive,
    parsed,
)
from tribopipe.cli.output import located, print_json, print_result, record_json, say, table
from tribopipe.cli.pages import show_run_page

if TYPE_CHECKING:
    from tribopipe.archive.store import Archive
    from tribopipe.base.errors import ArchiveError
    from tribopipe.documents.quantity import Quantity
    from tribopipe.evaluation.measurements.tip_map import MapVolume
    from tribopipe.evaluation.measurements.track_profile import Level, Track
    from tribopipe.results.run import Profile


Plot = Annotated[bool, typer.Option("--plot", help="Save figures and show their paths.")]
Radius = Annotated[
    str | None,
    typer.Option(
        help="Radius of the ball or crown on which the profile was measured, for example '3 mm'; default: flat surface."
    ),
]
PositionUnit = Annotated[
    str | None, typer.Option(help="Position unit, for example mm, if the file does not contain it.")
]
HeightUnit = Annotated[str | None, typer.Option(help="Height unit, for example um, if the file does not contain it.")]
_FIGURES = Path("figures")
"""Folder for the figures of a file, or of a run in a remote archive, in the current folder."""
_MOST_REASONS = 4
"""Number of profiles up to which the reason for a missing track is given for each."""


@dataclass(frozen=True)
class ProfileOptions:
    """Options for a file with profiles."""

    plot: bool
    radius: str | None
    position_unit: str | None
    height_unit: str | None


@dataclass(frozen=True)
class _Shown:
    """Profiles by their keys, with the result for each."""

    profiles: "Mapping[str, Profile]"
    found: "Mapping[str, Track | Level]"
    figures: Mapping[str, Path]

    def document(self) -> list[dict[str, Any]]:
        """Return everything as JSON types."""
        return [
            {"key": key, "points": len(self.profiles[key].position), **_described(found)}
            | ({"figure": str(self.figures[key])} if key in self.figures else {})
            for key, found in self.found.items()
        ]

    def tell(self, title: str) -> None:
        """Print everything as a table and notes."""
        from tribopipe.evaluation.measurements.height_map import maps_of
        from tribopipe.evaluation.measurements.track_profile import Track
        from tribopipe.views.profile_figures import drawn_of

        listed = drawn_of(list(self.found)) if maps_of(self.profiles) else list(self.found)
        rows = [[key, *_cells(found)] for key in listed if isinstance(found := self.found[key], Track)]
        if rows:
            table(
                title, ["profile", "groove area", "pile-up area", "net area", "width", "depth", "unworn surface"], rows
            )
        if len(listed) < len(self.found):
            say(f"{len(listed)} of {len(self.found)} scan lines of the height map listed; --json lists all")
        self._tell_levelled({key: found.why for key, found in self.found.items() if not isinstance(found, Track)})
        if 0 < len(self.figures) < len(self.found):
            say(f"{len(self.figures)} of {len(self.found)} profiles drawn")
        for path in self.figures.values():
            print_result(str(path))

    def _tell_levelled(self, why: Mapping[str, str]) -> None:
        """Report which profiles have no track, and why: each, or only the first if there are many, as in a map."""
        if len(why) > _MOST_REASONS:
            say(
                f"wear track not evaluated in {len(why)} of {len(self.found)} profiles, which are only leveled; for "
                "example:"
            )
        for key in list(why)[: 1 if len(why) > _MOST_REASONS else None]:
            say(f"{key}: wear track not evaluated, profile only leveled: {why[key]}")


def show_profile_file(path: Path, asked: ProfileOptions, *, as_json: bool) -> None:
    """Show the profiles in a file: areas, width and depth of the track in each, and figures if requested."""
    from tribopipe.base.errors import ReaderError
    from tribopipe.documents.manifest import ProfileSource
    from tribopipe.evaluation.measurements.track_profile import examined
    from tribopipe.readers.column_mapping import read_source
    from tribopipe.readers.number_fields import remarks
    from tribopipe.readers.profiles import Units, profiles_in
    from tribopipe.views.profile_figures import save_profile_figures

    radius = None if asked.radius is None else parsed("--radius", asked.radius, "length")
    named = ProfileSource(file=path.name)
    try:
        source = read_source(path.parent, path.name, "show", "profile")
        read, lines, notes = profiles_in(source, named, "profile", Units(asked.position_unit, asked.height_unit))
    except ReaderError as error:
        hint = "; or specify --position-unit and --height-unit" if "found no unit" in str(error) else ""
        raise located(path, ReaderError(f"{error}{hint}")) from None
    keys = ["profile"] if len(lines) == 1 else [f"profile[{number}]" for number in range(len(lines))]
    profiles = dict(zip(keys, lines, strict=True))
    found = {key: examined(profile, radius) for key, profile in profiles.items()}
    figures = save_profile_figures(profiles, found, _FIGURES, path.stem) if asked.plot else {}
    shown, said = _Shown(profiles, found, figures), [*remarks(read), *notes, *_gap_notes(found)]
    worn = None if radius is None else _worn_tip(path, profiles, radius)
    if as_json:
        tip = None if worn is None else {name: record_json(getattr(worn, name)) for name in ("volume", "radius")}
        print_json({"file": str(path), "notes": said, "profiles": shown.document(), "worn_tip": tip})
        return
    for note in said:
        say(f"note: {note}")
    if worn is None:
        shown.tell(f"{path}: wear track in each profile")
        return
    row = [worn.volume.shown("mm^3"), worn.radius.shown("mm")]
    table(f"{path}: scar in the height map", ["wear volume of the tip", "radius of the unworn surface"], [row])
    shown.tell(f"\n{path}: scar in scan lines")


def _gap_notes(found: "Mapping[str, Track | Level]") -> list[str]:
    """Report the widest gap in a track."""
    from tribopipe.evaluation.measurements.track_profile import GAP_REMEDY, Track, gap_found

    gaps = {key: track.gap for key, track in found.items() if isinstance(track, Track) and track.gap}
    if not gaps:
        return []
    widest = max(gaps, key=lambda key: gaps[key])
    return [f"{widest}: {gap_found(gaps[widest])}; {GAP_REMEDY}"]


def _worn_tip(path: Path, profiles: "Mapping[str, Profile]", radius: float) -> "MapVolume | None":
    """Return the volume that a spherical tip has lost by a height map; none for profiles, and maps without a scar."""
    from tribopipe.base.errors import FitError
    from tribopipe.documents.quantity import Quantity
    from tribopipe.evaluation.measurements.height_map import maps_of
    from tribopipe.evaluation.measurements.tip_map import volume_below_sphere

    for lines in maps_of(profiles).values():
        try:
            return volume_below_sphere(lines, Quantity(value=radius, unit="m"))
        except FitError as error:
            say(f"{path}: {error}")
    return None


def show_run_profiles(store: "Archive", run_id: str) -> list[dict[str, Any]]:
    """Report on the profiles of an archived run, save all figures of the run, and return the results as JSON types."""
    from tribopipe.archive.file_signature import FIGURES
    from tribopipe.archive.remote import RemotePath
    from tribopipe.evaluation.measurements.track_profile import examined, reference_radius
    from tribopipe.views.archived_figures import save_run_figures
    from tribopipe.views.profile_figures import save_profile_figures

    raw = store.raw(run_id)
    profiles = raw.single_profiles
    radii = {key: reference_radius(raw.manifest, key) for key in profiles}
    found = {
        key: examined(profile, None if (radius := radii[key]) is None else radius.value)
        for key, profile in profiles.items()
    }
    into = _FIGURES if isinstance(store.folder, RemotePath) else None
    drawn = save_profile_figures(profiles, found, into or store.folder / FIGURES, run_id)
    shown = _Shown(profiles, found, drawn)
    shown.tell("\nwear track in each profile")
    for path in save_run_figures(store, run_id, into=into):
        print_result(str(path))
    return shown.document()


def _described(found: "Track | Level") -> dict[str, Any]:
    from tribopipe.evaluation.measurements.track_profile import Track

    if not isinstance(found, Track):
        return {"track": None, "why": found.why, "unworn_surface": found.form}
    names = ("area", "pile_up", "net_area", "width", "depth", *(["cap"] if found.form == "arc" else []))
    measured = {name: record_json(getattr(found, name)) for name in names}
    return {"track": {**measured, "from_to_m": list(found.bounds)}, "unworn_surface": found.form}


def _cells(track: "Track") -> list[str]:
    lengths: list[Quantity] = [track.width, track.depth]
    areas = [area.shown("um^2") for area in (track.area, track.pile_up, track.net_area)]
    return [*areas, *(length.shown("um") for length in lengths), track.form]


schema_app = typer.Typer(cls=HelpPanels, help="Write schemas for documents and archived files.", no_args_is_help=True)


def show(
    run_id: Annotated[
        str,
        typer.Argument(
            help="ID of an archived run, or a file with a profile.", metavar="ID|FILE", autocompletion=archived_ids
        ),
    ],
    archive: ReadableArchive = DEFAULT_ARCHIVE,
    path: Annotated[
        str | None, typer.Option(help="Part of the run's HDF5 file to show, for example /entry/wear.", metavar="PATH")
    ] = None,
    rows: Annotated[
        int, typer.Option(help="Number of rows to show at the beginning and at the end of a part.", min=1)
    ] = 5,
    plot: Plot = False,
    radius: Radius = None,
    position_unit: PositionUnit = None,
    height_unit: HeightUnit = None,
    verbose: Verbose = 0,
    as_json: AsJson = False,
) -> None:
    """Show an archived run, or a measured profile."""
    if path is not None:
        _show_part(load_archive(archive), run_id, path, rows, as_json=as_json)
        return
    archived = (archive / f"{run_id}.h5").exists()
    if Path(run_id).is_file() and not archived:
        asked = ProfileOptions(plot, radius, position_unit, height_unit)
        show_profile_file(Path(run_id), asked, as_json=as_json)
        return
    if not archived and Path(run_id).suffix:
        raise _neither_file_nor_run(run_id, archive)
    store = load_archive(archive)
    if not archived and run_id in store.study_ids():
        raise _a_study(run_id, archive)
    _show_run(store, run_id, plot=plot, in_full=bool(verbose), as_json=as_json)


def _a_study(name: str, archive: Path) -> "ArchiveError":
    """Return the error for a study where a run is expected."""
    from tribopipe.base.errors import ArchiveError

    return ArchiveError(
        f"{archive}: found the study {name!r}, but no run of this ID; expected the ID of an archived run; to show the "
        f"study, use `tribopipe study show {name}`"
    )


def _neither_file_nor_run(name: str, archive: Path) -> "ArchiveError":
    """Return the error for a name that is neither that of a file nor the ID of a run."""
    from tribopipe.base.errors import ArchiveError, did_you_mean

    there, folder = load_archive(archive, must_exist=False).ids() if archive.is_dir() else [], Path(name).parent
    beside = [str(path) for path in folder.iterdir() if path.is_file()] if folder.is_dir() else []
    return ArchiveError(
        f"{name}: found neither a file nor a run with this name in {archive}; expected a profile file or the ID of an "
        f"archived run; {did_you_mean(name, [*there, *beside])}"
    )


def _show_part(store: "Archive", run_id: str, path: str, rows: int, *, as_json: bool) -> None:
    from tribopipe.cli.hdf5_part import part_json, show_part

    if as_json:
        print_json(part_json(store, run_id, path))
    else:
        show_part(store, run_id, path, rows)


def _show_run(store: "Archive", run_id: str, *, plot: bool, in_full: bool, as_json: bool) -> None:
    from tribopipe.cli.overview import show_run_overview
    from tribopipe.cli.summary import run_summary
    from tribopipe.views.run_page import run_page

    if not as_json:
        if in_full:
            show_run_page(run_page(store, run_id))
            print_result(f"\n{store.path(run_id)}")
        else:
            show_run_overview(store, run_id)
        if plot:
            show_run_profiles(store, run_id)
        return
    run = store.outline(run_id)
    told = {
        "manifest": record_json(run.manifest),
        "findings": [record_json(finding) for finding in run.findings],
        "steps": list(run.steps),
        "marks": [record_json(mark) for mark in run.marks],
        "tags": list(store.tags(run_id)),
        "annotations": [record_json(one) for one in store.annotations(run_id)],
        "amended": [
            {"date": one.date, "changes": one.changes, "earlier_sha256": one.checksum}
            for one in store.earlier_manifests(run_id)
        ],
    }
    if plot:
        told["profiles"] = show_run_profiles(store, run_id)
    print_json(run_summary(store, run_id) | told)


@schema_app.command("export")
def export_schemas(
    folder: Annotated[Path, typer.Argument(help="Output folder for *.schema.json and *.nxdl.xml.")] = Path("schemas"),
) -> None:
    """Write JSON Schemas and NeXus definitions.

    Editors use the schemas to complete and check run.toml, recipes and plans; nxvalidate uses the NeXus application
    definitions to check archived files.
    """
    from tribopipe.archive.definitions.nxdl import definition_files, write_definitions
    from tribopipe.pipeline.output_paths import made_here, require_free
    from tribopipe.results.json_schema import schema_files, write_schemas

    require_free([folder / name for name in (*schema_files(), *definition_files())], own=made_here)
    for path in (*write_schemas(folder), *write_definitions(folder)):
        print_result(str(path))
