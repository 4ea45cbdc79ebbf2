"""Services and parameters of the gateway's node, called as `rmw_cyclonedds_cpp` calls them.

Types are written by hand from std_srvs, rcl_interfaces and rmw_dds_common; Cyclone's own encoder
makes the requests.
"""

import asyncio
import os
from dataclasses import dataclass

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct, types
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from tests.extras.gateways.conftest import until
from workbench.extras.gateways.ros2 import serve_ros2
from workbench.extras.gateways.ros2_options import Ros2Options
from workbench.extras.gateways.running import LinkOptions
from workbench.link.messages import FlightOperation, RequestControl, Role, SetParameters

DOMAIN = 101 + (os.getpid() + 75) % 100
XCDR1 = Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False)
RELIABLE = Qos(Policy.Reliability.Reliable(0), Policy.History.KeepLast(10), XCDR1)
LATCHED = Qos(Policy.Reliability.Reliable(0), Policy.Durability.TransientLocal, XCDR1)


@dataclass
class TriggerRequest(IdlStruct, typename="std_srvs.srv.dds_.Trigger_Request_"):
    client_guid: types.uint64
    sequence_number: types.int64
    structure_needs_at_least_one_member: types.uint8 = 0


@dataclass
class TriggerResponse(IdlStruct, typename="std_srvs.srv.dds_.Trigger_Response_"):
    client_guid: types.uint64
    sequence_number: types.int64
    success: bool
    message: str


@dataclass
class Value(IdlStruct, typename="rcl_interfaces.msg.dds_.ParameterValue_"):
    type: types.uint8
    bool_value: bool = False
    integer_value: types.int64 = 0
    double_value: types.float64 = 0.0
    string_value: str = ""
    byte_array_value: types.sequence[types.byte] = ()
    bool_array_value: types.sequence[bool] = ()
    integer_array_value: types.sequence[types.int64] = ()
    double_array_value: types.sequence[types.float64] = ()
    string_array_value: types.sequence[str] = ()


@dataclass
class Parameter(IdlStruct, typename="rcl_interfaces.msg.dds_.Parameter_"):
    name: str
    value: Value


@dataclass
class SetRequest(IdlStruct, typename="rcl_interfaces.srv.dds_.SetParameters_Request_"):
    client_guid: types.uint64
    sequence_number: types.int64
    parameters: types.sequence[Parameter]


@dataclass
class SetResult(IdlStruct, typename="rcl_interfaces.msg.dds_.SetParametersResult_"):
    successful: bool
    reason: str


@dataclass
class SetResponse(IdlStruct, typename="rcl_interfaces.srv.dds_.SetParameters_Response_"):
    client_guid: types.uint64
    sequence_number: types.int64
    results: types.sequence[SetResult]


@dataclass
class NamesRequest(IdlStruct, typename="rcl_interfaces.srv.dds_.GetParameters_Request_"):
    client_guid: types.uint64
    sequence_number: types.int64
    names: types.sequence[str]


@dataclass
class GetResponse(IdlStruct, typename="rcl_interfaces.srv.dds_.GetParameters_Response_"):
    client_guid: types.uint64
    sequence_number: types.int64
    values: types.sequence[Value]


@dataclass
class DescribeRequest(IdlStruct, typename="rcl_interfaces.srv.dds_.DescribeParameters_Request_"):
    client_guid: types.uint64
    sequence_number: types.int64
    names: types.sequence[str]


@dataclass
class FloatRange(IdlStruct, typename="rcl_interfaces.msg.dds_.FloatingPointRange_"):
    from_value: types.float64
    to_value: types.float64
    step: types.float64


@dataclass
class IntegerRange(IdlStruct, typename="rcl_interfaces.msg.dds_.IntegerRange_"):
    from_value: types.int64
    to_value: types.int64
    step: types.uint64


@dataclass
class Descriptor(IdlStruct, typename="rcl_interfaces.msg.dds_.ParameterDescriptor_"):
    name: str
    type: types.uint8
    description: str
    additional_constraints: str
    read_only: bool
    dynamic_typing: bool
    floating_point_range: types.sequence[FloatRange]
    integer_range: types.sequence[IntegerRange]


@dataclass
class DescribeResponse(IdlStruct, typename="rcl_interfaces.srv.dds_.DescribeParameters_Response_"):
    client_guid: types.uint64
    sequence_number: types.int64
    descriptors: types.sequence[Descriptor]


@dataclass
class Gid(IdlStruct, typename="rmw_dds_common.msg.dds_.Gid_"):
    data: types.array[types.uint8, 16]


@dataclass
class NodeInfo(IdlStruct, typename="rmw_dds_common.msg.dds_.NodeEntitiesInfo_"):
    node_namespace: str
    node_name: str
    reader_gid_seq: types.sequence[Gid]
    writer_gid_seq: types.sequence[Gid]


@dataclass
class ParticipantInfo(IdlStruct, typename="rmw_dds_common.msg.dds_.ParticipantEntitiesInfo_"):
    gid: Gid
    node_entities_info_seq: types.sequence[NodeInfo]


@dataclass
class Text(IdlStruct, typename="std_msgs.msg.dds_.String_"):
    data: str


