"""No test needs a screen; this must be said before Qt or matplotlib is imported."""

import gc
import os
import signal

import pytest

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("MPLBACKEND", "Agg")
# a shell lets what runs in the background ignore Ctrl-C, and so would all that the tests start
signal.signal(signal.SIGINT, signal.default_int_handler)

# Drake ends the process where a Meshcat, and Qt where a widget, is collected in another thread than
# its own: so Python collects nothing by itself, and all is collected here, between tests.
gc.disable()
_COLLECT_EVERY = 20
"""So many tests."""


@pytest.fixture(autouse=True)
def collected(request):
    """Collect what earlier tests left, now and then, in the main thread."""
    count = request.config.stash.get(_COUNT, 0) + 1
    request.config.stash[_COUNT] = count
    if count % _COLLECT_EVERY == 0:
        gc.collect()


_COUNT = pytest.StashKey[int]()
