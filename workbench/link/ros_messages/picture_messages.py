"""Make ROS 2 messages of a camera's pictures: sensor_msgs/Image, and the CameraInfo beside it."""

from collections.abc import Mapping
from typing import Any

from workbench.link.picture import PIXEL_BYTES
from workbench.link.ros_messages.making import MessageMaker, sensor_header_maker
from workbench.link.topics import Topic

PINHOLE_DISTORTION_MODEL = "plumb_bob"
"""The model whose coefficients are all zero for a pinhole (sensor_msgs/distortion_models)."""
NO_DISTORTION = (0.0,) * 5
NO_ROTATION = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def image_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a sensor_msgs/msg/Image."""
    import numpy as np  # slow to load, and only pictures and clouds need it

    about: Mapping[str, Any] = topic.about
    head = sensor_header_maker(topic)
    width, height, encoding = int(about["width"]), int(about["height"]), str(about["encoding"])
    step = width * PIXEL_BYTES[encoding]

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        return {
            "header": head(values),
            "height": height,
            "width": width,
            "encoding": encoding,
            "is_bigendian": 0,
            "step": step,
            "data": np.asarray(values["pixels"], "<u4").tobytes()[: height * step],
        }

    return make


def camera_info_maker(topic: Topic) -> MessageMaker:
    """Return the maker of a sensor_msgs/msg/CameraInfo of a pinhole without distortion."""
    about: Mapping[str, Any] = topic.about
    head = sensor_header_maker(topic)
    fx, fy, cx, cy = (float(about[name]) for name in ("fx", "fy", "cx", "cy"))
    fixed = {
        "height": int(about["height"]),
        "width": int(about["width"]),
        "distortion_model": PINHOLE_DISTORTION_MODEL,
        "d": NO_DISTORTION,
        "k": (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0),
        "r": NO_ROTATION,
        "p": (fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0),
        "binning_x": 0,
        "binning_y": 0,
        "roi": {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False},
    }
    return lambda t_ns, values: {"header": head(values), **fixed}
