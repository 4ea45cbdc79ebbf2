"""What waits to be told to the flight: little, however long the flight stands still.

Of each client its first and its newest command and its few requests, and the newest status.
"""

from collections import deque

from workbench.link.backplane import Asked, Command, Gone, ServerFailed, ServerStatus

Told = Asked | ServerStatus | ServerFailed


class Waiting:
    """A queue in which some records take the place of older ones."""

    def __init__(self) -> None:
        self._records: deque[Told] = deque()
        self._known: set[int] = set()

    def add(self, record: Told) -> None:
        """Let a record wait."""
        match record:
            case Gone(peer):
                self._forget(peer)
                if peer in self._known:  # else the flight has never heard of it
                    self._known.discard(peer)
                    self._records.append(record)
            case Command():
                self._put(record)
            case ServerStatus():
                kept = [each for each in self._records if not isinstance(each, ServerStatus)]
                self._records = deque([*kept, record])
            case _:
                self._records.append(record)

    def next(self) -> Told | None:
        """Return what is to be told next; None if nothing waits."""
        if not self._records:
            return None
        record = self._records.popleft()
        if not isinstance(record, Gone | ServerStatus | ServerFailed):
            self._known.add(record.peer)
        return record

    def _put(self, command: Command) -> None:
        """Let a command wait, in the place of the client's last one if that is not its first.

        The first one stays, as it may be the neutral one that a new holder begins with; and none
        comes before a request that it was sent after.
        """
        own = [at for at, each in enumerate(self._records) if _is_of(each, command.peer)]
        if len(own) > 1 and all(isinstance(self._records[at], Command) for at in own[-2:]):
            self._records[own[-1]] = command
        else:
            self._records.append(command)

    def _forget(self, peer: int) -> None:
        """Leave out the commands of a client that is gone; what it asked for last still counts.

        Of one that the flight has never heard of, nothing does.
        """
        known = peer in self._known
        self._records = deque(
            each
            for each in self._records
            if not _is_of(each, peer) or (known and not isinstance(each, Command))
        )


def _is_of(record: Told, peer: int) -> bool:
    return getattr(record, "peer", 0) == peer
