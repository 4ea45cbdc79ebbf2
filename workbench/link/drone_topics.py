"""The topics of a drone: the eight of the paper, its sensors, and its state."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from workbench.link.topics import PREFIX, Delivery, Direction, Field, Topic

TIME = 1
POSITION = 2
VELOCITY = 3
ACCELERATION = 4
FORCE_TORQUE = 5
DRONE_STATE = 6
ON_OFF = 7
COMMAND = 8
IMU = 9
GPS = 10
LIDAR = 11
LIDAR_CLOUD = 12
FRAMES = 13
ROTORS = 14
WIND = 15
PARAMETERS = 16
EVENTS = 17
MAGNETOMETER = 18
ESTIMATE = 19

AXES = 15
"""All axes of a command: bit 0 v_x, bit 1 v_y, bit 2 v_z, bit 3 yaw rate."""
LONGEST_TEXT = 240
LONGEST_NAME = 48


@dataclass(frozen=True)
class Outfit:
    """The properties of a drone that determine its topics and their sizes.

    Attributes:
        rotors: their number.
        fast: rate of topics of the state [1/s].
        slow: rate of slow topics [1/s].
        imu: rate of the IMU, 0 without one [1/s]; the next two are similar.
        gps: rate of satellite navigation.
        lidar: rate of the lidar.
        rays: number of rays in its cloud on the wire.
        scan: directions of these rays and the position of the sensor, for `Topic.about`.
        frames: parent and child of each frame.
        limits: largest level speed, climb rate [m/s] and yaw rate [rad/s] of commands.
        mounts: names of the sensor frames, by the keys imu, gps, lidar and magnetometer.
        magnetometer: rate of the magnetometer, 0 without one [1/s].
        estimate: whether the controller uses an estimate of the motion.
    """

    rotors: int
    fast: float
    slow: float
    imu: float = 0.0
    gps: float = 0.0
    lidar: float = 0.0
    rays: int = 0
    scan: Mapping[str, object] = field(default_factory=dict)
    frames: Sequence[tuple[str, str]] = ()
    limits: tuple[float, float, float] = (8.0, 8.0, 0.4)
    mounts: Mapping[str, str] = field(default_factory=dict)
    magnetometer: float = 0.0
    estimate: bool = False


PARAMETERS_TOPIC = Topic(
    PARAMETERS,
    f"{PREFIX}parameters",
    Direction.OUT,
    0.0,
    (Field("name", "char", "", count=LONGEST_NAME), Field("value", "float64", "")),
    Delivery.EVENT,
)
EVENTS_TOPIC = Topic(
    EVENTS,
    f"{PREFIX}events",
    Direction.OUT,
    0.0,
    (
        Field("severity", "int32", "1", low=0, high=2),
        Field("said", "char", "", count=LONGEST_TEXT),
    ),
    Delivery.EVENT,
    {"severity": ["information", "warning", "failure"]},
)


def drone_topics(outfit: Outfit) -> tuple[Topic, ...]:
    """Return the topics of a drone, ordered by number; a number never changes its meaning."""
    topics = [
        *_paper(outfit),
        *_sensors(outfit),
        *_estimate(outfit),
        _out(
            FRAMES,
            "frames",
            outfit.slow,
            *([_numbers("poses", "m and 1", "", 7 * len(outfit.frames))] if outfit.frames else []),
            about={
                "frames": [list(pair) for pair in outfit.frames],
                "poses": "for each frame: place x, y, z in its parent, and a quaternion w, x, y, z",
            },
        ),
        _out(
            ROTORS,
            "rotors",
            outfit.fast,
            _numbers("speed", "rad/s", "", outfit.rotors),
            _numbers("thrust", "N", "B", outfit.rotors),
        ),
        _out(WIND, "wind", outfit.slow, _numbers("wind", "m/s", "W", 3)),
        PARAMETERS_TOPIC,
        EVENTS_TOPIC,
    ]
    topics.sort(key=lambda topic: topic.id)
    return tuple(topic for topic in topics if topic.fields)


def _paper(outfit: Outfit) -> list[Topic]:
    """Return the paper's topics."""
    fast = outfit.fast
    level, climb, turn = outfit.limits
    return [
        _out(
            TIME,
            "time_data",
            fast,
            Field("seconds", "int32", "s", low=0),
            Field("nanoseconds", "uint32", "ns", low=0, high=999_999_999),
            Field("wall_ns", "int64", "ns", low=0),
            about={"wall_ns": "when this was sampled, since 1970"},
        ),
        _out(
            POSITION,
            "position_data",
            fast,
            *_vector("", "m", "W", ("x", "y", "z")),
            *_vector("", "rad", "W", ("roll", "pitch", "yaw")),
            *_vector("displacement_", "m", "W", "xyz"),
        ),
        _out(
            VELOCITY,
            "velocity_data",
            fast,
            *_vector("v_", "m/s", "W", "xyz"),
            *_vector("w_", "rad/s", "W", "xyz"),
        ),
        _out(
            ACCELERATION,
            "acceleration_data",
            fast,
            *_vector("vdot_", "m/s^2", "W", "xyz"),
            *_vector("wdot_", "rad/s^2", "W", "xyz"),
        ),
        _out(
            FORCE_TORQUE,
            "force_torque_data",
            fast,
            *_vector("force_", "N", "W", "xyz"),
            *_vector("torque_", "N m", "B", "xyz"),
        ),
        _out(
            DRONE_STATE,
            "drone_state",
            outfit.slow,
            Field("mode", "int32", "1", low=0, high=7),
            Field("condition", "char", "", count=16),
            Field("charge", "float32", "1", low=0.0, high=1.0),
            Field("clearance", "float32", "m", low=0.0),
        ),
        _out(ON_OFF, "on_off_state", outfit.slow, Field("on", "int32", "1", low=0, high=1)),
        Topic(
            COMMAND,
            f"{PREFIX}command_velocity",
            Direction.BOTH,
            fast,
            (
                Field("lease", "uint32", "1"),
                Field("axes", "uint32", "1", low=1, high=AXES),
                Field("v_x", "float32", "m/s", "W", low=-level, high=level),
                Field("v_y", "float32", "m/s", "W", low=-level, high=level),
                Field("v_z", "float32", "m/s", "W", low=-climb, high=climb),
                Field("yaw_rate", "float32", "rad/s", "W", low=-turn, high=turn),
            ),
            about={
                "lease": "from request_control; 0 where the server tells what is flown",
                "axes": "bit 0 v_x, bit 1 v_y, bit 2 v_z, bit 3 yaw_rate; others are flown as 0",
            },
        ),
    ]


