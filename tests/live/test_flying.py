"""The loop in this process, with a wall clock that is made up; flights equal those of a Session."""

import dataclasses
from multiprocessing import Pipe

import numpy as np
import pytest

from tests.live_orders import execute
from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.control.mode import FlightMode
from workbench.ipc.send_queue import SendQueue
from workbench.ipc.worker_process import WorkerRefusal, WorkerRequest, WorkerResult
from workbench.link import authority
from workbench.live.flight_clock import FLIGHT_SLICE_S
from workbench.live.flying import FlightLoop
from workbench.live.messages import CLOSE_MESSAGE, FlightReport, FlownSoFar, Phase
from workbench.live.orders import FlightOrder, FlyOn, GetParameter, GetReading, SetSpeed
from workbench.live.view import LiveView
from workbench.scenario.scenario import (
    Action,
    Gust,
    Push,
    Rates,
    Scenario,
    ScenarioStart,
    SensorsConfig,
    VehicleConfig,
)
from workbench.scenario.scenario_file import load_scenario, save_scenario
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

STEP = Rates().physics_step
PERIOD = Rates().control_period
SETTINGS = {"kp_roll": 90.0, "max_tilt": 0.4, "wind_x": 1.0, "rotor_2": 0.97}


class KeptMessages:
    """A send queue that keeps all."""

    def __init__(self) -> None:
        self.sent: list[object] = []

    def post(self, message: object) -> None:
        self.sent.append(message)

    show = post


class Bench:
    """A `FlightLoop` and its wall clock."""

    def __init__(self, scenario: Scenario | None = None, settings=None, send_queue=None) -> None:
        self.wall = 0.0
        self.messages = send_queue or KeptMessages()
        self.bridge = Bridge()
        self.session = Session(scenario, settings, bridge=self.bridge)
        self.flying = FlightLoop(
            self.session, self.bridge, settings or {}, self.messages, lambda: self.wall
        )

    def fly(self, seconds: float) -> None:
        end = self.wall + seconds
        while self.wall < end:
            self.wall += min(FLIGHT_SLICE_S, end - self.wall)
            self.flying.fly()

    def execute(self, wanted) -> WorkerResult | WorkerRefusal:
        return execute(self.flying, wanted)

    def flown(self) -> FlownSoFar:
        return self.execute(FlightOrder.GET_FLOWN).value


def assert_equal_to_the_bit(one: Recording, other: Recording) -> None:
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            a, b = getattr(one, field.name), getattr(other, field.name)
            assert a.shape == b.shape, field.name
            assert a.tobytes() == b.tobytes(), field.name


def in_one_run(scenario, settings=None) -> Recording:
    session = Session(scenario, settings)
    session.run()
    return session.recording()


def scripted() -> Scenario:
    """Its script acts between updates, and at one at which the pilot acts, too."""
    script = [
        Action(at=0.1, set={"kp_velocity_x": 3.3}),
        Action(at=0.25 - 0.3 * STEP, velocity=[0.0, 0.5, 0.0], yaw_rate=0.3),
        Action(at=9.0, request="land"),
    ]
    start = ScenarioStart(position=[0.1, 0.2, 2.0], roll_pitch_yaw=[0.1, 0.2, 0.3])
    return Scenario(script=script, start=start, sensors=SensorsConfig(use=["imu"], seed=3))


def test_orders_take_effect_at_the_present_step_and_are_answered_with_its_time():
    bench = Bench()
    bench.fly(0.25)
    answer = bench.execute(Action(set={"kp_roll": 77.0}))
    assert isinstance(answer, WorkerResult)
    assert answer.value == bench.session.time == 0.25
    assert bench.session.get("kp_roll") == 77.0
    assert bench.execute(GetParameter("kp_roll")).value == 77.0


