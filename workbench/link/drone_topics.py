"""The signals of a drone: the eight topics of the paper, its sensors, and its state."""

from collections.abc import Mapping, Sequence
from functools import cache

from workbench.common.extensions import ExtensionGroup, load_extensions, warn_left_out
from workbench.link.joint_signals import (
    CONTACT_FORCES_SIGNAL,
    JOINT_SETPOINTS_SIGNAL,
    JOINT_STATES_SIGNAL,
    TENSIONS_SIGNAL,
)
from workbench.link.picture_signals import COLOUR_IMAGE_SIGNAL, DEPTH_IMAGE_SIGNAL
from workbench.link.ros_messages import making, transforms
from workbench.link.signal import (
    ANY_DRONE,
    STAMP_FIELD,
    RosChannel,
    Signal,
    TopicOptions,
    component_fields,
    vector_field,
)
from workbench.link.topics import PREFIX, Field, Topic, TopicDirection

MIN_ADDED_TOPIC_ID = 1000
"""Smallest number of a signal of another package."""

ALL_COMMAND_AXES = 15
"""All axes of a command: bit 0 v_x, bit 1 v_y, bit 2 v_z, bit 3 yaw rate."""
MAX_EVENT_TEXT_BYTES = 240
MAX_LINK_NAME_CHARS = 48


_POSITION_FIELDS = component_fields("m", "W", "x y z")
_ANGLE_FIELDS = component_fields("rad", "W", "roll pitch yaw")
_VELOCITY_FIELDS = component_fields("m/s", "W", "v_x v_y v_z")
_TURN_FIELDS = component_fields("rad/s", "W", "w_x w_y w_z")
_DISPLACEMENT_FIELDS = component_fields("m", "W", "displacement_x displacement_y displacement_z")
_ACCELERATION_FIELDS = (
    *component_fields("m/s^2", "W", "vdot_x vdot_y vdot_z"),
    *component_fields("rad/s^2", "W", "wdot_x wdot_y wdot_z"),
)
_FORCE_FIELDS = (
    *component_fields("N", "W", "force_x force_y force_z"),
    *component_fields("N m", "B", "torque_x torque_y torque_z"),
)
_ESTIMATE_FIELDS = (
    *(*_POSITION_FIELDS, *_ANGLE_FIELDS, *_VELOCITY_FIELDS, *_TURN_FIELDS),
    *component_fields("m", "W", "sigma_x sigma_y sigma_z"),
    *component_fields("rad", "B", "sigma_roll sigma_pitch sigma_yaw"),
    *component_fields("m/s", "W", "sigma_v_x sigma_v_y sigma_v_z"),
)
_IMU_FIELDS = (
    STAMP_FIELD,
    vector_field("specific_force", "m/s^2", "S"),
    vector_field("angular_velocity", "rad/s", "S"),
    vector_field("q_WS", "1", "", "wxyz"),
)
_GPS_FIELDS = (
    STAMP_FIELD,
    Field("latitude", "float64", "rad", low=-1.5707963267948966, high=1.57079632679),
    Field("longitude", "float64", "rad", low=-3.1415926535897931, high=3.1415926536),
    Field("altitude", "float64", "m"),
    vector_field("velocity", "m/s", "east, north, up"),
)
_LIDAR_FIELDS = (
    STAMP_FIELD,
    Field("returns", "uint32", "1"),
    Field("rays", "uint32", "1"),
    Field("nearest", "float32", "m", "S", low=0.0),
    vector_field("direction", "1", "S"),
)
_MAGNETOMETER_FIELDS = (STAMP_FIELD, vector_field("magnetic_field", "T", "S"))
_STATE_FIELDS = (
    Field("mode", "int32", "1", low=0, high=7),
    Field("condition", "char", "", count=16),
    Field("charge", "float32", "1", low=0.0, high=1.0),
    Field("clearance", "float32", "m", low=0.0),
)
_ON_OFF_FIELDS = (Field("on", "int32", "1", low=0, high=1),)
_BATTERY_FIELDS = (
    Field("voltage", "float32", "V"),
    Field("current", "float32", "A"),
    Field("charge", "float32", "1", low=0.0, high=1.0),
    Field("capacity", "float32", "C"),
)
_TIME_FIELDS = (
    Field("seconds", "int32", "s", low=0),
    Field("nanoseconds", "uint32", "ns", low=0, high=999_999_999),
    Field("wall_ns", "int64", "ns", low=0),
)
_PARAMETER_FIELDS = (
    Field("name", "char", "", count=MAX_LINK_NAME_CHARS),
    Field("value", "float64", ""),
)
_EVENT_FIELDS = (
    Field("severity", "int32", "1", low=0, high=2),
    Field("said", "char", "", count=MAX_EVENT_TEXT_BYTES),
)


