"""How a flight is integrated: fixed steps in the air, error control where something may be touched.

In the air `runge_kutta5` takes one step a control period, more where the IMU samples more often or
the body turns fast. Near contact `radau1` with error control follows the stiff contact forces. The
choice is made at the beginning of a control period from the Context alone.
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

FAST = 20.0
"""Angular velocity above which steps are half as long [rad/s]."""
LONGEST_STEP = 1 / 128
"""In the air [s]: lags of rotors of 2.5 ms and more stay stable, whatever the control period is."""
ACCURACY = 1e-3
"""Of the integrator with error control."""
SHORTEST_STEP = 1e-4
"""With error control [s]. A drone that tumbles over the ground would ask for steps of nanoseconds,
as friction changes its direction at once; it gets this step whatever its error is."""
AIR, GROUND = "runge_kutta5", "radau1"


class Integration:
    """Advances a Simulator, with the integrator that each control period needs."""

    def __init__(self, simulator: Simulator, airframe: Airframe, rates: Rates) -> None:
        self._simulator, self._airframe = simulator, airframe
        self._step, self._period = rates.physics_step, rates.control_period
        self._scheme, self._size = "", 0.0

    def advance(self, step: int) -> None:
        """Advance to a step of the physics."""
        every = round(self._period / self._step)
        now = round(self._simulator.get_context().get_time() / self._step)
        while now < step:
            now = min(step, (now // every + 1) * every)
            self._choose()
            self._simulator.AdvanceTo(now * self._step)

    def _choose(self) -> None:
        """Set the integrator for the control period that begins now."""
        root, airframe = self._simulator.get_context(), self._airframe
        samples = airframe.imu.sample_steps(airframe.imu.GetMyContextFromRoot(root))
        size = samples * self._step
        size /= math.ceil(size / LONGEST_STEP - 1e-9)
        if math.hypot(*airframe.body_state(root)[7:10].tolist()) > FAST:
            size = min(size, 0.5 * min(self._period, LONGEST_STEP))
        scheme = GROUND if airframe.may_touch(root, self._period) else AIR
        if scheme == self._scheme and size == self._size:
            return
        self._scheme, self._size = scheme, size
        integrator: IntegratorBase = ResetIntegratorFromFlags(self._simulator, scheme, size)
        integrator.set_fixed_step_mode(scheme == AIR)
        if scheme == GROUND:
            integrator.set_target_accuracy(ACCURACY)
            integrator.set_requested_minimum_step_size(SHORTEST_STEP)
            integrator.set_throw_on_minimum_step_size_violation(False)
        # With a new integrator the Simulator begins anew at the present time. Updates that are due
        # now are still to come; what is published now is published again.
        begin = InitializeParams()
        begin.suppress_initialization_events = True
        self._simulator.Initialize(begin)
