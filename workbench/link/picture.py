"""Pictures of a camera on the wire: few enough pixels that each picture fits into a frame."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from workbench.link.topics import Field
from workbench.link.wire import MAX_PAYLOAD_BYTES

DEPTH_ENCODING = "16UC1"
COLOUR_ENCODING = "rgb8"
"""Encodings of pixels, as in ROS: depth in millimetres (REP-118), and red, green and blue."""
PIXEL_BYTES = {DEPTH_ENCODING: 2, COLOUR_ENCODING: 3}
WORD_BYTES = 4
"""Bytes of a uint32: the wire has no shorter numbers, so each one has several bytes of pixels."""
STAMP_BYTES = 8
MAX_DEPTH_MM = 65_535
"""Largest depth in 16 bits [mm]; 0 means that it is unknown."""


class Pinhole(NamedTuple):
    """Intrinsics; pixel (u, v) is column and row from zero, and its centre is at whole numbers.

    The frame S of the sensor looks along x, with z up, as in SDF. The optical frame C has the same
    origin and looks along z, with x to the right and y down in the picture, as in Drake, ROS and
    OpenCV. A point (x, y, z) in the optical frame is seen at u = cx + fx x / z, v = cy + fy y / z.

    Attributes:
        width: pixels in a row.
        height: rows.
        fx: focal length in columns.
        fy: focal length in rows.
        cx: column of the optical axis.
        cy: row of the optical axis.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    def thinned(self, stride: int) -> "Pinhole":
        """Return the intrinsics of every n-th pixel of every n-th row (n is `stride`)."""
        width, height = math.ceil(self.width / stride), math.ceil(self.height / stride)
        return Pinhole(width, height, *(each / stride for each in self[2:]))


class PictureLayout(NamedTuple):
    """The published pictures of a depth camera.

    Attributes:
        pinhole: intrinsics.
        frame: name of the optical frame.
        has_colour: whether there are pictures of colour beside those of depth.
    """

    pinhole: Pinhole
    frame: str
    has_colour: bool

    def pixels_field(self, encoding: str) -> Field:
        """Return the field with the pixels of a picture."""
        size = self.pinhole.width * self.pinhole.height * PIXEL_BYTES[encoding]
        return Field("pixels", "uint32", "1", "", math.ceil(size / WORD_BYTES))

    def about(self, encoding: str) -> Mapping[str, object]:
        """Return what a client needs to decode the pixels and to use them."""
        return {
            **self.pinhole._asdict(),
            "frame": self.frame,
            "encoding": encoding,
            "order": "row by row; four bytes in each number, the lowest first, padded with zeros",
        }


def picture_stride(width: int, height: int) -> int:
    """Return the n so that every n-th pixel of every n-th row fits into a frame."""
    words = (MAX_PAYLOAD_BYTES - STAMP_BYTES) // WORD_BYTES
    room = words * WORD_BYTES // PIXEL_BYTES[COLOUR_ENCODING]
    stride = 1
    while math.ceil(width / stride) * math.ceil(height / stride) > room:
        stride += 1
    return stride