def test_a_script_that_the_operator_ends_is_not_flown_on_and_repeats_to_the_bit():
    bench = Bench(scripted())
    bench.fly(0.2)
    assert bench.session.next_action.velocity == [0.0, 0.5, 0.0]
    bench.execute(Action(request="hold"))
    bench.fly(0.3)
    assert bench.session.asked[:2] == (0.0, 0.0)
    assert bench.session.get("kp_velocity_x") == 3.3
    flown = bench.flown()
    assert all(
        not action.end_script and action.velocity is None for action in flown.scenario.script
    )
    assert_equal_to_the_bit(flown.recording, in_one_run(flown.scenario))
    bench.execute(FlightOrder.RESET)
    bench.fly(0.3)
    assert bench.session.asked[1] == 0.5  # another flight has the whole script


@pytest.mark.parametrize("request_name", ["hold", "land", "stop"])
def test_whoever_asks_to_hold_land_or_stop_ends_the_script(request_name):
    """Of a game pad and of Python, too: otherwise the script starts the rotors again."""
    bench = Bench(scripted())
    bench.fly(0.2)
    bench.execute(Action(request="take_off"))
    assert bench.session.next_action is not None
    bench.execute(Action(request=request_name))
    assert bench.session.next_action is None


def test_the_landing_after_a_clients_silence_ends_the_script_and_repeats_to_the_bit(monkeypatch):
    """Its holds do not: the script goes on until the drone lands."""
    monkeypatch.setattr(authority, "LAND_AFTER_S", 2.25)
    script = [Action(at=1.5, set={"kp_roll": 88.0}), Action(at=2.5, velocity=[0.0, 0.5, 0.0])]
    bench = Bench(Scenario(script=script))
    bench.bridge.authority.request(1, "one", 0.0)
    bench.fly(2.75)
    assert bench.session.snapshot().mode is FlightMode.LANDING
    assert (bench.session.get("kp_roll"), bench.session.asked[1]) == (88.0, 0.0)
    flown = bench.flown()
    assert_equal_to_the_bit(flown.recording, in_one_run(flown.scenario))


def test_what_the_script_itself_asks_for_does_not_end_it():
    script = [Action(at=0.1, request="land"), Action(at=0.2, request="stop"), Action(at=9.0)]
    bench = Bench(Scenario(script=script))
    bench.fly(0.3)
    assert bench.session.next_action == script[-1]


def test_a_flight_whose_script_was_ended_at_once_repeats_with_what_it_began_with():
    script = [Action(set={"wind_x": 2.0, "kp_roll": 55.0}), Action(velocity=[1.0, 0.0, 0.0])]
    bench = Bench(Scenario(script=script), SETTINGS)
    bench.execute(Action(request="hold", set={"kp_roll": 66.0}, end_script=True))
    bench.fly(0.3)
    assert (bench.session.get("wind_x"), bench.session.get("kp_roll")) == (2.0, 66.0)
    flown = bench.flown()
    assert_equal_to_the_bit(flown.recording, in_one_run(flown.scenario))


def test_a_gain_of_the_operator_forgets_no_stick_of_a_client():
    """A stick that leaves neutral ends a landing; one that is held since before does not."""
    bench = Bench()
    assert bench.bridge.moves(1.0, 0.0, 0.0, 0.0)
    bench.execute(Action(set={"kp_roll": 77.0}))
    assert not bench.bridge.moves(1.0, 0.0, 0.0, 0.0)


def test_an_operators_stick_ends_a_landing_in_the_air_as_it_leaves_neutral(case):
    """Neither one at rest nor one that is held since before; a place to go to does."""
    rest, ahead = Action(velocity=[0.0] * 3, yaw_rate=0.0), Action(velocity=[0.5, 0.0, 0.0])
    for before, then, ends in (
        (rest, rest, False),
        (ahead, ahead, False),
        (ahead, rest, False),
        (rest, ahead, True),
        (rest, Action(yaw_rate=0.1), True),
        (ahead, Action(go_to=[0.0, 0.0, 3.0]), True),
    ):
        with case(before, then):
            bench = Bench(Scenario(start=ScenarioStart(position=[0.0, 0.0, 3.0])))
            for order in (before, Action(request="land")):
                bench.execute(order)
                bench.fly(0.25)
            assert bench.session.snapshot().mode is FlightMode.LANDING
            bench.execute(then)
            bench.fly(0.25)
            assert (bench.session.snapshot().mode is not FlightMode.LANDING) == ends


