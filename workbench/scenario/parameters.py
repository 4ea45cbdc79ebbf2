"""The table of all parameters that can change in flight.

One row yields a slider, a `--set NAME=VALUE`, a line of `workbench params` and a test. A change of
a parameter never rebuilds the diagram; settings that would need that are in the scenario.
"""

from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.parameter import Parameter
from workbench.control.controller import Controller, load_controller
from workbench.estimation.settings import (
    COMPLEMENTARY,
    EKF,
    OWN,
    ComplementarySettings,
    EkfSettings,
)

if TYPE_CHECKING:
    from workbench.estimation.estimators import Estimator
    from workbench.plant.vehicle import Vehicle

__all__ = [
    "MOST_ROTORS",
    "SENSOR_KINDS",
    "Parameter",
    "ParameterTable",
    "parameter_table",
    "split_setting",
]


def _fault(kind: str) -> Parameter:
    """Return the row of a requested fault in all sensors of a kind."""
    help = f"fault of the {kind.replace('_', ' ')}: 0 none, 1 frozen, 2 noisy, 3 silent"
    return Parameter(f"{kind}_fault", kind, "1", 0.0, 3.0, 0.0, help, whole=True)


def _disturbance(axis: str, way: str) -> Parameter:
    """Return the row of a magnetic disturbance along an axis of B."""
    help = f"field that the drone adds to the earth's, {way}"
    return Parameter(
        f"magnetometer_disturbance_{axis}", "magnetometer", "T", -1e-3, 1e-3, 0.0, help
    )


def _rotor(number: int) -> Parameter:
    """Return the row of a requested fault in one rotor."""
    help = f"share of its thrust that rotor {number} gives; 0 stops it"
    return Parameter(f"rotor_{number}", "rotors", "1", 0.0, 1.0, 1.0, help)


def _air(name: str, unit: str, limits: tuple[float, float], default: float, help: str) -> Parameter:
    return Parameter(name, "air", unit, *limits, default, help)


def _gyro(name: str, limits: tuple[float, float], default: float, help: str) -> Parameter:
    return Parameter(name, "gyro", "Hz", *limits, default, help)


def _ekf(row: tuple[str, str, float, str]) -> Parameter:
    name, unit, most, help = row
    default = getattr(EkfSettings(), name)
    # an exact measurement would lead to a division by zero
    least = 0.0 if name.endswith(("_noise", "_walk")) else 1e-3 * default
    return Parameter(name, "ekf", unit, least, most, default, help)


def _complementary(row: tuple[str, str, float, str]) -> Parameter:
    name, unit, most, help = row
    least = 0.01 if unit == "s" else 0.0
    default = getattr(ComplementarySettings(), name)
    return Parameter(name, "complementary", unit, least, most, default, help)


def _payload(name: str, unit: str, limits: tuple[float, float], help: str) -> Parameter:
    return Parameter(name, "payload", unit, *limits, 0.0, help)


_SPEED_OF_AIR = (-50.0, 50.0)
_FORCE = (-1000.0, 1000.0)
_TORQUE = (-100.0, 100.0)
_PLACE = (-10.0, 10.0)
_LOAD = (0.0, 100.0)
_SIZE = (0.0, 10.0)
_TIME = (0.0, 1e6)
_DURATION = (0.001, 3600.0)
_FREQUENCY = (0.0, 4000.0)

EKF_ROWS = (
    ("ekf_gyro_noise", "rad/s/Hz^0.5", 1.0, "noise density of the gyro, as the EKF assumes it"),
    ("ekf_accel_noise", "m/s^2/Hz^0.5", 10.0, "the same of the accelerometer"),
    (
        "ekf_gyro_bias_walk",
        "rad/s^2/Hz^0.5",
        1.0,
        "random walk of its bias, as the EKF assumes it",
    ),
    ("ekf_accel_bias_walk", "m/s^3/Hz^0.5", 10.0, "the same of the accelerometer's"),
    ("ekf_gps_position", "m", 100.0, "deviation of GPS east and north, as the EKF assumes it"),
    ("ekf_gps_height", "m", 100.0, "the same upwards"),
    ("ekf_gps_velocity", "m/s", 100.0, "the same of its velocity"),
    ("ekf_barometer", "m", 100.0, "deviation of the barometer's height, as the EKF assumes it"),
    ("ekf_magnetometer", "T", 1e-4, "deviation of the magnetometer, as the EKF assumes it"),
    ("ekf_range_finder", "m", 100.0, "deviation of the range finder, as the EKF assumes it"),
    ("ekf_gate", "1", 1000.0, "deviations beyond which the EKF leaves a measurement out"),
)
COMPLEMENTARY_ROWS = (
    ("complementary_kp", "1/s", 100.0, "pull of accelerometer and magnetometer on the attitude"),
    ("complementary_ki", "1/s^2", 100.0, "their pull on the gyro's bias"),
    ("complementary_position_time", "s", 100.0, "time constant of the position by GPS"),
    ("complementary_velocity_time", "s", 100.0, "time constant of the velocity by GPS"),
    ("complementary_height_time", "s", 100.0, "time constant of the height by barometer"),
)
SIGNAL_PATH = ("gyro", "computer", COMPLEMENTARY, EKF, OWN)
"""Systems of filters and estimators; their parameters are not gains, but affect loops."""
MOST_ROTORS = 12
"""Number of rotors that can be weakened; a vehicle may have fewer, or more."""
SENSOR_KINDS = ("imu", "gps", "lidar", "range_finder", "barometer", "depth_camera", "magnetometer")
"""Systems with parameters for every sensor of a kind; a flight may have none."""

