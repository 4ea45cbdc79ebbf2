"""Parts that many messages have: times, headers, vectors, quaternions."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

WORLD = "world"
"""Frame at the root: x east, y north, z up."""
BODY = "base_link"


@lru_cache(maxsize=32)
def header(t_ns: int, frame: str) -> Mapping[str, Any]:
    """Return a std_msgs/msg/Header of a time [ns] and a frame; many messages share one."""
    seconds, rest = divmod(t_ns, 1_000_000_000)
    return {"stamp": {"sec": seconds, "nanosec": rest}, "frame_id": frame}


def vector(parts: Sequence[float]) -> Mapping[str, float]:
    """Return a geometry_msgs/msg/Vector3 or Point."""
    x, y, z = parts
    return {"x": x, "y": y, "z": z}


def quaternion(parts: Sequence[float]) -> Mapping[str, float]:
    """Return a geometry_msgs/msg/Quaternion of w, x, y, z."""
    w, x, y, z = parts
    return {"x": x, "y": y, "z": z, "w": w}
