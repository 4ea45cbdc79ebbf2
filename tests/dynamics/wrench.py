"""The load on a vehicle, put together from the functions of `dynamics` as all that fly do."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from workbench.dynamics.air.drag import drag_force
from workbench.dynamics.rigid_body import cross, into_body, rotation
from workbench.dynamics.rotors import rotor_load, static_thrusts, turning_share
from workbench.plant.rotors import Rotor

STILL = (0.0, 0.0, 0.0)


def wrench_on(
    rotors: Sequence[Rotor],
    state: Sequence[Any],
    speeds: Sequence[Any],
    slopes: Sequence[Any] | None = None,
    shares: Sequence[float] | None = None,
    wind: Sequence[float] = STILL,
    half_drag: float = 0.0,
    center: Sequence[float] = STILL,
) -> np.ndarray:
    """Return force and moment about the origin, in B (6), of rotors and drag.

    Args:
        rotors: n of them.
        state: of the body (13).
        speeds: of the rotors (n) [rad/s].
        slopes: of their speeds (n) [rad/s²].
        shares: of their thrust that rotors give (n).
        wind: in W (3) [m/s].
        half_drag: see `drag_force`.
        center: of mass, in B (3) [m].
    """
    R_WB = rotation(state[0:4])
    w_B = into_body(R_WB, state[7:10])
    v_B = into_body(R_WB, [v - u for v, u in zip(state[10:13], wind, strict=True)])
    shares = [turning_share(share) for share in shares or [1.0] * len(rotors)]
    way = [v + s for v, s in zip(v_B, cross(w_B, center), strict=True)]
    drag = drag_force(half_drag, way)
    found = np.array([*drag, *cross(center, drag)])
    statics = static_thrusts(rotors, shares, speeds)
    each = zip(rotors, speeds, slopes or [0.0] * len(rotors), shares, statics, strict=True)
    for one in each:
        force, moment, momentum = rotor_load(*one, w_B, v_B, R_WB, state[6])
        found = found + np.array([*force, *moment])
        found = found - np.array([*STILL, *cross(w_B, momentum)])
    return found
