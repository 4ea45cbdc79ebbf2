"""Loads on cables: taut, slack, dropped and picked up, against closed forms."""

import math

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder

from tests.jointed import drone, joint, link
from workbench.common.errors import WorkbenchError
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.diagram.free_loads import free_loads, hang_loads, refuse_out_of_reach
from workbench.diagram.joint_modes import joint_study
from workbench.plant.description import read_description
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import load_vehicle, make_vehicle
from workbench.plant.multibody import add_plant
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session
from workbench.setup import make_setup
from workbench.systems.cables import cable_rows
from workbench.systems.joint_forces import STOP_RATE_RAD_S

BASE, LOAD, LENGTH, RADIUS = 1.0, 0.2, 0.8, 0.05
BALL = f'<sphere radius="{RADIUS}"/>'

BATTERY = (
    "battery: {capacity: 18000, resistance: 0.06, "
    "open_circuit_voltage: [[0, 9], [0.9, 12], [1, 12.6]]}\n"
)


def slung(folder, hung=LENGTH, p=(0.0, 0.0, 0.0), more="") -> str:
    """Return a quadrotor with a ball `hung` metres below a point of it, and a cable between."""
    x, y, z = p
    ball = link("ball", LOAD, shape=BALL)
    free = joint("free", "floating", "base", "ball", (x, y, z - hung))
    cable = (
        f'<cable name="sling" length="{LENGTH}" {more}><parent link="base" xyz="{x} {y} {z}"/>'
        '<child link="ball"/></cable>'
    )
    return drone(folder, ball + free + cable, BASE)


def flight(path: str, height: float, script=(), **more) -> Session:
    """Return the flight of a script from hover at a height."""
    start = ScenarioStart(position=[0.0, 0.0, height])
    return Session(
        Scenario(vehicle=VehicleConfig(model=path), start=start, script=list(script), **more)
    )


def test_a_load_on_a_cable_hangs_and_swings_by_the_tension(tmp_path):
    """Of two masses on a cable of tension T and length L: w² = T / L (1 / m + 1 / M).

    The cable stretches by m g / k, with k = w_s² m M / (m + M) for the natural frequency w_s.
    """
    path = slung(tmp_path)
    study = LinearStudy(Scenario(vehicle=VehicleConfig(model=path)))
    reduced = LOAD * BASE / (LOAD + BASE)
    stretch = LOAD * GRAVITY / (reduced * STOP_RATE_RAD_S**2)
    trim = study.trim()
    assert trim.joints == pytest.approx([*[0.0] * 5, -stretch], abs=1e-9)
    tension = LOAD * GRAVITY
    expected = math.sqrt(tension / (LENGTH + stretch) / reduced)
    values = np.linalg.eigvals(study.bare_vehicle().A)
    swings = values[np.abs(values - 1j * expected) < 0.1]
    assert len(swings) == 2  # along x and y
    assert np.abs(swings - 1j * expected).max() < 1e-5
    assert np.abs(values - STOP_RATE_RAD_S * (-0.5 + math.sqrt(0.75) * 1j)).min() < 0.1


@pytest.mark.parametrize("mass", [0.8, 1.3])
def test_a_load_hangs_straight_down_below_a_drone_that_leans_against_its_drag(tmp_path, mass):
    """Whatever the speed, and though the drone is lighter or heavier than its law believes.

    In the frame of the drone, which leans by a, it is (L + m g / k) (sin a, 0, -cos a) away.
    """
    model = slung(tmp_path, more='stiffness="2000"')
    vary = Variation(mass=mass)
    study = LinearStudy(Scenario(vehicle=VehicleConfig(model=model, variation=vary)))
    cable = LENGTH + mass * LOAD * GRAVITY / 2000.0
    for speed in (0.5, 1.0, 2.0, 4.0, 7.0):
        trim = study.trim(OperatingPoint(velocity=(speed, 0.0, 0.0)), {"drag_area": 0.03})
        lean = 2.0 * math.asin(trim.q_WB[2])
        assert lean > 0.0
        found = trim.joints[3:6] + (0.0, 0.0, -LENGTH)
        assert found == pytest.approx(
            [cable * math.sin(lean), 0.0, -cable * math.cos(lean)], abs=1e-6
        )


