"""Free bodies of an MJCF that `<weld>` or `<connect>` holds to another body."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_document import MjcfDocument
from workbench.extras.formats.mjcf_elements import elements_of
from workbench.plant.formats.values import (
    attribute_number,
    attribute_numbers,
    attribute_triple,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.model import Freedom, Joint, Link

_READ_ATTRIBUTES: Mapping[str, Sequence[str]] = {
    "weld": [
        "name",
        "class",
        "active",
        "solref",
        "solimp",
        "body1",
        "body2",
        "relpose",
        "anchor",
        "torquescale",
    ],
    "connect": ["name", "class", "active", "solref", "solimp", "body1", "body2", "anchor"],
}
"""Attributes of what holds a load; how soft it is does not act."""


class HeldLoad(NamedTuple):
    """A free body, and the equality that holds it.

    Attributes:
        element: the `<weld>` or `<connect>`.
        holder: name of the body that holds it.
        is_second: whether the load is `body2`.
    """

    element: Element
    holder: str
    is_second: bool

    def X_ML(self, X_MH: RigidTransform, X_ML: RigidTransform) -> RigidTransform:
        """Return where a weld holds its load, and a connection leaves it.

        Args:
            X_MH: pose of the holder.
            X_ML: pose of the load in the file, which holds without a `relpose`.

        Raises:
            WorkbenchError: naming the element, for an invalid `relpose`.
        """
        if self.element.tag != "weld":
            return X_ML
        stated = attribute_numbers(self.element, "relpose", "0 1 0 0 0 0 0")
        if len(stated) != 7:
            raise WorkbenchError(
                f"{element_location(self.element)}: <weld relpose>: give it seven numbers"
            )
        quaternion = np.array(stated[3:])
        length = float(np.linalg.norm(quaternion))
        if length == 0.0:  # as MuJoCo has it
            return X_ML
        R_12 = RotationMatrix(Quaternion(quaternion / length))
        # the anchor of body2 is at the place that relpose gives in body1
        anchor = np.array(attribute_triple(self.element, "anchor", "0 0 0"))
        X_12 = RigidTransform(R_12, np.array(stated[:3]) - R_12.multiply(anchor))
        return X_MH @ (X_12 if self.is_second else X_12.inverse())

    def joint(self, name: str, load: str, X_MH: RigidTransform, X_ML: RigidTransform) -> Joint:
        """Return a fixed joint, or a ball joint at the anchor of a connection.

        Args:
            name: of the joint.
            load: its name.
            X_MH: pose of the holder.
            X_ML: pose of the load.
        """
        if self.element.tag == "weld":
            return Joint(name, "fixed", self.holder, load, X_ML, (0.0, 0.0, 1.0))
        first = X_MH if self.is_second else X_ML  # the anchor is in the frame of body1
        anchor = first.multiply(np.array(attribute_triple(self.element, "anchor", "")))
        X_MJ = RigidTransform(X_ML.rotation(), anchor)
        return Joint(name, "ball", self.holder, load, X_MJ, (0.0, 0.0, 1.0), (Freedom("ball"),))


def held_loads(
    document: MjcfDocument, drone: Element, free: Sequence[Element]
) -> Mapping[str, HeldLoad]:
    """Return the free bodies that one active weld or connection holds to the drone, by name.

    A remark has each, as it flies with the drone from the beginning and no order drops it. Those
    between sites, and of bodies below a free one, are not read.

    Args:
        document: with the equalities.
        drone: its body.
        free: the other free bodies.
    """
    own = {each.get("name", "") for each in (drone, *drone.iter("body"))} - {""}
    loads = {each.get("name", "") for each in free} - {""}
    found: dict[str, HeldLoad] = {}
    welds, connections = (elements_of(document.root, "equality", tag) for tag in _READ_ATTRIBUTES)
    for element in (*welds, *connections):  # a weld holds what a connection of the same two leaves
        first, second = element.get("body1", ""), element.get("body2", "")
        if not document.defaults.is_active(element):
            continue
        for load, holder in ((second, first), (first, second)):
            if load in loads and holder in own and load not in found:
                _refuse_unread(element)
                found[load] = HeldLoad(element, holder, load == second)
                text = f"<{element.tag}> holds it to '{shortened_text(holder)}'; nothing drops it"
                what = f"body '{shortened_text(load)}'"
                document.remarks.add("assumed", document.path, what, text)
    return found


def _refuse_unread(element: Element) -> None:
    """Refuse attributes of what holds a load that MuJoCo does not have or that free a part of it.

    Raises:
        WorkbenchError: naming the element and the attribute.
    """
    where = f"{element_location(element)}: <{element.tag}"
    for name in element.attrib:
        if name not in _READ_ATTRIBUTES[element.tag]:
            raise WorkbenchError(f"{where} {shortened_text(name)}>: not read here: leave it out")
    if element.get("torquescale") and attribute_number(element, "torquescale") <= 0.0:
        raise WorkbenchError(
            f"{where} torquescale>: 0 leaves the attitude free: write a <connect> for that"
        )


def pose_of_link(links: Sequence[Link], name: str) -> RigidTransform:
    """Return the pose of a link in the model."""
    return next(link.X_ML for link in links if link.name == name)
