"""A Drake system as a control law: a pure function of its inputs and its memory.

The system has its own Context. An update writes the memory into its state, and measurement and
setpoint into its input ports. It reads the output `wrench`, then advances the system by a control
period with held inputs. The resulting state is the memory of the next update. So a Drake system
flies, forks, replays and linearises like any other law.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.autodiffutils import AutoDiffXd, ExtractValue, InitializeAutoDiff
from pydrake.systems.analysis import (
    InitializeParams,
    ResetIntegratorFromFlags,
    Simulator,
    Simulator_,
)
from pydrake.systems.framework import Context, System

from workbench.common.errors import WorkbenchError
from workbench.control.guidance import (
    Gains,
    KnownBody,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
    position_error,
    velocity_setpoint,
)
from workbench.control.loop_points import Probes, probe

SYSTEM_PORT_SIZES = {
    "attitude": 4,
    "angular_velocity": 3,
    "velocity": 3,
    "acceleration": 3,
    "position_error": 3,
    "velocity_setpoint": 3,
    "yaw_rate_setpoint": 1,
    "path_acceleration": 3,
}
"""Input ports that a system may have, and their sizes: q_WT; w_WB, v_WBcm and a_WBcm; the position
error while a position is held and the commanded velocity within limits, all in W; the commanded yaw
rate; and the acceleration of a path in W."""
SYSTEM_POINTS = {"force": "N", "moment_x": "N*m", "moment_y": "N*m", "moment_z": "N*m"}
"""Loop points: the wrench, which is the plant's input."""
SYSTEM_STEP_AXES = {"force": "z", "moment_x": "y", "moment_y": "x", "moment_z": "yaw"}
"""The axis of the step that goes through the loop at each point."""
INTEGRATOR_STEPS = 4
"""Integrator steps in a control period, if the system has continuous states."""
UPDATE_TIME_SHARE = 1e-6
"""Share of a control period by which the times of discrete updates may be off."""
DIFFERENCE_STEP = 1e-6
"""Step of finite differences, for a system that does not convert to AutoDiffXd."""
MIN_SAMPLED_PERIOD_S = 1e-4
"""A shorter time between updates means a model without sampling [s]."""

SystemFactory = Callable[[KnownBody, Gains, float], System]


class SystemLaw:
    """The law of a Drake system.

    Args:
        file: of the law.
        make: makes the system for a vehicle, gains and the time between updates [s].
        system: made by `make`, for everything that does not depend on its arguments.
        dt: time between updates of that system [s].

    Attributes:
        memory: initial state.
        converts: whether linear models use exact derivatives instead of finite differences.

    Raises:
        WorkbenchError: if ports are missing, or the state is not known after a period.
    """

    def __init__(self, file: Path, make: SystemFactory, system: System, dt: float) -> None:
        self._file, self._make = file, make
        self._runner_for = lru_cache(maxsize=8)(self._make_runner)
        runner = _SystemRunner(file, system, dt)
        self.memory: list[float] = runner.initial
        self.converts = runner.converts

    def update(
        self,
        measured: MeasuredMotion,
        setpoint: LawSetpoint,
        g: Gains,
        vehicle: KnownBody,
        memory: Memory,
        dt: float,
        loops: Probes,
    ) -> LawResult:
        """Return the wrench in T, F [N] and m [N·m], and the next state of the system."""
        if dt < MIN_SAMPLED_PERIOD_S:
            raise WorkbenchError(
                f"{self._file}: a Drake system has no model without sampling here: take the "
                "sampled one"
            )
        if any(isinstance(value, AutoDiffXd) and len(value.derivatives()) for value in g):
            raise WorkbenchError(
                f"{self._file}: derivatives by the gains of a Drake system are not known: sweep "
                "them, as `workbench sweep`"
            )
        body = tuple(map(_hashable, vehicle))
        runner = self._runner_for(body, type(g), tuple(float(value) for value in g), dt)
        v_x, v_y, v_z, yaw_rate = velocity_setpoint((0.0, 0.0, 0.0), measured, setpoint, g)
        values = {
            "attitude": measured.q_WT,
            "angular_velocity": measured.w_WB,
            "velocity": measured.v_WBcm,
            "acceleration": measured.a_WBcm,
            "position_error": position_error(measured, setpoint),
            "velocity_setpoint": (v_x, v_y, v_z),
            "yaw_rate_setpoint": (yaw_rate,),
            "path_acceleration": setpoint.a_WBcm,
        }
        inputs = [value for name in runner.ports for value in values[name]]
        wrench, after = runner.run(inputs, list(memory), float(measured.time))
        force, m_x, m_y, m_z = (probe(part, place, loops) for place, part in enumerate(wrench))
        return (force, m_x, m_y, m_z), after

    def _make_runner(
        self,
        body: tuple[Any, ...],
        record: Callable[..., Gains],
        gains: tuple[float, ...],
        dt: float,
    ) -> "_SystemRunner":
        return _SystemRunner(self._file, self._make(KnownBody(*body), record(*gains), dt), dt)


