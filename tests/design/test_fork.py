"""Forks of a flight against the flight itself, and against sessions flown by hand."""

import dataclasses
import math
import pickle
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.branches import Branch
from workbench.design.fork import MAX_BRANCH_DURATION_S, Forker, _restore_branch, fly_fork
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, SensorsConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

SCENARIO = Scenario(
    sensors=SensorsConfig(use=["imu"], seed=4),
    script=[
        Action(at=0.1, set={"turbulence": 3.0}),
        Action(at=0.2, velocity=[0.8, 0.0, 0.0]),
        Action(at=1.7, yaw_rate=0.2),
    ],
)


@dataclasses.dataclass(frozen=True)
class Step:
    axis: str
    amplitude: float


@pytest.fixture(scope="module")
def forker():
    return Forker(SCENARIO)


@pytest.fixture
def flight():
    """At 1.2375 s, off the control grid, in turbulence, and with a gain that was changed."""
    return begun()


@pytest.fixture(scope="module")
def checkpoint():
    """That of such a flight, for what does not fly it on."""
    return begun().checkpoint()


def begun():
    session = Session(SCENARIO, bridge=Bridge())
    session.tick(0.9)
    session.set("kp_roll", 60.0)
    session.tick(0.3375)
    return session


def assert_is(flown, recording) -> None:
    """The branch has the recording's numbers.

    Steps of the integrator end where the flight's bridge samples, and a branch has no bridge.
    """
    later = recording.between(flown.time[0], flown.time[-1])
    w, x, y, z = later.q_WB.T
    pairs = (
        (flown.time, later.time),
        (flown.velocity, later.v_WB),
        (flown.yaw_rate, later.w_WB[:, 2]),
        (flown.position, later.p_WB),
        (flown.rotor_use, later.rotor_use),
    )
    for a, b in pairs:
        assert a == pytest.approx(b, abs=1e-5)
    tilt = np.arccos(np.minimum(1.0, 1.0 - 2.0 * (x * x + y * y)))
    assert flown.tilt == pytest.approx(tilt, abs=1e-5)


@pytest.mark.slow
def test_a_branch_with_the_flights_own_gains_is_what_the_flight_then_does(forker, flight):
    checkpoint = pickle.loads(pickle.dumps(flight.checkpoint()))
    own = {name: flight.get(name) for name in ("kp_roll", "kp_velocity_x", "max_tilt")}
    none, same = forker.fly(checkpoint, [Branch("flown", {}), Branch("same", own)], 2.0)
    flight.tick(2.0)
    for branch in (none, same):
        assert len(branch.time) == 257
        assert branch.lost == ""
        assert_is(branch, flight.recording())
    assert (none.name, same.name) == ("flown", "same")
    assert np.ptp(none.yaw_rate) > 0.1  # of the script, at 1.7 s


def test_a_branch_flies_with_its_gains_from_the_instant_on(forker, flight):
    checkpoint = flight.checkpoint()
    (branch,) = forker.fly(
        checkpoint, [Branch("soft", {"kp_roll": 20.0, "kp_velocity_x": 1.0})], 1.0
    )
    (other,) = forker.fly(checkpoint, [Branch("as it is", {})], 1.0)
    flight.set("kp_roll", 20.0)
    flight.set("kp_velocity_x", 1.0)
    flight.tick(1.0)
    assert_is(branch, flight.recording())
    assert abs(branch.velocity - other.velocity).max() > 0.005


def test_controllers_fly_on_from_one_instant_as_sessions_of_theirs_do(flight, tmp_path):
    """Each as one that begins from the checkpoint; the one that flew, as the flight itself."""
    mine = tmp_path / "mine.py"
    mine.write_text(load_controller("pid").text)
    checkpoint = flight.checkpoint()
    branches = [
        Branch("as flown", {}),
        Branch("lqi", {}, "lqi"),
        Branch("named", {}, "pd"),
        Branch("mine", {"kp_velocity_xy": 2.0}, str(mine)),
    ]
    as_flown, lqi, named, own = Forker(SCENARIO).fly(checkpoint, branches, 1.0)
    for branch, flown in zip(branches[1::2], (lqi, own), strict=True):
        other = Session(dataclasses.replace(SCENARIO, controller=branch.controller))
        other.begin_from(checkpoint)
        for name, value in branch.gains.items():
            other.set(name, value)
        other.tick(1.0)
        assert_is(flown, other.recording())
    flight.tick(1.0)
    assert_is(as_flown, flight.recording())
    assert_is(named, flight.recording())
    for other in (lqi, own):
        assert abs(other.velocity - as_flown.velocity).max() > 0.001


def test_the_controller_that_the_script_let_take_over_flies_on(tmp_path):
    mine = tmp_path / "mine.py"
    mine.write_text(load_controller("pid").text)
    later = Action(at=0.8, controller="lqi")
    script = [*SCENARIO.script, Action(at=0.5, controller=str(mine)), later]
    scenario = dataclasses.replace(SCENARIO, script=script)
    flight = Session(scenario)
    flight.tick(0.6)
    checkpoint, forker = flight.checkpoint(), Forker(scenario)
    branches = [Branch("as flown", {}), Branch("again", {}), Branch("pd", {}, "pd")]
    as_flown, again, pd = forker.fly(checkpoint, branches, 0.4)
    mine.write_text("no law any more")
    (late,) = forker.fly(checkpoint, [Branch("as flown", {})], 0.4)
    flight.tick(0.4)
    for branch in (as_flown, again, late):
        assert_is(branch, flight.recording())
    assert abs(pd.velocity - as_flown.velocity).max() > 1e-4


