"""Default classes of MJCF."""

from collections.abc import Mapping

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_elements import attribute_fault, elements
from workbench.extras.formats.mjcf_pose import ORIENTATION_SIZES
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element, element_location

ACTUATOR_TAGS = (
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "orientation",
    "pid",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
)
"""Elements of actuators."""
_ACTUATOR_DEFAULTS_KEY = "actuator"
"""Defaults of all kinds of actuators are of one object, as in MuJoCo."""
_TENDON_TAGS = ("spatial", "fixed")
_TENDON_DEFAULTS_TAG = "tendon"
"""Defaults of both kinds of tendons."""
_MAIN_CLASS = "main"
"""The default class of elements that name no other."""
_PARTIAL_ATTRIBUTES = ("size", "gear", "gainprm", "biasprm", "dynprm")
"""Attributes whose first numbers alone may be given; a default keeps the others."""
_SERVO_KIND_KEY = "-kind"
"""Mark of defaults that a kind other than a motor set; not a name that XML allows."""
_GAIN_ATTRIBUTES = (
    *("kp", "kv", "dampratio", "timeconst", "gainprm", "biasprm", "dynprm"),
    _SERVO_KIND_KEY,
)
_IMPLIED_TYPES = {
    "motor": ("fixed", "none", "none"),
    "position": ("fixed", "affine", "none"),
    "velocity": ("fixed", "affine", "none"),
    "intvelocity": ("fixed", "affine", "integrator"),
    "damper": ("affine", "none", "none"),
    "cylinder": ("fixed", "affine", "filter"),
    "muscle": ("muscle", "muscle", "muscle"),
    "adhesion": ("fixed", "none", "none"),
    "dcmotor": ("dcmotor", "dcmotor", "dcmotor"),
}
"""Types of gain, bias and dynamics by the kind of actuator."""


class Defaults:
    """The default attributes of elements, by class.

    Args:
        root: of the document.

    Raises:
        WorkbenchError: for a class that is defined twice, or a top-level one with a name of its
            own.
    """

    def __init__(self, root: Element) -> None:
        self._classes: dict[str, dict[str, dict[str, str]]] = {_MAIN_CLASS: {}}
        for element in elements(root, "default"):
            if element.get("class", _MAIN_CLASS) != _MAIN_CLASS:
                raise attribute_fault(
                    element, "class", "the class of a top-level <default> is main"
                )
            self._collect(element, _MAIN_CLASS, self._classes[_MAIN_CLASS])

    def _collect(self, element: Element, name: str, above: Mapping[str, Mapping[str, str]]) -> None:
        known = {tag: dict(words) for tag, words in above.items()}
        for child in elements(element):
            if child.tag == "default":
                continue
            tag = _ACTUATOR_DEFAULTS_KEY if child.tag in ACTUATOR_TAGS else child.tag
            merge = _merged_as_kind if child.tag in ACTUATOR_TAGS else _merged
            known[tag] = merge(known.get(tag, {}), child)
        self._classes[name] = known
        for child in elements(element, "default"):
            inner = child.get("class", "")
            if inner in self._classes or not inner:
                raise attribute_fault(child, "class", "give it a name that no other <default> has")
            self._collect(child, inner, known)

    def is_active(self, equality: Element) -> bool:
        """Return whether a constraint of `<equality>` acts from the beginning."""
        usual = self._classes.get(equality.get("class", _MAIN_CLASS), {}).get("equality", {})
        return equality.get("active", usual.get("active", "true")) != "false"

    def applied(self, element: Element, childclass: str) -> Element:
        """Return a copy of an element with the default attributes of its class.

        Args:
            element: its own attributes take precedence.
            childclass: default class in its body, "" for none.

        Raises:
            WorkbenchError: if its class does not exist.
        """
        name = element.get("class") or childclass or _MAIN_CLASS
        if name not in self._classes:
            raise WorkbenchError(
                f"{element_location(element)}: <{element.tag}> has the class "
                f"'{shortened_text(name)}', which no <default> defines: add it"
            )
        is_actuator = element.tag in ACTUATOR_TAGS
        tag = _ACTUATOR_DEFAULTS_KEY if is_actuator else element.tag
        known = self._classes[name].get(_TENDON_DEFAULTS_TAG if tag in _TENDON_TAGS else tag, {})
        return element.like((_merged_as_kind if is_actuator else _merged)(known, element))


def _merged(known: Mapping[str, str], element: Element) -> dict[str, str]:
    """Return default attributes with those of an element in their place."""
    words, own = dict(known), element.attrib
    if any(name in own for name in ORIENTATION_SIZES):
        for name in ORIENTATION_SIZES:
            words.pop(name, None)
    for name, text in own.items():
        if name in _PARTIAL_ATTRIBUTES and name in words:
            given = text.split()
            text = " ".join([*given, *words[name].split()[len(given) :]])
        words[name] = text
    return words


def _merged_as_kind(known: Mapping[str, str], element: Element) -> dict[str, str]:
    """Return the attributes of an actuator with what its kind implies (MuJoCo's mjs_setTo*).

    A kind other than general keeps gains of defaults of its own kind only.
    """
    if element.tag == "general":
        return _merged(known, element)
    if known.get(_SERVO_KIND_KEY) != element.tag:
        known = {name: text for name, text in known.items() if name not in _GAIN_ATTRIBUTES}
    words = _merged(known, element)
    gain, bias, dynamics = _IMPLIED_TYPES.get(element.tag, ("user", "user", "user"))
    words |= {"gaintype": gain, "biastype": bias, "dyntype": dynamics}
    if element.tag == "motor":
        return words | {"gainprm": "1"}
    if element.tag == "position" and "timeconst" in words:
        words |= {"dyntype": "filterexact", "dynprm": words["timeconst"]}
    return words | {_SERVO_KIND_KEY: element.tag}


def servo_of(element: Element) -> str:
    """Return the kind of actuator, other than motor and general, that set an actuator's gains."""
    return element.get(_SERVO_KIND_KEY, "")