def test_cables_in_parallel_have_the_mode_of_both(tmp_path):
    """Each alone has 100 rad/s and half of the critical damping: s² + 200 s + 20000 for both."""
    free = joint("free", "floating", "base", "load", (0, 0, -LENGTH))
    cables = "".join(
        f'<cable name="{name}" length="{LENGTH}"><parent link="base"/><child link="load"/></cable>'
        for name in ("first", "second")
    )
    description = read_description(drone(tmp_path, link("load", LOAD) + free + cables, BASE))
    modes, _, _ = joint_study(description)
    assert modes[0].joint in ("first", "second")
    assert modes[0].eigenvalue == pytest.approx(-100.0 + 100.0j, abs=1e-6)
    assert max(mode.rate for mode in modes[1:]) < 10.0


def test_a_law_knows_that_a_cable_passes_on_the_weight_and_no_moment(tmp_path):
    """On a cable from a point beside the centre the load pulls there, and turns with nothing."""
    place = (0.1, 0.0, -0.05)
    turned = load_vehicle(slung(tmp_path, p=place)).turned
    assert turned.p_BoBcm_B[0] == pytest.approx(LOAD * 0.1 / (BASE + LOAD), rel=1e-9)
    # a force across meets the base alone, and a moment about z, too
    assert turned.p_BoBcm_B[2] == pytest.approx(0.0, abs=1e-9)
    assert turned.I_BBcm_B[2][2] == pytest.approx(0.02, rel=1e-9)
    about_y = 0.012 + BASE * LOAD / (BASE + LOAD) * 0.1**2
    assert turned.I_BBcm_B[1][1] == pytest.approx(about_y, rel=1e-9)


def test_a_slack_cable_lets_its_load_fall_until_it_is_taut(tmp_path):
    slack = 0.2
    session = flight(slung(tmp_path, hung=LENGTH - slack), 20.0, duration=1.5)
    session.set("drag_area", 0.0)
    session.run()
    recording = session.recording()
    tension = recording.tensions[:, 0]
    first = recording.time[np.flatnonzero(tension)[0]]
    climb = recording.p_WB[recording.time <= first][-1, 2] - 20.0
    # the drone, lighter than its law believes, climbs meanwhile
    assert first == pytest.approx(math.sqrt(2.0 * (slack - climb) / GRAVITY), abs=0.01)
    assert tension.max() > 3.0 * LOAD * GRAVITY
    assert recording.slack_time > first - 0.01


def test_an_open_hook_drops_a_load_and_does_not_take_it_from_afar(tmp_path):
    session = flight(slung(tmp_path), 1.0 + LENGTH, [Action(0.25, set={"open_hooks": 1.0})])
    (cable,) = session.snapshot().cables
    assert cable.lower == pytest.approx(session.pose("world", "ball").translation(), abs=1e-12)
    assert cable.upper == pytest.approx([0.0, 0.0, 1.0 + LENGTH], abs=1e-12)
    session.tick(0.625)
    assert session.snapshot().cables == ()
    fallen = session.recording().between(0.25, 0.5)
    assert (fallen.tensions[1:] == 0.0).all()
    assert session.pose("world", "ball").translation()[2] == pytest.approx(
        1.0 - 0.5 * GRAVITY * 0.375**2, abs=0.01
    )
    session.tick(0.75)
    with pytest.raises(WorkbenchError, match="'sling' is 0.8 m long, and its load is 1.* m away"):
        session.set("open_hooks", 0.0)
    assert session.get("open_hooks") == 1.0
    place = session.pose("world", "ball").translation()
    assert place[2] == pytest.approx(RADIUS, abs=2e-3)


