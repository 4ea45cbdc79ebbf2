"""All signals by topic, with their descriptions."""

from collections.abc import Iterable, Mapping

from workbench.common.plain_text import plain_name
from workbench.gui.visualization.derived_signals import DERIVED
from workbench.link.topics import PREFIX, Topic

TITLES = {
    "position_data": "Place and attitude",
    "velocity_data": "Velocity",
    "acceleration_data": "Acceleration",
    "force_torque_data": "Force and torque",
    "command_velocity": "Command",
    "estimate": "Estimate",
    "rotors": "Rotors",
    "imu": "IMU",
    "gps": "GPS",
    "lidar": "Lidar",
    "magnetometer": "Magnetometer",
    "wind": "Wind",
    "drone_state": "State of the drone",
    "on_off_state": "On or off",
    "time_data": "Clock",
    "parameters": "Parameters",
    "events": "Events",
    "frames": "Frames",
    "error": "Errors",
    "bound": "Bounds of the estimate",
    "derived": "Derived",
    "own": "Derived by you",
    "exact_state": "Exact state",
}
VECTORS = {
    "imu.specific_force": "xyz",
    "imu.angular_velocity": "xyz",
    "imu.q_WS": "wxyz",
    "gps.velocity": "xyz",
    "lidar.direction": "xyz",
    "magnetometer.magnetic_field": "xyz",
    "wind.wind": "xyz",
}
"""Components of the fields that are vectors or quaternions."""


_ROTORS = "rotors"


def signal_label(name: str) -> str:
    """Return a signal's name within its topic, as charts show it.

    Indices count from 0, but rotors count from 1, as in parameters and on the Home screen. The
    components of a vector are x, y and z, those of a quaternion w, x, y and z.

    Args:
        name: TOPIC.FIELD, or TOPIC.FIELD.INDEX.
    """
    topic, _, field = name.partition(".")
    of, _, index = field.rpartition(".")
    if not index.isdecimal() or not of:
        return plain_name(field)
    if topic == _ROTORS:
        return f"{of} rotor {int(index) + 1}"
    components = VECTORS.get(f"{topic}.{of}", "")
    if int(index) < len(components):
        return f"{of} {components[int(index)]}"
    return plain_name(field)


Catalog = dict[str, list[tuple[str, str, str]]]
"""Name, SI unit and description of the signals of each topic."""


def make_catalog(units: Mapping[str, str], topics: Iterable[Topic]) -> Catalog:
    """Return all signals by topic, in the order of the topic.

    Args:
        units: SI unit of every signal, by name.
        topics: known topics; signals may belong to others, too.
    """
    known = _helps(topics) | {each.name: each.help for each in DERIVED}
    groups: Catalog = {}
    for name, unit in units.items():
        topic, _, field = name.partition(".")
        whole = f"{topic}.{field.partition('.')[0]}"
        groups.setdefault(topic, []).append((name, unit, known.get(name, known.get(whole, ""))))
    return dict(sorted(groups.items(), key=lambda item: _rank(item[0])))


def topic_title(topic: str) -> str:
    """Return the name of a topic in words."""
    return TITLES.get(topic, plain_name(topic.replace("_", " ").capitalize()))


def _rank(topic: str) -> tuple[int, str]:
    order = list(TITLES)
    return (order.index(topic) if topic in order else len(order), topic)


def _helps(topics: Iterable[Topic]) -> dict[str, str]:
    """Return the topics' descriptions of their fields, by TOPIC.FIELD."""
    helps = {}
    for topic in topics:
        short = topic.name.removeprefix(PREFIX)
        for field in topic.fields:
            parts = []
            if field.frame:
                parts.append(f"in {field.frame}")
            if field.low is not None and field.high is not None:
                parts.append(f"{field.low:g} .. {field.high:g}")
            if topic.rate:
                parts.append(f"{topic.rate:.0f} times a second")
            about = topic.about.get(field.name)
            if isinstance(about, str):
                parts.append(about)
            said = ", ".join(parts)
            helps[f"{short}.{field.name}"] = said
    return helps
