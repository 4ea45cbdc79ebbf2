"""The axes of a command: velocity along x, y, z of the world, and yaw rate."""

from dataclasses import dataclass

from workbench.common.errors import find_named_row


@dataclass(frozen=True)
class CommandAxis:
    """One axis of the command.

    Attributes:
        name: x, y, z or yaw.
        label: in words.
        unit: SI unit of command and response.
        acceleration_unit: unit of the rate of change of the response.
        force_unit: unit of the force or torque along it.
        signal: of the response, in the topics.
        limit: name of the parameter that limits the command.
        amplitude: initial amplitude in the app, in `unit`.
        place: its index in a velocity, None for yaw.
    """

    name: str
    label: str
    unit: str
    acceleration_unit: str
    force_unit: str
    signal: str
    limit: str
    amplitude: float
    place: int | None

    @property
    def response(self) -> str:
        """Name of the response to a command."""
        return "yaw rate" if self.turns else f"velocity {self.name}"

    @property
    def response_unit(self) -> str:
        """SI unit of the response, that of the command."""
        return self.unit

    @property
    def turns(self) -> bool:
        """Whether it changes the heading."""
        return self.place is None


AXIS_ROWS = (
    CommandAxis("x", "x, east", "m/s", "m/s²", "N", "velocity_data.v_x", "max_speed", 1.0, 0),
    CommandAxis("y", "y, north", "m/s", "m/s²", "N", "velocity_data.v_y", "max_speed", 1.0, 1),
    CommandAxis("z", "z, up", "m/s", "m/s²", "N", "velocity_data.v_z", "max_climb_rate", 1.0, 2),
    CommandAxis(
        "yaw", "yaw", "rad/s", "rad/s²", "N·m", "velocity_data.w_z", "max_yaw_rate", 0.2, None
    ),
)
AXIS_NAMES = tuple(row.name for row in AXIS_ROWS)
"""Names of the axes, in the order of a command."""


def find_axis(name: str) -> CommandAxis:
    """Return the axis with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("axis", name, AXIS_ROWS)
