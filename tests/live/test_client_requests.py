"""What clients ask for, answered as docs/protocol.md says, in a session that stands still."""

import json

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from workbench.control.mode import FlightMode
from workbench.link.backplane import ClientRequest
from workbench.link.message_json import write_message
from workbench.link.messages import (
    ControlOwner,
    DescribeVehicle,
    FlightOperation,
    GetParameters,
    ReleaseControl,
    RequestControl,
    SetParameters,
)
from workbench.live.client_requests import ClientRequests
from workbench.scenario.scenario import Action, FigureEight, Scenario, ScenarioStart
from workbench.session.session import Session
from workbench.systems.bridge import Bridge


class Station:
    """Requests of clients, their session, and what it took note of."""

    def __init__(self, scenario: Scenario | None = None) -> None:
        self.bridge = Bridge()
        scenario = scenario or Scenario(start=ScenarioStart(mode="off"))
        self.session = Session(scenario, bridge=self.bridge)
        self.did = []
        self.requests = ClientRequests(self.session, self.bridge, self.act)

    def act(self, action: Action, by: str) -> None:
        self.session.do(action)
        self.did.append((action, by))

    def asks(self, operation, peer: int = 1) -> dict:
        """Return the answer as the client reads it, without the request's number."""
        reply = self.requests.answer(ClientRequest(peer, operation))
        assert (reply.peer, reply.answer.id) == (peer, operation.id)
        answer = json.loads(write_message(reply.answer))
        del answer["id"]
        return answer

    def lease(self, peer: int = 1) -> int:
        lease = self.asks(RequestControl(5, f"client {peer}"), peer)["lease"]
        assert [(action.request, by) for action, by in self.did] == [("hold", "client 1")]
        self.did.clear()
        return lease


@pytest.fixture
def station() -> Station:
    return Station()


def test_control_is_granted_once_and_released(station):
    granted = station.asks(RequestControl(5, "one"))
    assert (granted["op"], granted["expires"]) == ("request_control", 0.5)
    refused = station.asks(RequestControl(6, "two"), 2)
    assert (refused["op"], refused["code"]) == ("nack", "held")
    assert "one" in refused["said"]
    wrong = station.asks(ReleaseControl(7, granted["lease"]), 2)
    assert wrong["code"] == "not_holder"
    assert station.asks(ReleaseControl(8, granted["lease"])) == {"op": "release_control"}
    assert station.asks(RequestControl(9, "two"), 2)["op"] == "request_control"


def test_a_flight_operation_is_done_and_on_record(station):
    lease = station.lease()
    done = station.asks(FlightOperation(6, "take_off", 1.25, lease))
    assert done == {"op": "flight", "what": "take_off", "applied_ns": 0}
    ((action, by),) = station.did
    assert (action.request, action.height, by) == ("take_off", 1.25, "client 1")
    station.session.tick(0.25)
    assert station.session.snapshot().mode is FlightMode.ARMED


def test_a_request_that_would_have_no_effect_is_not_answered_as_done(station):
    """In the air nothing takes off or arms; on the way down a take-off climbs again."""
    lease = station.lease()
    station.asks(FlightOperation(6, "take_off", 1.0, lease))
    for _ in range(20):  # the lease lasts half a second
        station.session.tick(0.25)
        station.asks(SetParameters(6, {"kp_roll": 90.0}, lease))
    assert station.session.snapshot().mode is FlightMode.HOVERING
    for what in ("take_off", "arm"):
        refused = station.asks(FlightOperation(7, what, 1.0, lease))
        assert (refused["code"], "hovering" in refused["said"]) == ("not_now", True)
    assert station.asks(FlightOperation(8, "land", 1.0, lease))["op"] == "flight"
    station.session.tick(0.25)
    assert station.asks(FlightOperation(9, "take_off", 1.0, lease))["op"] == "flight"
    assert station.did[-1][0].request == "abort_landing"
    assert station.asks(FlightOperation(9, "stop", 0.0, lease))["op"] == "flight"  # has no height


@pytest.mark.parametrize(
    ("operation", "peer", "code"),
    [
        (lambda lease: FlightOperation(6, "take_off", 1e9, lease), 1, "not_now"),
        (lambda lease: FlightOperation(6, "somersault", 1.0, lease), 1, "not_now"),
        (lambda lease: FlightOperation(6, "stop", 1.0, lease + 1), 1, "not_holder"),
        (lambda lease: FlightOperation(6, "stop", 1.0, lease), 2, "not_holder"),
        (lambda lease: SetParameters(6, {"kp_roll": 1e9}, lease), 1, "bad_value"),
        (lambda lease: SetParameters(6, {"kp_rol": 1.0}, lease), 1, "unknown_parameter"),
        (lambda lease: SetParameters(6, {"rotor_8": 1.0}, lease), 1, "unknown_parameter"),
        (lambda lease: SetParameters(6, {"kp_roll": 90.0}, 0), 1, "not_holder"),
        (lambda lease: GetParameters(6, ("kp_rol",)), 1, "unknown_parameter"),
    ],
)
def test_what_is_refused_says_so_and_does_nothing(station, operation, peer, code):
    lease = station.lease()
    before = station.session.get("kp_roll")
    refused = station.asks(operation(lease), peer)
    assert (refused["op"], refused["code"]) == ("nack", code)
    assert refused["said"]
    assert station.did == []
    assert station.session.get("kp_roll") == before


def test_parameters_are_set_together_or_not_at_all(station):
    lease = station.lease()
    values = {"kp_roll": 90.0, "kd_roll": 1e9}
    assert station.asks(SetParameters(6, values, lease))["code"] == "bad_value"
    assert station.session.get("kp_roll") != 90.0
    values = {"kp_roll": 90.0, "kd_roll": 15.0}
    done = station.asks(SetParameters(7, values, lease))
    assert done == {"op": "parameters", "values": values, "applied_ns": 0}
    assert [action.set for action, _ in station.did] == [values]


