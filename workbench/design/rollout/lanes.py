"""Arrays of the flights that the compiled code flies side by side."""

import math
from typing import Any, NamedTuple

import numpy as np

from workbench.design.rollout.fields import packed_dtype
from workbench.dynamics.rotors import RotorConstants

LANES = 16
"""Vehicles side by side: four vectors of four, so that one's wait is another's work."""
LANE_SHAPE = (LANES,)
CACHE_LINE_BYTES = 64
THREE_LANES, FOUR_LANES, SIX_LANES, NINE_LANES = ((rows, LANES) for rows in (3, 4, 6, 9))
LANE_BODIES_DTYPE = packed_dtype(
    {
        "q_WB": FOUR_LANES,
        "p_WB": THREE_LANES,
        "w_WB": THREE_LANES,
        "v_WB": THREE_LANES,
        "q_rate": FOUR_LANES,
        "p_rate": THREE_LANES,
        "w_rate": THREE_LANES,
        "v_rate": THREE_LANES,
        "R_WB": NINE_LANES,
        "w_B": THREE_LANES,
        "v_B": THREE_LANES,
        "force": THREE_LANES,
        "moment": THREE_LANES,
        "momentum": THREE_LANES,
        "wind": THREE_LANES,
        "push": THREE_LANES,
        "push_point": THREE_LANES,
        "push_torque": THREE_LANES,
        "mass": LANE_SHAPE,
        "inertia": SIX_LANES,
        "inverse": SIX_LANES,
        "p_BoBcm_B": THREE_LANES,
        "half_drag": LANE_SHAPE,
        "open_circuit": LANE_SHAPE,
        "drop": LANE_SHAPE,
        "compensation": LANE_SHAPE,
        "known_open_circuit": LANE_SHAPE,
        "power": LANE_SHAPE,
        "voltage": LANE_SHAPE,
        "divisor": LANE_SHAPE,
        "step": LANE_SHAPE,
    },
    whole={
        "state": ("q_WB", "p_WB", "w_WB", "v_WB"),
        "rate": ("q_rate", "p_rate", "w_rate", "v_rate"),
    },
)
"""The bodies of 16 vehicles:

    q_WB .. v_WB    state, in W [m, rad/s, m/s]; together they are `state` (13 x 16, row by row)
    q_rate .. v_rate    its derivative, likewise `rate`
    R_WB            attitude, row by row
    w_B, v_B        angular velocity, and velocity relative to the air, in B [rad/s, m/s]
    force, moment   without gravity, the moment about the origin, in B [N, N·m]
    momentum        angular momentum of the rotors in B [N·m·s]
    wind            velocity of the air in W [m/s]
    push            force of a push in W [N], push_point and push_torque in B [m, N·m]
    mass .. p_BoBcm_B    see `RigidBody`
    half_drag       half the air's density times the drag area [kg/m]
    open_circuit, drop, compensation, known_open_circuit    supply of the battery, see
                    `loaded_voltage` and `compensated_share`
    power, voltage, divisor    load of the battery, and by what commands are divided
    step            of the integrator [s]
"""
LANE_ROTORS_DTYPE = packed_dtype(
    {
        "speed": LANE_SHAPE,
        "speed_rate": LANE_SHAPE,
        "static": LANE_SHAPE,
        "command": LANE_SHAPE,
        "runs": LANE_SHAPE,
        "share": LANE_SHAPE,
        **{
            name: THREE_LANES if name in ("p_BR", "axis_B") else LANE_SHAPE
            for name in RotorConstants._fields
        },
    }
)
"""A rotor of each of 16 vehicles: speed, derivative, static thrust, command, whether it follows its
command (0, 1), share of its thrust, and constants."""
# Dormand and Prince: weights of the slopes before in each stage, then in the step
DORMAND_PRINCE_WEIGHTS = (
    (1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0),
    (3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0),
    (44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
# Kutta: likewise
KUTTA_WEIGHTS = ((1 / 2, 0.0, 0.0), (-1.0, 2.0, 0.0), (1 / 6, 2 / 3, 1 / 6))
DORMAND_PRINCE_TABLEAU, KUTTA_TABLEAU = np.array(DORMAND_PRINCE_WEIGHTS), np.array(KUTTA_WEIGHTS)
RUNGE_KUTTA_STAGES = len(DORMAND_PRINCE_WEIGHTS)
BODY_STATE_SIZE = 13


class LaneWorkspace(NamedTuple):
    """What flies, and places that the integrator works in; S is 16 times the size of the state.

    Attributes:
        bodies: one record, see `LANE_BODIES_DTYPE`.
        rotors: (n) see `LANE_ROTORS_DTYPE`.
        begun: (S) state at the beginning of a step: of the bodies, then of the rotors.
        moved: (S) the state in a stage, or at the end.
        slopes: (stages, S).
        sizes: (S) of the step of each lane [s].
    """

    bodies: np.ndarray
    rotors: np.ndarray
    begun: np.ndarray
    moved: np.ndarray
    slopes: np.ndarray
    sizes: np.ndarray


def make_lane_workspace(rotors: int) -> LaneWorkspace:
    """Return a room for vehicles with as many rotors."""
    size = (BODY_STATE_SIZE + rotors) * LANES
    return LaneWorkspace(
        aligned_zeros((1,), LANE_BODIES_DTYPE),
        aligned_zeros((rotors,), LANE_ROTORS_DTYPE),
        aligned_zeros((size,)),
        aligned_zeros((size,)),
        aligned_zeros((RUNGE_KUTTA_STAGES, size)),
        aligned_zeros((size,)),
    )


def aligned_zeros(shape: tuple[int, ...], dtype: Any = np.float64) -> np.ndarray:
    """Return an array of zeros that begins at a cache line; numpy's begin anywhere.

    A vector of eight numbers is as long as a line: elsewhere each would take two of them.
    """
    size = math.prod(shape) * np.dtype(dtype).itemsize
    memory = np.zeros(size + CACHE_LINE_BYTES, np.uint8)
    begin = -memory.ctypes.data % CACHE_LINE_BYTES
    return memory[begin : begin + size].view(dtype).reshape(shape)
