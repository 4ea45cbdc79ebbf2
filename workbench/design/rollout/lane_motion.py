"""Copy the motion of a flight to and from a lane of the compiled code."""

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.fields import get_field, set_lane
from workbench.design.rollout.lanes import LANES, LaneWorkspace
from workbench.dynamics.rotors import turning_share


@register_jitable(allocates=False)
def read_lane_motion(flight: np.record, room: LaneWorkspace, i: int) -> None:
    """Read the state of a flight from its lane."""
    state, speeds = room.bodies[0].state, flight.speeds
    for k in range(13):
        flight.state[k] = state[k * LANES + i]
    for number in range(len(speeds)):
        speeds[number] = room.rotors[number].speed[i]


@register_jitable(allocates=False)
def write_lane_state(flight: np.record, room: LaneWorkspace, i: int) -> None:
    """Write the state of a flight, and what seldom changes, to its lane."""
    body = room.bodies[0]
    state, speeds = body.state, flight.speeds
    for k in range(13):
        state[k * LANES + i] = flight.state[k]
    set_lane(body, "half_drag", i, 0.5 * flight.air.air_density * flight.air.drag_area)
    set_lane(body, "drop", i, flight.drop)
    set_lane(body, "compensation", i, flight.sag_compensation)
    for number in range(len(speeds)):
        rotor, share = room.rotors[number], flight.shares[number]
        set_lane(rotor, "speed", i, speeds[number])
        set_lane(rotor, "share", i, turning_share(share))
        set_lane(rotor, "runs", i, 1.0 if share > 0.0 else 0.0)


@register_jitable(allocates=False)
def write_lane_air(flight: np.record, room: LaneWorkspace, i: int) -> None:
    """Write wind and push of a flight to its lane."""
    body, push = room.bodies[0], get_field(flight, "push")
    set_lane(body, "wind", i, get_field(flight, "wind"))
    set_lane(body, "push", i, push[0:3])
    set_lane(body, "push_point", i, push[3:6])
    set_lane(body, "push_torque", i, push[6:9])


@register_jitable(allocates=False)
def write_lane_drive(flight: np.record, room: LaneWorkspace, i: int) -> None:
    """Write commands and voltage of a flight to its lane."""
    set_lane(room.bodies[0], "open_circuit", i, flight.open_circuit)
    set_lane(room.bodies[0], "known_open_circuit", i, flight.open_circuit)
    for number in range(len(flight.acting)):
        set_lane(room.rotors[number], "command", i, flight.acting[number])
