"""Oracle: gym-pybullet-drones' formulas (BaseAviary), worked out by hand for its Crazyflie."""

import math

import pytest
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.pybullet import is_pybullet, read_pybullet
from workbench.plant.model import Model
from workbench.plant.remarks import Remarks

PROPERTIES = {"arm": "0.0397", "kf": "3.16e-10", "km": "7.94e-12", "thrust2weight": "2.25"}
PLACES = ((0.028, -0.028), (-0.028, -0.028), (-0.028, 0.028), (0.028, 0.028))


@pytest.fixture
def crazyflie(tmp_path, link, joint):
    """27 g, with propeller links whose origins are all at the base's."""

    def make(name="cf2", count=4, mass=0.027, **properties) -> Model:
        links = [link(f"prop{i}_link", mass=0.0, com=(*PLACES[i % 4], 0.01)) for i in range(count)]
        joints = [joint(f"prop{i}_joint", rotor, kind="fixed") for i, rotor in enumerate(links)]
        values = {key: value for key, value in {**PROPERTIES, **properties}.items() if value}
        return Model(
            source=tmp_path / "cf2x.urdf",
            name=name,
            links=(link("base_link", RigidTransform(), mass), *links),
            joints=tuple(joints),
            frames=(),
            sensors=(),
            plugins=(),
            properties=tuple(values.items()),
        )

    return make


def read(model, remarks=None):
    return read_pybullet(model, "base_link", remarks or Remarks())


def test_coefficients_are_per_squared_turns_a_minute(crazyflie):
    rotor = read(crazyflie())[0]
    # 3.16e-10 N per RPM², 1 RPM = 0.10471975512 rad/s: 3.16e-10 / 0.0109662271
    assert rotor.motor_constant == pytest.approx(2.88157e-8, rel=1e-5)
    # 7.94e-12 / 3.16e-10
    assert rotor.moment_constant == pytest.approx(0.0251266, rel=1e-5)


def test_the_largest_speed_lifts_the_given_times_the_weight(crazyflie):
    rotors = read(crazyflie())
    # sqrt(2.25 x 0.027 x 9.8 / (4 x 3.16e-10)) = 21702.64 RPM
    assert rotors[0].max_rot_velocity == pytest.approx(21702.64 * math.pi / 30.0, rel=1e-6)
    assert sum(rotor.max_thrust for rotor in rotors) == pytest.approx(2.25 * 0.027 * 9.8)


def test_hubs_are_the_propellers_centres_of_mass(crazyflie):
    rotors = read(crazyflie())
    for rotor, place in zip(rotors, PLACES, strict=True):
        assert rotor.p_BR == pytest.approx((*place, 0.01))
        assert rotor.axis_B == (0.0, 0.0, 1.0)
    assert [rotor.joint for rotor in rotors] == [f"prop{i}_joint" for i in range(4)]
    assert [rotor.link for rotor in rotors] == [f"prop{i}_link" for i in range(4)]


def test_even_propellers_turn_counter_clockwise(crazyflie):
    assert [rotor.direction for rotor in read(crazyflie())] == [1, -1, 1, -1]


def test_those_of_the_racer_turn_the_other_way(crazyflie):
    assert [rotor.direction for rotor in read(crazyflie(name="racer"))] == [-1, 1, -1, 1]


def test_the_lag_is_assumed(crazyflie):
    remarks = Remarks()
    rotor = read(crazyflie(), remarks)[0]
    assert (rotor.time_constant_up, rotor.time_constant_down) == (0.0125, 0.025)
    assert [remark.kind for remark in remarks.found if remark.kind != "ignored"] == ["assumed"]


def test_properties_that_no_flight_uses_are_said_with_their_values(crazyflie):
    remarks = Remarks()
    read(crazyflie(drag_coeff_xy="1e-6", gnd_eff_coeff="x", dw_coeff_3="-.11", foo="1"), remarks)
    said = [remark.element for remark in remarks.found if remark.kind == "ignored"]
    names = ("arm=0.0397", "drag_coeff_xy=1e-6", "dw_coeff_3=-.11", "foo=1", "gnd_eff_coeff=x")
    assert said == [f"{name} of properties" for name in names]


def test_ground_effect_and_drag_along_the_axis_are_read(crazyflie):
    rotor = read(crazyflie(gnd_eff_coeff="11.4", prop_radius=".023", drag_coeff_z="1e-6"))[0]
    assert rotor.ground_effect_coefficient == 11.4
    assert (rotor.propeller_radius, rotor.inflow_coefficient) == (0.023, 1e-6)


def test_propellers_go_by_their_numbers_and_share_the_weight(crazyflie):
    rotors = read(crazyflie(count=12))
    assert [rotor.link for rotor in rotors] == [f"prop{i}_link" for i in range(12)]
    assert sum(rotor.max_thrust for rotor in rotors) == pytest.approx(2.25 * 0.027 * 9.8)


def test_without_propellers_the_properties_are_ignored(crazyflie):
    remarks = Remarks()
    assert read(crazyflie(count=0), remarks) == ()
    assert [remark.kind for remark in remarks.found] == ["ignored"]


@pytest.mark.parametrize("name", ["kf", "km", "thrust2weight"])
@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf", "much", "1e-300", "1e308"])
def test_a_coefficient_that_cannot_be_is_quoted(crazyflie, name, value):
    with pytest.raises(WorkbenchError, match=f"{name}='{value}'"):
        read(crazyflie(**{name: value}))


@pytest.mark.parametrize("name", ["kf", "km", "thrust2weight"])
def test_a_missing_coefficient_is_named(crazyflie, name):
    with pytest.raises(WorkbenchError, match=f"without {name}"):
        read(crazyflie(**{name: ""}))


def test_coefficients_that_make_no_rotor_are_refused(crazyflie):
    with pytest.raises(WorkbenchError, match="kf 1e-20"):
        read(crazyflie(kf="1e-20", km="1e6"))


def test_a_drone_without_mass_is_refused(crazyflie):
    with pytest.raises(WorkbenchError, match="mass"):
        read(crazyflie(mass=None))


def test_other_properties_are_not_theirs(crazyflie):
    assert is_pybullet(crazyflie())
    assert not is_pybullet(crazyflie(kf="", km=""))
