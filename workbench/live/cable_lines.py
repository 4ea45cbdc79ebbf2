"""Cables as lines, as plain numbers for Meshcat and the Qt view."""

import numpy as np

from workbench.session.snapshot import CableStatus

SAG_POINTS = 9
"""Number of points of the line of a slack cable."""
_SAG_SHARE = 0.75**0.5
"""Sag of a parabola of the same length, over that of two straight halves, for a small sag."""


def cable_line(cable: CableStatus) -> np.ndarray:
    """Return the points of a cable in W (N, 3) [m]: straight if it is taut, else a parabola.

    The sag is about that of a line of the cable's length.
    """
    upper, lower = np.array(cable.upper), np.array(cable.lower)
    if not cable.slack:
        return np.array([upper, lower])
    apart = float(np.linalg.norm(lower - upper))
    sag = 0.5 * _SAG_SHARE * max(cable.length**2 - apart**2, 0.0) ** 0.5
    share = np.linspace(0.0, 1.0, SAG_POINTS)[:, None]
    return upper + share * (lower - upper) - 4.0 * sag * share * (1.0 - share) * [0.0, 0.0, 1.0]
