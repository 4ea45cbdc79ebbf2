"""The physical meaning of gains, in angular and linear acceleration, for each gain of a law.

Around an axis, with the error e of the angle, ω its rate, and α the angular acceleration:

    ω_sp = angle e + angle_integral ∫e - angle_rate ω
    α    = rate (ω_sp - ω) + rate_integral ∫(ω_sp - ω) - slope dω/dt

and along an axis, with the error e of the place, velocity v and acceleration a:

    v_sp = place e + place_integral ∫e
    a    = speed (v_sp - v) + speed_integral ∫(v_sp - v) - slope dv/dt

From the angle θ to -α such a loop is slope s² + c1 s + c0 + c_1 / s + c_2 / s², with

    c1 = rate (1 + angle_rate),   c0 = rate angle + rate_integral (1 + angle_rate),
    c_1 = rate angle_integral + rate_integral angle,   c_2 = rate_integral angle_integral

so laws that have other parts than these can have the same loop.

Each law has a row for each of its gains. The physical gain of a row is its number times its scale,
and if the law commands torque or climb in its own unit, times the effect of that unit on the
vehicle, see `translation.effects`.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.plant.gravity import GRAVITY


@dataclass(frozen=True)
class Turn:
    """Gains around an axis, see above.

    Attributes:
        angle: [1/s].
        angle_integral: [1/s²].
        angle_rate: [-].
        rate: [1/s].
        rate_integral: [1/s²].
        slope: [-].
        ahead: angular acceleration per commanded rate [1/s].
    """

    angle: float = 0.0
    angle_integral: float = 0.0
    angle_rate: float = 0.0
    rate: float = 0.0
    rate_integral: float = 0.0
    slope: float = 0.0
    ahead: float = 0.0

    @property
    def stiffness(self) -> float:
        """Angular acceleration per angle, c0 [1/s²]."""
        return self.rate * self.angle + self.rate_integral * (1.0 + self.angle_rate)

    @property
    def stiffness_integral(self) -> float:
        """Angular acceleration per integral of the angle, c_1 [1/s³]."""
        return self.rate * self.angle_integral + self.rate_integral * self.angle

    def less(self, drag: float) -> "Turn":
        """Return the same loop, minus the damping of the rate by drag [1/s]."""
        rate = self.rate - drag
        return replace(self, rate=rate, angle=self.angle * self.rate / rate) if rate else self

    def of_rate(self) -> "Turn":
        """Return the same loop with its slope of ω alone, of one with that of ω_sp - ω.

        Of the loop with the error's slope, c1 is larger by slope angle.
        """
        rate = self.rate + self.slope * self.angle
        if rate <= 0.0:
            return self
        root = self.stiffness**2 - 4.0 * rate * self.stiffness_integral
        angle = (self.stiffness + math.sqrt(max(0.0, root))) / (2.0 * rate)
        integral = self.stiffness - rate * angle
        return replace(self, angle=angle, rate=rate, rate_integral=integral)

    def of_error(self) -> "Turn | None":
        """Return the same loop with the slope of ω_sp - ω, of one with that of ω; None for none.

        It is (s + angle) (slope s² + rate s + rate_integral) / s, so angle is a root of the loop.
        """
        c = (self.slope, self.rate, self.stiffness, self.stiffness_integral)
        roots = np.roots(c)
        angles = [-float(x.real) for x in roots if abs(x.imag) < 1e-9 * abs(x) and x.real < 0.0]
        if not angles:
            return None if self.angle else self
        angle = min(angles, key=lambda each: abs(each - self.angle))
        rate = self.rate - self.slope * angle
        integral = self.stiffness - rate * angle
        return replace(self, angle=angle, rate=rate, rate_integral=max(0.0, integral))

    def without_angle_rate(self) -> "Turn":
        """Return the same loop without the derivative of the angle, exactly."""
        more = 1.0 + self.angle_rate
        return replace(
            self,
            angle=self.angle / more,
            angle_integral=self.angle_integral / more,
            angle_rate=0.0,
            rate=self.rate * more,
            rate_integral=self.rate_integral * more,
        )

    def without_angle_integral(self) -> "Turn":
        """Return the same loop without integral and derivative of the angle, but for c_2.

        angle and rate_integral / rate are the roots of rate x² - c0 x + c_1 = 0.
        """
        plain = self.without_angle_rate()
        if not plain.angle_integral or plain.rate <= 0.0:
            return replace(plain, angle_integral=0.0)
        root = plain.stiffness**2 - 4.0 * plain.rate * plain.stiffness_integral
        angle = (plain.stiffness + math.sqrt(max(0.0, root))) / (2.0 * plain.rate)
        integral = plain.stiffness - plain.rate * angle
        return replace(plain, angle=angle, angle_integral=0.0, rate_integral=integral)


@dataclass(frozen=True)
class Move:
    """Gains along an axis, see above.

    Attributes:
        place: [1/s].
        place_integral: [1/s²].
        speed: [1/s].
        speed_integral: [1/s²].
        slope: [-].
        ahead: acceleration per commanded velocity [1/s].
    """

    place: float = 0.0
    place_integral: float = 0.0
    speed: float = 0.0
    speed_integral: float = 0.0
    slope: float = 0.0
    ahead: float = 0.0

    def less(self, drag: float) -> "Move":
        """Return the same loop, minus the damping of the speed by drag [1/s]."""
        speed = self.speed - drag
        return replace(self, speed=speed, place=self.place * self.speed / speed) if speed else self

    @property
    def pull(self) -> float:
        """Acceleration per error of the position [1/s²]."""
        return self.speed * self.place + self.speed_integral

    @property
    def pull_integral(self) -> float:
        """Acceleration per integral of the error of the position [1/s³]."""
        return self.speed * self.place_integral + self.speed_integral * self.place


DEGREES = 180.0 / math.pi
TURNS = ("roll", "pitch", "yaw")
MOVES = ("x", "y", "z")


@dataclass(frozen=True)
class Row:
    """One gain.

    Attributes:
        name: of the parameter.
        axis: the one it acts about or along.
        part: attribute of `Turn` or `Move`.
        scale: see above.
        factor: name of a parameter that multiplies it, "" for none.
        divisor: name of a parameter that divides it, "" for none.
        near: why its effect differs slightly from that of the part, a clause.
        never_zero: why it cannot be 0, a clause; it then stays unchanged.
    """

    name: str
    axis: str
    part: str
    scale: float = 1.0
    factor: str = ""
    divisor: str = ""
    near: str = ""
    never_zero: str = ""


@dataclass(frozen=True)
class Form:
    """The gains of a law, and its other properties.

    Attributes:
        rows: its gains.
        filters: parameters that are 0 if its filters are off.
        remarks: on parts of its structure without a gain, as sentences.
        hover: parameter of the hover thrust, and name of the thrust in its memory; empty for none.
        takes_drag: whether it compensates the damping of the yaw rate by rotor drag.
        exact: whether these gains determine its loops.
        slope_of_error: whether `slope` acts on the derivative of the rate error, not of the rate.
        climbs_by_acceleration: whether its climb commands an acceleration to a separate loop.
        off: parameters that are 0 in a translation: modes with a different meaning of gains.
    """

    rows: tuple[Row, ...]
    filters: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    hover: tuple[str, ...] = ()
    takes_drag: bool = False
    exact: bool = True
    slope_of_error: bool = False
    climbs_by_acceleration: bool = False
    off: tuple[str, ...] = ()


def _both(names: str, axes: str, parts: str) -> tuple[Row, ...]:
    """Return rows of gains common to several axes."""
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
    hover=("MPC_THR_HOVER", "thrust"),
    filters=("IMU_GYRO_CUTOFF", "IMU_DGYRO_CUTOFF", "MC_YAW_TQ_CUTOFF"),
    remarks=(
        "low-passes of the gyro, of its slope and of the yaw torque also turn the phase",
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
                ("Kd", "slope", "a low-pass of 20 Hz is before it"),
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
    hover=("posCtlPid_thrustBase", "thrust"),
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
_INNER = "a loop of the acceleration is inside it, PSC_D_ACC"
_SLOPE = "it differentiates the velocity, where others have the estimated acceleration"
_SQUARE_ROOT = "0 would leave the square root of the error, not nothing"
_SHORT = dict(zip(TURNS, ("RLL", "PIT", "YAW"), strict=True))
ARDUPILOT = Form(
    (
        *_both("PSC_NE_POS_P PSC_NE_VEL_P PSC_NE_VEL_I", "x y", "place speed speed_integral"),
        *(Row("PSC_NE_VEL_D", axis, "slope", near=_SLOPE) for axis in MOVES[:2]),
        *(
            Row(f"PSC_D_{name}", "z", part, near=_INNER)
            for name, part in (
                ("POS_P", "place"),
                ("VEL_P", "speed"),
                ("VEL_I", "speed_integral"),
                ("VEL_D", "slope"),
            )
        ),
        *(
            Row(f"ATC_ANG_{_SHORT[axis]}_P", axis, "angle", never_zero=_SQUARE_ROOT)
            for axis in TURNS
        ),
        *(
            Row(f"ATC_RAT_{_SHORT[axis]}_{name}", axis, part)
            for axis in TURNS
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
        *(f"ATC_RAT_{each}_{low}" for each in _SHORT.values() for low in ("FLTT", "FLTE", "FLTD")),
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
_P, _I, _D = (scale * DEGREES / 1000.0 for scale in (0.032029, 0.244381, 0.000529))
"""Motor fraction per rad/s for a gain of 1, for its integral, and for its derivative."""
BETAFLIGHT = Form(
    (
        *_both(
            "outer_p_position outer_p_velocity outer_i_velocity",
            "x y",
            "place speed speed_integral",
        ),
        *_both("outer_p_height outer_p_climb outer_i_climb", "z", "place speed speed_integral"),
        *(
            Row("angle_p_gain", axis, "angle", 0.1, near="a low-pass PT3 of 50 Hz is after it")
            for axis in TURNS[:2]
        ),
        *(Row(f"p_{axis}", axis, "rate", _P) for axis in TURNS),
        *(
            Row(f"i_{axis}", axis, "rate_integral", (2.5 if axis == "yaw" else 1.0) * _I)
            for axis in TURNS
        ),
        *(Row(f"d_{axis}", axis, "slope", _D) for axis in TURNS),
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
FORMS = {
    "pd": PD,
    "pid": PID,
    "geometric": GEOMETRIC,
    "indi": INDI,
    "px4": PX4,
    "crazyflie": CRAZYFLIE,
    "mellinger": MELLINGER,
    "ardupilot": ARDUPILOT,
    "betaflight": BETAFLIGHT,
}


def form_of(law: Controller) -> Form:
    """Return the meaning of the gains of a law.

    Raises:
        WorkbenchError: if it is unknown.
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
