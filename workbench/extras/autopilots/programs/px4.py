"""PX4 over its MAVLink simulator API, in lockstep, with the workbench as the TCP server.

HIL_SENSOR with id 0 is PX4's clock; HIL_ACTUATOR_CONTROLS is its answer. Until the first answer,
sensors run freely by the clock of the machine; from then on each waits for exactly one. Source:
PX4-Autopilot, src/modules/simulation/simulator_mavlink.
"""

import math
import os
import select
import socket
import time
from importlib.util import find_spec
from typing import Any

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.extras.autopilots.programs.motion import AutopilotMotion

PX4_REPLY_TIMEOUT_S = 0.2
"""Time limit for the answer to a sensor; then outputs are held, and the answer is lost [s]."""
PX4_BOOT_TIMEOUT_S = 60.0
"""Time limit for its first answer [s]."""
HIL_ARMED_BIT = 128
HIL_LOCKSTEP_BIT = 1
"""Bits of mode and of flags."""
HIL_INERTIAL_FIELDS = 0x3F
HIL_MAGNETIC_FIELDS = 0x1C0
HIL_PRESSURE_FIELDS = 0x1A00
"""Fields of HIL_SENSOR: accelerometer and gyro, magnetometer, barometer with temperature."""
SLOW_SENSOR_DIVIDER = 5
GPS_MESSAGE_DIVIDER = 32
"""Number of sensor messages per one with magnetometer and barometer, and per satellite position."""


