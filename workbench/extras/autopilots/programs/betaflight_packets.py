"""Packets of Betaflight's SITL, and its ports.

UDP 9003  to it     time, rates p q r [rad/s] (FRD), minus the specific force [m/s²] (FLU),
                    attitude w x y z (FRD in NED), velocity, place, pressure
UDP 9004  to it     time, 16 channels of the receiver [us]
UDP 9001  from it   its motors M1 .. M16 [us], once for each packet of motion
TCP 5761  both      MSP and the command line
"""

import contextlib
import math
import socket
import struct
import time
from collections.abc import Sequence
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.extras.autopilots.programs.motion import attitude_ned, to_frd

BETAFLIGHT_HOST = "127.0.0.1"
MOTORS_PORT = 9001
STATE_PORT = 9003
RECEIVER_PORT = 9004
CONSOLE_PORT = 5761
"""Ports, see above."""
MOTION_FORMAT, CHANNELS_FORMAT, MOTORS_PACKET_BYTES = (
    struct.Struct("<d3d3d4d3d3dd"),
    struct.Struct("<d16H"),
    68,
)
"""Formats of packets, and size of that of the motors."""
MIN_CHANNEL_US, MAX_CHANNEL_US = 1000.0, 2000.0
"""Limits of a channel, and of a motor [us]."""
SITL_REPLY_TIMEOUT_S = 0.05
"""Time limit for the answer to a packet of motion; then the motors are held [s]."""
TIME_RESET_GAP_S = 0.4
"""Time without a packet after which the next one only sets the time of the firmware [s]; there it
is 0.5."""
PORT_RELEASE_TIMEOUT_S = 1.0
"""Time limit for an ending program to release its ports [s]."""


@dataclass(frozen=True)
class ReceiverChannels:
    """Channels of a receiver: roll right, pitch nose down, yaw right and throttle up [us].

    Also states whether roll and pitch are angles or rates.
    """

    roll: float = 1500.0
    pitch: float = 1500.0
    throttle: float = MIN_CHANNEL_US
    yaw: float = 1500.0
    angle: bool = True


def motion_packet(
    rates: Sequence[float], force: Sequence[float], attitude: Sequence[float]
) -> bytes:
    """Return a packet of motion.

    Args:
        rates: about forward, left, up (3) [rad/s].
        force: specific force along these (3) [m/s²].
        attitude: of forward, left, up in east, north, up (4), w x y z.
    """
    numbers = (*to_frd(rates), *(-each for each in force), *attitude_ned(attitude))
    return MOTION_FORMAT.pack(0.0, *numbers, *(0.0,) * 6, 101325.0)


def channels_packet(sticks: ReceiverChannels, switch: float) -> bytes:
    """Return a packet of the receiver's channels.

    Args:
        sticks: its first channels.
        switch: channel that arms [us].
    """
    mode, low = MAX_CHANNEL_US if sticks.angle else MIN_CHANNEL_US, (MIN_CHANNEL_US,) * 10
    numbers = (sticks.roll, sticks.pitch, sticks.throttle, sticks.yaw, switch, mode, *low)
    channels = (round(min(max(x, MIN_CHANNEL_US), MAX_CHANNEL_US)) for x in numbers)
    return CHANNELS_FORMAT.pack(0.0, *channels)


def motors_in(packet: bytes) -> tuple[float, ...]:
    """Return the outputs M1 .. M4 in a packet of motors, 0 .. 1; () if one is not finite."""
    found = struct.unpack_from("<4f", packet, 4)
    if not all(map(math.isfinite, found)):
        return ()
    return tuple(
        min(max((x - MIN_CHANNEL_US) / (MAX_CHANNEL_US - MIN_CHANNEL_US), 0.0), 1.0) for x in found
    )


LEVEL_MOTION_PACKET = motion_packet((0.0, 0.0, 0.0), (0.0, 0.0, 9.80665), (1.0, 0.0, 0.0, 0.0))


def check_ports(output: socket.socket) -> None:
    """Bind the socket of the motors, once no other program has the firmware's ports.

    Raises:
        WorkbenchError: with a port that stays taken.
    """
    end = time.monotonic() + PORT_RELEASE_TIMEOUT_S
    while taken := _taken_port(output):
        if time.monotonic() > end:
            raise WorkbenchError(
                f"{taken} is in use: another Betaflight SITL, or a flight with one, still runs: "
                "end it, or close that flight"
            )
        time.sleep(0.05)


def _taken_port(output: socket.socket) -> str:
    """Bind the socket of the motors if all ports are free; else return one that is not."""
    for port in (STATE_PORT, RECEIVER_PORT):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("0.0.0.0", port))
            except OSError:
                return f"UDP port {port}"
    with contextlib.suppress(OSError):
        socket.create_connection((BETAFLIGHT_HOST, CONSOLE_PORT), 1.0).close()
        return f"TCP port {CONSOLE_PORT}"
    try:
        output.bind((BETAFLIGHT_HOST, MOTORS_PORT))
    except OSError:
        return f"UDP port {MOTORS_PORT}"
    return ""
