"""The sampled controller as one LeafSystem."""

import math
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    NumericParameterIndex,
)

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.common.own_file import user_code_errors
from workbench.control.controller import Controller
from workbench.control.flight_law import (
    ALL_PARTS,
    UNFILTERED_COMPUTER,
    ComputerSettings,
    flight_law,
)
from workbench.control.guidance import Guidance, LawSetpoint, Reference
from workbench.control.law_constants import LawConstants, known_vehicle, law_constants
from workbench.control.law_program import LawProgram
from workbench.control.law_signals import FILTER_STATE_COUNT, steady_filters
from workbench.control.update import (
    HeldArguments,
    UpdateInputs,
    check_update,
    make_control_update,
    plain_constants,
)
from workbench.plant.payload import NO_PAYLOAD, Payload
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.cached import cached
from workbench.systems.discrete_system import DiscreteSystem

_STRAIGHT = (0.0, 0.0, 0.0)
_AFTER_END = (
    "; the rotors stop, and the flight mode is held: reset, or fly again, to start it again"
)


class FlightComputer(DiscreteSystem):
    """Samples the state, runs a controller's law, and holds the commands of the rotors.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        reference (8): see `guidance.Reference`.
        guidance (22): see `guidance.Guidance`.
        feedforward (3): acceleration of a path in W [m/s²]; zero if unconnected.
        voltage (1): see `guidance.MeasuredMotion`; that of a full battery if unconnected.
        joints (2 s): positions and velocities of the joints that the law commands, if any.
    Output ports, which are state:
        commands (n + m + s): rotor speeds [rad/s], angles of tilts [rad], and setpoints of the
            servos that the law commands.
        ended (1): whether the program that runs the law has ended, after which all commands are
            zero. Only a controller that is a program has it.
    Numeric parameter 0: the controller's parameters, and the numbers that it designs.
    Numeric parameter 1: gates and injections of the loop points, see `loop_points`.
    Numeric parameter 2: `Payload`, as the law knows it.
    Numeric parameter 3: `ComputerSettings`.
    Numeric parameter 4: 1 if the hooks are open, and the law carries no loads; initially 0. Only
        with a vehicle that has loads on cables.

    Attributes:
        controller: whose law runs.
        period: between updates [s].

    Args:
        controller: whose law runs.
        vehicle: as the law knows it, without its payload.
        gains: initial values by name.
        period: between updates [s].
        payload: initial one.
        settings: initial ones of the stages around the law.

    Raises:
        WorkbenchError: if the law cannot hover with the payload that it knows.
    """

    def __init__(
        self,
        *,
        controller: Controller,
        vehicle: Vehicle,
        gains: Mapping[str, float],
        period: float,
        payload: Payload = NO_PAYLOAD,
        settings: ComputerSettings = UNFILTERED_COMPUTER,
    ) -> None:
        super().__init__()
        n = len(vehicle.rotors)
        self.controller = controller
        self._program: LawProgram | None = None
        self._run = make_control_update(controller)
        self._vehicle = vehicle
        self.period = period
        self._estimate = sampled_estimate(period)
        constants = law_constants(vehicle, payload)
        numbers = controller.gains(gains, known_vehicle(constants), period)
        self.gains_index = int(self.DeclareNumericParameter(BasicVector(numbers)))
        self.probes_index = int(self.DeclareNumericParameter(BasicVector(controller.closed)))
        self.payload_index = int(self.DeclareNumericParameter(BasicVector(list(payload))))
        self.settings_index = int(self.DeclareNumericParameter(BasicVector(list(settings))))
        self.hooks_index = None
        if vehicle.unloaded:
            self.hooks_index = int(self.DeclareNumericParameter(BasicVector([0.0])))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._reference = self.DeclareVectorInputPort("reference", len(Reference._fields))
        self._guidance = self.DeclareVectorInputPort("guidance", len(Guidance._fields))
        self._feedforward = self.DeclareVectorInputPort("feedforward", 3)
        self._voltage = self.DeclareVectorInputPort("voltage", 1)
        self._joints = None
        if controller.servos:
            self._joints = self.DeclareVectorInputPort("joints", 2 * len(controller.servos))
        self._rotors = n
        count = n + len(vehicle.tilts) + len(controller.servos)
        commands = self.DeclareDiscreteState(count)
        self.DeclareStateOutputPort("commands", commands)
        self._commands_state = int(commands)
        self._filtered = int(self.DeclareDiscreteState(FILTER_STATE_COUNT))
        self.memory_index = self._filtered + 1
        if controller.memory:
            self.DeclareDiscreteState(BasicVector(controller.initial_memory))
        self._ended, self._ended_index = "", None
        if controller.program:
            self._ended_index = self.DeclareDiscreteState(1)
            self.DeclareStateOutputPort("ended", self._ended_index)
        self._known = cached(
            self._calc_known,
            "what the law knows of the vehicle",
            {
                self.numeric_parameter_ticket(NumericParameterIndex(index))
                for index in (self.payload_index, self.hooks_index)
                if index is not None
            },
        )
        inputs = (self._reference, self._guidance, self._feedforward)
        self._held = cached(
            self._calc_held,
            "setpoint and parameters",
            {self.pn_ticket(), *(port.ticket() for port in inputs)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    @property
    def program(self) -> LawProgram | None:
        """The running program of a law that is a program, else None."""
        return self._program

    @property
    def ended(self) -> str:
        """Why the program that runs the law has ended in flight, and what to do; else "".

        That it has ended is state; the sentence is as much outside the Context as the program.
        """
        return self._ended

    def start_program(self, context: Context) -> None:
        """Start the program that runs the law, if there is one that neither runs nor has ended.

        Raises:
            WorkbenchError: if it cannot be started.
        """
        law = self.controller
        if law.program is None or self._program or self._has_ended(context):
            return
        known = known_vehicle(self._known(context))
        with user_code_errors(law.file, "program"):
            self._program = law.program(known, self.period)
        weakref.finalize(self, self._program.close)  # if nobody calls `end_program`
        self._run = make_control_update(replace(law, update=self._program.update))

    def end_program(self) -> None:
        """End the program that runs the law, if there is one."""
        if self._program:
            self._program.close()
            self._run = make_control_update(self.controller)
        self._program = None

    def continue_ended(self, context: Context) -> None:
        """Continue a flight in whose Context the program of the law may have ended."""
        if self._has_ended(context) and not self._ended:
            self._ended = (
                f"the program that runs {self.controller.name} ended before t = "
                f"{context.get_time():.3f} s, where this flight continues{_AFTER_END}"
            )

    def clear_ended(self, context: Context) -> None:
        """Let the law, whose program may have ended, run again from the next update on."""
        self._ended = ""
        if self._ended_index is not None:
            context.SetDiscreteState(self._ended_index, [0.0])

    def try_update(self, context: Context) -> None:
        """Run the next update on the present inputs without storing the result.

        Raises:
            WorkbenchError: if the law raises, or returns a number that is not finite.
        """
        self._update(context, self._old(context))

    def loop_signals(self, context: Context) -> np.ndarray:
        """Return the signals at the loop points (P) if every part of the law ran now, in order."""
        arguments = self._arguments(context, context.get_discrete_state())
        return self._signals(arguments._replace(count=ALL_PARTS))

    def probed(self, context: Context, place: int, value: float) -> float:
        """Inject a value at a loop point, and return the signal there in the next update.

        Args:
            context: of this system.
            place: index among the controller's points.
            value: value added from the next update on, which is due now.

        Returns:
            The signal before the injection; 0 if the part of the law with the point does not run.
        """
        probes = context.get_mutable_numeric_parameter(self.probes_index)
        probes.SetAtIndex(len(self.controller.points) + place, value)
        return float(self._signals(self._arguments(context, context.get_discrete_state()))[place])

    def set_point(self, context: Context, place: int, gate: float, value: float) -> None:
        """Set gate and injection of the loop point at a place, see `loop_points`."""
        probes = context.get_mutable_numeric_parameter(self.probes_index)
        probes.SetAtIndex(place, gate)
        probes.SetAtIndex(len(self.controller.points) + place, value)

    def close_loops(self, context: Context) -> None:
        """Inject nothing, and let all gates be 1, as in a normal flight."""
        context.get_mutable_numeric_parameter(self.probes_index).SetFromVector(
            self.controller.closed
        )

    def begin(self, context: Context, speeds: np.ndarray, velocity: np.ndarray) -> None:
        """Begin with rotors that turn steadily at `speeds` (n) [rad/s], at `velocity` [m/s]."""
        self._ended = ""
        count = context.get_discrete_state(self._commands_state).size()
        context.SetDiscreteState(self._commands_state, [*speeds, *[0.0] * (count - self._rotors)])
        context.SetDiscreteState(self._filtered, steady_filters(velocity.tolist()))

    def set_parameters(self, context: Context, numbers: Sequence[tuple[int, int, float]]) -> None:
        """Set numbers of numeric parameters, and design with them.

        Args:
            context: of this system.
            numbers: of each the index of its parameter, its place there, and its value.

        Raises:
            WorkbenchError: if the law cannot hover with the payload, or cannot design; nothing
                changes then.
        """
        changed = {number for number, _, _ in numbers}
        before = {
            number: context.get_numeric_parameter(number).CopyToVector() for number in changed
        }
        for number, place, value in numbers:
            context.get_mutable_numeric_parameter(number).SetAtIndex(place, value)
        try:
            if changed & {self.gains_index, self.payload_index, self.hooks_index}:
                self.design(context)
        except WorkbenchError:
            for number, values in before.items():
                context.get_mutable_numeric_parameter(number).SetFromVector(values)
            raise

    def design(self, context: Context) -> None:
        """Let the controller design the numbers that follow from its gains, payload and loads.

        Raises:
            WorkbenchError: if it cannot hover or design with them.
        """
        known = known_vehicle(self._known(context))
        if not self.controller.designed:
            return
        gains = context.get_mutable_numeric_parameter(self.gains_index)
        own = gains.CopyToVector()[: len(self.controller.parameters)].tolist()
        designed = self.controller.design_with(own, known, self.period)
        gains.SetFromVector([*own, *designed])

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        if self._has_ended(context):
            return  # the commands stay zero
        arguments = self._arguments(context, discrete_state)
        try:
            total = self._run(arguments)
        except FlightBrokenError as error:
            if self._ended_index is None:
                raise
            self._ended = f"{error} at t = {context.get_time():.3f} s{_AFTER_END}"
            discrete_state.set_value(self._ended_index, [1.0])
            discrete_state.get_mutable_value(self._commands_state)[:] = 0.0
        except Exception as error:
            with user_code_errors(self.controller.file, "update"):
                raise error
        else:
            if not math.isfinite(total):
                check_update(self.controller, self._arguments(context, self._old(context)))
            discrete_state.set_value(self._filtered, arguments.filtered)
            if arguments.memory:
                discrete_state.set_value(self.memory_index, arguments.memory)
            discrete_state.set_value(self._commands_state, arguments.speeds)

    def _has_ended(self, context: Context) -> bool:
        index = self._ended_index
        return index is not None and bool(context.get_discrete_state(index)[0])

    def _signals(self, arguments: UpdateInputs) -> np.ndarray:
        """Return the signals of an update at the loop points (P)."""
        flight_law(self.controller).update(*arguments)
        return np.array(arguments.loops[2 * len(self.controller.points) :])

    def _old(self, context: Context) -> DiscreteValues:
        """Return a copy of the state before an update."""
        old = self.AllocateDiscreteVariables()
        old.SetFrom(context.get_discrete_state())
        return old

    def _arguments(self, context: Context, state: DiscreteValues) -> UpdateInputs:
        """Return the arguments of an update from a discrete state."""
        held = self._held(context)
        has_voltage, controller = self._voltage.HasValue(context), self.controller
        motion = self._state.Eval(context).tolist()
        if self._joints:
            motion += self._joints.Eval(context).tolist()
        return UpdateInputs(
            motion,
            self._voltage.Eval(context)[0] if has_voltage else 1.0,
            held.setpoint,
            held.gains,
            held.constants,
            [*held.probes, *[0.0] * len(controller.points)],
            self._estimate,
            held.settings,
            state.value(self._filtered).tolist(),
            state.value(self.memory_index).tolist() if controller.memory else [],
            state.value(self._commands_state).tolist(),
            float(round(context.get_time() / self.period)),
        )

    def _calc_held(self, context: Context) -> HeldArguments:
        has_path = self._feedforward.HasValue(context)
        gains, probes, settings = (
            context.get_numeric_parameter(number).value().tolist()
            for number in (
                self.gains_index,
                self.probes_index,
                self.settings_index,
            )
        )
        setpoint = LawSetpoint(
            self._reference.Eval(context).tolist(),
            self._guidance.Eval(context).tolist(),
            self._feedforward.Eval(context).tolist() if has_path else _STRAIGHT,
        )
        return HeldArguments(setpoint, gains, self._known(context), probes, settings)

    def _calc_known(self, context: Context) -> LawConstants:
        payload = Payload(*context.get_numeric_parameter(self.payload_index).CopyToVector())
        vehicle = self._vehicle
        if self.hooks_index is not None:
            vehicle = vehicle.with_hooks(context.get_numeric_parameter(self.hooks_index)[0] > 0.5)
        return plain_constants(law_constants(vehicle, payload))
