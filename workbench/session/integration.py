"""How a flight is integrated: fixed steps in the air, error control where something may be touched.

In the air `runge_kutta5` takes one step a control period, more where the body turns fast or a
rotor is quick; where the control period is short `runge_kutta3` takes the steps, as exactly and in
half the time. A step ends at each sample of a sensor. Near contact CENIC always converges (Kurtz
and Castro, "CENIC: Convex Error-controlled Numerical Integration for Contact", 2025, arXiv
2511.08771).
The choice is made at the beginning of a control period from the Context alone.

Other integrators of Drake were measured on the ground. `radau1` and `implicit_euler` reuse their
Jacobian: one of the contact makes them hold a drone back that has just taken off (9 cm lower after
2 s). Explicit ones take a hundred times the steps. A drone that tumbles over the ground brings both
to steps of nanoseconds.
"""

import math

from pydrake.systems.analysis import (
    InitializeParams,
    IntegratorBase,
    ResetIntegratorFromFlags,
    Simulator,
)

from workbench.diagram.airframe import Airframe
from workbench.scenario.scenario import Rates

FAST = 5.0
"""Angular velocity above which steps are half as long [rad/s]."""
LONGEST_STEP = 1 / 128
"""[s]"""
ACCURACY = 1e-5
"""Of CENIC: a drone that slides is stopped after the right distance within 3 %, also if it has come
down with 0.5 m/s; with 1e-4 within 10 %."""
SHORT = 0.2
"""Share of the rotors' lag below which a step is as exact with `runge_kutta3` as one of a control
period with `runge_kutta5`."""
AIR, AIR_SHORT, GROUND = "runge_kutta5", "runge_kutta3", "cenic"


def air_step(period: float, lag: float, turns_fast: bool) -> tuple[float, bool]:
    """Return the step in the air [s], and whether it is of third order, else of fifth.

    Args:
        period: of control [s].
        lag: time constant of the quickest rotor [s].
        turns_fast: whether the body turns faster than `FAST`.
    """
    size = _part(period, min(0.5 * LONGEST_STEP if turns_fast else LONGEST_STEP, lag))
    return size, size <= SHORT * lag


def _part(period: float, longest: float) -> float:
    """Return the longest part of a period of which as many as fill it are no longer [s]."""
    return period / math.ceil(period / longest - 1e-9)


class Integration:
    """Advances a Simulator, with the integrator that each control period needs."""

    def __init__(self, simulator: Simulator, airframe: Airframe, rates: Rates) -> None:
        self._simulator, self._airframe = simulator, airframe
        self._step, self._period = rates.physics_step, rates.control_period
        self._every = rates.control_steps
        rotors = airframe.vehicle.rotors
        self._lag = min(min(each.time_constant_up, each.time_constant_down) for each in rotors)
        self._scheme, self._size = "", 0.0

    def advance(self, step: int) -> None:
        """Advance to a step of the physics."""
        now = round(self._simulator.get_context().get_time() / self._step)
        while now < step:
            self._choose()
            now = min(step, (now // self._every + 1) * self._every)
            self._simulator.AdvanceTo(now * self._step)

    def _choose(self) -> None:
        """Set the integrator for the control period that begins now."""
        root, airframe = self._simulator.get_context(), self._airframe
        air = not airframe.may_touch(root, self._period)
        turns_fast = math.hypot(*airframe.body_state(root)[7:10].tolist()) > FAST
        size, third = air_step(self._period, self._lag, turns_fast)
        scheme = AIR_SHORT if third else AIR
        if not air:  # steps of the rotors' speeds are those of Euler in CENIC
            scheme, size = GROUND, _part(self._period, min(size, 0.5 * self._lag))
        if scheme == self._scheme and size == self._size:
            return
        self._scheme, self._size = scheme, size
        integrator: IntegratorBase = ResetIntegratorFromFlags(self._simulator, scheme, size)
        integrator.set_fixed_step_mode(air)
        if not air:
            integrator.set_target_accuracy(ACCURACY)
        # With a new integrator the Simulator begins anew at the present time. Updates that are due
        # now are still to come; what is published now is published again.
        begin = InitializeParams()
        begin.suppress_initialization_events = True
        self._simulator.Initialize(begin)
