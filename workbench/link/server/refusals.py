"""What was refused: how often, and the last ones in words, for the operator's screen."""

from collections import Counter, deque

LONGEST_LOG = 20
LONGEST_LINE = 200


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
