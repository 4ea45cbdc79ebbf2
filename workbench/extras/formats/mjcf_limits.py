"""Limits that attributes of MJCF state."""

import math

from workbench.extras.formats.mjcf_compiler import Compiler
from workbench.extras.formats.mjcf_elements import attribute_fault, keyword_attribute
from workbench.plant.formats.joint_limits import joint_limits
from workbench.plant.formats.values import attribute_numbers
from workbench.plant.formats.xml import Element


def stated_limits(element: Element, word: str, compiler: Compiler) -> tuple[float, float]:
    """Return the limits of a control, an activation or a force, infinite without any.

    Args:
        element: with its defaults.
        word: that its attributes `..range` and `..limited` begin with.
        compiler: settings of the document.
    """
    name = f"{word}range"
    limited = keyword_attribute(element, f"{word}limited", "auto", "auto true false")
    given = name in element.attrib
    if limited == "auto" and given and not compiler.autolimits:
        raise attribute_fault(
            element, name, f"without autolimits, MuJoCo asks for {word}limited: add it"
        )
    if limited == "false" or not (given or limited == "true"):
        return -math.inf, math.inf
    values = attribute_numbers(element, name, "0 0")
    if limited == "auto" and values == (0.0, 0.0):  # MuJoCo's default, which is none
        return -math.inf, math.inf
    if len(values) != 2 or values[1] <= values[0]:
        raise attribute_fault(element, name, "give it two numbers, the smaller first")
    return values[0], values[1]


def joint_range(element: Element, compiler: Compiler) -> tuple[float, float]:
    """Return the limits of a joint as the file has them, infinite without any.

    As in MuJoCo a range whose ends are equal, or the wrong way round, is none unless `limited`.
    """
    limited = keyword_attribute(element, "limited", "auto", "auto true false")
    values = attribute_numbers(element, "range", "0 0")
    if len(values) != 2:
        raise attribute_fault(element, "range", "give it two numbers, the smaller first")
    if limited == "false" or (limited == "auto" and values[0] >= values[1]):
        return -math.inf, math.inf
    if limited == "auto" and not compiler.autolimits:
        raise attribute_fault(element, "range", "without autolimits, MuJoCo asks for limited")
    return joint_limits(*values)
