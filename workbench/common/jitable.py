"""Mark functions that compiled code may call, without loading numba.

numba takes half a second to load, and most commands compile nothing.
"""

import inspect
import types
from collections.abc import Callable, Sequence
from typing import Any, TypeVar, overload

Function = TypeVar("Function", bound=Callable[..., Any])
_unregistered: list[tuple[Callable[..., Any], dict[str, Any]]] = []
"""Functions that are not registered with numba yet."""


@overload
def register_jitable(function: Function) -> Function: ...
@overload
def register_jitable(
    *, forceinline: bool = False, boundscheck: bool = False, allocates: bool = True
) -> Callable[[Function], Function]: ...
def register_jitable(
    function: Function | None = None, *, allocates: bool = True, **options: Any
) -> Function | Callable[[Function], Function]:
    """Let compiled code call a function; in Python it stays as it is.

    Args:
        function: to be marked; without one, a decorator is returned.
        allocates: whether it makes arrays. If not, numba counts no references to those that it is
            given: each count is an atomic operation, and took a third of the time of a flight.
        options: of `numba.extending.register_jitable`.
    """

    def mark(each: Function) -> Function:
        _unregistered.append((each, {**options, "_nrt": allocates}))
        return each

    return mark if function is None else mark(function)


def mark_functions(module: types.ModuleType, boundscheck: bool = False) -> None:
    """Let compiled code call each function that a module defines.

    Args:
        module: with the functions.
        boundscheck: whether an index beyond the end of an array is an error there, as in Python.
    """
    for function in list(vars(module).values()):
        if inspect.isfunction(function) and function.__module__ == module.__name__:
            register_jitable(forceinline=True, boundscheck=boundscheck)(function)


def give_unique_name(function: Function, key: str) -> Function:
    """Return a function after giving it a unique name.

    numba names machine code by module, name, and a count that starts at 0 in each process. If two
    processes compile different functions with one name, and a third process loads both from the
    cache, it confuses them. So functions that are made inside a function need unique names.

    Args:
        function: made inside a function.
        key: everything that its code depends on.
    """
    function.__qualname__ = f"{function.__qualname__}_{key}"
    return function


def make_results_tuple(functions: Sequence[Callable[..., Any]], key: str) -> Callable[..., Any]:
    """Return a function that returns a tuple of the results of functions, and compiles.

    numba makes no tuple in a loop, so each function adds its result to those before it.

    Args:
        functions: that compile, and take the same arguments.
        key: see `give_unique_name`.
    """
    if not functions:
        return _none
    earlier, last = make_results_tuple(functions[:-1], key), functions[-1]

    @register_jitable(forceinline=True)
    def run(*args: Any) -> tuple[Any, ...]:
        return earlier(*args) + (last(*args),)

    return give_unique_name(run, f"{len(functions)}_{key}")


@register_jitable(forceinline=True)
def _none(*args: Any) -> tuple[()]:
    return ()


def make_attribute_reader(name: str) -> Callable[..., Any]:
    """Return a function that returns an attribute of a record, and compiles."""

    @register_jitable(forceinline=True)
    def read(record: object) -> Any:
        return getattr(record, name)

    return give_unique_name(read, name)


def make_tuple_reader(names: Sequence[str], key: str) -> Callable[..., Any]:
    """Return a function that returns attributes of a record as a tuple, see
    `make_results_tuple`.
    """
    return make_results_tuple([make_attribute_reader(name) for name in names], key)


def register_with_numba() -> None:
    """Register all functions marked so far with numba; needed before any compilation."""
    from numba.extending import register_jitable as register

    while _unregistered:
        function, options = _unregistered.pop()
        # no C program calls them: a wrapper would hold, and compile, a second copy of each
        register(no_cfunc_wrapper=True, **options)(function)
