"""The signals of a drone with joints: their motion, tensions of cables, and contact forces."""

from collections.abc import Mapping, Sequence

from workbench.common.parameter import SERVO_UNITS
from workbench.link.ros_messages import making
from workbench.link.signal import ROS_PACKAGE, RosChannel, Signal, TopicOptions
from workbench.link.topics import PREFIX, Field


def _joint_fields(options: TopicOptions) -> Sequence[Field]:
    count = len(options.joints)
    if not count:
        return ()
    return (
        Field("position", "float32", "rad or m", "", count),
        Field("velocity", "float32", "rad/s or m/s", "", count),
    )


def _joint_setpoint_fields(options: TopicOptions) -> Sequence[Field]:
    return tuple(
        Field(kind, "float32", " or ".join(units).replace("*", " "), "", len(options.joints))
        for kind, units in SERVO_UNITS.items()
        if kind in options.setpoints
    )


def _contact_fields(options: TopicOptions) -> Sequence[Field]:
    count = 3 * len(options.contacts)
    return (Field("force", "float32", "N", "W", count),) if count else ()


def _tension_fields(options: TopicOptions) -> Sequence[Field]:
    count = len(options.cables)
    return (Field("tension", "float32", "N", "", count),) if count else ()


def _about_joints(options: TopicOptions) -> Mapping[str, object]:
    return {"joints": list(options.joints)}


def _about_contacts(options: TopicOptions) -> Mapping[str, object]:
    return {"links": list(options.contacts)}


def _about_cables(options: TopicOptions) -> Mapping[str, object]:
    return {"cables": list(options.cables)}


_JOINT_STATES = RosChannel(
    f"{PREFIX}joint_states", "sensor_msgs/msg/JointState", making.joint_state_maker
)
_JOINT_SETPOINTS = RosChannel(
    f"{PREFIX}joint_setpoints", "sensor_msgs/msg/JointState", making.joint_state_maker
)
_CONTACT_FORCES = RosChannel(
    f"{PREFIX}contact_forces", f"{ROS_PACKAGE}/msg/ContactForces", making.named_numbers_maker
)
_TENSIONS = RosChannel(
    f"{PREFIX}tensions", f"{ROS_PACKAGE}/msg/CableTensions", making.named_numbers_maker
)
JOINT_STATES_SIGNAL = Signal(
    21,
    "joint_states",
    "Joints",
    "fast",
    _joint_fields,
    others=(_JOINT_STATES,),
    about=_about_joints,
)
JOINT_SETPOINTS_SIGNAL = Signal(
    24,
    "joint_setpoints",
    "Setpoints of joints",
    "fast",
    _joint_setpoint_fields,
    others=(_JOINT_SETPOINTS,),
    about=_about_joints,
)
CONTACT_FORCES_SIGNAL = Signal(
    25,
    "contact_forces",
    "Contact forces",
    "fast",
    _contact_fields,
    others=(_CONTACT_FORCES,),
    about=_about_contacts,
)
TENSIONS_SIGNAL = Signal(
    26,
    "tensions",
    "Tensions of cables",
    "fast",
    _tension_fields,
    others=(_TENSIONS,),
    about=_about_cables,
)
