"""Oracle: Drake's `Propeller`, set up by hand from the numbers in the drone's constants.xacro."""

import dataclasses

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import Propeller, PropellerInfo
from pydrake.systems.framework import DiagramBuilder

from workbench.plant.multibody import add_plant
from workbench.systems.rotor_forces import add_rotor_forces

MOTOR_CONSTANT = 8.54858e-06
MOMENT_CONSTANT = 0.016
ARM = 0.25
ROTOR_HEIGHT = 0.014 / 2 + 0.026 + 0.006
TURNS = (-1, 1, -1, 1)


def applied(propeller, context, R_WB) -> np.ndarray:
    """Return torque about the body's origin and force, in W, of all that a propeller applies."""
    forces = propeller.get_spatial_forces_output_port().Eval(context)
    return sum(F.F_Bq_W.Shift(-(R_WB @ F.p_BoBq_B)).get_coeffs() for F in forces)


def with_plant(description, vehicle):
    """Return diagram, plant and our propeller, commanded by thrusts."""
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description, time_step=0.0)
    propeller = add_rotor_forces(builder, plant, vehicle)
    builder.ExportInput(propeller.get_command_input_port(), "thrusts")
    return builder.Build(), plant, propeller


def by_hand(base_index):
    """Four rotors at odd multiples of 45 degrees, commanded by squared speeds."""
    infos = []
    for number, turn in enumerate(TURNS, start=1):
        angle = (2 * number - 1) * np.pi / 4
        p_BR = [ARM * np.cos(angle), ARM * np.sin(angle), ROTOR_HEIGHT]
        moment_ratio = -turn * MOTOR_CONSTANT * MOMENT_CONSTANT
        infos.append(PropellerInfo(base_index, RigidTransform(p_BR), MOTOR_CONSTANT, moment_ratio))
    return Propeller(infos)


def test_forces_are_those_of_a_propeller_set_up_by_hand(description, vehicle):
    diagram, plant, propeller = with_plant(description, vehicle)
    root = diagram.CreateDefaultContext()
    base = plant.GetBodyByName("base_link")
    twin = by_hand(base.index())
    context = twin.CreateDefaultContext()
    rng = np.random.default_rng(6)
    for _ in range(50):
        q, speeds = rng.normal(size=4), rng.uniform(0, 1100, 4)
        R_WB = RotationMatrix(Quaternion(q / np.linalg.norm(q)))
        X_WB = RigidTransform(R_WB, rng.uniform(-5, 5, 3) + [0, 0, 20])
        plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(root), base, X_WB)
        diagram.GetInputPort("thrusts").FixValue(root, MOTOR_CONSTANT * speeds**2)
        poses = plant.get_body_poses_output_port().Eval(plant.GetMyContextFromRoot(root))
        twin.get_body_poses_input_port().FixValue(context, poses)
        twin.get_command_input_port().FixValue(context, speeds**2)
        ours = applied(propeller, propeller.GetMyContextFromRoot(root), R_WB)
        assert ours == pytest.approx(applied(twin, context, R_WB), rel=1e-9, abs=1e-9)


def test_a_tilted_rotor_pushes_along_its_axis_and_drags_about_it(description, vehicle):
    """One newton of a counter-clockwise rotor at (0.3, 0, 0.1), tilted to the left."""
    axis = np.array([0.0, 0.6, 0.8])
    arm = np.array([0.3, 0.0, 0.1])
    rotor = dataclasses.replace(
        vehicle.rotors[0], p_BR=tuple(arm), axis_B=tuple(axis), direction=1, moment_constant=0.05
    )
    tilted = dataclasses.replace(vehicle, rotors=(rotor,))
    diagram, _, propeller = with_plant(description, tilted)
    root = diagram.CreateDefaultContext()
    diagram.GetInputPort("thrusts").FixValue(root, [1.0])
    found = applied(propeller, propeller.GetMyContextFromRoot(root), RotationMatrix())
    torque = np.cross(arm, axis) - 0.05 * axis
    assert found == pytest.approx([*torque, *axis], abs=1e-12)
