"""States with their shapes, and the size of text in instruments."""

from enum import Enum

DEFAULT_TEXT_HEIGHT_PX = 12.0
"""Default height of plain text [px]."""


class Sign(Enum):
    """A state; the value is the name of its colour."""

    GOOD = "good"
    WARNING = "warning"
    BAD = "bad"
    OFF = "muted"


SIGN_SHAPES = {Sign.GOOD: "●", Sign.WARNING: "▲", Sign.BAD: "✕", Sign.OFF: "○"}
"""Shape before the text of a state, as it is not told by colour alone."""
