"""What is estimated from a data sheet, beside what was published of real drones."""

from pathlib import Path

import pytest

from tests.installed import readable
from workbench.common.resources import find_model
from workbench.plant.data_sheet import DataSheet, Propeller
from workbench.plant.loading import load_vehicle
from workbench.plant.sheet_figures import sheet_figures

MODELS = Path(__file__).resolve().parents[2].parent / "shared" / "models"
FACTOR = 2.0
"""docs/first-drone.md says it."""
INCH = 0.0254
PUBLISHED = {
    "cf2x": ("gym_pybullet_drones/cf2x.urdf", {}, Propeller(2 * 0.0231)),
    "x500": ("px4_gazebo_models/x500/model.sdf", {}, Propeller(10 * INCH, 4.5 * INCH)),
    "hummingbird": (
        "rotors_description/urdf/hummingbird.xacro",
        {"namespace": "bird"},
        Propeller(8 * INCH, 4.5 * INCH),
    ),
}


def estimated(vehicle, propeller):
    """Return estimates for mass, arm and propeller of a vehicle, whatever else is known of it."""
    arm = vehicle.span / 2.0
    sheet = DataSheet(
        "drone", vehicle.mass, arm, propeller, max_thrust=vehicle.rotors[0].max_thrust
    )
    return {figure.name: figure.value for figure in sheet_figures(sheet)}


def assert_near(vehicle, found):
    ixx, iyy, izz = vehicle.inertia.diagonal()
    ratios = {
        "ixx": found["ixx"] / ((ixx + iyy) / 2.0),
        "izz": found["izz"] / izz,
        "motor_constant": found["motor_constant"] / vehicle.rotors[0].motor_constant,
    }
    assert all(1.0 / FACTOR < ratio < FACTOR for ratio in ratios.values()), ratios


def test_the_shipped_drone_is_estimated_well():
    vehicle = load_vehicle(find_model("dh_drone"))
    assert_near(vehicle, estimated(vehicle, Propeller(10 * INCH, 4.5 * INCH)))


@pytest.mark.skipif(
    not MODELS.is_dir(), reason=f"put published descriptions into {MODELS} to try them"
)
@pytest.mark.parametrize("name", [name for name in PUBLISHED if readable([PUBLISHED[name][0]])])
def test_published_drones_are_estimated_well(name):
    file, args, propeller = PUBLISHED[name]
    vehicle = load_vehicle(MODELS / file, args)
    assert_near(vehicle, estimated(vehicle, propeller))


def test_static_coefficients_are_those_of_the_tested_propellers():
    """The two propellers of the UIUC site come out as they were measured there."""
    for diameter, pitch, thrust, power in ((10, 4.7, 0.1185, 0.048), (9, 6.75, 0.134, 0.0825)):
        propeller = Propeller(diameter * INCH, pitch * INCH)
        sheet = DataSheet("drone", 1.0, 0.3, propeller, max_thrust=10.0)
        values = {figure.name: figure.value for figure in sheet_figures(sheet)}
        assert values["thrust_coefficient"] == pytest.approx(thrust, rel=0.01)
        assert values["power_coefficient"] == pytest.approx(power, rel=0.01)
