"""Predictions beside flights of the diagram, and of real Crazyflies with motion capture."""

import dataclasses
import gzip
import json
from pathlib import Path

import numpy as np
import pytest

from workbench.commands.cli import main
from workbench.control.controller_file import load_controller
from workbench.design.response_metrics import response_lag
from workbench.extras.flightdata.predict.flown import make_compiled_model
from workbench.extras.flightdata.predict.past import (
    ALL_EFFECTS,
    Past,
    mean_before,
    rotor_lagged,
    thrust_doubt,
    voltage_doubt,
)
from workbench.extras.flightdata.predict.prediction import (
    CLOSED_LOOP_METHOD,
    GIVEN_ATTITUDE_METHOD,
    PREDICTION_METHODS,
    Predictor,
)
from workbench.extras.flightdata.predict.prediction_summary import summarized
from workbench.gains.gain_choice import flight_gains
from workbench.scenario.scenario import Scenario, VehicleConfig

pytestmark = pytest.mark.usefixtures("unheld")

ROOT = Path(__file__).parents[4]
FLIGHTS = ROOT / "../shared/flights/given/nanobench"
DRONES = ROOT / "tests/drones"


def test_a_lag_is_found():
    time = np.arange(0.0, 12.0, 0.01)
    setpoint = np.sin(1.3 * time)
    assert response_lag(time, setpoint, 0.2 + 1.1 * np.sin(1.3 * (time - 0.47))) == pytest.approx(
        0.47
    )


def test_nothing_looks_ahead():
    values = np.arange(50.0)[:, None]
    means = mean_before(values, np.array([10, 30]), 4)
    assert means[:, 0].tolist() == [7.5, 27.5]


def test_the_model_predicts_its_own_flight(simulate):
    flown = simulate(Scenario(), duration=3.0)
    controller = load_controller("pd")
    gains = dict(flight_gains(flown.vehicle, controller=controller))
    predictor = Predictor(flown.vehicle, controller, gains, 1 / 128)
    summary = summarized([predictor.predict(flown.motion)])
    rows = {row.method: row for row in summary.methods}
    assert tuple(rows) == PREDICTION_METHODS
    assert rows[CLOSED_LOOP_METHOD].position < 0.1 * min(
        row.position for name, row in rows.items() if name != CLOSED_LOOP_METHOD
    )
    assert rows[CLOSED_LOOP_METHOD].attitude < np.radians(1.0)
    assert abs(summary.lag_difference) <= 0.01


def test_thrust_behind_the_rotors_lag_is_steady_before_the_log(simulate):
    flown = simulate(Scenario(), duration=0.5)
    steady = rotor_lagged(np.full((10, 4), 0.7), flown.motion, flown.vehicle)
    assert steady == pytest.approx(0.7)


def test_a_drone_whose_thrust_does_not_fit_is_doubted(simulate):
    flown = simulate(Scenario(), duration=0.5)
    assert thrust_doubt(flown.motion, flown.vehicle) == ""
    heavier = dataclasses.replace(flown.vehicle, mass=1.5 * flown.vehicle.mass)
    assert "0.67 times its weight" in thrust_doubt(flown.motion, heavier)


