"""Logs that others wrote: against their index, the parsers' own numbers, and made up files."""

import csv
import gzip
import struct
import zlib
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.extras.flightdata.foreign_files import blackbox, read_here, write_nanobench
from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.extras.flightdata.importing import write_flight
from workbench.extras.flightdata.readers.axes import angles, enu, from_ned_frd
from workbench.extras.flightdata.readers.mapped_csv import read_csv
from workbench.extras.flightdata.readers.topic_log import SignalRow, attitude_rows
from workbench.extras.flightdata.readers.ulog_topics import item_names
from workbench.logs.flight_contents import contents_of_flight
from workbench.logs.flight_reader import open_log, read_flight
from workbench.logs.readers import packed
from workbench.logs.readers.rotations import quaternion_from_angles, vectors_in_world
from workbench.logs.record import read_log

pytestmark = pytest.mark.usefixtures("unheld")

SHARED = Path(__file__).parents[3] / "../shared/flights/given"
real = pytest.mark.skipif(not SHARED.exists(), reason="put the real flights into ../shared/flights")
NED_TO_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD_TO_FLU = np.diag([1.0, -1.0, -1.0])


def turn(q: np.ndarray) -> np.ndarray:
    """Return scipy's rotation matrices of quaternions, w first."""
    return Rotation.from_quat(q[:, [1, 2, 3, 0]]).as_matrix()


