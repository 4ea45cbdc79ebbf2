"""Progress of long work."""

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

from workbench.commands.printing import print_message, terminal
from workbench.common.plain_text import plain_name

FIRST_DELAY_S, MAX_REPEAT_DELAY_S = 1.0, 120.0
"""Time to the first line without a terminal, and longest time between lines [s]."""
DELAY_GROWTH = 1.6
"""Factor on the time between lines with each line: an hour takes some forty."""


class ShowProgress(Protocol):
    """Shows the share done, 0 .. 1, and a text on what is being done."""

    def __call__(self, share: float, text: str = "", /) -> None:
        """Show both."""


@contextmanager
def progress_bar(what: str) -> Iterator[ShowProgress]:
    """Yield a function of the share done, which shows it on stderr.

    A terminal shows a bar; a file or a pipe, such as in CI, gets a line at intervals.
    """
    if not sys.stderr.isatty():
        with _lines(what) as show:
            yield show
        return
    from tqdm import tqdm

    with tqdm(
        total=100,
        desc=plain_name(what),
        file=terminal(),
        bar_format="{desc} {percentage:3.0f} %|{bar}| {elapsed}, {remaining} left{postfix}",
        leave=False,
    ) as bar:

        def show(share: float, text: str = "", /) -> None:
            if text:
                bar.set_postfix_str(plain_name(text))
            bar.update(100.0 * share - bar.n)

        yield show


@contextmanager
def _lines(what: str) -> Iterator[ShowProgress]:
    """Yield a function of the share done, and print it in a line, ever less often.

    A thread prints it, as the first share may take long. Short work prints no line.
    """
    done, now, over = 0.0, "", threading.Event()

    def show(share: float, text: str = "", /) -> None:
        nonlocal done, now
        done, now = share, text and f", {text}"

    def tell() -> None:
        pause = FIRST_DELAY_S
        while not over.wait(pause) and done < 1.0:
            print_message(f"{what}: {100.0 * done:.0f} %{now}")
            pause = next_delay(pause)

    teller = threading.Thread(target=tell, daemon=True)
    teller.start()
    try:
        yield show
    finally:
        over.set()
        teller.join()


def next_delay(pause: float) -> float:
    """Return the time until the line after the next [s], from the time until the next."""
    return min(MAX_REPEAT_DELAY_S, DELAY_GROWTH * pause)


@contextmanager
def above_bars() -> Iterator[None]:
    """Hide bars while something is printed, and show them again below it."""
    if "tqdm" not in sys.modules:
        yield
        return
    from tqdm import tqdm

    with tqdm.external_write_mode(file=terminal()):
        yield
