"""Handle signals to end long work with the results so far."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from workbench.commands.printing import print_message

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""Signals that end a program: Ctrl-C, a system shutdown, a closed terminal."""


class StopFlag:
    """Whether the program was asked to end; a call returns it.

    Attributes:
        number: of the signal, 0 for none.
    """

    number = 0

    def __call__(self) -> bool:
        return self.number != 0

    @property
    def exit_code(self) -> int:
        """Exit code of a program that this signal ends."""
        return 128 + self.number


@contextmanager
def stop_on_interrupt(
    stop: Callable[[], None] = lambda: None, keeps: str = "what is done"
) -> Iterator[StopFlag]:
    """Yield whether Ctrl-C was pressed, or another signal came; a second one ends the program.

    Outside of the main thread it is always false, as no signal arrives there.

    Args:
        stop: called with the signal.
        keeps: the results kept then, for a message.
    """
    stopped = StopFlag()
    if threading.current_thread() is not threading.main_thread():
        yield stopped
        return
    before = {
        number: signal.getsignal(number)
        for number in STOP_SIGNALS
        if signal.getsignal(number) is not signal.SIG_IGN  # as under nohup
    }

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def note(number: int, frame: FrameType | None) -> None:
        stopped.number = number
        stop()
        restore()
        again = "press Ctrl-C again" if number == signal.SIGINT else "send the signal again"
        print_message(f"stopping with {keeps}; {again} to quit at once")

    for number in before:
        signal.signal(number, note)
    try:
        yield stopped
    finally:
        restore()


@contextmanager
def stop_event_on_signal() -> Iterator[threading.Event]:
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
