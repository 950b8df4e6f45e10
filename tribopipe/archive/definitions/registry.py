"""All definitions that archived files follow, by name."""

from collections.abc import Mapping
from functools import cache

from tribopipe.archive.definitions.parts import Definition
from tribopipe.archive.definitions.run import run_definition
from tribopipe.archive.definitions.study import study_definition
from tribopipe.documents.contact_kinds import contacts


@cache
def definitions() -> Mapping[str, Definition]:
    """Return each definition by its name."""
    found = (*map(run_definition, (*contacts(), None)), study_definition())
    return {definition.name: definition for definition in found}
