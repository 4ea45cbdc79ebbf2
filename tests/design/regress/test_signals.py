"""What signals of a spec are taken from, on a recording in which no two numbers are equal."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.common.errors import WorkbenchError
from workbench.design.regress.flight import CaseFlight, fly_case
from workbench.design.regress.signals import find_signal, sensor_signal
from workbench.design.regress.spec import SpecCase
from workbench.scenario.scenario import Action
from workbench.session.recording import Recording
from workbench.setup import make_setup
from workbench.systems.sensors.samples import SampleTable

STEP, COUNT = 0.01, 60


@pytest.fixture
def recording(vehicle) -> Recording:
    random = np.random.default_rng(4)
    n = len(vehicle.rotors)
    sizes = {"q_WB": 4, "commanded_speeds": n, "rotor_speeds": n, "thrusts": n, "reference": 8}
    flat = {"mode", "charge", "clearance"}
    arrays = {
        each.name: random.normal(
            size=COUNT if each.name in flat else (COUNT, sizes.get(each.name, 3))
        )
        for each in dataclasses.fields(Recording)[2:]
        if each.default_factory is dataclasses.MISSING
    }
    return Recording(vehicle=vehicle, time=STEP * np.arange(COUNT), **arrays)


def test_a_component_is_that_of_its_axis_and_a_rotor_counts_from_1(recording):
    for name, array in (
        ("v", recording.v_WB),
        ("p", recording.p_WB),
        ("w", recording.w_WB),
        ("a", recording.vdot_WB),
    ):
        for index, axis in enumerate("xyz"):
            assert (find_signal(f"{name}_{axis}").of(recording) == array[:, index]).all(), name
    assert (find_signal("yaw_rate").of(recording) == recording.w_WB[:, 2]).all()
    for name, array in (("speed", recording.rotor_speeds), ("thrust", recording.thrusts)):
        for index in range(4):
            assert (find_signal(f"{name}_{index + 1}").of(recording) == array[:, index]).all()
    assert find_signal("thrust").of(recording) == pytest.approx(recording.thrusts.sum(axis=1))


def test_a_sensors_signal_is_its_last_sample_that_has_been_delivered(recording):
    """Of 0, 0.1, .. s, each delivered 0.05 s later: at 0.14 s that of 0, at 0.15 s that of 0.1."""
    stamps = 0.1 * np.arange(6)
    table = SampleTable("gps", ("v_x [m/s]",), stamps, 7.0 + np.arange(6)[:, None], latency=0.05)
    signal = sensor_signal("gps.v_x", [table])
    late = recording.between(0.05, 1.0)
    found = dict(zip(np.round(late.time, 2), signal.of(late), strict=True))
    assert (signal.unit, found[0.05], found[0.14], found[0.15], found[0.3]) == ("m/s", 7, 7, 8, 9)
    with pytest.raises(WorkbenchError, match="'gps' delivers first at 0.05 s"):
        signal.of(recording)


@pytest.mark.parametrize(("name", "axis"), [("roll", 0), ("pitch", 1), ("yaw", 2)])
def test_an_angle_is_that_about_its_own_axis(recording, name, axis):
    angles = np.linspace(-0.5, 0.6, COUNT)
    q = Rotation.from_rotvec(np.outer(angles, np.eye(3)[axis])).as_quat(scalar_first=True)
    turned = dataclasses.replace(recording, q_WB=q)
    for each in ("roll", "pitch", "yaw"):
        wanted = angles if each == name else np.zeros(COUNT)
        if each == "yaw":
            wanted = wanted - wanted[0] + find_signal("yaw").of(turned)[0]
        assert find_signal(each).of(turned) == pytest.approx(wanted, abs=1e-9), each


@pytest.mark.parametrize(("axis", "column"), [("y", 1), ("yaw", 3)])
def test_a_response_follows_the_command_that_acts_from_its_time_on(recording, axis, column):
    """A sample has the command of the period before it, so the next one has what acts now."""
    flight = CaseFlight(recording, edge=0.2, axis=axis, signal="", command=1.0)
    followed = flight.followed
    command = recording.reference[:, column]
    assert followed.setpoint[:-1] == pytest.approx(command[1:])
    response = recording.w_WB[:, 2] if axis == "yaw" else recording.v_WB[:, 1]
    assert followed.response == pytest.approx(response)


@pytest.mark.parametrize(("at", "changed"), [(0.05, False), (0.2, True)])
def test_only_a_change_of_parameters_from_the_edge_on_withholds(at, changed):
    script = [Action(at=at, set={"kp_velocity_x": 2.0})]
    case = SpecCase(name="set", edge=0.1, duration=0.2, script=script, signal="v_x", command=1.0)
    assert fly_case(case, make_setup(None)).changed is changed