def test_anybody_reads_parameters(station):
    assert station.asks(GetParameters(6, ("kp_roll",)))["values"] == {
        "kp_roll": station.session.get("kp_roll")
    }
    values = station.asks(GetParameters(6, ()))["values"]
    assert values["max_speed"] == 8.0
    assert "rotor_8" not in values


def test_a_reset_needs_control_and_is_reported_once(station):
    refused = station.asks(FlightOperation(1, "reset", 1.5, 7))
    assert (refused["code"], station.requests.resets) == ("not_holder", False)
    done = station.asks(FlightOperation(2, "reset", 1.5, station.lease()))
    assert done == {"op": "flight", "what": "reset", "applied_ns": 0}
    assert station.requests.resets and not station.did


def test_the_description_is_urdf_with_the_frames_of_the_drone(station):
    """Read by Drake, whose frames have the names of ours."""
    urdf = station.asks(DescribeVehicle(3))["urdf"]
    plant = MultibodyPlant(1e-3)
    Parser(plant).AddModelsFromString(urdf, "urdf")
    names = {frame.name for frame in station.session.vehicle.frames}
    assert {"base_link", "lidar_link"} <= names
    assert all(plant.HasFrameNamed(name) for name in names)


def test_an_operation_renews_the_lease(station):
    lease = station.lease()
    for _ in range(6):
        station.session.tick(0.25)
        assert station.asks(SetParameters(6, {"kp_roll": 90.0}, lease))["op"] == "parameters"
    assert station.bridge.authority.state(station.session.time).hand is ControlOwner.CLIENT


def test_nobody_flies_beside_a_path_of_the_scenario():
    station = Station(Scenario(figure_eight=FigureEight()))
    refused = station.asks(RequestControl(5, "one"))
    assert (refused["code"], "figure of eight" in refused["said"]) == ("not_now", True)


def test_a_script_that_flies_comes_before_clients():
    """It takes the lease at its step, and the ladder does not land what it flies."""
    station = Station(Scenario(script=[Action(at=0.25, velocity=[0.5, 0.0, 0.0])]))
    lease = station.lease()
    station.session.tick(0.2)
    assert station.asks(SetParameters(6, {"kp_roll": 90.0}, lease))["op"] == "parameters"
    station.session.tick(0.1)
    refused = station.asks(SetParameters(7, {"kp_roll": 80.0}, lease))
    assert (refused["code"], "script" in refused["said"]) == ("not_holder", True)
    station.session.tick(6.0)
    assert station.session.snapshot().v_WB[0] == pytest.approx(0.5, abs=0.05)
    assert station.asks(RequestControl(8, "two"), 2)["op"] == "request_control"


@pytest.mark.parametrize("name", ["stop", "land", "hold"])
def test_a_client_that_asks_to_hold_land_or_stop_ends_the_script(name):
    """Otherwise its next order would start the rotors again beside whoever stopped them."""
    script = [Action(at=0.25, request="take_off", height=1.0)]
    station = Station(Scenario(start=ScenarioStart(mode="off"), script=script))
    lease = station.lease()
    assert station.session.next_action is not None  # the hold of a new pilot ends nothing
    assert station.asks(FlightOperation(6, name, 1.0, lease))["op"] == "flight"
    station.session.tick(0.5)
    assert station.session.snapshot().mode is FlightMode.OFF
    assert [action.end_script for action, _ in station.did] == [True]


def test_a_flight_that_broke_answers_nothing_as_done(station):
    lease = station.lease()
    station.requests.broken = "the flight broke off after 0.1 s"
    for record in (
        RequestControl(6, "two"),
        FlightOperation(7, "take_off", 1.0, lease),
        SetParameters(8, {"kp_roll": 90.0}, lease),
    ):
        refused = station.asks(record)
        assert (refused["code"], "broke off" in refused["said"]) == ("not_now", True)
    assert station.asks(GetParameters(9, ("kp_roll",)))["op"] == "parameters"
    assert station.did == []


@pytest.mark.slow
def test_a_holder_that_goes_leaves_the_drone_where_its_take_off_was(station):
    """HOLD is no word alone: the height is kept, and after 5 s the drone lands."""
    lease = station.lease()
    station.asks(FlightOperation(6, "take_off", 30.0, lease))
    for _ in range(12):
        station.session.tick(0.25)
        station.asks(SetParameters(7, {"kp_roll": 90.0}, lease))
    station.requests.gone(1)
    station.session.tick(1.5)
    height = station.session.snapshot().p_WB[2]
    assert 1.0 < height < 4.0
    station.session.tick(3.0)
    assert station.session.snapshot().p_WB[2] == pytest.approx(height, abs=0.1)
    assert station.session.snapshot().mode is FlightMode.HOVERING
    station.session.tick(1.0)
    assert station.session.snapshot().mode is FlightMode.LANDING


def test_many_questions_cost_little(station):
    """All parameters are looked up once, however often anybody asks."""
    looked_up = []
    get = station.session.get
    station.session.get = lambda name: looked_up.append(name) or get(name)
    for number in range(100):
        station.asks(GetParameters(number, ("kp_roll",) * 256))
        station.asks(GetParameters(number, ()))
    assert len(looked_up) == len(set(looked_up))


def test_a_holder_that_goes_has_control_no_longer(station):
    station.lease()
    station.requests.gone(2)
    assert station.bridge.authority.state(0.0).hand is ControlOwner.CLIENT
    station.requests.gone(1)
    assert station.bridge.authority.state(0.0).hand is ControlOwner.NOBODY