OTHERS: tuple[Parameter, ...] = (
    Parameter("take_off_speed", "modes", "m/s", 0.1, 3.0, 1.0, "climb of a take-off"),
    Parameter("landing_speed", "modes", "m/s", 0.1, 0.5, 0.4, "descent of a landing"),
    Parameter("battery_reserve", "modes", "1", 0.0, 0.9, 0.15, "charge at which the drone lands"),
    Parameter(
        "obstacle_brake",
        "modes",
        "1/s",
        0.0,
        1.5,
        0.0,
        "largest speed towards an obstacle per distance left; 0 sets no limit",
    ),
    Parameter(
        "stop_distance", "modes", "m", 0.0, 20.0, 0.5, "clearance at which a braked drone stops"
    ),
    Parameter(
        "position_deviation_limit",
        "modes",
        "m",
        0.1,
        1000.0,
        5.0,
        "deviation of the level position beyond which a flight on the EKF lands",
    ),
    Parameter(
        "gps_timeout",
        "modes",
        "s",
        0.1,
        3600.0,
        5.0,
        "time without GPS after which a flight on the complementary filter lands",
    ),
    Parameter(
        "imu_timeout",
        "modes",
        "s",
        0.01,
        3600.0,
        0.1,
        "time of equal readings after which the IMU has failed and the rotors stop",
    ),
    Parameter(
        "battery_duration", "battery", "s", 1.0, 36000.0, 1200.0, "time a full battery hovers"
    ),
    Parameter(
        "sag_compensation",
        "battery",
        "1",
        0.0,
        1.0,
        0.0,
        "share of the battery's sag that rotor commands compensate",
    ),
    Parameter(
        "voltage_noise",
        "gauge",
        "V",
        0.0,
        100.0,
        0.0,
        "deviation of the battery's measured voltage, in a flight on an estimate",
    ),
    Parameter(
        "warning_distance",
        "obstacles",
        "m",
        0.1,
        20.0,
        1.0,
        "clearance below which there is a warning",
    ),
    _air("wind_x", "m/s", _SPEED_OF_AIR, 0.0, "velocity of the mean wind to the east"),
    _air("wind_y", "m/s", _SPEED_OF_AIR, 0.0, "velocity of the mean wind to the north"),
    _air("wind_z", "m/s", _SPEED_OF_AIR, 0.0, "velocity of the mean wind upwards"),
    _air(
        "turbulence",
        "m/s",
        (0.0, 50.0),
        0.0,
        "wind speed at 20 ft that causes it: light 7.7, moderate 15.4, severe 23.2",
    ),
    _air("gust_x", "m/s", _SPEED_OF_AIR, 0.0, "peak of the gust to the east"),
    _air("gust_y", "m/s", _SPEED_OF_AIR, 0.0, "peak of the gust to the north"),
    _air("gust_z", "m/s", _SPEED_OF_AIR, 0.0, "peak of the gust upwards"),
    _air("gust_start", "s", _TIME, 0.0, "when the gust begins"),
    _air("gust_duration", "s", _DURATION, 1.0, "how long the gust rises and falls"),
    _air("push_x", "N", _FORCE, 0.0, "force of the push to the east"),
    _air("push_y", "N", _FORCE, 0.0, "force of the push to the north"),
    _air("push_z", "N", _FORCE, 0.0, "force of the push upwards"),
    _air("push_at_x", "m", _PLACE, 0.0, "where the push acts, ahead of the base link's origin"),
    _air("push_at_y", "m", _PLACE, 0.0, "where the push acts, left of the base link's origin"),
    _air("push_at_z", "m", _PLACE, 0.0, "where the push acts, above the base link's origin"),
    _air("push_torque_x", "N*m", _TORQUE, 0.0, "torque of the push, right side down"),
    _air("push_torque_y", "N*m", _TORQUE, 0.0, "torque of the push, nose down"),
    _air("push_torque_z", "N*m", _TORQUE, 0.0, "torque of the push to the left"),
    _air("push_start", "s", _TIME, 0.0, "when the push begins"),
    _air("push_duration", "s", _DURATION, 0.1, "how long the push lasts"),
    _air("drag_area", "m^2", (0.0, 10.0), 0.015, "drag coefficient times area of the body"),
    _air("air_density", "kg/m^3", (0.0, 2.0), 1.225, "density of the air, for the body's drag"),
    _payload("payload_mass", "kg", _LOAD, "mass of the payload; 0 drops it"),
    _payload("payload_x", "m", _PLACE, "the payload's centre, ahead of the base link's origin"),
    _payload("payload_y", "m", _PLACE, "the payload's centre, left of the base link's origin"),
    _payload("payload_z", "m", _PLACE, "the payload's centre, above the base link's origin"),
    _payload("payload_size_x", "m", _SIZE, "length of the payload, a box of even density"),
    _payload("payload_size_y", "m", _SIZE, "width of the payload"),
    _payload("payload_size_z", "m", _SIZE, "height of the payload"),
    _payload("known_payload_mass", "kg", _LOAD, "mass of the payload that the law assumes"),
    _gyro(
        "gyro_rate",
        _FREQUENCY,
        0.0,
        "sample rate of the gyro, at least; 0 for one sample a physics step",
    ),
    _gyro("gyro_lowpass", _FREQUENCY, 0.0, "cut-off of the gyro's low-pass; 0 for none"),
    Parameter(
        "gyro_lowpass_order",
        "gyro",
        "1",
        1.0,
        2.0,
        2.0,
        "order of the gyro's low-pass, 1 or 2",
        whole=True,
    ),
    _gyro("gyro_notch", _FREQUENCY, 0.0, "centre of the gyro's notch; 0 for none"),
    _gyro("gyro_notch_width", (0.1, 1000.0), 20.0, "width of the gyro's notch, at 3 dB"),
    _gyro(
        "accel_lowpass",
        _FREQUENCY,
        0.0,
        "cut-off of the accelerometer's low-pass, which estimators use; 0 for none",
    ),
    Parameter(
        "accel_lowpass_order",
        "gyro",
        "1",
        1.0,
        2.0,
        2.0,
        "order of the accelerometer's low-pass, 1 or 2",
        whole=True,
    ),
    Parameter(
        "setpoint_lowpass",
        "computer",
        "Hz",
        *_FREQUENCY,
        0.0,
        "cut-off of the low-pass on the commanded velocity and yaw rate; 0 for none",
    ),
    Parameter(
        "derivative_lowpass",
        "computer",
        "Hz",
        *_FREQUENCY,
        0.0,
        "cut-off of the low-pass on the input of derivative gains; 0 for none",
    ),
    Parameter(
        "command_steps",
        "computer",
        "1",
        0.0,
        65536.0,
        0.0,
        "steps of a rotor's command from 0 to full, as 2000 of DShot; 0 for none",
        whole=True,
    ),
    *map(_ekf, EKF_ROWS),
    *map(_complementary, COMPLEMENTARY_ROWS),
    *map(_fault, SENSOR_KINDS),
    Parameter(
        "barometer_ground_effect",
        "barometer",
        "Pa",
        -500.0,
        500.0,
        0.0,
        "pressure that the downwash adds at the ground; 12 Pa for a metre",
    ),
    _disturbance("x", "ahead"),
    _disturbance("y", "to the left"),
    _disturbance("z", "upwards"),
    *map(_rotor, range(1, MOST_ROTORS + 1)),
)
"""Parameters of every flight; those of its controller come before them."""