def _sensors(outfit: Outfit) -> list[Topic]:
    """Return the topics of the sensors in use."""
    topics = []
    if outfit.imu:
        topics.append(
            _out(
                IMU,
                "imu",
                outfit.imu,
                Field("stamp", "int64", "ns", low=0),
                _numbers("specific_force", "m/s^2", "S", 3),
                _numbers("angular_velocity", "rad/s", "S", 3),
                _numbers("q_WS", "1", "", 4),
                about=_mount(outfit, "imu"),
            )
        )
    if outfit.gps:
        topics.append(
            _out(
                GPS,
                "gps",
                outfit.gps,
                Field("stamp", "int64", "ns", low=0),
                Field("latitude", "float64", "rad", low=-1.5707963267948966, high=1.57079632679),
                Field("longitude", "float64", "rad", low=-3.1415926535897931, high=3.1415926536),
                Field("altitude", "float64", "m"),
                _numbers("velocity", "m/s", "east, north, up", 3),
                about=_mount(outfit, "gps"),
            )
        )
    if outfit.lidar:
        topics += [
            _out(
                LIDAR,
                "lidar",
                outfit.lidar,
                Field("stamp", "int64", "ns", low=0),
                Field("returns", "uint32", "1"),
                Field("rays", "uint32", "1"),
                Field("nearest", "float32", "m", "S", low=0.0),
                _numbers("direction", "1", "S", 3),
                about=_mount(outfit, "lidar"),
            ),
            _out(
                LIDAR_CLOUD,
                "lidar_cloud",
                outfit.lidar,
                Field("stamp", "int64", "ns", low=0),
                _numbers("ranges", "m", "S", outfit.rays),
                about=outfit.scan,
            ),
        ]
    if outfit.magnetometer:
        topics.append(
            _out(
                MAGNETOMETER,
                "magnetometer",
                outfit.magnetometer,
                Field("stamp", "int64", "ns", low=0),
                _numbers("magnetic_field", "T", "S", 3),
                about=_mount(outfit, "magnetometer"),
            )
        )
    return topics


def _estimate(outfit: Outfit) -> list[Topic]:
    """Return the topic of the estimated motion, if the controller uses one."""
    if not outfit.estimate:
        return []
    body = next((child for parent, child in outfit.frames if parent == "world"), None)
    return [
        _out(
            ESTIMATE,
            "estimate",
            outfit.fast,
            *_vector("", "m", "W", ("x", "y", "z")),
            *_vector("", "rad", "W", ("roll", "pitch", "yaw")),
            *_vector("v_", "m/s", "W", "xyz"),
            *_vector("w_", "rad/s", "W", "xyz"),
            *_vector("sigma_", "m", "W", ("x", "y", "z")),
            *_vector("sigma_", "rad", "B", ("roll", "pitch", "yaw")),
            *_vector("sigma_", "m/s", "W", ("v_x", "v_y", "v_z")),
            about={
                "sigma": "standard deviations of the errors; NaN where they are not known",
                **({"frame": body} if body else {}),
            },
        )
    ]


def _mount(outfit: Outfit, sensor: str) -> Mapping[str, object]:
    """Return the name of the frame S of the data of a sensor, if known."""
    return {"frame": outfit.mounts[sensor]} if sensor in outfit.mounts else {}


def _out(
    number: int,
    name: str,
    rate: float,
    *fields: Field,
    about: Mapping[str, object] | None = None,
) -> Topic:
    return Topic(number, PREFIX + name, Direction.OUT, rate, fields, about=about or {})


def _numbers(name: str, unit: str, frame: str, count: int) -> Field:
    return Field(name, "float32", unit, frame, count)


def _vector(prefix: str, unit: str, frame: str, parts: Sequence[str]) -> list[Field]:
    return [Field(prefix + part, "float32", unit, frame) for part in parts]
