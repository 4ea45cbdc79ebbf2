"""Linear models of the vehicle that flies: Drake's plant with rotors and drag, by AutoDiff."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff
from pydrake.systems.framework import Diagram

from workbench.design.linear.model import LinearModel, Trim, motion, numbered
from workbench.design.linear.seeds import (
    STATE,
    constants,
    gradient,
    reduced,
    state_seeds,
    turn_with_heading,
)
from workbench.diagram.core import full_supply
from workbench.plant.vehicle import Vehicle


class Step(NamedTuple):
    """A vehicle over some time under held commands, in axes that turn with the heading.

    Attributes:
        by: of motion and rotor speeds after it (12 + n), by these before it and the commands (n).
        thrusts_by: of the thrusts at its beginning (n), by the same.
    """

    by: np.ndarray
    thrusts_by: np.ndarray


class VehicleDerivatives:
    """An AutoDiff copy of a vehicle core, with a reused Context.

    Args:
        core: from `make_vehicle_core`.
        vehicle: as known to its law.
    """

    def __init__(self, core: Diagram, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._diagram = core.ToAutoDiffXd()
        self._root = self._diagram.CreateDefaultContext()

    def model(self, trim: Trim, gains: Mapping[str, float]) -> LinearModel:
        """Return the continuous model at a trim, in the axes of the heading.

        Args:
            trim: where.
            gains: parameter values by name, of which those of the air are used.
        """
        n = trim.speeds.size
        self.set_air(gains)
        _, slopes = self.slopes(trim.state, trim.speeds, trim.commands)
        turn_with_heading(slopes, trim.point.yaw_rate, (3, 6, 9))
        shown = np.vstack([np.eye(STATE, STATE + 2 * n), *self._rotors(STATE + 2 * n)])
        return LinearModel(
            A=slopes[:, : STATE + n],
            input_matrix=slopes[:, STATE + n :],
            output_matrix=shown[:, : STATE + n],
            feedthrough=shown[:, STATE + n :],
            period=0.0,
            states=(*motion(), *numbered("speed", n, "rad/s")),
            inputs=numbered("command", n, "rad/s"),
            outputs=(*motion(), *numbered("thrust", n, "N"), *numbered("speed", n, "rad/s")),
            trim=trim,
        )

    def set_air(self, gains: Mapping[str, float]) -> None:
        """Set the live parameters of the vehicle."""
        self._set("body_forces", 0, [gains["drag_area"], gains["air_density"]])
        if self._vehicle.battery:
            self._set("supply", 0, full_supply(self._vehicle, gains))

    def slopes(
        self, state: np.ndarray, speeds: np.ndarray, commands: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return how fast motion and speeds change (12 + n), and its derivatives (12 + n, 12 + 2n).

        Args:
            state: of the body (13).
            speeds: of the rotors (n) [rad/s].
            commands: of the rotors (n) [rad/s].
        """
        n = speeds.size
        seeds = np.eye(STATE + 2 * n)
        self._set_state([state, speeds], state[:4], seeds[: STATE + n])
        self._fix("commands", commands, 0, seeds[STATE + n :])
        return self._slopes(state[:4], len(seeds))

    def step(
        self,
        state: np.ndarray,
        speeds: np.ndarray,
        commands: np.ndarray,
        yaw_rate: float,
        duration: float,
    ) -> Step:
        """Return the exact linear model over a time under held commands.

        Args:
            state: of the body in a trimmed flight (13).
            speeds: of the rotors (n) [rad/s].
            commands: of the rotors (n) [rad/s].
            yaw_rate: of the heading [rad/s].
            duration: [s].
        """
        _, slopes = self.slopes(state, speeds, commands)
        thrusts_by, _ = self._rotors(slopes.shape[1])
        turn_with_heading(slopes, yaw_rate, (3, 6, 9))
        # [A B; 0 0] holds the commands
        whole = np.vstack([slopes, np.zeros((speeds.size, slopes.shape[1]))])
        return Step(exponential(whole * duration)[: len(slopes)], thrusts_by)

    def _set(self, system: str, index: int, values: Sequence[float]) -> None:
        """Set a numeric parameter of a system."""
        context = self._diagram.GetSubsystemByName(system).GetMyMutableContextFromRoot(self._root)
        context.get_mutable_numeric_parameter(index).SetFromVector(constants(values).ravel())

    def _set_state(self, values: Sequence[np.ndarray], q_WB: np.ndarray, seeds: np.ndarray) -> None:
        """Set the state, the body's (13) first, with derivatives by the reduced state."""
        rows = np.vstack([state_seeds(q_WB) @ seeds[:STATE], seeds[STATE:]])
        self._root.SetContinuousState(InitializeAutoDiff(np.concatenate(values), rows))

    def _fix(self, port: str, values: np.ndarray, start: int, seeds: np.ndarray) -> None:
        """Fix an input port to values, of which some have derivatives."""
        rows = np.zeros((values.size, seeds.shape[1]))
        rows[start : start + seeds.shape[0]] = seeds
        self._diagram.GetInputPort(port).FixValue(self._root, InitializeAutoDiff(values, rows))

    def _slopes(self, q_WB: np.ndarray, columns: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the time derivatives of the reduced state, and their derivatives."""
        slopes = self._diagram.EvalTimeDerivatives(self._root).CopyToVector()
        values, found = ExtractValue(slopes).ravel(), gradient(slopes, columns)
        small = reduced(q_WB)
        return (
            np.concatenate([small @ values[:13], values[13:]]),
            np.vstack([small @ found[:13], found[13:]]),
        )

    def _rotors(self, columns: int) -> list[np.ndarray]:
        """Return the derivatives of thrusts and speeds."""
        ports = (self._diagram.GetOutputPort(name) for name in ("thrusts", "speeds"))
        return [gradient(port.Eval(self._root), columns) for port in ports]


def exponential(A: np.ndarray) -> np.ndarray:
    """Return the exponential of a matrix, by its series for a part of it that is small, squared.

    scipy has one, too, and takes as long to load as a linear model and its margins take.
    """
    halvings = max(0, int(np.ceil(np.log2(max(np.abs(A).sum(axis=0).max(), 1e-300)))) + 2)
    part = A / 2.0**halvings
    term = found = np.eye(len(A))
    for number in range(1, 13):  # a norm of a quarter to the 13th over 13! is below rounding
        term = term @ part / number
        found = found + term
    for _ in range(halvings):
        found = found @ found
    return found
