"""The card of attitude and heading: artificial horizon, compass tape, and numbers."""

import math
from collections.abc import Sequence

from PyQt6.QtWidgets import QWidget

from workbench.gui.home.attitude_indicator import AttitudeIndicator, attitude_of
from workbench.gui.home.heading_tape import HeadingTape
from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.heading import heading_of
from workbench.gui.instruments.readout import ReadoutLine
from workbench.gui.layout import CardPair, column, fill
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

ATTITUDE_LABELS = ("Roll", "Pitch", "Yaw", "Heading")


def heading_text(yaw: float) -> str:
    """Return the heading of a yaw [rad] with leading zeros, as 007.5."""
    if not math.isfinite(yaw):
        return "–"
    return f"{round(heading_of(yaw), 1) % 360.0:05.1f}"


class AttitudeCard(HomeCard):
    """The horizon ahead of the drone's nose.

    The angles are those of the workbench's frames: W is east-north-up and B forward-left-up, so a
    positive roll lowers the right side, a positive pitch the nose, and yaw is 0 to the east. The
    heading is that of a compass, clockwise from north.
    """

    name = "attitude"
    title = "Attitude"

    def __init__(self, look: Look, units: ShownUnits, parent: QWidget | None = None) -> None:
        super().__init__(look, units, parent)
        self.indicator = AttitudeIndicator(look)
        self.tape = HeadingTape(look)
        self.table = self.make_table("Angles", widest=("\N{MINUS SIGN}888.8",))
        numbers = column(1, self.table, 1)
        fill(self.body, (CardPair(self.indicator, numbers, (3, 2), 12), 1), self.tape)
        self.set_note("+ right side down, + nose down")

    @property
    def spoken(self) -> str:
        """The attitude as a sentence."""
        return "; ".join((self.indicator.spoken, self.tape.spoken, self.table.spoken))

    def lines(self, units: ShownUnits) -> Sequence[ReadoutLine]:
        """Return a line for each angle; a heading is always in degrees."""
        return *((label, units.angle.symbol) for label in ATTITUDE_LABELS[:3]), (
            ATTITUDE_LABELS[3],
            "°",
        )

    def set_text_size(self, size: float) -> None:
        """Set the text size of the dials, too."""
        super().set_text_size(size)
        self.indicator.set_text_size(size)
        self.tape.set_text_size(size)

    def show_dials(self, view: LiveView, now: Snapshot) -> None:
        """Update the horizon and the tape."""
        self.indicator.show_attitude(attitude_of(now.q_WB))
        self.tape.show_yaw(now.roll_pitch_yaw[2])

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the angles."""
        for index, angle in enumerate(now.roll_pitch_yaw):
            self.table.show_row(index, self.units.angle.number(angle))
        self.table.show_row(3, heading_text(now.roll_pitch_yaw[2]))
