"""Betaflight as a controller: the firmware itself, and a stand-in where what is ours is looked at.

All stand in one file, as they share ports: files are dealt out to processes as a whole.
"""

import contextlib
import json
import logging
import math
import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.live_orders import execute
from workbench.commands import ExitCode
from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.common.own_file import user_record_type
from workbench.control.controller_file import load_controller
from workbench.control.guidance import Guidance, LawSetpoint, MeasuredMotion, Reference
from workbench.control.law_constants import known_body, known_vehicle, law_constants
from workbench.control.mode import FlightMode, Reason
from workbench.design.compare import find_candidates
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.study import LinearStudy
from workbench.design.step_response import STEP_EDGE_S, step_scenario
from workbench.design.tune.tuner import Tuner
from workbench.extras.autopilots.gain_files.firmware import read_parameter_file
from workbench.extras.autopilots.laws import betaflight_sitl
from workbench.extras.autopilots.programs import betaflight_packets
from workbench.extras.autopilots.programs.betaflight import Betaflight
from workbench.extras.autopilots.programs.betaflight_build import betaflight_program
from workbench.gains.gain_choice import rule_gains
from workbench.ipc.worker_process import WorkerRefusal
from workbench.live.flight import LiveFlight
from workbench.live.flight_clock import FLIGHT_SLICE_S
from workbench.live.flying import FlightLoop
from workbench.live.messages import FlightNotice, FlightReport, Phase
from workbench.live.orders import FlightOrder
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import load_vehicle
from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session
from workbench.setup import make_setup
from workbench.systems.bridge import Bridge

HERE = Path(__file__).resolve().parent
MODEL = str(HERE.parents[2] / "drones/five_inch_quad.urdf.xacro")
FIRMWARE, LAW = "betaflight-sitl", "betaflight"
COUNTED = 0.001
"""Time that the firmware's control loop counts for a packet [s]."""


def scenario(controller=FIRMWARE, **more):
    return Scenario(controller=controller, vehicle=VehicleConfig(model=MODEL), **more)


@pytest.fixture
def fake(tmp_path, monkeypatch):
    """Let a stand-in fly in place of the firmware."""
    program = tmp_path / "fake"
    program.write_text(f"#!{sys.executable}\n" + (HERE / "fake_betaflight.py").read_text())
    program.chmod(0o755)
    monkeypatch.setattr(betaflight_sitl, "betaflight_program", lambda: program)
    return program


@pytest.fixture
def real():
    """Let the firmware itself fly, where it can be built."""
    try:
        return betaflight_program()
    except WorkbenchError as error:
        pytest.skip(str(error))


def hovering(session, duration):
    session.go_to([0.0, 0.0, 1.5])
    session.tick(duration)


def gone(pid):
    """Wait until a process has ended with all its threads, which hold its ports."""
    while True:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
            if state == "Z" and len([*Path(f"/proc/{pid}/task").iterdir()]) == 1:
                return True
        except (ProcessLookupError, FileNotFoundError):
            return True
        time.sleep(0.01)


def test_it_flies_in_lockstep_counts_what_is_lost_and_ends(fake, monkeypatch, caplog):
    caplog.set_level(logging.INFO, "workbench")
    monkeypatch.setenv("FAKE_LOSES", "100")
    session = Session(scenario(start=ScenarioStart(position=[0.0, 0.0, 1.5])))
    with session.programs():
        hovering(session, 0.5)
        pid, folder = session.program.pid, session.program._firmware.folder
        session.set("p_roll", 61.0)
        session.set("gyro_lpf2_static_hz", 333.0)
        session.tick(0.5)
        assert session.program.gains["p_roll"] == 61
        assert session.program.gains["gyro_lpf2_static_hz"] == 333
    assert "read back by MSP: p_roll 61, gyro_lpf2_static_hz 333" in caplog.text
    assert session.exchange["packets"] == 1024
    assert 10 <= session.exchange["lost"] <= 11  # it hears packets before the flight as well
    assert np.linalg.norm(session.state()[4:7] - [0.0, 0.0, 1.5]) < 0.1
    assert gone(pid) and not folder.exists()
    with pytest.raises(WorkbenchError, match="a separate process"):
        session.tick(0.1)


