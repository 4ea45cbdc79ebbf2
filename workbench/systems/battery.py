"""The battery: charge falls with the rotors' power, and voltage with charge and current.

The voltage without load follows from the charge by the description's curve. Under load it is lower
by resistance times current, as in gz-sim's LinearBatteryPlugin. The current that empties the
capacity at the rate of the charge is capacity P / P_hover / duration, see `Battery`. So the model
needs only capacity, resistance and the duration of a hover, and no motor efficiency. The effect of
the voltage on the rotors is in `systems.rotors`.

The flight computer estimates the charge from voltage and current at the terminals with a
first-order observer. It integrates the current, and at each update corrects a fixed share of the
difference from the charge that the voltage gives: the voltage plus resistance times current is that
without load, and the battery's curve gives its charge. The correction is slow because the voltage
is noisy, and says little where the curve is flat. Where the curve's slope changes from a to b,
noise of standard deviation s leaves a mean error of 0.4 s (1/b - 1/a): 1.5 % for 0.1 V and slopes
of 1.5 and 3.5 V.
"""

import math

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.plant.vehicle import BatteryPack, Vehicle
from workbench.systems.discrete_system import DiscreteSystem

BATTERY_PERIOD_S = 0.125
"""Between updates [s]; a battery is slow."""
CHARGE_SETTLING_TIME_S = 60.0
"""An error of the charge falls by the factor e in this time [s]: a voltage with noise of 0.1 V at
8 Hz on a curve of 3 V leaves 0.1 % of noise."""


class Battery(DiscreteSystem):
    """Charge (0 .. 1) that lasts a given time in hover.

    Power is proportional to thrust^(3/2) (momentum theory). With P the sum of thrust^(3/2) over the
    rotors, d(charge)/dt = -P / P_hover / duration.

    Input ports:
        thrusts (n): of the rotors at rest far from the ground [N].
        open_circuit (1): voltage without load over that of the full battery, as the sag
            compensation assumes it; the true one if unconnected.
    Output ports:
        charge (1), 1 full, 0 empty.
        supply (4): see `systems.rotors`.
        terminals (2): voltage under load [V] and current [A]; only if the vehicle has a battery.
    Numeric parameter 0: duration in hover [s], and the share of sag that is compensated.
    """

    def __init__(self, *, vehicle: Vehicle, duration: float, compensation: float = 0.0) -> None:
        super().__init__()
        n = len(vehicle.rotors)
        self._hover_power = hover_power(vehicle)
        self._pack = vehicle.battery
        self._curve, self._drop = voltage_curve(vehicle), voltage_drop(vehicle, 1.0)
        self.DeclareNumericParameter(BasicVector([duration, compensation]))
        self._thrusts = self.DeclareVectorInputPort("thrusts", n)
        self._known = self.DeclareVectorInputPort("open_circuit", 1)
        self.DeclareStateOutputPort("charge", self.DeclareDiscreteState([1.0]))
        needs = {self.xd_ticket(), self.all_parameters_ticket()}
        self.DeclareVectorOutputPort("supply", 4, self._calc_supply, needs | {self._known.ticket()})
        if self._pack:
            self.DeclareVectorOutputPort(
                "terminals", 2, self._calc_terminals, needs | {self._thrusts.ticket()}
            )
        self.DeclarePeriodicDiscreteUpdateEvent(BATTERY_PERIOD_S, 0.0, self._update)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        charge = context.get_discrete_state(0).CopyToVector()[0]
        duration = context.get_numeric_parameter(0).CopyToVector()[0]
        thrusts = self._thrusts.Eval(context).tolist()
        discrete_state.set_value([self.charge_after(charge, thrusts, duration)])

    def charge_after(self, charge: float, thrusts: list[float], duration: float) -> float:
        """Return the charge after a period, 0 .. 1.

        Args:
            charge: before it.
            thrusts: of the rotors at rest far from the ground (n) [N].
            duration: that a full battery hovers [s].
        """
        used = BATTERY_PERIOD_S * _power(thrusts) / self._hover_power / duration
        return max(0.0, charge - used)

    def supply_at(self, charge: float, duration: float, compensation: float) -> list[float]:
        """Return the supply (4), see `systems.rotors`, if the true charge is known.

        Args:
            charge: 0 .. 1.
            duration: that a full battery hovers [s].
            compensation: share of its sag that is compensated.
        """
        open_circuit = float(np.interp(charge, self._curve[:, 0], self._curve[:, 1]))
        return [open_circuit, self._drop / duration, compensation, open_circuit]

    def _calc_supply(self, context: Context, output: BasicVector) -> None:
        charge = context.get_discrete_state(0).CopyToVector()[0]
        duration, compensation = context.get_numeric_parameter(0).CopyToVector()
        supply = self.supply_at(charge, duration, compensation)
        if self._known.HasValue(context):
            supply[3] = self._known.Eval(context)[0]
        output.SetFromVector(supply)

    def _calc_terminals(self, context: Context, output: BasicVector) -> None:
        assert self._pack
        charge = context.get_discrete_state(0).CopyToVector()[0]
        duration = context.get_numeric_parameter(0).CopyToVector()[0]
        power = _power(self._thrusts.Eval(context).tolist())
        current = self._pack.capacity * power / self._hover_power / duration
        full = self._pack.open_circuit_voltage[-1][1]
        open_circuit = full * np.interp(charge, self._curve[:, 0], self._curve[:, 1])
        output.SetFromVector([max(0.0, open_circuit - self._pack.resistance * current), current])


