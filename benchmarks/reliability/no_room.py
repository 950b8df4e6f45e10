"""The calls of the system through which files are written, of which one, or all from it on, find the disk full."""

import os
from collections.abc import Callable
from errno import ENOSPC
from pathlib import Path
from typing import Any

from tribopipe.archive.file_access import LateErrors


class Layer:
    """The calls of the system through which files are written; the disk is full from some call on, or for one."""

    def __init__(self, fails_at: int, *, for_good: bool, told: Path | None = None) -> None:
        self.fails_at, self.for_good, self.told, self.calls = fails_at, for_good, told, 0

    def __call__(self) -> None:
        """Put the layer below this process."""
        for name in ("fsync", "replace"):
            setattr(os, name, self._over(getattr(os, name)))
        os.mkdir = self._over(os.mkdir, only=lambda path, *_, **__: not Path(path).exists())
        os.open = self._over(os.open, only=lambda path, flags, *_, **__: flags & os.O_CREAT and not Path(path).exists())
        Path.write_bytes = self._half_of(Path.write_bytes)  # type: ignore[assignment,method-assign]
        LateErrors.write_all = self._half_of(LateErrors.write_all)  # type: ignore[assignment,method-assign]

    def _half_of(self, plain: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        """Return a way to write of which half is done where the disk is full."""

        def write(file: Any, content: Any) -> Any:
            if self._is_full():
                plain(file, content[: len(content) // 2])
                raise OSError(ENOSPC, os.strerror(ENOSPC))
            return plain(file, content)

        return write

    def _over(
        self, call: Callable[..., Any], only: Callable[..., object] = lambda *_, **__: True
    ) -> Callable[..., Any]:
        def over(*given: Any, **named: Any) -> Any:
            if only(*given, **named) and self._is_full():
                raise OSError(ENOSPC, os.strerror(ENOSPC))
            return call(*given, **named)

        return over

    def _is_full(self) -> bool:
        self.calls += 1
        if self.told is not None:
            self.told.write_text(str(self.calls), encoding="utf-8")
        return self.calls == self.fails_at or (self.for_good and self.calls > self.fails_at > 0)
