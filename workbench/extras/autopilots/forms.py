"""The physical meaning of the gains of the autopilots' laws, by which gains are translated."""

from collections.abc import Iterator

from workbench.design.translate.forms import DEG_PER_RAD, Form, FormRow, form_rows
from workbench.plant.gravity import GRAVITY

_FORM_TURNS = "roll pitch yaw"


def _rows_by_axis(
    names: str, axes: str, parts: str, scale: float = 1.0, **others: str
) -> Iterator[FormRow]:
    """Yield the rows of `form_rows`, all of one axis before those of the next."""
    for axis in axes.split():
        yield from form_rows(names, axis, parts, scale, **others)


PX4_FORM = Form(
    (
        *form_rows("MPC_XY_P", "x y", "place"),
        *form_rows("MPC_Z_P", "z", "place"),
        *_rows_by_axis(
            "MPC_XY_VEL_P_ACC MPC_XY_VEL_I_ACC MPC_XY_VEL_D_ACC",
            "x y",
            "speed speed_integral slope",
        ),
        *form_rows(
            "MPC_Z_VEL_P_ACC MPC_Z_VEL_I_ACC MPC_Z_VEL_D_ACC", "z", "speed speed_integral slope"
        ),
        *form_rows("MC_{1}_P", _FORM_TURNS, "angle"),
        *_rows_by_axis(
            "MC_{1}RATE_P MC_{1}RATE_I MC_{1}RATE_D",
            _FORM_TURNS,
            "rate rate_integral slope",
            factor="MC_{1}RATE_K",
        ),
        *form_rows("MC_{1}RATE_FF", _FORM_TURNS, "ahead"),
    ),
    hover=("MPC_THR_HOVER", "thrust"),
    filters=("IMU_GYRO_CUTOFF", "IMU_DGYRO_CUTOFF", "MC_YAW_TQ_CUTOFF"),
    remarks=(
        "low-passes of the gyro, of its slope and of the yaw torque also turn the phase",
        "the integral of a rate stops to grow at large errors and limits, in its own units",
        "with THR_MDL_FAC other than the rotors' curve gains change with the thrust",
    ),
)
_PER_DEGREE = GRAVITY / DEG_PER_RAD
CRAZYFLIE_FORM = Form(
    (
        *form_rows("posCtlPid_{}Kp posCtlPid_{}Ki", "x y z", "place place_integral"),
        *(
            row
            for axis, scale in (("x", _PER_DEGREE), ("y", _PER_DEGREE), ("z", 1.0))
            for names, parts, near in (
                ("velCtlPid_v{}Kp velCtlPid_v{}Ki", "speed speed_integral", ""),
                ("velCtlPid_v{}Kd", "slope", "a low-pass of 20 Hz is before it"),
                ("velCtlPid_v{}KFF", "ahead", ""),
            )
            for row in form_rows(names, axis, parts, scale, near=near)
        ),
        *_rows_by_axis(
            "pid_attitude_{}_kp pid_attitude_{}_ki pid_attitude_{}_kd",
            _FORM_TURNS,
            "angle angle_integral angle_rate",
        ),
        *_rows_by_axis(
            "pid_rate_{}_kp pid_rate_{}_ki pid_rate_{}_kd pid_rate_{}_kff",
            _FORM_TURNS,
            "rate rate_integral slope ahead",
            DEG_PER_RAD,
        ),
    ),
    hover=("posCtlPid_thrustBase", "thrust"),
    remarks=("integrals are clamped in degrees and metres, before their gains",),
)
MELLINGER_FORM = Form(
    (
        *_rows_by_axis(
            "ctrlMel_kp_xy ctrlMel_kd_xy ctrlMel_ki_xy",
            "x y",
            "pull speed pull_integral",
            divisor="ctrlMel_mass",
        ),
        *form_rows("ctrlMel_kp_z ctrlMel_kd_z ctrlMel_ki_z", "z", "pull speed pull_integral"),
        *(
            row
            for axis in ("roll", "pitch")
            for name, part, scale in (
                ("kR_xy", "stiffness", 2.0),
                ("kw_xy", "rate", 1.0),
                ("ki_m_xy", "stiffness_integral", 2.0),
                ("kd_omega_rp", "slope", 1.0),
            )
            for row in form_rows(f"ctrlMel_{name}", axis, part, scale)
        ),
        *form_rows("ctrlMel_kw_z", "yaw", "rate"),
    ),
    remarks=(
        "the error of attitude is twice the sine of the angle: with large ones it is softer",
        "kR_z and ki_m_z see no error while nobody turns the heading, and stay as they are",
    ),
)
_INNER_LOOP_REMARK = "a loop of the acceleration is inside it, PSC_D_ACC"
_SLOPE_REMARK = "it differentiates the velocity, where others have the estimated acceleration"
_SQUARE_ROOT_REMARK = "0 would leave the square root of the error, not nothing"
_ARDUPILOT_TURNS = (("roll", "RLL"), ("pitch", "PIT"), ("yaw", "YAW"))
ARDUPILOT_FORM = Form(
    (
        *form_rows("PSC_NE_POS_P PSC_NE_VEL_P PSC_NE_VEL_I", "x y", "place speed speed_integral"),
        *form_rows("PSC_NE_VEL_D", "x y", "slope", near=_SLOPE_REMARK),
        *form_rows(
            "PSC_D_POS_P PSC_D_VEL_P PSC_D_VEL_I PSC_D_VEL_D",
            "z",
            "place speed speed_integral slope",
            near=_INNER_LOOP_REMARK,
        ),
        *(
            row
            for axis, name in _ARDUPILOT_TURNS
            for row in form_rows(f"ATC_ANG_{name}_P", axis, "angle", never_zero=_SQUARE_ROOT_REMARK)
        ),
        *(
            row
            for axis, name in _ARDUPILOT_TURNS
            for row in form_rows(
                " ".join(f"ATC_RAT_{name}_{term}" for term in ("P", "I", "D", "FF")),
                axis,
                "rate rate_integral slope ahead",
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
            for _, each in _ARDUPILOT_TURNS
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
        *form_rows(
            "angle_p_gain", "roll pitch", "angle", 0.1, near="a low-pass PT3 of 50 Hz is after it"
        ),
        *form_rows("p_{}", _FORM_TURNS, "rate", _BETAFLIGHT_P),
        *form_rows("i_{}", "roll pitch", "rate_integral", _BETAFLIGHT_I),
        *form_rows("i_{}", "yaw", "rate_integral", 2.5 * _BETAFLIGHT_I),
        *form_rows("d_{}", _FORM_TURNS, "slope", _BETAFLIGHT_D),
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
