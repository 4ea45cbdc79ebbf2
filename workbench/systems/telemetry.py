"""Telemetry: the topics of a flight, sampled in publish events and kept until drained."""

import math
import time
from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context

from workbench.common.parameter import SERVO_UNITS
from workbench.control.mode import FlightMode
from workbench.dynamics.rigid_body import into_world, rotation
from workbench.link import drone_topics as topic
from workbench.link.backplane import Published, Sampled
from workbench.link.picture import MAX_DEPTH_MM, STAMP_BYTES, picture_stride
from workbench.link.picture_signals import COLOUR_IMAGE_SIGNAL, DEPTH_IMAGE_SIGNAL
from workbench.link.topics import Topic
from workbench.plant.rotors import wrench_matrix
from workbench.plant.sensors import DepthCamera, Lidar
from workbench.plant.vehicle import Vehicle
from workbench.systems.bridge import Bridge
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.frame_poses import FrameTransforms
from workbench.systems.sensors.readings import DepthImage
from workbench.systems.sensors.scan_pattern import ScanPattern

TopicPayload = tuple[int, bytes]
SignalNumbers = Sequence[float]
SECOND_NS = 1e9
"""Nanoseconds in a second."""
SLOW_TOPIC_DIVIDER = 6
"""Slow topics are published with every sixth sample."""
UNKNOWN_TERMINALS = (math.nan, math.nan)
"""Voltage [V] and current [A] of a battery that the description does not state."""
FLOAT32_LIMIT = 3.4e38
"""About the largest number of a 32-bit float."""


