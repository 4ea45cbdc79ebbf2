"""Flights on an estimate with a battery that sags: the charge and the voltage as they are known."""

import re
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode, Reason
from workbench.design.estimation_errors import judge_estimate
from workbench.scenario.scenario import Scenario, ScenarioStart, SensorsConfig, VehicleConfig
from workbench.session.session import Session

ORACLES = Path(__file__).parents[1] / "oracles"
DURATION, RESISTANCE, CAPACITY = 20.0, 0.06, 300.0
POINTS = [[0.0, 10.8], [0.8, 12.0], [1.0, 12.6]]
IMU = """
  <gazebo reference="base_link">
    <sensor name="imu" type="imu"><update_rate>200</update_rate></sensor>
    <sensor name="gps" type="navsat"><update_rate>10</update_rate></sensor>
  </gazebo>
</robot>"""


@pytest.fixture(scope="module")
def drone(tmp_path_factory):
    """Return a drone with a battery of 20 s, an exact IMU and an exact GPS."""
    folder = tmp_path_factory.mktemp("drone")
    urdf = (ORACLES / "uneven_quad.urdf").read_text(encoding="utf-8")
    (folder / "drone.urdf").write_text(urdf.replace("</robot>", IMU), encoding="utf-8")
    battery = f"battery: {{capacity: {CAPACITY}, resistance: {RESISTANCE}, "
    battery += f"open_circuit_voltage: {POINTS}}}"
    text = (ORACLES / "effects.rotors.yaml").read_text(encoding="utf-8")
    (folder / "rotors.yaml").write_text(re.sub("battery: .*", battery, text), encoding="utf-8")
    return VehicleConfig(str(folder / "drone.urdf"), rotors=str(folder / "rotors.yaml"))


def flown(drone, duration, estimator="ekf", **settings):
    scenario = Scenario(
        vehicle=drone,
        estimator=estimator,
        start=ScenarioStart(position=[0.0, 0.0, 50.0]),
        duration=duration,
        sensors=SensorsConfig(seed=2),
    )
    values = {"battery_duration": DURATION, "battery_reserve": 0.0, **settings}
    session = Session(scenario, values)
    session.run()
    return session


@pytest.mark.slow
@pytest.mark.parametrize(
    "rows",
    [
        ((1.0, 0.1),),
        pytest.param(((0.0, 0.0), (1.0, 0.0), (0.0, 0.1)), marks=pytest.mark.slow),
    ],
    ids=["both", "neither or one"],
)
def test_the_charge_is_known_over_a_whole_discharge(drone, rows, case):
    """In hover it falls evenly; rotors go to voltage times command, raised for what is known."""
    for compensation, noise in rows:
        with case(compensation, noise):
            session = flown(
                drone, 0.93 * DURATION, sag_compensation=compensation, voltage_noise=noise
            )
            flight = session.recording()
            closed = 1.0 - flight.time / DURATION
            assert flight.known_charge[:, 0] == pytest.approx(closed, abs=0.01)
            row = judge_estimate(flight).states[-1]
            off = flight.charge - flight.known_charge[:, 0]
            assert (row.name, row.unit) == ("charge", "1")
            assert row.worst == np.abs(off).max()
            assert row.rms == pytest.approx(np.sqrt(np.mean(off**2)))
            assert row.worst < 1e-6 if noise == 0.0 else 1e-4 < row.worst < 0.01
            for time in (0.2 * DURATION, 0.5 * DURATION, 0.91 * DURATION):
                now = flight.between(time, time + 0.1)
                curve = tuple(zip(*POINTS, strict=True))
                drop = RESISTANCE * CAPACITY / DURATION
                voltage, known = (
                    (np.interp(charge[0], *curve) - drop) / 12.6
                    for charge in (now.charge, now.known_charge[:, 0])
                )
                wanted = session.vehicle.hover_speeds / voltage
                wanted *= 1.0 + compensation * (known - 1.0)
                assert now.commanded_speeds[0] == pytest.approx(wanted, rel=0.01)


def test_compensation_and_law_go_by_the_charge_that_is_known(drone, case):
    """With rotors at rest the voltage is that without load, of the charge that the gauge tells."""
    diagram = Session(Scenario(vehicle=drone, estimator="ekf")).diagram
    root = diagram.CreateDefaultContext()
    gauge, battery, computer = (
        (system := diagram.GetSubsystemByName(name), system.GetMyMutableContextFromRoot(root))
        for name in ("gauge", "battery", "controller")
    )
    for charge, voltage in ((1.0, 12.6), (0.8, 12.0), (0.4, 11.4), (0.0, 10.8)):
        with case(charge):
            gauge[1].SetDiscreteState([charge])
            supply = battery[0].GetOutputPort("supply").Eval(battery[1])
            assert (supply[0], supply[3]) == pytest.approx((1.0, voltage / 12.6))
            heard = computer[0].GetInputPort("voltage").Eval(computer[1])
            assert heard == pytest.approx([voltage / 12.6])


@pytest.mark.slow
def test_it_lands_by_the_charge_that_is_known_and_noise_is_that_of_the_seed(drone):
    flights = [
        flown(drone, 0.2 * DURATION, battery_reserve=0.85, voltage_noise=3.0).recording()
        for _ in range(2)
    ]
    assert np.array_equal(flights[0].known_charge, flights[1].known_charge)
    flight = flights[0]
    landing = np.argmax(flight.mode == FlightMode.LANDING)
    assert flight.reason[landing] == Reason.BATTERY_LOW
    below = np.argmax(flight.known_charge[:, 0] <= 0.85)
    assert 0.0 <= flight.time[landing] - flight.time[below] <= 0.26
    assert abs(flight.charge[landing] - 0.85) > 0.002  # the truth would have it land elsewhere


def test_on_the_truth_nothing_is_estimated_and_the_row_is_refused(drone):
    session = flown(drone, 0.5, estimator="truth")
    assert not session.recording().known_charge.size
    with pytest.raises(WorkbenchError, match="voltage_noise cannot be set: .*--estimator ekf"):
        session.set("voltage_noise", 0.1)
