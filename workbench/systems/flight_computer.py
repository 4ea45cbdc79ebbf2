"""The sampled controller as one LeafSystem."""

import math
import weakref
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    ValueProducer,
)

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.common.own_file import non_finite_named, own_errors
from workbench.control.controller import Controller, Program
from workbench.control.flight_law import (
    ALL_PARTS,
    BODY,
    PLAIN,
    ROTOR,
    SETPOINT,
    ComputerSettings,
    LawConstants,
    flight_law,
    known_vehicle,
    law_constants,
    packed,
    unpacked,
)
from workbench.control.flight_law import FILTERED as STAGES
from workbench.control.guidance import Guidance, Reference, Setpoint
from workbench.control.update import Arguments, Held, make_update, plain
from workbench.plant.payload import NO_PAYLOAD, Payload
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.weak_callback import weakly

_STRAIGHT = (0.0, 0.0, 0.0)


class FlightComputer(DiscreteSystem):
    """Samples the state, runs a controller's law, and holds the commands of the rotors.

    Input ports:
        state (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        reference (8): see `guidance.Reference`.
        guidance (22): see `guidance.Guidance`.
        feedforward (3): acceleration of a path in W [m/s²]; zero if unconnected.
        voltage (1): see `guidance.Measured`; that of a full battery if unconnected.
    Output ports, which are state:
        commands (n): rotor speeds [rad/s].
        ended (1): whether the program that runs the law has ended, after which all commands are
            zero. Only a controller that is a program has it.
    Numeric parameter 0: the controller's parameters, and the numbers that it designs.
    Numeric parameter 1: share of its thrust that each rotor gives (n), initially 1.
    Numeric parameter 2: gates and injections of the loop points, see `loop_points`.
    Numeric parameter 3: `Payload`.
    Numeric parameter 4: what the law knows of vehicle and payload, which follows from these, see
    `set_payload`.
    Numeric parameter 5: `ComputerSettings`.

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
        settings: ComputerSettings = PLAIN,
    ) -> None:
        super().__init__()
        n = len(vehicle.rotors)
        self._controller = controller
        self._program: Program | None = None
        self._run = make_update(controller)
        self._vehicle = vehicle
        self._period = period
        self._divides = bool(controller.dividers)
        self._estimate = sampled_estimate(period)
        constants = law_constants(vehicle, payload)
        numbers = controller.gains(gains, known_vehicle(constants), period)
        self.gains_index = int(self.DeclareNumericParameter(BasicVector(numbers)))
        self.shares_index = int(self.DeclareNumericParameter(BasicVector([1.0] * n)))
        self.probes_index = int(self.DeclareNumericParameter(BasicVector(controller.closed)))
        self.payload_index = int(self.DeclareNumericParameter(BasicVector(list(payload))))
        self.known_index = int(self.DeclareNumericParameter(BasicVector(_joined(constants))))
        self.settings_index = int(self.DeclareNumericParameter(BasicVector(list(settings))))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._reference = self.DeclareVectorInputPort("reference", len(Reference._fields))
        self._guidance = self.DeclareVectorInputPort("guidance", len(Guidance._fields))
        self._feedforward = self.DeclareVectorInputPort("feedforward", 3)
        self._voltage = self.DeclareVectorInputPort("voltage", 1)
        commands = self.DeclareDiscreteState(n)
        self.DeclareStateOutputPort("commands", commands)
        self._commands_state = int(commands)
        self._filtered = int(self.DeclareDiscreteState(STAGES))
        self.memory_index = self._filtered + 1
        if controller.memory:
            self.DeclareDiscreteState(BasicVector(controller.initial_memory))
        self._ended, self._ended_index = "", None
        if controller.program:
            self._ended_index = self.DeclareDiscreteState(1)
            self.DeclareStateOutputPort("ended", self._ended_index)
        inputs = (self._reference, self._guidance, self._feedforward)
        self._held = self.DeclareCacheEntry(
            "setpoint and parameters",
            ValueProducer(lambda: Value[object](()), weakly(self._calc_held)),
            {self.pn_ticket(), *(port.ticket() for port in inputs)},
        ).cache_index()
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    @property
    def period(self) -> float:
        """Between updates [s]."""
        return self._period

    @property
    def controller(self) -> Controller:
        """Whose law runs."""
        return self._controller

    @property
    def program(self) -> Program | None:
        """The running program of a law that is a program, else None."""
        return self._program

    @property
    def ended(self) -> str:
        """Why the program that runs the law has ended in flight, and what to do; else ""."""
        return self._ended

    def start_program(self, context: Context) -> None:
        """Start the program that runs the law, if there is one and it does not run yet.

        Raises:
            WorkbenchError: if it cannot be started.
        """
        law = self._controller
        if law.program is None or self._program:
            return
        payload = Payload(*context.get_numeric_parameter(self.payload_index).CopyToVector())
        known = known_vehicle(law_constants(self._vehicle, payload))
        with own_errors(law.file, "program"):
            self._program = law.program(known, self._period)
        weakref.finalize(self, self._program.close)  # if nobody calls `end_program`
        self._run = make_update(replace(law, update=self._program.update))

    def end_program(self) -> None:
        """End the program that runs the law, if there is one."""
        if self._program:
            self._program.close()
            self._run = make_update(self._controller)
        self._program = None

    def try_update(self, context: Context) -> None:
        """Run the next update on the present inputs without storing the result.

        Raises:
            WorkbenchError: if the law raises, or returns a number that is not finite.
        """
        self._update(context, self._old(context))

    def signals(self, context: Context) -> np.ndarray:
        """Return the signals of the next update at the loop points (P), in their order."""
        arguments = self._arguments(context, context.get_discrete_state())
        flight_law(self._controller).update(*arguments)
        return np.array(arguments.loops[2 * len(self._controller.points) :])

    def inject(self, context: Context, place: int, value: float) -> None:
        """Add a value to the signal of the loop point at a place, from the next update on."""
        probes = context.get_mutable_numeric_parameter(self.probes_index)
        probes.SetAtIndex(len(self._controller.points) + place, value)

    def close_loops(self, context: Context) -> None:
        """Inject nothing, and let all gates be 1, as in a normal flight."""
        context.get_mutable_numeric_parameter(self.probes_index).SetFromVector(
            self._controller.closed
        )

    def begin(self, context: Context, speeds: np.ndarray, velocity: np.ndarray) -> None:
        """Begin with rotors that turn steadily at `speeds` (n) [rad/s], at `velocity` [m/s]."""
        self._ended = ""
        context.SetDiscreteState(self._commands_state, speeds)
        filtered = np.zeros(STAGES)
        filtered[:3] = filtered[SETPOINT : SETPOINT + 3] = velocity
        context.SetDiscreteState(self._filtered, filtered)

    def set_payload(self, context: Context, payload: Payload) -> None:
        """Tell the law of a payload from now on.

        Raises:
            WorkbenchError: if it cannot hover with that; nothing changes then.
        """
        constants = law_constants(self._vehicle, payload)
        context.get_mutable_numeric_parameter(self.payload_index).SetFromVector(list(payload))
        context.get_mutable_numeric_parameter(self.known_index).SetFromVector(_joined(constants))
        self.design(context)

    def design(self, context: Context) -> None:
        """Let the controller design the numbers that follow from its gains and the payload.

        Raises:
            WorkbenchError: if it cannot design with them.
        """
        if not self._controller.designed:
            return
        gains = context.get_mutable_numeric_parameter(self.gains_index)
        payload = Payload(*context.get_numeric_parameter(self.payload_index).CopyToVector())
        known = known_vehicle(law_constants(self._vehicle, payload))
        own = gains.CopyToVector()[: len(self._controller.parameters)].tolist()
        designed = self._controller.design_with(own, known, self._period)
        gains.SetFromVector([*own, *designed])

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        if self._ended:  # the commands stay zero
            return
        arguments = self._arguments(context, discrete_state)
        try:
            total = self._run(arguments)
        except FlightBrokenError as error:
            if self._ended_index is None:
                raise
            self._ended = (
                f"{error} at t = {context.get_time():.3f} s; the rotors stop, and the flight mode "
                "is held: reset, or fly again, to start it again"
            )
            discrete_state.set_value(self._ended_index, [1.0])
            discrete_state.get_mutable_value(self._commands_state)[:] = 0.0
        except Exception as error:
            with own_errors(self._controller.file, "update"):
                raise error
        else:
            if not math.isfinite(total):
                self._break_off(context)
            discrete_state.set_value(self._filtered, arguments.filtered)
            if arguments.memory:
                discrete_state.set_value(self.memory_index, arguments.memory)
            discrete_state.set_value(self._commands_state, arguments.speeds)

    def _break_off(self, context: Context) -> None:
        """Break the flight off at an update that gives numbers that are not finite.

        Raises:
            FlightBrokenError: naming the line in the law's file, unless the update was given such
                numbers itself: the vehicle then breaks the flight off.
        """
        file, old = self._controller.file, self._old(context)
        given = [self._state.Eval(context), *(old.value(k) for k in range(old.num_groups()))]
        if not np.isfinite(np.concatenate(given)).all():
            return
        said = f"{file}: update returns a number that is not finite: check its divisions and roots"
        if self._program is None:
            try:
                with own_errors(file, "update"), non_finite_named(file, "update"):
                    make_update(self._controller)(self._arguments(context, old))
            except WorkbenchError as error:
                said = str(error)
        raise FlightBrokenError(said)

    def _old(self, context: Context) -> DiscreteValues:
        """Return a copy of the state before an update."""
        old = self.AllocateDiscreteVariables()
        old.SetFrom(context.get_discrete_state())
        return old

    def _arguments(self, context: Context, state: DiscreteValues) -> Arguments:
        """Return the arguments of an update from a discrete state."""
        held: Held = self.get_cache_entry(self._held).Eval(context)
        has_voltage, controller = self._voltage.HasValue(context), self._controller
        return Arguments(
            self._state.Eval(context).tolist(),
            self._voltage.Eval(context)[0] if has_voltage else 1.0,
            held.setpoint,
            held.gains,
            held.shares,
            held.constants,
            [*held.probes, *[0.0] * len(controller.points)],
            self._estimate,
            held.settings,
            state.value(self._filtered).tolist(),
            state.value(self.memory_index).tolist() if controller.memory else [],
            state.value(self._commands_state).tolist(),
            self._count(context),
        )

    def _calc_held(self, context: Context, output: Any) -> None:
        """Calculate `Held`."""
        has_path = self._feedforward.HasValue(context)
        gains, shares, known, probes, settings = (
            context.get_numeric_parameter(number).value()
            for number in (
                self.gains_index,
                self.shares_index,
                self.known_index,
                self.probes_index,
                self.settings_index,
            )
        )
        constants = unpacked(known[:BODY], known[BODY:].reshape(-1, ROTOR))
        setpoint = Setpoint(
            self._reference.Eval(context).tolist(),
            self._guidance.Eval(context).tolist(),
            self._feedforward.Eval(context).tolist() if has_path else _STRAIGHT,
        )
        output.set_value(
            Held(
                setpoint,
                gains.tolist(),
                shares.tolist(),
                plain(constants),
                probes.tolist(),
                settings.tolist(),
            )
        )

    def _count(self, context: Context) -> float:
        """Return the number of updates before the next one, see `ALL_PARTS`."""
        return float(round(context.get_time() / self._period)) if self._divides else ALL_PARTS


def _joined(constants: LawConstants) -> np.ndarray:
    """Return what the law knows, as `flight_law.packed_update` takes it."""
    body, rotors = packed(constants)
    return np.concatenate([body, rotors.ravel()])
