"""Pictures drawn by a process of their own."""

import importlib
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from workbench.design.executor.local_processes import without_interrupts
from workbench.errors import WorkbenchError


class Drawer:
    """Loads matplotlib in another process while the flight is computed, and draws there.

    That is a second or so less to wait for, where there is a second core. It is spawned, as
    Drake's threads do not survive a fork.

    Args:
        module: that has the function which draws.
        function: its name; takes what is drawn, returns a matplotlib figure.
    """

    def __init__(self, module: str, function: str) -> None:
        self._draws = module, function
        self._pool = ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn"))
        with without_interrupts():
            self._pool.submit(_load, module)

    def png(self, what: Any, to: Path) -> None:
        """Draw it and write the picture.

        Raises:
            WorkbenchError: if the process was ended from outside.
        """
        try:
            self._pool.submit(_draw, *self._draws, what, to).result()
        except BrokenProcessPool as error:
            raise WorkbenchError(
                "the process that draws was ended from outside, perhaps for want of memory: close "
                "other programs, or add --no-plots"
            ) from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Let it end; after a failure the command says so first, and waits at its very end."""
        self._pool.shutdown(wait=kind is None, cancel_futures=True)


def _load(module: str) -> None:
    importlib.import_module("matplotlib.backends.backend_agg")
    importlib.import_module(module)


def _draw(module: str, function: str, what: Any, to: Path) -> None:
    from workbench.design.plots import write_png

    write_png(getattr(importlib.import_module(module), function)(what), to)
