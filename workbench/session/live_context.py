"""The Context of a flying workbench: reads it, and writes to it between steps.

A Context of a diagram with systems in Python cannot be pickled, but its numbers can.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import TypeVar

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context, Diagram, System

from workbench.common.errors import WorkbenchError, sentences
from workbench.control.controller import COMMON, LIMITS
from workbench.control.flight_mode import REASON, initial_state
from workbench.control.mode import FlightMode, Reason
from workbench.control.schedule import Schedule, parse_schedule, split_label
from workbench.diagram.core import COMMAND_DELAY, COMMAND_HOLD, STATE_DELAY, STATE_HOLD
from workbench.diagram.sensing import Mounted
from workbench.diagram.workbench import Workbench
from workbench.estimation.ekf import START
from workbench.estimation.settings import ESTIMATORS, HEARD, OWN
from workbench.plant.payload import Payload
from workbench.plant.placing import body_state
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import SENSOR_KINDS, Parameter, check_parameters, parameter_table
from workbench.scenario.scenario import Scenario, Start
from workbench.session.checkpoint import Checkpoint, Groups, SystemState
from workbench.session.integration import Integration
from workbench.session.snapshot import Clearance, LidarSummary, SensorStatus, Snapshot, Triple
from workbench.systems.noise import CountedNoise, noise_seed, seed_noise
from workbench.systems.pilot import Wish
from workbench.systems.propeller_display import PropellerDisplay
from workbench.systems.push import PushSettings
from workbench.systems.sensors.faults import Fault
from workbench.systems.sensors.readings import (
    BarometerReading,
    GpsReading,
    ImuReading,
    LidarScan,
    MagnetometerReading,
    RangeReading,
    Reading,
)
from workbench.systems.wind import WindSettings

R = TypeVar("R", bound=Reading)
Place = tuple[System, int, int]
"""A system, the index of its numeric parameter, and an index in it."""
START_HEIGHT = 1.5
"""Initial height of a flight that starts hovering without a stated position [m]."""


class LiveContext:
    """A Simulator that begins at a scenario's start, and the state that may change in flight."""

    def __init__(
        self,
        bench: Workbench,
        scenario: Scenario,
        values: Mapping[str, float] | None = None,
        checkpoint: Checkpoint | None = None,
        first: Mapping[str, float] | None = None,
    ) -> None:
        """Begin a flight.

        Args:
            bench: the flying diagram.
            scenario: its start and seed are used.
            values: values of parameters by name. Those of faults and of optional systems are set;
                the others stay as built.
            checkpoint: state to continue from; without one the flight begins at its start.
            first: values that the script sets at time 0, so that the first sample is recorded with
                them; one that is refused is refused when the script acts.

        Raises:
            WorkbenchError: if Drake cannot begin, a fault names an absent system, the checkpoint
                belongs to another flight, or another controller cannot continue from it.
        """
        self._bench = bench
        self._table = parameter_table(bench.controller)
        self._period, self._step = scenario.rates.control_period, scenario.rates.physics_step
        self._places = _places(bench)
        self._found: dict[str, list[Place]] = {}
        self.simulator = Simulator(bench.diagram)
        self._integration = Integration(self.simulator, bench.airframe, scenario.rates)
        self._start(scenario.start)
        root = self.simulator.get_mutable_context()
        airframe = bench.airframe
        for noisy in (airframe.wind, airframe.imu):
            noisy.set_seed(self._of(noisy), scenario.sensors.seed)
        bench.sensing.seed(root, scenario.sensors.seed)
        if bench.navigation:
            state = airframe.body_state(root)
            seed = None
            if scenario.sensors.noise:
                seed = noise_seed(scenario.sensors.seed, START)
            bench.navigation.begin(self._of(bench.navigation), state, seed)
        if bench.gauge:
            seed_noise(bench.gauge.noise, root, scenario.sensors.seed)
        rows = [row for row in self._table if row.system in (*SENSOR_KINDS, "gauge", "rotors")]
        faults = {row.name: row.default for row in rows}
        self.set({n: v for n, v in (values or {}).items() if n in faults and v != faults[n]})
        with suppress(WorkbenchError):
            self.set(first or {})
        airframe.wind.begin(self._of(airframe.wind))
        begin = InitializeParams()
        if checkpoint:
            _write_states(bench, root, self._taken_over(checkpoint))
            airframe.set_payload(root, self.payload)
            bench.computer.close_loops(self._of(bench.computer))
            bench.computer.design(self._of(bench.computer))
            root.SetTime(checkpoint.time)
            if checkpoint.source != bench.controller.digest:  # before anything is published
                bench.computer.try_update(self._of(bench.computer))
            # events of the start are done; those due at the present time are still to come
            begin.suppress_initialization_events = True
        with sentences("the flight could not begin"):
            self.simulator.Initialize(begin)

    @property
    def root(self) -> Context:
        """The whole diagram's Context, for reading."""
        return self.simulator.get_context()

    def advance(self, step: int) -> None:
        """Let the Simulator advance to a step of the physics."""
        self._integration.advance(step)

    @property
    def payload(self) -> Payload:
        """What the vehicle carries."""
        computer = self._bench.computer
        values = self._of(computer).get_numeric_parameter(computer.payload_index).CopyToVector()
        return Payload(*values.tolist())

    def recorded(self) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return the recorded times (N) [s], and the signals (N, size) each."""
        recorder = self._bench.recorder
        return recorder.times(self.root), recorder.signals(self.root)

    def start_program(self) -> None:
        """Start the program that runs the law, see `FlightComputer.start_program`."""
        self._bench.computer.start_program(self._of(self._bench.computer))

    def states(self) -> dict[str, SystemState]:
        """Return the states that determine the rest of the flight, by path of the system."""
        return _read_states(self._bench, self.root)

    def snapshot(self, start: Sequence[float]) -> Snapshot:
        """Return the present of a flight that began at `start` in W [m], read from the ports."""
        return _observed(self._bench, self.root, start)

    @property
    def next_update(self) -> float:
        """Time of the next control update [s]."""
        return math.ceil(self.root.get_time() / self._period - 1e-6) * self._period

    @property
    def wish(self) -> Wish:
        """The pilot's command."""
        pilot = self._bench.pilot
        return pilot.wish(self._of(pilot))

    @wish.setter
    def wish(self, wish: Wish) -> None:
        pilot = self._bench.pilot
        pilot.set_wish(self._of(pilot), wish)

    def probed(self, place: int, value: float) -> float:
        """Inject a value at a loop point, and return the present signal there.

        Args:
            place: index among the controller's points.
            value: value added from the next update on, which is due now.
        """
        computer = self._bench.computer
        computer.inject(self._of(computer), place, value)
        return float(self.loop_signals()[place])

    def loop_signals(self) -> np.ndarray:
        """Return the signals that the next update reads at the loop points (P)."""
        return self._bench.computer.signals(self._of(self._bench.computer))

    def close_loops(self) -> None:
        """Stop the injection from the next update on."""
        self._bench.computer.close_loops(self._of(self._bench.computer))

    def set(self, values: Mapping[str, float]) -> None:
        """Set live parameters by name; if one is refused, none is set.

        Raises:
            WorkbenchError: if one is unknown, out of range, or absent in this flight, or the law
                cannot fly with the new payload or gains.
        """
        good = self._table.checked(values)
        places = {name: self._find(self._table.find(name)) for name in good}
        airframe, computer = self._bench.airframe, self._bench.computer
        carried = {name: good.pop(name) for name in Payload._fields if name in good}
        if carried:
            payload = self.payload._replace(**carried)
            computer.set_payload(self._of(computer), payload)
            airframe.set_payload(self.simulator.get_mutable_context(), payload)
        chosen = [(place, value) for name, value in good.items() for place in places[name]]
        own = [
            (place[2], value)
            for place, value in chosen
            if place[:2] == (computer, computer.gains_index)
        ]
        if own:
            gains = self._of(computer).get_mutable_numeric_parameter(computer.gains_index)
            before = gains.CopyToVector()
            for index, value in own:
                gains.SetAtIndex(index, value)
            try:
                computer.design(self._of(computer))
            except WorkbenchError:
                gains.SetFromVector(before)
                raise
        for (system, number, index), value in chosen:
            if (system, number) != (computer, computer.gains_index):
                self._of(system).get_mutable_numeric_parameter(number).SetAtIndex(index, value)

    def get(self, row: Parameter) -> float:
        """Return a live parameter's value; raises as `set` does."""
        system, number, index = self._find(row)[0]
        return float(system.GetMyContextFromRoot(self.root).get_numeric_parameter(number)[index])

    def _find(self, row: Parameter) -> list[Place]:
        """Return a parameter's places in the Context; cached, because the look-up is slow.

        Raises:
            WorkbenchError: if this flight does not have it.
        """
        if row.name not in self._found:
            check_parameters(self._bench.vehicle, [row.name], self._table)
            first = self._places.get(row.name) or self._places.get(row.system)
            if not first:
                raise WorkbenchError(
                    f"{row.name} cannot be set: nothing in this flight uses it: "
                    f"{_remedy(row.system)}"
                )
            index = 0 if row.name in self._places else self._table.of(row.system).index(row)
            self._found[row.name] = [(system, n, at + index) for system, n, at in first]
        return self._found[row.name]

    def _taken_over(self, checkpoint: Checkpoint) -> Mapping[str, SystemState]:
        """Return the systems' states; by name for the controller, if it is another one."""
        law, computer = self._bench.controller, self._bench.computer
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
            gains = {row.name: gains[row.name] for row in COMMON if row.group == LIMITS}
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
            before.parameters[computer.shares_index],
            here.parameters[computer.probes_index],
            *before.parameters[computer.probes_index + 1 :],
        ]
        return {**checkpoint.systems, path: SystemState(tuple(state), tuple(parameters))}

    def _flown_gains(
        self, checkpoint: Checkpoint, schedule: Schedule, sets: Mapping[str, float]
    ) -> Mapping[str, float]:
        """Return the gains interpolated in a schedule that flew, by name."""
        body = checkpoint.systems[self._bench.airframe.plant.GetSystemPathname()]
        computer = checkpoint.systems[self._bench.computer.GetSystemPathname()]
        number = self._bench.computer.payload_index
        state, payload = body.continuous, Payload(*computer.parameters[number])
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

    def _start(self, start: Start) -> None:
        """Write a scenario's start to the Context."""
        bench, vehicle = self._bench, self._bench.vehicle
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
        bench.computer.begin(self._of(bench.computer), speeds, np.array(start.velocity))
        self._fill_delay()
        mode = FlightMode.HOVERING if flying else FlightMode.OFF
        bench.modes.set_mode(self._of(bench.modes), initial_state(mode, p_WB), p_WB)

    def _fill_delay(self) -> None:
        """Fill delays with the initial values."""
        bench = self._bench
        state = bench.airframe.body_state(self.root)
        commands = bench.computer.GetOutputPort("commands").Eval(self._of(bench.computer))
        held = {STATE_HOLD: state, STATE_DELAY: state}
        held |= {COMMAND_DELAY: commands, COMMAND_HOLD: commands}
        for name, values in held.items():
            if bench.diagram.HasSubsystemNamed(name):
                context = self._of(bench.diagram.GetSubsystemByName(name))
                many = context.get_discrete_state_vector().size() // values.size
                context.SetDiscreteState(np.tile(values, many))

    def _of(self, system: System) -> Context:
        """Return a subsystem's Context."""
        return system.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())


