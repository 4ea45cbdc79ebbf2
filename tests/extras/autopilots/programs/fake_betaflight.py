"""A stand-in for Betaflight's SITL that speaks its ports, written from their description.

It knows nothing of the workbench: settings and MSP on TCP 5761, motion on UDP 9003, sticks on 9004,
motors to 9001. In place of the firmware's law it has P on angles and rates. FAKE_LOSES makes it
leave out each so manieth answer, and FAKE_DIES end at so many packets of motion once it is armed.
"""

import math
import os
import socket
import struct
import sys
import threading
from pathlib import Path

REVERSED = Path("reversed")
LOSES = int(os.environ.get("FAKE_LOSES", "0"))
DIES = int(os.environ.get("FAKE_DIES", "0"))
pid, advanced, filters = bytearray(15), bytearray(61), bytearray(49)
pid[:9] = bytes([45, 80, 30, 47, 84, 34, 45, 80, 0])
state = {"channels": (1500,) * 4 + (1000,) * 12, "armed": False}
tables = {112: pid, 94: advanced, 92: filters}


def answer(command, payload):
    for read, write in ((112, 202), (94, 95), (92, 93)):
        if command == read:
            return bytes(tables[read])
        if command == write:
            tables[read][:] = payload
            return b""
    if command == 101:
        state["armed"] = state["channels"][4] > 1700
        flags = struct.pack("<I", 1 if state["armed"] else 0)
        return struct.pack("<HHH", 1000, 0, 35) + flags + bytes(5) + b"\0" + b"\x1d" + bytes(8)
    return None


def console(client):
    kept, line = b"", ""
    shell = False
    while data := client.recv(4096):
        kept += data
        while kept:
            if kept[:2] == b"$M":
                if len(kept) < 6 or len(kept) < kept[3] + 6:
                    break
                size, command = kept[3], kept[4]
                found = answer(command, kept[5 : 5 + size])
                kept = kept[size + 6 :]
                body = bytes([len(found or b""), command]) + (found or b"")
                check = 0
                for byte in body:
                    check ^= byte
                sign = b"$M>" if found is not None else b"$M!"
                client.sendall(sign + body + bytes([check]))
                continue
            sent, kept = chr(kept[0]), kept[1:]
            if sent == "#" and not shell:
                shell = True
                client.sendall(b"Entering CLI Mode\r\n# ")
            elif sent == "\n":
                if line == "save":
                    os._exit(0)
                if line == "set yaw_motors_reversed = ON":
                    REVERSED.touch()
                bad = b"###ERROR: INVALID NAME###\r\n" if "nonsense" in line else b"\r\n"
                client.sendall(bad + b"# ")
                line = ""
            else:
                line += sent


def serve():
    server = socket.create_server(("127.0.0.1", 5761), reuse_port=False)
    while True:
        client, _ = server.accept()
        threading.Thread(target=console, args=(client,), daemon=True).start()


def listen():
    sticks = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sticks.bind(("0.0.0.0", 9004))
    while True:
        state["channels"] = struct.unpack("<d16H", sticks.recv(100))[1:]
        state["armed"] = state["channels"][4] > 1700


def fly():
    motion = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    motion.bind(("0.0.0.0", 9003))
    count, armed, out = 0, 0, socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    while True:
        numbers = struct.unpack("<18d", motion.recv(200))
        count, armed = count + 1, armed + state["armed"]
        if DIES and armed >= DIES:
            os._exit(3)
        if LOSES and count % LOSES == 0:
            continue
        p, q, r = numbers[1], -numbers[2], -numbers[3]
        w, x, y, z = numbers[7], numbers[8], -numbers[9], -numbers[10]  # FLU
        roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
        roll_d, pitch_d, throttle, turn, *_ = (s - 1500 for s in state["channels"])
        full = math.radians(60) / 500
        e = 5 * (full * roll_d - roll) - p, 5 * (full * pitch_d - pitch) - q
        a, b, c = 0.05 * e[0], 0.05 * e[1], 0.1 * (-math.radians(670) / 500 * turn - r)
        t = max(0.0, (throttle + 450) / 950)
        c = -c if REVERSED.exists() else c
        mixed = (t - a + b + c, t - a - b - c, t + a + b - c, t + a - b + c)
        pwm = [1055 + 945 * min(max(u, 0.0), 1.0) if state["armed"] else 1000.0 for u in mixed]
        out.sendto(struct.pack("<Hxx16f", 4, *pwm, *[0.0] * 12), ("127.0.0.1", 9001))


if __name__ == "__main__":
    print("fake Betaflight", flush=True)
    for work in (serve, listen, fly):
        threading.Thread(target=work, daemon=True).start()
    threading.Event().wait()
    sys.exit(0)
