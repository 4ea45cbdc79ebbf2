"""Common parts of the readers of rotors in plugins: turning directions, unused tags, limits."""

import re
from collections.abc import Container
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.block import LARGEST_POSITIVE, SMALLEST_POSITIVE, Block
from workbench.plant.formats.values import shortened
from workbench.plant.remarks import Remarks

SMALLEST, LARGEST = SMALLEST_POSITIVE, LARGEST_POSITIVE
"""Limits of the constants of a motor, in SI or per RPM."""
_NOT_PHYSICAL = re.compile(r"(?i)topic|namespace|node_?name|frame_?id|channel|pub_?rate")
"""Pattern of tags about Gazebo's communication."""
_MOST_NAMED = 10

TURNS = {"ccw": 1, "cw": -1}
MOST_ROTORS = 128


def turn_of(plugin: Block, tag: str) -> int:
    """Return the turning direction in a child of a plugin, 1 for ccw and -1 for cw.

    Raises:
        WorkbenchError: if it is missing or invalid.
    """
    value = plugin.required(tag)
    if value not in TURNS:
        raise plugin.fault(tag, "use cw or ccw")
    return TURNS[value]


def note_unused(plugin: Block, used: Container[str], element: str, remarks: Remarks) -> None:
    """Add a remark on children that are neither used nor about Gazebo's communication.

    Args:
        plugin: the plugin.
        used: names of the used children.
        element: for the remark.
        remarks: receives the remark.
    """
    unused = [
        f"<{shortened(str(child.tag))}>{shortened(child.text or '')}"
        for child in plugin.element
        if isinstance(child.tag, str)
        and child.tag not in used
        and not _NOT_PHYSICAL.search(child.tag)
    ]
    if unused:
        text = f"{', '.join(unused[:_MOST_NAMED])}: not known here; not used"
        remarks.add("ignored", plugin.file, element, text)


def refuse_crowd(file: Path, number: int) -> None:
    """Reject more rotors than any multirotor has.

    Raises:
        WorkbenchError: for more than `MOST_ROTORS`.
    """
    if number > MOST_ROTORS:
        raise WorkbenchError(
            f"{file}: it declares {number} rotors: only up to {MOST_ROTORS} are read"
        )
