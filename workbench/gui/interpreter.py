"""What Python's interpreter does beside the window: threads that take turns, and garbage."""

import gc
import sys

TURN = 0.0005
"""After which a thread that paints lets one go on that carries an answer [s].

Python's own 5 ms, taken twice on the way out and once on the way back, would be most of the time
from a slider to its margins.
"""


def take_short_turns() -> None:
    """Let the threads that carry orders and answers wait little for the one that paints."""
    sys.setswitchinterval(TURN)


def spare_collector() -> None:
    """Let the collector pass over all that is there by now, which lives as long as the window.

    Looking through all of it takes a tenth of a second at a time, while nothing is painted.
    """
    gc.collect()
    gc.freeze()
