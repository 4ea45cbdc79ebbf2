"""The text of a pinned specification."""

import os
from pathlib import Path

import yaml

from workbench.common.resources import find_file, find_model, list_models
from workbench.common.yaml_files import changes_of
from workbench.control.controller import Controller
from workbench.control.installed_laws import DEFAULT_CONTROLLER
from workbench.design.regress.spec import SpecFile, SpecLimit
from workbench.estimation.settings import TRUTH
from workbench.scenario.loads import find_excited
from workbench.scenario.scenario import Rates, SensorsConfig, VehicleConfig

_PIN_HEAD = """\
# Pinned from a flight: limits leave room around its numbers, and baselines are its curves.
# The gains are in the gain file beside this one, so no other gain file changes what is flown.
"""


def spec_text(content: SpecFile, path: Path, gain_file: Path, law: Controller) -> str:
    """Return the text of a spec of one step, with a line for each limit.

    Args:
        content: what the spec states.
        path: of the spec; files named in it are relative to it.
        gain_file: the one beside it.
        law: the controller that it names.
    """
    (case,) = content.cases
    flown = vehicle_head(content.vehicle, path.parent) | {"gains": gain_file.name}
    head: dict[str, object] = {"title": content.title, "vehicle": flown}
    if content.controller != DEFAULT_CONTROLLER:
        head["controller"] = content.controller
        if content.controller.endswith(".py"):
            head["controller"] = _relative_path(Path(content.controller).resolve(), path.parent)
    if content.estimator != TRUTH:
        head["estimator"] = content.estimator
    if content.sensors != SensorsConfig():
        head["sensors"] = changes_of(content.sensors)
    if content.rates != Rates():
        head["rates"] = changes_of(content.rates)
    lines = [_PIN_HEAD + yaml.safe_dump(head, sort_keys=False, allow_unicode=True).rstrip("\n")]
    kind, step = ("load", case.load) if case.load else ("axis", case.axis)
    lines += ["cases:", f"  - name: {case.name}", f"    {kind}: {step}"]
    unit = find_excited(step).unit
    lines += [f"    amplitude: {case.amplitude!r} # {unit}", f"    duration: {case.duration!r} # s"]
    if case.acts is not None:
        lines += [f"    acts: {case.acts!r} # s"]
    if case.set:
        lines += ["    set:"]
        lines += [
            f"      {name}: {_number_with_unit(name, value, law)}"
            for name, value in case.set.items()
        ]
    lines += ["    limits:"]
    lines += [f"      {name}: {limit_text(limit)}" for name, limit in case.limits.items()]
    lines += ["    baseline:"]
    for signal, tolerance in case.baseline.items():
        lines += [f"      {signal}: {{absolute: {tolerance.absolute!r}}}"]
    if content.margins:
        lines += ["margins:"]
    for loop, limits in content.margins.items():
        lines += [f"  {loop}:"]
        lines += [f"    {name}: {limit_text(limit)}" for name, limit in limits.items()]
    return "\n".join(lines) + "\n"


def _number_with_unit(name: str, value: float, law: Controller) -> str:
    unit = law.table.find(name).unit
    return f"{value!r}" if unit == "1" else f"{value!r} # {unit}"


def limit_text(limit: SpecLimit) -> str:
    """Return a limit in the form used in a spec."""
    if limit.min > -float("inf") and limit.max < float("inf"):
        return f"[{limit.min!r}, {limit.max!r}]"
    if limit.max < float("inf"):
        return f"{{max: {limit.max!r}}}"
    return f"{{min: {limit.min!r}}}"


def vehicle_head(config: VehicleConfig, folder: Path) -> dict[str, object]:
    """Return the head of a spec in a folder that names a vehicle, without its gains."""
    found: dict[str, object] = {"model": config.model, **changes_of(config)}
    if config.model not in list_models():
        found["model"] = _relative_path(find_model(config.model), folder)
    if config.rotors:
        found["rotors"] = _relative_path(find_file(config.rotors), folder)
    if config.packages:
        found["packages"] = {
            name: _relative_path(Path(place).expanduser().resolve(), folder)
            for name, place in config.packages.items()
        }
    found.pop("gains", None)
    return found


def _relative_path(file: Path, folder: Path) -> str:
    """Return the path of a file relative to a folder, if both lie in the same tree."""
    home = folder.resolve()
    if Path(os.path.commonpath([file, home])) == Path(file.anchor):
        return str(file)
    return os.path.relpath(file, home)
