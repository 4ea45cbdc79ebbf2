"""Keeps Python's collector of garbage from stopping the window."""

import gc


def spare_collector() -> None:
    """Let the collector pass over all that is there by now, which lives as long as the window.

    Looking through all of it takes a tenth of a second at a time, while nothing is painted.
    """
    gc.collect()
    gc.freeze()
