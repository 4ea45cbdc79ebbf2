"""Many compiled flights that go on together, step by step.

What the user of a batch reads and writes are views of the flights' records.
"""

import dataclasses
import operator
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.common.compiled import Compiled, compile_cached
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.jitable import unique
from workbench.common.own_file import own_errors
from workbench.control.controller import DEFAULT, Controller
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.engine import OPTIONS, SOURCES, RolloutEngine, make_schedule
from workbench.design.rollout.flights import begin, is_whole, make_rings
from workbench.design.rollout.gyro import KNOW_TRUTH
from workbench.design.rollout.motion import BODIES, LANES, ROTORS, Room, make_room
from workbench.design.rollout.period import (
    Rings,
    give_speeds,
    give_wrench,
    make_fly_period,
    make_times,
    make_update,
    write_flight,
)
from workbench.dynamics.air.settings import AirSettings, gust_settings, push_settings
from workbench.gains.gains import flight_gains
from workbench.plant.gravity import GRAVITY
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.parameters import MOST_ROTORS, parameter_table
from workbench.scenario.scenario import (
    Rates,
    Scenario,
    Start,
    VehicleConfig,
    at_own_period,
    check_scenario,
    flown_controller,
)
from workbench.session.live_context import start_position
from workbench.session.pilot_numbers import finite
from workbench.systems.noise import noise_seed

ACTIONS = ("setpoint", "wrench", "rotors")
"""What the user of a batch may ask for."""
MOST_FLIGHTS = 1_000_000
CHUNK = 50_000
"""Control periods of blocks in a call, so that it lasts no longer than some tenths of a second."""
Which = np.ndarray | Sequence[bool] | Sequence[int] | slice | int | None
"""Flights, by a mask or by their numbers; None for all."""


@lru_cache(maxsize=64)
def compiled_steps(controller: Controller | None, actions: str) -> Compiled:
    """Return the steps of a batch, compiled at their first call.

    Args:
        controller: whose law flies; None where none does.
        actions: that are asked for, see `batch.ACTIONS`.
    """
    whose = f" with {controller.name}" if controller and not controller.shipped else ""
    key = controller.key if controller else actions
    return compile_cached(
        make_step_flights(controller, actions, key),
        SOURCES,
        f"batches of flights{whose}",
        parts=170,
        text=f"{actions} {controller.digest if controller else ''}",
        file=str(controller.file) if controller else "",
        **OPTIONS,
    )


def make_step_flights(controller: Controller | None, actions: str, key: str) -> Callable[..., None]:
    """Return a function that flies blocks of 16 flights for some control periods.

    Args:
        controller: whose law flies; None where none does.
        actions: that are asked for, see `batch.ACTIONS`.
        key: see `jitable.unique`.
    """
    update = give_wrench if actions == "wrench" else give_speeds
    if controller:
        update = make_update(controller)
    fly_period = make_fly_period(update, KNOW_TRUTH, f"batch_{key}")

    def step_flights(first, last, periods, flights, rings, bodies, rotors, room, times, clock):
        """Fly on, 16 flights at a time; this is what gets compiled.

        Args:
            first: number of the first block.
            last: number of the block after the last one.
            periods: number of control periods.
            flights: all records, see `record.flight_dtype`.
            rings: of all flights, see `Rings`.
            bodies: of all blocks, see `motion.BODIES`.
            rotors: of all blocks (blocks, n), see `motion.ROTORS`.
            room: places for the integrator; its bodies and rotors are not used.
            times: see `period.Times`.
            clock: see `period.Clock`.
        """
        for number in range(first, last):
            since, to = number * LANES, (number + 1) * LANES
            some, late = flights[since:to], Rings(rings.seen[since:to], rings.asked[since:to])
            own = Room(
                bodies[number : number + 1],
                rotors[number],
                room.begun,
                room.moved,
                room.slopes,
                room.sizes,
            )
            for i in range(LANES):  # what the user may have written since the last call
                flight = some[min(i, len(some) - 1)]
                write_flight(flight, own, i)
                if flight.lost_at < 0.0 and not is_whole(flight):
                    flight.lost_at = flight.count
            for _ in range(periods):
                fly_period(some, late, own, times, clock, None)

    return unique(step_flights, key)


