"""PX4 and ArduPilot at the other end, played by doubles written from their interfaces' description.

A double knows nothing of the workbench: it decodes what comes, flies a hover at 1.5 m by P and D of
its own on height and attitude, and answers. None of this was flown against the programs themselves.
"""

import contextlib
import csv
import dataclasses
import json
import math
import shlex
import socket
import struct
import threading
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from workbench.commands.cli import main
from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.common.resources import find_model
from workbench.extras.autopilots.programs.ardupilot import ArduPilot, motion_line
from workbench.extras.autopilots.programs.motion import RestartedError, attitude_ned, to_frd
from workbench.extras.autopilots.programs.px4 import Px4
from workbench.extras.autopilots.sitl_flight import AutopilotFlight, checked_order
from workbench.plant.loading import load_vehicle
from workbench.scenario.scenario import Scenario, ScenarioStart

HEIGHT = 1.5


def outputs(height, climb, attitude, rates, hover):
    """Return front right, rear left, front left, rear right of a hover, from NED and FRD."""
    w, x, y, z = attitude
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    up = hover * (1.0 + 0.25 * (HEIGHT - height) - 0.25 * climb)
    a = 0.03 * hover * (-5.0 * roll - rates[0])
    b = 0.03 * hover * (-5.0 * pitch - rates[1])
    c = 0.06 * hover * -rates[2]
    # right rotors push to the left (roll -), front ones push up (pitch +), ccw ones turn right
    mixed = (up - a + b + c, up + a - b + c, up + a + b - c, up - a - b - c)
    return [min(max(u, 0.0), 1.0) for u in mixed]


class Px4Double(threading.Thread):
    """Connects, says hello, and answers each HIL_SENSOR of id 0 with controls of equal time."""

    def __init__(self, address, hover, spoil=lambda count, message: message, silent=20):
        super().__init__(daemon=True)
        self.address, self.hover, self.spoil, self.silent = address, hover, spoil, silent
        self.times, self.sensors, self.gps, self.answered = [], [], [], 0
        self.start()

    def run(self):
        while True:  # as PX4 does, until somebody listens
            with contextlib.suppress(ConnectionRefusedError):
                with socket.create_connection(self.address) as link:
                    self.talk(link)
                return
            threading.Event().wait(0.01)

    def talk(self, link):
        codec = mavlink.MAVLink(None, srcSystem=1)
        codec.robust_parsing = True
        link.sendall(mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 0, 3).pack(codec))
        link.sendall(
            mavlink.MAVLink_command_long_message(0, 0, 511, 0, 115, 5000, 0, 0, 0, 0, 0).pack(codec)
        )
        state = None
        while True:
            try:
                data = link.recv(65536)
            except OSError:
                return
            if not data:
                return
            for message in codec.parse_buffer(data) or ():
                kind = message.get_type()
                if kind == "HIL_STATE_QUATERNION":
                    state = message
                elif kind == "HIL_GPS":
                    self.gps.append(message)
                elif kind == "HIL_SENSOR" and message.id == 0:
                    self.times.append(message.time_usec)
                    self.sensors.append(message)
                    if len(self.times) <= self.silent:
                        continue  # it boots
                    rates = message.xgyro, message.ygyro, message.zgyro
                    height, climb = 0.001 * state.alt - self.ground(), -0.01 * state.vz
                    u = outputs(height, climb, state.attitude_quaternion, rates, self.hover)
                    said = mavlink.MAVLink_hil_actuator_controls_message(
                        message.time_usec, [*u, *[0.0] * 12], 128 | 1, 1
                    )
                    said = self.spoil(self.answered, said)
                    self.answered += 1
                    if said is None:
                        return
                    if said != "nothing":
                        link.sendall(said.pack(codec))

    def ground(self):
        return 0.001 * self.gps[0].alt - HEIGHT  # it begins there


