"""What foreign logs mean by their numbers: scales by header and version, instances, units, angles.

Right values of the cases in `shared/cases` come from other programs, as the README of each says.
"""

import struct
from pathlib import Path

import numpy as np
import pytest

from tests.extras.flightdata.foreign_files import blackbox, dataflash, read_here, ulog
from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.extras.flightdata.importing import write_flight
from workbench.extras.flightdata.readers import crazyflie_usd, tlog_topics, ulog_topics
from workbench.extras.flightdata.readers import dataflash as dataflash_reader
from workbench.extras.flightdata.readers.blackbox import read_blackbox
from workbench.extras.flightdata.readers.dataflash import read_dataflash
from workbench.extras.flightdata.readers.ulog import read_ulog
from workbench.logs.flight_reader import read_flight
from workbench.logs.logged_signal import standard_unit
from workbench.logs.readers.rotations import without_jumps

pytestmark = pytest.mark.usefixtures("unheld")

CASES = Path(__file__).parents[3] / "../shared/cases"
shared = pytest.mark.skipif(not CASES.exists(), reason="put the cases into ../shared/cases")
STAMPS = 1_000_000 + 1000 * np.arange(50)
TIMES_US = STAMPS.tolist()


def hex_float(value: float) -> str:
    """Return the bits of a float as a header has them."""
    return f"0x{struct.unpack('<I', struct.pack('<f', value))[0]:x}"


BLACKBOX = (
    # headers; field; number in the log; signal; its value
    ({}, "gyroADC[0]", 90, "imu.angular_velocity.x", np.radians(90.0)),
    (
        {"blackbox_high_resolution": "1"},
        "gyroADC[1]",
        900,
        "imu.angular_velocity.y",
        np.radians(90),
    ),
    ({"blackbox_high_resolution": "1"}, "gyroUnfilt[0]", 50, "imu.unfiltered.x", np.radians(5.0)),
    (
        {"blackbox_high_resolution": "1"},
        "setpoint[2]",
        1234,
        "rate_setpoint.w_z",
        np.radians(123.4),
    ),
    ({"blackbox_high_resolution": "1"}, "setpoint[3]", 500, "attitude_setpoint.thrust", 0.5),
    ({"blackbox_high_resolution": "1"}, "rcCommand[0]", 2500, "blackbox.rccommand.0", 250.0),
    ({"blackbox_high_resolution": "0"}, "setpoint[0]", 360, "rate_setpoint.w_x", 2.0 * np.pi),
    ({"gyro_scale": hex_float(1 / 16.4)}, "gyroADC[0]", 1476, "imu.angular_velocity.x", np.pi / 2),
    (
        {"gyro_scale": None, "gyro.scale": hex_float(1 / 16.4)},
        "gyroADC[0]",
        1476,
        "imu.angular_velocity.x",
        np.pi / 2,
    ),
    (  # Cleanflight 1: radians per microsecond
        {"gyro_scale": hex_float(np.radians(1 / 16.4) * 1e-6), "Firmware revision": "c0ffee1"},
        "gyroADC[0]",
        1476,
        "imu.angular_velocity.x",
        np.pi / 2,
    ),
    ({"gyro_scale": "1"}, "gyroADC[0]", 90, "imu.angular_velocity.x", np.pi / 2),
    ({"gyro_scale": "0.0625"}, "gyroADC[0]", 1440, "imu.angular_velocity.x", np.pi / 2),
    ({"gyro_scale": None}, "gyroADC[0]", 90, "imu.angular_velocity.x", np.pi / 2),
    ({"acc_1G": "512"}, "accSmooth[2]", 512, "imu.linear_acceleration.z", 9.81),
    ({"acc_1G": "4096"}, "accSmooth[0]", -2048, "imu.linear_acceleration.x", -4.905),
    *(
        (
            {"Firmware revision": f"Betaflight {version} (a) B"},
            "vbatLatest",
            number,
            "battery.voltage",
            16.2,
        )
        for version, number in (
            ("3.1.0", 162),
            ("3.1.7", 162),
            ("3.5.7", 162),
            ("4.0.0", 1620),
            ("4.2.11", 1620),
            ("4.5.1", 1620),
            ("2025.12.1", 1620),
            ("2026.6.1", 1620),
        )
    ),
    ({"Firmware revision": "Cleanflight 2.3.2 (a) B"}, "vbatLatest", 162, "battery.voltage", 16.2),
    (  # a 12-bit converter of 3.3 V behind a divider of 11
        {"Firmware revision": "Betaflight 3.0.1 (a) B", "vbatscale": "110"},
        "vbatLatest",
        1820,
        "battery.voltage",
        1820 / 4095 * 3.3 * 11.0,
    ),
    ({}, "amperageLatest", 1234, "battery.current", 12.34),
    (
        {"Firmware revision": "Betaflight 3.2.0 (a) B"},
        "amperageLatest",
        900,
        "battery.current",
        9.0,
    ),
    (
        {"Firmware revision": "Betaflight 3.0.0 (a) B", "currentMeter": "100,400"},
        "amperageLatest",
        1000,
        "battery.current",
        (3300.0 * 1000 / 4095 - 100.0) * 10.0 / 400.0,
    ),
    ({"motorOutput": "48,2047"}, "motor[0]", 1048, "motors.command_1", 1000 / 1999),
    (
        {"motorOutput": None, "minthrottle": "1150", "maxthrottle": "1850"},
        "motor[2]",
        1500,
        "motors.command_3",
        0.5,
    ),
    ({"motor_poles": "12"}, "eRPM[1]", 600, "rotors.speed.1", 10_000 * np.pi / 30.0),
    ({"features": "-2147479552"}, "gyroADC[0]", 90, "imu.angular_velocity.x", np.pi / 2),
)


