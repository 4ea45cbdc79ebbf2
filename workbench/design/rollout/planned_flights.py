"""Flights of many candidates on one schedule, flown in chunks by several threads."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from typing import NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.own_file import user_code_errors
from workbench.control.controller import Controller
from workbench.design.rollout.candidates import Candidates
from workbench.design.rollout.compiled_flights import compiled_fly
from workbench.design.rollout.flights import FlightSchedule, make_delay_rings
from workbench.design.rollout.lane_times import PeriodClock, make_lane_times
from workbench.design.rollout.lanes import LANES, make_lane_workspace
from workbench.design.rollout.sensor_set import SensorSet
from workbench.design.rollout.vehicle_batch import VehicleBatch
from workbench.design.step_response import check_duration
from workbench.scenario.scenario import Rates

MAX_PIECES_PER_CHUNK = 2
CHUNKS_PER_THREAD = 4
"""Pieces in a chunk at most, and chunks for each thread at least if there are pieces enough: a
few milliseconds each, so that progress is told and a stop is heard."""
ChunkWork = Callable[[int, int], None]
KeepSamples = Callable[[int, int, np.ndarray], None]
"""Takes samples (M, k, 16) of the candidates from a first up to before a last one; the array
belongs to it no longer than the call."""


def make_schedule(rates: Rates, edge_time: float, duration: float, stride: int) -> FlightSchedule:
    """Return when things happen; a command comes between physics steps, see `Session`.

    Args:
        rates: periods of physics and control.
        edge_time: when the command is given [s].
        duration: flown after it [s].
        stride: of the control periods that are kept.

    Raises:
        WorkbenchError: if that makes no flight.
    """
    check_duration(duration)
    if not (1 <= stride < math.inf and int(stride) == stride):
        raise WorkbenchError(f"the stride is {stride:g}: give it a whole number, 1 or more")
    step, steps = rates.physics_step, rates.control_steps
    edge = math.ceil(edge_time / step - 1e-6)
    return FlightSchedule(
        edge=-(-edge // steps),
        edge_time=edge_time,
        end=math.floor((edge_time + duration) / step + 1e-6) // steps,
        stride=int(stride),
    )


def run_chunks(
    work: ChunkWork,
    count: int,
    threads: int,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> int:
    """Do `work(first, last)` for pieces 0 .. count; return how many of them, from 0 on, are done.

    Threads help only with work that lets go of Python's lock, as compiled code may.

    Args:
        work: does the pieces from `first` up to before `last`.
        count: of pieces.
        threads: that work at a time, besides the caller's own, which waits; with 1 that works.
        progress: called with the share done, 0 .. 1, by the caller's thread.
        stop: asked after each chunk; chunks that have not begun are left when it says so.
    """
    size = max(1, min(MAX_PIECES_PER_CHUNK, -(-count // (CHUNKS_PER_THREAD * threads))))
    chunks = [(first, min(first + size, count)) for first in range(0, count, size)]

    def told(done: int) -> bool:
        if progress:
            progress(done / count)
        return bool(stop and stop())

    if threads == 1 or len(chunks) == 1:
        for first, last in chunks:
            work(first, last)
            if told(last):
                return last
        return count
    todo = deque(chunks)
    begun: deque[tuple[int, Future[None]]] = deque()
    done = 0
    with ThreadPoolExecutor(threads, thread_name_prefix="rollouts") as pool:
        while todo or begun:
            while todo and len(begun) <= threads:  # one waits, so that no thread does
                first, last = todo.popleft()
                begun.append((last, pool.submit(work, first, last)))
            done, chunk = begun.popleft()
            chunk.result()
            if told(done):
                todo.clear()
    return done


class PlannedFlights(NamedTuple):
    """N candidates that fly on the same schedule.

    Attributes:
        controller: whose law flies.
        candidates: N of them.
        flights: (N) their records, see `record.flight_dtype`.
        vehicles: what flies, K.
        which: (N) the vehicle of each candidate.
        clock: when things happen.
        schedule: of all.
        senses: what tells the laws the motion; None on the truth.
    """

    controller: Controller
    candidates: Candidates
    flights: np.ndarray
    vehicles: VehicleBatch
    which: np.ndarray
    clock: PeriodClock
    schedule: FlightSchedule
    senses: SensorSet | None = None

    @property
    def size(self) -> int:
        """How many candidates there are."""
        return len(self.which)

    @property
    def time(self) -> np.ndarray:
        """Time of the samples (M) from the edge on [s]."""
        when = self.schedule
        instants = np.arange(when.edge, when.end + 1, when.stride)
        return instants * self.clock.period - when.edge_time

    def again(
        self,
        places: np.ndarray,
        before: Sequence[float],
        commands: Sequence[float],
        schedule: FlightSchedule,
    ) -> "PlannedFlights":
        """Return flights of some candidates with other commands.

        Args:
            places: (K) of the candidates.
            before: velocity in W and yaw rate (4) that all are commanded before the edge.
            commands: and from the edge on (4).
            schedule: of all.
        """
        flights = self.flights[places].copy()
        flights["reference"][:, :4], flights["following"][:, :4] = before, commands
        return self._replace(
            candidates=Candidates(*(column[places] for column in self.candidates)),
            flights=flights,
            which=self.which[places],
            schedule=schedule,
        )

    def fly(
        self,
        kept: tuple[int, ...],
        keep: KeepSamples,
        threads: int,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Fly them.

        Args:
            kept: which k of the state's numbers to sample.
            keep: called with the samples of each block, by several threads.
            threads: that fly at a time.
            progress: called with the flown share, 0 .. 1.
            stop: asked every few blocks; when it returns true, no more are flown.

        Returns:
            Of those that were flown, the first of all: the largest share of its speed limit at
            which any rotor ran, and when it was lost, from the edge on [s], NaN if it was not.
        """
        fly = compiled_fly(self.controller, self.senses and self.senses.estimator)
        sensors = self.senses and self.senses.inputs
        file = self.senses and self.senses.estimator.file
        shape, rotors = (len(self.time), len(kept), LANES), self.vehicles.rotors.shape[1]
        peak_use, lost_at = np.zeros(self.size), np.full(self.size, -1.0)

        def work(first_block: int, last_block: int) -> None:
            samples, room, times = np.empty(shape), make_lane_workspace(rotors), make_lane_times()
            for first in range(first_block * LANES, last_block * LANES, LANES):
                last = min(first + LANES, self.size)
                vehicles = self.vehicles.chosen(self.which[first:last])
                vehicles.furnish(room)
                flights = self.flights[first:last].copy()  # they may be flown again
                with user_code_errors(file, "update") if file else nullcontext():
                    fly(
                        flights,
                        make_delay_rings(vehicles),
                        room,
                        times,
                        self.clock,
                        sensors,
                        self.schedule,
                        np.array(kept),
                        samples,
                    )
                peak_use[first:last], lost_at[first:last] = flights["peak_use"], flights["lost_at"]
                keep(first, last, samples)

        blocks = run_chunks(work, -(-self.size // LANES), threads, progress, stop)
        done = min(blocks * LANES, self.size)
        after = np.maximum(0.0, lost_at * self.clock.period - self.schedule.edge_time)
        lost = np.where(lost_at < 0.0, np.nan, after)
        return peak_use[:done], lost[:done]

    def curves(
        self,
        kept: tuple[int, ...],
        threads: int,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Fly them and keep every sample; the arguments are those of `fly`.

        Returns:
            The samples (done, M, k) of those that were flown, and what `fly` returns.
        """
        found = np.full((self.size, len(self.time), len(kept)), np.nan)

        def keep(first: int, last: int, samples: np.ndarray) -> None:
            found[first:last] = samples[:, :, : last - first].transpose(2, 0, 1)

        peak_use, lost_at = self.fly(kept, keep, threads, progress, stop)
        return found[: len(peak_use)], peak_use, lost_at
