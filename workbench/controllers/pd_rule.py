"""Gains of the PD cascade for any vehicle, from its record alone.

Gains are normalised by mass and inertia, so the rule only has to choose the speed of each loop. The
limits are the rotor lag and the spare thrust:

    lag = time constant of the slowest rotor at hover + CONTROL_DELAY
    spare = g (thrust_to_weight - 1)

    tilt     kd = LAG_MARGIN / lag,  kp = (kd / (2 DAMPING_RATIO))²,  pace = sqrt(kp),
             pace³ UNSATURATED_STEP <= LOOP_RATIO g alpha
    level    kp = pace / LOOP_RATIO,  kp UNSATURATED_STEP <= g tan(max_tilt) and g / 2,
             kp <= SWING_SHARE sqrt(g / lever),
             kd = KD_VELOCITY,  kd kp_tilt lever <= LEVER_SHARE g
    climb    kp = CLIMB_LAG_MARGIN / lag,  kp UNSATURATED_STEP <= g / 2,
             kp UNSATURATED_STEP <= spare (but kp may be MIN_CLIMB_KP)
    place    kp = kp_velocity / LOOP_RATIO, level and in height
    yaw      kp = YAW_LAG_MARGIN / lag,  kp max_yaw_rate <= YAW_SHARE alpha_z,
             kp <= TILT_LAG_MARGIN / lag of servos that tilt rotors for it,
             spin_up_feedforward = 1 where rotors have an inertia
    limits   1 / cos(max_tilt) <= 1 + TILT_SHARE spare / g,
             kp_position_z max_climb_rate <= BRAKE_SHARE spare

alpha is the spare angular acceleration of hovering rotors about an axis. A velocity step commands
the tilt kp UNSATURATED_STEP / g, and so the angular acceleration kp_tilt kp UNSATURATED_STEP / g =
pace³ UNSATURATED_STEP / (LOOP_RATIO g), hence the cube. At max_tilt half of the spare thrust
remains, and a drone that descends to a height can brake.

lever is the distance of the centre of mass from the base link's origin. When the drone tilts, that
origin swings: its response to a tilt is g / s² - lever, with a zero at sqrt(g / lever). A level
step much faster than that would overshoot at the origin. The law feeds back a share of the
acceleration, which must not destabilise the tilt loop.

A rotor that accelerates turns the vehicle at once by its inertia, which adds a zero to the yaw
loop, see `plant.thrust_frame`. The law compensates it; otherwise a yaw loop of the same gain would
be ten times faster than the rotors allow.

LAG_MARGIN 0.5 leaves the tilt loop a phase margin of 44 to 47 degrees whatever the lag: at its
crossover, near kd, the PD leads by 73 degrees, of which the lag takes atan(0.5).
"""

import math

import numpy as np

from workbench.control.controller import COMMON_PARAMETERS
from workbench.plant.gravity import GRAVITY
from workbench.plant.thrust_frame import ThrustFrame, thrust_frame
from workbench.plant.vehicle import Vehicle

CONTROL_DELAY = 0.5 / 128 + 1 / 1024
"""A command is held for a control period, and acts one physics step later [s]."""
UNSATURATED_STEP = 1.0
"""The velocity step in which no rotor should saturate [m/s]."""
LAG_MARGIN = 0.5
DAMPING_RATIO = 0.9
LOOP_RATIO = 4.0
"""Each loop is this many times slower than the one inside it."""
CLIMB_LAG_MARGIN = 0.25
YAW_LAG_MARGIN = 0.1
TILT_LAG_MARGIN = 0.3
MIN_CLIMB_KP = 2.0
"""Smallest kp of climbing, whatever the spare thrust, because take-offs need it [1/s]."""
BRAKE_SHARE = 0.75
YAW_SHARE = 0.5
TILT_SHARE = 0.5
SWING_SHARE = 0.6
LEVER_SHARE = 0.2
MIN_LEVER = 1e-6
"""Smaller values are raised to this [m, 1/s² m]."""
KD_VELOCITY = 0.1
MAX_ATTITUDE_KP = 2500.0
"""Largest kp of roll and pitch that is allowed [1/s²]."""


