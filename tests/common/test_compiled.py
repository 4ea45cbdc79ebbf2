"""Oracle: the function as Python runs it."""

import ast
import fcntl
import importlib
import importlib.util
import logging
import os
import re
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path

import numba
import numpy as np
import pytest

from workbench.common import compiled
from workbench.common.errors import WorkbenchError
from workbench.control import flight_law
from workbench.design.rollout import engine
from workbench.systems.casting import solids, surfaces

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


@pytest.fixture
def double_up(tmp_path):
    path = tmp_path / "double_up.py"
    path.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location("double_up", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.double_up


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def machine_code(folder) -> dict[str, int]:
    """Return every file of machine code with when it was written."""
    return {str(path): path.stat().st_mtime_ns for path in folder.rglob("*.code")}


def test_it_computes_the_same_and_keeps_the_code_on_disk(double_up, cache):
    fast = compiled.compile_cached(double_up, SOURCES, WHAT)
    assert fast(1.5) == double_up(1.5) == 4.0
    assert len(machine_code(cache)) == 1


def test_a_second_time_the_code_comes_from_disk_without_a_word(double_up, cache, caplog):
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    written = machine_code(cache)
    assert "compiling" in caplog.text
    caplog.clear()
    assert compiled.compile_cached(double_up, SOURCES, WHAT)(1.5) == 4.0
    assert machine_code(cache) == written
    assert not caplog.records

    fast = compiled.compile_cached(double_up, SOURCES, WHAT)
    fast(1.5)
    (code,) = cache.rglob("*.code")
    whole = code.read_bytes()
    code.write_bytes(whole[:-1])
    assert compiled.compile_cached(double_up, SOURCES, WHAT)(1.5) == 4.0
    assert len(code.read_bytes()) >= len(whole)


def test_code_compiled_otherwise_is_not_used(double_up, cache):
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    assert compiled.compile_cached(double_up, SOURCES, WHAT, fastmath={"contract"})(1.5) == 4.0
    assert len(machine_code(cache)) == 2


def test_code_of_other_sources_is_not_used(double_up, cache):
    """The law stands in several files, and numba itself looks at one."""
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    assert compiled.compile_cached(double_up, ["common"], WHAT)(1.5) == 4.0
    assert len(machine_code(cache)) == 2


def test_what_is_compiled_is_said(double_up, cache, caplog):
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    assert "compiling twice a number for this machine" in caplog.text


def test_how_far_it_is_is_said_by_the_clock(double_up, cache, caplog, monkeypatch):
    """A first message, others while one function compiles, and a last one."""
    monkeypatch.setattr(compiled, "PERIOD", 0.001)
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
    for path in folder.rglob("*.code"):
        path.unlink()
    caplog.clear()
    monkeypatch.setattr(compiled, "PATIENCE", 0.0)
    monkeypatch.setattr(compiled, "PERIOD", 0.0)
    one = compiled.compile_cached(double_up, SOURCES, WHAT)
    with (folder / "lock").open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        found = []
        waiting = threading.Thread(target=lambda: found.append(one(1.5)))
        waiting.start()
        deadline = time.monotonic() + ENOUGH
        while caplog.text.count("waiting for another") < 3 and time.monotonic() < deadline:
            time.sleep(0.01)
        assert found == [] == list(machine_code(cache))
    waiting.join(ENOUGH)
    assert found == [4.0]
    assert caplog.text.count("which compiles twice a number") >= 3  # as long as it waits


def test_where_nothing_can_be_written_it_still_computes(double_up, cache):
    cache.write_text("a file where the folder should be")
    assert compiled.compile_cached(double_up, SOURCES, WHAT)(1.5) == 4.0


def test_where_code_cannot_be_kept_or_loaded_it_still_computes(double_up, cache, case, monkeypatch):
    def refuses(*_):
        raise WorkbenchError("the disk is full")

    for name, function in (("keep", refuses), ("load", lambda _: None)):
        with case(name), monkeypatch.context() as changed:
            changed.setattr(compiled, name, function)
            fast = compiled.compile_cached(double_up, SOURCES, WHAT)
            assert fast(1.5) == fast(1.5) == 4.0
            assert fast(2) == 5.0


def test_numbers_that_machine_code_refuses_are_computed_by_numba(cache):
    """numpy has two types of whole numbers of 64 bits; the guard knows one of them."""
    fast = compiled.compile_cached(total, SOURCES, "a total")
    long, longlong = (np.array([1, 2, 4], each) for each in (np.dtype("l"), np.dtype("q")))
    assert long.dtype == longlong.dtype
    for numbers in (long, longlong, longlong, long):
        assert fast(numbers) == 7


def test_arguments_that_are_not_known_here_are_compiled_once(cache, monkeypatch):
    """Complex numbers are numba's to know."""
    fast = compiled.compile_cached(total, SOURCES, "a total")
    parts = (np.array([1.0, 2.0]).astype("c16"),)
    assert compiled.kinds_of(parts) is None
    assert fast(*parts) == 3.0
    with monkeypatch.context() as changed:
        changed.setattr(compiled, "_told", None)  # compiling calls it
        assert [fast(*parts), fast(*parts)] == [3.0, 3.0]
    assert fast(np.array([1.0, 4.0])) == 5.0


def test_with_numba_switched_off_python_computes(cache, monkeypatch):
    """`NUMBA_DISABLE_JIT=1` is how a law is debugged."""
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    ran = []
    fast = compiled.compile_cached(lambda x: ran.append(x) or 2.0 * x, SOURCES, "twice a number")
    assert [fast(1.5), fast(2), fast(0.5)] == [3.0, 4, 1.0]
    assert ran == [1.5, 2, 0.5]
    assert not machine_code(cache)


def total(numbers):
    return numbers.sum()


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
    assert len(machine_code(cache)) == 1


def test_every_file_of_what_is_compiled_is_watched(case):
    """What compiled code calls of ours, found by following the imports of files that it is in."""
    table = [
        ("workbench.control.flight_law", flight_law.SOURCES),
        ("workbench.systems.casting.solids", solids.SOURCES),
        ("workbench.systems.casting.surfaces", surfaces.SOURCES),
        ("workbench.design.rollout.flight", engine.SOURCES),
    ]
    package = Path(compiled.__file__).parent.parent
    for start, sources in table:
        watched = [package / name for name in sources]
        found, todo = set(), [start]
        while todo:
            name = todo.pop()
            found.add(name)
            file = Path(importlib.import_module(name).__file__)
            inside = any(file == one or one in file.parents for one in watched)
            with case(start, name):
                compiles = name == start or "register_jitable" in file.read_text()
                assert inside or name == MARKER or not compiles
            if inside:
                tree = ast.parse(file.read_text())
                names = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
                todo += [one for one in names - found if one.startswith("workbench.")]
        assert len(found) > 1
