"""How a flight is integrated: fixed steps in the air, error control where something may be touched.

In the air `runge_kutta5` takes one step a control period, more where the body turns fast or a
rotor is quick; where the control period is short `runge_kutta3` takes the steps, as exactly and in
half the time. A step ends at each sample of a sensor. Where joints have a mode too fast for that
step, it is taken in up to three parts; where that is not enough (light links, friction, joints that
follow others), `radau3` flies with error control. Near contact CENIC always converges (Kurtz and
Castro, "CENIC: Convex Error-controlled Numerical Integration for Contact", 2025, arXiv 2511.08771).
The choice is made at the beginning of a control period from the Context alone.

Other integrators of Drake were measured on the ground. `radau1` and `implicit_euler` reuse their
Jacobian: one of the contact makes them hold a drone back that has just taken off (9 cm lower after
2 s). Explicit ones take a hundred times the steps. A drone that tumbles over the ground brings both
to steps of nanoseconds.
"""

import math
from collections.abc import Sequence

from pydrake.systems.analysis import (
    InitializeParams,
    IntegratorBase,
    ResetIntegratorFromFlags,
    Simulator,
)

from workbench.common.errors import FlightBrokenError
from workbench.diagram.airframe import Airframe
from workbench.diagram.joint_modes import JointMode
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates

FAST_TURN_RAD_S = 5.0
"""Angular velocity above which steps are half as long [rad/s]."""
MAX_AIR_STEP_S = 1 / 128
"""[s]"""
CENIC_ACCURACY = 3e-6
"""Of CENIC: a drone that has come down with 0.5 m/s while it slides with 2 m/s stops 4 % short of
where friction says, with 1e-5 9 %, with 1e-6 2 %, which takes twice the time where it tumbles."""
SHORT_STEP_LAG_SHARE = 0.2
"""Share of the rotors' lag below which a step is as exact with `runge_kutta3` as one of a control
period with `runge_kutta5`."""
AIR_INTEGRATOR, SHORT_STEP_INTEGRATOR = "runge_kutta5", "runge_kutta3"
CONTACT_INTEGRATOR, STIFF_INTEGRATOR = "cenic", "radau3"
STIFF_ACCURACY = 1e-3
"""For joints with fast modes: an arm with dry friction and a gripper takes two steps a control
period. Of the implicit integrators `radau1` takes eight for the same accuracy, `implicit_euler`
and `velocity_implicit_euler` six. Positions are within 1e-6 m of those at 1e-5."""
MAX_EXPLICIT_STEP_RATE = 1.0
"""Largest product of step and fastest mode of the joints for an explicit integrator."""
MAX_STEP_PARTS = 3
"""Largest number of steps in place of one: elastic cables of up to 380 rad/s fly in half the time
of `radau3`, and a hundred times as exactly."""


def air_step(period: float, lag: float, turns_fast: bool) -> tuple[float, bool]:
    """Return the step in the air [s], and whether it is of third order, else of fifth.

    Args:
        period: of control [s].
        lag: time constant of the quickest rotor [s].
        turns_fast: whether the body turns faster than `FAST_TURN_RAD_S`.
    """
    size = _part(period, min(0.5 * MAX_AIR_STEP_S if turns_fast else MAX_AIR_STEP_S, lag))
    return size, size <= SHORT_STEP_LAG_SHARE * lag


def integrator_in_hover(rates: Rates, vehicle: Vehicle, modes: Sequence[JointMode]) -> str:
    """Return the integrator of a vehicle that hovers away from everything."""
    size, third = air_step(rates.control_period, quickest_rotor(vehicle), False)
    return _air_integrator(third, explicit_parts(size, modes))


def quickest_rotor(vehicle: Vehicle) -> float:
    """Return the smallest time constant of a rotor [s]."""
    return min(min(each.time_constant_up, each.time_constant_down) for each in vehicle.rotors)


def explicit_parts(step: float, modes: Sequence[JointMode]) -> int:
    """Return in how many parts a step [s] is short for the fastest mode of joints, the first."""
    return max(1, math.ceil(modes[0].rate * step / MAX_EXPLICIT_STEP_RATE)) if modes else 1


def _air_integrator(third: bool, parts: int) -> str:
    """Return the integrator in the air: of third order, fifth, or implicit for stiff joints."""
    if parts > MAX_STEP_PARTS:
        return STIFF_INTEGRATOR
    return SHORT_STEP_INTEGRATOR if third and parts == 1 else AIR_INTEGRATOR


def _part(period: float, longest: float) -> float:
    """Return the longest part of a period of which as many as fill it are no longer [s]."""
    return period / math.ceil(period / longest - 1e-9)


class Integration:
    """Advances a Simulator, with the integrator that each control period needs."""

    def __init__(self, simulator: Simulator, airframe: Airframe, rates: Rates) -> None:
        self._simulator, self._airframe = simulator, airframe
        self._step, self._period = rates.physics_step, rates.control_period
        self._every = rates.control_steps
        self._lag = quickest_rotor(airframe.vehicle)
        longest, _ = air_step(self._period, self._lag, False)
        self._parts = explicit_parts(longest, airframe.modes)
        self._joints_step = longest / self._parts
        self._scheme, self._size = "", 0.0

    def advance(self, step: int) -> None:
        """Advance to a step of the physics.

        Raises:
            FlightBrokenError: if the simulation cannot go on.
        """
        root, frames = self._simulator.get_mutable_context(), self._airframe.ball_frames
        now = round(root.get_time() / self._step)
        try:
            while now < step:
                if frames and not now % self._every:
                    turned = frames.turn(root, self._period)
                    if turned and self._scheme == STIFF_INTEGRATOR:
                        self._scheme = ""  # its derivatives are by the former angles
                self._choose()
                now = min(step, (now // self._every + 1) * self._every)
                self._simulator.AdvanceTo(now * self._step)
        except (FlightBrokenError, RuntimeError, SystemExit) as error:
            broke = f"the flight broke off after {root.get_time():.3f} s"
            if isinstance(error, FlightBrokenError):
                raise FlightBrokenError(f"{error}; {broke}") from error
            raise FlightBrokenError(f"{broke}: {' '.join(str(error).split())}") from error

    def _choose(self) -> None:
        """Set the integrator for the control period that begins now."""
        root, airframe = self._simulator.get_context(), self._airframe
        air = not airframe.may_touch(root, self._period)
        turns_fast = math.hypot(*airframe.body_state(root)[7:10].tolist()) > FAST_TURN_RAD_S
        size, third = air_step(self._period, self._lag, turns_fast)
        scheme, controlled = _air_integrator(third, self._parts), 0.0
        if scheme == STIFF_INTEGRATOR:
            size, controlled = self._period, STIFF_ACCURACY
        if not air:  # steps of the rotors' speeds are those of Euler in CENIC
            scheme, size = CONTACT_INTEGRATOR, _part(self._period, min(size, 0.5 * self._lag))
            controlled = CENIC_ACCURACY
        elif not controlled:
            size = min(size, self._joints_step)
        if scheme == self._scheme and size == self._size:
            return
        self._scheme, self._size = scheme, size
        integrator: IntegratorBase = ResetIntegratorFromFlags(self._simulator, scheme, size)
        integrator.set_fixed_step_mode(not controlled)
        if controlled:
            integrator.set_target_accuracy(controlled)
        # With a new integrator the Simulator begins anew at the present time. Updates that are due
        # now are still to come; what is published now is published again.
        begin = InitializeParams()
        begin.suppress_initialization_events = True
        self._simulator.Initialize(begin)
