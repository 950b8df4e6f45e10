"""What the catalog notes of a run and of a study, read from their files."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import h5py
import numpy as np

from tribopipe.archive.catalog.listing import COLUMNS, ITEM, Cell, ListedColumn, of_law
from tribopipe.archive.earlier_manifests import AMENDED
from tribopipe.archive.hdf5_compression import unpacked
from tribopipe.archive.nexus import text
from tribopipe.archive.runfile import read_annotations, read_findings, read_manifest, read_marks, read_result
from tribopipe.archive.step_names import PREDICTIONS, STEPS, WEAR_FITS, StepName, steps_among
from tribopipe.archive.store import Archive
from tribopipe.documents.annotation import Annotation, tags_after
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.quantity import Quantity
from tribopipe.documents.record import Record
from tribopipe.physics.laws import law_label
from tribopipe.results.specific_wear import BodyWearRate, SpecificWear
from tribopipe.results.study import AGREEMENT, StudyResult
from tribopipe.results.wear_fit import WearFit

_STAGES: Mapping[str, str] = {
    "local_wear": "local wear",
    "prediction": "predicted",
    "wear_fit": "fitted",
    "specific_wear": "wear rate",
    "friction_fit": "friction",
    "drift_correction": "corrected",
    "clean_up": "preprocessed",
}
"""How far a run is by the steps it has been through, the furthest first."""


_READ = [
    *(f"entry/{name}/data" for name in ("manifest", "findings", "marks", "annotations")),
    *(f"entry/{name}/result/data" for name in STEPS),
    *(f"entry/raw/{name}" for name in ("rotations", "sliding_distance")),
    "entry/source_files/file_0/checksum",
    AMENDED,
]
"""All that is read of a run, so that a first listing need not look through everything."""


class _Held(NamedTuple):
    """What is read of a run."""

    manifest: RunManifest
    results: Mapping[StepName, Record]
    ends: Mapping[str, float]
    """Distance covered, m, and rotations as recorded, as far as nothing but the signals gives them."""

    def of(self, name: StepName, *path: str) -> Any:
        """Return a field of a step's result; none where anything on the way to it is not there."""
        found: Any = self.results.get(name)
        for part in path:
            found = getattr(found, part, None)
        return found


def read_cells(archive: Archive, run_id: str) -> dict[str, Cell]:
    """Return what a run has in each column. Raises ``ArchiveError`` where its file is damaged or no run."""
    with archive.open(run_id, _READ) as file:
        entry = file["entry"]
        manifest = read_manifest(file)
        results = {name: result for name in steps_among(entry) if (result := read_result(entry, name))}
        held = _Held(manifest, results, _ends(entry, manifest, evaluated="specific_wear" in results))
        said = {
            "findings": sum(found.severity != "note" for found in read_findings(entry)),
            "marked_bad": next((mark.reason for mark in read_marks(entry)[-1:] if mark.kind == "bad"), None),
            **_annotated(read_annotations(entry)),
            "amended": text(file, AMENDED) if AMENDED in file else None,
            "run_toml": text(entry, "source_files/file_0/checksum"),
        }
    known = {"id": run_id, **_stated(held), **_found(held), **_progress(held), **said}
    known["mark"] = "bad" if known["marked_bad"] else None
    # Of a law that is not installed here there are no columns.
    return {name: _cell(COLUMNS[name], value) for name, value in known.items() if name in COLUMNS}


def read_agreement(archive: Archive, study_id: str) -> list[tuple[str, str | None]]:
    """Return each run of a study with its agreement with each law; none where the study has no result for it."""
    outline = archive.study_outline(study_id)
    lines = list(_agreement(study_id, outline.result))
    silent = {*outline.study.fit, *outline.study.predict}.difference(run for run, _ in lines)
    return [*lines, *((run, None) for run in sorted(silent))]


def _agreement(study_id: str, result: StudyResult) -> Iterator[tuple[str, str]]:
    for law in result.laws:
        for run in law.runs:
            yield run.id, f"{law_label(law.model)} in {study_id}: {AGREEMENT[run.outcome]}"
    for left_out in result.left_out:
        yield left_out.id, f"excluded from {study_id}"


def _ends(entry: h5py.Group, manifest: RunManifest, *, evaluated: bool) -> dict[str, float]:
    """Return how far a run went by its signals; a distance only where no evaluation gives it."""
    wanted = {manifest.progress.signal, "sliding_distance"} - ({"sliding_distance"} if evaluated else set())
    ends = {name: float(unpacked(entry["raw"][name], last=1)[-1]) for name in wanted if name in entry["raw"]}
    return {name: end for name, end in ends.items() if np.isfinite(end)}


