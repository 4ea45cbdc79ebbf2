"""Excitations in a live flight: at exact steps, whatever the pace, and always ended by a hover."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.live_orders import execute
from tests.oracles.test_wind import WIND, tilt_by_hand
from workbench.common.errors import WorkbenchError
from workbench.common.resources import models_dir
from workbench.control.mode import FlightMode
from workbench.design.judge.loop_response import loop_responses
from workbench.design.judge.measured_loop import measured_loop
from workbench.design.linear.study import LinearStudy
from workbench.design.step_response import fly_step, unwrapped_yaw
from workbench.ipc.worker_process import WorkerRefusal, WorkerResult
from workbench.live import exciter
from workbench.live.alarms import Alarms
from workbench.live.announcer import WARNING_SEVERITY
from workbench.live.excitation_guard import ExcitationGuard
from workbench.live.exciter import Exciter
from workbench.live.flight import LiveFlight
from workbench.live.flight_clock import FLIGHT_SLICE_S
from workbench.live.flying import FlightLoop
from workbench.live.messages import FlightReport, Pace, Phase, ViewChange
from workbench.live.orders import FlightOrder, FlyOn, KeepLog, MeasureLoop, NetworkOrder, SetSpeed
from workbench.live.step_drive import LOADED_YAW_RATE_RAD_S, StepDrive
from workbench.logs.record import read_log
from workbench.logs.replay import replay
from workbench.scenario.attitude_axes import tilt_angles
from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.loads import find_load
from workbench.scenario.scenario import (
    Action,
    FigureEight,
    Gust,
    Injection,
    Push,
    Rates,
    Scenario,
    ScenarioStart,
    VehicleConfig,
)
from workbench.scenario.scenario_file import load_scenario
from workbench.scenario.sensors_config import SensorsConfig
from workbench.session.checkpoint import Checkpoint
from workbench.session.drift import NEVER_STEADY
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

STEP = Rates().physics_step
CONTROL = Rates().control_period
ONE_STEP = Excitation("x", Shape.STEP, 1.0, 0.5)
SQUARE = Excitation("y", Shape.SQUARE, -0.6, 0.4, repeats=True)
CHIRP = Excitation("z", Shape.CHIRP, 0.4, 1.5)
TURN = Excitation("yaw", Shape.DOUBLET, 0.3, 0.5, repeats=True)
AT_REST = Action(velocity=[0.0, 0.0, 0.0], yaw_rate=0.0)


class KeptMessages:
    """A send queue that keeps all."""

    def __init__(self) -> None:
        self.sent: list[object] = []

    def post(self, message: object) -> None:
        self.sent.append(message)

    show = post


class Bench:
    """A `FlightLoop` and its wall clock."""

    def __init__(self, scenario: Scenario | None = None) -> None:
        self.wall = 0.0
        self.messages = KeptMessages()
        self.bridge = Bridge()
        self.session = Session(scenario, bridge=self.bridge)
        self.flying = FlightLoop(self.session, self.bridge, {}, self.messages, lambda: self.wall)

    def fly(self, seconds: float) -> None:
        end = self.wall + seconds
        while self.wall < end:
            self.wall += min(FLIGHT_SLICE_S, end - self.wall)
            self.flying.fly()

    def fly_to(self, time: float) -> None:
        """Fly at once to the last control update until a simulated time [s]."""
        self.execute(FlightOrder.PAUSE)
        self.execute(FlyOn(time - self.session.time))
        self.execute(FlightOrder.RESUME)
        assert 0.0 <= time - self.session.time < CONTROL

    def execute(self, wanted: object) -> WorkerResult | WorkerRefusal:
        return execute(self.flying, wanted)

    def excite(self, excitation: Excitation) -> WorkerResult | WorkerRefusal:
        return self.execute(excitation)

    @property
    def shown(self) -> FlightReport:
        return next(each for each in reversed(self.messages.sent) if isinstance(each, FlightReport))

    @property
    def asked(self) -> tuple[float, ...]:
        """Velocity and yaw rate that the pilot asks for now."""
        return self.session.snapshot().reference[:4]

    @property
    def done(self) -> list[Action]:
        return self.flying._network.done


def assert_equal_to_the_bit(one: Recording, other: Recording) -> None:
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            a, b = getattr(one, field.name), getattr(other, field.name)
            assert a.tobytes() == b.tobytes(), field.name


def test_a_step_begins_with_the_next_control_update_and_ends_at_exact_steps():
    bench = Bench()
    bench.fly_to(0.3)  # between two control updates: the flight stands at the first of them
    began = bench.excite(ONE_STEP).value
    assert began == 0.296875  # 38 control periods
    assert [each.at for each in bench.done] == [began]  # the update that is due
    bench.fly(6.0)
    on = Action(began, velocity=[1.0, 0.0, 0.0], yaw_rate=0.0)
    off = dataclasses.replace(AT_REST, at=began + 0.5)
    *flown, back, end = bench.done
    assert flown == [on, off]
    assert (back.at, back.go_to) == (began + 1.0, pytest.approx([0.0, 0.0, 1.5]))
    assert end == dataclasses.replace(AT_REST, at=end.at)
    assert bench.shown.exciting is None
    assert bench.asked == (0.0, 0.0, 0.0, 0.0)


def test_the_law_flies_it_from_its_very_beginning():
    """Until then it hovers, at rest; with the update at that time rotors begin to be asked."""
    bench = Bench()
    bench.fly_to(1.0)
    began = bench.excite(dataclasses.replace(ONE_STEP, amplitude=2.0)).value
    assert began == 1.0
    bench.fly_to(1.5)
    flown = bench.execute(FlightOrder.GET_FLOWN).value.recording
    spread = flown.commanded_speeds.max(axis=1) - flown.commanded_speeds.min(axis=1)
    assert spread[flown.time <= began].max() < 1e-3
    assert spread[flown.time == began + CONTROL] > 1.0


def test_it_is_shown_at_once():
    bench = Bench()
    answer = bench.excite(SQUARE)
    assert isinstance(answer, WorkerResult)
    report = bench.shown
    assert report.exciting.excitation == SQUARE
    assert report.exciting.began == answer.value == 0.0
    assert report.exciting.round == 1
    assert report.snapshot.reference[:4] == (0.0, -0.6, 0.0, 0.0)


def test_rounds_are_counted_and_begin_at_exact_times():
    bench = Bench()
    bench.fly_to(0.5)
    bench.excite(SQUARE)  # 0.4 s are 51.2 control periods, 51 are flown
    length = 51 * CONTROL
    bench.fly_to(0.5 + 2 * length)
    assert bench.shown.exciting.round == 2
    assert bench.shown.exciting.began == 0.5 + length
    bench.fly_to(0.5 + 2 * length + CONTROL)
    bench.execute(SetSpeed(1.0))
    assert bench.shown.exciting.round == 3
    assert bench.shown.exciting.began == 0.5 + 2 * length
    begins = [action.at for action in bench.done if action.velocity[1] < 0.0]
    assert begins == [0.5, 0.5 + length, 0.5 + 2 * length]


@pytest.mark.parametrize(
    "excitation",
    [CHIRP, *(pytest.param(each, marks=pytest.mark.slow) for each in (ONE_STEP, SQUARE, TURN))],
    ids=lambda e: e.shape.name,
)
def test_what_is_flown_depends_on_the_order_alone_not_on_the_pace(excitation):
    flown = []
    for speed in (0.5, 4.0):
        bench = Bench()
        bench.execute(SetSpeed(speed))
        bench.fly_to(0.3)
        bench.excite(excitation)
        bench.fly(1.6 / speed)
        bench.fly_to(2.0)
        flown.append(bench)
    states = [bench.execute(FlightOrder.GET_CHECKPOINT).value for bench in flown]
    for bench, state in zip(flown, states, strict=True):
        # how the time was cut is no state of the flight
        assert dataclasses.replace(state, due=2.0) == dataclasses.replace(states[0], due=2.0)
        assert bench.done == flown[0].done
        assert_equal_to_the_bit(bench.session.recording(), flown[0].session.recording())
    assert len(flown[0].done) >= 3


def test_a_chirp_changes_with_every_control_update():
    bench = Bench()
    bench.excite(CHIRP)
    bench.fly_to(2.0)
    sine, back = bench.done[:192], bench.done[192]
    assert [action.at for action in sine] == [k * CONTROL for k in range(192)]
    assert [action.velocity[2] for action in sine] == [CHIRP.command(action.at) for action in sine]
    assert back == Action(1.5, go_to=[0.0, 0.0, 1.5])
    others = bench.flying._network._log.done._others
    assert set(others) == {192}  # each of the sine is kept in a few numbers


@pytest.mark.slow
@pytest.mark.parametrize("excitation", [SQUARE, CHIRP], ids=lambda e: e.shape.name)
def test_a_flight_with_it_is_the_same_again_as_a_scenario(excitation):
    """Its script acts at a step of the excitation, and beside it."""
    script = [
        Action(at=0.5, set={"kp_velocity_y": 3.0}),
        Action(at=0.7003, set={"wind_x": 2.0}),
    ]
    bench = Bench(Scenario(script=script))
    bench.fly_to(0.5)
    bench.excite(excitation)
    bench.fly(0.4)
    bench.execute(Action(set={"kp_roll": 60.0}))
    bench.fly(0.6)
    bench.execute(FlightOrder.STOP_EXCITING)
    bench.fly(0.5)
    flown = bench.execute(FlightOrder.GET_FLOWN).value
    again = Session(flown.scenario)
    again.run()
    assert_equal_to_the_bit(flown.recording, again.recording())


def test_a_flight_with_it_is_replayed_from_its_log(tmp_path):
    bench = Bench()
    path = tmp_path / "flight.mcap"
    bench.execute(KeepLog(str(path)))
    bench.excite(TURN)
    bench.fly(1.3)
    bench.execute(FlightOrder.STOP_EXCITING)
    bench.fly(0.3)
    bench.flying._network.close()
    record = read_log(path)
    assert [done.by for done in record.done] == ["operator"] * len(bench.done)
    assert len(bench.done) >= 5
    assert replay(record).equal


def test_steps_begin_at_rest_also_after_the_flight_back_and_out_of_motion():
    """Within 2 % of the command, which the numbers of a step need; the first one is ordered at
    more than the speed that it commands."""
    bench = Bench()
    bench.execute(Action(velocity=[2.0, 0.0, 0.0]))
    bench.fly(0.5)
    bench.excite(dataclasses.replace(ONE_STEP, repeats=True))
    assert (bench.shown.exciting.round, bench.asked[0]) == (0, 0.0)
    begun = set()
    while bench.shown.exciting.round < 2 and bench.session.time < 15.0:
        bench.fly(0.25)
        if bench.shown.exciting.round:
            begun.add(bench.shown.exciting.began)
    flown = bench.session.recording()
    speeds = [np.abs(flown.v_WB[flown.time == each][0]) for each in begun]
    assert len(speeds) == 2 and np.max(speeds) < 0.02
    assert bench.session.time < 11.0


def test_a_step_of_the_yaw_rate_begins_at_rest_soon_after_the_turn_back():
    bench = Bench()
    bench.excite(Excitation("yaw", Shape.STEP, 0.2, 1.0, repeats=True))
    while bench.shown.exciting.round < 2 and bench.session.time < 20.0:
        bench.fly(0.25)
    began = bench.shown.exciting.began
    flown = bench.session.recording()
    assert abs(flown.w_WB[flown.time == began][0][2]) < 0.02 * 0.2
    assert began < 6.0


def test_a_torque_about_the_vertical_begins_once_the_drone_no_longer_turns():
    bench = Bench()
    bench.execute(Action(yaw_rate=0.3))
    bench.fly(1.0)
    bench.excite(Excitation("torque_yaw", Shape.STEP, 0.05, 1.0))
    assert bench.shown.exciting.round == 0
    while not bench.shown.exciting.round and bench.session.time < 20.0:
        bench.fly(0.25)
    flown = bench.session.recording()
    assert abs(flown.w_WB[flown.time == bench.shown.exciting.began][0][2]) < 0.05


@pytest.mark.slow
@pytest.mark.parametrize("kd_pitch", [27.0, 44.3])
def test_steps_of_an_attitude_begin_level_after_the_flight_back(kd_pitch):
    """Within 2 % of the setpoint, which its numbers need, though the flight back has pitched it.

    With more damping the drone creeps back, slow and hardly turning, but still tilted.
    """
    bench = Bench()
    bench.execute(Action(set={"kd_pitch": kd_pitch}))
    bench.excite(Excitation("pitch", Shape.STEP, 0.1, 1.0, repeats=True))
    begun = set()
    while bench.shown.exciting.round < 3 and bench.session.time < 20.0:
        bench.fly(0.25)
        begun.add(bench.shown.exciting.began)
    flown = bench.session.recording()
    pitch = Rotation.from_quat(flown.q_WB, scalar_first=True).as_euler("ZYX")[:, 1]
    assert np.abs(pitch).max() > 0.09
    assert len(begun) == 3
    assert np.abs(pitch[np.isin(flown.time, [*begun])]).max() < 0.02 * 0.1
    assert bench.session.time < 12.0


def test_a_step_that_never_comes_to_rest_is_flown_nevertheless():
    """In turbulence; 3 s after it has become no slower."""
    bench = Bench(HIGH)
    bench.execute(Action(set={"turbulence": 15.4}))
    bench.fly(1.0)
    bench.excite(ONE_STEP)
    assert bench.shown.exciting.round == 0
    bench.fly(5.0)
    assert bench.shown.exciting.round == 1


@pytest.mark.slow
def test_repeated_steps_begin_once_a_load_no_longer_swings():
    """For a whole swing before each, its speed is below 2 % of the step; it stands still twice."""
    slung = Scenario(
        start=ScenarioStart(position=[0.0, 0.0, 30.0]), vehicle=VehicleConfig(model="slung_load")
    )
    bench = Bench(slung)
    bench.excite(dataclasses.replace(ONE_STEP, repeats=True))
    begun = {}
    while bench.shown.exciting.round < 3 and bench.session.time < 60.0:
        bench.fly(0.25)
        begun[bench.shown.exciting.round] = bench.shown.exciting.began
        assert not bench.shown.exciting.swings
    flown = bench.session.recording()
    for number in (1, 2, 3):
        before = flown.between(begun[number] - 2.0, begun[number])
        assert np.linalg.norm(before.v_WB, axis=1).max() < 0.02
    assert begun[2] - begun[1] > 10.0


def swinging(monkeypatch, unrest):
    """A flight of a vehicle with loose joints whose unrest is a function of time [s]."""
    monkeypatch.setattr(Exciter, "_is_loose", property(lambda _: True))
    monkeypatch.setattr(StepDrive, "unrest", lambda self: unrest(self._session.time))
    return Bench(HIGH)


def test_a_step_waits_for_the_largest_motion_of_a_swing(monkeypatch):
    """8 exp(-t / 2) |cos(pi t)| is zero each second, 1.08 at 4 s, and at most 0.66 from 5 s on."""
    bench = swinging(monkeypatch, lambda t: 8.0 * math.exp(-0.5 * t) * abs(math.cos(math.pi * t)))
    bench.excite(ONE_STEP)
    bench.fly(5.0)
    assert (bench.shown.exciting.round, bench.asked[0]) == (0, 0.0)
    assert bench.shown.exciting.waited == pytest.approx(5.0, abs=0.2)
    bench.fly(1.9)
    assert bench.shown.exciting.round == 0
    bench.fly(0.6)
    assert (bench.shown.exciting.round, bench.asked[0]) == (1, 1.0)
    assert 7.0 <= bench.shown.exciting.began <= 7.5
    assert (bench.shown.exciting.waited, bench.shown.exciting.swings) == (None, False)


@pytest.mark.slow
@pytest.mark.parametrize("amplitude", [1.0, 0.05])  # of a small one it need not fly back
def test_the_next_round_waits_for_the_swing_after_the_last_one(amplitude, monkeypatch):
    """8 exp(4 - t) |sin(pi t)| is 0 at the end of the round at 4 s, at most 1.8 until 6 s, and at
    most 0.7 from then on; the round begins 3 s after it was last 1, between 5.5 s and 6 s."""

    def unrest(t):
        return 8.0 * math.exp(4.0 - t) * abs(math.sin(math.pi * t)) if t > 4.0 else 0.0

    bench = swinging(monkeypatch, unrest)
    bench.excite(dataclasses.replace(ONE_STEP, amplitude=amplitude, repeats=True))
    while bench.shown.exciting.round < 2 and bench.session.time < 20.0:
        bench.fly(0.25)
        if bench.session.time > 8.0 and bench.shown.exciting.round == 1:
            assert bench.shown.exciting.waited > 3.5
    assert 8.5 <= bench.shown.exciting.began <= 9.1
    assert bench.shown.exciting.from_rest


def test_a_vehicle_at_rest_with_loose_joints_is_known_to_be_after_3_s(monkeypatch):
    bench = swinging(monkeypatch, lambda t: 0.0)
    bench.excite(ONE_STEP)
    bench.fly(2.9)
    assert bench.shown.exciting.round == 0
    bench.fly(0.3)
    assert bench.shown.exciting.began == pytest.approx(3.0, abs=0.15)


@pytest.mark.slow
def test_steps_are_not_repeated_while_joints_swing_on_and_a_single_one_has_no_numbers(
    monkeypatch, case
):
    """Neither in a swing that does not decay, nor in one that takes too long, here 4 s and 5 s."""
    for name, unrest, most, waits in (
        ("steady", lambda t: 5.0 * abs(math.cos(math.pi * t)), 60.0, 4.0),
        ("slow", lambda t: 50.0 * math.exp(-0.1 * t), 5.0, 5.0),
    ):
        with case(name):
            monkeypatch.setattr(exciter, "MAX_SWING_WAIT_S", most)
            monkeypatch.setattr(exciter, "MAX_UNDAMPED_WAIT_S", 4.0)
            bench = swinging(monkeypatch, unrest)
            bench.excite(dataclasses.replace(ONE_STEP, repeats=True))
            bench.fly(waits - 0.5)
            assert bench.shown.exciting.round == 0
            bench.fly(1.0)
            assert bench.shown.exciting is None
            assert bench.asked == (0.0, 0.0, 0.0, 0.0)
            ended = bench.shown.excitation_ended
            assert f"still swings after {waits:.0f} s: damp its swing" in ended
            assert "larger amplitude, or fly a single one" in ended
            bench = swinging(monkeypatch, unrest)
            bench.excite(ONE_STEP)
            bench.fly(waits + 0.25)
            assert (bench.shown.exciting.round, bench.shown.exciting.swings) == (1, True)


def test_stopping_lets_it_hover_where_it_is():
    bench = Bench()
    bench.excite(dataclasses.replace(ONE_STEP, period=5.0))
    bench.fly(1.0)
    assert bench.asked == (1.0, 0.0, 0.0, 0.0)
    assert bench.execute(FlightOrder.STOP_EXCITING).value == bench.session.time
    assert bench.shown.exciting is None
    assert bench.asked == (0.0, 0.0, 0.0, 0.0)
    bench.fly(4.0)
    assert abs(bench.session.snapshot().v_WB[0]) < 0.01
    assert bench.session.snapshot().p_WB[0] > 0.5
    assert isinstance(bench.execute(FlightOrder.STOP_EXCITING), WorkerResult)  # twice is no fault
    assert len(bench.done) == 2


def test_any_other_order_that_flies_ends_it(case):
    for order, asked in [
        (Action(velocity=[0.0, 0.0, 0.2]), (0.0, 0.0, 0.2, 0.0)),
        (Action(yaw_rate=0.1), (0.0, 0.0, 0.0, 0.1)),
        (Action(go_to=[0.0, 1.0, 2.0]), (0.0, 0.0, 0.0, 0.0)),
        (Action(request="hold"), (0.0, 0.0, 0.0, 0.0)),
        (Action(request="land"), (0.0, 0.0, 0.0, 0.0)),
        (Action(request="stop"), (0.0, 0.0, 0.0, 0.0)),
        (FlightOrder.RESET, (0.0, 0.0, 0.0, 0.0)),
        (NetworkOrder.GIVE_BACK, (0.0, 0.0, 0.0, 0.0)),
    ]:
        with case(order, asked):
            bench = Bench()
            bench.excite(SQUARE)
            bench.fly(0.1)
            assert isinstance(bench.execute(order), WorkerResult)
            assert bench.shown.exciting is None
            assert bench.asked == asked
            before = list(bench.done)
            bench.fly(0.6)
            assert bench.done == before
            assert bench.asked == asked


@pytest.mark.parametrize(
    "order",
    [
        Action(set={"kp_roll": 60.0}),
        Action(go_to=[0.0, 0.0, -5.0]),
        Action(request="take_off", height=-1.0),
        SetSpeed(2.0),
        NetworkOrder.TAKE_OVER,
        dataclasses.replace(SQUARE, period=0.0),
    ],
    ids=str,
)
def test_what_does_not_fly_or_is_refused_leaves_it_alone(order):
    bench = Bench()
    bench.excite(SQUARE)
    bench.fly(0.1)
    bench.execute(order)
    assert bench.shown.exciting.excitation == SQUARE
    assert bench.asked == (0.0, -0.6, 0.0, 0.0)


def test_another_one_takes_its_place():
    bench = Bench()
    bench.excite(SQUARE)
    bench.fly(0.1)
    began = bench.excite(TURN).value
    assert bench.shown.exciting.excitation == TURN
    assert bench.shown.exciting.began == began
    bench.fly(0.05)
    assert bench.asked == (0.0, 0.0, 0.0, 0.3)


def test_one_that_takes_its_place_goes_back_to_where_the_first_began(monkeypatch):
    """Before an obstacle the drone is sent there: not to where it was when it was asked again."""
    bench = Bench()
    began = bench.session.snapshot().p_WB
    bench.excite(Excitation("x", Shape.STEP, 1.0, 2.0))
    bench.fly(1.0)
    assert bench.session.snapshot().p_WB[0] > began[0] + 0.3
    bench.excite(Excitation("y", Shape.STEP, 1.0, 2.0))
    bench.fly(0.1)
    monkeypatch.setattr(ExcitationGuard, "obstacle", lambda self: "a wall is 0.1 m ahead")
    bench.fly(0.1)
    assert "goes back to where it began" in bench.shown.excitation_ended
    assert bench.done[-1].go_to == pytest.approx(began, abs=1e-6)


def test_what_the_script_flies_ends_it_at_an_exact_step():
    script = [Action(at=0.4, yaw_rate=0.2)]
    recordings = []
    for speed in (0.5, 4.0):
        bench = Bench(Scenario(script=script))
        bench.execute(SetSpeed(speed))
        bench.excite(SQUARE)
        bench.fly(0.8 / speed)
        assert bench.shown.exciting is None
        assert bench.asked == (0.0, 0.0, 0.0, 0.0)  # who set it to 0 is the excitation's end
        bench.fly_to(1.0)
        # the script acts at the 52nd update, and is seen at the next one
        assert [action.at for action in bench.done][-1] == 53 * CONTROL
        recordings.append(bench.execute(FlightOrder.GET_FLOWN).value)
    assert_equal_to_the_bit(recordings[0].recording, recordings[1].recording)
    again = Session(recordings[0].scenario)
    again.run()
    assert_equal_to_the_bit(recordings[0].recording, again.recording())


def test_what_the_script_asks_for_stays():
    bench = Bench(Scenario(script=[Action(at=0.4, velocity=[0.3, 0.2, 0.1])]))
    bench.excite(SQUARE)
    bench.fly(0.8)
    assert bench.shown.exciting is None
    assert bench.asked == (0.3, 0.2, 0.1, 0.0)


def test_a_landing_that_the_battery_asks_for_ends_it():
    bench = Bench()
    bench.excite(TURN)
    bench.fly(0.5)
    bench.execute(Action(set={"battery_reserve": 0.9, "battery_duration": 1.0}))
    bench.fly(0.5)
    assert bench.session.snapshot().mode is FlightMode.LANDING
    assert bench.shown.exciting is None
    assert bench.asked == (0.0, 0.0, 0.0, 0.0)


def test_a_flight_that_breaks_ends_it(monkeypatch):
    from workbench.common.errors import FlightBrokenError

    def refuse(_duration: float) -> None:
        raise FlightBrokenError("it broke")

    bench = Bench()
    bench.excite(SQUARE)
    bench.fly(0.1)
    monkeypatch.setattr(bench.session, "tick", refuse)
    bench.fly(0.1)
    assert bench.shown.phase is Phase.BROKEN
    assert bench.shown.exciting is None
    assert "reset it first" in bench.excite(SQUARE).said
    assert "reset it first" in bench.execute(FlightOrder.GET_CHECKPOINT).said


@pytest.mark.parametrize("mode", ["off", "taking off", "landing"])
def test_a_drone_that_does_not_fly_is_not_excited(mode):
    orders = {
        "off": None,
        "taking off": Action(request="take_off", height=2.0),
        "landing": Action(request="land"),
    }
    start = ScenarioStart(mode="hovering" if mode == "landing" else "off")
    bench = Bench(Scenario(start=start))
    if orders[mode]:
        bench.execute(orders[mode])
    bench.fly(1.0)
    said = bench.excite(ONE_STEP).said
    assert f"the drone is {mode}: it can be excited once it hovers" in said
    assert bench.shown.exciting is None


def test_what_is_out_of_the_limits_of_the_flight_is_refused():
    bench = Bench()
    names = {"x": "max_speed", "z": "max_climb_rate", "yaw": "max_yaw_rate", "roll": "max_tilt"}
    limits = {axis: bench.session.get(name) for axis, name in names.items()}
    for axis, limit in limits.items():
        most = Excitation(axis, Shape.STEP, limit, 0.5)
        assert isinstance(bench.excite(most), WorkerResult)
        said = bench.excite(dataclasses.replace(most, amplitude=-1.01 * limit)).said
        assert f"within ±{limit:g}" in said
    said = bench.excite(dataclasses.replace(most, amplitude=math.nan)).said
    assert "amplitude is nan" in said


def test_a_rate_may_turn_by_the_largest_tilt_within_its_step():
    bench = Bench(Scenario(controller="px4"))
    most = Excitation("roll_rate", Shape.STEP, bench.session.get("max_tilt") / 0.25, 0.25)
    assert isinstance(bench.excite(most), WorkerResult)
    said = bench.excite(dataclasses.replace(most, amplitude=1.01 * most.amplitude)).said
    assert f"within ±{most.amplitude:g}" in said


def test_rounds_may_drift_by_half_a_metre_and_by_half_a_second_of_what_is_asked_for(case):
    session = Bench().session
    for axis, amplitude, stray, turn_rate in (
        ("x", -4.0, 2.5, 4.0),
        ("z", 0.5, 0.75, 0.5),
        ("roll", 0.3, 0.5, LOADED_YAW_RATE_RAD_S),
        ("force_x", 3.0, 0.5, LOADED_YAW_RATE_RAD_S),
    ):
        drive = StepDrive(session, Excitation(axis, Shape.STEP, amplitude, 1.0))
        with case(axis):
            assert (drive.stray, drive.turn_rate) == (stray, turn_rate)


def test_a_figure_of_eight_is_not_excited():
    bench = Bench(Scenario(figure_eight=FigureEight()))
    assert "figure of eight" in bench.excite(ONE_STEP).said


def test_a_client_that_flies_loses_control_and_the_drone_holds_first():
    bench = Bench()
    bench.bridge.authority.request(7, "robot", bench.session.time)
    bench.excite(ONE_STEP)
    assert bench.flying._network.operates
    assert bench.done[0].request == "hold"
    assert bench.done[1].velocity == [1.0, 0.0, 0.0]


def test_an_instant_in_the_middle_of_it_is_what_the_flight_is():
    bench = Bench()
    bench.excite(SQUARE)
    bench.fly_to(0.35)
    checkpoint = bench.execute(FlightOrder.GET_CHECKPOINT).value
    assert isinstance(checkpoint, Checkpoint)
    assert checkpoint.velocity == (0.0, 0.6, 0.0)
    assert checkpoint == bench.session.checkpoint()


def test_replays_are_saved_as_scenarios(tmp_path):
    from workbench.scenario.scenario_file import save_scenario

    bench = Bench()
    bench.excite(CHIRP)
    bench.fly_to(1.0)
    flown = bench.execute(FlightOrder.GET_FLOWN).value
    save_scenario(flown.scenario, tmp_path / "again.yaml")
    again = Session(load_scenario(tmp_path / "again.yaml"))
    again.run()
    assert_equal_to_the_bit(flown.recording, again.recording())


@pytest.mark.slow
@pytest.mark.parametrize(
    "excitation",
    [
        Excitation("x", Shape.STEP, 1.0, 2.0, repeats=True),
        Excitation("yaw", Shape.DOUBLET, 0.4, 2.0, repeats=True),
    ],
    ids=lambda e: e.shape.name,
)
def test_an_excitation_that_repeats_in_wind_does_not_wander_off(excitation):
    """Each round goes back to where the first one began, and the next one begins at rest."""
    bench = Bench(Scenario(script=[Action(at=0.0, set={"wind_x": 5.0, "wind_y": -3.0})]))
    bench.fly(4.0)
    begun = bench.session.snapshot()
    assert isinstance(bench.excite(excitation), WorkerResult)
    bench.fly(40.0)
    assert bench.shown.exciting.round > 2
    assert bench.shown.excitation_ended == ""
    flown = bench.session.recording().between(4.0, np.inf)
    furthest = abs(excitation.amplitude) * excitation.period + 1.5
    assert np.linalg.norm(flown.p_WB - begun.p_WB, axis=1).max() < furthest
    yaw = unwrapped_yaw(flown.q_WB)
    assert np.abs(yaw - yaw[0]).max() < abs(excitation.amplitude) * excitation.period + 0.3


@pytest.mark.slow
def test_in_wind_a_step_goes_from_the_drift_as_that_of_fly_step_does():
    windy = fly_step("x", 1.0, duration=2.0, settings={"wind_x": WIND})
    bench = Bench(Scenario(script=[Action(at=0.0, set={"wind_x": WIND})]))
    bench.fly(3.0)
    step = Excitation("x", Shape.STEP, 1.0, 2.0)
    bench.excite(step)
    assert bench.shown.exciting.drifts
    while bench.shown.exciting.round == 0:
        bench.fly(0.5)
        assert bench.session.time < 60.0
    exciting = bench.shown.exciting
    bench.fly_to(exciting.began + 2.0)
    assert (exciting.drifts, exciting.unsteady) == (False, "")
    assert exciting.hover == pytest.approx(windy.before, abs=2e-3)
    flown = bench.session.recording().between(exciting.began, exciting.began + 2.0)
    response = np.interp(flown.time - exciting.began, windy.time, windy.response)
    assert flown.v_WB[:, 0] - exciting.hover == pytest.approx(response, abs=5e-3)


@pytest.mark.parametrize(
    ("excitation", "air", "why"),
    [
        pytest.param(
            *(dataclasses.replace(SQUARE, axis="x"), {"wind_x": 6.0}, "fly a step or a doublet"),
            marks=pytest.mark.slow,
        ),
        (ONE_STEP, {"wind_x": 6.0, "turbulence": 15.4}, "the air is turbulent"),
        pytest.param(ONE_STEP, {}, "", marks=pytest.mark.slow),
        pytest.param(
            *(ONE_STEP, {"gust_x": 5.0, "gust_start": 0.5, "gust_duration": 0.5}, ""),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_round_says_why_the_air_leaves_it_without_numbers(excitation, air, why):
    bench = Bench(Scenario(script=[Action(at=0.0, set=air)]))
    bench.fly(2.0)
    bench.excite(excitation)
    while bench.shown.exciting.round == 0:
        assert not bench.shown.exciting.drifts
        bench.fly(0.5)
    said = bench.shown.exciting.unsteady
    assert why in said if why else said == ""


@pytest.fixture
def walled(tmp_path):
    """A wall 3 m to the east of where the flight begins."""
    path = tmp_path / "walled.yaml"
    path.write_text(
        "title: A wall\nobstacles:\n"
        "  - {name: wall, shape: {box: [0.2, 20, 6]}, position: [3.1, 0, 3]}\n"
    )
    return Scenario(world=str(path))


def test_an_excitation_without_room_is_refused_and_nothing_moves(walled):
    bench = Bench(walled)
    towards = Excitation("x", Shape.STEP, 2.0, 2.0, repeats=True)
    said = bench.excite(towards).said
    assert "the excitation needs 5.6 m east, and wall is 2." in said
    said = bench.excite(Excitation("z", Shape.STEP, -1.0, 2.0)).said
    assert "down, and the ground is 1." in said
    assert bench.done == []
    for change in ({"amplitude": -2.0}, {"axis": "y"}):
        assert isinstance(bench.excite(dataclasses.replace(towards, **change)), WorkerResult)


@pytest.mark.slow
def test_an_excitation_stops_before_what_comes_into_its_way(walled):
    """There is room for it in still air; then a wind blows towards the wall."""
    bench = Bench(walled)
    assert isinstance(bench.excite(Excitation("x", Shape.STEP, 0.8, 2.0, True)), WorkerResult)
    bench.execute(Action(set={"wind_x": 6.0}))
    bench.fly(15.0)
    assert bench.shown.exciting is None
    assert "the drone goes back to where it began" in bench.shown.excitation_ended
    assert bench.session.snapshot().p_WB[0] < 1.0
    flown = bench.session.recording()
    assert flown.p_WB[:, 0].max() < 2.6
    assert bench.shown.hit is None


SWINGING = {"of its attitude": {"kd_pitch": 1.0}, "of its velocity": {"kp_velocity_x": 18.0}}


@pytest.mark.slow
@pytest.mark.parametrize("gains", SWINGING.values(), ids=SWINGING)
def test_an_excitation_ends_when_the_drone_swings_at_a_step_that_no_pace_moves(gains):
    flown = []
    for speed in (0.5, 4.0):
        bench = Bench()
        bench.execute(SetSpeed(speed))
        bench.execute(Action(set=gains))
        bench.excite(Excitation("x", Shape.STEP, 1.0, 2.0, repeats=True))
        bench.fly(3.0 / speed)
        assert bench.shown.exciting is None
        assert "the drone oscillates" in bench.shown.excitation_ended
        flown.append(bench.done)
    assert flown[0] == flown[1]
    assert flown[0][-1].velocity == [0.0, 0.0, 0.0]


@pytest.mark.slow
def test_a_hard_hit_is_told_and_a_landing_is_none(walled):
    bench = Bench(walled)
    bench.execute(Action(velocity=[2.0, 0.0, 0.0]))
    bench.fly(3.0)
    assert bench.shown.hit.speed > 1.0
    bench = Bench()
    bench.execute(Action(request="land"))
    bench.fly(6.0)
    assert bench.session.snapshot().mode is FlightMode.OFF
    assert bench.shown.hit is None


def test_what_hits_again_within_a_second_is_the_same_hit():
    session = Session()
    watch = Alarms(session, lambda said: None)
    for speed in (5.0, 9.0):
        watch.look_for_hit(np.array([speed, 0.0, 0.0]), 0.0)
        assert watch.hit.speed == pytest.approx(5.0)
    session.tick(1.0 + CONTROL)
    watch.look_for_hit(session.state()[10:13] + [9.0, 0.0, 0.0], 0.0)
    assert watch.hit.speed == pytest.approx(9.0)


ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""


def test_a_live_flight_is_excited_shows_it_and_hands_out_instants():
    with LiveFlight(Scenario()) as flight:
        flight.wait(ENOUGH)
        flight.pause().result(ENOUGH)
        assert flight.latest().exciting is None
        began = flight.excite(SQUARE).result(ENOUGH)
        shown = flight.latest().exciting
        assert (shown.excitation, shown.began, shown.round) == (SQUARE, began, 1)
        flight.fly_on(1.0 + CONTROL).result(ENOUGH)  # past the edge of the third round
        assert flight.latest().exciting.round == 3
        checkpoint = flight.checkpoint().result(ENOUGH)
        flight.fly_on(0.5).result(ENOUGH)
        flight.stop_exciting().result(ENOUGH)
        assert flight.latest().exciting is None
        assert flight.latest().snapshot.reference[:4] == (0.0, 0.0, 0.0, 0.0)
        flown = flight.flown().result(ENOUGH).recording
        wrong = flight.excite(dataclasses.replace(SQUARE, period=100.0))
        with pytest.raises(WorkbenchError, match="period is 100 s"):
            wrong.result(ENOUGH)
    fork = Session()  # it knows nothing of the excitation: 0.1 s later comes the next edge
    fork.begin_from(checkpoint)
    fork.tick(0.1)
    same = flown.between(checkpoint.time, fork.time)
    assert len(same.time) > 10
    assert fork.recording().p_WB.tobytes() == same.p_WB.tobytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "amplitude", "most"),
    [("force_x", 1.0, 0.2), ("force_z", -1.0, 0.15), ("torque_pitch", 0.1, 0.05)],
)
def test_a_load_acts_while_the_drone_is_asked_to_stay_and_ends(name, amplitude, most):
    """As a push at the centre of mass, logged as an action, which flies the same again."""
    bench = Bench()
    bench.fly_to(1.0)
    began = bench.excite(Excitation(name, Shape.STEP, amplitude, 1.5)).value
    bench.fly(1.0)
    row = find_load(name)
    pushed = row.action(amplitude, 1.5, bench.session.vehicle.p_BoBcm_B)
    stay = dataclasses.replace(AT_REST, at=began, push=pushed.push)
    assert bench.done == [stay]
    assert bench.session.get(row.limit) == amplitude
    bench.fly(4.0)
    assert bench.done[1] == dataclasses.replace(AT_REST, at=began + 1.5, push=Push())
    assert bench.shown.exciting is None
    assert not bench.shown.excitation_ended
    flown = bench.execute(FlightOrder.GET_FLOWN).value
    loaded = flown.recording.between(began, began + 1.5)
    moved = row.moved(loaded.q_WB, loaded.p_WB, loaded.w_WB)
    assert 0.02 * most < np.abs(moved).max() < most
    again = Session(flown.scenario)
    again.run()
    assert_equal_to_the_bit(flown.recording, again.recording())


def a_client(bench) -> None:
    bench.execute(NetworkOrder.GIVE_BACK)
    bench.bridge.authority.request(7, "robot", bench.session.time)


@pytest.mark.parametrize(
    "takes_over", [lambda bench: bench.execute(Action(request="land")), a_client]
)
def test_a_load_ends_with_whoever_takes_over(takes_over):
    bench = Bench()
    bench.excite(Excitation("force_y", Shape.SQUARE, 1.0, 1.0, repeats=True))
    bench.fly(0.25)
    assert bench.session.get("push_y") == 1.0
    takes_over(bench)
    bench.fly(0.125)
    assert bench.shown.exciting is None
    assert bench.session.get("push_y") == 0.0


@pytest.mark.slow
def test_a_load_of_a_torque_about_yaw_is_turned_back():
    bench = Bench()
    bench.excite(Excitation("torque_yaw", Shape.STEP, 0.03, 1.0))
    bench.fly(1.5)
    assert bench.shown.snapshot.roll_pitch_yaw[2] > 0.12
    bench.fly(8.0)
    assert bench.shown.exciting is None
    assert abs(bench.shown.snapshot.roll_pitch_yaw[2]) < 0.11


def test_a_load_beyond_its_parameters_range_is_refused():
    bench = Bench()
    refused = bench.excite(Excitation("torque_roll", Shape.STEP, 101.0, 1.0))
    assert isinstance(refused, WorkerRefusal)
    assert "101 N·m" in refused.said and "±100 N·m" in refused.said


@pytest.mark.slow
def test_a_gust_blows_once_and_the_drone_has_time_to_come_back():
    bench = Bench()
    assert "the shape pulse" in bench.excite(Excitation("gust_y", Shape.STEP, 6.0, 1.0)).said
    began = bench.excite(Excitation("gust_y", Shape.PULSE, 6.0, 1.5)).value
    bench.fly(4.45)
    assert bench.shown.exciting is not None
    assert bench.done[0] == dataclasses.replace(AT_REST, at=began, gust=Gust([0.0, 6.0, 0.0], 1.5))
    bench.fly(4.0)
    assert bench.shown.exciting is None
    flown = bench.execute(FlightOrder.GET_FLOWN).value
    wind = flown.recording.wind_W[:, 1]
    assert wind.max() == pytest.approx(6.0, rel=0.01)
    assert wind[flown.recording.time > began + 1.51].max() == 0.0
    assert 0.02 < np.abs(flown.recording.p_WB[:, 1]).max() < 0.5


def test_what_disturbs_the_drone_stands_among_the_events(tmp_path):
    """In words, beside the actions: of a push, a gust, the wind and faults, and of repairs."""
    bench = Bench()
    path = tmp_path / "disturbed.mcap"
    bench.execute(KeepLog(str(path)))
    bench.fly(0.1)
    bench.excite(Excitation("force_x", Shape.PULSE, 2.0, 0.25))
    bench.fly(0.5)
    bench.execute(Action(push=Push(torque=[0.0, 0.0, 0.02])))
    bench.execute(Action(gust=Gust([0.0, 3.0, 0.0])))
    bench.execute(Action(set={"wind_x": 4.0, "wind_y": 0.0, "wind_z": 0.0, "turbulence": 7.7}))
    bench.execute(Action(set={"turbulence": 3.0}))
    bench.execute(Action(set={"rotor_2": 0.8}))
    bench.execute(Action(set={"rotor_2": 1.0, "kp_roll": 200.0}))
    bench.fly(0.1)
    bench.execute(NetworkOrder.STOP_LOG)
    said = read_log(path).flight["events.said"].values.tolist()
    assert said[said.index("a push of (2, 0, 0) N for 0.25 s") :] == [
        "a push of (2, 0, 0) N for 0.25 s",
        "a torque of (0, 0, 0.02) N·m for 0.1 s",
        "a gust of (0, 3, 0) m/s for 1 s",
        "a wind of (4, 0, 0) m/s",
        "turbulence: light",
        "turbulence: 3 m/s at 20 ft",
        "rotor 2 at 80 %",
        "rotor 2 repaired",
    ]
    assert [each.action for each in read_log(path).done if each.action.gust is not None]


MEASURE = MeasureLoop(Injection("acceleration_z", 1.0, 3.0, 30.0, 4), False)
"""Some 8.4 s: four periods, of which three are measured."""


def measured(bench):
    return [each.values["measured"] for each in bench.messages.sent if isinstance(each, ViewChange)]


@pytest.mark.slow
def test_a_measurement_is_told_after_each_period_and_flies_again_from_what_was_done():
    bench = Bench()
    bench.fly(0.31)
    assert isinstance(bench.execute(MEASURE), WorkerResult)
    bench.fly(1.0)
    assert 0.05 < bench.shown.measuring < 0.3
    bench.fly(9.0)
    assert bench.shown.measuring is None and bench.shown.excitation_ended == ""
    assert [len(each.came) for each in measured(bench)] == [2, 3]
    found = measured_loop(measured(bench)[-1])
    model = loop_responses(LinearStudy().sampled(), ["acceleration_z"]).at(found.frequency)[0]
    np.testing.assert_allclose(found.response, model, rtol=0.1)
    first, last = bench.done
    assert first.injection == MEASURE.injection and first.velocity[0] > 0.0
    assert last.injection == Injection() and last.go_to == pytest.approx([0.0, 0.0, 1.5])
    flown = bench.execute(FlightOrder.GET_FLOWN).value
    again = Session(flown.scenario)
    again.tick(bench.session.time)
    assert_equal_to_the_bit(again.recording(), flown.recording)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "said"),
    [
        (FlightOrder.STOP_EXCITING, ""),
        (Action(velocity=[0.5, 0.0, 0.0]), ""),
        (Action(request="land"), ""),
        (ONE_STEP, ""),
        (Action(set={"kp_velocity_z": 5.0}), "a parameter was changed"),
    ],
)
def test_another_order_ends_a_measurement(order, said):
    bench = Bench()
    bench.fly(0.2)
    bench.execute(MEASURE)
    bench.fly(1.0)
    bench.execute(order)
    bench.fly(0.1)
    assert bench.shown.measuring is None and bench.session.injecting is None
    assert said in bench.shown.excitation_ended
    bench.fly(2.0)
    assert measured(bench) == []


def test_a_landing_and_a_client_end_a_measurement_and_its_injection():
    """A battery that is at its reserve after 2 s; control that is given back."""
    bench = Bench()
    bench.execute(Action(set={"battery_reserve": 0.9, "battery_duration": 20.0}))
    bench.execute(MEASURE)
    bench.fly(1.0)
    assert bench.shown.measuring is not None
    bench.fly(2.0)
    assert bench.session.snapshot().mode is FlightMode.LANDING
    assert bench.shown.measuring is None and bench.session.injecting is None

    bench = Bench()
    bench.execute(MEASURE)
    bench.fly(1.0)
    bench.execute(NetworkOrder.GIVE_BACK)
    bench.bridge.authority.request(7, "robot", bench.session.time)
    assert bench.session.injecting is not None
    bench.fly(0.5)
    assert bench.shown.measuring is None and bench.session.injecting is None
    assert bench.asked == (0.0, 0.0, 0.0, 0.0), "the robot's grant holds"


def test_no_measurement_begins_on_the_ground_or_of_nothing():
    bench = Bench(Scenario(start=ScenarioStart(mode="off")))
    assert "once it hovers" in bench.execute(MEASURE).said
    bench = Bench()
    wrong = MeasureLoop(Injection("acceleration_w", 1.0), False)
    assert "unknown loop point" in bench.execute(wrong).said
    assert bench.done == [] and bench.shown.measuring is None


def test_a_drone_that_swings_ends_its_measurement():
    bench = Bench()
    bench.execute(MeasureLoop(Injection("roll_acceleration", 500.0, 3.0, 60.0, 3), False))
    bench.fly(3.0)
    assert "oscillates" in bench.shown.excitation_ended
    assert bench.session.injecting is None


def kept_events(bench):
    """What is published as a warning from now on."""
    network, found = bench.flying._network, []
    publish = network.event

    def keep(said, severity=0):
        if severity == WARNING_SEVERITY:
            found.append(said)
        publish(said, severity)

    network.event = keep
    return found


HIGH = Scenario(start=ScenarioStart(position=[0.0, 0.0, 30.0]))


def nudged(gains, seconds=6.0):
    """Warnings of a flight whose gains become these while it moves a little, and the flight."""
    bench = Bench(HIGH)
    told = kept_events(bench)
    bench.execute(Action(set=gains))
    bench.execute(Action(velocity=[0.5, 0.3, 0.0]))
    bench.fly(0.5)
    bench.execute(AT_REST)
    bench.fly(seconds)
    return told, bench


@pytest.mark.slow
def test_a_swing_is_told_once_with_its_loop_and_frequency(case):
    """The loop is that whose gains are wrong, though both swing alike; the frequency is that of
    the flown motion, by its turns."""
    for gains, loop, axis in (
        ({"kp_velocity_y": 20.0}, "velocity y", 0),
        ({"kd_pitch": 8.0}, "pitch", 1),
        ({"kd_roll": 8.0}, "roll", 0),
    ):
        with case(loop):
            told, bench = nudged(gains, 2.6)
            (alarm,) = [each for each in told if "oscillates" in each]
            assert f"oscillates in the loop {loop}, at " in alarm
            assert f"give {loop} more phase margin" in alarm
            flown = bench.session.recording().between(bench.session.time - 2.3, np.inf)
            rate = flown.w_WB[:, axis]
            (turns,) = np.nonzero((rate[:-1] < 0.0) & (rate[1:] >= 0.0))
            found = float(alarm.split(", at ")[1].split()[0])
            assert found == pytest.approx(1.0 / np.diff(flown.time[turns]).mean(), rel=0.1)


@pytest.mark.slow
def test_a_slow_swing_is_told_with_the_velocity_or_position_loop(case):
    """Below 1 Hz; the frequency is that of the flown velocity, by its turns."""
    for gains, loop in (
        ({"ki_velocity_xy": 12.0, "kp_velocity_xy": 1.5}, "velocity x"),
        ({"kp_position_xy": 5.0, "kp_velocity_xy": 1.8, "ki_velocity_xy": 2.1}, "position x"),
    ):
        with case(loop):
            bench = Bench(dataclasses.replace(HIGH, controller="pid"))
            told = kept_events(bench)
            bench.execute(Action(set=gains))
            bench.execute(Action(velocity=[0.9, 0.0, 0.0]))
            bench.fly(0.7)
            bench.execute(AT_REST)
            for _ in range(30):
                bench.fly(1.0)
                if told:
                    break
            (alarm,) = told
            assert f"oscillates in the loop {loop}, at 0." in alarm
            assert f"give {loop} more phase margin" in alarm
            flown = bench.session.recording().between(bench.session.time - 6.0, np.inf)
            speed = flown.v_WB[:, 0]
            (turns,) = np.nonzero((speed[:-1] < 0.0) & (speed[1:] >= 0.0))
            found = float(alarm.split(", at ")[1].split()[0])
            assert found == pytest.approx(1.0 / np.diff(flown.time[turns]).mean(), rel=0.1)


def watched(session, seconds):
    """What alarms tell of a flight that nobody excites."""
    told = []
    watch = Alarms(session, told.append)
    step = session.scenario.rates.physics_step
    for part in watch.parts(round(seconds / step)):
        session.tick(part * step)
        watch.look(excited=False)
    return told


SCENARIOS = [
    "estimate-complementary",
    "estimate-ekf",
    "figure-eight",
    "full-speed",
    "hover",
    "paper-steps",
    "square",
    "take-off-and-land",
    "windy",
]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    SCENARIOS,
)
def test_no_shipped_scenario_raises_an_alarm_and_four_end_at_rest(name):
    """The square passes its corners; full speed is 8 m/s in all directions, at one height."""
    scenario = load_scenario(models_dir() / "scenarios" / f"{name}.yaml")
    session = Session(scenario)
    assert watched(session, scenario.duration) == []
    end, flown = session.snapshot(), session.recording()
    if name in ("figure-eight", "full-speed", "paper-steps", "square"):
        assert end.mode.label == "hovering"
        assert end.v_WB == pytest.approx([0.0, 0.0, 0.0], abs=0.02)
    if name == "square":
        assert end.p_WB == pytest.approx([0.0, 0.0, 1.5], abs=0.02)
        for corner in ([4.0, 0.0, 1.5], [4.0, 4.0, 1.5], [0.0, 4.0, 1.5]):
            assert np.linalg.norm(flown.p_WB - corner, axis=1).min() < 0.02
    if name == "full-speed":
        speed = np.hypot(flown.v_WB[:, 0], flown.v_WB[:, 1])
        for time in (8.0, 20.0, 33.0):
            (at,) = np.flatnonzero(flown.time == time)
            assert speed[at] == pytest.approx(8.0, rel=0.01)
        assert np.ptp(flown.p_WB[:, 2]) <= 0.3


@pytest.mark.slow
def test_moderate_turbulence_is_no_slow_swing():
    assert watched(Session(HIGH, {"turbulence": 15.4}), 60.0) == []


@pytest.mark.slow
def test_a_pilot_who_swings_the_stick_and_air_that_shakes_are_no_swing():
    bench = Bench(HIGH)
    told = kept_events(bench)
    bench.execute(Action(set={"turbulence": 15.4}))
    for index in range(10):
        bench.execute(Action(velocity=[1.5 * (-1) ** index, 0.0, 0.0]))
        bench.fly(0.4)
    bench.execute(AT_REST)
    bench.fly(5.0)
    assert told == []


@pytest.mark.slow
def test_nor_is_a_pilot_who_taps_unevenly():
    """What is asked for is uneven; the drone, which follows late, swings evenly."""
    bench = Bench(HIGH)
    told = kept_events(bench)
    taps = ((-1.0, 0.4), (0.0, 1.7), (2.0, 0.7), (-1.0, 0.5), (2.0, 0.5), (-1.0, 0.5), (0.0, 1.3))
    for climb, lasting in taps:
        bench.execute(Action(velocity=[0.0, 0.0, climb]))
        bench.fly(lasting)
    assert told == []


def test_alarms_are_told_once_with_what_to_do_and_stand_in_the_log(walled, case):
    hover = Scenario()
    for scenario, act, seconds, said, remedy in (
        (walled, Action(velocity=[2.0, 0.0, 0.0]), 3.0, "hit something hard", "obstacles"),
        (
            Scenario(start=ScenarioStart(position=[0.0, 0.0, 0.6])),
            Action(velocity=[0.0, 0.0, -1.5]),
            1.5,
            "hard touch-down, at ",
            "Sink more slowly",
        ),
        (hover, Action(request="stop"), 1.5, "fell with its rotors off, and hit", "STOP switches"),
        (
            hover,
            Action(set={"battery_duration": 1.0}),
            4.0,
            "fell with its rotors off (battery empty), and hit",
            "Reset to fly again; land before the battery is empty",
        ),
        (
            Scenario(estimator="ekf", sensors=SensorsConfig(use=["imu", "gps", "magnetometer"])),
            Action(set={"imu_fault": 3.0}),
            3.0,
            "fell with its rotors off (IMU failed), and hit",
            "Repair the IMU, then reset",
        ),
        (
            dataclasses.replace(hover, controller="pd"),
            Action(set={"rotor_1": 0.0}),
            2.0,
            "hit the ground at ",
            "fly higher",
        ),
        (
            HIGH,
            Action(set={"payload_mass": 2.3}),
            2.0,
            "largest thrust",
            "Ask for less",
        ),
        (hover, Action(set={"battery_reserve": 0.9}), 1.0, "battery low", "Land"),
        (
            Scenario(estimator="ekf", sensors=SensorsConfig(use=["imu", "gps", "magnetometer"])),
            Action(set={"gps_fault": 3.0}),
            4.0,
            "no GPS, dead reckoning",
            "repair the GPS",
        ),
    ):
        with case(said):
            bench = Bench(scenario)
            told = kept_events(bench)
            answer = bench.execute(act)
            assert isinstance(answer, WorkerResult), answer
            while not any(said in each for each in told) and bench.wall < seconds:
                bench.fly(0.1)
            bench.fly(0.3)  # it is not told again
            (found,) = [each for each in told if said in each]
            assert remedy in found.split(". ")[1]
            assert ("obstacles" in found) is (scenario is walled)


def test_lost_real_time_is_told_once():
    bench = Bench()
    told = []
    watch = Alarms(bench.session, told.append)
    slow = Pace(asked=1.0, achieved=0.6, lag=0.3, given_up=1.0, slow=True)
    for now in np.arange(0.0, 6.0, 0.1):
        watch.look_at_pace(slow, float(now))
    (said,) = told
    assert said.startswith("the flight is slower than real time: 0.60")
    assert said.split(". ")[1].startswith("Choose a lower speed")
    watch.begin()
    watch.look_at_pace(dataclasses.replace(slow, slow=False), 7.0)
    watch.look_at_pace(slow, 7.1)
    assert len(told) == 1


def test_a_doublet_of_roll_is_flown_at_exact_steps_and_repeats_to_the_bit():
    """Its setpoints replace those of the velocity loop; then the drone hovers where it began."""
    doublet = Excitation("roll", Shape.DOUBLET, 0.1, 0.5)
    bench = Bench()
    bench.fly_to(0.25)
    began = bench.excite(doublet).value
    bench.fly(3.0)
    given = [(each.at - began, each.setpoint.given) for each in bench.done if each.setpoint]
    assert given[:3] == [(0.0, {"roll": 0.1}), (0.25, {"roll": -0.1}), (0.5, {})]
    assert bench.shown.exciting is None
    flown = bench.flying._flown()
    roll = flown.recording.between(began, began + 0.25).q_WB[-1, 1] * 2.0
    assert roll == pytest.approx(0.1, abs=0.02)
    assert abs(flown.recording.p_WB[-1, 1]) < 0.1
    again = Session(flown.scenario)
    again.run()
    assert_equal_to_the_bit(flown.recording, again.recording())


@pytest.mark.slow
def test_a_setpoint_of_attitude_steps_from_that_of_a_hover_in_wind(monkeypatch):
    """By as much as without wind; a drone that is not at rest, as in gusts, gets it from level."""
    bench = Bench(HIGH)
    bench.execute(Action(set={"wind_x": WIND}))
    bench.fly(5.0)
    tilt = tilt_by_hand(bench.session.vehicle, bench.session.get("drag_area"))
    bench.flying._exciter.check(Excitation("pitch", Shape.STEP, 0.65, 0.5))  # level by 0.56
    for shape, size in ((Shape.STEP, -0.65), (Shape.DOUBLET, 0.65)):
        said = bench.excite(Excitation("pitch", shape, size, 0.5)).said
        assert "pitch of -0.65 rad from a hover of -0.1" in said
        assert "would tilt the drone by 0.7" in said and "max_tilt is 0.7 rad" in said
    bench.excite(Excitation("pitch", Shape.DOUBLET, 0.1, 1.5))
    began = bench.shown.exciting.began
    assert bench.shown.exciting.hover == pytest.approx(-tilt, rel=5e-3)
    bench.fly(1.6)
    up, down, end = (each.setpoint.given for each in bench.done if each.setpoint)
    assert up["pitch"] - down["pitch"] == pytest.approx(0.2)
    assert -0.15 < 0.5 * (up["pitch"] + down["pitch"]) < -0.09
    assert end == {}
    flown = bench.session.recording().between(began, began + 0.75)
    _, pitch = tilt_angles(flown.q_WB)
    assert pitch[0] == pytest.approx(-tilt, rel=5e-3)
    assert pitch[-1] - pitch[0] == pytest.approx(0.098, abs=2e-3)
    monkeypatch.setattr(exciter, "RETURN_TIMEOUT_S", 0.5)
    bench.execute(Action(set={"turbulence": 15.4}))
    bench.excite(Excitation("pitch", Shape.STEP, 0.1, 1.0))
    assert bench.shown.exciting.round == 0
    given = end
    while not given and bench.session.time < 20.0:
        bench.fly(0.25)
        given = [each.setpoint.given for each in bench.done if each.setpoint][-1]
    assert given == {"pitch": 0.1}


def test_a_hover_that_tilts_more_before_a_step_begins_ends_an_excitation_beyond_the_limit():
    """The wind rises while the drone is still level, and its step waits for it to be at rest."""
    bench = Bench(HIGH)
    bench.execute(Action(set={"wind_x": 12.0}))
    bench.fly(0.3)
    bench.excite(Excitation("pitch", Shape.STEP, -0.69, 0.6))
    assert bench.shown.exciting.round == 0
    while bench.shown.exciting and bench.session.time < 20.0:
        bench.fly(0.25)
    said = bench.shown.excitation_ended
    assert "a pitch of -0.69 rad from a hover of -0.2" in said and "max_tilt is 0.7 rad" in said
    assert [each.setpoint.given for each in bench.done if each.setpoint][-1] == {}
    _, pitch = tilt_angles(bench.session.recording().q_WB)
    assert pitch.min() > -0.4


def test_a_setpoint_of_roll_steps_from_that_of_a_hover_in_crosswind():
    """Which turns the drone steadily about the vertical."""
    bench = Bench(HIGH)
    bench.execute(Action(set={"wind_y": 6.0}))
    bench.fly(3.5)
    roll, _, _ = bench.session.snapshot().roll_pitch_yaw
    bench.excite(Excitation("roll", Shape.STEP, 0.1, 1.0))
    assert bench.shown.exciting.round == 1
    assert bench.shown.exciting.hover == pytest.approx(roll)
    assert roll > 0.05
    assert bench.done[-1].setpoint.roll == pytest.approx(roll + 0.1, rel=0.1)


def test_a_vehicle_that_hovers_tilted_without_wind_has_setpoints_from_there_by_itself():
    bench = Bench(Scenario(vehicle=VehicleConfig(model="tricopter")))
    bench.fly(0.25)
    roll, _, _ = bench.session.snapshot().roll_pitch_yaw
    assert abs(roll) > 0.02
    bench.excite(Excitation("roll", Shape.STEP, 0.1, 1.0))
    assert bench.shown.exciting.hover == pytest.approx(roll, abs=1e-6)
    bench.fly(0.1)
    assert [each.setpoint.given for each in bench.done if each.setpoint] == [{"roll": 0.1}]


def test_a_setpoint_that_the_law_or_the_room_forbids_is_refused():
    bench = Bench()
    bench.fly_to(0.25)
    for excitation, said in (
        (Excitation("roll_rate", Shape.STEP, 0.2, 0.5), "pd has no loop that follows"),
        (Excitation("roll", Shape.STEP, 0.8, 0.5), "within ±0.7 rad"),
    ):
        assert said in bench.excite(excitation).said


def test_who_takes_over_gets_a_level_setpoint():
    bench = Bench()
    bench.fly_to(0.25)
    bench.excite(Excitation("pitch", Shape.STEP, 0.1, 2.0))
    bench.fly(0.3)
    bench.execute(Action(velocity=[0.5, 0.0, 0.0]))
    bench.fly(0.3)
    assert [each.setpoint.given for each in bench.done if each.setpoint] == [{"pitch": 0.1}, {}]
    assert not bench.session._live.attitude_is_set


@pytest.mark.parametrize(
    ("air", "why"), [({"turbulence": 5.0}, NEVER_STEADY), ({"wind_x": 0.0}, "")]
)
def test_a_round_does_not_step_from_the_drift_of_air_that_has_changed(air, why):
    session = Session(Scenario(controller="pd"), {"wind_x": 4.0})
    drive = StepDrive(session, Excitation("x", Shape.STEP, 1.0, 1.0))
    session.do(drive.begin_drift())
    while not drive.drifts_steadily():
        assert session.time < 30.0
        session.tick(0.1)
    drive.begin_round()
    assert drive.hover.angle > 0.0
    session.do(Action(set=air))
    drive.begin_round()
    assert drive.hover.angle == 0.0
    assert drive.why_unsteady() == why