class TopicValues:
    """Makes payloads from signals.

    Args:
        vehicle: the flying vehicle.
        topics: its topics.
        pattern: of the lidar's rays; None if none is published.
        sent: indices of the published rays.

    Attributes:
        start: where the flight began, in W [m]; displacement is from there.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        topics: Sequence[Topic],
        pattern: ScanPattern | None = None,
        sent: Sequence[int] | np.ndarray = (),
    ) -> None:
        self._topics = {each.id: each for each in topics}
        self._measured = {row.rate: row.id for row in topic.drone_signals()}
        self._wrench = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)
        self._pattern, self._sent = pattern, np.array(sent, dtype=int)
        joints, servos = vehicle.published_joints, vehicle.servos
        pairs = zip(*joints.values(), strict=True)
        self._joint_places = [place for pair in pairs for place in pair]
        known = {each.servo.kind for each in servos}
        kinds, names = [each for each in SERVO_UNITS if each in known], list(joints)
        self._setpoint_count = len(kinds) * len(names)
        self._setpoint_places = [
            kinds.index(each.servo.kind) * len(names) + names.index(each.joint) for each in servos
        ]
        self._capacity = vehicle.battery.capacity if vehicle.battery else math.nan
        self.start: SignalNumbers = (0.0, 0.0, 0.0)

    def clocks(self, t_ns: int, wall_ns: int) -> TopicPayload:
        """Return the payload of simulated time and the wall clock."""
        seconds, nanoseconds = divmod(t_ns, 1_000_000_000)
        return self._pack(topic.CLOCK_SIGNAL.id, seconds, nanoseconds, wall_ns)

    def fast(self, signals: Mapping[str, list[float]]) -> list[TopicPayload]:
        """Return the payloads of the other fast topics."""
        state = signals["state"]
        w, x, y, z = _unit(state[0:4])
        p, w_WB, v = state[4:7], state[7:10], state[10:13]
        acceleration, thrusts = signals["acceleration"], signals["thrusts"]
        force_x, force_y, force_z, *torque = (self._wrench @ thrusts).tolist()
        v_x, v_y, v_z, yaw_rate = signals["reference"][:4]
        angles = _angles((w, x, y, z))
        force = into_world(rotation((w, x, y, z)), (force_x, force_y, force_z))
        way = [here - begin for here, begin in zip(p, self.start, strict=True)]
        return [
            self._pack(topic.POSITION_SIGNAL.id, *p, *angles, *way),
            self._pack(topic.VELOCITY_SIGNAL.id, *v, *w_WB),
            self._pack(topic.ACCELERATION_SIGNAL.id, *acceleration[3:6], *acceleration[0:3]),
            self._pack(topic.FORCE_TORQUE_SIGNAL.id, *force, *torque),
            self._pack(topic.COMMAND_SIGNAL.id, 0, topic.ALL_COMMAND_AXES, v_x, v_y, v_z, yaw_rate),
            self._pack(topic.ROTORS_SIGNAL.id, *signals["speeds"], *thrusts),
            *self._estimate(signals),
            *self._joints(signals),
            *(
                self._pack(row.id, *signals[row.name])
                for row in (topic.CONTACT_FORCES_SIGNAL, topic.TENSIONS_SIGNAL)
                if row.name in signals
            ),
        ]

    def _joints(self, signals: Mapping[str, list[float]]) -> list[TopicPayload]:
        """Return the payloads of positions and velocities of joints, and of setpoints of servos."""
        moving, setpoints = signals.get("joints"), signals.get("joint_setpoints")
        found = []
        if moving and self._joint_places:
            values = [moving[place] for place in self._joint_places]
            found.append(self._pack(topic.JOINT_STATES_SIGNAL.id, *values))
        if setpoints:
            values = [math.nan] * self._setpoint_count
            for place, setpoint in zip(self._setpoint_places, setpoints, strict=True):
                values[place] = setpoint
            found.append(self._pack(topic.JOINT_SETPOINTS_SIGNAL.id, *values))
        return found

    def _estimate(self, signals: Mapping[str, list[float]]) -> list[TopicPayload]:
        """Return the payload of the estimated motion, where there is an estimator."""
        if "estimate" not in signals:
            return []
        known, deviations = signals["estimate"], signals["deviations"]
        angles = _angles(_unit(known[0:4]))
        attitude, p, v = deviations[0:3], deviations[3:6], deviations[6:9]
        motion = (*known[4:7], *angles, *known[10:13], *known[7:10])
        return [self._pack(topic.ESTIMATE_SIGNAL.id, *motion, *p, *attitude, *v)]

    def slow(self, signals: Mapping[str, list[float]]) -> list[TopicPayload]:
        """Return the payloads of slow topics."""
        mode = FlightMode(int(signals["mode"][0]))
        charge = signals["charge"][0]
        clearance = signals["obstacle"][0] if "obstacle" in signals else math.inf
        return [
            self._pack(
                topic.DRONE_STATE_SIGNAL.id, int(mode), mode.label.encode(), charge, clearance
            ),
            self._pack(topic.ON_OFF_SIGNAL.id, int(mode is not FlightMode.OFF)),
            self._pack(topic.WIND_SIGNAL.id, *signals["wind"]),
        ]

    def battery(self, charge: float, terminals: SignalNumbers) -> TopicPayload:
        """Return the payload of the battery: charge, 0 .. 1, and voltage [V] and current [A]."""
        voltage, current = terminals
        return self._pack(topic.BATTERY_SIGNAL.id, voltage, current, charge, self._capacity)

    def measured(self, kind: str, measurement: np.ndarray) -> list[TopicPayload]:
        """Return the payloads of a sensor's sample, stamp [s] and values."""
        stamp, *numbers = measurement.tolist()
        if self._pattern is not None and kind == Lidar.kind:
            directions_S = self._pattern.directions_S
            return self._scan(stamp, measurement[1 : 1 + len(directions_S)], directions_S)
        return [self._pack(self._measured[kind], _ns(stamp), *numbers)]

    def _scan(
        self, stamp: float, ranges: np.ndarray, directions_S: np.ndarray
    ) -> list[TopicPayload]:
        """Return the payloads of a scan: ranges (R) [m], unit vectors of the rays in S (R, 3)."""
        seen = np.isfinite(ranges)
        nearest, direction = math.inf, [0.0, 0.0, 0.0]
        if seen.any():
            index = int(np.argmin(np.where(seen, ranges, np.inf)))
            nearest, direction = float(ranges[index]), directions_S[index].tolist()
        cloud = self._topics[topic.LIDAR_CLOUD_SIGNAL.id].packer
        return [
            self._pack(
                topic.LIDAR_SIGNAL.id, _ns(stamp), int(seen.sum()), len(ranges), nearest, *direction
            ),
            (topic.LIDAR_CLOUD_SIGNAL.id, cloud.pack(_ns(stamp), *ranges[self._sent].tolist())),
        ]

    def pictures(self, image: DepthImage) -> list[TopicPayload]:
        """Return the payloads of a camera's pictures, of every n-th pixel of every n-th row."""
        n = picture_stride(image.pinhole.width, image.pinhole.height)
        depth_mm = np.nan_to_num(np.rint(1e3 * image.depth[::n, ::n]), posinf=0.0, neginf=0.0)
        depth_mm[depth_mm > MAX_DEPTH_MM] = 0.0
        pixels = {DEPTH_IMAGE_SIGNAL.id: depth_mm.astype("<u2")}
        if image.colour is not None:
            pixels[COLOUR_IMAGE_SIGNAL.id] = image.colour[::n, ::n]
        stamp = _ns(image.stamp).to_bytes(STAMP_BYTES, "little")
        return [
            (number, (stamp + array.tobytes()).ljust(self._topics[number].packer.size, b"\0"))
            for number, array in pixels.items()
        ]

    def frames(self, poses: Sequence[tuple[SignalNumbers, SignalNumbers]]) -> list[TopicPayload]:
        """Return the payload of all frames: position and quaternion of each."""
        return [self._pack(topic.FRAMES_SIGNAL.id, *(n for p, q in poses for n in (*p, *q)))]

    def _pack(self, number: int, *values: object) -> TopicPayload:
        packer = self._topics[number].packer
        try:
            return number, packer.pack(*values)
        except OverflowError:  # a diverging flight stays visible
            return number, packer.pack(*map(_in_range, values))