def test_blackbox_numbers_have_the_scale_of_header_and_version(tmp_path, case):
    path = tmp_path / "a.bbl"
    for headers, field, number, signal, value in BLACKBOX:
        with case(headers, field):
            path.write_bytes(blackbox(TIMES_US, [[number]] * 50, [field], headers))
            np.testing.assert_allclose(read_blackbox(path)[signal].values, value, rtol=1e-6)


def test_blackbox_numbers_without_a_known_scale_keep_their_names(tmp_path, case):
    """No number gets a unit that nothing states, and a remark says so."""
    path = tmp_path / "a.bbl"
    for headers, field, signal, why in (
        (
            {"gyro_scale": None, "Firmware revision": "Betaflight 3.0.1 (a) B"},
            "gyroADC[0]",
            "imu.angular_velocity.x",
            "gyro_scale",
        ),
        ({"gyro_scale": "0x7fc00000"}, "gyroADC[0]", "imu.angular_velocity.x", "gyro_scale"),
        ({"acc_1G": None}, "accSmooth[0]", "imu.linear_acceleration.x", "acc_1G"),
        ({"acc_1G": "0"}, "accSmooth[0]", "imu.linear_acceleration.x", "acc_1G"),
        ({"motorOutput": None}, "motor[0]", "motors.command_1", "range"),
        ({"features": "4096"}, "motor[0]", "motors.command_1", "3D"),
        ({"Firmware revision": None}, "vbatLatest", "battery.voltage", "not known"),
        (
            {"Firmware revision": "EmuFlight 0.4.1 (a) B"},
            "vbatLatest",
            "battery.voltage",
            "EmuFlight",
        ),
        ({"Firmware revision": "INAV 7.1.0 (a) B"}, "amperage", "battery.current", "INAV 7.1.0"),
        (
            {"Firmware revision": "Betaflight 3.0.1 (a) B"},
            "vbatLatest",
            "battery.voltage",
            "vbatscale",
        ),
    ):
        with case(headers, field):
            path.write_bytes(blackbox(TIMES_US, [[100 + i] for i in range(50)], [field], headers))
            flight = read_blackbox(path)
            assert signal not in flight
            base, bracket, _ = field.partition("[")
            own = flight[f"blackbox.{base.lower()}" + (".0" if bracket else "")]
            assert own.unit == "" and own.values[3] == 103.0
            assert any(why in each and field in each for each in flight.remarks), flight.remarks


