"""The sensors of a description. Truth and noise are computed elsewhere."""

import dataclasses
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, ClassVar

from workbench.common.extensions import (
    ExtensionGroup,
    complete_extensions,
    load_extensions,
    warn_left_out,
)
from workbench.common.parameter import Parameter

if TYPE_CHECKING:
    from workbench.plant.formats.block import XmlBlock
    from workbench.plant.remarks import Remarks

SensorVector = tuple[float, float, float]
MAX_LIDAR_RAYS = 1_000_000
"""Largest number of rays of a lidar: its samples are state of the diagram."""


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
        scaled = {each.name: unit * getattr(self, each.name) for each in dataclasses.fields(self)}
        scaled["dynamic_bias_correlation_time"] = self.dynamic_bias_correlation_time
        return Noise(**scaled)


NO_NOISE = Noise()


@dataclass(frozen=True)
class Sensor:
    """The common attributes of all sensors.

    A class is a kind of sensor; its constants are the same for all of them. One of an installed
    package also has `read`, and is a `MeasuringSensor`.

    Attributes:
        kind: its name in scenarios, the same for all equivalent types.
        usual_rate: rate of a sensor without a declared one [1/s].
        types: declared types that `read` reads; the core's are in `plant/sensor_reader.py`.
        parameters: live ones of its system besides the fault, in the order of its settings.
        noise_unit: of its noise, for tables.
        casts_rays: whether it needs the scene.
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
    types: ClassVar[tuple[str, ...]] = ()
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    noise_unit: ClassVar[str] = "m"
    casts_rays: ClassVar[bool] = False

    name: str
    type: str
    frame: str
    link: str
    rate: float
    p_BS: SensorVector
    R_BS: tuple[SensorVector, SensorVector, SensorVector]

    @property
    def stated_noises(self) -> dict[str, tuple[Noise, ...]]:
        """Noises by attribute, one value or one for each axis."""
        values = {each.name: getattr(self, each.name) for each in dataclasses.fields(self)}
        several = {name: v if isinstance(v, tuple) else (v,) for name, v in values.items()}
        return {k: v for k, v in several.items() if v and all(isinstance(n, Noise) for n in v)}

    @property
    def noises(self) -> tuple[Noise, ...]:
        """Noises of each number in a sample."""
        return tuple(each for values in self.stated_noises.values() for each in values)

    @classmethod
    def read(cls, common: "Sensor", block: "XmlBlock", remarks: "Remarks") -> "Sensor | None":
        """Return the sensor of a `<sensor>` block, None if it is not used.

        Args:
            common: attributes of all sensors.
            block: the whole element.
            remarks: receives what is assumed, repaired or ignored.

        Raises:
            WorkbenchError: with file and line, for an impossible number.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class Imu(Sensor):
    """Gyroscope and accelerometer; noises along x, y, z in rad/s and m/s²."""

    kind: ClassVar[str] = "imu"
    usual_rate: ClassVar[float] = 200.0

    angular_velocity: tuple[Noise, Noise, Noise] = (NO_NOISE, NO_NOISE, NO_NOISE)
    linear_acceleration: tuple[Noise, Noise, Noise] = (NO_NOISE, NO_NOISE, NO_NOISE)


@dataclass(frozen=True)
class Gps(Sensor):
    """Satellite navigation (`gps` or `navsat`); noises in m and m/s."""

    kind: ClassVar[str] = "gps"
    usual_rate: ClassVar[float] = 10.0

    horizontal_position: Noise = NO_NOISE
    vertical_position: Noise = NO_NOISE
    horizontal_velocity: Noise = NO_NOISE
    vertical_velocity: Noise = NO_NOISE

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
    casts_rays: ClassVar[bool] = True
    usual_rate: ClassVar[float] = 10.0

    horizontal: ScanAxis = ScanAxis(1, 0.0, 0.0)
    vertical: ScanAxis = ScanAxis(1, 0.0, 0.0)
    min_range: float = 0.0
    max_range: float = 0.0
    resolution: float = 0.0
    noise: Noise = NO_NOISE


