"""What clients ask for, answered as docs/protocol.md says, in a session that stands still."""

import pytest

from workbench.control.mode import FlightMode
from workbench.link.backplane import (
    Command,
    FlightOperation,
    GetParameters,
    Gone,
    Hand,
    ReleaseControl,
    RequestControl,
    SetParameters,
)
from workbench.live.desk import Desk
from workbench.scenario.scenario import Action, FigureEight, Scenario, Start
from workbench.session.session import Session
from workbench.systems.bridge import Bridge


class Office:
    """A desk, its session, and what it took note of."""

    def __init__(self, scenario: Scenario | None = None) -> None:
        self.bridge = Bridge()
        scenario = scenario or Scenario(start=Start(mode="off"))
        self.session = Session(scenario, bridge=self.bridge)
        self.did = []
        self.desk = Desk(
            self.session, self.bridge, lambda action, by: self.did.append((action, by))
        )

    def asks(self, record) -> dict:
        reply = self.desk.answer(record)
        assert (reply.peer, reply.id) == (record.peer, record.id)
        return dict(reply.operation)

    def lease(self, peer: int = 1) -> int:
        lease = self.asks(RequestControl(peer, 5, f"client {peer}"))["lease"]
        assert [(action.request, by) for action, by in self.did] == [("hold", "client 1")]
        self.did.clear()
        return lease


@pytest.fixture
def office() -> Office:
    return Office()


def test_control_is_granted_once_and_released(office):
    granted = office.asks(RequestControl(1, 5, "one"))
    assert (granted["op"], granted["expires"]) == ("request_control", 0.5)
    refused = office.asks(RequestControl(2, 6, "two"))
    assert (refused["op"], refused["code"]) == ("nack", "held")
    assert "one" in refused["said"]
    wrong = office.asks(ReleaseControl(2, 7, granted["lease"]))
    assert wrong["code"] == "not_holder"
    assert office.asks(ReleaseControl(1, 8, granted["lease"])) == {"op": "release_control"}
    assert office.asks(RequestControl(2, 9, "two"))["op"] == "request_control"


def test_a_flight_operation_is_done_and_on_record(office):
    lease = office.lease()
    done = office.asks(FlightOperation(1, 6, lease, "take_off", 1.25))
    assert done == {"op": "flight", "what": "take_off", "applied_ns": 0}
    ((action, by),) = office.did
    assert (action.request, action.height, by) == ("take_off", 1.25, "client 1")
    office.session.tick(0.25)
    assert office.session.snapshot().mode is FlightMode.ARMED


def test_a_request_that_would_have_no_effect_is_not_answered_as_done(office):
    """In the air nothing takes off or arms; on the way down a take-off climbs again."""
    lease = office.lease()
    office.asks(FlightOperation(1, 6, lease, "take_off", 1.0))
    for _ in range(20):  # the lease lasts half a second
        office.session.tick(0.25)
        office.asks(SetParameters(1, 6, lease, {"kp_roll": 90.0}))
    assert office.session.snapshot().mode is FlightMode.HOVERING
    for what in ("take_off", "arm"):
        refused = office.asks(FlightOperation(1, 7, lease, what, 1.0))
        assert (refused["code"], "hovering" in refused["said"]) == ("not_now", True)
    assert office.asks(FlightOperation(1, 8, lease, "land", 1.0))["op"] == "flight"
    office.session.tick(0.25)
    assert office.asks(FlightOperation(1, 9, lease, "take_off", 1.0))["op"] == "flight"
    assert office.did[-1][0].request == "abort_landing"
    assert office.asks(FlightOperation(1, 9, lease, "stop", 1.0))["op"] == "flight"


@pytest.mark.parametrize(
    ("record", "code"),
    [
        (lambda lease: FlightOperation(1, 6, lease, "take_off", 1e9), "not_now"),
        (lambda lease: FlightOperation(1, 6, lease, "somersault", 1.0), "not_now"),
        (lambda lease: FlightOperation(1, 6, lease + 1, "stop", 1.0), "not_holder"),
        (lambda lease: FlightOperation(2, 6, lease, "stop", 1.0), "not_holder"),
        (lambda lease: SetParameters(1, 6, lease, {"kp_roll": 1e9}), "bad_value"),
        (lambda lease: SetParameters(1, 6, lease, {"kp_rol": 1.0}), "unknown_parameter"),
        (lambda lease: SetParameters(1, 6, lease, {"rotor_8": 1.0}), "unknown_parameter"),
        (lambda lease: SetParameters(1, 6, 0, {"kp_roll": 90.0}), "not_holder"),
        (lambda lease: GetParameters(1, 6, ("kp_rol",)), "unknown_parameter"),
    ],
)
def test_what_is_refused_says_so_and_does_nothing(office, record, code):
    lease = office.lease()
    before = office.session.get("kp_roll")
    refused = office.asks(record(lease))
    assert (refused["op"], refused["code"]) == ("nack", code)
    assert refused["said"]
    assert office.did == []
    assert office.session.get("kp_roll") == before


