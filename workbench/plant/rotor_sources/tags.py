"""Common parts of the readers of rotors in plugins: turning directions, unused tags, limits."""

import re
from collections.abc import Container
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.block import MAX_POSITIVE_VALUE, MIN_POSITIVE_VALUE, XmlBlock
from workbench.plant.formats.values import shortened_text
from workbench.plant.remarks import Remarks

MIN_MOTOR_CONSTANT, MAX_MOTOR_CONSTANT = MIN_POSITIVE_VALUE, MAX_POSITIVE_VALUE
"""Limits of the constants of a motor, in SI or per RPM."""
_COMMUNICATION_PATTERN = re.compile(r"(?i)topic|namespace|node_?name|frame_?id|channel|pub_?rate")
"""Pattern of tags about Gazebo's communication."""
_MAX_TAGS_LISTED = 10

ROTOR_DIRECTIONS = {"ccw": 1, "cw": -1}
MAX_DECLARED_ROTORS = 128


def turn_of(plugin: XmlBlock, tag: str) -> int:
    """Return the turning direction in a child of a plugin, 1 for ccw and -1 for cw.

    Raises:
        WorkbenchError: if it is missing or invalid.
    """
    value = plugin.required(tag)
    if value not in ROTOR_DIRECTIONS:
        raise plugin.fault(tag, "use cw or ccw")
    return ROTOR_DIRECTIONS[value]


def note_unused(plugin: XmlBlock, used: Container[str], element: str, remarks: Remarks) -> None:
    """Add a remark on children that are neither used nor about Gazebo's communication.

    Args:
        plugin: the plugin.
        used: names of the used children.
        element: for the remark.
        remarks: receives the remark.
    """
    unused = [
        f"<{shortened_text(str(child.tag))}>{shortened_text(child.text or '')}"
        for child in plugin.element
        if isinstance(child.tag, str)
        and child.tag not in used
        and not _COMMUNICATION_PATTERN.search(child.tag)
    ]
    if unused:
        text = f"{', '.join(unused[:_MAX_TAGS_LISTED])}: not known here; not used"
        remarks.add("ignored", plugin.file, element, text)


def refuse_too_many_rotors(file: Path, number: int) -> None:
    """Reject more rotors than any multirotor has.

    Raises:
        WorkbenchError: for more than `MAX_DECLARED_ROTORS`.
    """
    if number > MAX_DECLARED_ROTORS:
        raise WorkbenchError(
            f"{file}: it declares {number} rotors: only up to {MAX_DECLARED_ROTORS} are read"
        )
