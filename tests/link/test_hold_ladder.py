"""The ladder, changes of hands and the operator, through the real server and the real flight.

Flight and server stand in this process, with clocks that are made up, so that times are exact.
"""

import importlib.util
from pathlib import Path

import pytest

from workbench.common.errors import FlightBrokenError
from workbench.control.mode import FlightMode
from workbench.link.messages import ControlOwner, LinkLossStage
from workbench.live.messages import Phase
from workbench.live.orders import FlightOrder, NetworkOrder, SetSpeed
from workbench.scenario.scenario import Action, Rates, Scenario, ScenarioStart
from workbench.session.session import Session

CONTROL = Rates().control_period
STILL = [0.0, 0.0, 0.0]


def _load():
    spec = importlib.util.spec_from_file_location("served", Path(__file__).with_name("served.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.load()


rig = _load()


@pytest.fixture(scope="module")
def built():
    return rig.build(Scenario(start=ScenarioStart(position=[0.0, 0.0, 2.0])))


@pytest.fixture
def served(monkeypatch, built):
    served = rig.Served(monkeypatch, built)
    yield served
    served.flying._network.close()


@pytest.fixture
def holder(served):
    """A client that flies at 1 m/s, and has just said so."""
    holder = rig.Client(served, "Ada")
    holder.begin()
    served.fly(0.25)
    holder.command(1.0, 0.0, 0.0)
    served.fly(CONTROL)
    assert served.velocities[-1][1] == [1.0, 0.0, 0.0]
    return holder


def last_move(served) -> float:
    return max(at for at, velocity in served.velocities if velocity != STILL)


def hold_after(served) -> float:
    """Return how long after the last move the next HOLD came [s]."""
    after = [at for at, velocity in served.velocities if velocity == STILL]
    return min(at for at in after if at > last_move(served)) - last_move(served)


def test_the_ladder_of_a_client_that_falls_silent(served, holder):
    """HOLD at 0.5 s, lost at 2 s, LAND at 5 s; each within one control step."""
    began = last_move(served)
    seen = {}
    while served.time < began + 5.125:
        served.fly(CONTROL)
        seen.setdefault(served.stage, served.time - began)
    assert list(seen) == [
        (ControlOwner.CLIENT, LinkLossStage.LIVE),
        (ControlOwner.CLIENT, LinkLossStage.HOLD),
        (ControlOwner.NOBODY, LinkLossStage.LOST),
        (ControlOwner.NOBODY, LinkLossStage.LAND),
    ]
    for stage, after in zip(list(seen)[1:], (0.5, 2.0, 5.0), strict=True):
        assert after <= seen[stage] <= after + 2.0 * CONTROL  # seen after the slice
    assert hold_after(served) == 0.5
    (land,) = [each for each in served.script if each.request == "land"]
    assert (land.request, land.at - began) == ("land", 5.0)
    served.fly(0.25)
    assert served.session.snapshot().mode is FlightMode.LANDING


@pytest.mark.parametrize("how", ["gone", "killed", "stopped", "release", "bye"])
def test_hold_comes_at_once_where_the_connection_or_the_lease_ends(served, holder, how):
    if how == "gone":
        holder.go()
    elif how == "killed":
        served.lost = True
    elif how == "stopped":
        served.order(NetworkOrder.STOP_SERVING)
    elif how == "bye":
        holder.say(op="bye")
    else:
        assert holder.ask(op="release_control", lease=holder.lease)["op"] == "release_control"
    served.fly(5.125 if how in ("gone", "release") else 0.25)
    assert 0.0 < hold_after(served) <= CONTROL
    landed = [each.at - last_move(served) for each in served.script if each.request == "land"]
    assert landed == ([5.0] if how == "gone" else [])


@pytest.mark.slow
def test_who_takes_what_was_lost_is_not_landed(served, holder):
    served.fly(2.5)
    other = rig.Client(served, "Bob")
    other.begin()
    for _ in range(50):
        other.command(0.0, 1.0, 0.0)
        served.fly(0.125)
    assert not [each for each in served.script if each.request == "land"]
    assert served.stage == (ControlOwner.CLIENT, LinkLossStage.LIVE)


def test_equal_never_pre_empts_equal(served, holder):
    other = rig.Client(served, "Bob")
    for _ in range(15):
        assert other.request() == 0
        assert other.said[-1]["code"] == "held"
        served.fly(0.125)
    served.fly(0.25)
    assert other.request()


def test_a_change_of_hands_passes_through_hold_and_neutral(served, holder):
    holder.ask(op="release_control", lease=holder.lease)
    other = rig.Client(served, "Bob")
    assert other.request()
    first = other.command(0.0, 1.0, 0.0)
    served.fly(CONTROL)
    assert other.nacks(first) == ["neutral_first"]
    assert served.velocities[-1][1] == STILL
    other.command(0.0, 0.0, 0.0)
    other.command(0.0, 1.0, 0.0)
    served.fly(CONTROL)
    assert served.velocities[-1][1] == [0.0, 1.0, 0.0]


def test_nothing_resumes_by_itself(served, holder):
    """A holder that was silent goes on commanding: it has no lease any more."""
    served.fly(0.6)
    for _ in range(30):
        holder.command(1.0, 0.0, 0.0)
        served.fly(0.0625)
    assert set(holder.nacks()) == {"not_holder"}
    assert hold_after(served) == 0.5
    assert served.stage == (ControlOwner.NOBODY, LinkLossStage.LOST)


def test_what_is_refused_renews_nothing(served, holder):
    while served.time < last_move(served) + 0.75:
        holder.command(float("nan"), 0.0, 0.0)
        holder.command(99.0, 0.0, 0.0)
        holder.command(1.0, 0.0, 0.0, t_ns=0 if served.time > 1.1 else 2**62)
        holder.command(1.0, 0.0, 0.0, axes=0)
        holder.ask(op="parameters", set={"kp_velocity_x": 1e9}, lease=holder.lease)
        holder.ask(op="parameters", get=[])
        holder.ask(op="ping")
        served.fly(CONTROL)
    assert hold_after(served) == 0.5


@pytest.mark.slow
@pytest.mark.parametrize("act", ["turn", "command", "take over"])
def test_the_operator_wins_and_the_drone_holds_first(served, holder, act):
    if act == "take over":
        served.order(NetworkOrder.TAKE_OVER)
        expected = [STILL]
    elif act == "turn":
        served.order(Action(yaw_rate=0.2))
        expected = [STILL]
    else:
        served.order(Action(velocity=[0.0, 0.5, 0.0]))
        expected = [STILL, [0.0, 0.5, 0.0]]
    assert served.stage == (ControlOwner.OPERATOR, LinkLossStage.LIVE)
    refused = holder.command(1.0, 0.0, 0.0)
    served.fly(CONTROL)
    assert holder.nacks(refused) == ["not_holder"]
    assert [
        velocity for at, velocity in served.velocities if at > last_move_of(holder, served)
    ] == (expected)
    assert holder.request() == 0
    served.fly(10.0)  # no ladder stands above the operator
    assert not [each for each in served.script if each.request == "land"]
    served.order(NetworkOrder.GIVE_BACK)
    assert served.velocities[-1][1] == STILL
    assert holder.request()


def last_move_of(holder, served) -> float:
    return max(at for at, velocity in served.velocities if velocity == [1.0, 0.0, 0.0])


def test_the_operator_takes_over_from_nobody_before_hold_has_come(served, holder):
    """In a pause HOLD waits for the next update, and the operator's order does not."""
    served.order(FlightOrder.PAUSE)
    holder.go()
    served.hear()
    served.order(Action(yaw_rate=0.2))
    served.order(FlightOrder.RESUME)
    served.fly(0.25)
    assert served.velocities[-1][1] == STILL
    assert served.session.snapshot().reference[:4] == (0.0, 0.0, 0.0, 0.2)


def test_an_order_that_flies_nothing_takes_no_control(served, holder):
    served.order(Action(set={"kp_roll": 60.0}))
    assert served.stage == (ControlOwner.CLIENT, LinkLossStage.LIVE)


def test_a_paused_flight_answers_and_takes_nothing(served, holder):
    served.order(FlightOrder.PAUSE)
    at = served.time
    served.fly(30.0)
    assert served.time == at
    assert served.stage == (ControlOwner.CLIENT, LinkLossStage.LIVE)
    assert rig.Client(served, "Bob").request() == 0
    assert holder.ask(op="parameters", get=["kp_roll"])["op"] == "parameters"
    assert holder.ask(op="release_control", lease=holder.lease)["op"] == "release_control"
    other = rig.Client(served, "Bob")
    other.begin()
    assert served.stage == (ControlOwner.CLIENT, LinkLossStage.LIVE)
    for number in range(1000):  # as joysticks do; the neutral one is not displaced
        other.command(0.0, 0.001 * number, 0.0)
        served.wall += 0.01
        served.hear()
    served.order(FlightOrder.RESUME)
    served.fly(CONTROL)
    assert other.nacks() == []
    assert not other.session.gone
    assert served.velocities[-1][1] == pytest.approx([0.0, 0.999, 0.0])


def test_a_flood_of_others_displaces_no_command(served, holder):
    others = [rig.Client(served, f"other {number}") for number in range(4)]
    served.order(FlightOrder.PAUSE)
    for number in range(200):
        for other in others:
            other.command(3.0, 3.0, 3.0, lease=holder.lease)
        if number == 100:
            holder.command(1.5, 0.0, 0.0)
        served.hear()
    served.order(FlightOrder.RESUME)
    served.fly(CONTROL)
    assert served.velocities[-1][1] == [1.5, 0.0, 0.0]


def test_a_reset_while_somebody_flies_leaves_nobody_in_control(served, holder):
    holder.command(2.0, 0.0, 0.0)
    served.order(FlightOrder.RESET)
    assert served.time == 0.0
    assert served.stage == (ControlOwner.NOBODY, LinkLossStage.LIVE)
    refused = holder.command(1.0, 0.0, 0.0)
    served.fly(6.0)
    assert holder.nacks(refused) == ["not_holder"]
    assert served.velocities == []
    holder.begin()
    holder.command(1.0, 0.0, 0.0)
    served.fly(CONTROL)
    assert served.velocities[-1][1] == [1.0, 0.0, 0.0]


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.2, 5.0])
def test_the_ladder_counts_simulated_time(served, holder, speed):
    served.order(SetSpeed(speed))
    holder.command(1.5, 0.0, 0.0)
    served.fly(7.0 / speed)
    assert hold_after(served) == 0.5
    (land,) = [each for each in served.script if each.request == "land"]
    assert land.at - last_move(served) == 5.0


