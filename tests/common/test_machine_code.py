"""Oracle: the function as Python runs it, and numba's own dispatcher for kinds of arguments."""

import ctypes
import hashlib
import pickle
import subprocess
import sys
import textwrap
import threading
from typing import NamedTuple

import numba
import numpy as np
import pytest

from workbench.common import machine_code
from workbench.common.errors import WorkbenchError
from workbench.common.machine_code import (
    _CHECK,
    OtherKindError,
    _Code,
    code_file,
    keep,
    kinds_of,
    load,
)


def work(scale, numbers, pair, some, out):
    """Use what numba's runtime has: memory, exceptions, functions of C, arrays, tuples."""
    if scale < 0.0:
        raise ValueError("a scale below zero", 7)
    middle = np.empty(len(numbers))
    for i in range(len(numbers)):
        middle[i] = scale * np.sin(numbers[i]) ** pair[0] / pair[1]
    out[:] = middle + (0.0 if some is None else 1.0)
    return middle.sum(), len(numbers)


class Pair(NamedTuple):
    """As `work` takes, with names."""

    first: float
    second: int


ARGUMENTS = (0.7, np.linspace(0.1, 3.0, 9), (2.5, 3), None, np.zeros(9))


def made(function, arguments, folder):
    """Return a file with the machine code of a function for some arguments."""
    dispatcher = numba.njit(function)
    kinds, types = kinds_of(arguments), tuple(map(numba.typeof, arguments))
    dispatcher.compile(types)
    file = code_file(folder, function, kinds)
    keep(file, dispatcher.overloads[types], kinds)
    return file


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    return made(work, ARGUMENTS, tmp_path_factory.mktemp("code"))


def test_what_is_loaded_equals_numba_to_the_bit(file):
    run, fast = load(file), numba.njit(work)
    wanted, out = [*ARGUMENTS[:-1], np.zeros(9)], np.zeros(9)
    assert run(*ARGUMENTS[:-1], out) == fast(*wanted)
    np.testing.assert_array_equal(out, wanted[-1])
    assert out.any()


def test_exceptions_are_those_of_the_function(file):
    with pytest.raises(ValueError, match="a scale below zero") as raised:
        load(file)(-1.0, *ARGUMENTS[1:])
    assert raised.value.args[1] == 7
    with pytest.raises(ZeroDivisionError):
        load(file)(1.0, ARGUMENTS[1], (2.5, 0), *ARGUMENTS[3:])


def test_a_process_that_loads_it_does_not_load_numba(file):
    text = f"""
        import sys
        from pathlib import Path
        import numpy as np
        from workbench.common.machine_code import load
        run, out = load(Path({str(file)!r})), np.zeros(9)
        found = run(0.7, np.linspace(0.1, 3.0, 9), (2.5, 3), None, out)
        assert not {{"numba", "llvmlite"}} & set(sys.modules), "loaded"
        import numba
        again = numba.njit(lambda x: np.full(3, x).sum())(2.0)  # its runtime begins beside ours
        assert again == 6.0 and run(0.7, np.linspace(0.1, 3.0, 9), (2.5, 3), None, out) == found
        print(repr(found))
        """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(text)], capture_output=True, text=True, check=False
    )
    wanted = load(file)(*ARGUMENTS[:-1], np.zeros(9))
    assert (done.stderr, done.stdout.strip()) == ("", repr(wanted))


def test_only_arguments_that_it_was_made_for_reach_machine_code(file, case):
    """numba tells these apart by their types; the code itself would read wrong numbers."""
    run, (scale, numbers, pair, some, out) = load(file), ARGUMENTS
    frozen = out.copy()
    frozen.flags.writeable = False
    odd = np.frombuffer(b"\0" * (8 * 9 + 1), np.uint8)[1:].view(np.float64)
    same = [
        ("numpy's float", (np.float64(scale), numbers, pair, some, out)),
        ("numpy's int", (scale, numbers, (2.5, np.int64(3)), some, out)),
        ("from afar", (scale, np.frombuffer(numbers.tobytes()).copy(), pair, some, out)),
    ]
    others = [
        ("an int for a float", (1, numbers, pair, some, out)),
        ("numbers of 32 bits", (scale, numbers.astype("f4"), pair, some, out)),
        ("whole numbers", (scale, numbers.astype("i8"), pair, some, out)),
        ("other bytes first", (scale, numbers.astype(">f8"), pair, some, out)),
        ("every other number", (scale, np.repeat(numbers, 2)[::2], pair, some, out)),
        ("two axes", (scale, numbers[None], pair, some, out)),
        ("a list", (scale, list(numbers), pair, some, out)),
        ("what may not be written", (scale, numbers, pair, some, frozen)),
        ("between addresses", (scale, odd, pair, some, out)),
        ("a longer tuple", (scale, numbers, (2.5, 3, 1), some, out)),
        ("a float in a tuple", (scale, numbers, (2.5, 3.0), some, out)),
        ("a list for a tuple", (scale, numbers, [2.5, 3], some, out)),
        ("a tuple with names", (scale, numbers, Pair(2.5, 3), some, out)),
        ("something for None", (scale, numbers, pair, 1.0, out)),
        ("None for something", (scale, None, pair, some, out)),
        ("one too few", (scale, numbers, pair, some)),
        ("one too many", (*ARGUMENTS, 1.0)),
    ]
    wanted = run(*ARGUMENTS)
    for name, arguments in same:
        with case(name):
            assert kinds_of(arguments) == kinds_of(ARGUMENTS)
            assert list(map(numba.typeof, arguments)) == list(map(numba.typeof, ARGUMENTS))
            assert run(*arguments) == wanted
    for name, arguments in others:
        with case(name):
            assert kinds_of(arguments) != kinds_of(ARGUMENTS)
            with pytest.raises(OtherKindError):
                run(*arguments)


