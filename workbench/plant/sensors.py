"""What a description says of its sensors; truth and noise are made of this elsewhere."""

from dataclasses import dataclass

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Noise:
    """Gaussian noise of one sample, in the unit of what it is added to.

    Attributes:
        mean: constant offset.
        stddev: of each sample.
        bias_mean: mean of a bias drawn once.
        bias_stddev: its standard deviation.
    """

    mean: float = 0.0
    stddev: float = 0.0
    bias_mean: float = 0.0
    bias_stddev: float = 0.0


QUIET = Noise()


@dataclass(frozen=True)
class Sensor:
    """What all sensors have.

    Attributes:
        name: as declared; unique in the vehicle.
        type: as declared: imu, navsat, gpu_lidar, ...
        frame: the frame that its data are labelled with: a link's name or what the file asks for.
        link: on which it is mounted.
        rate: samples per second [1/s]; 0 where the file leaves it open.
        p_BS: position in the body frame [m].
        R_BS: orientation, rows of the rotation matrix.
    """

    name: str
    type: str
    frame: str
    link: str
    rate: float
    p_BS: Triple
    R_BS: tuple[Triple, Triple, Triple]


@dataclass(frozen=True)
class Imu(Sensor):
    """Gyroscope and accelerometer; noises along x, y, z in rad/s and m/s²."""

    angular_velocity: tuple[Noise, Noise, Noise] = (QUIET, QUIET, QUIET)
    linear_acceleration: tuple[Noise, Noise, Noise] = (QUIET, QUIET, QUIET)


@dataclass(frozen=True)
class Gps(Sensor):
    """Satellite navigation (`gps` or `navsat`); noises in m and m/s."""

    horizontal_position: Noise = QUIET
    vertical_position: Noise = QUIET
    horizontal_velocity: Noise = QUIET
    vertical_velocity: Noise = QUIET


@dataclass(frozen=True)
class ScanAxis:
    """Rays of a lidar along one axis: angles [rad] of the first and the last, both measured."""

    samples: int
    min_angle: float
    max_angle: float


@dataclass(frozen=True)
class Lidar(Sensor):
    """Lidar (`lidar`, `ray`, `gpu_lidar`, `gpu_ray`); ranges and noise in m."""

    horizontal: ScanAxis = ScanAxis(1, 0.0, 0.0)
    vertical: ScanAxis = ScanAxis(1, 0.0, 0.0)
    min_range: float = 0.0
    max_range: float = 0.0
    resolution: float = 0.0
    noise: Noise = QUIET


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

    width: int = 0
    height: int = 0
    horizontal_fov: float = 0.0
    near: float = 0.0
    far: float = 0.0
    noise: Noise = QUIET
