"""Trajectories of joints that ROS 2 programs send, and the setpoints of servos along them.

Source: trajectory_msgs/JointTrajectory, and its meaning in ros2_control's joint trajectory
controller: points are at times from the start, and setpoints change linearly between them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.parameter import (
    SERVO_PREFIX,
    SERVO_UNITS,
    is_servo_parameter,
    servo_parameter_name,
)
from workbench.link.hello import ParameterRow

MAX_STAMP_LEAD_S = 60.0
"""Largest time between now and the stamp of a trajectory [s]; a larger one is of another clock."""
MAX_TRAJECTORY_NUMBERS = 100_000
"""Largest number of points times joints."""
_SETPOINTS_BY_KIND = {"position": "positions", "velocity": "velocities", "effort": "effort"}
"""Field of a point with the setpoint of a servo, by its kind."""
_SETPOINTS_BY_UNIT = {
    unit: _SETPOINTS_BY_KIND[kind] for kind, units in SERVO_UNITS.items() for unit in units
}
"""Field of a point with the setpoint of a servo, by the unit of its parameter."""


@dataclass(frozen=True)
class TrajectoryOrder:
    """A trajectory as it was sent; no points end the one that is on its way.

    Attributes:
        joints: their names.
        points: each a trajectory_msgs/msg/JointTrajectoryPoint.
        start: simulated time of its start [s], 0 for now.
    """

    joints: tuple[str, ...]
    points: tuple[Any, ...]
    start: float


@dataclass(frozen=True)
class ServoTrajectory:
    """Setpoints of servos over time.

    Attributes:
        names: of the servos' parameters.
        times: simulated, of each point [s]; they increase.
        setpoints: one row for each point, in SI units (points, names).
    """

    names: tuple[str, ...]
    times: np.ndarray
    setpoints: np.ndarray

    def at(self, time: float) -> dict[str, float]:
        """Return the setpoint of each servo at a time [s], by its parameter."""
        columns = zip(self.names, self.setpoints.T, strict=True)
        return {name: float(np.interp(time, self.times, column)) for name, column in columns}


def trajectory_order(message: Any) -> TrajectoryOrder:
    """Return the order in a trajectory_msgs/msg/JointTrajectory from DDS."""
    joints = tuple(map(str, message.joint_names))
    return TrajectoryOrder(joints, tuple(message.points), _seconds(message.header.stamp))


def servo_trajectory(
    order: TrajectoryOrder,
    rows: Sequence[ParameterRow],
    present: Mapping[str, float],
    now: float,
) -> ServoTrajectory:
    """Return the setpoints along a trajectory that has points.

    Args:
        order: what was sent.
        rows: the live parameters of the flight.
        present: their values, where the setpoints begin.
        now: simulated time [s].

    Raises:
        WorkbenchError: if a joint has no servo, or the points are not those of a trajectory.
    """
    known = {row.name: row for row in rows if is_servo_parameter(row.name)}
    servos = [_servo_row(joint, known) for joint in order.joints]
    if not servos or len({row.name for row in servos}) < len(servos):
        raise WorkbenchError("a trajectory names each of its joints once")
    if len(order.points) * len(servos) > MAX_TRAJECTORY_NUMBERS:
        raise WorkbenchError(f"a trajectory has at most {MAX_TRAJECTORY_NUMBERS} setpoints")
    start = order.start or now
    if abs(start - now) > MAX_STAMP_LEAD_S:
        raise WorkbenchError(
            f"the trajectory starts at {start:.0f} s by its stamp, and the flight is at {now:.0f} "
            "s: leave the stamp zero, or let the node use_sim_time"
        )
    times = [start + _seconds(point.time_from_start) for point in order.points]
    table = [
        [_setpoint(point, index, row) for index, row in enumerate(servos)] for point in order.points
    ]
    if times[0] > start:  # from where the servos are
        times.insert(0, start)
        table.insert(0, [present[row.name] for row in servos])
    if any(later <= earlier for earlier, later in zip(times, times[1:], strict=False)):
        raise WorkbenchError("time_from_start has to increase from each point to the next")
    if not np.isfinite(table).all():
        raise WorkbenchError("a point has a setpoint that is not finite")
    return ServoTrajectory(tuple(row.name for row in servos), np.array(times), np.array(table))


def _servo_row(joint: str, servos: Mapping[str, ParameterRow]) -> ParameterRow:
    """Return the parameter with the setpoint of a joint's servo."""
    row = servos.get(servo_parameter_name(joint))
    if row is None:
        known = ", ".join(name.removeprefix(SERVO_PREFIX) for name in servos)
        raise WorkbenchError(
            f"no servo can be commanded at a joint {joint[:40]!r}: "
            + (f"name {known}" if known else "this drone has none, or its control law has them")
        )
    return row


def _setpoint(point: Any, index: int, row: ParameterRow) -> float:
    """Return the number of a point that a servo takes."""
    field = _SETPOINTS_BY_UNIT[row.unit]
    values = getattr(point, field)
    if len(values) <= index:
        raise WorkbenchError(
            f"a point has {len(values)} {field}: write one for each joint, for {row.name} in "
            f"{row.unit}"
        )
    return float(values[index])


def _seconds(duration: Any) -> float:
    return float(duration.sec) + 1e-9 * float(duration.nanosec)