def rule(vehicle: Vehicle) -> dict[str, float]:
    """Return the parameters that depend on the vehicle, by name; see above."""
    frame = thrust_frame(vehicle)
    lag = vehicle.rotor_lag + CONTROL_DELAY
    spare = GRAVITY * max(0.0, thrust_to_weight(frame) - 1.0)
    *alphas, alpha_z = spare_angular_acceleration(frame)
    max_tilt = min(_default("max_tilt"), math.acos(1.0 / (1.0 + TILT_SHARE * spare / GRAVITY)))
    fastest = min(LAG_MARGIN / lag / (2.0 * DAMPING_RATIO), MAX_ATTITUDE_KP**0.5)
    roll, pitch = (
        min(fastest, math.cbrt(LOOP_RATIO * GRAVITY * a / UNSATURATED_STEP)) for a in alphas
    )
    lever = max(MIN_LEVER, math.hypot(*vehicle.p_BoBcm_B))
    level = min(
        min(roll, pitch) / LOOP_RATIO,
        GRAVITY * math.tan(max_tilt) / UNSATURATED_STEP,
        GRAVITY / 2.0 / UNSATURATED_STEP,
        SWING_SHARE * math.sqrt(GRAVITY / lever),
    )
    swing = max(MIN_LEVER, lever * max(roll, pitch) ** 2)
    damped = min(KD_VELOCITY, LEVER_SHARE * GRAVITY / swing)
    climb = min(
        CLIMB_LAG_MARGIN / lag,
        max(MIN_CLIMB_KP, spare / UNSATURATED_STEP),
        GRAVITY / 2.0 / UNSATURATED_STEP,
    )
    sink = max(UNSATURATED_STEP, BRAKE_SHARE * spare * LOOP_RATIO / climb)
    return {
        "kp_position_xy": level / LOOP_RATIO,
        "kp_position_z": min(climb / LOOP_RATIO, BRAKE_SHARE * spare / UNSATURATED_STEP),
        "kp_velocity_x": level,
        "kp_velocity_y": level,
        "kp_velocity_z": climb,
        "kd_velocity_x": damped,
        "kd_velocity_y": damped,
        "kd_velocity_z": KD_VELOCITY,
        "kp_roll": roll**2,
        "kp_pitch": pitch**2,
        "kd_roll": 2.0 * DAMPING_RATIO * roll,
        "kd_pitch": 2.0 * DAMPING_RATIO * pitch,
        "kp_yaw_rate": min(
            YAW_LAG_MARGIN / lag,
            YAW_SHARE * alpha_z / _default("max_yaw_rate"),
            TILT_LAG_MARGIN / vehicle.tilt_lag if vehicle.tilts else math.inf,
        ),
        "spin_up_feedforward": 1.0 if frame.spin_up_time > 0.0 else 0.0,
        "max_climb_rate": min(_default("max_climb_rate"), sink),
        "max_tilt": max_tilt,
    }


def thrust_to_weight(frame: ThrustFrame) -> float:
    """Return the largest force without moment that the rotors can make, over the weight."""
    most = np.array([rotor.max_thrust for rotor in frame.rotors])
    lifting = frame.hover_thrusts > 0.0
    return float(np.min(most[lifting] / frame.hover_thrusts[lifting]))


def spare_angular_acceleration(frame: ThrustFrame) -> list[float]:
    """Return the spare angular acceleration of hovering rotors about x, y and z [rad/s²].

    It is the angular acceleration, in either direction, at which the first rotor reaches a limit.
    """
    most = np.array([rotor.max_thrust for rotor in frame.rotors])
    hover = frame.hover_thrusts
    room = np.maximum(np.minimum(most - hover, hover - frame.idle_thrusts), 0.0)
    room = np.append(room, [min(tilt.upper, -tilt.lower) for tilt in frame.tilts])
    thrusts = np.abs(frame.allocation[:, 1:] @ frame.inertia_T)  # for 1 rad/s² about each axis
    with np.errstate(divide="ignore", invalid="ignore"):
        return [float(np.nanmin(room / column)) for column in thrusts.T]


def _default(name: str) -> float:
    return next(row.default for row in COMMON_PARAMETERS if row.name == name)
