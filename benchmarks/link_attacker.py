"""Clients without a login that attack a server, by sockets alone, for link_attacks.py.

`python benchmarks/link_attacker.py ATTACK CLIENTS ADDRESS PAGE` is one of so many clients. It
prints a line when it begins, and attacks until it reads one; then it prints how much it was, as
JSON. It has the lowest priority, as it stands for a program of another machine.
"""

import contextlib
import json
import os
import selectors
import socket
import sys
import threading
import time
from dataclasses import dataclass, replace

CONNECTIONS = 10_000
"""Of all attackers together, where they open as many as they can."""
PIECE = 256 * 1024
REQUESTS = 250_000
"""Of requests that are sent at once [bytes]."""
LOWEST = 19
"""Of the attackers' priority (nice)."""
OPENED = 1000.0
"""Connections that an attacker makes, where it wants many [1/s]. At several times as many the
system's network itself leaves connections out, which no program can do anything about."""


@dataclass(frozen=True)
class Attack:
    """What clients without a login do.

    Attributes:
        begin: sent first; %s is the host of the page.
        again: sent without end after that.
        web: whether to the page; else by TCP.
        connections: that all clients together open and keep open; 0 for one each.
        period: pause between two bytes that a connection reads or sends [s]; 0 for all that goes.
        piece: bytes sent at once.
    """

    begin: bytes = b""
    again: bytes = b""
    web: bool = True
    connections: int = 0
    period: float = 0.0
    piece: int = PIECE

    def of(self, page: str) -> "Attack":
        """Return it for a page."""
        host = page.encode()
        return replace(
            self, begin=self.begin.replace(b"%s", host), again=self.again.replace(b"%s", host)
        )


HEADERS = b" HTTP/1.1\r\nHost: %s\r\n"
GET = b"GET /app.js" + HEADERS + b"\r\n"
UPGRADE = (
    b"GET /ws" + HEADERS + b"Origin: http://%s\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
)
BEGUN = UPGRADE + b"\x02\x80" + bytes(4)
"""A WebSocket, and the first part of a message."""
ATTACKS: dict[str, Attack] = {
    "pipelining": Attack(again=GET * (REQUESTS // len(GET))),
    "continuations": Attack(BEGUN, (b"\x00\x80" + bytes(4)) * 20_000),
    "slow reads": Attack(GET, connections=200, period=0.2),
    "slow requests": Attack(again=GET, connections=200, period=0.05, piece=1),
    "10,000 connections": Attack(web=False, connections=CONNECTIONS),
    "10,000 requests": Attack(GET, connections=CONNECTIONS),
}


class Stranger:
    """A connection of an attacker.

    Args:
        attack: what it does.
        where: address of the server.
    """

    def __init__(self, attack: Attack, where: tuple[str, int]) -> None:
        self.attack = attack
        self.left, self.sent = attack.begin, 0
        self.link = socket.socket()
        self.link.setblocking(False)
        self.link.connect_ex(where)

    @property
    def events(self) -> int:
        """What to wait for."""
        writes = self.left or self.attack.again
        return selectors.EVENT_READ | (selectors.EVENT_WRITE if writes else 0)

    def go_on(self) -> bool:
        """Read and send what goes; return whether the connection is still there."""
        try:
            with contextlib.suppress(BlockingIOError):
                if not self.link.recv(1 if self.attack.period else PIECE):
                    return False
            with contextlib.suppress(BlockingIOError):
                self.left = self.left or self.attack.again
                count = self.link.send(self.left[: self.attack.piece]) if self.left else 0
                self.sent += count
                self.left = self.left[count:]
        except OSError:
            return False
        return True


def attack(name: str, clients: int, address: str, page: str) -> None:
    """Attack until a line is read, and print how much it was."""
    os.nice(LOWEST)
    what = ATTACKS[name].of(page)
    host, _, port = (page if what.web else address).rpartition(":")
    stopped = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.readline(), stopped.set()), daemon=True).start()
    wanted = what.connections // clients or 1
    made, sent, begun = 0, 0, time.monotonic()
    print("attacks", flush=True)
    inside: set[Stranger] = set()
    with selectors.DefaultSelector() as selector:
        while not stopped.is_set():
            now = time.monotonic()
            while len(inside) < wanted and (wanted == 1 or made < OPENED * (now - begun)):
                stranger = Stranger(what, (host, int(port)))
                inside.add(stranger)
                selector.register(stranger.link, stranger.events, stranger)
                made += 1
            if what.period:
                time.sleep(what.period)
                ready = list(inside)
            else:
                wait = 0.001 if len(inside) < wanted else 0.05
                ready = [key.data for key, _ in selector.select(wait)]
            for stranger in ready:
                before, goes_on = stranger.events, stranger.go_on()
                if not goes_on:
                    inside.discard(stranger)
                    sent += stranger.sent
                    selector.unregister(stranger.link)
                    stranger.link.close()
                elif stranger.events != before:
                    selector.modify(stranger.link, stranger.events, stranger)
    sent += sum(stranger.sent for stranger in inside)
    print(json.dumps({"connections": made, "bytes": sent}), flush=True)
    os._exit(0)  # closing 10,000 sockets one by one takes long


if __name__ == "__main__":
    attack(sys.argv[1], int(sys.argv[2]), *sys.argv[3:])