def test_what_dies_or_falls_silent_stops_the_rotors_holds_the_mode_and_starts_anew(fake, case):
    """A fall from rest is the truth: 0.5 s without thrust are 1.23 m, rotors need some of it."""
    for how, said in (
        (signal.SIGKILL, "killed by signal 9"),
        (signal.SIGSTOP, "did not answer for 2 s, and was ended"),
    ):
        with case(how):
            session = Session(scenario(start=ScenarioStart(position=[0.0, 0.0, 5.0])))
            with session.programs():
                session.tick(0.1)
                pid = session.program.pid
                os.kill(pid, how)
                session.tick(0.6)
                assert said in session.ended and "reset, or fly again" in session.ended
                assert session.ended.count(". ") == 0  # one sentence
                assert gone(pid)
                now = session.snapshot()
                assert now.mode is FlightMode.HOVERING
                assert now.reason is Reason.AUTOPILOT_ENDED
                assert max(now.thrusts) == pytest.approx(0.0, abs=1e-6)
                assert 0.8 < 5.0 - now.p_WB[2] < 0.5 * GRAVITY * 0.6**2
                session.request("land")  # nobody flies it
                session.tick(0.25)
                assert session.snapshot().mode is FlightMode.HOVERING
                session.request("stop")
                session.tick(0.25)
                assert session.snapshot().mode is FlightMode.OFF
                session.reset()
                assert not session.ended
                session.tick(0.3)
                assert not session.ended and session.program.pid != pid
                assert session.snapshot().reason is Reason.NONE
                assert abs(session.state()[6] - 5.0) < 0.1
            assert session.exchange["packets"] == round(0.3 * 1024)


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_what_has_died_on_the_ground_is_told_when_it_is_to_fly(fake, how):
    session = Session(scenario(start=ScenarioStart(mode="off")))
    with session.programs():
        session.tick(0.1)
        os.kill(session.program.pid, how)
        session.tick(0.5)
        assert not session.ended  # nobody has asked it for anything
        session.request("take_off")
        session.tick(1.0)
        assert session.ended
        session.reset()
        session.request("take_off")
        session.tick(1.0)
        assert not session.ended and session.exchange["packets"] > 100


def test_a_live_flight_goes_on_and_tells_once_what_died_until_a_reset(fake):
    wall, bridge, sent = [0.0], Bridge(), []
    session = Session(scenario(start=ScenarioStart(position=[0.0, 0.0, 5.0])), bridge=bridge)
    queue = SimpleNamespace(post=sent.append, show=sent.append)

    def seen(kind):
        return [each for each in sent if isinstance(each, kind)]

    def fly(flying, seconds):
        for _ in range(round(seconds / FLIGHT_SLICE_S)):
            wall[0] += FLIGHT_SLICE_S
            flying.fly()

    def refused(flying, wanted):
        answer = execute(flying, wanted)
        return isinstance(answer, WorkerRefusal) and "killed by signal 9" in answer.said

    with session.programs():
        flying = FlightLoop(session, bridge, {}, queue, lambda: wall[0])
        fly(flying, 0.2)
        os.kill(session.program.pid, signal.SIGKILL)
        fly(flying, 0.3)
        report = seen(FlightReport)[-1]
        assert report.phase is Phase.FLYING and report.snapshot.time > 0.4
        assert report.snapshot.mode is FlightMode.HOVERING
        assert report.autopilot.exchange["packets"] > 100
        assert report.autopilot.exchange["lost"] >= 1
        assert [each.said for each in seen(FlightNotice)] == [report.autopilot.ended]
        assert refused(flying, Action(request="land"))
        assert refused(flying, Excitation("x", Shape.STEP, 0.5, 1.0))
        assert not refused(flying, Action(request="stop"))
        assert not refused(flying, FlightOrder.RESET)
        sent.clear()
        fly(flying, 0.2)
        assert seen(FlightReport)[0].phase is Phase.STARTING
        last = seen(FlightReport)[-1]
        assert last.phase is Phase.FLYING and not last.autopilot.ended and not seen(FlightNotice)
        assert last.snapshot.mode is FlightMode.HOVERING and last.snapshot.time > 0.1


