"""Mass and inertia of a link in SDF."""

from pydrake.math import RigidTransform

from workbench.plant.formats.sdf_node import Node
from workbench.plant.formats.sdf_poses import Poses
from workbench.plant.formats.sdf_shapes import solid
from workbench.plant.formats.sdf_values import flag, number, pose
from workbench.plant.formats.solids import Solid, together, volume
from workbench.plant.model import Inertial
from workbench.plant.remarks import Remarks

_DENSITY = 1000.0
"""Of water [kg/m³]: what SDF assumes."""
_DEFAULT = Inertial(1.0, RigidTransform(), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
"""What SDF, and Gazebo with it, take for a link that says nothing."""


def read_inertial(link: Node, poses: Poses, remarks: Remarks) -> Inertial:
    """Return mass and inertia of a link.

    Args:
        link: its element.
        poses: to find its collisions, where its inertia is to be made from them.
        remarks: where to note what is not in the file.

    Raises:
        WorkbenchError: naming file and line of what is no number.
    """
    node = link.child("inertial")
    if not node:
        text = "it has no <inertial>; SDF's defaults of 1 kg and 1 kg·m² hold, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
        return _DEFAULT
    if flag(node, node.attribute("auto")):
        return _from_collisions(link, node, poses, remarks)
    if not node.text_of("mass"):
        text = "its <inertial> gives no mass; SDF's default of 1 kg holds, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
    inertia = node.child("inertia")
    X_LI = pose(node.child("pose"))
    mass = number(node, "mass", 1.0)
    if not inertia:
        text = "its <inertial> has no <inertia>; SDF's default of 1 kg·m² holds, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
        return Inertial(mass, X_LI, _DEFAULT.moments, _DEFAULT.products)
    xx, yy, zz = (number(inertia, tag, 1.0) for tag in ("ixx", "iyy", "izz"))
    xy, xz, yz = (number(inertia, tag, 0.0) for tag in ("ixy", "ixz", "iyz"))
    return Inertial(mass, X_LI, (xx, yy, zz), (xy, xz, yz))


def _from_collisions(link: Node, inertial: Node, poses: Poses, remarks: Remarks) -> Inertial:
    """Return what SDF's `<inertial auto="true">` asks for; a given mass scales it."""
    bodies = []
    density = number(inertial, "density", _DENSITY)
    for node in link.children("collision"):
        shape = solid(node)
        if shape is None:
            text = "automatic inertia leaves out a collision that is no box, sphere, cylinder, "
            text += "capsule or ellipsoid"
            remarks.add("assumed", link.file, link.title, text)
            continue
        X_LC = poses.X_LF(node, link.full_name)
        mass = number(node, "density", density) * volume(shape)
        bodies.append(Solid(mass, X_LC, shape))
    total = sum(body.mass for body in bodies)
    if not bodies or min(body.mass for body in bodies) <= 0.0:
        text = "automatic inertia has no collision with a mass; SDF's defaults of 1 kg and 1 kg·m² "
        remarks.add("assumed", link.file, link.title, text + "hold")
        return _DEFAULT
    return together(bodies, number(inertial, "mass", total) / total)