class ParameterTable:
    """The parameters of a flight with a controller, in order.

    Args:
        controller: its parameters come first; those of the user's own estimator come last.

    Raises:
        WorkbenchError: if one of the two has a parameter with a name that is taken.
    """

    def __init__(self, controller: Controller) -> None:
        estimator = controller.estimator
        taken = {row.name: "one of every flight" for row in OTHERS}
        stating: list[Controller | Estimator] = [controller, *([estimator] if estimator else [])]
        for of in stating:
            for row in of.parameters:
                if row.name in taken:
                    raise WorkbenchError(
                        f"{of.file}: the parameter {row.name} is {taken[row.name]}: give it "
                        "another name"
                    )
            taken |= {row.name: f"one of {of.name}" for row in of.parameters}
        self.controller = controller
        self.rows = (*controller.parameters, *OTHERS, *(estimator.parameters if estimator else ()))
        self._by_name = {row.name: row for row in self.rows}

    def __iter__(self) -> Iterator[Parameter]:
        return iter(self.rows)

    def __contains__(self, name: str) -> bool:
        """Return whether there is a parameter with a name, or sets of it."""
        try:
            return bool(self.sets(name))
        except WorkbenchError:
            return False

    def find(self, name: str, where: str = "") -> Parameter:
        """Return the row of a name.

        Args:
            name: of the parameter.
            where: file and line for the message, if any.

        Raises:
            WorkbenchError: if there is none.
        """
        if name in self._by_name:
            return self._by_name[name]
        error = unknown_name("parameter", name, list(self._by_name))
        raise WorkbenchError(f"{where}{error}")

    def sets(self, name: str, where: str = "") -> tuple[Parameter, ...]:
        """Return the row of a name, or those of all sets of a scheduled gain; see `find`."""
        schedule = self.controller.schedule
        every = schedule.names(name) if schedule else ()
        if name not in self._by_name and every and every[0] in self._by_name:
            return tuple(self._by_name[each] for each in every)
        return (self.find(name, where),)

    def defaults(self) -> dict[str, float]:
        """Return the default of every parameter by name."""
        return {row.name: row.default for row in self.rows}

    def checked(self, values: Mapping[str, float], where: str = "") -> dict[str, float]:
        """Return `values` if every name is in the table and every value within its limits.

        The name of a scheduled gain refers to all of its sets.

        Raises:
            WorkbenchError: for the first error, prefixed with `where`.
        """
        return {
            row.name: row.check(value, where)
            for name, value in values.items()
            for row in self.sets(name, where)
        }

    def of(self, system: str) -> tuple[Parameter, ...]:
        """Return the parameters of one system, in the order of its numeric parameter."""
        return tuple(row for row in self.rows if row.system == system)


