"""Displacement, velocity and acceleration."""

import math

from PyQt6.QtCore import QRectF

from workbench.gui.home.card import Card, put
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.readout import Line, Readout
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot


class MotionCard(Card):
    """A table: along x, y, z of the world, and how much in all."""

    name = "motion"
    title = "Motion"

    def __init__(self, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        lines = [Line("Displacement"), Line("Velocity"), Line("Acceleration")]
        headings = ("x east", "y north", "z up", "total")
        self.table = Readout(self.look, "Motion in W", lines, headings, parent=self)
        self.parts = [self.table]
        self.use_units(self.units)

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return f"in the world frame: {self.table.spoken}"

    def use_units(self, units: ShownUnits) -> None:
        """Show units and numbers."""
        super().use_units(units)
        self._rows = (units.length, units.speed, units.acceleration)
        labels = ("Displacement", "Velocity", "Acceleration")
        for index, (label, shown) in enumerate(zip(labels, self._rows, strict=True)):
            self.table.set_line(index, Line(label, shown.unit.symbol))

    def place_parts(self, body: QRectF) -> None:
        """Let the table fill it."""
        put(self.table, body)

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show all three."""
        vectors = (now.displacement, now.v_WB, now.vdot_WB)
        for index, (vector, shown) in enumerate(zip(vectors, self._rows, strict=True)):
            self.table.show_row(index, *shown.texts(*vector, math.hypot(*vector)))
        self.set_note("world frame W")
