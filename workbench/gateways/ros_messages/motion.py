"""Where the drone is and how it moves, in the standard messages."""

import math
from collections.abc import Callable, Mapping
from typing import Any

from workbench.gateways.ros_messages.stamps import BODY, WORLD, header, quaternion, vector
from workbench.link.topics import Topic, Value

Make = Callable[[int, Mapping[str, Any]], dict[str, Any]]
"""Makes a message of the time [ns] and a topic's fields by name."""
UNKNOWN = (0.0,) * 36
"""Covariance of a pose or twist that nobody knows."""


def pose(topic: Topic) -> Make:
    """Return what makes a geometry_msgs/msg/PoseStamped of position_data."""
    return lambda t_ns, values: {"header": header(t_ns, WORLD), "pose": _pose(values)}


def twist(topic: Topic) -> Make:
    """Return what makes a geometry_msgs/msg/TwistStamped of velocity_data, in the world's axes."""
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
    """Return a nav_msgs/msg/Odometry, whose velocities are in the body's axes.

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
    """Return what makes a nav_msgs/msg/Odometry of estimate.

    Covariances have their diagonal alone: of place and turn in the world's axes, of velocity in the
    body's; zeros where the estimator knows none, and of the turning rate.
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
    """Return a covariance (36), row by row, of its diagonal (6)."""
    return tuple(variances[i // 6] if i % 7 == 0 else 0.0 for i in range(36))


def _turned(turn: Mapping[str, float], variances: list[float]) -> list[float]:
    """Return variances along the world's axes as those along the axes of the body."""
    columns = [_in_body(turn, [float(i == j) for i in range(3)]) for j in range(3)]
    return [
        sum(
            column[axis] ** 2 * variance
            for column, variance in zip(columns, variances, strict=True)
        )
        for axis in "xyz"
    ]


def transforms(topic: Topic) -> Make:
    """Return what makes a tf2_msgs/msg/TFMessage of the topic frames."""
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
    """Return a geometry_msgs/msg/Pose of the fields of position_data."""
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
    """Return a vector of the world's axes in the axes of the body, which `turn` brings there."""
    w, x, y, z = turn["w"], -turn["x"], -turn["y"], -turn["z"]
    a, b, c = parts
    t_x, t_y, t_z = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return {
        "x": a + w * t_x + y * t_z - z * t_y,
        "y": b + w * t_y + z * t_x - x * t_z,
        "z": c + w * t_z + x * t_y - y * t_x,
    }