def test_a_law_that_compensates_the_battery_without_its_voltage_is_doubted(simulate, case):
    """Where it is not known in the air; speeds need none, and other laws do not use it."""
    motion = simulate(Scenario(), duration=1.0).motion._replace(speeds_shown=False)
    nothing = np.full(len(motion.p), np.nan)
    first, last = motion.airborne
    known = np.where(np.arange(len(motion.p)) < last, 4.0, np.nan)
    hole = np.where(np.arange(len(motion.p)) == (first + last) // 2, np.nan, 4.0)
    for name, flown, gains, doubted in (
        ("no voltage", motion._replace(voltage=nothing), {"vbat": 4.2}, True),
        ("a hole", motion._replace(voltage=hole), {"vbat": 4.2}, True),
        ("none after the landing", motion._replace(voltage=known), {"vbat": 4.2}, False),
        ("another law", motion._replace(voltage=nothing), {"kp": 1.0}, False),
        ("speeds", motion._replace(voltage=nothing, speeds_shown=True), {"vbat": 4.2}, False),
    ):
        with case(name):
            assert ("full battery of 4.2 V" in voltage_doubt(flown, gains)) is doubted


def test_integrals_of_another_firmware_are_those_of_the_log(simulate):
    """PX4 has integrals of rates, too, but none of the Crazyflie's gains that scale them."""
    flown = simulate(Scenario(controller="px4"), duration=1.0)
    px4 = load_controller("px4")
    gains = dict(flight_gains(flown.vehicle, controller=px4))
    model = make_compiled_model(flown.vehicle, px4, gains, px4.period)

    def listen(*arguments):
        return np.tile(np.arange(float(len(px4.memory))), (int(1.0 / px4.period), 1))

    start = Past(flown.motion, flown.vehicle, px4, gains, model, listen).start(np.array([100]))
    assert start.memory[0].tolist() == list(range(len(px4.memory)))


def test_what_cannot_be_predicted_is_a_sentence(tmp_path, capsys):
    empty = tmp_path / "logs"
    empty.mkdir()
    bench = tmp_path / "bench.csv.gz"
    names = "t,px,py,pz,qx,qy,qz,qw,roll,pitch,yaw,vx,vy,vz"
    rows = "\n".join(f"{0.01 * k:.2f},0,0,0,0,0,0,1,0,0,0,0,0,0" for k in range(100))
    bench.write_bytes(gzip.compress(f"{names}\n{rows}\n".encode()))
    for said, arguments in (
        ("this folder has no logs", [str(empty)]),
        ("a prediction needs", [str(bench)]),
        ("effect", [str(bench), "--without", "luck"]),
        ("--horizon", [str(bench), "--horizon", "nan"]),
    ):
        arguments += ["--model", "dh_drone", "--output", str(tmp_path / "out")]
        assert main(["predict", *arguments]) == 2
        assert said in capsys.readouterr().err
    assert not list((tmp_path / "out").glob("*"))


@pytest.mark.slow
@pytest.mark.skipif(not FLIGHTS.exists(), reason="put the real flights into ../shared/flights")
def test_real_flights_are_predicted(tmp_path, capsys):
    """All flights of NanoBench that are given: the figures of docs/prediction.md."""
    model = DRONES / "nanobench.urdf"
    assert main(["predict", str(FLIGHTS), "--model", str(model), "--json", "--no-plots",
                 "--output", str(tmp_path)]) == 0  # fmt: skip
    summary = json.loads(capsys.readouterr().out)["summary"]
    rows = {row["method"]: row for row in summary["methods"]}
    assert summary["flights"] == 33 and summary["windows"] > 9000
    assert rows[CLOSED_LOOP_METHOD]["position"] <= 0.042
    assert rows[CLOSED_LOOP_METHOD]["velocity"] <= 0.23
    assert np.degrees(rows[CLOSED_LOOP_METHOD]["attitude"]) <= 5.5
    assert rows[GIVEN_ATTITUDE_METHOD]["position"] <= 0.017
    assert summary["whole"] <= 0.065
    assert abs(summary["lag_difference"]) <= 0.03


def test_the_drone_of_these_flights_is_that_of_the_crazyflie_but_for_the_air():
    from workbench.plant.loading import make_vehicle
    from workbench.scenario.configured import read_configured

    ours, plain = (
        make_vehicle(read_configured(VehicleConfig(model=str(DRONES / f"{name}.urdf"))))
        for name in ("nanobench", "crazyflie")
    )
    assert ours.mass == plain.mass and ours.rotor_lag == plain.rotor_lag
    assert ours.hover_speeds == pytest.approx(plain.hover_speeds)


@pytest.mark.slow  # the law of a firmware is compiled
def test_inner_integrals_hold_the_moment_of_the_air(simulate):
    """A Crazyflie whose rotors' drag acts above its centre of mass, at up to 1 m/s."""
    config = VehicleConfig(model=str(DRONES / "nanobench.urdf"))
    flown = simulate(Scenario(controller="crazyflie", vehicle=config), duration=3.5)
    controller = load_controller("crazyflie")
    gains = dict(flight_gains(flown.vehicle, controller=controller))
    errors = []
    for moment in (True, False):
        effects = ALL_EFFECTS._replace(
            moment=moment, thrust=False
        )  # the motion's commands are made up
        predictor = Predictor(flown.vehicle, controller, gains, controller.period, effects=effects)
        errors.append(summarized([predictor.predict(flown.motion)]).methods[0])
    held, not_held = errors
    assert held.attitude < 0.6 * not_held.attitude
    assert held.position < 0.02
