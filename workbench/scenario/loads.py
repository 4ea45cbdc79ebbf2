"""The axes of a load: a force along x, y, z of the world, and a torque about an axis of the body.

A drone that is loaded in hover holds its place, so a force moves its position; a torque turns it.
Nothing holds a heading, so of a torque about the yaw axis the answer is a rate.
"""

from dataclasses import dataclass

import numpy as np

from workbench.common.errors import find_row
from workbench.scenario.axes import AXIS_ROWS, Axis
from workbench.scenario.scenario import Push


@dataclass(frozen=True)
class Load:
    """One axis of a load.

    Attributes:
        name: force_x, … or torque_roll, …
        label: in words.
        unit: SI unit of the load.
        response: what it moves, in words.
        response_unit: SI unit of that.
        signal: of the response, in the topics.
        limit: parameter whose range bounds the load.
        amplitude: that the app proposes first, in `unit`.
        force_W: force of a load of one (3) [N].
        torque_B: torque of a load of one (3) [N·m].
    """

    name: str
    label: str
    unit: str
    response: str
    response_unit: str
    signal: str
    limit: str
    amplitude: float
    force_W: tuple[float, float, float] = (0.0, 0.0, 0.0)
    torque_B: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def push(self, size: float, duration: float, p_BoBcm_B: tuple[float, float, float]) -> Push:
        """Return the push of a load.

        Args:
            size: of it [N] or [N·m].
            duration: [s].
            p_BoBcm_B: the centre of mass, where a force acts, so that it turns nothing [m].
        """
        return Push(
            [size * part for part in self.force_W],
            list(p_BoBcm_B),
            duration,
            [size * part for part in self.torque_B],
        )

    @property
    def turns(self) -> bool:
        """Whether it changes the heading."""
        return self.torque_B[2] != 0.0

    def moved(self, q_WB: np.ndarray, p_WB: np.ndarray, w_WB: np.ndarray) -> np.ndarray:
        """Return the response (M) of motions, from its value at the first.

        Args:
            q_WB: attitudes (M, 4), as w, x, y, z.
            p_WB: positions (M, 3) [m].
            w_WB: angular velocities in W (M, 3) [rad/s].
        """
        w, x, y, z = q_WB.T
        values = np.column_stack(
            [
                p_WB,
                np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
                np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0)),
                w_WB[:, 2],
            ]
        )[:, LOAD_ROWS.index(self)]
        return np.asarray(values - values[0])


def _force(axis: Axis) -> Load:
    place = "xyz".index(axis.name)
    x, y, z = (float(place == each) for each in range(3))
    return Load(
        f"force_{axis.name}",
        f"force {axis.label}",
        "N",
        f"position {axis.name}",
        "m",
        f"position_data.{axis.name}",
        f"push_{axis.name}",
        1.0,
        force_W=(x, y, z),
    )


def _torque(name: str, axis: str, response: tuple[str, str, str], amplitude: float) -> Load:
    x, y, z = (float(axis == each) for each in "xyz")
    return Load(
        f"torque_{name}",
        f"torque {name}",
        "N·m",
        *response,
        f"push_torque_{axis}",
        amplitude,
        torque_B=(x, y, z),
    )


LOAD_ROWS = (
    *map(_force, AXIS_ROWS[:3]),
    _torque("roll", "x", ("roll", "rad", "position_data.roll"), 0.1),
    _torque("pitch", "y", ("pitch", "rad", "position_data.pitch"), 0.1),
    _torque("yaw", "z", ("yaw rate", "rad/s", "velocity_data.w_z"), 0.02),
)
LOADS = tuple(row.name for row in LOAD_ROWS)
"""Their names."""
EXCITED: tuple[Axis | Load, ...] = (*AXIS_ROWS, *LOAD_ROWS)
"""All that an excitation moves: setpoints, and loads."""


def find_load(name: str) -> Load:
    """Return the row of a load's name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("load", name, LOAD_ROWS)


def find_excited(name: str) -> Axis | Load:
    """Return the row of a setpoint's axis or of a load.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("axis", name, EXCITED)
