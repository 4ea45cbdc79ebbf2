"""MSP, the protocol of Betaflight's console: requests, answers, and where gains are in them."""

import socket
import struct
from collections.abc import Iterator, Mapping

ARMED_FLAG_BIT = 1
"""Bit of the mode flags for an armed state."""
MSP_PID = 112
MSP_SET_PID = 202
MSP_PID_ADVANCED = 94
MSP_SET_PID_ADVANCED = 95
MSP_FILTER_CONFIG = 92
MSP_SET_FILTER_CONFIG = 93
MSP_STATUS = 101
"""Commands of MSP, the protocol by which Betaflight is configured."""
MSP_SETTER_BY_GETTER = {
    MSP_PID: MSP_SET_PID,
    MSP_PID_ADVANCED: MSP_SET_PID_ADVANCED,
    MSP_FILTER_CONFIG: MSP_SET_FILTER_CONFIG,
}
MSP_GAIN_LOCATIONS = {
    f"{name}_{axis}": (MSP_PID, "B", 3 * row + column)
    for row, axis in enumerate(("roll", "pitch", "yaw"))
    for column, name in enumerate("pid")
} | {
    "angle_p_gain": (MSP_PID, "B", 9),
    "angle_limit": (MSP_PID_ADVANCED, "B", 17),
    "anti_gravity_gain": (MSP_PID_ADVANCED, "<H", 21),
    "throttle_boost": (MSP_PID_ADVANCED, "B", 30),
    "f_roll": (MSP_PID_ADVANCED, "<H", 32),
    "f_pitch": (MSP_PID_ADVANCED, "<H", 34),
    "f_yaw": (MSP_PID_ADVANCED, "<H", 36),
    "d_max_roll": (MSP_PID_ADVANCED, "B", 39),
    "d_max_pitch": (MSP_PID_ADVANCED, "B", 40),
    "d_max_yaw": (MSP_PID_ADVANCED, "B", 41),
    "d_max_gain": (MSP_PID_ADVANCED, "B", 42),
    "d_max_advance": (MSP_PID_ADVANCED, "B", 43),
    "iterm_relax_cutoff": (MSP_PID_ADVANCED, "B", 46),
    "thrust_linear": (MSP_PID_ADVANCED, "B", 56),
    "tpa_rate": (MSP_PID_ADVANCED, "B", 58),
    "tpa_breakpoint": (MSP_PID_ADVANCED, "<H", 59),
    "yaw_lowpass_hz": (MSP_FILTER_CONFIG, "<H", 3),
    "gyro_lpf2_static_hz": (MSP_FILTER_CONFIG, "<H", 22),
    "dterm_lpf2_static_hz": (MSP_FILTER_CONFIG, "<H", 26),
    "gyro_lpf1_dyn_min_hz": (MSP_FILTER_CONFIG, "<H", 29),
    "gyro_lpf1_dyn_max_hz": (MSP_FILTER_CONFIG, "<H", 31),
    "dterm_lpf1_dyn_min_hz": (MSP_FILTER_CONFIG, "<H", 33),
    "dterm_lpf1_dyn_max_hz": (MSP_FILTER_CONFIG, "<H", 35),
}
"""Location of each gain in an MSP answer: the command, its size, and its index."""
ARMING_BLOCK_REASONS = {
    0: "no gyro",
    1: "failsafe",
    2: "no receiver",
    3: "bad receiver",
    4: "box failsafe",
    5: "runaway take-off",
    6: "crash",
    7: "throttle not low",
    8: "angle",
    9: "boot grace time",
    10: "no prearm",
    11: "load",
    12: "calibrating",
    13: "command line",
    23: "accelerometer not calibrated",
    28: "arm switch on at start",
}
"""Reasons why it does not arm, by bit of its arming flags."""


def payload_with_gains(command: int, payload: bytes, values: Mapping[str, float]) -> bytes:
    """Return the payload of a command with gains by name, rounded to whole numbers."""
    changed = bytearray(payload)
    for name, value in values.items():
        place = MSP_GAIN_LOCATIONS[name]
        if place[0] == command:
            struct.pack_into(place[1], changed, place[2], round(value))
    return bytes(changed)


def gains_in(answers: Mapping[int, bytes]) -> dict[str, int]:
    """Return the gains in answers, which are by command."""
    return {
        name: struct.unpack_from(size, answers[command], place)[0]
        for name, (command, size, place) in MSP_GAIN_LOCATIONS.items()
    }


def arming_status(answer: bytes) -> tuple[bool, int]:
    """Return whether it is armed, and its arming flags, from the answer to `MSP_STATUS`."""
    (flags,) = struct.unpack_from("<I", answer, 17 + (answer[15] & 15))
    return bool(struct.unpack_from("<I", answer, 6)[0] & ARMED_FLAG_BIT), flags


def arming_block_reason(flags: int) -> str:
    """Return the reasons why it does not arm, from its arming flags."""
    found = [ARMING_BLOCK_REASONS.get(bit, f"bit {bit}") for bit in range(32) if flags >> bit & 1]
    return ", ".join(found) or "it gives no reason"


def received_bytes(console: socket.socket) -> bytes:
    """Return bytes that the console sends."""
    found = console.recv(4096)
    if not found:
        raise ConnectionError("it closed it")
    return found


def msp_request(command: int, payload: bytes = b"") -> bytes:
    """Return a request of MSP version 1: `$M<`, size, command, payload, checksum.

    The checksum is the exclusive or of the three before it. Source: Betaflight 4.6, src/main/msp.
    """
    body = bytes([len(payload), command]) + payload
    return b"$M<" + body + bytes([_checksum(body)])


def take_msp_answers(kept: bytearray) -> Iterator[tuple[int, bytes | None]]:
    """Yield each complete answer in received bytes: its command, and its payload, None if refused.

    Answers have the form of requests, but begin with `$M>`, and with `$M!` where the command is
    refused. Other bytes, and answers with a wrong checksum, are left out.

    Args:
        kept: what was received; the beginning of the next answer is left in it.
    """
    while True:
        start = kept.find(b"$M")
        if start < 0:
            del kept[:-1]  # a $ may begin one
            return
        del kept[:start]
        if len(kept) < 6:
            return
        size = kept[3]
        if len(kept) < size + 6:
            return
        body, check = bytes(kept[3 : size + 5]), kept[size + 5]
        kind = chr(kept[2])
        if kind not in ">!" or _checksum(body) != check:
            del kept[:2]
            continue
        refused = kind == "!"
        del kept[: size + 6]
        yield body[1], None if refused else body[2:]


def _checksum(body: bytes) -> int:
    check = 0
    for byte in body:
        check ^= byte
    return check
