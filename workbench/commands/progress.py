"""A progress bar for what takes a while."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tqdm import tqdm


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr if that is a terminal; yield a function that takes the share done."""
    with tqdm(
        total=100,
        desc=what,
        file=sys.stderr,
        disable=not sys.stderr.isatty(),
        bar_format="{desc} {percentage:3.0f} %|{bar}| {elapsed}, {remaining} left",
        leave=False,
    ) as bar:

        def show(share: float) -> None:
            bar.update(100.0 * share - bar.n)

        yield show