def _in_range(value: object) -> object:
    """Return a number that fits into 32 bits, infinity if it is too large."""
    if isinstance(value, float) and abs(value) > FLOAT32_LIMIT:
        return math.copysign(math.inf, value)
    return value


def _ns(seconds: float) -> int:
    return round(seconds * SECOND_NS)


def _unit(q: SignalNumbers) -> tuple[float, float, float, float]:
    w, x, y, z = q
    length = math.sqrt(w * w + x * x + y * y + z * z)
    return w / length, x / length, y / length, z / length


def _angles(q: SignalNumbers) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a unit quaternion [rad]."""
    w, x, y, z = q
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x)))),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


SAME_TIME_TOLERANCE_S = 1e-9
"""Between times that are one but for their rounding [s], as 60 times 5 ms and 3 times 0.1 s."""


class Telemetry(DiscreteSystem):
    """Publishes topics. It reads signals that exist anyway, and nothing depends on it.

    Input ports:
        signals (n): stacked as the recorder has them.
        frames: a `FrameTransforms`.
        battery (2): voltage under load [V] and current [A]; not connected if unknown.
        the kind of each published sensor: stamp [s] and values delivered last.
        depth_camera: the `DepthImage` delivered last, if a camera's pictures are published.
    """

    def __init__(
        self,
        bridge: Bridge,
        values: TopicValues,
        places: Mapping[str, slice],
        *,
        period: float,
        quick: Mapping[str, float] | None = None,
        sizes: dict[str, int],
        picture_period: float | None = None,
    ) -> None:
        """Declare the event.

        Args:
            bridge: where samples wait.
            values: makes the payloads.
            places: of the signals in their stack.
            period: between samples [s].
            quick: periods of sensors that sample more often [s], by their kind; they are published
                at their own updates, which end steps of the integrator.
            sizes: of the input ports of the sensors, by their kind.
            picture_period: between published pictures [s], None without a camera.
        """
        super().__init__()
        self._bridge, self._values, self._places = bridge, values, places
        self._period, self._quick = period, dict(quick or {})
        size = max(place.stop for place in places.values())
        self._signals = self.DeclareVectorInputPort("signals", size)
        self._frames = self.DeclareAbstractInputPort(
            "frames", AbstractValue.Make(FrameTransforms(0.0, ()))
        )
        self._battery = self.DeclareVectorInputPort("battery", len(UNKNOWN_TERMINALS))
        self._sensors = {
            kind: self.DeclareVectorInputPort(kind, size) for kind, size in sizes.items()
        }
        self._picture_period = picture_period
        self._camera = None
        if picture_period is not None:
            of_any_object = AbstractValue.Make(())
            self._camera = self.DeclareAbstractInputPort(DepthCamera.kind, of_any_object)
        self._stamps = dict.fromkeys((*sizes, DepthCamera.kind), math.nan)
        self._last = -math.inf
        self.DeclarePeriodicPublishEvent(period, 0.0, self._publish)
        if self._quick:
            self.DeclarePerStepPublishEvent(self._publish_sensors)

    def begin(self, start: Sequence[float]) -> None:
        """Begin with a new flight at a place in W [m]."""
        self._values.start = start
        self._stamps = dict.fromkeys(self._stamps, math.nan)
        self._last = -math.inf

    def continue_from(self, before: "Telemetry") -> None:
        """Go on with the flight of another one, whose sensors have published what they measured."""
        self.begin(before._values.start)
        self._stamps.update(before._stamps)

    def _publish(self, context: Context) -> None:
        now = context.get_time()
        # a change of integrator publishes the present again
        if not self._bridge.wanted or now <= self._last:
            return
        self._last = now
        t_ns = round(now * SECOND_NS)
        stacked = self._signals.Eval(context).tolist()
        signals = {name: stacked[place] for name, place in self._places.items()}
        payloads = list(self._values.fast(signals))
        if round(now / self._period) % SLOW_TOPIC_DIVIDER == 0:
            payloads += self._values.slow(signals)
            known = self._battery.HasValue(context)
            terminals = self._battery.Eval(context).tolist() if known else UNKNOWN_TERMINALS
            payloads.append(self._values.battery(signals["charge"][0], terminals))
            transforms = self._frames.Eval(context).transforms
            if transforms:
                payloads += self._values.frames([(each.p, each.q) for each in transforms])
        for kind in self._sensors:
            if kind not in self._quick or _is_due(now, self._quick[kind]):
                payloads += self._measured(context, kind)
        payloads += self._pictures(context)
        self._send(t_ns, payloads, signals["state"])

    def _publish_sensors(self, context: Context) -> None:
        """Publish new measurements of quick sensors alone, unless a sample is due."""
        now = context.get_time()
        if (
            not self._bridge.wanted
            or now <= self._last + SAME_TIME_TOLERANCE_S
            or _is_due(now, self._period)
        ):
            return
        due = [kind for kind, period in self._quick.items() if _is_due(now, period)]
        payloads = [each for kind in due for each in self._measured(context, kind)]
        if payloads:
            self._last = now
            state = self._signals.Eval(context)[self._places["state"]]
            self._send(round(now * SECOND_NS), payloads, state.tolist())

    def _send(self, t_ns: int, payloads: Sequence[TopicPayload], state: SignalNumbers) -> None:
        wall_ns = time.time_ns()
        clocks = self._values.clocks(t_ns, wall_ns)
        self._bridge.publish(Sampled(Published(t_ns, wall_ns, (clocks, *payloads)), tuple(state)))

    def _measured(self, context: Context, kind: str) -> list[TopicPayload]:
        """Return the payloads of a sensor's new sample, none without one."""
        measurement = self._sensors[kind].Eval(context)
        stamp = float(measurement[0])
        if math.isnan(stamp) or stamp == self._stamps[kind]:
            return []
        self._stamps[kind] = stamp
        return self._values.measured(kind, measurement)

    def _pictures(self, context: Context) -> list[TopicPayload]:
        """Return the payloads of the camera's newest pictures, none before the next are due."""
        if self._camera is None or self._picture_period is None:
            return []
        image: DepthImage = self._camera.Eval(context)
        since = image.stamp - self._stamps[DepthCamera.kind]
        too_soon = 0.0 <= since < self._picture_period - SAME_TIME_TOLERANCE_S
        if math.isnan(image.stamp) or too_soon:
            return []
        self._stamps[DepthCamera.kind] = image.stamp
        return self._values.pictures(image)


def _is_due(now: float, period: float) -> bool:
    """Return whether a time is a multiple of a period [s]."""
    count = now / period
    return abs(count - round(count)) < 1e-6
