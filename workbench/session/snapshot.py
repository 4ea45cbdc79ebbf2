"""The present of a flight as a frozen copy, for a screen or a client."""

from dataclasses import dataclass

from workbench.common.vectors import Vector3
from workbench.control.mode import FlightMode, Reason
from workbench.plant.faults import Fault
from workbench.systems.sensors.readings import (
    BarometerReading,
    GpsReading,
    ImuReading,
    MagnetometerReading,
    Reading,
)


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
    direction: Vector3 | None


@dataclass(frozen=True)
class NearestClearance:
    """The nearest obstacle, other than the ground.

    Attributes:
        distance: free distance from the sphere around the drone [m]; infinite if nothing is near.
        direction: unit vector in W to the obstacle, zero if nothing is near.
        warning: whether the distance is less than the warning distance.
    """

    distance: float
    direction: Vector3
    warning: bool


@dataclass(frozen=True)
class SensorStatus:
    """State of a sensor.

    Attributes:
        name: its declared name.
        kind: one of `sensor_kinds`.
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
class CableStatus:
    """A cable that carries a load.

    Attributes:
        name: of the cable.
        upper: place of its upper end in W [m].
        lower: place of its lower end in W [m].
        length: of the cable without tension [m].
        tension: [N], 0 of a slack one.
    """

    name: str
    upper: Vector3
    lower: Vector3
    length: float
    tension: float

    @property
    def slack(self) -> bool:
        """Whether its ends are closer than its length."""
        return self.tension == 0.0


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
        voltage: voltage of the battery, see `guidance.MeasuredMotion`.
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
        others: last reading of each sensor of another package.
        joints: positions, then velocities of joints, see `Vehicle.joint_signals`.
        cables: while the hooks are open those without one.
    """

    time: float
    p_WB: Vector3
    q_WB: tuple[float, float, float, float]
    v_WB: Vector3
    w_WB: Vector3
    vdot_WB: Vector3
    displacement: Vector3
    roll_pitch_yaw: Vector3
    thrusts: tuple[float, ...]
    reference: tuple[float, ...]
    mode: FlightMode
    charge: float
    wind: Vector3
    imu: ImuReading | None = None
    gps: GpsReading | None = None
    barometer: BarometerReading | None = None
    lidar: LidarSummary | None = None
    height: float | None = None
    clearance: NearestClearance | None = None
    sensors: tuple[SensorStatus, ...] = ()
    voltage: float = 1.0
    magnetometer: MagnetometerReading | None = None
    reason: Reason = Reason.NONE
    others: tuple[Reading, ...] = ()
    joints: tuple[float, ...] = ()
    cables: tuple[CableStatus, ...] = ()
