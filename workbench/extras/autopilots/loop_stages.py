"""The loop points of the autopilots whose cascade ends with torques, stage by stage."""

from workbench.controllers import points

RADIAN_STAGE_POINTS = points(
    {
        "position_{}_error": "m",
        "velocity_{}_error": "m/s",
        "attitude_{}_error": "rad",
        "rate_{}_error": "rad/s",
        "torque_{}": "1",
    }
) | {
    "roll_setpoint": "1",
    "pitch_setpoint": "1",
    "roll_rate_setpoint": "rad/s",
    "pitch_rate_setpoint": "rad/s",
}
"""Of laws that compute in radians."""
ATTITUDE_STAGE_POINT = 6
RATE_STAGE_POINT = 9
TORQUE_STAGE_POINT = 12
TILT_SETPOINT_POINT = 15
RATE_SETPOINT_POINT = 17
"""Index of the first of the three points of each stage, or of the two setpoints."""