def start_position(start: Start, vehicle: Vehicle) -> list[float]:
    """Return where a flight begins [m]: as stated, on the ground, or hovering at `START_HEIGHT`."""
    height = START_HEIGHT if start.mode == "hovering" else vehicle.ground_clearance
    return [0.0, 0.0, height] if start.position is None else [float(p) for p in start.position]


def _places(bench: Workbench) -> dict[str, list[Place]]:
    """Return the places of the first row of each system of the parameter table.

    Most systems have their rows in numeric parameter 0 of the diagram's system of that name.
    """
    airframe, computer, navigation = bench.airframe, bench.computer, bench.navigation
    places: dict[str, list[Place]] = {
        each.get_name(): [(each, 0, 0)] for each in bench.diagram.GetSystems()
    }
    places |= {
        "gyro": [(airframe.imu, airframe.imu.settings_index, 0)],
        "payload": [(computer, computer.payload_index, 0)],
        "rotors": [(computer, computer.shares_index, 0), (airframe.rotors, 0, 0)],
        "computer": [(computer, computer.settings_index, 0)],
    }
    for system, names in (
        (airframe.wind, WindSettings._fields),
        (airframe.push, PushSettings._fields),
        (airframe.body_forces, ("drag_area", "air_density")),
    ):
        places |= {name: [(system, 0, number)] for number, name in enumerate(names)}
    for kind in SENSOR_KINDS:
        places[kind] = [(each.system, 0, 0) for each in bench.sensing.of_kind(kind)]
    if navigation:
        own = navigation.estimator
        places[own.name if own.file is None else OWN] = [(navigation, 0, 0)]
        places["imu"].insert(0, (airframe.imu, airframe.imu.fault_index, 0))
    return places


