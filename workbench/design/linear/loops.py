"""The loops of the law by name, and where each can be opened."""

from dataclasses import dataclass

from workbench.common.errors import find_row, unknown_name


@dataclass(frozen=True)
class Loop:
    """One loop of the cascade.

    Attributes:
        name: of what it controls.
        error: the loop point of its error.
        actuator: the loop point of what it asks of the loop inside it; the error where there is no
            other place.
        hold: whether it is closed only while a place is held.
    """

    name: str
    error: str
    actuator: str
    hold: bool = False

    def point(self, cut: str) -> str:
        """Return the loop point of a cut, `actuator` or `error`.

        Raises:
            WorkbenchError: if it is neither.
        """
        if cut not in CUTS:
            raise unknown_name("place to cut a loop", cut, CUTS)
        return self.error if cut == "error" else self.actuator


CUTS = ("actuator", "error")

LOOPS = (
    Loop("velocity_x", "velocity_x_error", "acceleration_x"),
    Loop("velocity_y", "velocity_y_error", "acceleration_y"),
    Loop("velocity_z", "velocity_z_error", "acceleration_z"),
    Loop("roll", "roll_error", "roll_acceleration"),
    Loop("pitch", "pitch_error", "pitch_acceleration"),
    Loop("yaw_rate", "yaw_rate_error", "yaw_acceleration"),
    Loop("position_x", "position_x_error", "position_x_error", hold=True),
    Loop("position_y", "position_y_error", "position_y_error", hold=True),
    Loop("position_z", "position_z_error", "position_z_error", hold=True),
)


def find_loop(name: str) -> Loop:
    """Return a loop.

    Raises:
        WorkbenchError: if there is none of that name.
    """
    return find_row("loop", name, LOOPS)
