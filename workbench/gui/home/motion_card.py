"""The card of the drone's motion: position, velocity and acceleration in the world."""

import math
from collections.abc import Sequence
from typing import Any

from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.readout import ReadoutLine
from workbench.gui.layout import fill
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot


class MotionCard(HomeCard):
    """A table: components along x, y, z of the world, and magnitude."""

    name = "motion"
    title = "Motion"

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        columns = ("x east", "y north", "z up", "total")
        signed, total = "\N{MINUS SIGN}88.88", "88.88"
        self.table = self.make_table("Motion in W", columns, (signed, signed, signed, total))
        self.parts = [self.table]
        fill(self.body, (self.table, 1))

    @property
    def spoken(self) -> str:
        """The table as a sentence."""
        return f"in the world frame: {self.table.spoken}"

    def lines(self, units: ShownUnits) -> Sequence[ReadoutLine]:
        """Return a line for each vector."""
        return (
            ("Displacement", units.length.symbol),
            ("Velocity", units.speed.symbol),
            ("Acceleration", units.acceleration.symbol),
        )

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show all three."""
        units = self.units
        for index, (vector, shown) in enumerate(
            (
                (now.displacement, units.length),
                (now.v_WB, units.speed),
                (now.vdot_WB, units.acceleration),
            )
        ):
            self.table.show_row(index, *map(shown.number, (*vector, math.hypot(*vector))))
        self.set_note("world frame W")
