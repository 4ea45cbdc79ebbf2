"""Endless planes in a Gazebo world: the one that is the ground, and the others."""

import dataclasses

import numpy as np

from workbench.plant.formats.sdf_node import Node
from workbench.plant.formats.sdf_poses import Poses
from workbench.plant.formats.sdf_values import triple
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks

_FLAT = 1e-6
"""How far from upright the normal of the ground may be [rad]."""
_THIN = 1e-3
"""How far from z = 0 it may be [m]."""


def without_planes(link: Node, poses: Poses, remarks: Remarks) -> Node:
    """Return a link without the planes that touch, and without the picture of the ground.

    The ground is the half space of every world; planes that are not at z = 0 cannot be had.

    Args:
        link: with its `<visual>` and `<collision>` elements.
        poses: of all links.
        remarks: where to note planes that touch and are not the ground.
    """
    left_out = []
    for part in link.children("visual", "collision"):
        geometry = part.child("geometry")
        plane = geometry.child("plane") if geometry else None
        if plane is None:
            continue
        X_WP = poses.X_MF(link.full_name) @ poses.X_LF(part, link.full_name)
        normal = np.array(triple(plane, "normal", (0.0, 0.0, 1.0)))
        n_W = X_WP.rotation().matrix() @ normal / max(float(np.linalg.norm(normal)), 1e-12)
        height = float(X_WP.translation()[2])
        is_ground = np.hypot(n_W[0], n_W[1]) < _FLAT and n_W[2] > 0.0 and abs(height) < _THIN
        if is_ground or part.element.tag == "collision":
            left_out.append(part.element)
        if not is_ground and part.element.tag == "collision":
            text = f"an endless plane that is not the ground at z = 0 (here {height:g} m); left out"
            remarks.add("ignored", part.file, f"{part.title} of link '{link.full_name}'", text)
    if not left_out:
        return link
    kept = Element(link.element.tag, link.element.attrib)
    kept.line, kept.text = link.element.line, link.element.text
    kept.extend(child for child in link.element if child not in left_out)
    return dataclasses.replace(link, element=kept)
