"""JSON Schemas of the records, for editors and other programs."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tribopipe.base.files import write_file
from tribopipe.documents.contact import Contact
from tribopipe.documents.contact_kinds import SHIPPED, WITH_BALL, alternatives
from tribopipe.documents.dataset import Dataset
from tribopipe.documents.lab_template import Template
from tribopipe.documents.manifest import RunManifest, foreign_keys
from tribopipe.documents.plan import Plan, Truth, TwinDiscTruth
from tribopipe.documents.preprocessing import CleanUp
from tribopipe.documents.reader_profile import ReaderProfile
from tribopipe.documents.recipe import Recipe
from tribopipe.documents.record import Record
from tribopipe.documents.report_details import ReportDetails
from tribopipe.documents.study import Study
from tribopipe.documents.sweep import Sweep
from tribopipe.results.evaluation import DriftCorrection, FrictionFit
from tribopipe.results.local_wear import LocalWearResult
from tribopipe.results.specific_wear import SpecificWear
from tribopipe.results.study import Design, StudyResult
from tribopipe.results.wear_fit import WearFit
from tribopipe.results.wear_prediction import WearPrediction

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
    "report": ReportDetails,
    "clean-up": CleanUp,
    "drift-correction": DriftCorrection,
    "friction-fit": FrictionFit,
    "specific-wear": SpecificWear,
    "wear-fit": WearFit,
    "wear-prediction": WearPrediction,
    "local-wear": LocalWearResult,
    "study-result": StudyResult,
    "twin-disc-truth": TwinDiscTruth,
    "design": Design,
}


def schema_text(name: str) -> str:
    """Return one schema as the file holds it."""
    schema: dict[str, Any] = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$comment": "Written by tribopipe schema export.",
    }
    schema |= SCHEMAS[name].model_json_schema(by_alias=True)
    for title, part in schema.get("$defs", {}).items():
        if title in ("EndValues", "Interruption"):
            part["properties"] |= _in_names_of_contacts(title, part["properties"])
    for kind in SHIPPED.values():
        _leave_out(schema.get("$defs", {}), kind)
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def _in_names_of_contacts(title: str, properties: Mapping[str, Any]) -> dict[str, Any]:
    """Return post-test measurements by the names that kinds of contact have for their bodies, and of a ball."""
    named: dict[str, Any] = {}
    for name in properties:
        part = {"$ref": f"#/$defs/{title}/properties/{name}"}
        kinds = (*SHIPPED.values(), *WITH_BALL.values())
        own = [kind.worded(name) for kind in kinds if name not in foreign_keys(kind)]
        named |= {one: part for one in own if one not in properties}
    return named


def _leave_out(definitions: Mapping[str, Any], kind: type[Contact]) -> None:
    """Let an editor accept a ball in the place of a pin, and bodies that are like another where they are left out."""
    part = definitions.get(kind.__name__)
    if part is None:
        return
    required = [name for name in part["required"] if name not in kind.like]
    for name, other in alternatives(kind).items():
        about = f"{other.capitalize()}, instead of {name}."
        part["properties"][other] = {"$ref": f"#/$defs/{other.capitalize()}", "description": about}
        part["anyOf"] = [{"required": [name]}, {"required": [other]}]
        required.remove(name)
    part["required"] = required


def schema_files() -> dict[str, str]:
    """Return which schema each file holds."""
    return {f"{name}.schema.json": name for name in SCHEMAS}


def write_schemas(folder: Path) -> list[Path]:
    """Write every schema into a folder and return the files."""
    folder.mkdir(parents=True, exist_ok=True)
    for file, name in schema_files().items():
        write_file(folder / file, schema_text(name).encode("utf-8"))
    return [folder / file for file in schema_files()]
