"""Store machine code that numba compiled, and load it without numba.

Importing numba takes longer than importing Drake, and numba must set up its compiler before it can
load cached code. The compiled code itself needs neither. It is an object file, and its relocations
refer only to functions of C, of Python, and of numba's runtime, which is a separate library.

This module is a linker for the part of the ELF format that LLVM writes for numba on x86-64 (System
V ABI, AMD64 Supplement, chapter 4). Code that uses any other part is not stored, and numba compiles
it in every process. A file is ignored, and its code compiled again, if the file is damaged, or if
it was made for another processor, or by another release of Python, numpy, LLVM or numba.
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
"""Bits of numpy's array flags: C order; Fortran order; C order, aligned and writeable."""
_TYPE, _AXES, _DTYPE, _FLAGS = 8, 24, 56, 64
"""Offsets of an object's type, and of an array's number of axes, dtype and flags [bytes]."""
_BYTE_ORDER, _TYPE_NUMBER = 26, 28
"""Offsets of byte order and type number in a dtype [bytes]."""
_SCALARS: dict[str, tuple[type, ...]] = {
    "none": (type(None),),
    "bool": (bool, np.bool_),
    "int": (int, np.int64),
    "float": (float, np.float64),
}
"""Types that machine code does not distinguish."""
_NUMBERS = (
    *("bool", "float32", "float64", "int8", "int16", "int32", "int64"),
    *("uint8", "uint16", "uint32", "uint64"),
)
"""Names of the supported dtypes of arrays."""
_GUARD = "guard"
"""Name of the function that `_Guard` defines."""
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
_RELOCATION = np.dtype([("offset", "<u8"), ("kind", "<u4"), ("symbol", "<u4"), ("addend", "<i8")])
_ELF, _X86_64, _MACHINE = b"\x7fELF\x02\x01", 62, 18
"""First bytes of a 64-bit little-endian ELF file; machine number, and its offset."""
_TABLE_AT, _TABLE_SIZE = 40, 60
"""Offsets in the header: offset of the section table (8 bytes), and number of sections (2)."""
_SYMBOL_TABLE, _RELOCATIONS, _ZEROS, _UNWINDING = 2, 4, 8, 0x70000001
"""Types of sections: SYMTAB, RELA, NOBITS (zeros that are not in the file), X86_64_UNWIND."""
_WRITEABLE, _LOADED = 0x1, 0x2
"""Flags of sections: WRITE, ALLOC."""
_UNDEFINED, _COMMON = 0, 0xFFF2
"""Section numbers of symbols outside of sections: UNDEF (in another file), and COMMON."""
_ADDRESS = 1
"""The only supported type of relocation: R_X86_64_64, an absolute address of 8 bytes."""
_ALIGNMENT = 64
"""Alignment of sections in memory [bytes], the largest one that a section may require."""


class OtherKindError(TypeError):
    """Machine code was called with arguments of other kinds than it was compiled for."""


class _Code(NamedTuple):
    """The stored code of one function, for arguments of certain kinds.

    Attributes:
        entry: name of the function that numba made for Python.
        constants: of numba's environments, by the symbols of the pointers to them; the first one is
            that of the function itself.
        content: of the object file.
        guard: object file of a function that checks the arguments and then calls the entry.
    """

    entry: str
    constants: dict[str, list[Any]]
    content: bytes
    guard: bytes


Kind = str | tuple[Any, ...]
"""The kind of an argument: the name of a scalar; ("array", dtype, axes, flags) of an array; or the
type of a tuple, followed by the kinds of its parts."""


def kinds_of(args: Sequence[Any]) -> tuple[Kind, ...] | None:
    """Return the kinds of arguments, or None if the kind of one is not supported."""
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
    if isinstance(value, tuple) and "." not in type(value).__qualname__:  # includes named tuples
        parts = kinds_of(value)
        return None if parts is None else (_name_of(type(value)), *parts)
    return None


def _name_of(kind: type) -> str:
    """Return the name of a type with its module, for `_address_of`."""
    return f"{kind.__module__}.{kind.__qualname__}"