def several(*lengths: int) -> bytes:
    """Return a file of blackbox logs with so many frames; the gyro tells their number."""
    logs = [
        blackbox(TIMES_US[:length], [[number]] * length, ["gyroADC[0]"])
        for number, length in enumerate(lengths, start=1)
    ]
    header = blackbox([], [], ["gyroADC[0]"], end=b"")
    return b"".join(log if length else header for log, length in zip(logs, lengths, strict=True))


def test_of_several_logs_the_longest_is_read_or_the_wanted_one(tmp_path, capsys, case):
    path = tmp_path / "a.bbl"
    for lengths, longest in (((5, 50), 2), ((50, 5), 1), ((0, 5, 20, 3), 3), ((3, 0), 1)):
        with case(lengths):
            path.write_bytes(several(*lengths))
            flight = read_blackbox(path)
            assert np.rint(np.degrees(flight["imu.angular_velocity.x"].values[0])) == longest
            remark = flight.remarks[0]
            assert f"has {len(lengths)} logs" in remark and f"number {longest}" in remark
            assert len(flight.logs) == len(lengths)
            assert [length > 0.0 for length in flight.logs] == [length > 1 for length in lengths]
    path.write_bytes(several(5, 50, 20))
    for number in (1, 2, 3):
        flight = read_flight(str(path), log_number=number)
        assert f"this is log {number} of the 3" in flight.remarks[0]
        assert np.rint(np.degrees(flight["imu.angular_velocity.x"].values[0])) == number
    for number in (0, 4, -1):
        with pytest.raises(WorkbenchError, match=f"3 logs: --log-number {number}"):
            read_flight(path, log_number=number)
    for command in (
        ["log"],
        ["plot", "--list"],
        ["export", "--output", str(tmp_path / "tables")],
        ["import", "--save", str(tmp_path / "a.mcap")],
    ):
        with case(command):
            name, *options = command
            assert main([name, str(path), *options, "--log-number", "3"]) == 0
    assert max(read_flight(tmp_path / "a.mcap")["imu.angular_velocity.x"].time) < 0.02
    (tmp_path / "own.csv").write_text("t,g\n0,1\n1,2\n2,3\n")
    (tmp_path / "own.mapping.yaml").write_text(
        "time: {column: t, unit: s}\ncolumns: {g: {signal: battery.voltage, unit: V}}"
    )
    assert main(["log", str(tmp_path / "own.csv"), "--log-number", "2"]) == 2
    assert "has one log" in capsys.readouterr().err


def test_padding_behind_a_blackbox_log_is_no_damage(tmp_path, case):
    """A chip's dump is filled with 0xFF, and a log that lost power has no end mark."""
    path = tmp_path / "a.bbl"
    for end in (b"", b"\xff" * 5000, b"E\xffEnd of log\x00" + b"\xff" * 300):
        with case(end[:2], len(end)):
            path.write_bytes(blackbox(TIMES_US, [[90]] * 50, ["gyroADC[0]"], end=end))
            flight = read_blackbox(path)
            assert not any("None" in each or "damaged" in each for each in flight.remarks)
            assert len(flight["imu.angular_velocity.x"].time) >= 48


def battery(instance: int, connected: float, volts: float, amperes: float) -> tuple:
    fields = {
        "connected": ("bool", [connected] * 50),
        "voltage_v": ("float", [volts] * 50),
        "current_a": ("float", [amperes] * 50),
    }
    return ("battery_status", instance, TIMES_US, fields)


