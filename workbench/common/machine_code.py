"""Machine code that numba made, kept on disk and loaded without numba.

numba takes longer to load than Drake, and tells its compiler of all types and functions that it
knows before the first code can be loaded. What is compiled needs none of that: an object file whose
places for addresses are to be filled in, with those of functions of C, of Python, and of numba's
runtime, which is a library of its own.

That is as much of the ELF format as LLVM writes for numba on x86-64 (System V ABI, AMD64
Supplement, chapter 4). What has anything else is not kept: numba makes it anew. So it is where a
file is not whole, or was made for another processor, Python, numpy, LLVM or numba.
"""

import builtins
import ctypes
import hashlib
import importlib.util
import mmap
import os
import pickle
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from importlib.machinery import EXTENSION_SUFFIXES, PathFinder
from itertools import takewhile
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from workbench.common.cache import release
from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically

SUFFIX = ".code"
_CHECK = hashlib.sha256().digest_size
_C, _F, _LAYOUT = 0x1, 0x2, 0x501
"""Bits of numpy's flags of an array: in the order of C, of Fortran; of C, aligned, writeable."""
_TYPE, _AXES, _NUMBERS_OF, _FLAGS = 8, 24, 56, 64
"""Where an object has its type, and an array its number of axes, type of numbers, and flags."""
_ORDER, _NUMBER = 26, 28
"""Where a type of numbers has the order of its bytes, and its own number."""
_SCALARS: dict[str, tuple[type, ...]] = {
    "none": (type(None),),
    "bool": (bool, np.bool_),
    "int": (int, np.int64),
    "float": (float, np.float64),
}
"""Types that machine code takes for the same."""
_NUMBERS = (
    *("bool", "float32", "float64", "int8", "int16", "int32", "int64"),
    *("uint8", "uint16", "uint32", "uint64"),
)
"""That arrays may have, by their names."""
_GUARD = "guard"
"""Name of the function that `_Guard` makes."""
_SECTION = np.dtype(
    {
        "names": ["type", "flags", "offset", "size", "link", "info", "align"],
        "formats": ["<u4", "<u8", "<u8", "<u8", "<u4", "<u4", "<u8"],
        "offsets": [4, 8, 24, 32, 40, 44, 48],
        "itemsize": 64,
    }
)
_SYMBOL = np.dtype(
    {
        "names": ["name", "section", "value", "size"],
        "formats": ["<u4", "<u2", "<u8", "<u8"],
        "offsets": [0, 6, 8, 16],
        "itemsize": 24,
    }
)
_PLACE = np.dtype([("offset", "<u8"), ("kind", "<u4"), ("symbol", "<u4"), ("addend", "<i8")])
_ELF, _X86_64, _MACHINE = b"\x7fELF\x02\x01", 62, 18
"""How a file of 64 bits, the lowest first, begins; its machine, and where that stands."""
_TABLE_AT, _TABLE_SIZE = 40, 60
"""Where a file's head says where its table of sections stands (8 bytes), and its length (2)."""
_SYMBOLS, _PLACES, _EMPTY, _UNWINDING = 2, 4, 8, 0x70000001
"""Types of sections: SYMTAB, RELA, NOBITS, X86_64_UNWIND."""
_WRITTEN, _LOADED = 0x1, 0x2
"""Flags of sections: WRITE, ALLOC."""
_ELSEWHERE, _COMMON = 0, 0xFFF2
"""In place of the section of symbols that stand in none: UNDEF, COMMON."""
_ADDRESS = 1
"""The only kind of place for an address: R_X86_64_64, a whole one."""
_STEP = 64
"""What stands in memory begins at a multiple of this: as much as any section asks for."""


class OtherKindError(TypeError):
    """Machine code was called with arguments of other kinds than it was made for."""


class _Code(NamedTuple):
    """What is kept of one function, for arguments of one kind.

    Attributes:
        entry: name of the function that numba made for Python.
        constants: of numba's environments, by the names of the places that lead to them; that of
            the function itself is the first.
        content: of the object file.
        guard: the object file of a function that looks at the arguments and calls the entry.
    """

    entry: str
    constants: dict[str, list[Any]]
    content: bytes
    guard: bytes


