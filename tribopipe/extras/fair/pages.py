"""A crate as people read it: the page of a run or a study in a notebook, and ro-crate-preview.html."""

from collections.abc import Mapping, Sequence
from typing import Any
from urllib.parse import unquote

import orjson
from markupsafe import Markup

from tribopipe.archive.store import Archive
from tribopipe.views.html.rendering import rendered
from tribopipe.views.run_page import run_page
from tribopipe.views.study_page import study_page

_ROWS = (
    ("Creators", "creator"),
    ("Publisher", "publisher"),
    ("Published", "datePublished"),
    ("Version", "version"),
    ("DOI", "identifier"),
    ("License", "license"),
    ("Funding", "funding"),
    ("Belongs to", "citation"),
    ("Keywords", "keywords"),
)
"""What the preview shows of the crate as a whole."""
_Entity = Mapping[str, Any]


def run_text(archive: Archive, run_id: str, tested: str) -> Markup:
    """Return what a notebook shows of a run; ``tested`` states in a sentence what was tested."""
    return Markup(rendered("run_record.html", tested=tested, internal=True, run={"page": run_page(archive, run_id)}))  # noqa: S704


def study_text(archive: Archive, study_id: str) -> Markup:
    """Return what a notebook shows of a study."""
    return Markup(rendered("study_record.html", study=study_page(archive, study_id)))  # noqa: S704


def preview(metadata: bytes, texts: Mapping[str, Markup]) -> str:
    """Return the page that RO-Crate recommends, with a copy of the metadata in it, as RO-Crate 1.1 demands.

    ``texts`` are those of runs and studies, by their folder in the crate.
    """
    document = orjson.loads(metadata)
    graph = {entity["@id"]: entity for entity in document["@graph"]}

    def of(entity: _Entity, name: str) -> Sequence[Any]:
        """Yield the values of a property of an entity: texts, and the entities that it refers to."""
        said = entity.get(name, [])
        return [
            graph[one["@id"]] if isinstance(one, dict) else one for one in (said if isinstance(said, list) else [said])
        ]

    root = graph["./"]
    return rendered(
        "crate.html",
        title=root["name"],
        root=root,
        citation=_citation(root, of(root, "creator"), of(root, "publisher")),
        rows=_ROWS,
        records=[(graph[folder], text) for folder, text in texts.items()],
        about=graph["about/"],
        metadata=_inert(document),
        of=of,
        decoded=unquote,
    )


def _citation(root: _Entity, creators: Sequence[_Entity], publishers: Sequence[_Entity]) -> str:
    """Return how DataCite would have the data cited: creators (year): title. Version. Publisher. DOI."""
    names = "; ".join(", ".join(filter(None, (one["familyName"], one.get("givenName")))) for one in creators)
    parts = [f"{names or 'Unknown'} ({root['datePublished'][:4]}): {root['name']}"]
    parts += [f"Version {root['version']}"] if "version" in root else []
    parts += [one["name"] for one in publishers]
    parts += [root["identifier"]] if "identifier" in root else []
    return ". ".join(parts)


def _inert(document: object) -> Markup:
    """Write JSON so that nothing in it ends the script element that it stands in."""
    return Markup(orjson.dumps(document).decode("utf-8").replace("<", "\\u003c"))  # noqa: S704