def test_orders_for_the_law_that_flew_before_are_over():
    script = [
        Action(at=0.1, set={"kp_pitch": 300.0}),
        Action(at=0.2, controller="lqi"),
        Action(at=0.9, velocity=[0.5, 0.0, 0.0]),
    ]
    flight = Session(Scenario(script=script))
    flight.tick(0.6)
    late, forker = flight.checkpoint(), Forker(flight.flown_scenario)
    flight.tick(0.6)
    (branch,) = forker.fly(late, [Branch("as flown", {})], 0.6)
    assert_is(branch, flight.recording())
    assert branch.velocity[-1, 0] > 0.01


def test_a_forker_continues_a_checkpoint_of_before_too():
    scenario = Scenario(script=[Action(at=0.3, velocity=[1.0, 0.0, 0.0])])
    flight, forker = Session(scenario), Forker(scenario)
    flight.tick(0.125)
    before = flight.checkpoint()
    flight.tick(0.375)
    forker.fly(flight.checkpoint(), [Branch("late", {})], 0.25)
    (early,) = forker.fly(before, [Branch("early", {})], 0.375)
    assert_is(early, flight.recording())


def test_a_controller_that_cannot_fly_is_told_before_anything_is_flown(
    forker, checkpoint, tmp_path
):
    mine = tmp_path / "mine.py"
    mine.write_text(load_controller("pd").text.replace("def update(", "def renamed("))

    def flown() -> bool:
        pytest.fail("the first branch is flown")

    for name, gains, said in (
        (str(mine), {}, r"mine\.py.* update"),
        ("lqr", {}, "unknown controller 'lqr'"),
        ("lqi", {"kp_roll": 40.0}, "kp_roll"),
    ):
        branches = [Branch("as flown", {}), Branch("other", gains, name)]
        with pytest.raises(WorkbenchError, match=said):
            forker.fly(checkpoint, branches, 1.0, stop=flown)


def test_a_controller_that_fails_in_flight_ends_its_branch_with_file_and_line(tmp_path):
    """As a system of Drake's, of which no machine code is made."""
    mine = tmp_path / "mine.py"
    mine.write_text(
        "from pydrake.systems.framework import LeafSystem\n\n\n"
        "class Brittle(LeafSystem):\n"
        "    def __init__(self, vehicle, g, dt):\n"
        "        super().__init__()\n"
        "        self.weight = 9.81 * vehicle.mass\n"
        "        self.DeclareVectorInputPort('velocity', 3)\n"
        "        self.DeclareVectorOutputPort('wrench', 4, self.calc)\n\n"
        "    def calc(self, context, output):\n"
        "        if self.GetInputPort('velocity').Eval(context)[2] > 0.3:\n"
        "            raise ValueError('too fast')\n"
        "        output.SetFromVector([1.2 * self.weight, 0.0, 0.0, 0.0])\n\n\n"
        "def system(vehicle, g, dt):\n"
        "    return Brittle(vehicle, g, dt)\n"
    )
    flight = Session(Scenario())
    flight.tick(0.25)
    branches = [Branch("mine", {}, str(mine)), Branch("as flown", {})]
    own, as_flown = fly_fork(flight.scenario, flight.checkpoint(), branches, 1.0)
    assert own.lost.startswith(f"{mine}:13: update fails: ValueError: too fast")
    assert 0.25 < own.velocity[-1, 2] < 0.35
    assert as_flown.lost == "" and as_flown.time[-1] == 1.25


def test_a_script_that_sets_what_a_controller_has_not_ends_that_branch():
    script = [Action(at=0.5, set={"kp_roll": 60.0})]
    scenario = dataclasses.replace(SCENARIO, script=script)
    flight = Session(scenario)
    flight.tick(0.25)
    branches = [Branch("lqi", {}, "lqi"), Branch("as flown", {})]
    lqi, as_flown = Forker(scenario).fly(flight.checkpoint(), branches, 0.75)
    assert "kp_roll" in lqi.lost
    flight.tick(0.75)
    assert as_flown.lost == ""
    assert_is(as_flown, flight.recording())