class Caller:
    """A client of services in another participant."""

    def __init__(self):
        self.participant = DomainParticipant(DOMAIN)
        self.seq = 0

    async def call(self, name, request, response, *values):
        """Return the response; requests of other clients are told apart by their header."""
        self.seq += 1
        writer = DataWriter(
            self.participant, Topic(self.participant, f"rq{name}Request", request), qos=RELIABLE
        )
        reader = DataReader(
            self.participant, Topic(self.participant, f"rr{name}Reply", response), qos=RELIABLE
        )
        await until(writer.get_matched_subscriptions)
        await until(reader.get_matched_publications)
        writer.write(request(4711, self.seq, *values))
        (answer,) = await until(lambda: reader.take(1))
        assert (answer.client_guid, answer.sequence_number) == (4711, self.seq)
        return answer

    async def last(self, topic, kind):
        """Return the message that a latched topic had before."""
        reader = DataReader(self.participant, Topic(self.participant, topic, kind), qos=LATCHED)
        (message,) = await until(lambda: reader.take(1))
        return message


def beside(server, test, **options):
    """Run the gateway beside a test."""

    async def inner():
        here = Ros2Options(domain=DOMAIN, **options)
        role = Role.COMMAND if here.allow_commands else Role.VIEW
        link, said = LinkOptions(server.address, "ros2", role=role), []
        gateway = asyncio.create_task(serve_ros2(link, here, said.append))
        try:
            await until(lambda: said or gateway.done())
            await test(Caller())
        finally:
            gateway.cancel()
            await asyncio.gather(gateway, return_exceptions=True)

    asyncio.run(inner())


def asked(server, kind):
    return [each for each in server.operations if isinstance(each, kind)]


def test_operations_are_services_and_keep_control(server):
    async def test(caller):
        server.t_ns = 12_000_000_000
        done = await caller.call("/dh_drone/take_off", TriggerRequest, TriggerResponse)
        assert (done.success, done.message) == (True, "take_off has started at 12 s")
        count = len(server.commands)
        await until(lambda: len(server.commands) > count + 3)  # a service sends no velocities
        for what in ("hold", "land", "arm", "stop", "reset"):
            done = await caller.call(f"/dh_drone/{what}", TriggerRequest, TriggerResponse)
            assert done.success, what
        said = [each.what for each in asked(server, FlightOperation)]
        assert said == ["take_off", "hold", "land", "arm", "stop", "reset"]
        assert len(asked(server, RequestControl)) == 1

    beside(server, test, allow_commands=True)


def test_a_service_is_refused_with_the_reason(server):
    async def test(caller):
        server.refuse(RequestControl, "held", "the operator at the screen flies")
        done = await caller.call("/dh_drone/arm", TriggerRequest, TriggerResponse)
        assert (done.success, done.message) == (
            False,
            "refused: the operator at the screen flies",
        )

    beside(server, test, allow_commands=True)


def test_a_gateway_that_watches_refuses_services_and_parameters(server):
    async def test(caller):
        done = await caller.call("/dh_drone/arm", TriggerRequest, TriggerResponse)
        assert not done.success and "--allow-commands" in done.message
        wanted = [Parameter("take_off_speed", Value(3, double_value=0.8))]
        done = await caller.call("/dh_drone/flight/set_parameters", SetRequest, SetResponse, wanted)
        assert not done.results[0].successful and "--allow-commands" in done.results[0].reason
        assert not asked(server, RequestControl)

    beside(server, test)


def test_parameters_are_those_of_a_node(server):
    async def test(caller):
        node = "/dh_drone/flight"
        got = await caller.call(
            f"{node}/get_parameters", NamesRequest, GetResponse, ["take_off_speed", "no_such"]
        )
        assert [(each.type, each.double_value) for each in got.values] == [(3, 0.5), (0, 0.0)]
        told = await caller.call(
            f"{node}/describe_parameters", DescribeRequest, DescribeResponse, ["take_off_speed"]
        )
        [about] = told.descriptors
        assert about.description == "how fast [m/s]"  # of the scripted server
        [span] = about.floating_point_range
        assert (span.from_value, span.to_value, span.step) == (0.1, 2.0, 0.0)
        wanted = [
            Parameter("take_off_speed", Value(3, double_value=0.8)),
            Parameter("take_off_speed", Value(2, integer_value=1)),  # `ros2 param set .. 1`
            Parameter("take_off_speed", Value(4, string_value="fast")),
            Parameter("take_off_speed", Value(3, double_value=float("nan"))),
        ]
        done = await caller.call(f"{node}/set_parameters", SetRequest, SetResponse, wanted)
        assert [each.successful for each in done.results] == [True, True, False, False]
        assert "needs a finite number" in done.results[2].reason
        assert [each.set for each in asked(server, SetParameters)] == [
            {"take_off_speed": 0.8},
            {"take_off_speed": 1.0},
        ]

    beside(server, test, allow_commands=True)


def test_the_node_and_the_description_are_there_for_who_comes_later(server):
    async def test(caller):
        info = await caller.last("ros_discovery_info", ParticipantInfo)
        [node] = info.node_entities_info_seq
        assert (node.node_namespace, node.node_name) == ("/iris_2", "flight")
        assert len(node.reader_gid_seq) == 12  # a reader of requests for each service
        text = await caller.last("rt/iris_2/robot_description", Text)
        assert text.data == '<robot name="fake"/>'

    beside(server, test, namespace="iris_2")
