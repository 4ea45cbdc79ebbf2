"""Which rotor carries more than its share: added weights, cut and weak propellers.

It takes commands alone. In a hover the rotors' thrusts balance the drone, whatever the law:

    the moment of weight: a rotor near which a weight hangs, or that gives less thrust than it is
    told to, is told to give more than the rotor across;
    the drag torque: a propeller that gives less torque over its thrust, as one whose tips are cut
    does, has its pair, which turns the same way, told to give more than the other rotors.

Rotors across each other and pairs are compared, and not neighbours. One stands out where its
interval of 95 %, from the means of seconds, lies above what normal flights of a Crazyflie show.
Some normal drones differ by more: a finding is a reason to look at the rotor, and no proof. Where
the pair alone stands out, which of the two it is rests on the little by which one gives more.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_erosion, uniform_filter1d
from scipy.stats import t as student

from workbench.common.errors import WorkbenchError
from workbench.plant.vehicle import Vehicle

MAX_OPPOSITE_RATIO = 1.107
"""Largest thrust over that of the rotor across in two normal flights, one each of two Crazyflies of
CrazyPAD; neither of them alone has both limits."""
MAX_PAIR_RATIO = 1.232
"""Likewise of a pair over the others."""
TRIM_BLOCK_S = 1.0
"""In which shares hang together [s]."""
SHARE_THRUST_EXPONENT = 1.68
"""Of thrust over a command that is a share of the voltage: 1.52 to 1.83 on flights of a Crazyflie;
that over a speed is 2."""
MIN_TRIM_COMMAND_SHARE = 1e-3
"""Share of the largest command that a rotor has at least, so that ratios are numbers."""
MIN_TRIM_HOVER_S = 5.0
"""[s]."""
TRIM_EDGE_S = 1.5
"""Time after take-off and before landing that is left out [s]."""


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
    vehicle: Vehicle,
    time: np.ndarray,
    commands: np.ndarray,
    exponent: float = SHARE_THRUST_EXPONENT,
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
    if good.sum() < MIN_TRIM_HOVER_S * rate:
        raise WorkbenchError(
            f"there are {good.sum() / rate:.1f} s of flight: {MIN_TRIM_HOVER_S:g} s are the least"
        )
    thrusts = np.maximum(commands[good], MIN_TRIM_COMMAND_SHARE * commands.max()) ** exponent
    means = thrusts.mean(axis=0)
    many = int(len(thrusts) / (TRIM_BLOCK_S * rate))
    seconds = np.array([each.mean(axis=0) for each in np.array_split(thrusts, many)])
    shares = means / means.mean()
    found = []
    for i, rotor in enumerate(vehicle.rotors):
        pair = [i, across[i]]
        over, least_over = _thrust_ratio(seconds[:, i], seconds[:, across[i]])
        twist, least_twist = _thrust_ratio(
            seconds[:, pair].mean(axis=1), np.delete(seconds, pair, axis=1).mean(axis=1)
        )
        finding = _finding(over, least_over, least_twist)
        found.append(RotorTrim(rotor.name, float(shares[i]), over, twist, finding))
    return found


def _thrust_ratio(one: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Return the ratio of two thrusts (N), and the low end of its interval of 95 %."""
    ratio = float(np.log(one.mean() / other.mean()))
    spread = float(np.std(np.log(one / other), ddof=1)) / math.sqrt(len(one))
    return math.exp(ratio), math.exp(ratio - float(student.ppf(0.975, len(one) - 1)) * spread)


def _finding(over: float, least_over: float, least_twist: float) -> str:
    """Return what is suspected of a rotor: of two across each other of the one that gives more."""
    if over <= 1.0:
        return ""
    if least_over > MAX_OPPOSITE_RATIO and least_twist > MAX_PAIR_RATIO:
        return "+ carries more, and its pair turns the drone less: cut propeller, or a heavy weight"
    if least_over > MAX_OPPOSITE_RATIO:
        return "+ carries more: a weight or the battery nearer to it, or its propeller gives less"
    if least_twist > MAX_PAIR_RATIO:
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
        raise WorkbenchError(f"{vehicle.name}: its rotors are not in opposite pairs")
    return found


def _hovers(mean: np.ndarray, rate: float) -> np.ndarray:
    """Return where motors run as in flight (N), without its ends."""
    steady = uniform_filter1d(mean, max(1, round(rate)))
    flies = steady > 0.5 * np.median(mean[mean > 0.05 * max(mean.max(), 1e-12)])
    return np.asarray(binary_erosion(flies, np.ones(2 * round(TRIM_EDGE_S * rate) + 1)))