class Px4:
    """The workbench side of the connection to PX4, see `motion.Autopilot`.

    Args:
        host: to listen at.
        port: to listen at.
        patience: time without a timely answer after which the flight ends [s].

    Raises:
        WorkbenchError: if pymavlink is missing, or the port is taken.
    """

    name = "PX4"

    def __init__(self, host: str, port: int, patience: float) -> None:
        if find_spec("pymavlink") is None:
            raise WorkbenchError("PX4 speaks MAVLink: `pip install pymavlink`, the extra `mavlink`")
        from pymavlink.dialects.v20 import common

        self._mavlink: Any = common
        self._codec: Any = common.MAVLink(None, srcSystem=1, srcComponent=51)
        self._codec.robust_parsing = True
        self._patience = patience
        self._peer: socket.socket | None = None
        try:
            self._server = socket.create_server((host, port))
        except OSError as error:
            raise WorkbenchError(
                f"cannot listen at {host}:{port}: {os.strerror(error.errno or 0)}; "
                "end the program that uses that port, or give another port, as --port 4561"
            ) from None
        self._server.setblocking(False)
        self.armed = False
        self._controls: tuple[float, ...] = (0.0,) * 16
        self._locked = False
        self._heard_us = -1
        self._heard = 0.0
        self._count = self._lost = self._free = 0

    @property
    def address(self) -> tuple[str, int]:
        """The address that it listens at."""
        host, port = self._server.getsockname()[:2]
        return host, port

    @property
    def locked(self) -> bool:
        """Whether it has answered, so that each sensor message waits for its answer."""
        return self._locked

    def connect(self) -> None:
        """Wait for the autopilot."""
        while self._peer is None:
            if select.select([self._server], [], [], 0.1)[0]:
                self._peer = self._server.accept()[0]
        self._peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._peer.settimeout(self._patience)
        self._heard = time.monotonic()

    def exchange(self, motion: AutopilotMotion) -> tuple[float, ...]:
        """Send the sensors at a time, and return the controls (16) in the answer, 0 .. 1."""
        now = int(1e6 * motion.time)
        data = b"".join(message.pack(self._codec) for message in self._messages(motion, now))
        try:
            self._sent(data)
        except OSError as error:
            raise _gone(str(error.strerror or error)) from None
        self._count += 1
        if not self._locked:
            self._free += 1
            self._take(0.0, now)
        elif not self._take(PX4_REPLY_TIMEOUT_S, now):
            self._lost += 1
        limit = self._patience if self._locked else PX4_BOOT_TIMEOUT_S
        if time.monotonic() > self._heard + limit:
            raise FlightBrokenError(
                f"PX4 has not answered for {limit:g} s at {motion.time:.3f} s: see its "
                "console, and start both again"
            )
        return self._controls if self.armed else (0.0,) * 16

    def report(self) -> dict[str, float]:
        """Return the numbers of sensor messages: sent, before lockstep, and without an answer."""
        return {"packets": self._count, "free": self._free, "lost": self._lost}

    def close(self) -> None:
        """Close the sockets."""
        if self._peer:
            self._peer.close()
        self._server.close()

    def _sent(self, data: bytes) -> None:
        if self._peer is None:
            raise WorkbenchError("PX4 is not connected yet")
        self._peer.sendall(data)

    def _messages(self, motion: AutopilotMotion, now: int) -> list[Any]:
        """Return the messages for a time; HIL_SENSOR is the last, as it advances PX4's clock."""
        m, made = self._mavlink, []
        latitude, longitude, altitude = motion.place
        place = (round(1e7 * math.degrees(latitude)), round(1e7 * math.degrees(longitude)))
        v_n, v_e, v_d = motion.velocity
        centimetres = (round(100.0 * v_n), round(100.0 * v_e), round(100.0 * v_d))
        speed = math.hypot(v_n, v_e)
        if self._count % GPS_MESSAGE_DIVIDER == 0:
            course = round(100.0 * math.degrees(math.atan2(v_e, v_n) % math.tau)) % 36000
            made.append(
                m.MAVLink_hil_gps_message(
                    now,
                    3,
                    *place,
                    round(1000.0 * altitude),
                    30,
                    40,
                    round(100.0 * speed),
                    *centimetres,
                    course if speed > 0.5 else 65535,
                    12,
                )
            )
        milli_g = [round(1000.0 * a / 9.80665) for a in motion.force]
        made.append(
            m.MAVLink_hil_state_quaternion_message(
                now,
                list(motion.attitude),
                *motion.gyro,
                *place,
                round(1000.0 * altitude),
                *centimetres,
                round(100.0 * speed),
                round(100.0 * speed),
                *(min(max(a, -32768), 32767) for a in milli_g),
            )
        )
        fields = HIL_INERTIAL_FIELDS | (
            HIL_MAGNETIC_FIELDS | HIL_PRESSURE_FIELDS
            if self._count % SLOW_SENSOR_DIVIDER == 0
            else 0
        )
        gauss = [1e4 * b for b in motion.field]
        made.append(
            m.MAVLink_hil_sensor_message(
                now,
                *motion.force,
                *motion.gyro,
                *gauss,
                0.01 * motion.pressure,
                0.0,
                motion.pressure_altitude,
                20.0,
                fields,
                0,
            )
        )
        return made

    def _take(self, limit: float, now: int) -> bool:
        """Read until the answer to the sensors at a time or a time limit [s]; return if it came."""
        end, peer = time.monotonic() + limit, self._peer
        while peer and select.select([peer], [], [], max(0.0, end - time.monotonic()))[0]:
            try:
                data = peer.recv(65536)
            except OSError as error:
                raise _gone(str(error.strerror or error)) from None
            if not data:
                raise _gone("it closed the connection")
            for message in self._codec.parse_buffer(data) or ():
                self._note(message, now)
            if self._heard_us == now:
                return True
            if time.monotonic() > end:  # it may continue to send other messages
                break
        return False

    def _note(self, message: Any, now: int) -> None:
        """Note the controls of a message, and reject invalid ones."""
        if message.get_type() != "HIL_ACTUATOR_CONTROLS":
            return
        said = int(message.time_usec)
        if not message.flags & HIL_LOCKSTEP_BIT:
            raise FlightBrokenError(
                "this PX4 was built without lockstep: build it without ENABLE_LOCKSTEP_SCHEDULER=no"
            )
        if said > now or said < self._heard_us:
            raise FlightBrokenError(
                f"PX4 says that it is {1e-6 * said:.6f} s, but the last sensor readings were of "
                f"{1e-6 * now:.6f} s and its last answer of {1e-6 * self._heard_us:.6f} s: it is "
                "not in lockstep; start both again"
            )
        if not all(map(math.isfinite, message.controls)):
            raise FlightBrokenError(
                f"PX4 sent a motor output that is not a number at {1e-6 * now:.3f} s: its "
                "motors are stopped"
            )
        self._controls = tuple(min(max(u, 0.0), 1.0) for u in message.controls)
        self.armed = bool(message.mode & HIL_ARMED_BIT)
        self._heard_us = said
        if said == now or not self._locked:  # one that always answers late is not in lockstep
            self._heard = time.monotonic()
        self._locked = True


def _gone(why: str) -> FlightBrokenError:
    return FlightBrokenError(f"PX4 is gone: {why}; start both again")
