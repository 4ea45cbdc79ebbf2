"""The axes of a load: a force or a gust along x, y, z of the world, a torque about the body's axes.

A drone under a load in hover holds its position, so the response to a force or a gust is in
position; a torque turns the drone. No controller holds the heading, so the response to a torque
about the yaw axis is a rate.
"""

import math
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import find_named_row
from workbench.scenario.attitude_axes import STEP_AXIS_ROWS, AttitudeAxis, tilt_angles
from workbench.scenario.axes import AXIS_ROWS, CommandAxis
from workbench.scenario.scenario import Action, Gust, Push

LoadVector = tuple[float, float, float]
LOAD_RESPONSES = ("position x", "position y", "position z", "roll", "pitch", "yaw rate")
"""Responses to loads."""


@dataclass(frozen=True)
class Load:
    """One axis of a force, a torque, or a gust, which rises to its size and falls again.

    Attributes:
        name: force_x, torque_roll, gust_x, …
        label: in words.
        unit: SI unit of the load.
        response: name of the response.
        response_unit: SI unit of the response.
        signal: of the response, in the topics.
        limit: name of the parameter with the limits of the load.
        amplitude: that the app proposes first, in `unit`.
        force_W: force of a unit load (3) [N].
        torque_B: torque of a unit load (3) [N·m].
        velocity_W: velocity of a unit gust (3) [m/s].
    """

    name: str
    label: str
    unit: str
    response: str
    response_unit: str
    signal: str
    limit: str
    amplitude: float
    force_W: LoadVector = (0.0, 0.0, 0.0)
    torque_B: LoadVector = (0.0, 0.0, 0.0)
    velocity_W: LoadVector = (0.0, 0.0, 0.0)

    def action(self, size: float, duration: float, p_BoBcm_B: LoadVector) -> Action:
        """Return the action that starts a load in a script; a size of 0 ends it.

        Args:
            size: of the load, in `unit`.
            duration: [s].
            p_BoBcm_B: the centre of mass, where a force acts without a moment [m].
        """
        force, torque, velocity = (
            [size * part for part in unit]
            for unit in (self.force_W, self.torque_B, self.velocity_W)
        )
        if self.is_gust:
            return Action(gust=Gust(velocity, duration) if size else Gust())
        return Action(push=Push(force, list(p_BoBcm_B), duration, torque) if size else Push())

    @property
    def is_gust(self) -> bool:
        """Whether it is air that moves."""
        return any(self.velocity_W)

    @property
    def longest(self) -> float:
        """Default duration [s]; infinite until the end."""
        return Gust().duration if self.is_gust else math.inf

    @property
    def turns(self) -> bool:
        """Whether it changes the heading."""
        return self.torque_B[2] != 0.0

    def moved(self, q_WB: np.ndarray, p_WB: np.ndarray, w_WB: np.ndarray) -> np.ndarray:
        """Return the response (M) in a motion, relative to its first value.

        Args:
            q_WB: attitudes (M, 4), as w, x, y, z.
            p_WB: positions (M, 3) [m].
            w_WB: angular velocities in W (M, 3) [rad/s].
        """
        values = (*p_WB.T, *tilt_angles(q_WB), w_WB[:, 2])[LOAD_RESPONSES.index(self.response)]
        return np.asarray(values - values[0])


def _unit(axis: str) -> LoadVector:
    x, y, z = (float(axis == each) for each in "xyz")
    return x, y, z


def _along(
    axis: CommandAxis, kind: str, unit: str, limit: str, amplitude: float, **vector: LoadVector
) -> Load:
    return Load(
        f"{kind}_{axis.name}",
        f"{kind} {axis.label}",
        unit,
        f"position {axis.name}",
        "m",
        f"position_data.{axis.name}",
        f"{limit}_{axis.name}",
        amplitude,
        **vector,
    )


def _torque(name: str, axis: str, response: tuple[str, str, str], amplitude: float) -> Load:
    return Load(
        f"torque_{name}",
        f"torque {name}",
        "N·m",
        *response,
        f"push_torque_{axis}",
        amplitude,
        torque_B=_unit(axis),
    )


PUSH_ROWS = (
    *(_along(row, "force", "N", "push", 1.0, force_W=_unit(row.name)) for row in AXIS_ROWS[:3]),
    _torque("roll", "x", ("roll", "rad", "position_data.roll"), 0.1),
    _torque("pitch", "y", ("pitch", "rad", "position_data.pitch"), 0.1),
    _torque("yaw", "z", ("yaw rate", "rad/s", "velocity_data.w_z"), 0.02),
)
GUST_ROWS = tuple(
    _along(row, "gust", "m/s", "gust", 5.0, velocity_W=_unit(row.name)) for row in AXIS_ROWS[:3]
)
LOAD_ROWS = (*PUSH_ROWS, *GUST_ROWS)
LOAD_NAMES = tuple(row.name for row in LOAD_ROWS)
"""Names of the loads."""
EXCITED_AXES: tuple[CommandAxis | AttitudeAxis | Load, ...] = (*STEP_AXIS_ROWS, *LOAD_ROWS)
"""Names of all axes of an excitation: setpoints, and loads."""


def find_load(name: str) -> Load:
    """Return the load with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("load", name, LOAD_ROWS)


def find_excited(name: str) -> CommandAxis | AttitudeAxis | Load:
    """Return the axis of a setpoint or the load with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("axis", name, EXCITED_AXES)