def _remedy(system: str) -> str:
    """Return how to get a missing system into a flight."""
    if system in SENSOR_KINDS:
        said = f"switch the {system.replace('_', ' ')} on, as `--sensors {system}`"
        if system in HEARD:
            said += ", or fly with an estimator, which reads it, as `--estimator ekf`"
        return said
    if system in ESTIMATORS:
        return f"fly with that estimator, as `--estimator {system}`"
    if system == "gauge":
        return "fly a drone that has a battery with an estimator, as `--estimator ekf`"
    return "fly in a world with obstacles, as `--world room`"


def _read_states(bench: Workbench, root: Context) -> dict[str, SystemState]:
    """Return the state of each system that determines the rest of the flight, by its path."""
    found = {}
    for path, system in _deciding(bench):
        context = system.GetMyContextFromRoot(root)
        continuous = tuple(context.get_continuous_state_vector().CopyToVector().tolist())
        # the plant's parameters follow from the payload
        parameters = () if isinstance(system, MultibodyPlant) else _parameters(context)
        memory = SystemState(_discrete(context), parameters, continuous)
        if memory.state or memory.parameters or continuous:
            found[path] = memory
    return found


def _write_states(bench: Workbench, root: Context, states: Mapping[str, SystemState]) -> None:
    """Write the states of a checkpoint to the systems.

    Raises:
        WorkbenchError: if the states belong to a different flight.
    """
    here = _read_states(bench, root)
    if _shapes(here) != _shapes(states):
        raise WorkbenchError(
            "the checkpoint belongs to another flight: continue with the scenario that it was "
            "taken from"
        )
    for path, system in _deciding(bench):
        if path not in states or states[path] == here[path]:
            continue
        context = system.GetMyMutableContextFromRoot(root)
        for number, values in enumerate(states[path].state):
            context.SetDiscreteState(number, values)
        for number, values in enumerate(states[path].parameters):
            context.get_mutable_numeric_parameter(number).SetFromVector(values)
        if states[path].continuous:
            context.SetContinuousState(states[path].continuous)


