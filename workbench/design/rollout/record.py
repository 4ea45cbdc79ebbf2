"""One flight between two control periods, as a record of named numbers."""

from typing import Any, NamedTuple

import numpy as np

from workbench.control.controller import Controller
from workbench.control.flight_law import ComputerSettings
from workbench.control.guidance import Reference
from workbench.control.law_constants import LawConstants
from workbench.control.law_signals import FILTER_STATE_COUNT
from workbench.design.rollout.fields import packed_dtype
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.air.update import EDDY_MEMORY_SIZE
from workbench.estimation.gyro import GYRO_COEFFICIENT_COUNT, GYRO_STATE_COUNT, GyroSettings

IMU_MOTION_SIZE = 14
"""Of the IMU, see `motion_between.point_motion`."""
FILTER_COEFFICIENTS = 9
"""Coefficients of a filter, see `estimation.filters`."""


class Sizes(NamedTuple):
    """Sizes that differ between flights.

    Attributes:
        rotors: n.
        gains: of the controller, and what it designs.
        memory: numbers that the law remembers.
    """

    rotors: int
    gains: int
    memory: int


def sizes_of(controller: Controller | None, rotors: int) -> Sizes:
    """Return sizes for a law, None without one."""
    gains = len(controller.gain_names) if controller else 0
    memory = len(controller.memory) if controller else 0
    return Sizes(rotors, gains, memory)


def flight_dtype(sizes: Sizes, estimate: dict[str, Any] | None = None) -> np.dtype:
    """Return the type of a flight's record.

    All fields are float64; a flag is 0.0 or 1.0. Shapes are in brackets, and a field without one is
    a number. Vectors are in W unless they say otherwise. `inputs` are what a flight is given:
    state, speeds, reference, following, wrench, commands, gains, computer, shares, air and gyro.

        state           (13) of the body: q_WB, p_WB [m], w_WB [rad/s], v_WB [m/s]
        speeds          (n) of the rotors [rad/s]
        reference       (8) `guidance.Reference`; `following` (8) is that from the edge on
        hold            (3) point that is held [m]; holding is a flag: it is held
        mode            see `control.mode.FlightMode`; mode_updates are those that it had
        wrench          (4) that is asked for where no law flies: force [N], moment [N·m], in T
        known           (13) the state that the law sees
        commands        (n) of the law [rad/s]; `acting` (n) are those that the rotors follow
        filtered        (10) see `law_signals.FilterStates`
        gains, memory   of the law, in its order; their sizes are those of `sizes`
        computer        (3) `ComputerSettings`
        law             the record of `LawConstants`
        shares          (n) of their thrust that rotors give
        air             the record of `AirSettings`; air_seed of the turbulence, eddies (6) of its
                        filters
        wind            (3) velocity in this control period [m/s]
        push            (9) in this control period: force [N], point in B [m], torque in B [N·m]
        voltage         that the law is told, see `guidance.MeasuredMotion`
        charge          of the battery, 0 .. 1; open_circuit is the voltage that follows, see
                        `dynamics.rotors.loaded_voltage`, and drop, too; sag_compensation is a
                        share; battery_updates are those that it had
        gyro            (7) `GyroSettings`; gyro_every are the steps of physics between its samples,
                        gyro_filters is a flag: they are filtered; gyro_filter (18) has
                        coefficients, gyro_states (12) the states of the filters
        rates           (3) angular velocity in B that the filters give [rad/s]
        motion          (14) at the last control update, of the IMU with an estimator, else of the
                        body's origin, see `motion_between.point_motion`; sampled is a flag: there
                        was an update
        acceleration    (6) angular, and of the origin, at the start [rad/s², m/s²]
        sensing_delay   control periods from sensing to the law; sensing_offset is when in a
                        period the state is sensed, after its beginning [s]
        command_delay   control periods from the law to the rotors; command_offset is when in a
                        period they follow new commands, after its beginning [s]
        step            of the integrator [s]; third is a flag: it is of third order; fast_step and
                        fast_third where the body turns fast, see `session.integration.air_step`
        clearance       height at which the body stands on the ground [m]
        count           control periods flown; lost_at is that at which it was lost, else -1
        peak_use        largest share of its speed limit at which a rotor ran

    Args:
        sizes: see `Sizes`.
        estimate: fields of the sensors and the estimator; none on the truth.
    """
    n = sizes.rotors
    fields: dict[str, Any] = {
        "state": (13,),
        "speeds": (n,),
        "reference": (len(Reference._fields),),
        "following": (len(Reference._fields),),
        "wrench": (4,),
        "commands": (n,),
        "gains": (sizes.gains,),
        "computer": (len(ComputerSettings._fields),),
        "shares": (n,),
        "air": packed_dtype(dict.fromkeys(AirSettings._fields, ())),
        "gyro": (len(GyroSettings._fields),),
        "hold": (3,),
        "holding": (),
        "mode": (),
        "mode_updates": (),
        "known": (13,),
        "acting": (n,),
        "filtered": (FILTER_STATE_COUNT,),
        "memory": (sizes.memory,),
        "law": law_dtype(n),
        "air_seed": (),
        "eddies": (EDDY_MEMORY_SIZE,),
        "wind": (3,),
        "push": (9,),
        "charge": (),
        "open_circuit": (),
        "voltage": (),
        "drop": (),
        "sag_compensation": (),
        "battery_updates": (),
        "gyro_every": (),
        "gyro_filters": (),
        "gyro_filter": (GYRO_COEFFICIENT_COUNT,),
        "gyro_states": (GYRO_STATE_COUNT,),
        "rates": (3,),
        "motion": (IMU_MOTION_SIZE,),
        "sampled": (),
        "acceleration": (6,),
        "sensing_delay": (),
        "sensing_offset": (),
        "command_delay": (),
        "command_offset": (),
        "step": (),
        "third": (),
        "fast_step": (),
        "fast_third": (),
        "clearance": (),
        "count": (),
        "lost_at": (),
        "peak_use": (),
        **(estimate or {}),
    }
    present = {name: kind for name, kind in fields.items() if kind != (0,)}
    return packed_dtype(present, whole={"inputs": ("state", "gyro")})


def law_dtype(n: int) -> np.dtype:
    """Return the type of the record of `LawConstants`, for n rotors."""
    shapes = {"inertia": (6,), "q_BT": (4,), "p_BoBcm_B": (3,), "drag": (3,)}
    shapes |= {"allocation": (n, 4), "effects": (n, 4)}
    each = ("idle_thrusts", "max_thrusts", "motor_constants", "half_linear_speeds")
    shapes |= dict.fromkeys(each, (n,))
    return packed_dtype({name: shapes.get(name, ()) for name in LawConstants._fields})


def law_record(constants: LawConstants) -> np.ndarray:
    """Return constants as a record (1)."""
    found = np.zeros(1, law_dtype(len(constants.idle_thrusts)))
    for name, value in zip(constants._fields, constants, strict=True):
        found[name] = value
    return found
