"""The process of a `Drawer`: `python -m workbench.commands.drawing FD`, a socket to the caller."""

import importlib
import pickle
import sys
from contextlib import suppress
from multiprocessing.connection import Connection


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
