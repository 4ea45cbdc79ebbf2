"""Units of the Home screen, by the user's preferences."""

from dataclasses import dataclass

from workbench.common.quantity import DisplayUnit
from workbench.gui.preferences import Preferences
from workbench.gui.units import place_unit, unit_for


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

    length: DisplayUnit
    speed: DisplayUnit
    acceleration: DisplayUnit
    angle: DisplayUnit
    rate: DisplayUnit
    place: DisplayUnit


def shown_units(preferences: Preferences) -> ShownUnits:
    """Return the preferred units."""
    return ShownUnits(
        length=unit_for("m", preferences),
        speed=unit_for("m/s", preferences),
        acceleration=unit_for("m/s^2", preferences),
        angle=unit_for("rad", preferences),
        rate=unit_for("rad/s", preferences),
        place=place_unit(preferences),
    )
