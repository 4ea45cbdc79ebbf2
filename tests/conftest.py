"""No test needs a screen, none hangs for ever, and all leave what they made to be collected."""

import faulthandler
import gc
import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

collect_ignore = ["outside/given"]  # specs and tests that tools/outside.py has others run

# before Qt or matplotlib is imported
os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("MPLBACKEND", "Agg")
# the oracle of many tests is the diagram, whatever a machine has compiled before
os.environ.setdefault("WORKBENCH_FLY_ON", "diagram")
# before numpy is imported: threads of its own for small matrices wait busily for each other where
# other processes have the cores, and a test of a second takes fifteen
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# a shell lets what runs in the background ignore Ctrl-C, and nohup a closed terminal, and so would
# all that the tests start
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)

# Drake ends the process where a Meshcat, and Qt where a widget, is collected in another thread than
# its own: so Python collects nothing by itself, and all is collected here, between tests.
gc.disable()
_COLLECT_EVERY, _COLLECT_ALL_EVERY = 50, 500
"""So many tests: what was made since the last time, and all, which takes a tenth of a second."""


@pytest.fixture(autouse=True)
def collected(request):
    """Collect what earlier tests left, now and then, in the main thread."""
    count = request.config.stash.get(_COUNT, 0) + 1
    request.config.stash[_COUNT] = count
    if count % _COLLECT_EVERY == 0:
        gc.collect(2 if count % _COLLECT_ALL_EVERY == 0 else 1)


_COUNT = pytest.StashKey[int]()


def pytest_collection_finish():
    """Leave what was imported and collected out of every later search for garbage.

    Their garbage stays, too: to find its 150,000 objects takes 0.7 s in each worker.
    """
    gc.freeze()


@pytest.fixture(scope="session")
def case():
    """Return what names the row of a table that fails: a table is a loop, not an item a row."""
    return named


@contextmanager
def named(*row: object) -> Iterator[None]:
    try:
        yield
    except BaseException as failure:
        failure.add_note(f"in the case {', '.join(map(repr, row))}")
        raise


LIMIT, SLOW_LIMIT = 600.0, 1200.0
"""Seconds of a test with its set-up and tear-down; what takes longer hangs, on any machine."""
_WATCH_EVERY = 5.0
"""Seconds: the watchdog is set anew after these at most, as each time takes a millisecond."""
_STDERR = pytest.StashKey[int]()
_WATCHED = pytest.StashKey[tuple[float, float]]()


def pytest_configure(config):
    config.stash[_STDERR] = os.dup(2)  # pytest captures nothing yet, and what is said here is seen


def pytest_unconfigure(config):
    """End the process, too, if it does not end by itself, as with a thread that nobody ended."""
    faulthandler.dump_traceback_later(LIMIT, exit=True, file=config.stash[_STDERR])


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item):
    """End the process with the stacks of all threads, in which the test is named, if it hangs.

    The watchdog is one of C: it also ends a test that waits in Drake or Qt with Python's lock.
    `faulthandler_timeout` of pytest is the same, but leaves a tear-down after a failure alone.
    """
    begun, before = item.config.stash.get(_WATCHED, (-LIMIT, 0.0))
    if _limit(item) != before or time.monotonic() - begun > _WATCH_EVERY:
        _watch(item)


@pytest.hookimpl(trylast=True)
def pytest_exception_interact(node):
    """Watch the tear-down, too: pytest itself has just ended the watch, for a debugger."""
    _watch(node)


def _limit(node):
    return SLOW_LIMIT if node.get_closest_marker("slow") else LIMIT


def _watch(node):
    limit, stash = _limit(node), node.config.stash
    stash[_WATCHED] = time.monotonic(), limit
    faulthandler.dump_traceback_later(limit, exit=True, file=stash[_STDERR])


def pytest_addoption(parser):
    parser.addoption(
        "--allowed-skips",
        metavar="FILE",
        type=Path,
        help="fail if a test skips, unless a line of FILE, a regular expression, is in its reason",
    )
    parser.addoption(
        "--until",
        metavar="TIME",
        type=float,
        default=math.inf,
        help="skip tests that would begin later than TIME (seconds since 1970)",
    )


def pytest_runtest_setup(item):
    if time.time() > item.config.getoption("--until"):
        pytest.skip("no time was left for it")
    _count_flights(item.config)
    _read_once(item.config)


_READ = pytest.StashKey[bool]()


def _read_once(config):
    """Let all scenarios of this process have one reading of the shipped drone.

    To read and weigh it takes most of the time in which a session is made. It is read before the
    test that follows changes anything; `read_description` itself reads anew.
    """
    setup = sys.modules.get("workbench.setup")
    if setup is None or _READ in config.stash:
        return
    config.stash[_READ] = True
    from workbench.common.resources import find_model
    from workbench.scenario import configured

    model, read_anew, make_anew = (
        find_model("dh_drone"),
        configured.read_description,
        setup.make_vehicle,
    )
    read = read_anew(model)
    made = make_anew(read)

    def description_of(path, args, packages, rotors):
        same = path == model and not (args or packages or rotors)
        return read if same else read_anew(path, args, packages, rotors)

    configured.read_description = description_of
    setup.make_vehicle = lambda description: made if description is read else make_anew(description)


_FLOWN = pytest.StashKey[float]()


def _count_flights(config):
    """Add the simulated seconds of this process, from the first test on that finds Drake loaded."""
    module = sys.modules.get("workbench.session.integration")
    if module is None or _FLOWN in config.stash:
        return
    config.stash[_FLOWN] = 0.0
    advance = module.Integration.advance

    def counted(self, step):
        begin = self._simulator.get_context().get_time()
        try:
            advance(self, step)
        finally:
            config.stash[_FLOWN] += self._simulator.get_context().get_time() - begin

    module.Integration.advance = counted


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node):
    """Take over the seconds that a worker of xdist has flown."""
    flown = getattr(node, "workeroutput", {}).get("flown", 0.0)
    node.config.stash[_FLOWN] = node.config.stash.get(_FLOWN, 0.0) + flown


