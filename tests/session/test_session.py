"""Oracles: the same flight flown in another way, to the bit; and what was asked for."""

import dataclasses
import gc
import importlib.metadata
import logging
import math

import numpy as np
import pytest
from pydrake.geometry import Meshcat
from pydrake.systems.framework import LeafSystem

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.scenario.scenario import (
    Action,
    FigureEight,
    Push,
    Rates,
    Scenario,
    ScenarioStart,
    SensorsConfig,
    VehicleConfig,
)
from workbench.session.recording import Recording
from workbench.session.session import Session

STEP = Rates().physics_step
PERIOD = Rates().control_period
ODD_RATES = Rates(physics_step=0.001, control_period=0.004, mode_period=0.02, record_period=0.01)


def busy(**changes) -> Scenario:
    """Two seconds in which much happens, at times between the steps."""
    script = [
        Action(at=0.0, set={"kp_velocity_x": 3.3}),
        Action(at=0.1003, velocity=[1.0, -0.5, 0.3], yaw_rate=0.2),
        Action(at=0.71, set={"kp_roll": 120.0, "landing_speed": 0.5}),
        Action(at=0.9, go_to=[1.0, 1.0, 2.0]),
        Action(at=1.4999, request="land"),
    ]
    start = ScenarioStart(
        position=[0.1, 0.2, 2.0], roll_pitch_yaw=[0.1, 0.2, 0.3], velocity=[0.3, 0, 0]
    )
    return dataclasses.replace(Scenario(duration=2.0, script=script, start=start), **changes)


def assert_equal_to_the_bit(one: Recording, other: Recording) -> None:
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            a, b = getattr(one, field.name), getattr(other, field.name)
            assert a.shape == b.shape, field.name
            assert a.tobytes() == b.tobytes(), field.name


def in_one_run(scenario) -> Recording:
    session = Session(scenario)
    session.tick(scenario.duration)
    return session.recording()


@pytest.fixture(scope="module")
def busy_flight() -> Recording:
    return in_one_run(busy())


def test_equal_scenarios_give_equal_flights(busy_flight):
    assert_equal_to_the_bit(in_one_run(busy()), busy_flight)


def test_a_flight_is_a_flight(busy_flight):
    """So that the equalities here are not those of nothing."""
    assert len(busy_flight.time) == 2 * 128 + 1
    assert np.ptp(busy_flight.p_WB[:, 0]) > 0.3
    assert set(busy_flight.mode) >= {FlightMode.CRUISING, FlightMode.LANDING}


def test_slices_of_any_size_are_one_flight(case, busy_flight):
    for rates, whole in ((Rates(), busy_flight), (ODD_RATES, in_one_run(busy(rates=ODD_RATES)))):
        with case(rates):
            session = Session(busy(rates=rates))
            rng = np.random.default_rng(0)
            # from far below a physics step up to a quarter of a second
            cuts = np.sort(rng.uniform(0.0, 2.0, 60))
            tiny = 1.0 + np.cumsum(rng.uniform(0.0, rates.physics_step, 40))
            cuts = np.sort(np.concatenate([[0.0], cuts, tiny, [2.0]]))
            for duration in np.diff(cuts):
                session.tick(float(duration))
            assert_equal_to_the_bit(session.recording(), whole)


def test_slices_below_a_control_period_add_up(busy_flight):
    session = Session(busy())
    for _ in range(3 * 256):
        session.tick(PERIOD / 3.0)
    assert_equal_to_the_bit(session.recording(), busy_flight)


def test_what_is_owed_is_paid_later():
    session = Session()
    for time in (0.0, 0.0, PERIOD, PERIOD, 2.0 * PERIOD):
        session.tick(0.4 * PERIOD)
        assert session.time == time


