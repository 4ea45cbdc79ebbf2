"""numba's cache on disk, in a folder whose name says everything that the code depends on.

numba's own cache looks at one source file, and its keys hash what a closure holds, which may differ
in each process. It names machine code by the arguments' types, and a type of record by a count that
starts anew in each process: code of two laws, compiled in two processes, then has equal names, and
a third that loads both calls the one for the other. Here a type of record is named by its layout.
This module imports numba, so only `compiled` imports it, at a first call.
"""

import hashlib
import pickle
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.codegen import CPUCodegen
from numba.core.compiler import CompileResult
from numba.core.cpu import CPUContext
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.types import Record, Type


def _layout_name(self: Record) -> tuple[str, tuple[object, ...]]:
    """Return what numba puts into the names of functions for a type of record."""
    return "Record", (hashlib.sha256(self.name.encode()).hexdigest()[:16],)


Record.mangling_args = property(_layout_name)


class CodeCache(FunctionCache):
    """The cache of one function; damaged files are those of a function not compiled yet.

    Args:
        folder: private to the user, as loading a file may run any code that it holds.
        function: that numba compiles.
    """

    def __init__(self, folder: Path, function: Callable[..., Any]) -> None:
        # not numba's, which looks for a folder by the function's source file
        digest = hashlib.sha256(f"{function.__module__} {function.__qualname__}".encode())
        name = f"{function.__name__}-{digest.hexdigest()[:16]}"  # closures have long names
        self._name = repr(function)
        self._cache_path = str(folder)
        self._cache_file = IndexDataCacheFile(self._cache_path, name, source_stamp="")
        self.enable()

    def holds(self, types: tuple[Type, ...], target: CPUContext) -> bool:
        """Return whether there is code for types of arguments."""
        try:
            return self._index_key(types, target.codegen()) in self._cache_file._load_index()
        except Exception:  # pickle raises any kind for a damaged file
            return False

    def load_overload(
        self, sig: tuple[Type, ...], target_context: CPUContext
    ) -> CompileResult | None:
        """Return the `CompileResult` for types of arguments, or None if there is none."""
        # all that machine code needs; numba's own cache loads what its compiler needs, too
        rtsys.initialize(target_context)
        try:
            data = self._cache_file.load(self._index_key(sig, target_context.codegen()))
            if data is None:
                return None
            check, content = data
            if hashlib.sha256(content).digest() != check:  # damaged code would crash the process
                raise ValueError("the file is damaged")
            return CompileResult._rebuild(target_context, *pickle.loads(content))
        except Exception:  # as above; a damaged index would also stop `save_overload`
            with suppress(OSError):  # a folder that is read-only
                self.flush()
            return None

    def save_overload(self, sig: tuple[Type, ...], data: CompileResult) -> None:
        """Keep a `CompileResult`, unless it refers to objects of this process."""
        if data.lifted or data.library.has_dynamic_globals:
            return
        content = dumps(data._reduce())
        with suppress(OSError):  # a full disk: the code runs without a cache, too
            key = self._index_key(sig, data.codegen)
            self._cache_file.save(key, (hashlib.sha256(content).digest(), content))

    def _index_key(self, sig: tuple[Type, ...], codegen: CPUCodegen) -> tuple[Any, ...]:
        return sig, codegen.magic_tuple()
