"""How far it is, of what takes a while."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from workbench.commands.printing import say

SELDOM = 4.0
"""Between two lines where there is no terminal [s]."""


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None]]:
    """Yield a function that takes the share done, and shows it on stderr.

    A terminal has a bar; a file or a pipe, as of CI, a line now and then.
    """
    if not sys.stderr.isatty():
        yield _lines(what)
        return
    from tqdm import tqdm

    with tqdm(
        total=100,
        desc=what,
        file=sys.stderr,
        bar_format="{desc} {percentage:3.0f} %|{bar}| {elapsed}, {remaining} left",
        leave=False,
    ) as bar:

        def show(share: float) -> None:
            bar.update(100.0 * share - bar.n)

        yield show


def _lines(what: str) -> Callable[[float], None]:
    """Return what says the share done, in a line now and then; nothing of what is done soon."""
    said = time.monotonic()

    def show(share: float) -> None:
        nonlocal said
        if time.monotonic() > said + SELDOM and share < 1.0:
            said = time.monotonic()
            say(f"{what}: {100.0 * share:.0f} %")

    return show


@contextmanager
def above_bars() -> Iterator[None]:
    """Take bars off the terminal while something is printed, and show them again below it."""
    if "tqdm" not in sys.modules:
        yield
        return
    from tqdm import tqdm

    with tqdm.external_write_mode(file=sys.stderr):
        yield
