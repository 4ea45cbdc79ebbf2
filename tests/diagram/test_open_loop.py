"""The airframe under a table: physics by hand."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.diagram.core import ROTOR_COMMANDS, make_open_loop
from workbench.plant.placing import body_state
from workbench.plant.worlds.reading import read_world
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.open_loop import fly_open_loop
from workbench.systems.rotor_playback import RotorCommands

HEIGHT = 10.0


def started(diagram, airframe, vehicle, height: float) -> Simulator:
    """Return a simulator at rest in the air, with rotors at hover speed."""
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    still = [0.0] * 3
    state = body_state(p_WB=[0, 0, height], roll_pitch_yaw=still, v_WB=still, w_WB=still)
    airframe.place(context, state, vehicle.hover_speeds)
    held = diagram.GetSubsystemByName(ROTOR_COMMANDS)
    held.GetMyMutableContextFromRoot(context).SetDiscreteState(vehicle.hover_speeds)
    return simulator


def state_of(recorder, simulator) -> np.ndarray:
    return recorder.now(simulator.get_context())["state"]


def test_it_hovers_on_hover_thrust(setup, vehicle):
    """Two seconds; then one rotor gives up and it tumbles."""
    hover = vehicle.hover_speeds
    commands = RotorCommands(np.array([0.0, 2.0]), np.array([hover, [0.0, *hover[1:]]]))
    diagram, airframe, recorder = make_open_loop(setup, commands)
    simulator = started(diagram, airframe, vehicle, HEIGHT)
    simulator.AdvanceTo(2.0)
    assert state_of(recorder, simulator)[4:7] == pytest.approx([0, 0, HEIGHT], abs=1e-6)
    simulator.AdvanceTo(2.5)
    assert np.linalg.norm(state_of(recorder, simulator)[7:10]) > 5.0


def test_a_world_stands_in_its_way(setup, vehicle, tmp_path):
    """It falls on a table 1 m high, and comes to rest on it as it would on the ground."""
    (tmp_path / "table.yaml").write_text(
        "obstacles: [{name: table, shape: {box: [4, 4, 1]}, position: [0, 0, 0.5]}]"
    )
    commands = RotorCommands(np.array([0.0]), np.zeros((1, 4)))
    world = read_world(tmp_path / "table.yaml", {})
    diagram, airframe, recorder = make_open_loop(dataclasses.replace(setup, world=world), commands)
    simulator = started(diagram, airframe, vehicle, 1.5)
    simulator.AdvanceTo(2.0)
    height = state_of(recorder, simulator)[6]
    assert height == pytest.approx(1.0 + vehicle.ground_clearance, abs=2e-3)


def test_a_table_acts_from_the_first_instant_on(tmp_path):
    """Also where it does not begin with hover: its rotors already turn as its first row says."""
    table = tmp_path / "table.csv"
    table.write_text("0, 2, 3, 4, 5\n0.03125, 3, 3, 3, 3\n")
    start = ScenarioStart(position=[0.0, 0.0, 10.0])
    flown = fly_open_loop(Scenario(start=start, duration=1 / 16), table)
    first = [math.sqrt(thrust / 8.54858e-06) for thrust in (2.0, 3.0, 4.0, 5.0)]
    assert flown.time[0] == 0.0
    assert flown.rotor_speeds[0] == pytest.approx(first, rel=1e-6)
    assert flown.commanded_speeds[flown.time < 1 / 32] == pytest.approx(
        np.tile(first, (4, 1)), rel=1e-6
    )