@dataclass(frozen=True)
class RangeFinder(Sensor):
    """Range finder: one ray along its x (a lidar of a single ray, or a `sonar`), all in m."""

    kind: ClassVar[str] = "range_finder"
    casts_rays: ClassVar[bool] = True
    usual_rate: ClassVar[float] = 20.0

    min_range: float = 0.0
    max_range: float = 0.0
    resolution: float = 0.0
    noise: Noise = NO_NOISE

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
    noise_unit: ClassVar[str] = "Pa"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter(
            "barometer_ground_effect",
            "Pa",
            "pressure that the downwash adds at the ground; 12 Pa for a metre",
            -500.0,
            500.0,
            0.0,
            "barometer",
        ),
    )

    reference_altitude: float | None = None
    noise: Noise = NO_NOISE


@dataclass(frozen=True)
class Magnetometer(Sensor):
    """Magnetometer; noises along x, y, z in T."""

    kind: ClassVar[str] = "magnetometer"
    usual_rate: ClassVar[float] = 50.0
    parameters: ClassVar[tuple[Parameter, ...]] = tuple(
        Parameter(
            f"magnetometer_disturbance_{axis}",
            "T",
            f"field that the drone adds to the earth's, {way}",
            -1e-3,
            1e-3,
            0.0,
            "magnetometer",
        )
        for axis, way in (("x", "ahead"), ("y", "to the left"), ("z", "upwards"))
    )

    magnetic_field: tuple[Noise, Noise, Noise] = (NO_NOISE, NO_NOISE, NO_NOISE)


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
    colour_types: ClassVar[tuple[str, ...]] = ("rgbd", "rgbd_camera")

    width: int = 0
    height: int = 0
    horizontal_fov: float = 0.0
    near: float = 0.0
    far: float = 0.0
    noise: Noise = NO_NOISE

    @property
    def has_colour(self) -> bool:
        """Whether it also has a picture of colour."""
        return self.type in self.colour_types


CORE_SENSORS: tuple[type[Sensor], ...] = (
    *(Imu, Gps, Lidar, RangeFinder, Barometer, DepthCamera, Magnetometer),
)
"""The core's kinds; installed packages add others."""


@cache
def added_sensors() -> tuple[type[Sensor], ...]:
    """Return the kinds that installed packages add, by name.

    One that is no class of a sensor, or not of the kind of its entry, is left out with a warning.
    """
    added: list[type[Sensor]] = []
    for name, kind in load_extensions(ExtensionGroup.SENSORS, type).items():
        if not issubclass(kind, Sensor) or kind.kind != name:
            warn_left_out(ExtensionGroup.SENSORS, name, f"is no Sensor of the kind {name}")
        elif name not in (each.kind for each in CORE_SENSORS):
            added.append(kind)
    return tuple(added)


@cache
def sensor_kinds() -> tuple[str, ...]:
    """Return the names of all kinds, those of the core first; nothing is loaded."""
    core = [each.kind for each in CORE_SENSORS]
    return tuple(dict.fromkeys([*core, *complete_extensions(ExtensionGroup.SENSORS)]))


def sensor_frames(
    sensors: Sequence[Sensor], others: Collection[str]
) -> list[tuple[str, str | None, str | None]]:
    """Return the names of the frames of sensors, in order.

    Each has that of its frame S, NAME if it is free, else NAME_sensor; that of the optical frame of
    a depth camera, None for others; and another name for S, the label of its readings, or None.

    Args:
        sensors: in the order of the description; a `frame` of "" needs no alias.
        others: names that are taken.
    """
    taken = {*others, ""}
    found: list[tuple[str, str | None, str | None]] = []
    for sensor in sensors:
        own = free_name(taken, sensor.name, f"{sensor.name}_sensor")
        taken.add(own)
        optical = None
        if isinstance(sensor, DepthCamera):
            optical = free_name(taken, f"{sensor.name}_optical")
            taken.add(optical)
        alias = None if sensor.frame in taken else sensor.frame
        taken.add(sensor.frame)
        found.append((own, optical, alias))
    return found


def free_name(taken: Collection[str], *wishes: str) -> str:
    """Return the first of several names that is not taken, or the last one with a number."""
    *_, last = wishes
    numbered = (f"{last}_{number}" for number in range(2, len(taken) + 3))
    return next(name for name in (*wishes, *numbered) if name not in taken)
