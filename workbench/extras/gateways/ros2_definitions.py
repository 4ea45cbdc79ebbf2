"""Definitions of ROS 2 types that only the gateway uses, as those of services and parameters.

Source: the packages rosgraph_msgs, std_msgs, std_srvs, trajectory_msgs, rcl_interfaces and
rmw_dds_common of ROS 2.
`structure_needs_at_least_one_member` is what ROS 2 puts into a message without fields.
"""

from workbench.link.ros_messages.definitions import Definition, read_definition
from workbench.link.ros_messages.library import definition, included, type_names

CLOCK_TYPE = "rosgraph_msgs/msg/Clock"
STRING_TYPE = "std_msgs/msg/String"
TRIGGER_TYPE = "std_srvs/srv/Trigger"
TRAJECTORY_TYPE = "trajectory_msgs/msg/JointTrajectory"
PARAMETER_EVENT_TYPE = "rcl_interfaces/msg/ParameterEvent"
NODES_TYPE = "rmw_dds_common/msg/ParticipantEntitiesInfo"
EMPTY_FIELD = "structure_needs_at_least_one_member"
REQUEST_HEADER = "uint64 client_guid\nint64 sequence_number\n"
"""First fields of a request and of its response in DDS, as `rmw_cyclonedds_cpp` has them."""
_SERVICES = {
    TRIGGER_TYPE: (f"uint8 {EMPTY_FIELD}\n", "bool success\nstring message\n"),
    "rcl_interfaces/srv/GetParameters": (
        "string[] names\n",
        "rcl_interfaces/ParameterValue[] values\n",
    ),
    "rcl_interfaces/srv/GetParameterTypes": ("string[] names\n", "uint8[] types\n"),
    "rcl_interfaces/srv/SetParameters": (
        "rcl_interfaces/Parameter[] parameters\n",
        "rcl_interfaces/SetParametersResult[] results\n",
    ),
    "rcl_interfaces/srv/SetParametersAtomically": (
        "rcl_interfaces/Parameter[] parameters\n",
        "rcl_interfaces/SetParametersResult result\n",
    ),
    "rcl_interfaces/srv/ListParameters": (
        "string[] prefixes\nuint64 depth\n",
        "rcl_interfaces/ListParametersResult result\n",
    ),
    "rcl_interfaces/srv/DescribeParameters": (
        "string[] names\n",
        "rcl_interfaces/ParameterDescriptor[] descriptors\n",
    ),
}
"""Fields of request and response of each service, by its type."""
_TEXTS = {
    CLOCK_TYPE: "builtin_interfaces/Time clock\n",
    STRING_TYPE: "string data\n",
    TRAJECTORY_TYPE: (
        "std_msgs/Header header\nstring[] joint_names\nJointTrajectoryPoint[] points\n"
    ),
    "trajectory_msgs/msg/JointTrajectoryPoint": (
        "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
        "builtin_interfaces/Duration time_from_start\n"
    ),
    "builtin_interfaces/msg/Duration": "int32 sec\nuint32 nanosec\n",
    PARAMETER_EVENT_TYPE: (
        "builtin_interfaces/Time stamp\nstring node\nParameter[] new_parameters\n"
        "Parameter[] changed_parameters\nParameter[] deleted_parameters\n"
    ),
    NODES_TYPE: "Gid gid\nNodeEntitiesInfo[] node_entities_info_seq\n",
    "rmw_dds_common/msg/Gid": "char[16] data\n",
    "rmw_dds_common/msg/NodeEntitiesInfo": (
        "string node_namespace\nstring node_name\nGid[] reader_gid_seq\nGid[] writer_gid_seq\n"
    ),
    "rcl_interfaces/msg/Parameter": "string name\nParameterValue value\n",
    "rcl_interfaces/msg/ParameterValue": (
        "uint8 type\nbool bool_value\nint64 integer_value\nfloat64 double_value\n"
        "string string_value\nbyte[] byte_array_value\nbool[] bool_array_value\n"
        "int64[] integer_array_value\nfloat64[] double_array_value\nstring[] string_array_value\n"
    ),
    "rcl_interfaces/msg/ParameterDescriptor": (
        "string name\nuint8 type\nstring description\nstring additional_constraints\n"
        "bool read_only\nbool dynamic_typing\nFloatingPointRange[] floating_point_range\n"
        "IntegerRange[] integer_range\n"
    ),
    "rcl_interfaces/msg/FloatingPointRange": "float64 from_value\nfloat64 to_value\nfloat64 step\n",
    "rcl_interfaces/msg/IntegerRange": "int64 from_value\nint64 to_value\nuint64 step\n",
    "rcl_interfaces/msg/SetParametersResult": "bool successful\nstring reason\n",
    "rcl_interfaces/msg/ListParametersResult": "string[] names\nstring[] prefixes\n",
    **{f"{kind}_Request": REQUEST_HEADER + request for kind, (request, _) in _SERVICES.items()},
    **{f"{kind}_Response": REQUEST_HEADER + response for kind, (_, response) in _SERVICES.items()},
}


def gateway_types() -> tuple[str, ...]:
    """Return the names of the types that are defined here."""
    return tuple(_TEXTS)


def included_definitions(name: str) -> tuple[Definition, ...]:
    """Return the definitions of a type, and then of all types included in it, each once.

    Raises:
        WorkbenchError: if it is unknown.
    """
    return included(name, _definition)


def _definition(name: str) -> Definition:
    shipped = name in type_names() or name not in _TEXTS
    return definition(name) if shipped else read_definition(name, _TEXTS[name])
