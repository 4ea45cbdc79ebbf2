"""Oracle: the function as Python runs it."""

import ast
import ctypes
import fcntl
import importlib
import importlib.util
import logging
import os
import pickle
import re
import struct
import subprocess
import sys
import textwrap
import threading
import time
import types
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest
from numba.core.caching import IndexDataCacheFile
from numba.core.codegen import JITCPUCodegen

from workbench.common import compiled, jitable
from workbench.control import flight_law
from workbench.design.rollout import compiled_flights
from workbench.systems.casting import solids

SOURCE = """
from numba.extending import register_jitable

@register_jitable
def twice(x):
    return 2.0 * x

def double_up(x):
    return twice(x) + 1.0
"""
MARKER = "workbench.common.jitable"
"""It marks functions; nothing of it is compiled."""
SOURCES, WHAT = ["common/compiled.py"], "twice a number"
ENOUGH = 300.0


class Pair(NamedTuple):
    first: float
    second: float


@pytest.fixture
def double_up(tmp_path, monkeypatch):
    path = tmp_path / "double_up.py"
    path.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location("double_up", path)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "double_up", module)  # code that is loaded imports it
    spec.loader.exec_module(module)
    return module.double_up


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def kept(folder) -> dict[str, int]:
    """Return every file of compiled code with when it was written."""
    return {str(path): path.stat().st_mtime_ns for path in folder.rglob("*.nbc")}


def test_it_computes_the_same_and_keeps_the_code_on_disk(double_up, cache):
    fast = compiled.compile_cached(double_up, SOURCES, WHAT)
    assert fast.signatures == []
    assert fast(1.5) == double_up(1.5) == 4.0
    assert len(kept(cache)) == len(fast.signatures) == 1


def test_a_second_time_the_code_comes_from_disk_without_a_word(double_up, cache, caplog):
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    written = kept(cache)
    assert "compiling" in caplog.text
    caplog.clear()
    assert compiled.compile_cached(double_up, SOURCES, WHAT)(1.5) == 4.0
    assert kept(cache) == written
    assert not caplog.records


