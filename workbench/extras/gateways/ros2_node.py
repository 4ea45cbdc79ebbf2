"""The gateway as a node of ROS 2: services of the flight, parameters, and its announcement."""

from collections.abc import Awaitable, Callable, Sequence
from functools import partial
from typing import Any

from cyclonedds.core import Entity
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_dds import latched_qos, message_type
from workbench.extras.gateways.ros2_definitions import NODES_TYPE, TRIGGER_TYPE
from workbench.extras.gateways.ros2_parameters import (
    NODE_NAME,
    ParameterAnswers,
)
from workbench.extras.gateways.ros2_services import RosService
from workbench.extras.gateways.running import SetParameters
from workbench.link import AsyncClient
from workbench.link.message_json import FLIGHT_OPERATIONS

DISCOVERY_TOPIC = "ros_discovery_info"
"""DDS topic on which ROS 2 programs announce their nodes."""
FAST_DDS_TEXT = (
    "a ROS 2 program with Fast DDS calls a service or reads parameters, and will get no answer: "
    "set RMW_IMPLEMENTATION=rmw_cyclonedds_cpp for it"
)
Operate = Callable[[str], Awaitable[str]]
"""Does a flight operation, and returns a sentence; it raises a WorkbenchError with the reason."""


class FlightNode:
    """The node `flight` in the namespace of the drone.

    Args:
        client: of the link, open.
        participant: of the domain.
        namespace: of the drone, without slashes.
        operate: does a flight operation.
        set_parameters: sets live parameters.
        say: shows the user a sentence.
    """

    def __init__(
        self,
        client: AsyncClient,
        participant: DomainParticipant,
        namespace: str,
        operate: Operate,
        set_parameters: SetParameters,
        say: Callable[[str], None],
    ) -> None:
        async def answer(what: str, request: object) -> dict[str, Any]:
            try:
                return {"success": True, "message": await operate(what)}
            except WorkbenchError as error:
                return {"success": False, "message": str(error)}

        self._namespace, self._participant, self._say = namespace, participant, say
        self._services = [
            RosService(participant, f"/{namespace}/{what}", TRIGGER_TYPE, partial(answer, what))
            for what in FLIGHT_OPERATIONS
        ]
        self._services += [
            RosService(participant, f"/{namespace}/{NODE_NAME}/{name}", kind, respond)
            for name, (kind, respond) in ParameterAnswers(client, set_parameters).services.items()
        ]
        kind = message_type(NODES_TYPE)
        topic = DdsTopic(participant, DISCOVERY_TOPIC, kind.idl)
        self._announcement = DataWriter(participant, topic, qos=latched_qos())

    async def serve(self) -> None:
        """Answer the requests that have arrived, and say which clients get no answer."""
        for service in self._services:
            await service.serve()
            if service.has_new_fast_dds_client():
                self._say(FAST_DDS_TEXT)

    def announce(self, writers: Sequence[DataWriter]) -> None:
        """Announce the node with its services and other writers.

        The message is that of `rmw_dds_common` since ROS 2 Iron.
        """
        own = [end for service in self._services for end in service.endpoints]
        readers = [end for end in own if isinstance(end, DataReader)]
        writers = [*writers, *(end for end in own if isinstance(end, DataWriter))]
        node = {
            "node_namespace": f"/{self._namespace}",
            "node_name": NODE_NAME,
            "reader_gid_seq": [_gid(each) for each in readers],
            "writer_gid_seq": [_gid(each) for each in writers],
        }
        message = {"gid": _gid(self._participant), "node_entities_info_seq": [node]}
        self._announcement.write(message_type(NODES_TYPE).sample(message))


def _gid(entity: Entity) -> dict[str, Sequence[int]]:
    """Return the global identifier of an entity."""
    return {"data": tuple(entity.guid.bytes)}
