"""Who may come in: so many clients in all and from an address, and none that guesses tokens."""

from collections import Counter
from typing import NamedTuple

from workbench.link.codes import ErrorCode
from workbench.link.server.config import is_loopback

FREE_GUESSES = 3
"""Bad logins in a row without a wait."""
FIRST_WAIT = 1.0
"""After the next bad login; doubled at each further one [s]."""
LONGEST_WAIT = 60.0
MOST_GUESSERS = 256
"""Addresses whose bad logins are remembered; the oldest is forgotten."""
OF_THIS_MACHINE = 0.75
"""Share of all seats that programs of this machine may have: gateways, monitors and the page."""


class Refused(NamedTuple):
    """Why somebody may not come in."""

    code: ErrorCode
    said: str


class _Guesses(NamedTuple):
    bad: int
    until: float


class Admission:
    """Counts who is in; times are told [s].

    Args:
        clients: at once.
        an_address: at once from one address of another machine.
    """

    def __init__(self, clients: int, an_address: int) -> None:
        self._clients = clients
        self._an_address = an_address
        self._inside: Counter[str] = Counter()
        self._guesses: dict[str, _Guesses] = {}

    def most_of(self, host: str) -> int:
        """Return how many clients may come from an address."""
        if is_loopback(host):
            return max(self._an_address, int(OF_THIS_MACHINE * self._clients))
        return self._an_address

    def enter(self, host: str, now: float) -> Refused | None:
        """Let a client in, unless it is refused."""
        guesses = self._guesses.get(host)
        if guesses and now < guesses.until:
            return Refused(
                ErrorCode.BACK_OFF,
                f"there were {guesses.bad} bad logins from {host}: wait "
                f"{guesses.until - now:.0f} s more, and look at the token",
            )
        if self._inside.total() >= self._clients:
            return Refused(
                ErrorCode.TOO_MANY,
                f"all {self._clients} places are taken: disconnect another client",
            )
        if self._inside[host] >= self.most_of(host):
            return Refused(
                ErrorCode.TOO_MANY,
                f"{host} has {self._inside[host]} clients already, the most from one address: "
                "disconnect another of them",
            )
        self._inside[host] += 1
        return None

    def leave(self, host: str) -> None:
        """Note that a client has gone that was let in."""
        self._inside[host] -= 1
        if not self._inside[host]:
            del self._inside[host]

    def bad_login(self, host: str, now: float) -> None:
        """Note a bad login."""
        count = self._guesses.pop(host, _Guesses(0, 0.0)).bad + 1
        wait = 0.0
        if count > FREE_GUESSES:
            wait = min(LONGEST_WAIT, FIRST_WAIT * 2.0 ** min(count - FREE_GUESSES - 1, 10))
        self._guesses[host] = _Guesses(count, now + wait)
        if len(self._guesses) > MOST_GUESSERS:
            del self._guesses[next(iter(self._guesses))]

    def good_login(self, host: str) -> None:
        """Forget the bad ones before."""
        self._guesses.pop(host, None)
