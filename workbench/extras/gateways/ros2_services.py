"""ROS 2 services over DDS.

Requests and responses have the header of `rmw_cyclonedds_cpp`: the client's number and that of the
request. `rmw_fastrtps_cpp` puts it beside the message (PID_RELATED_SAMPLE_IDENTITY of RTPS), where
Cyclone DDS neither shows nor sends it. So clients with Fast DDS find these services, and wait in
vain.
"""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from typing import Any
from uuid import uuid4

from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic as DdsTopic

from workbench.extras.gateways.ros2_dds import endpoint_qos, message_type
from workbench.extras.gateways.ros2_reading import make_reader, take_messages

RESPONSE_READER_WAIT_S = 0.1
"""Time for the client's reader of responses to be discovered [s], as in `rmw_cyclonedds_cpp`."""
FAST_DDS_VENDOR = b"\x01\x0f"
"""First bytes of the identifiers of Fast DDS, by the list of vendors of RTPS."""
_WAIT_STEP_S = 0.005
ServiceAnswer = Callable[[Any], Awaitable[Mapping[str, Any]]]
"""Returns the fields of the response to a request."""


class RosService:
    """A service of ROS 2.

    Args:
        participant: of the domain.
        name: of the service, such as /dh_drone/arm.
        type_name: such as std_srvs/srv/Trigger.
        answer: executes a request.
    """

    def __init__(
        self, participant: DomainParticipant, name: str, type_name: str, answer: ServiceAnswer
    ) -> None:
        user_data = f"serviceid={'.'.join(f'{byte:x}' for byte in uuid4().bytes)};"
        request = message_type(f"{type_name}_Request")
        self._response = message_type(f"{type_name}_Response")
        self._answer = answer
        self._known: set[int] = set()
        self._reader = make_reader(
            participant, DdsTopic(participant, f"rq{name}Request", request.idl), user_data=user_data
        )
        self._writer = DataWriter(
            participant,
            DdsTopic(participant, f"rr{name}Reply", self._response.idl),
            qos=endpoint_qos(Policy.Userdata(user_data.encode())),
        )

    @property
    def endpoints(self) -> tuple[DataReader, DataWriter]:
        """Its reader of requests and writer of responses."""
        return self._reader, self._writer

    def has_new_fast_dds_client(self) -> bool:
        """Return whether a client with Fast DDS, which gets no answers, is new since last time."""
        handles = set(self._reader.get_matched_publications())
        new, self._known = handles - self._known, handles
        clients = map(self._reader.get_matched_publication_data, new)
        return any(
            each is not None and each.participant_key.bytes.startswith(FAST_DDS_VENDOR)
            for each in clients
        )

    async def serve(self) -> None:
        """Answer the requests that have arrived."""
        for _, message, _ in list(take_messages(self._reader)):
            if message is None:  # of another protocol
                continue
            request: Any = message
            values = await self._answer(request)
            await self._wait_for_reader()
            head = {
                "client_guid": request.client_guid,
                "sequence_number": request.sequence_number,
            }
            self._writer.write(self._response.sample({**head, **values}))

    async def _wait_for_reader(self) -> None:
        """Wait until somebody reads responses, for a short time."""
        for _ in range(round(RESPONSE_READER_WAIT_S / _WAIT_STEP_S)):
            if self._writer.get_matched_subscriptions():
                return
            await asyncio.sleep(_WAIT_STEP_S)