class _Guard:
    """LLVM's text of a function that calls another one if its arguments have certain kinds.

    numba's entry for Python checks the number of axes of an array and the size of its numbers, but
    neither their type nor whether they are contiguous. A check costs a nanosecond here, and 0.1 µs
    in Python. Objects are read in the layout that Python and numpy define for compiled extensions
    (`PyObject`, `PyArrayObject_fields`, `PyArray_Descr`).

    Args:
        kinds: of the arguments.
        entry: name of the function to call.
    """

    def __init__(self, kinds: tuple[Kind, ...], entry: str) -> None:
        self._lines: list[str] = []
        self._check_parts("%args", kinds)
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

    def _check_parts(self, whole: str, kinds: tuple[Kind, ...]) -> None:
        size = self._let(f"call i64 @PyTuple_Size(ptr {whole})")
        self._require(f"icmp eq i64 {size}, {len(kinds)}")
        for place, kind in enumerate(kinds):
            part = self._let(f"call ptr @PyTuple_GetItem(ptr {whole}, i64 {place})")
            self._check(part, kind)

    def _check(self, value: str, kind: Kind) -> None:
        if kind == "none":
            self._require(f"icmp eq ptr {value}, @_Py_NoneStruct")
            return
        held = self._field(value, _TYPE, "ptr")
        if isinstance(kind, str):
            same = [f'icmp eq ptr {held}, @"{_name_of(each)}"' for each in _SCALARS[kind]]
            self._require("or i1 " + ", ".join(map(self._let, same)))
        elif kind[0] == "array":
            self._check_array(value, held, *kind[1:])
        else:
            self._require(f'icmp eq ptr {held}, @"{kind[0]}"')
            self._check_parts(value, kind[1:])

    def _check_array(self, value: str, held: str, number: str, axes: int, layout: int) -> None:
        self._require(f'icmp eq ptr {held}, @"numpy.ndarray"')
        self._require(f"icmp eq i32 {self._field(value, _AXES, 'i32')}, {axes}")
        known = _LAYOUT | (layout & _F)
        flags = self._let(f"and i32 {self._field(value, _FLAGS, 'i32')}, {known}")
        self._require(f"icmp eq i32 {flags}, {layout}")
        numbers = self._field(value, _DTYPE, "ptr")
        self._require(
            f"icmp eq i32 {self._field(numbers, _TYPE_NUMBER, 'i32')}, {np.dtype(number).num}"
        )
        self._require(f"icmp ne i8 {self._field(numbers, _BYTE_ORDER, 'i8')}, {ord('>')}")

    def _field(self, of: str, at: int, kind: str) -> str:
        place = self._let(f"getelementptr i8, ptr {of}, i64 {at}")
        return self._let(f"load {kind}, ptr {place}")

    def _let(self, value: str) -> str:
        name = f"%v{len(self._lines)}"
        self._lines.append(f"{name} = {value}")
        return name

    def _require(self, condition: str) -> None:
        fits, then = self._let(condition), f"l{len(self._lines)}"
        self._lines += [f"br i1 {fits}, label %{then}, label %other", f"{then}:"]


def code_file(folder: Path, function: Callable[..., Any], kinds: tuple[Kind, ...]) -> Path:
    """Return the file for the code of a function on this machine.

    Args:
        folder: for all code compiled from the same sources.
        function: the Python function.
        kinds: of its arguments.
    """
    whose = f"{function.__module__} {function.__qualname__} {kinds}"
    digest = hashlib.sha256(whose.encode()).hexdigest()[:16]
    return folder / f"{function.__name__}-{digest}.{_here()}{SUFFIX}"


@lru_cache(maxsize=1)
def _here() -> str:
    """Return a name for everything that code depends on besides its sources.

    That is the processor, Python and its layout of objects, numba's settings, the releases of the
    compilers, and this module.
    """
    settings = sorted(each for each in os.environ.items() if each[0].startswith("NUMBA_"))
    made_by = [release(each) for each in ("numba", "llvmlite", "numpy")]
    where = f"{EXTENSION_SUFFIXES[0]} {sys.version} {settings} {made_by} {_processor()}"
    digest = hashlib.sha256(where.encode())
    digest.update(Path(__file__).read_bytes())
    return digest.hexdigest()[:16]


