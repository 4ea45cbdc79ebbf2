"""The mixer for a vehicle with stopped rotors: the nearest wrench that the others can make.

Fixed allocation columns do not work here: a hexacopter without one of its rotors hovers with the
opposite one at rest and the others far from equal. This mixer solves a least-squares problem:

    minimise  |f|² / 2 + sum over rows of (wanted - made)² / (2 soft),  0 <= f <= most

with thrusts f, and `soft` [N² or (N·m)²] smallest for tilt, larger for force and largest for yaw,
so that yaw is given up before force, and force before tilt. The dual problem has only four
unknowns, a price for each row of the wrench. A rotor's thrust is its column times the prices,
clipped to its limits. Newton's method with an exact line search finds the prices in about five
steps. Source for weighted least squares with limits: O. Härkegård, "Efficient active set algorithms
for solving constrained least squares problems in aircraft control allocation", 2002.

The smallest thrust is 0 here, not idle: if the hexacopter's opposite rotor idled, the yaw rate
would grow without limit.

Pure arithmetic on scalars, so the same source works with floats, AutoDiffXd and numba.
"""

from collections.abc import MutableSequence, Sequence
from typing import Any

from workbench.common.jitable import Scalar, register_jitable

SOFT_TILT = 1e-11
SOFT_FORCE = 1e-7
SOFT_YAW = 1e-3
"""Relative to a row's sum of squares; far enough apart for strict priorities."""
ROUNDS = 4
"""Corrections of the error that softness leaves: yaw once, force twice, tilt every time."""
STEPS = 40
"""Largest number of Newton steps; twice the largest one seen."""
ROUNDING = 1e-18
"""A smaller gain of a step is rounding, relative to squared thrusts."""
FULL_STEP = 1e-9
"""A share of a Newton step this near to 1 met no limit."""


@register_jitable
def any_stopped(shares: Sequence[Any]) -> bool:
    """Return whether any rotor has stopped."""
    for i in range(len(shares)):  # noqa: SIM110 - numba compiles a loop faster
        if shares[i] == 0.0:
            return True
    return False


@register_jitable
def mix_without(
    force: Scalar,
    moment_x: Scalar,
    moment_y: Scalar,
    moment_z: Scalar,
    effects: Sequence[Sequence[float]],
    most: Sequence[Any],
    thrusts: MutableSequence[Scalar],
) -> None:
    """Write the thrusts [N] that make a wrench into `thrusts`, or the nearest possible ones.

    Tilt and force are exact if possible; otherwise tilt has priority, then force, then yaw. Unlike
    with all rotors, the tilting moment may change its direction, because some directions may be
    impossible.

    Args:
        force: along body z [N].
        moment_x: about the centre of mass, in B [N·m]; so `moment_y`, `moment_z`.
        moment_y: see `moment_x`.
        moment_z: see `moment_x`.
        effects: n rows of 4, force and moments that a newton of thrust makes.
        most: n largest thrusts [N], 0 for stopped rotors.
        thrusts: n places to write to.
    """
    soft, rounding = _measures(effects, most)
    prices = (1e-6, 0.0, 0.0, 0.0)  # a little lift from each, so that all start within limits
    force_asked, x_asked, y_asked, z_asked = force, moment_x, moment_y, moment_z
    for turn in range(ROUNDS):
        asked = (force_asked, x_asked, y_asked, z_asked)
        prices = _nearest(asked, prices, soft, effects, most, rounding)
        if turn == 0:
            z_asked = moment_z + soft[3] * prices[3]
        if turn <= 1:
            force_asked = force + soft[0] * prices[0]
        x_asked = moment_x + soft[1] * prices[1]
        y_asked = moment_y + soft[2] * prices[2]
    for i in range(len(effects)):
        thrusts[i] = _cut(_pull(effects[i], prices), most[i])


@register_jitable
def _measures(effects, most):
    """Return the softness of each row, and the gain of a step that is only rounding [N²]."""
    force, tilt, yaw, scale = 0.0, 0.0, 0.0, 0.0
    for i in range(len(effects)):
        lift, roll, pitch, turn = effects[i]
        force += lift * lift
        tilt += roll * roll + pitch * pitch
        yaw += turn * turn
        scale += most[i] * most[i]
    soft = (SOFT_FORCE * force, SOFT_TILT * tilt, SOFT_TILT * tilt, SOFT_YAW * yaw)
    return soft, ROUNDING * scale


@register_jitable
def _nearest(wanted, prices, soft, effects, most, rounding):
    """Return the prices at which rotors make the wanted wrench, from initial prices."""
    for _ in range(STEPS):
        step, gain = _newton_step(wanted, prices, soft, effects, most)
        share = 1.0
        if gain > rounding:
            share = _best_share(wanted, prices, step, gain, soft, effects, most)
            if abs(share - 1.0) < FULL_STEP:
                share = 1.0
        prices = (
            prices[0] + share * step[0],
            prices[1] + share * step[1],
            prices[2] + share * step[2],
            prices[3] + share * step[3],
        )
        if share == 1.0:
            break
    return prices


