"""Gazebo's DetachableJoint: a load that is held in place until it is dropped."""

import math

import numpy as np
import pytest

from workbench.plant.description import read_description
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import load_vehicle, make_vehicle
from workbench.plant.worlds.reading import read_world
from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

BASE, CRATE, LOW = 1.0, 0.3, 0.12
"""Masses [kg], and how far the crate is below the base [m]."""
AROUND = {"xx": 0.01, "yy": 0.012, "zz": 0.02}
SPHERE = 5e-4
"""Moments of inertia of the base and, about each axis, of the crate [kg m²]."""
TURN = 1.0
"""Of the drone in its world about z [rad]."""
HOLD = {"parent_link": "base", "child_model": "crate", "child_link": "body"}
WELD = '<joint name="weld" type="fixed"><parent>base</parent><child>crate::body</child></joint>'


def body(name, mass, moments, more="") -> str:
    rows = "".join(f"<i{axis}>{value}</i{axis}>" for axis, value in moments.items())
    inertial = f"<inertial><mass>{mass}</mass><inertia>{rows}</inertia></inertial>"
    return f'<link name="{name}">{inertial}{more}</link>'


def crate(pose) -> str:
    ball = '<collision name="c"><geometry><sphere><radius>0.05</radius></sphere></geometry>'
    link = body("body", CRATE, dict.fromkeys(("xx", "yy", "zz"), SPHERE), f"{ball}</collision>")
    return f'<model name="crate"><pose>{pose}</pose>{link}</model>'


def plugin(kind, file, **values) -> str:
    inside = "".join(f"<{tag}>{text}</{tag}>" for tag, text in values.items())
    return f'<plugin filename="{file}" name="gz::sim::systems::{kind}">{inside}</plugin>'


def hold(**changed) -> str:
    return plugin("DetachableJoint", "gz-sim-detachable-joint-system", **HOLD | changed)


def rotor(name, x, y) -> str:
    light = dict.fromkeys(("xx", "yy", "zz"), 1e-12)
    return (
        body(name, 1e-9, light, f"<pose>{x} {y} 0 0 0 0</pose>")
        + f'<joint name="{name}_joint" type="revolute"><parent>base</parent><child>{name}</child>'
        + "<axis><xyz>0 0 1</xyz></axis></joint>"
        + plugin(
            "MulticopterMotorModel",
            "gz-sim-multicopter-motor-model-system",
            jointName=f"{name}_joint",
            linkName=name,
            turningDirection="cw" if x * y > 0 else "ccw",
            timeConstantUp=0.01,
            timeConstantDown=0.02,
            maxRotVelocity=1000,
            motorConstant=1e-5,
            momentConstant=0.016,
        )
    )


def drone(more, pose="0 0 0 0 0 0") -> str:
    places = ((0.2, 0.2), (-0.2, -0.2), (0.2, -0.2), (-0.2, 0.2))
    rotors = "".join(rotor(f"r{number}", *place) for number, place in enumerate(places))
    parts = body("base", BASE, AROUND) + rotors + more
    return f'<model name="quad"><pose>{pose}</pose>{parts}</model>'


NESTED = drone(crate(f"0 0 -{LOW} 0 0 0") + hold())
WORLD = (
    f'<world name="w">{crate(f"2 1 {0.5 - LOW} 0 0 {TURN}")}'
    f"{drone(hold(), f'2 1 0.5 0 0 {TURN}')}</world>"
)


def write(folder, content, name="quad.sdf") -> str:
    path = folder / name
    path.write_text(f'<sdf version="1.9">{content}</sdf>')
    return str(path)


