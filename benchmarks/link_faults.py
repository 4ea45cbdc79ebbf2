"""Flights in which whoever flies over the link comes to harm, for link_hold.py and the tests."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from link_proxy import Proxy

from workbench.link.messages import ControlOwner, LinkLossStage
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Action

HOLDER = Path(__file__).with_name("link_holder.py")
ENOUGH = 120.0
"""Nothing takes so long unless it fails [s]."""
ATTEMPTS = 50


class Pilot:
    """A holder in a process of its own.

    Args:
        address: of the server, "HOST:PORT".
    """

    def __init__(self, address: str) -> None:
        host, _, port = address.rpartition(":")
        self.process = subprocess.Popen(
            [sys.executable, "-I", "-S", str(HOLDER), host, port],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )

    def heard(self) -> str:
        """Wait for a line that it prints."""
        assert self.process.stdout
        return self.process.stdout.readline().strip()

    def told(self, word: str) -> None:
        """Let it do something."""
        assert self.process.stdin
        self.process.stdin.write(word + "\n")
        self.process.stdin.flush()

    def sent(self, number: int) -> None:
        """Send it a signal."""
        os.kill(self.process.pid, number)

    def close(self) -> None:
        """End it."""
        self.process.kill()
        self.process.wait()
        for each in (self.process.stdin, self.process.stdout):
            assert each
            each.close()


@dataclass
class Scene:
    """A flight, its server, and who flies it.

    Attributes:
        flight: live.
        address: of its server, "HOST:PORT".
        pilot: who holds control.
        proxy: between the two.
    """

    flight: LiveFlight
    address: str
    pilot: Pilot
    proxy: Proxy

    def server(self) -> int:
        """Return the number of the server's process."""
        (found,) = children(self.flight.pid)
        return found


def children(pid: int) -> list[int]:
    """Return the processes that a process has started and that are still there."""
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(each) for each in text.split()]


FAULTS: dict[str, Callable[[Scene], object]] = {
    "kill -9": lambda scene: scene.pilot.sent(signal.SIGKILL),
    "SIGSTOP": lambda scene: scene.pilot.sent(signal.SIGSTOP),
    "reset": lambda scene: scene.pilot.told("reset"),
    "close": lambda scene: scene.pilot.told("close"),
    "half-open": lambda scene: scene.proxy.stop(),
    "silence": lambda scene: scene.pilot.told("silent"),
    "only NaN": lambda scene: scene.pilot.told("bad"),
    "release": lambda scene: scene.pilot.told("release"),
    "server stopped": lambda scene: scene.flight.stop_serving().result(ENOUGH),
    "server killed": lambda scene: os.kill(scene.server(), signal.SIGKILL),
    "server SIGSTOP": lambda scene: os.kill(scene.server(), signal.SIGSTOP),
}
"""What happens to who flies."""
OF_THE_SERVER = ("server stopped", "server killed", "server SIGSTOP")
REVIVALS: dict[str, Callable[[Scene], object]] = {
    "SIGSTOP": lambda scene: scene.pilot.sent(signal.SIGCONT),
    "half-open": lambda scene: scene.proxy.go_on(),
    "server SIGSTOP": lambda scene: os.kill(scene.server(), signal.SIGCONT),
}
"""How what stood still goes on: with commands that are too old."""
MORE = 0.3
"""Flown after that [s]."""
AT_ONCE = ("kill -9", "reset", "close", "release", "server stopped", "server killed")
"""These end the connection or the lease, and are not silence."""


@dataclass(frozen=True)
class Held:
    """What came of a fault, in simulated time.

    Attributes:
        fault: see `FAULTS`.
        gap: from the last command that came into force to HOLD [s].
        commands: that came into force.
        revived: further ones, when what stood still went on again.
    """

    fault: str
    gap: float
    commands: int
    revived: int


