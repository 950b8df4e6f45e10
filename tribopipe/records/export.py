"""JSON Schemas of the records, for editors and other programs."""

import json
from pathlib import Path
from typing import Any

from tribopipe.files import write_file
from tribopipe.records.base import Record
from tribopipe.records.clean_up import CleanUp
from tribopipe.records.dataset import Dataset
from tribopipe.records.design import Design
from tribopipe.records.disc_results import TwinDiscFit, TwinDiscPrediction
from tribopipe.records.disc_verdict import TwinDiscStudyResult
from tribopipe.records.local_wear import LocalWearResult
from tribopipe.records.manifest import RunManifest
from tribopipe.records.plan import Plan, Truth, TwinDiscTruth
from tribopipe.records.reader_profile import ReaderProfile
from tribopipe.records.recipe import Recipe
from tribopipe.records.results import DriftCorrection, FrictionFit, WearFit, WearPrediction
from tribopipe.records.specific_wear import SpecificWear
from tribopipe.records.study import Study
from tribopipe.records.sweep import Sweep
from tribopipe.records.template import Template
from tribopipe.records.verdict import StudyResult

SCHEMAS: dict[str, type[Record]] = {
    "run": RunManifest,
    "template": Template,
    "reader": ReaderProfile,
    "recipe": Recipe,
    "plan": Plan,
    "truth": Truth,
    "study": Study,
    "sweep": Sweep,
    "dataset": Dataset,
    "clean-up": CleanUp,
    "drift-correction": DriftCorrection,
    "friction-fit": FrictionFit,
    "specific-wear": SpecificWear,
    "wear-fit": WearFit,
    "wear-prediction": WearPrediction,
    "local-wear": LocalWearResult,
    "study-result": StudyResult,
    "twin-disc-truth": TwinDiscTruth,
    "twin-disc-fit": TwinDiscFit,
    "twin-disc-prediction": TwinDiscPrediction,
    "twin-disc-study-result": TwinDiscStudyResult,
    "design": Design,
}


def schema_text(name: str) -> str:
    """Return one schema as the file holds it."""
    schema: dict[str, Any] = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$comment": "Written by tribopipe schema export.",
    }
    schema |= SCHEMAS[name].model_json_schema(by_alias=True)
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def schema_files() -> dict[str, str]:
    """Return which schema each file holds."""
    return {f"{name}.schema.json": name for name in SCHEMAS}


def write_schemas(folder: Path) -> list[Path]:
    """Write every schema into a folder and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    for file, name in schema_files().items():
        write_file(folder / file, schema_text(name).encode("utf-8"))
    return [folder / file for file in schema_files()]