def _command_fields(options: TopicOptions) -> Sequence[Field]:
    level, climb, turn = options.limits
    return (
        Field("lease", "uint32", "1"),
        Field("axes", "uint32", "1", low=1, high=ALL_COMMAND_AXES),
        Field("v_x", "float32", "m/s", "W", low=-level, high=level),
        Field("v_y", "float32", "m/s", "W", low=-level, high=level),
        Field("v_z", "float32", "m/s", "W", low=-climb, high=climb),
        Field("yaw_rate", "float32", "rad/s", "W", low=-turn, high=turn),
    )


def _rotor_fields(options: TopicOptions) -> Sequence[Field]:
    n = options.rotors
    return (Field("speed", "float32", "rad/s", "", n), Field("thrust", "float32", "N", "B", n))


def _cloud_fields(options: TopicOptions) -> Sequence[Field]:
    return (STAMP_FIELD, Field("ranges", "float32", "m", "S", options.rays))


def _frames_fields(options: TopicOptions) -> Sequence[Field]:
    count = 7 * len(options.frames)
    return (Field("poses", "float32", "m and 1", "", count),) if count else ()


def _about_frames(options: TopicOptions) -> Mapping[str, object]:
    return {
        "frames": [list(pair) for pair in options.frames],
        "moving": list(options.moving),
        "poses": "for each frame: place x, y, z in its parent, and a quaternion w, x, y, z",
    }


def _about_estimate(options: TopicOptions) -> Mapping[str, object]:
    body = next((child for parent, child in options.frames if parent == "world"), None)
    return {
        "sigma": "standard deviations of the errors; NaN where they are not known",
        **({"frame": body} if body else {}),
    }


