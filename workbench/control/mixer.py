"""The mixer: from a wanted force and moment to rotor thrusts within their limits.

Without saturation, thrusts = allocation · (F, m_x, m_y, m_z). With saturation, priority goes to
tilt, then force, then yaw. `stopped_rotors` replaces the mixer if a rotor has stopped.

Pure arithmetic on scalars, so the same source works with floats, AutoDiffXd and numba.
"""

from collections.abc import MutableSequence, Sequence

from workbench.common.jitable import Scalar, register_jitable


@register_jitable
def mix(
    force: Scalar,
    moment_x: Scalar,
    moment_y: Scalar,
    moment_z: Scalar,
    allocation: Sequence[Sequence[float]],
    thrust_min: Sequence[float],
    thrust_max: Sequence[float],
    thrusts: MutableSequence[Scalar],
) -> None:
    """Write the thrusts [N] that make a wrench into `thrusts`, or the nearest possible ones.

    If rotors saturate, the tilting moment has priority (it keeps the drone upright), then force;
    yaw gets the rest. The tilting moment keeps its direction and is only scaled down.

    Args:
        force: along body z [N].
        moment_x: about the centre of mass, in B [N·m]; so `moment_y`, `moment_z`.
        moment_y: see `moment_x`.
        moment_z: see `moment_x`.
        allocation: n rows of 4, from `plant.rotors.allocation_matrix`.
        thrust_min: n limits [N].
        thrust_max: n limits [N].
        thrusts: n places to write to.
    """
    saturated = False
    for i in range(len(allocation)):
        thrust = plain_thrust(force, moment_x, moment_y, moment_z, allocation[i])
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
def plain_thrust(
    force: Scalar, moment_x: Scalar, moment_y: Scalar, moment_z: Scalar, row: Sequence[float]
) -> Scalar:
    """Return a rotor's thrust for a wrench [N], without limits; `row` is of the allocation."""
    lift, roll, pitch, yaw = row
    return lift * force + roll * moment_x + pitch * moment_y + yaw * moment_z


@register_jitable
def _tilt_share(moment_x, moment_y, allocation, thrust_min, thrust_max):
    """Return the largest share of the tilting moment that is possible with any total force."""
    tilt = 1.0
    for high in range(len(allocation)):
        for low in range(len(allocation)):
            a = allocation[high]
            b = allocation[low]
            spread = (a[1] * moment_x + a[2] * moment_y) * b[0]
            spread = spread - (b[1] * moment_x + b[2] * moment_y) * a[0]
            room = thrust_max[high] * b[0] - thrust_min[low] * a[0]
            if spread > 0.0 and tilt * spread > room:
                tilt = room / spread
    return tilt


@register_jitable
def _add_force(force, allocation, thrust_min, thrust_max, thrusts):
    """Add the force nearest to the wanted one that keeps every rotor within its limits."""
    for i in range(len(allocation)):
        if allocation[i][0] * force + thrusts[i] > thrust_max[i]:
            force = (thrust_max[i] - thrusts[i]) / allocation[i][0]
    for i in range(len(allocation)):
        if allocation[i][0] * force + thrusts[i] < thrust_min[i]:
            force = (thrust_min[i] - thrusts[i]) / allocation[i][0]
    for i in range(len(allocation)):
        thrusts[i] = thrusts[i] + allocation[i][0] * force


@register_jitable
def _add_yaw(moment_z, allocation, thrust_min, thrust_max, thrusts):
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
