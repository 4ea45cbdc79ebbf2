"""Units of the Home screen, by the user's preferences."""

from dataclasses import dataclass

from workbench.gui.charts.ticks import number_text
from workbench.gui.preferences import Preferences
from workbench.gui.units import Unit, unit_for


@dataclass(frozen=True)
class Shown:
    """A unit and its number of decimals.

    Attributes:
        unit: the unit.
        decimals: number of decimals.
    """

    unit: Unit
    decimals: int

    @property
    def symbol(self) -> str:
        """Symbol of the unit."""
        return self.unit.symbol

    def text(self, value: float) -> str:
        """Return a value in SI as text."""
        return number_text(self.unit.shown(value), self.decimals)

    def texts(self, *values: float) -> tuple[str, ...]:
        """Return several values as text."""
        return tuple(map(self.text, values))


@dataclass(frozen=True)
class ShownUnits:
    """Units by quantity.

    Attributes:
        length: length [m], to the centimetre.
        speed: velocity of the drone.
        acceleration: acceleration of the drone.
        angle: angle of attitude.
        rate: angular velocity.
        place: latitude and longitude, to 1 cm.
    """

    length: Shown
    speed: Shown
    acceleration: Shown
    angle: Shown
    rate: Shown
    place: Shown


def shown_units(preferences: Preferences) -> ShownUnits:
    """Return the preferred units."""
    degree = preferences.text("angle_unit") == "degree"
    angle = unit_for("rad", preferences)
    return ShownUnits(
        length=Shown(unit_for("m", preferences), 2),
        speed=Shown(unit_for("m/s", preferences), 2),
        acceleration=Shown(unit_for("m/s^2", preferences), 2),
        angle=Shown(angle, 1 if degree else 3),
        rate=Shown(unit_for("rad/s", preferences), 1 if degree else 3),
        place=Shown(angle, 7 if degree else 9),
    )
