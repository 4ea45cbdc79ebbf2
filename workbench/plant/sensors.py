"""The sensors of a description. Truth and noise are computed elsewhere."""

import dataclasses
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Noise:
    """Gaussian noise of one sample, in the unit of what it is added to.

    A sample is truth + mean + bias + drift + stddev times a normal number, rounded to precision.
    The bias is drawn once. The drift b starts at 0 and follows db/dt = -b / tau + white noise of
    the density s, with tau = dynamic_bias_correlation_time and s = dynamic_bias_stddev: a random
    walk for times far below tau, with the final standard deviation s sqrt(tau / 2). As in Gazebo,
    there is no drift if tau is 0. gz-sensors differs in two ways: its bias decays with tau, while
    this one stays, in addition to the drift; and its bias has a random sign, while this one has the
    declared sign.

    Attributes:
        mean: constant offset.
        stddev: of each sample.
        bias_mean: mean of a bias drawn once.
        bias_stddev: its standard deviation.
        dynamic_bias_stddev: density of the noise that drives the drift [unit / sqrt(s)].
        dynamic_bias_correlation_time: of the drift [s]; 0 for none.
        precision: step to which samples are rounded; 0 for none.
    """

    mean: float = 0.0
    stddev: float = 0.0
    bias_mean: float = 0.0
    bias_stddev: float = 0.0
    dynamic_bias_stddev: float = 0.0
    dynamic_bias_correlation_time: float = 0.0
    precision: float = 0.0

    def at_rate(self, declared: float, delivered: float) -> "Noise":
        """Return the noise of the same density for a sensor that is sampled at another rate.

        Args:
            declared: rate for which `stddev` is given [1/s]; 0 if not stated, and `stddev` then
                holds for a sample at any rate.
            delivered: actual sampling rate [1/s].
        """
        if declared == 0.0:
            return self
        return dataclasses.replace(self, stddev=self.stddev * math.sqrt(delivered / declared))

    def drift(self, period: float) -> tuple[float, float]:
        """Return the share of the drift that remains after a period, and the deviation added to it.

        The drift is a first-order Gauss-Markov process with time constant T and driving density s:
        after dt it is exp(-dt / T) times itself plus a normal number of variance
        s² T / 2 (1 - exp(-2 dt / T)). Source: Maybeck, Stochastic Models, Estimation, and Control,
        volume 1, section 4.9; gz-sensors and RotorS use the same.
        """
        time, density = self.dynamic_bias_correlation_time, self.dynamic_bias_stddev
        if time == 0.0:
            return 1.0, 0.0
        variance = -0.5 * density**2 * time * math.expm1(-2.0 * period / time)
        return math.exp(-period / time), math.sqrt(variance)

    def in_unit(self, unit: float) -> "Noise":
        """Return this noise converted from a unit to SI."""
        return Noise(
            mean=unit * self.mean,
            stddev=unit * self.stddev,
            bias_mean=unit * self.bias_mean,
            bias_stddev=unit * self.bias_stddev,
            dynamic_bias_stddev=unit * self.dynamic_bias_stddev,
            dynamic_bias_correlation_time=self.dynamic_bias_correlation_time,
            precision=unit * self.precision,
        )


QUIET = Noise()


@dataclass(frozen=True)
class Sensor:
    """The common attributes of all sensors.

    The class constant `kind` is its name in scenarios, the same for all equivalent types.
    `usual_rate` is the rate of a sensor without a declared one [1/s].

    Attributes:
        name: as declared; unique in the vehicle.
        type: as declared: imu, navsat, gpu_lidar, ...
        frame: label of its data: the frame stated in the file; else the link if the sensor's own
            frame S coincides with the link's; else S by its name in the frame tree.
        link: the one it is mounted on.
        rate: samples per second [1/s]; 0 if not stated.
        p_BS: position in the body frame [m].
        R_BS: orientation, rows of the rotation matrix.
    """

    kind: ClassVar[str] = ""
    usual_rate: ClassVar[float] = 0.0

    name: str
    type: str
    frame: str
    link: str
    rate: float
    p_BS: Triple
    R_BS: tuple[Triple, Triple, Triple]

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Noises of each number in a sample; empty if the class does not state them."""
        return ()


@dataclass(frozen=True)
class Imu(Sensor):
    """Gyroscope and accelerometer; noises along x, y, z in rad/s and m/s²."""

    kind: ClassVar[str] = "imu"
    usual_rate: ClassVar[float] = 200.0

    angular_velocity: tuple[Noise, Noise, Noise] = (QUIET, QUIET, QUIET)
    linear_acceleration: tuple[Noise, Noise, Noise] = (QUIET, QUIET, QUIET)


@dataclass(frozen=True)
class Gps(Sensor):
    """Satellite navigation (`gps` or `navsat`); noises in m and m/s."""

    kind: ClassVar[str] = "gps"
    usual_rate: ClassVar[float] = 10.0

    horizontal_position: Noise = QUIET
    vertical_position: Noise = QUIET
    horizontal_velocity: Noise = QUIET
    vertical_velocity: Noise = QUIET

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Noises of position and velocity, east, north and up (6)."""
        place, speed = self.horizontal_position, self.horizontal_velocity
        return (place, place, self.vertical_position, speed, speed, self.vertical_velocity)


