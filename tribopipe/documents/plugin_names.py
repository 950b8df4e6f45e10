"""Names of what packages may add: those of installed ones in documents that people write, any in what is read back."""

import re
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationInfo
from pydantic_core import CoreSchema, core_schema

from tribopipe.base.plugins import names, not_installed

WRITTEN_BY_PEOPLE = {"written_by_people": True}
"""Context in which a document is validated that people write."""


@dataclass(frozen=True)
class InstalledName:
    """Declare that a text names something of a group of entry points.

    An archive may come from a machine where more is installed, so that results are read whatever they name.
    """

    group: str
    what: str
    pattern: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return the schema of the text, which is then held against the names."""
        return core_schema.with_info_after_validator_function(self._checked, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return a schema that names what is installed here."""
        return {"type": "string", "enum": self.names()}

    def names(self) -> list[str]:
        """Return the names of what is installed."""
        return names(self.group)

    def _checked(self, name: str, info: ValidationInfo) -> str:
        if info.context == WRITTEN_BY_PEOPLE and name not in self.names():
            raise ValueError(not_installed(self.group, self.what, name))
        if not re.fullmatch(self.pattern, name):
            raise ValueError(
                f"found {name!r}, which is not a valid name of a {self.what}; expected lowercase letters, digits and "
                "_, not ending in flat; rename it"
            )
        return name
