"""One compiled flight along a script, with all that a recording has of it.

At a control instant the recorder sees what the diagram's sees: all that holds until then. Only the
estimate is that of the update of then.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.common.compiled import Compiled
from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.design.rollout.engine import compiled_flights
from workbench.design.rollout.estimate import know_by
from workbench.design.rollout.fields import packed_dtype, store, take
from workbench.design.rollout.flights import write_flights
from workbench.design.rollout.gyro import KNOW_TRUTH
from workbench.design.rollout.motion import acceleration, constants, derive
from workbench.design.rollout.period import make_fly_period, make_update
from workbench.dynamics.rotors import hub_velocity, moving_thrust
from workbench.estimation.estimators import Estimator

COPIED = ("state", "speeds", "wind", "commands", "reference")
"""Fields of a flight that are copied, as they are before the updates of an instant; and so its
`mode` and `charge`."""
ESTIMATED = ("estimate", "estimator")
"""Fields that are copied as they are after the estimator's update."""


def sample_dtype(flight: np.dtype) -> Any:
    """Return the type of a sample of a flight, of the type of its record.

    It has fields of that record, and

        acceleration    (6) angular, and of the origin, in W [rad/s², m/s²]
        thrusts         (n) of the rotors [N]
    """
    names = [name for name in (*COPIED, *ESTIMATED) if name in (flight.names or ())]
    shapes = {name: flight[name].shape for name in names}
    own = {"acceleration": (6,), "thrusts": flight["speeds"].shape, "mode": (), "charge": ()}
    return packed_dtype(shapes | own)


def make_fly(controller: Controller, knowing: Any, estimates: bool) -> Callable[..., None]:
    """Return a flight with a controller's law.

    Args:
        controller: whose law flies.
        knowing: how it knows the motion, see `period.Knowing`.
        estimates: whether an estimator tells it.
    """
    key = f"{controller.key}_{knowing.key}"
    fly_period = make_fly_period(make_update(controller), knowing, key)
    keep_estimate = _keep_estimate if estimates else _keep_nothing

    def fly(flights, rings, room, times, clock, sensors, references, first, samples):
        """Fly some control periods of one flight; this is what gets compiled.

        Args:
            flights: its record (1), see `record.flight_dtype`.
            rings: see `period.Rings`.
            room: of its motion, furnished, see `Crafts.furnish`.
            times: see `period.Times`.
            clock: see `period.Clock`.
            sensors: see `make_fly_period`.
            references: (M, 8) the pilot's command from each instant on.
            first: number of the first instant.
            samples: (M) see `sample_dtype`.
        """
        flight, body = flights[0], room.bodies[0]
        if first == 0:
            write_flights(flights, rings, room)
        for k in range(len(samples)):
            derive(body, room.rotors, clock.sags, True)
            _keep(flight, room, samples[k])
            if first + k == 0:
                store(flight, "acceleration", acceleration(body, 0))
            for place in range(len(flight.reference)):
                flight.reference[place] = references[k, place]
            fly_period(flights, rings, room, times, clock, sensors)
            keep_estimate(flight, samples[k])

    return unique(fly, key)


@register_jitable
def _keep(flight, room, sample):
    """Write what the recorder sees of a flight before the updates of an instant."""
    body = room.bodies[0]
    sample.state[:] = flight.state
    sample.speeds[:] = flight.speeds
    sample.wind[:] = flight.wind
    sample.commands[:] = flight.commands
    sample.reference[:] = flight.reference
    sample.mode = flight.mode
    sample.charge = flight.charge
    store(sample, "acceleration", acceleration(body, 0))
    R_WB, w_B, v_B = take(body, "R_WB", 0), take(body, "w_B", 0), take(body, "v_B", 0)
    for number in range(len(room.rotors)):
        rotor = room.rotors[number]
        known = constants(rotor, 0)
        v_x, v_y, v_z = hub_velocity(known, w_B, v_B)
        n_x, n_y, n_z = known.axis_B
        along = v_x * n_x + v_y * n_y + v_z * n_z
        share, static = take(rotor, "share", 0), take(rotor, "static", 0)
        speed, height = take(rotor, "speed", 0), take(body, "p_WB", 0)[2]
        sample.thrusts[number] = moving_thrust(known, speed, share, static, along, R_WB, height)


@register_jitable
def _keep_estimate(flight, sample):
    """Write what the estimator tells at an instant, and what it remembers."""
    sample.estimate[:] = flight.estimate
    sample.estimator[:] = flight.estimator


@register_jitable
def _keep_nothing(flight, sample):
    """Do nothing: nothing is estimated."""


@lru_cache(maxsize=64)
def compiled_recorded(controller: Controller, estimator: Estimator | None, shapes: str) -> Compiled:
    """Return the flight with a controller, compiled at its first call.

    Args:
        controller: whose law flies; it compiles.
        estimator: that tells it the motion; None tells it the truth.
        shapes: of the records in words, as machine code is for one type of them.
    """
    knowing = know_by(estimator) if estimator else KNOW_TRUTH
    return compiled_flights(
        make_fly(controller, knowing, estimator is not None),
        "recorded flights",
        controller,
        estimator,
        f"recorded {shapes} ",
    )
