"""An update of the control law in compiled flights."""

from collections.abc import Callable

import numpy as np

from workbench.common.jitable import give_unique_name, register_jitable
from workbench.control.controller import Controller
from workbench.control.flight_law import allocate, flight_law, full_speed
from workbench.control.guidance import LawSetpoint
from workbench.control.law_signals import quantized_speed
from workbench.design.rollout.fields import get_field, set_field
from workbench.design.rollout.lane_times import PeriodClock

NO_ACCELERATION = (0.0, 0.0, 0.0)
"""Of a path: there is none."""
NO_BRAKE = (0.0,) * 13
"""There are no obstacles here: the numbers of `Guidance` after the point to hold."""


def make_law_update(controller: Controller) -> Callable[..., None]:
    """Return a function that runs one update of a controller, and writes `commands` [rad/s]."""
    law_update = flight_law(controller).update
    remember, memory_of = (
        (_remember_law, _memory_of) if controller.memory else (_remember_nothing, _no_memory)
    )

    @register_jitable(forceinline=True, allocates=False)
    def update(flight: np.record, clock: PeriodClock) -> None:
        """Run the law on what it knows; see `flight_law.update` for the order of the arguments."""
        holding = flight.holding
        # motors, lift and authority are on; the mode itself does not climb
        guidance = (1.0, 1.0, 1.0, 0.0, holding, holding) + get_field(flight, "hold") + NO_BRAKE
        setpoint = LawSetpoint(get_field(flight, "reference"), guidance, NO_ACCELERATION)
        filtered, memory = law_update(
            get_field(flight, "known"),
            flight.voltage,
            setpoint,
            get_field(flight, "gains"),
            flight.law,
            None,  # no loop is cut or measured
            clock.estimate,
            flight.computer,
            get_field(flight, "filtered"),
            memory_of(flight),
            flight.commands,
            flight.count,
        )
        set_field(flight, "filtered", filtered)
        remember(flight, memory)
        _quantise(flight)

    return give_unique_name(update, controller.key)


@register_jitable(allocates=False)
def command_wrench(flight: np.record, clock: PeriodClock) -> None:
    """Command the rotors to make the wrench that is asked for."""
    allocate(get_field(flight, "wrench"), 1.0, 1.0, flight.law, flight.commands)
    _quantise(flight)


@register_jitable(allocates=False)
def keep_commanded_speeds(flight: np.record, clock: PeriodClock) -> None:
    """Do nothing: the commands are what is asked for."""


@register_jitable(forceinline=True, allocates=False)
def _memory_of(flight: np.record) -> tuple[float, ...]:
    return get_field(flight, "memory")


@register_jitable(forceinline=True, allocates=False)
def _no_memory(flight: np.record) -> tuple[()]:
    return ()


@register_jitable(forceinline=True, allocates=False)
def _remember_law(flight: np.record, memory: tuple[float, ...]) -> None:
    set_field(flight, "memory", memory)


@register_jitable(forceinline=True, allocates=False)
def _remember_nothing(flight: np.record, memory: tuple[float, ...]) -> None:
    """Do nothing: the law remembers nothing."""


@register_jitable(allocates=False)
def _quantise(flight: np.record) -> None:
    """Round the commands to their resolution."""
    steps = flight.computer[2]
    if steps > 0.0:
        for k in range(len(flight.commands)):
            flight.commands[k] = quantized_speed(
                flight.commands[k], full_speed(flight.law, k), steps
            )
