"""A session: one diagram and its simulator, flown in slices of any length.

It has no threads and no Qt. Time advances in whole control periods, and a pilot's actions take
effect between them, so equal scenarios give equal flights, to the bit.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram

from workbench.common.errors import FlightBrokenError, WorkbenchError, sentences, unknown_name
from workbench.control.controller import (
    LIMITS,
    Controller,
    Program,
    load_controller,
    with_estimator,
)
from workbench.control.flight_law import law_constants
from workbench.control.flight_mode import REASON
from workbench.control.mode import FlightMode, Reason, Request
from workbench.diagram.sensor_choice import choose_sensors
from workbench.diagram.workbench import PICTURE_PERIOD, Workbench, make_workbench
from workbench.dynamics.air.settings import gust_settings, push_settings
from workbench.estimation.estimators import Estimator
from workbench.gains.gains import flight_gains, remark_on_owner
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import Payload, payload_of
from workbench.plant.variation import varied
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import World
from workbench.scenario.configured import (
    read_configured,
    read_configured_world,
    tell_gyro_bias,
    tell_remarks,
    tell_start,
    tell_world,
)
from workbench.scenario.parameters import check_settings, parameter_table, vehicle_parameters
from workbench.scenario.scenario import (
    REQUESTS,
    Action,
    Injection,
    Scenario,
    at_own_period,
    check_injection,
    check_scenario,
    flown_controller,
    flown_tables,
)
from workbench.session.checkpoint import Checkpoint
from workbench.session.injected import Injected, Injecting
from workbench.session.live_context import START_HEIGHT, LiveContext, start_position
from workbench.session.pilot_numbers import check_height, finite, place_above
from workbench.session.recording import Recording
from workbench.session.script import Script, scenario_feedforward, scenario_path
from workbench.session.snapshot import Snapshot
from workbench.systems.frame_poses import FrameTransforms
from workbench.systems.pilot import commanded, gone_to, requested
from workbench.systems.sensors.readings import Reading
from workbench.systems.sensors.samples import Samples

if TYPE_CHECKING:
    from workbench.link.backplane import Sampled
    from workbench.link.topics import Topic
    from workbench.systems.bridge import Bridge


@dataclass(frozen=True)
class _BuiltFlight:
    """A scenario's diagram, and its sources.

    Attributes:
        scenario: the built scenario.
        world: its world.
        values: values of all parameters, by name.
        bench: the diagram.
    """

    scenario: Scenario
    world: World
    values: Mapping[str, float]
    bench: Workbench


def _build_flight(
    scenario: Scenario,
    settings: Mapping[str, float] | None,
    meshcat: Meshcat | None,
    bridge: "Bridge | None",
    picture_period: float,
    estimator: Estimator | None = None,
) -> _BuiltFlight:
    """Read and build everything that a scenario names; arguments and exceptions as for `Session`.

    The user's own estimator continues as it flew before, even if its file has changed.
    """
    check_scenario(scenario)
    description = read_configured(scenario.vehicle)
    vehicle = make_vehicle(description)
    variation = scenario.vehicle.variation
    tell_remarks(description, vehicle)
    controller = flown_controller(scenario)
    if estimator:
        controller = with_estimator(controller, estimator)
    values = flight_gains(vehicle, scenario.vehicle.gains, settings, controller)
    tell_gyro_bias(vehicle, scenario, values)
    remark_on_owner(scenario.vehicle.gains, vehicle.name, controller)
    world = read_configured_world(scenario)
    tell_world(world)
    bench = make_workbench(
        controller,
        varied(description, vehicle, variation),
        vehicle,
        values,
        scenario.rates,
        scenario_path(scenario),
        meshcat,
        world,
        choose_sensors(vehicle, scenario),
        scenario.sensors.seed,
        variation,
        bridge,
        picture_period,
        scenario_feedforward(scenario),
        scenario.estimator,
        scenario.sensors.noise,
    )
    _check_script(scenario, vehicle, payload_of(values))
    return _BuiltFlight(scenario, world, values, bench)


def _check_script(scenario: Scenario, vehicle: Vehicle, payload: Payload) -> None:
    """Refuse actions of a script with rows or payloads that the vehicle cannot have.

    Args:
        scenario: scenario with the script.
        vehicle: vehicle as known to the controller.
        payload: payload at the start.
    """
    tables = zip(scenario.script, flown_tables(scenario), strict=True)
    for action, table in sorted(tables, key=lambda each: each[0].at):
        check_settings(vehicle, action.set, table)
        carried = {name: value for name, value in action.set.items() if name in Payload._fields}
        if carried:
            payload = payload._replace(**carried)
            law_constants(vehicle, payload)


@dataclass(frozen=True)
class _Earlier:
    """Recording before another controller took over.

    Attributes:
        time: recorded times (N) [s].
        signals: (N, size) each, by name.
        samples: rows of each kept sensor.
    """

    time: np.ndarray
    signals: Mapping[str, np.ndarray]
    samples: Sequence[np.ndarray]


class Session:
    """Builds a scenario's diagram and flies it.

    Attributes:
        records: recordings of programs that ran the law, see `Program.records`.

    Args:
        scenario: what to fly; the default one hovers.
        settings: parameter values that override those of the scenario's gains.
        meshcat: the Meshcat to draw in, if any.
        bridge: bridge to listeners and commanders, if any.
        picture_period: time between pictures in Meshcat [s]; infinite if only `draw` makes them.

    Raises:
        WorkbenchError: if the scenario cannot be built.
    """

    def __init__(
        self,
        scenario: Scenario | None = None,
        settings: Mapping[str, float] | None = None,
        meshcat: Meshcat | None = None,
        bridge: "Bridge | None" = None,
        picture_period: float = PICTURE_PERIOD,
    ) -> None:
        self.scenario = at_own_period(scenario or Scenario())
        self._settings, self._bridge = dict(settings or {}), bridge
        self._build = partial(
            _build_flight, meshcat=meshcat, bridge=bridge, picture_period=picture_period
        )
        # flown after a reset, unless a script's controller has taken over
        self._first = self._flown_with = self._build(self.scenario, self._settings)
        self._owner = self._first.bench.controller  # the gain file and settings belong to it
        self._gains = self.scenario.vehicle.gains
        self.vehicle: Vehicle = self._first.bench.vehicle
        self.world: World = self._first.world
        self._script = Script(self.scenario.script, self.scenario.rates)
        self._injecting: Injecting | None = None
        self._runs_programs = False
        self._exchange: Mapping[str, float] = {}
        self.records: Mapping[str, bytes] = {}
        self.reset()
        obstacles = self._bench.obstacles
        if obstacles and (near := obstacles.nearest(self._live.root)):
            tell_start(*near)

    def reset(self) -> None:
        """Restart from the scenario's start, with its initial parameter values.

        A program that ran the law and has ended is started again at the next tick.
        """
        self._use(self._first)
        if self.ended:
            self.end_program()
            self._exchange = {}
        self.scenario = self._first.scenario
        self._begin(None)

    def follow(self, script: Sequence[Action], duration: float) -> None:
        """Restart with another script; the flight equals that of a new session to the bit.

        Args:
            script: actions of the pilot.
            duration: of the scenario [s].

        Raises:
            WorkbenchError: if the vehicle cannot fly it.
        """
        scenario = dataclasses.replace(self._first.scenario, script=list(script), duration=duration)
        check_scenario(scenario)
        _check_script(scenario, self.vehicle, payload_of(self._first.values))
        self._first = dataclasses.replace(self._first, scenario=scenario)
        self._script = Script(scenario.script, scenario.rates)
        self.reset()

    def checkpoint(self) -> Checkpoint:
        """Return the present state of the flight, to continue from here or in another process."""
        return Checkpoint(
            time=self.time,
            steps=self._steps,
            due=self._due,
            acted=self._script.done,
            velocity=self.asked[:3],
            yaw_rate=self.asked[3],
            systems=self._live.states(),
            controller=self.controller.name,
            source=self.controller.digest,
            parameters=tuple(row.name for row in self.controller.parameters),
            memory=tuple(state.name for state in self.controller.memory),
        )

    instant = checkpoint
    """The name of `checkpoint` in earlier versions."""

    def begin_from(self, checkpoint: Checkpoint) -> None:
        """Continue from a checkpoint of a flight of the same scenario, equal to it to the bit.

        Nothing before it is recorded here. Sensors, which may differ, start again.

        A different controller takes over in flight. If its file was edited, its gains and states
        keep the values that they had under the same names. A controller of another name starts
        with its own gains, within the same limits.

        Raises:
            WorkbenchError: if it is a checkpoint of a flight of something else.
        """
        self._begin(checkpoint)

    def fly_controller(self, name_or_path: str | Path) -> None:
        """Let another controller take over in flight, as `begin_from` does; a reset keeps it.

        The recording continues; sensors start again. No simulated time passes. `scenario` stays
        that of the present flight until a reset.

        Args:
            name_or_path: see `load_controller`; the file is read now.

        Raises:
            WorkbenchError: if it cannot be read or built, or cannot continue from here; the
                present controller then continues.
        """
        self._take_over(str(name_or_path))
        flown = dataclasses.replace(self._flown_with, scenario=self.flown_scenario)
        self._first = self._flown_with = flown

    @property
    def diagram(self) -> Diagram:
        """The diagram of the flight, for reading."""
        return self._bench.diagram

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._live.root.get_time())

    def command(
        self, velocity: Sequence[float] | None = None, yaw_rate: float | None = None
    ) -> None:
        """Command a velocity in W [m/s] and a yaw rate [rad/s]; None leaves a value unchanged.

        Raises:
            WorkbenchError: if a number is not finite.
        """
        if velocity is not None:
            velocity = finite("velocity", velocity, 3)
        if yaw_rate is not None:
            yaw_rate = finite("yaw rate", [yaw_rate], 1)[0]
        self._live.wish = commanded(self._live.wish, velocity, yaw_rate)

    def go_to(self, p_WB: Sequence[float]) -> None:
        """Fly to a position in W [m] and stay there.

        Raises:
            WorkbenchError: if a number is not finite, or the scenario has its own path.
        """
        if self.scenario.figure_eight:
            raise WorkbenchError(
                "cannot go to a place while the scenario flies its figure of eight"
            )
        place = place_above("position", p_WB, self.vehicle.ground_clearance)
        self._live.wish = gone_to(self._live.wish, place)

    def request(self, what: str, height: float = START_HEIGHT) -> None:
        """Request arm, take_off (to a height [m]), hold, land, or stop (at once).

        In a landing only "stop" and "abort_landing" have an effect. The latter climbs to the
        height, or holds the position if the drone is higher.

        Raises:
            WorkbenchError: if the request is unknown.
        """
        if what not in REQUESTS:
            raise unknown_name("request", what, REQUESTS)
        check_height(what, height, self.vehicle.ground_clearance, self.get("max_height"))
        state = self._bench.recorder.now(self._live.root)["mode"]
        mode, seen = FlightMode(int(state[0])), state[1]
        self._live.wish = requested(self._live.wish, Request[what.upper()], height, mode, seen)

    @property
    def asked(self) -> tuple[float, float, float, float]:
        """The pilot's command: velocity in W [m/s] and yaw rate [rad/s]."""
        v_x, v_y, v_z, yaw_rate, *_ = self._live.wish.reference
        return v_x, v_y, v_z, yaw_rate

    @property
    def reason(self) -> Reason:
        """Why the flight mode is not the requested one, or what has failed."""
        modes = self._bench.modes
        state = modes.GetOutputPort("mode").Eval(modes.GetMyContextFromRoot(self._live.root))
        return Reason(int(state[REASON]))

    @property
    def flown_scenario(self) -> Scenario:
        """Return the present scenario with the flying controller and its gain file."""
        return dataclasses.replace(self._flown_with.scenario, script=self._first.scenario.script)

    @property
    def script(self) -> Sequence[Action]:
        """Executed actions of the scenario's script, in order of time."""
        return self._script.actions_done

    @property
    def waiting_request(self) -> Request:
        """The request that the flight mode has not read yet, NONE without one."""
        wish = self._live.wish
        seen = self._bench.recorder.now(self._live.root)["mode"][1]
        return Request(int(wish.request)) if seen < wish.serial else Request.NONE

    def gust(self, velocity: Sequence[float], duration: float = 1.0) -> None:
        """Start a gust that rises to a velocity in W [m/s] and falls, within a duration [s].

        It is added to the wind, and replaces a gust that has not ended.

        Raises:
            WorkbenchError: if a number is out of the range of its parameter.
        """
        velocity = finite("gust", velocity, 3)
        self.act(Action(set=gust_settings(velocity, self._live.next_update, duration)))

    def push(
        self,
        force: Sequence[float],
        point: Sequence[float] = (0.0, 0.0, 0.0),
        duration: float = 0.1,
        torque: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Push with a force in W [N] at a point of the body, in B [m], and a torque in B [N·m].

        It starts with the next control update, lasts for a duration [s], and replaces a push that
        has not ended.

        Raises:
            WorkbenchError: if a number is out of the range of its parameter.
        """
        force, point = finite("push", force, 3), finite("point of the push", point, 3)
        torque, start = finite("torque of the push", torque, 3), self._live.next_update
        self.act(Action(set=push_settings(force, point, start, duration, torque)))

    def inject(self, injection: Injection) -> None:
        """Add a multisine to a signal of the law from the next control update on.

        It replaces an unfinished one; an injection without a point only ends that.

        Raises:
            WorkbenchError: if it cannot be flown.
        """
        check_injection(injection, self.controller, self.scenario.rates)
        if self._injecting and not self._injecting.is_over:
            self._live.close_loops()
        self._injecting = None
        if injection.point:
            rates = self.scenario.rates
            place = self.controller.point_names.index(injection.point)
            first = round(self._live.next_update / rates.physics_step)
            divider = self.controller.point_dividers[injection.point]
            self._injecting = Injecting(injection, place, first, rates, divider)

    @property
    def injecting(self) -> float | None:
        """The flown share of an injection, 0 .. 1; None without one."""
        return self._injecting.share if self._injecting else None

    @property
    def injected(self) -> Injected | None:
        """The last injection and its response, in whole periods; None without one."""
        return self._injecting.injected if self._injecting else None

    def loop_signals(self) -> np.ndarray:
        """Return the signals of the law's next update at its loop points (P), in their order."""
        return self._live.loop_signals()

    def set(self, name: str, value: float) -> None:
        """Set a live parameter; it takes effect at the next control update.

        Raises:
            WorkbenchError: if it is unknown or out of range.
        """
        self.act(Action(set={name: value}))

    def get(self, name: str) -> float:
        """Return the present value of a live parameter."""
        return self._live.get(self._table.find(name))

    def parameters(self) -> dict[str, float]:
        """Return the live parameters that the flight has, by name."""
        values = {}
        for row in vehicle_parameters(self.vehicle, self._table):
            with suppress(WorkbenchError):  # of an inactive sensor
                values[row.name] = self.get(row.name)
        return values

    @contextmanager
    def programs(self) -> Iterator[None]:
        """Allow controllers that are programs in a `with` statement, and end them after it.

        Without it such a controller refuses to fly, because its flights are not repeatable.
        """
        self._runs_programs = True
        try:
            yield
        finally:
            self._runs_programs = False
            self.end_program()

    @property
    def program(self) -> Program | None:
        """The running program that runs the law, if the law is a program."""
        return self._bench.computer.program

    @property
    def exchange(self) -> Mapping[str, float]:
        """The statistics of the exchange with that program, see `Program.report`."""
        return self.program.report() if self.program else self._exchange

    @property
    def ended(self) -> str:
        """Why that program has ended in flight, and what to do, as one sentence; else "".

        The flight continues with stopped rotors and in the same flight mode.
        """
        return self._bench.computer.ended

    def end_program(self) -> None:
        """End the program that runs the law, and keep its recordings of the flight.

        The next tick starts another program.
        """
        if program := self._bench.computer.program:
            self._exchange, self.records = program.report(), program.records()
            self._bench.computer.end_program()

    def tick(self, duration: float) -> None:
        """Fly for a time [s]; a remainder of a control period is added to the next tick.

        Raises:
            FlightBrokenError: if the simulation cannot go on.
        """
        if not isinstance(duration, Real) or not 0.0 <= duration < math.inf:
            raise WorkbenchError(f"cannot fly on for {duration!r:.60} s: give it a positive time")
        if self._runs_programs:
            self._live.start_program()
        rates = self.scenario.rates
        self._due += duration
        target = rates.control_steps * math.floor(self._due / rates.control_period + 1e-6)
        while self._steps < target:
            for action in self._script.due(self._steps):
                if self._bridge and action.flies:  # it precedes clients, as an operator does
                    from workbench.link.authority import SCRIPT_FLIES

                    self._bridge.authority.begin(self.time, SCRIPT_FLIES)
                if action.controller is not None:
                    self._take_over(action.controller)
                self._act(action)
            self._advance(min(target, self._script.next_step, self._inject()))

    def run(self, progress: Callable[[float], None] | None = None) -> None:
        """Fly to the end of the scenario, calling `progress` with the flown share, 0 .. 1."""
        remaining = max(0.0, self.scenario.duration - self._due)
        slices = max(1, math.ceil(4.0 * remaining))
        for index in range(slices):
            self.tick(remaining / slices)
            if progress:
                progress((index + 1) / slices)

    @property
    def topics(self) -> "tuple[Topic, ...]":
        """Topics that are published; none without a bridge."""
        return self._bench.topics

    def drain(self) -> "list[Sampled]":
        """Return what was published since the last call, at most the last 20 s."""
        return self._bridge.drain() if self._bridge else []

    def recording(self) -> Recording:
        """Return everything flown since the start."""
        time, signals = self._recorded()
        return Recording.from_signals(self.vehicle, time, signals)

    def reading(self, sensor: str) -> Reading | None:
        """Return the last delivered reading of a sensor, by name or kind; None if nothing yet.

        Raises:
            WorkbenchError: if no such sensor is active in this flight.
        """
        return self._bench.sensing.find(sensor).reading(self._live.root)

    def samples(self) -> tuple[Samples, ...]:
        """Return all samples delivered since the start, if the scenario keeps them."""
        kept = zip(self._bench.sensing.kept, self._sample_rows(), strict=True)
        return tuple(mounted.samples(rows) for mounted, rows in kept)

    def snapshot(self) -> Snapshot:
        """Return the present as a frozen copy."""
        start = start_position(self.scenario.start, self.vehicle)
        return self._live.snapshot(start)

    def draw(self) -> None:
        """Draw the present in Meshcat, if the session draws."""
        visualizer = self._bench.visualizer
        if visualizer is not None:
            visualizer.ForcedPublish(visualizer.GetMyContextFromRoot(self._live.root))

    def state(self) -> np.ndarray:
        """Return the present state of the body (13): q_WB, p_WB, w_WB and v_WB, SI units."""
        return self._bench.airframe.body_state(self._live.root)

    def free_way(self, direction_W: Sequence[float], most: float) -> tuple[float, str]:
        """Return how far the drone can fly straight ahead before it may touch something [m].

        Args:
            direction_W: unit vector in W.
            most: largest distance [m].

        Returns:
            The free distance, at most `most`, and the name of the obstacle there, or "".
        """
        obstacles, found = self._bench.obstacles, (most, "")
        if obstacles is not None:
            found = obstacles.free_way(self._live.root, direction_W, most)
        down = -direction_W[2]
        if down > 0.0:
            height = float(self.state()[6]) - self.vehicle.ground_clearance
            found = min(found, (max(0.0, height) / down, "the ground"))
        return found

    def pose(self, a: str, b: str) -> RigidTransform:
        """Return X_AB, the present pose of frame B in frame A; `workbench frames` lists them.

        Raises:
            WorkbenchError: if a frame does not exist.
        """
        frames = self._bench.frames
        return frames.pose(frames.GetMyContextFromRoot(self._live.root), a, b)

    def frames(self) -> FrameTransforms:
        """Return the present pose of every frame in its parent frame."""
        frames = self._bench.frames
        return frames.transforms(frames.GetMyContextFromRoot(self._live.root))

    def act(self, action: Action) -> None:
        """Execute an action now; its `at` is ignored."""
        if action.controller is not None:
            self.fly_controller(action.controller)
        self._act(action)

    def _act(self, action: Action) -> None:
        """Execute an action other than a change of controller."""
        if action.set:
            self._live.set(action.set)
            self._tell_limits()
        if action.request is not None:
            self.request(action.request, action.height)
        if action.velocity is not None or action.yaw_rate is not None:
            self.command(action.velocity, action.yaw_rate)
        if action.go_to is not None:
            self.go_to(action.go_to)
        if action.gust is not None:
            self.gust(action.gust.velocity, action.gust.duration)
        if action.push is not None:
            push = action.push
            self.push(push.force, push.point, push.duration, push.torque)
        if action.injection is not None:
            self.inject(action.injection)

    def _use(self, built: _BuiltFlight) -> None:
        """Fly a newly built diagram from now on."""
        if built is not self._flown_with:
            self.end_program()
        self._flown_with = built
        self.controller: Controller = built.bench.controller
        self._table = parameter_table(built.bench.controller)
        self._bench, self._values = built.bench, built.values

    def _begin(self, checkpoint: Checkpoint | None) -> None:
        """Begin at a checkpoint, or at the start without one."""
        if self._bridge:
            self._bridge.reset()
        self._begin_telemetry()
        first = {} if checkpoint else self._script.first_values
        self._live = LiveContext(self._bench, self.scenario, self._values, checkpoint, first)
        self._injecting = None
        self._earlier: _Earlier | None = None
        self._steps, self._due = (checkpoint.steps, checkpoint.due) if checkpoint else (0, 0.0)
        self._script.rewind(checkpoint.acted if checkpoint else 0)
        self._tell_limits()

    def _take_over(self, name_or_path: str) -> None:
        """Switch to another controller from now on."""
        scenario = self._first.scenario
        law = with_estimator(load_controller(name_or_path), self.controller.estimator)
        if law is self.controller:
            return
        table, owner, gains = parameter_table(law), self._owner, self._gains
        settings = {name: value for name, value in self._settings.items() if name in table}
        if owner.name not in (law.name, law.unscheduled):
            gains = ""
        if owner.unscheduled != law.unscheduled:
            own = {row.name for row in owner.parameters if row.group != LIMITS}
            settings = {name: value for name, value in settings.items() if name not in own}
        scenario = dataclasses.replace(
            scenario,
            controller=name_or_path,
            script=[],
            vehicle=dataclasses.replace(scenario.vehicle, gains=gains),
        )
        scenario = at_own_period(scenario)
        built = self._build(scenario, settings, estimator=law.estimator)
        with sentences(f"the controller {law.name} cannot take over"):
            live = LiveContext(built.bench, scenario, built.values, self.checkpoint())
        self._earlier = _Earlier(*self._recorded(), self._sample_rows())
        self._injecting = None
        self._use(built)
        self._live = live
        self._begin_telemetry()
        self._tell_limits()

    def _begin_telemetry(self) -> None:
        if self._bridge and self._bench.telemetry:
            self._bench.telemetry.begin(start_position(self.scenario.start, self.vehicle))

    def _recorded(self) -> tuple[np.ndarray, Mapping[str, np.ndarray]]:
        """Return the recorded times (N) [s], and the signals."""
        time, signals = self._live.recorded()
        if self._earlier is None:
            return time, signals
        before = self._earlier.signals
        # both recordings may contain the instant itself
        new = time > self._earlier.time[-1:].max(initial=-math.inf)
        return np.concatenate([self._earlier.time, time[new]]), {
            name: np.concatenate([before[name], values[new]]) for name, values in signals.items()
        }

    def _sample_rows(self) -> list[np.ndarray]:
        """Return the rows of each kept sensor, see `Mounted.kept_rows`."""
        found = [each.kept_rows(self._live.root) for each in self._bench.sensing.kept]
        if self._earlier is None:
            return found
        return [
            np.vstack([before, now[now[:, 0] > before[-1:, 0].max(initial=-math.inf)]])
            for before, now in zip(self._earlier.samples, found, strict=True)
        ]

    def _tell_limits(self) -> None:
        """Apply the present limits to commands from the network."""
        if self._bridge:
            from workbench.link.authority import Limits

            self._bridge.settings += 1
            names = ("max_speed", "max_climb_rate", "max_yaw_rate")
            self._bridge.authority.limits = Limits(*map(self.get, names))

    def _inject(self) -> int | float:
        """Add the injection's value that is due; return the next step with one."""
        injecting = self._injecting
        if injecting is None or injecting.is_over:
            return math.inf
        injecting.act(self._steps, self._live)
        return injecting.next_step

    def _advance(self, step: int | float) -> None:
        """Simulate up to a step."""
        target = int(step)
        try:
            self._live.advance(target)
            self._steps = target
        except FlightBrokenError as error:
            raise FlightBrokenError(
                f"{error}; the flight broke off after {self.time:.3f} s"
            ) from error
        except (RuntimeError, SystemExit) as error:
            reason = " ".join(str(error).split())
            raise FlightBrokenError(
                f"the flight broke off after {self.time:.3f} s: {reason}"
            ) from error