@contextmanager
def flown(flight: LiveFlight, address: str, indirectly: bool = False) -> Iterator[Scene]:
    """Begin anew, and let somebody take control and fly, over the proxy or not."""
    proxy = Proxy(address)
    pilot = begun(flight, proxy.address if indirectly else address)
    try:
        yield Scene(flight, address, pilot, proxy)
    finally:
        pilot.close()
        proxy.close()


def begun(flight: LiveFlight, address: str) -> Pilot:
    """Return somebody who flies; on a busy machine one may fall silent before that."""
    for _ in range(ATTEMPTS):
        flight.reset().result(ENOUGH)
        pilot = Pilot(address)
        if pilot.heard() == "flies" and is_moved(flight):
            return pilot
        pilot.close()
    raise AssertionError("nobody manages to fly")


def is_moved(flight: LiveFlight) -> bool:
    """Wait until a client moves the drone, or has lost control; return whether it moves."""

    def is_settled() -> bool:
        control = flight.latest().network.control
        return is_flown(flight) or (control is not None and control.stage is not LinkLossStage.LIVE)

    wait_for(is_settled, "the flight does not follow")
    return is_flown(flight)


def is_flown(flight: LiveFlight) -> bool:
    """Return whether a client commands and the drone is asked to move."""
    view = flight.latest()
    control, snapshot = view.network.control, view.snapshot
    is_live = control and (control.hand, control.stage) == (ControlOwner.CLIENT, LinkLossStage.LIVE)
    return bool(is_live and snapshot and snapshot.reference[0] > 0.5)


def harmed(flight: LiveFlight, address: str, fault: str, delay: float = 0.0) -> Held:
    """Fly, let something happen after a delay [s of wall], and return what came of it.

    A server that was to blame is gone afterwards.
    """
    with flown(flight, address, indirectly=fault == "half-open") as scene:
        time.sleep(delay)
        FAULTS[fault](scene)
        wait_for(lambda: not is_flown(flight), "nobody noticed it")
        wait_for(lambda: gap(script(flight)) is not None, "the drone does not hold")
        before = script(flight)
        if fault in REVIVALS:
            REVIVALS[fault](scene)
            fly_on(flight, MORE)
        after = script(flight)
        found = gap(after)
        assert found is not None, "the drone moves again"
        if fault in OF_THE_SERVER:
            flight.stop_serving().result(ENOUGH)
        return Held(fault, found, moves(before), moves(after) - moves(before))


def gap(script: list[Action]) -> float | None:
    """Return the time from the last command that moves the drone to the HOLD after it [s]."""
    orders = [each for each in script if each.velocity is not None]
    last = max(i for i, each in enumerate(orders) if is_move(each))
    return orders[last + 1].at - orders[last].at if last + 1 < len(orders) else None


def is_move(action: Action) -> bool:
    """Return whether an action asks the drone to move."""
    return any((*(action.velocity or []), action.yaw_rate or 0.0))


def moves(script: list[Action]) -> int:
    """Return how many of its actions ask the drone to move."""
    return sum(map(is_move, script))


def fly_on(flight: LiveFlight, duration: float) -> None:
    """Wait until the flight has gone on for a time [s]."""
    end = time_of(flight) + duration
    wait_for(lambda: time_of(flight) >= end, "the flight stands")


def time_of(flight: LiveFlight) -> float:
    """Return the simulated time [s]."""
    snapshot = flight.latest().snapshot
    assert snapshot
    return snapshot.time


def script(flight: LiveFlight) -> list[Action]:
    """Return all that came into force."""
    return list(flight.flown().result(ENOUGH).scenario.script)


def wait_for(condition: Callable[[], bool], complaint: str) -> None:
    """Wait until something is so."""
    end = time.monotonic() + ENOUGH
    while not condition():
        assert time.monotonic() < end, complaint
        time.sleep(0.005)


def serve(flight: LiveFlight) -> str:
    """Serve a flight, once its last server is gone, and return the address."""
    wait_for(lambda: flight.latest().network.server is None, "the server is still there")
    return flight.serve(ServerConfig(port=0)).result(ENOUGH)
