"""Compile a pure function with numba, and keep the machine code on disk.

numba's own cache looks at the one file that the compiled function stands in; the law stands in
several. So the cache lies in a folder named after the content of all of them.
"""

import hashlib
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import config

from workbench.cache import cache_folder
from workbench.errors import WorkbenchError

_SOURCES = ("cascade.py", "mixer.py", "rotor_response.py", "flight_law.py")


def compile_cached(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return `function` compiled at its first call, which takes a few seconds once a machine.

    Where no folder can be written, it is compiled anew in every process.
    """
    try:
        folder = cache_folder(_digest())
    except WorkbenchError:  # the law flies without a cache, too
        return _Announced(numba.njit(function))
    new = not any(folder.iterdir())
    before = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    try:
        compiled = numba.njit(cache=True)(function)
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]
    return _Announced(compiled) if new else compiled


class _Announced:
    """A compiled function that says what it does before its first, slow call."""

    def __init__(self, compiled: Callable[..., Any]) -> None:
        self._compiled = compiled
        self._said = False

    def __call__(self, *args: Any) -> Any:
        if not self._said:
            self._said = True
            logging.getLogger("workbench").warning(
                "compiling the control law for this machine, a few seconds, this once"
            )
        return self._compiled(*args)


def _digest() -> str:
    """Return a name for the sources as they are."""
    digest = hashlib.sha256(numba.__version__.encode())
    for name in _SOURCES:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest.hexdigest()[:16]
