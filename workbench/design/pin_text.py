"""A pinned step's spec, as its file has it."""

import os
from pathlib import Path

import yaml

from workbench.common.resources import find_file, find_model, list_models
from workbench.common.yaml_files import dump_changes
from workbench.control.controller import DEFAULT, Controller, load_controller
from workbench.design.regress.spec import Limit, SpecFile
from workbench.scenario.axes import find_axis
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Rates, VehicleConfig

_HEAD = """\
# Pinned from a flight: limits have room around what it was like, and baselines are its curves.
# The gains stand in the gain file beside this one, so no other profile changes what is flown.
"""


def spec_text(content: SpecFile, path: Path, profile: Path) -> str:
    """Return the text of a spec of one step, with a line for each limit.

    Args:
        content: of the spec.
        path: where it will be; files that it names are found from there.
        profile: the gain file beside it.
    """
    (case,) = content.cases
    law = load_controller(content.controller)
    head = {"title": content.title, "vehicle": _vehicle(content.vehicle, path.parent, profile)}
    if content.controller != DEFAULT:
        head["controller"] = _controller(content.controller, path.parent)
    if content.rates != Rates():
        head["rates"] = yaml.safe_load(dump_changes(content.rates))
    lines = [_HEAD + yaml.safe_dump(head, sort_keys=False, allow_unicode=True).rstrip("\n")]
    lines += ["cases:", f"  - name: {case.name}", f"    axis: {case.axis}"]
    unit = find_axis(case.axis).unit
    lines += [f"    amplitude: {case.amplitude!r} # {unit}", f"    duration: {case.duration!r} # s"]
    if case.set:
        lines += ["    set:"]
        lines += [f"      {name}: {_number(name, value, law)}" for name, value in case.set.items()]
    lines += ["    limits:"]
    lines += [f"      {name}: {_limit(limit)}" for name, limit in case.limits.items()]
    lines += ["    baseline:"]
    for signal, tolerance in case.baseline.items():
        lines += [f"      {signal}: {{absolute: {tolerance.absolute!r}}}"]
    if content.margins:
        lines += ["margins:"]
    for loop, limits in content.margins.items():
        lines += [f"  {loop}:"]
        lines += [f"    {name}: {_limit(limit)}" for name, limit in limits.items()]
    return "\n".join(lines) + "\n"


def _number(name: str, value: float, law: Controller) -> str:
    unit = parameter_table(law).find(name).unit
    return f"{value!r}" if unit == "1" else f"{value!r} # {unit}"


def _limit(limit: Limit) -> str:
    """Return a limit as a spec has it."""
    if limit.min > -float("inf") and limit.max < float("inf"):
        return f"[{limit.min!r}, {limit.max!r}]"
    if limit.max < float("inf"):
        return f"{{max: {limit.max!r}}}"
    return f"{{min: {limit.min!r}}}"


def _controller(name: str, folder: Path) -> str:
    """Return a controller as a spec in a folder names it."""
    return _beside(Path(name).resolve(), folder) if name.endswith(".py") else name


def _vehicle(config: VehicleConfig, folder: Path, profile: Path) -> dict[str, object]:
    """Return a vehicle as a spec in a folder names it."""
    found: dict[str, object] = {"model": config.model}
    found |= yaml.safe_load(dump_changes(config)) or {}
    if config.model not in list_models():
        found["model"] = _beside(find_model(config.model), folder)
    if config.rotors:
        found["rotors"] = _beside(find_file(config.rotors), folder)
    if config.packages:
        found["packages"] = {
            name: _beside(Path(place).expanduser().resolve(), folder)
            for name, place in config.packages.items()
        }
    return found | {"gains": profile.name}


def _beside(file: Path, folder: Path) -> str:
    """Return a file's path as seen from a folder, where both lie in the same tree."""
    home = folder.resolve()
    if Path(os.path.commonpath([file, home])) == Path(file.anchor):
        return str(file)
    return os.path.relpath(file, home)