def test_the_connected_battery_counts(tmp_path, case):
    path = tmp_path / "a.ulg"
    off, on, other = (0, 0.0, -1.0), (1, 16.5, 11.0), (1, 16.0, 4.0)
    for states, volts, told in (
        ((off, on), 16.5, False),
        ((on, off), 16.5, False),
        ((off, off, other), 16.0, False),
        ((on, other), 16.5, True),
    ):
        with case(states):
            path.write_bytes(ulog([battery(i, *state) for i, state in enumerate(states)]))
            flight = read_ulog(path)
            np.testing.assert_allclose(flight["battery.voltage"].values, volts)
            assert any("batteries are connected" in each for each in flight.remarks) == told
    path.write_bytes(ulog([battery(0, 0, 0.0, -1.0)]))  # 0 V and -1 A stand for unknown
    assert "battery.voltage" not in read_ulog(path)
    stamps = np.repeat(TIMES_US, 2).tolist()  # two batteries, at the same times
    rows = [(i % 2, 12.6 if i % 2 else 0.0, 1.0 + i % 2) for i in range(100)]
    path = tmp_path / "a.bin"
    path.write_bytes(dataflash([("BAT", "Bff", ("I", "Volt", "Curr"), stamps, rows)]))
    flight = read_dataflash(path)
    np.testing.assert_allclose(flight["battery.voltage"].values, 12.6, rtol=1e-6)
    np.testing.assert_allclose(flight["battery.current"].values, 2.0)
    assert len(flight["battery.voltage"].time) == 50
    assert not any("share the time" in each for each in flight.remarks)


def test_all_subscriptions_of_a_topic_are_read(tmp_path):
    """A logger that starts again subscribes anew: the second half is another subscription."""
    halves = [(TIMES_US[:20], 0.0), (TIMES_US[20:], 100.0)]
    topics = [
        (
            "sensor_combined",
            0,
            stamps,
            {
                f"gyro_rad[{i}]": ("float", [first + k for k in range(len(stamps))])
                for i in range(3)
            },
        )
        for stamps, first in halves
    ]
    path = tmp_path / "a.ulg"
    path.write_bytes(ulog(topics))
    gyro = read_ulog(path)["imu.angular_velocity.x"]
    assert gyro.values.tolist() == [*range(20), *range(100, 130)]
    np.testing.assert_allclose(gyro.time, 1e-3 * np.arange(50), atol=1e-9)


def gyro_topic(name: str, instance: int, device: int, value: float) -> tuple:
    fields = {"device_id": ("uint32_t", [device] * 50)}
    return (name, instance, TIMES_US, fields | {axis: ("float", [value] * 50) for axis in "xyz"})


def test_sensor_gyro_stands_in_for_sensor_combined(tmp_path, case):
    path = tmp_path / "a.ulg"
    selection = ("sensor_selection", 0, TIMES_US[:2], {"gyro_device_id": ("uint32_t", [22, 22])})
    two = [gyro_topic("sensor_gyro", 0, 11, 1.0), gyro_topic("sensor_gyro", 1, 22, 2.0)]
    combined = {f"gyro_rad[{i}]": ("float", [3.0] * 50) for i in range(3)}
    for topics, parameters, expected in (
        (two, {}, (1.0, -1.0, -1.0)),
        ([*two, selection], {}, (2.0, -2.0, -2.0)),
        ([*two, ("sensor_combined", 0, TIMES_US, combined)], {}, (3.0, -3.0, -3.0)),
        (two[:1], {"SENS_BOARD_ROT": 4.0}, (-1.0, 1.0, -1.0)),  # half a turn about down
        (two[:1], {"SENS_BOARD_ROT": 2.0}, (-1.0, -1.0, -1.0)),  # a quarter: x forward is -y
    ):
        with case(len(topics), parameters):
            path.write_bytes(ulog(topics, parameters))
            flight = read_ulog(path)
            found = [flight[f"imu.angular_velocity.{axis}"].values[0] for axis in "xyz"]
            assert found == pytest.approx(expected)
    path.write_bytes(ulog(two[:1], {"SENS_BOARD_ROT": 8.0}))
    flight = read_ulog(path)
    assert "imu.angular_velocity.x" not in flight
    assert any("SENS_BOARD_ROT 8" in each for each in flight.remarks)


