"""The live parameters of the air, in the order of the parameter table."""

from collections.abc import Sequence
from typing import NamedTuple

from workbench.common.jitable import Scalar
from workbench.plant.drag import AIR_DENSITY, drag_area
from workbench.plant.vehicle import Vehicle


class AirSettings(NamedTuple):
    """Wind, gust, push and drag; `workbench params` lists meaning, unit and range of each."""

    wind_x: Scalar = 0.0
    wind_y: Scalar = 0.0
    wind_z: Scalar = 0.0
    turbulence: Scalar = 0.0
    gust_x: Scalar = 0.0
    gust_y: Scalar = 0.0
    gust_z: Scalar = 0.0
    gust_start: Scalar = 0.0
    gust_duration: Scalar = 1.0
    push_x: Scalar = 0.0
    push_y: Scalar = 0.0
    push_z: Scalar = 0.0
    push_at_x: Scalar = 0.0
    push_at_y: Scalar = 0.0
    push_at_z: Scalar = 0.0
    push_torque_x: Scalar = 0.0
    push_torque_y: Scalar = 0.0
    push_torque_z: Scalar = 0.0
    push_start: Scalar = 0.0
    push_duration: Scalar = 0.1
    drag_area: Scalar = 0.0
    air_density: Scalar = AIR_DENSITY


def calm_air(vehicle: Vehicle) -> AirSettings:
    """Return still air, in which a vehicle has the drag of its size."""
    return AirSettings(drag_area=drag_area(vehicle.mass))


def gust_settings(velocity: Sequence[float], start: float, duration: float) -> dict[str, float]:
    """Return the settings of a gust with a peak velocity in W [m/s], start and duration [s]."""
    x, y, z = velocity
    return {"gust_x": x, "gust_y": y, "gust_z": z, "gust_start": start, "gust_duration": duration}


def push_settings(
    force: Sequence[float],
    point: Sequence[float],
    start: float,
    duration: float,
    torque: Sequence[float] = (0.0, 0.0, 0.0),
) -> dict[str, float]:
    """Return the settings of a push, with times as for a gust [s].

    It has a force in W [N] at a point in B [m], and a torque in B [N·m].
    """
    x, y, z = force
    at_x, at_y, at_z = point
    torque_x, torque_y, torque_z = torque
    return {
        "push_x": x,
        "push_y": y,
        "push_z": z,
        "push_at_x": at_x,
        "push_at_y": at_y,
        "push_at_z": at_z,
        "push_torque_x": torque_x,
        "push_torque_y": torque_y,
        "push_torque_z": torque_z,
        "push_start": start,
        "push_duration": duration,
    }
