"""How a curve of a chart is drawn."""

from enum import Enum

from PyQt6.QtGui import QColor, QPen

COMMAND = -1
"""In place of a curve's number: the colour of what was asked for."""
FAINT_SHARE = 0.45
"""Of its colour that a faint curve keeps."""


class CurveStyle(Enum):
    """What a curve's stroke says."""

    SOLID = "solid"
    """What was measured."""
    DASHED = "dashed"
    """What was asked for, or predicted."""
    FAINT = "faint"
    """What is past, or of a log."""


def make_pen(colour: QColor, style: CurveStyle, ground: QColor) -> QPen:
    """Return the pen of a curve on a ground: one pixel wide, which is what Qt paints fast."""
    if style is CurveStyle.FAINT:  # mixed, as blending is slow
        pairs = zip(colour.getRgb()[:3], ground.getRgb()[:3], strict=True)
        mixed = [FAINT_SHARE * (a or 0) + (1.0 - FAINT_SHARE) * (b or 0) for a, b in pairs]
        colour = QColor(*map(round, mixed))
    pen = QPen(colour, 1)
    pen.setCosmetic(True)
    if style is CurveStyle.DASHED:
        pen.setDashPattern([6.0, 4.0])
    return pen
