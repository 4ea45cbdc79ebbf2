"""How a flight is integrated: fixed steps in the air, error control where something may be touched.

In the air `runge_kutta5` takes one step a control period, more where the IMU samples more often or
the body turns fast. Near contact `radau1` with error control follows the stiff contact forces. The
choice is made at the beginning of a control period from the Context alone.
"""

import numpy as np
from pydrake.systems.analysis import IntegratorBase, ResetIntegratorFromFlags, Simulator

from workbench.diagram.airframe import Airframe
from workbench.scenario.scenario import Rates

FAST = 20.0
"""Angular velocity above which steps are half as long [rad/s]."""
ACCURACY = 1e-3
"""Of the integrator with error control."""
AIR, GROUND = "runge_kutta5", "radau1"


class Integration:
    """Chooses the integrator of each control period."""

    def __init__(self, rates: Rates) -> None:
        self._rates = rates
        self._steps = round(rates.control_period / rates.physics_step)
        self._scheme = ""
        self._size = 0.0

    def choose(self, simulator: Simulator, airframe: Airframe) -> None:
        """Set the integrator for the control period that begins now."""
        root = simulator.get_context()
        samples = airframe.imu.sample_steps(airframe.imu.GetMyContextFromRoot(root))
        size = samples * self._rates.physics_step
        state = airframe.body_state(root)
        if np.linalg.norm(state[7:10]) > FAST:
            size = min(size, 0.5 * self._rates.control_period)
        scheme = GROUND if airframe.may_touch(root, self._rates.control_period) else AIR
        if scheme == self._scheme and size == self._size:
            return
        self._scheme, self._size = scheme, size
        integrator: IntegratorBase = ResetIntegratorFromFlags(simulator, scheme, size)
        integrator.set_fixed_step_mode(scheme == AIR)
        if scheme == GROUND:
            integrator.set_target_accuracy(ACCURACY)
        integrator.Initialize()
