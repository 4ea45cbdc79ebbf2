"""What a flight computer makes of its battery's voltage and current, as a LeafSystem."""

from pydrake.common import RandomDistribution
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from workbench.estimation.charge import next_charge, open_circuit
from workbench.plant.vehicle import BatteryPack
from workbench.systems.battery import PERIOD


class ChargeGauge(LeafSystem):
    """Estimates the state of charge, see `estimation.charge`, as often as the battery discharges.

    It begins with a full battery, as a flight does.

    Input ports:
        terminals (2): voltage under load [V] and current [A] of the battery.
        noise (1): a standard normal number, another one for each update.
    Output ports:
        charge (1): as it is known, 0 .. 1.
        open_circuit (1): voltage without load at that charge, over that of the full battery.
        voltage (1): what it is under the present current, over that of the full battery without
            load; not below 0.
    Numeric parameter 0: deviation of the measured voltage [V].

    Args:
        pack: what is known of the battery.
        voltage_noise: to begin with [V].
    """

    def __init__(self, *, pack: BatteryPack, voltage_noise: float = 0.0) -> None:
        super().__init__()
        self._pack, self._full = pack, pack.open_circuit_voltage[-1][1]
        self.DeclareNumericParameter(BasicVector([voltage_noise]))
        self._terminals = self.DeclareVectorInputPort("terminals", 2)
        self.noise_input = self.DeclareVectorInputPort("noise", 1, RandomDistribution.kGaussian)
        self.DeclareStateOutputPort("charge", self.DeclareDiscreteState([1.0]))
        known = {self.xd_ticket()}
        self.DeclareVectorOutputPort("open_circuit", 1, self._calc_open_circuit, known)
        needs = known | {self._terminals.ticket()}
        self.DeclareVectorOutputPort("voltage", 1, self._calc_voltage, needs)
        self.DeclarePeriodicDiscreteUpdateEvent(PERIOD, 0.0, self._update)

    def _charge(self, context: Context) -> float:
        return float(context.get_discrete_state(0)[0])

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        voltage, current = self._terminals.Eval(context).tolist()
        deviation = float(context.get_numeric_parameter(0)[0])
        if deviation > 0.0:
            voltage += deviation * float(self.noise_input.Eval(context)[0])
        found = next_charge(self._charge(context), voltage, current, self._pack, PERIOD)
        discrete_state.set_value([found])

    def _calc_open_circuit(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([open_circuit(self._charge(context), self._pack) / self._full])

    def _calc_voltage(self, context: Context, output: BasicVector) -> None:
        current = float(self._terminals.Eval(context)[1])
        rest = open_circuit(self._charge(context), self._pack)
        output.SetFromVector([max(0.0, rest - self._pack.resistance * current) / self._full])
