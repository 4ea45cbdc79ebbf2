"""Rotors as systems of their own: continuous for linear models, held for playback."""

import numpy as np
from pydrake.symbolic import Variable
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, DiscreteValues, LeafSystem
from pydrake.systems.primitives import Demultiplexer, SymbolicVectorSystem

from workbench.plant.rotors import Rotor
from workbench.systems.rotor_response import rotor_period, split_error, step_rotor


def make_continuous_lag(rotors: tuple[Rotor, ...]) -> Diagram:
    """Return a diagram in which rotor speeds follow their commands; its state is the speeds.

    Commands are taken as they come: the controller keeps them within the rotors' limits.

    Input port:
        commands (n) [rad/s].
    Output ports:
        thrusts (n) [N] and speeds (n) [rad/s].
    """
    n = len(rotors)
    w = [Variable(f"w{index}") for index in range(n)]
    u = [Variable(f"u{index}") for index in range(n)]
    dynamics = []
    for w_i, u_i, rotor in zip(w, u, rotors, strict=True):
        up, down = split_error(u_i - w_i)
        dynamics.append(up / rotor.time_constant_up + down / rotor.time_constant_down)
    thrusts = [rotor.motor_constant * w_i * w_i for w_i, rotor in zip(w, rotors, strict=True)]
    builder = DiagramBuilder()
    lag = builder.AddNamedSystem(
        "speeds", SymbolicVectorSystem(state=w, input=u, dynamics=dynamics, output=[*thrusts, *w])
    )
    split = builder.AddNamedSystem("split", Demultiplexer([n, n]))
    builder.Connect(lag.get_output_port(), split.get_input_port())
    builder.ExportInput(lag.get_input_port(), "commands")
    builder.ExportOutput(split.get_output_port(0), "thrusts")
    builder.ExportOutput(split.get_output_port(1), "speeds")
    diagram = builder.Build()
    diagram.set_name("rotor_lag")
    return diagram


class HeldRotors(LeafSystem):
    """Rotors whose commands are sampled and held; between samples they follow a closed form.

    Input port:
        commands (n) [rad/s].
    Output ports, both of them state, as those of `FlightComputer`:
        thrusts (n): mean over the running period [N].
        memory (2 n): speeds at its end and commands held in it [rad/s].
    """

    def __init__(self, *, rotors: tuple[Rotor, ...], period: float) -> None:
        super().__init__()
        n = len(rotors)
        self._rotors = rotors
        self._limits = [rotor.max_rot_velocity for rotor in rotors]
        self._constants = [rotor_period(rotor, period) for rotor in rotors]
        self._commands = self.DeclareVectorInputPort("commands", n)
        self.DeclareStateOutputPort("thrusts", self.DeclareDiscreteState(n))
        self.DeclareStateOutputPort("memory", self.DeclareDiscreteState(2 * n))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def set_rotors(self, context: Context, speeds: np.ndarray) -> None:
        """Let the rotors turn steadily at `speeds` (n) [rad/s]."""
        constants = np.array([rotor.motor_constant for rotor in self._rotors])
        context.SetDiscreteState(0, constants * speeds**2)
        context.SetDiscreteState(1, np.concatenate([speeds, speeds]))

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        commands = np.clip(self._commands.Eval(context), 0.0, self._limits).tolist()
        speeds = context.get_discrete_state(1).CopyToVector()[: len(commands)].tolist()
        steps = [
            step_rotor(command, speed, constants)
            for command, speed, constants in zip(commands, speeds, self._constants, strict=True)
        ]
        discrete_state.set_value(0, [thrust for thrust, _ in steps])
        discrete_state.set_value(1, [speed for _, speed in steps] + commands)