def test_samples_in_arrays_are_single_samples(tmp_path):
    """A message every 4 ms with 4 samples is a gyro at 1 kHz; its time is that of the last."""
    count = 40
    stamps = 1_000_000 + 4000 * np.arange(count)
    number = np.arange(4 * count).reshape(count, 4)
    fields = {
        "dt": ("float", [1000.0] * count),
        "scale": ("float", [0.001] * count),
        "samples": ("uint8_t", [4] * count),
    }
    for axis, sign in (("x", 1), ("y", -1), ("z", 2)):
        fields |= {
            f"{axis}[{i}]": ("int16_t", sign * number[:, i] if i < 4 else [9999] * count)
            for i in range(32)
        }
    path = tmp_path / "a.ulg"
    volts = {"voltage_v": ("float", [16.0] * count)}
    beside = ("battery_status", 0, stamps.tolist(), volts)
    path.write_bytes(ulog([("sensor_gyro_fifo", 0, stamps.tolist(), fields), beside]))
    flight = read_ulog(path)
    gyro = flight["imu.angular_velocity.x"]
    assert gyro.rate == pytest.approx(1000.0) and len(gyro.time) == 4 * count
    np.testing.assert_allclose(gyro.values, 1e-3 * np.arange(4 * count), rtol=1e-5)
    np.testing.assert_allclose(
        flight["imu.angular_velocity.y"].values, 1e-3 * np.arange(4 * count), rtol=1e-5
    )
    np.testing.assert_allclose(np.diff(gyro.time), 1e-3, atol=1e-9)
    np.testing.assert_allclose(flight["battery.voltage"].time, gyro.time[3::4], atol=1e-9)


def test_outputs_are_motor_commands_only_if_they_move_as_pulses(tmp_path, case):
    path = tmp_path / "a.ulg"

    def outputs(instance: int, low: float, high: float) -> tuple:
        values = np.linspace(low, high, 50)
        fields = {"noutputs": ("uint32_t", [4] * 50)}
        fields |= {f"output[{i}]": ("float", values) for i in range(4)}
        return ("actuator_outputs", instance, TIMES_US, fields)

    for topics, first, said in (
        ([outputs(0, 1100, 1900)], 0.1, "outputs of actuator_outputs, 1000 to 2000 us"),
        ([outputs(0, 900, 900), outputs(1, 1200, 1800)], 0.2, "outputs of actuator_outputs_1"),
        ([outputs(0, 900, 900)], None, "no output of actuator_outputs moves"),
        ([outputs(0, 0.0, 1.0)], None, "are not pulses"),
    ):
        with case(said):
            path.write_bytes(ulog(topics))
            flight = read_ulog(path)
            assert ("motors.command_1" in flight) == (first is not None)
            assert any(said in each for each in flight.remarks), flight.remarks
            if first is not None:
                assert flight["motors.command_1"].values[0] == pytest.approx(first)
                assert not any("no motor commands" in each for each in flight.remarks)