def _deciding(bench: Workbench) -> Iterator[tuple[str, System]]:
    """Yield the systems that determine the rest of the flight, with their paths.

    This excludes sensors that no estimator reads, with their noise, and everything that draws.
    """
    unheard = [m for m in bench.sensing.mounted if not isinstance(m.noise, CountedNoise)]
    looking = {mounted.system.GetSystemPathname() for mounted in unheard}
    looking |= {mounted.noise.GetSystemPathname() for mounted in unheard if mounted.noise}
    for system in _leaves(bench.diagram):
        path = system.GetSystemPathname()
        if path not in looking and not isinstance(system, PropellerDisplay):
            yield path, system


def _leaves(diagram: Diagram) -> Iterator[System]:
    """Yield the systems in a diagram, and in its nested diagrams."""
    for system in diagram.GetSystems():
        if isinstance(system, Diagram):
            yield from _leaves(system)
        else:
            yield system


def _discrete(context: Context) -> Groups:
    """Return the discrete state."""
    assert not context.num_abstract_states()
    groups = range(context.num_discrete_state_groups())
    return tuple(tuple(context.get_discrete_state(i).CopyToVector().tolist()) for i in groups)


def _parameters(context: Context) -> Groups:
    groups = range(context.num_numeric_parameter_groups())
    return tuple(tuple(context.get_numeric_parameter(i).CopyToVector().tolist()) for i in groups)


