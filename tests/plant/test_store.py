"""A stored description is read again as the same vehicle, by us and by Drake alone."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import xacro
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from workbench.common.resources import find_model
from workbench.plant.description import read_description
from workbench.plant.formats.urdf_writer import safe_name, stored_files
from workbench.plant.loading import make_vehicle

DRONES = Path(__file__).parent.parent / "drones"
STATED = (
    "inertia",
    "inflow_coefficient",
    "ground_effect_coefficient",
    "propeller_radius",
    "linear_motor_constant",
)
"""Of a rotor, where it is."""
INERTIAL = (
    """<inertial><mass value="0.01"/><inertia ixx="1e-6" iyy="3e-5" izz="3e-5"/></inertial>"""
)
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def store(description, folder: Path) -> Path:
    """Write a description's files and return that of the URDF."""
    paths = []
    for relative, data in stored_files(description):
        path = folder / relative
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        paths.append(path)
    return paths[0]


def assert_same(one, other):
    assert other.name == one.name
    assert other.mass == pytest.approx(one.mass, rel=1e-12)
    assert other.p_BoBcm_B == pytest.approx(one.p_BoBcm_B, abs=1e-12)
    assert other.inertia == pytest.approx(one.inertia, rel=1e-9, abs=1e-12)
    assert other.ground_clearance == pytest.approx(one.ground_clearance, abs=1e-9)
    for before, after in zip(one.rotors, other.rotors, strict=True):
        assert after.p_BR == pytest.approx(before.p_BR, abs=1e-12)
        assert after.axis_B == pytest.approx(before.axis_B, abs=1e-12)
        assert after.direction == before.direction
        assert after.max_thrust == before.max_thrust
        assert after.moment_constant == before.moment_constant
        assert after.time_constant_down == before.time_constant_down
        for name in STATED:
            assert getattr(after, name) == getattr(before, name)
    assert (other.battery is None) == (one.battery is None)
    if one.battery:
        assert other.battery.capacity == pytest.approx(one.battery.capacity)
        assert other.battery.open_circuit_voltage == one.battery.open_circuit_voltage
        assert other.battery.resistance == one.battery.resistance
    for before, after in zip(one.sensors, other.sensors, strict=True):
        assert (after.name, after.type, after.frame, after.rate) == (
            before.name,
            before.type,
            before.frame,
            before.rate,
        )
        assert after.p_BS == pytest.approx(before.p_BS, abs=1e-12)
        assert np.array(after.R_BS) == pytest.approx(np.array(before.R_BS), abs=1e-12)


MODELS = ["dh_drone", *sorted(str(path) for path in DRONES.glob("*.urdf.xacro"))]


@pytest.mark.parametrize("model", MODELS, ids=[Path(model).name for model in MODELS])
def test_what_is_stored_is_the_same_vehicle(tmp_path, model):
    description = read_description(find_model(model))
    path = store(description, tmp_path)
    assert_same(make_vehicle(description), make_vehicle(read_description(path)))


