"""A wrench acts on the plant through Drake's `Propeller`: in C++, as rotors do."""

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant, PropellerInfo


def air_forces(plant: MultibodyPlant, base_link: str) -> list[PropellerInfo]:
    """Return rotors that make any force [N] and moment about Bo [N·m], given in B (6).

    They are at the body's origin: three that only pull, along x, y and z, and three that only turn
    about them.
    """
    base = plant.GetBodyByName(base_link).index()
    poses = [
        RigidTransform(RotationMatrix.MakeFromOneVector(axis, axis_index=2), np.zeros(3))
        for axis in np.eye(3)
    ]
    pulls = [PropellerInfo(base, pose, thrust_ratio=1.0, moment_ratio=0.0) for pose in poses]
    turns = [PropellerInfo(base, pose, thrust_ratio=0.0, moment_ratio=1.0) for pose in poses]
    return pulls + turns
