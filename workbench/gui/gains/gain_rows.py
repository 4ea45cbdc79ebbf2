"""Labels and groups of the rows of the parameter table on the tuning screen."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from workbench.control.controller import COMMON
from workbench.gains.autopilots.firmware import Firmware
from workbench.scenario.parameters import OTHERS, SIGNAL_PATH, Parameter, ParameterTable

PAIRS = (
    ("kp_velocity_x", "kp_velocity_y"),
    ("kd_velocity_x", "kd_velocity_y"),
    ("kp_roll", "kp_pitch"),
    ("kd_roll", "kd_pitch"),
)
"""Gains of x and of y that can be linked."""

IN_A_GAIN_FILE = ("drag_area",)
"""Rows beside the controller's that belong to the vehicle: a gain file also has them."""

_VELOCITY = "Velocity loop"
_ATTITUDE = "Attitude loop"
_YAW = "Yaw"
_POSITION = "Position hold"
_LIMITS = "Limits"
_PAYLOAD = "Payload"
_MODES = "Flight modes"
_SYMBOLS = ("kp", "ki", "kd", "k", "q")
GAIN_GROUPS = (_VELOCITY, _ATTITUDE, _YAW, _POSITION, _LIMITS)
"""Headings of the controller's rows, in order."""

_SYSTEMS = {
    "modes": _MODES,
    "battery": "Battery",
    "gauge": "Battery gauge",
    "gyro": "Gyro and accelerometer filters",
    "computer": "Setpoint, derivative and commands",
    "ekf": "EKF",
    "complementary": "Complementary filter",
    "estimator": "Estimator of your own",
    "obstacles": "Obstacles",
    "air": "Air, gusts and pushes",
    "payload": _PAYLOAD,
    "rotors": "Rotor faults",
}
_FAULTS = "Sensor faults"


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


_LABELS = {
    "accel_lowpass_order": GainLabel("Gyro and accelerometer filters", "Accel order"),
    "kp_velocity_x": GainLabel(_VELOCITY, "Velocity x", "Kp"),
    "kp_velocity_y": GainLabel(_VELOCITY, "Velocity y", "Kp"),
    "kp_velocity_z": GainLabel(_VELOCITY, "Velocity z", "Kp"),
    "kd_velocity_x": GainLabel(_VELOCITY, "Velocity x", "Kd"),
    "kd_velocity_y": GainLabel(_VELOCITY, "Velocity y", "Kd"),
    "kd_velocity_z": GainLabel(_VELOCITY, "Velocity z", "Kd"),
    "kp_roll": GainLabel(_ATTITUDE, "Roll", "Kp"),
    "kp_pitch": GainLabel(_ATTITUDE, "Pitch", "Kp"),
    "kd_roll": GainLabel(_ATTITUDE, "Roll", "Kd"),
    "kd_pitch": GainLabel(_ATTITUDE, "Pitch", "Kd"),
    "kp_yaw_rate": GainLabel(_YAW, "Yaw rate", "Kp"),
    "spin_up_feedforward": GainLabel(_YAW, "Spin-up", "Kff"),
    "kp_position_xy": GainLabel(_POSITION, "Position x, y", "Kp"),
    "kp_position_z": GainLabel(_POSITION, "Position z", "Kp"),
    "max_speed": GainLabel(_LIMITS, "Max speed"),
    "max_climb_rate": GainLabel(_LIMITS, "Max climb rate"),
    "max_height": GainLabel(_LIMITS, "Max height"),
    "max_tilt": GainLabel(_LIMITS, "Max tilt"),
    "max_yaw_rate": GainLabel(_LIMITS, "Max yaw rate"),
    "position_deviation_limit": GainLabel(_MODES, "Position deviation"),
    "known_payload_mass": GainLabel(_PAYLOAD, "Known mass"),
}


_IN_A_SET = re.compile(r"_at_\d+(_\d+)?$")
"""Suffix of a scheduled gain's name: a screen names the shown set once."""
_OTHERS = frozenset(row.name for row in OTHERS)
_FELT = frozenset(row.name for row in OTHERS if row.system in SIGNAL_PATH)
"""Parameters of filters and estimators: no gains, and not in a gain file, but they affect loops in
the same way."""
_NO_LOOP = (_OTHERS - _FELT) | {row.name for row in COMMON if row.group == _LIMITS}


def gain_label(row: Parameter, firmware: Firmware | None = None) -> GainLabel:
    """Return a row's label; a row without one is labelled with the parameter's name.

    Args:
        row: row of the parameter table.
        firmware: firmware of the controller's law, whose own parameter names are shown.
    """
    name = _IN_A_SET.sub("", row.name)
    if name != row.name:
        where = row.name.removeprefix(f"{name}_at_").replace("_", ".")
        return replace(gain_label(replace(row, name=name), firmware), where=f"at {where}")
    if firmware and is_gain(row) and firmware.has(name):
        return GainLabel(row.group or GAIN_GROUPS[0], firmware.file_name(name))
    if name in _LABELS and row.group in ("", _LABELS[name].group):
        return _LABELS[name]
    if is_gain(row) and name != name.lower():  # the firmware's own name
        return GainLabel(row.group or GAIN_GROUPS[0], name)
    symbol, _, words = name.partition("_")
    if is_gain(row) and words and symbol in _SYMBOLS:
        words = words.replace("_", " ").capitalize()
        return GainLabel(row.group or GAIN_GROUPS[0], words, symbol.capitalize())
    words = name.removesuffix("_fault").removeprefix(f"{row.system}_")
    words = words.replace("_", " ").capitalize()
    group = row.group or GAIN_GROUPS[0] if is_gain(row) else _SYSTEMS.get(row.system, _FAULTS)
    return GainLabel(group, words)


def gain_groups(rows: Iterable[Parameter]) -> tuple[str, ...]:
    """Return the headings of a controller's rows, in order; limits are last."""
    found = dict.fromkeys(gain_label(row).group for row in rows)
    if set(found) <= set(GAIN_GROUPS):
        return GAIN_GROUPS
    return (*(group for group in found if group != _LIMITS), _LIMITS)


def is_gain(row: Parameter) -> bool:
    """Return whether a row can be tuned: kept, reverted, stored and saved."""
    return row.system == "controller"


def in_gain_file(row: Parameter) -> bool:
    """Return whether a vehicle's gain file has the row."""
    return is_gain(row) or row.name in IN_A_GAIN_FILE


def controller_gains(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values of the controller and its filters; the others belong to the flight."""
    conditions = _OTHERS - _FELT
    return {name: value for name, value in values.items() if name not in conditions}


def loop_gains(values: Mapping[str, float]) -> dict[str, float]:
    """Return the values that affect a loop near hover: gains and filters, no limits."""
    return {name: value for name, value in values.items() if name not in _NO_LOOP}


def partner(name: str) -> str:
    """Return the gain linked with another one, "" for none."""
    gain = _IN_A_SET.sub("", name)
    for pair in PAIRS:
        if gain in pair:
            return pair[1 - pair.index(gain)] + name.removeprefix(gain)
    return ""


def flight_rows(names: Iterable[str], table: ParameterTable) -> tuple[Parameter, ...]:
    """Return the rows of these names in the table's order."""
    known = set(names)
    return tuple(row for row in table if row.name in known)
