"""Propellers turn in the picture as far as their speeds say, and are drawn once."""

import math

import numpy as np
import pytest
from pydrake.geometry import Role, SceneGraph
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.multibody import add_plant
from workbench.resources import find_model
from workbench.systems.propeller_display import add_propeller_display

PERIOD = 1 / 32
SPEEDS = np.array([100.0, 200.0, 300.0, 400.0])


@pytest.fixture(scope="module")
def shown():
    """Vehicle, simulator flown for three pictures, scene graph and display."""
    description = read_description(find_model("dh_drone"))
    vehicle = make_vehicle(description)
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, description, time_step=1 / 1024)
    speeds = builder.AddSystem(ConstantVectorSource(SPEEDS))
    display = add_propeller_display(
        builder, plant, scene_graph, vehicle, speeds.get_output_port(), period=PERIOD
    )
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(
        context, plant.GetBodyByName(vehicle.base_link), RigidTransform([0.0, 0.0, 50.0])
    )
    simulator.AdvanceTo(3.5 * PERIOD)
    return vehicle, simulator, scene_graph, display, plant


def _pose(simulator, scene_graph: SceneGraph, name: str) -> RigidTransform:
    inspector = scene_graph.model_inspector()
    frame = next(f for f in inspector.GetAllFrameIds() if inspector.GetName(f) == name)
    context = scene_graph.GetMyContextFromRoot(simulator.get_context())
    return scene_graph.get_query_output_port().Eval(context).GetPoseInWorld(frame)


def test_angle_is_speed_times_time_over_slow_down_with_the_rotors_direction(shown):
    vehicle, simulator, scene_graph, _, _ = shown
    turned_for = 4 * PERIOD  # updates at 0, 1, 2 and 3 periods
    for rotor, speed in zip(vehicle.rotors, SPEEDS, strict=True):
        R = _pose(simulator, scene_graph, rotor.name).rotation().matrix()
        expected = rotor.direction * speed * turned_for / rotor.velocity_slowdown
        assert math.isclose(
            math.remainder(math.atan2(R[1, 0], R[0, 0]) - expected, 2 * math.pi), 0.0, abs_tol=1e-9
        )


def test_propellers_stay_on_their_hubs(shown):
    vehicle, simulator, scene_graph, _, plant = shown
    context = plant.GetMyContextFromRoot(simulator.get_context())
    for rotor in vehicle.rotors:
        hub = plant.GetBodyByName(rotor.link).EvalPoseInWorld(context).translation()
        shown_at = _pose(simulator, scene_graph, rotor.name).translation()
        np.testing.assert_allclose(shown_at, hub, atol=1e-9)


def test_each_blade_is_drawn_once(shown):
    vehicle, _, scene_graph, _, plant = shown
    inspector = scene_graph.model_inspector()
    for rotor in vehicle.rotors:
        frame = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(rotor.link).index())
        assert inspector.NumGeometriesForFrameWithRole(frame, Role.kIllustration) == 0
        own = next(f for f in inspector.GetAllFrameIds() if inspector.GetName(f) == rotor.name)
        assert inspector.NumGeometriesForFrameWithRole(own, Role.kIllustration) > 0