def shown(values: Any) -> str:
    """Return how values from outside begin, on a line."""
    return " ".join(f"{values!r}".split())[:60]


def write(name: str, array: np.ndarray, values: Any) -> None:
    """Write values into an array, a number for all or an array of its shape.

    Args:
        name: of the array, for the message.
        array: that is written.
        values: from outside, so they may be anything.

    Raises:
        WorkbenchError: if they do not fit.
    """
    try:
        array[...] = values
    except (TypeError, ValueError):
        raise WorkbenchError(
            f"{name} of a batch is {shown(values)}: give a number, or an array {array.shape} of "
            "them"
        ) from None


class Columns(Mapping[str, np.ndarray]):
    """Arrays (n) by name; to set one, as `columns[name] = 3.0`, writes into the array."""

    def __init__(self, columns: Mapping[str, np.ndarray]) -> None:
        self._columns = dict(columns)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._columns:
            raise unknown_name("parameter of a batch", name, self._columns)
        return self._columns[name]

    def __setitem__(self, name: str, values: Any) -> None:
        write(name, self[name], values)

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)


class _Arrays:
    """Has arrays: to set one that is there writes into it, and no other one takes its place."""

    def __setattr__(self, name: str, value: Any) -> None:
        there = getattr(self, name, None)
        if name.startswith("_") or there is None:
            super().__setattr__(name, value)
        elif isinstance(there, np.ndarray) and there.flags.writeable:
            write(name, there, value)
        elif there is not value:
            raise WorkbenchError(
                f"{name} of a batch cannot be set: write its state, setpoint, parameters or starts"
            )


@dataclasses.dataclass(eq=False)
class Setpoint(_Arrays):
    """What is asked of n flights, in W.

    Attributes:
        velocity: (n, 3) [m/s].
        yaw_rate: (n) [rad/s].
        position: (n, 3) a point to go to [m], where `follow` is 1.
        follow: (n) whether it is gone to, 0 or 1; the velocity is added to what leads there.
    """

    velocity: np.ndarray
    yaw_rate: np.ndarray
    position: np.ndarray
    follow: np.ndarray