@pytest.mark.parametrize("content", [NESTED, WORLD], ids=["nested", "in the world"])
def test_a_law_knows_the_held_load_as_a_part_of_the_body(tmp_path, content):
    description = read_description(write(tmp_path, content))
    vehicle = make_vehicle(description)
    mass = BASE + CRATE
    assert vehicle.mass == pytest.approx(mass, abs=1e-7)
    assert vehicle.unloaded.mass == pytest.approx(BASE, abs=1e-7)
    # two bodies, each with its own inertia, LOW apart: the reduced mass turns
    swung = BASE * CRATE / mass * LOW**2
    by_hand = np.diag(
        [AROUND["xx"] + SPHERE + swung, AROUND["yy"] + SPHERE + swung, AROUND["zz"] + SPHERE]
    )
    assert np.array(vehicle.turned.I_BBcm_B) == pytest.approx(by_hand, abs=1e-6)
    assert vehicle.turned.p_BoBcm_B == pytest.approx([0.0, 0.0, -LOW * CRATE / mass], abs=1e-6)
    (remark,) = [each for each in description.remarks if "DetachableJoint" in each.element]
    assert "open_hooks drops it" in remark.text
    assert not [each for each in description.remarks if "Gazebo only" in each.text]
    assert not [each for each in description.remarks if "left out" in each.text]


def test_a_drone_whose_camera_is_missing_still_holds_a_load(tmp_path):
    camera = "<include><uri>model://no_camera</uri></include>"
    world = WORLD.replace('<model name="quad">', f'<model name="quad">{camera}')
    description = read_description(write(tmp_path, world))
    assert description.base_link == "base"
    assert make_vehicle(description).mass == pytest.approx(BASE + CRATE, abs=1e-7)
    assert [each for each in description.remarks if "no_camera" in f"{each.element}{each.text}"]


def test_it_hangs_in_place_and_falls_when_it_is_dropped(tmp_path):
    start = ScenarioStart(position=[0.0, 0.0, 2.0])
    path = write(tmp_path, NESTED)
    session = Session(Scenario(vehicle=VehicleConfig(model=path), start=start))
    session.tick(0.5)
    apart = session.pose("world", "base").inverse() @ session.pose("world", "crate::body")
    assert apart.translation() == pytest.approx([0.0, 0.0, -LOW], abs=5e-3)
    lifts = [
        tension * (each.upper[2] - each.lower[2]) / math.dist(each.upper, each.lower)
        for tension, each in zip(
            session.recording().tensions[-1], session.snapshot().cables, strict=True
        )
    ]
    assert np.array(lifts) == pytest.approx([CRATE * GRAVITY / 6.0] * 6, rel=0.02)
    before = session.pose("world", "crate::body").translation()[2]
    session.set("open_hooks", 1.0)
    session.tick(0.25)
    fallen = before - session.pose("world", "crate::body").translation()[2]
    assert fallen == pytest.approx(0.5 * GRAVITY * 0.25**2, abs=5e-3)


def test_what_cannot_be_held_is_named_and_flies_as_without_the_plugin(tmp_path, case):
    inside = crate(f"0 0 -{LOW} 0 0 0")
    for more, why in (
        (hold(parent_link="bse"), "no <parent_link> 'bse'"),
        (hold(child_link="bdy"), "no such link 'bdy'"),
        (hold(child_model="crat"), "no such link 'body'"),
        (hold(initial_attach="false"), "its <initial_attach> is false"),
        (WELD + hold(), "joints hold it"),
        (hold(child_model="__model__", child_link="base"), "joints hold it"),
    ):
        with case(more):
            description = read_description(write(tmp_path, drone(inside + more)))
            (remark,) = [each for each in description.remarks if "DetachableJoint" in each.element]
            assert why in remark.text
            assert "nothing is attached" in remark.text
            plain = read_description(
                write(tmp_path, drone(inside + (WELD if WELD in more else "")))
            )
            assert description.model.cables == ()
            assert make_vehicle(description).mass == make_vehicle(plain).mass


def test_only_one_of_two_plugins_holds_a_load(tmp_path):
    path = write(tmp_path, drone(crate(f"0 0 -{LOW} 0 0 0") + hold() + hold()))
    assert len(load_vehicle(path).cables) == 6


def test_a_world_has_no_obstacle_where_a_drone_holds_a_load(tmp_path):
    twice = WORLD.replace("</world>", crate("5 5 0 0 0 0") + "</world>")
    path = write(tmp_path, twice)
    assert load_vehicle(path).mass == pytest.approx(BASE + CRATE, abs=1e-7)
    assert [each.name for each in read_world(path).obstacles] == ["crate_1::body"]
    loose = write(tmp_path, WORLD.replace(hold(), hold(initial_attach="0")))
    assert [each.name for each in read_world(loose).obstacles] == ["crate::body"]
