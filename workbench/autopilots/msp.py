"""MSP, the protocol by which Betaflight is configured, and its command line, over one TCP port.

MSP version 1: `$M<`, size, command, payload, and the exclusive or of the last three; answers begin
with `$M>`, and with `$M!` where the command is refused. Source: Betaflight 4.6, src/main/msp.
"""

from collections.abc import Iterator

PID, SET_PID = 112, 202
PID_ADVANCED, SET_PID_ADVANCED = 94, 95
FILTER_CONFIG, SET_FILTER_CONFIG = 92, 93
STATUS, ATTITUDE = 101, 108


def request(command: int, payload: bytes = b"") -> bytes:
    """Return a request."""
    body = bytes([len(payload), command]) + payload
    return b"$M<" + body + bytes([_checksum(body)])


class Answers:
    """Takes bytes as they come, and gives answers."""

    def __init__(self) -> None:
        self._kept = bytearray()

    def take(self, data: bytes) -> Iterator[tuple[int, bytes | None]]:
        """Yield each answer that is whole now: its command, and its payload, None if refused.

        What is no answer, or has a wrong checksum, is left out.
        """
        self._kept += data
        while True:
            start = self._kept.find(b"$M")
            if start < 0:
                del self._kept[:-1]  # a $ may begin one
                return
            del self._kept[:start]
            if len(self._kept) < 6:
                return
            size = self._kept[3]
            if len(self._kept) < size + 6:
                return
            body, check = bytes(self._kept[3 : size + 5]), self._kept[size + 5]
            kind = chr(self._kept[2])
            if kind not in ">!" or _checksum(body) != check:
                del self._kept[:2]
                continue
            refused = kind == "!"
            del self._kept[: size + 6]
            yield body[1], None if refused else body[2:]


def _checksum(body: bytes) -> int:
    check = 0
    for byte in body:
        check ^= byte
    return check