def test_a_joint_that_points_against_the_thrust_keeps_its_turn(tmp_path):
    """Its plugin says how the rotor turns about the joint, not about the thrust.

    All four, so that yaw stays in balance: with a single one another's share of hover is 0, and
    which side of it rounding leaves is the machine's.
    """
    text = xacro.process_file(str(find_model("dh_drone"))).toxml()
    assert '<axis xyz="0 0 1"/>' in text
    path = tmp_path / "down.urdf"
    path.write_text(text.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>'))
    vehicle = make_vehicle(read_description(path))
    assert vehicle.rotors[0].direction == 1  # cw about an axis that points down
    stored = store(read_description(path), tmp_path / "stored")
    assert_same(vehicle, make_vehicle(read_description(stored)))


def test_a_rotor_that_points_down_turns_backwards_and_pushes_up(quad, write, tmp_path):
    """As four of an omnicopter's: the same turn seen from the other tip; stored so as well."""
    at = '<origin xyz="{} 0.05"/>'
    text = quad
    for place in ("0.2 0.0", "-0.2 0.0"):
        assert at.format(place) in text
        down = at.format(place).replace("/>", ' rpy="3.141592653589793 0 0"/>')
        text = text.replace(at.format(place), down)
    path = write(text)
    description = read_description(path)
    vehicle = make_vehicle(description)
    assert [rotor.axis_B for rotor in vehicle.rotors] == [pytest.approx((0, 0, 1))] * 4
    assert [rotor.direction for rotor in vehicle.rotors] == [-1, 1, -1, 1]
    assert min(vehicle.hover_speeds) > 100.0
    said = [remark.element for remark in description.remarks if "backwards" in remark.text]
    assert said == ["rotor 'joint_0'", "rotor 'joint_2'"]
    massive = text.replace('<link name="rotor_0"/>', f'<link name="rotor_0">{INERTIAL}</link>')
    description = read_description(write(massive, "massive.urdf"))
    stored = store(description, tmp_path / "stored")  # the first turns on its joint, the others not
    assert_same(make_vehicle(description), make_vehicle(read_description(stored)))


def test_drake_alone_reads_it_with_rotors_that_turn(tmp_path):
    """A free body (7) and four rotors."""
    path = store(read_description(find_model("dh_drone")), tmp_path)
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 0.001)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    assert plant.num_positions() == 7 + 4
    assert plant.CalcTotalMass(plant.CreateDefaultContext()) == pytest.approx(1.9)


def test_rotors_without_a_joint_or_mass_are_stored_as_hubs(tmp_path):
    (tmp_path / "x.urdf").write_text(
        '<robot name="x"><link name="b"><inertial><mass value="1"/>'
        '<inertia ixx="0.01" iyy="0.01" izz="0.02"/></inertial></link></robot>'
    )
    rotor = "  - {{position: [{}, {}, 0.1], axis: [{}, 0, 1], direction: {}}}"
    lines = [
        rotor.format(x, y, 0.1 * x, "cw" if x * y > 0 else "ccw") for x in (1, -1) for y in (1, -1)
    ]
    constants = "motor_constant: 1.0e-5, moment_constant: 0.02, max_rot_velocity: 1000"
    defaults = f"{{{constants}, time_constant_up: 0.02, time_constant_down: 0.03}}"
    (tmp_path / "x.rotors.yaml").write_text(
        f"defaults: {defaults}\nrotors:\n" + "\n".join(lines) + "\n"
    )
    urdf = tmp_path / "x.urdf"
    taken = '<link name="rotor_0_hub"/><joint name="k" type="fixed"><parent link="b"/>'
    taken += '<child link="rotor_0_hub"/></joint></robot>'
    urdf.write_text(urdf.read_text().replace("</robot>", taken))
    description = read_description(urdf)
    path = store(description, tmp_path / "stored")
    assert_same(make_vehicle(description), make_vehicle(read_description(path)))


def test_meshes_lie_beside_it_under_plain_names(quad, write, tmp_path):
    write(TETRAHEDRON, "a b.obj")
    mesh = '<geometry><mesh filename="a b.obj"/></geometry>'
    shapes = f"</inertial><visual>{mesh}</visual><collision>{mesh}</collision>"
    path = write(quad.replace("</inertial>", shapes, 1))
    folder = tmp_path / "stored"
    stored = store(read_description(path), folder)
    names = [mesh.get("filename") for mesh in meshes_of(stored)]
    assert len(names) == 2
    convex = [mesh.find("{http://drake.mit.edu}declare_convex") for mesh in meshes_of(stored)]
    assert [found is not None for found in convex] == [False, True]  # drawn as it is, touched
    assert all((folder / name).is_file() and name.startswith("meshes/") for name in names)
    assert_same(make_vehicle(read_description(path)), make_vehicle(read_description(stored)))


def meshes_of(path: Path) -> list[ET.Element]:
    return list(ET.parse(path).iter("mesh"))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("x500", "x500"),
        ("../../etc/passwd", "etc_passwd"),
        ("/abs", "abs"),
        ("a b", "a_b"),
        ("..", "model"),
        ("", "model"),
        ("a\0b", "a_b"),
    ],
)
def test_a_name_cannot_lead_out_of_the_folder(name, expected):
    assert safe_name(name) == expected