@pytest.hookimpl(tryfirst=True)
def pytest_sessionfinish(session):
    """Fail a run that would pass although tests did not run for a reason that is not allowed."""
    if hasattr(session.config, "workeroutput"):
        session.config.workeroutput["flown"] = session.config.stash.get(_FLOWN, 0.0)
    if session.exitstatus == pytest.ExitCode.OK and _not_run(session.config):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter, config):
    if flown := config.stash.get(_FLOWN, 0.0):
        terminalreporter.write_line(
            f"flown on the diagram, child processes left out: {flown:,.0f} s"
        )
    for line in _not_run(config):
        terminalreporter.write_line(f"NOT RUN {line}")


def _not_run(config):
    """Return a line for each place and reason of tests that were not to skip, on the controller."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    if config.getoption("--allowed-skips") is None or reporter is None:
        return []
    rows = config.getoption("--allowed-skips").read_text(encoding="utf-8").splitlines()
    allowed = [row for row in rows if row and not row.startswith("#")]
    skips = Counter(
        f"{Path(file).name}:{line}: {reason.removeprefix('Skipped: ')}"
        for file, line, reason in (each.longrepr for each in reporter.getreports("skipped"))
        if not any(re.search(row, reason) for row in allowed)
    )
    return [f"[{count}] {line}" for line, count in sorted(skips.items())]


@pytest.fixture(scope="module")
def served():
    """Return a function from a scenario's name to the address where `workbench serve` flies it."""
    with ExitStack() as running:
        yield lambda scenario: running.enter_context(_serving(scenario))


@contextmanager
def _serving(scenario: str) -> Iterator[str]:
    words = [sys.executable, "-m", "workbench", "serve", "--scenario", scenario, "--port", "0"]
    with subprocess.Popen(
        [*words, "--duration", "600"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            line = process.stdout.readline()
            assert line, process.stderr.read()
            yield line.split()[-1]
        finally:
            process.terminate()
            try:
                process.communicate(timeout=120.0)
            except subprocess.TimeoutExpired:
                process.kill()


@pytest.fixture
def unheld(monkeypatch):
    """Read logs in this process instead of a held one, which takes a quarter of a second to start.

    The `test_log_process.py` of tests/logs and of the extra have the held one.
    """
    from workbench.logs import log_child, log_process

    def answer(module, request, **limits):
        return json.loads(json.dumps(log_child.read_to_arrays(request)))

    monkeypatch.setattr(log_process, "run_limited", answer)


@pytest.fixture
def unconfined_xacro(monkeypatch):
    """Expand xacro files in this process instead of a confined one, which takes a tenth of a second
    to start.

    tests/plant/formats has the confined one. What an expansion changes in xacro is restored.
    """
    from workbench.plant.formats import xacro as expander

    def expand(module, request, **limits):
        import xacro
        from xacro import substitution_args

        from workbench.plant.formats.xacro_child import expand as expand_here

        offered = xacro._global_symbols["python"]
        with ExitStack() as restored:
            for names in (vars(xacro), vars(substitution_args), offered, sys.modules):
                restored.callback(_restore, names, dict(names))
            return json.loads(json.dumps(expand_here(json.loads(json.dumps(request)))))

    monkeypatch.setattr(expander, "run_limited", expand)
    # what a confined process has not made is not for later tests, nor for the user's cache
    monkeypatch.setattr(expander, "cache_expansion", lambda *expansion: None)


def _restore(names, before):
    """Let a dict have the entries that it had before, beside modules that were imported since."""
    for name in [each for each in names if each not in before]:
        if names is not sys.modules or name.startswith("ament_index_python"):
            del names[name]
    names.update(before)


@pytest.fixture(scope="session")
def description():
    """The shipped drone."""
    from workbench.common.resources import find_model
    from workbench.plant.description import read_description

    return read_description(find_model("dh_drone"))


@pytest.fixture(scope="session")
def vehicle(description):
    from workbench.plant.loading import make_vehicle

    return make_vehicle(description)


@pytest.fixture(scope="session")
def gains():
    """The defaults of the controller's parameters, by name and in their order."""
    from workbench.control.controller_file import load_controller
    from workbench.control.flight_law import flight_law

    law = load_controller()
    return flight_law(law).gains([row.default for row in law.parameters])


@pytest.fixture(scope="session")
def random_signals():
    """Return state, acceleration, reference and guidance of a drone in any kind of trouble."""
    import numpy as np

    from workbench.control.obstacle_brake import MAX_WALLS

    def signals(rng: np.random.Generator) -> tuple[list[float], ...]:
        q_WB = rng.normal(size=4)
        state = [*q_WB / np.linalg.norm(q_WB), *rng.uniform(-3, 3, 9)]
        state[6] += 10.0
        reference = [*rng.uniform(-4, 4, 3), rng.normal(), *rng.uniform(0, 9, 3), 0.0]
        reference[7] = float(rng.integers(0, 2))
        weights = rng.integers(0, 2, 3).astype(float)
        guidance = [1.0, 1.0, weights[0], rng.normal(), weights[1], weights[2], *rng.normal(size=3)]
        guidance.append(rng.integers(0, 2) * rng.uniform(0.0, 2.0))
        for _ in range(MAX_WALLS):
            n_W = rng.normal(size=3)
            guidance += [*n_W / np.linalg.norm(n_W), rng.uniform(-5, 15)]
        return state, list(rng.normal(size=3)), reference, guidance

    return signals