class ArduPilotDouble(threading.Thread):
    """Sends servo packets, and waits for the answer to each before it sends the next."""

    def __init__(self, address, hover, wide=False, spoil=lambda count, packet: packet, wait=5.0):
        super().__init__(daemon=True)
        self.address, self.hover, self.wide, self.spoil = address, hover, wide, spoil
        self.times, self.said, self.resend, self.wait = [], [], (), wait
        self.start()

    def packet(self, count, pulses):
        n, magic = (32, 29569) if self.wide else (16, 18458)
        return struct.pack(f"<HHI{n}H", magic, 1024, count, *pulses, *[0] * (n - 4))

    def run(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            link.settimeout(self.wait)
            link.connect(self.address)
            self.talk(link)

    def talk(self, link):
        count, pulses = 0, [1000] * 4
        while True:
            packet = self.spoil(count, self.packet(count, pulses))
            if packet is None:
                return
            try:
                for _ in range(2 if count in self.resend else 1):
                    link.send(packet)
                    text = link.recv(4096).decode()
            except OSError:
                return
            assert text[0] == text[-1] == "\n" and text.count("\n") == 2
            heard = json.loads(text)
            self.times.append(heard["timestamp"])
            self.said.append(text)
            (_, _, down), (_, _, sink) = heard["position"], heard["velocity"]
            u = outputs(-down, -sink, heard["quaternion"], heard["imu"]["gyro"], self.hover)
            pulses = [round(1000 + 1000 * each) for each in u]
            count += 1


def flight(rate, mode="hovering", **more):
    return AutopilotFlight(Scenario(start=ScenarioStart(mode=mode, **more)), rate, noise=False)


def share(flown):
    return float(flown.vehicle.hover_speeds[0] / flown.vehicle.rotors[0].max_rot_velocity)


def fly(flown, peer, duration):
    while flown.time < duration:
        flown.fly(peer.exchange(flown.motion()))


def hover_px4(duration):
    flown, peer = flight(256.0), Px4("127.0.0.1", 0, 5.0)
    double = Px4Double(peer.address, share(flown))
    peer.connect()
    # until the double has booted sensors run freely; a real one has the machine's clock meanwhile
    while not peer.locked:
        controls = peer.exchange(flown.motion())
        flown.fly(controls if peer.armed else (share(flown),) * 4)
        threading.Event().wait(0.004)
    first = peer.report()["free"]
    fly(flown, peer, duration)
    peer.close()
    report = peer.report()
    assert report["lost"] == 0
    assert report["packets"] == round(256 * duration) == len(double.times)
    assert double.answered == report["packets"] - double.silent
    assert first >= double.silent
    steps = np.arange(report["packets"])
    assert double.times == [int(1e6 * n / 256) for n in steps]  # no drift
    assert np.linalg.norm(flown.recording().p_WB[-1] - [0.0, 0.0, HEIGHT]) < 0.3
    return double


def hover_ardupilot(duration, wide):
    flown, peer = flight(1024.0), ArduPilot("127.0.0.1", 0, 5.0, (1000.0, 2000.0))
    double = ArduPilotDouble(peer.address, share(flown), wide)
    double.resend = (100, 200)
    peer.connect()
    fly(flown, peer, duration)
    peer.close()
    assert peer.report() == {"packets": round(1024 * duration), "resent": 2}
    assert double.times[: round(1024 * duration)] == [
        n / 1024 for n in range(round(1024 * duration))
    ]
    assert np.linalg.norm(flown.recording().p_WB[-1] - [0.0, 0.0, HEIGHT]) < 0.3


def test_px4_flies_in_lockstep_and_hears_its_units():
    double = hover_px4(3.0)
    message, gps = double.sensors[0], double.gps[0]
    assert [message.xacc, message.yacc] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert message.fields_updated == 0x1BFF  # accelerometer, gyro, magnetometer, barometer
    assert double.sensors[1].fields_updated == 0x3F
    assert 900.0 < message.abs_pressure < 1013.25  # hPa
    field = math.hypot(message.xmag, message.ymag, message.zmag)
    assert 0.3 < field < 0.6 and message.zmag > 0.2  # gauss, downwards in the north
    assert 45e7 < gps.lat < 49e7 and gps.fix_type == 3 and gps.cog == 65535
    assert len(double.gps) == 24


def test_ardupilot_flies_in_lockstep(case):
    for wide in (False, True):
        with case(wide):
            hover_ardupilot(1.0, wide)


@pytest.mark.slow
def test_twenty_seconds_in_lockstep_do_not_drift():
    hover_px4(20.0)
    hover_ardupilot(20.0, wide=False)


def test_frames_and_signs_are_those_of_section_0():
    rest = flight(256.0, "off")
    for _ in range(256):  # contact gives way until it carries the weight
        rest.fly((0.0,) * 4)
    now = rest.motion()
    assert now.force == pytest.approx((0.0, 0.0, -9.80665), abs=0.01)
    half = math.sqrt(0.5)
    # forward is east: heading 90 degrees
    assert now.attitude == pytest.approx((half, 0.0, 0.0, half), abs=1e-6)
    assert attitude_ned((half, 0.0, 0.0, half)) == pytest.approx((1.0, 0.0, 0.0, 0.0))
    assert to_frd((1.0, 2.0, 3.0)) == (1.0, -2.0, -3.0)
    moving = flight(
        256.0, position=[1.0, 2.0, 3.0], velocity=[4.0, 5.0, 6.0], angular_velocity=[0.1, 0.2, 0.3]
    ).motion()
    assert moving.position == pytest.approx((2.0, 1.0, -3.0))
    assert moving.velocity == pytest.approx((5.0, 4.0, -6.0))
    assert moving.gyro == pytest.approx((0.1, -0.2, -0.3))
    # by matrices, as section 0 has it: R_NED_FRD = R_ne R_ENU_FLU diag(1, -1, -1)
    tilted = flight(256.0, roll_pitch_yaw=[0.3, -0.2, 0.5]).motion()
    cr, sr, cp, sp, cy, sy = (f(a) for a in (0.3, -0.2, 0.5) for f in (math.cos, math.sin))
    R = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    R = R @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    R = R @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    R = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]) @ R @ np.diag([1, -1, -1])
    w, x, y, z = tilted.attitude
    found = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    assert np.allclose(found, R, atol=1e-9)


