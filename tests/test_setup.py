"""What flies is read once: nothing that is built of it needs the files any more."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.controllers import pd
from workbench.design.linear.study import LinearStudy
from workbench.gains.gain_choice import flight_gains
from workbench.gains.gains import GainFile, save_gains
from workbench.plant.loading import load_vehicle
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Action, Scenario, SensorsConfig, VehicleConfig
from workbench.session.session import Session
from workbench.setup import make_setup

DRONES = Path(__file__).parent / "drones"
FIRM = {"kp_yaw_rate": 4.0}
SETTINGS = {"wind_x": 2.0}


@pytest.fixture
def folder(tmp_path):
    """A folder with description, law, gains and world of its own."""
    shutil.copy(DRONES / "crazyflie.urdf", tmp_path)
    shutil.copy(DRONES / "crazyflie.rotors.yaml", tmp_path)
    shutil.copy(pd.__file__, tmp_path / "mine.py")
    law = load_controller(tmp_path / "mine.py")
    save_gains(tmp_path / "gains.yaml", GainFile("other", "", FIRM, controller="mine"), law)
    (tmp_path / "far.yaml").write_text(
        "obstacles: [{name: box, shape: {box: [1, 1, 1]}, position: [40, 30, 0.5]}]"
    )
    return tmp_path


def scenario_of(folder: Path) -> Scenario:
    return Scenario(
        vehicle=VehicleConfig(
            model=str(folder / "crazyflie.urdf"), gains=str(folder / "gains.yaml")
        ),
        controller=str(folder / "mine.py"),
        world=str(folder / "far.yaml"),
        duration=0.5,
        script=[Action(velocity=[1.0, 0.0, 0.0])],
    )


def flown(session: Session) -> np.ndarray:
    session.run()
    return session.recording().p_WB


def test_what_is_built_of_it_reads_no_file(folder):
    """It flies and is linearised as it was, although all its files are gone."""
    scenario = scenario_of(folder)
    wanted, poles = flown(Session(scenario, SETTINGS)), LinearStudy(scenario).sampled().A
    setup = make_setup(scenario, SETTINGS)
    plain = make_setup(scenario)
    shutil.rmtree(folder)
    with pytest.raises(WorkbenchError):
        make_setup(scenario)
    assert np.array_equal(flown(Session(setup)), wanted)
    assert np.array_equal(LinearStudy(plain).sampled().A, poles)
    heavy = flown(Session(setup.varied(Variation(mass=1.2))))
    assert np.abs(heavy - wanted).max() > 1e-3
    again = Session(setup)
    again.follow([], 0.25)
    assert len(flown(again)) == 33


def test_what_flies_has_a_record_of_its_own_only_if_it_differs(folder):
    """Heavier by a fifth, with rotors half as fast; the law's vehicle is as before."""
    setup = make_setup(scenario_of(folder))
    assert setup.flown_vehicle is setup.vehicle
    varied = setup.varied(Variation(mass=1.2, rotor_lag=2.0))
    assert varied.flown_vehicle.mass == pytest.approx(1.2 * setup.vehicle.mass)
    assert varied.flown_vehicle.rotor_lag == pytest.approx(2.0 * setup.vehicle.rotor_lag)
    assert varied.vehicle is setup.vehicle


def test_values_are_those_of_the_vehicle_its_gain_file_and_the_settings(folder):
    setup = make_setup(scenario_of(folder), SETTINGS)
    vehicle = load_vehicle(folder / "crazyflie.urdf")
    own = flight_gains(vehicle, controller=load_controller(folder / "mine.py"))
    assert dict(setup.values) == {**own, **FIRM, **SETTINGS}
    assert make_setup(setup) is setup
    turned = make_setup(setup, {"kp_yaw_rate": 5.0})
    assert dict(turned.values) == {**setup.values, "kp_yaw_rate": 5.0}
    assert dict(turned.settings) == {**SETTINGS, "kp_yaw_rate": 5.0}
    for wrong in ({"kp_nothing": 1.0}, {"wind_x": 1e6}, {"rotor_9": 0.5}):
        with pytest.raises(WorkbenchError):
            setup.with_settings(wrong)


def test_another_scenario_has_its_own_sensors_and_the_same_vehicle():
    setup = make_setup()
    assert setup.sensors == ()
    sensors = SensorsConfig(use=["gps"], keep=True)
    other = setup.with_scenario(Scenario(vehicle=VehicleConfig("nowhere"), sensors=sensors))
    assert [(each.sensor.kind, each.kept) for each in other.sensors] == [("gps", True)]
    assert other.vehicle is setup.vehicle


def test_another_script_is_checked_and_a_period_is_that_of_the_law(folder):
    text = (folder / "mine.py").read_text()
    (folder / "mine.py").write_text(f"{text}\n\nPERIOD = 1 / 256\n")
    setup = make_setup(scenario_of(folder))
    assert setup.rates.control_period == 1 / 256
    with pytest.raises(WorkbenchError, match="kp_nothing"):
        setup.with_scenario(Scenario(script=[Action(set={"kp_nothing": 1.0})]))
