"""Which gain of a law means what: a row for each, see `cascade`.

A row's physical gain is number times scale, times the effect of the law's own unit of torque or
climb on the vehicle, where it asks for those, see `translation.effects`.
"""

import math
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.plant.gravity import GRAVITY

DEGREES = 180.0 / math.pi
TURNS = ("roll", "pitch", "yaw")
MOVES = ("x", "y", "z")


@dataclass(frozen=True)
class Row:
    """One gain.

    Attributes:
        name: of the parameter.
        axis: that it acts about or along.
        part: attribute of `Turn` or `Move`.
        scale: see above.
        factor: name of a parameter that multiplies it, "" for none.
        divisor: name of one that divides it.
        near: why it acts a little otherwise than the part says, a clause.
    """

    name: str
    axis: str
    part: str
    scale: float = 1.0
    factor: str = ""
    divisor: str = ""
    near: str = ""


@dataclass(frozen=True)
class Form:
    """The gains of a law, and what they do not tell of it.

    Attributes:
        rows: its gains.
        filters: parameters that are 0 where its filters are off.
        remarks: what its structure has that no gain carries, sentences.
        hover: parameter of the thrust in hover, which it remembers as `thrust`; "" for none.
        takes_drag: whether it takes back what the rotors' drag damps the yaw rate by.
        exact: whether its loops follow from these gains.
    """

    rows: tuple[Row, ...]
    filters: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    hover: str = ""
    takes_drag: bool = False
    exact: bool = True


def _both(names: str, axes: str, parts: str) -> tuple[Row, ...]:
    """Return rows of gains that several axes share."""
    return tuple(
        Row(name, axis, part)
        for name, part in zip(names.split(), parts.split(), strict=True)
        for axis in axes.split()
    )


