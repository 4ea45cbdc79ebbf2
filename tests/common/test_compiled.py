"""Oracle: the function as Python runs it."""

import ast
import fcntl
import importlib
import importlib.util
import logging
import threading
import time
from pathlib import Path

import numba
import pytest

from workbench.common import compiled
from workbench.control import flight_law
from workbench.design.rollout import engine
from workbench.systems import vehicle_dynamics
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
ENOUGH = 120.0


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
    return {str(path): path.stat().st_mtime_ns for path in folder.rglob("*.nbc")}


def test_it_computes_the_same_and_keeps_the_code_on_disk(double_up, cache):
    before = numba.config.CACHE_DIR
    fast = compiled.compile_cached(double_up, SOURCES, WHAT)
    assert fast(1.5) == double_up(1.5) == 4.0
    assert before == numba.config.CACHE_DIR
    assert len(machine_code(cache)) == 1


def test_a_second_time_the_code_comes_from_disk_without_a_word(double_up, cache, caplog):
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    written = machine_code(cache)
    assert "compiling" in caplog.text
    caplog.clear()
    assert compiled.compile_cached(double_up, SOURCES, WHAT)(1.5) == 4.0
    assert machine_code(cache) == written
    assert not caplog.records


def test_code_that_was_never_whole_is_not_made(double_up, cache):
    fast = compiled.compile_cached(double_up, SOURCES, WHAT)
    assert not fast.is_made
    fast(1.5)
    (code,) = cache.rglob("*.nbc")
    again = compiled.compile_cached(double_up, SOURCES, WHAT)
    assert again.is_made
    code.unlink()
    assert any(cache.rglob("*.nbi")) and not again.is_made


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


def test_how_far_it_is_is_said(double_up, cache, caplog, monkeypatch):
    monkeypatch.setattr(compiled, "PERIOD", 0.0)
    caplog.set_level(logging.INFO)
    compiled.compile_cached(double_up, SOURCES, WHAT, parts=2)(1.0)
    first, middle, last = (record.getMessage() for record in caplog.records)
    assert first.startswith("compiling twice a number for this machine")
    assert middle == "compiling twice a number: 50 %"
    assert last.startswith("compiled twice a number in ")


def test_one_process_compiles_and_another_waits_for_it(double_up, cache, caplog, monkeypatch):
    """Two that begin at once would both compile for a minute, and each for longer."""
    compiled.compile_cached(double_up, SOURCES, WHAT)(1.0)
    (folder,) = cache.rglob("double_up")
    for path in [each for each in folder.rglob("*") if each.suffix in (".nbc", ".nbi")]:
        path.unlink()
    caplog.clear()
    monkeypatch.setattr(compiled, "PATIENCE", 0.0)
    one = compiled.compile_cached(double_up, SOURCES, WHAT)
    with (folder / "lock").open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        found = []
        waiting = threading.Thread(target=lambda: found.append(one(1.5)))
        waiting.start()
        deadline = time.monotonic() + ENOUGH
        while "waiting for another process" not in caplog.text and time.monotonic() < deadline:
            time.sleep(0.01)
        assert found == [] == list(machine_code(cache))
    waiting.join(ENOUGH)
    assert found == [4.0]
    assert "which compiles twice a number" in caplog.text


def test_where_nothing_can_be_written_it_still_computes(double_up, cache):
    cache.write_text("a file where the folder should be")
    assert compiled.compile_cached(double_up, SOURCES, WHAT)(1.5) == 4.0


def test_every_file_of_what_is_compiled_is_watched(case):
    """What compiled code calls of ours, found by following the imports of files that it is in."""
    table = [
        ("workbench.control.flight_law", flight_law.SOURCES),
        ("workbench.systems.vehicle_dynamics", vehicle_dynamics.SOURCES),
        ("workbench.systems.casting.solids", solids.SOURCES),
        ("workbench.systems.casting.surfaces", surfaces.SOURCES),
        ("workbench.design.rollout.flight", engine.SOURCES),
        ("workbench.design.rollout.measuring", engine.SOURCES),
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
                assert inside or name == MARKER or "register_jitable" not in file.read_text()
            if inside:
                tree = ast.parse(file.read_text())
                names = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
                todo += [one for one in names - found if one.startswith("workbench.")]
        assert len(found) > 1
