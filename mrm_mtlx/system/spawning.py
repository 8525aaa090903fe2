"""Worker processes that never run the script again that started them.

A process that Python spawns imports the caller's main module first, which runs a script without a guard
(`if __name__ == "__main__"`) anew, and so on for ever. Workers of this package need nothing of it.
"""

from __future__ import annotations

import sys
import threading
from contextlib import contextmanager
from multiprocessing import context
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

_STARTING = threading.Lock()


class _Process(context.SpawnProcess):
    """A process that is spawned while the caller's main module is out of sight."""

    @staticmethod
    def _Popen(process_obj: Any) -> Any:  # noqa: N802  as the base has it
        with _without_main():
            return context.SpawnProcess._Popen(process_obj)


class SpawnContext(context.SpawnContext):
    """Spawns processes that do not import the caller's main module; for `multiprocessing` and its pools."""

    Process = _Process


@contextmanager
def _without_main() -> Iterator[None]:
    with _STARTING:
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            yield
        finally:
            sys.modules["__main__"] = main