def test_a_unit_is_converted_or_refused(tmp_path, case):
    table = tmp_path / "a.csv"
    table.write_text("t,x\n" + "".join(f"{i},{600}\n" for i in range(20)))
    mapping = tmp_path / "a.mapping.yaml"

    def read(signal: str, unit: str, time: str = "unit: msec") -> Flight:
        unit = f", unit: '{unit}'" if unit else ""
        mapping.write_text(
            f"time: {{column: t, {time}}}\ncolumns: {{x: {{signal: {signal}{unit}}}}}"
        )
        return read_flight(table)

    for signal, unit, value in (
        ("rotors.speed_command.0", "RPM", 600 * np.pi / 30),
        ("rotors.speed.0", "rev/s", 1200 * np.pi),
        ("imu.angular_velocity.x", "dps", np.radians(600)),
        ("imu.angular_velocity.x", "mrad/s", 0.6),
        ("battery.voltage", "cV", 6.0),
        ("estimate.x", "ft", 182.88),
        ("estimate.v_x", "knot", 600 * 1852 / 3600),
        ("motors.command_1", "%", 6.0),
        ("estimate.yaw", "cdeg", np.radians(6.0)),
        ("my.heat", "degC", 873.15),
        ("my.field", "mG", 6e-5),
    ):
        with case(signal, unit):
            found = read(signal, unit)[signal]
            np.testing.assert_allclose(found.values, value)
            assert found.unit == standard_unit(signal) or found.unit in ("K", "T")
            assert found.rate == pytest.approx(1000.0)
    for signal, unit, said in (
        ("rotors.speed.0", "Hz", "is in rad/s, and Hz is no unit of that"),
        ("motors.command_1", "us", "is in 1"),
        ("battery.voltage", "mA", "is in V"),
        ("imu.angular_velocity.x", "dgs/s", "unknown unit 'dgs/s': did you mean"),
        ("estimate.x", "Meters", "did you mean meter"),
    ):
        with case(signal, unit), pytest.raises(WorkbenchError, match=said):
            read(signal, unit)
    with pytest.raises(WorkbenchError, match="time: unknown unit 'milis'"):
        read("battery.voltage", "V", "unit: milis")
    with pytest.raises(WorkbenchError, match="runs? backwards"):
        read("battery.voltage", "V", "unit: s, scale: -1")
    assert any("read as rad/s" in each for each in read("rate_setpoint.w_x", "").remarks)
    own = read("my.count", "counts")
    assert own["my.count"].unit == "counts" and any(
        "keeps its unit" in each for each in own.remarks
    )


def test_tables_with_decimal_commas_are_read_or_refused(tmp_path, case):
    """Rows that no delimiter makes right are never read as other numbers."""
    path, mapping = tmp_path / "a.csv", tmp_path / "a.mapping.yaml"
    columns = "columns:\n  g: {signal: imu.angular_velocity.x, unit: rad/s}"
    mapping.write_text(f"time: {{column: t, unit: s}}\n{columns}")
    rows = [(0.01 * i, 0.5 * i - 3.25) for i in range(20)]
    pairs = [[f"{value:.3f}".replace(".", ",") for value in row] for row in rows]
    for name, first, text in (
        ("European Excel", "", [f"{a};{b}" for a, b in pairs]),
        ("with its delimiter", "sep=;\n", [f"{a};{b}" for a, b in pairs]),
        ("points", "", [f"{a};{b}".replace(",", ".") for a, b in pairs]),
        ("tabs", "", [f"{a}\t{b}" for a, b in pairs]),
    ):
        with case(name):
            head = "t\tg" if name == "tabs" else "t;g"
            path.write_text("\ufeff" * (not first) + first + "\n".join([head, *text]))
            found = read_here(path)["imu.angular_velocity.x"]
            np.testing.assert_allclose(found.values, [row[1] for row in rows])
            np.testing.assert_allclose(found.time, [row[0] for row in rows], atol=1e-9)
    path.write_text("sep=;\n" + "\n".join(["t;g", *(f"{a};{b}" for a, b in pairs), "1,0;x"]))
    assert "in line 23" in read_here(path).remarks[0]
    for name, text, said in (
        ("no other delimiter", [f"{a},{b}" for a, b in pairs], "have more cells than the 2"),
        ("in quotes", [f'"{a}","{b}"' for a, b in pairs], "40 numbers with a comma and 0"),
        ("both", [f"{a};{row[1]}" for (a, _), row in zip(pairs, rows, strict=True)], "and 20 with"),
    ):
        with case(name), pytest.raises(WorkbenchError, match=said):
            path.write_text("\n".join(["t;g" if name == "both" else "t,g", *text]))
            read_here(path)
    path.write_text("\n".join(["t,g", *(f"{a},{b:.3f}," for a, b in rows)]))
    assert len(read_here(path)["imu.angular_velocity.x"].time) == 20  # an empty cell at the end
    mapping.write_text(f'delimiter: ";"\ntime: {{column: t, unit: s}}\n{columns}')
    with pytest.raises(WorkbenchError, match="column of .*'t'"):
        read_here(path)


