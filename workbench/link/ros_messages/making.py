"""Make ROS 2 messages of motion and sensors, mostly standard ones, from fields of the link."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from workbench.link.topics import PART_NAMES, FieldValue, Topic

if TYPE_CHECKING:
    import numpy as np  # slow to load, and only a cloud needs it

ROS_WORLD_FRAME = "world"
"""Name of the root frame: x east, y north, z up."""
ROS_MAP_FRAME = "map"
ROS_ODOM_FRAME = "odom"
"""REP-105's fixed frames, both equal to the world."""
ROS_BODY_FRAME = "base_link"
MessageMaker = Callable[[int, Mapping[str, Any]], Mapping[str, Any]]
"""Makes a message from the time [ns] and the fields of a topic by name."""


def time_message(t_ns: int) -> Mapping[str, int]:
    """Return a builtin_interfaces/msg/Time for a time [ns]."""
    seconds, rest = divmod(t_ns, 1_000_000_000)
    return {"sec": seconds, "nanosec": rest}


@lru_cache(maxsize=32)
def header(t_ns: int, frame: str) -> Mapping[str, Any]:
    """Return a std_msgs/msg/Header for a time [ns] and a frame, cached for other messages."""
    return {"stamp": time_message(t_ns), "frame_id": frame}


def vector_message(parts: Sequence[float]) -> Mapping[str, float]:
    """Return a geometry_msgs/msg/Vector3 or Point."""
    x, y, z = parts
    return {"x": x, "y": y, "z": z}


def quaternion_message(parts: Sequence[float]) -> Mapping[str, float]:
    """Return a geometry_msgs/msg/Quaternion for w, x, y, z."""
    w, x, y, z = parts
    return {"x": x, "y": y, "z": z, "w": w}


def own_message_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a message of our own type, with the field names of the link."""
    if not any(field.name == "stamp" for field in topic.fields):
        return lambda t_ns, values: {"header": header(t_ns, ROS_WORLD_FRAME), **values}
    head = sensor_header_maker(topic)
    return lambda t_ns, values: {"header": head(values), **values}


UNKNOWN_POSE_COVARIANCE = (0.0,) * 36
"""Unknown covariance of a pose or twist."""
EXACT_VARIANCE = 1e-9
"""Variance of an exact value, in its unit squared; 0 would mean unknown in ROS."""
EXACT_POSE_COVARIANCE = tuple(EXACT_VARIANCE if i % 7 == 0 else 0.0 for i in range(36))
"""Covariance of the true pose or twist, row by row."""


def pose_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a geometry_msgs/msg/PoseStamped from position_data."""
    return lambda t_ns, values: {
        "header": header(t_ns, ROS_MAP_FRAME),
        "pose": _pose_message(values),
    }


def twist_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a geometry_msgs/msg/TwistStamped from velocity_data, in world axes."""
    return lambda t_ns, values: {
        "header": header(t_ns, ROS_MAP_FRAME),
        "twist": {
            "linear": {"x": values["v_x"], "y": values["v_y"], "z": values["v_z"]},
            "angular": {"x": values["w_x"], "y": values["w_y"], "z": values["w_z"]},
        },
    }


def odometry(
    t_ns: int,
    position: Mapping[str, FieldValue],
    velocity: Mapping[str, FieldValue],
    body: str = ROS_BODY_FRAME,
) -> dict[str, Any]:
    """Return a nav_msgs/msg/Odometry of the true motion, with velocities in body axes.

    Args:
        t_ns: simulated time [ns].
        position: fields of position_data.
        velocity: fields of velocity_data at the same time.
        body: name of the body's frame.
    """
    placed = _pose_message(position)
    turn = placed["orientation"]
    linear = _in_body(turn, [velocity[name] for name in ("v_x", "v_y", "v_z")])
    angular = _in_body(turn, [velocity[name] for name in ("w_x", "w_y", "w_z")])
    return {
        "header": header(t_ns, ROS_ODOM_FRAME),
        "child_frame_id": body,
        "pose": {"pose": placed, "covariance": EXACT_POSE_COVARIANCE},
        "twist": {
            "twist": {"linear": linear, "angular": angular},
            "covariance": EXACT_POSE_COVARIANCE,
        },
    }


def estimated_odometry_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a nav_msgs/msg/Odometry from estimate.

    Covariances have only a diagonal: of position and orientation in world axes, of velocity in body
    axes. They are zero for the angular velocity, and if the estimator states none.
    """
    body = str(topic.about.get("frame", ROS_BODY_FRAME))

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        made = odometry(t_ns, values, values, body)
        for part in ("pose", "twist"):
            made[part]["covariance"] = UNKNOWN_POSE_COVARIANCE
        turn = made["pose"]["pose"]["orientation"]
        place, attitude, velocity = (
            [values[f"sigma_{name}"] ** 2 for name in names]
            for names in (("x", "y", "z"), ("roll", "pitch", "yaw"), ("v_x", "v_y", "v_z"))
        )
        if all(map(math.isfinite, (*place, *attitude, *velocity))):
            back = {**turn, "w": -turn["w"]}
            made["pose"]["covariance"] = _diagonal([*place, *_body_variances(back, attitude)])
            made["twist"]["covariance"] = _diagonal(
                [*_body_variances(turn, velocity), 0.0, 0.0, 0.0]
            )
        return made

    return make