def mode(served) -> FlightMode:
    return served.session.snapshot().mode


def landing(served, client) -> None:
    """Let a client, or nobody, land, and fly until it comes down."""
    if client is not None:
        asked = client.ask(op="flight", what="land", lease=client.lease)
        assert asked["op"] == "flight"
    for _ in range(20):
        served.fly(0.125)
        if client is not None:
            client.command(1.0, 0.0, 0.0)  # the stick that was pushed before stays so
    assert mode(served) is FlightMode.LANDING


@pytest.mark.slow
@pytest.mark.parametrize(
    "how", ["stick", "take_off", "hold", "operator's stick", "operator's hold"]
)
def test_a_landing_is_ended_in_the_air_by_who_flies(served, holder, how):
    """And what is recorded of that flies the same, to the bit."""
    landing(served, holder)
    low = served.session.snapshot().p_WB[2]
    if how == "stick":
        holder.command(0.0, 0.0, 0.0)
        served.fly(CONTROL)
        assert mode(served) is FlightMode.LANDING, "neutral asks for nothing"
        holder.command(0.0, 0.5, 0.0)
    elif how == "operator's stick":
        served.order(Action(velocity=[0.0, 0.5, 0.0]))
    elif how == "operator's hold":
        served.order(Action(request="hold"))
    else:
        said = holder.ask(op="flight", what=how, height=3.0, lease=holder.lease)
        assert (said["op"], said["what"]) == ("flight", how)
    for _ in range(8):
        served.fly(0.25)
        if how == "stick":
            holder.command(0.0, 0.5, 0.0)
        elif "operator" not in how:
            holder.command(0.0, 0.0, 0.0)
    z = served.session.snapshot().p_WB[2]
    assert z > low + 1.0 if how == "take_off" else abs(z - low) < 0.3
    assert mode(served) is (
        FlightMode.TAKING_OFF if how == "take_off"
        else FlightMode.CRUISING if "stick" in how
        else FlightMode.HOVERING
    )  # fmt: skip
    flown = served.flown()
    again = Session(flown.scenario)
    again.run()
    assert again.recording().p_WB.tobytes() == flown.recording.p_WB.tobytes()


