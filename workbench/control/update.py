"""One update of a control law in plain Python, with its arguments by name."""

from collections.abc import Callable
from contextlib import nullcontext
from typing import NamedTuple

import numpy as np

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.common.own_file import limit_call_time, locate_non_finite, user_code_errors
from workbench.control.controller import Controller
from workbench.control.flight_law import flight_law, full_speed
from workbench.control.guidance import LawSetpoint
from workbench.control.law_constants import LawConstants
from workbench.control.law_signals import quantized_speed


class HeldArguments(NamedTuple):
    """Arguments of an update that seldom change; reading them costs more than the law.

    Attributes:
        setpoint: see `guidance.LawSetpoint`.
        gains: in the controller's order.
        constants: what the law knows of the vehicle.
        probes: gates and injections of the loop points.
        settings: see `ComputerSettings`.
    """

    setpoint: LawSetpoint
    gains: list[float]
    constants: LawConstants
    probes: list[float]
    settings: list[float]


class UpdateInputs(NamedTuple):
    """The arguments of an update, in its order; see `flight_law.update`.

    Plain lists of numbers, as numpy's own numbers take three times as long. An update writes to
    loops, filtered, memory and speeds.
    """

    state: list[float]
    voltage: float
    setpoint: LawSetpoint
    gains: list[float]
    constants: LawConstants
    loops: list[float]
    estimate: tuple[float, float]
    settings: list[float]
    filtered: list[float]
    memory: list[float]
    speeds: list[float]
    count: float


def make_control_update(controller: Controller) -> Callable[[UpdateInputs], float]:
    """Return the control update with a controller, see `flight_law.update`.

    It writes its results to its arguments, and returns a number that is finite if all that the law
    commands and remembers is.
    """
    function = flight_law(controller).update
    watched = not controller.shipped and controller.program is None

    def run(arguments: UpdateInputs) -> float:
        # as in compiled flights: a division by zero is an error, other non-finite numbers are not
        with (
            np.errstate(divide="raise", over="ignore", invalid="ignore"),
            limit_call_time(controller.file, "update") if watched else nullcontext(),
        ):
            filtered, memory = function(*arguments)
        arguments.filtered[:], arguments.memory[:] = filtered, memory
        total: float = sum(arguments.speeds) + sum(memory)
        steps = arguments.settings[2]
        if steps > 0.0:
            rotors = len(arguments.constants.motor_constants)
            for i, speed in enumerate(arguments.speeds[:rotors]):
                arguments.speeds[i] = quantized_speed(
                    speed, full_speed(arguments.constants, i), steps
                )
        return total

    return run


def check_update(controller: Controller, arguments: UpdateInputs) -> None:
    """Find out why an update gives numbers that are not finite.

    Raises:
        FlightBrokenError: naming the line in the law's file, unless the update is given such
            numbers itself: the vehicle then breaks the flight off.
    """
    given = [*arguments.state, *arguments.filtered, *arguments.memory, *arguments.speeds]
    if not np.isfinite(given).all():
        return
    file = controller.file
    message = f"{file}: update returns a number that is not finite: check its divisions and roots"
    if controller.program is None:
        try:
            with user_code_errors(file, "update"), locate_non_finite(file, "update"):
                make_control_update(controller)(arguments)
        except WorkbenchError as error:
            message = str(error)
    raise FlightBrokenError(message)


def plain_constants(constants: LawConstants) -> LawConstants:
    """Return constants as plain numbers and lists."""
    return LawConstants(*(np.asarray(each).tolist() for each in constants))