Kind = str | tuple[Any, ...]
"""A scalar's name; `array`, its numbers' name, axes and flags; a tuple's type and its parts'."""


def kinds_of(args: Sequence[Any]) -> tuple[Kind, ...] | None:
    """Return what machine code for some arguments depends on; None where it is not known here."""
    kinds = [_kind_of(each) for each in args]
    known = tuple(kind for kind in kinds if kind is not None)
    return known if len(known) == len(kinds) else None


def _kind_of(value: Any) -> Kind | None:
    for kind, types in _SCALARS.items():
        if type(value) in types:
            return kind
    if type(value) is np.ndarray and value.dtype.name in _NUMBERS and value.dtype.isnative:
        flags = value.flags.num & (_LAYOUT | _F)
        layout = flags if flags & _F and not flags & _C else flags & _LAYOUT
        return ("array", value.dtype.name, value.ndim, layout)
    if isinstance(value, tuple) and "." not in type(value).__qualname__:  # named ones, too
        parts = kinds_of(value)
        return None if parts is None else (_name_of(type(value)), *parts)
    return None


def _name_of(kind: type) -> str:
    """Return where a type stands; `_address_of` finds it again."""
    return f"{kind.__module__}.{kind.__qualname__}"


class _Guard:
    """The text, for LLVM, of a function that calls another one if its arguments are of some kinds.

    What numba makes for Python looks at the axes of an array and at the size of its numbers, not at
    their type, nor whether they stand one behind the other. Each look costs a nanosecond here, and
    a tenth of a microsecond in Python. Objects are read as Python and numpy lay them out for
    compiled extensions (`PyObject`, `PyArrayObject_fields`, `PyArray_Descr`).

    Args:
        kinds: of the arguments.
        entry: name of the function that is called.
    """

    def __init__(self, kinds: tuple[Kind, ...], entry: str) -> None:
        self._lines: list[str] = []
        self._look_at_parts("%args", kinds)
        types = sorted(set(re.findall(r'@"[\w.]+"', " ".join(self._lines))))
        self.text = "\n".join(
            [
                *(f"{name} = external global i8" for name in types),
                "@_Py_NoneStruct = external global i8",
                f'@"{__name__}.{OtherKindError.__name__}" = external global i8',
                "declare i64 @PyTuple_Size(ptr)",
                "declare ptr @PyTuple_GetItem(ptr, i64)",
                "declare void @PyErr_SetNone(ptr)",
                f'declare ptr @"{entry}"(ptr, ptr, ptr)',
                f"define ptr @{_GUARD}(ptr %self, ptr %args, ptr %words) {{",
                *self._lines,
                f'%result = call ptr @"{entry}"(ptr %self, ptr %args, ptr %words)',
                "ret ptr %result",
                "other:",
                f'call void @PyErr_SetNone(ptr @"{__name__}.{OtherKindError.__name__}")',
                "ret ptr null",
                "}",
            ]
        )

    def _look_at_parts(self, whole: str, kinds: tuple[Kind, ...]) -> None:
        size = self._let(f"call i64 @PyTuple_Size(ptr {whole})")
        self._demand(f"icmp eq i64 {size}, {len(kinds)}")
        for place, kind in enumerate(kinds):
            part = self._let(f"call ptr @PyTuple_GetItem(ptr {whole}, i64 {place})")
            self._look_at(part, kind)

    def _look_at(self, value: str, kind: Kind) -> None:
        if kind == "none":
            self._demand(f"icmp eq ptr {value}, @_Py_NoneStruct")
            return
        held = self._field(value, _TYPE, "ptr")
        if isinstance(kind, str):
            same = [f'icmp eq ptr {held}, @"{_name_of(each)}"' for each in _SCALARS[kind]]
            self._demand("or i1 " + ", ".join(map(self._let, same)))
        elif kind[0] == "array":
            self._look_at_array(value, held, *kind[1:])
        else:
            self._demand(f'icmp eq ptr {held}, @"{kind[0]}"')
            self._look_at_parts(value, kind[1:])

    def _look_at_array(self, value: str, held: str, number: str, axes: int, layout: int) -> None:
        self._demand(f'icmp eq ptr {held}, @"numpy.ndarray"')
        self._demand(f"icmp eq i32 {self._field(value, _AXES, 'i32')}, {axes}")
        known = _LAYOUT | (layout & _F)
        flags = self._let(f"and i32 {self._field(value, _FLAGS, 'i32')}, {known}")
        self._demand(f"icmp eq i32 {flags}, {layout}")
        numbers = self._field(value, _NUMBERS_OF, "ptr")
        self._demand(f"icmp eq i32 {self._field(numbers, _NUMBER, 'i32')}, {np.dtype(number).num}")
        self._demand(f"icmp ne i8 {self._field(numbers, _ORDER, 'i8')}, {ord('>')}")

    def _field(self, of: str, at: int, kind: str) -> str:
        place = self._let(f"getelementptr i8, ptr {of}, i64 {at}")
        return self._let(f"load {kind}, ptr {place}")

    def _let(self, value: str) -> str:
        name = f"%v{len(self._lines)}"
        self._lines.append(f"{name} = {value}")
        return name

    def _demand(self, condition: str) -> None:
        fits, then = self._let(condition), f"l{len(self._lines)}"
        self._lines += [f"br i1 {fits}, label %{then}, label %other", f"{then}:"]


