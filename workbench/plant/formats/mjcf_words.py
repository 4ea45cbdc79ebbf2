"""What an MJCF file may say: elements and attributes that are read, others that do not matter.

The schema is that of MuJoCo 4.0 (`mj_printSchema`), with settings of older versions. Whatever it
lacks is refused, as by MuJoCo: it might decide mass, inertia or thrust.
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.mjcf_document import ACTUATORS, elements, fault
from workbench.plant.formats.values import numbers, shortened
from workbench.plant.formats.xml import Element, place
from workbench.plant.remarks import Remarks

_MOST = 50
"""Largest number of remarks on unused parts."""
_POSE = "pos quat axisangle xyaxes zaxis euler"
_CONTACT = (
    "condim friction gap margin priority solimp solmix solref surfacevel adhesion castshadow user"
)


@dataclass(frozen=True)
class Words:
    """The attributes of an element.

    Attributes:
        read: those that are read, or have no effect on a flight and need no remark.
        unused: those without effect on mass, inertia and thrust; a remark lists them.
        neutral: those that have one unless they have this value, and are then refused.
    """

    read: str
    unused: str = ""
    neutral: tuple[tuple[str, str], ...] = ()


_ACTUATOR = Words(
    "name class site gear ctrlrange ctrllimited forcerange forcelimited group joint body tendon "
    "jointinparent cranksite slidersite cranklength refsite lengthrange inheritrange",
    "actearly delay interp nsample user armature damping",
)
_GENERAL = Words(
    f"{_ACTUATOR.read} dyntype dynprm gainprm gaintype biastype biasprm actlimited actrange actdim",
    _ACTUATOR.unused,
    (("input", ""), ("velrange", ""), ("ffrange", "")),
)
_BODY = Words(
    f"name class childclass {_POSE}",
    "user sleep simple fuse",
    (("gravcomp", "0"), ("mocap", "false")),
)
WORDS = {
    "compiler": Words(
        "angle eulerseq meshdir assetdir texturedir strippath autolimits inertiafromgeom "
        "inertiagrouprange boundmass boundinertia balanceinertia settotalmass exactmeshinertia "
        "fitaabb coordinate",
        "alignfree conflict discardvisual fusestatic passthrough savecanonical savecompiled "
        "saveinertial usethread convexhull",
    ),
    "flag": Words(
        "",
        "autoreset constraint contact damper diagexact energy equality eulerdamp filterparent "
        "frictionloss fwdinv gravity invdiscrete ipc island limit midphase multiccd nativeccd "
        "override passive refsafe sensor sensornoise sleep speculative spring warmstart",
        (("actuation", "enable"), ("clampctrl", "enable")),
    ),
    "body": _BODY,
    "frame": _BODY,
    "inertial": Words(f"{_POSE} mass diaginertia fullinertia"),
    "joint": Words(
        "name class type pos axis group range limited armature",
        "actuatorfrclimited actuatorfrcrange actuatorgravcomp damping frictionloss margin ref "
        "solimpfriction solimplimit solreffriction solreflimit springdamper springref springyield "
        "stiffness user",
    ),
    "freejoint": Words("name group align"),
    "geom": Words(
        f"name class {_POSE} type size fromto mesh rgba material group contype conaffinity mass "
        "density shellinertia fitscale hfield",
        f"{_CONTACT} fluidshape fluidcoef",
    ),
    "site": Words(f"name class {_POSE} type size rgba material group fromto mesh", "user"),
    "mesh": Words(
        "name class file scale inertia refpos refquat vertex face builtin params maxhullvert "
        "content_type material",
        "normal texcoord smoothnormal",
    ),
    "material": Words(
        "name class rgba",
        "emission metallic reflectance roughness shininess specular texrepeat texture texuniform",
    ),
    "motor": _ACTUATOR,
    "general": _GENERAL,
}
"""Attributes by element. Those of elements that are not here are not looked at."""
_INSIDE = "body frame inertial joint freejoint geom site"
_UNUSED_INSIDE = "camera light"
_USED = {
    "mujoco": "compiler option default asset worldbody actuator",
    "compiler": "",
    "option": "flag",
    "asset": "mesh material",
    "body": _INSIDE,
    "frame": _INSIDE,
    "worldbody": _INSIDE,
    "actuator": " ".join(ACTUATORS),
    "default": f"default mesh material joint geom site {' '.join(ACTUATORS)}",
    "geom": "",
    "mesh": "",
}
"""Children that are read, by parent."""
_UNUSED = {
    "mujoco": "size statistic visual extension deformable contact tendon equality sensor custom "
    "keyframe",
    "compiler": "lengthrange",
    "asset": "texture hfield skin model",
    "body": _UNUSED_INSIDE,
    "frame": _UNUSED_INSIDE,
    "worldbody": _UNUSED_INSIDE,
    "default": "texture camera light pair equality tendon",
}
"""Children without effect on mass, inertia and thrust, by parent; a remark lists them."""
_WHY = {
    "option": "gravity, air and integrator are those of the workbench",
    "sensor": "sensors are added as docs/sensors.md says",
    "keyframe": "a scenario says how a flight begins",
    "contact": "friction and stiffness of the ground are those of the workbench",
    "camera": "cameras are not drawn",
    "light": "lights are not drawn",
    "visual": "pictures are those of the workbench",
    "statistic": "pictures are those of the workbench",
    "texture": "only colours are drawn",
    "equality": "the drone is one rigid body",
    "tendon": "the drone is one rigid body",
    "deformable": "the drone is one rigid body",
}
_WHY_NOT = {
    "gravcomp": "it carries a share of the weight, which the workbench has not: leave it out",
    "mocap": "a body that is moved by motion capture does not fly: leave it out",
    "actuation": "it switches all actuators off: leave it out",
    "clampctrl": "without the limits of controls a rotor has no largest thrust: leave it out",
    "input": "the workbench knows only the sum of gain times control and bias: leave it out",
    "attach": "it adds bodies of another file: write them here, or <include> them",
    "composite": "it adds bodies: write them as <body> elements",
    "flexcomp": "it adds bodies: write them as <body> elements",
    "plugin": "what a plugin adds is not known: give the body an <inertial>, and its rotors "
    "<motor> elements",
}


def check_words(path: Path, root: Element, drone: Element, remarks: Remarks) -> None:
    """Add remarks on what is not read, and refuse what may decide mass, inertia or thrust.

    Other bodies of the world are not looked at.

    Args:
        path: of the file.
        root: of the document, without includes and `<replicate>`.
        drone: the free body in it.
        remarks: receives one for each name that is not read.

    Raises:
        WorkbenchError: for an element or attribute that MuJoCo does not have, or whose effect on
            mass, inertia or thrust is not read.
    """
    found: Counter[tuple[str, str]] = Counter()
    for section in elements(root):
        if not _is_read(root, section, found):
            continue
        if section.tag == "worldbody":
            for child in elements(section, *_UNUSED_INSIDE.split()):
                _is_read(section, child, found)
        else:
            _check(section, found)
    _check(drone, found)
    for (what, why), times in list(found.items())[:_MOST]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"{why}; not used{often}")


def _check(element: Element, found: Counter[tuple[str, str]]) -> None:
    """Check an element and its descendants."""
    _check_attributes(element, found)
    for child in elements(element):
        if element.tag not in _USED or _is_read(element, child, found):
            _check(child, found)


def _is_read(parent: Element, child: Element, found: Counter[tuple[str, str]]) -> bool:
    """Return whether a child is read; count it if it is not."""
    if child.tag in _USED[parent.tag].split():
        return True
    if child.tag not in _UNUSED.get(parent.tag, "").split():
        why = _WHY_NOT.get(child.tag, "it is not known, and might decide mass, inertia or thrust")
        raise WorkbenchError(f"{place(child)}: <{shortened(child.tag)}> in <{parent.tag}>: {why}")
    if len(child) or child.attrib:
        found[f"element <{child.tag}>", _WHY.get(child.tag, "it does not matter here")] += 1
    return False


def _check_attributes(element: Element, found: Counter[tuple[str, str]]) -> None:
    """Check the attributes of one element."""
    tag = element.tag
    if tag == "option":
        if element.attrib:
            names = " ".join(sorted(element.attrib))
            found[f"element <option> ({shortened(names)})", _WHY["option"]] += 1
        return
    words = WORDS.get(tag)
    if words is None:
        return
    neutral = dict(words.neutral)
    for name, text in element.attrib.items():
        if name in words.unused.split():
            found[f"attribute {name} of <{tag}>", "not read"] += 1
        elif name in neutral:
            if not _equal(element, name, neutral[name]):
                raise fault(element, name, _WHY_NOT.get(name, _WHY_NOT["input"]))
        elif name not in words.read.split():
            raise WorkbenchError(
                f"{place(element)}: <{tag} {shortened(name)}='{shortened(text)}'>: MuJoCo has no "
                "such attribute, or a version after 4.0: leave it out, or correct its name"
            )


def _equal(element: Element, name: str, value: str) -> bool:
    """Return whether an attribute has a value, as a number or a word."""
    text = element.get(name, "").strip()
    return text == value or (value == "0" and set(numbers(element, name, "0")) == {0.0})
