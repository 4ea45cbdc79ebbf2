"""The setpoints of servos: from the law and from live parameters, delayed, low-passed and limited.

With the wanted setpoint u of a control period and the setpoint r of the period before, the next one
is r + d, where d is (1 - exp(-period / time_constant)) (u - r), at most max_rate times the period.
"""

from collections.abc import Sequence

from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
)

from workbench.plant.servo import Servo
from workbench.systems.cached import cached
from workbench.systems.discrete_system import DiscreteSystem


class ServoCommands(DiscreteSystem):
    """Holds the setpoints of all servos over a control period.

    Input port:
        commands (c): of the law, if it commands any.
    Output port:
        setpoints (k): in the order of the servos.
    Numeric parameter 0: the wanted setpoints of the others (k - c), in their order.

    Args:
        servos: all of them (k).
        commanded: places of those that the law commands (c).
        wanted: initial setpoints of the others.
        period: of control [s].
    """

    def __init__(
        self,
        *,
        servos: Sequence[Servo],
        commanded: Sequence[int],
        wanted: Sequence[float],
        period: float,
    ) -> None:
        super().__init__()
        self._servos, self._commanded = tuple(servos), tuple(commanded)
        self._others = [i for i in range(len(servos)) if i not in self._commanded]
        self._late = [servo.delay_periods(period) for servo in servos]
        self._shares = [servo.lowpass_share(period) for servo in servos]
        self._steps = [servo.max_rate * period for servo in servos]
        self._taken = -1
        if self._others:
            self.DeclareNumericParameter(BasicVector(list(wanted)))
            self._taken = int(self.DeclareDiscreteState(BasicVector(list(wanted))))
        if self._commanded:
            self._commands = self.DeclareVectorInputPort("commands", len(self._commanded))
        start = [servo.start for servo in servos]
        for place, value in zip(self._others, wanted, strict=True):
            start[place] = servos[place].within(value)
        self._previous = int(self.DeclareDiscreteState(BasicVector(start)))
        self._waiting = [
            int(self.DeclareDiscreteState(BasicVector(start))) for _ in range(max(self._late))
        ]
        needs = {self.xd_ticket()}
        if self._commanded:
            needs.add(self._commands.ticket())
        self._setpoints = cached(self._calc_setpoints, "setpoints", needs)
        self.DeclareVectorOutputPort("setpoints", len(servos), self._calc_output, needs)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_setpoints(self, context: Context) -> tuple[list[float], list[float]]:
        """Return what is wanted now, and the setpoints."""
        wanted = [0.0] * len(self._servos)
        if self._commanded:
            given = self._commands.Eval(context).tolist()
            for place, value in zip(self._commanded, given, strict=True):
                wanted[place] = value
        state = context.get_discrete_state()
        if self._others:
            taken = state.value(self._taken).tolist()
            for place, value in zip(self._others, taken, strict=True):
                wanted[place] = value
        previous = state.value(self._previous).tolist()
        waiting = [state.value(index).tolist() for index in self._waiting]
        setpoints = []
        for i, servo in enumerate(self._servos):
            late = self._late[i]
            asked = servo.within(waiting[late - 1][i] if late else wanted[i])
            step = self._shares[i] * (asked - previous[i])
            setpoints.append(previous[i] + min(max(step, -self._steps[i]), self._steps[i]))
        return wanted, setpoints

    def _calc_output(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._setpoints(context)[1])

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        wanted, setpoints = self._setpoints(context)
        newer = wanted
        for index in self._waiting:
            older = context.get_discrete_state().value(index).tolist()
            discrete_state.set_value(index, newer)
            newer = older
        discrete_state.set_value(self._previous, setpoints)
        if self._others:  # as the law's, they act from an update on
            discrete_state.set_value(self._taken, context.get_numeric_parameter(0).CopyToVector())
