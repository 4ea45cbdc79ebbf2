"""The live parameters of a flight as parameters of a ROS 2 node, for `ros2 param` and rqt.

Source: rcl_interfaces, whose services each node has.
"""

import math
from collections.abc import Sequence
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_services import ServiceAnswer
from workbench.extras.gateways.running import SetParameters
from workbench.link import AsyncClient
from workbench.link.hello import ParameterRow
from workbench.link.ros_messages.making import time_message

NODE_NAME = "flight"
"""Name of the gateway's node, in the namespace of the drone."""
PARAMETER_NOT_SET = 0
PARAMETER_INTEGER = 2
PARAMETER_DOUBLE = 3
"""Constants of rcl_interfaces/msg/ParameterType."""


class ParameterAnswers:
    """Answers to the parameter services of a node.

    Args:
        client: of the link, open.
        set_parameters: sets live parameters.
    """

    def __init__(self, client: AsyncClient, set_parameters: SetParameters) -> None:
        self._client, self._set = client, set_parameters

    @property
    def services(self) -> dict[str, tuple[str, ServiceAnswer]]:
        """Type and answer of each service, by its name below that of the node."""
        answers: dict[str, ServiceAnswer] = {
            "DescribeParameters": self._describe,
            "GetParameters": self._get,
            "GetParameterTypes": self._types,
            "ListParameters": self._list,
            "SetParameters": self._set_each,
            "SetParametersAtomically": self._set_all,
        }
        return {
            _snake_case(plain): (f"rcl_interfaces/srv/{plain}", answer)
            for plain, answer in answers.items()
        }

    def _rows(self) -> dict[str, ParameterRow]:
        return {row.name: row for row in self._client.hello.parameters}

    async def _list(self, request: Any) -> dict[str, Any]:
        prefixes = list(request.prefixes)
        names = [name for name in self._rows() if not prefixes or name in prefixes]
        return {"result": {"names": names, "prefixes": ()}}

    async def _types(self, request: Any) -> dict[str, Any]:
        rows = self._rows()
        return {
            "types": bytes(
                PARAMETER_DOUBLE if name in rows else PARAMETER_NOT_SET for name in request.names
            )
        }

    async def _get(self, request: Any) -> dict[str, Any]:
        values = await self._client.parameters()
        return {"values": [_parameter_value(values.get(name)) for name in request.names]}

    async def _describe(self, request: Any) -> dict[str, Any]:
        rows = self._rows()
        return {"descriptors": [_descriptor(name, rows.get(name)) for name in request.names]}

    async def _set_each(self, request: Any) -> dict[str, Any]:
        return {"results": [await self._result([each]) for each in request.parameters]}

    async def _set_all(self, request: Any) -> dict[str, Any]:
        return {"result": await self._result(request.parameters)}

    async def _result(self, parameters: Sequence[Any]) -> dict[str, Any]:
        """Set parameters, and return the rcl_interfaces/msg/SetParametersResult."""
        try:
            await self._set({each.name: _number(each) for each in parameters})
        except WorkbenchError as error:
            return {"successful": False, "reason": str(error)}
        return {"successful": True, "reason": ""}


def parameter_event(t_ns: int, node: str, name: str, number: float) -> dict[str, Any]:
    """Return the rcl_interfaces/msg/ParameterEvent of a parameter that has changed.

    Args:
        t_ns: simulated time [ns].
        node: name of the node, with its namespace.
        name: of the parameter.
        number: its value.
    """
    return {
        "stamp": time_message(t_ns),
        "node": node,
        "new_parameters": (),
        "changed_parameters": ({"name": name, "value": _parameter_value(number)},),
        "deleted_parameters": (),
    }


def _number(parameter: Any) -> float:
    """Return the number of a rcl_interfaces/msg/Parameter.

    Raises:
        WorkbenchError: if it is none; `ros2 param set` writes 1 as an integer.
    """
    value = parameter.value
    if value.type == PARAMETER_INTEGER:
        return float(value.integer_value)
    if value.type == PARAMETER_DOUBLE and math.isfinite(value.double_value):
        return float(value.double_value)
    raise WorkbenchError(f"{parameter.name:.60} needs a finite number, such as 1.5")


def _parameter_value(number: float | None) -> dict[str, Any]:
    """Return a rcl_interfaces/msg/ParameterValue; None is not set."""
    return {
        "type": PARAMETER_NOT_SET if number is None else PARAMETER_DOUBLE,
        "bool_value": False,
        "integer_value": 0,
        "double_value": number or 0.0,
        "string_value": "",
        "byte_array_value": b"",
        "bool_array_value": (),
        "integer_array_value": (),
        "double_array_value": (),
        "string_array_value": (),
    }


def _descriptor(name: str, row: ParameterRow | None) -> dict[str, Any]:
    """Return a rcl_interfaces/msg/ParameterDescriptor, with unit and range."""
    span = [] if row is None else [{"from_value": row.low, "to_value": row.high, "step": 0.0}]
    return {
        "name": name,
        "type": PARAMETER_NOT_SET if row is None else PARAMETER_DOUBLE,
        "description": "" if row is None else f"{row.help} [{row.unit}]",
        "additional_constraints": "",
        "read_only": False,
        "dynamic_typing": False,
        "floating_point_range": span,
        "integer_range": [],
    }


def _snake_case(name: str) -> str:
    """Return a name of a type as that of a service."""
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")