def test_json_is_found_by_its_first_textual_match():
    flown = flight(256.0, "off")
    text = motion_line(flown.motion()).decode()
    heard = json.loads(text)

    def after(section, key):  # as SIM_JSON looks: the section's text, then the key's behind it
        start = text.index(section) if section else 0
        place = text.index(f'"{key}":', start) + len(key) + 3
        return json.JSONDecoder().raw_decode(text[place:])[0]

    assert " " not in text
    assert after("", "timestamp") == heard["timestamp"]
    assert after("imu", "gyro") == heard["imu"]["gyro"]
    assert after("imu", "accel_body") == heard["imu"]["accel_body"]
    for key in ("position", "quaternion", "velocity"):
        assert after("", key) == heard[key]


def wrong_time(later):
    def spoil(count, message):
        if count >= 20:
            message.time_usec += later
        return message

    return spoil


def no_number(count, message):
    if count >= 20:
        message.controls[1] = math.nan
    return message


def no_lockstep(count, message):
    message.flags = 0
    return message


def test_a_px4_that_stops_lies_or_sends_nan_ends_in_a_sentence(case):
    for spoil, said in (
        (lambda count, message: None if count >= 20 else message, "PX4 is gone"),
        (lambda count, message: "nothing" if count >= 20 else message, "has not answered for 1 s"),
        (wrong_time(10**6), "not in lockstep"),
        (wrong_time(-20000), "not in lockstep"),
        (no_number, "is not a number"),
        (no_lockstep, "without lockstep"),
    ):
        with case(said):
            flown, peer = flight(256.0), Px4("127.0.0.1", 0, 1.0)
            Px4Double(peer.address, share(flown), spoil, silent=0)
            peer.connect()
            with pytest.raises(FlightBrokenError, match=said):
                fly(flown, peer, 60.0)
            peer.close()


def test_an_ardupilot_that_stops_or_lies_ends_in_a_sentence(case):
    def skipped(count, packet):
        return packet[:4] + struct.pack("<I", count + (7 if count > 20 else 0)) + packet[8:]

    for spoil, said in (
        (lambda count, packet: None if count > 20 else packet, "no new packet for 1 s"),
        (
            lambda count, packet: packet[:4] + struct.pack("<I", min(count, 20)) + packet[8:],
            "no new",
        ),
        (skipped, "not in lockstep"),
        (lambda count, packet: packet[:-3] if count > 20 else packet, "not one of ArduPilot's"),
    ):
        with case(said):
            flown, peer = flight(1024.0), ArduPilot("127.0.0.1", 0, 1.0, (1000.0, 2000.0))
            ArduPilotDouble(peer.address, share(flown), spoil=spoil)
            peer.connect()
            with pytest.raises(FlightBrokenError, match=said):
                fly(flown, peer, 60.0)
            peer.close()


