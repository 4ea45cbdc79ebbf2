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
        stamp: when it was taken [s].
        returns: rays that met something.
        rays: all of them.
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
    """What is nearest to the drone, besides the ground.

    Attributes:
        distance: free way from the sphere around the drone [m]; infinite where nothing is near.
        direction: unit vector in W to it, zero where nothing is near.
        warning: whether that is less than the warning distance.
    """

    distance: float
    direction: Triple
    warning: bool


@dataclass(frozen=True)
class SensorStatus:
    """How a sensor does.

    Attributes:
        name: as declared.
        kind: imu, gps, lidar, range_finder, barometer, depth_camera or magnetometer.
        asked_rate: samples a second that were asked for [1/s].
        rate: samples a second that it took, over the periods begun since the start [1/s].
        age: of what it delivered last [s]; infinite if that is nothing.
        fault: that was ordered.
    """

    name: str
    kind: str
    asked_rate: float
    rate: float
    age: float
    fault: Fault


@dataclass(frozen=True)
class Snapshot:
    """What a flight is at one time: all that a home screen shows; vectors in W, SI units.

    Attributes:
        time: simulated [s].
        p_WB: position of the base link.
        q_WB: orientation, unit quaternion w, x, y, z.
        v_WB: velocity.
        w_WB: angular velocity.
        vdot_WB: acceleration.
        displacement: from where the flight began.
        roll_pitch_yaw: orientation as angles [rad].
        thrusts: of the rotors [N].
        reference: what the pilot asks for, see `control.guidance.Reference`.
        mode: flight mode.
        charge: of the battery, 0 .. 1.
        voltage: of it, see `guidance.Measured`.
        wind: velocity of the air at the drone.
        imu: last reading, None where no IMU measures; so the next three.
        gps: location and altitude.
        barometer: pressure and altitude.
        lidar: last scan in a few numbers.
        height: what the range finder read last [m], inf beyond its range, -inf too near for it.
        clearance: from obstacles, None in a world without.
        sensors: how each of them does.
        magnetometer: last reading, None where none measures.
        reason: why the mode is not the requested one, or what has failed.
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