@dataclass(frozen=True)
class ScanAxis:
    """Rays of a lidar along one axis: angles [rad] of the first and the last, both measured."""

    samples: int
    min_angle: float
    max_angle: float


@dataclass(frozen=True)
class Lidar(Sensor):
    """Lidar (`lidar`, `ray`, `gpu_lidar`, `gpu_ray`); ranges and noise in m."""

    kind: ClassVar[str] = "lidar"
    usual_rate: ClassVar[float] = 10.0

    horizontal: ScanAxis = ScanAxis(1, 0.0, 0.0)
    vertical: ScanAxis = ScanAxis(1, 0.0, 0.0)
    min_range: float = 0.0
    max_range: float = 0.0
    resolution: float = 0.0
    noise: Noise = QUIET


@dataclass(frozen=True)
class RangeFinder(Sensor):
    """Range finder: one ray along its x (a lidar of a single ray, or a `sonar`), all in m."""

    kind: ClassVar[str] = "range_finder"
    usual_rate: ClassVar[float] = 20.0

    min_range: float = 0.0
    max_range: float = 0.0
    resolution: float = 0.0
    noise: Noise = QUIET

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Noise of the distance, which is a multiple of the resolution (1)."""
        return (dataclasses.replace(self.noise, precision=self.resolution or self.noise.precision),)


@dataclass(frozen=True)
class Barometer(Sensor):
    """Barometer (`air_pressure`).

    Attributes:
        reference_altitude: altitude of the world's origin above sea level [m], None for that of the
            world.
        noise: of the pressure [Pa].
    """

    kind: ClassVar[str] = "barometer"
    usual_rate: ClassVar[float] = 50.0

    reference_altitude: float | None = None
    noise: Noise = QUIET

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Noise of the pressure (1)."""
        return (self.noise,)


@dataclass(frozen=True)
class Magnetometer(Sensor):
    """Magnetometer; noises along x, y, z in T."""

    kind: ClassVar[str] = "magnetometer"
    usual_rate: ClassVar[float] = 50.0

    magnetic_field: tuple[Noise, Noise, Noise] = (QUIET, QUIET, QUIET)

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Noises along the axes of S (3)."""
        return self.magnetic_field


@dataclass(frozen=True)
class DepthCamera(Sensor):
    """Depth camera (`depth`, `depth_camera`, `rgbd`, `rgbd_camera`), looking along its x.

    Attributes:
        width: pixels in a row.
        height: rows.
        horizontal_fov: full horizontal angle of view [rad].
        near: of the clip range [m].
        far: of the clip range [m].
        noise: of a pixel's depth [m].
    """

    kind: ClassVar[str] = "depth_camera"
    usual_rate: ClassVar[float] = 15.0

    width: int = 0
    height: int = 0
    horizontal_fov: float = 0.0
    near: float = 0.0
    far: float = 0.0
    noise: Noise = QUIET


class SensorFrames(NamedTuple):
    """Names of the frames of a sensor.

    Attributes:
        own: of the sensor's frame S.
        optical: of a depth camera's optical frame, None for other sensors.
        alias: another name for S, the label of its readings; None if there is none.
    """

    own: str
    optical: str | None
    alias: str | None


def sensor_frames(sensors: Sequence[Sensor], others: Collection[str]) -> list[SensorFrames]:
    """Return the names for sensors, in order: NAME if it is free, else NAME_sensor.

    Args:
        sensors: in the order of the description; a `frame` of "" needs no alias.
        others: names that are taken.
    """
    taken = {*others, ""}
    found = []
    for sensor in sensors:
        own = free_name(taken, sensor.name, f"{sensor.name}_sensor")
        taken.add(own)
        optical = None
        if isinstance(sensor, DepthCamera):
            optical = free_name(taken, f"{sensor.name}_optical")
            taken.add(optical)
        alias = None if sensor.frame in taken else sensor.frame
        taken.add(sensor.frame)
        found.append(SensorFrames(own, optical, alias))
    return found


def free_name(taken: Collection[str], *wishes: str) -> str:
    """Return the first of several names that is not taken, or the last one with a number."""
    *_, last = wishes
    numbered = (f"{last}_{number}" for number in range(2, len(taken) + 3))
    return next(name for name in (*wishes, *numbered) if name not in taken)
