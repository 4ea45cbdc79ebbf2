"""Attitude and heading: dials, and the same as numbers."""

import math

from PyQt6.QtCore import QRectF
from PyQt6.QtWidgets import QWidget

from workbench.gui.home.beside import beside
from workbench.gui.home.card import Card, put
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.attitude import attitude_of
from workbench.gui.instruments.attitude_indicator import AttitudeIndicator
from workbench.gui.instruments.heading import heading_of
from workbench.gui.instruments.heading_tape import HeadingTape
from workbench.gui.instruments.readout import Line, Readout
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

LABELS = ("Roll", "Pitch", "Yaw", "Heading")


def heading_text(yaw: float) -> str:
    """Return the heading of a yaw [rad] with all its digits, as 007.5."""
    if not math.isfinite(yaw):
        return "–"
    return f"{round(heading_of(yaw), 1) % 360.0:05.1f}"


class AttitudeCard(Card):
    """The horizon as it is seen ahead.

    The angles are those of the frames in use: W is east-north-up and B forward-left-up, so a
    positive roll lowers the right side, a positive pitch the nose, and yaw is 0 to the east. The
    heading is the compass's, clockwise from north.
    """

    name = "attitude"
    title = "Attitude"

    def __init__(self, look: Look, units: ShownUnits, parent: QWidget | None = None) -> None:
        super().__init__(look, units, parent)
        self.indicator = AttitudeIndicator(look, self)
        self.tape = HeadingTape(look, self)
        self.table = Readout(
            look,
            "Angles",
            [Line(label) for label in LABELS],
            widest="\N{MINUS SIGN}888.8",
            parent=self,
        )
        self.parts = [self.indicator, self.tape, self.table]
        self.use_units(units)
        self.set_note("+ right side down, + nose down")

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return f"{self.indicator.spoken}; {self.tape.spoken}; {self.table.spoken}"

    def use_units(self, units: ShownUnits) -> None:
        """Show units and numbers."""
        super().use_units(units)
        for index, label in enumerate(LABELS[:3]):
            self.table.set_line(index, Line(label, units.angle.unit.symbol))
        self.table.set_line(3, Line(LABELS[3], "°"))

    def place_parts(self, body: QRectF) -> None:
        """Put the tape below dial and numbers."""
        size = self.text_size
        upper = body.adjusted(0.0, 0.0, 0.0, -2.9 * size)
        places = beside(upper, 1.2 * size, 7.0 * size)
        put(self.indicator, places.picture)
        put(self.table, places.numbers)
        tape = QRectF(body)
        tape.setTop(body.bottom() - 2.6 * size)
        put(self.tape, tape)

    def show_dials(self, view: LiveView, now: Snapshot) -> None:
        """Turn the horizon and the tape."""
        self.indicator.show_attitude(attitude_of(now.q_WB))
        self.tape.show_yaw(now.roll_pitch_yaw[2])

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the angles."""
        for index, angle in enumerate(now.roll_pitch_yaw):
            self.table.show_row(index, self.units.angle.text(angle))
        self.table.show_row(3, heading_text(now.roll_pitch_yaw[2]))