@lru_cache(maxsize=64)
def parameter_table(controller: Controller | None = None) -> ParameterTable:
    """Return the parameter table of a flight with a controller, None for the default one."""
    return ParameterTable(controller or load_controller())


def split_setting(text: str) -> tuple[str, float]:
    """Return name and number of a `NAME=VALUE` text; the name is not checked.

    Raises:
        WorkbenchError: if it is not of that form.
    """
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise WorkbenchError(f"'{text}' is not a setting: write NAME=VALUE, as kp_velocity_x=5")
    try:
        return name.strip(), float(value)
    except ValueError:
        raise WorkbenchError(f"{name.strip()} is '{value}': give it a number") from None


def vehicle_parameters(
    vehicle: "Vehicle", table: ParameterTable | None = None
) -> tuple[Parameter, ...]:
    """Return the parameters that apply to a vehicle, in the order of the table."""
    table = table or parameter_table()
    rotors = table.of("rotors")[: len(vehicle.rotors)]
    kinds = {sensor.kind for sensor in vehicle.sensors}
    return tuple(
        row
        for row in table
        if (row.system != "rotors" or row in rotors)
        and (row.system not in SENSOR_KINDS or row.system in kinds)
    )


def check_settings(
    vehicle: "Vehicle", settings: Mapping[str, float], table: ParameterTable | None = None
) -> None:
    """Check that parameters that do not apply to a vehicle have their defaults.

    So a file with every parameter of the table is valid for any drone.

    Raises:
        WorkbenchError: for the first error.
    """
    table = table or parameter_table()
    changed = [
        row.name
        for name, value in settings.items()
        for row in table.sets(name)
        if value != row.default
    ]
    check_parameters(vehicle, changed, table)


def check_parameters(
    vehicle: "Vehicle", names: Iterable[str], table: ParameterTable | None = None
) -> None:
    """Check that all parameters apply to a vehicle.

    Raises:
        WorkbenchError: for the first error.
    """
    table = table or parameter_table()
    rows = vehicle_parameters(vehicle, table)
    for name in names:
        row = table.find(name)
        if row in rows:
            continue
        if row.system == "rotors":
            has = f"{len(vehicle.rotors)} rotors"
        else:
            has = f"no {row.system.replace('_', ' ')}"
        raise WorkbenchError(f"{name} cannot be set: {vehicle.name} has {has}")
