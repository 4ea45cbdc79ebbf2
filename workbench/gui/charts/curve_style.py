"""How a curve of a chart is drawn."""

from enum import Enum

COMMAND = -1
"""In place of a curve's number: the colour of what was asked for."""


class CurveStyle(Enum):
    """What a curve's stroke says."""

    SOLID = "solid"
    """What was measured."""
    DASHED = "dashed"
    """What was asked for, or predicted."""
    FAINT = "faint"
    """What is past, or of a log."""
