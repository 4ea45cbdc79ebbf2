"""Labels and groups of the rows of the parameter table on the tuning screen."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from workbench.common.parameter import Parameter, is_servo_parameter
from workbench.control.controller import COMMON_PARAMETERS
from workbench.gains.formats import GainFormat
from workbench.parameters.flight_parameters import SIGNAL_PATH, flight_parameters
from workbench.parameters.parameter_table import ParameterTable
from workbench.plant.servo import SERVO_SYSTEM

LINKED_GAIN_PAIRS = (
    ("kp_velocity_x", "kp_velocity_y"),
    ("kd_velocity_x", "kd_velocity_y"),
    ("kp_roll", "kp_pitch"),
    ("kd_roll", "kd_pitch"),
)
"""Gains of x and of y that can be linked."""

VEHICLE_GAIN_ROWS = ("drag_area",)
"""Rows beside the controller's that belong to the vehicle: a gain file also has them."""

_VELOCITY_GROUP = "Velocity loop"
_ATTITUDE_GROUP = "Attitude loop"
_YAW_GROUP = "Yaw"
_POSITION_GROUP = "Position hold"
_LIMITS_GROUP = "Limits"
_PAYLOAD_GROUP = "Payload"
_MODES_GROUP = "Flight modes"
FILTERS_GROUP = "Filters of sensors and setpoint"
_GAIN_SYMBOLS = ("kp", "ki", "kd", "k", "q")
GAIN_GROUPS = (_VELOCITY_GROUP, _ATTITUDE_GROUP, _YAW_GROUP, _POSITION_GROUP, _LIMITS_GROUP)
"""Headings of the controller's rows, in order."""

_SYSTEM_GROUPS = {
    "modes": _MODES_GROUP,
    "battery": "Battery",
    "gauge": "Battery gauge",
    "gyro": FILTERS_GROUP,
    "computer": FILTERS_GROUP,
    "ekf": "EKF",
    "complementary": "Complementary filter",
    "estimator": "Estimator of your own",
    "obstacles": "Obstacles",
    "air": "Air, gusts and pushes",
    "payload": _PAYLOAD_GROUP,
    "cables": "Cables",
    "rotors": "Rotor faults",
    SERVO_SYSTEM: "Servos",
}
_FAULTS_GROUP = "Sensor faults"


@dataclass(frozen=True)
class GainLabel:
    """Label of a row.

    Attributes:
        group: its heading.
        words: its name in words.
        symbol: symbol used in control engineering, "" without one.
        where: its set of scheduled gains, "" for none.
    """

    group: str
    words: str
    symbol: str = ""
    where: str = ""

    @property
    def text(self) -> str:
        """Words, symbol and set."""
        return " ".join(filter(None, (self.words, self.symbol, self.where)))


_GAIN_LABELS = {
    "accel_lowpass_order": GainLabel(FILTERS_GROUP, "Accel order"),
    "kp_velocity_x": GainLabel(_VELOCITY_GROUP, "Velocity x", "Kp"),
    "kp_velocity_y": GainLabel(_VELOCITY_GROUP, "Velocity y", "Kp"),
    "kp_velocity_z": GainLabel(_VELOCITY_GROUP, "Velocity z", "Kp"),
    "kd_velocity_x": GainLabel(_VELOCITY_GROUP, "Velocity x", "Kd"),
    "kd_velocity_y": GainLabel(_VELOCITY_GROUP, "Velocity y", "Kd"),
    "kd_velocity_z": GainLabel(_VELOCITY_GROUP, "Velocity z", "Kd"),
    "kp_roll": GainLabel(_ATTITUDE_GROUP, "Roll", "Kp"),
    "kp_pitch": GainLabel(_ATTITUDE_GROUP, "Pitch", "Kp"),
    "kd_roll": GainLabel(_ATTITUDE_GROUP, "Roll", "Kd"),
    "kd_pitch": GainLabel(_ATTITUDE_GROUP, "Pitch", "Kd"),
    "kp_yaw_rate": GainLabel(_YAW_GROUP, "Yaw rate", "Kp"),
    "spin_up_feedforward": GainLabel(_YAW_GROUP, "Spin-up", "Kff"),
    "kp_position_xy": GainLabel(_POSITION_GROUP, "Position x, y", "Kp"),
    "kp_position_z": GainLabel(_POSITION_GROUP, "Position z", "Kp"),
    "max_speed": GainLabel(_LIMITS_GROUP, "Max speed"),
    "max_climb_rate": GainLabel(_LIMITS_GROUP, "Max climb rate"),
    "max_height": GainLabel(_LIMITS_GROUP, "Max height"),
    "max_tilt": GainLabel(_LIMITS_GROUP, "Max tilt"),
    "max_yaw_rate": GainLabel(_LIMITS_GROUP, "Max yaw rate"),
    "position_deviation_limit": GainLabel(_MODES_GROUP, "Position deviation"),
    "known_payload_mass": GainLabel(_PAYLOAD_GROUP, "Known mass"),
}