def test_a_step_is_added_to_the_command_of_the_flight(case):
    """Also to a yaw rate, and other axes stay as they are asked for."""
    asked = {"x": 0.8, "y": -0.2, "z": 0.1, "yaw": 0.3}
    instant = SimpleNamespace(velocity=[0.8, -0.2, 0.1], yaw_rate=0.3)
    told = []
    session = SimpleNamespace(
        begin_from=told.append, command=lambda velocity, rate: told.append((*velocity, rate))
    )
    for axis in asked:
        told.clear()
        _restore_branch(session, instant, {}, Step(axis, 0.25))
        with case(axis):
            wanted = tuple((asked | {axis: asked[axis] + 0.25}).values())
            assert told == [instant, pytest.approx(wanted)]


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["x", "y", "z", "yaw"])
def test_a_step_goes_on_top_of_what_is_asked_for(forker, flight, axis):
    (branch,) = forker.fly(flight.checkpoint(), [Branch("", {})], 0.7, Step(axis, 0.25))
    asked = {"x": 0.8, "y": 0.0, "z": 0.0, "yaw": 0.0}
    asked[axis] += 0.25
    flight.command([asked["x"], asked["y"], asked["z"]], asked["yaw"])
    flight.tick(0.7)
    assert_is(branch, flight.recording())


def test_a_fork_leaves_nothing_behind_for_the_next_one(forker, checkpoint):
    first = forker.fly(checkpoint, [Branch("a", {})], 0.5)
    forker.fly(checkpoint, [Branch("b", {"kp_roll": 1.0, "rotor_1": 0.6})], 2.0, Step("z", 3.0))
    again = forker.fly(checkpoint, [Branch("a", {})], 0.5)
    for field in dataclasses.fields(first[0]):
        one, other = getattr(first[0], field.name), getattr(again[0], field.name)
        assert np.array_equal(one, other), field.name


def test_what_diverges_is_lost_and_cut_there_and_the_others_fly_on(forker, checkpoint):
    """Without a rotor and without damping nothing stays upright for long."""
    wild = {"kd_roll": 0.0, "kd_pitch": 0.0, "rotor_1": 0.0}
    branches = [Branch("wild", wild), Branch("as it is", {})]
    lost, flown = forker.fly(checkpoint, branches, 3.0)
    assert lost.lost.startswith("the flight is lost at t = ")
    assert 0 < len(lost.time) < 384
    assert np.isfinite(lost.velocity).all()
    assert lost.time[-1] < float(lost.lost.split("t = ")[1].split(" s")[0]) + 1e-3
    assert flown.lost == ""
    assert len(flown.time) == 385


def test_a_flight_that_breaks_off_says_so(forker, checkpoint, monkeypatch):
    from workbench.common.errors import FlightBrokenError

    def tick(session: Session, duration: float) -> None:
        whole(session, duration)
        if session.time > 2.0:
            raise FlightBrokenError("the flight broke off after 2 s: so it was told")

    whole = Session.tick
    monkeypatch.setattr(Session, "tick", tick)
    broken, again = forker.fly(checkpoint, [Branch("a", {}), Branch("b", {})], 3.0)
    assert broken.lost == "the flight broke off after 2 s: so it was told"
    assert again.lost == broken.lost
    assert 2.0 < broken.time[-1] < 2.3


@pytest.mark.parametrize(
    "gains", [{"kp_roll": math.nan}, {"kp_roll": -1.0}, {"kp_rol": 1.0}, {"max_tilt": math.inf}]
)
def test_what_no_flight_may_have_is_refused_before_anything_is_flown(forker, checkpoint, gains):
    def flown() -> bool:
        pytest.fail("the first branch is flown")

    with pytest.raises(WorkbenchError, match="kp_rol|max_tilt"):
        forker.fly(checkpoint, [Branch("a", {}), Branch("b", gains)], 1.0, stop=flown)


@pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf, MAX_BRANCH_DURATION_S + 1.0])
def test_a_time_that_cannot_be_flown_is_refused(forker, checkpoint, duration):
    with pytest.raises(WorkbenchError, match="cannot fork a flight for"):
        forker.fly(checkpoint, [Branch("a", {})], duration)


def test_a_step_on_no_axis_or_of_no_size_is_refused(forker, checkpoint):
    with pytest.raises(WorkbenchError, match="unknown axis 'roll'"):
        forker.fly(checkpoint, [Branch("a", {})], 1.0, Step("roll", 1.0))
    with pytest.raises(WorkbenchError, match="finite"):
        forker.fly(checkpoint, [Branch("a", {})], 1.0, Step("x", math.nan))


def test_it_stops_when_told_and_returns_what_is_complete(forker, checkpoint):
    asked = []

    def stop() -> bool:
        asked.append(True)
        return len(asked) > 6

    branches = [Branch(name, {}) for name in "abc"]
    flown = forker.fly(checkpoint, branches, 1.0, stop=stop)
    assert [each.name for each in flown] == ["a"]
    assert len(asked) == 7


def test_walls_are_there_in_a_fork_and_sensors_are_not():
    scenario = dataclasses.replace(
        SCENARIO,
        world="room",
        sensors=SensorsConfig(use=["lidar"]),
        start=ScenarioStart(position=[0.0, 0.0, 1.5]),
        script=[Action(velocity=[3.0, 0.0, 0.0], set={"obstacle_brake": 1.0})],
    )
    flight = Session(scenario)
    flight.tick(0.8)
    (branch,) = fly_fork(scenario, flight.checkpoint(), [Branch("as it is", {})], 2.5)
    flight.tick(2.5)
    assert_is(branch, flight.recording())
    assert branch.velocity[-1, 0] < 1.0  # it brakes
