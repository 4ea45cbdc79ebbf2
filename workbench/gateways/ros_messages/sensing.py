"""What sensors measure, in the standard messages."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from workbench.gateways.ros_messages.stamps import BODY, WORLD, header, quaternion, vector
from workbench.link.topics import Topic

Make = Callable[[int, Mapping[str, Any]], dict[str, Any]]
"""Makes a message of the time [ns] and a topic's fields by name."""
UNKNOWN = (0.0,) * 9
"""A covariance that nobody knows."""
FIX = 0
GPS = 1
FLOAT32 = 7
"""Constants of sensor_msgs: NavSatStatus.STATUS_FIX and SERVICE_GPS, PointField.FLOAT32."""
POINT_SIZE = 12


def sensor_header(topic: Topic) -> Callable[[Mapping[str, Any]], Mapping[str, Any]]:
    """Return what makes a sample's header: when it was taken, and the sensor's frame."""
    frame = str(topic.about.get("frame", BODY))
    return lambda values: header(int(values["stamp"]), frame)


def imu(topic: Topic) -> Make:
    """Return what makes a sensor_msgs/msg/Imu."""
    head = sensor_header(topic)
    return lambda t_ns, values: {
        "header": head(values),
        "orientation": quaternion(values["q_WS"]),
        "orientation_covariance": UNKNOWN,
        "angular_velocity": vector(values["angular_velocity"]),
        "angular_velocity_covariance": UNKNOWN,
        "linear_acceleration": vector(values["specific_force"]),
        "linear_acceleration_covariance": UNKNOWN,
    }


def fix(topic: Topic) -> Make:
    """Return what makes a sensor_msgs/msg/NavSatFix, which is in degrees."""
    head = sensor_header(topic)
    return lambda t_ns, values: {
        "header": head(values),
        "status": {"status": FIX, "service": GPS},
        "latitude": math.degrees(values["latitude"]),
        "longitude": math.degrees(values["longitude"]),
        "altitude": values["altitude"],
        "position_covariance": UNKNOWN,
        "position_covariance_type": 0,
    }


def fix_velocity(topic: Topic) -> Make:
    """Return what makes a geometry_msgs/msg/TwistStamped of a fix: east, north, up."""
    nothing = {"x": 0.0, "y": 0.0, "z": 0.0}
    return lambda t_ns, values: {
        "header": header(values["stamp"], WORLD),
        "twist": {"linear": vector(values["velocity"]), "angular": nothing},
    }


def magnetic_field(topic: Topic) -> Make:
    """Return what makes a sensor_msgs/msg/MagneticField."""
    head = sensor_header(topic)
    return lambda t_ns, values: {
        "header": head(values),
        "magnetic_field": vector(values["magnetic_field"]),
        "magnetic_field_covariance": UNKNOWN,
    }


def cloud(topic: Topic) -> Make:
    """Return what makes a sensor_msgs/msg/PointCloud2 of the rays that met something."""
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
    """Return the unit vectors of a cloud's rays in the sensor's axes, (n, 3)."""
    azimuth, elevation = (_angles(topic.about[name]) for name in ("azimuths", "elevations"))
    level = np.cos(elevation)[:, None]
    x, y = level * np.cos(azimuth), level * np.sin(azimuth)
    z = np.broadcast_to(np.sin(elevation)[:, None], x.shape)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32)


def _angles(said: Any) -> np.ndarray:
    """Return evenly spaced angles of their first, step and count [rad]."""
    first, step, count = said
    return first + step * np.arange(count)