def test_a_report_that_shows_the_effect_goes_before_the_answer():
    bench = Bench()
    caller, connection = Pipe()
    caller.send(WorkerRequest(1, Action(velocity=[0.5, 0.0, 0.0], yaw_rate=0.1)))
    caller.send(WorkerRequest(2, FlyOn(1.0)))
    caller.send(CLOSE_MESSAGE)
    bench.flying.run(connection, lambda: True)
    report, answer, refusal = bench.messages.sent[-3:]
    assert answer == WorkerResult(1, 0.0)
    assert refusal == WorkerRefusal(2, "the flight runs: pause it first")
    assert isinstance(report, FlightReport)
    assert report.snapshot.reference[:4] == (0.5, 0.0, 0.0, 0.1)


def test_a_live_flight_is_the_same_again_as_a_scenario(tmp_path):
    bench = Bench(scripted(), SETTINGS)
    bench.fly(0.25)
    bench.execute(Action(velocity=[1.0, 0.0, 0.2]))  # at the step at which the script acts
    bench.execute(Action(set={"kp_pitch": 60.0}))
    bench.fly(0.1)
    bench.execute(Action(gust=Gust([2.0, 1.0, 0.0], 0.5)))
    bench.execute(Action(push=Push([0.0, 0.5, 0.0], [0.1, 0.0, 0.0], 0.2)))
    bench.execute(SetSpeed(3.0))
    bench.fly(0.3)
    bench.execute(FlightOrder.PAUSE)
    bench.execute(Action(go_to=[1.0, 1.0, 2.0]))
    bench.execute(FlyOn(0.1003))
    bench.execute(Action(request="land", height=1.5))
    bench.execute(FlightOrder.RESUME)
    bench.execute(SetSpeed(1.0))
    bench.fly(0.5)
    flown = bench.flown()
    assert flown.recording.time[-1] > 1.5
    assert np.ptp(flown.recording.p_WB[:, 0]) > 0.1  # it is no equality of nothing
    assert_equal_to_the_bit(in_one_run(flown.scenario), flown.recording)

    save_scenario(flown.scenario, tmp_path / "again.yaml")
    again = load_scenario(tmp_path / "again.yaml")
    assert_equal_to_the_bit(in_one_run(again), flown.recording)


def test_a_live_flight_equals_a_session_with_the_same_commands_at_the_same_times():
    bench = Bench(scripted(), SETTINGS)
    session = Session(scripted(), SETTINGS)
    for seconds, velocity in ((0.25, (1.0, 0.0, 0.2)), (0.375, (0.0, -1.0, 0.0))):
        bench.fly(seconds)
        at = bench.execute(Action(velocity=list(velocity))).value
        session.tick(at - session.time)
        session.command(velocity)
    bench.fly(0.5)
    session.tick(bench.session.time - session.time)
    assert_equal_to_the_bit(bench.flown().recording, session.recording())


def test_a_flight_without_any_order_is_its_scenario():
    bench = Bench(scripted())
    bench.fly(0.5)
    flown = bench.flown()
    assert flown.scenario.duration == 0.5
    assert_equal_to_the_bit(in_one_run(flown.scenario), flown.recording)
    assert Bench(scripted()).flown().scenario == scripted_in_periods()


def scripted_in_periods() -> Scenario:
    scenario = scripted()
    acting = zip(scenario.script, (13, 32, 1152), strict=True)
    scenario.script = [dataclasses.replace(each, at=update * PERIOD) for each, update in acting]
    return scenario