def test_tuples_with_names_are_told_apart(tmp_path):
    pairs = Pair(1.0, 2), (1.0, 2)
    run = load(made(lambda pair: pair.first + pair.second, pairs[:1], tmp_path))
    assert run(pairs[0]) == 3.0
    with pytest.raises(OtherKindError):
        run(pairs[1])


def test_threads_run_it_at_once(file):
    run, found = load(file), []
    wanted = run(*ARGUMENTS[:-1], np.zeros(9))

    def many():
        found.append({run(*ARGUMENTS[:-1], np.zeros(9)) for _ in range(2000)})

    threads = [threading.Thread(target=many) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [{wanted}] * 4


def test_code_that_leads_elsewhere_in_this_process_is_not_kept(tmp_path):
    root = ctypes.CDLL(None).sqrt
    root.restype, root.argtypes = ctypes.c_double, (ctypes.c_double,)
    with pytest.raises(WorkbenchError, match="only this process has"):
        made(lambda x: root(x), (2.0,), tmp_path)
    assert not list(tmp_path.iterdir())


def test_code_is_not_run_where_a_function_that_it_calls_is_missing(file, monkeypatch):
    missing = {**machine_code._library("_helperlib").c_helpers}
    del missing["do_raise"]
    monkeypatch.setattr(machine_code._library("_helperlib"), "c_helpers", missing)
    assert load(file) is None


def test_a_function_that_calls_itself_is_kept(tmp_path):
    fall = numba.njit(lambda x: 1.0 if x < 1.0 else x * fall(x - 1.0))
    assert fall(5.0) == 120.0
    file = tmp_path / "fall"
    keep(file, fall.overloads[(numba.float64,)], kinds_of((5.0,)))
    assert load(file)(5.0) == 120.0


def test_a_file_that_is_damaged_is_none(file, tmp_path, case):
    whole = file.read_bytes()
    code = _Code(*pickle.loads(whole[_CHECK:]))
    machine, table = code.content.index(b"\x3e\0"), int.from_bytes(code.content[40:48], "little")
    assert machine == 18
    arm = code.content[:18] + b"\xb7\0" + code.content[20:]
    wide = table + 64 + 48  # of the first section that is one
    page = code.content[:wide] + (4096).to_bytes(8, "little") + code.content[wide + 8 :]
    for name, content in (
        ("missing", None),
        ("empty", b""),
        ("short", whole[:-1]),
        ("long", whole + b"\0"),
        ("a bit", whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:]),
        ("zeros, of a system that went down", bytes(len(whole))),
        ("no pickle", checked(b"code")),
        ("a part of it", checked(pickle.dumps(code[:-1]))),
        ("something else", checked(pickle.dumps((1, 2, 3, 4)))),
        ("of a type that is gone", checked(b"cno.such.module\nKind\n.")),
        ("for another processor", checked(pickle.dumps(tuple(code._replace(content=arm))))),
        ("in pages", checked(pickle.dumps(tuple(code._replace(content=page))))),
        ("cut within", checked(pickle.dumps(tuple(code._replace(content=code.content[:-900]))))),
        ("Windows", checked(pickle.dumps(tuple(code._replace(content=b"MZ" + bytes(900)))))),
        ("no entry", checked(pickle.dumps(tuple(code._replace(entry="another"))))),
    ):
        path = tmp_path / name
        if content is not None:
            path.write_bytes(content)
        with case(name):
            assert load(path) is None
    with case("whole"):
        (tmp_path / "whole").write_bytes(checked(pickle.dumps(tuple(code))))
        assert load(tmp_path / "whole")(*ARGUMENTS) == load(file)(*ARGUMENTS)


def checked(data):
    """Return what is whole by its check."""
    return hashlib.sha256(data).digest() + data


@pytest.fixture
def elsewhere():
    """Let the machine be told anew, before and after a test."""
    machine_code._here.cache_clear()
    yield
    machine_code._here.cache_clear()


@pytest.mark.usefixtures("elsewhere")
def test_code_of_another_machine_or_release_has_another_name(file, monkeypatch, tmp_path, case):
    known = machine_code.release
    ours = tmp_path / "machine_code.py"
    ours.write_text("# another way to load")

    def other(package):
        return lambda name: f"{name}-9.9.dist-info" if name == package else known(name)

    table = [
        ("processor", machine_code, "_processor", lambda: "flags: none"),
        ("Python", sys, "version", "3.99.0"),
        ("layout of objects", machine_code, "EXTENSION_SUFFIXES", [".cpython-399t.so"]),
        ("numba", machine_code, "release", other("numba")),
        ("llvmlite", machine_code, "release", other("llvmlite")),
        ("numpy", machine_code, "release", other("numpy")),
        ("numba's settings", machine_code.os, "environ", {"NUMBA_OPT": "0"}),
        ("loader", machine_code, "__file__", str(ours)),
    ]
    kinds, seen = kinds_of(ARGUMENTS), {file}
    assert code_file(file.parent, work, kinds) == file
    for name, *change in table:
        with monkeypatch.context() as changed, case(name):
            machine_code._here.cache_clear()
            changed.setattr(*change)
            assert code_file(file.parent, work, kinds) not in seen
            seen.add(code_file(file.parent, work, kinds))


def test_a_processor_that_cannot_be_told_is_no_error(monkeypatch, tmp_path, case):
    for name, text in (("none", None), ("one, and no empty line", "vendor_id\t: A\nflags\t: b")):
        place = tmp_path / name
        if text:
            place.write_text(text)
        monkeypatch.setattr(machine_code, "Path", lambda _, place=place: place)
        with case(name):
            assert machine_code._processor() == (text or "")
