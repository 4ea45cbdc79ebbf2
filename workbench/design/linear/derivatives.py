"""Exact derivatives of one control update and one physics step of the sampled core."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff
from pydrake.systems.framework import System

from workbench.design.linear.attitude import reduced, state_seeds
from workbench.design.linear.autodiff import constants, gradient, whole
from workbench.design.linear.last_call import LastCall
from workbench.diagram.core import parameter_values
from workbench.diagram.sampled_core import SampledCore
from workbench.systems.cascade import Guidance
from workbench.systems.flight_computer import GAINS, MEMORY, PROBES, THRUSTS
from workbench.systems.loop_points import CLOSED, COUNT, INJECTIONS

STATE = 12
"""Angles, place, angular velocity and velocity, all in W."""
REFERENCE = 4
HELD = 3
"""Velocity and yaw rate asked for, and the place held."""
WRENCH = 6
DRAG = ("drag_area", "air_density")
"""Parameters of the drag, in its order."""
HOLD_X = Guidance._fields.index("p_x")


@dataclass(frozen=True)
class Update:
    """A control update and its derivatives.

    Columns are those of the plant's state as the law sees it (12), the law's memory (2 n + 3),
    velocity and yaw rate asked for (4), place held (3), and injections (15). The drag's wrench
    depends on the plant's state and the rotors' speeds, which are the memory's first.
    """

    thrusts: np.ndarray
    memory: np.ndarray
    wrench: np.ndarray
    thrusts_by: np.ndarray
    memory_by: np.ndarray
    signals_by: np.ndarray
    wrench_by: np.ndarray


@dataclass(frozen=True)
class Step:
    """A physics step: the state after it (13), and its derivatives.

    Rows are angles, place, w and v (12), columns these, thrusts (n) and the drag's wrench (6).
    """

    state: np.ndarray
    by: np.ndarray


class Derivatives:
    """An AutoDiff copy of a sampled core, kept, whose Context is filled anew each time.

    Its functions, each of which remembers its last call: `update(state, memory, reference,
    guidance) -> Update`, `step(state, thrusts, wrench) -> Step`, and `acceleration`, of the same
    arguments, which returns wdot and vdot (6) and their derivatives by the columns of a step.

    Args:
        core: what flies.
    """

    def __init__(self, core: SampledCore) -> None:
        diagram = core.diagram.ToAutoDiffXd()
        root = diagram.CreateDefaultContext()
        self._plant, self._in_plant = _found(diagram, root, core.plant)
        self._computer, self._in_computer = _found(diagram, root, core.computer)
        self._drag, self._in_drag = _found(diagram, root, core.drag)
        _, self._in_held = _found(diagram, root, core.held_drag)
        self._diagram, self._root = diagram, root
        self.update = LastCall(self._update)
        self.step = LastCall(self._step)
        self.acceleration = LastCall(self._acceleration)

    def set_gains(self, gains: Mapping[str, float]) -> None:
        """Let the law fly with parameter values, by name, in air of theirs."""
        _set(self._in_computer, GAINS, constants(parameter_values("controller", gains).values()))
        _set(self._in_drag, 0, constants(gains[name] for name in DRAG))
        self.update.forget()

    def _update(
        self,
        state: np.ndarray,
        memory: np.ndarray,
        reference: np.ndarray,
        guidance: np.ndarray,
    ) -> Update:
        """Return a control update.

        Args:
            state: of the plant (13).
            memory: of the computer (2 n + 3).
            reference: see `cascade.Reference` (8).
            guidance: see `cascade.Guidance` (22).
        """
        sizes = (STATE, memory.size, REFERENCE, HELD, COUNT)
        seeds = np.split(np.eye(sum(sizes)), np.cumsum(sizes)[:-1])
        self._plant.SetPositionsAndVelocities(
            self._in_plant, InitializeAutoDiff(state, state_seeds(state[:4]) @ seeds[0])
        )
        self._in_computer.SetDiscreteState(MEMORY, InitializeAutoDiff(memory, seeds[1]))
        asked = np.zeros((reference.size, sum(sizes)))
        asked[:REFERENCE] = seeds[2]
        self._diagram.GetInputPort("reference").FixValue(
            self._root, InitializeAutoDiff(reference, asked).ravel()
        )
        kept = np.zeros((guidance.size, sum(sizes)))
        kept[HOLD_X : HOLD_X + HELD] = seeds[3]
        self._diagram.GetInputPort("guidance").FixValue(
            self._root, InitializeAutoDiff(guidance, kept).ravel()
        )
        probes = np.zeros((len(CLOSED), sum(sizes)))
        probes[INJECTIONS:] = seeds[4]
        _set(self._in_computer, PROBES, InitializeAutoDiff(np.array(CLOSED), probes))
        thrusts, after, signals = self._computer.update(self._in_computer)
        wrench = self._drag.get_output_port().Eval(self._in_drag)
        return Update(
            ExtractValue(whole(thrusts)).ravel(),
            ExtractValue(whole(after)).ravel(),
            ExtractValue(wrench).ravel(),
            gradient(thrusts, sum(sizes)),
            gradient(after, sum(sizes)),
            gradient(signals, sum(sizes)),
            gradient(wrench, sum(sizes)),
        )

    def _step(self, state: np.ndarray, thrusts: np.ndarray, wrench: np.ndarray) -> Step:
        """Return a physics step from a plant state (13) under thrusts (n) and a wrench (6)."""
        columns = self._load(state, thrusts, wrench)
        after = self._plant.EvalUniquePeriodicDiscreteUpdate(self._in_plant).value()
        reached = ExtractValue(after).ravel()
        return Step(reached, reduced(reached[:4]) @ gradient(after, columns))

    def _acceleration(
        self, state: np.ndarray, thrusts: np.ndarray, wrench: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return wdot and vdot (6), and their derivatives by the columns of `step`."""
        columns = self._load(state, thrusts, wrench)
        found = self._plant.get_generalized_acceleration_output_port().Eval(self._in_plant)
        return ExtractValue(found).ravel(), gradient(found, columns)

    def _load(self, state: np.ndarray, thrusts: np.ndarray, wrench: np.ndarray) -> int:
        """Put what a physics step begins with into the Context; return how many seeds it has."""
        sizes = (STATE, thrusts.size, wrench.size)
        seeds = np.split(np.eye(sum(sizes)), np.cumsum(sizes)[:-1])
        self._plant.SetPositionsAndVelocities(
            self._in_plant, InitializeAutoDiff(state, state_seeds(state[:4]) @ seeds[0])
        )
        self._in_computer.SetDiscreteState(THRUSTS, InitializeAutoDiff(thrusts, seeds[1]))
        self._in_held.SetDiscreteState(InitializeAutoDiff(wrench, seeds[2]))
        return sum(sizes)


def _found(diagram: Any, root: Any, system: System) -> tuple[Any, Any]:
    """Return the counterpart of a system in the AutoDiff copy, and its Context."""
    copy = diagram.GetSubsystemByName(system.get_name())
    return copy, copy.GetMyMutableContextFromRoot(root)


def _set(context: Any, index: int, values: np.ndarray) -> None:
    context.get_mutable_numeric_parameter(index).SetFromVector(values.ravel())
