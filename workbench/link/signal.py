"""A signal: what the link, logs, charts and ROS 2 know of one published quantity."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from workbench.link.picture import PictureLayout
from workbench.link.ros_messages.making import MessageMaker, own_message_maker
from workbench.link.topics import PREFIX, Delivery, Field, Topic, TopicDirection

ROS_PACKAGE = "dh_drone_msgs"
"""Our package of ROS 2 messages."""


@dataclass(frozen=True)
class TopicOptions:
    """The properties of a drone that determine its topics and their sizes.

    Attributes:
        rotors: their number.
        fast: rate of topics of the state [1/s].
        slow: rate of slow topics [1/s].
        rates: of the signals that not every flight has, by `Signal.rate` [1/s].
        rays: number of rays in the lidar's cloud on the wire.
        scan: directions of these rays and the position of the sensor, for `Topic.about`.
        frames: parent and child of each frame.
        limits: largest level speed, climb rate [m/s] and yaw rate [rad/s] of commands.
        mounts: names of the sensor frames, by kind.
        deviations: standard deviations of the first values of a sensor's samples, by kind.
        moving: names of the frames that move in their parents.
        joints: names of the joints that move, one for each freedom.
        setpoints: what the servos of some of them take: position, velocity and effort as far as
            there are such servos.
        contacts: first links of the bodies whose contact forces are published.
        cables: names of those whose tensions are published.
        home: latitude, longitude [rad] and altitude [m] of the world's origin.
        picture: layout of the depth camera's published pictures, None without a camera.
    """

    rotors: int
    fast: float
    slow: float
    rates: Mapping[str, float] = field(default_factory=dict)
    rays: int = 0
    scan: Mapping[str, object] = field(default_factory=dict)
    frames: Sequence[tuple[str, str]] = ()
    limits: tuple[float, float, float] = (8.0, 8.0, 0.4)
    mounts: Mapping[str, str] = field(default_factory=dict)
    deviations: Mapping[str, Sequence[float]] = field(default_factory=dict)
    moving: Sequence[str] = ()
    joints: Sequence[str] = ()
    setpoints: Sequence[str] = ()
    contacts: Sequence[str] = ()
    cables: Sequence[str] = ()
    home: Sequence[float] = ()
    picture: PictureLayout | None = None


class RosChannel(NamedTuple):
    """A ROS 2 topic, and its messages.

    Attributes:
        topic: with its prefix.
        type: of the messages, such as std_msgs/msg/Header.
        make: returns the function that makes them, for the topic of the link.
        repeats: whether another channel of the signal has the same numbers, which curves show.
    """

    topic: str
    type: str
    make: Callable[[Topic], MessageMaker] = own_message_maker
    repeats: bool = False


@dataclass(frozen=True)
class Signal:
    """A published quantity; its topic, log, charts and messages are made from this row.

    Attributes:
        id: number of its topic, which never changes its meaning; 1000 or more for a signal of
            another package.
        name: of its topic below the prefix of the drone, of its signals in logs and charts.
        title: in lists of signals.
        rate: fast: with each sample of the state; slow: with every sixth; event; or the kind of
            sensor that it is of, or another name of `TopicOptions.rates`.
        fields: in order, with units and frames. Those of a sensor are `STAMP_FIELD` and its
            columns; its axes are those of the sensor's frame.
        own_type: our ROS 2 message with these fields, "" for none; its definition is a file in
            `ros_messages/msg`, or made from the fields.
        others: its other messages in ROS 2 and in logs.
        about: further data for clients; by default the name of the sensor's frame, and the
            deviations of its values.
        plotted: whether its numbers are signals of a flight record.
        direction: who sends it.
    """

    id: int
    name: str
    title: str
    rate: str
    fields: "Sequence[Field] | Callable[[TopicOptions], Sequence[Field]]"
    own_type: str = ""
    others: tuple[RosChannel, ...] = ()
    about: Callable[[TopicOptions], Mapping[str, object]] | None = None
    plotted: bool = True
    direction: TopicDirection = TopicDirection.OUT

    def fields_for(self, options: TopicOptions) -> tuple[Field, ...]:
        """Return the fields of a drone; some have a value for each rotor, ray or frame."""
        return tuple(self.fields(options) if callable(self.fields) else self.fields)

    @property
    def channels(self) -> tuple[RosChannel, ...]:
        """All its ROS 2 topics and messages."""
        if not self.own_type:
            return self.others
        return (RosChannel(PREFIX + self.name, f"{ROS_PACKAGE}/msg/{self.own_type}"), *self.others)

    @property
    def definition_text(self) -> str:
        """The definition of a message of our own type with its fields, as in a .msg file."""
        lines = [f"# {self.title}.\n", "std_msgs/Header header\n"]
        for each in self.fields_for(ANY_DRONE):
            of = "string" if each.type == "char" else each.type
            size = f"[{each.count}]" if each.count > 1 and of != "string" else ""
            frame = f" in {each.frame}" if each.frame else ""
            if each != STAMP_FIELD:  # which the header has
                lines.append(f"{of}{size} {each.name} # [{each.unit}]{frame}\n")
        return "".join(lines)

    def topic(self, options: TopicOptions) -> Topic | None:
        """Return its topic of a drone, None if the drone does not have it."""
        rates = {"fast": options.fast, "slow": options.slow, "event": 0.0, **options.rates}
        fields = self.fields_for(options)
        if not fields or self.rate not in rates:
            return None
        return Topic(
            id=self.id,
            name=PREFIX + self.name,
            direction=self.direction,
            rate=rates[self.rate],
            fields=fields,
            delivery=Delivery.EVENT if self.rate == "event" else Delivery.STATE,
            about=self.about(options) if self.about else self.about_sensor(options),
        )

    def about_sensor(self, options: TopicOptions) -> dict[str, object]:
        """Return the frame and the deviations of a sensor, as far as they are known."""
        about: dict[str, object] = {}
        if self.rate in options.mounts:
            about["frame"] = options.mounts[self.rate]
        if self.rate in options.deviations:
            about["deviations"] = list(options.deviations[self.rate])
        return about


ANY_DRONE = TopicOptions(rotors=1, fast=1.0, slow=1.0)
"""For what is the same for each drone."""
STAMP_FIELD = Field("stamp", "int64", "ns", low=0)
"""Time of a sensor's sample, the first of its fields."""


def vector_field(name: str, unit: str, frame: str, components: str = "xyz") -> Field:
    """Return a field of a number for each component, as in `xyz` or `wxyz`."""
    return Field(name, "float32", unit, frame, len(components), components=components)


def component_fields(unit: str, frame: str, names: str) -> tuple[Field, ...]:
    """Return a field for each part of a vector, from names with blanks between them."""
    return tuple(Field(name, "float32", unit, frame) for name in names.split())
