"""Betaflight's SITL as a component: one packet of motion in, one of motors out.

The firmware is a local program owned by this class, which starts it in its own folder, configures
it, arms it, exchanges packets with it, and ends it.
See `betaflight_packets` for its ports, `betaflight_msp` for its console and `betaflight_build` for
the program.

Its clock is that of the machine, as all packets carry one time. Its control loop runs once for each
packet of motion, as it is built with SIMULATOR_GYROPID_SYNC. See docs/betaflight-sitl.md for the
remaining nondeterminism. Source: Betaflight 4.6, src/platform/SIMULATOR/sitl.c.
"""

import contextlib
import logging
import math
import shutil
import socket
import struct
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from multiprocessing.connection import wait
from pathlib import Path

from workbench.common.cache import PROGRESS_LOGGER
from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.extras.autopilots.programs.betaflight_msp import (
    MSP_SETTER_BY_GETTER,
    MSP_STATUS,
    arming_block_reason,
    arming_status,
    gains_in,
    msp_request,
    payload_with_gains,
    received_bytes,
    take_msp_answers,
)
from workbench.extras.autopilots.programs.betaflight_packets import (
    BETAFLIGHT_HOST,
    CONSOLE_PORT,
    LEVEL_MOTION_PACKET,
    MAX_CHANNEL_US,
    MIN_CHANNEL_US,
    MOTORS_PACKET_BYTES,
    RECEIVER_PORT,
    SITL_REPLY_TIMEOUT_S,
    STATE_PORT,
    TIME_RESET_GAP_S,
    ReceiverChannels,
    channels_packet,
    check_ports,
    motors_in,
)
from workbench.ipc.child_process import ChildProcess

SITL_SILENCE_TIMEOUT_S = 2.0
"""Time without any answer after which it counts as dead [s]."""
EXIT_CODE_TIMEOUT_S = 1.0
"""Time limit for its exit code after its console has closed [s]."""
SITL_BOOT_TIMEOUT_S = 3.0
MAX_SITL_STARTS = 5
"""Time limit for its control loop to run after a start [s], and largest number of starts."""
ARMING_TIMEOUT_S, MSP_TIMEOUT_S = 30.0, 10.0
"""Time limits until it can be armed, due to the calibration of its barometer, and for an answer
[s]."""


