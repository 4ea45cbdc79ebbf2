"""The rows of the parameter table of a flight."""

from functools import cache

from workbench.common.parameter import HOOKS, Parameter
from workbench.dynamics.air.settings import AIR_PARAMETERS
from workbench.estimation.settings import COMPLEMENTARY, EKF, ESTIMATOR_PARAMETERS, USER_ESTIMATOR
from workbench.plant.sensors import CORE_SENSORS, added_sensors
from workbench.plant.servo import SERVO_SYSTEM


def _fault(kind: str) -> Parameter:
    """Return the row of a requested fault in all sensors of a kind."""
    help = f"fault of the {kind.replace('_', ' ')}: 0 none, 1 frozen, 2 noisy, 3 silent"
    return Parameter(f"{kind}_fault", "1", help, 0.0, 3.0, 0.0, kind, whole=True)


def _rotor(number: int) -> Parameter:
    """Return the row of a requested fault in one rotor."""
    help = f"share of its thrust that rotor {number} gives; 0 stops it"
    return Parameter(f"rotor_{number}", "1", help, 0.0, 1.0, 1.0, "rotors")


def _gyro(name: str, limits: tuple[float, float], default: float, help: str) -> Parameter:
    return Parameter(name, "Hz", help, *limits, default, "gyro")


def _payload(name: str, unit: str, limits: tuple[float, float], help: str) -> Parameter:
    return Parameter(name, unit, help, *limits, 0.0, "payload")


