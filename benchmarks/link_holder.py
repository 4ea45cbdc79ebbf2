"""A client that takes control and flies, by sockets alone, for link_faults.py to do harm to.

`python benchmarks/link_holder.py HOST PORT` prints a line as soon as it flies at about 1 m/s, then
does what a line on its standard input says: `silent` keeps the connection and commands no more,
`reset` drops it without a goodbye, `close` closes it, `release` gives control back, `ask` asks for
control again and prints the answer, `bad` sends commands that are not numbers. Every command
differs a little from the one before, so that a flight's script shows each.
"""

import json
import math
import select
import socket
import struct
import sys

HEADER = struct.Struct("<2sBBHHIIq")
COMMAND = struct.Struct("<IIffff")
CONTROL, DATA, ACKNOWLEDGEMENT = 0, 1, 2
ACKNOWLEDGE = 2
COMMAND_TOPIC = 8
ALL_AXES = 15
LEAST_FLOWN = 5
"""Commands that are sent before it says that it flies."""


class Holder:
    """A connection that holds the lease; it commands with each frame of data that comes."""

    def __init__(self, host: str, port: int) -> None:
        self._socket = socket.create_connection((host, port))
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._buffer = b""
        self._seq = 0
        self._t_ns = 0
        self._lease = 0
        self._sent = 0
        self._flies = True
        self._bad = False

    @property
    def connection(self) -> socket.socket:
        """Readable when something has come."""
        return self._socket

    def begin(self) -> None:
        """Subscribe; control is asked for with the first frame, which tells the time."""
        topics = ["/dh_drone/velocity_data"]
        self._say({"op": "subscribe", "topics": topics, "rate": 25})

    def do(self, word: str) -> bool:
        """Do what a line says; return whether to go on."""
        if word == "reset":
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        if word in ("reset", "close", ""):
            self._socket.close()
            return False
        if word == "ask":
            self._say({"op": "request_control", "id": 2})
        elif word == "release":
            self._say({"op": "release_control", "lease": self._lease})
        self._bad = word == "bad"
        self._flies = self._bad
        return True

    def read(self) -> None:
        """Take what has come.

        Raises:
            OSError: if the connection has ended.
        """
        data = self._socket.recv(65536)
        if not data:
            raise ConnectionResetError("the server has closed the connection")
        self._buffer += data
        while len(self._buffer) >= HEADER.size:
            _, _, kind, _, flags, seq, length, t_ns = HEADER.unpack_from(self._buffer)
            end = HEADER.size + length
            if len(self._buffer) < end:
                break
            payload, self._buffer = self._buffer[HEADER.size : end], self._buffer[end:]
            if kind == DATA:
                self._t_ns = t_ns
                self._command()
            elif kind == CONTROL:
                self._hear(json.loads(payload))
            if flags & ACKNOWLEDGE:
                self._socket.sendall(HEADER.pack(b"DH", 1, ACKNOWLEDGEMENT, 0, 0, seq, 0, 0))

    def _hear(self, said: dict) -> None:
        if said["op"] == "request_control" and not self._lease:
            self._lease = said["lease"]
            self._send_command(0.0, 0.0)  # a new holder begins from neutral
        elif said.get("code") == "neutral_first":
            self._send_command(0.0, 0.0)
        elif said.get("id") == 2:
            print(json.dumps(said), flush=True)

    def _command(self) -> None:
        if not self._lease:
            if not self._sent:
                self._sent = 1
                self._say({"op": "request_control", "id": 1, "name": "holder"})
            return
        if not self._flies:
            return
        self._sent += 1
        self._send_command(math.nan if self._bad else 1.0, 0.001 * (self._sent % 97))
        if self._sent == LEAST_FLOWN:
            print("flies", flush=True)

    def _send_command(self, v_x: float, v_y: float) -> None:
        payload = COMMAND.pack(self._lease, ALL_AXES, v_x, v_y, 0.0, 0.0)
        self._send(DATA, COMMAND_TOPIC, payload, self._t_ns)

    def _say(self, operation: dict) -> None:
        self._send(CONTROL, 0, json.dumps(operation).encode(), 0)

    def _send(self, kind: int, topic: int, payload: bytes, t_ns: int) -> None:
        self._seq += 1
        head = HEADER.pack(b"DH", 1, kind, topic, 0, self._seq, len(payload), t_ns)
        self._socket.sendall(head + payload)


def main() -> None:
    """Fly, until told something else."""
    holder = Holder(sys.argv[1], int(sys.argv[2]))
    holder.begin()
    while True:
        ready, _, _ = select.select([holder.connection, sys.stdin], [], [])
        if holder.connection in ready:
            holder.read()
        if sys.stdin in ready and not holder.do(sys.stdin.readline().strip()):
            return


if __name__ == "__main__":
    main()