def test_commands_count_lost_replies_and_say_what_died(fake, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("FAKE_LOSES", "100")
    monkeypatch.setenv("FAKE_DIES", "1500")
    common = ["--controller", FIRMWARE, "--model", MODEL, "--no-plots", "--output", str(tmp_path)]
    said = "Betaflight ended with 3 at t = 1."
    assert main(["step", "--axis", "y", "--duration", "1", *common]) == ExitCode.NOT_AS_DEMANDED
    told = capsys.readouterr()
    assert re.search(r"lost replies +\d\d .*of 1\d\d\d packets to the autopilot", told.out)
    assert said in told.out
    words = ["fly", "hover", "--duration", "2", *common, "--json"]
    assert main(words) == ExitCode.NOT_AS_DEMANDED
    told = capsys.readouterr()
    found = json.loads(told.out)
    assert 10 <= found["exchange"]["lost"] < 20 and found["exchange"]["packets"] > 1000
    assert found["autopilot_ended"].startswith(said)
    assert said in told.err and "autopilot ended at" not in told.err


def test_ports_that_are_taken_are_named(fake, monkeypatch, case):
    """No wait for a release is needed: each port is held until the end."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as output:
        betaflight_packets.check_ports(output)  # the test before may still hold them
    monkeypatch.setattr(betaflight_packets, "PORT_RELEASE_TIMEOUT_S", 0.1)
    kinds = {
        betaflight_packets.MOTORS_PORT: socket.SOCK_DGRAM,
        betaflight_packets.STATE_PORT: socket.SOCK_DGRAM,
    }
    kinds |= {
        betaflight_packets.RECEIVER_PORT: socket.SOCK_DGRAM,
        betaflight_packets.CONSOLE_PORT: socket.SOCK_STREAM,
    }
    for port, kind in kinds.items():
        with case(port), socket.socket(socket.AF_INET, kind) as taken:
            taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            taken.bind(("127.0.0.1", port))
            if kind == socket.SOCK_STREAM:
                taken.listen()
            session = Session(scenario())
            with session.programs(), pytest.raises(WorkbenchError, match=f"port {port} is in use"):
                session.tick(0.1)


def test_a_port_that_is_about_to_be_released_is_waited_for(case):
    for port in (
        betaflight_packets.MOTORS_PORT,
        betaflight_packets.STATE_PORT,
        betaflight_packets.RECEIVER_PORT,
    ):
        with case(port), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as output:
            ending = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            ending.bind(("127.0.0.1", port))
            release = threading.Timer(0.2, ending.close)
            release.start()
            betaflight_packets.check_ports(output)
            release.join()
            assert output.getsockname() == ("127.0.0.1", betaflight_packets.MOTORS_PORT)


def test_a_process_whose_threads_live_on_is_not_gone():
    """Its first thread ends alone, and is a zombie until the others end."""
    code = """
        import ctypes, threading, time
        threading.Thread(target=time.sleep, args=(0.5,)).start()
        print(flush=True)
        ctypes.CDLL(None).pthread_exit(None)
    """
    begin = time.monotonic()
    words = [sys.executable, "-c", textwrap.dedent(code)]
    with subprocess.Popen(words, stdout=subprocess.PIPE) as child:
        child.stdout.readline()
        assert gone(child.pid) and time.monotonic() > begin + 0.5


def test_it_ends_with_its_caller_however_that_ends(fake):
    code = f"""
        from workbench.extras.autopilots.programs.betaflight import Betaflight
        from pathlib import Path
        firmware = Betaflight(Path({str(fake)!r}), {{}})
        print(firmware.pid, flush=True)
        input()
    """
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(code)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as caller:
        pid = int(caller.stdout.readline())
        caller.kill()
    assert gone(pid)


def test_a_setting_that_it_refuses_is_named(fake):
    with pytest.raises(WorkbenchError, match="refuses 'set nonsense = 1'"):
        Betaflight(fake, {"nonsense": 1})


def test_what_wants_equal_flights_is_refused_in_a_sentence(fake, case):
    hover = Session(scenario(LAW, start=ScenarioStart(position=[0.0, 0.0, 1.5])))
    hover.tick(0.1)
    refused = "betaflight-sitl runs in a separate process, has no linear model"
    for what, act in {
        "margins": lambda: loop_margins(LinearStudy(scenario()).sampled(), "force"),
        "tuned": lambda: Tuner(scenario()),
        "compared": lambda: find_candidates([LAW, FIRMWARE]),
        "takes over": lambda: hover.fly_controller(FIRMWARE),
        "no program": lambda: Session(scenario()).tick(0.1),
        "scheduled": lambda: load_controller(f"{FIRMWARE}@speed=0,4"),
    }.items():
        with case(what), pytest.raises(WorkbenchError, match="a separate process") as error:
            act()
        if what in ("margins", "no program"):
            assert refused in str(error.value)


def test_a_vehicle_or_period_that_it_cannot_fly_is_refused(fake, case):
    rotors = known_vehicle(law_constants(load_vehicle(MODEL))).rotors
    for what, given, said in (
        ("three", rotors[:3], "four rotors in X"),
        ("alike", tuple(r._replace(m_z=0.01) for r in rotors), "diagonal turn alike"),
    ):
        with case(what), pytest.raises(WorkbenchError, match=said):
            betaflight_sitl.betaflight_order(given)
    slow = scenario()
    slow.rates.control_period = 1 / 256
    with pytest.raises(WorkbenchError, match="control_period"):
        session = Session(slow)
        with session.programs():
            session.tick(0.1)


@pytest.mark.slow
def test_the_firmware_hovers_takes_gains_records_and_dies(real, tmp_path):
    session = Session(scenario(start=ScenarioStart(position=[0.0, 0.0, 1.5])))
    with session.programs():
        hovering(session, 5.0)
        session.set("p_roll", 60.0)
        session.set("d_max_pitch", 50.0)
        session.tick(5.0)
        gains = session.program.gains
        assert gains["p_roll"] == 60 and gains["d_max_pitch"] == 50 and gains["i_roll"] == 80
        blackbox = session.program.records()[".bfl"]
        recording = session.recording()
        os.kill(session.program.pid, signal.SIGKILL)
        session.tick(1.0)
        assert "killed by signal 9" in session.ended
        assert session.snapshot().mode is FlightMode.HOVERING
        session.reset()
        session.tick(1.0)
        assert not session.ended and np.linalg.norm(session.state()[4:7] - [0.0, 0.0, 1.5]) < 0.2
    assert np.linalg.norm(recording.p_WB - [0.0, 0.0, 1.5], axis=1).max() < 0.2
    assert recording.tilt.max() < math.radians(2.0)
    assert blackbox.startswith(b"H Product:Blackbox flight data recorder")
    assert b"H rollPID:" in blackbox
    orangebox = pytest.importorskip("orangebox", reason="install the extra `test` to try it")
    file = tmp_path / "flight.bfl"
    file.write_bytes(blackbox)
    frames = [frame.data for frame in orangebox.Parser.load(str(file)).frames()]
    assert len(frames) > 9000


@pytest.mark.slow
def test_the_firmware_reads_back_what_was_exported(real, tmp_path):
    """By the file of its command line: written by export, read by import, set and read by MSP."""
    wanted = {"p_roll": 61.0, "i_pitch": 93.0, "d_pitch": 37.0, "p_yaw": 52.0, "f_roll": 80.0}
    file = tmp_path / "quad.diff"
    words = [word for name, value in wanted.items() for word in ("--set", f"{name}={value:g}")]
    export = ["gains", "export", str(file), "--for", "betaflight", "--model", MODEL, *words]
    assert main(export) == 0
    _, found = read_parameter_file(file)
    entries = found.entries
    written = {each.name: each.value for each in entries}
    assert {name: written[name] for name in wanted} == wanted
    rows = {row.name for row in load_controller(FIRMWARE).parameters}
    values = {name: value for name, value in written.items() if name in rows}
    session = Session(scenario(start=ScenarioStart(position=[0.0, 0.0, 1.5])), values)
    with session.programs():
        hovering(session, 0.5)
        gains = session.program.gains
    known = {name: value for name, value in written.items() if name in gains}
    assert wanted.keys() <= known.keys()
    assert {name: gains[name] for name in known} == known


@pytest.mark.slow
def test_a_live_flight_takes_gains_says_when_it_is_killed_and_begins_anew(real, latest_pid):
    start = ScenarioStart(position=[0.0, 0.0, 1.5])
    with LiveFlight(scenario(start=start), {}) as flight:
        flight.wait()
        flight.set_all({"p_roll": 60.0}).result()
        while "read back by MSP: p_roll 60" not in " ".join((view := flight.latest()).remarks):
            assert view.phase is Phase.FLYING, view.said
            time.sleep(0.05)
        assert flight.latest().autopilot.exchange["packets"] > 0
        os.kill(latest_pid(real), signal.SIGKILL)
        while not (view := flight.latest()).autopilot.ended:
            assert view.phase is Phase.FLYING, view.said
            time.sleep(0.05)
        assert "killed by signal 9" in view.autopilot.ended
        assert view.autopilot.ended in flight.latest().remarks
        for order in (flight.request("land"), flight.excite(Excitation("x", Shape.STEP, 0.5, 1.0))):
            with pytest.raises(WorkbenchError, match="killed by signal 9"):
                order.result()
        flight.request("stop").result()
        flight.reset().result()
        waited = set()
        while (view := flight.latest()).autopilot.ended or (
            view.autopilot.exchange.get("packets", 0) < 99
        ):
            waited.add(view.phase)
            time.sleep(0.05)
        assert Phase.STARTING in waited and Phase.BROKEN not in waited


@pytest.fixture
def latest_pid():
    """Return a function to the process that runs a program."""

    def find(program):
        for link in Path("/proc").glob("[0-9]*/exe"):
            with contextlib.suppress(OSError):
                if link.readlink() == program:
                    return int(link.parent.name)
        raise AssertionError(f"no process runs {program}")

    return find


def rise_time(time, signal):
    """Return from a tenth to nine tenths of the first peak, between samples on a line [s]."""
    peak = np.argmax(np.abs(signal))
    share = np.maximum.accumulate(signal[: peak + 1] / signal[peak])
    early, late = np.interp([0.1, 0.9], share, time[: peak + 1])
    return late - early


@pytest.mark.slow
def test_the_firmware_turns_as_its_law_predicts(real, case):
    """A step of velocity to the left is one of the roll angle, and so of the rate.

    In rate mode without feed-forward, which goes with the time at which sticks come.
    """
    for settings in (
        {},
        {"p_roll": 90.0, "d_roll": 60.0, "d_max_roll": 0.0},
        {"acro": 1.0, "f_roll": 0.0},
    ):
        found = {}
        for law in (LAW, FIRMWARE):
            flown = Session(
                step_scenario("y", 2.0, 1.0, make_setup(scenario(law)).scenario), settings
            )
            with flown.programs():
                flown.run()
            after = flown.recording().between(STEP_EDGE_S, np.inf)
            rates = after.w_WB[:, 0]
            found[law] = rise_time(after.time, rates), np.abs(rates).max()
        print(settings, found)
        with case(settings):
            assert found[FIRMWARE] == pytest.approx(found[LAW], rel=0.1)


@pytest.mark.slow
def test_its_motors_answer_a_recorded_flight_as_the_law_does(real, case):
    """Open loop: motion and sticks of a flight of the law, to the law and to the firmware.

    Both count the same time between packets, and the stick of yaw is a whole number of them. What
    yaw's feed-forward makes of a step is left out: it goes with the time at which sticks come.
    """
    vehicle = load_vehicle(MODEL)
    constants = law_constants(vehicle)
    known, body = known_vehicle(constants), known_body(constants)
    rotors, _ = betaflight_sitl.betaflight_order(known.rotors)
    effects = np.array([[each.force, each.m_x, each.m_y, each.m_z] for each in rotors]).T

    def signals(wrench, full):
        thrusts = np.maximum(np.linalg.solve(effects, np.array(wrench, float)), 0.0)
        return np.sqrt(thrusts / rotors[0].motor_constant) / full

    laws = [load_controller(LAW), load_controller(FIRMWARE)]
    zero = (0.0, 0.0, 0.0)
    for axis, amplitude in (("y", 2.0), ("yaw", math.radians(13.4))):
        flown = Session(
            step_scenario(axis, amplitude, 1.0, make_setup(scenario(LAW)).scenario), {"f_yaw": 0.0}
        )
        flown.run()
        told = flown.recording()
        program = laws[1].program(known, COUNTED)
        updates = [laws[0].update, program.update]
        gains, memories = [], []
        for law in laws:
            names = {row.name: row.default for row in law.parameters}
            values = names | dict(rule_gains(vehicle, law)) | {"f_yaw": 0.0}
            fields = [*names, *law.designed]
            gains.append(user_record_type("Gains", fields)(*law.gains(values, known, COUNTED)))
            memories.append(
                user_record_type("Memory", [x.name for x in law.memory])(*law.initial_memory)
            )
        found = []
        with contextlib.closing(program):
            # the firmware wants some packets until its throttle is where the stick is
            for count, row in enumerate([*[0] * 256, *range(len(told.time))]):
                measured = MeasuredMotion(
                    *(tuple(x[row]) for x in (told.p_WB, told.v_WB)),
                    zero,
                    *(tuple(x[row]) for x in (told.q_WB, told.w_WB)),
                    zero,
                    (0.0, *zero),
                    elapsed=(8 * COUNTED if count % 8 == 0 else 0.0,),
                )
                guidance = Guidance(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, *zero)
                asked = LawSetpoint(Reference(*told.reference[row]), guidance, zero)
                made = []
                for k, law in enumerate(laws):
                    probes = [*law.closed, *[0.0] * len(law.points)]
                    wrench, memory = updates[k](
                        measured, asked, gains[k], body, memories[k], COUNTED, probes
                    )
                    memories[k] = type(memories[k])(*memory)
                    made.append(signals(wrench, gains[0].motor_speed))
                found.append(made)
        law, firmware = np.array(found)[256:].transpose(1, 0, 2)
        # sticks act in the packet after the one with which they come, or in the same
        apart = np.minimum(np.abs(firmware[1:] - law[1:]), np.abs(firmware[1:] - law[:-1]))
        print(axis, program.report(), apart.max(), np.quantile(apart, 0.99), np.ptp(law))
        with case(axis):
            assert np.ptp(law) > 0.03
            assert np.quantile(apart, 0.99) < 0.01
            # on a busy machine a step of the sticks comes some packets late
            assert apart.max() < 0.05


@pytest.mark.slow
def test_the_commands_of_the_page_run(real, tmp_path, monkeypatch, case):
    page = (HERE.parents[3] / "docs/betaflight-sitl.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    commands = "".join(re.findall(r"```sh\n(.*?)```", page, re.DOTALL)).splitlines()
    assert len(commands) == 6
    for command in commands:
        words = shlex.split(command, comments=True)
        if words[0] == "workbench":
            with case(command):
                assert main(words[1:]) == 0
