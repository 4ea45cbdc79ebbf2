"""Where the links of a URDF are: poses along its joints."""

from pathlib import Path

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened


def link_poses(
    path: Path, links: list[str], joints: list[tuple[str, str, RigidTransform]]
) -> dict[str, RigidTransform]:
    """Return every link's pose in the frame of the root that it hangs on.

    Args:
        path: for messages.
        links: names.
        joints: parent, child, and the child's pose in the parent.

    Raises:
        WorkbenchError: if a link hangs on two joints, or joints go round in a circle.
    """
    above: dict[str, tuple[str, RigidTransform]] = {}
    for parent, child, X_PC in joints:
        if child in above:
            raise WorkbenchError(
                f"{path}: link '{shortened(child)}' is the child of two joints: a URDF is a tree, "
                "so leave one out"
            )
        above[child] = (parent, X_PC)
    poses = {name: RigidTransform() for name in links if name not in above}
    for name in links:
        way = [name]
        while way[-1] not in poses:
            way.append(above[way[-1]][0])
            if len(way) > len(links):
                raise WorkbenchError(
                    f"{path}: the joints above link '{shortened(name)}' go round in a circle: "
                    "one link must be no joint's child"
                )
        for child in reversed(way[:-1]):
            parent, X_PC = above[child]
            poses[child] = poses[parent] @ X_PC
    return poses
