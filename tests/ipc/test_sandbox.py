"""The kernel's limits, tried from inside by code that may do all that Python and C can."""

import os
import re
from pathlib import Path

import pytest

from tests.ipc import attempts
from workbench.ipc import call_filter, sandbox
from workbench.ipc.limited import FORBIDDEN_CLAUSE, LimitedError, run_limited, run_trusted

MISSING = sandbox.missing_protections()
held = pytest.mark.skipif(bool(MISSING), reason=f"not tested: the kernel lacks {MISSING}")
"""Where the kernel has all limits, nothing here is skipped."""
DENIED = {"EPERM", "EACCES", "ENOSYS"}
HARMLESS = set(attempts.ATTEMPTS) - {*attempts.NUMBERS, "clone with its memory", "reads_the_parent"}
"""Attempts that any user's process may make without damage."""


@pytest.fixture
def asked(tmp_path, monkeypatch):
    """Files of a test, and the module of attempts on the child's path."""
    monkeypatch.setenv("PYTHONPATH", str(Path(attempts.__file__).parent))
    folder, outside = tmp_path / "own", tmp_path / "outside"
    for each in (folder, outside):
        each.mkdir()
    (folder / "drone.urdf").write_text("<robot/>")
    for name in ("secret", "doomed"):
        (outside / name).write_text("private")
    (folder / "link").symlink_to(outside / "secret")
    return {
        "own": str(folder / "drone.urdf"),
        "secret": str(outside / "secret"),
        "doomed": str(outside / "doomed"),
        "target": str(outside / "made"),
        "link": str(folder / "link"),
        "folder": "",
        "again": False,
        "attempts": list(attempts.ATTEMPTS),
    }


def run(asked, by=run_limited, **more):
    return by("attempts", asked, seconds=20.0, megabytes=1000, **more)


@held
@pytest.mark.parametrize("may_write", [False, True], ids=["reader", "writer"])
def test_a_held_process_gets_nothing_but_its_files(asked, tmp_path, may_write):
    own = tmp_path / "own"
    (tmp_path / "written").mkdir()
    asked["folder"] = str(tmp_path / "written") if may_write else ""
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    found = run(asked, reads=[own], writes=[asked["folder"]] if may_write else [])
    allowed = found.pop("allowed")
    assert allowed["read"] == 8
    assert allowed.get("written") == (["renamed"] if may_write else None)
    assert len(found) > 70
    assert {name: said for name, said in found.items() if said not in DENIED} == {}
    after = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    assert after == before | ({tmp_path / "written" / "renamed": b"abc"} if may_write else {})


def test_each_attempt_is_a_real_one(asked):
    """The same code succeeds in a process that the kernel does not hold."""
    found = run(asked | {"attempts": sorted(HARMLESS), "again": True}, by=run_trusted)
    del found["allowed"]
    assert found == dict.fromkeys(found, "done") | {"executes": "ENOENT"}


@held
@pytest.mark.skipif(os.uname().machine != "x86_64", reason="not tested: x32 is of x86-64 only")
def test_a_call_of_another_architecture_ends_the_process(asked):
    with pytest.raises(LimitedError, match="Bad system call"):
        run(asked | {"kill": "x32"}, reads=[])
    assert run(asked | {"kill": "no"}, reads=[]) == "lives"


@held
def test_what_the_kernel_stops_is_a_sentence(asked):
    with pytest.raises(LimitedError, match=f"{FORBIDDEN_CLAUSE}: .*{asked['secret']}"):
        run(asked | {"own": asked["secret"]}, reads=[asked["own"]])


@held
def test_a_thread_that_landlock_would_not_bind_is_refused(asked, tmp_path, monkeypatch):
    start = "import threading, time\nthreading.Thread(target=time.sleep, args=(9,), daemon=True)"
    (tmp_path / "sitecustomize.py").write_text(f"{start}.start()\n")
    path = f"{tmp_path}{os.pathsep}{os.environ['PYTHONPATH']}"
    monkeypatch.setenv("PYTHONPATH", path)
    with pytest.raises(LimitedError, match="does not bound its process: .*second thread"):
        run(asked)


def test_what_the_kernel_has_is_found():
    """By /proc and /sys, so that a fault of `lacking` does not skip the tests above."""
    release = tuple(map(int, re.findall(r"\d+", os.uname().release)[:2]))
    modules = Path("/sys/kernel/security/lsm")
    symbols = Path("/proc/kallsyms")
    if modules.is_file():
        has_landlock = "landlock" in modules.read_text()
    else:
        has_landlock = symbols.is_file() and "landlock_restrict_self" in symbols.read_text()
    if has_landlock and release >= (6, 2):
        assert not any("Landlock" in each for each in MISSING)
    if "Seccomp_filters" in Path("/proc/self/status").read_text():
        assert "seccomp filters" not in MISSING


def test_a_kernel_without_limits_is_named(monkeypatch):
    for module in (sandbox, call_filter):
        monkeypatch.setattr(module, "system_call", lambda *_: -1)
    assert sandbox.missing_protections() == ("seccomp filters", "Landlock of ABI 3 (Linux 6.2)")
    sandbox.confine([], [])  # the limits of time and memory remain


@pytest.mark.parametrize(
    ("header", "column"),
    [
        ("/usr/include/x86_64-linux-gnu/asm/unistd_64.h", 0),
        ("/usr/include/asm-generic/unistd.h", 1),
    ],
)
def test_the_numbers_of_system_calls_are_those_of_the_kernel(header, column):
    """aarch64 has the generic numbers; some have the prefix of 32-bit variants there."""
    if not Path(header).is_file():
        pytest.skip(f"not tested: there is no {header}")
    lines = re.findall(r"#define __NR(?:3264)?_(\w+)\s+(\d+)", Path(header).read_text())
    numbers = {name: int(number) for name, number in lines}
    numbers.setdefault("newfstatat", numbers.get("fstatat", 0))
    tables = (
        call_filter._ALLOWED_CALLS,
        call_filter._WRITE_CALLS,
        call_filter._OPEN_CALLS,
        call_filter._FILTERED_CALLS,
    )
    ours = {name: found[column] for table in tables for name, found in table.items()}
    ours |= {name: found[column] for name, found in attempts.NUMBERS.items()}
    assert ours == {name: numbers.get(name) for name in ours}