def test_parameters_are_set_together_or_not_at_all(office):
    lease = office.lease()
    values = {"kp_roll": 90.0, "kd_roll": 1e9}
    assert office.asks(SetParameters(1, 6, lease, values))["code"] == "bad_value"
    assert office.session.get("kp_roll") != 90.0
    values = {"kp_roll": 90.0, "kd_roll": 15.0}
    done = office.asks(SetParameters(1, 7, lease, values))
    assert done == {"op": "parameters", "values": values, "applied_ns": 0}
    assert [action.set for action, _ in office.did] == [values]


def test_anybody_reads_parameters(office):
    assert office.asks(GetParameters(9, 6, ("kp_roll",)))["values"] == {
        "kp_roll": office.session.get("kp_roll")
    }
    values = office.asks(GetParameters(9, 6, ()))["values"]
    assert values["max_speed"] == 8.0
    assert "rotor_8" not in values


def test_an_operation_renews_the_lease(office):
    lease = office.lease()
    for _ in range(6):
        office.session.tick(0.25)
        assert office.asks(SetParameters(1, 6, lease, {"kp_roll": 90.0}))["op"] == "parameters"
    assert office.bridge.authority.state(office.session.time).hand is Hand.CLIENT


def test_nobody_flies_beside_a_path_of_the_scenario():
    office = Office(Scenario(figure_eight=FigureEight()))
    refused = office.asks(RequestControl(1, 5, "one"))
    assert (refused["code"], "figure of eight" in refused["said"]) == ("not_now", True)


def test_a_script_that_flies_comes_before_clients():
    """It takes the lease at its step, and the ladder does not land what it flies."""
    office = Office(Scenario(script=[Action(at=0.25, velocity=[0.5, 0.0, 0.0])]))
    lease = office.lease()
    office.session.tick(0.2)
    assert office.asks(SetParameters(1, 6, lease, {"kp_roll": 90.0}))["op"] == "parameters"
    office.session.tick(0.1)
    refused = office.asks(SetParameters(1, 7, lease, {"kp_roll": 80.0}))
    assert (refused["code"], "script" in refused["said"]) == ("not_holder", True)
    office.session.tick(6.0)
    assert office.session.snapshot().v_WB[0] == pytest.approx(0.5, abs=0.05)
    assert office.asks(RequestControl(2, 8, "two"))["op"] == "request_control"


def test_a_flight_that_broke_answers_nothing_as_done(office):
    lease = office.lease()
    office.desk.broken = "the flight broke off after 0.1 s"
    for record in (
        RequestControl(2, 6, "two"),
        FlightOperation(1, 7, lease, "take_off", 1.0),
        SetParameters(1, 8, lease, {"kp_roll": 90.0}),
    ):
        refused = office.asks(record)
        assert (refused["code"], "broke off" in refused["said"]) == ("not_now", True)
    assert office.asks(GetParameters(1, 9, ("kp_roll",)))["op"] == "parameters"
    assert office.did == []


def test_a_holder_that_goes_leaves_the_drone_where_its_take_off_was(office):
    """HOLD is no word alone: the height is kept, and after 5 s the drone lands."""
    lease = office.lease()
    office.asks(FlightOperation(1, 6, lease, "take_off", 30.0))
    for _ in range(12):
        office.session.tick(0.25)
        office.asks(SetParameters(1, 7, lease, {"kp_roll": 90.0}))
    office.desk.answer(Gone(1))
    office.session.tick(1.5)
    height = office.session.snapshot().p_WB[2]
    assert 1.0 < height < 4.0
    office.session.tick(3.0)
    assert office.session.snapshot().p_WB[2] == pytest.approx(height, abs=0.1)
    assert office.session.snapshot().mode is FlightMode.HOVERING
    office.session.tick(1.0)
    assert office.session.snapshot().mode is FlightMode.LANDING


def test_many_questions_cost_little(office):
    """All parameters are looked up once, however often anybody asks."""
    looked_up = []
    get = office.session.get
    office.session.get = lambda name: looked_up.append(name) or get(name)
    for number in range(100):
        office.asks(GetParameters(1, number, ("kp_roll",) * 256))
        office.asks(GetParameters(1, number, ()))
    assert len(looked_up) == len(set(looked_up))


def test_commands_and_partings_are_not_answered(office):
    lease = office.lease()
    assert office.desk.answer(Command(1, 1, 0, lease, 15, (0.0, 0.0, 0.0), 0.0)) is None
    assert office.desk.answer(Gone(1)) is None
    assert office.bridge.authority.state(0.0).hand is Hand.NOBODY
