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
    attribute_numbers,
    attribute_triple,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.model import Freedom, Joint, Link


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
        stated = attribute_numbers(self.element, "relpose", "0 1 0 0 0 0 0")
        if len(stated) != 7:
            raise WorkbenchError(
                f"{element_location(self.element)}: <weld relpose>: give it seven numbers"
            )
        quaternion = np.array(stated[3:])
        length = float(np.linalg.norm(quaternion))
        if self.element.tag != "weld" or length == 0.0:  # as MuJoCo has it
            return X_ML
        R = RotationMatrix(Quaternion(quaternion / length))
        X_12 = RigidTransform(R, np.array(stated[:3]))
        return X_MH @ (X_12 if self.is_second else X_12.inverse())

    def joint(self, name: str, X_MH: RigidTransform, X_ML: RigidTransform) -> Joint:
        """Return a fixed joint, or a ball joint at the anchor of a connection.

        Args:
            name: of the load.
            X_MH: pose of the holder.
            X_ML: pose of the load.
        """
        own = self.element.get("name") or f"{name}_{self.element.tag}"
        if self.element.tag == "weld":
            return Joint(own, "fixed", self.holder, name, X_ML, (0.0, 0.0, 1.0))
        first = X_MH if self.is_second else X_ML  # the anchor is in the frame of body1
        anchor = first.multiply(np.array(attribute_triple(self.element, "anchor", "")))
        X_MJ = RigidTransform(X_ML.rotation(), anchor)
        return Joint(own, "ball", self.holder, name, X_MJ, (0.0, 0.0, 1.0), (Freedom("ball"),))


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
    for element in elements_of(document.root, "equality", "weld", "connect"):
        first, second = element.get("body1", ""), element.get("body2", "")
        if element.get("active", "true") == "false":
            continue
        for load, holder in ((second, first), (first, second)):
            if load in loads and holder in own and load not in found:
                found[load] = HeldLoad(element, holder, load == second)
                text = f"<{element.tag}> holds it to '{shortened_text(holder)}'; nothing drops it"
                what = f"body '{shortened_text(load)}'"
                document.remarks.add("assumed", document.path, what, text)
    return found


def pose_of_link(links: Sequence[Link], name: str) -> RigidTransform:
    """Return the pose of a link in the model."""
    return next(link.X_ML for link in links if link.name == name)
