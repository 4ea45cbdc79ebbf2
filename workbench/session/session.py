"""A session: one diagram and its simulator, flown in slices of any length.

It has no threads and no Qt. Time advances in whole control periods, and a pilot's actions take
effect between them, so equal scenarios give equal flights, to the bit.
"""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING

from pydrake.geometry import Meshcat

from workbench.common.errors import WorkbenchError, drake_error_sentences
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller, with_estimator
from workbench.control.law_program import LawProgram
from workbench.control.mode import ModeRequest
from workbench.diagram.workbench import MESHCAT_PERIOD_S, Workbench, make_workbench
from workbench.scenario.configured import warn_of_start_contact
from workbench.scenario.pilot_orders import PilotOrders
from workbench.scenario.scenario import Action, Injection, Scenario
from workbench.scenario.scenario_check import check_injection
from workbench.session.action_check import (
    check_loops_free,
    check_place,
    check_take_off_height,
    checked_action,
)
from workbench.session.checkpoint import Checkpoint
from workbench.session.injected import ActiveInjection, InjectedSignal
from workbench.session.live_context import LiveContext, start_position
from workbench.session.observed_flight import ObservedFlight
from workbench.session.script import Script, disturbance_settings
from workbench.setup import Setup, log_setup, make_setup, with_servos_of
from workbench.systems.pilot import with_position_command, with_velocity_command

if TYPE_CHECKING:
    from workbench.link.backplane import Sampled
    from workbench.systems.bridge import Bridge


