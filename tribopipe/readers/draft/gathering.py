"""What a template, a person and the headers of files state about a run, and which has priority."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from typing import Any

from tribopipe.base.errors import ManifestError
from tribopipe.documents.quantity import read_quantity
from tribopipe.readers.draft.known_values import LOAD, Given, Known, alike, flat, shared_key
from tribopipe.readers.draft.toml import value_of
from tribopipe.readers.export_files import Export

_MOST_DOUBTS = 4
_ROUNDED = 0.01
"""How far half a diameter may be from a radius for both to be the same."""
_SHAPE, _DIAMETER, _RADIUS = "contact.pin.shape", "contact.pin.diameter", "contact.pin.radius"


def gather(
    template: Mapping[str, Any],
    template_name: str,
    settings: Sequence[str],
    exports: Sequence[Export],
    measured: Mapping[str, Given] | None = None,
) -> Known:
    """Gather what a template, a person, a table of ``measured`` values and the headers of files state about a run.

    A person's word goes before the table's, that before a header's, that before a template's. Raises ``ManifestError``
    where the template, the table or the person state what cannot be; what headers state is doubted.
    """
    known = Known()
    told = {key: value for key, value in flat(template).items() if key not in ("schema", "signals")}
    known.given = {key: Given(value, f"from {template_name}") for key, value in told.items()}
    if told and (problem := known.problem()) is not None:
        raise ManifestError(f"{template_name}: {problem}")
    for key, given in (measured or {}).items():
        problem = known.take_text(key, given.value, given.origin) if isinstance(given.value, str) else None
        problem = problem if isinstance(given.value, str) else known.take(key, given.value, given.origin)
        if problem is not None:
            raise ManifestError(f"{given.origin.removeprefix('from ')}: {problem}")
        known.of_tables.add(shared_key(key))
    for setting in settings:
        _set(known, setting)
    for key, values in _facts(exports).items():
        _take_fact(known, key, values)
    take_radius(known)
    return known


def take_radius(known: Known) -> None:
    """Take half the diameter of a ball as its radius, where nobody has stated another one."""
    diameter, shape = (known.values.get(key) for key in (_DIAMETER, _SHAPE))
    if diameter is None or shape != "spherical":
        return
    whole, before = read_quantity(diameter, "length"), known.given.get(_RADIUS)
    half, unsure = (f"{1e3 * number / 2:.12g} mm" for number in (whole.value, whole.standard_uncertainty or 0.0))
    origin = "half of the diameter"
    if before is not None:
        if not before.origin or alike(_RADIUS, before.value, half, _ROUNDED):
            return
        origin += f"; {before.origin.removeprefix('from ')} gives {before.value}"
    stated = half if whole.standard_uncertainty is None else {"value": half, "standard_uncertainty": unsure}
    problem = known.take(_RADIUS, stated, origin)
    if problem is not None:
        known.dissent.append(f"the radius of the pin is not taken from its diameter of {whole.shown('mm')}: {problem}")


def _set(known: Known, setting: str) -> None:
    key, equals, text = (part.strip() for part in setting.partition("="))
    if not equals:
        raise ManifestError(
            f"--set {setting}: found no '='; expected a key of run.toml and its value, such as {LOAD}='50 N'"
        )
    value = value_of(text)
    problem = known.take(key, value)
    if problem is not None and not isinstance(value, Mapping | list):
        problem = known.take_typed(key, text)
    if problem is not None:
        raise ManifestError(f"--set {setting}: {problem}")


Said = dict[str, list[str]]
"""What headers state about one key → the files that state it, with the line where it is a free one."""


def _facts(exports: Iterable[Export]) -> dict[str, Said]:
    told: dict[str, Said] = {}
    for export in exports:
        for key, text in export.header.facts.items():
            line = export.header.lines.get(key)
            source = export.name if line is None else f"{export.name}, {' '.join(line.split())!r}"
            told.setdefault(key, {}).setdefault(text, []).append(source)
    return told


def _take_fact(known: Known, key: str, said: Said) -> None:
    if len(said) > 1 and key != "started":
        for text, files in islice(said.items(), _MOST_DOUBTS):
            known.doubt(key, text, f"given by {_few(files)}; the files do not agree")
        return
    text, files = next(iter(said.items()))  # a test starts with its first file
    before, origin = known.given.get(key), f"from {_few(files)}"
    if before is not None and key in known.of_tables:
        if not alike(key, before.value, text):
            known.object(key, f"{text} {origin}")
        return
    if before is not None and not before.origin:
        known.given[key] = before if text == before.value else Given(before.value, f"{_few(files)} gives {text}")
        return
    if before is not None and text != before.value:
        origin += f"; {before.origin.removeprefix('from ')} gives {before.value}"
    problem = known.take_text(key, text, origin)
    if problem is None:
        known.of_headers.add(key)
    else:
        known.doubt(key, text, f"from {_few(files)}, but {problem}")


def _few(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