def _processor() -> str:
    """Return the model and features of the processor, as code may use all of its features."""
    known = ("vendor_id", "cpu family", "model", "stepping", "flags")
    try:
        with Path("/proc/cpuinfo").open(encoding="utf-8") as lines:
            first = takewhile(str.strip, lines)  # several processors are separated by blank lines
            return "".join(line for line in first if line.partition("\t")[0] in known)
    except OSError:  # not Linux, where no code is stored anyway
        return ""


def keep(file: Path, result: Any, kinds: tuple[Kind, ...]) -> None:
    """Store code that numba has compiled.

    Args:
        file: see `code_file`.
        result: of the compiler, a `numba.core.compiler.CompileResult`.
        kinds: of the arguments that it was compiled for.

    Raises:
        WorkbenchError: if this module cannot load such code, or the file cannot be written.
    """
    try:
        code = _code(result, kinds)
        data = pickle.dumps(tuple(code))
        _in_memory(code)
    except Exception as error:  # numba's internals may change with any release
        raise WorkbenchError(f"{file}: this code cannot be kept: {error}") from error
    write_atomically(file, hashlib.sha256(data).digest() + data)


def _code(result: Any, kinds: tuple[Kind, ...]) -> _Code:
    """Return the code of a `CompileResult`, to be stored.

    Raises:
        ValueError: if it refers to objects of this process.
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
    """Return the code in a file as a Python function, or None if there is none that can be used.

    The function raises `OtherKindError` for arguments of other kinds, before it does anything.

    Args:
        file: see `code_file`.
    """
    try:
        data = file.read_bytes()
        if hashlib.sha256(data[_CHECK:]).digest() != data[:_CHECK]:
            return None
        return _function(file.stem, _Code(*pickle.loads(data[_CHECK:])))
    except Exception:  # whatever is wrong with the file, the code can be compiled again
        return None


def _function(name: str, code: _Code) -> Callable[..., Any]:
    """Return code as a Python function."""
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
        (loaded, guard, environments),  # kept alive by the function
    )
    return made


def _in_memory(code: _Code) -> tuple["_Loaded", "_Loaded"]:
    """Return code and guard, ready to run.

    Raises:
        ValueError: if they use an unsupported part of ELF.
    """
    loaded = _Loaded(code.content, {})
    return loaded, _Loaded(code.guard, {code.entry: loaded.address(code.entry)})


class _Loaded:
    """An object file in memory, with all relocations applied.

    Args:
        content: of the file.
        known: addresses of functions that it may call, besides those of libraries.

    Raises:
        ValueError: if it uses an unsupported part of ELF, or refers to an unknown symbol.
    """

    def __init__(self, content: bytes, known: Mapping[str, int]) -> None:
        (machine,) = np.frombuffer(content, "<u2", 1, _MACHINE)
        if not content.startswith(_ELF) or machine != _X86_64:
            raise ValueError("code of another system")
        (table,) = np.frombuffer(content, "<u8", 1, _TABLE_AT)
        (count,) = np.frombuffer(content, "<u2", 1, _TABLE_SIZE)
        sections = np.frombuffer(content, _SECTION, count, table)
        if (sections["align"] > _ALIGNMENT).any():
            raise ValueError("a section that begins where ours cannot")
        kept = (sections["flags"] & _LOADED > 0) & (sections["type"] != _UNWINDING)
        (own,) = sections[sections["type"] == _SYMBOL_TABLE]
        symbols = _entries(content, own, _SYMBOL)
        texts = content[sections["offset"][own["link"]] :]
        names = [texts[at : texts.index(b"\0", at)].decode() for at in symbols["name"]]
        starts, commons = self._allocate(sections, kept, symbols)
        values = self._values(symbols, names, starts, commons, known)
        for section, start in zip(sections[kept], starts[kept].tolist(), strict=True):
            if section["type"] != _ZEROS:
                part = content[section["offset"] :][: section["size"]]
                ctypes.memmove(start, part, len(part))
        for section in sections[sections["type"] == _RELOCATIONS]:
            if kept[section["info"]]:
                relocations = _entries(content, section, _RELOCATION)
                _relocate(relocations, starts[section["info"]], values)
        _make_executable(self._code)
        self._addresses = dict(zip(names, values.tolist(), strict=True))

    def _allocate(
        self, sections: np.ndarray, kept: np.ndarray, symbols: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Allocate memory; return the addresses of all sections, and of the common symbols."""
        writeable = sections["flags"] & _WRITEABLE > 0
        commons = symbols["size"][symbols["section"] == _COMMON]
        sizes = np.where(kept, sections["size"], 0)
        self._code, code = _allocated(np.where(writeable, 0, sizes))
        self._data, data = _allocated(np.append(np.where(writeable, sizes, 0), commons))
        count = len(sections)
        return np.where(writeable, data[:count], code), data[count:]

    def _values(
        self,
        symbols: np.ndarray,
        names: Sequence[str],
        starts: np.ndarray,
        commons: np.ndarray,
        known: Mapping[str, int],
    ) -> np.ndarray:
        """Return the address of each symbol."""
        values = symbols["value"].copy()
        section = symbols["section"]
        inside = (section != _UNDEFINED) & (section < len(starts))
        values[inside] += starts[section[inside]]
        values[section == _COMMON] = commons
        undefined = np.flatnonzero(section == _UNDEFINED)[1:]  # the first entry is not a symbol
        values[undefined] = [known.get(names[at]) or _address_of(names[at]) for at in undefined]
        return values

    def address(self, name: str) -> int:
        """Return the address of a symbol."""
        return self._addresses[name]


