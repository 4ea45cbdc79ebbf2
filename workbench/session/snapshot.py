"""The present of a flight as a frozen copy, for a screen or a client."""

from dataclasses import dataclass

from workbench.control.mode import FlightMode, Reason
from workbench.systems.sensors.faults import Fault
from workbench.systems.sensors.readings import (
    BarometerReading,
    GpsReading,
    ImuReading,
    MagnetometerReading,
)

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class LidarSummary:
    """A lidar's last scan in a few numbers.

    Attributes:
        stamp: time of the scan [s].
        returns: number of rays with a return.
        rays: number of all rays.
        nearest: smallest range [m], infinite without a return.
        direction: unit vector of that ray in the sensor's frame, None without a return.
    """

    stamp: float
    returns: int
    rays: int
    nearest: float
    direction: Triple | None


@dataclass(frozen=True)
class Clearance:
    """The nearest obstacle, other than the ground.

    Attributes:
        distance: free distance from the sphere around the drone [m]; infinite if nothing is near.
        direction: unit vector in W to the obstacle, zero if nothing is near.
        warning: whether the distance is less than the warning distance.
    """

    distance: float
    direction: Triple
    warning: bool


@dataclass(frozen=True)
class SensorStatus:
    """State of a sensor.

    Attributes:
        name: its declared name.
        kind: one of `parameters.SENSOR_KINDS`.
        asked_rate: requested rate of samples [1/s].
        rate: achieved rate of samples, over the periods begun since the start [1/s].
        age: age of the last delivered sample [s]; infinite before the first.
        fault: the commanded fault.
    """

    name: str
    kind: str
    asked_rate: float
    rate: float
    age: float
    fault: Fault


@dataclass(frozen=True)
class Snapshot:
    """A flight at one time, with everything that a home screen shows; vectors in W, SI units.

    Attributes:
        time: simulated time [s].
        p_WB: position of the base link.
        q_WB: orientation, unit quaternion w, x, y, z.
        v_WB: velocity.
        w_WB: angular velocity.
        vdot_WB: acceleration.
        displacement: position relative to the start of the flight.
        roll_pitch_yaw: orientation as Euler angles [rad].
        thrusts: thrusts of the rotors [N].
        reference: the pilot's command, see `control.guidance.Reference`.
        mode: flight mode.
        charge: charge of the battery, 0 .. 1.
        voltage: voltage of the battery, see `guidance.Measured`.
        wind: velocity of the air at the drone.
        imu: last reading, None without an active IMU; the same applies to the next three.
        gps: location and altitude.
        barometer: pressure and altitude.
        lidar: last scan in a few numbers.
        height: last reading of the range finder [m], inf beyond its range, -inf below it.
        clearance: distance from obstacles, None in a world without any.
        sensors: state of each sensor.
        magnetometer: last reading, None without an active one.
        reason: why the mode differs from the requested one, or what has failed.
    """

    time: float
    p_WB: Triple
    q_WB: tuple[float, float, float, float]
    v_WB: Triple
    w_WB: Triple
    vdot_WB: Triple
    displacement: Triple
    roll_pitch_yaw: Triple
    thrusts: tuple[float, ...]
    reference: tuple[float, ...]
    mode: FlightMode
    charge: float
    wind: Triple
    imu: ImuReading | None = None
    gps: GpsReading | None = None
    barometer: BarometerReading | None = None
    lidar: LidarSummary | None = None
    height: float | None = None
    clearance: Clearance | None = None
    sensors: tuple[SensorStatus, ...] = ()
    voltage: float = 1.0
    magnetometer: MagnetometerReading | None = None
    reason: Reason = Reason.NONE
