"""An archive in which every text that a lab can write is an attack on whoever shows it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tribopipe import read_run
from tribopipe.archive.store import Archive
from tribopipe.documents.annotation import Annotation, Mark
from tribopipe.documents.recipe import MonteCarloRecipe, Recipe
from tribopipe.documents.study import Study
from tribopipe.pipeline.studies import run_study
from tribopipe.results.finding import Finding
from tribopipe.results.run import ExtraColumn, SourceFile

QUICK = Recipe(monte_carlo=MonteCarloRecipe(significant_digits=0))

SCRIPT = "<script>alert(1)</script>"
HOSTILE = (
    f'{SCRIPT}"><img src=x onerror=alert(1)></style></svg></title>javascript:alert(1) $x_$ {{{{ 7*7 }}}} &lt;b&gt;'
)
STEERING = "a\x00b\x1b[31m\u202eturned"


def hostile_archive(folder: Path, into: Path, text: str = HOSTILE) -> Archive:
    """Archive the run of a folder and a study of it, with markup, or another text, in every text."""
    run = read_run(folder)
    bodies = {name: body.model_copy(update={"material": text}) for name, body in run.manifest.bodies.items()}
    scar = run.manifest.end_values.pin_scar_diameter.model_copy(update={"method": text})
    manifest = run.manifest.model_copy(
        update={
            **dict.fromkeys(("title", "operator", "instrument"), text),
            "comment": STEERING,
            "contact": run.manifest.described.model_copy(update=bodies),
            "conditions": run.manifest.conditions.model_copy(update={"medium": text}),
            "end_values": run.manifest.end_values.model_copy(update={"pin_scar_diameter": scar}),
        }
    )
    spoiled = replace(
        run,
        manifest=manifest,
        sources=(SourceFile(text, b"1"),),
        extras={text: ExtraColumn(np.zeros(len(run)), text)},
    )
    archive = Archive(into)
    archive.add(spoiled, [Finding(severity="warning", code="x", where=text, message=text, remedy=text)])
    archive.mark(run.id, Mark(kind="bad", reason=text, date=text, operator=text))
    archive.mark(run.id, Mark(kind="good", reason=text, date=text, operator=text))
    archive.annotate(run.id, Annotation(kind="tag", text=SCRIPT, date=text))
    archive.annotate(run.id, Annotation(kind="note", text=text, date=text, operator=text))
    assert [one for one in run_study(archive, Study(id="x", title=text, fit=(run.id,)), QUICK) if one.error] == []
    archive.mark(run.id, Mark(kind="bad", reason=text, date=text, operator=text))
    return archive
