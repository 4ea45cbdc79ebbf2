"""What MJCF has and no flight uses, to say it."""

from collections import Counter
from pathlib import Path

from workbench.plant.formats.mjcf_words import elements
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks

_FRAME = "name class pos quat axisangle xyaxes zaxis euler"
_USED = {
    "mujoco": "compiler default asset worldbody actuator",
    "worldbody": "body geom frame",
    "body": "body frame inertial joint freejoint geom site",
    "frame": "body frame inertial joint freejoint geom site",
    "asset": "mesh material",
}
"""Children that are read."""
_WORDS = {
    "compiler": "angle eulerseq meshdir assetdir texturedir autolimits inertiafromgeom",
    "body": f"{_FRAME} childclass",
    "frame": f"{_FRAME} childclass",
    "inertial": f"{_FRAME} mass diaginertia fullinertia",
    "joint": "name class type pos axis group range limited",
    "freejoint": "name group align",
    "geom": f"{_FRAME} type size fromto mass density mesh rgba material group contype conaffinity",
    "site": f"{_FRAME} type size rgba material group fromto",
    "mesh": "name class file scale",
    "material": "name class rgba",
    "motor": "name class site gear ctrlrange ctrllimited forcerange forcelimited group dyntype "
    "dynprm gainprm gaintype biastype joint body tendon",
}
"""Attributes that are read, or that say nothing of flight; those of other elements are not read."""
_WORDS["general"] = _WORDS["motor"]
_WHY = {
    "option": "gravity and air are the workbench's own, and so is the integrator",
    "sensor": "sensors are added as docs/sensors.md says",
    "keyframe": "a scenario says how a flight begins",
    "contact": "friction and stiffness of the ground are the workbench's own",
    "camera": "cameras are not drawn",
    "light": "lights are not drawn",
    "visual": "pictures are the workbench's own",
    "statistic": "pictures are the workbench's own",
    "texture": "colours alone are drawn",
}
_MOST = 50
"""Of such remarks; a stranger's file may have very many."""


def note_unused(path: Path, root: Element, remarks: Remarks) -> None:
    """Note elements and attributes that are not read, once for each name.

    What an element that is not read has in it is not looked at. Of defaults the words count like
    those of the elements that have them.
    """
    found: Counter[tuple[str, str]] = Counter()
    _count(root, found)
    for (what, why), times in list(found.items())[:_MOST]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"{why}; not used{often}")


def _count(element: Element, found: Counter[tuple[str, str]]) -> None:
    """Count what is not read of an element, and of those below it."""
    for child in elements(element):
        tag = child.tag
        known = _USED.get(element.tag)
        if known is not None and tag not in known.split():
            if len(child) or child.attrib:
                why = _WHY.get(tag, "not known here")
                words = " ".join(sorted(child.attrib)) if tag == "option" else ""
                found[f"element <{shortened(tag)}>{words and f' ({words})'}", why] += 1
            continue
        for name in child.attrib:
            if tag in _WORDS and name not in _WORDS[tag].split():
                found[f"attribute {shortened(name)} of <{tag}>", "not read"] += 1
        _count(child, found)
