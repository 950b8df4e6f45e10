"""RO-Crates and .eln files held against their rules, without a network.

The vocabulary that a validator would fetch is the one that rocrate brings; it is of a later version of RO-Crate, and
holds all names of the earlier ones.
"""

import json
import warnings
from email.message import Message
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from urllib.response import addinfourl
from zipfile import ZipFile

import pytest
import rocrate
from jsonschema import Draft201909Validator

CONTEXT = Path(rocrate.__file__).parent / "data" / "ro-crate.jsonld"
METADATA = "ro-crate-metadata.json"
LATER_NAMES = {"sha256"}
"""Names that we use and that RO-Crate 1.1 does not have by itself, by its context.jsonld."""


def without_network(patch) -> None:
    """Have the validator take the vocabulary from the disk; nothing else is fetched."""
    pytest.importorskip("rocrate_validator", reason="it has an environment of its own, by the extra crates")
    import rdflib.parser
    from rocrate_validator.utils.http import HttpRequester

    content = CONTEXT.read_bytes()
    headers = Message()
    headers["Content-Type"] = "application/ld+json"

    def opened(request):
        assert request.full_url == "https://w3id.org/ro/crate/1.1/context"
        return addinfourl(BytesIO(content), headers, request.full_url, 200)

    def get(_self, url, **_):
        assert url == "https://w3id.org/ro/crate/1.1/context"
        return SimpleNamespace(status_code=200, headers=headers, json=lambda: json.loads(content))

    patch.setattr(rdflib.parser, "_urlopen", opened)
    patch.setattr(HttpRequester, "get", get, raising=False)


def issues(path: Path, profile: str) -> list[str]:
    """What the validator finds that a profile requires and a crate lacks."""
    from rocrate_validator import models, services

    settings = services.ValidationSettings(
        rocrate_uri=str(path), profile_identifier=profile, requirement_severity=models.Severity.REQUIRED
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of rdflib, within the validator
        found = services.validate(settings).get_issues()
    return [f"{issue.check.identifier}: {issue.message}" for issue in found]


def graph_of(path: Path) -> dict[str, dict]:
    """The entities of a crate by their id."""
    if path.is_dir():
        content = (path / METADATA).read_text(encoding="utf-8")
    else:
        with ZipFile(path) as packed:
            content = packed.read(next(name for name in packed.namelist() if name.endswith(METADATA))).decode("utf-8")
    entities = json.loads(content)["@graph"]
    assert len({entity["@id"] for entity in entities}) == len(entities)
    return {entity["@id"]: entity for entity in entities}


def datacite_errors(fields: dict) -> list[str]:
    """What DataCite's JSON schema, as the package datacite brings it, refuses of its fields."""
    datacite = pytest.importorskip("datacite", reason="it comes with the extra crates")
    schema = Path(datacite.__file__).parent / "schemas" / "datacite-v4.5.json"
    found = Draft201909Validator(json.loads(schema.read_text(encoding="utf-8"))).iter_errors(fields)
    return [f"{error.json_path}: {error.message}" for error in found]
