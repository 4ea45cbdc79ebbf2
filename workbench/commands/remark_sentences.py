"""Print remarks and warnings of the program as sentences."""

import contextlib
import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import logging


REPEAT_REPORT_AFTER_S = 2.0
"""Time after which unchanged progress is reported again [s]."""


@contextlib.contextmanager
def remarks_as_sentences(verbose: bool = False) -> Iterator[None]:
    """Print log messages of the workbench in the same form as other output on stderr.

    Args:
        verbose: whether to print those for the curious, too.
    """
    import logging

    from workbench.commands.progress import above_bars

    class Handler(logging.StreamHandler):
        """Prints a sentence above a progress bar, not into it."""

        def emit(self, record: logging.LogRecord) -> None:
            with above_bars():
                super().emit(record)

    logger = logging.getLogger("workbench")
    handler = Handler()
    handler.setFormatter(logging.Formatter("workbench: %(message)s"))
    said: dict[str, tuple[float, float]] = {}
    handler.addFilter(lambda record: _is_new(record, said, sys.stderr.isatty()))
    logger.setLevel(logging.DEBUG if verbose else logging.INFO)
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = True
        logger.setLevel(logging.NOTSET)


def _is_new(
    record: "logging.LogRecord", said: dict[str, tuple[float, float]], terminal: bool
) -> bool:
    """Return whether to print a message: a remark only once, as a command may fly several times.

    Progress is reported again even if unchanged, as silence looks like a program that hangs, but
    only once for all processes that wait at a time, and ever less often in a file or a pipe.

    Args:
        record: of the message.
        said: time of the next message that may be printed, and time until that, of each [s].
        terminal: whether it is printed on one.
    """
    from workbench.commands.progress import next_delay
    from workbench.common.cache import PROGRESS_LOGGER

    message, now = record.getMessage(), record.created
    if getattr(record, "repeated", False) and not terminal:
        message = message.partition(":")[0]
        due, pause = said.get(message, (now, REPEAT_REPORT_AFTER_S))
        pause = next_delay(pause)
    else:
        due, pause = said.get(message, (now, 0.0))
        pause = REPEAT_REPORT_AFTER_S if record.name == PROGRESS_LOGGER else float("inf")
    if now < due:
        return False
    said[message] = now + pause, pause
    return True
