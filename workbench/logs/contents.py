"""The parts of a log other than topics, and their names: scenario, gains, actions, versions."""

import json
import platform
from collections.abc import Mapping
from dataclasses import fields, replace
from importlib import metadata
from numbers import Real
from pathlib import Path
from typing import Any

import yaml

from workbench.common.resources import list_models, list_worlds
from workbench.common.yaml_files import as_record, dump_changes
from workbench.control.controller import Controller
from workbench.control.installed_laws import DEFAULT_CONTROLLER, is_shipped
from workbench.control.schedule import split_label, with_label
from workbench.estimation.settings import ESTIMATORS
from workbench.link.signal import RosChannel
from workbench.scenario.scenario import Action, Gust, Injection, Push, Scenario

FLIGHT_METADATA = "flight"
"""Name of the metadata with vehicle, physics_step [s] and begun_ns [ns since 1970]."""
VERSIONS_METADATA = "versions"
SETTINGS_METADATA = "settings"
SCENARIO_ATTACHMENT = "scenario.yaml"
"""Attachment: the scenario, for `workbench fly`."""
GAINS_ATTACHMENT = "gains.yaml"
"""Attachment: all parameter values at the start, as a gain file."""
CONTROLLER_METADATA = "controller"
"""Name of the metadata with name, file and sha256 of the control law; attachment: its text."""
LAW_ATTACHMENT = "controller.py"
LAW_MEDIA_TYPE = "text/x-python"
JOINTS_METADATA = "joints"
"""Name of the metadata with the unit of the position of each joint, if the vehicle has any."""
ESTIMATOR_METADATA = "estimator"
"""Name of the metadata with name, file and sha256 of the user's own estimator, if the flight used
one; attachment: its text."""
ESTIMATOR_ATTACHMENT = "estimator.py"
LAW_ATTACHMENT_PREFIX = "controllers/"
"""Prefix of the names of attachments with the texts of laws that took over in flight."""
TOPICS_ATTACHMENT = "topics.json"
"""Attachment: the link's definitions of the topics."""
IMPORTED_ATTACHMENT = "flight_record.json"
"""The only attachment of an imported log: data that are not in its messages."""
STATE_CHANNEL = RosChannel("/dh_drone/exact_state", "dh_drone_msgs/msg/ExactState")
ACTIONS_CHANNEL = RosChannel("/dh_drone/actions", "dh_drone_msgs/msg/PilotAction")

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def law_attachment_name(law: Controller) -> str:
    """Return the name of the attachment with the text of a law, also used in its action."""
    file = f"{LAW_ATTACHMENT_PREFIX}{law.digest[:12]}/{law.unscheduled}.py"
    return with_label(file, law.schedule.label if law.schedule else "")


def scenario_text(scenario: Scenario) -> str:
    """Return the YAML of what differs from the default scenario, with absolute paths of files."""
    from pydrake.common.yaml import yaml_dump_typed

    vehicle = scenario.vehicle
    rooted = replace(
        scenario,
        world=_from_root(scenario.world, list_worlds()),
        controller=_controller_from_root(scenario.controller),
        estimator=_from_root(scenario.estimator, list(ESTIMATORS)),
        vehicle=replace(
            vehicle,
            model=_from_root(vehicle.model, list_models()),
            rotors=_from_root(vehicle.rotors, []),
            gains=_from_root(vehicle.gains, []),
            packages={name: _from_root(path, []) for name, path in vehicle.packages.items()},
        ),
    )
    plain = yaml_dump_typed(rooted, defaults=Scenario())  # numbers may be numpy's
    return dump_changes(as_record(yaml.load(plain, _LOADER), Scenario))


def logged_gains_text(
    vehicle: str, values: Mapping[str, float], controller: str = DEFAULT_CONTROLLER
) -> str:
    """Return parameter values as the text of a gain file for a vehicle and a controller."""
    whose = {} if controller == DEFAULT_CONTROLLER else {"controller": controller}
    data: dict[str, Any] = {
        "vehicle": vehicle,
        **whose,
        "origin": "the start of a logged flight",
        "gains": {name: float(value) for name, value in values.items()},
    }
    text: str = yaml.safe_dump(data, sort_keys=False, allow_unicode=True)
    return text


def read_gains(text: str) -> dict[str, float]:
    """Return the parameter values from a text made by `logged_gains_text`.

    Raises:
        yaml.YAMLError, KeyError, TypeError, ValueError: if it is invalid.
    """
    return {str(name): float(value) for name, value in yaml.load(text, _LOADER)["gains"].items()}


def _from_root(name: str, shipped: list[str]) -> str:
    """Return an absolute path, or a shipped name unchanged."""
    if not name or name in shipped or not Path(name).expanduser().exists():
        return name
    return str(Path(name).expanduser().resolve())


def _controller_from_root(name: str) -> str:
    file, label = split_label(name)
    return name if is_shipped(file) else with_label(_from_root(file, []), label)


def action_text(action: Action) -> str:
    """Return an action as JSON, without its time and defaults; numbers are exact."""
    values = {
        field.name: _action_value_as_json(getattr(action, field.name)) for field in fields(Action)
    }
    usual = {
        field.name: _action_value_as_json(getattr(Action(), field.name)) for field in fields(Action)
    }
    return json.dumps(
        {name: value for name, value in values.items() if name != "at" and value != usual[name]}
    )


def read_action(at: float, text: str) -> Action:
    """Return the action from a text, at a time [s].

    Raises:
        ValueError, TypeError, AttributeError: if it is invalid.
    """
    action: Action = as_record({"at": at, **json.loads(text)}, Action)
    if action.injection:
        injection = replace(action.injection, periods=int(action.injection.periods))
        action = replace(action, injection=injection)
    return action


def _action_value_as_json(value: Any) -> Any:
    """Return a value of JSON types only; numbers may be numpy's."""
    if value is None or isinstance(value, str | bool):
        return value
    if isinstance(value, Gust | Push | Injection):
        values = {
            field.name: _action_value_as_json(getattr(value, field.name)) for field in fields(value)
        }
        if not any(values.get("torque", ())):  # as in logs of earlier versions
            values.pop("torque", None)
        return values
    if isinstance(value, Mapping):
        return {str(name): _action_value_as_json(each) for name, each in value.items()}
    return (
        float(value) if isinstance(value, Real) else [_action_value_as_json(each) for each in value]
    )


LOGGED_PACKAGES = {
    "workbench": "drake-drone-workbench",
    "drake": "drake",
    "numpy": "numpy",
    "numba": "numba",
}
UNKNOWN_VERSION = "unknown"
PHYSICS_VERSION = "2"
"""Version of the physics stepping; logs without it have version 1, Drake's discrete plant."""


def software_versions() -> dict[str, str]:
    """Return the versions of the software used, by name, and the platform."""
    found = {name: _package_version(package) for name, package in LOGGED_PACKAGES.items()}
    machine = {"python": platform.python_version(), "platform": platform.platform()}
    return {"physics": PHYSICS_VERSION} | found | machine


def _package_version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return UNKNOWN_VERSION
