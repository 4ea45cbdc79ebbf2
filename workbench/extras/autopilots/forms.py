"""The physical meaning of the gains of the autopilots' laws, by which gains are translated."""

from workbench.design.translate.forms import (
    DEG_PER_RAD,
    MOVE_AXES,
    TURN_AXES,
    Form,
    FormRow,
    form_rows,
)
from workbench.plant.gravity import GRAVITY

PX4_FORM = Form(
    (
        *form_rows("MPC_XY_P", "x y", "place"),
        FormRow("MPC_Z_P", "z", "place"),
        *(
            FormRow(f"MPC_{name}_VEL_{letter}_ACC", axis, part)
            for name, axes in (("XY", "xy"), ("Z", "z"))
            for axis in axes
            for letter, part in zip("PID", ("speed", "speed_integral", "slope"), strict=True)
        ),
        *(FormRow(f"MC_{axis.upper()}_P", axis, "angle") for axis in TURN_AXES),
        *(
            FormRow(f"MC_{axis.upper()}RATE_{letter}", axis, part, 1.0, f"MC_{axis.upper()}RATE_K")
            for axis in TURN_AXES
            for letter, part in zip("PID", ("rate", "rate_integral", "slope"), strict=True)
        ),
        *(FormRow(f"MC_{axis.upper()}RATE_FF", axis, "ahead") for axis in TURN_AXES),
    ),
    hover=("MPC_THR_HOVER", "thrust"),
    filters=("IMU_GYRO_CUTOFF", "IMU_DGYRO_CUTOFF", "MC_YAW_TQ_CUTOFF"),
    remarks=(
        "low-passes of the gyro, of its slope and of the yaw torque also turn the phase",
        "the integral of a rate stops to grow at large errors and limits, in its own units",
        "with THR_MDL_FAC other than the rotors' curve gains change with the thrust",
    ),
)
CRAZYFLIE_FORM = Form(
    (
        *(FormRow(f"posCtlPid_{axis}Kp", axis, "place") for axis in MOVE_AXES),
        *(FormRow(f"posCtlPid_{axis}Ki", axis, "place_integral") for axis in MOVE_AXES),
        *(
            FormRow(
                f"velCtlPid_v{axis}{name}",
                axis,
                part,
                1.0 if axis == "z" else GRAVITY / DEG_PER_RAD,
                near=near,
            )
            for axis in MOVE_AXES
            for name, part, near in (
                ("Kp", "speed", ""),
                ("Ki", "speed_integral", ""),
                ("Kd", "slope", "a low-pass of 20 Hz is before it"),
                ("KFF", "ahead", ""),
            )
        ),
        *(
            FormRow(f"pid_attitude_{axis}_{name}", axis, part)
            for axis in TURN_AXES
            for name, part in (("kp", "angle"), ("ki", "angle_integral"), ("kd", "angle_rate"))
        ),
        *(
            FormRow(f"pid_rate_{axis}_{name}", axis, part, DEG_PER_RAD)
            for axis in TURN_AXES
            for name, part in (
                ("kp", "rate"),
                ("ki", "rate_integral"),
                ("kd", "slope"),
                ("kff", "ahead"),
            )
        ),
    ),
    hover=("posCtlPid_thrustBase", "thrust"),
    remarks=("integrals are clamped in degrees and metres, before their gains",),
)
MELLINGER_FORM = Form(
    (
        *(
            FormRow(f"ctrlMel_{name}_xy", axis, part, divisor="ctrlMel_mass")
            for axis in "xy"
            for name, part in (("kp", "pull"), ("kd", "speed"), ("ki", "pull_integral"))
        ),
        *(
            FormRow(f"ctrlMel_{name}_z", "z", part)
            for name, part in (("kp", "pull"), ("kd", "speed"), ("ki", "pull_integral"))
        ),
        *(
            FormRow(f"ctrlMel_{name}", axis, part, scale)
            for axis in TURN_AXES[:2]
            for name, part, scale in (
                ("kR_xy", "stiffness", 2.0),
                ("kw_xy", "rate", 1.0),
                ("ki_m_xy", "stiffness_integral", 2.0),
                ("kd_omega_rp", "slope", 1.0),
            )
        ),
        FormRow("ctrlMel_kw_z", "yaw", "rate"),
    ),
    remarks=(
        "the error of attitude is twice the sine of the angle: with large ones it is softer",
        "kR_z and ki_m_z see no error while nobody turns the heading, and stay as they are",
    ),
)
_INNER_LOOP_REMARK = "a loop of the acceleration is inside it, PSC_D_ACC"
_SLOPE_REMARK = "it differentiates the velocity, where others have the estimated acceleration"
_SQUARE_ROOT_REMARK = "0 would leave the square root of the error, not nothing"
_SHORT_AXIS_NAMES = dict(zip(TURN_AXES, ("RLL", "PIT", "YAW"), strict=True))
ARDUPILOT_FORM = Form(
    (
        *form_rows("PSC_NE_POS_P PSC_NE_VEL_P PSC_NE_VEL_I", "x y", "place speed speed_integral"),
        *(FormRow("PSC_NE_VEL_D", axis, "slope", near=_SLOPE_REMARK) for axis in MOVE_AXES[:2]),
        *(
            FormRow(f"PSC_D_{name}", "z", part, near=_INNER_LOOP_REMARK)
            for name, part in (
                ("POS_P", "place"),
                ("VEL_P", "speed"),
                ("VEL_I", "speed_integral"),
                ("VEL_D", "slope"),
            )
        ),
        *(
            FormRow(
                f"ATC_ANG_{_SHORT_AXIS_NAMES[axis]}_P",
                axis,
                "angle",
                never_zero=_SQUARE_ROOT_REMARK,
            )
            for axis in TURN_AXES
        ),
        *(
            FormRow(f"ATC_RAT_{_SHORT_AXIS_NAMES[axis]}_{name}", axis, part)
            for axis in TURN_AXES
            for name, part in (
                ("P", "rate"),
                ("I", "rate_integral"),
                ("D", "slope"),
                ("FF", "ahead"),
            )
        ),
    ),
    filters=(
        "INS_GYRO_FILTER",
        "ATC_RATE_FF_ENAB",
        "PSC_NE_VEL_FLTE",
        "PSC_NE_VEL_FLTD",
        "PSC_D_VEL_FLTE",
        "PSC_D_VEL_FLTD",
        "PSC_D_ACC_FLTT",
        "PSC_D_ACC_FLTE",
        "PSC_D_ACC_FLTD",
        *(
            f"ATC_RAT_{each}_{low}"
            for each in _SHORT_AXIS_NAMES.values()
            for low in ("FLTT", "FLTE", "FLTD")
        ),
    ),
    hover=("MOT_THST_HOVER", "throttle"),
    remarks=(
        "low-passes of the gyro, of the commanded rate, of errors and of their slopes also turn "
        "the phase, and the target of the attitude is shaped",
        "D acts on the error of the rate: a step of the setpoint causes a kick",
        "square roots of errors, ATC_ACC and WP_ACC, make large errors softer",
        "gains of the throttle, PSC_D_ACC, follow from the vehicle, not from the other law",
    ),
    slope_of_error=True,
    climbs_by_acceleration=True,
)
_BETAFLIGHT_P, _BETAFLIGHT_I, _BETAFLIGHT_D = (
    scale * DEG_PER_RAD / 1000.0 for scale in (0.032029, 0.244381, 0.000529)
)
"""Motor fraction per rad/s for a gain of 1, for its integral, and for its derivative."""
BETAFLIGHT_FORM = Form(
    (
        *form_rows(
            "outer_p_position outer_p_velocity outer_i_velocity",
            "x y",
            "place speed speed_integral",
        ),
        *form_rows("outer_p_height outer_p_climb outer_i_climb", "z", "place speed speed_integral"),
        *(
            FormRow("angle_p_gain", axis, "angle", 0.1, near="a low-pass PT3 of 50 Hz is after it")
            for axis in TURN_AXES[:2]
        ),
        *(FormRow(f"p_{axis}", axis, "rate", _BETAFLIGHT_P) for axis in TURN_AXES),
        *(
            FormRow(
                f"i_{axis}", axis, "rate_integral", (2.5 if axis == "yaw" else 1.0) * _BETAFLIGHT_I
            )
            for axis in TURN_AXES
        ),
        *(FormRow(f"d_{axis}", axis, "slope", _BETAFLIGHT_D) for axis in TURN_AXES),
    ),
    filters=(
        "gyro_lpf1_dyn_min_hz",
        "gyro_lpf1_dyn_max_hz",
        "gyro_lpf2_static_hz",
        "dterm_lpf1_dyn_min_hz",
        "dterm_lpf1_dyn_max_hz",
        "dterm_lpf2_static_hz",
        "yaw_lowpass_hz",
        "throttle_boost",
        "tpa_rate",
        "anti_gravity_gain",
    ),
    hover=("outer_hover", "throttle"),
    remarks=(
        "low-passes of gyro and D also turn the phase",
        "d_max, TPA, anti-gravity, I-term relax and thrust_linear change gains as it flies",
        "gains are whole numbers in the firmware: an export rounds them",
    ),
    off=("acro",),
)
