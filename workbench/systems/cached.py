"""Values that a system calculates from its Context, once for each change of it."""

from collections.abc import Callable
from types import MethodType
from typing import Any, TypeVar
from weakref import ref

from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, DependencyTicket, ValueProducer

from workbench.systems.weak_callback import weakly

Calculated = TypeVar("Calculated")


def cached(
    calculate: Callable[[Context], Calculated], name: str, needs: set[DependencyTicket]
) -> Callable[[Context], Calculated]:
    """Declare a cache entry of a system, and return a function that evaluates it.

    Drake 1.58 hides the callbacks of cache entries from Python's garbage collector, so neither
    they nor the returned function keep the system alive, see `weakly`.

    Args:
        calculate: method of the system that returns the value.
        name: of the entry.
        needs: what it is calculated from.
    """
    assert isinstance(calculate, MethodType)
    owner: Any = calculate.__self__
    system, function = ref(owner), weakly(calculate)

    def store(context: Context, output: AbstractValue) -> None:
        output.set_value(function(context))

    producer = ValueProducer(_empty_entry, store)
    index = owner.DeclareCacheEntry(name, producer, needs).cache_index()

    def evaluate(context: Context) -> Calculated:
        alive: Any = system()
        value: Calculated = alive.get_cache_entry(index).Eval(context)
        return value

    return evaluate


def _empty_entry() -> AbstractValue:
    """Return the first value of a cache entry."""
    return Value[object](())