def test_attitudes_are_those_of_scipy():
    q = np.random.default_rng(1).standard_normal((50, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    rpy = angles(q)
    np.testing.assert_allclose(
        Rotation.from_euler("ZYX", rpy[:, ::-1]).as_matrix(), turn(q), atol=1e-12
    )
    np.testing.assert_allclose(turn(quaternion_from_angles(*rpy.T)), turn(q), atol=1e-12)
    np.testing.assert_allclose(turn(from_ned_frd(q)), NED_TO_ENU @ turn(q) @ FRD_TO_FLU, atol=1e-12)
    vectors = np.random.default_rng(2).standard_normal((50, 3))
    np.testing.assert_allclose(
        vectors_in_world(q, vectors), np.einsum("nij,nj->ni", turn(q), vectors)
    )


@real
@pytest.mark.parametrize("every", [pytest.param(1, marks=pytest.mark.slow), 5])
def test_nanobench_is_read_as_its_index_says(case, every):
    """Ends, controllers, rates and gyro delays of 33 flights, and of two flawed ones."""
    offsets = []
    for folder in ("nanobench", "nanobench_flawed"):
        with (SHARED / folder / "index.csv").open() as file:
            rows = list(csv.DictReader(file))[::every]
        for row in rows:
            with case(row["file"]):
                flight = read_flight(SHARED / folder / f"{row['file']}.gz")
                assert flight.end == pytest.approx(float(row["duration_s"]), abs=0.011)
                contents = contents_of_flight(flight)
                end = float(row["onboard_data_end_s"])
                # The index leaves ends alone that are no longer than a common gap.
                slack = 0.03 if flight.end - end > 0.15 else 0.15
                gyro = flight["imu.angular_velocity.x"]
                assert gyro.time[-1] == pytest.approx(end, abs=slack)
                assert flight["motors.command_1"].time[-1] == pytest.approx(end, abs=slack)
                motors = np.concatenate(
                    [flight[f"motors.command_{i}"].values for i in (1, 2, 3, 4)]
                )
                assert motors.min() >= 0.0 and motors.max() <= 1.0
                if row["controller"] != "?":
                    assert flight.parameters["controller"] == row["controller"]
                    assert contents.turning > 10.0
                assert gyro.rate == pytest.approx(float(row["raw_rate_imu_hz"]), abs=0.2)
                for axis in "xyz":  # nobody flew further, but the extrapolated estimates did
                    assert abs(flight[f"estimate.{axis}"].values).max() < 2.5
                lag = next((o for o in contents.offsets if o.later == "gyro"), None)
                if row["gyro_minus_vicon_lag_ms"] and lag is not None:
                    offsets.append(1000.0 * lag.offset - float(row["gyro_minus_vicon_lag_ms"]))
    assert len(offsets) > 15 // every
    # Offsets of single axes scatter by 10 ms, and how the index weighs them is not said.
    assert np.abs(offsets).max() < 12.0 and abs(np.median(offsets)) < 4.0


def test_counts_of_a_longer_record_give_a_cut_table_no_rate(tmp_path):
    """Its metadata count 400 samples of the IMU, and the table has 200 rows at 100 Hz."""
    path = write_nanobench(tmp_path, 1_000_000 + 10_000 * np.arange(200), 1.7 * np.arange(200))
    for count, rate in ((400, 100.0), (180, 180 / 1.99)):
        (tmp_path / "a_metadata.yaml").write_text(f"row_counts: {{imu: {count}}}")
        assert read_here(path)["imu.angular_velocity.x"].rate == pytest.approx(rate, rel=1e-3)


@real
def test_flawed_flights_are_seen_to_be_useless():
    still = contents_of_flight(read_flight(SHARED / "nanobench_flawed/B7_oval_slow_rep1.csv.gz"))
    assert still.turning == 0.0 and not any(each.can for each in still.findable[:4])
    full = contents_of_flight(read_flight(SHARED / "nanobench_flawed/B6_linear_ramp_rep1.csv.gz"))
    assert full.saturated > 0.9


@real
def test_interpolated_gaps_are_left_out():
    flight = read_flight(SHARED / "nanobench/B5_helix_medium_rep2.csv.gz")
    longest = max(end - begin for begin, end in flight["estimate.x"].gaps[:-1])
    assert 0.3 < longest < 0.5  # "up to 400 ms for the on-board state"
    assert any("interpolated" in remark for remark in flight.remarks)


@real
def test_firmware_attitude_and_motion_capture_agree():
    """The legacy pitch is turned: both attitudes go the same way."""
    flight = read_flight(SHARED / "nanobench/B3_figure8_fast_rep2.csv.gz")
    for angle in ("roll", "pitch"):
        grid = flight.resample([f"position_data.{angle}", f"estimate.{angle}"], 0.01, 0.05)
        assert np.corrcoef(grid.values[grid.whole].T)[0, 1] > 0.8
        wanted = flight.resample([f"attitude_setpoint.{angle}", f"estimate.{angle}"], 0.01, 0.05)
        assert np.corrcoef(wanted.values[wanted.whole].T)[0, 1] > 0.5


@real
def test_a_usd_log_has_si_units_and_microseconds():
    flight = read_flight(SHARED / "crazyflie_1khz/log10.gz")
    gyro = flight["imu.angular_velocity.z"]
    assert flight.parameters["first_sample_s"] == pytest.approx(26.33, abs=0.01)
    assert flight.clock_start == flight.parameters["first_sample_s"]
    assert gyro.rate == pytest.approx(1.0 / 0.989e-3, rel=1e-3)
    rest = flight["imu.linear_acceleration.z"].values[:2000]
    assert rest.mean() == pytest.approx(9.81, abs=0.05)
    assert np.abs(gyro.values).max() < np.radians(2000.0)
    padded = read_flight(SHARED / "crazypad/motor_data/normal_flight/E9_log00")
    assert 3.0 < padded["battery.voltage"].values.min() < 4.3
    assert padded["motors.command_3"].values.max() <= 1.0


def usd_log(rows: list[tuple[int, float, float]], broken: bool = False) -> bytes:
    """Return a usd log of version 2: time [us], gyro.y [deg/s], acc.z [g]."""
    data = struct.pack("<BHHH", 0xBC, 2, 1, 7) + b"fixed\0" + struct.pack("<H", 2)
    data += b"gyro.y(f)\0acc.z(f)\0"
    for time, gyro, acc in rows:
        data += struct.pack("<HQff", 7, time, gyro, acc)
    return data + struct.pack("<I", zlib.crc32(data) ^ broken)


def test_a_made_up_usd_log(tmp_path):
    rows = [(1_000_000 + 1000 * i, 90.0, 1.0) for i in range(100)]
    path = tmp_path / "log07"
    path.write_bytes(usd_log(rows))
    flight = read_flight(path)
    assert flight.name == "log07" and flight.remarks == () and flight.end == pytest.approx(0.099)
    np.testing.assert_allclose(flight["imu.angular_velocity.y"].values, np.pi / 2, rtol=1e-6)
    np.testing.assert_allclose(flight["imu.linear_acceleration.z"].values, 9.81, rtol=1e-6)
    path.write_bytes(gzip.compress(usd_log(rows, broken=True)))
    assert "checksum" in read_flight(path).remarks[0]
    path.write_bytes(usd_log(rows)[:-50])
    assert "left out" in read_flight(path).remarks[0]


@real
def test_a_ulog_is_what_pyulog_reads_turned_to_our_axes():
    pyulog = pytest.importorskip("pyulog")
    path = SHARED / "px4_ulog/sample.ulg"
    flight = read_flight(path)
    log = pyulog.ULog(str(path))
    imu = log.get_dataset("sensor_combined").data
    gyro = flight["imu.angular_velocity.y"]
    assert len(gyro.time) == len(imu["timestamp"]) and gyro.rate == pytest.approx(250.0, rel=0.01)
    np.testing.assert_allclose(gyro.values, -imu["gyro_rad[1]"], rtol=1e-6)
    place = log.get_dataset("vehicle_local_position").data
    np.testing.assert_allclose(flight["estimate.z"].values, -place["z"], rtol=1e-6)
    turned = log.get_dataset("vehicle_attitude").data
    q = np.column_stack([turned[f"q[{i}]"] for i in range(4)]).astype(float)
    ours = np.column_stack([flight[f"estimate.q_{part}"].values for part in "wxyz"])
    np.testing.assert_allclose(turn(ours), NED_TO_ENU @ turn(q) @ FRD_TO_FLU, atol=1e-5)
    assert any("4 times" in remark for remark in flight.remarks)
    assert flight.parameters["SYS_AUTOSTART"] == 10020.0
    # An outer loop makes the rate setpoint here: there is no response to be trusted.
    assert "roll_rate" in contents_of_flight(flight).loops


@real
def test_a_dataflash_log_is_what_pymavlink_reads_turned_to_our_axes():
    reader = pytest.importorskip("pymavlink.DFReader")
    path = SHARED / "ardupilot/test.BIN"
    flight = read_flight(path)
    log, seen = reader.DFReader_binary(str(path)), []
    while (message := log.recv_match(type=["IMU", "ATT"])) is not None:
        seen.append(message)
    log.close()
    imu = [each for each in seen if each.get_type() == "IMU"]
    frd = np.array([[each.GyrX, each.GyrY, each.GyrZ] for each in imu])
    ours = np.column_stack([flight[f"imu.angular_velocity.{axis}"].values for axis in "xyz"])
    np.testing.assert_allclose(ours, frd * [1.0, -1.0, -1.0], rtol=1e-9)
    yaw = [each.Yaw for each in seen if each.get_type() == "ATT"]
    east = np.radians(90.0 - np.array(yaw))
    np.testing.assert_allclose(
        np.cos(flight["estimate.yaw"].values - east), 1.0, atol=1e-9
    )  # 0 is north there, and east here
    assert flight.firmware.startswith("ArduPlane V3.8.2") and len(flight.parameters) > 700


def made_up_blackbox(rows: int) -> bytes:
    """Return a log of Betaflight with all kinds of fields."""
    fields = ["gyroADC[0]", "gyroADC[1]", "setpoint[1]", "motor[0]", "accSmooth[2]", "vbatLatest"]
    values = [[90, -180, 360, 158 + i, 2048, 1620, 700] for i in range(rows)]
    stamps = [1_000_000 + 500 * i for i in range(rows)]
    return blackbox(stamps, values, [*fields, "eRPM[0]"], {"motor_poles": "14"})


def test_a_made_up_blackbox_log(tmp_path):
    path = tmp_path / "made.bbl"
    path.write_bytes(made_up_blackbox(200))
    flight = read_flight(path)
    assert flight.firmware.startswith("Betaflight 4.5.1")
    assert flight["imu.angular_velocity.x"].source == "gyroADC[0]"
    assert flight["rate_setpoint.w_y"].source == "setpoint[1]"
    gyro = flight["imu.angular_velocity.x"]
    assert gyro.rate == pytest.approx(2000.0) and len(gyro.time) >= 198
    np.testing.assert_allclose(gyro.values, np.pi / 2)
    np.testing.assert_allclose(flight["imu.angular_velocity.y"].values, -np.pi)
    np.testing.assert_allclose(flight["rate_setpoint.w_y"].values, 2.0 * np.pi)
    np.testing.assert_allclose(flight["imu.linear_acceleration.z"].values, 9.81)
    np.testing.assert_allclose(flight["battery.voltage"].values, 16.2)
    # 700 hundreds of electrical turns a minute, of 14 poles.
    np.testing.assert_allclose(flight["rotors.speed.0"].values, 10_000.0 * np.pi / 30.0)
    first = flight["motors.command_1"].values
    np.testing.assert_allclose(first[:3], np.arange(3) / (2047 - 158), atol=1e-12)


MAPPING = """
delimiter: ";"
time: {column: t, unit: ms}
columns:
  gx: {signal: imu.angular_velocity.x, unit: deg/s, sign: -1}
  m1: {signal: motors.command_1, unit: "1", scale: 0.001, offset: -1.0}
  v: {signal: battery.voltage, unit: mV, delay: 0.1}
"""


def test_a_csv_with_a_mapping(tmp_path, case):
    table = tmp_path / "own.csv"
    rows = [f"{10 * i};{90};{1000 + i};{11100}" for i in range(50)]
    rows[20:30] = []
    rows[3] = "30;;nonsense;11100"
    table.write_text("t; gx;m1;v\n" + "\n".join(rows))
    with pytest.raises(WorkbenchError, match="--mapping"):
        read_flight(table)
    (tmp_path / "own.mapping.yaml").write_text(MAPPING)
    flight = read_flight(table)
    np.testing.assert_allclose(flight["imu.angular_velocity.x"].values, -np.pi / 2)
    assert flight["motors.command_1"].values[2] == pytest.approx(0.002)
    assert flight["motors.command_1"].delay is None
    assert flight["battery.voltage"].delay == 0.1 and flight["battery.voltage"].values[0] == 11.1
    assert len(flight["battery.voltage"].gaps) == 1 and len(flight["motors.command_1"].time) == 39
    assert any("1 cells" in remark for remark in flight.remarks)
    for wrong, said in (
        (MAPPING.replace("gx:", "gz:"), "column of"),
        (MAPPING.replace("sign: -1", "sgn: -1"), "did you mean 'sign'"),
        (
            MAPPING.replace('motors.command_1, unit: "1"', "battery.voltage, unit: V"),
            "give each a different name",
        ),
        (MAPPING.replace("imu.angular_velocity.x", "Gyro X"), "is not a signal"),
        ("columns: {}", "is not a mapping"),
        ("[", "not YAML"),
    ):
        with case(said):
            path = tmp_path / "wrong.yaml"
            path.write_text(wrong)
            with pytest.raises(WorkbenchError, match=said):
                read_flight(table, path)


def test_an_imported_log_is_the_flight_again(tmp_path):
    random = np.random.default_rng(4)
    time = np.sort(random.uniform(0.0, 5.0, 300))
    late = np.arange(0.0, 4.0, 0.02)
    late = late[(late < 1.0) | (late > 2.0)]
    signals = {
        name: make_series(name, unit, when, random.standard_normal(len(when)), end=5.0, delay=delay)
        for name, unit, when, delay in (
            ("imu.angular_velocity.x", "rad/s", time, None),
            ("imu.angular_velocity.y", "rad/s", time, 0.01),
            ("estimate.q_w", "1", late, None),
            ("estimate.x", "m", time, None),
            ("rotors.speed.1", "rad/s", late, None),
        )
    }
    flight = Flight(
        "made", tmp_path / "made", "made up", signals, "firmware 1", {"KP": 2.0}, ("a", "b"), 5.0
    )
    path = tmp_path / "made.mcap"
    write_flight(flight, path)
    again = read_flight(path)
    assert (again.firmware, again.parameters, again.remarks) == (
        "firmware 1",
        {"KP": 2.0},
        ("a", "b"),
    )
    for name, signal in signals.items():
        np.testing.assert_allclose(again[name].time, signal.time, atol=1e-9)
        np.testing.assert_array_equal(again[name].values, signal.values)
        found = (again[name].unit, again[name].rate, again[name].delay, again[name].gaps)
        assert found == (signal.unit, signal.rate, signal.delay, signal.gaps)
    shown = open_log(path)["estimate.x"]
    drawn = open_log(path)["estimate.q_w"]
    (begin, end), _ = signals["estimate.q_w"].gaps
    inside = (drawn.time > begin + 1e-6) & (drawn.time < end - 1e-6)
    assert shown.unit == "m" and np.isnan(drawn.values[inside]).all() and inside.any()
    alone = open_log(path)["rotors.speed.1"]  # of which no other stream has a sample
    assert np.isnan(alone.values[(alone.time > begin + 1e-6) & (alone.time < end - 1e-6)]).all()
    assert len(alone.time) == len(late) + 2
    assert len(drawn.time) == len(late) + 2  # and no hole where the other stream has samples
    assert np.isfinite(shown.values).sum() == len(signals["estimate.x"].time)
    record = read_log(path)
    rotors = record.topics["rotors"]  # whose curve breaks in other programs, too
    lost = np.isnan(rotors.fields["speed.1"].values)
    assert rotors.time[lost] == pytest.approx([0.5 * (begin + end), 0.5 * (late[-1] + 5.0)])
    with pytest.raises(WorkbenchError, match="comes from another program"):
        record.scenario()


def test_a_damaged_table_of_states_is_read_as_far_as_it_is_whole(tmp_path):
    path = tmp_path / "flight.csv"
    groups = {"p_W": "xyz", "q_WB": "wxyz", "v_W": "xyz", "w_W": "xyz", "vdot_W": "xyz"}
    head = ["t [s]", *(f"{name}.{axis} [m]" for name, axes in groups.items() for axis in axes)]
    rows = [[0.01 * i, *(float(i + k) for k in range(1, len(head)))] for i in range(20)]
    lines = [",".join(map(str, row)) for row in (head, *rows)]
    lines[5] = lines[5].replace(",", ",x", 1)
    path.write_text("\n".join(lines)[:-30], encoding="utf-8")
    flight = read_flight(path)
    assert flight.remarks == ("2 damaged rows were left out, the first one is line 6",)
    expected = [row[3] for i, row in enumerate(rows[:-1]) if i != 4]
    assert flight["position_data.z"].values.tolist() == expected
    path.write_text("\n".join(lines[:3]), encoding="utf-8")
    with pytest.raises(WorkbenchError, match="fewer than three complete rows"):
        read_flight(path)


def test_what_is_no_log_is_a_sentence(tmp_path, case):
    for data, said in (
        (b"", "is empty"),
        (b"hello", "is not a known kind of log"),
        (b"\x1f\x8bhello", "cannot be unpacked"),
        (b"\xbc\x09\x00\x01\x00", "version 9"),
    ):
        with case(data):
            path = tmp_path / "some"
            path.write_bytes(data)
            with pytest.raises(WorkbenchError, match=said):
                read_flight(path)
    with pytest.raises(WorkbenchError, match="no such file"):
        read_flight(tmp_path / "none")
    with pytest.raises(WorkbenchError, match="a folder"):
        read_flight(tmp_path)


def many_columns(folder: Path, count: int) -> float:
    """Read a table of so many columns with a mapping; return the processor time [s]."""
    names = [f"c{number}" for number in range(count)]
    wide, mapping = folder / "wide.csv", folder / "wide.yaml"
    rows = ["\n" + ",".join(map(str, range(row, row + count + 1))) for row in range(3)]
    wide.write_text(",".join(["t", *names]) + "".join(rows))
    mapping.write_text(
        "time: {column: t, unit: s}\ncolumns:\n"
        + "".join(f'  {name}: {{signal: own.{name}, unit: "1"}}\n' for name in names)
    )
    begun = process_time()
    flight = read_csv(wide, mapping)
    assert flight[f"own.{names[-1]}"].values.tolist() == [count, count + 1.0, count + 2.0]
    return process_time() - begun


def test_a_mapping_of_ten_times_the_columns_takes_no_hundred_times_as_long(tmp_path):
    assert many_columns(tmp_path, 10_000) < 40.0 * many_columns(tmp_path, 1000)


def test_a_table_has_bounds(tmp_path, case, monkeypatch):
    monkeypatch.setattr(packed, "FREE_UNPACKED_BYTES", 1_000_000)
    table, small = tmp_path / "a.csv", tmp_path / "a.yaml"
    small.write_text(MAPPING)
    for data, said in (
        (b"t;gx;m1;v\n" + b"1" * 5_000_000, "has a line of more than 1 MB"),
        (gzip.compress(b"t;gx;m1;v\n" + bytes(100_000_000)), "unpacks to more than"),
        (gzip.compress(b"t;gx;m1;v\n" + b"1;2;3;4\n" * 200_000), "unpacks to more than 1 MB"),
        (b"t;gx;m1;v" + b";" * 60_000, "has more than 50000 columns"),
        (b't;gx;m1;v\n1;"2' + b"\n2" * 200_000, "cannot be read as CSV: field larger"),
    ):
        with case(said), pytest.raises(WorkbenchError, match=said):
            table.write_bytes(data)
            read_csv(table, small)


def test_standard_signals_have_the_names_of_the_firmware():
    """East is the second of north, east, down; an angle is of a whole quaternion."""
    row = SignalRow("local", "xyz", ("estimate.x", "estimate.y", "estimate.z"), "m", enu)
    assert [row.source_of(place) for place in range(3)] == ["local.y", "local.x", "local.z"]
    angle, quaternion = attitude_rows("att", item_names("q", 4), "estimate", lambda q: q)
    assert angle.source_of(0) == "att.q" and quaternion.source_of(2) == "att.q[2]"