_POINT_RANGE_M = (-10.0, 10.0)
_PAYLOAD_RANGE_KG = (0.0, 100.0)
_PAYLOAD_SIZE_RANGE_M = (0.0, 10.0)
_FREQUENCY_RANGE_HZ = (0.0, 4000.0)
SIGNAL_PATH = ("gyro", "computer", COMPLEMENTARY, EKF, USER_ESTIMATOR)
"""Systems of filters and estimators; their parameters are not gains, but affect loops."""
VEHICLE_SYSTEMS = ("payload", "cables", SERVO_SYSTEM)
"""Systems whose parameters change the vehicle that linear models are made of."""
MAX_WEAKENED_ROTORS = 12
"""Number of rotors that can be weakened; a vehicle may have fewer, or more."""
_CORE_PARAMETERS: tuple[Parameter, ...] = (
    Parameter("take_off_speed", "m/s", "climb of a take-off", 0.1, 3.0, 1.0, "modes"),
    Parameter("landing_speed", "m/s", "descent of a landing", 0.1, 0.5, 0.4, "modes"),
    Parameter("battery_reserve", "1", "charge at which the drone lands", 0.0, 0.9, 0.15, "modes"),
    Parameter(
        "obstacle_brake",
        "1/s",
        "largest speed towards an obstacle per distance left; 0 sets no limit",
        0.0,
        1.5,
        0.0,
        "modes",
    ),
    Parameter(
        "stop_distance", "m", "clearance at which a braked drone stops", 0.0, 20.0, 0.5, "modes"
    ),
    Parameter(
        "position_deviation_limit",
        "m",
        "deviation of the level position beyond which a flight on the EKF lands",
        0.1,
        1000.0,
        5.0,
        "modes",
    ),
    Parameter(
        "gps_timeout",
        "s",
        "time without GPS after which a flight on the complementary filter lands",
        0.1,
        3600.0,
        5.0,
        "modes",
    ),
    Parameter(
        "imu_timeout",
        "s",
        "time of equal readings after which the IMU has failed and the rotors stop",
        0.01,
        3600.0,
        0.1,
        "modes",
    ),
    Parameter(
        "battery_duration", "s", "time a full battery hovers", 1.0, 36000.0, 1200.0, "battery"
    ),
    Parameter(
        "sag_compensation",
        "1",
        "share of the battery's sag that rotor commands compensate",
        0.0,
        1.0,
        0.0,
        "battery",
    ),
    Parameter(
        "voltage_noise",
        "V",
        "deviation of the battery's measured voltage, in a flight on an estimate",
        0.0,
        100.0,
        0.0,
        "gauge",
    ),
    Parameter(
        "warning_distance",
        "m",
        "clearance below which there is a warning",
        0.1,
        20.0,
        1.0,
        "obstacles",
    ),
    *AIR_PARAMETERS,
    _payload("payload_mass", "kg", _PAYLOAD_RANGE_KG, "mass of the payload; 0 drops it"),
    _payload(
        "payload_x", "m", _POINT_RANGE_M, "the payload's centre, ahead of the base link's origin"
    ),
    _payload(
        "payload_y", "m", _POINT_RANGE_M, "the payload's centre, left of the base link's origin"
    ),
    _payload(
        "payload_z", "m", _POINT_RANGE_M, "the payload's centre, above the base link's origin"
    ),
    _payload(
        "payload_size_x", "m", _PAYLOAD_SIZE_RANGE_M, "length of the payload, a box of even density"
    ),
    _payload("payload_size_y", "m", _PAYLOAD_SIZE_RANGE_M, "width of the payload"),
    _payload("payload_size_z", "m", _PAYLOAD_SIZE_RANGE_M, "height of the payload"),
    _payload(
        "known_payload_mass", "kg", _PAYLOAD_RANGE_KG, "mass of the payload that the law assumes"
    ),
    Parameter(
        HOOKS,
        "1",
        "1 opens the hooks of cables, which drops loads; 0 closes them on what they reach",
        0.0,
        1.0,
        0.0,
        "cables",
        whole=True,
    ),
    _gyro(
        "gyro_rate",
        _FREQUENCY_RANGE_HZ,
        0.0,
        "sample rate of the gyro, at least; 0 for one sample a physics step",
    ),
    _gyro("gyro_lowpass", _FREQUENCY_RANGE_HZ, 0.0, "cut-off of the gyro's low-pass; 0 for none"),
    Parameter(
        "gyro_lowpass_order",
        "1",
        "order of the gyro's low-pass, 1 or 2",
        1.0,
        2.0,
        2.0,
        "gyro",
        whole=True,
    ),
    _gyro("gyro_notch", _FREQUENCY_RANGE_HZ, 0.0, "centre of the gyro's notch; 0 for none"),
    _gyro("gyro_notch_width", (0.1, 1000.0), 20.0, "width of the gyro's notch, at 3 dB"),
    _gyro(
        "accel_lowpass",
        _FREQUENCY_RANGE_HZ,
        0.0,
        "cut-off of the accelerometer's low-pass, which estimators use; 0 for none",
    ),
    Parameter(
        "accel_lowpass_order",
        "1",
        "order of the accelerometer's low-pass, 1 or 2",
        1.0,
        2.0,
        2.0,
        "gyro",
        whole=True,
    ),
    Parameter(
        "setpoint_lowpass",
        "Hz",
        "cut-off of the low-pass on the commanded velocity and yaw rate; 0 for none",
        *_FREQUENCY_RANGE_HZ,
        0.0,
        "computer",
    ),
    Parameter(
        "derivative_lowpass",
        "Hz",
        "cut-off of the low-pass on the input of derivative gains; 0 for none",
        *_FREQUENCY_RANGE_HZ,
        0.0,
        "computer",
    ),
    Parameter(
        "command_steps",
        "1",
        "steps of a rotor's command from 0 to full, as 2000 of DShot; 0 for none",
        0.0,
        65536.0,
        0.0,
        "computer",
        whole=True,
    ),
    *ESTIMATOR_PARAMETERS,
    *(_fault(each.kind) for each in CORE_SENSORS),
    *(row for each in CORE_SENSORS for row in each.parameters),
    *map(_rotor, range(1, MAX_WEAKENED_ROTORS + 1)),
)


@cache
def flight_parameters() -> tuple[Parameter, ...]:
    """Return the parameters of every flight; those of its controller come before them.

    Those of sensors that installed packages add come last.
    """
    added = [row for each in added_sensors() for row in (_fault(each.kind), *each.parameters)]
    return (*_CORE_PARAMETERS, *added)
