"""Translate gains of one law to another, with inexact parts and differences of the loops."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.design.linear.study import LinearStudy
from workbench.design.translate.forms import (
    MOVE_AXES,
    TURN_AXES,
    Form,
    FormRow,
    MoveGains,
    TurnGains,
    form_of,
)
from workbench.gains.formats import VERSION_ROW
from workbench.plant.drag import drag_rates
from workbench.plant.thrust_frame import thrust_frame

TORQUE_PARTS = frozenset(
    ("rate", "rate_integral", "slope", "ahead", "stiffness", "stiffness_integral")
)
"""Parts of a turn that command torque; all parts of a climb except position command thrust."""
SAME_AXES_TOLERANCE = 5e-3
"""Relative difference of numbers that two axes may share without a remark."""
EXACT_TEXT = "exact"
ZERO_GAIN_TOLERANCE = 1e-12
GainMeaning = dict[str, Any]
"""A `MoveGains` of each of x, y and z, and a `TurnGains` of roll, pitch and yaw."""


@dataclass(frozen=True)
class Translated:
    """One gain of the new law.

    Attributes:
        name: of the parameter.
        unit: of it.
        value: new.
        said: "exact", or why not, a clause.
    """

    name: str
    unit: str
    value: float
    said: str


@dataclass(frozen=True)
class LostPart:
    """A part of an axis without a gain in the new law, a clause."""

    axis: str
    said: str


@dataclass(frozen=True)
class Translation:
    """Gains of a law with the same meaning as those of another one.

    Attributes:
        gains: rows of the gains of the new law.
        values: all values of the new law.
        lost: parts of the old gains that are not in the new ones.
        remarks: on parts of either structure without a gain, as sentences.
        exact: whether gains determine the loops in both laws.
    """

    gains: tuple[Translated, ...]
    values: dict[str, float]
    lost: tuple[LostPart, ...]
    remarks: tuple[str, ...]
    exact: bool

    def lost_in(self, channel: str) -> tuple[str, ...]:
        """Return what a loop around an axis, or of z, lacks; with the velocity outside of it."""
        axes = {channel, {"roll": "y", "pitch": "x"}.get(channel, channel)}
        return tuple(each.said for each in self.lost if each.axis in axes)


def law_effects(study: LinearStudy, values: Mapping[str, float]) -> dict[str, float]:
    """Return the effect on a vehicle of one unit of the output of a law, by axis.

    It is the derivative of the law's own update in hover by injections at its loop points. So it
    includes its allocation, its thrust curve and that of the vehicle, and the inertia.

    Args:
        study: of the vehicle with the law.
        values: of the law's parameters.

    Returns:
        Angular acceleration per unit of torque about roll, pitch and yaw [rad/s²], and of z the
        acceleration per unit of what the velocity's error asks for [m/s²].
    """
    law = study.controller
    frame = thrust_frame(study.vehicle)
    form = form_of(law)
    plain = {**values, **dict.fromkeys(form.filters, 0.0), "spin_up_feedforward": 0.0}
    loops = {loop.name: loop for loop in law.loops}
    points = []
    for axis in TURN_AXES:
        inner = next(loops[name] for name in (f"{axis}_rate", axis, "heading") if name in loops)
        points.append(inner.point("actuator"))
    points.append(loops["velocity_z"].point("error"))
    wrench = study.wrench_by(points, plain)
    inertia = np.diagonal(frame.inertia_T)
    # the Crazyflie counts pitch the other way round, and its law sees to that
    found = {axis: abs(float(wrench[1 + k, k] / inertia[k])) for k, axis in enumerate(TURN_AXES)}
    if form.climbs_by_acceleration:
        return {**found, "z": 1.0}
    # by two gains, as an integral may act in the same update
    climb_row = next(row for row in form.rows if row.axis == "z" and row.part == "speed")
    name, unit = climb_row.name, _by_parameters(climb_row, values)
    row = law.table.find(name)
    other = max(row.minimum, 0.5 * values[name])
    if other == values[name]:
        raise WorkbenchError(f"{name} is {other:g}, its least: no vertical gain can be computed")
    less = study.wrench_by(points[3:], {**plain, name: other})
    climb = float(wrench[0, 3] - less[0, 0]) / study.vehicle.mass
    return {**found, "z": climb / ((values[name] - other) * unit)}


def meaning_of_gains(
    form: Form, values: Mapping[str, float], by: Mapping[str, float], drag: Mapping[str, float]
) -> GainMeaning:
    """Return the meaning of the gains of a law, by axis.

    Args:
        form: of the law.
        values: of its parameters.
        by: effects by axis, see `law_effects`.
        drag: of the vehicle, by which it damps velocities and the yaw rate, by axis [1/s].
    """
    found: dict[str, dict[str, float]] = {axis: {} for axis in (*MOVE_AXES, *TURN_AXES)}
    for row in form.rows:
        physical = values[row.name] * _by_parameters(row, values) * _effect(row, by)
        found[row.axis][row.part] = physical
    moves = {
        axis: MoveGains(**_plain_parts(found[axis], "speed", "place", "pull")) for axis in MOVE_AXES
    }
    turns = {
        axis: TurnGains(**_plain_parts(found[axis], "rate", "angle", "stiffness"))
        for axis in TURN_AXES
    }
    if form.slope_of_error:
        turns = {axis: turn.of_rate() for axis, turn in turns.items()}
    parts: GainMeaning = {**moves, **turns}
    if form.takes_drag:
        parts |= {axis: parts[axis].less(drag[axis]) for axis in drag}
    return parts


def gains_for_meaning(
    law: Controller,
    meant: GainMeaning,
    present: Mapping[str, float],
    by: Mapping[str, float],
    drag: Mapping[str, float],
) -> tuple[tuple[Translated, ...], tuple[LostPart, ...]]:
    """Return the gains of a law for a meaning, and the parts without a gain.

    Args:
        law: with the requested gains.
        meant: their meaning.
        present: values of all its parameters; those that are not gains stay.
        by: effects by axis of this law.
        drag: see `meaning_of_gains`.
    """
    form = form_of(law)
    parts = {axis: {row.part for row in form.rows if row.axis == axis} for axis in _form_axes(form)}
    wanted: dict[str, list[tuple[str, float]]] = {}
    lost: list[LostPart] = []
    folded = {axis: _folded(axis, meant[axis], parts[axis], lost) for axis in parts}
    if form.takes_drag:
        folded |= {axis: folded[axis].less(-drag[axis]) for axis in drag if axis in folded}
    if form.slope_of_error:
        for axis in TURN_AXES:
            found = folded[axis].of_error()
            if found is None:
                lost.append(LostPart(axis, "no gains with D on the error make this loop"))
            else:
                folded[axis] = found
    for row in form.rows:
        unit = row.scale * _by_parameters(dataclasses.replace(row, scale=1.0), present)
        unit *= _effect(row, by)
        physical = getattr(folded[row.axis], row.part)
        wanted.setdefault(row.name, []).append((row.axis, physical / unit))
    table = law.table
    gains = []
    for name, of_axes in wanted.items():
        parameter = table.find(name)
        each = [value for _, value in of_axes]
        value = sum(each) / len(each)
        said = EXACT_TEXT
        if max(each) - min(each) > SAME_AXES_TOLERANCE * max(abs(value), ZERO_GAIN_TOLERANCE):
            wishes = " and ".join(f"{v:.4g} for {axis}" for axis, v in of_axes)
            said = f"the mean of {wishes}, which share one gain here"
            lost += [LostPart(axis, f"shares {name} with another axis") for axis, _ in of_axes]
        limited = min(parameter.maximum, max(parameter.minimum, value))
        if limited != value:
            way = "largest" if limited < value else "least"
            said = f"{value:.4g} is wanted, and {limited:g} is the {way} allowed"
            lost += [LostPart(axis, f"{name} is at its limit") for axis, _ in of_axes]
        elif value == 0.0 and present[name] != 0.0:
            said = "exact: 0, as the other law has no such part"
        held = [row for row in form.rows if row.name == name and row.never_zero]
        if held and limited == 0.0:
            limited, said = present[name], f"stays: {held[0].never_zero}"
            lost += [LostPart(row.axis, f"{name} is unchanged") for row in held]
        near = [(row.axis, row.near) for row in form.rows if row.name == name and row.near]
        if near and limited:
            said = near[0][1]
            lost += [LostPart(axis, f"{name}: {said}") for axis, said in near]
        gains.append(Translated(name, parameter.unit, limited, said))
    return tuple(gains), tuple(lost)


def translate(
    old: LinearStudy,
    new: LinearStudy,
    values: Mapping[str, float],
    present: Mapping[str, float],
) -> Translation:
    """Return gains of another law with the same meaning as those of a law.

    Args:
        old: study of the vehicle with the law of the given gains.
        new: study of the same vehicle with the other law.
        values: of all parameters of the first.
        present: of all parameters of the second, for those that are not gains.

    Raises:
        WorkbenchError: if the meaning of the gains of one of them is unknown.
    """
    forms = form_of(old.controller), form_of(new.controller)
    drag = _drag_rates(old)
    meant = meaning_of_gains(forms[0], values, law_effects(old, values), drag)
    for study, form, each in zip((old, new), forms, (values, present), strict=True):
        for name in form.off:
            if each[name]:
                raise WorkbenchError(
                    f"{study.controller.name} flies with {name}, which changes the meaning of its "
                    "gains: set it to 0"
                )
    hover = forms[1].hover
    if hover:
        places = [state.name for state in new.controller.memory]
        thrust = new.trim(gains=present).memory[places.index(hover[1])]
        present = {**present, hover[0]: float(thrust)}
    gains, lost = gains_for_meaning(new.controller, meant, present, law_effects(new, present), drag)
    if hover:
        row = new.controller.table.find(hover[0])
        gains = (*gains, Translated(row.name, row.unit, present[row.name], "at which it hovers"))
    own = {VERSION_ROW, *(gain.name for gain in gains)}  # a version is that of its firmware
    shared = {
        row.name: values[row.name]
        for row in new.controller.table
        if row.name in values and row.name not in own
    }
    integrals = {row.name for row in forms[1].rows if row.part.endswith("_integral")}
    gone = [g.name for g in gains if g.name in integrals and not g.value and present[g.name]]
    remarks = []
    if gone:
        remarks.append(
            f"{', '.join(gone)} are 0: wind, and a centre of mass that is off, leave an error; "
            f"`workbench tune --controller {new.controller.name}` continues from a gain file"
        )
    heading = [row.name for row in forms[1].rows if row.axis == "yaw" and row.part == "angle"]
    if any(gain.name in heading and not gain.value for gain in gains):
        remarks.append(f"{heading[0]} is 0: nothing corrects the heading")
    remarks += [
        f"{study.controller.name}: {said}"
        for study, form in zip((old, new), forms, strict=True)
        for said in form.remarks
    ]
    if forms[0].slope_of_error != forms[1].slope_of_error:
        said = "D acts on the error of the rate in one law, and on the rate in the other"
        lost += tuple(LostPart(axis, said) for axis in TURN_AXES if meant[axis].slope)
    lost += tuple(
        LostPart(row.axis, f"{row.name}: {row.near}")
        for row in forms[0].rows
        if row.near and values[row.name]
    )
    return Translation(
        gains,
        {**present, **shared, **{gain.name: gain.value for gain in gains}},
        lost,
        tuple(dict.fromkeys(remarks)),
        exact=all(form.exact for form in forms),
    )


def _drag_rates(study: LinearStudy) -> dict[str, float]:
    """Return what laws that know it take drag to damp velocities and the yaw rate by [1/s]."""
    rates = drag_rates(study.vehicle)
    return {"x": rates.across, "y": rates.across, "yaw": rates.yaw}


def _form_axes(form: Form) -> tuple[str, ...]:
    return tuple(
        axis for axis in (*MOVE_AXES, *TURN_AXES) if any(row.axis == axis for row in form.rows)
    )


def _by_parameters(row: FormRow, values: Mapping[str, float]) -> float:
    """Return what other parameters make of a gain, and its scale."""
    factor = values[row.factor] if row.factor else 1.0
    divisor = values[row.divisor] if row.divisor else 1.0
    return row.scale * factor / divisor


def _effect(row: FormRow, by: Mapping[str, float]) -> float:
    if row.axis in TURN_AXES:
        return by[row.axis] if row.part in TORQUE_PARTS else 1.0
    return by["z"] if row.axis == "z" and not row.part.startswith("place") else 1.0


def _plain_parts(
    parts: Mapping[str, float], inner: str, outer: str, product: str
) -> dict[str, float]:
    """Return parts of a `TurnGains` or `MoveGains`, also of a law that states the product of two
    loops.
    """
    plain = {name: value for name, value in parts.items() if not name.startswith(product)}
    gain = parts.get(inner, 0.0)
    if gain > 0.0 and product in parts:
        plain[outer] = parts[product] / gain
        plain[f"{outer}_integral"] = parts.get(f"{product}_integral", 0.0) / gain
    return plain


def _folded(axis: str, meant: TurnGains | MoveGains, parts: set[str], lost: list[LostPart]) -> Any:
    """Return gains as a law with some parts can have them; add to `lost` what is left out."""
    found: Any = meant
    if isinstance(found, TurnGains):
        stiff = "stiffness" in parts
        if "angle_rate" not in parts:
            found = found.without_angle_rate()
        if not stiff and "angle_integral" not in parts and found.angle_integral:
            double = found.rate_integral * found.angle_integral
            found = found.without_angle_integral()
            if double:
                said = f"a double integral of {double:.3g} 1/s⁴, of its angle and its rate, is lost"
                lost.append(LostPart(axis, said))
        if stiff and "rate_integral" not in parts and found.rate_integral:
            said = f"the integral of the rate, {found.rate_integral:.3g} 1/s², becomes stiffness"
            if "stiffness_integral" not in parts:
                lost.append(LostPart(axis, f"{said}, and an offset stays"))
        known = parts | ({"angle", "rate_integral"} if stiff else set())
        known |= {"angle_integral"} if "stiffness_integral" in parts else set()
    else:
        pulls = "pull" in parts
        if pulls and found.speed_integral:
            said = f"the integral of the speed, {found.speed_integral:.3g} 1/s², becomes pull"
            lost.append(
                LostPart(axis, f"{said} to a held position; there is none while the pilot steers")
            )
        known = parts | ({"place", "speed_integral"} if pulls else set())
        known |= {"place_integral"} if "pull_integral" in parts else set()
    for field in dataclasses.fields(found):
        value = getattr(found, field.name)
        if field.name not in known and abs(value) > ZERO_GAIN_TOLERANCE:
            said = f"there is no {field.name.replace('_', ' ')}: {value:.3g} is left out"
            lost.append(LostPart(axis, said))
    return found