_ABOUT_COMMAND = {
    "lease": "from request_control; 0 where the server tells what is flown",
    "axes": "bit 0 v_x, bit 1 v_y, bit 2 v_z, bit 3 yaw_rate; others are flown as 0",
}
_ABOUT_TIME = {"wall_ns": "when this was sampled, since 1970"}
_ABOUT_EVENTS = {"severity": ["information", "warning", "failure"]}
_POSE = RosChannel(
    f"{PREFIX}pose", "geometry_msgs/msg/PoseStamped", making.pose_maker, repeats=True
)
_TWIST = RosChannel(
    f"{PREFIX}twist", "geometry_msgs/msg/TwistStamped", making.twist_maker, repeats=True
)
_ODOMETRY = RosChannel(
    f"{PREFIX}estimated_odometry",
    "nav_msgs/msg/Odometry",
    making.estimated_odometry_maker,
    repeats=True,
)
_IMU = RosChannel(f"{PREFIX}imu", "sensor_msgs/msg/Imu", making.imu_maker)
_FIX = RosChannel(f"{PREFIX}gps", "sensor_msgs/msg/NavSatFix", making.fix_maker)
_FIX_VELOCITY = RosChannel(
    f"{PREFIX}gps_velocity", "geometry_msgs/msg/TwistStamped", making.fix_velocity_maker
)
_CLOUD = RosChannel(f"{PREFIX}lidar_cloud", "sensor_msgs/msg/PointCloud2", making.cloud_maker)
_MAGNETIC_FIELD = RosChannel(
    f"{PREFIX}magnetometer", "sensor_msgs/msg/MagneticField", making.magnetic_field_maker
)
_BATTERY_STATE = RosChannel(
    f"{PREFIX}battery_state", "sensor_msgs/msg/BatteryState", making.battery_maker, repeats=True
)
_TRANSFORMS = RosChannel("/tf", "tf2_msgs/msg/TFMessage", transforms.transforms_maker)
POSITION_SIGNAL = Signal(
    2,
    "position_data",
    "Place and attitude",
    "fast",
    (*_POSITION_FIELDS, *_ANGLE_FIELDS, *_DISPLACEMENT_FIELDS),
    "PositionData",
    (_POSE,),
)
VELOCITY_SIGNAL = Signal(
    3,
    "velocity_data",
    "Velocity",
    "fast",
    (*_VELOCITY_FIELDS, *_TURN_FIELDS),
    "VelocityData",
    (_TWIST,),
)
ACCELERATION_SIGNAL = Signal(
    4, "acceleration_data", "Acceleration", "fast", _ACCELERATION_FIELDS, "AccelerationData"
)
FORCE_TORQUE_SIGNAL = Signal(
    5, "force_torque_data", "Force and torque", "fast", _FORCE_FIELDS, "ForceTorqueData"
)
COMMAND_SIGNAL = Signal(
    8,
    "command_velocity",
    "Command",
    "fast",
    _command_fields,
    "CommandVelocity",
    about=lambda _: _ABOUT_COMMAND,
    direction=TopicDirection.BOTH,
)
ROTORS_SIGNAL = Signal(14, "rotors", "Rotors", "fast", _rotor_fields, "RotorData")
IMU_SIGNAL = Signal(9, "imu", "IMU", "imu", _IMU_FIELDS, others=(_IMU,))
GPS_SIGNAL = Signal(
    10,
    "gps",
    "GPS",
    "gps",
    _GPS_FIELDS,
    others=(_FIX, _FIX_VELOCITY),
    about=lambda options: GPS_SIGNAL.about_sensor(options) | {"home": list(options.home)},
)
LIDAR_SIGNAL = Signal(11, "lidar", "Lidar", "lidar", _LIDAR_FIELDS, "LidarSummary", plotted=False)
LIDAR_CLOUD_SIGNAL = Signal(
    12,
    "lidar_cloud",
    "Point cloud",
    "lidar",
    _cloud_fields,
    others=(_CLOUD,),
    about=lambda options: options.scan,
    plotted=False,
)
MAGNETOMETER_SIGNAL = Signal(
    18,
    "magnetometer",
    "Magnetometer",
    "magnetometer",
    _MAGNETOMETER_FIELDS,
    others=(_MAGNETIC_FIELD,),
)
ESTIMATE_SIGNAL = Signal(
    19,
    "estimate",
    "Estimate",
    "estimate",
    _ESTIMATE_FIELDS,
    "EstimateData",
    (_ODOMETRY,),
    about=_about_estimate,
)
WIND_SIGNAL = Signal(15, "wind", "Wind", "slow", (vector_field("wind", "m/s", "W"),), "WindData")
DRONE_STATE_SIGNAL = Signal(
    6, "drone_state", "State of the drone", "slow", _STATE_FIELDS, "DroneState", plotted=False
)
ON_OFF_SIGNAL = Signal(
    7, "on_off_state", "On or off", "slow", _ON_OFF_FIELDS, "OnOffState", plotted=False
)
CLOCK_SIGNAL = Signal(
    1,
    "time_data",
    "Clock",
    "fast",
    _TIME_FIELDS,
    "DroneTime",
    about=lambda _: _ABOUT_TIME,
    plotted=False,
)
PARAMETERS_SIGNAL = Signal(
    16, "parameters", "Parameters", "event", _PARAMETER_FIELDS, "ParameterChange", plotted=False
)
EVENTS_SIGNAL = Signal(
    17,
    "events",
    "Events",
    "event",
    _EVENT_FIELDS,
    "Event",
    about=lambda _: _ABOUT_EVENTS,
    plotted=False,
)
FRAMES_SIGNAL = Signal(
    13,
    "frames",
    "Frames",
    "slow",
    _frames_fields,
    others=(_TRANSFORMS,),
    about=_about_frames,
    plotted=False,
)
BATTERY_SIGNAL = Signal(
    20, "battery", "Battery", "slow", _BATTERY_FIELDS, "BatteryData", (_BATTERY_STATE,)
)
DRONE_SIGNALS = (
    *(POSITION_SIGNAL, VELOCITY_SIGNAL, ACCELERATION_SIGNAL, FORCE_TORQUE_SIGNAL, COMMAND_SIGNAL),
    *(ROTORS_SIGNAL, IMU_SIGNAL, GPS_SIGNAL, LIDAR_SIGNAL, LIDAR_CLOUD_SIGNAL),
    *(MAGNETOMETER_SIGNAL, ESTIMATE_SIGNAL, WIND_SIGNAL, DRONE_STATE_SIGNAL, ON_OFF_SIGNAL),
    *(CLOCK_SIGNAL, PARAMETERS_SIGNAL, EVENTS_SIGNAL, FRAMES_SIGNAL),
    *(BATTERY_SIGNAL, JOINT_STATES_SIGNAL, JOINT_SETPOINTS_SIGNAL),
    *(CONTACT_FORCES_SIGNAL, TENSIONS_SIGNAL),
    *(DEPTH_IMAGE_SIGNAL, COLOUR_IMAGE_SIGNAL),
)
"""The core's signals, in the order of lists."""


@cache
def drone_signals() -> tuple[Signal, ...]:
    """Return the core's signals, then those that installed packages add.

    One without a number or a name of its own is left out with a warning.
    """
    found = list(DRONE_SIGNALS)
    for entry, row in load_extensions(ExtensionGroup.SIGNALS, Signal).items():
        taken = [each for each in found if each.id == row.id or each.name == row.name]
        if taken or row.id < MIN_ADDED_TOPIC_ID:
            warn_left_out(
                ExtensionGroup.SIGNALS,
                entry,
                f"needs a name and a number of its own, {MIN_ADDED_TOPIC_ID} or more",
            )
        else:
            found.append(row)
    return tuple(found)


def drone_topics(options: TopicOptions) -> tuple[Topic, ...]:
    """Return the topics of a drone, ordered by number; a number never changes its meaning."""
    topics = [topic for row in drone_signals() if (topic := row.topic(options))]
    return tuple(sorted(topics, key=lambda topic: topic.id))


@cache
def fixed_topic(number: int) -> Topic:
    """Return a topic that each drone has, with the same fields."""
    [topic] = (row.topic(ANY_DRONE) for row in DRONE_SIGNALS if row.id == number)
    assert topic
    return topic
