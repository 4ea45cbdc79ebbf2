"""Oracles: a flight in closed form, sampled as the recorder does, and a flown one."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model, find_scenario
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.vehicle_frames import frame_tree
from workbench.scenario.scenario import load_scenario
from workbench.session.frames import FlightFrames
from workbench.session.recording import Recording
from workbench.session.session import Session

STEP = 1 / 128
ACCELERATION = np.array([3.0, -4.0, 8.0])
SPIN = 50.0
"""Angular acceleration about `AXIS` [rad/s²]."""
AXIS = np.array([0.6, 0.0, 0.8])
START = np.array([1.0, 2.0, 3.0])


@pytest.fixture(scope="module")
def description():
    return read_description(find_model("dh_drone"))


@pytest.fixture(scope="module")
def vehicle(description):
    return make_vehicle(description)


@pytest.fixture(scope="module")
def tree(vehicle, description):
    return frame_tree(vehicle, description.model)


def place(time: float) -> np.ndarray:
    return START + 0.5 * ACCELERATION * time**2


def turned(time: float) -> np.ndarray:
    half = 0.25 * SPIN * time**2
    return np.array([math.cos(half), *(math.sin(half) * AXIS)])


def recording_of(vehicle, count: int) -> Recording:
    time = STEP * np.arange(count)
    n = len(vehicle.rotors)
    sizes = {"v_WB": 3, "w_WB": 3, "vdot_WB": 3, "wdot_WB": 3, "reference": 8, "wind_W": 3}
    sizes |= {"commanded_speeds": n, "rotor_speeds": n, "thrusts": n}
    return Recording(
        vehicle=vehicle,
        time=time,
        p_WB=np.array([place(t) for t in time]).reshape(-1, 3),
        # a log may change a quaternion's sign, which means the same
        q_WB=np.array([(-1) ** i * turned(t) for i, t in enumerate(time)]).reshape(-1, 4),
        mode=np.zeros(count),
        charge=np.zeros(count),
        clearance=np.full(count, math.inf),
        **{name: np.zeros((count, size)) for name, size in sizes.items()},
    )


@pytest.fixture(scope="module")
def frames(vehicle, tree):
    return FlightFrames(tree, recording_of(vehicle, 65))


def test_at_samples_it_is_the_sample(frames):
    for i, time in enumerate(frames.recording.time):
        X_WB = frames.X("world", "base_link", time)
        assert X_WB.translation() == pytest.approx(frames.recording.p_WB[i], abs=1e-14)
        wanted = RotationMatrix(Quaternion(frames.recording.q_WB[i]))
        assert X_WB.rotation().matrix() == pytest.approx(wanted.matrix(), abs=1e-12)


def test_between_samples_it_is_off_by_no_more_than_it_says(frames):
    """h²/8 times the acceleration, which the middle between samples comes up to."""
    place_off, angle_off = [], []
    for time in np.linspace(0.0, 0.5, 1001):
        X_WB = frames.X_WB(time)
        place_off.append(np.linalg.norm(X_WB.translation() - place(time)))
        error = RotationMatrix(Quaternion(turned(time))).InvertAndCompose(X_WB.rotation())
        angle_off.append(abs(error.ToAngleAxis().angle()))
    most = STEP**2 / 8.0 * np.linalg.norm(ACCELERATION)
    assert 0.9 * most < max(place_off) <= most * (1.0 + 1e-9)
    most = STEP**2 / 8.0 * SPIN
    assert 0.9 * most < max(angle_off) <= most * (1.0 + 1e-6)


def test_frames_go_with_the_drone(frames, vehicle):
    X_WB = frames.X_WB(0.3)
    found = frames.X("world", "lidar", 0.3).translation()
    (lidar,) = (sensor for sensor in vehicle.sensors if sensor.name == "lidar")
    assert found == pytest.approx(X_WB @ np.array(lidar.p_BS), abs=1e-12)


@pytest.mark.parametrize("time", [-0.001, 0.501, math.nan, math.inf])
def test_times_outside_of_the_flight_are_refused(frames, time):
    with pytest.raises(WorkbenchError, match=r"no time .* s: give one from 0 to 0.5 s"):
        frames.X("world", "lidar", time)


def test_the_ends_of_a_flight_may_be_met_to_rounding(frames):
    for time, sample in ((-1e-12, 0), (0.5 + 1e-12, -1)):
        found = frames.X_WB(time).translation()
        assert found == pytest.approx(frames.recording.p_WB[sample], abs=1e-12)


def test_a_flight_of_one_sample_and_one_of_none(vehicle, tree):
    one = FlightFrames(tree, recording_of(vehicle, 1))
    assert one.X_WB(0.0).translation() == pytest.approx(START)
    with pytest.raises(WorkbenchError, match="no samples"):
        FlightFrames(tree, recording_of(vehicle, 0)).X_WB(0.0)


def test_of_a_flown_flight_every_other_sample_tells_the_ones_between(tree):
    """At twice the usual distance of samples, four times the bound, for what was flown."""
    scenario = dataclasses.replace(load_scenario(find_scenario("square")), duration=4.0)
    session = Session(scenario)
    session.run()
    flight = session.recording()
    halves = {
        field.name: getattr(flight, field.name)[::2]
        for field in dataclasses.fields(flight)
        if field.name != "vehicle"
    }
    frames = FlightFrames(tree, Recording(vehicle=flight.vehicle, **halves))
    for i in range(1, len(flight.time) - 1, 2):
        found = frames.X_WB(flight.time[i])
        around = slice(i - 1, i + 2)
        most = (2 * STEP) ** 2 / 8.0
        fastest = np.linalg.norm(flight.vdot_WB[around], axis=1).max()
        off = np.linalg.norm(found.translation() - flight.p_WB[i])
        assert off <= 1.5 * most * fastest + 1e-5
        wanted = RigidTransform(Quaternion(flight.q_WB[i]), flight.p_WB[i])
        angle = abs(wanted.rotation().InvertAndCompose(found.rotation()).ToAngleAxis().angle())
        spin = np.linalg.norm(flight.wdot_WB[around], axis=1).max()
        assert angle <= 1.5 * most * spin + 1e-5