def test_a_law_no_longer_carries_a_load_that_it_has_dropped(tmp_path):
    """It hovers on with the thrust of the base alone, at the height where it let the load go.

    A law that still added the load's weight would climb: by 0.2 kg g over the stiffness of height.
    """
    session = flight(slung(tmp_path), 5.0, [Action(0.25, set={"open_hooks": 1.0})])
    session.tick(0.5)
    checkpoint = session.checkpoint()
    session.tick(1.5)
    recording = session.recording()
    assert recording.total_thrust[-1] == pytest.approx(BASE * GRAVITY, rel=2e-3)
    assert abs(recording.p_WB[-1, 2] - 5.0) < 0.01
    ended = session.state().tolist()
    session.begin_from(checkpoint)
    session.tick(1.5)
    assert session.state().tolist() == ended


def test_a_script_that_opens_the_hooks_at_once_begins_with_the_speeds_of_the_base(tmp_path):
    """Of four equal rotors with motor constant 1e-5: 4 · 1e-5 w² = m g."""
    session = flight(slung(tmp_path), 5.0, [Action(0.0, set={"open_hooks": 1.0})])
    session.tick(0.5)
    recording = session.recording()
    assert recording.rotor_speeds[0] == pytest.approx(math.sqrt(BASE * GRAVITY / 4e-5), rel=1e-9)
    assert np.abs(recording.p_WB[:, 2] - 5.0).max() < 1e-3


@pytest.mark.parametrize("battery", ["", BATTERY], ids=["no battery", "battery"])
def test_linear_models_with_open_hooks_are_those_of_the_base_alone(tmp_path, battery):
    """Whether the scenario opens them or one call does, which the next call does not remember.

    The battery is that of the flight: it hovers base and load for the time of its parameter, and
    the base alone longer by the ratio of powers, which is (mass ratio)^1.5.
    """
    folders = [tmp_path / name for name in ("slung", "alone")]
    for folder in folders:
        folder.mkdir()
    opened = {"open_hooks": 1.0}
    loaded = Scenario(vehicle=VehicleConfig(model=slung(folders[0])))
    base = Scenario(vehicle=VehicleConfig(model=drone(folders[1], "", BASE)))
    for folder in folders:
        with (folder / "jointed.rotors.yaml").open("a") as file:
            file.write(battery)
    study = LinearStudy(loaded)
    own = study.like(study.setup.with_settings(opened))
    gains = dict(study.gains)  # a law's own gains are for the loaded one
    gains["battery_duration"] *= ((BASE + LOAD) / BASE) ** 1.5
    alone = LinearStudy(make_setup(base, gains))
    assert own.vehicle.mass == pytest.approx(BASE)
    for model in (LinearStudy.sampled, LinearStudy.continuous, LinearStudy.bare_vehicle):
        expected, before = model(alone), model(study)
        for found in (model(own), model(study, gains=opened)):
            assert found.state_names == expected.state_names
            np.testing.assert_allclose(found.A, expected.A, rtol=0.0, atol=1e-9)
        assert model(study).A.tobytes() == before.A.tobytes()
        assert before.A.shape > expected.A.shape


BOB, REACH = 0.05, 0.2
"""Of a bob on a rod of no mass, hinged below the base's origin, which a strap holds [kg, m]."""


def strapped(more: str) -> str:
    """Return the parts of a bob that a strap of 0.1 m holds to the base."""
    return (
        link("bob", BOB, (REACH, 0.0, 0.0))
        + joint("hinge", "continuous", "base", "bob", (0.0, 0.0, -0.1))
        + f'<cable name="strap" length="0.1"><parent link="base" xyz="{REACH} 0 0"/>'
        f'<child link="bob" xyz="{REACH} 0 0"/></cable>{more}'
    )


