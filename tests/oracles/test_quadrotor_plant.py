"""Accelerations of our airframe against Drake's own quadrotor, an independent model.

`QuadrotorPlant` has its centre of mass at the origin and four rotors at distance L, in this order
(probed by giving each one newton): ahead, left, behind, right; the first and third turn clockwise
and so drag the body counter-clockwise. A rotor's input u makes the force kF u and the drag kM u.
Its state is position, roll-pitch-yaw, and the rates of both.
"""

import numpy as np
import pytest
from pydrake.examples import QuadrotorPlant
from pydrake.math import RollPitchYaw

from workbench.plant.description import read_description

PLACES = ((1, 0), (0, 1), (-1, 0), (0, -1))
TURNS = ("cw", "ccw", "cw", "ccw")
MOTOR_CONSTANT = 1.3e-5

URDF = """<robot name="q">
  <link name="base">
    <inertial>
      <mass value="{mass!r}"/>
      <inertia ixx="{I[0][0]!r}" ixy="{I[0][1]!r}" ixz="{I[0][2]!r}"
               iyy="{I[1][1]!r}" iyz="{I[1][2]!r}" izz="{I[2][2]!r}"/>
    </inertial>
  </link>{rotors}
</robot>"""

ROTOR = """
  <link name="rotor_{i}"/>
  <joint name="joint_{i}" type="continuous">
    <parent link="base"/>
    <child link="rotor_{i}"/>
    <origin xyz="{x!r} {y!r} 0"/>
    <axis xyz="0 0 1"/>
  </joint>
  <gazebo>
    <plugin name="motor_{i}" filename="librotors_gazebo_motor_model.so">
      <jointName>joint_{i}</jointName>
      <linkName>rotor_{i}</linkName>
      <turningDirection>{turn}</turningDirection>
      <timeConstantUp>0.01</timeConstantUp>
      <timeConstantDown>0.02</timeConstantDown>
      <maxRotVelocity>2000</maxRotVelocity>
      <motorConstant>{motor_constant!r}</motorConstant>
      <momentConstant>{moment_constant!r}</momentConstant>
      <motorNumber>{i}</motorNumber>
    </plugin>
  </gazebo>"""


def random_inertia(rng) -> np.ndarray:
    """Return an inertia that a body can have, with products: that of random points."""
    points = rng.normal(scale=0.1, size=(20, 3))
    squares = (points**2).sum(axis=1)
    return 0.05 * (squares.sum() * np.eye(3) - points.T @ points)


def write_urdf(path, mass, length, inertia, moment_constant):
    rotors = "".join(
        ROTOR.format(
            i=i,
            x=length * x,
            y=length * y,
            turn=TURNS[i],
            motor_constant=MOTOR_CONSTANT,
            moment_constant=moment_constant,
        )
        for i, (x, y) in enumerate(PLACES)
    )
    path.write_text(URDF.format(mass=mass, I=inertia.tolist(), rotors=rotors))


def theirs(plant, p_WB, rpy, v_WB, rpy_rates, forces) -> np.ndarray:
    """Return angular and linear acceleration in W that `QuadrotorPlant` gives."""
    context = plant.CreateDefaultContext()
    context.SetContinuousState(np.concatenate([p_WB, rpy.vector(), v_WB, rpy_rates]))
    plant.get_input_port().FixValue(context, forces / plant.force_constant())
    derivatives = plant.EvalTimeDerivatives(context).CopyToVector()
    # w = M rates, so dw/dt = M (second rates - those without any angular acceleration)
    M = np.array([rpy.CalcAngularVelocityInParentFromRpyDt(row) for row in np.eye(3)]).T
    free = rpy.CalcRpyDDtFromRpyDtAndAngularAccelInParent(rpy_rates, np.zeros(3))
    return np.concatenate([M @ (derivatives[9:12] - free), derivatives[6:9]])


@pytest.mark.parametrize("seed", range(10))
def test_accelerations_are_those_of_drakes_quadrotor(tmp_path, rig_of, seed):
    """Ten vehicles, a hundred random states and inputs each."""
    rng = np.random.default_rng(seed)
    mass, length, moment_constant = rng.uniform([0.5, 0.1, 0.005], [3.0, 0.4, 0.05]).tolist()
    inertia = random_inertia(rng)
    path = tmp_path / "quad.urdf"
    write_urdf(path, mass, length, inertia, moment_constant)
    rig = rig_of(read_description(path))
    # kF is not 1, so that a newton is told from an input
    plant = QuadrotorPlant(mass, length, inertia, 0.8, 0.8 * moment_constant)
    for _ in range(100):
        p_WB = rng.uniform(-10, 10, 3) + [0, 0, 20]
        rpy = RollPitchYaw(rng.uniform([-np.pi, -1.4, -np.pi], [np.pi, 1.4, np.pi]))
        v_WB, rpy_rates = rng.uniform(-8, 8, 3), rng.uniform(-5, 5, 3)
        speeds = rng.uniform(0, 1000, 4)
        w_WB = rpy.CalcAngularVelocityInParentFromRpyDt(rpy_rates)
        rig.set_state([*rpy.ToQuaternion().wxyz(), *p_WB, *w_WB, *v_WB])
        rig.set_speeds(speeds)
        expected = theirs(plant, p_WB, rpy, v_WB, rpy_rates, MOTOR_CONSTANT * speeds**2)
        assert rig.accelerations() == pytest.approx(expected, rel=1e-9, abs=1e-9)