def test_what_is_refused_changes_nothing_and_is_not_in_the_script():
    bench = Bench()
    for wanted, word in (
        (Action(set={"kp_rol": 1.0}), "'kp_roll'"),
        (Action(set={"kp_roll": 1e9}), "2500"),
        (Action(set={"lidar_fault": 1.0}), "lidar_fault"),
        (Action(go_to=[0.0, 0.0, -5.0]), "height"),
        (Action(request="lend", height=1.5), "'land'"),
        (Action(request="take_off", height=1e4), "take_off"),
        (Action(gust=Gust([99.0, 0.0, 0.0], 1.0)), "gust_x"),
        (Action(push=Push([1.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.0)), "push_duration"),
        (GetParameter("kp_rol"), "'kp_roll'"),
        (GetReading("imu"), "'imu'"),
        (SetSpeed(0.0), "0.01 to 20"),
        (SetSpeed(21.0), "0.01 to 20"),
        (FlyOn(1.0), "pause"),
        (SetSpeed("x"), "'x'"),
        (GetParameter([]), "is no order"),
        ("land", "is no order"),
        (Action(gust=3.0), "gust is 3.0: give it a Gust"),
        (Action(set=["kp_roll"]), "set is ['kp_roll']"),
    ):
        answer = bench.execute(wanted)
        assert isinstance(answer, WorkerRefusal), wanted
        assert word in answer.said
    assert bench.flown().scenario.script == []
    bench.execute(FlightOrder.PAUSE)
    for duration in (-1.0, 61.0):
        assert "60" in bench.execute(FlyOn(duration)).said
    assert bench.session.time == 0.0


def test_a_reset_begins_again_and_forgets_the_script():
    bench = Bench(Scenario(), SETTINGS)
    bench.execute(Action(set={"kp_roll": 50.0}))
    bench.fly(0.2)
    assert bench.execute(FlightOrder.RESET).value == 0.0
    assert bench.session.get("kp_roll") == SETTINGS["kp_roll"]
    bench.execute(Action(velocity=[0.0, 1.0, 0.0]))
    bench.fly(0.25)
    flown = bench.flown()
    assert flown.recording.time[-1] == 0.25
    assert [action.set for action in flown.scenario.script] == [SETTINGS, {}]
    assert_equal_to_the_bit(in_one_run(flown.scenario), flown.recording)


def test_a_report_tells_a_flight_from_the_one_before_a_reset_at_any_time():
    bench = Bench()
    bench.execute(FlightOrder.PAUSE)
    numbers = []
    for _ in range(2):
        bench.execute(FlightOrder.RESET)  # time stands at 0
        report = bench.messages.sent[-1]
        assert isinstance(report, FlightReport)
        assert report.snapshot.time == 0.0
        numbers.append(report.flight)
    assert numbers == [2, 3]


def test_a_reset_shows_the_initial_values_also_after_another_law_has_taken_over():
    """Screens begin a flight with them: hooks that were open are closed again."""
    bench = Bench(Scenario(vehicle=VehicleConfig(model="slung_load")))
    initial = bench.session.parameters()
    view = LiveView(scenario=bench.session.scenario, values=initial, flight=1)
    seen = {}
    for order in (
        Action(set={"open_hooks": 1.0, "wind_x": 2.0}),
        Action(controller="pid"),
        FlightOrder.RESET,
    ):
        assert isinstance(bench.execute(order), WorkerResult), order
        bench.flying.report()
        for message in bench.messages.sent:
            view = view.after(message)
            if view.snapshot is not None:
                seen.setdefault(view.flight, view.values)
        bench.messages.sent.clear()
        if order == Action(controller="pid"):
            assert (view.values["open_hooks"], view.values["wind_x"]) == (1.0, 2.0)
    assert (seen[2]["open_hooks"], seen[2]["wind_x"]) == (0.0, 0.0)  # as the new flight begins
    assert view.values == bench.session.parameters()
    assert view.controller is bench.session.controller


def test_a_pause_holds_time_and_flying_on_moves_it():
    bench = Bench()
    bench.fly(0.125)
    assert bench.execute(FlightOrder.PAUSE).value == 0.125
    assert bench.messages.sent[-1].phase is Phase.PAUSED
    bench.fly(1.0)
    assert bench.session.time == 0.125
    assert bench.execute(FlyOn(0.5)).value == 0.625
    assert bench.execute(FlyOn(PERIOD)).value == 0.625 + PERIOD
    bench.execute(FlightOrder.RESUME)
    assert bench.messages.sent[-1].phase is Phase.FLYING
    bench.fly(0.125)
    assert bench.session.time == 0.75 + PERIOD


@pytest.mark.parametrize("kind", [FlightBrokenError, WorkbenchError])
def test_a_broken_flight_is_a_sentence_and_can_begin_again(monkeypatch, kind):
    """Broken by Drake, or by a script that asks for what cannot be."""
    bench = Bench()
    bench.fly(0.125)
    tick = bench.session.tick

    def breaks(duration):
        raise kind("the flight broke off after 0.125 s: because")

    monkeypatch.setattr(bench.session, "tick", breaks)
    bench.fly(0.125)
    monkeypatch.setattr(bench.session, "tick", tick)
    report = bench.messages.sent[-1]
    assert (report.phase, report.said[:26]) == (Phase.BROKEN, "the flight broke off after")
    bench.fly(1.0)
    assert bench.session.time == 0.125  # it does not try again
    for wanted in (
        Action(velocity=[1.0, 0.0, 0.0]),
        FlightOrder.RESUME,
        FlyOn(1.0),
    ):
        assert "reset it first" in bench.execute(wanted).said
    assert bench.flown().recording.time[-1] == 0.125
    assert bench.execute(FlightOrder.RESET).value == 0.0
    assert bench.messages.sent[-1].phase is Phase.FLYING
    bench.fly(0.25)
    assert bench.session.time == 0.25


@pytest.mark.parametrize("failure", [SystemExit("abort: Failure"), RuntimeError("no\nway")])
def test_what_drake_refuses_is_a_sentence(monkeypatch, failure):
    bench = Bench()

    def refuses(*arguments):
        raise failure

    monkeypatch.setattr(bench.session, "do", refuses)
    said = bench.execute(Action(set={"kp_roll": 50.0})).said
    assert said == f"the flight cannot do that: {' '.join(str(failure).split())}"


def test_reports_come_sixty_times_a_second_whatever_the_speed():
    for speed in (1.0, 8.0):
        bench = Bench()
        bench.execute(SetSpeed(speed))
        before = len(bench.messages.sent)
        bench.fly(0.5)
        assert 25 <= len(bench.messages.sent) - before <= 31


def test_a_reader_that_stands_still_does_not_stop_the_flight():
    """Nobody reads the pipe, which holds a few hundred reports at most."""
    here, there = Pipe()
    send_queue = SendQueue(here)
    bench = Bench(send_queue=send_queue)
    for _ in range(400):
        bench.fly(FLIGHT_SLICE_S)
        bench.flying.report()
    assert bench.session.time == 400 * FLIGHT_SLICE_S
    there.close()
    send_queue.close(30.0)
    here.close()


def test_a_flood_of_orders_does_not_stop_the_flight_and_closing_is_heard(monkeypatch):
    """Each turn of the loop takes so many orders at most, and flies what is due."""
    monkeypatch.setattr("workbench.live.flying.MAX_ORDERS_PER_SLICE", 10)
    here, there = Pipe()
    bench = Bench()
    count = 30  # few enough for the pipe to take them all
    for number in range(count):
        there.send(WorkerRequest(number, Action(set={"kp_roll": 50.0 + number / count})))
    there.send(CLOSE_MESSAGE)

    def wanted() -> bool:
        bench.wall += FLIGHT_SLICE_S
        return True

    bench.flying.run(here, wanted)
    times = [answer.value for answer in bench.messages.sent if isinstance(answer, WorkerResult)]
    assert len(times) == count
    assert len(set(times)) == 3  # at three steps
    assert times == sorted(times)
    here.close()
    there.close()


@pytest.mark.parametrize("close", [True, False])
def test_the_loop_ends_when_the_caller_is_gone(close):
    """Either its end of the pipe is closed, or it is nobody's parent any more."""
    here, there = Pipe()
    bench = Bench()
    left = [3]

    def wanted() -> bool:
        left[0] -= 1
        return left[0] > 0

    if close:
        there.close()
        bench.flying.run(here, lambda: True)
    else:
        bench.flying.run(here, wanted)
        assert left == [0]
        there.close()
    here.close()
