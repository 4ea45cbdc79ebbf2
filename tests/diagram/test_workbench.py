"""Oracle: the same flight on the continuous core; and what is in the diagram, and what is not."""

import html
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat, Role
from pydrake.systems.analysis import Simulator

from workbench.common.resources import find_world
from workbench.control.flight_mode import in_the_air
from workbench.control.guidance import Guidance, Reference
from workbench.diagram.workbench import make_workbench
from workbench.link.topics import TopicDirection
from workbench.plant.variation import Variation
from workbench.plant.worlds.reading import read_world
from workbench.scenario.scenario import Action, Rates, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

DOCS = Path(__file__).resolve().parents[2] / "docs"
SVG = "{http://www.w3.org/2000/svg}"
HEIGHT = 10.0
ALWAYS = {
    *("plant", "rotors", "body_forces", "forces", "push", "wind", "flight_imu"),
    *("scene_graph", "controller"),
    *("pilot", "modes", "battery", "frames", "recorded_signals", "recorder"),
    "body_contact",
}
"""Systems of the plainest flight."""


def core_flight(core, vehicle, reference, times, wind=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Return state over time of the continuous core under a reference, from hover."""
    simulator = Simulator(core)
    context = simulator.get_mutable_context()
    core.GetInputPort("wind").FixValue(context, np.array(wind))
    core.GetInputPort("reference").FixValue(context, np.array(reference, dtype=float))
    guide = Guidance(1, 1, 1, 0, 0, 0, 0, 0, HEIGHT)
    core.GetInputPort("guidance").FixValue(context, np.array(guide, dtype=float))
    start = [1, 0, 0, 0, 0, 0, HEIGHT, *[0.0] * 6, *vehicle.hover_speeds, 0, 0, 0, 0]
    context.SetContinuousState(start)
    simulator.get_mutable_integrator().set_target_accuracy(1e-6)
    states = []
    for time in times:
        simulator.AdvanceTo(time)
        states.append(core.GetOutputPort("state").Eval(context).copy())
    return np.array(states)


@pytest.mark.parametrize(
    ("reference", "bound"),
    [
        pytest.param(Reference(2.0, 0, 0, 0, 0, 0, 0, 0), 0.045, marks=pytest.mark.slow),
        pytest.param(Reference(0, 0, 1.0, 0, 0, 0, 0, 0), 0.012, marks=pytest.mark.slow),
        (Reference(0, 0, 0, 0.2, 0, 0, 0, 0), 0.0025),
        pytest.param(Reference(1.0, -1.0, 0.5, 0.1, 0, 0, 0, 0), 0.05, marks=pytest.mark.slow),
    ],
)
def test_the_workbench_flies_as_the_core_does(core, vehicle, reference, bound):
    """A step, sampled at the default rates and continuous.

    A hold is a delay of half a control period, 4 ms, and a stepped plant half a step more. On a
    slope of 6.5 m/s² that is 28 mm/s while x rises (37 are seen, as a delay also stirs the loop),
    on 2.5 m/s² 11 mm/s of z (8 are seen), on 0.5 rad/s² 2 mrad/s of yaw. Where rotors that speed up
    faster than others slow down kick the yaw, as late as that, 43 mrad/s are seen for a moment. In
    the end they agree.
    """
    scenario = Scenario(
        duration=2.0,
        start=ScenarioStart(position=[0.0, 0.0, HEIGHT]),
        script=[Action(at=0.0, velocity=list(reference[:3]), yaw_rate=reference.yaw_rate)],
    )
    session = Session(scenario)
    session.run()
    flight = session.recording()
    states = core_flight(core, vehicle, reference, flight.time)
    velocity = np.column_stack([flight.v_WB, flight.w_WB[:, 2]])
    wanted = np.column_stack([states[:, 10:13], states[:, 9]])
    assert wanted[-1] == pytest.approx(reference[:4], abs=0.02)
    assert np.abs(velocity - wanted).max() < bound
    assert velocity[-1] == pytest.approx(wanted[-1], abs=0.001)


@pytest.mark.slow
def test_in_the_wind_too_the_workbench_flies_as_the_core_does(core, vehicle):
    """A step as above, to the same bound: what the wind adds, 1 m/s², is as late."""
    wind = [-6.0, 4.0, 1.0]
    reference = Reference(1.0, -1.0, 0.5, 0.1, 0, 0, 0, 0)
    scenario = Scenario(
        duration=2.0,
        start=ScenarioStart(position=[0.0, 0.0, HEIGHT]),
        script=[Action(at=0.0, velocity=list(reference[:3]), yaw_rate=reference.yaw_rate)],
    )
    session = Session(scenario, dict(zip(("wind_x", "wind_y", "wind_z"), wind, strict=True)))
    session.run()
    flight = session.recording()
    states = core_flight(core, vehicle, reference, flight.time, wind)
    assert np.linalg.norm(states[-1, 10:12] - reference[:2]) > 0.1
    assert np.abs(flight.v_WB - states[:, 10:13]).max() < 0.03
    assert flight.v_WB[-1] == pytest.approx(states[-1, 10:13], abs=0.001)


def test_the_plainest_flight_has_nothing_that_it_does_not_need(setup, system_names):
    """No path, no world, no sensors: then there is no system for these, not even an idle one."""
    bench = make_workbench(setup)
    names = system_names(bench.diagram)
    assert set(names) == ALWAYS
    assert len(names) == len(ALWAYS)
    assert bench.diagram.num_input_ports() == 0
    assert bench.obstacles is None
    assert bench.sensing.mounted == ()


@pytest.mark.parametrize("watched", [True, False])
def test_the_drone_has_shapes_to_draw_only_where_somebody_watches(setup, watched):
    description = setup.description
    bench = make_workbench(setup, Meshcat() if watched else None)
    inspector = bench.airframe.scene_graph.model_inspector()
    drawn = sum(len(link.visuals) for link in description.model.links)
    assert inspector.NumGeometriesWithRole(Role.kIllustration) == (drawn if watched else 0)
    touching = sum(len(link.collisions) for link in description.model.links)
    # and the ground, and the corners of the drone's box
    assert inspector.NumGeometriesWithRole(Role.kProximity) == touching + 1 + 8


@pytest.mark.parametrize(
    ("world", "more"),
    [
        ("empty", set()),
        ("room", {"obstacles"}),
        ("moving_obstacle", {"obstacles", "obstacle_paths", "obstacle_poses"}),
    ],
)
def test_a_world_adds_what_it_needs(setup, system_names, world, more):
    bench = make_workbench(replace(setup, world=read_world(find_world(world), {})))
    assert set(system_names(bench.diagram)) == ALWAYS | more
    assert (bench.obstacles is not None) == bool(more)


def test_obstacles_far_away_do_not_change_the_flight(tmp_path):
    """But for errors of integration: a step also ends where their clearance is measured."""
    (tmp_path / "far.yaml").write_text(
        "obstacles: [{name: box, shape: {box: [1, 1, 1]}, position: [40, 30, 0.5]}]"
    )
    scenario = Scenario(
        duration=2.0, script=[Action(at=0.1, velocity=[2, 1, -0.5]), Action(at=1.0, request="land")]
    )
    flights = []
    for world in ("empty", str(tmp_path / "far.yaml")):
        scenario.world = world
        session = Session(scenario)
        session.run()
        flights.append(session.recording())
    without, far = flights
    for name in ("p_WB", "q_WB", "v_WB", "w_WB", "thrusts"):
        off = np.abs(getattr(far, name) - getattr(without, name)).max()
        assert off < 1e-5 * np.abs(getattr(without, name)).max(), name
    assert far.mode.tobytes() == without.mode.tobytes()


def reaction(variation: Variation) -> tuple[int, int]:
    """Return the steps at which commands, and rotors, first differ by a push that begins at 64."""
    rates = Rates(record_period=Rates().physics_step)
    config = VehicleConfig(variation=variation)
    scenario = Scenario(vehicle=config, rates=rates, start=ScenarioStart(position=[0.0, 0.0, 5.0]))
    flown = []
    for force in (0.0, 2.0):
        push = {"push_y": force, "push_start": 64 / 1024, "push_duration": 1.0}
        session = Session(scenario, push)
        session.tick(128 / 1024)
        flown.append(session.recording())
    calm, pushed = flown
    return tuple(
        int(np.argmax((getattr(calm, name) != getattr(pushed, name)).any(axis=1)))
        for name in ("commanded_speeds", "rotor_speeds")
    )


def test_delays_are_of_as_many_steps_as_they_say(case):
    """The push moves the state from step 65 on: updates are at 72, 80 and so on.

    With a delay d the first that sees it is the first at 65 + d or later.
    """
    commands, rotors = reaction(Variation())
    assert (commands, rotors) == (73, 73)
    for steps, later in ((7, 0), (8, 8), (11, 8), (15, 8), (16, 16), (17, 16)):
        with case("sensing", steps):
            found = reaction(Variation(sensing_delay=steps / 1024))
            assert found == (commands + later, rotors + later)
    for steps in (5, 8, 19):
        with case("command", steps):
            found = reaction(Variation(command_delay=steps / 1024))
            assert found == (commands, rotors + steps)


def drawn_as_text(dot):
    """Return the texts of each system, and who feeds whom, in Drake's text for Graphviz."""
    labels = re.findall(r"^(\w+) \[.*?label=<(.*?)>\s*\]", dot, re.MULTILINE | re.DOTALL)
    texts = {
        node: [html.unescape(each) for each in re.findall(r">\s*([^\s<>][^<>]*?)\s*<", label)]
        for node, label in labels
    }
    edges = re.findall(r"^(\w+):\w+:e -> (\w+):\w+:w", dot, re.MULTILINE)
    return by_name(texts, edges)


def drawn_as_picture(svg):
    """Return the same of the picture that Graphviz makes of it."""
    texts, edges = {}, []
    for group in ET.parse(svg).getroot().iter(f"{SVG}g"):
        title = group.findtext(f"{SVG}title")
        if group.get("class") == "node":
            texts[title] = [each.text for each in group.iter(f"{SVG}text")]
        elif group.get("class") == "edge":
            edges += re.findall(r"(\w+):e->(\w+):w", title)
    return by_name(texts, edges)


def by_name(texts, edges):
    """Return both with the systems' names: their numbers differ from run to run."""
    names = {
        node: next(each for each in lines if each.startswith("name="))
        for node, lines in texts.items()
    }
    boxes = {names[node]: sorted(lines) for node, lines in texts.items()}
    return boxes, sorted((names[a], names[b]) for a, b in edges)


def test_the_documentation_shows_the_diagram_that_flies():
    """Graphviz's versions place boxes differently, so only texts and connections are compared.

    Drake's versions give its own plant other ports; only its connections are compared.
    """
    boxes, edges = drawn_as_text(Session().diagram.GetGraphvizString(max_depth=1))
    assert set(boxes) == {f"name={name}" for name in ALWAYS}
    assert len(edges) > 25
    shown, shown_edges = drawn_as_picture(DOCS / "diagram.svg")
    for name in ("name=plant", "name=scene_graph"):
        boxes[name] = shown[name] = []
    assert (shown, shown_edges) == (boxes, edges), (
        "the diagram has changed: draw docs/diagram.svg as docs/architecture.md says"
    )


def test_obstacles_are_measured_a_step_before_they_are_read():
    """A drone that flies towards a wall sees it where it was a step ago, not a period ago."""
    start = ScenarioStart(position=[0.0, 1.0, 1.5], velocity=[0.0, 1.0, 0.0])
    session = Session(Scenario(world="room", start=start))
    first = session.snapshot().clearance
    session.tick(1 / 16)
    clearance, position = session.snapshot().clearance, session.state()[4:7]
    moved = float((position - [0.0, 1.0, 1.5]) @ first.direction)
    assert first.distance - clearance.distance == pytest.approx(moved, abs=3e-3)


def test_its_systems_have_the_limits_and_the_height_of_the_drone():
    settings = {"max_speed": 6.0, "max_climb_rate": 2.5, "max_yaw_rate": 0.7}
    standing = Scenario(start=ScenarioStart(mode="off"))
    session = Session(standing, settings, bridge=Bridge())
    command = next(topic for topic in session.topics if topic.direction is TopicDirection.BOTH)
    high = {each.name: each.high for each in command.fields}
    assert [high[name] for name in ("v_x", "v_y", "v_z", "yaw_rate")] == [6.0, 6.0, 2.5, 0.7]
    # a drone that stands is not in the air, so that it cannot go around
    z = float(session.state()[6])
    assert not in_the_air(z, session._bench.modes._standing_height)
    assert in_the_air(z + 0.5, session._bench.modes._standing_height)
