"""Handle Ctrl-C to end long work with the results so far."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from workbench.commands.printing import say


@contextmanager
def stop_on_interrupt(
    stop: Callable[[], None] = lambda: None, keeps: str = "what is done"
) -> Iterator[Callable[[], bool]]:
    """Yield a function that returns whether Ctrl-C was pressed; a second one ends the program.

    Outside of the main thread it is always false, as no signal arrives there.

    Args:
        stop: called on Ctrl-C.
        keeps: the results kept then, for a message.
    """
    stopped = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stopped.is_set
        return

    def note(number: int, frame: FrameType | None) -> None:
        stopped.set()
        stop()
        signal.signal(signal.SIGINT, before)
        say(f"stopping with {keeps}; press Ctrl-C again to quit at once")

    before = signal.signal(signal.SIGINT, note)
    try:
        yield stopped.is_set
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def told_to_stop() -> Iterator[threading.Event]:
    """Yield an event that is set by Ctrl-C, or by a request to end the process."""
    stopped = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stopped
        return
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda *_: stopped.set()) for number in numbers]
    try:
        yield stopped
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
