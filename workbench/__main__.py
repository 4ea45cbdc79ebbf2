# PYTHON_ARGCOMPLETE_OK
"""`python -m workbench` is the command `workbench`.

Nothing is loaded here before Ctrl-C is waited for: a person who presses it while modules load wants
no traceback.
"""

import gc
import os
import sys

NEW_OBJECTS_PER_COLLECTION = 50_000
"""With the 2,000 of Python it searches for garbage 40 times while modules load, which takes a
fourteenth of a short command; nearly all that is made then stays."""

if __name__ == "__main__" and not sys.flags.safe_path:
    del sys.path[0]  # the current folder, in which a file may have a module's name, as signal.py


def main() -> int:
    """Run the command line, and return its exit code."""
    # Two threads of numpy's on a matrix of 100 rows wait busily for each other where flight, window
    # and analysts share the cores: a solution of 50 µs then takes 100 ms. Processes inherit it.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(NEW_OBJECTS_PER_COLLECTION)
    try:
        from workbench.commands.cli import main as run
        from workbench.common.import_path import own_packages_first

        own_packages_first()
        return run()
    except KeyboardInterrupt:  # before the command line began, or after it had ended
        print("workbench: interrupted; nothing was written", file=sys.stderr)
        return 130
    finally:
        _end_quickly()


def _end_quickly() -> None:
    """Prepare the end of the process: no search for garbage, and no traceback for Ctrl-C.

    Python searches for garbage while it ends. With Drake and numpy that takes 40 ms, a seventh of a
    short command, and the system takes the memory back anyway.
    """
    import signal

    gc.disable()
    gc.freeze()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


if __name__ == "__main__":
    sys.exit(main())
