"""Callbacks that do not keep their system alive."""

from collections.abc import Callable
from typing import Any
from weakref import WeakMethod


def weakly(method: Callable[..., None]) -> Callable[..., None]:
    """Return a function that calls a system's method and refers to the system weakly.

    Drake 1.58 hides the callbacks of abstract output ports and of cache entries from Python's
    garbage collector. A bound method there would keep its system alive for ever, and with it the
    whole diagram. The function for their first value must not refer to the system either, and the
    system must keep the index of a `CacheEntry` instead of the entry.
    """
    reference = WeakMethod(method)

    def call(*args: Any) -> None:
        alive = reference()
        assert alive is not None  # ports and cache entries are part of their system
        alive(*args)

    return call
