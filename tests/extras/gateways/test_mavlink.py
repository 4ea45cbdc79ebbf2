"""The gateway to MAVLink: a real flight, and a ground station that is pymavlink's own."""

import asyncio
import json
import math
import socket
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

pytest.importorskip("pymavlink", reason="install the extra `mavlink` to try it")

from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink
from pymavlink.dialects.v20 import development
from pymavlink.mavftp import MAVFTP

from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import installed_laws
from workbench.extras.gateways import mavlink_vehicle
from workbench.extras.gateways.mavlink import check_stations, serve_mavlink
from workbench.extras.gateways.mavlink_messages import (
    MAX_PARAMETER_ID_CHARS,
    motion_messages,
    parameter_ids,
    position_messages,
    status_messages,
    text_messages,
)
from workbench.extras.gateways.mavlink_vehicle import FORCED_DISARM_CODE, MavlinkVehicle
from workbench.extras.gateways.running import LinkOptions
from workbench.link import Client
from workbench.link.address import Address
from workbench.link.messages import Role

LIMIT = 300.0
"""For anything to happen [s]."""
NED_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FLU_FRD = np.diag([1.0, -1.0, -1.0])


def test_motion_is_told_in_north_east_down_and_forward_right_down():
    """Against rotation matrices: R_NED_FRD = R_NED_ENU R_ENU_FLU R_FLU_FRD."""
    random = np.random.default_rng(1)
    for _ in range(100):
        p, v, w = random.uniform(-5.0, 5.0, (3, 3))
        yaw, pitch, roll = random.uniform((-3.1, -1.4, -3.1), (3.1, 1.4, 3.1))
        R_ENU = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
        position = dict(zip("xyz", p, strict=True), roll=roll, pitch=pitch, yaw=yaw)
        names = ("v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
        velocity = dict(zip(names, (*v, *w), strict=True))
        attitude, local, hud = motion_messages(2_500_000_000, position, velocity)
        told = Rotation.from_euler("ZYX", [attitude.yaw, attitude.pitch, attitude.roll])
        assert told.as_matrix() == pytest.approx(NED_ENU @ R_ENU @ FLU_FRD, abs=1e-12)
        rates = (attitude.rollspeed, attitude.pitchspeed, attitude.yawspeed)
        assert rates == pytest.approx(FLU_FRD @ R_ENU.T @ w, abs=1e-12)
        assert (local.x, local.y, local.z) == pytest.approx(NED_ENU @ p)
        assert (local.vx, local.vy, local.vz) == pytest.approx(NED_ENU @ v)
        assert (attitude.time_boot_ms, hud.climb) == (2500, v[2])


def test_a_place_is_told_in_mavlinks_integers():
    gps = {
        "latitude": math.radians(47.4),
        "longitude": math.radians(-8.5),
        "altitude": 488.25,
        "velocity": (1.0, -2.0, 0.5),
    }
    raw, place = position_messages(1_000_000_000, gps, {"z": 3.5, "yaw": math.pi / 2.0})
    for each in (raw, place):
        assert (each.lat, each.lon, each.alt) == (474_000_000, -85_000_000, 488_250)
    assert (place.relative_alt, place.vx, place.vy, place.vz) == (3500, -200, 100, -50)
    assert place.hdg == 0  # north
    assert raw.cog == round(100.0 * math.degrees(math.atan2(1.0, -2.0)))  # by hand: 153.43 deg


@pytest.mark.parametrize("west_of_north", [0.0, 1e-5, 1e-3])
def test_north_is_0_and_never_360_degrees(west_of_north):
    """MAVLink's courses and headings are 0 .. 35999 hundredths; what is next to 360 is 0."""
    velocity = (-3.0 * math.sin(west_of_north), 3.0 * math.cos(west_of_north), 0.0)
    gps = {"latitude": 0.8, "longitude": 0.1, "altitude": 0.0, "velocity": velocity}
    yaw = math.pi / 2.0 + west_of_north
    raw, place = position_messages(0, gps, {"z": 0.0, "yaw": yaw})
    assert raw.cog == place.hdg == (0 if west_of_north < 1e-4 else 35994)


@pytest.mark.parametrize(
    ("current", "told"), [(12.5, 1250), (-3.0, -300), (327.66, 32766), (500.0, -1), (math.nan, -1)]
)
def test_a_battery_is_told_in_hundredths_of_an_ampere_that_fit_in_16_bits(current, told):
    battery = {"voltage": 14.8, "current": current}
    _, status, pack, _ = status_messages({"charge": 0.5, "mode": 3}, True, 0, battery)
    for message in (status, pack):
        message.pack(mavlink.MAVLink(None))  # a number that does not fit is refused here
        assert message.current_battery == told
    assert (status.voltage_battery, pack.voltages[0]) == (14800, 14800)


def test_every_parameter_has_a_short_name_of_its_own():
    for name in installed_laws():
        names = [each.name for each in load_controller(name).parameters]
        ids = parameter_ids(names)
        assert len(set(ids.values())) == len(names), name
        assert all(1 <= len(each) <= MAX_PARAMETER_ID_CHARS for each in ids.values()), name
        assert all(ids[each] == each for each in names if len(each) <= MAX_PARAMETER_ID_CHARS), name
    many = [f"a_very_long_parameter_{number}" for number in range(30)]
    assert len(set(parameter_ids(many).values())) == 30


def test_a_long_sentence_is_told_in_pieces():
    sentence = "The drone holds its position, since nobody was heard for half a second; ask again."
    (one,) = text_messages(1, 4, sentence[:50])
    assert (one.text, one.id) == (sentence[:50], 0)
    pieces = text_messages(3, 4, sentence)
    assert "".join(each.text for each in pieces) == sentence
    assert [each.chunk_seq for each in pieces] == [0, 1]
    assert len({each.id for each in pieces}) == 1 and pieces[0].id > 0
    assert text_messages(3, 4, 100 * "a")[-1].text == ""  # so that the end is known


def test_commands_are_taken_from_this_computer_only(capsys):
    with pytest.raises(WorkbenchError, match="MAVLink has no login"):
        link = LinkOptions("127.0.0.1:1", "mavlink", role=Role.COMMAND)
        stations = [Address("127.0.0.1", 14550), Address("192.168.1.20", 14540)]
        check_stations(stations, link)
    assert main(["gateway", "mavlink", "127.0.0.1:1"]) == 2
    assert "nobody listens at 127.0.0.1:1" in capsys.readouterr().err


class FakeControl:
    """Controls whose operations are done at 10 s, once the test lets them."""

    lost = ""

    def __init__(self):
        self.released, self.go_on = False, asyncio.Event()

    async def __aenter__(self):
        return self

    async def __aexit__(self, *_):
        self.released = True

    async def request(self, what, height):
        await self.go_on.wait()
        return 10.0


class FakeClient:
    """A client of a flight that is always at the time and in the state that a test gives."""

    def __init__(self):
        self.time, self.on, self.given = 9.0, 0, []

    def control(self):
        self.given.append(FakeControl())
        return self.given[-1]

    hello = SimpleNamespace(topics=(), parameters=())

    def latest(self, topic):
        if topic == "on_off_state":
            return self.sample({"on": self.on})
        mode = {"mode": 2 * self.on, "condition": "taking off", "charge": 1.0}
        return self.sample(mode) if topic == "drone_state" else None

    def sample(self, values):
        return type(
            "Sample",
            (),
            {"time": self.time, "values": values, "__getitem__": lambda _, name: values[name]},
        )()


class FakeStation:
    """A ground station that was heard just now."""

    heard_at = math.inf

    def __init__(self):
        self.sent = []

    def send(self, *messages):
        self.sent += messages


def test_control_is_kept_until_an_operation_shows(case):
    """A heartbeat beside a TAKEOFF knows only rotors that stand still, and must not end it."""

    async def scenario():
        client, station = FakeClient(), FakeStation()
        vehicle = MavlinkVehicle(client, station, {}, True, lambda said: None)
        message = mavlink.MAVLink_command_long_message(
            1, 1, mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 0, 1.5
        )
        message._header = mavlink.MAVLink_header(message.get_msgId(), srcSystem=255)
        order = asyncio.create_task(vehicle._command(message))
        await asyncio.sleep(0)
        [control] = client.given
        for time_, on, done, kept in [
            (9.0, 0, False, True),  # it is on its way
            (11.5, 0, False, True),
            (9.9, 0, True, True),  # the flight has done it, and its rotors are to turn yet
            (10.5, 0, True, True),
            (10.6, 1, True, True),
            (20.0, 1, True, True),
            (30.0, 0, True, False),  # landed
        ]:
            client.time, client.on = time_, on
            if done:
                control.go_on.set()
            if on:
                await order
            assert order.done() or not on
            beat = asyncio.create_task(vehicle.beat())
            await asyncio.sleep(0)
            await asyncio.sleep(0)
            beat.cancel()
            with case(time_, on, done):
                assert control.released is not kept
        [ack] = [each for each in station.sent if each.get_type() == "COMMAND_ACK"]
        assert ack.result == mavlink.MAV_RESULT_ACCEPTED

    asyncio.run(scenario())


def test_a_mission_that_replaces_another_can_be_stopped(monkeypatch):
    """The cancelled one ends after the new one has begun, and must not pass for its end."""

    class EndlessFlight:
        def __init__(self, *_):
            self.fly = asyncio.Event().wait

    async def scenario():
        vehicle = MavlinkVehicle(FakeClient(), FakeStation(), {}, True, lambda said: None)
        vehicle._mission.steps = [None, None]
        for number in (0, 1):
            start = asyncio.create_task(vehicle._start_mission(number))
            await asyncio.sleep(0)
            for control in vehicle._client.given:
                control.go_on.set()
            await start
            await asyncio.sleep(0)
        flown = vehicle._flying
        assert flown is not None and vehicle._carried_out == math.inf
        vehicle._stop_mission()
        with pytest.raises(asyncio.CancelledError):
            await flown
        assert vehicle._flying is None and vehicle._carried_out == 9.0

    monkeypatch.setattr(mavlink_vehicle, "MissionFlight", EndlessFlight)
    asyncio.run(scenario())


def test_a_change_of_the_mission_stops_the_one_that_is_flown_and_a_question_does_not(case):
    """Or the drone would go on to places of a mission that nobody sees any more."""

    async def scenario():
        for message, stops in (
            (mavlink.MAVLink_mission_request_list_message(1, 1, 0), False),
            (mavlink.MAVLink_mission_count_message(1, 1, 3, 0), True),
            (mavlink.MAVLink_mission_clear_all_message(1, 1, 0), True),
        ):
            vehicle = MavlinkVehicle(FakeClient(), FakeStation(), {}, True, lambda said: None)
            message._header = mavlink.MAVLink_header(message.get_msgId(), srcSystem=255)
            flown = vehicle._flying = asyncio.create_task(asyncio.Event().wait())
            await vehicle._answer(message)
            with case(message.get_type()):
                assert (vehicle._flying is None) is stops
                assert bool(flown.cancelling()) is stops
            flown.cancel()

    asyncio.run(scenario())


def test_control_is_given_back_when_the_station_is_silent_for_five_seconds(case):
    """A slow machine sees less of the silence, and never more."""

    class SilentStation(FakeStation):
        def __init__(self, silent):
            super().__init__()
            self._silent = silent

        @property
        def heard_at(self):
            return asyncio.get_running_loop().time() - self._silent

    async def scenario():
        for silent, kept in ((4.9, True), (30.0, False)):
            said = []
            vehicle = MavlinkVehicle(FakeClient(), SilentStation(silent), {}, True, said.append)
            await vehicle._controls()
            [control] = vehicle._client.given
            await vehicle._look(in_use=True)
            with case(silent):
                assert control.released is not kept
                assert any("was silent for" in each for each in said) is not kept

    asyncio.run(scenario())


def test_a_command_without_an_effect_is_not_acknowledged_as_done():
    """The flight takes the order, and two seconds later the drone is still off."""

    async def scenario():
        client, station = FakeClient(), FakeStation()
        vehicle = MavlinkVehicle(client, station, {}, True, lambda said: None)
        message = mavlink.MAVLink_command_long_message(
            1, 1, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0, 1.0, 0, 0, 0, 0, 0, 0
        )
        message._header = mavlink.MAVLink_header(message.get_msgId(), srcSystem=255)
        order = asyncio.create_task(vehicle._command(message))
        await asyncio.sleep(0)
        client.given[0].go_on.set()
        client.time = 11.9
        await asyncio.sleep(0.05)
        assert not order.done()
        client.time = 12.1
        await order
        [ack] = [each for each in station.sent if each.get_type() == "COMMAND_ACK"]
        assert ack.result == mavlink.MAV_RESULT_FAILED
        assert "arm had no effect" in station.sent[-2].text

    asyncio.run(scenario())


@pytest.fixture(scope="module")
def address(served):
    return served("network")


class Ground:
    """A ground station, and the gateway that it hears.

    Attributes:
        address: of the server of the flight.
        mav: pymavlink's own connection.
        said: what the gateway told its user.
    """

    def __init__(self, address, allow_commands):
        self.address = address
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as found:
            found.bind(("127.0.0.1", 0))
            self.port = found.getsockname()[1]
        self.mav = mavutil.mavlink_connection(f"udpin:127.0.0.1:{self.port}", dialect="common")
        self.said = []
        self.beats_at = 0.0
        role = Role.COMMAND if allow_commands else Role.VIEW
        link, to = LinkOptions(address, "mavlink", role=role), [Address("127.0.0.1", self.port)]
        self.loop = asyncio.new_event_loop()
        self.task = self.loop.create_task(serve_mavlink(link, to, self.said.append))
        self.thread = threading.Thread(target=self._run)
        self.thread.start()
        assert self.receive("HEARTBEAT").type == mavlink.MAV_TYPE_QUADROTOR
        self.beat()

    def _run(self):
        try:
            self.loop.run_until_complete(self.task)
        except asyncio.CancelledError:
            pass
        finally:
            self.loop.close()

    def beat(self):
        if self.mav.target_system and time.monotonic() > self.beats_at:
            self.beats_at = time.monotonic() + 1.0
            self.mav.mav.heartbeat_send(
                mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0
            )

    def receive(self, *kinds, where=lambda message: True):
        """Return the next message of some kind that fits; a station has a heartbeat meanwhile."""
        ends = time.monotonic() + LIMIT
        while time.monotonic() < ends:
            message = self.mav.recv_match(type=list(kinds), blocking=True, timeout=1.0)
            self.beat()
            if message is not None and where(message):
                return message
        raise AssertionError(f"no {kinds}; the gateway said {self.said}")

    def order(self, command, *numbers):
        self.mav.mav.command_long_send(1, 1, command, 0, *numbers, *[0.0] * (7 - len(numbers)))
        return self.receive("COMMAND_ACK", where=lambda ack: ack.command == command).result

    def set(self, name, value):
        self.mav.mav.param_set_send(1, 1, name.encode(), value, mavlink.MAV_PARAM_TYPE_REAL32)
        return self.receive("PARAM_VALUE", where=lambda each: each.param_id == name).param_value

    def told(self, words):
        return self.receive("STATUSTEXT", where=lambda text: words in text.text)

    def close(self):
        self.loop.call_soon_threadsafe(self.task.cancel)
        self.thread.join(LIMIT)
        self.mav.close()


@pytest.fixture
def ground(address):
    made = Ground(address, allow_commands=True)
    yield made
    made.close()


def test_a_station_reads_and_sets_gains_under_the_lease_and_flies(ground, address):
    with Client(address, topics=["drone_state"]) as client:
        wanted = client.parameters()
        ids = parameter_ids(wanted)
        ground.mav.mav.param_request_list_send(1, 1)
        found = {}
        while len(found) < len(wanted):
            value = ground.receive("PARAM_VALUE")
            assert value.param_count == len(wanted)
            found[value.param_id] = value.param_value
        assert found == {
            ids[name]: pytest.approx(value, rel=1e-6) for name, value in wanted.items()
        }

        assert ground.set("kp_pitch", 200.1) == pytest.approx(200.1)
        assert client.parameters("kp_pitch") == {"kp_pitch": 200.1}  # not 200.10000610351562
        for value in (1e9, math.nan):
            assert ground.set("kp_pitch", value) == pytest.approx(200.1)
        ground.mav.mav.param_request_read_send(1, 1, b"no_such", -1)
        assert ground.told("there is no parameter 'no_such'")
        ground.mav.mav.param_request_read_send(1, 1, b"", list(wanted).index("kp_pitch"))
        assert ground.receive("PARAM_VALUE").param_id == "kp_pitch"

        charge = round(100.0 * next(client).values["charge"])
        assert 0 < charge <= 100
        assert ground.receive("BATTERY_STATUS").battery_remaining in (charge, charge - 1)
        assert abs(ground.receive("ATTITUDE").roll) < 0.1  # it stands

        with client.control():  # somebody else flies
            assert ground.set("kp_pitch", 300.0) == pytest.approx(200.1)
            assert ground.order(mavlink.MAV_CMD_NAV_LAND) == mavlink.MAV_RESULT_DENIED

    accepted = mavlink.MAV_RESULT_ACCEPTED
    assert ground.order(mavlink.MAV_CMD_DO_SET_SERVO) == mavlink.MAV_RESULT_UNSUPPORTED
    take_off = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    assert ground.order(mavlink.MAV_CMD_NAV_TAKEOFF, *take_off) == accepted
    ground.receive("LOCAL_POSITION_NED", where=lambda local: local.z < -0.5)
    armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    assert ground.receive("HEARTBEAT", where=lambda beat: beat.base_mode & armed)
    disarm = mavlink.MAV_CMD_COMPONENT_ARM_DISARM
    assert ground.order(disarm, 0.0) == mavlink.MAV_RESULT_DENIED  # it flies
    assert ground.order(mavlink.MAV_CMD_NAV_LAND) == accepted
    assert ground.order(disarm, 0.0, FORCED_DISARM_CODE) == accepted
    ground.receive("HEARTBEAT", where=lambda beat: not beat.base_mode & armed)


def request(ground, number, which=0.0):
    return ground.order(mavlink.MAV_CMD_REQUEST_MESSAGE, float(number), which)


def test_modes_and_units_are_listed(ground, address):
    """By the dialect that has standard modes, and by pymavlink's client of files."""
    assert request(ground, 9999) == mavlink.MAV_RESULT_UNSUPPORTED
    assert request(ground, math.nan, math.inf) == mavlink.MAV_RESULT_UNSUPPORTED
    gimbal = mavlink.MAVLINK_MSG_ID_GIMBAL_MANAGER_INFORMATION  # which this drone has not
    assert request(ground, gimbal) == mavlink.MAV_RESULT_UNSUPPORTED
    version = mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION
    assert request(ground, version, math.nan) == mavlink.MAV_RESULT_ACCEPTED  # as MAVSDK has it
    modes = []
    mavutil.mavlink.mavlink_map.setdefault(435, development.MAVLink_available_modes_message)
    mavutil.mavlink.mavlink_map.setdefault(436, development.MAVLink_current_mode_message)
    ground.mav.mav.command_long_send(1, 1, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, 435.0, *[0.0] * 6)
    while not modes or len(modes) < modes[0].number_modes:
        modes.append(ground.receive("AVAILABLE_MODES"))
    by_name = {mode.mode_name: mode for mode in modes}
    assert by_name["Hold"].standard_mode == mavlink.MAV_STANDARD_MODE_POSITION_HOLD
    assert by_name["Mission"].properties == 0 and by_name["Cruising"].properties == 2
    assert ground.receive("CURRENT_MODE").custom_mode in [mode.custom_mode for mode in modes]
    assert ground.order(mavlink.MAV_CMD_DO_SET_MODE, 1.0, 6.0) == mavlink.MAV_RESULT_UNSUPPORTED
    assert request(ground, 397) == mavlink.MAV_RESULT_ACCEPTED
    ftp = MAVFTP(ground.mav, 1, 1)
    found = []
    ftp.cmd_get(["/parameter.json"], callback=lambda file: found.append(file.read()))
    ftp.process_ftp_reply("OpenFileRO", timeout=60)
    about = {row["name"]: row for row in json.loads(found[0])["parameters"]}
    assert (about["kp_pitch"]["units"], about["kp_pitch"]["min"]) == ("1/s^2", 0.0)
    assert not any(name.startswith("GIMBAL") for name in ground.mav.messages)
    with Client(address) as client:
        assert {row["shortDesc"] for row in about.values()} == set(client.parameters())


@pytest.mark.slow
def test_a_mission_is_flown(ground, address):
    """Up to 2 m, 3 m north, wait, and down; pymavlink sends it, and the topic tells the way."""
    local = mavlink.MAV_FRAME_LOCAL_NED
    steps = [
        (mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, -2.0, 0.0),
        (mavlink.MAV_CMD_NAV_WAYPOINT, 30_000, 10_000, -2.0, 0.5),
        (mavlink.MAV_CMD_NAV_LAND, 30_000, 10_000, 0.0, 0.0),
    ]
    ground.mav.mav.mission_count_send(1, 1, len(steps), 0)
    for number, (command, x, y, z, wait) in enumerate(steps):
        ground.receive("MISSION_REQUEST_INT", where=lambda each, number=number: each.seq == number)
        ground.mav.mav.mission_item_int_send(
            1, 1, number, local, command, 0, 1, wait, 0.0, 0.0, 0.0, x, y, z, 0
        )
    assert ground.receive("MISSION_ACK").type == mavlink.MAV_MISSION_ACCEPTED
    with Client(address, topics=["position_data"]) as client:
        assert ground.order(mavlink.MAV_CMD_MISSION_START) == mavlink.MAV_RESULT_ACCEPTED
        assert ground.receive("HEARTBEAT", where=lambda beat: beat.custom_mode == 8)
        assert ground.receive("MISSION_ITEM_REACHED", where=lambda each: each.seq == 1)
        place = client.latest("position_data")
        assert (place["x"], place["y"], place["z"]) == pytest.approx((1.0, 3.0, 2.0), abs=0.6)
        assert ground.receive("MISSION_ITEM_REACHED", where=lambda each: each.seq == 2)
        assert client.latest("position_data")["z"] < 0.5
    ground.told("the mission is done")


def test_what_is_no_mavlink_does_no_harm(ground):
    random = np.random.default_rng(2)
    for size in random.integers(1, 300, 500):
        ground.mav.write(random.bytes(int(size)))
    found = None
    while found is None:  # a datagram may be lost among so many
        ground.mav.mav.param_request_read_send(1, 1, b"kp_pitch", -1)
        found = ground.mav.recv_match(type="PARAM_VALUE", blocking=True, timeout=0.5)
    assert found.param_id == "kp_pitch"


def test_without_leave_it_only_watches(address):
    ground = Ground(address, allow_commands=False)
    try:
        ground.set("kp_pitch", 100.0)
        assert ground.told("only watches")
        assert ground.order(mavlink.MAV_CMD_NAV_LAND) == mavlink.MAV_RESULT_DENIED
    finally:
        ground.close()
