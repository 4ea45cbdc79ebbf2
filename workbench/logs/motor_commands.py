"""The commands of the motors of a flight, by rotor."""

from collections.abc import Sequence

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import held_on_grid
from workbench.logs.logged_signal import MOTOR_COMMAND_PREFIX, SPEED_COMMAND_PREFIX

ROTOR_SPEED_COMMANDS, FULL_SHARE_COMMANDS = "speed", "share"
"""Kinds of commands: rotor speeds [rad/s], or shares of the full command (0 .. 1)."""


def motor_commands(
    flight: Flight, rotors: int, order: Sequence[int] = ()
) -> tuple[np.ndarray, np.ndarray, str]:
    """Return times (N) [s] and commands (N, n) of motors, by rotor, and their kind.

    Args:
        flight: of the log.
        rotors: number of rotors of the vehicle.
        order: for each rotor of the description the number of its motor in the log, from 1; empty
            for the order of the log.

    Raises:
        WorkbenchError: if the log has no commands, or those of fewer motors; or of more, and no
            order is given.
    """
    names, kind = command_names(flight, rotors, order)
    time = flight[names[0]].time
    columns = [held_on_grid(flight[name].time, flight[name].values, time) for name in names]
    return time, np.column_stack(columns), kind


def command_names(flight: Flight, rotors: int, order: Sequence[int]) -> tuple[list[str], str]:
    """Return the names of the motor commands, by rotor, and their kind; see `motor_commands`."""
    for beginning, kind in (
        (SPEED_COMMAND_PREFIX, ROTOR_SPEED_COMMANDS),
        (MOTOR_COMMAND_PREFIX, FULL_SHARE_COMMANDS),
    ):
        names = flight.motors(beginning)
        if len(names) == rotors and not order:
            return names, kind
        if len(names) >= rotors and order:
            if sorted(order) != list(range(1, rotors + 1)):
                raise WorkbenchError(
                    f"the order of motors is {','.join(map(str, order))}: give each of 1 .. "
                    f"{rotors} once, as {','.join(map(str, range(1, rotors + 1)))}"
                )
            return [names[number - 1] for number in order], kind
        if len(names) > rotors:
            raise WorkbenchError(
                f"{flight.source}: has the commands of {len(names)} motors, and the model has "
                f"{rotors} rotors: name the model that flew, with --model, or the motors that "
                f"turn its rotors, as --order {','.join(map(str, range(1, rotors + 1)))}"
            )
        if names:
            raise WorkbenchError(
                f"{flight.source}: has the commands of {len(names)} of the model's "
                f"{rotors} motors: name the model that flew, with --model"
            )
    hint = (
        "; of a simulated flight take the CSV that `workbench fly --csv FILE` writes"
        if "rotors.speed.0" in flight
        else ": log the motors' outputs"
    )
    raise WorkbenchError(f"{flight.source}: has no motor commands{hint}")
