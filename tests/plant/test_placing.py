"""Oracle: Drake's own reading of the pose and velocity that were written."""

import numpy as np
import pytest
from pydrake.math import RollPitchYaw
from pydrake.systems.framework import DiagramBuilder

from workbench.plant.multibody import add_plant
from workbench.plant.placing import body_state


def test_a_vehicle_is_where_it_was_put(dh_drone):
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, dh_drone, time_step=0.0)
    diagram = builder.Build()
    context = plant.GetMyMutableContextFromRoot(diagram.CreateDefaultContext())
    put = body_state(
        p_WB=[1.0, 2.0, 3.0],
        roll_pitch_yaw=[0.1, -0.2, 2.0],
        v_WB=[4.0, 5.0, 6.0],
        w_WB=[0.7, 0.8, 0.9],
    )
    plant.SetPositionsAndVelocities(context, put)
    base = plant.GetBodyByName("base_link")
    pose = plant.EvalBodyPoseInWorld(context, base)
    motion = plant.EvalBodySpatialVelocityInWorld(context, base)
    assert pose.translation().tolist() == [1.0, 2.0, 3.0]
    assert RollPitchYaw(pose.rotation()).vector() == pytest.approx([0.1, -0.2, 2.0])
    assert motion.translational().tolist() == [4.0, 5.0, 6.0]
    assert motion.rotational().tolist() == [0.7, 0.8, 0.9]
    # and in the order that the whole project reads the state in: q_WB, p_WB, w_WB, v_WB
    state = plant.GetPositionsAndVelocities(context)
    assert state[4:] == pytest.approx(np.array([1, 2, 3, 0.7, 0.8, 0.9, 4, 5, 6]))
    quaternion = RollPitchYaw(0.1, -0.2, 2.0).ToQuaternion().wxyz()
    assert state[:4] * np.sign(state[0]) == pytest.approx(quaternion * np.sign(quaternion[0]))
