"""Linear models of the vehicle that flies: Drake's plant with rotors and drag, by AutoDiff."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff
from pydrake.systems.framework import Diagram

from workbench.common.parameter import HOOKS
from workbench.control.controller import Controller
from workbench.design.linear.joint_coordinates import JointCoordinates
from workbench.design.linear.model import (
    LinearModel,
    ModelSignal,
    Trim,
    motion_signals,
    rotor_signals,
)
from workbench.design.linear.resting_joints import resting_positions
from workbench.design.linear.seeds import (
    MOTION_STATE_SIZE,
    autodiff_constants,
    gradient,
    reduced_state_seeds,
    state_seeds,
    turn_with_heading,
)
from workbench.diagram.core import full_supply
from workbench.diagram.forces import (
    CABLES_SYSTEM,
    JOINT_FORCES_SYSTEM,
    body_places,
    joint_places,
)
from workbench.diagram.free_loads import hang_loads
from workbench.plant.payload import Payload
from workbench.plant.vehicle import Vehicle


class HeldCommandStep(NamedTuple):
    """A vehicle over some time under held commands, in axes that turn with the heading.

    Attributes:
        by: of motion, rotor speeds and joints after it (12 + n + 2 j), by these before it and the
            commands (c).
        thrusts_by: of the thrusts at its beginning (n), by the same.
    """

    by: np.ndarray
    thrusts_by: np.ndarray


class VehicleDerivatives:
    """An AutoDiff copy of a vehicle core, with a reused Context.

    Attributes:
        joint_signals: positions and velocities of the joints (2 j).
        commanded_joints: whose servos the law commands.
        measured_joints: places of positions and velocities of the joints of SERVOS among those of
            all joints.

    Args:
        core: from `make_vehicle_core`.
        vehicle: as known to its law.
        servos: joints whose servos the law commands itself, its SERVOS.
        loaded: vehicle of which the battery's time in hover is stated, if it is another one.
    """

    def __init__(
        self,
        core: Diagram,
        vehicle: Vehicle,
        servos: Sequence[str] = (),
        loaded: Vehicle | None = None,
    ) -> None:
        self._vehicle, self._loaded = vehicle, loaded or vehicle
        self.commanded_joints = (*(tilt.joint for tilt in vehicle.tilts), *servos)
        plant = core.GetSubsystemByName("plant")
        base = body_places(plant, plant.GetBodyByName(vehicle.base_link))
        joints = np.setdiff1d(np.arange(plant.num_multibody_states()), base)
        self.joint_signals = tuple(ModelSignal(*each) for each in vehicle.small_joint_signals)
        context = plant.CreateDefaultContext()
        if core.HasSubsystemNamed(JOINT_FORCES_SYSTEM):
            q = plant.GetPositions(context).copy()
            for row in core.GetSubsystemByName(JOINT_FORCES_SYSTEM).rows:
                if row.servo and row.servo.kind == "position":
                    q[row.position] = row.servo.start
            plant.SetPositions(context, q)
        if vehicle.cables:
            rows = core.GetSubsystemByName(CABLES_SYSTEM).rows
            hang_loads(plant, context, rows, vehicle)
        self._core, self._start = core, plant.GetPositions(context)
        made = [plant.get_joint(index) for index in plant.GetJointIndices()]
        moving = [each for each in made if each.position_start() in joints and each.num_positions()]
        moving.sort(key=lambda joint: joint.position_start())
        self._joints = JointCoordinates([joint.num_positions() for joint in moving])
        self._joint_positions = joints[joints < plant.num_positions()]
        states = plant.GetStateNames(add_model_instance_prefix=False)
        signals = [signal.name for signal in self.joint_signals]
        self.measured_joints = np.array(
            [signals.index(states[place]) for place in joint_places(plant, servos)], dtype=int
        )
        self._diagram = core.ToAutoDiffXd()
        self._root = self._diagram.CreateDefaultContext()
        # Drake's order of the states: those of the plant first, among which the body's need not be
        own = np.concatenate([base, joints])
        rotors = len(vehicle.rotors)
        rest = np.arange(own.size + rotors, core.num_continuous_states())
        self._places = np.concatenate([base, own.size + np.arange(rotors), joints, rest])

    @cached_property
    def joint_start(self) -> np.ndarray:
        """Positions in which the joints rest below a level body, in `JointCoordinates` (j).

        The search for them begins with servos at their setpoints and taut cables.
        """
        if not self._joint_positions.size:
            return np.zeros(0)
        q = resting_positions(self._core, self._vehicle, self._start)
        return self._joints.small(q[self._joint_positions])

    def model(self, trim: Trim, gains: Mapping[str, float]) -> LinearModel:
        """Return the continuous model at a trim, in the axes of the heading.

        Args:
            trim: where.
            gains: parameter values by name, of which those of the air are used.
        """
        n = trim.speeds.size
        self.set_air(gains)
        _, slopes = self.slopes(trim.state, trim.speeds, trim.commands, trim.joints)
        turn_with_heading(slopes, trim.point.yaw_rate, (3, 6, 9))
        size, columns = slopes.shape
        shown = np.vstack(
            [
                np.eye(MOTION_STATE_SIZE, columns),
                *self._rotors(columns),
                np.eye(size, columns)[MOTION_STATE_SIZE + n :],
            ]
        )
        return LinearModel(
            A=slopes[:, :size],
            input_matrix=slopes[:, size:],
            output_matrix=shown[:, :size],
            feedthrough=shown[:, size:],
            period=0.0,
            states=(*motion_signals(), *rotor_signals("speed", n, "rad/s"), *self.joint_signals),
            inputs=command_signals(n, self.commanded_joints),
            outputs=(
                *motion_signals(),
                *rotor_signals("thrust", n, "N"),
                *rotor_signals("speed", n, "rad/s"),
                *self.joint_signals,
            ),
            trim=trim,
        )

    def set_air(self, gains: Mapping[str, float]) -> None:
        """Set the live parameters of the vehicle."""
        self._set("body_forces", 0, [gains["drag_area"], gains["air_density"]])
        if self._vehicle.battery:
            self._set("supply", 0, full_supply(self._loaded, gains))

    def slopes(
        self, state: np.ndarray, speeds: np.ndarray, commands: np.ndarray, joints: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return how fast motion, speeds and joints change (12 + n + 2 j), and its derivatives.

        These are by motion, speeds, joints and commands (12 + n + 2 j, 12 + n + 2 j + c).

        Args:
            state: of the body (13).
            speeds: of the rotors (n) [rad/s].
            commands: of the law (c), see `FlightComputer`.
            joints: positions (j), at rest.
        """
        size = MOTION_STATE_SIZE + speeds.size + 2 * joints.size
        seeds = np.eye(size + commands.size)
        self._set_state([state, speeds, joints, np.zeros_like(joints)], state[:4], seeds[:size])
        self._fix("commands", commands, 0, seeds[size:])
        return self._slopes(state[:4], len(seeds))

    def step(
        self,
        state: np.ndarray,
        speeds: np.ndarray,
        commands: np.ndarray,
        joints: np.ndarray,
        yaw_rate: float,
        duration: float,
    ) -> HeldCommandStep:
        """Return the exact linear model over a time under held commands.

        Args:
            state: of the body in a trimmed flight (13).
            speeds: of the rotors (n) [rad/s].
            commands: of the law (c), see `FlightComputer`.
            joints: positions (j), at rest.
            yaw_rate: of the heading [rad/s].
            duration: [s].
        """
        _, slopes = self.slopes(state, speeds, commands, joints)
        thrusts_by, _ = self._rotors(slopes.shape[1])
        turn_with_heading(slopes, yaw_rate, (3, 6, 9))
        # [A B; 0 0] holds the commands
        whole = np.vstack([slopes, np.zeros((commands.size, slopes.shape[1]))])
        return HeldCommandStep(matrix_exponential(whole * duration)[: len(slopes)], thrusts_by)

    def _set(self, system: str, index: int, values: Sequence[float]) -> None:
        """Set a numeric parameter of a system."""
        context = self._diagram.GetSubsystemByName(system).GetMyMutableContextFromRoot(self._root)
        context.get_mutable_numeric_parameter(index).SetFromVector(
            autodiff_constants(values).ravel()
        )

    def _set_state(self, values: Sequence[np.ndarray], q_WB: np.ndarray, seeds: np.ndarray) -> None:
        """Set the state with derivatives by the reduced state.

        The body's (13) comes first, then speeds, joints, and the states of other systems.
        """
        state, speeds, joints, *rest = values
        positions, self._joint_map = self._joints.positions(joints)
        first = MOTION_STATE_SIZE + speeds.size
        last = first + joints.size
        rows = np.vstack(
            [
                state_seeds(q_WB) @ seeds[:MOTION_STATE_SIZE],
                seeds[MOTION_STATE_SIZE:first],
                self._joint_map @ seeds[first:last],
                seeds[last:],
            ]
        )
        known = InitializeAutoDiff(np.concatenate([state, speeds, positions, *rest]), rows).ravel()
        whole = np.empty_like(known)
        whole[self._places] = known
        self._root.SetContinuousState(whole)

    def _fix(self, port: str, values: np.ndarray, start: int, seeds: np.ndarray) -> None:
        """Fix an input port to values, of which some have derivatives."""
        rows = np.zeros((values.size, seeds.shape[1]))
        rows[start : start + seeds.shape[0]] = seeds
        self._diagram.GetInputPort(port).FixValue(self._root, InitializeAutoDiff(values, rows))

    def _slopes(self, q_WB: np.ndarray, columns: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the time derivatives of the reduced state, and their derivatives."""
        slopes = self._diagram.EvalTimeDerivatives(self._root).CopyToVector()[self._places]
        values, found = ExtractValue(slopes).ravel(), gradient(slopes, columns)
        small, back = reduced_state_seeds(q_WB), self._joints.inverse(self._joint_map)
        first = 13 + len(self._vehicle.rotors)
        last = first + len(self._joint_map)
        reduced = [
            [small @ each[:13], each[13:first], back @ each[first:last], each[last:]]
            for each in (values, found)
        ]
        return np.concatenate(reduced[0]), np.vstack(reduced[1])

    def _rotors(self, columns: int) -> list[np.ndarray]:
        """Return the derivatives of thrusts and speeds."""
        ports = (self._diagram.GetOutputPort(name) for name in ("thrusts", "speeds"))
        return [gradient(port.Eval(self._root), columns) for port in ports]


def built_in_values(controller: Controller, values: Mapping[str, float]) -> dict[str, float]:
    """Return the parameter values by name that a continuous plant has built in.

    They are the payload, hooks, and the setpoints of servos that the law does not command.
    """
    names = (*Payload._fields, HOOKS, *(row.name for row in controller.setpoints))
    return {name: values[name] for name in names}


def command_signals(
    rotors: int, joints: Sequence[str], name: str = "command"
) -> tuple[ModelSignal, ...]:
    """Return a signal for each command of a law: of rotors, and of the servos of joints."""
    return (
        *rotor_signals(name, rotors, "rad/s"),
        *(ModelSignal(f"{name}_{joint}", "rad") for joint in joints),
    )


def matrix_exponential(A: np.ndarray) -> np.ndarray:
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
