"""Rotor thrust and drag torque act on the plant, through Drake's `Propeller`."""

from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant, Propeller, PropellerInfo
from pydrake.systems.framework import DiagramBuilder

from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle


def add_rotor_forces(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    vehicle: Vehicle,
    others: Sequence[PropellerInfo] = (),
) -> Propeller:
    """Add a `Propeller` for the vehicle's rotors, fed with thrusts (n) [N].

    The moment about each rotor's axis is -direction moment_constant thrust.

    Args:
        builder: of the diagram.
        plant: which has the vehicle.
        vehicle: whose rotors these are.
        others: what acts besides, fed with a number each, behind the thrusts. It is in the same
            system because one more costs time at every physics step.
    """
    base = plant.GetBodyByName(vehicle.base_link).index()
    infos = [
        PropellerInfo(
            base,
            _pose(rotor),
            thrust_ratio=1.0,
            moment_ratio=-rotor.direction * rotor.moment_constant,
        )
        for rotor in vehicle.rotors
    ]
    forces = builder.AddNamedSystem("forces", Propeller([*infos, *others]))
    builder.Connect(plant.get_body_poses_output_port(), forces.get_body_poses_input_port())
    return forces


def _pose(rotor: Rotor) -> RigidTransform:
    """Return X_BR with z along the rotor's axis."""
    R_BR = RotationMatrix.MakeFromOneVector(np.array(rotor.axis_B), axis_index=2)
    return RigidTransform(R_BR, np.array(rotor.p_BR))
