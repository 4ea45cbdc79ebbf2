"""Settings of Python's interpreter that keep painting smooth."""

import gc
import sys

SWITCH_INTERVAL_S = 0.0005
"""Interval after which the painting thread yields to threads that carry answers [s].

Python's default of 5 ms, needed twice for a question and once for the reply, would be most of the
delay from a slider to its margins.
"""


def shorten_switch_interval() -> None:
    """Let threads that carry orders and answers wait less for the thread that paints."""
    sys.setswitchinterval(SWITCH_INTERVAL_S)


def freeze_gc() -> None:
    """Exclude present objects from garbage collection, as they live as long as the window.

    A collection of all of them would stop painting for a tenth of a second.
    """
    gc.collect()
    gc.freeze()
