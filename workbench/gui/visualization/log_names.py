"""Names that series of a log have in a flight, so that charts show both."""

import math
import re

_AXES = {"x": 0, "y": 1, "z": 2}
_QUATERNION = {"w": 0, "x": 1, "y": 2, "z": 3}
_UNWANTED = re.compile(
    r"covariance|^actions\.|^lidar_cloud\.|^tf|\.fields\.|^pose\.|^twist\.|^gps\.status|"
    r"^command_velocity\.(lease|axes)$|twist\.angular"
)


def live_name(name: str) -> str | None:
    """Return the name of a log's series as a flight has it; None where it is not worth a curve."""
    if _UNWANTED.search(name):
        return None
    patterns = (
        (r"^imu\.linear_acceleration\.([xyz])$", "imu.specific_force.{}", _AXES),
        (r"^imu\.angular_velocity\.([xyz])$", "imu.angular_velocity.{}", _AXES),
        (r"^imu\.orientation\.([wxyz])$", "imu.q_WS.{}", _QUATERNION),
        (r"^gps_velocity\.twist\.linear\.([xyz])$", "gps.velocity.{}", _AXES),
    )
    for pattern, wanted, places in patterns:
        found = re.match(pattern, name)
        if found:
            return wanted.format(places[found.group(1)])
    return name


def si_unit(unit: str) -> tuple[str, float]:
    """Return the SI unit in which a flight has a quantity of a log, and the factor to it."""
    if unit in ("deg", "degree", "degrees"):
        return "rad", math.pi / 180.0
    return unit or "1", 1.0