def _diagonal(variances: list[float]) -> tuple[float, ...]:
    """Return a covariance (36), row by row, from its diagonal (6)."""
    return tuple(variances[i // 6] if i % 7 == 0 else 0.0 for i in range(36))


def _body_variances(turn: Mapping[str, float], variances: list[float]) -> list[float]:
    """Return the variances along body axes for variances along world axes."""
    columns = [_in_body(turn, [float(i == j) for i in range(3)]) for j in range(3)]
    return [
        sum(
            column[axis] ** 2 * variance
            for column, variance in zip(columns, variances, strict=True)
        )
        for axis in "xyz"
    ]


def _pose_message(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a geometry_msgs/msg/Pose from the fields of position_data."""
    roll, pitch, yaw = 0.5 * values["roll"], 0.5 * values["pitch"], 0.5 * values["yaw"]
    c_r, c_p, c_y = math.cos(roll), math.cos(pitch), math.cos(yaw)
    s_r, s_p, s_y = math.sin(roll), math.sin(pitch), math.sin(yaw)
    return {
        "position": {"x": values["x"], "y": values["y"], "z": values["z"]},
        "orientation": {
            "x": s_r * c_p * c_y - c_r * s_p * s_y,
            "y": c_r * s_p * c_y + s_r * c_p * s_y,
            "z": c_r * c_p * s_y - s_r * s_p * c_y,
            "w": c_r * c_p * c_y + s_r * s_p * s_y,
        },
    }


def _in_body(turn: Mapping[str, float], parts: list[Any]) -> Mapping[str, float]:
    """Return a vector in body axes, given in world axes and the orientation of the body."""
    w, x, y, z = turn["w"], -turn["x"], -turn["y"], -turn["z"]
    a, b, c = parts
    t_x, t_y, t_z = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return {
        "x": a + w * t_x + y * t_z - z * t_y,
        "y": b + w * t_y + z * t_x - x * t_z,
        "z": c + w * t_z + x * t_y - y * t_x,
    }


UNKNOWN_VECTOR_COVARIANCE = (0.0,) * 9
"""Unknown covariance of a vector."""
EXACT_VECTOR_COVARIANCE = tuple(EXACT_VARIANCE if i % 4 == 0 else 0.0 for i in range(9))
"""Covariance of an exact vector or orientation, row by row."""
EXACT_FIELD_VARIANCE_T2 = 1e-18
"""Variance of an exact magnetic field, that of a nanotesla [T²]."""
NAVSAT_STATUS_FIX = 0
NAVSAT_SERVICE_GPS = 1
COVARIANCE_TYPE_UNKNOWN = 0
COVARIANCE_TYPE_DIAGONAL_KNOWN = 2
POINT_FIELD_FLOAT32 = 7
"""Constants of sensor_msgs: NavSatStatus.STATUS_FIX and SERVICE_GPS, NavSatFix, PointField."""
COULOMBS_PER_AMPERE_HOUR = 3600.0
POWER_SUPPLY_STATUS_DISCHARGING = 2
POWER_SUPPLY_TECHNOLOGY_LIPO = 3
"""Constants of sensor_msgs/msg/BatteryState."""
CLOUD_POINT_BYTES = 12


def sensor_header_maker(topic: Topic) -> Callable[[Mapping[str, Any]], Mapping[str, Any]]:
    """Return the maker of the header of a sample: its time, and the frame of the sensor."""
    frame = str(topic.about.get("frame", ROS_BODY_FRAME))
    return lambda values: header(int(values["stamp"]), frame)


def vector_covariance(topic: Topic, first: int, exact: float = EXACT_VARIANCE) -> tuple[float, ...]:
    """Return the covariance of three values of a sensor's samples (9), row by row.

    It is that of white noise, as in Gazebo: biases and drift are not in it.

    Args:
        topic: of the sensor; an older server does not state its deviations.
        first: place of the first value among those with deviations.
        exact: variance of values without noise.
    """
    stated: Any = topic.about.get("deviations", ())
    deviations = [float(each) for each in stated[first : first + 3]]
    if len(deviations) < 3:
        return UNKNOWN_VECTOR_COVARIANCE
    variances = [max(each * each, exact) for each in deviations]
    return tuple(variances[i // 4] if i % 4 == 0 else 0.0 for i in range(9))


def imu_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a sensor_msgs/msg/Imu; its orientation is the true one."""
    head = sensor_header_maker(topic)
    force, turn = vector_covariance(topic, 0), vector_covariance(topic, 3)
    return lambda t_ns, values: {
        "header": head(values),
        "orientation": quaternion_message(values["q_WS"]),
        "orientation_covariance": EXACT_VECTOR_COVARIANCE,
        "angular_velocity": vector_message(values["angular_velocity"]),
        "angular_velocity_covariance": turn,
        "linear_acceleration": vector_message(values["specific_force"]),
        "linear_acceleration_covariance": force,
    }


def fix_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a sensor_msgs/msg/NavSatFix, in degrees."""
    head, covariance = sensor_header_maker(topic), vector_covariance(topic, 0)
    known = COVARIANCE_TYPE_DIAGONAL_KNOWN if any(covariance) else COVARIANCE_TYPE_UNKNOWN
    return lambda t_ns, values: {
        "header": head(values),
        "status": {"status": NAVSAT_STATUS_FIX, "service": NAVSAT_SERVICE_GPS},
        "latitude": math.degrees(values["latitude"]),
        "longitude": math.degrees(values["longitude"]),
        "altitude": values["altitude"],
        "position_covariance": covariance,
        "position_covariance_type": known,
    }


def fix_velocity_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a geometry_msgs/msg/TwistStamped from a GPS velocity: east, north, up."""
    nothing = {"x": 0.0, "y": 0.0, "z": 0.0}
    return lambda t_ns, values: {
        "header": header(values["stamp"], ROS_MAP_FRAME),
        "twist": {"linear": vector_message(values["velocity"]), "angular": nothing},
    }


def magnetic_field_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a sensor_msgs/msg/MagneticField."""
    head = sensor_header_maker(topic)
    covariance = vector_covariance(topic, 0, EXACT_FIELD_VARIANCE_T2)
    return lambda t_ns, values: {
        "header": head(values),
        "magnetic_field": vector_message(values["magnetic_field"]),
        "magnetic_field_covariance": covariance,
    }


def battery_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a sensor_msgs/msg/BatteryState; what is not known is NaN."""
    unknown = math.nan
    return lambda t_ns, values: {
        "header": header(t_ns, ROS_BODY_FRAME),
        "voltage": values["voltage"],
        "temperature": unknown,
        "current": -values["current"],  # negative while discharging
        "charge": values["charge"] * values["capacity"] / COULOMBS_PER_AMPERE_HOUR,
        "capacity": values["capacity"] / COULOMBS_PER_AMPERE_HOUR,
        "design_capacity": values["capacity"] / COULOMBS_PER_AMPERE_HOUR,
        "percentage": values["charge"],
        "power_supply_status": POWER_SUPPLY_STATUS_DISCHARGING,
        "power_supply_health": 0,
        "power_supply_technology": POWER_SUPPLY_TECHNOLOGY_LIPO,
        "present": True,
        "cell_voltage": (),
        "cell_temperature": (),
        "location": "",
        "serial_number": "",
    }


def joint_state_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a sensor_msgs/msg/JointState; what the topic does not have is empty."""
    names = topic.about["joints"]
    empty = {"position": (), "velocity": (), "effort": ()}

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        return {"header": header(t_ns, ""), "name": names} | empty | _arrays(topic, values)

    return make


def named_numbers_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a message of ours with numbers of the parts that the topic names."""
    names = {key: topic.about[key] for key in PART_NAMES if key in topic.about}

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        return {"header": header(t_ns, ROS_WORLD_FRAME), **names, **_arrays(topic, values)}

    return make


def _arrays(topic: Topic, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of fields, that of a field with one in a sequence, too."""
    return {
        each.name: values[each.name] if each.count > 1 else (values[each.name],)
        for each in topic.fields
    }


def cloud_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a sensor_msgs/msg/PointCloud2 from the rays that hit something."""
    import numpy as np

    head, directions = sensor_header_maker(topic), scan_directions(topic)
    fields = [
        {"name": name, "offset": 4 * index, "datatype": POINT_FIELD_FLOAT32, "count": 1}
        for index, name in enumerate("xyz")
    ]

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        ranges = np.asarray(values["ranges"], dtype=np.float32)
        seen = np.isfinite(ranges)
        points = ranges[seen, None] * directions[seen]
        return {
            "header": head(values),
            "height": 1,
            "width": len(points),
            "fields": fields,
            "is_bigendian": False,
            "point_step": CLOUD_POINT_BYTES,
            "row_step": CLOUD_POINT_BYTES * len(points),
            "data": points.astype("<f4").tobytes(),
            "is_dense": True,
        }

    return make


def scan_directions(topic: Topic) -> "np.ndarray":
    """Return the unit vectors of the rays of a cloud in sensor axes, (n, 3)."""
    import numpy as np

    def even_angles(name: str) -> np.ndarray:
        about: Any = topic.about[name]
        first, step, count = about
        return first + step * np.arange(count)

    azimuth, elevation = map(even_angles, ("azimuths", "elevations"))
    level = np.cos(elevation)[:, None]
    x, y = level * np.cos(azimuth), level * np.sin(azimuth)
    z = np.broadcast_to(np.sin(elevation)[:, None], x.shape)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)
