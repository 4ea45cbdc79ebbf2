"""Names of signals, of what a log calls otherwise."""

import re

PLAIN = re.compile(r"[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*|\.\d+)+")
"""Of a signal: TOPIC.FIELD, in which a field's parts and places in arrays stand behind dots."""
_ARRAY = re.compile(r"(.*)\[(\d+)\]")


def own_name(topic: str, field: str) -> str:
    """Return the name of what has none of the workbench's: the log's own, in lower case.

    Args:
        topic: of the log, as "vehicle_status".
        field: of the topic; "output[3]" is place 3 of an array.
    """
    array = _ARRAY.fullmatch(field)
    place = f".{int(array[2])}" if array else ""
    return f"{_plain(topic)}.{_plain(array[1] if array else field)}{place}"


def _plain(text: str) -> str:
    """Return a text as a part of a name."""
    plain = re.sub(r"[^a-z0-9_]+", "_", text.lower()).strip("_")
    return plain if re.match(r"[a-z]", plain) else f"n_{plain}"