def test_hooks_open_under_loads_and_leave_cables_between_other_links(tmp_path):
    """The strap bears the bob before and after the load is dropped: T REACH = m g REACH."""
    ball = link("ball", LOAD, shape=BALL)
    free = joint("free", "floating", "base", "ball", (0.0, 0.0, -LENGTH))
    ends = '<parent link="base"/><child link="ball"/>'
    sling = f'<cable name="sling" length="{LENGTH}">{ends}</cable>'
    path = drone(tmp_path, strapped(ball + free + sling), BASE)
    session = flight(path, 10.0, [Action(1.5, set={"open_hooks": 1.0})])
    session.tick(1.5)
    assert [cable.name for cable in session.snapshot().cables] == ["strap", "sling"]
    session.tick(1.5)
    assert [cable.name for cable in session.snapshot().cables] == ["strap"]
    tensions = session.recording().tensions
    names = session.vehicle.cables
    strap, sling = names.index("strap"), names.index("sling")
    for row, held in ((tensions[len(tensions) // 2 - 2], LOAD), (tensions[-1], 0.0)):
        assert row[strap] == pytest.approx(BOB * GRAVITY, rel=0.02)
        assert row[sling] == pytest.approx(held * GRAVITY, rel=0.02, abs=1e-12)


def test_a_payload_and_a_load_are_carried_at_once_and_dropped_apart(tmp_path):
    """The law knows both: it has the thrust of what it carries each time, and hardly leans.

    It leans a little while the cable stretches; by 0.05 rad if it did not know the payload's place.
    """
    payload = {"payload_mass": 0.3, "known_payload_mass": 0.3, "payload_x": 0.05}
    script = [
        Action(0.5, set={"open_hooks": 1.0}),
        Action(1.0, set=dict.fromkeys(payload, 0.0)),
    ]
    scenario = Scenario(
        vehicle=VehicleConfig(model=slung(tmp_path)),
        start=ScenarioStart(position=[0.0, 0.0, 10.0]),
        script=script,
    )
    session = Session(scenario, payload)
    for carried in (0.3 + LOAD, 0.3, 0.0):
        session.tick(0.5)
        flown = session.recording()
        assert flown.total_thrust[-1] == pytest.approx((BASE + carried) * GRAVITY, rel=5e-3)
        assert flown.tilt.max() < 0.02
    assert flown.p_WB[-1] == pytest.approx([0.0, 0.0, 10.0], abs=0.02)


def test_a_drone_without_loads_has_no_hooks(tmp_path):
    """Its strap is recorded all the same, and its linear models have it."""
    session = flight(drone(tmp_path, strapped(""), BASE), 10.0)
    with pytest.raises(WorkbenchError, match="open_hooks"):
        session.set("open_hooks", 1.0)
    session.tick(1.5)
    assert session.recording().tensions[-1] == pytest.approx([BOB * GRAVITY], rel=0.02)


def test_a_law_designs_its_numbers_anew_when_its_load_is_dropped_and_taken(tmp_path):
    law = tmp_path / "weigher.py"
    law.write_text(
        "from workbench.controllers import pd\n"
        "PARAMETERS, POINTS, LOOPS, rule = pd.PARAMETERS, pd.POINTS, pd.LOOPS, pd.rule\n"
        "update = pd.update\n"
        'DESIGNED = ("known_mass",)\n\n'
        "def design(vehicle, g, dt):\n"
        "    return [vehicle.mass]\n"
    )
    config = VehicleConfig(model=slung(tmp_path))
    session = Session(Scenario(vehicle=config, controller=str(law)))
    computer = session._bench.computer
    context = computer.GetMyContextFromRoot(session._live.root)
    gains = context.get_numeric_parameter(computer.gains_index)
    assert gains[gains.size() - 1] == pytest.approx(BASE + LOAD)
    session.set("open_hooks", 1.0)
    assert gains[gains.size() - 1] == pytest.approx(BASE)
    session.set("open_hooks", 0.0)
    assert gains[gains.size() - 1] == pytest.approx(BASE + LOAD)


def test_a_load_that_lies_on_the_ground_is_picked_up(tmp_path):
    """Below a drone that begins lower than its cable is long, with the hook open, then closed."""
    script = [Action(0.25, set={"open_hooks": 0.0}), Action(0.25, go_to=[0.0, 0.0, 2.0])]
    start = ScenarioStart(position=[0.0, 0.0, 0.5])
    config = VehicleConfig(model=slung(tmp_path))
    scenario = Scenario(vehicle=config, start=start, script=script, duration=4.0)
    session = Session(scenario, {"open_hooks": 1.0})
    assert session.pose("world", "ball").translation()[2] == pytest.approx(RADIUS, abs=1e-9)
    session.run()
    recording = session.recording()
    assert not recording.between(0.0, 0.25).tensions.any()
    assert recording.tensions[-1, 0] == pytest.approx(LOAD * GRAVITY, rel=0.1)
    lifted = session.pose("world", "ball").translation()
    assert lifted[2] == pytest.approx(recording.p_WB[-1, 2] - LENGTH, abs=0.02)
    assert lifted[2] > 0.5


def test_a_load_is_within_its_sphere_and_no_point_of_it_is_faster_than_that_says(tmp_path):
    """It spins about y at 30 rad/s while it moves: points of its rim move at v + 30 r at most."""
    description = read_description(slung(tmp_path))
    plant, _ = add_plant(DiagramBuilder(), description.undrawn(), time_step=0.0)
    [load] = free_loads(plant, description)
    context = plant.CreateDefaultContext()
    load.joint.SetTranslation(context, [1.0, 2.0, -3.0])
    load.joint.set_angular_velocity(context, [0.0, 30.0, 0.0])
    load.joint.set_translational_velocity(context, [1.0, 0.0, 0.0])
    centre, radius, speed = load.sphere(plant, context)
    at = plant.EvalBodyPoseInWorld(context, load.body).translation()
    assert centre == pytest.approx(at) and radius == pytest.approx(RADIUS)
    assert speed == pytest.approx(1.0 + 30.0 * RADIUS)


def test_loads_hang_on_the_shortest_of_their_cables_and_hooks_reach_as_far_as_theirs(tmp_path):
    """Of 0.8 and 1.1 m, from one point: the shorter one is stretched by m g over both stiffnesses,
    as `hang_loads` states."""
    free = joint("free", "floating", "base", "load", (0.1, 0.2, -0.3))
    cables = "".join(
        f'<cable name="{name}" length="{length}"><parent link="base" xyz="0.1 0 0"/>'
        '<child link="load"/></cable>'
        for name, length in (("long", 1.1), ("short", LENGTH))
    )
    description = read_description(drone(tmp_path, link("load", LOAD) + free + cables, BASE))
    plant, _ = add_plant(DiagramBuilder(), description.undrawn(), time_step=0.0)
    [load] = free_loads(plant, description)
    rows = cable_rows(plant, description.model, plant.GetBodyByName("base").model_instance())
    context = plant.CreateDefaultContext()
    hang_loads(plant, context, rows, make_vehicle(description))
    stretch = LOAD * GRAVITY / sum(row.stiffness for row in rows)
    hung = plant.EvalBodyPoseInWorld(context, load.body).translation()
    assert hung == pytest.approx([0.1, 0.0, -LENGTH - stretch], abs=1e-9)
    assert 0.0 < stretch < 0.01
    (short,) = (row for row in rows if row.name == "short")
    for share, reaches in ((0.99, True), (1.01, False)):
        load.joint.SetTranslation(context, [0.0, -0.2, 0.3 - share * LENGTH])
        if reaches:
            refuse_out_of_reach(plant, context, short)
        else:
            with pytest.raises(WorkbenchError, match="0.8 m long, and its load is 0.81 m away"):
                refuse_out_of_reach(plant, context, short)