def _shapes(states: Mapping[str, SystemState]) -> dict[str, tuple[list[int], list[int]]]:
    """Return the number of numbers in each group."""
    return {
        path: (list(map(len, each.state)), list(map(len, each.parameters)))
        for path, each in states.items()
    }


def _observed(bench: Workbench, root_context: Context, start: Sequence[float]) -> Snapshot:
    """Return everything that a screen shows of a flight."""
    signals = bench.recorder.now(root_context)
    state = signals["state"]
    q_WB = state[0:4] / np.linalg.norm(state[0:4])
    mounted = bench.sensing.mounted
    readings = [each.reading(root_context) for each in mounted]
    scan = _first(readings, LidarScan)
    height = _first(readings, RangeReading)
    w, x, y, z = q_WB.tolist()
    return Snapshot(
        time=root_context.get_time(),
        p_WB=_triple(state[4:7]),
        q_WB=(w, x, y, z),
        v_WB=_triple(state[10:13]),
        w_WB=_triple(state[7:10]),
        vdot_WB=_triple(signals["acceleration"][3:6]),
        displacement=_triple(state[4:7] - np.array(start)),
        roll_pitch_yaw=_triple(RollPitchYaw(Quaternion(q_WB)).vector()),
        thrusts=tuple(signals["thrusts"].tolist()),
        reference=tuple(signals["reference"].tolist()),
        mode=FlightMode(int(signals["mode"][0])),
        charge=float(signals["charge"][0]),
        wind=_triple(signals["wind"]),
        imu=_first(readings, ImuReading),
        gps=_first(readings, GpsReading),
        barometer=_first(readings, BarometerReading),
        lidar=_summary(scan) if scan else None,
        height=height.distance if height else None,
        clearance=_clearance(signals["obstacle"]) if "obstacle" in signals else None,
        sensors=tuple(map(partial(_status, root_context), mounted, readings)),
        voltage=_voltage(bench, root_context),
        magnetometer=_first(readings, MagnetometerReading),
        reason=Reason(int(signals["mode"][REASON])),
    )


def _voltage(bench: Workbench, root_context: Context) -> float:
    """Return the voltage under load over that of a full battery, 1 without a stated battery."""
    rotors = bench.airframe.rotors
    port = rotors.GetOutputPort("voltage")
    return float(port.Eval(rotors.GetMyContextFromRoot(root_context))[0])


def _first(readings: Iterable[Reading | None], wanted: type[R]) -> R | None:
    """Return the first reading of a type, None without one."""
    return next((reading for reading in readings if isinstance(reading, wanted)), None)


def _summary(scan: LidarScan) -> LidarSummary:
    return LidarSummary(
        stamp=scan.stamp,
        returns=scan.returns,
        rays=scan.ranges.size,
        nearest=scan.nearest,
        direction=scan.nearest_direction if scan.returns else None,
    )


def _clearance(obstacle: np.ndarray) -> Clearance:
    distance, *direction, warning = obstacle.tolist()
    return Clearance(distance, _triple(np.array(direction)), bool(warning))


def _status(root_context: Context, mounted: Mounted, reading: Reading | None) -> SensorStatus:
    sensor, period = mounted.choice.sensor, mounted.choice.period
    time, taken = root_context.get_time(), mounted.samples_taken(root_context)
    periods = math.ceil(time / period - 1e-6)  # periods begun so far; each has a sample
    context = mounted.system.GetMyContextFromRoot(root_context)
    return SensorStatus(
        name=sensor.name,
        kind=sensor.kind,
        asked_rate=mounted.choice.asked_rate,
        rate=taken / (periods * period) if periods else 0.0,
        age=time - reading.stamp if reading else math.inf,
        fault=Fault(int(context.get_numeric_parameter(0).GetAtIndex(0))),
    )


def _triple(vector: np.ndarray) -> Triple:
    x, y, z = (float(number) for number in vector)
    return (x, y, z)
