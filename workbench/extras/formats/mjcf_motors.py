"""Read the actuators of an MJCF file that push or turn a site of the drone."""

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_compiler import Compiler
from workbench.extras.formats.mjcf_defaults import servo_of
from workbench.extras.formats.mjcf_document import MjcfDocument
from workbench.extras.formats.mjcf_elements import (
    attribute_fault,
    elements,
    elements_of,
    keyword_attribute,
    padded_numbers,
)
from workbench.extras.formats.mjcf_limits import stated_limits
from workbench.plant.formats.values import (
    attribute_number,
    attribute_numbers,
    listed_names,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.model import DeclaredActuator
from workbench.plant.servo import Servo

SitePoses = Mapping[str, tuple[str, RigidTransform]]
"""Link and pose in it of the sites, by name."""
_SERVO_TAGS = ("general", "motor", "position", "velocity", "intvelocity")
"""Actuators that can drive a joint."""
_FILTER_DYNTYPES = ("filter", "filterexact")
_ACTUATOR_ADVICE = (
    "the workbench knows actuators whose force is gain times control plus bias, with a filter of "
    "first order or without: write it as a <motor>"
)


def read_actuators(
    document: MjcfDocument, sites: SitePoses, kinds: Mapping[str, str]
) -> Iterator[DeclaredActuator]:
    """Yield the actuators that apply a force or moment at a site of the drone, in MuJoCo's order.

    An actuator at a site that `<replicate>` copied is copied too.

    Args:
        document: with the actuators.
        sites: of the drone.
        kinds: of the joints' freedoms, by name; `joint_servos` reads what drives them.

    Raises:
        WorkbenchError: for an actuator whose force cannot be had.
    """
    disabled = {
        group
        for option in elements(document.root, "option")
        for group in attribute_numbers(option, "actuatorgroupdisable", "")
    }
    found: list[tuple[str, str, Element]] = []
    for index, child in enumerate(elements_of(document.root, "actuator")):
        element = document.defaults.applied(child, "")
        name = element.get("name") or f"actuator_{index}"
        site = element.get("site", "")
        joint = actuated_joint(element)
        driven = {kinds.get(joint + copy, "") for copy in document.suffixes("joint", joint)} - {""}
        if not site and driven - {"ball"}:
            continue  # see `joint_servos`
        if not site:
            text = (
                "its joint is a ball, which no servo drives; not used"
                if driven
                else f"a <{shortened_text(child.tag)}> that does not push a site of the drone; "
                "not used"
            )
            document.remarks.add(
                "ignored", document.path, f"actuator '{shortened_text(name)}'", text
            )
            continue
        if attribute_number(element, "group", "0") in disabled:
            raise attribute_fault(
                element, "group", "<option actuatorgroupdisable> switches it off: enable it"
            )
        found += [(suffix, name, element) for suffix in document.suffixes("site", site)]
    for suffix, name, element in sorted(found, key=lambda each: each[0]):
        site = element.get("site", "") + suffix
        yield _actuator(element, name + suffix, site, document.compiler, sites)


def _actuator(
    element: Element, name: str, site: str, compiler: Compiler, sites: SitePoses
) -> DeclaredActuator:
    """Return one actuator."""
    what = f"{element_location(element)}: actuator '{shortened_text(name)}'"
    if site not in sites:
        raise WorkbenchError(
            f"{what} is at the site '{shortened_text(site)}', which the drone "
            f"does not have: sites are {listed_names(list(sites))}"
        )
    if "refsite" in element.attrib:
        raise attribute_fault(element, "refsite", "a rotor pushes along its own site: leave it out")
    servo = servo_of(element)
    if element.tag not in ("motor", "general") or servo:
        raise WorkbenchError(f"{what} is a <{servo or element.tag}>: {_ACTUATOR_ADVICE}")
    least, most = _force_range_over_gear(element, compiler)
    gear = padded_numbers(element, "gear", "1", 6)
    link, X_LS = sites[site]
    return DeclaredActuator(
        name=name,
        link=link,
        X_LS=X_LS,
        force_S=(gear[0], gear[1], gear[2]),
        moment_S=(gear[3], gear[4], gear[5]),
        least=least,
        most=most,
        time_constant=_filter_time_constant(element),
    )


def _force_range_over_gear(element: Element, compiler: Compiler) -> tuple[float, float]:
    """Return the least and the largest force over gear, infinite without limits."""
    kind = element.get("dyntype", "none")
    if kind not in ("none", *_FILTER_DYNTYPES) or attribute_number(element, "actdim", "-1") > 1.0:
        raise attribute_fault(element, "dyntype", _ACTUATOR_ADVICE)
    gain = padded_numbers(element, "gainprm", "1", 3)
    if keyword_attribute(element, "gaintype", "fixed", "fixed affine muscle user dcmotor") not in (
        "fixed",
        "affine",
    ) or (element.get("gaintype") == "affine" and any(gain[1:3])):
        raise attribute_fault(element, "gaintype", _ACTUATOR_ADVICE)
    bias = padded_numbers(element, "biasprm", "0", 3)
    if element.get("biastype", "none") == "none":
        bias = [0.0] * 3
    elif element.get("biastype") != "affine" or any(bias[1:3]):
        raise attribute_fault(element, "biastype", _ACTUATOR_ADVICE)
    if gain[0] == 0.0:
        raise attribute_fault(element, "gainprm", "its control has no effect: give it a gain")
    low, high = stated_limits(element, "ctrl", compiler)
    if kind in _FILTER_DYNTYPES:
        inner = stated_limits(element, "act", compiler)
        low, high = max(low, inner[0]), min(high, inner[1])
    ends = sorted(gain[0] * end + bias[0] for end in (low, high))
    force = stated_limits(element, "force", compiler)
    least, most = (min(max(end, force[0]), force[1]) for end in ends)
    return least, most


def _filter_time_constant(element: Element) -> float | None:
    """Return the time constant of an actuator with a first-order filter [s], None without."""
    if element.get("dyntype") not in _FILTER_DYNTYPES:
        return None
    value = attribute_numbers(element, "dynprm", "1")[0]
    return value if value > 0.0 else None


class DrivenJoint(NamedTuple):
    """A joint that an actuator drives.

    Attributes:
        name: of the joint.
        servo: what the actuator is to it, None if its force is not that of a servo.
        armature: inertia that the actuator adds to it [kg m² or kg].
        damping: that the actuator adds to it [N m s/rad or N s/m].
    """

    name: str
    servo: Servo | None
    armature: float
    damping: float


def actuated_joint(element: Element) -> str:
    """Return the joint that an actuator drives, "" for none."""
    return element.get("joint", "") or element.get("jointinparent", "")


def joint_servos(document: MjcfDocument, kinds: Mapping[str, str]) -> Iterator[DrivenJoint]:
    """Yield each joint that an actuator drives.

    MuJoCo's force is f = gain u + b0 + b1 l + b2 dl/dt for the control u and the length l, which is
    gear times the position of the joint, on which gear times f acts. So with b1 the servo is one of
    position, with b2 alone one of velocity, else one of effort, and its setpoint is that of the
    joint: l / gear.

    Args:
        document: with the actuators.
        kinds: of the joints' freedoms, by name; no servo drives a ball.

    Raises:
        WorkbenchError: for an invalid number.
    """
    for index, child in enumerate(elements_of(document.root, "actuator")):
        element = document.defaults.applied(child, "")
        joint = actuated_joint(element)
        joints = [joint + copy for copy in document.suffixes("joint", joint)]
        if all(kinds.get(each, "ball") == "ball" for each in joints):
            continue  # see `read_actuators`
        kind = element.tag
        name = shortened_text(element.get("name") or f"actuator_{index}")
        if kind not in _SERVO_TAGS:
            text = f"a <{shortened_text(kind)}> on a joint; not used"
            document.remarks.add("ignored", document.path, f"actuator '{name}'", text)
            continue
        servo: Servo | None = _joint_servo(element, document.compiler)
        integrates = element.get("dyntype") == "integrator"
        if _has_other_force(element) or (integrates and servo and servo.kind != "position"):
            text = (
                "its force is not gain times control plus bias, with a filter of first order or "
                "without; not used"
            )
            document.remarks.add("ignored", document.path, f"actuator '{name}'", text)
            servo = None
        elif integrates:
            text = "it takes a position in place of a velocity"
            document.remarks.add("assumed", document.path, f"actuator '{name}'", text)
        square = attribute_numbers(element, "gear", "1")[0] ** 2
        armature, damping = (
            square * attribute_numbers(element, word, "0")[0] for word in ("armature", "damping")
        )
        for each in joints:
            yield DrivenJoint(each, servo, armature, damping)


def _has_other_force(element: Element) -> bool:
    """Return whether the force of an actuator is another one than `joint_servos` says."""
    affine = element.get("gaintype") == "affine" and any(
        padded_numbers(element, "gainprm", "1", 3)[1:3]
    )
    return (
        affine
        or servo_of(element) not in ("", *_SERVO_TAGS)
        or element.get("gaintype", "fixed") not in ("fixed", "affine")
        or element.get("biastype", "none") not in ("none", "affine")
        or element.get("dyntype", "none") not in ("none", "integrator", *_FILTER_DYNTYPES)
    )


def _joint_servo(element: Element, compiler: Compiler) -> Servo:
    """Return the servo of one actuator of a joint."""
    gear = attribute_numbers(element, "gear", "1")[0]
    gain, bias = 1.0, [0.0] * 3
    ratio: float | None = None
    match servo_of(element):  # its own kind, or that of its default class
        case "position" | "intvelocity":
            gain = attribute_numbers(element, "kp", "1")[0]
            bias = [0.0, -gain, -attribute_numbers(element, "kv", "0")[0]]
            if "dampratio" in element.attrib:
                ratio = attribute_numbers(element, "dampratio", "0")[0]
        case "velocity":
            gain = attribute_numbers(element, "kv", "1")[0]
            bias = [0.0, 0.0, -gain]
    if element.tag == "general":
        gain = attribute_numbers(element, "gainprm", str(gain))[0]
        stated = attribute_numbers(element, "biasprm", "0")
        bias = [*stated, *bias[len(stated) :]][:3]
        if element.get("biastype", "none") == "none":
            bias, ratio = [0.0] * 3, None
    stiffness, damping = -bias[1] * gear**2, -bias[2] * gear**2
    drive = "position" if bias[1] else "velocity" if bias[2] else "effort"
    scale, offset = gear * gain, gear * bias[0]
    if drive != "effort":  # of the setpoint; a gear may turn the other way
        over = stiffness if drive == "position" else damping
        scale, offset = (scale / over, offset / over) if over else (0.0, 0.0)
    word = "act" if element.get("dyntype") == "integrator" else "ctrl"
    lower, upper = sorted(scale * end + offset for end in stated_limits(element, word, compiler))
    force = stated_limits(element, "force", compiler)
    if not math.isfinite(lower + upper) or not lower < upper:
        lower, upper = -math.inf, math.inf
    return Servo(
        kind=drive,
        stiffness=stiffness,
        damping=damping if ratio is None else None,
        damping_ratio=1.0 if ratio is None else ratio,
        lower=lower,
        upper=upper,
        start=offset,
        max_effort=abs(gear) * max(map(abs, force)),
        time_constant=_filter_time_constant(element) or 0.0,
    )
