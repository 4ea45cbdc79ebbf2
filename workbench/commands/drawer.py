"""Pictures drawn by a process of their own: `python -m workbench.commands.drawer FD`."""

import importlib
import pickle
import sys
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from workbench.common.errors import WorkbenchError
from workbench.ipc.child_process import ChildProcess


class Drawer:
    """Loads matplotlib in another process while the flight is computed, and draws there.

    That is a second or so less to wait for, where there is a second core.

    Args:
        module: that has the function which draws.
        function: its name; takes what is drawn, returns a matplotlib figure.
    """

    def __init__(self, module: str, function: str) -> None:
        self._process = ChildProcess("workbench.commands.drawer", "picture")
        self._process.connection.send((module, function))

    def png(self, what: Any, to: Path) -> None:
        """Draw it and write the picture.

        Raises:
            WorkbenchError: if it cannot be written, or the process was ended from outside.
        """
        try:
            self._process.connection.send((what, to))
            error = self._process.connection.recv()
        except (EOFError, OSError) as gone:  # nobody is at the other end
            raise WorkbenchError(
                f"{self._process.cause()}: close other programs if it was for want of memory, or "
                "add --no-plots"
            ) from gone
        if error is not None:
            raise error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it; whatever was drawn is written."""
        self._process.end(0.0)
        self._process.release()


def main(connection: Connection) -> int:
    """Load what draws, then draw what comes until nobody is at the other end.

    The first message is module and function, later ones what to draw and where to write it; each
    of those is answered by None, or by the exception.
    """
    with suppress(EOFError, OSError):
        module, function = connection.recv()
        importlib.import_module("matplotlib.backends.backend_agg")
        draw = getattr(importlib.import_module(module), function)
        write = importlib.import_module("workbench.design.plots").write_png
        while True:
            what, to = connection.recv()
            try:
                write(draw(what), to)
            except Exception as error:
                connection.send(_fit_to_send(error))
            else:
                connection.send(None)
    return 0


def _fit_to_send(error: Exception) -> Exception:
    """Return it, or its words where the other side could not read it."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # a stranger's may refuse in any way
        return RuntimeError(repr(error))
    return error


if __name__ == "__main__":
    sys.exit(main(Connection(int(sys.argv[1]))))
