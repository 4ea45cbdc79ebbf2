"""Callbacks that do not keep their system alive."""

from collections.abc import Callable
from types import MethodType
from typing import TypeVar
from weakref import ref

Result = TypeVar("Result")


def weakly(method: Callable[..., Result]) -> Callable[..., Result]:
    """Return a function that calls a system's method and refers to the system weakly.

    Drake 1.58 hides the callbacks of abstract output ports and of cache entries from Python's
    garbage collector. A bound method there would keep its system alive for ever, and with it the
    whole diagram. The function for their first value must not refer to the system either, and the
    system must keep the index of a `CacheEntry` instead of the entry.
    """
    assert isinstance(method, MethodType)
    system, function = ref(method.__self__), method.__func__  # quicker than a WeakMethod

    def call(*args: object) -> Result:
        return function(
            system(), *args
        )  # alive, as ports and cache entries are part of their system

    return call
