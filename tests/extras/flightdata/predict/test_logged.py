"""What predictions start from, out of records that are made up here: signals, motors, laws."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.extras.flightdata.predict.logged import (
    LOGGED_ESTIMATE_SIGNALS,
    TRUE_STATE_SIGNALS,
    flown_law,
    flown_law_name,
    motion_of,
)
from workbench.extras.flightdata.predict.past import rotor_lagged, steady_thrusts
from workbench.logs.flight_reader import read_flight
from workbench.logs.logged_signal import SETPOINT_SIGNALS
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

pytestmark = pytest.mark.usefixtures("unheld")

TIME = np.arange(0.0, 2.0, 0.01)
MOTORS = tuple(f"motors.command_{number}" for number in (1, 2, 3, 4))
RATES = tuple(f"estimate.w_{axis}" for axis in "xyz")


@pytest.fixture(scope="module")
def vehicle():
    """The shipped drone, of four rotors."""
    return configured_vehicle(VehicleConfig(model="dh_drone"))


@pytest.fixture
def make(tmp_path):
    """Returns a record of signals that all rise from 0.1, but for some values."""

    def made(names, values=None, **about) -> Flight:
        found = {name: 0.1 + 0.01 * TIME for name in names} | (values or {})
        signals = {
            name: make_series(name, "1", TIME, each, end=TIME[-1]) for name, each in found.items()
        }
        source = tmp_path / "flight.csv"
        return Flight("flight", source, "made up", signals, end=TIME[-1], **about)

    return made


def test_the_estimate_is_the_motion_where_nothing_else_measured_it(make, vehicle):
    motion = motion_of(
        make((*LOGGED_ESTIMATE_SIGNALS, *RATES, *SETPOINT_SIGNALS, *MOTORS)), vehicle
    )
    assert np.array_equal(motion.p, motion.p_known) and np.array_equal(motion.q, motion.q_known)
    assert motion.commands[0] == pytest.approx(0.1)  # shares, and no speeds
    names = (
        *LOGGED_ESTIMATE_SIGNALS,
        *TRUE_STATE_SIGNALS,
        *RATES,
        *SETPOINT_SIGNALS,
        *MOTORS,
        *(f"attitude.w_{axis}" for axis in "xyz"),
    )
    measured = {"position_data.x": 0.5, "velocity_data.v_y": -0.7, "attitude.q_x": -0.1}
    both = motion_of(
        make(names, {name: each + 0.0 * TIME for name, each in measured.items()}), vehicle
    )
    assert both.p[0, 0] == 0.5 and both.p_known[0, 0] == pytest.approx(0.1)
    assert both.v[0, 1] == -0.7 and both.v_known[0, 1] == pytest.approx(0.1)
    assert both.q[0, 1] < 0.0 < both.q_known[0, 1]


def test_without_rates_they_are_those_of_the_attitude(make, vehicle):
    """About all axes in turn: from each sample to the next, by scipy, in the body's axes."""
    turn = Rotation.from_rotvec(np.sin(np.outer(TIME, [1.0, 1.7, 2.3]) + [0.0, 1.0, 2.0]))
    q = turn.as_quat(scalar_first=True)
    q *= np.sign(np.sum(q * q[0], axis=1))[:, None]
    motion = motion_of(
        make(
            (*LOGGED_ESTIMATE_SIGNALS, *SETPOINT_SIGNALS, *MOTORS),
            dict(zip(LOGGED_ESTIMATE_SIGNALS[:4], q.T, strict=True)),
        ),
        vehicle,
    )
    between = (turn[:-1].inv() * turn[1:]).as_rotvec() / 0.01
    wanted = 0.5 * (between[1:] + between[:-1])
    np.testing.assert_allclose(motion.w[1:-1], wanted, atol=2e-3)


def test_speeds_of_the_rotors_show_their_lag_and_commands_do_not(make, vehicle, case):
    for head, lag_shown in (("rotors.speed.", True), ("rotors.speed_command.", False)):
        with case(head):
            speeds = {f"{head}{i}": 300.0 + 100.0 * TIME for i in range(4)}
            motion = motion_of(
                make((*LOGGED_ESTIMATE_SIGNALS, *RATES, *SETPOINT_SIGNALS), speeds), vehicle
            )
            made = steady_thrusts(motion, vehicle)
            assert np.array_equal(rotor_lagged(made, motion, vehicle), made) is lag_shown
            assert motion.speeds_shown
            full = vehicle.rotors[0].max_rot_velocity
            assert motion.commands[-1, 0] == pytest.approx((300.0 + 100.0 * TIME[-1]) / full)
    both = {f"{head}{i}": 0.0 * TIME for head in ("rotors.speed.",) for i in range(4)} | speeds
    assert not motion_of(
        make((*LOGGED_ESTIMATE_SIGNALS, *RATES, *SETPOINT_SIGNALS), both), vehicle
    ).lag_shown
    assert not motion_of(
        make((*LOGGED_ESTIMATE_SIGNALS, *RATES, *SETPOINT_SIGNALS, *MOTORS)), vehicle
    ).speeds_shown


