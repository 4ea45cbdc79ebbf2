"""The linear model of what delays and low-passes setpoints of servos, see `ServoCommands`."""

from collections.abc import Sequence

import numpy as np

from workbench.design.linear.model import ModelSignal
from workbench.plant.vehicle import VehicleServo


class SetpointFilter:
    """The delays and low-passes between the commands of a law (c) and the setpoints of servos.

    Limits of setpoints and of their rates are not in a linear model.

    Attributes:
        states: those of all servos (f): of each the commands that are still to act, the newest
            first, and with a low-pass its last setpoint. A servo without delay and low-pass has
            none.

    Args:
        servos: of the last commands, in their order.
        rotors: number of commands before them.
        period: of control [s].
    """

    def __init__(self, servos: Sequence[VehicleServo], rotors: int, period: float) -> None:
        self.states: tuple[ModelSignal, ...] = ()
        self._rows: list[tuple[int, int, int, float]] = []
        for place, each in enumerate(servos, start=rotors):
            late = each.servo.delay_periods(period)
            share = each.servo.lowpass_share(period)
            self._rows.append((place, len(self.states), late, share))
            names = [f"servo_command_{ago + 1}_before_{each.joint}" for ago in range(late)]
            if share < 1.0:
                names.append(f"servo_setpoint_{each.joint}")
            self.states += tuple(ModelSignal(name, each.setpoint_unit) for name in names)

    def setpoints(self, states: np.ndarray, commands: np.ndarray) -> np.ndarray:
        """Return rows of the commands as they reach rotors and joints (c, m).

        Args:
            states: rows of the states before the update (f, m).
            commands: rows of the commands (c, m).
        """
        found = commands.copy()
        for place, first, late, share in self._rows:
            asked = states[first + late - 1] if late else commands[place]
            found[place] = asked
            if share < 1.0:
                before = states[first + late]
                found[place] = before + share * (asked - before)
        return found

    def after(self, states: np.ndarray, commands: np.ndarray) -> np.ndarray:
        """Return rows of the states after a period (f, m); arguments are those at its end."""
        found, setpoints = states.copy(), self.setpoints(states, commands)
        for place, first, late, share in self._rows:
            if late:
                found[first] = commands[place]
                found[first + 1 : first + late] = states[first : first + late - 1]
            if share < 1.0:
                found[first + late] = setpoints[place]
        return found
