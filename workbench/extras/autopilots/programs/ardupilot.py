"""ArduPilot over its JSON interface, in lockstep: it sends requests by UDP, and we answer.

The answer to a packet of servo outputs is one line of JSON. Its frame count is the clock: the next
count is one step, an equal one repeats the request, and a restarted count means a restart. Source:
ArduPilot, libraries/SITL/SIM_JSON.cpp and examples/JSON/readme.md.
"""

import json
import os
import select
import socket
import struct
import time

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.extras.autopilots.programs.motion import AutopilotMotion, RestartedError

PACKET_FORMATS = {18458: struct.Struct("<HHI16H"), 29569: struct.Struct("<HHI32H")}
"""Formats of packets by magic number: that number, frame rate, frame count, and pulses [us]."""
MAX_PACKET_BYTES = 4096
"""Largest number of bytes read of a packet."""
MIN_ARMED_PULSE_US = 1
"""Pulse above the smallest one from which on a motor turns [us]."""


class ArduPilot:
    """The workbench side of the connection to ArduPilot, see `motion.Autopilot`.

    Args:
        host: to listen at.
        port: to listen at.
        patience: time without a packet after which the flight ends [s].
        pulses: of a motor at rest, and at full speed [us].

    Raises:
        WorkbenchError: if the port is taken.
    """

    name = "ArduPilot"
    locked = True

    def __init__(self, host: str, port: int, patience: float, pulses: tuple[float, float]) -> None:
        self._patience, self._pulses = patience, pulses
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise WorkbenchError(
                f"cannot listen at {host}:{port}: {os.strerror(error.errno or 0)}; "
                "end the program that uses that port, or give another port, as --port 9012"
            ) from None
        self.armed = False
        self._asked: tuple[tuple[str, int], int, tuple[int, ...]] | None = None
        self._answer = b""
        self._last = -1
        self._count = self._resent = 0

    @property
    def address(self) -> tuple[str, int]:
        """The address that it listens at."""
        host, port = self._socket.getsockname()[:2]
        return host, port

    def connect(self) -> None:
        """Wait for the autopilot."""
        while self._asked is None:
            if select.select([self._socket], [], [], 0.1)[0]:
                self._read()

    def exchange(self, motion: AutopilotMotion) -> tuple[float, ...]:
        """Answer the waiting packet; return the outputs of the next one, 0 .. 1.

        Raises:
            RestartedError: if its count has restarted; the next call answers it.
        """
        if self._asked is None:
            raise WorkbenchError("ArduPilot is not connected yet")
        self._answer = motion_line(motion)
        peer, self._last, _ = self._asked
        self._send(peer)
        self._asked = None
        end = time.monotonic() + self._patience
        while self._asked is None:
            left = end - time.monotonic()  # it may continue to request the same frame
            if left < 0.0 or not select.select([self._socket], [], [], left)[0]:
                raise FlightBrokenError(
                    f"ArduPilot has sent no new packet for {self._patience:g} s at "
                    f"{motion.time:.3f} s: see its console, and start both again"
                )
            self._read()
        self._count += 1
        _, count, pulses = self._asked
        if count < self._last:
            self._last, self.armed = -1, False
            raise RestartedError
        if count != self._last + 1:
            raise FlightBrokenError(
                f"ArduPilot's frame count went from {self._last} to {count} at "
                f"{motion.time:.3f} s: it is not in lockstep; start both again"
            )
        least, most = self._pulses
        self.armed = any(pulse > least + MIN_ARMED_PULSE_US for pulse in pulses[:4])
        return tuple(min(max((pulse - least) / (most - least), 0.0), 1.0) for pulse in pulses)

    def report(self) -> dict[str, float]:
        """Return the numbers of packets answered, and of those answered again."""
        return {"packets": self._count, "resent": self._resent}

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()

    def _read(self) -> None:
        """Process a packet: repeat the answer for an equal count, and reject invalid packets."""
        data, peer = self._socket.recvfrom(MAX_PACKET_BYTES)
        magic = struct.unpack_from("<H", data)[0] if len(data) >= 2 else 0
        layout = PACKET_FORMATS.get(magic)
        if layout is None or len(data) != layout.size:
            raise FlightBrokenError(
                f"a packet of {len(data)} bytes from {peer[0]}:{peer[1]} is not one of ArduPilot's "
                "servo outputs: end the other program that sends to this port, or give another "
                "port with --port"
            )
        _, _, count, *pulses = layout.unpack(data)
        if count == self._last and self._answer:
            self._resent += 1
            self._send(peer)
            return
        self._asked = peer, count, tuple(pulses)

    def _send(self, peer: tuple[str, int]) -> None:
        try:
            self._socket.sendto(self._answer, peer)
        except OSError as error:
            raise FlightBrokenError(f"ArduPilot cannot be answered: {error.strerror}") from None


def motion_line(motion: AutopilotMotion) -> bytes:
    """Return the line of JSON with a motion for ArduPilot.

    ArduPilot searches it for the first text that matches a key. So there are no spaces after
    colons, and no key is part of an earlier one.
    """
    said = {
        "timestamp": motion.time,
        "imu": {"gyro": motion.gyro, "accel_body": motion.force},
        "position": motion.position,
        "quaternion": motion.attitude,
        "velocity": motion.velocity,
    }
    return b"\n" + json.dumps(said, separators=(",", ":"), allow_nan=False).encode() + b"\n"