def test_the_csv_of_a_flight_to_places_tells_what_was_gone_to(vehicle, tmp_path):
    start = ScenarioStart(position=[0.0, 0.0, 1.5])
    script = [Action(0.25, go_to=[0.5, 0.0, 1.5]), Action(0.75, go_to=[0.5, 0.25, 1.5])]
    session = Session(Scenario(duration=1.25, start=start, script=script))
    session.run()
    session.recording().write_csv(tmp_path / "flight.csv")
    motion = motion_of(read_flight(tmp_path / "flight.csv"), vehicle)
    assert motion.time[-1] == pytest.approx(1.0, abs=0.02)
    assert motion.setpoint[0].tolist() == [0.5, 0.0, 1.5]
    assert motion.setpoint[-1].tolist() == [0.5, 0.25, 1.5]
    assert not motion.lag_shown and motion.measured.all()


def test_what_jumps_was_not_measured(make, vehicle):
    x = np.where(np.arange(len(TIME)) == 100, 50.0, 0.1)
    motion = motion_of(
        make((*LOGGED_ESTIMATE_SIGNALS, *RATES, *SETPOINT_SIGNALS, *MOTORS), {"estimate.x": x}),
        vehicle,
    )
    assert np.flatnonzero(~motion.measured).tolist() == [99, 100, 101]


def test_what_is_missing_for_longer_was_not_measured(make, vehicle, case):
    """A fifth of a second is bridged, as from a packet that was lost, and more is not."""
    record = make((*LOGGED_ESTIMATE_SIGNALS, *RATES, *SETPOINT_SIGNALS, *MOTORS))
    for name in ("estimate.y", RATES[2], MOTORS[3]):
        for lost, bridged in ((18, True), (30, False)):
            with case(name, lost):
                kept = np.abs(TIME - 1.0) > 0.005 * lost
                torn = make_series(name, "1", TIME[kept], record[name].values[kept], end=TIME[-1])
                flight = dataclasses.replace(record, signals={**record.signals, name: torn})
                measured = motion_of(flight, vehicle).measured
                np.testing.assert_array_equal(measured, kept | bridged)


def test_what_makes_no_motion_is_a_sentence(make, vehicle, case):
    whole = (*LOGGED_ESTIMATE_SIGNALS, *RATES, *SETPOINT_SIGNALS, *MOTORS)
    far = {"estimate.z": np.where(TIME < 1.0, 0.1, 1e30)}
    for said, record in (
        (
            "no setpoint of the position, no motors' commands: a prediction",
            make((*LOGGED_ESTIMATE_SIGNALS, *RATES)),
        ),
        ("no position, no velocity, no attitude: a prediction", make((*SETPOINT_SIGNALS, *MOTORS))),
        (
            "has 6 motors, but .* has 4: give the drone .* `--model`, or in the app fly that drone",
            make((*whole, "motors.command_5", "motors.command_6")),
        ),
        ("at 1.00 s is not a position", make(whole, far)),
    ):
        with case(said), pytest.raises(WorkbenchError, match=said):
            motion_of(record, vehicle)


def test_the_law_that_flew_is_told_by_the_log_or_its_firmware(make, case):
    for law, about in (
        ("crazyflie", {"parameters": {"controller": "PID"}}),
        ("geometric", {"parameters": {"controller": "geometric"}, "firmware": "workbench 0.1.0"}),
        ("px4", {"firmware": "PX4 1.15.0, PX4_FMU_V6X"}),
        ("ardupilot", {"firmware": "ArduCopter V4.6.0"}),
        ("ardupilot", {"firmware": "APM:Copter V3.5.7"}),
        ("mine.py", {"parameters": {"controller": "mine"}}),
        ("", {"parameters": {"controller": "?"}}),
        ("", {}),
    ):
        with case(about):
            assert flown_law_name(make(MOTORS, **about), {"mine": "mine.py"}) == law
    with pytest.raises(WorkbenchError, match="flown by yours"):
        flown_law_name(make(MOTORS, parameters={"controller": "yours"}), {"mine": "mine.py"})


def test_a_law_has_the_gains_of_the_log_over_others(make, vehicle):
    log = make(MOTORS, parameters={"controller": "pd", "kp_pitch": 123.0, "vehicle": "x"})
    law = flown_law(log, vehicle, "pd", {"kp_pitch": 99.0, "kp_roll": 77.0})
    assert (law.gains["kp_pitch"], law.gains["kp_roll"]) == (123.0, 77.0)