class _SystemRunner:
    """A system with a Context that each update overwrites."""

    def __init__(self, file: Path, system: System, dt: float) -> None:
        if not isinstance(system, System):
            raise WorkbenchError(
                f"{file}: system returns {system!r:.60}: let it return a LeafSystem or a Diagram"
            )
        self._system, self._dt = system, dt
        self.ports = _ports(file, system)
        self._plain = _PeriodRun(system, Simulator, self.ports, dt)
        context = self._plain.context
        _check_state(file, system, context, dt)
        self.initial: list[float] = self._plain.state().tolist()
        converted = system.ToAutoDiffXdMaybe() if hasattr(system, "ToAutoDiffXdMaybe") else None
        self._exact = converted and _PeriodRun(converted, Simulator_[AutoDiffXd], self.ports, dt)

    @property
    def converts(self) -> bool:
        """Whether derivatives are exact instead of finite differences."""
        return self._exact is not None

    def run(
        self, inputs: list[Any], memory: list[Any], time: float
    ) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
        """Return wrench (4) and next state at a time of the flight [s]."""
        known = [*inputs, *memory]
        if not any(isinstance(value, AutoDiffXd) for value in known):
            found = self._plain.run(np.array(known, dtype=float), time)
            return tuple(found[:4].tolist()), tuple(found[4:].tolist())
        values = [value if isinstance(value, AutoDiffXd) else AutoDiffXd(value) for value in known]
        at = ExtractValue(np.array(values)).ravel()
        by = _whole_gradient(values)
        slopes = self._slopes(at, time)
        found = InitializeAutoDiff(self._plain.run(at, time), slopes @ by).ravel()
        return tuple(found[:4].tolist()), tuple(found[4:].tolist())

    def _slopes(self, at: np.ndarray, time: float) -> np.ndarray:
        """Return derivatives of wrench and next state by inputs and state."""
        if self._exact is not None:
            found = self._exact.run(InitializeAutoDiff(at, np.eye(at.size)).ravel(), time)
            return _whole_gradient(list(found), at.size)
        columns = []
        for place in range(at.size):
            step = np.zeros(at.size)
            step[place] = DIFFERENCE_STEP * max(1.0, abs(at[place]))
            rise = self._plain.run(at + step, time) - self._plain.run(at - step, time)
            columns.append(rise / (2.0 * step[place]))
        return np.column_stack(columns)


