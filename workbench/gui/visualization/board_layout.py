"""Which charts there are and what they show, as a record that can be kept as text."""

import json
from dataclasses import dataclass

MOST_CHARTS = 8


@dataclass(frozen=True)
class ChartSpec:
    """A chart.

    Attributes:
        title: over it.
        signals: names of what it shows.
    """

    title: str
    signals: tuple[str, ...] = ()


Board = tuple[ChartSpec, ...]


def _names(topic: str, fields: str) -> tuple[str, ...]:
    return tuple(f"{topic}.{field}" for field in fields.split())


_VELOCITY = ChartSpec(
    "Velocity and command",
    _names("velocity_data", "v_x v_y v_z") + _names("command_velocity", "v_x v_y v_z"),
)
_ATTITUDE = ChartSpec("Attitude", _names("position_data", "roll pitch yaw"))
_THRUSTS = ChartSpec("Rotor thrusts", _names("rotors", "thrust.0 thrust.1 thrust.2 thrust.3"))
_VELOCITY_ERROR = ChartSpec("Velocity error", _names("error", "v_x v_y v_z"))

PRESETS: dict[str, Board] = {
    "Flight": (_VELOCITY, _ATTITUDE, _THRUSTS, _VELOCITY_ERROR),
    "Rotors": (
        _THRUSTS,
        ChartSpec("Rotor speeds", _names("rotors", "speed.0 speed.1 speed.2 speed.3")),
        ChartSpec("Torque", _names("force_torque_data", "torque_x torque_y torque_z")),
        ChartSpec("Turning rates", _names("velocity_data", "w_x w_y w_z")),
    ),
    "Errors": (
        _VELOCITY_ERROR,
        ChartSpec("Yaw rate error", _names("error", "yaw_rate")),
        _VELOCITY,
        ChartSpec(
            "Yaw rate and command",
            ("velocity_data.w_z", "command_velocity.yaw_rate"),
        ),
    ),
    "Sensors": (
        ChartSpec(
            "Specific force",
            _names("imu", "specific_force.0 specific_force.1 specific_force.2"),
        ),
        ChartSpec(
            "Gyroscope",
            _names("imu", "angular_velocity.0 angular_velocity.1 angular_velocity.2"),
        ),
        ChartSpec("GPS velocity", _names("gps", "velocity.0 velocity.1 velocity.2")),
        ChartSpec("Nearest lidar return", _names("lidar", "nearest")),
    ),
}
DEFAULT = "Flight"


def board_text(board: Board) -> str:
    """Return a board as text."""
    return json.dumps([{"title": each.title, "signals": list(each.signals)} for each in board])


def read_board(text: str) -> Board | None:
    """Return the board that a text says; None if it says none."""
    try:
        said = json.loads(text)
        board = tuple(
            ChartSpec(str(each["title"]), tuple(map(str, each["signals"]))) for each in said
        )
    except (ValueError, TypeError, KeyError):  # another version wrote it, or an editor
        return None
    return board[:MOST_CHARTS] if board else None
