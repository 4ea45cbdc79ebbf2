"""The signals of a depth camera's pictures."""

from collections.abc import Sequence

from workbench.link.picture import COLOUR_ENCODING, DEPTH_ENCODING
from workbench.link.ros_messages import picture_messages
from workbench.link.signal import STAMP_FIELD, RosChannel, Signal, TopicOptions
from workbench.link.topics import PREFIX, Field


def _picture_signal(id: int, name: str, title: str, encoding: str, path: str) -> Signal:
    """Return the signal of a camera's pictures; `path` is that of its ROS 2 topics.

    Picture and calibration stand side by side, as `image_transport` expects them.
    """

    def fields(options: TopicOptions) -> Sequence[Field]:
        layout = options.picture
        if layout is None or (encoding == COLOUR_ENCODING and not layout.has_colour):
            return ()
        return (STAMP_FIELD, layout.pixels_field(encoding))

    place = f"{PREFIX}{path}"
    info = picture_messages.camera_info_maker
    return Signal(
        id,
        name,
        title,
        "depth_camera",
        fields,
        others=(
            RosChannel(f"{place}/image_raw", "sensor_msgs/msg/Image", picture_messages.image_maker),
            RosChannel(f"{place}/camera_info", "sensor_msgs/msg/CameraInfo", info),
        ),
        about=lambda options: options.picture.about(encoding) if options.picture else {},
        plotted=False,
    )


DEPTH_IMAGE_SIGNAL = _picture_signal(
    22, "depth_image", "Depth image", DEPTH_ENCODING, "camera/depth"
)
COLOUR_IMAGE_SIGNAL = _picture_signal(23, "colour_image", "Colour image", COLOUR_ENCODING, "camera")