def test_an_automatic_hold_ends_no_landing_and_who_takes_control_may(served, holder):
    """The ladder's landing goes on, also when somebody takes control, until that one flies."""
    landing(served, holder)
    holder.go()  # HOLD comes at once
    served.fly(1.0)
    assert mode(served) is FlightMode.LANDING
    other = rig.Client(served, "Bob")
    other.begin()
    served.fly(0.25)
    assert mode(served) is FlightMode.LANDING
    other.command(0.0, 0.0, 0.3)
    served.fly(0.25)
    assert mode(served) is not FlightMode.LANDING


def test_on_the_ground_a_take_off_is_not_answered_as_done_where_a_stop_comes_first(monkeypatch):
    ground = rig.build(Scenario(start=ScenarioStart(mode="off")))
    served = rig.Served(monkeypatch, ground)
    client = rig.Client(served, "Ada")
    client.begin()
    for first in ("land", "stop"):
        assert client.ask(op="flight", what=first, lease=client.lease)["op"] == "flight"
        refused = client.ask(op="flight", what="take_off", lease=client.lease)
        assert (refused["op"], refused["code"]) == ("nack", "not_now")
        assert first in refused["said"]
        served.fly(0.25)
        done = client.ask(op="flight", what="take_off", lease=client.lease)
        assert done["op"] == "flight"
        served.fly(0.25)
        assert mode(served) is FlightMode.ARMED
    served.flying._network.close()


