"""The heading as a tape, in degrees clockwise from north."""

import math

import pyqtgraph as pg
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QFont
from PyQt6.QtWidgets import QSizePolicy

from workbench.gui.instruments.heading import compass_point, heading_of, mark_text
from workbench.gui.theme import Look

HEADING_TAPE_SPAN_DEG = 120.0
"""Visible part of the tape [degrees]."""
HEADING_RESOLUTION_DEG = 0.1
"""Smaller changes are not shown [degrees]."""
TAPE_HEIGHT_EM = 2.6
"""Height of the tape relative to plain text."""


class HeadingTape(pg.PlotWidget):
    """Shows the heading as the middle of an axis in degrees clockwise from north.

    Args:
        look: source of colours.

    Attributes:
        heading: the shown heading [degrees], NaN before the first.
    """

    def __init__(self, look: Look) -> None:
        self._axis = pg.AxisItem("top", maxTickLength=6)
        super().__init__(axisItems={"top": self._axis}, enableMenu=False)
        self._look = look
        self.heading = math.nan
        turns = range(-90, 451, 5)
        numbered = [each for each in turns if each % 45 == 0 or each % 30 == 0]
        self._axis.setTicks(
            [[(each, mark_text(each)) for each in numbered], [(each, "") for each in turns]]
        )
        self._pointer = pg.InfiniteLine(0.0)
        top = (False, True, False, False)
        self.plotItem.showAxes(top, showValues=top)
        self.plotItem.hideButtons()
        self.plotItem.setMouseEnabled(False, False)
        self.addItem(self._pointer)
        self.setYRange(0.0, 1.0, padding=0.0)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setAccessibleName("Heading")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        look.changed.connect(self._apply_colours)
        self._apply_colours()
        self._axis.hide()

    @property
    def spoken(self) -> str:
        """The heading as a sentence."""
        if math.isnan(self.heading):
            return "no heading yet"
        return f"heading {self.heading:.0f} degrees, {compass_point(self.heading)}"

    def show_yaw(self, yaw: float) -> None:
        """Show the heading of a yaw [rad]; none if it is not finite."""
        heading = math.nan
        if math.isfinite(yaw):
            steps = round(heading_of(yaw) / HEADING_RESOLUTION_DEG)
            heading = HEADING_RESOLUTION_DEG * steps % 360.0
        if heading == self.heading or (math.isnan(heading) and math.isnan(self.heading)):
            return
        self.heading = heading
        self._axis.setVisible(math.isfinite(heading))
        self._pointer.setVisible(math.isfinite(heading))
        if math.isfinite(heading):
            half = 0.5 * HEADING_TAPE_SPAN_DEG
            self.setXRange(heading - half, heading + half, padding=0.0)
            self._pointer.setValue(heading)

    def set_text_size(self, size: float) -> None:
        """Set the height of its text [px]."""
        font = QFont(self.font())
        font.setPixelSize(round(size))
        self._axis.setTickFont(font)
        self._axis.setHeight(round(1.9 * size))
        self.setFixedHeight(round(TAPE_HEIGHT_EM * size))

    def _apply_colours(self) -> None:
        """Apply the colours of the look."""
        colour = self._look.colour
        self.setBackground(colour("card"))
        self._axis.setPen(colour("muted"))
        self._axis.setTextPen(colour("ink"))
        self._pointer.setPen(pg.mkPen(colour("accent"), width=3))
