"""Pin a log as a regression: a spec that holds later logs of the same flight to what this one is.

The room around each number is what flights of one plan differ by: of 34 pairs of real flights of
one trajectory (NanoBench), the second is within each limit of the first in 91 to 100 %.
"""

import dataclasses
import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

import yaml

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.design.pin import ANYTHING, check_name, limit_between, limit_text, vehicle_head
from workbench.design.regress.running import Job, ReadLog
from workbench.design.regress.spec import Case, Limit, LogConfig, Spec, SpecFile
from workbench.scenario.scenario import VehicleConfig

_HEAD = """\
# Pinned from a log: limits have the room that flights of one plan differ by. For another flight of
# the plan change the file's name under log.
"""
SHARES = {"rise_time": 0.25, "lag": 0.25, "measured_rise_time": 0.25}
"""Numbers that are held from both sides, with this share of room."""
MOST = {
    "overshoot": (1.0, 5.0),
    "measured_overshoot": (1.0, 5.0),
    "settling_time": (1.5, 0.0),
    "tracking_error": (1.5, 0.0),
    "mean_rotor_use": (1.0, 0.1),
    "saturation": (1.0, 10.0),
    "trim": (1.0, 0.1),
    "peak_tilt": (1.5, 0.0),
}
"""Numbers that may not become larger: than so many times what they were, and so much more."""
OF_LOOP = ("rise_time", "settling_time", "overshoot", "tracking_error", "lag", "measured_rise_time",
           "measured_overshoot")  # fmt: skip
"""Of them, those that need a loop."""
_NOT_IN_NAMES = re.compile(r"^[^A-Za-z0-9]+|[^A-Za-z0-9 _.+-]")
MARKED = ("rise_time", "settling_time", "overshoot")
"""Numbers of steps, which are left out where they are marked: the step has not settled, say."""


@dataclass(frozen=True)
class PinnedLog:
    """A regression that was written.

    Attributes:
        spec: its file.
        limits: how many numbers are limited.
        left_out: why others are not, by name.
    """

    spec: Path
    limits: int
    left_out: dict[str, str]


def pin_log(
    path: Path | str,
    vehicle: VehicleConfig,
    log: LogConfig,
    loop: str,
    read_log: ReadLog,
    *,
    overwrite: bool = False,
) -> PinnedLog:
    """Write a spec that holds later logs of a flight to what this one is.

    Args:
        path: of the spec, NAME.spec.yaml.
        vehicle: that flew.
        log: which part of which log.
        loop: whose response is judged; "" for none.
        read_log: makes the flight, `workbench.logs.judged_log.read_case`.
        overwrite: whether a spec that is there may be replaced.

    Raises:
        WorkbenchError: if the log cannot be read or tells of nothing, a file is there already, or
            cannot be written.
    """
    path = Path(path).expanduser().absolute()
    check_name(path, (path,), overwrite)
    place = Path(log.file).expanduser().absolute()
    mapping = str(Path(log.mapping).expanduser().absolute()) if log.mapping else ""
    log = dataclasses.replace(log, file=str(place), mapping=mapping)
    names = [name for name in (*SHARES, *MOST) if loop or name not in OF_LOOP]
    case = Case(name=_NOT_IN_NAMES.sub("-", place.name.split(".")[0]), log=log, loop=loop)
    case.limits = dict.fromkeys(names, ANYTHING)
    content = SpecFile(title=f"{place.name}, pinned", vehicle=vehicle, cases=[case])
    spec = Spec(path, content)
    job = Job(spec, case.name, logged=read_log(spec, case))
    found: dict[str, list[float]] = {}
    left_out: dict[str, str] = {}
    for check in job.run().checks:
        name = check.name.split(" ")[0]
        if math.isnan(check.value) or (check.doubt and name in MARKED):
            left_out[name] = check.doubt
        else:
            found.setdefault(name, []).append(check.value)
    # The spec will judge each step: where one of them tells nothing sure, none is held to it.
    limits = {
        name: log_limit(name, values) for name, values in found.items() if name not in left_out
    }
    if not limits:
        raise WorkbenchError(f"{place}: tells of nothing that can be pinned: {left_out[names[0]]}")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, _text(path, vehicle, case, limits))
    return PinnedLog(path, len(limits), left_out)


def log_limit(name: str, values: list[float]) -> Limit:
    """Return the limit of a metric, of which a log has one value or one for each step."""
    if name in SHARES:
        return limit_between((1.0 - SHARES[name]) * min(values), (1.0 + SHARES[name]) * max(values))
    times, more = MOST[name]
    return limit_between(0.0, times * max(values) + more)


def _text(path: Path, vehicle: VehicleConfig, case: Case, limits: dict[str, Limit]) -> str:
    """Return the spec's text."""
    assert case.log is not None
    log = {
        key: value
        for key, value in dataclasses.asdict(case.log).items()
        if value != getattr(LogConfig(), key)
    }
    for key in ("file", "mapping"):
        if key in log:
            log[key] = os.path.relpath(log[key], path.parent)
    head = {"title": f"{case.name}, pinned", "vehicle": vehicle_head(vehicle, path.parent)}
    lines = [_HEAD + yaml.safe_dump(head, sort_keys=False, allow_unicode=True).rstrip("\n")]
    flow = yaml.safe_dump(log, default_flow_style=True, sort_keys=False, width=1000).strip()
    lines += ["cases:", f"  - name: {case.name}", f"    log: {flow}"]
    lines += [f"    loop: {case.loop}"] if case.loop else []
    lines += ["    limits:"]
    lines += [f"      {name}: {limit_text(limit)}" for name, limit in limits.items()]
    return "\n".join(lines) + "\n"
