"""Many compiled flights that go on together, step by step.

What the user of a batch reads and writes are views of the flights' records.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.own_file import user_code_errors
from workbench.control.installed_laws import DEFAULT_CONTROLLER
from workbench.design.executor.executor import available_cores
from workbench.design.rollout.batch_arrays import (
    BatchArrays,
    Columns,
    FlightSelection,
    checked_whole_number,
    frozen_values,
    parameter_columns,
    selected_flights,
    setpoint_views,
)
from workbench.design.rollout.batch_steps import compiled_steps
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.flights import begin_flights, make_delay_rings
from workbench.design.rollout.lane_times import make_lane_times
from workbench.design.rollout.lanes import (
    LANE_BODIES_DTYPE,
    LANE_ROTORS_DTYPE,
    LANES,
    aligned_zeros,
    make_lane_workspace,
)
from workbench.design.rollout.planned_flights import make_schedule
from workbench.dynamics.air.settings import AirSettings, gust_settings, push_settings
from workbench.parameters.flight_parameters import MAX_WEAKENED_ROTORS
from workbench.parameters.parameter_table import flight_table
from workbench.plant.gravity import GRAVITY
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates, Scenario, ScenarioStart, VehicleConfig
from workbench.session.action_check import finite_floats
from workbench.session.live_context import start_position
from workbench.setup import make_setup
from workbench.systems.noise import noise_seed

BATCH_ACTIONS = ("setpoint", "wrench", "rotors")
"""What the user of a batch may ask for."""
MAX_BATCH_FLIGHTS = 1_000_000
BLOCK_PERIODS_PER_CALL = 50_000
"""Control periods of blocks in a call, so that it lasts no longer than some tenths of a second."""


class Batch(BatchArrays):
    """Flies n vehicles of one description together, each as a `Session` would fly it alone.

    These are the compiled flights of `RolloutEngine`, continued from call to call: the same law,
    vehicle, air and flight mode in the air. Each flight has its own time, seed, gains, air and
    faults, and its numbers do not depend on the other flights.

    There is no ground, obstacle, sensor, take-off or landing. A flight is lost, and stands still
    until a reset, when it reaches the height of the ground, when a number is not finite, and when
    it is tilted over 90 degrees and then turns faster than 10 rad/s or moves faster than 20 m/s. A
    battery of the description is full at the start and weakens the rotors; without one, the charge
    stays full.

    Attributes:
        vehicle: the vehicle as the law knows it.
        controller: whose law flies; None without a law.
        rates: periods of physics, control and flight mode.
        state: (n, 13) q_WB (w, x, y, z), p_WB [m], w_WB [rad/s] and v_WB [m/s] of the base link in
            W. It may be written, and so may the views of it: `attitude` (n, 4), `position`,
            `angular_velocity` and `velocity` (n, 3).
        rotor_speeds: (n, rotors) [rad/s]; they may be written.
        setpoint: commands to the laws, all zero at a reset; None without a law.
        wrench: (n, 4) commanded force along z [N] and moment [N·m] about the centre of mass, in
            the frame of upright hover; that of hover at a reset. None unless `actions` is
            "wrench".
        rotor_commands: (n, rotors) commanded rotor speeds [rad/s], those of hover at a reset.
            None unless `actions` is "rotors".
        parameters: (n) each, by the names of `workbench params`: gains of the law, air with its
            wind, gusts and pushes, and the shares of their thrust that rotors give. They stay at
            a reset, and may exceed their limits. Times of gusts and pushes are those of each
            flight, see `time`.
        starts: (n, 13) states at which flights begin at a reset, as `state`.

    Args:
        count: n, of flights.
        model: a shipped model's name, the path of a description, or a `VehicleConfig`.
        controller: a shipped law's name or the path of a file.
        gains: path of a gain file; without one here or with the model they follow from the vehicle.
        parameters: live values by name, a number for all flights or n of them. Those that are not
            in the attribute of that name, such as payload and filters, cannot change later.
        actions: "setpoint" for flights with the law; "wrench" or "rotors" for those without.
        seed: of the turbulence; flight k has that of a scenario with the seed `seed` + k.
        start: where flights begin, hovering; 1.5 m high if it has no position.
        rates: periods; by default the law's own, or those of a default scenario.
        variations: how the simulated vehicles differ from what the law knows, one for all flights
            or one for each (n); by default those of the model.
        threads: number of threads; by default that of the cores.

    Raises:
        WorkbenchError: if an argument is not valid, or a flight is not possible.
    """

    def __init__(
        self,
        count: int,
        model: str | VehicleConfig = "dh_drone",
        controller: str = DEFAULT_CONTROLLER,
        *,
        gains: str = "",
        parameters: Mapping[str, float | Sequence[float] | np.ndarray] | None = None,
        actions: str = "setpoint",
        seed: int = 0,
        start: ScenarioStart | None = None,
        rates: Rates | None = None,
        variations: Variation | Sequence[Variation] | None = None,
        threads: int | None = None,
    ) -> None:
        count = checked_whole_number("count", count, 1, MAX_BATCH_FLIGHTS)
        seed = checked_whole_number("seed", seed, 0, 2**62)
        if actions not in BATCH_ACTIONS:
            raise unknown_name("kind of action", actions, BATCH_ACTIONS)
        config = VehicleConfig(model) if isinstance(model, str) else model
        config = dataclasses.replace(config, gains=gains or config.gains)
        scenario = Scenario(vehicle=config, controller=controller, start=start or ScenarioStart())
        if rates:
            scenario.rates = rates
        setup = make_setup(scenario)
        if scenario.start.mode != "hovering":
            raise WorkbenchError("a batch flies in the air alone: let its start be hovering")
        self.rates = setup.rates
        if not (self.rates.mode_period / self.rates.control_period).is_integer():
            raise WorkbenchError(
                f"the flight mode every {self.rates.mode_period:g} s is not flown in a batch with "
                f"a law every {self.rates.control_period:g} s: make it a multiple of that"
            )
        self.controller = setup.controller if actions == "setpoint" else None
        self.vehicle: Vehicle = setup.vehicle
        cores = available_cores()
        self._threads = checked_whole_number(
            "threads", cores if threads is None else threads, 1, 256
        )
        self._pool: ThreadPoolExecutor | None = None
        one = config.variation if variations is None else variations
        several = None if isinstance(one, Variation) else list(one)
        engine = RolloutEngine.of(setup.varied(one if isinstance(one, Variation) else Variation()))
        begin = scenario.start
        place = start_position(begin, self.vehicle)
        planned = engine.plan(
            parameter_columns(parameters or {}, count),
            np.zeros(4),
            start_state(self.vehicle, dataclasses.replace(begin, position=place)),
            make_schedule(self.rates, 0.0, 1.0, 1),
            several,
            range(seed, seed + count),
        )
        self._engine, self._payloads = engine, planned.candidates.payloads
        self._flights = planned.flights
        self._vehicles = planned.vehicles.chosen(planned.which)
        self._rings = make_delay_rings(self._vehicles)
        rotors, blocks = len(self.vehicle.rotors), -(-count // LANES)
        self._bodies = aligned_zeros((blocks,), LANE_BODIES_DTYPE)
        self._rotors = aligned_zeros((blocks, rotors), LANE_ROTORS_DTYPE)
        for number in range(blocks):
            some = slice(number * LANES, (number + 1) * LANES)
            room = make_lane_workspace(rotors)
            self._vehicles.chosen(some).furnish(room)
            self._bodies[number], self._rotors[number] = room.bodies[0], room.rotors
        self._steps = compiled_steps(self.controller, actions)
        self._gains = self._flights["gains"]
        self._designed = self._own_gains()
        self.state, self.rotor_speeds = self._flights["state"], self._flights["speeds"]
        self.starts = planned.candidates.starts
        self.parameters = self._by_name()
        asks = {name: name == actions for name in BATCH_ACTIONS}
        self.setpoint = setpoint_views(self._flights["reference"]) if asks["setpoint"] else None
        self.wrench = self._flights["wrench"] if asks["wrench"] else None
        self.rotor_commands = self._flights["commands"] if asks["rotors"] else None
        self.reset()

    def __repr__(self) -> str:
        law = self.controller.name if self.controller else "no law"
        return f"<Batch of {len(self)} {self.vehicle.name} with {law}, {int(self.lost.sum())} lost>"

    def __len__(self) -> int:
        return len(self.state)

    @property
    def attitude(self) -> np.ndarray:
        """Orientation q_WB (n, 4): w, x, y, z; a view of `state`."""
        return self.state[:, 0:4]

    @property
    def position(self) -> np.ndarray:
        """Place p_WB (n, 3) [m]; a view of `state`."""
        return self.state[:, 4:7]

    @property
    def angular_velocity(self) -> np.ndarray:
        """Angular velocity w_WB in W (n, 3) [rad/s]; a view of `state`."""
        return self.state[:, 7:10]

    @property
    def velocity(self) -> np.ndarray:
        """Velocity v_WB in W (n, 3) [m/s]; a view of `state`."""
        return self.state[:, 10:13]

    @property
    def time(self) -> np.ndarray:
        """Time since each flight began (n) [s]."""
        return frozen_values(self._flights["count"] * self.rates.control_period)

    @property
    def lost(self) -> np.ndarray:
        """Whether each flight is lost (n), as it was when it was."""
        return frozen_values(self._flights["lost_at"] >= 0.0)

    @property
    def mode(self) -> np.ndarray:
        """Flight mode of each (n), see `control.mode.FlightMode`: one of those that fly."""
        return frozen_values(self._flights["mode"].astype(int))

    def step(self, periods: int = 1) -> None:
        """Fly all on for some control periods.

        Raises:
            WorkbenchError: if that is not a number of periods, or the law cannot be compiled, or
                design with the gains that are there.
        """
        left = checked_whole_number("periods", periods, 0, 2**31)
        self._design()
        blocks = len(self._bodies)
        most = max(1, BLOCK_PERIODS_PER_CALL // blocks)
        file = self.controller.file if self.controller else None
        while left:
            part = min(left, most)
            with user_code_errors(file, "update") if file else nullcontext():
                self._fly(blocks, part)
            left -= part

    def reset(self, which: FlightSelection = None, *, seeds: Sequence[int] | None = None) -> None:
        """Start flights again at their `starts`; the others go on unchanged.

        Args:
            which: of them, a mask (n) or numbers; all without.
            seeds: of their turbulence from now on, one for each that begins, as in a scenario;
                those that they had without.

        Raises:
            WorkbenchError: if a number is not a flight's, or the seeds are more or fewer.
        """
        chosen = selected_flights(which, len(self))
        if seeds is not None:
            given = np.atleast_1d(seeds).tolist()
            if len(given) != len(chosen):
                raise WorkbenchError(
                    f"there are {len(given)} seeds for {len(chosen)} flights: give each one"
                )
            self._flights["air_seed"][chosen] = [
                float(noise_seed(checked_whole_number("seed", seed, 0, 2**62), "air"))
                for seed in given
            ]
        if self.wrench is not None:
            self.wrench[chosen] = 0.0
            self.wrench[chosen, 0] = GRAVITY * self._flights["law"]["mass"][chosen]
        self._design()
        some = self._flights[chosen]
        some["reference"] = 0.0
        memory = self.controller.initial_memory if self.controller else []
        begin_flights(some, self.starts[chosen], self._vehicles.speeds[chosen], memory)
        self._flights[chosen] = some
        self._rings.states[chosen] = some["state"][:, None]
        self._rings.commands[chosen] = some["commands"][:, None]

    def push(
        self,
        which: FlightSelection = None,
        *,
        force: Sequence[float] = (0.0, 0.0, 0.0),
        point: Sequence[float] = (0.0, 0.0, 0.0),
        duration: float = 0.1,
        torque: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> None:
        """Push flights from now on, as `Session.push` does.

        Args:
            which: of them, a mask (n) or numbers; all without.
            force: in W [N].
            point: of the body at which it acts, in B [m].
            duration: [s].
            torque: in B [N·m].

        Raises:
            WorkbenchError: if a number is out of the range of its parameter.
        """
        force, point = finite_floats("push", force, 3), finite_floats("point of the push", point, 3)
        torque = finite_floats("torque of the push", torque, 3)
        self._blow(which, push_settings(force, point, 0.0, duration, torque), "push_start")

    def gust(
        self, which: FlightSelection = None, *, velocity: Sequence[float], duration: float = 1.0
    ) -> None:
        """Let a gust rise and fall from now on, as `Session.gust` does.

        Args:
            which: of the flights, a mask (n) or numbers; all without.
            velocity: in W, at its peak [m/s].
            duration: [s].

        Raises:
            WorkbenchError: if a number is out of the range of its parameter.
        """
        velocity = finite_floats("gust", velocity, 3)
        self._blow(which, gust_settings(velocity, 0.0, duration), "gust_start")

    def _blow(self, which: FlightSelection, settings: Mapping[str, float], start: str) -> None:
        """Give flights settings of the air, one of which is the time now."""
        chosen = selected_flights(which, len(self))
        now = self.time[chosen]
        for name, value in flight_table().checked(settings).items():
            self.parameters[name][chosen] = now if name == start else value

    def _fly(self, blocks: int, periods: int) -> None:
        """Fly all blocks on for some control periods."""

        def work(first: int, last: int) -> None:
            self._steps(
                first,
                last,
                periods,
                self._flights,
                self._rings,
                self._bodies,
                self._rotors,
                make_lane_workspace(len(self.vehicle.rotors)),
                make_lane_times(),
                self._engine.clock,
            )

        threads = min(self._threads, blocks)
        if threads == 1 or not self._steps.signatures:  # what is not compiled yet is so once
            work(0, blocks)
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._threads - 1, thread_name_prefix="batch")
        ends = [blocks * k // threads for k in range(threads + 1)]
        begun = [self._pool.submit(work, a, b) for a, b in zip(ends[1:-1], ends[2:], strict=True)]
        work(0, ends[1])
        for each in begun:
            each.result()

    def _own_gains(self) -> np.ndarray:
        """Return a copy of what the controller designs by (n, p); none where it does not."""
        if self.controller is None or not self.controller.designed:
            return np.zeros((0, 0))
        return self._gains[:, : len(self.controller.parameters)].copy()

    def _design(self) -> None:
        """Let the controller design again for flights whose gains have changed."""
        if not self._designed.size:
            return
        many = self._designed.shape[1]
        own = self._gains[:, :many]
        changed = np.flatnonzero((own != self._designed).any(axis=1))
        if len(changed):
            payloads = self._payloads[changed]
            self._gains[changed, many:] = self._engine.design(own[changed], payloads)
            self._designed = own.copy()

    def _by_name(self) -> Columns:
        """Return the live columns by their parameters' names."""
        flights = self._flights
        names = [row.name for row in self.controller.parameters] if self.controller else []
        weak = min(flights["shares"].shape[1], MAX_WEAKENED_ROTORS)
        return Columns(
            {name: self._gains[:, place] for place, name in enumerate(names)}
            | {name: flights["air"][name] for name in AirSettings._fields}
            | {f"rotor_{k + 1}": flights["shares"][:, k] for k in range(weak)}
        )