_SCHEDULE_SUFFIX = re.compile(r"_at_\d+(_\d+)?$")
"""Suffix of a scheduled gain's name: a screen names the shown set once."""
_OTHER_ROW_NAMES = frozenset(row.name for row in flight_parameters())
_SIGNAL_PATH_ROWS = frozenset(row.name for row in flight_parameters() if row.system in SIGNAL_PATH)
"""Parameters of filters and estimators: no gains, and not in a gain file, but they affect loops in
the same way."""
_ROWS_OUTSIDE_LOOPS = (_OTHER_ROW_NAMES - _SIGNAL_PATH_ROWS) | {
    row.name for row in COMMON_PARAMETERS if row.group == _LIMITS_GROUP
}


def gain_label(row: Parameter, firmware: GainFormat | None = None) -> GainLabel:
    """Return a row's label; a row without one is labelled with the parameter's name.

    Args:
        row: row of the parameter table.
        firmware: firmware of the controller's law, whose own parameter names are shown.
    """
    name = _SCHEDULE_SUFFIX.sub("", row.name)
    if name != row.name:
        where = row.name.removeprefix(f"{name}_at_").replace("_", ".")
        return replace(gain_label(replace(row, name=name), firmware), where=f"at {where}")
    if firmware and is_gain(row) and firmware.has(name):
        return GainLabel(row.group or GAIN_GROUPS[0], firmware.file_name(name))
    if name in _GAIN_LABELS and row.group in ("", _GAIN_LABELS[name].group):
        return _GAIN_LABELS[name]
    if is_gain(row) and name != name.lower():  # the firmware's own name
        return GainLabel(row.group or GAIN_GROUPS[0], name)
    symbol, _, words = name.partition("_")
    if is_gain(row) and words and symbol in _GAIN_SYMBOLS:
        words = words.replace("_", " ").capitalize()
        return GainLabel(row.group or GAIN_GROUPS[0], words, symbol.capitalize())
    words = name.removesuffix("_fault").removeprefix(f"{row.system}_")
    if row.system == SERVO_SYSTEM:
        words = name.removeprefix("servo_")
    words = words.replace("_", " ").capitalize()
    group = (
        row.group or GAIN_GROUPS[0]
        if is_gain(row)
        else _SYSTEM_GROUPS.get(row.system, _FAULTS_GROUP)
    )
    return GainLabel(group, words)


def gain_groups(rows: Iterable[Parameter]) -> tuple[str, ...]:
    """Return the headings of a controller's rows, in order; limits are last."""
    found = dict.fromkeys(gain_label(row).group for row in rows)
    if set(found) <= set(GAIN_GROUPS):
        return GAIN_GROUPS
    return (*(group for group in found if group != _LIMITS_GROUP), _LIMITS_GROUP)


def is_gain(row: Parameter) -> bool:
    """Return whether a row can be tuned: kept, reverted, stored and saved."""
    return row.system == "controller"


def in_gain_file(row: Parameter) -> bool:
    """Return whether a vehicle's gain file has the row."""
    return is_gain(row) or row.name in VEHICLE_GAIN_ROWS


def controller_gains(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values of the controller and its filters; the others belong to the flight."""
    conditions = _OTHER_ROW_NAMES - _SIGNAL_PATH_ROWS
    return {
        name: value
        for name, value in values.items()
        if name not in conditions and not is_servo_parameter(name)
    }


def loop_gains(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values that affect a loop near hover: gains and filters, no limits."""
    return {
        name: value
        for name, value in values.items()
        if name not in _ROWS_OUTSIDE_LOOPS and not is_servo_parameter(name)
    }


def linked_gain(name: str) -> str:
    """Return the gain linked with another one, "" for none."""
    gain = _SCHEDULE_SUFFIX.sub("", name)
    for pair in LINKED_GAIN_PAIRS:
        if gain in pair:
            return pair[1 - pair.index(gain)] + name.removeprefix(gain)
    return ""


def flight_rows(names: Iterable[str], table: ParameterTable) -> tuple[Parameter, ...]:
    """Return the rows of these names in the table's order."""
    known = set(names)
    return tuple(row for row in table if row.name in known)


def gain_count_text(number: int) -> str:
    """Return a number of gains in words."""
    return "1 gain" if number == 1 else f"{number} gains"