def test_run_and_reset_and_looking_change_nothing(busy_flight):
    session = Session(busy())
    session.set("kp_roll", 60.0)
    session.command([1.0, 0.0, 0.0])
    session.tick(0.7)
    session.reset()
    assert session.time == 0.0
    shares = []
    session.run(shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert_equal_to_the_bit(session.recording(), busy_flight)

    session.reset()
    while session.time < 2.0:
        session.tick(0.05)
        session.snapshot()
        session.recording()
        session.get("kp_roll")
    assert_equal_to_the_bit(session.recording(), busy_flight)


@pytest.mark.slow
@pytest.mark.parametrize("flown", [0.0, 0.4])
def test_running_when_the_end_is_reached_or_past_flies_no_further(flown):
    """3.3 is no sum of thirteen equal slices, in binary."""
    session = Session(Scenario(duration=3.3))
    session.run()
    session.tick(flown)
    end = session.time
    session.run()
    assert session.time == end


def test_a_script_is_what_a_pilot_does_at_those_times(busy_flight):
    """An action takes effect at the first control update at or after its time."""
    session = Session(busy(script=[]))

    def fly_to(time):
        session.tick(math.ceil(time / PERIOD) * PERIOD - session.time)

    session.set("kp_velocity_x", 3.3)
    fly_to(0.1003)
    session.command([1.0, -0.5, 0.3], 0.2)
    fly_to(0.71)
    session.set("kp_roll", 120.0)
    session.set("landing_speed", 0.5)
    fly_to(0.9)
    session.go_to([1.0, 1.0, 2.0])
    fly_to(1.4999)
    session.request("land")
    fly_to(2.0)
    assert_equal_to_the_bit(session.recording(), busy_flight)


def test_the_order_of_a_script_is_that_of_its_times(busy_flight):
    scenario = busy()
    scenario.script.reverse()
    assert_equal_to_the_bit(in_one_run(scenario), busy_flight)


def test_two_sessions_at_once_do_not_disturb_each_other(busy_flight):
    one, other = Session(busy()), Session(busy(script=[]), {"kp_roll": 90.0})
    for _ in range(20):
        one.tick(0.1)
        other.tick(0.1)
    assert_equal_to_the_bit(one.recording(), busy_flight)


@pytest.mark.parametrize("mode", ["off", "hovering"])
def test_a_flight_begins_as_said(mode):
    start = ScenarioStart(mode, [1.0, 2.0, 3.0], [0.1, 0.2, 0.3], [0.4, 0.5, 0.6], [0.7, 0.8, 0.9])
    session = Session(Scenario(start=start))
    now = session.snapshot()
    assert now.time == 0.0
    assert now.p_WB == (1.0, 2.0, 3.0)
    assert now.v_WB == pytest.approx((0.4, 0.5, 0.6))
    assert now.w_WB == pytest.approx((0.7, 0.8, 0.9))
    # roll-pitch-yaw (0.1, 0.2, 0.3) as half angles, by hand: w = c c c + s s s
    half = np.cos([0.05, 0.1, 0.15]).prod() + np.sin([0.05, 0.1, 0.15]).prod()
    assert now.q_WB[0] == pytest.approx(half)
    flying = mode == "hovering"
    assert now.mode is (FlightMode.HOVERING if flying else FlightMode.OFF)
    weight = session.vehicle.mass * 9.81
    assert sum(now.thrusts) == pytest.approx(weight if flying else 0.0)
    assert now.charge == 1.0


def test_without_a_place_it_stands_or_hovers():
    standing = Session(Scenario(start=ScenarioStart(mode="off")))
    assert standing.snapshot().p_WB == (0.0, 0.0, standing.vehicle.ground_clearance)
    assert Session().snapshot().p_WB == (0.0, 0.0, 1.5)


def test_hovering_from_the_start_is_at_rest():
    session = Session()
    session.tick(1.0)
    assert np.abs(session.recording().p_WB - [0.0, 0.0, 1.5]).max() < 1e-9


def test_commands_replace_what_they_name():
    session = Session()
    session.command([1.0, 2.0, 3.0], 0.1)
    assert session.snapshot().reference == (1.0, 2.0, 3.0, 0.1, 0.0, 0.0, 0.0, 0.0)
    session.command(yaw_rate=0.2)
    assert session.snapshot().reference == (1.0, 2.0, 3.0, 0.2, 0.0, 0.0, 0.0, 0.0)
    session.go_to([7.0, 8.0, 9.0])
    assert session.snapshot().reference == (0.0, 0.0, 0.0, 0.2, 7.0, 8.0, 9.0, 1.0)
    session.command([0.0, 0.0, 1.0])
    reference = session.snapshot().reference
    assert (reference[:4], reference[7]) == ((0.0, 0.0, 1.0, 0.2), 0.0)


def test_a_landing_takes_back_what_was_asked():
    session = Session()
    session.command([1.0, 0.0, 0.0], 0.3)
    session.request("land")
    assert session.snapshot().reference[:4] == (0.0, 0.0, 0.0, 0.0)


def test_a_gain_takes_effect_at_the_next_control_update():
    """Both flights see the same command; one has another gain from the middle of a period on."""
    period = Rates().control_period

    def thrusts_after(change):
        session = Session()
        session.command([1.0, 0.0, 0.0])
        session.tick(4.5 * period)
        if change:
            session.set("kp_velocity_x", 9.0)
        session.tick(0.4 * period)
        before = session.snapshot().thrusts
        session.tick(0.4 * period)  # it acts a step later, and shows at the end of that
        return before, session.snapshot().thrusts

    kept, changed = thrusts_after(False), thrusts_after(True)
    assert kept[0] == changed[0]
    assert kept[1] != changed[1]


def test_settings_come_after_the_vehicles_gains(tmp_path):
    gains = tmp_path / "gains.yaml"
    gains.write_text("gains: {kp_roll: 111.0, kp_pitch: 112.0}\n")
    scenario = Scenario(vehicle=VehicleConfig(gains=str(gains)))
    session = Session(scenario, {"kp_pitch": 113.0})
    assert session.get("kp_roll") == 111.0
    assert session.get("kp_pitch") == 113.0
    session.set("kp_roll", 99.0)
    assert session.get("kp_roll") == 99.0
    session.reset()
    assert session.get("kp_roll") == 111.0


def test_a_snapshot_is_the_newest_sample_and_frozen(busy_flight):
    session = Session(busy())
    session.tick(2.0)
    now = session.snapshot()
    assert now.time == busy_flight.time[-1]
    for name in ("p_WB", "v_WB", "w_WB", "thrusts", "reference"):
        assert getattr(now, name) == tuple(getattr(busy_flight, name)[-1])
    assert now.q_WB == pytest.approx(busy_flight.q_WB[-1])
    assert (now.mode, now.charge) == (busy_flight.mode[-1], busy_flight.charge[-1])
    with pytest.raises(dataclasses.FrozenInstanceError):
        now.time = 0.0


def test_a_recording_is_a_copy():
    session = Session()
    session.tick(0.1)
    session.recording().p_WB[:] = 99.0
    assert session.recording().p_WB.max() < 2.0


def test_arming_and_taking_off_and_stopping():
    session = Session(Scenario(start=ScenarioStart(mode="off")))
    session.request("arm")
    session.tick(0.5)
    assert session.snapshot().mode is FlightMode.ARMED
    idle = [0.1 * rotor.max_rot_velocity for rotor in session.vehicle.rotors]
    assert session.recording().rotor_speeds[-1] == pytest.approx(idle, rel=1e-3)
    session.request("take_off", 2.0)
    session.tick(6.0)
    assert session.snapshot().mode is FlightMode.HOVERING
    assert session.snapshot().p_WB[2] == pytest.approx(2.0, abs=0.05)
    session.request("stop")
    session.tick(0.5)
    assert session.snapshot().mode is FlightMode.OFF
    assert session.snapshot().v_WB[2] < -3.0  # it falls: 0.5 s less one update and the rotors' lag


@pytest.mark.slow
def test_a_figure_of_eight_is_flown():
    eight = FigureEight(center=[0.0, 0.0, 2.0], length=3.0, width=1.5, period=8.0, laps=1)
    scenario = Scenario(
        duration=16.0, start=ScenarioStart(position=[0.0, 0.0, 2.0]), figure_eight=eight
    )
    flight = in_one_run(scenario)
    wanted = flight.reference[:, 4:7]
    assert np.ptp(wanted[:, 0]) == pytest.approx(3.0, rel=0.01)
    assert np.linalg.norm(flight.p_WB - wanted, axis=1).max() < 0.4
    assert flight.p_WB[-1] == pytest.approx([0.0, 0.0, 2.0], abs=0.02)


def test_a_path_hands_its_acceleration_on_unless_it_is_told_not_to(case):
    for eight, fed in (
        (FigureEight(), True),
        (FigureEight(feedforward=False), False),
        (None, False),
    ):
        with case(eight):
            diagram = Session(Scenario(figure_eight=eight)).diagram
            assert diagram.HasSubsystemNamed("feedforward") is fed


def test_nonsense_is_refused_in_a_sentence_and_changes_nothing(case):
    for act, words in [
        (lambda s: s.command([1.0, math.nan, 0.0]), ("velocity",)),
        (lambda s: s.command([1.0, 2.0]), ("velocity",)),
        (lambda s: s.command(yaw_rate=math.inf), ("yaw rate",)),
        (lambda s: s.go_to([0.0, 0.0, math.inf]), ("position",)),
        (lambda s: s.gust([1.0, 2.0]), ("gust",)),
        (lambda s: s.gust([99.0, 0.0, 0.0]), ("gust_x", "50")),
        (lambda s: s.gust([1.0, 0.0, 0.0], 0.0), ("gust_duration",)),
        (lambda s: s.push([math.nan, 0.0, 0.0]), ("push",)),
        (lambda s: s.push([1.0, 0.0, 0.0], [0.0]), ("point",)),
        (lambda s: s.push([1.0, 0.0, 0.0], duration=math.inf), ("push_duration",)),
        (lambda s: s.reading("imu"), ("'imu'", "no sensors")),
        (lambda s: s.request("fly"), ("'fly'", "take_off")),
        (lambda s: s.request("lend"), ("'lend'", "'land'")),
        (lambda s: s.request("take_off", math.nan), ("height",)),
        (lambda s: s.request("take_off", -1.0), ("height",)),
        (lambda s: s.request("take_off", math.inf), ("height",)),
        (lambda s: s.set("kp_rol", 1.0), ("'kp_rol'", "'kp_roll'")),
        (lambda s: s.set("kp_roll", math.nan), ("kp_roll",)),
        (lambda s: s.set("kp_roll", 1e9), ("kp_roll", "2500")),
        (lambda s: s.get("kp_rol"), ("'kp_roll'",)),
        (lambda s: s.push("abc"), ("push", "'abc'", "3 finite")),
        (lambda s: s.push("123"), ("push", "'123'")),
        (lambda s: s.push(None), ("push", "None")),
        (lambda s: s.push([1.0, 0.0, 0.0], duration="x"), ("push_duration", "'x'")),
        (lambda s: s.gust("abc"), ("gust", "'abc'")),
        (lambda s: s.gust("a" * 10_000), ("gust", "'aaa")),
        (lambda s: s.command("abc"), ("velocity", "'abc'")),
        (lambda s: s.command(["1", "2", "3"]), ("velocity", "'1'")),
        (lambda s: s.command(yaw_rate="x"), ("yaw rate", "'x'")),
        (lambda s: s.command([10**400, 0, 0]), ("velocity",)),
        (lambda s: s.go_to(None), ("position", "None")),
        (lambda s: s.request("take_off", "x"), ("height", "'x'")),
        (lambda s: s.request("land", None), ("height", "None")),
        (lambda s: s.tick("x"), ("'x'", "positive")),
        (lambda s: s.tick(None), ("None",)),
        (lambda s: s.tick(-1.0), ("-1",)),
        (lambda s: s.tick(math.nan), ("nan",)),
        (lambda s: s.tick(math.inf), ("inf",)),
    ]:
        with case(act, words):
            session = Session()
            before = (session.snapshot(), session.get("kp_roll"))
            with pytest.raises(WorkbenchError) as caught:
                act(session)
            assert not [word for word in words if word not in str(caught.value)]
            assert len(str(caught.value)) < 1000
            assert (session.snapshot(), session.get("kp_roll")) == before
            session.tick(0.1)


TABLE = """ground: true
obstacles: [{name: table, shape: {box: [2, 2, 1.2]}, position: [0, 0, 0.6]}]
"""


def test_a_landing_on_an_obstacle_ends(tmp_path, case):
    """As on the ground, the rotors stop; the drone starts again from there.

    So they do where the law hardly demands less thrust than in the air.
    """
    (tmp_path / "table.yaml").write_text(TABLE)
    scenario = Scenario(world=str(tmp_path / "table.yaml"), script=[Action(request="land")])
    for values in ({"payload_mass": 0.6, "known_payload_mass": 0.6}, {}):
        with case(values):
            session = Session(scenario, values)
            session.tick(4.2)
            found = session.snapshot()
            height = pytest.approx(1.2 + 0.136, abs=0.002)
            assert (found.mode, found.p_WB[2]) == (FlightMode.OFF, height)
    session.do(Action(request="take_off", height=1.8))
    session.tick(1.0)
    assert session.snapshot().p_WB[2] > 1.4


@pytest.mark.slow
def test_a_landing_that_something_pushes_up_does_not_stop_the_rotors_in_the_air(case):
    """A law without an integral stands still up there, whoever says where it is.

    Without the push, it sinks and lands.
    """
    weight = 9.81 * Session().vehicle.mass
    for estimator, change in (
        ("truth", {"push": Push(force=(0.0, 0.0, 0.17 * weight), duration=9.0)}),
        ("complementary", {"push": Push(force=(0.0, 0.0, 0.17 * weight), duration=9.0)}),
        ("truth", {"set": {"wind_z": 8.0, "landing_speed": 0.1}}),
    ):
        with case(estimator, change):
            session = Session(Scenario(estimator=estimator, script=[Action(**change)]))
            session.tick(1.0)
            session.do(Action(request="land"))
            session.tick(4.5)
            found = session.snapshot()
            assert found.mode is FlightMode.LANDING
            assert (found.p_WB[2] > 0.5, abs(found.v_WB[2]) < 0.1) == (True, True)


@pytest.mark.slow
def test_a_load_that_stands_on_the_ground_does_not_carry_the_drone():
    """The law demands the thrust for both, so the drone stays above it on the taut cable."""
    slung = VehicleConfig(model="slung_load")
    session = Session(Scenario(vehicle=slung, script=[Action(request="land")]))
    session.tick(4.5)
    found = session.snapshot()
    assert (found.mode, found.p_WB[2] > 0.9) == (FlightMode.LANDING, True)


WORLD = """
obstacles: [{name: box, shape: {box: [2, 2, 2]}, position: [0, 0, 1]}]
moving: [{name: cart, shape: {sphere: 0.5}, path: [[0, 5, 0, 1.5], [1, 9, 0, 1.5]]}]
"""


@pytest.mark.parametrize(
    ("position", "words"),
    [
        ([0.0, 0.0, 1.0], ["the flight begins inside 'box'"]),
        ([1.2, 0.0, 1.0], ["from 'box', within the drone's own reach"]),
        ([5.0, 0.0, 1.5], ["the flight begins inside 'cart'"]),
        ([0.0, 3.0, 1.5], []),
        ([9.0, 0.0, 1.5], []),  # where the cart comes to later
        ([60.0, 0.0, 1.5], []),
    ],
)
def test_a_flight_that_begins_in_an_obstacle_says_so_once(tmp_path, caplog, position, words):
    (tmp_path / "world.yaml").write_text(WORLD)
    world = str(tmp_path / "world.yaml")
    with caplog.at_level(logging.INFO, logger="workbench"):
        session = Session(Scenario(world=world, start=ScenarioStart(position=position)))
        session.reset()
    said = [message for message in caplog.messages if "the flight begins" in message]
    assert len(said) == len(words)
    assert all(word in message for word, message in zip(words, said, strict=True))


def test_standing_on_the_ground_is_not_worth_a_word(caplog):
    with caplog.at_level(logging.INFO, logger="workbench"):
        Session(Scenario(world="room", start=ScenarioStart(mode="off")))
    assert not [message for message in caplog.messages if "begins" in message]


def test_a_reading_is_by_name_or_kind_and_none_before_the_first():
    sensors = SensorsConfig(use=["depth_camera", "imu"], rates={"camera": 1.0, "imu": 64.0})
    session = Session(Scenario(sensors=sensors))
    assert session.reading("camera") is session.reading("imu") is None
    session.tick(PERIOD)
    assert session.reading("camera") is session.reading("depth_camera")
    assert session.reading("imu").stamp == 0.0
    session.reset()
    assert session.reading("camera") is session.reading("imu") is None


def test_what_breaks_in_flight_becomes_a_sentence(monkeypatch):
    """A place that is no number, let through for once: the flight stops at the force it makes."""
    session = Session()
    session.tick(0.1)
    monkeypatch.setattr("workbench.session.session.checked_action", lambda action: action)
    session.go_to([0.0, 0.0, math.nan])
    with pytest.raises(WorkbenchError, match=r"broke off after 0\."):
        session.tick(0.5)


def alive() -> set[int]:
    """Return which leaf systems of Python or C++ garbage collections leave.

    Two: what stands in contact is a diagram that belongs to a system of the flight's.
    """
    gc.collect()
    gc.collect()
    return {id(it) for it in gc.get_objects() if issubclass(type(it), LeafSystem)}


@pytest.mark.parametrize("drawn", [False, True])
def test_nothing_stays_of_a_session_that_is_let_go(drawn):
    if importlib.metadata.version("drake") < "1.58":
        pytest.skip("Drake before 1.58 keeps every LeafSystem of Python: docs/install.md")
    before = alive()
    scenario = Scenario(sensors=SensorsConfig(use=["all"]), duration=0.2)
    session = Session(scenario, meshcat=Meshcat() if drawn else None)
    session.run()
    assert len(alive() - before) > 10
    del session
    assert not alive() - before
