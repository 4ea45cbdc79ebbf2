"""Make ROS 2 messages of motion and sensors, mostly standard ones, from fields of the link."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.link.topics import Topic, Value

WORLD = "world"
"""Name of the root frame: x east, y north, z up."""
BODY = "base_link"
Make = Callable[[int, Mapping[str, Any]], Mapping[str, Any]]
"""Makes a message from the time [ns] and the fields of a topic by name."""


@lru_cache(maxsize=32)
def header(t_ns: int, frame: str) -> Mapping[str, Any]:
    """Return a std_msgs/msg/Header for a time [ns] and a frame, cached for other messages."""
    seconds, rest = divmod(t_ns, 1_000_000_000)
    return {"stamp": {"sec": seconds, "nanosec": rest}, "frame_id": frame}


def vector(parts: Sequence[float]) -> Mapping[str, float]:
    """Return a geometry_msgs/msg/Vector3 or Point."""
    x, y, z = parts
    return {"x": x, "y": y, "z": z}


def quaternion(parts: Sequence[float]) -> Mapping[str, float]:
    """Return a geometry_msgs/msg/Quaternion for w, x, y, z."""
    w, x, y, z = parts
    return {"x": x, "y": y, "z": z, "w": w}


UNKNOWN = (0.0,) * 36
"""Unknown covariance of a pose or twist."""


def pose(topic: Topic) -> Make:
    """Return the maker of a geometry_msgs/msg/PoseStamped from position_data."""
    return lambda t_ns, values: {"header": header(t_ns, WORLD), "pose": _pose(values)}


def twist(topic: Topic) -> Make:
    """Return the maker of a geometry_msgs/msg/TwistStamped from velocity_data, in world axes."""
    return lambda t_ns, values: {
        "header": header(t_ns, WORLD),
        "twist": {
            "linear": {"x": values["v_x"], "y": values["v_y"], "z": values["v_z"]},
            "angular": {"x": values["w_x"], "y": values["w_y"], "z": values["w_z"]},
        },
    }


def odometry(
    t_ns: int, position: Mapping[str, Value], velocity: Mapping[str, Value], body: str = BODY
) -> dict[str, Any]:
    """Return a nav_msgs/msg/Odometry, with velocities in body axes.

    Args:
        t_ns: simulated time [ns].
        position: fields of position_data.
        velocity: fields of velocity_data at the same time.
        body: name of the body's frame.
    """
    placed = _pose(position)
    turn = placed["orientation"]
    linear = _in_body(turn, [velocity[name] for name in ("v_x", "v_y", "v_z")])
    angular = _in_body(turn, [velocity[name] for name in ("w_x", "w_y", "w_z")])
    return {
        "header": header(t_ns, WORLD),
        "child_frame_id": body,
        "pose": {"pose": placed, "covariance": UNKNOWN},
        "twist": {"twist": {"linear": linear, "angular": angular}, "covariance": UNKNOWN},
    }


def estimated_odometry(topic: Topic) -> Make:
    """Return the maker of a nav_msgs/msg/Odometry from estimate.

    Covariances have only a diagonal: of position and orientation in world axes, of velocity in body
    axes. They are zero for the angular velocity, and if the estimator states none.
    """
    body = str(topic.about.get("frame", BODY))

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        made = odometry(t_ns, values, values, body)
        turn = made["pose"]["pose"]["orientation"]
        place, attitude, velocity = (
            [values[f"sigma_{name}"] ** 2 for name in names]
            for names in (("x", "y", "z"), ("roll", "pitch", "yaw"), ("v_x", "v_y", "v_z"))
        )
        if all(map(math.isfinite, (*place, *attitude, *velocity))):
            back = {**turn, "w": -turn["w"]}
            made["pose"]["covariance"] = _diagonal([*place, *_turned(back, attitude)])
            made["twist"]["covariance"] = _diagonal([*_turned(turn, velocity), 0.0, 0.0, 0.0])
        return made

    return make


def _diagonal(variances: list[float]) -> tuple[float, ...]:
    """Return a covariance (36), row by row, from its diagonal (6)."""
    return tuple(variances[i // 6] if i % 7 == 0 else 0.0 for i in range(36))


def _turned(turn: Mapping[str, float], variances: list[float]) -> list[float]:
    """Return the variances along body axes for variances along world axes."""
    columns = [_in_body(turn, [float(i == j) for i in range(3)]) for j in range(3)]
    return [
        sum(
            column[axis] ** 2 * variance
            for column, variance in zip(columns, variances, strict=True)
        )
        for axis in "xyz"
    ]


def transforms(topic: Topic) -> Make:
    """Return the maker of a tf2_msgs/msg/TFMessage from the topic frames."""
    pairs: Any = topic.about["frames"]

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        poses = values["poses"]
        made = [
            {
                "header": header(t_ns, parent),
                "child_frame_id": child,
                "transform": {
                    "translation": vector(poses[7 * index : 7 * index + 3]),
                    "rotation": quaternion(poses[7 * index + 3 : 7 * index + 7]),
                },
            }
            for index, (parent, child) in enumerate(pairs)
        ]
        return {"transforms": made}

    return make


def _pose(values: Mapping[str, Any]) -> dict[str, Any]:
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


UNKNOWN_OF_VECTOR = (0.0,) * 9
"""Unknown covariance of a vector."""
FIX = 0
GPS = 1
FLOAT32 = 7
"""Constants of sensor_msgs: NavSatStatus.STATUS_FIX and SERVICE_GPS, PointField.FLOAT32."""
POINT_SIZE = 12


def sensor_header(topic: Topic) -> Callable[[Mapping[str, Any]], Mapping[str, Any]]:
    """Return the maker of the header of a sample: its time, and the frame of the sensor."""
    frame = str(topic.about.get("frame", BODY))
    return lambda values: header(int(values["stamp"]), frame)


def imu(topic: Topic) -> Make:
    """Return the maker of a sensor_msgs/msg/Imu."""
    head = sensor_header(topic)
    return lambda t_ns, values: {
        "header": head(values),
        "orientation": quaternion(values["q_WS"]),
        "orientation_covariance": UNKNOWN_OF_VECTOR,
        "angular_velocity": vector(values["angular_velocity"]),
        "angular_velocity_covariance": UNKNOWN_OF_VECTOR,
        "linear_acceleration": vector(values["specific_force"]),
        "linear_acceleration_covariance": UNKNOWN_OF_VECTOR,
    }


def fix(topic: Topic) -> Make:
    """Return the maker of a sensor_msgs/msg/NavSatFix, in degrees."""
    head = sensor_header(topic)
    return lambda t_ns, values: {
        "header": head(values),
        "status": {"status": FIX, "service": GPS},
        "latitude": math.degrees(values["latitude"]),
        "longitude": math.degrees(values["longitude"]),
        "altitude": values["altitude"],
        "position_covariance": UNKNOWN_OF_VECTOR,
        "position_covariance_type": 0,
    }


def fix_velocity(topic: Topic) -> Make:
    """Return the maker of a geometry_msgs/msg/TwistStamped from a GPS velocity: east, north, up."""
    nothing = {"x": 0.0, "y": 0.0, "z": 0.0}
    return lambda t_ns, values: {
        "header": header(values["stamp"], WORLD),
        "twist": {"linear": vector(values["velocity"]), "angular": nothing},
    }


def magnetic_field(topic: Topic) -> Make:
    """Return the maker of a sensor_msgs/msg/MagneticField."""
    head = sensor_header(topic)
    return lambda t_ns, values: {
        "header": head(values),
        "magnetic_field": vector(values["magnetic_field"]),
        "magnetic_field_covariance": UNKNOWN_OF_VECTOR,
    }


def cloud(topic: Topic) -> Make:
    """Return the maker of a sensor_msgs/msg/PointCloud2 from the rays that hit something."""
    head, directions = sensor_header(topic), scan_directions(topic)
    fields = [
        {"name": name, "offset": 4 * index, "datatype": FLOAT32, "count": 1}
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
            "point_step": POINT_SIZE,
            "row_step": POINT_SIZE * len(points),
            "data": points.astype("<f4").tobytes(),
            "is_dense": True,
        }

    return make


def scan_directions(topic: Topic) -> np.ndarray:
    """Return the unit vectors of the rays of a cloud in sensor axes, (n, 3)."""
    azimuth, elevation = (_angles(topic.about[name]) for name in ("azimuths", "elevations"))
    level = np.cos(elevation)[:, None]
    x, y = level * np.cos(azimuth), level * np.sin(azimuth)
    z = np.broadcast_to(np.sin(elevation)[:, None], x.shape)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)


def _angles(said: Any) -> np.ndarray:
    """Return evenly spaced angles from the first one, step and count [rad]."""
    first, step, count = said
    return first + step * np.arange(count)
