"""An archive of thousands of runs, made in seconds, for what has to stay quick however many there are.

    python benchmarks/many_runs.py FOLDER 5000

Three short virtual runs are processed; each further run is a copy of one of them under another id, with other bodies,
load, date, people and k_D, in its manifest, its results and the fields for viewers alike. Its samples, and run.toml
among its source files, are those of the run it was copied from.
"""

import json
import random
import shutil
import sys
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import h5py

from tribopipe.archive import nexus
from tribopipe.archive.provenance import raw_digest
from tribopipe.archive.runfile import write_annotations, write_marks
from tribopipe.archive.seal import seal_file
from tribopipe.archive.step_names import WEAR_FITS, Step, StepName
from tribopipe.archive.store import Archive
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.documents.manifest import RunManifest
from tribopipe.documents.plan import Plan
from tribopipe.documents.record import Record, load_toml
from tribopipe.extras.simulate import simulate_plan
from tribopipe.pipeline.stages import process
from tribopipe.results.run import RawRun

SAMPLES = Path(__file__).parents[1] / "sample_runs"
_MATERIALS = ("Si3N4", "Al2O3", "ZrO2", "100Cr6", "WC-Co", "SiC", "DLC", "Ti-6Al-4V")
_MEDIA = ("air", "water", "dry nitrogen", "PAO oil", "water vapour")
_PEOPLE = ("anna", "otto", "mei", "jürgen", "søren")
_TAGS = ("run-in", "repeat", "thesis", "reference", "new-batch")
_FIRST_DAY = datetime.fromisoformat("2004-01-05T08:00:00+01:00")


def many_runs(folder: Path, count: int, seed: int = 1) -> None:
    """Fill an empty folder with an archive of so many runs, the same for the same seed."""
    chance = random.Random(seed)  # noqa: S311
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        templates = _templates(Path(scratch))
        for number in range(count):
            _vary(chance.choice(templates), folder, number, chance)


class _Template(NamedTuple):
    """A processed run that others are copied from."""

    path: Path
    run: RawRun
    fits: Mapping[StepName, Step]


def _templates(folder: Path) -> list[_Template]:
    """Return three processed runs of 20 m."""
    text = (SAMPLES / "plan.toml").read_text(encoding="utf-8")
    kept = text.partition("[[series]]")[0] + "[[series]]" + text.split("[[series]]")[1]
    plan = folder / "plan.toml"
    plan.write_text(kept.replace('sliding_distance = "500 m"', 'sliding_distance = "20 m"'), encoding="utf-8")
    simulate_plan(load_toml(plan, Plan), folder / "runs")
    archive = Archive(folder / "archive")
    failed = [one for one in process(sorted((folder / "runs").iterdir()), archive) if one.status == "failed"]
    if failed:
        raise RuntimeError(failed)
    return [_template(archive, run_id) for run_id in archive.ids()]


def _template(archive: Archive, run_id: str) -> _Template:
    fits = {name: step for name, step in archive.steps(run_id).items() if name in WEAR_FITS.values()}
    return _Template(archive.path(run_id), archive.raw(run_id), fits)


def _vary(template: _Template, folder: Path, number: int, chance: random.Random) -> None:
    """Write one run."""
    load, wear = chance.choice((0.5, 1.0, 1.5, 2.5)), chance.lognormvariate(0.0, 0.8)
    document = _document(template.run.manifest, number, load, chance)
    path = folder / f"{document['id']}.h5"
    shutil.copyfile(template.path, path)
    with h5py.File(path, "r+", locking=False) as file:
        entry = file["entry"]
        manifest = RunManifest.model_validate(document)
        _state(entry, manifest, raw_digest(replace(template.run, manifest=manifest)))
        for name, step in template.fits.items():
            _put_result(entry[name], replace(step, result=_scaled(step.result, wear)))
        _remark(entry, chance)
    seal_file(path)


def _document(manifest: RunManifest, number: int, load: float, chance: random.Random) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(manifest.model_dump_json(by_alias=True))
    pin, disc = chance.choice(_MATERIALS), chance.choice(_MATERIALS)
    document["contact"]["pin"]["material"], document["contact"]["disc"]["material"] = pin, disc
    for part in ("value", "standard_uncertainty"):
        document["conditions"]["normal_load"][part] *= load
    started = _FIRST_DAY + timedelta(hours=chance.randrange(24 * 365 * 20))
    medium = chance.choice(_MEDIA)
    return document | {
        "id": f"{pin.lower()}-{disc.lower()}-{number:05}",
        "title": f"{pin} on {disc} in {medium}",
        "started": started.isoformat(),
        "operator": chance.choice(_PEOPLE),
        "conditions": document["conditions"] | {"medium": medium},
    }


def _state(entry: h5py.Group, manifest: RunManifest, raw_sha256: str) -> None:
    """Put what a manifest says where the run's file says it."""
    _put(entry["title"], manifest.title)
    _put(entry["identifier_run"], manifest.id)
    _put(entry["start_time"], manifest.started.isoformat() if manifest.started else "")
    _put(entry["archived/raw_sha256"], raw_sha256)
    _put(entry["manifest/data"], manifest.model_dump_json(by_alias=True))
    _put(entry["wear/title"], f"Wear of the pin, run {manifest.id}")
    nexus.field(nexus.group(entry, "user", "NXuser"), "name", manifest.operator)
    _summarise(entry, "conditions", "NXcollection", manifest.conditions)
    for name, body in manifest.bodies.items():
        _put(entry[name]["name"], f"{body.material} {name}")
        _summarise(entry[name], "properties", "NXcollection", body)


def _put_result(process: h5py.Group, step: Step) -> None:
    _put(process["result/data"], step.result.model_dump_json(by_alias=True))
    _put(process["fingerprints/result_sha256"], step.result_sha256)
    _summarise(process, "parameters", "NXparameters", step.result)


def _put(field: h5py.Dataset, text: str | None) -> None:
    field[()] = text or ""


def _summarise(parent: h5py.Group, name: str, nx_class: str, record: Record) -> None:
    del parent[name]
    nexus.summary(nexus.group(parent, name, nx_class), record)


def _scaled(result: Record, factor: float) -> Record:
    """Return a fit with another k_D."""
    return type(result).model_validate(dict(_multiplied(result.model_dump(), factor)))


def _multiplied(document: Mapping[str, Any], factor: float) -> Iterator[tuple[str, Any]]:
    """Return a document in which every wear coefficient is multiplied."""
    for key, value in document.items():
        yield key, _times(value, factor)


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, Mapping) and value.get("unit") == "m^2/N":
        spread = value["standard_uncertainty"]
        scaled = {"value": value["value"] * factor, "standard_uncertainty": spread and spread * factor}
        return dict(value) | scaled
    if isinstance(value, Mapping):
        return dict(_multiplied(value, factor))
    return tuple(map(partial(_times, factor=factor), value)) if isinstance(value, tuple) else value


def _remark(entry: h5py.Group, chance: random.Random) -> None:
    """Tag some runs, and mark a few as bad."""
    told: dict[str, Any] = {"date": "2026-01-05T08:00:00+00:00", "operator": chance.choice(_PEOPLE)}
    if chance.random() < 0.2:
        write_annotations(entry, [Annotation(kind="tag", text=chance.choice(_TAGS), **told)])
    if chance.random() < 0.02:
        write_marks(entry, [Mark(kind="bad", reason="the pin slipped", **told)])


if __name__ == "__main__":
    many_runs(Path(sys.argv[1]), int(sys.argv[2]))