class Betaflight:
    """Owns a Betaflight SITL.

    Attributes:
        folder: its working folder: settings, log, and blackbox.
        pid: of its process.
        steps: number of packets of motion sent in flight.
        lost: number of those without an answer in time.
        motors: its last outputs M1 .. M4, 0 .. 1.

    Args:
        binary: see `betaflight_program`.
        settings: for its command line, by name.

    Raises:
        WorkbenchError: if its ports are taken, or it does not start.
    """

    def __init__(self, binary: Path, settings: Mapping[str, object]) -> None:
        self._binary, self._tell = binary, logging.getLogger(PROGRESS_LOGGER).info
        self.steps = self.lost = 0
        self.motors: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
        self._sticks, self._switch = ReceiverChannels(), MIN_CHANNEL_US
        self._sent = self._heard = -math.inf
        self._end, self._watched = "", False
        self._console: socket.socket | None = None
        self._received = bytearray()
        self._read_back: dict[int, bytes] = {}
        self._asked: set[int] = set()
        with contextlib.ExitStack() as opened:
            self._output = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            check_ports(self._output)
            self._input = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            self.folder = Path(tempfile.mkdtemp(prefix="betaflight-"))
            opened.callback(shutil.rmtree, self.folder, ignore_errors=True)
            self._keeper = ChildProcess("workbench.extras.autopilots.programs.keeper", "Betaflight")
            opened.callback(self._keeper.end, 2.0)
            opened.callback(self._keeper.release)
            opened.callback(self._hang_up)
            self._tell("Betaflight: configuring it")
            self._start()
            self._configure(settings)
            self._tell("Betaflight: starts it")
            self._start()
            self._opened = opened.pop_all()

    def close(self) -> None:
        """End it, and remove its folder."""
        self._opened.close()

    def arm(self) -> None:
        """Arm it, after clearing its memory of an earlier flight.

        Raises:
            FlightBrokenError: if it has ended, or no longer answers and is then ended.
            WorkbenchError: if it does not arm, with the reasons.
        """
        self._sticks, self._switch = ReceiverChannels(), MIN_CHANNEL_US
        self._wait(self._settled, "confirms its gains")
        self._wait(lambda: not self._status()[0], "disarms")
        self._wait(lambda: not self._status()[1], "is ready to arm", self._why_not)
        self._switch = MAX_CHANNEL_US
        self._wait(lambda: self._status()[0], "arms", self._why_not)

    def step(self, motion: bytes, sticks: ReceiverChannels) -> tuple[float, ...]:
        """Return its outputs M1 .. M4 for a packet of motion, 0 .. 1.

        If it does not answer in time, the motors are held and the step counts as lost.

        Raises:
            FlightBrokenError: if it has ended, or no longer answers and is then ended.
        """
        self._sticks = sticks
        if self._asked and wait([self._connected()], 0.0):
            self._hear()
        now = time.monotonic()
        if now > self._sent + TIME_RESET_GAP_S:  # the packet only sets its time, and has no answer
            self._send(motion)
            self._heard = now
        self._drain()
        self._send(motion)
        self.steps += 1
        self._output.settimeout(SITL_REPLY_TIMEOUT_S)
        try:
            self._read(self._output.recv(2 * MOTORS_PACKET_BYTES))
        except TimeoutError:
            self.lost += 1
            self._check()
            self._check_silence()
        return self.motors

    def blackbox(self) -> bytes:
        """Return its recording, which disarming ends, or what exists of it after its end."""
        with contextlib.suppress(WorkbenchError):
            self._check()
            self._sticks, self._switch = ReceiverChannels(), MIN_CHANNEL_US
            self._wait(lambda: not self._status()[0], "disarms")
        found = sorted(self.folder.glob("LOG*"))
        return b"".join(file.read_bytes() for file in found)

    def set_gains(self, values: Mapping[str, float]) -> None:
        """Set gains by name, rounded to whole numbers; `gains` has them once confirmed."""
        console = self._connected()
        for command, setter in MSP_SETTER_BY_GETTER.items():
            payload = payload_with_gains(command, self._read_back[command], values)
            if payload != self._read_back[command]:
                with self._told_how_it_ended():
                    console.sendall(msp_request(setter, payload) + msp_request(command))
                self._asked.add(command)

    @property
    def confirmed(self) -> bool:
        """Whether it has confirmed all gains set."""
        return not self._asked

    @property
    def gains(self) -> dict[str, int]:
        """Its gains, as last reported by MSP."""
        return gains_in(self._read_back)

    def ask(self, command: int, payload: bytes = b"", limit: float = MSP_TIMEOUT_S) -> bytes:
        """Return the answer to an MSP request.

        Raises:
            WorkbenchError: if it is rejected, or there is no answer.
        """
        console = self._connected()
        with self._told_how_it_ended():
            console.sendall(msp_request(command, payload))
        end = time.monotonic() + limit
        while time.monotonic() < end:
            self._keep_alive()
            if wait([console], 0.001) and (found := self._hear().get(command)) is not None:
                return found
        raise WorkbenchError(f"Betaflight does not answer the MSP command {command}")

    # start and end

    def _start(self) -> None:
        """Start the program, and wait until its control loop runs and its console answers.

        In about one of ten starts its scheduler never reaches the control loop; the program is then
        restarted.
        """
        printed = self.folder / "betaflight.log"
        for _ in range(MAX_SITL_STARTS):
            self._keeper.connection.send(([str(self._binary)], str(self.folder), str(printed)))
            self.pid, self._end = self._keeper.connection.recv(), ""
            # Sticks sent before the start of its receiver are ignored: it sets them up at the first
            # packet, and then resets them.
            self._listens = False
            end = time.monotonic() + SITL_BOOT_TIMEOUT_S
            while time.monotonic() < end:
                self._check()
                with contextlib.suppress(OSError, WorkbenchError):
                    runs = self._cycle(end - time.monotonic()) > 0
                    self._listens = True
                    if runs:
                        self._read_back = {
                            command: self.ask(command) for command in MSP_SETTER_BY_GETTER
                        }
                        self._asked.clear()
                        return
                time.sleep(0.05)
            self._tell("Betaflight: its control loop does not run; starts it again")
            self._keeper.connection.send(None)
            self._ended()
        raise WorkbenchError(
            f"Betaflight's control loop did not run in {MAX_SITL_STARTS} starts of "
            f"{SITL_BOOT_TIMEOUT_S:g} s: the machine "
            "may be too busy; end other programs, and fly again"
        )

    def _cycle(self, limit: float) -> int:
        """Return the reported period of its control loop [us], 0 if it does not run."""
        self._connected()
        (found,) = struct.unpack_from("<H", self.ask(MSP_STATUS, limit=limit))
        return int(found)

    def _check(self, patience: float = 0.0) -> None:
        """Check that the program has not ended, nor ends within a time [s]."""
        if not self._end and self._keeper.connection.poll(patience):
            try:
                code = self._keeper.connection.recv()
            except (EOFError, OSError):
                self._end = f"Betaflight ended: {self._keeper.cause()}"
            else:
                how = f"was killed by signal {-code}" if code < 0 else f"ended with {code}"
                self._end = f"Betaflight {how}"
        if self._end:
            raise FlightBrokenError(self._end)

    def _check_silence(self) -> None:
        """End it and raise an error if it has not answered a packet for long."""
        if time.monotonic() > self._heard + SITL_SILENCE_TIMEOUT_S:
            self._keeper.connection.send(None)
            with contextlib.suppress(WorkbenchError):
                self._check(EXIT_CODE_TIMEOUT_S)
            self._end = f"Betaflight did not answer for {SITL_SILENCE_TIMEOUT_S:g} s, and was ended"
            self._check()

    @contextlib.contextmanager
    def _told_how_it_ended(self) -> Iterator[None]:
        """Raise an error that states how it ended, if its console has closed."""
        try:
            yield
        except OSError as error:
            self._hang_up()
            self._check(EXIT_CODE_TIMEOUT_S)
            raise WorkbenchError(f"Betaflight's console is closed: {error}") from None

    def _ended(self) -> int:
        """Wait until it ends; return its exit code."""
        if not self._keeper.connection.poll(MSP_TIMEOUT_S):
            raise WorkbenchError(f"Betaflight does not end within {MSP_TIMEOUT_S:g} s")
        self._hang_up()
        return int(self._keeper.connection.recv())

    def _configure(self, settings: Mapping[str, object]) -> None:
        """Write settings over its command line, which then ends it."""
        lines = [f"set {name} = {value}" for name, value in settings.items()]
        lines = ["aux 0 0 0 1700 2100 0 0", "aux 1 1 1 1700 2100 0 0", *lines]
        console = self._connected()
        time.sleep(0.15)  # it accepts a # as the start of the command line only after a pause
        console.sendall(b"#")
        self._prompt(console)
        for line in lines:
            console.sendall(line.encode() + b"\n")
            said = self._prompt(console)
            if "ERROR" in said:
                raise WorkbenchError(f"Betaflight refuses '{line}': {' '.join(said.split())}")
        console.sendall(b"save\n")
        if code := self._ended():
            raise WorkbenchError(f"Betaflight ended with {code} when its settings were saved")

    def _prompt(self, console: socket.socket) -> str:
        """Return the output of its command line up to the prompt."""
        said, end = b"", time.monotonic() + MSP_TIMEOUT_S
        while time.monotonic() < end:
            self._keep_alive()
            if wait([console], 0.001):
                with self._told_how_it_ended():
                    said += received_bytes(console)
                if said.endswith(b"# "):
                    return said.decode(errors="replace")
        raise WorkbenchError("Betaflight's command line does not answer")

    def _hang_up(self) -> None:
        if self._console:
            self._console.close()
        self._console = None

    def _connected(self) -> socket.socket:
        if self._console is None:
            self._console = socket.create_connection((BETAFLIGHT_HOST, CONSOLE_PORT), 1.0)
            self._received = bytearray()
        return self._console

    def _settled(self) -> bool:
        """Return whether no answer about gains is due."""
        self._keep_alive()
        if wait([self._connected()], 0.001):
            self._hear()
        return not self._asked

    def _hear(self) -> dict[int, bytes]:
        """Return its present answers by command, and note confirmed gains."""
        heard = {}
        with self._told_how_it_ended():
            told = received_bytes(self._connected())
        self._received += told
        for command, payload in take_msp_answers(self._received):
            if payload is None:
                raise WorkbenchError(f"Betaflight refuses the MSP command {command}")
            heard[command] = payload
            if command in self._asked:
                self._asked.remove(command)
                self._read_back[command] = payload
        return heard

    def _keep_alive(self) -> None:
        """Send the motion of a drone at rest, as it needs packets while it waits."""
        if self._listens:
            self._send(LEVEL_MOTION_PACKET)
            self._drain()
            if self._watched:
                self._check_silence()

    def _send(self, motion: bytes) -> None:
        channels = channels_packet(self._sticks, self._switch)
        self._input.sendto(channels, (BETAFLIGHT_HOST, RECEIVER_PORT))
        self._input.sendto(motion, (BETAFLIGHT_HOST, STATE_PORT))
        self._sent = time.monotonic()

    def _drain(self) -> None:
        """Discard packets that are late or unexpected."""
        self._output.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while True:
                self._read(self._output.recv(2 * MOTORS_PACKET_BYTES))

    def _read(self, packet: bytes) -> None:
        if len(packet) != MOTORS_PACKET_BYTES:
            return
        self._heard = time.monotonic()
        self.motors = motors_in(packet) or self.motors

    def _status(self) -> tuple[bool, int]:
        """Return whether it is armed, and its arming flags."""
        return arming_status(self.ask(MSP_STATUS))

    def _why_not(self) -> str:
        return arming_block_reason(self._status()[1])

    def _wait(
        self, done: Callable[[], bool], what: str, why: Callable[[], str] = lambda: ""
    ) -> None:
        self._tell(f"Betaflight: waits until it {what}")
        self._heard, self._watched = time.monotonic(), True
        end = self._heard + ARMING_TIMEOUT_S
        try:
            while not done():
                time.sleep(0.002)  # it has other work besides MSP
                self._check()
                if time.monotonic() > end:
                    reason = why()
                    raise WorkbenchError(
                        f"Betaflight is not ready within {ARMING_TIMEOUT_S:g} s"
                        + (f": {reason}" if reason else "")
                    )
        finally:
            self._watched = False
