"""Which clients are admitted: a maximum in all and for each address, none that guesses tokens.

A client has its place from the moment when it may look at anything: from its login where one is
needed, so that strangers take no places.
"""

from collections import Counter, deque
from typing import NamedTuple

from workbench.link.address import is_loopback, network_of
from workbench.link.codes import ErrorCode
from workbench.link.messages import Error

FREE_GUESSES = 3
"""Bad logins in a row without a wait."""
FIRST_WAIT = 1.0
"""Wait after a bad login, doubled at each further one [s]."""
LONGEST_WAIT = 60.0
MOST_GUESSERS = 256
"""Networks whose bad logins are remembered; the oldest is forgotten."""
OWN_WAIT = 1.0
"""Until a program of this machine hears that its login was bad. It is never told to wait before the
next one: any program would lock out the gateways and the operator's monitor with that [s]."""
OF_THIS_MACHINE = 0.75
"""Share of all places that programs of this machine may have: gateways, monitors and the page."""
LONGEST_LOG = 20
LONGEST_LINE = 200


class _Guesses(NamedTuple):
    bad: int
    until: float


class Admission:
    """Counts who has a place; times are told [s].

    Args:
        clients: at once.
        an_address: at once from one address of another machine.

    Attributes:
        refusals: what was refused to clients.
    """

    def __init__(self, clients: int, an_address: int) -> None:
        self.refusals = Refusals()
        self._clients = clients
        self._an_address = an_address
        self._inside: Counter[str] = Counter()
        self._guesses: dict[str, _Guesses] = {}

    def most_of(self, host: str) -> int:
        """Return how many clients may come from an address."""
        if is_loopback(host):
            return max(self._an_address, int(OF_THIS_MACHINE * self._clients))
        return self._an_address

    def wait(self, host: str, now: float) -> Error | None:
        """Refuse who has guessed, for a while."""
        guesses = self._guesses.get(network_of(host))
        if guesses and now < guesses.until:
            return Error(
                ErrorCode.BACK_OFF,
                f"there were {guesses.bad} bad logins from {host}: wait "
                f"{guesses.until - now:.0f} s more, and look at the token",
            )
        return None

    def enter(self, host: str) -> Error | None:
        """Give a client a place, unless there is none."""
        if self._inside.total() >= self._clients:
            return Error(
                ErrorCode.TOO_MANY,
                f"all {self._clients} places are taken: disconnect another client",
            )
        if self._inside[host] >= self.most_of(host):
            return Error(
                ErrorCode.TOO_MANY,
                f"{host} has {self._inside[host]} clients already, the most from one address: "
                "disconnect another of them",
            )
        self._inside[host] += 1
        return None

    def leave(self, host: str) -> None:
        """Note that a client has gone that had a place."""
        self._inside[host] -= 1
        if not self._inside[host]:
            del self._inside[host]

    def bad_login(self, host: str, now: float) -> float:
        """Note a bad login; return for how long not to answer it [s]."""
        if is_loopback(host):
            return OWN_WAIT
        network = network_of(host)
        count = self._guesses.pop(network, _Guesses(0, 0.0)).bad + 1
        wait = 0.0
        if count > FREE_GUESSES:
            wait = min(LONGEST_WAIT, FIRST_WAIT * 2.0 ** min(count - FREE_GUESSES - 1, 10))
        self._guesses[network] = _Guesses(count, now + wait)
        if len(self._guesses) > MOST_GUESSERS:
            del self._guesses[next(iter(self._guesses))]
        return 0.0

    def good_login(self, host: str) -> None:
        """Forget the bad ones before."""
        self._guesses.pop(network_of(host), None)


class Refusals:
    """Counts refusals by their code.

    Attributes:
        changed: whether there were some since this was last set to False.
    """

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._log: deque[str] = deque(maxlen=LONGEST_LOG)
        self.changed = False

    def add(self, code: str, said: str) -> None:
        """Note one.

        Args:
            code: of `link.codes`, so there are not many.
            said: who was refused what, and why.
        """
        self._counts[str(code)] += 1
        self._log.append(said[:LONGEST_LINE])
        self.changed = True

    @property
    def counts(self) -> dict[str, int]:
        """How often, by code."""
        return dict(self._counts)

    @property
    def log(self) -> tuple[str, ...]:
        """The last ones, newest last."""
        return tuple(self._log)