def test_all_readers_give_shared_signals_their_units():
    rows = [
        *dataflash_reader.ARDUPILOT_SIGNAL_ROWS,
        *ulog_topics.PX4_SIGNAL_ROWS,
        *tlog_topics.MAVLINK_SIGNAL_ROWS,
        *tlog_topics.battery_rows("BATTERY_STATUS"),
    ]
    found = {(name, row.unit) for row in rows for name in row.names}
    found |= {(name, unit) for name, unit, _ in crazyflie_usd.SIGNAL_BY_USD_VARIABLE.values()}
    assert {(name, standard_unit(name)) for name, _ in found} == found


def turning(begin: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a yaw [rad] that turns twice around, and a setpoint just ahead of it."""
    yaw = begin + np.linspace(0.0, 4.0 * np.pi, 400)
    return yaw, yaw + 0.3


def wrap(angle: np.ndarray) -> np.ndarray:
    return np.arctan2(np.sin(angle), np.cos(angle))


@pytest.mark.parametrize("kind", ["ulg", "bin", "csv"])
def test_angles_pass_half_a_turn_without_a_jump(tmp_path, case, kind):
    stamps = (1_000_000 + 10_000 * np.arange(400)).tolist()
    for heading in np.radians([0.0, 90.0, 170.0, 180.0, -179.0, -90.0]):
        with case(heading):
            yaw, wanted = turning(heading)
            path = tmp_path / f"a.{kind}"
            if kind == "ulg":  # north, clockwise
                q = [
                    np.cos(0.25 * np.pi - 0.5 * yaw),
                    np.zeros(400),
                    np.zeros(400),
                    np.sin(0.25 * np.pi - 0.5 * yaw),
                ]
                sign = np.where(np.arange(400) % 90 < 45, 1.0, -1.0)  # the same attitude
                fields = {f"q[{i}]": ("float", part * sign) for i, part in enumerate(q)}
                goal = {"yaw": ("float", wrap(0.5 * np.pi - wanted))}
                path.write_bytes(
                    ulog(
                        [
                            ("vehicle_attitude", 0, stamps, fields),
                            ("trajectory_setpoint", 0, stamps, goal),
                        ]
                    )
                )
                setpoint = "setpoint.yaw"
            elif kind == "bin":
                degrees = [np.degrees(0.5 * np.pi - each) % 360.0 for each in (yaw, wanted)]
                rows = [(0.0, 0.0, a, 0.0, 0.0, b) for a, b in zip(*degrees, strict=True)]
                names = ("Roll", "Pitch", "Yaw", "DesRoll", "DesPitch", "DesYaw")
                path.write_bytes(dataflash([("ATT", "ffffff", names, stamps, rows)]))
                setpoint = "attitude_setpoint.yaw"
            else:
                rows = [
                    f"{t},{np.degrees(a)},{np.degrees(b)}"
                    for t, a, b in zip(stamps, wrap(yaw), wrap(wanted), strict=True)
                ]
                path.write_text("\n".join(["t,a,b", *rows]))
                (tmp_path / "a.mapping.yaml").write_text(
                    "time: {column: t, unit: us}\ncolumns:\n"
                    "  a: {signal: estimate.yaw, unit: deg}\n"
                    "  b: {signal: attitude_setpoint.yaw, unit: deg}"
                )
                setpoint = "attitude_setpoint.yaw"
            flight = read_here(path)
            found = flight["estimate.yaw"].values
            np.testing.assert_allclose(np.diff(found), np.diff(yaw), atol=1e-4)
            np.testing.assert_allclose(wrap(found - yaw), 0.0, atol=1e-4)
            np.testing.assert_allclose(flight[setpoint].values - found, 0.3, atol=1e-4)
            if "estimate.q_w" in flight:
                turn = np.column_stack([flight[f"estimate.q_{part}"].values for part in "wxyz"])
                assert (np.sum(turn[1:] * turn[:-1], axis=1) > 0.9).all()


def test_an_angle_is_in_the_same_turn_as_the_estimate_behind_a_gap():
    """Two turns in 4 s, of which a setpoint has no sample for 2 s, and no other one moves."""
    yaw, wanted = turning(0.5)
    time = 0.01 * np.arange(400)
    kept = (time <= 1.0) | (time >= 3.0)
    found = without_jumps(
        {
            "setpoint.yaw": make_series("setpoint.yaw", "rad", time[kept], wrap(wanted[kept])),
            "estimate.yaw": make_series("estimate.yaw", "rad", time, wrap(yaw)),
        }
    )
    np.testing.assert_allclose(found["estimate.yaw"].values, yaw, atol=1e-9)
    np.testing.assert_allclose(found["setpoint.yaw"].values, wanted[kept], atol=1e-9)


def test_a_log_that_an_earlier_version_imported_loses_its_jumps(tmp_path):
    yaw, wanted = turning(np.pi)
    signals = {
        name: make_series(name, "rad", 0.01 * np.arange(400), wrap(values), end=4.0)
        for name, values in (("estimate.yaw", yaw), ("setpoint.yaw", wanted))
    }
    path = tmp_path / "a.mcap"
    write_flight(Flight("a", tmp_path / "a", "made up", signals, end=4.0), path)
    flight = read_flight(path)
    found = flight["estimate.yaw"].values
    np.testing.assert_allclose(np.diff(found), np.diff(yaw), atol=1e-9)
    np.testing.assert_allclose(flight["setpoint.yaw"].values - found, 0.3, atol=1e-9)


@pytest.mark.slow
@shared
def test_the_shared_cases_have_their_right_values(tmp_path, capsys):
    deg = np.degrees
    first = read_flight(CASES / "01-blackbox-high-resolution/quad.bbl")
    assert deg(first["imu.angular_velocity.x"].values.max()) == pytest.approx(90.0, abs=0.1)
    assert deg(first["rate_setpoint.w_x"].values.max()) == pytest.approx(100.0, abs=0.1)
    scaled = read_flight(CASES / "03-blackbox-gyro-scale/quad.bbl")
    assert deg(scaled["imu.angular_velocity.x"].values.max()) == pytest.approx(90.0, abs=0.1)
    speeds = [
        read_flight(CASES / "04-unit-RPM/flight.csv", CASES / f"04-unit-RPM/{name}.mapping.yaml")
        for name in ("flight", "right")
    ]
    for number in range(4):
        name = f"rotors.speed_command.{number}"
        np.testing.assert_array_equal(*(each[name].values for each in speeds))
    for heading in ("west", "north"):
        assert main(["regress", str(CASES / f"06-yaw-wrap-ulog/{heading}.spec.yaml")]) == 0
    rows = read_flight(CASES / "08-time-restarts-csv/flight.csv")
    assert len(rows["imu.angular_velocity.x"].time) == 1000 and rows.remarks[0].number == 700
    back = read_flight(CASES / "10-time-back-ulog-bin/back3.ulg")
    assert len(back["estimate.q_w"].time) == 1000 and any("goes back" in r for r in back.remarks)
    bad = read_flight(CASES / "10-time-back-ulog-bin/one_bad.ulg")
    assert bad.end == pytest.approx(9.99) and len(bad["estimate.q_w"].time) == 999
    reboot = read_flight(CASES / "10-time-back-ulog-bin/reboot.bin")
    assert len(reboot["imu.angular_velocity.x"].time) == 1000
    wraps = read_flight(CASES / "11-time-wraps-blackbox/quad.bbl")
    assert wraps.end == pytest.approx(0.5995, abs=1e-3)
    assert len(wraps["imu.angular_velocity.x"].time) >= 1199
    second = read_flight(CASES / "20-blackbox-second-log/quad.bbl")
    assert second.end == pytest.approx(0.6, abs=0.01) and len(second.logs) == 2
    flown = read_flight(CASES / "21-ulog-second-battery/flight.ulg")
    np.testing.assert_allclose(flown["battery.voltage"].values, 16.5)
    np.testing.assert_allclose(flown["battery.current"].values, 11.0)
