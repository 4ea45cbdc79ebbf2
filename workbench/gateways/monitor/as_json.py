"""A picture of a flight as an object of JSON on one line."""

import json
import math

from workbench.gateways.monitor.picture import Picture
from workbench.link.topics import Value


def as_json(picture: Picture) -> str:
    """Return the object; numbers are in SI units, and what is not finite is null."""
    control = picture.control
    said = {
        "vehicle": picture.vehicle,
        "address": picture.address,
        "connected": not picture.trouble,
        "trouble": picture.trouble,
        "time": picture.time,
        "rate": round(picture.rate, 1),
        "age": picture.age,
        "control": control
        and {
            "hand": control.hand.value,
            "peer": control.peer,
            "name": control.name,
            "stage": control.stage.value,
            "age": _plain(control.age),
            "reason": control.reason,
        },
        "topics": {
            name: {field: _plain(value) for field, value in sample.values.items()}
            for name, sample in picture.samples.items()
        },
    }
    return json.dumps(said, allow_nan=False, separators=(",", ":"))


def _plain(value: Value) -> object:
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
