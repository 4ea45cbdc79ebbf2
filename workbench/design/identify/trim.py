"""Which rotor carries more than its share: added weights, cut and weak propellers.

It takes commands alone. In a hover the rotors' thrusts balance the drone, whatever the law:

    the moment of weight: a rotor near which a weight hangs, or that gives less thrust than it is
    told to, is told to give more than the rotor across;
    the drag torque: a propeller that gives less torque over its thrust, as one whose tips are cut
    does, has its pair, which turns the same way, told to give more than the other rotors.

Rotors across each other and pairs are compared, and not neighbours: normal drones differ by up to a
quarter between any two motors, but by a tenth across, and by a fifth between pairs.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_erosion, uniform_filter1d

from workbench.common.errors import WorkbenchError
from workbench.plant.vehicle import Vehicle

HEAVY = 1.13
"""Thrust over that of the rotor across from which on one is suspected."""
TWISTED = 1.28
"""Thrust of a pair over that of the others from which on a propeller of it is suspected."""
EXPONENT = 1.68
"""Of thrust over a command that is a share of the voltage: 1.52 to 1.83 on flights of a Crazyflie;
that over a speed is 2."""
LEAST_HOVER = 5.0
"""[s]."""
EDGE = 1.5
"""After take-off and before landing that does not count [s]."""


@dataclass(frozen=True)
class RotorTrim:
    """A rotor in hover.

    Attributes:
        name: of the description.
        share: its thrust over the mean of all.
        over_opposite: its thrust over that of the rotor across.
        pair_over_others: mean thrust of it and the rotor across, over that of all others.
        finding: what is suspected, "" for nothing.
    """

    name: str
    share: float
    over_opposite: float
    pair_over_others: float
    finding: str


def trim(
    vehicle: Vehicle, time: np.ndarray, commands: np.ndarray, exponent: float = EXPONENT
) -> list[RotorTrim]:
    """Return what each rotor does in hover.

    Args:
        vehicle: whose rotors stand across each other in pairs.
        time: (N) [s].
        commands: (N, n) shares of the full voltage, or speeds.
        exponent: of thrust over them.

    Raises:
        WorkbenchError: if there is too little, or no rotor stands across another.
    """
    rate = 1.0 / float(np.median(np.diff(time)))
    across = opposites(vehicle)
    good = _hovers(commands.mean(axis=1), rate)
    if good.sum() < LEAST_HOVER * rate:
        raise WorkbenchError(
            f"there are {good.sum() / rate:.1f} s of flight: {LEAST_HOVER:g} s are the least"
        )
    thrusts = np.maximum(commands[good], 0.0) ** exponent
    shares = thrusts.mean(axis=0) / thrusts.mean()
    found = []
    for i, rotor in enumerate(vehicle.rotors):
        pair = [i, across[i]]
        over = float(shares[i] / shares[across[i]])
        twist = float(shares[pair].mean() / np.delete(shares, pair).mean())
        found.append(RotorTrim(rotor.name, float(shares[i]), over, twist, _finding(over, twist)))
    return found


def _finding(over: float, twist: float) -> str:
    """Return what is suspected of a rotor: of two across each other of the one that gives more."""
    if over <= 1.0:
        return ""
    if over >= HEAVY and twist >= TWISTED:
        return "+ carries more, and its pair turns the drone less: cut propeller, or a heavy weight"
    if over >= HEAVY:
        return "+ carries more: a weight near it, or its propeller gives less"
    if twist >= TWISTED:
        return "+ its pair turns the drone less than it should: its propeller is cut or damaged"
    return ""


def opposites(vehicle: Vehicle) -> Sequence[int]:
    """Return for each rotor the number of the one across.

    Raises:
        WorkbenchError: if rotors do not stand in pairs across each other.
    """
    places = np.array([rotor.p_BR[:2] for rotor in vehicle.rotors])
    places = places - places.mean(axis=0)
    gaps = np.linalg.norm(places[:, None, :] + places[None, :, :], axis=2)
    found = [int(each) for each in gaps.argmin(axis=1)]
    near = all(gaps[i, j] < 0.2 * vehicle.span for i, j in enumerate(found))
    if not near or any(found[j] != i for i, j in enumerate(found)):
        raise WorkbenchError(f"{vehicle.name}: its rotors do not stand across each other in pairs")
    return found


def _hovers(mean: np.ndarray, rate: float) -> np.ndarray:
    """Return where motors run as in flight (N), without its ends."""
    steady = uniform_filter1d(mean, max(1, round(rate)))
    flies = steady > 0.5 * np.median(mean[mean > 0.05 * max(mean.max(), 1e-12)])
    return np.asarray(binary_erosion(flies, np.ones(2 * round(EDGE * rate) + 1)))
