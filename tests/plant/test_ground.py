"""Oracle: rest, Coulomb's law of friction, and the height of a bounce."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from workbench.plant.description import read_description
from workbench.plant.multibody import add_plant
from workbench.scenario.scenario import Rates

FOOT = """<collision><origin xyz="{} {} 0"/>
  <geometry><sphere radius="0.01"/></geometry></collision>"""


def drop(description, height, speed, times):
    """Let a drone go with a level speed; return places, and both velocities, over time."""
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description, time_step=Rates().physics_step)
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    base = plant.GetBodyByName(description.base_link)
    plant.SetFreeBodyPose(context, base, RigidTransform([0.0, 0.0, height]))
    plant.SetFreeBodySpatialVelocity(context, base, SpatialVelocity(np.zeros(3), [speed, 0, 0]))
    simulator.Initialize()
    states = []
    for time in times:
        simulator.AdvanceTo(time)
        states.append(plant.GetPositionsAndVelocities(context).copy())
    states = np.array(states)
    return states[:, 4:7], states[:, 7:13]


def test_at_rest_it_neither_sinks_nor_trembles(dh_drone, dh_vehicle):
    clearance = dh_vehicle.ground_clearance
    p_WB, speeds = drop(dh_drone, clearance, 0.0, np.linspace(0.01, 3.0, 300))
    assert np.abs(p_WB[:, 2] - clearance).max() < 0.005
    assert np.abs(speeds[100:]).max() < 1e-4


def test_let_fall_it_does_not_bounce_and_comes_to_rest(dh_drone, dh_vehicle):
    clearance = dh_vehicle.ground_clearance
    times = np.linspace(0.005, 3.0, 600)
    p_WB, speeds = drop(dh_drone, clearance + 0.3, 0.0, times)
    height = p_WB[:, 2] - clearance
    landed = int(np.argmax(height < 0.001))
    assert times[landed] == pytest.approx(np.sqrt(2 * 0.3 / 9.81), abs=0.01)  # free fall
    assert height[landed:].max() < 0.02
    assert height.min() > -0.02
    assert np.abs(height[-1]) < 0.005
    assert np.abs(speeds[-1]).max() < 1e-4


def test_it_slides_to_a_stop_as_friction_has_it(write, quad):
    """v^2 / (2 mu g), less half a step's way.

    The ground has 0.7, a URDF's shape without a coefficient 1, and Drake takes the harmonic mean
    2 * 0.7 * 1 / 1.7. Four flat feet, far apart, keep the slide from becoming a tumble.
    """
    feet = "".join(FOOT.format(x, y) for x in (-0.2, 0.2) for y in (-0.2, 0.2))
    path = write(quad.replace("</inertial>", f"</inertial>{feet}"))
    p_WB, speeds = drop(read_description(path), 0.01, 1.0, [1.0])
    way = 1.0 / (2.0 * (1.4 / 1.7) * 9.81)
    assert p_WB[-1, 0] == pytest.approx(way - 0.5 * Rates().physics_step, rel=0.01)
    assert np.abs(speeds[-1]).max() < 1e-4
