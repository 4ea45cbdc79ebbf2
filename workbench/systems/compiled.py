"""Compile a pure function with numba, and keep the machine code on disk.

numba's own cache looks at the one file that the compiled function stands in; the law stands in
several, and so do rays. So the cache lies in a folder named after the content of all of them.
"""

import hashlib
import logging
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numba
from numba.core import config

from workbench.cache import cache_folder
from workbench.errors import WorkbenchError

LAW = (
    "cascade.py",
    "loop_points.py",
    "obstacle_brake.py",
    "mixer.py",
    "stopped_rotors.py",
    "rotor_response.py",
    "flight_state.py",
    "flight_law.py",
    "../plant/gravity.py",
)
"""The files that the control law stands in, in this folder."""


def compile_cached(
    function: Callable[..., Any],
    sources: Sequence[str] = LAW,
    what: str = "the control law",
    **options: Any,
) -> Callable[..., Any]:
    """Return `function` compiled at its first call, up to a minute once a machine.

    Where no folder can be written, it is compiled anew in every process.

    Args:
        function: which compiles.
        sources: the files of all that it calls, and of its arguments' types, from this folder; a
            change in one compiles anew.
        what: it computes, for people.
        options: of `numba.njit`, such as `nogil=True`, which lets other Python threads run
            meanwhile: worth it where a call takes long.
    """
    try:
        folder = cache_folder(_digest(sources, options)) / function.__name__
        folder.mkdir(exist_ok=True)
    except (WorkbenchError, OSError):  # it runs without a cache, too
        return _Announced(numba.njit(**options)(function), what)
    new = not any(folder.iterdir())
    before = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = str(folder)  # type: ignore[attr-defined]
    try:
        compiled = numba.njit(cache=True, **options)(function)
    finally:
        config.CACHE_DIR = before  # type: ignore[attr-defined]
    return _Announced(compiled, what) if new else compiled


class _Announced:
    """A compiled function that says what it does before its first, slow call."""

    def __init__(self, compiled: Callable[..., Any], what: str) -> None:
        self._compiled = compiled
        self._what = what
        self._said = False

    def __call__(self, *args: Any) -> Any:
        if not self._said:
            self._said = True
            logging.getLogger("workbench").warning(
                "compiling %s for this machine, up to a minute, this once", self._what
            )
        return self._compiled(*args)


def _digest(sources: Sequence[str], options: Mapping[str, Any]) -> str:
    """Return a name for the sources as they are, and for how they are compiled."""
    how = sorted((name, str(value)) for name, value in options.items())
    digest = hashlib.sha256(f"{numba.__version__} {how}".encode())
    for name in sources:
        digest.update((Path(__file__).parent / name).read_bytes())
    return digest.hexdigest()[:16]
