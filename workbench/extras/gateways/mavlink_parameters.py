"""The live parameters of a flight by MAVLink's parameter protocol."""

import asyncio
import math
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ground_station import GroundStation
from workbench.link import AsyncClient

PARAMETERS_PER_TURN = 20
"""Number of parameters sent before other work gets a turn."""
SetParameter = Callable[[str, float], Awaitable[None]]
"""Sets a live parameter; it raises a WorkbenchError with the reason."""


class ParameterProtocol:
    """Lists, reads and sets parameters for a station.

    Args:
        client: of the link, open.
        station: the ground station.
        ids: MAVLink id of each parameter, by its name.
        set_parameter: sets one.
    """

    def __init__(
        self,
        client: AsyncClient,
        station: GroundStation,
        ids: Mapping[str, str],
        set_parameter: SetParameter,
    ) -> None:
        self._client, self._station, self._set = client, station, set_parameter
        self._names, self._ids = list(ids), ids
        self._named = {short: name for name, short in ids.items()}

    async def answer(self, message: Any) -> None:
        """Answer a message, if it is one of the protocol.

        Raises:
            WorkbenchError: if a parameter is unknown or refused.
        """
        match message.get_type():
            case "PARAM_REQUEST_LIST":
                values = await self._client.parameters()
                for place, name in enumerate(self._names, start=1):
                    self.send(name, values[name])
                    if place % PARAMETERS_PER_TURN == 0:
                        await asyncio.sleep(0)
            case "PARAM_REQUEST_READ":
                name = self._asked(message)
                self.send(name, (await self._client.parameters(name))[name])
            case "PARAM_SET":
                await self._set_value(self._named_by(message.param_id), message.param_value)

    def send(self, name: str, value: Any) -> None:
        """Send the value of a parameter, if the station knows it."""
        if name not in self._ids:
            return
        self._station.send(
            mavlink.MAVLink_param_value_message(
                self._ids[name].encode(),
                value,
                mavlink.MAV_PARAM_TYPE_REAL32,
                len(self._names),
                self._names.index(name),
            )
        )

    async def _set_value(self, name: str, value: float) -> None:
        """Set a parameter, and report its present value, even if that failed."""
        try:
            if not math.isfinite(value):
                raise WorkbenchError(f"{name} = {value} is not a number: nothing was set")
            # a station sends 32 bits: 0.8 must not become 0.800000011920929
            await self._set(name, float(str(np.float32(value))))
        finally:
            self.send(name, (await self._client.parameters(name))[name])

    def _asked(self, message: Any) -> str:
        """Return the name of the requested parameter."""
        if message.param_index < 0:
            return self._named_by(message.param_id)
        if message.param_index >= len(self._names):
            raise WorkbenchError(
                f"there is no parameter {message.param_index} of 0 to {len(self._names) - 1}"
            )
        return self._names[message.param_index]

    def _named_by(self, short: str) -> str:
        name = self._named.get(short)
        if name is None:
            raise WorkbenchError(f"there is no parameter {short!r} here")
        return name
