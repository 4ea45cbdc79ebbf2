"""What a pilot did, as text and back: JSON with the keys of a scenario's script."""

import json
from collections.abc import Mapping
from dataclasses import fields, replace
from numbers import Real
from typing import Any

from workbench.scenario.scenario import Action, Gust, Injection, Push


def action_text(action: Action) -> str:
    """Return an action as JSON, without its time and what is as by default; numbers are exact."""
    values = {field.name: _plain(getattr(action, field.name)) for field in fields(Action)}
    usual = {field.name: _plain(getattr(Action(), field.name)) for field in fields(Action)}
    return json.dumps(
        {name: value for name, value in values.items() if name != "at" and value != usual[name]}
    )


def read_action(at: float, text: str) -> Action:
    """Return the action of a text at a time [s].

    Raises:
        ValueError, TypeError, AttributeError: if it is none.
    """
    values: dict[str, Any] = json.loads(text)
    if "gust" in values:
        values["gust"] = Gust(**values["gust"])
    if "push" in values:
        values["push"] = Push(**values["push"])
    if "injection" in values:
        injection = Injection(**values["injection"])
        values["injection"] = replace(injection, periods=int(injection.periods))
    return Action(at=at, **values)


def _plain(value: Any) -> Any:
    """Return a value made only of what JSON knows; numbers may be numpy's."""
    if value is None or isinstance(value, str | bool):
        return value
    if isinstance(value, Gust | Push | Injection):
        values = {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
        if not any(values.get("torque", ())):  # as what reads logs of earlier versions has it
            values.pop("torque", None)
        return values
    if isinstance(value, Mapping):
        return {str(name): _plain(each) for name, each in value.items()}
    return float(value) if isinstance(value, Real) else [_plain(each) for each in value]
