"""A push on the body: a force in W at a point of the body, and a torque in B, for a time.

Its impulse is exact: in the control period in which it begins or ends it acts with the share of the
period that it lasts.
"""

from typing import NamedTuple

from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.dynamics.air.update import push_share
from workbench.systems.discrete_system import DiscreteSystem


class PushSettings(NamedTuple):
    """Live parameters of a push; see `workbench params`."""

    push_x: float = 0.0
    push_y: float = 0.0
    push_z: float = 0.0
    push_at_x: float = 0.0
    push_at_y: float = 0.0
    push_at_z: float = 0.0
    push_torque_x: float = 0.0
    push_torque_y: float = 0.0
    push_torque_z: float = 0.0
    push_start: float = 0.0
    push_duration: float = 0.1


class Push(DiscreteSystem):
    """The push of the present control period.

    Output port, which is state:
        push (9): force in W [N], its point in B [m], and torque in B [N·m].
    Numeric parameter 0: `PushSettings`.

    Args:
        settings: initial ones.
        period: of control [s].
    """

    def __init__(self, *, settings: PushSettings, period: float) -> None:
        super().__init__()
        self._period = period
        self.DeclareNumericParameter(BasicVector(list(settings)))
        self.DeclareStateOutputPort("push", self.DeclareDiscreteState(9))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        push = PushSettings(*context.get_numeric_parameter(0).value().tolist())
        share = push_share(context.get_time(), self._period, push.push_start, push.push_duration)
        if share > 0.0:
            values = [share * value for value in push[:9]]
            values[3:6] = push[3:6]
            discrete_state.set_value(values)
        elif discrete_state.value(0).any():
            discrete_state.set_value([0.0] * 9)
