"""The live parameters of the air, in the order of the parameter table."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from workbench.common.parameter import Parameter
from workbench.plant.gravity import AIR_DENSITY

if TYPE_CHECKING:
    from workbench.plant.vehicle import Vehicle


class AirSettings(NamedTuple):
    """Wind, gust, push and drag; `AIR_PARAMETERS` has meaning, unit and range of each."""

    wind_x: float = 0.0
    wind_y: float = 0.0
    wind_z: float = 0.0
    turbulence: float = 0.0
    gust_x: float = 0.0
    gust_y: float = 0.0
    gust_z: float = 0.0
    gust_start: float = 0.0
    gust_duration: float = 1.0
    push_x: float = 0.0
    push_y: float = 0.0
    push_z: float = 0.0
    push_at_x: float = 0.0
    push_at_y: float = 0.0
    push_at_z: float = 0.0
    push_torque_x: float = 0.0
    push_torque_y: float = 0.0
    push_torque_z: float = 0.0
    push_start: float = 0.0
    push_duration: float = 0.1
    drag_area: float = 0.0
    air_density: float = AIR_DENSITY


WIND_FIELDS = AirSettings._fields[: AirSettings._fields.index("push_x")]
"""Names of wind, turbulence and gust."""
PUSH_FIELDS = AirSettings._fields[len(WIND_FIELDS) : AirSettings._fields.index("drag_area")]
"""Names of force, point, torque, start and duration of the push."""
TABLE_DRAG_AREA_M2 = 0.015
"""Drag area in the table [m^2]; a flight has that of its vehicle."""
_AIR_SPEED_RANGE = (-50.0, 50.0)
_FORCE_RANGE_N = (-1000.0, 1000.0)
_TORQUE_RANGE_NM = (-100.0, 100.0)
_PUSH_POINT_RANGE_M = (-10.0, 10.0)
_TIME_RANGE_S = (0.0, 1e6)
_DURATION_RANGE_S = (0.001, 3600.0)
_DEFAULTS = AirSettings(drag_area=TABLE_DRAG_AREA_M2)._asdict()


def _air(name: str, unit: str, limits: tuple[float, float], help: str) -> Parameter:
    return Parameter(name, unit, help, *limits, _DEFAULTS[name], "air")


AIR_PARAMETERS = (
    _air("wind_x", "m/s", _AIR_SPEED_RANGE, "velocity of the mean wind to the east"),
    _air("wind_y", "m/s", _AIR_SPEED_RANGE, "velocity of the mean wind to the north"),
    _air("wind_z", "m/s", _AIR_SPEED_RANGE, "velocity of the mean wind upwards"),
    _air(
        "turbulence",
        "m/s",
        (0.0, 50.0),
        "wind speed at 20 ft that causes it: light 7.7, moderate 15.4, severe 23.2",
    ),
    _air("gust_x", "m/s", _AIR_SPEED_RANGE, "peak of the gust to the east"),
    _air("gust_y", "m/s", _AIR_SPEED_RANGE, "peak of the gust to the north"),
    _air("gust_z", "m/s", _AIR_SPEED_RANGE, "peak of the gust upwards"),
    _air("gust_start", "s", _TIME_RANGE_S, "when the gust begins"),
    _air("gust_duration", "s", _DURATION_RANGE_S, "how long the gust rises and falls"),
    _air("push_x", "N", _FORCE_RANGE_N, "force of the push to the east"),
    _air("push_y", "N", _FORCE_RANGE_N, "force of the push to the north"),
    _air("push_z", "N", _FORCE_RANGE_N, "force of the push upwards"),
    _air(
        "push_at_x",
        "m",
        _PUSH_POINT_RANGE_M,
        "where the push acts, ahead of the base link's origin",
    ),
    _air(
        "push_at_y", "m", _PUSH_POINT_RANGE_M, "where the push acts, left of the base link's origin"
    ),
    _air(
        "push_at_z", "m", _PUSH_POINT_RANGE_M, "where the push acts, above the base link's origin"
    ),
    _air("push_torque_x", "N*m", _TORQUE_RANGE_NM, "torque of the push, right side down"),
    _air("push_torque_y", "N*m", _TORQUE_RANGE_NM, "torque of the push, nose down"),
    _air("push_torque_z", "N*m", _TORQUE_RANGE_NM, "torque of the push to the left"),
    _air("push_start", "s", _TIME_RANGE_S, "when the push begins"),
    _air("push_duration", "s", _DURATION_RANGE_S, "how long the push lasts"),
    _air("drag_area", "m^2", (0.0, 10.0), "drag coefficient times area of the body"),
    _air("air_density", "kg/m^3", (0.0, 2.0), "density of the air, for the body's drag"),
)
"""Rows of the parameter table, in the order of `AirSettings`."""


def calm_air(vehicle: "Vehicle") -> AirSettings:
    """Return still air, in which a vehicle has the drag of its size."""
    from workbench.plant.drag import drag_area  # the rows are read before numpy is loaded

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
