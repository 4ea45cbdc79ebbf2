"""What Gazebo's DetachableJoint holds, as a load on six cables that hold it in place.

Three points around the centre of mass of the load hang on three points of the drone above them,
turned by 60 degrees, each on two cables. Its weight keeps all six taut, and they leave it no
freedom, as in a Stewart platform; a force across them slackens one only beyond 0.86 of the weight.
"""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.vectors import float_triple
from workbench.extras.formats.sdf_node import Node
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element
from workbench.plant.gathered import whole_inertial
from workbench.plant.model import FREE_FREEDOMS, FREE_JOINT_KIND, Cable, Joint, Model
from workbench.plant.remarks import Remarks

_DETACHABLE_CLASS, _DETACHABLE_FILE = "DetachableJoint", "detachable-joint-system"
_OWN_MODEL_NAME = "__model__"
_MIN_HOLD_RADIUS_M = 0.02
"""Least distance of the held points from the centre of mass: that of a point has no radius."""


def is_detachable_plugin(plugin: Element) -> bool:
    """Return whether a plugin is gz-sim's DetachableJoint, by its class or file."""
    name, file = plugin.get("name", "").strip(), plugin.get("filename", "")
    return name.endswith(f"::{_DETACHABLE_CLASS}") or _DETACHABLE_FILE in file


def held_models(plugins: Sequence[Node]) -> set[str]:
    """Return the names of the models that plugins hold when a flight begins."""
    return {
        plugin.text_of("child_model")
        for plugin in plugins
        if is_detachable_plugin(plugin.element) and _begins_attached(plugin.element)
    }


def with_detachable_loads(model: Model, remarks: Remarks) -> Model:
    """Return a model whose plugins' loads hang on it, dropped by `open_hooks`.

    Args:
        model: with the links of the loads; its plugins have full names of parent links.
        remarks: receives a remark on each plugin.
    """
    for number, plugin in enumerate(filter(is_detachable_plugin, model.plugins), start=1):
        what = f"DetachableJoint of '{shortened_text(_text(plugin, 'child_model'))}'"
        parent, child = _text(plugin, "parent_link"), _child_link(model, plugin)
        load = _joined(model, child)
        inertial = whole_inertial(
            [(each.X_ML, each.inertial) for each in model.links if each.name in load]
        )
        if not _begins_attached(plugin):
            why = "its <initial_attach> is false"
        elif not model.link(parent):
            why = f"there is no <parent_link> '{shortened_text(parent)}'"
        elif not child:
            why = f"there is no such link '{shortened_text(_text(plugin, 'child_link'))}'"
        elif parent in load:
            why = "joints hold it"
        elif inertial is None or inertial.mass <= 0.0:
            why = "it has no mass"
        else:
            held = model.link(child)
            assert held
            X_MJ = held.X_ML
            name = f"detachable_joint_{number}"
            joint = Joint(name, FREE_JOINT_KIND, parent, child, X_MJ, (0, 0, 1), FREE_FREEDOMS)
            centre = inertial.X_LI.translation()
            radius = 2.0 * math.sqrt(max(inertial.moments) / inertial.mass)
            cables = _holding_cables(model, joint, centre, max(radius, _MIN_HOLD_RADIUS_M))
            model = dataclasses.replace(
                model, joints=(*model.joints, joint), cables=(*model.cables, *cables)
            )
            text = "six cables hold its load in place; open_hooks drops it, with all other loads"
            remarks.add("assumed", plugin.file, what, text)
            continue
        remarks.add("ignored", plugin.file, what, f"{why}; nothing is attached or detached")
    others = tuple(each for each in model.plugins if not is_detachable_plugin(each))
    return dataclasses.replace(model, plugins=others)


def _text(plugin: Element, tag: str) -> str:
    return (plugin.findtext(tag) or "").strip()


def _begins_attached(plugin: Element) -> bool:
    return _text(plugin, "initial_attach").lower() not in ("0", "false")


def _child_link(model: Model, plugin: Element) -> str:
    """Return the full name of the link that a plugin holds, "" without one.

    As in Gazebo, the name of its model may be without the models around it.
    """
    scope = _text(plugin, "parent_link").rpartition("::")[0]
    owner, link = _text(plugin, "child_model"), _text(plugin, "child_link")
    if owner == _OWN_MODEL_NAME:
        owner = scope
    name = f"{owner}::{link}" if owner else link
    inside = [each.name for each in model.links if f"::{each.name}".endswith(f"::{name}")]
    return min(inside, key=lambda each: not each.startswith(scope), default="")


def _joined(model: Model, link: str) -> set[str]:
    """Return a link and all that joints connect with it."""
    found, size = {link}, 0
    while len(found) > size:
        size = len(found)
        for joint in model.joints:
            if not found.isdisjoint((joint.parent, joint.child)):
                found |= {joint.parent, joint.child}
    return found


def _holding_cables(model: Model, joint: Joint, centre: np.ndarray, radius: float) -> list[Cable]:
    """Return the cables that hold what hangs on a free joint.

    Args:
        model: with both links.
        joint: between them.
        centre: of mass of the load in M (3) [m].
        radius: of the points around its centre, and twice the height of those above [m].
    """
    parent, child = model.link(joint.parent), model.link(joint.child)
    assert parent and child

    def ring(turn: float, height: float) -> list[np.ndarray]:
        angles = turn + np.arange(3) * 2.0 * math.pi / 3.0
        return [centre + (radius * math.cos(a), radius * math.sin(a), height) for a in angles]

    upper, lower = ring(math.pi / 3.0, 0.5 * radius), ring(0.0, 0.0)
    return [
        Cable(
            f"{joint.name}_cable_{2 * i + side + 1}",
            parent.name,
            _seen_from(parent.X_ML, top),
            child.name,
            _seen_from(child.X_ML, lower[(i + side) % 3]),
            float(np.linalg.norm(top - lower[(i + side) % 3])),
        )
        for i, top in enumerate(upper)
        for side in (0, 1)
    ]


def _seen_from(X_ML: RigidTransform, p_M: np.ndarray) -> tuple[float, float, float]:
    return float_triple(X_ML.inverse().multiply(p_M))
