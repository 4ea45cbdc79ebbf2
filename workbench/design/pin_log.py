"""Pin a logged flight as a case of a specification."""

import dataclasses
import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

import yaml

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_in_folder
from workbench.common.resources import find_file
from workbench.design.pin import check_name
from workbench.design.pin_limits import (
    LIMIT_WITHOUT_EFFECT,
    PIN_LOG_SHARES,
    PIN_LOG_UPPER_LIMITS,
    log_limit,
)
from workbench.design.pin_spec import limit_text, vehicle_head
from workbench.design.regress.running import Job, ReadLog
from workbench.design.regress.spec import LogConfig, Spec, SpecCase, SpecFile, SpecLimit
from workbench.scenario.scenario import VehicleConfig

_PIN_LOG_HEAD = """\
# Pinned from a log: limits leave room for the differences between flights of one plan. For another
# flight of the plan, change the name of the file under log.
"""
PIN_LOOP_NUMBERS = (
    "rise_time",
    "settling_time",
    "overshoot",
    "tracking_error",
    "lag",
    "measured_rise_time",
    "measured_overshoot",
)
"""Those of them that need a loop."""
WITHHELD_NUMBERS = ("rise_time", "settling_time", "overshoot")
"""Numbers of steps that are left out where they are withheld, such as for a step that has not
settled."""
_NOT_IN_NAMES = re.compile(r"^[^A-Za-z0-9]+|[^A-Za-z0-9 _.+-]")


@dataclass(frozen=True)
class PinnedLog:
    """A regression that was written.

    Attributes:
        spec: its file.
        limits: their number.
        left_out: why other numbers have no limit, by name.
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
    """Write a spec that compares later logs of a flight with this one.

    Args:
        path: of the spec, NAME.workbench.yaml.
        vehicle: the one that flew.
        log: the log and the part of it.
        loop: the one to judge the response of; "" for none.
        read_log: reads the flight, such as `workbench.logs.judged_log.read_case`.
        overwrite: whether to replace an existing spec.

    Raises:
        WorkbenchError: if the log cannot be read or yields no number, or a file exists or cannot be
            written.
    """
    path = Path(path).expanduser().absolute()
    check_name(path, (path,), overwrite)
    for name in filter(None, (log.file, log.mapping)):
        find_file(name)
    place = Path(log.file).expanduser().absolute()
    mapping = str(Path(log.mapping).expanduser().absolute()) if log.mapping else ""
    log = dataclasses.replace(log, file=str(place), mapping=mapping)
    names = [
        name
        for name in (*PIN_LOG_SHARES, *PIN_LOG_UPPER_LIMITS)
        if loop or name not in PIN_LOOP_NUMBERS
    ]
    case = SpecCase(name=_NOT_IN_NAMES.sub("-", place.name.split(".")[0]), log=log, loop=loop)
    case.limits = dict.fromkeys(names, LIMIT_WITHOUT_EFFECT)
    content = SpecFile(title=f"{place.name}, pinned", vehicle=vehicle, cases=[case])
    spec = Spec(path, content)
    job = Job(spec, case.name, logged=read_log(spec, case))
    found: dict[str, list[float]] = {}
    left_out: dict[str, str] = {}
    for check in job.task.run().checks:
        name = check.name.split(" ")[0]
        if math.isnan(check.value) or (check.doubt and name in WITHHELD_NUMBERS):
            left_out[name] = check.doubt
        else:
            found.setdefault(name, []).append(check.value)
    # The spec will judge each step. If the number is withheld for one of them, none gets a limit.
    limits = {
        name: log_limit(name, values) for name, values in found.items() if name not in left_out
    }
    if not limits:
        raise WorkbenchError(f"{place}: has nothing that can be pinned: {left_out[names[0]]}")
    write_in_folder(path, _log_text(path, vehicle, case, limits))
    return PinnedLog(path, len(limits), left_out)


def _log_text(
    path: Path, vehicle: VehicleConfig, case: SpecCase, limits: dict[str, SpecLimit]
) -> str:
    """Return the text of the spec."""
    assert case.log is not None
    log = {
        key: value
        for key, value in dataclasses.asdict(case.log).items()
        if value != getattr(LogConfig(), key)
    }
    for key in ("file", "mapping"):
        if key in log:
            log[key] = os.path.relpath(str(log[key]), path.parent)
    head = {"title": f"{case.name}, pinned", "vehicle": vehicle_head(vehicle, path.parent)}
    lines = [_PIN_LOG_HEAD + yaml.safe_dump(head, sort_keys=False, allow_unicode=True).rstrip("\n")]
    flow = yaml.safe_dump(log, default_flow_style=True, sort_keys=False, width=1000).strip()
    lines += ["cases:", f"  - name: {case.name}", f"    log: {flow}"]
    lines += [f"    loop: {case.loop}"] if case.loop else []
    lines += ["    limits:"]
    lines += [f"      {name}: {limit_text(limit)}" for name, limit in limits.items()]
    return "\n".join(lines) + "\n"
