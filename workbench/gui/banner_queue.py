"""The notices that wait to be seen; the banner shows the first."""

from dataclasses import dataclass

from workbench.gui.notices import Notice, Severity

STAYS = {Severity.INFORMATION: 8.0, Severity.WARNING: 20.0, Severity.FAILURE: float("inf")}
"""How long a notice is shown that nobody dismisses [s]."""
MOST = 20
"""Notices that wait; of more the oldest that are no failures go."""


@dataclass(frozen=True)
class Told:
    """A notice in the queue.

    Attributes:
        notice: the newest of those that say the same.
        times: how often it was told.
        until: when it goes by itself, in the clock's time [s].
    """

    notice: Notice
    times: int
    until: float


class BannerQueue:
    """Notices, those that matter most first, and of equals the newest.

    A sentence that comes again is counted, and does not stand twice.
    """

    def __init__(self) -> None:
        self._told: list[Told] = []

    def __len__(self) -> int:
        return len(self._told)

    @property
    def first(self) -> Told | None:
        """What is to be shown."""
        ranks = list(Severity)
        return max(self._told, key=lambda each: ranks.index(each.notice.severity), default=None)

    def add(self, notice: Notice, now: float) -> None:
        """Take a notice at a time [s]."""
        times = 1
        for each in self._told:
            same = each.notice.what == notice.what
            if same and each.notice.severity is notice.severity:
                times = each.times + 1
                self._told.remove(each)
                break
        self._told.insert(0, Told(notice, times, now + STAYS[notice.severity]))
        while len(self._told) > MOST:
            passing = [each for each in self._told if each.until < float("inf")]
            self._told.remove((passing or self._told)[-1])

    def dismiss(self) -> None:
        """Forget what is shown."""
        if self.first is not None:
            self._told.remove(self.first)

    def forget_failures(self) -> None:
        """Forget what was broken: it flies again."""
        self._told = [each for each in self._told if each.notice.severity is not Severity.FAILURE]

    def expire(self, now: float) -> None:
        """Forget what has been shown long enough."""
        self._told = [each for each in self._told if each.until > now]
