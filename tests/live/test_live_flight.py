"""Live flights in real processes: exact, safe from each other's deaths, and never waiting."""

import dataclasses
import os
import pickle
import signal
import socket
import subprocess
import sys
import time
import urllib.parse
import urllib.request
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.live.flight import LiveFlight
from workbench.live.messages import Phase
from workbench.plant.home import DEFAULT_HOME
from workbench.scenario.scenario import Scenario, ScenarioStart, SensorsConfig, VehicleConfig
from workbench.session.recording import Recording
from workbench.session.session import Session

ROOT = Path(__file__).resolve().parents[2]
ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""
SCENARIO = Scenario(
    world="obstacle_field",
    start=ScenarioStart(mode="off"),
    sensors=SensorsConfig(use=["imu", "lidar"], seed=5, keep=True),
)
SETTINGS = {"kp_roll": 90.0, "turbulence": 1.0}


@pytest.fixture(scope="module")
def flight():
    with LiveFlight(SCENARIO, SETTINGS, draw=True) as flight:
        flight.wait(ENOUGH)
        yield flight


@pytest.fixture
def paused(flight):
    """The flight at its start, which waits."""
    flight.set_speed(1.0)
    flight.pause()
    flight.reset().result(ENOUGH)
    return flight


def running(pid: int) -> bool:
    """Return whether a process is there, and no zombie."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False
    return stat.rpartition(")")[2].split()[0] not in "ZX"


def assert_gone(pid: int) -> None:
    end = time.monotonic() + ENOUGH
    while running(pid):
        assert time.monotonic() < end, "the process goes on"
        time.sleep(0.01)


def test_a_flight_begins_and_says_what_flies(paused):
    paused.fly_on(0.25).result(ENOUGH)  # until there is a scan
    view = paused.latest()
    assert view.vehicle.name == "dh_drone"
    assert view.values["kp_roll"] == 90.0
    assert "lidar_fault" in view.values
    assert "gps_fault" not in view.values  # it has one, and does not measure
    assert view.snapshot.lidar.rays == 5760
    assert {"mast", "slab", "crate_1::crate"} <= {each.name for each in view.outlines}
    assert view.home == DEFAULT_HOME


def test_a_live_flight_equals_a_session_to_the_bit_and_so_does_its_scenario(paused):
    """The flight goes on in real time for a while: at which steps it is ordered, nobody knows."""
    done = []

    def ordered(answer, act):
        done.append((answer.result(ENOUGH), act))

    ordered(paused.request("take_off", 1.2), lambda s: s.request("take_off", 1.2))
    paused.set_speed(4.0)
    paused.resume().result(ENOUGH)
    ordered(paused.set("kp_pitch", 61.0), lambda s: s.set("kp_pitch", 61.0))
    ordered(paused.gust([1.0, 2.0, 0.0], 0.7), lambda s: s.gust([1.0, 2.0, 0.0], 0.7))
    paused.pause()
    paused.fly_on(2.0)
    ordered(paused.command([0.5, 0.0, 0.0], 0.3), lambda s: s.command([0.5, 0.0, 0.0], 0.3))
    paused.resume()
    ordered(paused.push([0.0, 1.0, 0.0]), lambda s: s.push([0.0, 1.0, 0.0]))
    paused.pause()
    paused.fly_on(0.4)
    ordered(paused.go_to([1.0, 0.5, 1.5]), lambda s: s.go_to([1.0, 0.5, 1.5]))
    paused.fly_on(0.6)
    flown = paused.flown().result(ENOUGH)

    session = Session(SCENARIO, SETTINGS)
    for at, act in done:
        session.tick(at - session.time)
        act(session)
    session.tick(flown.scenario.duration - session.time)
    assert np.ptp(flown.recording.p_WB, axis=0).min() > 0.05
    assert_equal_to_the_bit(session, flown)
    again = Session(flown.scenario)
    again.run()
    assert_equal_to_the_bit(again, flown)


def assert_equal_to_the_bit(session, flown) -> None:
    for field in dataclasses.fields(Recording):
        if field.name != "vehicle":
            a, b = getattr(session.recording(), field.name), getattr(flown.recording, field.name)
            assert a.tobytes() == b.tobytes(), field.name
    assert len(flown.samples) == 2
    for own, other in zip(session.samples(), flown.samples, strict=True):
        assert own.stamps.tobytes() == other.stamps.tobytes()
        values = "ranges" if hasattr(own, "ranges") else "values"
        assert getattr(own, values).tobytes() == getattr(other, values).tobytes()


def test_an_order_that_is_answered_is_seen(paused):
    paused.command([0.25, 0.0, 0.0]).result(ENOUGH)
    assert paused.latest().snapshot.reference[0] == 0.25
    assert paused.latest().phase is Phase.PAUSED
    assert paused.fly_on(0.5).result(ENOUGH) == paused.latest().snapshot.time == 0.5
    assert paused.resume().result(ENOUGH) == 0.5
    assert paused.latest().phase is Phase.FLYING
    assert paused.get("kp_roll").result(ENOUGH) == 90.0
    paused.request("take_off").result(ENOUGH)
    end = time.monotonic() + ENOUGH
    while paused.latest().snapshot.mode in (FlightMode.OFF, FlightMode.ARMED):
        assert time.monotonic() < end, "no snapshot shows the take-off"
        time.sleep(0.01)
    assert paused.latest().pace.asked == 1.0


def test_who_shows_a_flight_loads_neither_diagrams_nor_qt():
    code = "import sys, workbench.live.flight; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    loaded = set(done.stdout.split())
    heavy = {
        "pydrake.multibody.plant",
        "pydrake.systems.framework",
        "workbench.session.session",
        "PyQt6",
    }
    assert not loaded & heavy


def test_what_comes_over_needs_no_drake(paused):
    paused.fly_on(0.2).result(ENOUGH)
    reading = paused.reading("lidar").result(ENOUGH)
    assert reading.ranges.size == 5760
    for thing in (paused.latest(), paused.flown().result(ENOUGH), reading):
        assert b"pydrake" not in pickle.dumps(thing)


def test_a_predicted_way_is_drawn_and_is_no_order_to_fly(paused):
    begun, flown = paused.latest().network.control, paused.flown().result(ENOUGH)
    way = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]])
    assert paused.foresee(5.0, way).result(ENOUGH) == 0.0
    assert paused.flown().result(ENOUGH).scenario == flown.scenario
    assert paused.latest().network.control == begun


@pytest.mark.parametrize(
    ("order", "words"),
    [
        (lambda f: f.set("kp_rol", 1.0), ("'kp_rol'", "'kp_roll'")),
        (lambda f: f.set(3, 1.0), ("parameter", "3")),
        (lambda f: f.set([], 1.0), ("parameter", "[]")),
        (lambda f: f.set("kp_roll", float("nan")), ("kp_roll", "nan")),
        (lambda f: f.set("kp_roll", "much"), ("kp_roll", "'much'")),
        (lambda f: f.set("kp_roll", 1e9), ("kp_roll", "2500")),
        (lambda f: f.set_all({"kp_roll": 50.0, "kp_pitch": 1e9}), ("kp_pitch", "2500")),
        (lambda f: f.command("abc"), ("velocity", "'abc'")),
        (lambda f: f.command([1e7, 0, 0]), ("velocity", "1e+06")),
        (lambda f: f.command(yaw_rate=object()), ("yaw rate",)),
        (lambda f: f.go_to([0.0, 0.0, -9.0]), ("-9 m",)),
        (lambda f: f.request("lend"), ("'lend'", "'land'")),
        (lambda f: f.request(None), ("request", "None")),
        (lambda f: f.request("land", -1.0), ("height", "-1")),
        (lambda f: f.gust([99.0, 0.0, 0.0]), ("gust_x", "50")),
        (lambda f: f.push([1.0, 0.0, 0.0], duration="x"), ("push_duration", "'x'")),
        (lambda f: f.set_speed(99.0), ("99", "20")),
        (lambda f: f.fly_on(1e9), ("60 s",)),
        (lambda f: f.reading("gps"), ("gps",)),
        (lambda f: f.reading([]), ("sensor", "[]")),
    ],
)
def test_nonsense_is_refused_in_a_sentence(paused, order, words):
    error = order(paused).exception(ENOUGH)
    assert isinstance(error, WorkbenchError)
    assert not [word for word in words if word not in str(error)]
    assert paused.get("kp_roll").result(ENOUGH) == 90.0


def test_meshcat_draws_from_the_process(flight):
    url = flight.latest().url
    assert url.startswith("http://localhost:")
    with urllib.request.urlopen(url, timeout=ENOUGH) as page:
        assert b"meshcat" in page.read().lower()


def test_only_this_machine_sees_the_page(flight):
    """All of 127.0.0.0/8 is this machine; who listens everywhere is reached at all of it."""
    port = urllib.parse.urlsplit(flight.latest().url).port
    socket.create_connection(("127.0.0.1", port), ENOUGH).close()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.2", port), ENOUGH)


def test_a_scenario_that_cannot_be_built_is_a_sentence():
    with LiveFlight(Scenario(vehicle=VehicleConfig(model="dh_drome"))) as flight:
        with pytest.raises(WorkbenchError, match="dh_drome") as caught:
            flight.wait(ENOUGH)
        assert flight.latest().phase is Phase.ENDED
        assert flight.latest().said == str(caught.value)
        assert str(flight.pause().exception(ENOUGH)) == str(caught.value)


def test_what_cannot_be_sent_is_a_sentence():
    with pytest.raises(WorkbenchError, match="cannot be sent"):
        LiveFlight(Scenario(title=lambda: None))


@pytest.mark.parametrize(
    ("number", "words"), [(signal.SIGKILL, "was killed"), (signal.SIGABRT, "crashed (Aborted)")]
)
def test_a_process_that_dies_is_a_sentence_and_nothing_hangs(number, words):
    """The process stands still when it gets the signal, so that an order is waiting."""
    flight = LiveFlight()
    if number == signal.SIGABRT:
        flight.wait(ENOUGH)
    os.kill(flight.pid, signal.SIGSTOP)
    waiting = flight.pause()
    os.kill(flight.pid, number)
    os.kill(flight.pid, signal.SIGCONT)
    assert words in str(waiting.exception(ENOUGH))
    view = flight.latest()
    assert view.phase is Phase.ENDED
    assert words in view.said
    assert "\n" not in view.said
    assert words in str(flight.set("kp_roll", 50.0).exception(ENOUGH))
    flight.close()
    flight.close()


def test_a_process_that_stands_still_takes_orders_up_to_a_bound_and_is_closed():
    flight = LiveFlight()
    os.kill(flight.pid, signal.SIGSTOP)
    orders = [flight.set("kp_roll", 50.0) for _ in range(1001)]
    assert "1000 orders" in str(orders[-1].exception(0.0))
    assert not any(order.done() for order in orders[:-1])
    with pytest.raises(WorkbenchError, match="not begun, and sent no message for 0.01 s: "):
        flight.wait(0.01)
    flight.close(limit=0.1)
    assert_gone(flight.pid)
    assert str(orders[0].exception(ENOUGH)) == "the flight is closed"
    assert str(flight.pause().exception(ENOUGH)) == "the flight is closed"


CALLER = """
import time
from workbench.live.flight import LiveFlight

with LiveFlight() as flight:
    flight.wait()
    try:
        print(flight.pid, flush=True)
        time.sleep(600.0)
    except KeyboardInterrupt:
        print(flight.pause().exception(60.0), flight.latest().phase.value)
        raise SystemExit
"""


@pytest.mark.parametrize(
    "number", [signal.SIGKILL, pytest.param(signal.SIGINT, marks=pytest.mark.slow)]
)
def test_a_process_ends_with_its_caller(number):
    """Killed; or by its will after Ctrl-C, which a terminal sends to the whole group."""
    caller = subprocess.Popen(
        [sys.executable, "-c", CALLER],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        process_group=0,
    )
    worker = int(caller.stdout.readline())
    assert running(worker)
    os.killpg(caller.pid, number)
    said, complaints = caller.communicate(timeout=ENOUGH)
    assert_gone(worker)
    assert complaints == ""
    assert said == ("None paused\n" if number == signal.SIGINT else "")
