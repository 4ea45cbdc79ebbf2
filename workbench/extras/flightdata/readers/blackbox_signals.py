"""The signals of a blackbox log, scaled as its header says."""

import re
import struct
from collections.abc import Callable, Mapping

import numpy as np

from workbench.common.flight import LogRemark
from workbench.common.quantity import RPM_IN_RAD_S
from workbench.extras.flightdata.readers.topic_log import (
    ONLY_TOPIC,
    SignalRow,
    motor_share,
    parameter_number,
    scaled,
)
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS, component_names
from workbench.plant.gravity import GRAVITY

MAX_BLACKBOX_MOTORS = 8
FEATURE_3D = 1 << 12
MIN_GYRO_SCALE_DEG = 1e-5
"""A smaller `gyro_scale` is in radians per microsecond; the finest gyros have 4e-3 degrees."""
MIN_FLOAT_BITS = 1 << 23
"""A smaller whole number has the bits of no float, and is itself the scale."""
DEFAULT_MOTOR_POLES = 14.0
_REVISION_PATTERN = re.compile(r"(\w+)\s+v?(\d{1,4})\.(\d{1,4})(?:\.(\d{1,4}))?")
_BLACKBOX_DEG_IN_RAD = np.pi / 180.0
_ADC_STEP_V = 3.3 / 4095.0
"""Voltage of a step of the converter that older firmware logs [V]."""
BLACKBOX_TOPIC = ONLY_TOPIC


def _header_pair(headers: Mapping[str, object], *names: str) -> tuple[float, float] | None:
    """Return two numbers of the headers, from the first of some names that has them."""
    for name in names:
        value = headers.get(name)
        if isinstance(value, list) and len(value) == 2:
            first, second = value
            if isinstance(first, int | float) and isinstance(second, int | float):
                return float(first), float(second)
    return None


def _revision(headers: Mapping[str, object]) -> tuple[str, tuple[int, int, int]]:
    """Return the name of the firmware in lower case, and its version; "" and zeros if unknown."""
    found = _REVISION_PATTERN.match(str(headers.get("Firmware revision", "")))
    if found is None:
        return "", (0, 0, 0)
    return found[1].lower(), (int(found[2]), int(found[3]), int(found[4] or 0))


def _gyro_scale(headers: Mapping[str, object]) -> float:
    """Return the angular velocity of a count of the gyro [rad/s], 0 if it is not stated."""
    value = next((headers[each] for each in ("gyro_scale", "gyro.scale") if each in headers), None)
    if isinstance(value, int) and MIN_FLOAT_BITS <= value < 2**32:
        (value,) = struct.unpack("<f", struct.pack("<I", value))
    firmware, version = _revision(headers)
    if value is None and firmware == "betaflight" and version >= (3, 1, 0):
        value = 1.0
    if not isinstance(value, int | float) or not 0.0 < value < MIN_FLOAT_BITS:
        return 0.0
    return value * 1e6 if value < MIN_GYRO_SCALE_DEG else value * _BLACKBOX_DEG_IN_RAD


FieldColumn = tuple[str, str, str, Callable[[np.ndarray], np.ndarray]]
"""A field, its signal, the unit, and the conversion."""


