"""The mixer: from a wanted force and moment to rotor thrusts within their limits.

Without saturation, thrusts = allocation · (F, m_x, m_y, m_z). With saturation, priority goes to
tilt, then force, then yaw. Joints that tilt rotors count as more rotors, with angles for thrusts.

Pure arithmetic on scalars, so the same source works with floats, AutoDiffXd and numba.
"""

from collections.abc import Sequence

from workbench.common.jitable import register_jitable
from workbench.common.vectors import MutableNumbers, Numbers


@register_jitable(forceinline=True)
def mix(
    force: float,
    moment_x: float,
    moment_y: float,
    moment_z: float,
    allocation: Sequence[Numbers],
    thrust_min: Numbers,
    thrust_max: Numbers,
    thrusts: MutableNumbers,
) -> None:
    """Write the n thrusts [N] and m tilts [rad] that make a wrench, or the nearest possible ones.

    If rotors saturate, the tilting moment has priority (it keeps the drone upright), then force;
    yaw gets the rest. The tilting moment keeps its direction and is only scaled down.

    Args:
        force: along z of T [N], the frame of upright hover, see `plant.thrust_frame`.
        moment_x: about the centre of mass, in T [N·m]; so `moment_y`, `moment_z`.
        moment_y: see `moment_x`.
        moment_z: see `moment_x`.
        allocation: n rows of 4 from a wrench to thrusts, then m to angles of tilts, see
            `LawConstants`.
        thrust_min: n limits [N], then m [rad].
        thrust_max: likewise.
        thrusts: n + m places to write to.
    """
    saturated = False
    for i in range(len(allocation)):
        lift, roll, pitch, yaw = allocation[i]
        thrust = lift * force + roll * moment_x + pitch * moment_y + yaw * moment_z
        if thrust > thrust_max[i] or thrust < thrust_min[i]:
            saturated = True
        thrusts[i] = thrust
    if saturated:
        tilt = _tilt_share(moment_x, moment_y, allocation, thrust_min, thrust_max)
        for i in range(len(allocation)):  # thrusts of the tilting moment alone, for now
            thrusts[i] = tilt * (allocation[i][1] * moment_x + allocation[i][2] * moment_y)
        _add_force(force, allocation, thrust_min, thrust_max, thrusts)
        _add_yaw(moment_z, allocation, thrust_min, thrust_max, thrusts)


@register_jitable
def _tilt_share(
    moment_x: float,
    moment_y: float,
    allocation: Sequence[Numbers],
    thrust_min: Numbers,
    thrust_max: Numbers,
) -> float:
    """Return the largest share of the tilting moment that is possible with any total force."""
    tilt = 1.0
    for high in range(len(allocation)):
        for low in range(len(allocation)):
            a, most = allocation[high], thrust_max[high]
            b, least = allocation[low], thrust_min[low]
            up = 1.0 if a[0] >= 0.0 else -1.0  # a tilt may turn back as the force grows
            down = 1.0 if b[0] >= 0.0 else -1.0
            if a[0] < 0.0:
                most = -thrust_min[high]
            if b[0] < 0.0:
                least = -thrust_max[low]
            lift, other = up * a[0], down * b[0]
            spread = up * (a[1] * moment_x + a[2] * moment_y) * other
            spread = spread - down * (b[1] * moment_x + b[2] * moment_y) * lift
            room = most * other - least * lift
            if spread > 0.0 and tilt * spread > room:
                tilt = room / spread
    return tilt


@register_jitable
def _add_force(
    force: float,
    allocation: Sequence[Numbers],
    thrust_min: Numbers,
    thrust_max: Numbers,
    thrusts: MutableNumbers,
) -> None:
    """Add the force nearest to the wanted one that keeps every rotor within its limits."""
    for i in range(len(allocation)):  # upper bounds of the force
        own, bound = allocation[i][0], thrust_max[i]
        if own < 0.0:
            own, bound = -own, -thrust_min[i]
            if own * force - thrusts[i] > bound:
                force = (bound + thrusts[i]) / own
        elif own > 0.0 and own * force + thrusts[i] > bound:
            force = (bound - thrusts[i]) / own
    for i in range(len(allocation)):  # and lower ones
        own, bound = allocation[i][0], thrust_min[i]
        if own < 0.0:
            own, bound = -own, -thrust_max[i]
            if own * force - thrusts[i] < bound:
                force = (bound + thrusts[i]) / own
        elif own > 0.0 and own * force + thrusts[i] < bound:
            force = (bound - thrusts[i]) / own
    for i in range(len(allocation)):
        thrusts[i] = thrusts[i] + allocation[i][0] * force


@register_jitable
def _add_yaw(
    moment_z: float,
    allocation: Sequence[Numbers],
    thrust_min: Numbers,
    thrust_max: Numbers,
    thrusts: MutableNumbers,
) -> None:
    """Add as much of the yaw moment as the remaining room allows."""
    yaw = 1.0
    for i in range(len(allocation)):
        own = allocation[i][3] * moment_z
        room = thrust_max[i] - thrusts[i]
        if own < 0.0:
            own = -own
            room = thrusts[i] - thrust_min[i]
        if room < 0.0:  # by rounding: force and tilt have used it up
            room = 0.0
        if yaw * own > room:
            yaw = room / own
    for i in range(len(allocation)):
        thrusts[i] = thrusts[i] + yaw * allocation[i][3] * moment_z
