"""`workbench estimate`."""

import csv
import dataclasses
import math

import numpy as np
import pytest

from workbench.commands.estimate import underestimated_settings
from workbench.design.estimation_errors import Innovations
from workbench.estimation.settings import EkfSettings
from workbench.logs.flight_log import FlightLog, LoggedFlight
from workbench.logs.record import read_log
from workbench.scenario.scenario import Action, Scenario, VehicleConfig
from workbench.scenario.sensors_config import SensorsConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

FLIGHT = Scenario(
    duration=1.5,
    vehicle=VehicleConfig(args={"gps_noise": "0.5"}),
    sensors=SensorsConfig(use=["imu", "gps", "magnetometer"]),
    script=[Action(0.5, velocity=[1.0, 0.0, 0.0])],
)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """The log of a flight on the truth, with a setting of the filter."""
    path = tmp_path_factory.mktemp("logs") / "flown.mcap"
    LoggedFlight(path, FLIGHT, {"ekf_gps_height": 1.5}).run(lambda share: None)
    return path


def table(path):
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


def test_errors_innovations_table_and_picture(run, path, out):
    said = run("estimate", path, "--output", out)
    assert said.code == 0, said.err
    title, heading, *_ = said.out.splitlines()
    assert title == "dh_drone: flown.mcap, ekf, 0.00 .. 1.50 s"
    assert heading.split() == ["estimate", "RMS", "error", "worst"]
    assert {"deg", "m/s"} <= {line.split()[-1] for line in said.out.splitlines() if line}
    assert "NEES of attitude, position and velocity" in said.out
    assert (
        "has no samples of barometer and range finder: the estimate does not use them" in said.err
    )
    assert (out / "flown-estimate.png").read_bytes().startswith(b"\x89PNG")
    rows = table(out / "flown-estimate.csv")
    record = read_log(path)
    states = dict(zip(record.state_ns, record.states, strict=True))
    assert len(rows) == len(record.topics["imu"].t_ns)
    both = [(row, states.get(round(float(row["t [s]"]) * 1e9))) for row in rows]
    both = [(row, truth) for row, truth in both if truth is not None]
    assert len(both) > 35  # the IMU samples every 5, the state comes every 8 physics steps
    for row, truth in both:
        assert [float(row[f"p_W.{x} [m]"]) for x in "xyz"] == pytest.approx(truth[4:7])
        for index, x in enumerate("xyz"):
            gap = float(row[f"estimate.p_W.{x} [m]"]) - truth[4 + index]
            assert abs(gap) < 5.0 * float(row[f"deviation.p_W.{x} [m]"])
    worst = max(abs(float(row["p_W.x [m]"]) - float(row["estimate.p_W.x [m]"])) for row in rows)
    (line,) = (line for line in said.out.splitlines() if line.startswith("x "))
    assert float(line.split()[2]) == pytest.approx(worst, abs=6e-4)


def test_json_has_what_was_run_and_what_it_gave(run, path, out):
    said = run(
        *("estimate", path, "--json", "--no-plots", "--output", out),
        *("--set", "ekf_gps_position=0.3"),
    )
    assert said.code == 0, said.err
    found = said.json
    expected = EkfSettings(ekf_gps_height=1.5, ekf_gps_position=0.3)
    assert found["settings"] == pytest.approx(expected._asdict())
    assert found["estimator"] == "ekf"
    assert found["missing"] == ["barometer", "range_finder"]
    assert found["gaps"] == []
    assert found["files"] == [str(out / "flown-estimate.csv")]
    assert not (out / "flown-estimate.png").exists()
    states = {each["name"]: each for each in found["estimate"]["states"]}
    assert 0.0 < states["roll"]["rms"] <= states["roll"]["worst"] < math.radians(0.5)
    assert {each["channel"] for each in found["estimate"]["innovations"]} == {
        *("gps_x", "gps_y", "gps_z", "gps_v_x", "gps_v_y", "gps_v_z", "magnetometer")
    }


def test_the_complementary_filter_knows_no_deviations(run, path, out):
    words = ("estimate", path, "--estimator", "complementary", "--no-plots", "--json")
    said = run(*words, "--output", out)
    assert said.code == 0, said.err
    assert said.json["estimate"]["nees"] is None
    assert said.json["estimate"]["innovations"] == []
    row, *_ = table(out / "flown-estimate.csv")
    assert row["deviation.p_W.x [m]"] == ""


def test_a_silent_imu_is_told(run, logged, tmp_path, out):
    """From 0.2 to 0.4 s of half a second; the messages that a bridge keeps are more than that."""
    faults = [Action(0.2, set={"imu_fault": 3.0}), Action(0.4, set={"imu_fault": 0.0})]
    scenario = Scenario(duration=0.5, sensors=SensorsConfig(use=["imu"]), script=faults)
    log = logged(scenario, tmp_path / "silent.mcap")
    said = run("estimate", log, "--json", "--no-plots", "--output", out)
    assert said.code == 0, said.err
    (gap,) = said.json["gaps"]
    assert gap["begin"] == pytest.approx(0.2, abs=0.01)
    assert gap["length"] == pytest.approx(0.2, abs=0.02)
    assert "the IMU is silent once, longest for 0.2" in said.err
    assert "has no samples of gps, barometer, magnetometer and range finder" in said.err


def test_an_estimate_of_a_flight_on_an_estimate_is_the_flights_estimator(run, logged, tmp_path):
    scenario = Scenario(
        duration=0.3, estimator="complementary", sensors=SensorsConfig(use=["imu", "gps"])
    )
    log = logged(scenario, tmp_path / "on.mcap")
    said = run("estimate", log, "--json", "--no-plots", "--output", tmp_path)
    assert said.json["estimator"] == "complementary"


