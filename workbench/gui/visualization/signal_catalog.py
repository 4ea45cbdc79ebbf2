"""All signals by topic, with their descriptions."""

from collections.abc import Iterable, Mapping
from functools import cache

from workbench.common.plain_text import plain_name
from workbench.gui.visualization.derived_signals import DERIVED_SIGNALS
from workbench.link.drone_topics import drone_signals
from workbench.link.signal import ANY_DRONE
from workbench.link.topics import PREFIX, Topic

OTHER_TOPIC_TITLES = {
    "error": "Errors",
    "bound": "Bounds of the estimate",
    "derived": "Derived",
    "own": "Derived by you",
    "exact_state": "Exact state",
}
"""Titles of signals that are not published, and their order after those that are."""
_ROTORS_TOPIC = "rotors"
_BOUND_SIGNS = {"low": "\N{MINUS SIGN}", "high": "+"}


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
    if topic == _ROTORS_TOPIC:
        return f"{of} rotor {int(index) + 1}"
    components = vector_components().get(f"{topic}.{of}", "")
    if int(index) < len(components):
        return f"{of} {components[int(index)]}"
    return plain_name(field)


SETPOINT_TOPICS = (
    *("command_velocity", "setpoint", "attitude_setpoint", "rate_setpoint"),
    "joint_setpoints",
)
"""Topics of what loops should follow, in the order of the cascade, then of what servos should."""
_FOLLOWING_LABELS = {
    "yaw_rate": ("w_z",),
    "w_x": ("angular_velocity x", "w_x"),
    "w_y": ("angular_velocity y", "w_y"),
    "w_z": ("angular_velocity z", "w_z"),
}
"""Labels of what follows a setpoint, where they are not that of its field, the likeliest first."""


def setpoint_label(name: str) -> str:
    """Return the label of a setpoint, "" for any other signal."""
    topic, _, field = name.partition(".")
    if topic not in SETPOINT_TOPICS:
        return ""
    return f"{plain_name(field)} {'command' if topic == SETPOINT_TOPICS[0] else 'setpoint'}"


def bound_label(name: str) -> str:
    """Return the label of a bound of the estimate, "" for any other signal."""
    topic, _, field = name.partition(".")
    of, _, side = field.rpartition("_")
    if topic != "bound" or side not in _BOUND_SIGNS:
        return ""
    return f"{plain_name(of)} {_BOUND_SIGNS[side]} 2σ"


def estimate_label(name: str, names: tuple[str, ...]) -> str:
    """Return the label of an estimate in a chart with its truth or bounds, "" without them.

    Args:
        name: the signal.
        names: all signals of the chart.
    """
    topic, _, field = name.partition(".")
    if topic != "estimate":
        return ""
    for each in names:
        other = each.partition(".")[2]
        if bound_label(each):
            other = other.rpartition("_")[0]
        if each != name and other == field and not setpoint_label(each):
            return f"{plain_name(field)} estimate"
    return ""


def following_labels(name: str) -> tuple[str, ...]:
    """Return the labels of signals that follow a setpoint, the likeliest first."""
    field = name.partition(".")[2]
    return _FOLLOWING_LABELS.get(field, (field,))


@cache
def _topic_titles() -> dict[str, str]:
    """Return the titles of all topics, in their order."""
    return {row.name: row.title for row in drone_signals()} | OTHER_TOPIC_TITLES


@cache
def vector_components() -> dict[str, str]:
    """Return the names of components of vectors, by TOPIC.FIELD."""
    return {
        f"{row.name}.{field.name}": field.components
        for row in drone_signals()
        for field in row.fields_for(ANY_DRONE)
    }


Catalog = dict[str, list[tuple[str, str, str, str]]]
"""Name, SI unit, description and name in its log of the signals of each topic."""


def make_catalog(
    units: Mapping[str, str], topics: Iterable[Topic], sources: Mapping[str, str] | None = None
) -> Catalog:
    """Return all signals by topic, in the order of the topic.

    Args:
        units: SI unit of every signal, by name.
        topics: known topics; signals may belong to others, too.
        sources: what signals are called in the log of another program, by name.
    """
    sources = sources or {}
    known = _field_descriptions(topics) | {each.name: each.help for each in DERIVED_SIGNALS}
    groups: Catalog = {}
    for name, unit in units.items():
        topic, _, field = name.partition(".")
        whole = f"{topic}.{field.partition('.')[0]}"
        help, source = known.get(name, known.get(whole, "")), sources.get(name, "")
        groups.setdefault(topic, []).append((name, unit, help, source))
    return dict(sorted(groups.items(), key=lambda item: _rank(item[0])))


def topic_title(topic: str) -> str:
    """Return the name of a topic in words."""
    return _topic_titles().get(topic, plain_name(topic.replace("_", " ").capitalize()))


def _rank(topic: str) -> tuple[int, str]:
    order = list(_topic_titles())
    return (order.index(topic) if topic in order else len(order), topic)


def _field_descriptions(topics: Iterable[Topic]) -> dict[str, str]:
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
