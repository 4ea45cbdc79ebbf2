"""Admission of clients: limits in total and for each address, and waits after bad logins.

A client takes a place as soon as it may watch. If login is required, that is after its login, so
clients without a token take no places.
"""

from collections import Counter, deque

from workbench.link.address import is_loopback, network_of
from workbench.link.codes import ErrorCode
from workbench.link.messages import Error

FREE_LOGIN_ATTEMPTS = 3
"""Number of consecutive bad logins without a wait."""
FIRST_LOGIN_WAIT_S = 1.0
"""Wait after a further bad login; each is twice the one before [s]."""
MAX_LOGIN_WAIT_S = 60.0
MAX_FAILED_NETWORKS = 256
"""Largest number of networks with remembered bad logins; the oldest is forgotten first."""
LOCAL_LOGIN_DELAY_S = 1.0
"""Delay of the answer to a bad login from this machine [s]. There is no wait before the next login:
otherwise any local program could lock out the gateways."""
MAX_LOCAL_SHARE = 0.75
"""Largest share of all places for programs of this machine: gateways and the page."""
MAX_REFUSAL_LOG_LINES = 20
MAX_REFUSAL_LINE_CHARS = 200


class Admission:
    """Counts the places taken; callers pass the time [s].

    Args:
        clients: largest number at once.
        an_address: largest number at once from one address of another machine.

    Attributes:
        refusals: rejections of clients.
    """

    def __init__(self, clients: int, an_address: int) -> None:
        self.refusals = Refusals()
        self._clients = clients
        self._an_address = an_address
        self._inside: Counter[str] = Counter()
        self._guesses: dict[str, tuple[int, float]] = {}  # bad logins, and when the wait ends [s]

    def most_of(self, host: str) -> int:
        """Return the largest number of clients from an address."""
        if is_loopback(host):
            return max(self._an_address, int(MAX_LOCAL_SHARE * self._clients))
        return self._an_address

    def wait(self, host: str, now: float) -> Error | None:
        """Return an error if an address must wait after bad logins."""
        bad, until = self._guesses.get(network_of(host), (0, now))
        if now < until:
            return Error(
                ErrorCode.BACK_OFF,
                f"there were {bad} bad logins from {host}: wait "
                f"{until - now:.0f} s more, and look at the token",
            )
        return None

    def enter(self, host: str) -> Error | None:
        """Give a client a place, or return an error if there is none."""
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
        """Release the place of a client."""
        self._inside[host] -= 1
        if not self._inside[host]:
            del self._inside[host]

    def bad_login(self, host: str, now: float) -> float:
        """Count a bad login, and return the delay of its answer [s]."""
        if is_loopback(host):
            return LOCAL_LOGIN_DELAY_S
        network = network_of(host)
        count = self._guesses.pop(network, (0, 0.0))[0] + 1
        wait = 0.0
        if count > FREE_LOGIN_ATTEMPTS:
            wait = min(
                MAX_LOGIN_WAIT_S,
                FIRST_LOGIN_WAIT_S * 2.0 ** min(count - FREE_LOGIN_ATTEMPTS - 1, 10),
            )
        self._guesses[network] = (count, now + wait)
        if len(self._guesses) > MAX_FAILED_NETWORKS:
            del self._guesses[next(iter(self._guesses))]
        return 0.0

    def good_login(self, host: str) -> None:
        """Forget earlier bad logins."""
        self._guesses.pop(network_of(host), None)


class Refusals:
    """Counts rejections by code."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._log: deque[str] = deque(maxlen=MAX_REFUSAL_LOG_LINES)

    def add(self, code: str, said: str) -> None:
        """Add a rejection.

        Args:
            code: one of `link.codes`, a small set.
            said: the rejected client, and the reason.
        """
        self._counts[str(code)] += 1
        self._log.append(said[:MAX_REFUSAL_LINE_CHARS])

    @property
    def counts(self) -> dict[str, int]:
        """Number of rejections by code."""
        return dict(self._counts)

    @property
    def log(self) -> tuple[str, ...]:
        """The last rejections, newest last."""
        return tuple(self._log)