def test_a_log_that_was_cut_is_told_and_run(run, path, tmp_path):
    cut = tmp_path / "cut.mcap"
    whole = path.read_bytes()
    cut.write_bytes(whole[: len(whole) // 2])
    said = run("estimate", cut, "--json", "--no-plots", "--output", tmp_path)
    assert said.code == 0, said.err
    assert "was not closed and ends at" in said.err
    assert 0.3 < said.json["end"] < 1.4


def test_wrong_input_is_a_sentence_and_leaves_nothing(refused, log, path, tmp_path, write, out):
    there = ("--output", out)
    assert "no such file" in refused("estimate", tmp_path / "none.mcap", *there)
    assert "is not an MCAP file" in refused("estimate", write("a.mcap", "t,v"), *there)
    assert "has no samples of an IMU, which every estimator needs" in refused(
        "estimate", log, *there
    )
    assert "unknown setting of ekf 'ekf_gate_'" in refused(
        "estimate", path, "--set", "ekf_gate_=3", *there
    )
    assert "ekf_gate is a setting of ekf, but complementary runs: add `--estimator ekf`" in refused(
        "estimate", path, "--estimator", "complementary", "--set", "ekf_gate=3", *there
    )
    assert "ekf_gate is -1" in refused("estimate", path, "--set", "ekf_gate=-1", *there)
    assert "unknown estimator 'truth'" in refused("estimate", path, "--estimator", "truth", *there)
    assert not out.exists()


def test_a_vehicle_that_is_another_one_by_now_is_refused(refused, tmp_path, out):
    scenario = dataclasses.replace(FLIGHT, duration=0.2)
    session = Session(scenario, bridge=Bridge())
    session.run()
    samples = session.drain()

    def write(name, vehicle, flown=scenario):
        log = FlightLog(tmp_path / name, session.topics, flown, {}, {}, vehicle)
        for sampled in samples:
            log.write(sampled)
        log.close()
        return tmp_path / name

    said = refused("estimate", write("other.mcap", "my_drone"), "--output", out)
    assert "was flown by my_drone, and dh_drone is dh_drone now" in said
    bare = dataclasses.replace(scenario, vehicle=VehicleConfig(args={"imu": "false"}))
    bare.sensors = SensorsConfig(use=["gps"])
    said = refused("estimate", write("bare.mcap", "dh_drone", bare), "--output", out)
    assert "has none now" in said
    gone = dataclasses.replace(scenario, vehicle=VehicleConfig(model=str(tmp_path / "gone.urdf")))
    said = refused("estimate", write("gone.mcap", "dh_drone", gone), "--output", out)
    assert "gone.urdf" in said
    assert np.isfinite(read_log(tmp_path / "other.mcap").states).all()


def test_a_log_of_a_flight_on_an_estimate_needs_no_further_option(run, out):
    """The IMU is in it by itself, and the flight is the same as without a log.

    Its samples end steps of the integrator, which moves the last digits.
    """
    path, short = out / "flown.mcap", ("--duration", "0.5", "--no-plots", "--output", out)
    flown = []
    for log in ((), ("--log", path)):
        for estimator in ("complementary", "ekf"):
            said = run("fly", "hover", "--estimator", estimator, *log, *short)
            assert said.code == 0, said.err
            flown.append(table(out / "hover.csv"))
            if log:
                told = run("estimate", path, "--no-plots", "--output", out, "--json")
                assert told.code == 0, told.err
                assert told.json["estimator"] == estimator
                assert told.json["missing"] == ["barometer", "range_finder"]
                (x,) = (row for row in told.json["estimate"]["states"] if row["name"] == "x")
                assert 0.0 < x["worst"] < 0.5
    for alone, written in zip(flown[:2], flown[2:], strict=True):
        for row, other in zip(alone, written, strict=True):
            for name, value in row.items():
                size = 1e-7 if name.startswith("p_W") else 1e-3
                assert (value and float(value)) == pytest.approx(
                    other[name] and float(other[name]), abs=size, nan_ok=True
                ), name
    assert flown[0] != flown[1]


def test_a_sensor_that_is_worse_than_its_setting_is_named():
    """A GPS with errors of 1 m, of which the filter assumes 0.5 m, has half of them in bounds."""
    told = [
        Innovations("gps_x", 300, 0.51, 2.1, "ekf_gps_position"),
        Innovations("gps_y", 300, 0.6, 1.8, "ekf_gps_position"),
        Innovations("gps_z", 300, 0.93, 1.1, "ekf_gps_height"),
        Innovations("barometer", 20, 0.8, 1.3, "ekf_barometer"),  # of so few, by chance
        Innovations("magnetometer", 300, 0.7, 1.5, "ekf_magnetometer"),
    ]
    assert underestimated_settings(told) == [
        "gps_x, gps_y: up to 2.1 times as far from the estimate as it assumes: raise "
        "ekf_gps_position about as much (--set), or look for a fault of the sensor",
        "magnetometer: up to 1.5 times as far from the estimate as it assumes: raise "
        "ekf_magnetometer about as much (--set), or look for a fault of the sensor",
    ]


def test_the_setting_that_is_too_small_is_named(run, path, out):
    words = ("estimate", path, "--no-plots", "--output", out)
    assert "as it assumes" not in run(*words).out
    said = run(*words, "--set", "ekf_magnetometer=1e-7").out
    assert "magnetometer: up to " in said and "raise ekf_magnetometer about as much" in said
