"""A client of the link by sockets alone, for link_age.py: it prints what it saw as JSON.

`python benchmarks/link_client.py HOST PORT SECONDS FRAMES_A_SECOND [TOPICS]`; 0 frames a second for
all that come, less than 0 to stop reading; the first TOPICS of eight. It acknowledges as
docs/protocol.md asks.
"""

import contextlib
import json
import os
import socket
import struct
import sys
import time

HEADER = struct.Struct("<2sBBHHIIq")
STAMP = struct.Struct("<iIq")
CONTROL, DATA, ACKNOWLEDGEMENT = 0, 1, 2
ACKNOWLEDGE = 2
TIME = 1
LONGEST_WAIT = 30.0
WARM_UP = 2.0
"""Gaps count from then on: until then other clients are started beside [s]."""
TOPICS = (
    "time_data",
    "position_data",
    "velocity_data",
    "acceleration_data",
    "force_torque_data",
    "rotors",
    "command_velocity",
    "imu",
)


class Watcher:
    """Reads frames, and keeps how old they were and where some were missing."""

    def __init__(self, host: str, port: int) -> None:
        # a server takes 32 connections from one address at most
        source = (f"127.0.0.{2 + os.getpid() % 4}", 0) if host == "127.0.0.1" else None
        self._socket = socket.create_connection((host, port), source_address=source)
        self._socket.settimeout(LONGEST_WAIT)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._buffer = b""
        self._begun = time.monotonic()
        self._seq = 0
        self.ages: list[float] = []
        self.times: dict[int, list[int]] = {}
        self.frames = 0
        self.ended = ""

    def subscribe(self, count: int = len(TOPICS)) -> None:
        """Ask for so many topics."""
        names = [f"/dh_drone/{name}" for name in TOPICS[:count]]
        self.send(CONTROL, json.dumps({"op": "subscribe", "topics": names}).encode())

    def send(self, kind: int, payload: bytes = b"", seq: int | None = None) -> None:
        """Send a frame."""
        self._seq += 1
        number = self._seq if seq is None else seq
        self._socket.sendall(HEADER.pack(b"DH", 1, kind, 0, 0, number, len(payload), 0) + payload)

    def read(self) -> None:
        """Wait for bytes and take the frames in them."""
        data = self._socket.recv(65536)
        if not data:
            raise ConnectionResetError("the server has closed the connection")
        self._buffer += data
        begin = 0
        while len(self._buffer) - begin >= HEADER.size:
            _, _, kind, topic, flags, seq, length, t_ns = HEADER.unpack_from(self._buffer, begin)
            end = begin + HEADER.size + length
            if len(self._buffer) < end:
                break
            self._take(kind, topic, t_ns, self._buffer[begin + HEADER.size : end])
            if flags & ACKNOWLEDGE:
                with contextlib.suppress(OSError):  # what was sent before the end is read still
                    self.send(ACKNOWLEDGEMENT, seq=seq)
            begin = end
        self._buffer = self._buffer[begin:]

    def read_one(self) -> None:
        """Wait for one frame and take it."""
        _, _, kind, topic, flags, seq, length, t_ns = HEADER.unpack(self._whole(HEADER.size))
        self._take(kind, topic, t_ns, self._whole(length))
        if flags & ACKNOWLEDGE:
            self.send(ACKNOWLEDGEMENT, seq=seq)

    def _whole(self, size: int) -> bytes:
        data = self._socket.recv(size, socket.MSG_WAITALL) if size else b""
        if len(data) < size:
            raise ConnectionResetError("the server has closed the connection")
        return data

    def _take(self, kind: int, topic: int, t_ns: int, payload: bytes) -> None:
        if kind == DATA:
            self.frames += 1
            if time.monotonic() - self._begun > WARM_UP:
                self.times.setdefault(topic, []).append(t_ns)
            if topic == TIME:
                self.ages.append(1e-9 * (time.time_ns() - STAMP.unpack(payload)[2]))
        elif kind == CONTROL:
            said = json.loads(payload)
            if said["op"] in ("error", "bye"):
                self.ended = said.get("code", said["op"])

    def gaps(self) -> int:
        """Return how many samples were missing: steps in time over half a period too long."""
        missing = 0
        for times in self.times.values():
            steps = [after - before for before, after in zip(times, times[1:], strict=False)]
            period = min(steps, default=1)
            missing += sum(round(step / period) - 1 for step in steps)
        return missing


def main() -> None:
    """Watch, and print what was seen."""
    host, port, seconds, pace = sys.argv[1], int(sys.argv[2]), *map(float, sys.argv[3:5])
    watcher = Watcher(host, port)
    watcher.subscribe(*map(int, sys.argv[5:]))
    begun = time.monotonic()
    end = begun + seconds
    try:
        while time.monotonic() < end:
            if pace < 0.0:
                time.sleep(0.1)
                if time.monotonic() - begun > 8.0:  # to see why it was thrown out
                    watcher.read()
            elif pace > 0.0:
                watcher.read_one()
                time.sleep(1.0 / pace)
            else:
                watcher.read()
    except OSError:
        watcher.ended = watcher.ended or "closed"
    lasted = time.monotonic() - begun
    print(
        json.dumps(
            {
                "ages": watcher.ages,
                "gaps": watcher.gaps(),
                "frames": watcher.frames,
                "ended": watcher.ended,
                "lasted": lasted,
            }
        )
    )


if __name__ == "__main__":
    main()
