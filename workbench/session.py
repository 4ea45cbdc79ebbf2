"""A session: one diagram and its simulator, flown in slices of any size.

It has no threads and no Qt. Time goes in whole physics steps, and whatever a pilot does takes
effect between steps, so that equal scenarios give equal flights, to the bit.
"""

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, Diagram, System

from workbench.configured import read_configured, tell_remarks
from workbench.diagram import Workbench, make_workbench
from workbench.errors import WorkbenchError, sentences, unknown_name
from workbench.gains import flight_gains, remark_on_owner
from workbench.parameters import Parameter, find_parameter, parameters_of
from workbench.plant.loading import make_vehicle
from workbench.plant.placing import place_vehicle
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.recording import Recording
from workbench.scenario import REQUESTS, Action, Scenario, Start, check_scenario
from workbench.snapshot import Snapshot
from workbench.systems.cascade import Reference
from workbench.systems.flight_mode import FlightMode, Request, initial_state
from workbench.systems.reference import figure_eight

START_HEIGHT = 1.5
"""Where a flight begins that starts hovering and says no place [m]."""


class Session:
    """Builds a scenario's diagram and flies it.

    Args:
        scenario: what to fly; the default one hovers.
        settings: parameter values that override those of the scenario's gains.
        meshcat: where to draw, if anywhere.

    Raises:
        WorkbenchError: if the scenario cannot be built.
    """

    def __init__(
        self,
        scenario: Scenario | None = None,
        settings: Mapping[str, float] | None = None,
        meshcat: Meshcat | None = None,
    ) -> None:
        self.scenario = scenario or Scenario()
        check_scenario(self.scenario)
        description = read_configured(self.scenario.vehicle)
        self.vehicle: Vehicle = make_vehicle(description)
        tell_remarks(description, self.vehicle)
        values = flight_gains(self.vehicle, self.scenario.vehicle.gains, settings)
        remark_on_owner(self.scenario.vehicle.gains, self.vehicle.name)
        eight = self.scenario.figure_eight
        path = (
            figure_eight(eight.center, eight.length, eight.width, eight.period, eight.laps)
            if eight
            else None
        )
        self._bench: Workbench = make_workbench(
            description, self.vehicle, values, self.scenario.rates, path, meshcat
        )
        self._script = sorted(self.scenario.script, key=lambda action: action.at)
        self.reset()

    def reset(self) -> None:
        """Begin again from the scenario's start, with the values it was built with."""
        self._simulator = Simulator(self._bench.diagram)
        self._steps = 0
        self._due = 0.0
        self._next_action = 0
        self._requests = 0
        self._start(self.scenario.start)
        with sentences("the flight could not begin"):
            self._simulator.Initialize()

    @property
    def diagram(self) -> Diagram:
        """The diagram that flies, to be looked at."""
        return self._bench.diagram

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return float(self._simulator.get_context().get_time())

    def command(
        self, velocity: Sequence[float] | None = None, yaw_rate: float | None = None
    ) -> None:
        """Ask for a velocity in W [m/s] and a yaw rate [rad/s]; what is None stays as it was.

        Raises:
            WorkbenchError: if a number is not finite.
        """
        now = self._reference()
        if velocity is not None:
            v_x, v_y, v_z = _finite("velocity", velocity, 3)
            now = now._replace(v_x=v_x, v_y=v_y, v_z=v_z, follow=0.0)
        if yaw_rate is not None:
            now = now._replace(yaw_rate=_finite("yaw rate", [yaw_rate], 1)[0])
        self._set_reference(now)

    def go_to(self, p_WB: Sequence[float]) -> None:
        """Ask for a place in W [m] and stay there.

        Raises:
            WorkbenchError: if a number is not finite, or the scenario flies a path of its own.
        """
        if self.scenario.figure_eight:
            raise WorkbenchError(
                "cannot go to a place while the scenario flies its figure of eight"
            )
        p_x, p_y, p_z = _finite("position", p_WB, 3)
        if p_z < self.vehicle.ground_clearance:
            raise WorkbenchError(
                f"cannot go to a height of {p_z:g} m: the drone stands on the ground at "
                f"{self.vehicle.ground_clearance:g} m"
            )
        now = self._reference()
        self._set_reference(Reference(0.0, 0.0, 0.0, now.yaw_rate, p_x, p_y, p_z, 1.0))

    def request(self, what: str, height: float = START_HEIGHT) -> None:
        """Ask the flight mode to arm, take_off (to a height [m]), land, or stop at once.

        Raises:
            WorkbenchError: if it is none of these.
        """
        if what not in REQUESTS:
            raise unknown_name("request", what, REQUESTS)
        standing, ceiling = self.vehicle.ground_clearance, self.get("max_height")
        if what == "take_off" and not standing < height <= ceiling:
            raise WorkbenchError(
                f"the height of a take_off is {height:g} m: give it one above {standing:g} m, at "
                f"which the drone stands, up to the {ceiling:g} m of max_height"
            )
        state = self._bench.recorder.now(self._simulator.get_context())["mode"]
        mode, seen = FlightMode(int(state[0])), state[1]
        if what in ("land", "stop") or mode in (FlightMode.OFF, FlightMode.ARMED):
            # an old command must not come into force later
            self._set_reference(Reference(*[0.0] * len(Reference._fields)))
        source = self._bench.request.get_mutable_source_value(self._context_of(self._bench.request))
        code = float(Request[what.upper()])
        if seen < self._requests:  # the last one is still to be seen: the more urgent one stays
            code = max(code, source.GetAtIndex(0))
        self._requests += 1
        source.set_value([code, float(self._requests), height])

    def set(self, name: str, value: float) -> None:
        """Give a live parameter a value; it takes effect at the next control update.

        Raises:
            WorkbenchError: if it is unknown or out of range.
        """
        row = find_parameter(name)
        vector, index = self._parameter(row)
        vector.SetAtIndex(index, row.check(value))

    def get(self, name: str) -> float:
        """Return the present value of a live parameter."""
        vector, index = self._parameter(find_parameter(name))
        return float(vector.GetAtIndex(index))

    def tick(self, duration: float) -> None:
        """Fly on for a time [s]; what does not make a whole physics step is owed to the next tick.

        Raises:
            WorkbenchError: if the simulation cannot go on.
        """
        if not 0.0 <= duration < math.inf:
            raise WorkbenchError(f"cannot fly on for {duration} s: give it a positive time")
        step = self.scenario.rates.physics_step
        self._due += duration
        target = math.floor(self._due / step + 1e-6)
        while self._steps < target:
            self._act()
            self._advance(min(target, self._next_action_step()))

    def run(self, progress: Callable[[float], None] | None = None) -> None:
        """Fly to the end of the scenario, calling `progress` with the flown share, 0 .. 1."""
        remaining = max(0.0, self.scenario.duration - self._due)
        slices = max(1, math.ceil(4.0 * remaining))
        for index in range(slices):
            self.tick(remaining / slices)
            if progress:
                progress((index + 1) / slices)

    def recording(self) -> Recording:
        """Return everything flown since the start."""
        context = self._simulator.get_context()
        recorder = self._bench.recorder
        return Recording.from_signals(
            self.vehicle, recorder.times(context), recorder.signals(context)
        )

    def snapshot(self) -> Snapshot:
        """Return the present as a frozen copy."""
        signals = self._bench.recorder.now(self._simulator.get_context())
        return Snapshot.from_signals(self.time, signals)

    def _act(self) -> None:
        """Do what the script has for this step or before it."""
        while self._next_action < len(self._script) and self._next_action_step() <= self._steps:
            action = self._script[self._next_action]
            self._next_action += 1
            self._do(action)

    def _do(self, action: Action) -> None:
        for name, value in action.set.items():
            self.set(name, value)
        if action.request is not None:
            self.request(action.request, action.height)
        if action.velocity is not None or action.yaw_rate is not None:
            self.command(action.velocity, action.yaw_rate)
        if action.go_to is not None:
            self.go_to(action.go_to)

    def _next_action_step(self) -> int | float:
        """Return the first step at or after the next action's time."""
        if self._next_action == len(self._script):
            return math.inf
        at = self._script[self._next_action].at
        return math.ceil(at / self.scenario.rates.physics_step - 1e-6)

    def _advance(self, step: int | float) -> None:
        """Simulate up to a step."""
        with sentences(f"the flight broke off after {self.time:.3f} s"):
            self._simulator.AdvanceTo(step * self.scenario.rates.physics_step)
        self._steps = int(step)

    def _start(self, start: Start) -> None:
        """Put a scenario's start into the Context."""
        flying = start.mode == "hovering"
        frame = thrust_frame(self.vehicle)
        p_WB = start_position(start, self.vehicle)
        attitude = start.roll_pitch_yaw
        plant = self._bench.airframe.plant
        place_vehicle(
            plant,
            self._context_of(plant),
            self.vehicle,
            p_WB=p_WB,
            roll_pitch_yaw=frame.roll_pitch_yaw(attitude) if flying else attitude,
            v_WB=start.velocity,
            w_WB=start.angular_velocity,
        )
        speeds = frame.hover_speeds if flying else np.zeros(len(self.vehicle.rotors))
        computer = self._bench.computer
        computer.set_rotors(self._context_of(computer), speeds, np.array(start.velocity))
        mode = FlightMode.HOVERING if flying else FlightMode.OFF
        modes = self._bench.modes
        modes.set_mode(self._context_of(modes), initial_state(mode, p_WB), p_WB)

    def _context_of(self, system: System) -> Context:
        """Return a subsystem's part of the Context, to be written only here, between steps."""
        return system.GetMyMutableContextFromRoot(self._simulator.get_mutable_context())

    def _reference(self) -> Reference:
        context = self._context_of(self._bench.pilot)
        return Reference(*self._bench.pilot.get_source_value(context).get_value().tolist())

    def _set_reference(self, reference: Reference) -> None:
        context = self._context_of(self._bench.pilot)
        self._bench.pilot.get_mutable_source_value(context).set_value(list(reference))

    def _parameter(self, row: Parameter) -> tuple[BasicVector, int]:
        """Return the vector in the Context that has a parameter, and its place there."""
        system = self._bench.diagram.GetSubsystemByName(row.system)
        vector = self._context_of(system).get_mutable_numeric_parameter(0)
        return vector, parameters_of(row.system).index(row)


def start_position(start: Start, vehicle: Vehicle) -> list[float]:
    """Return where a flight begins [m]: as said, or standing, or hovering at `START_HEIGHT`."""
    height = START_HEIGHT if start.mode == "hovering" else vehicle.ground_clearance
    return [0.0, 0.0, height] if start.position is None else [float(p) for p in start.position]


def _finite(what: str, values: Sequence[float], count: int) -> list[float]:
    numbers = [float(value) for value in values]
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise WorkbenchError(f"{what} is {list(values)}: give it {count} finite number(s)")
    return numbers
