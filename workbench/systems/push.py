"""A push on the body: a force in W at a point of the body, and a torque in B, for a time.

Its impulse is exact: in the control period in which it begins or ends it acts with the share of the
period that it lasts.
"""

from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.dynamics.air.settings import PUSH_FIELDS, AirSettings
from workbench.dynamics.air.update import push_share
from workbench.systems.discrete_system import DiscreteSystem


class PushSystem(DiscreteSystem):
    """The push of the present control period.

    Output port, which is state:
        push (9): force in W [N], its point in B [m], and torque in B [N·m].
    Numeric parameter 0: `PUSH_FIELDS` of the settings.

    Args:
        settings: initial ones.
        period: of control [s].
    """

    def __init__(self, *, settings: AirSettings, period: float) -> None:
        super().__init__()
        self._period = period
        self.DeclareNumericParameter(BasicVector([getattr(settings, name) for name in PUSH_FIELDS]))
        self.DeclareStateOutputPort("push", self.DeclareDiscreteState(9))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        *push, start, duration = context.get_numeric_parameter(0).value().tolist()
        share = push_share(context.get_time(), self._period, start, duration)
        if share > 0.0:
            values = [share * value for value in push]
            values[3:6] = push[3:6]
            discrete_state.set_value(values)
        elif discrete_state.value(0).any():
            discrete_state.set_value([0.0] * 9)
