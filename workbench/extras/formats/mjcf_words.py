"""What an MJCF file may say: elements and attributes that are read, others that do not matter.

The schema is that of MuJoCo 4.0 (`mj_printSchema`), with settings of older versions. Whatever it
lacks is refused, as by MuJoCo: it might decide mass, inertia or thrust.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_defaults import ACTUATOR_TAGS
from workbench.extras.formats.mjcf_elements import attribute_fault, elements
from workbench.plant.formats.values import attribute_numbers, shortened_text
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.remarks import Remarks

_MAX_UNUSED_REMARKS = 50
"""Largest number of remarks on unused parts."""
_POSE_ATTRIBUTES = "pos quat axisangle xyaxes zaxis euler"
_CONTACT_ATTRIBUTES = (
    "condim friction gap margin priority solimp solmix solref surfacevel adhesion castshadow user"
)


@dataclass(frozen=True)
class MjcfAttributes:
    """The attributes of an element.

    Attributes:
        read: those that are read, or have no effect on a flight and need no remark.
        unused: those without effect on mass, inertia and thrust; a remark lists them.
        neutral: those that have one unless they have this value, and are then refused.
    """

    read: str
    unused: str = ""
    neutral: tuple[tuple[str, str], ...] = ()


_ACTUATOR_ATTRIBUTES = MjcfAttributes(
    "name class site gear ctrlrange ctrllimited forcerange forcelimited group joint body tendon "
    "jointinparent cranksite slidersite cranklength refsite lengthrange inheritrange armature "
    "damping",
    "actearly delay interp nsample user",
)
_GENERAL_ATTRIBUTES = MjcfAttributes(
    f"{_ACTUATOR_ATTRIBUTES.read} dyntype dynprm gainprm gaintype biastype biasprm actlimited "
    "actrange actdim",
    _ACTUATOR_ATTRIBUTES.unused,
    (("input", ""), ("velrange", ""), ("ffrange", "")),
)
_BODY_ATTRIBUTES = MjcfAttributes(
    f"name class childclass {_POSE_ATTRIBUTES}",
    "user sleep simple fuse",
    (("gravcomp", "0"), ("mocap", "false")),
)
MJCF_ATTRIBUTES = {
    "compiler": MjcfAttributes(
        "angle eulerseq meshdir assetdir texturedir strippath autolimits inertiafromgeom "
        "inertiagrouprange boundmass boundinertia balanceinertia settotalmass exactmeshinertia "
        "fitaabb coordinate",
        "alignfree conflict discardvisual fusestatic passthrough savecanonical savecompiled "
        "saveinertial usethread convexhull",
    ),
    "flag": MjcfAttributes(
        "",
        "autoreset constraint contact diagexact energy equality eulerdamp filterparent "
        "frictionloss fwdinv invdiscrete ipc island limit midphase multiccd nativeccd override "
        "passive refsafe sensor sensornoise sleep speculative warmstart",
        tuple(
            (name, "enable") for name in ("actuation", "clampctrl", "damper", "gravity", "spring")
        ),
    ),
    "body": _BODY_ATTRIBUTES,
    "frame": _BODY_ATTRIBUTES,
    "inertial": MjcfAttributes(f"{_POSE_ATTRIBUTES} mass diaginertia fullinertia"),
    "joint": MjcfAttributes(
        "name class type pos axis group range limited armature damping frictionloss ref springref "
        "stiffness actuatorfrclimited actuatorfrcrange",
        "actuatorgravcomp margin solimpfriction solimplimit "
        "solreffriction solreflimit springyield user",
        (("springdamper", "0"),),
    ),
    "freejoint": MjcfAttributes("name group align"),
    "geom": MjcfAttributes(
        f"name class {_POSE_ATTRIBUTES} type size fromto mesh rgba material group contype "
        "conaffinity mass "
        "density shellinertia fitscale hfield",
        f"{_CONTACT_ATTRIBUTES} fluidshape fluidcoef",
    ),
    "site": MjcfAttributes(
        f"name class {_POSE_ATTRIBUTES} type size rgba material group fromto mesh", "user"
    ),
    "mesh": MjcfAttributes(
        "name class file scale inertia refpos refquat vertex face builtin params maxhullvert "
        "content_type material",
        "normal texcoord smoothnormal",
    ),
    "material": MjcfAttributes(
        "name class rgba",
        "emission metallic reflectance roughness shininess specular texrepeat texture texuniform",
    ),
    "motor": _ACTUATOR_ATTRIBUTES,
    "general": _GENERAL_ATTRIBUTES,
}
"""Attributes by element. Those of elements that are not here are not looked at."""
_BODY_CHILDREN_READ = "body frame inertial joint freejoint geom site"
_BODY_CHILDREN_IGNORED = "camera light"
_MJCF_CHILDREN_READ = {
    "mujoco": "compiler option default asset worldbody actuator equality tendon",
    "tendon": "spatial",
    "spatial": "site geom pulley",
    "equality": "joint",
    "compiler": "",
    "option": "flag",
    "asset": "mesh material",
    "body": _BODY_CHILDREN_READ,
    "frame": _BODY_CHILDREN_READ,
    "worldbody": _BODY_CHILDREN_READ,
    "actuator": " ".join(ACTUATOR_TAGS),
    "default": f"default mesh material joint geom site tendon {' '.join(ACTUATOR_TAGS)}",
    "geom": "",
    "mesh": "",
}
"""Children that are read, by parent."""
_MJCF_CHILDREN_IGNORED = {
    "mujoco": "size statistic visual extension deformable contact sensor custom keyframe",
    "tendon": "fixed",
    "equality": "connect weld tendon flex flexvert flexstrain",
    "compiler": "lengthrange",
    "asset": "texture hfield skin model",
    "body": _BODY_CHILDREN_IGNORED,
    "frame": _BODY_CHILDREN_IGNORED,
    "worldbody": _BODY_CHILDREN_IGNORED,
    "default": "texture camera light pair equality",
}
"""Children without effect on mass, inertia and thrust, by parent; a remark lists them."""
_REASON_IGNORED = {
    "option": "gravity, air and integrator are those of the workbench",
    "sensor": "sensors are added as docs/sensors.md says",
    "keyframe": "a scenario says how a flight begins",
    "contact": "friction and stiffness of the ground are those of the workbench",
    "camera": "cameras are not drawn",
    "light": "lights are not drawn",
    "visual": "pictures are those of the workbench",
    "statistic": "pictures are those of the workbench",
    "texture": "only colours are drawn",
    "equality": "only equalities of joints are flown",
    "connect": "it closes no loop between bodies that move",
    "weld": "it closes no loop between bodies that move",
    "tendon": "only equalities of joints are flown",
    "fixed": "its own springs and limits do not act",
    "deformable": "the drone is one rigid body",
}
_REASON_REFUSED = {
    "gravcomp": "it carries a share of the weight, which the workbench has not: leave it out",
    "mocap": "a body that is moved by motion capture does not fly: leave it out",
    "actuation": "it switches all actuators off: leave it out",
    "clampctrl": "without the limits of controls a rotor has no largest thrust: leave it out",
    "damper": "dampings would not act: leave it out, or the dampings of joints and tendons",
    "gravity": "nothing would have a weight: leave it out",
    "spring": "springs would not act: leave it out, or the stiffnesses of joints and tendons",
    "input": "the workbench knows only the sum of gain times control and bias: leave it out",
    "springdamper": "its spring would depend on all inertia that it moves: give it stiffness and "
    "damping",
    "attach": "it adds bodies of another file: write them here, or <include> them",
    "composite": "it adds bodies: write them as <body> elements",
    "flexcomp": "it adds bodies: write them as <body> elements",
    "plugin": "what a plugin adds is not known: give the body an <inertial>, and its rotors "
    "<motor> elements",
}


def check_mjcf_attributes(
    path: Path,
    root: Element,
    flying: Sequence[Element],
    remarks: Remarks,
    held: Sequence[Element] = (),
) -> None:
    """Add remarks on what is not read, and refuse what may decide mass, inertia or thrust.

    Other bodies of the world are not looked at.

    Args:
        path: of the file.
        root: of the document, without includes and `<replicate>`.
        flying: the free bodies in it that are read.
        remarks: receives one for each name that is not read.
        held: the equalities that hold loads, which are read.

    Raises:
        WorkbenchError: for an element or attribute that MuJoCo does not have, or whose effect on
            mass, inertia or thrust is not read.
    """
    found: Counter[tuple[str, str]] = Counter()
    for section in elements(root):
        if not _is_read(root, section, found):
            continue
        if section.tag == "worldbody":
            for child in elements(section, *_BODY_CHILDREN_IGNORED.split()):
                _is_read(section, child, found)
        elif section.tag in ("equality", "tendon"):  # whose <joint>, <site> are not a body's
            for child in elements(section):
                if child not in held:
                    _is_read(section, child, found)
        else:
            _check_element(section, found)
    for body in flying:
        _check_element(body, found)
    for (what, why), times in list(found.items())[:_MAX_UNUSED_REMARKS]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"{why}; not used{often}")


def _check_element(element: Element, found: Counter[tuple[str, str]]) -> None:
    """Check an element and its descendants."""
    _check_attributes(element, found)
    for child in elements(element):
        if element.tag not in _MJCF_CHILDREN_READ or _is_read(element, child, found):
            _check_element(child, found)


def _is_read(parent: Element, child: Element, found: Counter[tuple[str, str]]) -> bool:
    """Return whether a child is read; count it if it is not."""
    if child.tag in _MJCF_CHILDREN_READ[parent.tag].split():
        return True
    if child.tag not in _MJCF_CHILDREN_IGNORED.get(parent.tag, "").split():
        why = _REASON_REFUSED.get(
            child.tag, "it is not known, and might decide mass, inertia or thrust"
        )
        raise WorkbenchError(
            f"{element_location(child)}: <{shortened_text(child.tag)}> in <{parent.tag}>: {why}"
        )
    if len(child) or child.attrib:
        found[
            f"element <{child.tag}>", _REASON_IGNORED.get(child.tag, "it does not matter here")
        ] += 1
    return False


def _check_attributes(element: Element, found: Counter[tuple[str, str]]) -> None:
    """Check the attributes of one element."""
    tag = element.tag
    if tag == "option":
        if element.attrib:
            names = " ".join(sorted(element.attrib))
            found[f"element <option> ({shortened_text(names)})", _REASON_IGNORED["option"]] += 1
        return
    words = MJCF_ATTRIBUTES.get(tag)
    if words is None:
        return
    neutral = dict(words.neutral)
    for name, text in element.attrib.items():
        if name in words.unused.split():
            found[f"attribute {name} of <{tag}>", "not read"] += 1
        elif name in neutral:
            if not _has_value(element, name, neutral[name]):
                raise attribute_fault(
                    element, name, _REASON_REFUSED.get(name, _REASON_REFUSED["input"])
                )
        elif name not in words.read.split():
            raise WorkbenchError(
                f"{element_location(element)}: <{tag} "
                f"{shortened_text(name)}='{shortened_text(text)}'>: MuJoCo has no "
                "such attribute, or a version after 4.0: leave it out, or correct its name"
            )


def _has_value(element: Element, name: str, value: str) -> bool:
    """Return whether an attribute has a value, as a number or a word."""
    text = element.get(name, "").strip()
    return text == value or (value == "0" and set(attribute_numbers(element, name, "0")) == {0.0})