def test_an_ardupilot_started_anew_resets_the_vehicle():
    flown, peer = flight(1024.0), ArduPilot("127.0.0.1", 0, 5.0, (1000.0, 2000.0))
    double = ArduPilotDouble(
        peer.address, share(flown), spoil=lambda n, p: None if n > 50 else p, wait=2.0
    )
    peer.connect()
    fly(flown, peer, 50 / 1024)
    double.join()
    again = ArduPilotDouble(peer.address, share(flown))
    assert peer.armed
    with pytest.raises(RestartedError):
        peer.exchange(flown.motion())
    assert not peer.armed
    flown.reset()
    fly(flown, peer, 0.1)
    peer.close()
    assert again.times[:3] == [0.0, 1 / 1024, 2 / 1024]


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def test_the_command_flies_sums_up_and_stops_the_motors(capsys, tmp_path, case):
    ports = free_port(socket.SOCK_STREAM), free_port(socket.SOCK_DGRAM)
    for kind, port, least, said, has_armed in (
        ("px4", ports[0], 20, "is not a number", "PX4 has armed at"),
        ("ardupilot", ports[1], 590, "no new packet for 1 s", "ArduPilot has armed at"),
    ):
        log = tmp_path / f"{kind}.csv"
        line = ["sitl", kind, "--port", str(port), "--fast", "--json", "--patience", "1"]
        if kind == "px4":
            Px4Double(("127.0.0.1", port), share(flight(256.0)), no_number, silent=0)
        else:
            Waiting(port).start()
        with case(kind):
            assert main([*line, "--csv", str(log)]) == 1
            out, err = capsys.readouterr()
            found = json.loads(out)
            assert said in found["broken"] and has_armed in err
            assert found["exchange"]["packets"] >= least
            names, *rows = csv.reader(log.read_text().splitlines())
            speeds = [n for n, name in enumerate(names) if name.startswith("speed_command")]
            asked = [[float(row[n]) for n in speeds] for row in rows]
            assert len(speeds) == 4 and all(map(all, asked[2:5])) and not any(asked[-1])
    assert main(["sitl", "px4", "--rate", "250"]) == 2
    assert "not a whole number of physics steps" in capsys.readouterr().err


class Waiting(threading.Thread):
    """A double that sends its first packet again until it is heard, as ArduPilot does."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.port = port

    def run(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            link.settimeout(0.1)
            link.connect(("127.0.0.1", self.port))
            count = 0
            while count <= 600:
                pulse = 1500 if count else 1000
                with contextlib.suppress(OSError):  # nobody listens yet, or the answer is late
                    link.send(struct.pack("<HHI16H", 18458, 1024, count, *[pulse] * 16))
                    link.recv(4096)
                    count += 1
                    continue
                threading.Event().wait(0.01)


def test_the_commands_of_the_page_fly(capsys):
    page = (Path(__file__).parents[4] / "docs/sitl.md").read_text(encoding="utf-8")
    lines = [line for line in page.splitlines() if line.startswith("workbench sitl ")]
    hover = share(flight(1024.0))
    assert len(lines) == 2
    for line, kind in zip(lines, (socket.SOCK_STREAM, socket.SOCK_DGRAM), strict=True):
        port = free_port(kind)
        if kind == socket.SOCK_STREAM:
            Px4Double(("127.0.0.1", port), hover)
        else:
            Waiting(port).start()
        given = ["--fast", "--json", "--duration", "0.4", "--port", str(port)]
        assert main([*shlex.split(line)[1:], *given]) == 0
        out, err = capsys.readouterr()
        assert json.loads(out)["duration"] == pytest.approx(0.4, abs=0.01)
        assert "is connected" in err and "has armed" in err


def test_outputs_are_those_of_a_quad_x():
    """Front right and rear left turn counter-clockwise, then front left and rear right."""
    drone = load_vehicle(find_model("dh_drone"))
    for rotors in (drone.rotors, drone.rotors[::-1], drone.rotors[1:] + drone.rotors[:1]):
        vehicle = dataclasses.replace(drone, rotors=rotors)
        order = [rotors[each] for each in checked_order(vehicle, ())]
        corners = [(math.copysign(1, r.p_BR[0]), math.copysign(1, r.p_BR[1])) for r in order]
        assert corners == [(1, -1), (-1, 1), (1, 1), (-1, -1)]
        assert [r.direction for r in order] == [1, 1, -1, -1]


def test_a_drone_that_is_no_quad_x_wants_an_order():
    with pytest.raises(WorkbenchError, match="--order must name each of the 4 rotors once"):
        AutopilotFlight(Scenario(), 256.0, (0, 0, 1, 2))