class _PeriodRun:
    """Runs a system for a control period, with floats or with AutoDiffXd."""

    def __init__(
        self,
        system: System,
        simulator: Callable[[System], Simulator],
        ports: Sequence[str],
        dt: float,
    ) -> None:
        self._system, self._dt = system, dt
        timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
        # a control period in periods of the system, which may be ours rounded to some digits
        whole = timing and round(dt / timing.period_sec()) * timing.period_sec()
        self._span = whole or dt
        self._ports = [system.GetInputPort(name) for name in ports]
        self._wrench = system.GetOutputPort("wrench")
        self._simulator = simulator(system)
        self.context = self._simulator.get_mutable_context()
        self._begin = InitializeParams()
        self._begin.suppress_initialization_events = True
        self._continuous = self.context.num_continuous_states()
        self._groups = [
            self.context.get_discrete_state(k).size()
            for k in range(self.context.num_discrete_state_groups())
        ]
        if self._continuous:
            ResetIntegratorFromFlags(self._simulator, "runge_kutta3", dt / INTEGRATOR_STEPS)
            self._simulator.get_mutable_integrator().set_fixed_step_mode(True)

    def state(self) -> np.ndarray:
        """Return the state: the continuous one, then the discrete groups."""
        parts = [self.context.get_continuous_state_vector().CopyToVector()]
        parts += [
            self.context.get_discrete_state(k).CopyToVector() for k in range(len(self._groups))
        ]
        found: np.ndarray = np.concatenate(parts)
        return found

    def run(self, known: np.ndarray, time: float) -> np.ndarray:
        """Return the wrench at a time [s], and the state a control period later."""
        context, at = self.context, 0
        for port in self._ports:
            port.FixValue(context, known[at : at + port.size()])
            at += port.size()
        context.SetTime(time)
        if self._continuous:
            context.SetContinuousState(known[at : at + self._continuous])
            at += self._continuous
        for number, size in enumerate(self._groups):
            context.SetDiscreteState(number, known[at : at + size])
            at += size
        wrench = self._wrench.Eval(context).copy()
        if at > sum(port.size() for port in self._ports):
            # multiples of its period and of ours are not equal to the bit: an update that is due
            # now is in this period, and the one at its end in the next
            start = time * (self._span / self._dt) - UPDATE_TIME_SHARE * self._dt
            context.SetTime(start)
            self._simulator.Initialize(self._begin)
            self._simulator.AdvanceTo(start + self._span)
        return np.concatenate([wrench, self.state()])


def _ports(file: Path, system: System) -> list[str]:
    """Return the names of a system's input ports.

    Raises:
        WorkbenchError: if a port is unknown, or the output port is missing.
    """
    found = []
    for number in range(system.num_input_ports()):
        port = system.get_input_port(number)
        name = port.get_name()
        if name not in SYSTEM_PORT_SIZES or port.size() != SYSTEM_PORT_SIZES[name]:
            listed = ", ".join(f"{each} ({size})" for each, size in SYSTEM_PORT_SIZES.items())
            raise WorkbenchError(
                f"{file}: the system has an input port {name} ({port.size()}): rename it to one "
                f"of {listed}"
            )
        found.append(name)
    if not system.HasOutputPort("wrench") or system.GetOutputPort("wrench").size() != 4:
        raise WorkbenchError(
            f"{file}: the system has no output port wrench (4): force along z of T [N], and moment "
            "in T [N·m]"
        )
    return found


def _check_state(file: Path, system: System, context: Context, dt: float) -> None:
    """Refuse a state that is abstract, or changes at other times than the law's updates."""
    if context.num_abstract_states():
        raise WorkbenchError(f"{file}: the system has an abstract state: use only numeric state")
    if not context.num_discrete_state_groups():
        return
    timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
    share = dt / timing.period_sec() if timing else 0.0
    if timing is None or timing.offset_sec() or share < 0.999 or abs(share - round(share)) > 1e-6:
        raise WorkbenchError(
            f"{file}: the system's discrete states change at other times than the law's updates: "
            f"let all have one period of {dt:g} s, which `system` is given, or a whole part of it"
        )


def _whole_gradient(values: list[Any], columns: int = 0) -> np.ndarray:
    """Return derivatives (N, columns), zero for constants."""
    size = max([columns, *(len(value.derivatives()) for value in values)])
    rows = np.zeros((len(values), size))
    for row, value in zip(rows, values, strict=True):
        if len(value.derivatives()):
            row[:] = value.derivatives()
    return rows


def _hashable(value: Any) -> float | tuple[float, ...]:
    return tuple(map(float, value)) if np.ndim(value) else float(value)
