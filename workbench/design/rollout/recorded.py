"""One compiled flight along a script, with all that a recording has of it.

At a control instant the recorder sees what the diagram's sees: all that holds until then. Only the
estimate is that of the update of then.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from workbench.common.compiled import Compiled
from workbench.common.jitable import give_unique_name, register_jitable
from workbench.control.controller import Controller
from workbench.design.rollout.compiled_flights import compiled_flights
from workbench.design.rollout.estimate import estimator_source
from workbench.design.rollout.fields import get_lane, packed_dtype, set_field
from workbench.design.rollout.flights import write_flights
from workbench.design.rollout.gyro import TRUE_STATE
from workbench.design.rollout.lane_times import DelayRings, LaneTimes, PeriodClock
from workbench.design.rollout.lanes import LaneWorkspace
from workbench.design.rollout.law_update import make_law_update
from workbench.design.rollout.motion import derive_lanes, lane_acceleration, rotor_constants_of
from workbench.design.rollout.period import StateSource, make_fly_period
from workbench.design.rollout.sensor_set import EstimatorInputs
from workbench.dynamics.rotors import hub_velocity, moving_thrust
from workbench.estimation.estimators import Estimator

COPIED_FIELDS = ("state", "speeds", "wind", "commands", "reference")
"""Fields of a flight that are copied, as they are before the updates of an instant; and so its
`mode` and `charge`."""
ESTIMATE_FIELDS = ("estimate", "estimator")
"""Fields that are copied as they are after the estimator's update."""


def sample_dtype(flight: np.dtype) -> np.dtype:
    """Return the type of a sample of a flight, of the type of its record.

    It has fields of that record, and

        acceleration    (6) angular, and of the origin, in W [rad/s², m/s²]
        thrusts         (n) of the rotors [N]
    """
    names = [name for name in (*COPIED_FIELDS, *ESTIMATE_FIELDS) if name in (flight.names or ())]
    shapes = {name: flight[name].shape for name in names}
    own = {"acceleration": (6,), "thrusts": flight["speeds"].shape, "mode": (), "charge": ()}
    return packed_dtype(shapes | own)


def make_fly_recorded(
    controller: Controller, source: StateSource, estimates: bool
) -> Callable[..., None]:
    """Return a flight with a controller's law.

    Args:
        controller: whose law flies.
        source: of the state that the law gets.
        estimates: whether an estimator tells it.
    """
    key = f"{controller.key}_{source.key}"
    fly_period = make_fly_period(make_law_update(controller), source, key)
    keep_estimate = _record_estimate if estimates else _record_no_estimate

    def fly(
        flights: np.ndarray,
        rings: DelayRings,
        room: LaneWorkspace,
        times: LaneTimes,
        clock: PeriodClock,
        sensors: EstimatorInputs | None,
        references: np.ndarray,
        first: int,
        samples: np.ndarray,
    ) -> None:
        """Fly some control periods of one flight; this is what gets compiled.

        Args:
            flights: its record (1), see `record.flight_dtype`.
            rings: see `DelayRings`.
            room: of its motion, furnished, see `VehicleBatch.furnish`.
            times: see `LaneTimes`.
            clock: see `PeriodClock`.
            sensors: see `make_fly_period`.
            references: (M, 8) the pilot's command from each instant on.
            first: number of the first instant.
            samples: (M) see `sample_dtype`.
        """
        flight, body = flights[0], room.bodies[0]
        if first == 0:
            write_flights(flights, rings, room)
        for k in range(len(samples)):
            derive_lanes(body, room.rotors, clock.sags, True)
            _record_sample(flight, room, samples[k])
            if first + k == 0:
                set_field(flight, "acceleration", lane_acceleration(body, 0))
            for place in range(len(flight.reference)):
                flight.reference[place] = references[k, place]
            fly_period(flights, rings, room, times, clock, sensors)
            keep_estimate(flight, samples[k])

    return give_unique_name(fly, key)


@register_jitable
def _record_sample(flight: np.record, room: LaneWorkspace, sample: np.record) -> None:
    """Write what the recorder sees of a flight before the updates of an instant."""
    body = room.bodies[0]
    sample.state[:] = flight.state
    sample.speeds[:] = flight.speeds
    sample.wind[:] = flight.wind
    sample.commands[:] = flight.commands
    sample.reference[:] = flight.reference
    sample.mode = flight.mode
    sample.charge = flight.charge
    set_field(sample, "acceleration", lane_acceleration(body, 0))
    R_WB, w_B, v_B = get_lane(body, "R_WB", 0), get_lane(body, "w_B", 0), get_lane(body, "v_B", 0)
    for number in range(len(room.rotors)):
        rotor = room.rotors[number]
        known = rotor_constants_of(rotor, 0)
        v_x, v_y, v_z = hub_velocity(known, w_B, v_B)
        n_x, n_y, n_z = known.axis_B
        along = v_x * n_x + v_y * n_y + v_z * n_z
        share, static = get_lane(rotor, "share", 0), get_lane(rotor, "static", 0)
        speed, height = get_lane(rotor, "speed", 0), get_lane(body, "p_WB", 0)[2]
        sample.thrusts[number] = moving_thrust(known, speed, share, static, along, R_WB, height)


@register_jitable
def _record_estimate(flight: np.record, sample: np.record) -> None:
    """Write what the estimator tells at an instant, and what it remembers."""
    sample.estimate[:] = flight.estimate
    sample.estimator[:] = flight.estimator


@register_jitable
def _record_no_estimate(flight: np.record, sample: np.record) -> None:
    """Do nothing: nothing is estimated."""


@lru_cache(maxsize=64)
def compiled_recorded(controller: Controller, estimator: Estimator | None, shapes: str) -> Compiled:
    """Return the flight with a controller, compiled at its first call.

    Args:
        controller: whose law flies; it compiles.
        estimator: that tells it the motion; None tells it the truth.
        shapes: of the records in words, as machine code is for one type of them.
    """
    source = estimator_source(estimator) if estimator else TRUE_STATE
    return compiled_flights(
        make_fly_recorded(controller, source, estimator is not None),
        "recorded flights",
        controller,
        estimator,
        f"recorded {shapes} ",
    )
