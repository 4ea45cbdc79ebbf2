"""The Context of a flying workbench: reads it, and writes to it between steps.

A Context of a diagram with systems in Python cannot be pickled, but its numbers can.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context, System

from workbench.common.errors import WorkbenchError, drake_error_sentences
from workbench.common.parameter import HOOKS, Parameter, hooks_are_open
from workbench.control.controller import COMMON_PARAMETERS, LIMITS_GROUP
from workbench.control.flight_mode import initial_state
from workbench.control.mode import FlightMode, ModeRequest
from workbench.control.schedule import GainSchedule, parse_schedule, split_label
from workbench.diagram.core import COMMAND_DELAY, COMMAND_HOLD, STATE_DELAY, STATE_HOLD
from workbench.diagram.workbench import Workbench
from workbench.estimation.ekf import START_ERRORS_SOURCE
from workbench.parameters.parameter_table import check_parameters
from workbench.plant.payload import Payload
from workbench.plant.placing import body_state
from workbench.plant.sensors import sensor_kinds
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.scenario.attitude_axes import attitude_places, point_values
from workbench.scenario.scenario import AttitudeSetpoint, ScenarioStart
from workbench.session.checkpoint import Checkpoint, SystemState
from workbench.session.flight_snapshot import flight_snapshot
from workbench.session.integration import Integration
from workbench.session.live_states import read_system_states, write_system_states
from workbench.session.parameter_place import (
    ParameterPlace,
    missing_system_remedy,
    parameter_places,
)
from workbench.session.snapshot import Snapshot
from workbench.systems.noise import noise_seed, seed_noise
from workbench.systems.pilot import PilotCommand, with_mode_request

START_HEIGHT_M = 1.5
"""Initial height of a flight that starts hovering without a stated position [m]."""


class LiveContext:
    """A Simulator that begins at a scenario's start, and the state that may change in flight."""

    def __init__(
        self,
        bench: Workbench,
        checkpoint: Checkpoint | None = None,
        first: Mapping[str, float] | None = None,
        before: "LiveContext | None" = None,
    ) -> None:
        """Begin a flight.

        Args:
            bench: the flying diagram. Start and seed are its setup's; of its values, those of
                faults and of optional systems are set, and the others stay as built.
            checkpoint: state to continue from; without one the flight begins at its start.
            first: values that the script sets at time 0, so that the first sample is recorded with
                them; one that is refused is refused when the script acts.
            before: the same flight until the checkpoint, with another controller: its sensors
                continue, with their faults.

        Raises:
            WorkbenchError: if Drake cannot begin, a fault names an absent system, the checkpoint
                belongs to another flight, or another controller cannot continue from it.
        """
        setup, scenario = bench.setup, bench.setup.scenario
        self._bench, self._table = bench, setup.table
        self._period, self._step = scenario.rates.control_period, scenario.rates.physics_step
        self._places = parameter_places(bench)
        self._found: dict[str, list[ParameterPlace]] = {}
        self.simulator = Simulator(bench.diagram)
        self.integration = Integration(self.simulator, bench.airframe, scenario.rates)
        self._start(scenario.start, hooks_are_open({**setup.values, **(first or {})}))
        root = self.simulator.get_mutable_context()
        airframe = bench.airframe
        for noisy in (airframe.wind, airframe.imu):
            noisy.set_seed(self.context_of(noisy), scenario.sensors.seed)
        bench.sensing.seed(root, scenario.sensors.seed)
        if bench.navigation:
            state = airframe.body_state(root)
            seed = None
            if scenario.sensors.noise:
                seed = noise_seed(scenario.sensors.seed, START_ERRORS_SOURCE)
            bench.navigation.begin(self.context_of(bench.navigation), state, seed)
        if bench.gauge:
            seed_noise(bench.gauge.noise, root, scenario.sensors.seed)
        rows = [
            row
            for row in self._table
            if row.system in (*sensor_kinds(), "gauge", "rotors", "cables")
        ]
        faults = {row.name: row.default for row in rows}
        self.set({n: v for n, v in setup.values.items() if n in faults and v != faults[n]})
        with suppress(WorkbenchError):
            self.set(first or {})
        airframe.wind.begin(self.context_of(airframe.wind))
        begin = InitializeParams()
        if checkpoint:
            write_system_states(bench, root, self._taken_over(checkpoint))
            if before:
                self._continue_sensors(before)
            airframe.set_payload(root, self.payload)
            if airframe.ball_frames:
                airframe.ball_frames.place(root)
            bench.computer.close_loops(self.context_of(bench.computer))
            bench.computer.design(self.context_of(bench.computer))
            root.SetTime(checkpoint.time)
            bench.computer.continue_ended(self.context_of(bench.computer))
            if checkpoint.source != setup.controller.digest:  # before anything is published
                bench.computer.try_update(self.context_of(bench.computer))
            # events of the start are done; those due at the present time are still to come
            begin.suppress_initialization_events = True
        with drake_error_sentences("the flight could not begin"):
            self.simulator.Initialize(begin)

    @property
    def root(self) -> Context:
        """The whole diagram's Context, for reading."""
        return self.simulator.get_context()

    def context_of(self, system: System) -> Context:
        """Return a subsystem's Context."""
        return system.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())

    @property
    def payload(self) -> Payload:
        """What the vehicle carries."""
        computer = self._bench.computer
        values = self.context_of(computer).get_numeric_parameter(computer.payload_index)
        return Payload(*values.CopyToVector().tolist())

    def recorded(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return the recorded times (N) [s], and the signals (N, size) each."""
        recorder = self._bench.recorder
        return recorder.times(self.root), recorder.signals(self.root)

    def states(self) -> dict[str, SystemState]:
        """Return the states that determine the rest of the flight, by path of the system."""
        return read_system_states(self._bench, self.root)

    def snapshot(self, start: Sequence[float]) -> Snapshot:
        """Return the present of a flight that began at `start` in W [m], read from the ports."""
        return flight_snapshot(self._bench, self.root, start)

    @property
    def next_update(self) -> float:
        """Time of the next control update [s]."""
        return math.ceil(self.root.get_time() / self._period - 1e-6) * self._period

    @property
    def command(self) -> PilotCommand:
        """The pilot's command."""
        pilot = self._bench.pilot
        return pilot.command(self.context_of(pilot))

    @command.setter
    def command(self, command: PilotCommand) -> None:
        pilot = self._bench.pilot
        pilot.set_command(self.context_of(pilot), command)

    def request(self, what: ModeRequest, height: float) -> None:
        """Request something of the flight mode; the height is that of a take-off [m]."""
        mode, seen, *_ = self._bench.recorder.now(self.root)["mode"]
        self.command = with_mode_request(self.command, what, height, FlightMode(int(mode)), seen)

    def set_attitude(self, setpoint: AttitudeSetpoint) -> None:
        """Give the attitude and rate loops their setpoints from the next update on.

        Raises:
            WorkbenchError: if the law has no such loop.
        """
        computer = self._bench.computer
        values = point_values(setpoint, computer.controller)
        for place in attitude_places(computer.controller):
            value = values.get(computer.controller.point_names[place])
            gate = 1.0 if value is None else 0.0
            computer.set_point(self.context_of(computer), place, gate, value or 0.0)

    @property
    def attitude_is_set(self) -> bool:
        """Whether a setpoint replaces that of the loops outside."""
        computer = self._bench.computer
        probes = self.context_of(computer).get_numeric_parameter(computer.probes_index)
        return any(probes[place] == 0.0 for place in attitude_places(computer.controller))

    def set(self, values: Mapping[str, float]) -> None:
        """Set live parameters by name; if one is refused, none is set.

        Raises:
            WorkbenchError: if one is unknown, out of range, or absent in this flight, or the law
                cannot fly with the new payload or gains.
        """
        good = self._table.checked(values)
        places = {name: self._find(self._table.find(name)) for name in good}
        airframe, computer = self._bench.airframe, self._bench.computer
        if good.get(HOOKS, 1.0) == 0.0 and self.get(self._table.find(HOOKS)) != 0.0:
            airframe.refuse_closing_hooks(self.root)
        numbers = [(*place, value) for name, value in good.items() for place in places[name]]
        computer.set_parameters(
            self.context_of(computer), [row[1:] for row in numbers if row[0] is computer]
        )
        if not good.keys().isdisjoint(Payload._fields):
            airframe.set_payload(self.simulator.get_mutable_context(), self.payload)
        for system, number, index, value in numbers:
            if system is not computer:
                parameter = self.context_of(system).get_mutable_numeric_parameter(number)
                parameter.SetAtIndex(index, value)

    def get(self, row: Parameter) -> float:
        """Return a live parameter's value; raises as `set` does."""
        system, number, index = self._find(row)[0]
        return float(system.GetMyContextFromRoot(self.root).get_numeric_parameter(number)[index])

    def _find(self, row: Parameter) -> list[ParameterPlace]:
        """Return a parameter's places in the Context; cached, because the look-up is slow.

        Raises:
            WorkbenchError: if this flight does not have it.
        """
        if row.name not in self._found:
            check_parameters(self._bench.setup.vehicle, [row.name], self._table)
            first = self._places.get(row.name) or self._places.get(row.system)
            if not first:
                raise WorkbenchError(
                    f"{row.name} cannot be set: nothing in this flight uses it: "
                    f"{missing_system_remedy(row.system)}"
                )
            index = 0 if row.name in self._places else self._table.of(row.system).index(row)
            self._found[row.name] = [(system, n, at + index) for system, n, at in first]
        return self._found[row.name]

    def _continue_sensors(self, before: "LiveContext") -> None:
        """Write the states and parameters of the sensors, and of their noise, of this flight."""
        mounted = (self._bench.sensing.mounted, before._bench.sensing.mounted)
        for here, there in zip(*mounted, strict=True):
            for system, other in ((here.system, there.system), (here.noise, there.noise)):
                if system is not None and other is not None:
                    self.context_of(system).SetStateAndParametersFrom(before.context_of(other))

    def _taken_over(self, checkpoint: Checkpoint) -> Mapping[str, SystemState]:
        """Return the systems' states; by name for the controller, if it is another one."""
        law, computer = self._bench.setup.controller, self._bench.computer
        path = computer.GetSystemPathname()
        if checkpoint.source in ("", law.digest):
            return checkpoint.systems
        before, here = checkpoint.systems[path], self.states()[path]
        gains = dict(
            zip(checkpoint.parameters, before.parameters[computer.gains_index], strict=False)
        )
        known = dict(zip(checkpoint.memory, before.state[-1], strict=False))
        earlier, label = split_label(checkpoint.controller)
        if earlier != law.unscheduled:  # another law may have a gain of the same name
            gains = {
                row.name: gains[row.name] for row in COMMON_PARAMETERS if row.group == LIMITS_GROUP
            }
            known = {}
        elif label:
            gains |= self._flown_gains(checkpoint, parse_schedule(label), gains)
        own = [
            gains.get(row.name, gains.get(law.gain_of(row.name), x))
            for row, x in zip(law.parameters, here.parameters[computer.gains_index], strict=False)
        ]
        designed = here.parameters[computer.gains_index][len(own) :]
        state = [*before.state[: computer.memory_index]]
        if law.memory:
            state.append(tuple(known.get(each.name, each.initial) for each in law.memory))
        state += here.state[len(state) :]
        parameters = [
            (*own, *designed),
            here.parameters[computer.probes_index],
            *before.parameters[computer.probes_index + 1 :],
        ]
        return {**checkpoint.systems, path: SystemState(tuple(state), tuple(parameters))}

    def _flown_gains(
        self, checkpoint: Checkpoint, schedule: GainSchedule, sets: Mapping[str, float]
    ) -> Mapping[str, float]:
        """Return the gains interpolated in a schedule that flew, by name."""
        body = checkpoint.systems[self._bench.airframe.plant.GetSystemPathname()]
        computer = checkpoint.systems[self._bench.computer.GetSystemPathname()]
        number = self._bench.computer.payload_index
        state = np.array(body.continuous)[self._bench.airframe.places].tolist()
        payload = Payload(*computer.parameters[number])
        # the voltage is unknown before the flight continues: that of a full battery stands in
        now = schedule.value(
            height=state[6], velocity=state[10:13], payload=payload.known_payload_mass
        )
        found = {}
        for name in sets:
            if schedule.number_of(name) == 0:
                gain = name.removesuffix(schedule.suffixes[0])
                found[gain] = schedule.between([sets[each] for each in schedule.names(gain)], now)
        return found

    def _start(self, start: ScenarioStart, hooks_open: bool) -> None:
        """Write a scenario's start to the Context."""
        bench = self._bench
        vehicle = bench.setup.vehicle.with_hooks(hooks_open)
        flying = start.mode == "hovering"
        frame = thrust_frame(vehicle)
        p_WB = start_position(start, vehicle)
        attitude = start.roll_pitch_yaw
        state = body_state(
            p_WB=p_WB,
            roll_pitch_yaw=frame.roll_pitch_yaw(attitude) if flying else attitude,
            v_WB=start.velocity,
            w_WB=start.angular_velocity,
        )
        speeds = frame.hover_speeds if flying else np.zeros(len(vehicle.rotors))
        root = self.simulator.get_mutable_context()
        bench.airframe.place(root, state, speeds)
        bench.airframe.set_payload(root, self.payload)
        bench.computer.begin(self.context_of(bench.computer), speeds, np.array(start.velocity))
        self._fill_delay()
        mode = FlightMode.HOVERING if flying else FlightMode.OFF
        bench.modes.set_mode(self.context_of(bench.modes), initial_state(mode, p_WB), p_WB)

    def _fill_delay(self) -> None:
        """Fill delays with the initial values."""
        bench = self._bench
        state = bench.airframe.body_state(self.root)
        commands = bench.computer.GetOutputPort("commands").Eval(self.context_of(bench.computer))
        held = {STATE_HOLD: state, STATE_DELAY: state}
        held |= {COMMAND_DELAY: commands, COMMAND_HOLD: commands}
        for name, values in held.items():
            if bench.diagram.HasSubsystemNamed(name):
                context = self.context_of(bench.diagram.GetSubsystemByName(name))
                many = context.get_discrete_state_vector().size() // values.size
                context.SetDiscreteState(np.tile(values, many))


def start_position(start: ScenarioStart, vehicle: Vehicle) -> list[float]:
    """Return where a flight begins [m]: as stated, on the ground, or hovering at
    `START_HEIGHT_M`.
    """
    height = START_HEIGHT_M if start.mode == "hovering" else vehicle.ground_clearance
    return [0.0, 0.0, height] if start.position is None else [float(p) for p in start.position]
