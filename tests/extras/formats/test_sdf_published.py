"""The published x500: masses, places and directions as a person reads them in its files."""

from pathlib import Path

import numpy as np
import pytest

from workbench.extras.formats.sdf import read_sdf
from workbench.plant.model import Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks

PUBLISHED = Path(__file__).resolve().parents[3] / "../shared/models/px4_gazebo_models"
X500 = PUBLISHED / "x500/model.sdf"

pytestmark = pytest.mark.skipif(
    not X500.is_file(), reason="put the published descriptions into ../shared/models to try them"
)


@pytest.fixture
def remarks() -> Remarks:
    return Remarks()


@pytest.fixture
def x500(remarks) -> Model:
    return read_sdf(X500, PackageFinder(X500), remarks)


def test_links_are_those_of_the_merged_base(x500):
    names = ["base_link", "rotor_0", "rotor_1", "rotor_2", "rotor_3"]
    assert [link.name for link in x500.links] == names
    assert x500.links[0].inertial.mass == 2.0
    assert x500.links[0].inertial.moments == (
        0.02166666666666667,
        0.02166666666666667,
        0.04000000000000001,
    )
    assert sum(link.inertial.mass for link in x500.links) == pytest.approx(2.0643076923)


def test_rotors_are_where_they_are(x500):
    places = [link.X_ML.translation().tolist() for link in x500.links]
    expected = [
        [0.0, 0.0, 0.24],
        [0.174, -0.174, 0.3],
        [-0.174, 0.174, 0.3],
        [0.174, 0.174, 0.3],
        [-0.174, -0.174, 0.3],
    ]
    np.testing.assert_allclose(places, expected, atol=1e-12)
    for index, joint in enumerate(x500.joints):
        assert joint.name == f"rotor_{index}_joint"
        assert (joint.parent, joint.child) == ("base_link", f"rotor_{index}")
        assert joint.axis_J == (0.0, 0.0, 1.0)


def test_plugins_and_sensors_are_there(x500):
    turns = [plugin.findtext("turningDirection") for plugin in x500.plugins]
    assert turns == ["ccw", "ccw", "cw", "cw", None]
    assert {plugin.file.parent.name for plugin in x500.plugins} == {"x500"}
    types = [sensor.element.get("type") for sensor in x500.sensors]
    assert types == ["air_pressure", "magnetometer", "imu", "navsat"]
    assert {sensor.element.file.parent.name for sensor in x500.sensors} == {"x500_base"}


def test_what_the_schema_does_not_know_is_noted_once(x500, remarks):
    unused, remark = remarks.found
    assert (unused.kind, unused.element) == ("ignored", "element <surface> of <collision>")
    assert remark.kind == "repaired"
    assert remark.file.parent.name == "x500_base"
    assert remark.element == "element <gz_frame_id> of <sensor>"
    assert "4 times" in remark.text


def test_shapes_have_their_files_and_colours(x500):
    base, rotor = x500.links[0], x500.links[1]
    assert len(base.visuals) == 8
    assert len(base.collisions) == 5
    assert base.visuals[0].shape.path is None
    assert base.visuals[1].shape.path.name == "5010Base.dae"
    assert rotor.visuals[0].shape.path.name == "1345_prop_ccw.stl"
    assert rotor.visuals[0].shape.scale == (0.8461538461538461,) * 3
    assert rotor.visuals[0].rgba == (0.175, 0.175, 0.175, 1.0)
