"""Names and units of the signals that all readers of logs share.

`workbench log LOG` lists those of a log. W is east, north, up; B forward, left, up:

    position_data.x y z roll pitch yaw     true motion, as of motion capture: W
    velocity_data.v_x .. w_x ..            likewise, both in W
    attitude.q_w q_x q_y q_z w_x w_y w_z   likewise: B to W, and angular velocity in B
    estimate.x .. v_x .. roll .. q_w ..    what the flight computer took them for
    estimate.w_x .. a_x ..                 its angular velocity in B, its acceleration in W
    imu.linear_acceleration.x ..           specific force in B [m/s^2]
    imu.angular_velocity.x ..              gyro in B [rad/s]
    motors.command_1 ..                    share of the full command, 0 .. 1, in the log's order
    rotors.speed.0 ..                      [rad/s], in the same order
    battery.voltage, battery.current       under load [V], [A]
    setpoint.x y z yaw v_x v_y v_z         of the position and velocity loops: W
    attitude_setpoint.roll pitch yaw thrust   thrust as a share of the full one
    rate_setpoint.w_x w_y w_z              in B [rad/s]
    torque_setpoint.x y z                  share of the full torque, in B

Other signals keep the names of the log. Samples filled in by a logger and not measured are left
out; the gaps of the signal show where.
"""

import re
import unicodedata
import warnings
from collections.abc import Iterable
from typing import Any

from workbench.common.series import make_series

SIGNAL_NAME = re.compile(r"[^\W\d_A-Z][^\WA-Z]*(\.[^\W\d_A-Z][^\WA-Z]*|\.\d+)+")
"""Matches a signal's name, TOPIC.FIELD: letters of any script, dots before parts and indices."""


def signal_name_part(text: str) -> str:
    """Return a text as a part of a signal's name: lower case, and composed as in expressions."""
    composed = unicodedata.normalize("NFKC", text).lower()  # the capital of a sign such as ℃, too
    plain = re.sub(r"\W+", "_", unicodedata.normalize("NFKC", composed)).strip("_")
    return plain if re.match(r"[^\W\d_]", plain) else f"n_{plain}"


def component_names(beginning: str, each: Iterable[str] = "xyz") -> tuple[str, ...]:
    """Return the names of the signals of a vector: prefix, and name of the component."""
    return tuple(f"{beginning}{part}" for part in each)


def topic_signals(topic: str, fields: str) -> tuple[str, ...]:
    """Return the names of the signals of a topic, of its fields with spaces between them."""
    return component_names(f"{topic}.", fields.split())


STANDARD_UNITS = (
    (r"(position_data|estimate|setpoint)\.[xyz]", "m"),
    (r"(position_data|estimate|setpoint|attitude_setpoint)\.(roll|pitch|yaw)", "rad"),
    (r"(velocity_data|estimate|setpoint|command_velocity)\.v_[xyz]", "m/s"),
    (r"(velocity_data|attitude|estimate|rate_setpoint)\.w_[xyz]", "rad/s"),
    (r"(attitude|estimate|attitude_setpoint)\.q_[wxyz]", "1"),
    (r"estimate\.a_[xyz]|imu\.linear_acceleration\.[xyz]", "m/s^2"),
    (r"imu\.(angular_velocity|unfiltered)\.[xyz]|command_velocity\.yaw_rate", "rad/s"),
    (r"motors\.command_\d+|torque_setpoint\.[xyz]|attitude_setpoint\.thrust", "1"),
    (r"rotors\.speed(_command)?\.\d+", "rad/s"),
    (r"battery\.voltage", "V"),
    (r"battery\.current", "A"),
)
"""Patterns of the names of signals that all readers share, and their units."""


def standard_unit(name: str) -> str:
    """Return the unit of a signal that all readers share, "" for any other signal."""
    return next((unit for names, unit in STANDARD_UNITS if re.fullmatch(names, name)), "")


GYRO_SIGNALS = component_names("imu.angular_velocity.")
ACCELEROMETER_SIGNALS = component_names("imu.linear_acceleration.")
SETPOINT_SIGNALS = component_names("setpoint.")
"""Names of gyro, accelerometer, and position setpoint."""
MOTOR_COMMAND_PREFIX, SPEED_COMMAND_PREFIX, ROTOR_SPEED_PREFIX = (
    "motors.command_",
    "rotors.speed_command.",
    "rotors.speed.",
)
"""Prefixes of the names of motor signals: commands as shares of the full one, commands as speeds,
and rotor speeds."""


def __getattr__(name: str) -> Any:
    """Return what readers of logs imported from here in version 1.0."""
    if name != "make_signal":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    said = "workbench.logs.logged_signal.make_signal is now workbench.make_series"
    warnings.warn(said, DeprecationWarning, stacklevel=2)
    return make_series