def code_file(folder: Path, function: Callable[..., Any], kinds: tuple[Kind, ...]) -> Path:
    """Return where the code of a function is kept that can run here.

    Args:
        folder: of all that follows from the same sources.
        function: in Python.
        kinds: of its arguments.
    """
    whose = f"{function.__module__} {function.__qualname__} {kinds}"
    digest = hashlib.sha256(whose.encode()).hexdigest()[:16]
    return folder / f"{function.__name__}-{digest}.{_here()}{SUFFIX}"


def has_code(folder: Path) -> bool:
    """Return whether code is kept that can run here, of any function and kinds of arguments."""
    return any(folder.glob(f"*.{_here()}{SUFFIX}"))


@lru_cache(maxsize=1)
def _here() -> str:
    """Return a name for all but the sources that code depends on.

    That is processor, Python with its way to lay out objects, numba's settings, and what makes,
    keeps and loads the code.
    """
    settings = sorted(each for each in os.environ.items() if each[0].startswith("NUMBA_"))
    made_by = [release(each) for each in ("numba", "llvmlite", "numpy")]
    where = f"{EXTENSION_SUFFIXES[0]} {sys.version} {settings} {made_by} {_processor()}"
    digest = hashlib.sha256(where.encode())
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()[:16]


def _processor() -> str:
    """Return what this machine's processor can do; others may not."""
    known = ("vendor_id", "cpu family", "model", "stepping", "flags")
    try:
        with Path("/proc/cpuinfo").open(encoding="utf-8") as lines:
            first = takewhile(str.strip, lines)  # of several processors
            return "".join(line for line in first if line.partition("\t")[0] in known)
    except OSError:  # no Linux, for which no code is kept anyway
        return ""


def keep(file: Path, result: Any, kinds: tuple[Kind, ...]) -> None:
    """Keep what numba has compiled, where it can be loaded without it.

    Args:
        file: see `code_file`.
        result: of the compiler, a `numba.core.compiler.CompileResult`.
        kinds: of the arguments that it was compiled for.

    Raises:
        WorkbenchError: if it is not known how to load it, or it cannot be written.
    """
    try:
        code = _code(result, kinds)
        data = pickle.dumps(tuple(code))
        _in_memory(code)
    except Exception as error:  # numba's inside is others', and changes
        raise WorkbenchError(f"{file}: this code cannot be kept: {error}") from error
    write_atomically(file, hashlib.sha256(data).digest() + data)


