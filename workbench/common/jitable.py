"""Mark functions that compiled code may call, without loading numba.

numba takes half a second to load, and most commands compile nothing.
"""

import inspect
import types
from collections.abc import Callable, Sequence
from typing import Any, TypeVar, overload

Scalar = Any
"""A number of a function that runs in three ways: float, AutoDiffXd, or what numba makes of it."""
Vector = Any
"""A sequence of such numbers: a list or tuple in Python, an array or tuple in machine code."""
Function = TypeVar("Function", bound=Callable[..., Any])
_marked: list[tuple[Callable[..., Any], dict[str, Any]]] = []
"""Functions that are not registered with numba yet."""


@overload
def register_jitable(function: Function) -> Function: ...
@overload
def register_jitable(
    *, forceinline: bool = False, boundscheck: bool = False, _nrt: bool = True
) -> Callable[[Function], Function]: ...
def register_jitable(function: Any = None, **options: Any) -> Any:
    """Let compiled code call a function; in Python it stays as it is.

    Args:
        function: to be marked; without one, a decorator is returned.
        options: of `numba.extending.register_jitable`, such as `_nrt=False` for one that makes no
            arrays: numba then counts no references to those that it is given.
    """

    def mark(each: Callable[..., Any]) -> Callable[..., Any]:
        _marked.append((each, options))
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


def unique(function: Function, key: str) -> Function:
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


def each_of(functions: Sequence[Callable[..., Any]], key: str) -> Callable[..., Any]:
    """Return a function that returns a tuple of the results of functions, and compiles.

    numba makes no tuple in a loop, so each function adds its result to those before it.

    Args:
        functions: that compile, and take the same arguments.
        key: see `unique`.
    """
    if not functions:
        return _none
    earlier, last = each_of(functions[:-1], key), functions[-1]

    @register_jitable(forceinline=True)
    def run(*args: Any) -> Any:
        return earlier(*args) + (last(*args),)

    return unique(run, f"{len(functions)}_{key}")


@register_jitable(forceinline=True)
def _none(*args: Any) -> Any:
    return ()


def attribute(name: str) -> Callable[..., Any]:
    """Return a function that returns an attribute of a record, and compiles."""

    @register_jitable(forceinline=True)
    def read(record: Any) -> Any:
        return getattr(record, name)

    return unique(read, name)


def attributes(names: Sequence[str], key: str) -> Callable[..., Any]:
    """Return a function that returns attributes of a record as a tuple, see `each_of`."""
    return each_of([attribute(name) for name in names], key)


def tell_numba() -> None:
    """Register all functions marked so far with numba; needed before any compilation."""
    from numba.extending import register_jitable as register

    while _marked:
        function, options = _marked.pop()
        # no C program calls them: a wrapper would hold, and compile, a second copy of each
        register(no_cfunc_wrapper=True, **options)(function)
