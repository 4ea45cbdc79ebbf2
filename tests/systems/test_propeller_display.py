"""Propellers turn in the picture as far as their speeds say, and are drawn once."""

import math

import numpy as np
import pytest
from pydrake.geometry import Role, SceneGraph
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from workbench.plant.multibody import add_plant
from workbench.systems.propeller_display import add_propeller_display

PERIOD = 1 / 32
SPEEDS = np.array([100.0, 200.0, 300.0, 400.0])


@pytest.fixture(scope="module")
def shown(description, vehicle):
    """Vehicle, simulator flown for three pictures, scene graph and display."""
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, description, time_step=1 / 1024)
    speeds = builder.AddSystem(ConstantVectorSource(SPEEDS))
    display = add_propeller_display(
        builder,
        plant,
        scene_graph,
        vehicle,
        plant.get_state_output_port(),
        speeds.get_output_port(),
        period=PERIOD,
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
        hub = plant.GetFrameByName(rotor.link).CalcPoseInWorld(context).translation()
        shown_at = _pose(simulator, scene_graph, rotor.name).translation()
        np.testing.assert_allclose(shown_at, hub, atol=1e-9)


def test_each_blade_is_drawn_once(shown, description):
    """As many shapes turn as the rotor's link has; the others stay on the body."""
    vehicle, _, scene_graph, _, plant = shown
    inspector = scene_graph.model_inspector()
    drawn = {link.name: len(link.visuals) for link in description.model.links}
    for rotor in vehicle.rotors:
        own = next(f for f in inspector.GetAllFrameIds() if inspector.GetName(f) == rotor.name)
        shapes = inspector.NumGeometriesForFrameWithRole(own, Role.kIllustration)
        assert shapes == drawn.pop(rotor.link) > 0
    body = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(vehicle.base_link).index())
    shapes = inspector.NumGeometriesForFrameWithRole(body, Role.kIllustration)
    assert shapes == sum(drawn.values()) > 0


def test_a_blade_that_has_not_turned_is_where_the_description_has_it(description, vehicle):
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, description, time_step=1 / 1024)
    base = plant.GetBodyByName(vehicle.base_link)
    inspector = scene_graph.model_inspector()
    before = {
        inspector.GetName(geometry): inspector.GetPoseInFrame(geometry)
        for geometry in plant.GetVisualGeometriesForBody(base)
    }
    speeds = builder.AddSystem(ConstantVectorSource(SPEEDS))
    add_propeller_display(
        builder,
        plant,
        scene_graph,
        vehicle,
        plant.get_state_output_port(),
        speeds.get_output_port(),
        period=PERIOD,
    )
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    X_WB = RigidTransform(RollPitchYaw(0.3, -0.2, 1.0), [1.0, 2.0, 50.0])
    plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(root), base, X_WB)
    query = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(root))
    for rotor in vehicle.rotors:
        own = next(f for f in inspector.GetAllFrameIds() if inspector.GetName(f) == rotor.name)
        for geometry in inspector.GetGeometries(own, Role.kIllustration):
            X_BG = before[inspector.GetName(geometry).removeprefix(f"{rotor.name}_")]
            assert query.GetPoseInWorld(geometry).IsNearlyEqualTo(X_WB @ X_BG, 1e-12)
