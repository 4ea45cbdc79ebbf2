"""Elements that only Drake's parsers read, in URDF and SDF, and that are not used here."""

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element, element_location

_DRAKE_PREFIX = "drake:"
_FORCE_ELEMENTS = ("linear_bushing_rpy", "linear_spring_damper")
_REASONS = {
    "accepting_renderer": "pictures are those of the workbench",
    "collision_filter_group": "links of a drone do not touch each other",
    "controller_gains": "gains of servos are those of the sidecar",
    "declare_convex": "",  # every mesh is taken as convex
    "diffuse_map": "only colours are drawn",
    "illustration_properties": "pictures are those of the workbench",
    "perception_properties": "pictures are those of the workbench",
    "proximity_properties": "friction and stiffness of the ground are those of the workbench",
}
"""Why an element is not used; without a reason it means nothing here."""


def unused_drake_element(element: Element) -> str:
    """Return why an element of Drake is not used, "" for another one, or one without an effect.

    Raises:
        WorkbenchError: with file and line, for a force between bodies, or a constraint.
    """
    if not element.tag.startswith(_DRAKE_PREFIX):
        return ""
    name = element.tag.removeprefix(_DRAKE_PREFIX)
    what = f"{element_location(element)}: <{shortened_text(element.tag)}>"
    if name in _FORCE_ELEMENTS:
        raise WorkbenchError(
            f"{what} is a force between two bodies, which does not fly: leave it out, or give "
            "their joint a spring and damping"
        )
    if name.endswith("_constraint"):
        raise WorkbenchError(
            f"{what} closes a loop of bodies, which does not fly: leave it out, or use a <mimic>, "
            "or a <cable> in a URDF"
        )
    return _REASONS.get(name, "Drake's")
