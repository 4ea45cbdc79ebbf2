"""Compile the periods of a batch of flights."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from workbench.common.compiled import Compiled, compile_cached
from workbench.common.jitable import give_unique_name
from workbench.control.controller import Controller
from workbench.design.rollout.compiled_flights import BLOCK_COMPILE_OPTIONS, ENGINE_SOURCES
from workbench.design.rollout.flights import is_finite_flight
from workbench.design.rollout.gyro import TRUE_STATE
from workbench.design.rollout.lane_motion import write_lane_state
from workbench.design.rollout.lane_times import DelayRings, LaneTimes, PeriodClock
from workbench.design.rollout.lanes import LANES, LaneWorkspace
from workbench.design.rollout.law_update import (
    command_wrench,
    keep_commanded_speeds,
    make_law_update,
)
from workbench.design.rollout.period import make_fly_period


@lru_cache(maxsize=64)
def compiled_steps(controller: Controller | None, actions: str) -> Compiled:
    """Return the steps of a batch, compiled at their first call.

    Args:
        controller: whose law flies; None where none does.
        actions: that are asked for, see `batch.BATCH_ACTIONS`.
    """
    whose = f" with {controller.name}" if controller and not controller.shipped else ""
    key = controller.key if controller else actions
    return compile_cached(
        make_step_flights(controller, actions, key),
        ENGINE_SOURCES,
        f"batches of flights{whose}",
        parts=170,
        text=f"{actions} {controller.digest if controller else ''}",
        file=str(controller.file) if controller else "",
        **BLOCK_COMPILE_OPTIONS,
    )


def make_step_flights(controller: Controller | None, actions: str, key: str) -> Callable[..., None]:
    """Return a function that flies blocks of 16 flights for some control periods.

    Args:
        controller: whose law flies; None where none does.
        actions: that are asked for, see `batch.BATCH_ACTIONS`.
        key: see `give_unique_name`.
    """
    update = command_wrench if actions == "wrench" else keep_commanded_speeds
    if controller:
        update = make_law_update(controller)
    fly_period = make_fly_period(update, TRUE_STATE, f"batch_{key}")

    def step_flights(
        first: int,
        last: int,
        periods: int,
        flights: np.ndarray,
        rings: DelayRings,
        bodies: np.ndarray,
        rotors: np.ndarray,
        room: LaneWorkspace,
        times: LaneTimes,
        clock: PeriodClock,
    ) -> None:
        """Fly on, 16 flights at a time; this is what gets compiled.

        Args:
            first: number of the first block.
            last: number of the block after the last one.
            periods: number of control periods.
            flights: all records, see `record.flight_dtype`.
            rings: of all flights, see `DelayRings`.
            bodies: of all blocks, see `lanes.LANE_BODIES_DTYPE`.
            rotors: of all blocks (blocks, n), see `lanes.LANE_ROTORS_DTYPE`.
            room: places for the integrator; its bodies and rotors are not used.
            times: see `LaneTimes`.
            clock: see `PeriodClock`.
        """
        for number in range(first, last):
            block = slice(number * LANES, (number + 1) * LANES)
            some = flights[block]
            some_rings = DelayRings(rings.states[block], rings.commands[block])
            own = LaneWorkspace(  # the bodies stay from call to call
                bodies[number : number + 1],
                rotors[number],
                room.begun,
                room.moved,
                room.slopes,
                room.sizes,
            )
            # the user may have written states; lanes without a flight repeat the last one
            for i in range(LANES):
                flight = some[min(i, len(some) - 1)]
                write_lane_state(flight, own, i)
                if flight.lost_at < 0.0 and not is_finite_flight(flight):
                    flight.lost_at = flight.count
            for _ in range(periods):
                fly_period(some, some_rings, own, times, clock, None)

    return give_unique_name(step_flights, key)
