"""The axes along which a drone is excited, and where its command and its response are found."""

from dataclasses import dataclass

from workbench.common.errors import find_row


@dataclass(frozen=True)
class Axis:
    """One axis of the command.

    Attributes:
        name: x, y, z or yaw.
        label: in words.
        unit: SI unit of command and response.
        signal: of the response.
        limit: parameter that bounds the command.
        amplitude: that is proposed first, in `unit`.
        place: in a velocity, None for yaw.
    """

    name: str
    label: str
    unit: str
    signal: str
    limit: str
    amplitude: float
    place: int | None


AXES = (
    Axis("x", "x, east", "m/s", "velocity_data.v_x", "max_speed", 1.0, 0),
    Axis("y", "y, north", "m/s", "velocity_data.v_y", "max_speed", 1.0, 1),
    Axis("z", "z, up", "m/s", "velocity_data.v_z", "max_climb_rate", 1.0, 2),
    Axis("yaw", "yaw", "rad/s", "velocity_data.w_z", "max_yaw_rate", 0.2, None),
)


def find_axis(name: str) -> Axis:
    """Return the row of a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("axis", name, AXES)
