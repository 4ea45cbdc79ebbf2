"""A progress bar for what takes a while."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None]]:
    """Show a bar on stderr if that is a terminal; yield a function that takes the share done."""
    if not sys.stderr.isatty():
        yield lambda share: None
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
