"""Gains of one law as those of another, with what of it is not exact."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.control.flight_law import known_vehicle, law_constants
from workbench.design.linear.study import LinearStudy
from workbench.design.translate.cascade import Meaning, Move, Turn
from workbench.design.translate.forms import MOVES, TURNS, Form, Row, form_of
from workbench.plant.thrust_frame import thrust_frame
from workbench.scenario.parameters import parameter_table

OF_EFFORT = frozenset(
    ("rate", "rate_integral", "slope", "ahead", "stiffness", "stiffness_integral")
)
"""Parts of a turn that ask for torque; of a climb all but the place's ask for thrust."""
ALIKE = 5e-3
"""Two axes that want numbers this near share one without a word."""
EXACT = "exact"
NONE = 1e-12


@dataclass(frozen=True)
class Translated:
    """One gain of the new law.

    Attributes:
        name: of the parameter.
        unit: of it.
        value: new.
        said: "exact", or why it is not, a clause.
    """

    name: str
    unit: str
    value: float
    said: str


@dataclass(frozen=True)
class Translation:
    """Gains of a law that mean what those of another one do.

    Attributes:
        gains: rows of the new law's own gains.
        values: all values of the new law.
        remarks: what of either structure no gain carries, sentences.
    """

    gains: tuple[Translated, ...]
    values: dict[str, float]
    remarks: tuple[str, ...]


def effects(study: LinearStudy, values: Mapping[str, float]) -> dict[str, float]:
    """Return what one unit of what a law asks for makes of a vehicle, by axis.

    Taken is the derivative of the law's own update in hover, by injections at its loop points: so
    its allocation, its thrust curve and the vehicle's, and the inertia are all in it.

    Args:
        study: of the vehicle with the law.
        values: of the law's parameters.

    Returns:
        Angular acceleration per unit of torque about roll, pitch and yaw [rad/s²], and of z the
        acceleration per unit of what the velocity's error asks for [m/s²].
    """
    law = study.controller
    frame = thrust_frame(study.vehicle)
    plain = {**values, "spin_up_feedforward": 0.0}
    loops = {loop.name: loop for loop in law.loops}
    points = []
    for axis in TURNS:
        inner = next(
            loops[name] for name in (f"{axis}_rate", axis, "heading") if name in loops
        )
        points.append(inner.point("actuator"))
    points.append(loops["velocity_z"].point("error"))
    wrench = study.wrench_by(points, plain)
    inertia = np.diagonal(frame.inertia_T)
    found = {axis: float(wrench[1 + k, k] / inertia[k]) for k, axis in enumerate(TURNS)}
    climb = float(wrench[0, 3]) / study.vehicle.mass
    speeds = [row for row in form_of(law).rows if row.axis == "z" and row.part == "speed"]
    number = values[speeds[0].name] * _by_parameters(speeds[0], values)
    if number == 0.0:
        raise WorkbenchError(f"{speeds[0].name} is 0: without it nothing holds the height")
    found["z"] = climb / number
    return found


def meaning(
    form: Form, values: Mapping[str, float], by: Mapping[str, float], yaw_drag: float
) -> Meaning:
    """Return what a law's gains mean.

    Args:
        form: of the law.
        values: of its parameters.
        by: effects by axis, see `effects`.
        yaw_drag: of the vehicle, by which the rotors' drag damps the yaw rate [1/s].
    """
    found: dict[str, dict[str, float]] = {axis: {} for axis in (*MOVES, *TURNS)}
    for row in form.rows:
        physical = values[row.name] * _by_parameters(row, values) * _effect(row, by)
        found[row.axis][row.part] = physical
    moves = {axis: _move(found[axis]) for axis in MOVES}
    turns = {axis: _turn(found[axis]) for axis in TURNS}
    if form.takes_drag:
        turns["yaw"] = dataclasses.replace(turns["yaw"], rate=turns["yaw"].rate - yaw_drag)
    return Meaning(**moves, **turns)


def numbers(
    law: Controller,
    meant: Meaning,
    present: Mapping[str, float],
    by: Mapping[str, float],
    yaw_drag: float,
) -> tuple[tuple[Translated, ...], tuple[str, ...]]:
    """Return a law's gains that mean something, and what it has no gain for.

    Args:
        law: whose gains are wanted.
        meant: what they shall mean.
        present: values of all its parameters; those that are no gains stay.
        by: effects by axis of this law.
        yaw_drag: see `meaning`.
    """
    form = form_of(law)
    parts = {axis: {row.part for row in form.rows if row.axis == axis} for axis in _axes(form)}
    wanted: dict[str, list[tuple[str, float]]] = {}
    lost: list[str] = []
    folded = {axis: _folded(axis, getattr(meant, axis), parts[axis], lost) for axis in parts}
    if form.takes_drag:
        yaw = folded["yaw"]
        folded["yaw"] = dataclasses.replace(yaw, rate=yaw.rate + yaw_drag)
    for row in form.rows:
        unit = row.scale * _by_parameters(dataclasses.replace(row, scale=1.0), present)
        unit *= _effect(row, by)
        physical = getattr(folded[row.axis], row.part)
        wanted.setdefault(row.name, []).append((row.axis, physical / unit))
    table = parameter_table(law)
    gains = []
    for name, of_axes in wanted.items():
        parameter = table.find(name)
        each = [value for _, value in of_axes]
        value = sum(each) / len(each)
        said = EXACT
        if max(each) - min(each) > ALIKE * max(abs(value), NONE):
            wishes = " and ".join(f"{v:.4g} for {axis}" for axis, v in of_axes)
            said = f"the mean of {wishes}, which share it here"
        limited = min(parameter.maximum, max(parameter.minimum, value))
        if limited != value:
            way = "largest" if limited < value else "least"
            said = f"{value:.4g} is wanted, and {limited:g} is the {way} allowed"
        elif value == 0.0 and present[name] != 0.0:
            said = "exact: 0, as the other law has no such part"
        gains.append(Translated(name, parameter.unit, limited, said))
    return tuple(gains), tuple(lost)