def blackbox_signals(
    headers: Mapping[str, object], fields: Mapping[str, np.ndarray]
) -> tuple[list[SignalRow], list[LogRemark]]:
    """Return the signals of Betaflight's fields, and remarks on fields without one."""
    columns: list[FieldColumn] = []
    remarks: list[LogRemark] = []

    def unknown(prefix: str, why: str) -> None:
        names = [name for name in fields if name.startswith(prefix)]
        if names:
            remarks.append(
                LogRemark(f"{names[0]} keeps its name, without a unit: {why}", len(names), names[0])
            )

    gyro, gravity = _gyro_scale(headers), parameter_number(headers, "acc_1G")
    for i, (turn, force) in enumerate(zip(GYRO_SIGNALS, ACCELEROMETER_SIGNALS, strict=True)):
        unfiltered = component_names("imu.unfiltered.")[i]
        if gyro:
            columns += [
                (f"gyroADC[{i}]", turn, "rad/s", scaled(gyro)),
                (f"gyroUnfilt[{i}]", turn, "rad/s", scaled(gyro)),
                (f"gyroUnfilt[{i}]", unfiltered, "rad/s", scaled(gyro)),
            ]
        if gravity > 0.0:
            columns.append((f"accSmooth[{i}]", force, "m/s^2", scaled(GRAVITY / gravity)))
        columns.append(
            (
                f"setpoint[{i}]",
                component_names("rate_setpoint.w_")[i],
                "rad/s",
                scaled(_BLACKBOX_DEG_IN_RAD),
            )
        )
    columns.append(("setpoint[3]", "attitude_setpoint.thrust", "1", scaled(1e-3)))
    if not gyro:
        unknown("gyro", "the header has no gyro_scale")
    if not gravity > 0.0:
        unknown("accSmooth", "the header has no acc_1G")
    motors, why = _motor_columns(headers)
    columns += motors
    if why:
        unknown("motor[", why)
    poles = parameter_number(headers, "motor_poles")
    if poles <= 0.0 and "eRPM[0]" in fields:
        remarks.append(
            LogRemark(
                f"rotors.speed: the header has no motor_poles: {DEFAULT_MOTOR_POLES:g} are assumed"
            )
        )
    # eRPM is in hundreds of electrical revolutions per minute.
    turns = 100.0 * 2.0 / (poles if poles > 0.0 else DEFAULT_MOTOR_POLES)
    columns += [
        (f"eRPM[{i}]", f"rotors.speed.{i}", "rad/s", scaled(turns * RPM_IN_RAD_S))
        for i in range(MAX_BLACKBOX_MOTORS)
    ]
    battery, why = _battery_columns(headers)
    columns += battery
    found = {name for name, *_ in battery}
    for name in ("vbat", "amperage"):
        if not any(each.startswith(name) for each in found):
            unknown(name, why)
    rows = [
        SignalRow(BLACKBOX_TOPIC, (field,), (name,), unit, make)
        for field, name, unit, make in columns
    ]
    return rows, remarks


def _motor_columns(headers: Mapping[str, object]) -> tuple[list[FieldColumn], str]:
    """Return the columns of the motor commands, or the reason why there are none."""
    output = _header_pair(headers, "motorOutput")
    low, full = output or (
        parameter_number(headers, "minthrottle"),
        parameter_number(headers, "maxthrottle"),
    )
    features = headers.get("features")
    if isinstance(features, int) and features & FEATURE_3D:
        return [], "the feature 3D is on, so the motors also turn backwards"
    if not full > low:
        return [], "the header does not state their range (motorOutput)"
    return [
        (f"motor[{i}]", f"motors.command_{i + 1}", "1", motor_share(low, full))
        for i in range(MAX_BLACKBOX_MOTORS)
    ], ""


def _battery_columns(headers: Mapping[str, object]) -> tuple[list[FieldColumn], str]:
    """Return the columns of voltage and current, and the reason why one is missing."""
    firmware, version = _revision(headers)
    first = {"betaflight": (3, 1, 0), "cleanflight": (2, 0, 0)}.get(firmware)
    if first is None:
        named = str(headers.get("Firmware revision", "")) or "the firmware, which is not stated,"
        return [], f"the unit that {named} has is not known"
    if version >= first:
        volts = 0.01 if firmware == "betaflight" and version >= (4, 0, 0) else 0.1
        return [
            ("vbatLatest", "battery.voltage", "V", scaled(volts)),
            ("amperageLatest", "battery.current", "A", scaled(0.01)),
        ], ""
    columns: list[FieldColumn] = []
    scale = parameter_number(headers, "vbatscale") or parameter_number(headers, "vbat_scale")
    if scale > 0.0:
        # The divider's ratio is a tenth of the scale.
        columns.append(("vbatLatest", "battery.voltage", "V", scaled(0.1 * scale * _ADC_STEP_V)))
    meter = _header_pair(headers, "currentMeter", "currentSensor")
    if meter and meter[1] != 0.0:
        offset, sensor = meter  # [mV], [mV / 10 A]
        columns.append(
            (
                "amperageLatest",
                "battery.current",
                "A",
                lambda reading: (1e3 * _ADC_STEP_V * reading - offset) * 10.0 / sensor,
            )
        )
    return columns, "the header has no vbatscale or currentMeter"