_DRAG = (
    "what drag of still air takes is given back; laws that do not have so much less gain on the "
    "velocity and the yaw rate instead"
)
PD = Form(
    (
        *_both("kp_position_xy", "x y", "place"),
        Row("kp_position_z", "z", "place"),
        *(Row(f"kp_velocity_{axis}", axis, "speed") for axis in MOVES),
        *(Row(f"kd_velocity_{axis}", axis, "slope") for axis in MOVES),
        *(Row(f"kp_{axis}", axis, "stiffness") for axis in TURNS[:2]),
        *(Row(f"kd_{axis}", axis, "rate") for axis in TURNS[:2]),
        Row("kp_yaw_rate", "yaw", "rate"),
    ),
    remarks=(_DRAG,),
    takes_drag=True,
)
PID = Form(
    (
        *_both("kp_position_xy", "x y", "place"),
        Row("kp_position_z", "z", "place"),
        *_both("kp_velocity_xy ki_velocity_xy kd_velocity_xy", "x y", "speed speed_integral slope"),
        *_both("kp_velocity_z ki_velocity_z kd_velocity_z", "z", "speed speed_integral slope"),
        *_both("kp_tilt kp_rate ki_rate kd_rate", "roll pitch", "angle rate rate_integral slope"),
        *_both("kp_yaw_rate ki_yaw_rate", "yaw", "rate rate_integral"),
    ),
    remarks=(_DRAG, "its angular acceleration is filtered with 10 ms"),
    takes_drag=True,
)
GEOMETRIC = Form(
    (
        *_both("k_position_xy k_velocity_xy", "x y", "pull speed"),
        *_both("k_position_z k_velocity_z", "z", "pull speed"),
        *_both("k_attitude_xy k_rate_xy", "roll pitch", "stiffness rate"),
        *_both("k_attitude_z k_rate_z", "yaw", "stiffness rate"),
    ),
    remarks=(_DRAG,),
    takes_drag=True,
)
INDI = Form(
    (
        *_both("kp_position_xy kp_velocity_xy", "x y", "place speed"),
        *_both("kp_position_z kp_velocity_z", "z", "place speed"),
        *_both("kp_tilt kd_tilt", "roll pitch", "stiffness rate"),
        Row("kp_yaw_rate", "yaw", "rate"),
    ),
    remarks=(
        "it measures accelerations and closes a loop around them, which its gains do not tell: the "
        "same gains make another loop in a law without it",
    ),
    exact=False,
)
PX4 = Form(
    (
        *_both("MPC_XY_P", "x y", "place"),
        Row("MPC_Z_P", "z", "place"),
        *(
            Row(f"MPC_{name}_VEL_{letter}_ACC", axis, part)
            for name, axes in (("XY", "xy"), ("Z", "z"))
            for axis in axes
            for letter, part in zip("PID", ("speed", "speed_integral", "slope"), strict=True)
        ),
        *(Row(f"MC_{axis.upper()}_P", axis, "angle") for axis in TURNS),
        *(
            Row(f"MC_{axis.upper()}RATE_{letter}", axis, part, 1.0, f"MC_{axis.upper()}RATE_K")
            for axis in TURNS
            for letter, part in zip("PID", ("rate", "rate_integral", "slope"), strict=True)
        ),
        *(Row(f"MC_{axis.upper()}RATE_FF", axis, "ahead") for axis in TURNS),
    ),
    hover="MPC_THR_HOVER",
    filters=("IMU_GYRO_CUTOFF", "IMU_DGYRO_CUTOFF", "MC_YAW_TQ_CUTOFF"),
    remarks=(
        "low-passes of the gyro, of its slope and of the yaw torque turn the phase besides",
        "the integral of a rate stops to grow at large errors and limits, in its own units",
        "with THR_MDL_FAC other than the rotors' curve gains change with the thrust",
    ),
)
CRAZYFLIE = Form(
    (
        *(Row(f"posCtlPid_{axis}Kp", axis, "place") for axis in MOVES),
        *(Row(f"posCtlPid_{axis}Ki", axis, "place_integral") for axis in MOVES),
        *(
            Row(
                f"velCtlPid_v{axis}{name}",
                axis,
                part,
                1.0 if axis == "z" else GRAVITY / DEGREES,
                near=near,
            )
            for axis in MOVES
            for name, part, near in (
                ("Kp", "speed", ""),
                ("Ki", "speed_integral", ""),
                ("Kd", "slope", "a low-pass of 20 Hz stands before it"),
                ("KFF", "ahead", ""),
            )
        ),
        *(
            Row(f"pid_attitude_{axis}_{name}", axis, part)
            for axis in TURNS
            for name, part in (("kp", "angle"), ("ki", "angle_integral"), ("kd", "angle_rate"))
        ),
        *(
            Row(f"pid_rate_{axis}_{name}", axis, part, DEGREES)
            for axis in TURNS
            for name, part in (
                ("kp", "rate"),
                ("ki", "rate_integral"),
                ("kd", "slope"),
                ("kff", "ahead"),
            )
        ),
    ),
    hover="posCtlPid_thrustBase",
    remarks=("integrals are clamped in degrees and metres, before their gains",),
)
MELLINGER = Form(
    (
        *(
            Row(f"ctrlMel_{name}_xy", axis, part, divisor="ctrlMel_mass")
            for axis in "xy"
            for name, part in (("kp", "pull"), ("kd", "speed"), ("ki", "pull_integral"))
        ),
        *(
            Row(f"ctrlMel_{name}_z", "z", part)
            for name, part in (("kp", "pull"), ("kd", "speed"), ("ki", "pull_integral"))
        ),
        *(
            Row(f"ctrlMel_{name}", axis, part, scale)
            for axis in TURNS[:2]
            for name, part, scale in (
                ("kR_xy", "stiffness", 2.0),
                ("kw_xy", "rate", 1.0),
                ("ki_m_xy", "stiffness_integral", 2.0),
                ("kd_omega_rp", "slope", 1.0),
            )
        ),
        Row("ctrlMel_kw_z", "yaw", "rate"),
    ),
    remarks=(
        "the error of attitude is twice the sine of the angle: with large ones it is softer",
        "kR_z and ki_m_z see no error while nobody turns the heading, and stay as they are",
    ),
)
FORMS = {
    "pd": PD,
    "pid": PID,
    "geometric": GEOMETRIC,
    "indi": INDI,
    "px4": PX4,
    "crazyflie": CRAZYFLIE,
    "mellinger": MELLINGER,
}


def form_of(law: Controller) -> Form:
    """Return what a law's gains mean.

    Raises:
        WorkbenchError: if that is not known.
    """
    if law.schedule:
        raise WorkbenchError("scheduled gains are not translated: name the law without its @")
    if law.unscheduled == "lqi":
        raise WorkbenchError(
            "lqi has weights, from which its gains follow by a Riccati equation: there is nothing "
            "to translate them from or to"
        )
    if law.unscheduled not in FORMS or not law.shipped:
        raise WorkbenchError(
            f"what the gains of {law.name} mean is not known: translated are {', '.join(FORMS)}"
        )
    return FORMS[law.unscheduled]