def translate(
    old: LinearStudy,
    new: LinearStudy,
    values: Mapping[str, float],
    present: Mapping[str, float],
) -> Translation:
    """Return gains of another law that mean what those of a law do.

    Args:
        old: of the vehicle with the law that there are gains of.
        new: of the same vehicle with the other law.
        values: of all parameters of the first.
        present: of all parameters of the second, for what is no gain.

    Raises:
        WorkbenchError: if it is not known what gains of one of them mean.
    """
    forms = form_of(old.controller), form_of(new.controller)
    drag = _yaw_drag(old)
    meant = meaning(forms[0], values, effects(old, values), drag)
    gains, lost = numbers(new.controller, meant, present, effects(new, present), drag)
    shared = {
        row.name: values[row.name]
        for row in parameter_table(new.controller)
        if row.name in values and row.name not in {gain.name for gain in gains}
    }
    remarks = [
        *lost,
        *(
            f"{study.controller.name}: {said}"
            for study, form in zip((old, new), forms, strict=True)
            for said in form.remarks
        ),
    ]
    return Translation(
        gains,
        {**present, **shared, **{gain.name: gain.value for gain in gains}},
        tuple(dict.fromkeys(remarks)),
    )


def _yaw_drag(study: LinearStudy) -> float:
    """Return what laws that know it take the rotors' drag to damp the yaw rate by [1/s]."""
    return float(known_vehicle(law_constants(study.vehicle)).yaw_drag)


def _axes(form: Form) -> tuple[str, ...]:
    return tuple(axis for axis in (*MOVES, *TURNS) if any(row.axis == axis for row in form.rows))


def _by_parameters(row: Row, values: Mapping[str, float]) -> float:
    """Return what other parameters make of a gain, and its scale."""
    factor = values[row.factor] if row.factor else 1.0
    divisor = values[row.divisor] if row.divisor else 1.0
    return row.scale * factor / divisor


def _effect(row: Row, by: Mapping[str, float]) -> float:
    if row.axis in TURNS:
        return by[row.axis] if row.part in OF_EFFORT else 1.0
    return by["z"] if row.axis == "z" and not row.part.startswith("place") else 1.0


def _turn(parts: Mapping[str, float]) -> Turn:
    """Return a turn, also of a law that states what it is stiff by."""
    plain: Any = {name: value for name, value in parts.items() if not name.startswith("stiff")}
    rate = parts.get("rate", 0.0)
    if rate > 0.0 and "stiffness" in parts:
        plain["angle"] = parts["stiffness"] / rate
        plain["angle_integral"] = parts.get("stiffness_integral", 0.0) / rate
    return Turn(**plain)


def _move(parts: Mapping[str, float]) -> Move:
    """Return a move, also of a law that states what it pulls by."""
    plain: Any = {name: value for name, value in parts.items() if not name.startswith("pull")}
    speed = parts.get("speed", 0.0)
    if speed > 0.0 and "pull" in parts:
        plain["place"] = parts["pull"] / speed
        plain["place_integral"] = parts.get("pull_integral", 0.0) / speed
    return Move(**plain)


def _folded(axis: str, meant: Turn | Move, parts: set[str], lost: list[str]) -> Any:
    """Return gains as a law with some parts can have them; add to `lost` what is left out."""
    found: Any = meant
    if isinstance(found, Turn):
        stiff = "stiffness" in parts
        if "angle_rate" not in parts:
            found = found.without_angle_rate()
        if not stiff and "angle_integral" not in parts and found.angle_integral:
            double = found.rate_integral * found.angle_integral
            found = found.without_angle_integral()
            lost.append(
                f"{axis}: the integral of the angle is folded into that of the rate"
                + (f"; a double integral of {double:.3g} 1/s⁴ is lost" if double else "")
            )
        if stiff and "rate_integral" not in parts and found.rate_integral:
            stays = "" if "stiffness_integral" in parts else ", and an offset stays"
            lost.append(
                f"{axis}: the integral of the rate, {found.rate_integral:.3g} 1/s², becomes "
                f"stiffness{stays}"
            )
        known = parts | ({"angle", "rate_integral"} if stiff else set())
        known |= {"angle_integral"} if "stiffness_integral" in parts else set()
    else:
        pulls = "pull" in parts
        known = parts | ({"place", "speed_integral"} if pulls else set())
        known |= {"place_integral"} if "pull_integral" in parts else set()
    for field in dataclasses.fields(found):
        value = getattr(found, field.name)
        if field.name not in known and abs(value) > NONE:
            lost.append(
                f"{axis}: there is no {field.name.replace('_', ' ')}: {value:.3g} is left out"
            )
    return found

