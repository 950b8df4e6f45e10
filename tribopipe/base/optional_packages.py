"""Packages of the optional extras, imported where they are needed."""

from importlib import import_module
from typing import Any

from tribopipe.base.errors import NotInstalledError, TribopipeError


def required(
    module: str,
    extra: str,
    purpose: str,
    *,
    problem: str | None = None,
    error: type[TribopipeError] = NotInstalledError,
) -> Any:
    """Import a module of a package that an extra of tribopipe installs.

    Raises ``error`` if it is not installed: ``problem`` replaces the first part of its sentence, "xarray: not
    installed", and ``purpose`` is what the package is needed for.
    """
    try:
        return import_module(module)
    except ImportError:
        raise error(
            f"{problem or f'{module}: not installed'}; expected this package for {purpose}; run "
            f'pip install "tribopipe[{extra}]"'
        ) from None