def _entries(content: bytes, section: np.void, kind: np.dtype) -> np.ndarray:
    """Return the entries of a section that is a table."""
    count = int(section["size"]) // kind.itemsize
    return np.frombuffer(content, kind, count, int(section["offset"]))


def _relocate(relocations: np.ndarray, start: np.uint64, values: np.ndarray) -> None:
    """Write the address of a symbol at each relocation of a section that starts at an address.

    Raises:
        ValueError: if the type of a relocation is not supported.
    """
    if (relocations["kind"] != _ADDRESS).any():
        raise ValueError("an address that is not whole")
    addresses = values[relocations["symbol"]] + relocations["addend"].view("<u8")
    places = start + relocations["offset"]
    for at, address in zip(places.tolist(), addresses.tolist(), strict=True):
        ctypes.c_uint64.from_address(at).value = address


def _allocated(sizes: np.ndarray) -> tuple[mmap.mmap, np.ndarray]:
    """Return memory for parts of some sizes, and the address of each."""
    whole = -(-sizes.astype("<u8") // _ALIGNMENT) * _ALIGNMENT
    memory = mmap.mmap(-1, int(whole.sum()) or 1, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    return memory, _start(memory) + np.cumsum(whole) - whole


def _start(memory: mmap.mmap) -> int:
    return ctypes.addressof(ctypes.c_char.from_buffer(memory))


def _make_executable(memory: mmap.mmap) -> None:
    """Make memory executable and read-only.

    Raises:
        ValueError: if the system does not allow it.
    """
    start, size = ctypes.c_void_p(_start(memory)), ctypes.c_size_t(len(memory))
    if ctypes.CDLL(None).mprotect(start, size, mmap.PROT_READ | mmap.PROT_EXEC):
        raise ValueError("memory may not be run here")


def _address_of(name: str) -> int:
    """Return the address of a function or object of C, Python or numba's runtime.

    Names are those that `numba.core.base` and `numba.core.runtime.nrt` register with LLVM.

    Raises:
        ValueError: if it is unknown.
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
    """Load a library of numba's runtime without the rest of numba, and return it.

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