def _stated(held: _Held) -> dict[str, object]:
    """Return what run.toml states, and how far the run went."""
    manifest, conditions = held.manifest, held.manifest.conditions
    return {
        "title": manifest.title,
        "tribometer": None if manifest.contact is None else manifest.contact.kind,
        **_bodies(manifest),
        "medium": conditions.medium,
        "load": conditions.normal_load,
        "speed": manifest.nominal_speed,
        "distance": held.of("specific_wear", "sliding_distance")
        or held.ends.get("sliding_distance")
        or conditions.sliding_distance,
        "rotations": held.ends.get("rotations") or conditions.rotations,
        "slip": manifest.slip,
        "temperature": conditions.temperature,
        "humidity": conditions.relative_humidity,
        "started": None if manifest.started is None else manifest.started.isoformat(),
        "operator": manifest.operator,
        "instrument": manifest.instrument,
        "comment": manifest.comment,
    }


def _bodies(manifest: RunManifest) -> dict[str, object]:
    bodies = {} if manifest.contact is None else manifest.contact.in_roles
    first = next(iter(bodies.values()), None)
    return {
        "material": list(dict.fromkeys(body.material for body in bodies.values())),
        **{f"{name}_material": body.material for name, body in bodies.items()},
        "shape": getattr(first, "shape", None),
        "radius": getattr(first, "radius", None) or getattr(first, "crown_radius", None),
    }


def _found(held: _Held) -> dict[str, object]:
    """Return what the steps found."""
    pin_depth = held.of("drift_correction", "pin_wear_depth")
    first, second = _worn(held.results.get("specific_wear"))
    return {
        "friction": held.of("friction_fit", "steady_state"),
        "friction_amplitude": held.of("friction_fit", "amplitude"),
        "running_in": held.of("friction_fit", "running_in_distance"),
        "mean_friction": held.of("friction_fit", "mean"),
        "drift_rate": held.of("drift_correction", "drift_rate"),
        "discrepancy": held.of("drift_correction", "discrepancy"),
        "end_depth": pin_depth or held.of("drift_correction", "end_wear_depth"),
        **_under_laws(held),
        "wear_volume": getattr(first, "volume", None),
        "wear_rate": getattr(first, "specific_wear_rate", None),
        "disc_wear_volume": getattr(second, "volume", None),
        "disc_wear_rate": getattr(second, "specific_wear_rate", None),
    }


def _under_laws(held: _Held) -> dict[str, object]:
    """Return k_D and predicted depth under each law; Archard's have the plain names."""
    found: dict[str, object] = {}
    for name in held.results:
        if (law := WEAR_FITS.law_of(name)) is not None:
            found |= _coefficients(of_law(law), held.results[name], held.manifest)
        if (law := PREDICTIONS.law_of(name)) is not None:
            found[f"predicted_depth{of_law(law)}"] = _predicted(held.of(name, "prediction"))
    return found


def _coefficients(law: str, fit: Record | None, manifest: RunManifest) -> dict[str, Quantity | None]:
    if not isinstance(fit, WearFit) or manifest.contact is None:
        return {}
    columns = zip(manifest.contact.body_names, ("", "_disc"), strict=True)
    return {f"k_d{law}{end}": fit.bodies[name].wear_coefficient for name, end in columns if name in fit.bodies}


def _predicted(points: Iterable[Any] | None) -> Quantity | None:
    """Return the depth at the end, the first that a prediction is asked for."""
    return next((point.contact.approach for point in points or ()), None)


def _worn(result: Record | None) -> tuple[BodyWearRate | None, BodyWearRate | None]:
    """Return the wear of the pin or the crowned disc, and that of the other disc."""
    if not isinstance(result, SpecificWear):
        return None, None
    return result.pin or result.curved_disc, result.disc or result.flat_disc


def _progress(held: _Held) -> dict[str, object]:
    reached = (stage for prefix, stage in _STAGES.items() if any(name.startswith(prefix) for name in held.results))
    missing = [name for result in held.results.values() for name in getattr(result, "missing", ())]
    return {"steps": list(held.results), "stage": next(reached, "ingested"), "missing": list(dict.fromkeys(missing))}


def _annotated(history: list[Annotation]) -> dict[str, object]:
    return {"tags": list(tags_after(history)), "notes": [entry.text for entry in history if entry.kind == "note"]}


def _cell(column: ListedColumn, value: object) -> Cell:
    if isinstance(value, Quantity):
        shown = value.shown(column.unit).removesuffix(f" {column.unit}")
        return Cell(value.value, value.standard_uncertainty, shown)
    if isinstance(value, float | int):
        return _cell(column, Quantity(value=value, unit="m" if column.measures == "distance" else "1"))
    texts = value if isinstance(value, list) else [value]
    return Cell(ITEM.join(_one_line(str(text)) for text in texts if text) or None)


def _one_line(text: str) -> str:
    """Return a text without breaks, and with what is no character, from another console, spelt out."""
    return " ".join(text.split()).encode("utf-8", "backslashreplace").decode()