@register_jitable
def _newton_step(wanted, prices, soft, effects, most):
    """Return Newton's step, which is exact if no rotor meets a limit, and its gain.

    The four equations are symmetric and definite, so elimination needs no pivoting.
    """
    r_0 = wanted[0] - soft[0] * prices[0]
    r_1 = wanted[1] - soft[1] * prices[1]
    r_2 = wanted[2] - soft[2] * prices[2]
    r_3 = wanted[3] - soft[3] * prices[3]
    h_00, h_11, h_22, h_33 = soft
    h_01, h_02, h_03, h_12, h_13, h_23 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(effects)):
        a, b, c, d = effects[i]
        pull = _pull(effects[i], prices)
        thrust = _cut(pull, most[i])
        r_0 = r_0 - a * thrust
        r_1 = r_1 - b * thrust
        r_2 = r_2 - c * thrust
        r_3 = r_3 - d * thrust
        if 0.0 < pull < most[i]:
            h_00, h_01, h_02, h_03 = h_00 + a * a, h_01 + a * b, h_02 + a * c, h_03 + a * d
            h_11, h_12, h_13 = h_11 + b * b, h_12 + b * c, h_13 + b * d
            h_22, h_23, h_33 = h_22 + c * c, h_23 + c * d, h_33 + d * d
    l_1, l_2, l_3 = h_01 / h_00, h_02 / h_00, h_03 / h_00
    h_11, h_12, h_13 = h_11 - l_1 * h_01, h_12 - l_1 * h_02, h_13 - l_1 * h_03
    h_22, h_23, h_33 = h_22 - l_2 * h_02, h_23 - l_2 * h_03, h_33 - l_3 * h_03
    k_2, k_3 = h_12 / h_11, h_13 / h_11
    h_22, h_23, h_33 = h_22 - k_2 * h_12, h_23 - k_2 * h_13, h_33 - k_3 * h_13
    m_3 = h_23 / h_22
    h_33 = h_33 - m_3 * h_23
    y_1 = r_1 - l_1 * r_0
    y_2 = r_2 - l_2 * r_0 - k_2 * y_1
    y_3 = r_3 - l_3 * r_0 - k_3 * y_1 - m_3 * y_2
    x_3 = y_3 / h_33
    x_2 = y_2 / h_22 - m_3 * x_3
    x_1 = y_1 / h_11 - k_2 * x_2 - k_3 * x_3
    x_0 = r_0 / h_00 - l_1 * x_1 - l_2 * x_2 - l_3 * x_3
    return (x_0, x_1, x_2, x_3), r_0 * x_0 + r_1 * x_1 + r_2 * x_2 + r_3 * x_3


@register_jitable
def _best_share(wanted, prices, step, gain, soft, effects, most):
    """Return the share of a step at which its gain becomes zero.

    The gain falls along the step, linearly between the limits of rotors.
    """
    low, gain_low = 0.0, gain
    high, gain_high = -1.0, gain  # below zero: none known yet
    for i in range(len(effects)):
        pull, change = _pull(effects[i], prices), _pull(effects[i], step)
        for limit in (0.0 * most[i], most[i]):
            if change != 0.0:
                share = (limit - pull) / change
                if share > low and (high < 0.0 or share < high):
                    slope = _slope(wanted, prices, step, share, soft, effects, most)
                    if slope > 0.0:
                        low, gain_low = share, slope
                    else:
                        high, gain_high = share, slope
    if high < 0.0:
        high = low + 1.0
        gain_high = _slope(wanted, prices, step, high, soft, effects, most)
    return low + (high - low) * gain_low / (gain_low - gain_high)


@register_jitable
def _slope(wanted, prices, step, share, soft, effects, most):
    """Return the gain per share of a step, at a share of it."""
    slope = 0.0
    for row in range(4):
        price = prices[row] + share * step[row]
        slope = slope + step[row] * (wanted[row] - soft[row] * price)
    for i in range(len(effects)):
        change = _pull(effects[i], step)
        slope = slope - change * _cut(_pull(effects[i], prices) + share * change, most[i])
    return slope


@register_jitable
def _pull(effect, prices):
    """Return a rotor's thrust at given prices, without limits [N]."""
    a, b, c, d = effect
    return a * prices[0] + b * prices[1] + c * prices[2] + d * prices[3]


@register_jitable
def _cut(thrust, most):
    """Return a thrust clipped to its limits."""
    if thrust > most:
        thrust = most
    if thrust <= 0.0:
        thrust = 0.0  # a float, not AutoDiffXd: its root has no derivative
    return thrust
