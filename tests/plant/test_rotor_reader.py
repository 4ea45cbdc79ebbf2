"""Which of several ways to declare rotors counts, and what is said of the others."""

import pytest
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.description import read_rotors
from workbench.plant.formats.xml import parse_xml
from workbench.plant.model import Inertial, Joint, Link, Model
from workbench.plant.remarks import Remarks

BLOCK = "".join(f"<link{i}>prop{i}_link</link{i}><joint{i}>spin_{i}</joint{i}>" for i in range(4))
BLOCK = f'<plugin filename="libSetVelocity.so">{BLOCK}</plugin>'
SIDECAR = """
rotors:
  - {joint: spin_2, direction: cw, motor_constant: 3.0e-5, moment_constant: 0.02,
     time_constant_up: 0.01, time_constant_down: 0.02, max_rot_velocity: 900}
"""


def motor(i: int, scope: str = "") -> str:
    return (
        f'<plugin filename="libgazebo_motor_model.so"><jointName>{scope}spin_{i}</jointName>'
        f"<linkName>prop{i}_link</linkName><motorNumber>{i}</motorNumber>"
        "<turningDirection>cw</turningDirection><motorConstant>1e-5</motorConstant>"
        "<momentConstant>0.02</momentConstant><timeConstantUp>0.01</timeConstantUp>"
        "<timeConstantDown>0.02</timeConstantDown><maxRotVelocity>900</maxRotVelocity>"
        "<rotorVelocitySlowdownSim>10</rotorVelocitySlowdownSim></plugin>"
    )


@pytest.fixture
def model(tmp_path):
    def make(*plugins, properties=()) -> Model:
        path = tmp_path / "drone.urdf.xacro"
        inertial = Inertial(1.0, RigidTransform(), (0.01, 0.01, 0.01), (0.0, 0.0, 0.0))
        links = [
            Link(f"prop{i}_link", RigidTransform([x, y, 0.0]), None, (), ())
            for i, (x, y) in enumerate(((0.2, 0.0), (0.0, 0.2), (-0.2, 0.0), (0.0, -0.2)))
        ]
        return Model(
            source=path,
            name="drone",
            links=(Link("base", RigidTransform(), inertial, (), ()), *links),
            joints=tuple(
                Joint(f"spin_{i}", "continuous", "base", link.name, link.X_ML, (0.0, 0.0, 1.0))
                for i, link in enumerate(links)
            ),
            frames=(),
            sensors=(),
            plugins=tuple(parse_xml(f"<model>{''.join(plugins)}</model>", path)),
            properties=properties,
        )

    return make


def read(model):
    remarks = Remarks()
    rotors = read_rotors(model, "base", remarks)
    return rotors, [(remark.kind, remark.element) for remark in remarks.found]


def test_a_description_without_rotors_has_none(model):
    assert read(model()) == ((), [])


def test_motor_models_go_silently_before_a_block_of_the_same_joints(model):
    rotors, remarks = read(model(BLOCK, *[motor(i) for i in range(4)]))
    assert [rotor.motor_constant for rotor in rotors] == [1e-5] * 4
    assert remarks == []


def test_a_block_that_names_other_joints_is_noted(model):
    rotors, remarks = read(model(BLOCK, *[motor(i) for i in range(3)]))
    assert len(rotors) == 3
    assert remarks == [("ignored", "velocity plugin")]


def test_a_block_alone_counts(model):
    rotors, remarks = read(model(BLOCK))
    assert len(rotors) == 4
    assert {kind for kind, _ in remarks} == {"assumed"}


def test_the_first_of_two_blocks_counts(model):
    rotors, remarks = read(model(BLOCK, BLOCK))
    assert len(rotors) == 4
    assert ("ignored", "velocity plugin") in remarks


@pytest.mark.parametrize("plugins", [[], [BLOCK], [motor(0)], ["<plugin filename='other'/>"]])
@pytest.mark.parametrize("name", ["drone.rotors.yaml", "rotors.yaml"])
def test_a_sidecar_goes_before_all_and_says_so(model, tmp_path, plugins, name):
    (tmp_path / name).write_text(SIDECAR)
    rotors, remarks = read(model(*plugins))
    assert [rotor.motor_constant for rotor in rotors] == [3e-5]
    own = plugins and "other" not in plugins[0]
    assert remarks == ([("ignored", "rotors")] if own else [])


def test_a_sidecar_excuses_plugins_that_cannot_be_read(model, tmp_path):
    broken = motor(0).replace("1e-5", "nan")
    with pytest.raises(WorkbenchError, match="motorConstant"):
        read(model(broken))
    (tmp_path / "rotors.yaml").write_text(SIDECAR)
    assert len(read(model(broken))[0]) == 1
