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
vehicle, see `translation.law_effects`.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.extensions import ExtensionGroup, find_extensions, load_extension
from workbench.control.controller import Controller


@dataclass(frozen=True)
class TurnGains:
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

    def less(self, drag: float) -> "TurnGains":
        """Return the same loop, minus the damping of the rate by drag [1/s]."""
        rate = self.rate - drag
        return replace(self, rate=rate, angle=self.angle * self.rate / rate) if rate else self

    def of_rate(self) -> "TurnGains":
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

    def of_error(self) -> "TurnGains | None":
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

    def without_angle_rate(self) -> "TurnGains":
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

    def without_angle_integral(self) -> "TurnGains":
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
class MoveGains:
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

    def less(self, drag: float) -> "MoveGains":
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


DEG_PER_RAD = 180.0 / math.pi
TURN_AXES = ("roll", "pitch", "yaw")
MOVE_AXES = ("x", "y", "z")


@dataclass(frozen=True)
class FormRow:
    """One gain.

    Attributes:
        name: of the parameter.
        axis: the one it acts about or along.
        part: attribute of `TurnGains` or `MoveGains`.
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

    rows: tuple[FormRow, ...]
    filters: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    hover: tuple[str, ...] = ()
    takes_drag: bool = False
    exact: bool = True
    slope_of_error: bool = False
    climbs_by_acceleration: bool = False
    off: tuple[str, ...] = ()


def form_rows(
    names: str, axes: str, parts: str, scale: float = 1.0, **others: str
) -> tuple[FormRow, ...]:
    """Return rows of gains of several axes.

    Args:
        names: of the gains, with `{}` for the name of the axis, or `{1}` for that in capitals.
        axes: for which each of the gains is.
        parts: of the loop, one for each name.
        scale: of all rows.
        others: texts of all rows, by their fields, with the axis as in `names`.
    """
    return tuple(
        FormRow(
            name.format(axis, axis.upper()),
            axis,
            part,
            scale,
            **{field: text.format(axis, axis.upper()) for field, text in others.items()},
        )
        for name, part in zip(names.split(), parts.split(), strict=True)
        for axis in axes.split()
    )


_DRAG_REMARK = (
    "what drag of still air takes is given back; laws that do not have so much less gain on the "
    "velocity and the yaw rate instead"
)
PD_FORM = Form(
    (
        *form_rows("kp_position_xy", "x y", "place"),
        FormRow("kp_position_z", "z", "place"),
        *form_rows("kp_velocity_{} kd_velocity_{}", "x y z", "speed slope"),
        *form_rows("kp_{} kd_{}", "roll pitch", "stiffness rate"),
        FormRow("kp_yaw_rate", "yaw", "rate"),
    ),
    remarks=(_DRAG_REMARK,),
    takes_drag=True,
)
PID_FORM = Form(
    (
        *form_rows("kp_position_xy", "x y", "place"),
        FormRow("kp_position_z", "z", "place"),
        *form_rows(
            "kp_velocity_xy ki_velocity_xy kd_velocity_xy", "x y", "speed speed_integral slope"
        ),
        *form_rows("kp_velocity_z ki_velocity_z kd_velocity_z", "z", "speed speed_integral slope"),
        *form_rows(
            "kp_tilt kp_rate ki_rate kd_rate", "roll pitch", "angle rate rate_integral slope"
        ),
        *form_rows("kp_yaw_rate ki_yaw_rate", "yaw", "rate rate_integral"),
    ),
    remarks=(_DRAG_REMARK, "its angular acceleration is filtered with 10 ms"),
    takes_drag=True,
)
GEOMETRIC_FORM = Form(
    (
        *form_rows("k_position_xy k_velocity_xy", "x y", "pull speed"),
        *form_rows("k_position_z k_velocity_z", "z", "pull speed"),
        *form_rows("k_attitude_xy k_rate_xy", "roll pitch", "stiffness rate"),
        *form_rows("k_attitude_z k_rate_z", "yaw", "stiffness rate"),
    ),
    remarks=(_DRAG_REMARK,),
    takes_drag=True,
)
INDI_FORM = Form(
    (
        *form_rows("kp_position_xy kp_velocity_xy", "x y", "place speed"),
        *form_rows("kp_position_z kp_velocity_z", "z", "place speed"),
        *form_rows("kp_tilt kd_tilt", "roll pitch", "stiffness rate"),
        FormRow("kp_yaw_rate", "yaw", "rate"),
    ),
    remarks=(
        "it measures accelerations and closes a loop around them, which its gains do not tell: the "
        "same gains make another loop in a law without it",
    ),
    exact=False,
)
FORMS = {
    "pd": PD_FORM,
    "pid": PID_FORM,
    "geometric": GEOMETRIC_FORM,
    "indi": INDI_FORM,
}
"""Forms of the core's laws; installed packages add others, `ExtensionGroup.LAW_FORMS`."""


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
    if law.unscheduled in FORMS and law.shipped:
        return FORMS[law.unscheduled]
    others = find_extensions(ExtensionGroup.LAW_FORMS)
    if law.unscheduled in others and law.shipped:
        form: Form = load_extension(ExtensionGroup.LAW_FORMS, law.unscheduled)
        return form
    raise WorkbenchError(
        f"what the gains of {law.name} mean is not known: translated are "
        f"{', '.join((*FORMS, *others))}"
    )
