"""The linear model of the vehicle alone: from rotor commands to motion."""

from collections.abc import Mapping

import numpy as np
from pydrake.autodiffutils import InitializeAutoDiff
from pydrake.systems.framework import Diagram

from workbench.design.linear.attitude import reduced, state_seeds, turn_with_heading
from workbench.design.linear.autodiff import constants, gradient
from workbench.design.linear.derivatives import DRAG, STATE
from workbench.design.linear.model import LinearModel, Trim
from workbench.design.linear.names import motion, numbered


class VehicleDerivatives:
    """An AutoDiff copy of a vehicle core, kept, whose Context is filled anew each time.

    Args:
        core: from `make_vehicle_core`.
    """

    def __init__(self, core: Diagram) -> None:
        self._diagram = core.ToAutoDiffXd()
        self._root = self._diagram.CreateDefaultContext()

    def model(self, trim: Trim, gains: Mapping[str, float]) -> LinearModel:
        """Return the continuous model at a trim, in the axes of the heading.

        Args:
            trim: where.
            gains: parameter values by name; those of the air are used.
        """
        air = self._diagram.GetSubsystemByName("forces").GetMyMutableContextFromRoot(self._root)
        air.get_mutable_numeric_parameter(0).SetFromVector(constants(gains[d] for d in DRAG))
        n = trim.speeds.size
        seeds = np.eye(STATE + 2 * n)
        rows = np.vstack([state_seeds(trim.q_WB) @ seeds[:STATE], seeds[STATE : STATE + n]])
        values = np.concatenate([trim.state, trim.speeds])
        self._root.SetContinuousState(InitializeAutoDiff(values, rows))
        commands = InitializeAutoDiff(trim.speeds, seeds[STATE + n :])
        self._diagram.GetInputPort("commands").FixValue(self._root, commands)
        slopes = gradient(self._diagram.EvalTimeDerivatives(self._root).CopyToVector(), len(seeds))
        slopes = np.vstack([reduced(trim.q_WB) @ slopes[:13], slopes[13:]])
        thrusts = gradient(self._diagram.GetOutputPort("thrusts").Eval(self._root), len(seeds))
        outputs = np.vstack([seeds[:STATE], thrusts, seeds[STATE : STATE + n]])
        known = STATE + n
        turn_with_heading(slopes, trim.point.yaw_rate, (3, 6, 9))
        return LinearModel(
            A=slopes[:, :known],
            input_matrix=slopes[:, known:],
            output_matrix=outputs[:, :known],
            feedthrough=outputs[:, known:],
            period=0.0,
            states=(*motion(), *numbered("speed", n, "rad/s")),
            inputs=numbered("command", n, "rad/s"),
            outputs=(*motion(), *numbered("thrust", n, "N"), *numbered("speed", n, "rad/s")),
            trim=trim,
        )
