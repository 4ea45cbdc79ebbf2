"""Oracle: frames that Drake finds in the description, and names by hand."""

import dataclasses

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.framework import DiagramBuilder

from workbench.common.resources import find_model
from workbench.plant.description import read_description
from workbench.plant.frame_tree import frame_tree
from workbench.plant.loading import make_vehicle
from workbench.plant.model import NamedFrame
from workbench.plant.multibody import add_plant
from workbench.plant.placing import body_state
from workbench.plant.sensors import DepthCamera, Sensor

EYE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

POSED = """<link name="arm"/>
<joint name="j" type="fixed"><parent link="base"/><child link="arm"/>
<origin xyz="0.1 0 0" rpy="0 0 0.3"/></joint>
<gazebo reference="arm"><sensor name="plain" type="imu"/>
<sensor name="eye" type="imu"><pose>0 0.02 0 0.1 0 0</pose></sensor>
<sensor name="arm" type="imu"><pose>0 0 0 0 0.5 0</pose></sensor></gazebo>
</robot>"""


@pytest.fixture(scope="module")
def description():
    return read_description(find_model("dh_drone"))


@pytest.fixture(scope="module")
def vehicle(description):
    return make_vehicle(description)


@pytest.fixture(scope="module")
def tree(description, vehicle):
    return frame_tree(vehicle, description.model)


def parents(tree) -> dict[str, str]:
    return {frame.name: frame.parent for frame in tree.frames}


def test_poses_are_those_of_drakes_bodies(description, vehicle, tree):
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description, time_step=0.0)
    context = builder.Build().CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(context)
    state = body_state(
        p_WB=[1.0, 2.0, 3.0],
        roll_pitch_yaw=[0.3, -0.2, 1.0],
        v_WB=[0, 0, 0],
        w_WB=[0, 0, 0],
    )
    plant.SetPositionsAndVelocities(context, state)
    X_WB = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(vehicle.base_link))
    frames = {
        frame.name: plant.GetFrameByName(frame.name).CalcPoseInWorld(context)
        for frame in vehicle.frames
    }
    assert len(frames) == len(description.model.links)
    for a, X_WA in frames.items():
        assert tree.X("world", a, X_WB).IsNearlyEqualTo(X_WA, 1e-12)
        for b, X_WB2 in frames.items():
            assert tree.X(a, b, X_WB).IsNearlyEqualTo(X_WA.inverse() @ X_WB2, 1e-12)


def test_links_hang_as_joints_have_them(tree, description):
    found = parents(tree)
    assert found["base_link"] == "world"
    for joint in description.model.joints:
        assert found[joint.child] == joint.parent


def test_sensors_hang_on_their_links_with_names_of_their_own(tree, vehicle):
    found = parents(tree)
    X_WB = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1, 2, 3])
    for sensor in vehicle.sensors:
        assert found[sensor.name] == sensor.link
        X_BS = tree.X("base_link", sensor.name, X_WB)
        assert X_BS.translation() == pytest.approx(sensor.p_BS, abs=1e-12)
        assert X_BS.rotation().matrix() == pytest.approx(np.array(sensor.R_BS), abs=1e-12)


def test_an_optical_frame_looks_along_its_z_with_x_right_and_y_down(tree):
    assert parents(tree)["camera_optical"] == "camera"
    R_SO = tree.X("camera", "camera_optical", RigidTransform()).rotation().matrix()
    assert R_SO[:, 2].tolist() == [1, 0, 0]
    assert R_SO[:, 0].tolist() == [0, -1, 0]
    assert R_SO[:, 1].tolist() == [0, 0, -1]


def sensor(kind: type[Sensor], name: str, frame: str = "base_link") -> Sensor:
    return kind(name, "any", frame, "base_link", 10.0, (0.1, 0.2, 0.3), EYE)


@pytest.mark.parametrize(
    ("name", "expected"),
    [("imu_1", "imu_1"), ("GPS_link", "GPS_link_sensor"), ("world", "world_sensor")],
)
def test_a_sensor_with_a_links_name_is_told_apart(vehicle, description, name, expected):
    other = dataclasses.replace(vehicle, sensors=(sensor(Sensor, name),))
    names = frame_tree(other, description.model).names
    assert names[-1] == expected
    assert len(set(names)) == len(names)


def test_where_that_is_taken_too_it_gets_a_number(vehicle, description):
    sensors = (sensor(Sensor, "GPS_link_sensor"), sensor(Sensor, "GPS_link"))
    names = frame_tree(dataclasses.replace(vehicle, sensors=sensors), description.model).names
    assert names[-2:] == ("GPS_link_sensor", "GPS_link_sensor_2")


def test_readings_are_labelled_with_a_frame_that_is_where_their_data_are(quad, write):
    """A vehicle from its file; where the data are is the sensor's pose in the body."""
    description = read_description(write(quad.replace("</robot>", POSED)))
    vehicle = make_vehicle(description)
    tree = frame_tree(vehicle, description.model)
    labels = [each.frame for each in vehicle.sensors]
    assert labels == ["arm", "eye", "arm_sensor"]
    for each in vehicle.sensors:
        X_BS = tree.X("base", each.frame, RigidTransform())
        assert X_BS.translation() == pytest.approx(each.p_BS, abs=1e-12)
        assert X_BS.rotation().matrix() == pytest.approx(np.array(each.R_BS), abs=1e-12)


def test_a_label_that_is_no_link_is_another_name_for_the_sensors_frame(vehicle, description):
    sensors = (sensor(DepthCamera, "eye", "my_optical"), sensor(Sensor, "ear", "my_optical"))
    tree = frame_tree(dataclasses.replace(vehicle, sensors=sensors), description.model)
    assert tree.names[-4:] == ("eye", "eye_optical", "my_optical", "ear")
    assert tree.X("eye", "my_optical", RigidTransform()).IsExactlyIdentity()


def test_frames_of_the_description_are_there(vehicle, description):
    pose = RigidTransform([0.0, 0.0, 0.1])
    frames = (
        NamedFrame("mast_top", "lidar_link", pose),
        NamedFrame("GPS_link", "lidar_link", pose),
        NamedFrame("lost", "no_link", pose),
    )
    tree = frame_tree(vehicle, dataclasses.replace(description.model, frames=frames))
    found = parents(tree)
    assert found["mast_top"] == "lidar_link"
    assert found["GPS_link"] == "base_link"
    assert "lost" not in found
    assert tree.X("lidar_link", "mast_top", RigidTransform()).IsExactlyEqualTo(pose)


def test_parts_of_the_world_stay_or_move(vehicle, description):
    wall = RigidTransform([3.0, 0.0, 1.0])
    tree = frame_tree(
        vehicle,
        description.model,
        fixed=[("wall", wall), ("lidar", wall)],
        moving=[("cart", lambda time: RigidTransform([time, 0.0, 0.0])), ("wall", lambda _: wall)],
    )
    assert tree.names[-4:] == ("wall", "lidar_2", "cart", "wall_2")
    assert {parents(tree)[name] for name in tree.names[-4:]} == {"world"}
    X_WB = RigidTransform([1.0, 0.0, 0.0])
    assert tree.X("base_link", "wall", X_WB, 2.0).translation().tolist() == [2.0, 0.0, 1.0]
    assert tree.X("wall", "cart", X_WB, 2.0).translation().tolist() == [-1.0, 0.0, -1.0]
