"""The list of notices: the newest and gravest first, those that are over last."""

from collections.abc import Callable
from dataclasses import replace

from workbench.gui.notices import Notice, Severity

MAX_LISTED_NOTICES = 50
"""Limit of the list; beyond it the last ones are dropped."""
SEVERITY_ORDER = list(Severity)


class NoticeList:
    """Notices that were told; those that are over stay at its end.

    Args:
        now: returns a monotonic time [s].
    """

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._listed: tuple[Notice, ...] = ()  # the newest first

    @property
    def ordered(self) -> tuple[Notice, ...]:
        """All of them: new ones by severity, then those that stay, then the others by age."""
        now = self._now()

        def order(listed: Notice) -> tuple[int, int]:
            gravity = -SEVERITY_ORDER.index(listed.severity)
            if listed.is_new(now):
                return 0, gravity
            return (1, gravity) if listed.stays else (2, 0)

        return tuple(sorted(self._listed, key=order))

    @property
    def present(self) -> tuple[Notice, ...]:
        """Those that are new or stay, in the same order."""
        now = self._now()
        return tuple(each for each in self.ordered if each.is_new(now) or each.stays)

    def add(self, notice: Notice) -> None:
        """Add a notice; a repeated one is only counted."""
        same = (notice.what, notice.severity)
        equal = [each for each in self._listed if (each.what, each.severity) == same]
        times = 1 + sum(each.times for each in equal)
        rest = [each for each in self._listed if each not in equal]
        self._listed = (replace(notice, times=times, told_at=self._now()), *rest)
        if len(self._listed) > MAX_LISTED_NOTICES:
            ordered = self.ordered
            last = ([each for each in ordered if not each.stays] or ordered)[-1]
            self._listed = tuple(each for each in self._listed if each is not last)

    def end(self, over: Callable[[Notice], bool]) -> None:
        """Note that some are over: dismissed, or without their cause."""
        self._listed = tuple(
            replace(each, is_over=True) if over(each) else each for each in self._listed
        )

    def clear(self) -> None:
        """Remove those that neither are new nor stay."""
        self._listed = self.present

    @property
    def has_new(self) -> bool:
        """Whether any is still new."""
        now = self._now()
        return any(each.is_new(now) for each in self._listed)