def test_holds_are_by_who_causes_them(served, holder):
    """In the log: a grant and a release by the client, a silence by the link."""

    def by():
        return [who for action, who in served.flying._network._log.done if action.request == "hold"]

    assert by() == ["Ada"]
    holder.ask(op="release_control", lease=holder.lease)
    other = rig.Client(served, "Bob")
    other.begin()
    served.fly(1.0)
    assert by() == ["Ada", "Ada", "Bob", "link"]


def test_the_answer_to_set_says_when(served, holder):
    said = holder.ask(op="parameters", set={"kp_roll": 60.0}, lease=holder.lease)
    assert said["applied_ns"] == round(served.time * 1e9)
    assert "applied_ns" not in holder.ask(op="parameters", get=["kp_roll"])


def test_what_a_script_sets_is_told_as_what_a_client_sets(monkeypatch):
    script = [Action(0.25, set={"kp_roll": 60.0}), Action(0.5, set={"kp_pitch": 61.0})]
    served = rig.Served(monkeypatch, rig.build(Scenario(script=script)))
    for flight in range(2):
        client = rig.Client(served)
        client.say(op="subscribe", topics=["/dh_drone/parameters"])
        served.fly(1.0)
        told = [(name.rstrip(b"\0").decode(), value) for name, value in client.parameters]
        assert told == [("kp_roll", 60.0), ("kp_pitch", 61.0)], flight
        client.go()
        served.order(FlightOrder.RESET)
    served.flying._network.close()


def test_a_broken_flight_grants_and_goes_on_after_a_reset(served, holder, monkeypatch):
    def breaks(duration):
        raise FlightBrokenError("the flight broke off")

    monkeypatch.setattr(served.session, "tick", breaks)
    served.fly(0.125)
    assert served.reports[-1].phase is Phase.BROKEN
    assert rig.Client(served).request() == 0
    monkeypatch.undo()  # the server that runs goes on
    served.order(FlightOrder.RESET)
    assert rig.Client(served).request()