def test_a_damaged_file_is_compiled_and_kept_again(double_up, cache, caplog, case):
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    for suffix in (".nbc", ".nbi"):
        (file,) = cache.rglob(f"*{suffix}")
        whole = file.read_bytes()
        for name, content in (
            ("missing", None),
            ("empty", b""),
            ("short", whole[:-1]),
            ("half", whole[: len(whole) // 2]),
            ("another number", whole.replace(struct.pack("<d", 1.0), struct.pack("<d", 3.0))),
            ("zeros, of a system that went down", bytes(len(whole))),
            ("no pickle", b"code"),
            ("of a type that is gone", b"cno.such.module\nKind\n."),
            ("something else", pickle.dumps((1, 2))),
        ):
            if content == whole:
                continue  # the index has no such number
            file.unlink()
            if content is not None:
                file.write_bytes(content)
            with case(suffix, name):
                for again in (True, False):
                    caplog.clear()
                    assert compiled.compile_cached(double_up, SOURCES, WHAT)(1.5) == 4.0
                    assert ("compiled twice a number" in caplog.text) == again
                    assert again or not caplog.records


def test_closures_and_functions_without_a_file_are_kept(cache, caplog):
    made = {"__name__": __name__}
    exec("def half(x):\n    return 0.5 * x", made)

    def scaled(factor):
        return lambda x: factor * x

    for make in (lambda: made["half"], lambda: scaled(0.5)):
        for words in (True, False):
            caplog.clear()
            assert compiled.compile_cached(make(), SOURCES, "a half")(3.0) == 1.5
            assert bool(caplog.records) == words
    assert len(kept(cache)) == 2


def test_each_types_of_arguments_have_their_own_code(cache, caplog):
    locked = np.array([1.0, 2.0])
    locked.setflags(write=False)
    table = [
        np.array([1.0, 2.0]),
        locked,
        np.array([1.0, 0.0, 2.0, 0.0])[::2],
        np.array([1, 2]),
        np.array([1.0, 2.0]).astype("c16"),
        Pair(1.0, 2.0),
        (1.0, 2.0),
    ]
    for words in (True, False):
        caplog.clear()
        fast = compiled.compile_cached(ends, SOURCES, "two ends")
        assert [fast(each) for each in table] == [3.0] * len(table)
        assert len(kept(cache)) == len(fast.signatures) == len(table)
        assert bool(caplog.records) == words


def ends(numbers):
    return numbers[0] + numbers[1]


def test_code_that_leads_elsewhere_in_this_process_is_not_kept(cache):
    root = ctypes.CDLL(None).sqrt
    root.restype, root.argtypes = ctypes.c_double, (ctypes.c_double,)
    assert compiled.compile_cached(lambda x: root(x), SOURCES, "a root")(4.0) == 2.0
    assert not kept(cache)


def test_code_compiled_otherwise_is_not_used(double_up, cache):
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    assert compiled.compile_cached(double_up, SOURCES, WHAT, fastmath={"contract"})(1.5) == 4.0
    assert len(kept(cache)) == 2


def test_code_of_other_sources_is_not_used(cache, monkeypatch, tmp_path, case):
    """The law stands in several files, and numba itself looks at one."""
    monkeypatch.setattr(compiled, "PACKAGE_FOLDER", tmp_path)
    one, other = tmp_path / "one.py", tmp_path / "folder" / "other.py"
    other.parent.mkdir()
    for count, file in enumerate((one, other, one, other)):
        with case(count, file.name):
            file.write_text(f"NUMBER = {count}")
            other.touch()
            one.touch()
            for _ in range(2):
                fast = compiled.compile_cached(ends, ["one.py", "folder"], "two ends")
                assert fast((1.0, 2.0)) == 3.0
            assert len(kept(cache)) == count + 1


def test_code_of_another_machine_or_release_is_not_used(double_up, cache, monkeypatch, case):
    known = compiled.release

    def other(package):
        return lambda name: f"{name}-9.9.dist-info" if name == package else known(name)

    def run(text=""):
        assert compiled.compile_cached(double_up, SOURCES, WHAT, text=text)(1.5) == 4.0
        return len(kept(cache))

    assert run() == 1
    for name, *change in (
        ("Python", sys, "version", "3.99.0"),
        ("numba", compiled, "release", other("numba")),
        ("llvmlite", compiled, "release", other("llvmlite")),
        ("numpy", compiled, "release", other("numpy")),
        ("numba's settings", os, "environ", os.environ | {"NUMBA_OPT": "0"}),
        ("processor", JITCPUCodegen, "magic_tuple", lambda _: ("another",)),
    ):
        with monkeypatch.context() as changed, case(name):
            before = len(kept(cache))
            changed.setattr(*change)
            assert run() == before + 1
    assert run("a user's own") == run() == before + 2


def test_what_is_compiled_is_said(double_up, cache, caplog):
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    assert "compiling twice a number for this machine" in caplog.text


def test_how_far_it_is_is_said_by_the_clock(double_up, cache, caplog, monkeypatch):
    """A first message, others while one function compiles, and a last one."""
    monkeypatch.setattr(compiled, "WAIT_MESSAGE_PERIOD_S", 0.001)
    caplog.set_level(logging.INFO)
    compiled.compile_cached(double_up, SOURCES, WHAT, parts=2)(1.0)
    first, *middle, last = (record.getMessage() for record in caplog.records)
    assert first.startswith("compiling twice a number for this machine")
    told = r"compiling twice a number: (\d+) %, \d+ s"
    shares = [re.fullmatch(told, each)[1] for each in middle]
    assert {"50"} <= set(shares) <= {"0", "50", "99"}
    assert shares == sorted(shares, key=int)
    assert last.startswith("compiled twice a number in ")


def test_one_process_compiles_and_another_waits_for_it(double_up, cache, caplog, monkeypatch):
    """Two that begin at once would both compile for a minute, and each for longer."""
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    (folder,) = cache.rglob("double_up")
    caplog.clear()
    monkeypatch.setattr(compiled, "MAX_SILENT_WAIT_S", 0.0)
    monkeypatch.setattr(compiled, "WAIT_MESSAGE_PERIOD_S", 0.0)
    found = []

    def begin():
        fast = compiled.compile_cached(double_up, SOURCES, WHAT)
        thread = threading.Thread(target=lambda: found.append(fast(1.5)))
        thread.start()
        return thread

    def wait(until):
        deadline = time.monotonic() + ENOUGH
        while not until() and time.monotonic() < deadline:
            time.sleep(0.01)

    with (folder / "lock").open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        begin()
        wait(lambda: found or "waiting" in caplog.text)
        assert found == [4.0]  # what is there is loaded at once
        found.clear()
        for path in folder.rglob("*.nb?"):
            path.unlink()
        waiting = begin()
        wait(lambda: found or caplog.text.count("waiting for another") >= 3)
        assert found == [] == list(kept(cache))
    waiting.join(ENOUGH)
    assert found == [4.0]
    assert caplog.text.count("which compiles twice a number") >= 3  # as long as it waits


def test_where_nothing_can_be_written_it_still_computes(double_up, cache):
    cache.write_text("a file where the folder should be")
    assert compiled.compile_cached(double_up, SOURCES, WHAT)(1.5) == 4.0


def test_where_code_cannot_be_kept_it_still_computes(double_up, cache, monkeypatch):
    def refuses(*_):
        raise OSError("the disk is full")

    monkeypatch.setattr(IndexDataCacheFile, "_open_for_write", refuses)
    fast = compiled.compile_cached(double_up, SOURCES, WHAT)
    assert fast(1.5) == fast(1.5) == 4.0
    assert fast(2) == 5.0
    assert not kept(cache)


def test_threads_that_begin_at_once_share_what_one_compiles(double_up, cache, caplog):
    fast, found = compiled.compile_cached(double_up, SOURCES, WHAT), []
    threads = [threading.Thread(target=lambda: found.append(fast(1.5))) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(ENOUGH)
    assert found == [4.0] * 4
    assert caplog.text.count("compiled twice a number") == 1


def test_with_numba_switched_off_python_computes(cache, monkeypatch):
    """`NUMBA_DISABLE_JIT=1` is how a law is debugged."""
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    ran = []
    fast = compiled.compile_cached(lambda x: ran.append(x) or 2.0 * x, SOURCES, "twice a number")
    assert [fast(1.5), fast(2), fast(0.5)] == [3.0, 4, 1.0]
    assert ran == [1.5, 2, 0.5]
    assert not kept(cache)


@pytest.mark.slow
def test_processes_that_begin_at_once_with_an_empty_cache_agree(cache, tmp_path):
    (tmp_path / "law.py").write_text(SOURCE)
    code = textwrap.dedent(
        """
        import sys
        from law import double_up
        from workbench.common.compiled import compile_cached
        fast = compile_cached(double_up, ["common/compiled.py"], "twice a number")
        print([fast(0.5 * i) for i in range(4)])
        """
    )
    path = os.pathsep.join((str(tmp_path), str(Path(compiled.__file__).parents[2])))
    begun = [
        subprocess.Popen(
            [sys.executable, "-c", code],
            env=os.environ | {"PYTHONPATH": path},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(3)
    ]
    told = [each.communicate(timeout=ENOUGH) for each in begun]
    assert [out.strip() for out, _ in told] == [str([1.0, 2.0, 3.0, 4.0])] * 3
    assert sum("compiled twice a number" in err for _, err in told) == 1
    assert len(kept(cache)) == 1


def test_every_file_of_what_is_compiled_is_watched(case):
    """What compiled code calls of ours, found by following the imports of files that it is in."""
    table = [
        ("workbench.control.flight_law", flight_law.LAW_SOURCES),
        ("workbench.systems.casting.solids", solids.CASTING_SOURCES),
        ("workbench.systems.casting.surfaces", solids.CASTING_SOURCES),
        ("workbench.design.rollout.flights", compiled_flights.ENGINE_SOURCES),
    ]
    for start, sources in table:
        with case(start):
            check_watched(start, sources)


def check_watched(start, sources):
    """Check that all that the compiled code of a module calls of ours is in some files."""
    package = Path(compiled.__file__).parent.parent
    watched = [package / name for name in sources]
    found, todo = set(), [start]
    while todo:
        name = todo.pop()
        found.add(name)
        file = Path(importlib.import_module(name).__file__)
        inside = any(file == one or one in file.parents for one in watched)
        compiles = name == start or "register_jitable" in file.read_text()
        assert inside or name == MARKER or not compiles, name
        if inside:
            tree = ast.parse(file.read_text())
            names = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
            todo += [one for one in names - found if one.startswith("workbench.")]
    assert len(found) > 1


def test_code_that_makes_no_arrays_counts_no_references():
    """numba then has no counting at all: it refuses an array."""

    def first_of_three(x):
        return np.full(3, x)[0]

    with_arrays, without = types.FunctionType(first_of_three.__code__, globals()), first_of_three
    jitable.register_jitable(with_arrays)
    jitable.register_jitable(allocates=False)(without)
    jitable.register_with_numba()
    assert numba.njit(lambda x: with_arrays(x))(2.0) == 2.0
    with pytest.raises(numba.core.errors.NumbaError, match="NRT required"):
        numba.njit(lambda x: without(x))(2.0)
