"""The state of charge of a battery, as far as voltage and current at its terminals tell it.

Current over time tells how much the charge falls, and nothing of where it began. The voltage tells
where it is: with the resistance times the current added it is that without load, and the charge is
where the battery's curve has that. It is noisy, and where the curve is flat it tells little. So a
current is counted, and a fixed share of what the voltage says otherwise is taken in at each update:
an observer of first order. Where the curve's slope changes from a to b, noise of the deviation s
leaves a mean error of 0.4 s (1/b - 1/a): 1.5 % for 0.1 V and slopes of 1.5 and 3.5 V.

All of it in plain floats; a pack is a `plant.battery.BatteryPack`.
"""

import math

from workbench.plant.vehicle import BatteryPack

SETTLING_TIME = 60.0
"""An error of the charge falls by the factor e in this time [s]: a voltage with noise of 0.1 V at
8 Hz on a curve of 3 V leaves 0.1 % of noise."""


def open_circuit(charge: float, pack: BatteryPack) -> float:
    """Return the voltage without load at a charge, 0 .. 1 [V]."""
    points = pack.open_circuit_voltage
    for (q_0, u_0), (q_1, u_1) in zip(points[:-1], points[1:], strict=True):
        if charge <= q_1:
            return u_0 + (u_1 - u_0) * max(0.0, charge - q_0) / (q_1 - q_0)
    return points[-1][1]


def charge_by_voltage(voltage: float, current: float, pack: BatteryPack, near: float) -> float:
    """Return the charge that a voltage under load tells.

    Beyond its ends the curve goes on as it came: a noisy voltage of a full battery may tell more
    than 1. Were that cut, its noise would lower the mean.

    Args:
        voltage: at the terminals [V].
        current: that is drawn [A].
        pack: whose resistance and curve count.
        near: where the curve is level all of its charges have that voltage: the one nearest to this
            is returned.
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
        charge: at its begin, as it was known, 0 .. 1.
        voltage: at the terminals then [V].
        current: that is drawn from then on [A].
        pack: what is known of the battery.
        dt: to the next update [s].
    """
    told = charge_by_voltage(voltage, current, pack, charge)
    charge += (1.0 - math.exp(-dt / SETTLING_TIME)) * (told - charge)
    return min(max(charge - current * dt / pack.capacity, 0.0), 1.0)
