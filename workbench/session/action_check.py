"""Check what an action contains, whoever gives it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Real

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.scenario.scenario import Action, AttitudeSetpoint, Gust, Injection, Push
from workbench.scenario.scenario_check import MAX_VECTOR_COMPONENT, REQUESTS

_PART_TYPES: dict[str, type] = {
    "request": str,
    "controller": str,
    "gust": Gust,
    "push": Push,
    "injection": Injection,
    "setpoint": AttitudeSetpoint,
    "set": Mapping,
}


def checked_action(action: Action) -> Action:
    """Return an action with plain numbers that a script can hold.

    Raises:
        WorkbenchError: for the first part that a script cannot hold.
    """
    for name, kind in _PART_TYPES.items():
        part = getattr(action, name)
        if part is not None and not isinstance(part, kind):
            raise WorkbenchError(f"the {name} is {part!r:.60}: give it a {kind.__name__}")
    if action.request is not None and action.request not in REQUESTS:
        raise unknown_name("request", action.request, REQUESTS)
    velocity, place, gust, push = action.velocity, action.go_to, action.gust, action.push
    setpoint = action.setpoint
    return replace(
        action,
        velocity=None if velocity is None else checked_triple("velocity", velocity),
        yaw_rate=None if action.yaw_rate is None else checked_number("yaw rate", action.yaw_rate),
        go_to=None if place is None else checked_triple("position", place),
        height=action.height if action.request is None else _checked_height(action.height),
        gust=gust and _checked_gust(gust),
        push=push and _checked_push(push),
        setpoint=setpoint and _checked_setpoint(setpoint),
        set={name: _plain_value(value) for name, value in action.set.items()},
    )


def checked_number(what: str, value: float) -> float:
    """Return a finite number; `what` names it in the error."""
    return finite_floats(what, [value], 1)[0]


def checked_triple(what: str, values: Sequence[float]) -> list[float]:
    """Return three numbers that a script can hold."""
    x, y, z = finite_floats(what, values, 3)
    if max(abs(x), abs(y), abs(z)) > MAX_VECTOR_COMPONENT:
        raise WorkbenchError(
            f"{what} is {values!r:.60}: give it numbers within ±{MAX_VECTOR_COMPONENT:g}"
        )
    return [x, y, z]


def _plain_value(value: float) -> float:
    """Return the value of a parameter as a float; the table refuses what is no number."""
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    return float(value) if is_number else value


def _checked_height(value: float) -> float:
    """Return a height above the ground [m]."""
    height = checked_number("height", value)
    if height <= 0.0:
        raise WorkbenchError(f"the height is {height:g} m: give it one above the ground")
    return height


def _checked_gust(gust: Gust) -> Gust:
    return Gust(
        checked_triple("gust", gust.velocity), checked_number("gust_duration", gust.duration)
    )


def _checked_setpoint(setpoint: AttitudeSetpoint) -> AttitudeSetpoint:
    given = setpoint.given
    return AttitudeSetpoint(**{name: checked_number(name, x) for name, x in given.items()})


def _checked_push(push: Push) -> Push:
    return Push(
        checked_triple("push", push.force),
        checked_triple("point of the push", push.point),
        checked_number("push_duration", push.duration),
        checked_triple("torque of the push", push.torque),
    )


def finite_floats(what: str, values: Sequence[float], count: int) -> list[float]:
    """Return an expected count of numbers as floats.

    Args:
        what: name of the numbers, for the message.
        values: untrusted input of any type.
        count: expected count.

    Raises:
        WorkbenchError: if the count is wrong, or a number is not finite.
    """
    try:
        # Exclude strings, so that '123' does not count as three numbers.
        numbers = [float(value) for value in values if not isinstance(value, str)]
    except (TypeError, ValueError, OverflowError):
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise WorkbenchError(f"{what} is {values!r:.60}: give it {count} finite number(s)")
    return numbers


def check_loops_free(action: Action, injecting: float | None, attitude_is_set: bool) -> None:
    """Refuse a setpoint of attitude or rate while a loop is measured, and the other way round.

    Args:
        action: checked action.
        injecting: the flown share of an injection, None without one.
        attitude_is_set: whether there is such a setpoint.
    """
    setpoint, injection = action.setpoint, action.injection
    if setpoint and setpoint.given and injecting is not None and injecting < 1.0:
        raise WorkbenchError(
            "a loop is being measured: let that end, or give an injection without a point, before "
            "a setpoint of attitude or rate"
        )
    if injection and injection.point and attitude_is_set:
        raise WorkbenchError(
            "a setpoint of attitude or rate is given: end it, as by `setpoint: {}` in a script, "
            "before a loop is measured"
        )


def check_place(p_WB: Sequence[float], standing: float) -> None:
    """Refuse a position below that of the drone on the ground, at a height of `standing` [m]."""
    if p_WB[2] < standing:
        raise WorkbenchError(
            f"cannot go to a height of {p_WB[2]:g} m: give it {standing:g} m, at which the drone "
            "stands on the ground, or more"
        )


def check_take_off_height(height: float, standing: float, ceiling: float) -> None:
    """Refuse a height that no take-off can have [m].

    Args:
        height: height to take off to.
        standing: height of the drone on the ground [m].
        ceiling: largest allowed height [m].

    Raises:
        WorkbenchError: says which heights it may have.
    """
    if not standing < height <= ceiling:
        raise WorkbenchError(
            f"the height of a take_off is {height:g} m: give it one above {standing:g} m, at "
            f"which the drone stands, up to the {ceiling:g} m of max_height"
        )