class Batch(_Arrays):
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
        controller: str = DEFAULT,
        *,
        gains: str = "",
        parameters: Mapping[str, float | Sequence[float] | np.ndarray] | None = None,
        actions: str = "setpoint",
        seed: int = 0,
        start: Start | None = None,
        rates: Rates | None = None,
        variations: Variation | Sequence[Variation] | None = None,
        threads: int | None = None,
    ) -> None:
        count = _whole("count", count, 1, MOST_FLIGHTS)
        seed = _whole("seed", seed, 0, 2**62)
        if actions not in ACTIONS:
            raise unknown_name("kind of action", actions, ACTIONS)
        config = VehicleConfig(model) if isinstance(model, str) else model
        scenario = Scenario(vehicle=config, controller=controller, start=start or Start())
        if rates:
            scenario.rates = rates
        scenario = at_own_period(scenario)
        check_scenario(scenario)
        if scenario.start.mode != "hovering":
            raise WorkbenchError("a batch flies in the air alone: let its start be hovering")
        self.rates = scenario.rates
        if not (self.rates.mode_period / self.rates.control_period).is_integer():
            raise WorkbenchError(
                f"the flight mode every {self.rates.mode_period:g} s is not flown in a batch with "
                f"a law every {self.rates.control_period:g} s: make it a multiple of that"
            )
        law = flown_controller(scenario)
        self.controller = law if actions == "setpoint" else None
        self.vehicle: Vehicle = configured_vehicle(config)
        cores = len(os.sched_getaffinity(0))
        self._threads = _whole("threads", cores if threads is None else threads, 1, 256)
        self._pool: ThreadPoolExecutor | None = None
        one = config.variation if variations is None else variations
        several = None if isinstance(one, Variation) else list(one)
        engine = RolloutEngine(
            self.vehicle,
            self.rates,
            one if isinstance(one, Variation) else None,
            own=flight_gains(self.vehicle, gains or config.gains, controller=law),
            controller=law,
        )
        begin = scenario.start
        place = start_position(begin, self.vehicle)
        planned = engine.plan(
            _columns(parameters or {}, count),
            np.zeros(4),
            start_state(self.vehicle, dataclasses.replace(begin, position=place)),
            make_schedule(self.rates, 0.0, 1.0, 1),
            several,
            range(seed, seed + count),
        )
        self._engine, self._payloads = engine, planned.candidates.payloads
        self._flights = planned.flights
        self._crafts = planned.crafts.chosen(planned.which)
        self._rings = make_rings(self._crafts)
        rotors, blocks = len(self.vehicle.rotors), -(-count // LANES)
        self._bodies, self._rotors = np.zeros(blocks, BODIES), np.zeros((blocks, rotors), ROTORS)
        for number in range(blocks):
            some = slice(number * LANES, (number + 1) * LANES)
            room = make_room(rotors)
            self._crafts.chosen(some).furnish(room)
            self._bodies[number], self._rotors[number] = room.bodies[0], room.rotors
        self._steps = compiled_steps(self.controller, actions)
        self._gains = self._flights["gains"]
        self._designed = self._own_gains()
        self.state, self.rotor_speeds = self._flights["state"], self._flights["speeds"]
        self.starts = planned.candidates.starts
        self.parameters = self._by_name()
        asks = {name: name == actions for name in ACTIONS}
        self.setpoint = _steered(self._flights["reference"]) if asks["setpoint"] else None
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
        return _told(self._flights["count"] * self.rates.control_period)

    @property
    def lost(self) -> np.ndarray:
        """Whether each flight is lost (n), as it was when it was."""
        return _told(self._flights["lost_at"] >= 0.0)

    @property
    def mode(self) -> np.ndarray:
        """Flight mode of each (n), see `control.mode.FlightMode`: one of those that fly."""
        return _told(self._flights["mode"].astype(int))

    def step(self, periods: int = 1) -> None:
        """Fly all on for some control periods.

        Raises:
            WorkbenchError: if that is not a number of periods, or the law cannot be compiled, or
                design with the gains that are there.
        """
        left = _whole("periods", periods, 0, 2**31)
        self._design()
        blocks = len(self._bodies)
        most = max(1, CHUNK // blocks)
        file = self.controller.file if self.controller else None
        while left:
            part = min(left, most)
            with own_errors(file, "update") if file else nullcontext():
                self._fly(blocks, part)
            left -= part

    def reset(self, which: Which = None, *, seeds: Sequence[int] | None = None) -> None:
        """Start flights again at their `starts`; the others go on unchanged.

        Args:
            which: of them, a mask (n) or numbers; all without.
            seeds: of their turbulence from now on, one for each that begins, as in a scenario;
                those that they had without.

        Raises:
            WorkbenchError: if a number is not a flight's, or the seeds are more or fewer.
        """
        chosen = self._chosen(which)
        if seeds is not None:
            given = np.atleast_1d(seeds).tolist()
            if len(given) != len(chosen):
                raise WorkbenchError(
                    f"there are {len(given)} seeds for {len(chosen)} flights: give each one"
                )
            self._flights["air_seed"][chosen] = [
                float(noise_seed(_whole("seed", seed, 0, 2**62), "air")) for seed in given
            ]
        if self.wrench is not None:
            self.wrench[chosen] = 0.0
            self.wrench[chosen, 0] = GRAVITY * self._flights["law"]["mass"][chosen]
        self._design()
        some = self._flights[chosen]
        some["reference"] = 0.0
        memory = self.controller.initial_memory if self.controller else []
        begin(some, self.starts[chosen], self._crafts.speeds[chosen], memory)
        self._flights[chosen] = some
        self._rings.seen[chosen] = some["state"][:, None]
        self._rings.asked[chosen] = some["commands"][:, None]

    def push(
        self,
        which: Which = None,
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
        force, point = finite("push", force, 3), finite("point of the push", point, 3)
        torque = finite("torque of the push", torque, 3)
        self._blow(which, push_settings(force, point, 0.0, duration, torque), "push_start")

    def gust(
        self, which: Which = None, *, velocity: Sequence[float], duration: float = 1.0
    ) -> None:
        """Let a gust rise and fall from now on, as `Session.gust` does.

        Args:
            which: of the flights, a mask (n) or numbers; all without.
            velocity: in W, at its peak [m/s].
            duration: [s].

        Raises:
            WorkbenchError: if a number is out of the range of its parameter.
        """
        velocity = finite("gust", velocity, 3)
        self._blow(which, gust_settings(velocity, 0.0, duration), "gust_start")

    def _blow(self, which: Which, settings: Mapping[str, float], start: str) -> None:
        """Give flights settings of the air, one of which is the time now."""
        chosen = self._chosen(which)
        now = self.time[chosen]
        for name, value in parameter_table(self.controller).checked(settings).items():
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
                make_room(len(self.vehicle.rotors)),
                make_times(),
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

    def _chosen(self, which: Which) -> np.ndarray:
        """Return the numbers of flights (k)."""
        numbers = np.arange(len(self))
        if which is None:
            return numbers
        try:
            return np.atleast_1d(numbers[which])
        except (IndexError, TypeError, ValueError):
            raise WorkbenchError(
                f"no flights of a batch of {len(self)} are {shown(which)}: give a mask of as many, "
                f"or numbers from 0 to {len(self) - 1}"
            ) from None

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
        weak = min(flights["shares"].shape[1], MOST_ROTORS)
        return Columns(
            {name: self._gains[:, place] for place, name in enumerate(names)}
            | {name: flights["air"][name] for name in AirSettings._fields}
            | {f"rotor_{k + 1}": flights["shares"][:, k] for k in range(weak)}
        )


def _told(values: np.ndarray) -> np.ndarray:
    """Return values that nobody writes, as no flight would know of it."""
    values.setflags(write=False)
    return values


def _whole(name: str, number: Any, least: int, most: int) -> int:
    """Return a whole number within limits.

    Raises:
        WorkbenchError: if it is not one.
    """
    try:
        found = operator.index(number)
    except TypeError:
        found = least - 1
    if not least <= found <= most:
        raise WorkbenchError(
            f"the {name} of a batch is {number!r:.60}: give a whole number from {least} to {most}"
        )
    return found


def _columns(parameters: Mapping[str, Any], count: int) -> list[dict[str, float]]:
    """Return values by name of each flight."""
    if not isinstance(parameters, Mapping):
        raise WorkbenchError(
            f"the parameters of a batch are {parameters!r:.60}: give values by name, as "
            "{'wind_x': 3.0}"
        )
    columns = {}
    for name, values in parameters.items():
        try:
            column = np.broadcast_to(np.asarray(values, dtype=float), count)
        except (TypeError, ValueError):
            column = np.full(count, np.nan)
        if not np.isfinite(column).all():
            raise WorkbenchError(
                f"{name} of a batch is {shown(values)}: give a finite number, or {count} of them"
            )
        columns[name] = column.tolist()
    return [{name: column[k] for name, column in columns.items()} for k in range(count)]


def _steered(references: np.ndarray) -> Setpoint:
    """Return the views of references (n, 8), see `guidance.Reference`."""
    return Setpoint(references[:, 0:3], references[:, 3], references[:, 4:7], references[:, 7])