def _code(result: Any, kinds: tuple[Kind, ...]) -> _Code:
    """Return what is kept of a `CompileResult`.

    Raises:
        ValueError: if it leads to what only this process has.
    """
    import llvmlite.binding as llvm

    library, own = result.library, result.environment
    if library.has_dynamic_globals or result.objectmode or result.lifted or result.reload_init:
        raise ValueError("it leads to what only this process has")
    _, _, (content, _) = library.serialize_using_object_code()
    entry = result.fndesc.llvm_cpython_wrapper_name
    guard = llvm.parse_assembly(_Guard(kinds, entry).text)
    others = {each.env_name: each.consts for each in result._find_referenced_environments()}
    constants = {own.env_name: own.consts, **{name: each for name, each in others.items() if each}}
    return _Code(entry, constants, content, library.codegen._tm.emit_object(guard))


def load(file: Path) -> Callable[..., Any] | None:
    """Return what a file has as a function for Python; None where there is none that fits.

    Called with arguments of other kinds, it raises `OtherKindError` and does nothing.

    Args:
        file: see `code_file`.
    """
    try:
        data = file.read_bytes()
        if hashlib.sha256(data[_CHECK:]).digest() != data[:_CHECK]:
            return None
        return _function(file.stem, _Code(*pickle.loads(data[_CHECK:])))
    except Exception:  # whatever is wrong with a file, what it should have can be made anew
        return None


def _function(name: str, code: _Code) -> Callable[..., Any]:
    """Return code as a function for Python."""
    loaded, guard = _in_memory(code)
    runtime = _library("_dynfunc")
    environments = []
    for place, constants in code.constants.items():
        environments.append(runtime.Environment({}))
        environments[-1].consts.extend(constants)
        ctypes.c_void_p.from_address(loaded.address(place)).value = id(environments[-1])
    made: Callable[..., Any] = runtime.make_function(
        sys.modules[__name__],
        name,
        "",
        guard.address(_GUARD),
        environments[0],
        (loaded, guard, environments),  # which live as long as it
    )
    return made


def _in_memory(code: _Code) -> tuple["_Loaded", "_Loaded"]:
    """Return code and guard, ready to run.

    Raises:
        ValueError: if they are not what is known here.
    """
    loaded = _Loaded(code.content, {})
    return loaded, _Loaded(code.guard, {code.entry: loaded.address(code.entry)})


class _Loaded:
    """An object file in memory, with all addresses filled in.

    Args:
        content: of the file.
        known: addresses of functions that it may call, besides those of libraries.

    Raises:
        ValueError: if it has what is not known here, or calls what is not there.
    """

    def __init__(self, content: bytes, known: Mapping[str, int]) -> None:
        (machine,) = np.frombuffer(content, "<u2", 1, _MACHINE)
        if not content.startswith(_ELF) or machine != _X86_64:
            raise ValueError("code of another system")
        (table,) = np.frombuffer(content, "<u8", 1, _TABLE_AT)
        (count,) = np.frombuffer(content, "<u2", 1, _TABLE_SIZE)
        sections = np.frombuffer(content, _SECTION, count, table)
        (own,) = sections[sections["type"] == _SYMBOLS]
        symbols = _entries(content, own, _SYMBOL)
        texts = content[sections["offset"][own["link"]] :]
        names = [texts[at : texts.index(b"\0", at)].decode() for at in symbols["name"]]
        if (sections["align"] > _STEP).any():
            raise ValueError("a section that begins where ours cannot")
        kept = (sections["flags"] & _LOADED > 0) & (sections["type"] != _UNWINDING)
        written = sections["flags"] & _WRITTEN > 0
        common = symbols["section"] == _COMMON
        sizes = np.where(kept, sections["size"], 0)
        self._code, code = _room(np.where(written, 0, sizes))
        self._data, data = _room(np.append(np.where(written, sizes, 0), symbols["size"][common]))
        starts = np.where(written, data[:count], code)
        values = symbols["value"].copy()
        inside = (symbols["section"] != _ELSEWHERE) & (symbols["section"] < count)
        values[inside] += starts[symbols["section"][inside]]
        values[common] = data[count:]
        elsewhere = np.flatnonzero(symbols["section"] == _ELSEWHERE)[1:]  # the first is no symbol
        values[elsewhere] = [
            known.get(names[place]) or _address_of(names[place]) for place in elsewhere
        ]
        for section, start in zip(sections[kept], starts[kept].tolist(), strict=True):
            if section["type"] != _EMPTY:
                part = content[section["offset"] :][: section["size"]]
                ctypes.memmove(start, part, len(part))
        for section in sections[sections["type"] == _PLACES]:
            if kept[section["info"]]:
                places = _entries(content, section, _PLACE)
                if (places["kind"] != _ADDRESS).any():
                    raise ValueError("an address that is not whole")
                found = values[places["symbol"]] + places["addend"].view("<u8")
                where = starts[section["info"]] + places["offset"]
                for at, address in zip(where.tolist(), found.tolist(), strict=True):
                    ctypes.c_uint64.from_address(at).value = address
        _make_executable(self._code)
        self._addresses = dict(zip(names, values.tolist(), strict=True))

    def address(self, name: str) -> int:
        """Return where something with a name stands."""
        return self._addresses[name]


