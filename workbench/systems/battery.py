"""The battery: charge falls with the power the rotors draw."""

from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from workbench.plant.vehicle import Vehicle

PERIOD = 0.125
"""Between updates [s]; a battery is slow."""


class Battery(LeafSystem):
    """Charge (0 .. 1) that lasts a given time in hover.

    Power in hover goes with thrust to the 3/2 (momentum theory), so with P the sum of
    thrust^(3/2) over rotors, d(charge)/dt = -P / P_hover / duration.

    Input port:
        thrusts (n) [N].
    Output port:
        charge (1), 1 full, 0 empty.
    Numeric parameter 0: duration in hover [s].
    """

    def __init__(self, *, vehicle: Vehicle, duration: float) -> None:
        super().__init__()
        n = len(vehicle.rotors)
        constants = [rotor.motor_constant for rotor in vehicle.rotors]
        self._hover_power = sum(
            (k * w * w) ** 1.5 for k, w in zip(constants, vehicle.hover_speeds, strict=True)
        )
        self.DeclareNumericParameter(BasicVector([duration]))
        self._thrusts = self.DeclareVectorInputPort("thrusts", n)
        self.DeclareStateOutputPort("charge", self.DeclareDiscreteState([1.0]))
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        charge = context.get_discrete_state(0).CopyToVector()[0]
        duration = context.get_numeric_parameter(0).CopyToVector()[0]
        power = sum(thrust**1.5 for thrust in self._thrusts.Eval(context).tolist())
        used = PERIOD * power / self._hover_power / duration
        discrete_state.set_value([max(0.0, charge - used)])