class Session(ObservedFlight, PilotOrders[None]):
    """Builds a scenario's diagram and flies it.

    Attributes:
        records: recordings of programs that ran the law, see `LawProgram.records`.

    Args:
        scenario: what to fly, or its setup; the default one hovers.
        settings: parameter values that override those of the scenario's gains.
        meshcat: the Meshcat to draw in, if any.
        bridge: bridge to listeners and commanders, if any.
        picture_period: time between pictures in Meshcat [s]; infinite if only `draw` makes them.

    Raises:
        WorkbenchError: if the scenario cannot be built.
    """

    def __init__(
        self,
        scenario: Scenario | Setup | None = None,
        settings: Mapping[str, float] | None = None,
        meshcat: Meshcat | None = None,
        bridge: "Bridge | None" = None,
        picture_period: float = MESHCAT_PERIOD_S,
    ) -> None:
        # the gain file and the settings belong to its law
        self._given = setup = make_setup(scenario, settings)
        self.scenario, self._bridge = setup.scenario, bridge
        self._build = partial(
            make_workbench, meshcat=meshcat, bridge=bridge, picture_period=picture_period
        )
        log_setup(setup)
        # flown after a reset, unless a script's controller has taken over
        self._first = self._bench = self._build(setup)
        self.vehicle, self.description, self.world = setup.vehicle, setup.flown, setup.world
        self._script = Script(self.scenario.script, self.scenario.rates)
        self._injecting: ActiveInjection | None = None
        self._runs_programs = False
        self._exchange: Mapping[str, float] = {}
        self.records: Mapping[str, bytes] = {}
        self.reset()
        obstacles = self._bench.obstacles
        if obstacles and (near := obstacles.nearest(self._live.root)):
            warn_of_start_contact(*near)

    def reset(self) -> None:
        """Restart from the scenario's start, with its initial parameter values.

        A program that ran the law and has ended is started again at the next tick.
        """
        self._use(self._first)
        if self.ended:
            self.end_program()
            self._exchange = {}
        self.scenario = self._first.setup.scenario
        self._begin(None)

    def follow(self, script: Sequence[Action], duration: float) -> None:
        """Restart with another script; the flight equals that of a new session to the bit.

        Args:
            script: actions of the pilot.
            duration: of the scenario [s].

        Raises:
            WorkbenchError: if the vehicle cannot fly it.
        """
        first = self._first.setup
        setup = first.with_scenario(
            dataclasses.replace(first.scenario, script=list(script), duration=duration)
        )
        self._first = dataclasses.replace(self._first, setup=setup)
        self._script = Script(script, setup.rates)
        self.reset()

    def checkpoint(self) -> Checkpoint:
        """Return the present state of the flight, to continue from here or in another process."""
        return Checkpoint(
            time=self.time,
            steps=self._steps,
            due=self._due,
            acted=self._script.done,
            script_ended=self._script.ended,
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

    def do(self, action: Action) -> None:
        """Execute an action now, see `Action.ends_script`; its `at` is ignored.

        Raises:
            WorkbenchError: if a number, a name or a request is not valid, or the flight lacks what
                the action needs.
        """
        action = checked_action(action)
        if action.controller is not None:
            self._take_over(action.controller)
            setup = dataclasses.replace(self._bench.setup, scenario=self.flown_scenario)
            self._first = self._bench = dataclasses.replace(self._bench, setup=setup)
        live, standing = self._live, self.vehicle.ground_clearance
        check_loops_free(action, self.injecting, live.attitude_is_set)
        if values := action.set | disturbance_settings(action, live.next_update):
            live.set(values)
            self._update_limits()
        if action.request is not None:
            if action.request == "take_off":
                check_take_off_height(action.height, standing, self.get("max_height"))
            live.request(ModeRequest[action.request.upper()], action.height)
        if action.velocity is not None or action.yaw_rate is not None:
            live.command = with_velocity_command(live.command, action.velocity, action.yaw_rate)
        if action.go_to is not None:
            if self.scenario.figure_eight:
                raise WorkbenchError(
                    "cannot go to a place while the scenario flies its figure of eight"
                )
            check_place(action.go_to, standing)
            live.command = with_position_command(live.command, action.go_to)
        if action.setpoint is not None:
            live.set_attitude(action.setpoint)
        if action.injection is not None:
            self._begin_injection(action.injection)
        if action.ends_script:
            self._script.end()

    act = do
    """The name of `do` in earlier versions."""

    def fly_controller(self, name_or_path: str | Path) -> None:
        """Let another controller take over in flight, as `begin_from` does; a reset keeps it.

        Recording and sensors continue, these with their faults and noise. No simulated time
        passes. `scenario` stays that of the present flight until a reset.

        Args:
            name_or_path: see `load_controller`; the file is read now.

        Raises:
            WorkbenchError: if it cannot be read or built, or cannot continue from here; the
                present controller then continues.
        """
        self.do(Action(controller=str(name_or_path)))

    def inject(self, injection: Injection) -> None:
        """Add a multisine to a signal of the law from the next control update on.

        It replaces an unfinished one; an injection without a point only ends that.
        """
        self.do(Action(injection=injection))

    @property
    def injecting(self) -> float | None:
        """The flown share of an injection, 0 .. 1; None without one."""
        return self._injecting.share if self._injecting else None

    @property
    def injected(self) -> InjectedSignal | None:
        """The last injection and its response, in whole periods; None without one."""
        return self._injecting.injected if self._injecting else None

    @property
    def flown_scenario(self) -> Scenario:
        """Return the present scenario with the flying controller and its gain file."""
        script = self._first.setup.scenario.script
        return dataclasses.replace(self._bench.setup.scenario, script=script)

    @property
    def script(self) -> Sequence[Action]:
        """Executed actions of the scenario's script, in order of time."""
        return self._script.actions_done

    @property
    def next_action(self) -> Action | None:
        """The next action of the scenario's script; None if it has no more, or was ended."""
        return self._script.next_action

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
    def program(self) -> LawProgram | None:
        """The running program that runs the law, if the law is a program."""
        return self._bench.computer.program

    @property
    def exchange(self) -> Mapping[str, float]:
        """The statistics of the exchange with that program, see `LawProgram.report`."""
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
            self._bench.computer.start_program(self._live.context_of(self._bench.computer))
        rates = self.scenario.rates
        self._due += duration
        target = rates.control_steps * math.floor(self._due / rates.control_period + 1e-6)
        while self._steps < target:
            for action in self._script.due(self._steps):
                if self._bridge and action.flies:
                    self._bridge.script_flies(self.time)
                with self._script.refusals(self.scenario.title):
                    if action.controller is not None:
                        self._take_over(action.controller)
                    self.do(dataclasses.replace(action, controller=None, end_script=False))
                self._script.note_mode(self.scenario.title, self.mode, self.waiting_request)
            step = int(min(target, self._script.next_step, self._inject()))
            self._live.integration.advance(step)
            self._steps = step
            self._script.ended |= self._bridge is not None and self._bridge.has_landed

    def run(self, progress: Callable[[float], None] | None = None) -> None:
        """Fly to the end of the scenario, calling `progress` with the flown share, 0 .. 1."""
        remaining = max(0.0, self.scenario.duration - self._due)
        slices = max(1, math.ceil(4.0 * remaining))
        for index in range(slices):
            self.tick(remaining / slices)
            if progress:
                progress((index + 1) / slices)

    def drain(self) -> "list[Sampled]":
        """Return what was published since the last call, at most the last 20 s."""
        return self._bridge.drain() if self._bridge else []

    def _begin_injection(self, injection: Injection) -> None:
        check_injection(injection, self.controller, self.scenario.rates)
        if self._injecting and not self._injecting.is_over:
            self._bench.computer.close_loops(self._live.context_of(self._bench.computer))
        self._injecting = None
        if injection.point:
            self._injecting = ActiveInjection.starting(
                injection, self.controller, self._live.next_update, self.scenario.rates
            )

    def _use(self, bench: Workbench) -> None:
        """Fly a newly built diagram from now on."""
        if bench is not self._bench:
            self.end_program()
        self._bench = bench
        self.controller: Controller = bench.setup.controller
        self._table = bench.setup.table

    def _begin(self, checkpoint: Checkpoint | None) -> None:
        """Begin at a checkpoint, or at the start without one."""
        if self._bridge:
            self._bridge.reset()
        if self._bridge and self._bench.telemetry:
            self._bench.telemetry.begin(start_position(self.scenario.start, self.vehicle))
        first = {} if checkpoint else self._script.first_values
        self._live = LiveContext(self._bench, checkpoint, first)
        self._injecting = None
        self._earlier = None
        self._steps, self._due = (checkpoint.steps, checkpoint.due) if checkpoint else (0, 0.0)
        acted, ended = (checkpoint.acted, checkpoint.script_ended) if checkpoint else (0, False)
        self._script.rewind(acted, ended=ended)
        self._update_limits()

    def _take_over(self, name_or_path: str) -> None:
        """Switch to another controller from now on."""
        law = with_estimator(load_controller(name_or_path), self.controller.estimator)
        law = with_servos_of(self.vehicle, law)
        if law is self.controller:
            return
        first, (gains, settings) = self._first.setup, self._given.gains_of(law)
        vehicle = dataclasses.replace(first.scenario.vehicle, gains=gains)
        scenario = dataclasses.replace(
            first.scenario, controller=name_or_path, script=[], vehicle=vehicle
        )
        setup = make_setup(
            scenario, settings, description=first.description, vehicle=first.vehicle, controller=law
        )
        log_setup(setup)
        bench = self._build(setup)
        with drake_error_sentences(f"the controller {law.name} cannot take over"):
            live = LiveContext(bench, self.checkpoint(), before=self._live)
        bench.computer.clear_ended(live.context_of(bench.computer))
        self._earlier = self._flown()
        self._injecting = None
        if bench.telemetry and self._bench.telemetry:
            bench.telemetry.continue_from(self._bench.telemetry)
        self._use(bench)
        self._live = live
        self._update_limits()

    def _update_limits(self) -> None:
        if self._bridge:
            self._bridge.parameters_changed(self.get)

    def _inject(self) -> int | float:
        """Add the injection's value that is due; return the next step with one."""
        injecting = self._injecting
        if injecting is None or injecting.is_over:
            return math.inf
        computer = self._bench.computer
        injecting.act(self._steps, computer, self._live.context_of(computer))
        return injecting.next_step
