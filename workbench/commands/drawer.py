"""A process that draws figures: `python -m workbench.commands.drawer FD`."""

import gc
import importlib
import pickle
import sys
import threading
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from queue import SimpleQueue
from typing import Any, Self

from workbench.commands.printing import print_message
from workbench.common.errors import WorkbenchError
from workbench.ipc.child_process import ChildProcess

FIGURE_MESSAGE_PERIOD_S = 3.0
"""Period between messages while waiting for a figure [s]."""


class Drawer:
    """Loads matplotlib in another process during a flight, and draws there.

    This saves about a second if there is a second core. Call `finish` to wait for the figures.

    Args:
        modules: with the functions that draw.
    """

    def __init__(self, *modules: str) -> None:
        self._process = ChildProcess("workbench.commands.drawer", "picture")
        self._process.connection.send(modules)
        self._begun: list[Path] = []

    def begin(self, to: Path, module: str, function: str, *args: Any, **options: Any) -> None:
        """Begin to draw a figure, and to write it.

        Args:
            to: file of the figure.
            module: of the function.
            function: its name; it returns a matplotlib figure.
            args: of the function.
            options: of the function.

        Raises:
            WorkbenchError: if the process was killed.
        """
        try:
            self._process.connection.send((to, module, function, args, options))
        except OSError as gone:  # the process has ended
            raise self._ended() from gone
        self._begun.append(to)

    def finish(self) -> None:
        """Wait until all figures are written.

        Raises:
            WorkbenchError: if a figure cannot be written, or the process was killed.
        """
        while self._begun:
            picture = self._begun.pop(0)
            try:
                while not self._process.connection.poll(FIGURE_MESSAGE_PERIOD_S):
                    print_message(f"drawing {picture}; the first time, matplotlib looks for fonts")
                error = self._process.connection.recv()
            except (EOFError, OSError) as gone:
                raise self._ended() from gone
            if error is not None:
                raise error

    def _ended(self) -> WorkbenchError:
        return WorkbenchError(
            f"{self._process.cause()}: if memory ran out, close other programs; or add --no-plots"
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """End the process; all finished figures are written."""
        self._process.end(0.0)
        self._process.release()


def main(connection: Connection) -> int:
    """Load the modules that draw, then handle requests until the connection closes.

    The first message has the names of modules, later ones the arguments of `Drawer.begin`, with the
    answer None or an exception. A thread reads them while modules load, so that the other side does
    not block.
    """
    gc.disable()  # all objects here live as long as the process
    read: SimpleQueue[bytes | None] = SimpleQueue()
    threading.Thread(target=_read, args=(connection, read), daemon=True).start()
    first = read.get()
    if first is None:
        return 0
    _leave_out_help()
    for module in ("matplotlib.backends.backend_agg", *pickle.loads(first)):
        importlib.import_module(module)
    write = importlib.import_module("workbench.design.plots").write_png
    with suppress(OSError):
        while (message := read.get()) is not None:
            try:
                to, module, function, args, options = pickle.loads(message)
                draw = getattr(importlib.import_module(module), function)
                write(draw(*args, **options), to)
            except Exception as error:
                connection.send(_fit_to_send(error))
            else:
                connection.send(None)
    return 0


def _leave_out_help() -> None:
    """Load matplotlib without the help texts of its classes, which take a third of that time.

    It composes them for each class from all its methods, and nobody reads them in this process. A
    release with other names composes them as usual.
    """
    from matplotlib import artist

    if hasattr(artist.Artist, "_update_set_signature_and_docstring") and hasattr(artist, "kwdoc"):
        setattr(artist, "kwdoc", lambda of: "")  # noqa: B010
        setattr(  # noqa: B010
            artist.Artist, "_update_set_signature_and_docstring", classmethod(lambda cls: None)
        )


def _read(connection: Connection, read: "SimpleQueue[bytes | None]") -> None:
    """Put all messages into a queue, and None at the end."""
    with suppress(EOFError, OSError):
        while True:
            read.put(connection.recv_bytes())
    read.put(None)


def _fit_to_send(error: Exception) -> Exception:
    """Return the exception, or one with its text if it cannot be unpickled."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # foreign exceptions may fail in any way
        return RuntimeError(repr(error))
    return error


if __name__ == "__main__":
    sys.exit(main(Connection(int(sys.argv[1]))))
