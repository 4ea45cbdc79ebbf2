"""Names and scales of parameters in versions before that of the law.

ArduPilot 4.7 went to SI units: pull requests 31513 and 32192, and the tables in AC_PosControl.cpp
by which it converts what is stored; those leave FF, PDMX and D_FF of PSC_D_ACC as they were. PX4
1.11 put the velocity gains in accelerations: pull request 14823. Betaflight 4.6 calls the smaller
of two D gains d and the larger one d_max; before, d was the larger one, and d_min the smaller.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

LATEST = (10**6,)
"""Version of anything not known to be older."""


@dataclass(frozen=True)
class Rename:
    """A parameter with a new name since a version.

    Attributes:
        old: its name before.
        new: its name since.
        factor: new value over old value.
        since: the first version with the new name.
    """

    old: str
    new: str
    factor: float
    since: tuple[int, ...]


def _psc() -> Iterable[Rename]:
    since = (4, 7)
    filters = ("FLTT", "FLTE", "FLTD", "FF", "SMAX", "PDMX", "D_FF", "NTF", "NEF")
    for old, new in (("POSXY", "NE_POS"), ("POSZ", "D_POS")):
        yield Rename(f"PSC_{old}_P", f"PSC_{new}_P", 1.0, since)
    for old, new, factor, most in (
        ("VELXY", "NE_VEL", 1.0, 0.01),
        ("VELZ", "D_VEL", 1.0, 0.01),
        ("ACCZ", "D_ACC", 0.1, 0.001),
    ):
        for part in "PID":
            yield Rename(f"PSC_{old}_{part}", f"PSC_{new}_{part}", factor, since)
        yield Rename(f"PSC_{old}_IMAX", f"PSC_{new}_IMAX", most, since)
        for part in filters:
            yield Rename(f"PSC_{old}_{part}", f"PSC_{new}_{part}", 1.0, since)
    yield Rename("PSC_JERK_XY", "PSC_JERK_NE", 1.0, since)
    yield Rename("PSC_JERK_Z", "PSC_JERK_D", 1.0, since)
    for axis in "RPY":
        yield Rename(f"ATC_ACCEL_{axis}_MAX", f"ATC_ACC_{axis}_MAX", 0.01, since)
    yield Rename("ATC_SLEW_YAW", "ATC_RATE_WPY_MAX", 0.01, since)
    yield Rename("ANGLE_MAX", "ATC_ANGLE_MAX", 0.01, since)
    for old, new in (("SPEED", "SPD"), ("ACCEL", "ACC")):
        yield Rename(f"WPNAV_{old}", f"WP_{new}", 0.01, since)
    for old, new in (("SPEED_UP", "SPD_UP"), ("SPEED_DN", "SPD_DN"), ("ACCEL_Z", "ACC_Z")):
        yield Rename(f"WPNAV_{old}", f"WP_{new}", 0.01, since)


ARDUPILOT = tuple(_psc())
PX4 = tuple(
    Rename(f"MPC_{axis}_VEL_{part}", f"MPC_{axis}_VEL_{part}_ACC", 20.0, (1, 11))
    for axis in ("XY", "Z")
    for part in "PID"
)
AXES = ("roll", "pitch", "yaw")
PEAK_BEFORE = (4, 6)
"""First version of Betaflight with d as the smaller of two D gains."""
PEAK, LEAST = {"roll": 40.0, "pitch": 46.0, "yaw": 0.0}, {"roll": 30.0, "pitch": 34.0, "yaw": 0.0}
"""Defaults of d and d_min from 4.3 to 4.5: a `diff` leaves them out."""


def numbers_of(version: str) -> tuple[int, ...]:
    """Return the numbers of a version such as 4.6.0; those of the latest if it has none."""
    found = re.match(r"v?(\d{1,4})((?:\.\d{1,4})*)", version.strip())
    return tuple(int(each) for each in found[0].lstrip("v").split(".")) if found else LATEST


def with_new_names(
    values: Mapping[str, float], renames: Iterable[Rename]
) -> tuple[dict[str, float], dict[str, Rename]]:
    """Return values by present names, and the renamed ones.

    Args:
        values: by the names of a file; if it has both names, the new one counts.
        renames: of the firmware.
    """
    by_old = {each.old: each for each in renames}
    found, renamed = dict(values), {}
    for name in values:
        rename = by_old.get(name)
        if rename is None:
            continue
        value = found.pop(name)
        if rename.new not in values:
            found[rename.new] = value * rename.factor
            renamed[rename.new] = rename
    return found, renamed


def with_old_names(
    values: Mapping[str, float], renames: Iterable[Rename], version: tuple[int, ...]
) -> dict[str, float]:
    """Return values by the names and in the scales of a version."""
    by_new = {each.new: each for each in renames if version < each.since}
    found = {}
    for name, value in values.items():
        rename = by_new.get(name)
        found[rename.old if rename else name] = value / rename.factor if rename else value
    return found


def d_of_today(values: Mapping[str, float]) -> dict[str, float]:
    """Return Betaflight's gains from before 4.6 by their names in 4.6."""
    found = dict(values)
    for axis in AXES:
        if f"d_{axis}" not in found and f"d_min_{axis}" not in found:
            continue
        peak = found.get(f"d_{axis}", PEAK[axis])
        least = found.pop(f"d_min_{axis}", LEAST[axis])
        rises = 0.0 < least < peak
        found[f"d_{axis}"] = least if rises else peak
        found[f"d_max_{axis}"] = peak if rises else 0.0
    return found


def d_of_before(values: Mapping[str, float]) -> dict[str, float]:
    """Return Betaflight's gains from 4.6 by their earlier names; the inverse of `d_of_today`."""
    found = dict(values)
    for axis in AXES:
        base, peak = found.get(f"d_{axis}"), found.pop(f"d_max_{axis}", None)
        if base is None or peak is None:
            continue
        rises = peak > base
        found[f"d_{axis}"] = peak if rises else base
        found[f"d_min_{axis}"] = base if rises else 0.0
    return found
