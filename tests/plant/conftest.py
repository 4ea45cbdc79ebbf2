"""A small quadrotor to break, and the shipped drone to measure."""

import pytest

from workbench.common.resources import find_model
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle

_ARMS = ((0.2, 0.0), (0.0, 0.2), (-0.2, 0.0), (0.0, -0.2))

_PLUGIN = """
  <gazebo>
    <plugin name="motor_{i}" filename="librotors_gazebo_motor_model.so">
      <jointName>joint_{i}</jointName>
      <linkName>rotor_{i}</linkName>
      <turningDirection>{direction}</turningDirection>
      <timeConstantUp>0.0125</timeConstantUp>
      <timeConstantDown>0.025</timeConstantDown>
      <maxRotVelocity>{max_rot_velocity}</maxRotVelocity>
      <motorConstant>1e-05</motorConstant>
      <momentConstant>0.02</momentConstant>
      <motorNumber>{i}</motorNumber>
    </plugin>
  </gazebo>"""

_ARM = """
  <link name="rotor_{i}"/>
  <joint name="joint_{i}" type="continuous">
    <parent link="base"/>
    <child link="rotor_{i}"/>
    <origin xyz="{x} {y} 0.05"/>
    <axis xyz="0 0 1"/>
  </joint>"""

_BASE = """<robot name="quad">
  <link name="base">
    <inertial>
      <mass value="1.2"/>
      <inertia ixx="0.01" iyy="0.012" izz="0.02" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>"""


@pytest.fixture(scope="session")
def quad() -> str:
    """A plus-shaped quadrotor of 1.2 kg as URDF text; rotor i can spin at 1000 + i rad/s."""
    arms = "".join(_ARM.format(i=i, x=x, y=y) for i, (x, y) in enumerate(_ARMS))
    plugins = "".join(
        _PLUGIN.format(i=i, direction=("cw", "ccw")[i % 2], max_rot_velocity=1000 + i)
        for i in range(4)
    )
    return f"{_BASE}{arms}{plugins}\n</robot>"


@pytest.fixture
def write(tmp_path):
    """Write a description and return its path."""

    def write_file(text: str, name: str = "quad.urdf"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write_file


@pytest.fixture
def broken_quad(quad, write):
    """Write the quadrotor with one text replaced by another."""

    def write_broken(old: str, new: str):
        assert old in quad
        return write(quad.replace(old, new, 1))

    return write_broken


@pytest.fixture(scope="session")
def dh_drone():
    return read_description(find_model("dh_drone"))


@pytest.fixture(scope="session")
def dh_vehicle(dh_drone):
    return make_vehicle(dh_drone)
