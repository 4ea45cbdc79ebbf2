"""The gimbal of a drone: its axes, its attitude and its setpoints, in MAVLink's angles.

A gimbal has joints with servos of position, about axes of the body; their names or those of their
links have `gimbal` or `camera` in them. MAVLink's angles are forward-right-down: roll to the right,
pitch up, yaw to the right.
"""

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from scipy.spatial.transform import Rotation

from workbench.common.errors import WorkbenchError
from workbench.common.parameter import servo_parameter_name
from workbench.common.vectors import Quaternion
from workbench.link.hello import ParameterRow

GIMBAL_AXIS_NAMES = ("roll", "pitch", "yaw")
_FRD_SIGNS = (1.0, -1.0, -1.0)
"""Signs of x, y and z of the body (forward, left, up) along forward, right and down."""
_GIMBAL_WORDS = ("gimbal", "camera")
_ALIGNED = 1.0 - 1e-6
"""Smallest component of a unit vector along an axis of the body."""
AXIS_LETTERS = "XYZ"
ZERO_ANGLE = 1e-3
"""Largest angle about an axis that a gimbal lacks, for the rounding of a station [rad]."""


@dataclass(frozen=True)
class GimbalAxis:
    """An axis of a gimbal.

    Attributes:
        joint: its name.
        axis: 0 for roll, 1 for pitch, 2 for yaw.
        sign: of MAVLink's angle for a positive angle of the joint.
        row: the parameter with the setpoint of its servo [rad].
    """

    joint: str
    axis: int
    sign: float
    row: ParameterRow

    @property
    def limits(self) -> tuple[float, float]:
        """The smallest and the largest of MAVLink's angles [rad]."""
        low, high = sorted((self.sign * self.row.low, self.sign * self.row.high))
        return low, high


@dataclass(frozen=True)
class Gimbal:
    """The axes of a gimbal, from the body to the camera."""

    axes: tuple[GimbalAxis, ...]

    def find(self, axis: int) -> GimbalAxis | None:
        """Return its axis of roll (0), pitch (1) or yaw (2), None if it has none."""
        return next((each for each in self.axes if each.axis == axis), None)

    def limits(self) -> list[float]:
        """Return lower and upper limit of roll, pitch and yaw [rad]; 0 without the axis."""
        found = [self.find(axis) for axis in range(len(GIMBAL_AXIS_NAMES))]
        return [limit for each in found for limit in (each.limits if each else (0.0, 0.0))]

    def attitude(self, roll: float, pitch: float, joints: Mapping[str, float]) -> Quaternion:
        """Return the attitude of the camera in forward-right-down axes of the drone's heading.

        Args:
            roll: of the body (forward-left-up) in W [rad].
            pitch: of the body in W [rad].
            joints: angles of all joints by name [rad].
        """
        angles = [each.sign * joints[each.joint] for each in self.axes]
        body = Rotation.from_euler("YX", [-pitch, roll])
        turned = body * Rotation.from_euler(self._order, angles)
        x, y, z, w = turned.as_quat().ravel().tolist()  # one axis is a stack in older SciPy
        return w, x, y, z

    def angles_of(self, q: Quaternion) -> dict[int, float]:
        """Return roll (0), pitch (1) and yaw (2) of its axes for an attitude relative to the body.

        An axis that it lacks has the angle that would be left over [rad].
        """
        w, x, y, z = q
        order = self._order + "".join(axis for axis in AXIS_LETTERS if axis not in self._order)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # straight down, the last angle is 0
            angles = Rotation.from_quat([x, y, z, w]).as_euler(order).tolist()
        return {AXIS_LETTERS.index(axis): angle for axis, angle in zip(order, angles, strict=True)}

    @property
    def _order(self) -> str:
        """The axes for scipy: each turns about what those before it have turned."""
        return "".join(AXIS_LETTERS[each.axis] for each in self.axes)

    def setpoints(self, angles: Mapping[int, float]) -> dict[str, float]:
        """Return the setpoints for some of MAVLink's angles.

        Args:
            angles: by axis [rad]; a NaN leaves an axis as it is.

        Raises:
            WorkbenchError: if the gimbal has no such axis, and the angle is not zero.
        """
        setpoints = {}
        for axis, angle in angles.items():
            found = self.find(axis)
            if found is not None and math.isfinite(angle):
                setpoints[found.row.name] = found.sign * angle
            elif found is None and abs(angle) > ZERO_ANGLE:
                there = " and ".join(GIMBAL_AXIS_NAMES[each.axis] for each in self.axes)
                missing = GIMBAL_AXIS_NAMES[axis]
                raise WorkbenchError(
                    f"the gimbal has {there} only: leave out {missing}, or set it to 0"
                )
        return setpoints

    def neutral(self) -> dict[str, float]:
        """Return the setpoints that the servos start with."""
        return {each.row.name: each.row.default for each in self.axes}


def gimbal_of(description: str, rows: Sequence[ParameterRow]) -> Gimbal | None:
    """Return the gimbal of a drone, None if it has none.

    Args:
        description: of the drone as URDF, from the server.
        rows: the live parameters.
    """
    servos = {row.name: row for row in rows if row.unit == "rad"}
    axes: list[tuple[int, GimbalAxis]] = []
    try:
        robot = ElementTree.fromstring(description)
    except ElementTree.ParseError:
        return None
    above = {_link(joint, "child"): joint for joint in robot.iter("joint")}
    for link, joint in above.items():
        name = joint.get("name", "")
        row = servos.get(servo_parameter_name(name))
        if row is None or not any(word in f"{name} {link}".lower() for word in _GIMBAL_WORDS):
            continue
        way = _way_up(joint, above)
        found = None if any(map(_is_turned, way)) else _aligned_axis(joint)
        if found is None or found[0] in (each.axis for _, each in axes):
            return None  # its angles are not those of MAVLink
        axes.append((len(way), GimbalAxis(name, *found, row)))
    axes.sort(key=lambda each: each[0])
    return Gimbal(tuple(axis for _, axis in axes)) if axes else None


def _link(joint: ElementTree.Element, end: str) -> str:
    """Return the link at an end of a joint, `parent` or `child`."""
    found = joint.find(end)
    return "" if found is None else found.get("link", "")


def _way_up(
    joint: ElementTree.Element, above: Mapping[str, ElementTree.Element]
) -> list[ElementTree.Element]:
    """Return a joint and those above it, up to the root."""
    way: list[ElementTree.Element] = []
    now: ElementTree.Element | None = joint
    while now is not None and now not in way:
        way.append(now)
        now = above.get(_link(now, "parent"))
    return way


def _is_turned(joint: ElementTree.Element) -> bool:
    origin = joint.find("origin")
    turned = [] if origin is None else _numbers(origin.get("rpy", ""))
    return any(abs(angle) > 1.0 - _ALIGNED for angle in turned)


def _aligned_axis(joint: ElementTree.Element) -> tuple[int, float] | None:
    """Return the axis of the body that a joint turns about, and the sign of MAVLink's angle."""
    axis = joint.find("axis")
    parts = _numbers("1 0 0" if axis is None else axis.get("xyz", "1 0 0"))
    length = math.hypot(*parts) or 1.0
    for index, part in enumerate(parts):
        if abs(part) / length >= _ALIGNED:
            return index, _FRD_SIGNS[index] * math.copysign(1.0, part)
    return None


def _numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]