def _power(thrusts: list[float]) -> float:
    """Return the sum of thrusts to the 3/2 [N^3/2]."""
    return float(sum(thrust**1.5 for thrust in thrusts))


def hover_power(vehicle: Vehicle) -> float:
    """Return the sum of the rotors' thrusts to the 3/2 in hover [N^3/2]."""
    turning = zip(vehicle.rotors, vehicle.hover_speeds, strict=True)
    return float(sum((r.motor_constant * w * (w + r.linear_speed)) ** 1.5 for r, w in turning))


def voltage_curve(vehicle: Vehicle) -> np.ndarray:
    """Return charge, and voltage without load over that of the full battery, in rows (m, 2)."""
    if vehicle.battery is None:
        return np.array([[0.0, 1.0], [1.0, 1.0]])
    points = np.array(vehicle.battery.open_circuit_voltage)
    points[:, 1] /= points[-1, 1]
    return points


def voltage_drop(vehicle: Vehicle, duration: float) -> float:
    """Return the voltage drop per power of the rotors [N^-3/2], see `rotors.loaded_voltage`.

    Args:
        vehicle: has the battery; without one the result is 0.
        duration: of a hover on the full battery [s].
    """
    pack = vehicle.battery
    if pack is None:
        return 0.0
    hover_current = pack.capacity / duration
    full = pack.open_circuit_voltage[-1][1]
    return pack.resistance * hover_current / full / hover_power(vehicle)


class ChargeGauge(DiscreteSystem):
    """Estimates the state of charge, see `next_charge`, at the period of the battery.

    It starts with a full battery, as a flight does.

    Input ports:
        terminals (2): voltage under load [V] and current [A] of the battery.
        noise (1): a new standard normal number for each update.
    Output ports:
        charge (1): estimate, 0 .. 1.
        open_circuit (1): voltage without load at that charge, over that of the full battery.
        voltage (1): the same under the present current; not below 0.
    Numeric parameter 0: standard deviation of the measured voltage [V].

    Args:
        pack: the known properties of the battery.
        voltage_noise: initial value of the parameter [V].
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
        self.DeclarePeriodicDiscreteUpdateEvent(BATTERY_PERIOD_S, 0.0, self._update)

    def _charge(self, context: Context) -> float:
        return float(context.get_discrete_state(0)[0])

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        voltage, current = self._terminals.Eval(context).tolist()
        deviation = float(context.get_numeric_parameter(0)[0])
        if deviation > 0.0:
            voltage += deviation * float(self.noise_input.Eval(context)[0])
        found = next_charge(self._charge(context), voltage, current, self._pack, BATTERY_PERIOD_S)
        discrete_state.set_value([found])

    def _calc_open_circuit(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector([open_circuit(self._charge(context), self._pack) / self._full])

    def _calc_voltage(self, context: Context, output: BasicVector) -> None:
        current = float(self._terminals.Eval(context)[1])
        rest = open_circuit(self._charge(context), self._pack)
        output.SetFromVector([max(0.0, rest - self._pack.resistance * current) / self._full])


def open_circuit(charge: float, pack: BatteryPack) -> float:
    """Return the voltage without load at a charge, 0 .. 1 [V]."""
    points = pack.open_circuit_voltage
    for (q_0, u_0), (q_1, u_1) in zip(points[:-1], points[1:], strict=True):
        if charge <= q_1:
            return u_0 + (u_1 - u_0) * max(0.0, charge - q_0) / (q_1 - q_0)
    return points[-1][1]


def charge_by_voltage(voltage: float, current: float, pack: BatteryPack, near: float) -> float:
    """Return the charge for a voltage under load.

    The curve is extrapolated linearly, so a noisy voltage of a full battery may give more than 1.
    With a limit at 1, noise would lower the mean.

    Args:
        voltage: at the terminals [V].
        current: of the battery [A].
        pack: its resistance and curve are used.
        near: if the curve is flat at this voltage, the charge nearest to this value is returned.
    """
    points = pack.open_circuit_voltage
    rest = voltage + pack.resistance * current
    least, most = math.inf, -math.inf
    last = len(points) - 2
    for number, ((q_0, u_0), (q_1, u_1)) in enumerate(zip(points[:-1], points[1:], strict=True)):
        above, below = rest >= u_0 or number == 0, rest <= u_1 or number == last
        if not (above and below):
            continue
        if u_0 == u_1:
            least, most = min(least, q_0), max(most, q_1)
        else:
            charge = q_0 + (q_1 - q_0) * (rest - u_0) / (u_1 - u_0)
            least, most = min(least, charge), max(most, charge)
    return min(max(near, least), most)


def next_charge(
    charge: float, voltage: float, current: float, pack: BatteryPack, dt: float
) -> float:
    """Return the charge after an update, 0 .. 1.

    Args:
        charge: estimate before the update, 0 .. 1.
        voltage: at the terminals [V].
        current: until the next update [A].
        pack: the known properties of the battery.
        dt: to the next update [s].
    """
    measured = charge_by_voltage(voltage, current, pack, charge)
    charge += (1.0 - math.exp(-dt / CHARGE_SETTLING_TIME_S)) * (measured - charge)
    return min(max(charge - current * dt / pack.capacity, 0.0), 1.0)
