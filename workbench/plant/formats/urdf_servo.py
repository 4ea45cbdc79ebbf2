"""The servo of a joint in a URDF: an element `<servo>`, which is our own."""

import math
from xml.etree import ElementTree as ET

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import attribute_number
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.servo import SERVO_KINDS, Servo

_NUMBERS = (
    "stiffness",
    "damping",
    "damping_ratio",
    "lower",
    "upper",
    "start",
    "max_effort",
    "max_rate",
    "time_constant",
    "delay",
)


def read_servo(joint: Element) -> Servo | None:
    """Return the servo of a joint, None without one.

    Raises:
        WorkbenchError: naming the element, for an invalid number or kind.
    """
    element = joint.find("servo")
    if not isinstance(element, Element):
        return None
    kind = element.get("kind", "position")
    if kind not in SERVO_KINDS:
        raise WorkbenchError(
            f"{element_location(element)}: <servo> has another kind than {', '.join(SERVO_KINDS)}: "
            "give it one of them"
        )
    found = Servo(
        kind,
        **{name: attribute_number(element, name) for name in _NUMBERS if name in element.attrib},
    )
    if min(found.stiffness or 0.0, found.damping or 0.0, found.damping_ratio) < 0.0 or (
        found.lower > found.upper
    ):
        raise WorkbenchError(
            f"{element_location(element)}: <servo> has a negative gain, or lower above upper: "
            "correct it"
        )
    return found


def add_servo(joint: ET.Element, servo: Servo) -> None:
    """Add a servo to an element of a joint."""
    plain = Servo()
    values = {"kind": servo.kind}
    for name in _NUMBERS:
        value = getattr(servo, name)
        if value is not None and math.isfinite(value) and value != getattr(plain, name):
            values[name] = repr(value)
    ET.SubElement(joint, "servo", values)