def _entries(content: bytes, section: np.void, kind: np.dtype) -> np.ndarray:
    """Return the entries of a section that is a table."""
    many = int(section["size"]) // kind.itemsize
    return np.frombuffer(content, kind, many, int(section["offset"]))


def _room(sizes: np.ndarray) -> tuple[mmap.mmap, np.ndarray]:
    """Return memory for parts of some sizes, and the address of each."""
    whole = -(-sizes.astype("<u8") // _STEP) * _STEP
    memory = mmap.mmap(-1, int(whole.sum()) or 1, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    return memory, _start(memory) + np.cumsum(whole) - whole


def _start(memory: mmap.mmap) -> int:
    return ctypes.addressof(ctypes.c_char.from_buffer(memory))


def _make_executable(memory: mmap.mmap) -> None:
    """Let memory be run, and no longer written.

    Raises:
        ValueError: if the system does not allow that.
    """
    start, size = ctypes.c_void_p(_start(memory)), ctypes.c_size_t(len(memory))
    if ctypes.CDLL(None).mprotect(start, size, mmap.PROT_READ | mmap.PROT_EXEC):
        raise ValueError("memory may not be run here")


def _address_of(name: str) -> int:
    """Return where a function or an object of C, Python or numba's runtime stands.

    Names are those that `numba.core.base` and `numba.core.runtime.nrt` tell LLVM.

    Raises:
        ValueError: if there is none.
    """
    if name == "_Py_NoneStruct":
        return id(None)
    if name.startswith("PyExc_"):
        return id(getattr(builtins, name.removeprefix("PyExc_")))
    module, _, kind = name.rpartition(".")
    if module in sys.modules:  # a type, see `_Guard`
        return id(getattr(sys.modules[module], kind))
    helpers = _library("_helperlib").c_helpers
    runtime = _library("core.runtime._nrt_python").c_helpers
    for known in (helpers, _library("_dynfunc").c_helpers):
        if name.removeprefix("numba_") in known:
            return int(known[name.removeprefix("numba_")])
    if name.removeprefix("NRT_") in runtime:
        return int(runtime[name.removeprefix("NRT_")])
    try:
        found = ctypes.cast(getattr(ctypes.CDLL(None), name), ctypes.c_void_p).value
    except AttributeError:
        found = None
    if not found:
        raise ValueError(f"there is no {name} in this process")
    return found


@lru_cache(maxsize=8)
def _library(name: str) -> ModuleType:
    """Return a library of numba's runtime, without the rest of numba.

    Args:
        name: of the module below `numba`.
    """
    full = f"numba.{name}"
    if full in sys.modules:
        return sys.modules[full]
    package = importlib.util.find_spec("numba")
    assert package and package.submodule_search_locations
    folder = Path(package.submodule_search_locations[0], *name.split(".")[:-1])
    spec = PathFinder.find_spec(full, [str(folder)])
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
