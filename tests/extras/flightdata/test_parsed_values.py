"""Readers beside the parsers of others, number by number, with the sign of our axes.

Each log is written here, with another random number in each cell, and parsed by pyulog, pymavlink
or orangebox; the logs of a Crazyflie and tables have no such parser, and their numbers are those
that were written. Which sign and which axis a number has is said once more in the tables here.
"""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.extras.flightdata.foreign_files import blackbox, dataflash, ulog, usd
from workbench.common.flight import Flight
from workbench.extras.flightdata.readers.blackbox import read_blackbox
from workbench.extras.flightdata.readers.crazyflie_usd import SIGNAL_BY_USD_VARIABLE, read_usd
from workbench.extras.flightdata.readers.dataflash import ARDUPILOT_SIGNAL_ROWS as DATAFLASH_ROWS
from workbench.extras.flightdata.readers.dataflash import read_dataflash
from workbench.extras.flightdata.readers.mapped_csv import read_csv
from workbench.extras.flightdata.readers.nanobench import read_nanobench
from workbench.extras.flightdata.readers.states_csv import read_states
from workbench.extras.flightdata.readers.ulog import read_ulog
from workbench.extras.flightdata.readers.ulog_topics import PX4_SIGNAL_ROWS as ULOG_ROWS

pytestmark = pytest.mark.usefixtures("unheld")

COUNT = 12
GRAVITY = 9.81
STAMPS = 1_000_000 + np.cumsum(np.random.default_rng(0).integers(3000, 5000, COUNT))
"""Of all samples [us], at no even period, so that a sample at another's place has its time."""
TIME = 1e-6 * (STAMPS - STAMPS[0])
SAME = ((0, 1.0), (1, 1.0), (2, 1.0))
ENU, FLU = ((1, 1.0), (0, 1.0), (2, -1.0)), ((0, 1.0), (1, -1.0), (2, -1.0))
"""For east, north, up or forward, left, up: the place of the number among north, east, down or
forward, right, down, and its factor."""
NED_TO_ENU = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
FRD_TO_FLU = np.diag([1.0, -1.0, -1.0])
DEGREES, RPM = np.pi / 180.0, np.pi / 30.0
KINDS = ("angular_velocity", "linear_acceleration")
"""Of the signals of an IMU."""


def numbers(fields, seed=1):
    """Return random columns (N) by field, between 0.1 and 1 of either sign."""
    random = np.random.default_rng(seed)
    signs = random.choice([-1.0, 1.0], (len(fields), COUNT))
    return dict(zip(fields, signs * random.uniform(0.1, 1.0, (len(fields), COUNT)), strict=True))


def check(flight: Flight, signals, parsed, places, scale=1.0):
    """Check signals against parsed columns (k, N), and their times."""
    for name, (place, factor) in zip(signals, places, strict=True):
        np.testing.assert_allclose(flight[name].time, TIME, atol=1e-9, err_msg=name)
        expected = scale * factor * np.asarray(parsed[place], dtype=float)
        np.testing.assert_allclose(flight[name].values, expected, rtol=1e-6, err_msg=name)


def xyz(beginning, axes="xyz"):
    return [f"{beginning}{axis}" for axis in axes]


def items(field, count=3):
    return [f"{field}[{i}]" for i in range(count)]


DOWN, AS_IT_IS = ((2, -1.0),), ((0, 1.0),)
PX4 = (
    # topic, fields, signals, and where their numbers are; of a signal the newest topic first
    ("vehicle_local_position", ["x", "y", "z"], xyz("estimate."), ENU),
    ("vehicle_local_position", ["vx", "vy", "vz"], xyz("estimate.v_"), ENU),
    ("vehicle_local_position", ["ax", "ay", "az"], xyz("estimate.a_"), ENU),
    ("vehicle_local_position_groundtruth", ["x", "y", "z"], xyz("position_data."), ENU),
    ("vehicle_local_position_groundtruth", ["vx", "vy", "vz"], xyz("velocity_data.v_"), ENU),
    ("vehicle_angular_velocity", items("xyz"), xyz("estimate.w_"), FLU),
    ("vehicle_angular_velocity_groundtruth", items("xyz"), xyz("attitude.w_"), FLU),
    ("vehicle_attitude", ["rollspeed", "pitchspeed", "yawspeed"], xyz("estimate.w_"), FLU),
    ("sensor_combined", items("accelerometer_m_s2"), xyz("imu.linear_acceleration."), FLU),
    ("sensor_combined", items("gyro_rad"), xyz("imu.angular_velocity."), FLU),
    ("vehicle_rates_setpoint", ["roll", "pitch", "yaw"], xyz("rate_setpoint.w_"), FLU),
    ("vehicle_attitude_setpoint", items("thrust_body"), ["attitude_setpoint.thrust"], DOWN),
    ("vehicle_attitude_setpoint", ["thrust"], ["attitude_setpoint.thrust"], AS_IT_IS),
    ("vehicle_rates_setpoint", items("thrust_body"), ["attitude_setpoint.thrust"], DOWN),
    ("vehicle_rates_setpoint", ["thrust"], ["attitude_setpoint.thrust"], AS_IT_IS),
    ("vehicle_torque_setpoint", items("xyz"), xyz("torque_setpoint."), FLU),
    ("actuator_controls_0", items("control", 4), xyz("torque_setpoint."), FLU),
    ("trajectory_setpoint", items("position"), xyz("setpoint."), ENU),
    ("trajectory_setpoint", items("velocity"), xyz("setpoint.v_"), ENU),
    ("vehicle_local_position_setpoint", ["x", "y", "z"], xyz("setpoint."), ENU),
    ("vehicle_local_position_setpoint", ["vx", "vy", "vz"], xyz("setpoint.v_"), ENU),
    ("battery_status", ["voltage_v"], ["battery.voltage"], AS_IT_IS),
    ("battery_status", ["current_a"], ["battery.current"], AS_IT_IS),
    ("actuator_motors", items("control", 4), xyz("motors.command_", "1234"), (*SAME, (3, 1.0))),
)


PX4_ATTITUDES = (
    # topic, quaternion, and topics of the quaternion and of the angles that it becomes
    ("vehicle_attitude", "q", "estimate", "estimate"),
    ("vehicle_attitude_groundtruth", "q", "attitude", "position_data"),
    ("vehicle_attitude_setpoint", "q_d", "attitude_setpoint", "attitude_setpoint"),
)


def px4(path, topic, columns):
    """Write a log of one topic; return the flight, and what pyulog reads of it."""
    pyulog = pytest.importorskip("pyulog")
    fields = {name: ("float", values) for name, values in columns.items()}
    path.write_bytes(ulog([(topic, 0, STAMPS.tolist(), fields)]))
    return read_ulog(path), pyulog.ULog(str(path)).get_dataset(topic).data


def test_px4s_numbers_are_pyulogs_with_the_sign_of_our_axes(tmp_path, case):
    for topic, fields, signals, places in PX4:
        with case(topic, fields):
            flight, parsed = px4(tmp_path / "a.ulg", topic, numbers(fields))
            check(flight, signals, [parsed[field] for field in fields], places)


def by_quaternion(flight, topic):
    """Return the rotation of B to W that the quaternion of a topic says."""
    q = np.column_stack([flight[f"{topic}.q_{part}"].values for part in "wxyz"])
    return Rotation.from_quat(q, scalar_first=True).as_matrix()


def by_angles(flight, topic):
    """Return the rotation of B to W that roll, pitch and yaw of a topic say."""
    rpy = [flight[f"{topic}.{angle}"].values for angle in ("roll", "pitch", "yaw")]
    return Rotation.from_euler("ZYX", np.column_stack(rpy)[:, ::-1]).as_matrix()


def test_px4s_attitudes_and_headings_are_turned_from_pyulogs(tmp_path, case):
    for topic, field, turn, angles in PX4_ATTITUDES:
        with case(topic):
            flight, parsed = px4(tmp_path / "a.ulg", topic, numbers(items(field, 4)))
            q = np.column_stack([parsed[each] for each in items(field, 4)])
            frd = Rotation.from_quat(q, scalar_first=True).as_matrix()
            for found in (by_quaternion(flight, turn), by_angles(flight, angles)):
                np.testing.assert_allclose(found, NED_TO_ENU @ frd @ FRD_TO_FLU, atol=1e-5)
    with case("before version 1.7"):
        columns = numbers(["roll_body", "pitch_body", "yaw_body"])
        flight, parsed = px4(tmp_path / "a.ulg", "vehicle_attitude_setpoint", columns)
        rpy = np.column_stack([parsed[each] for each in columns])
        frd = Rotation.from_euler("ZYX", rpy[:, ::-1]).as_matrix()
        found = by_angles(flight, "attitude_setpoint")
        np.testing.assert_allclose(found, NED_TO_ENU @ frd @ FRD_TO_FLU, atol=1e-6)
    for topic in ("trajectory_setpoint", "vehicle_local_position_setpoint"):
        with case(topic):
            flight, parsed = px4(tmp_path / "a.ulg", topic, numbers(["yaw"]))
            off = flight["setpoint.yaw"].values - (0.5 * np.pi - parsed["yaw"])
            np.testing.assert_allclose(np.cos(off), 1.0, atol=1e-9)
            np.testing.assert_allclose(np.sin(off), 0.0, atol=1e-6)


def test_of_px4s_topics_for_one_signal_the_newer_one_counts(tmp_path, case):
    """Whichever of both comes first in the log; the newer one stands before the other in `PX4`."""
    pairs = [
        (newer, older)
        for newer, older in itertools.combinations(PX4, 2)
        if newer[2] == older[2] and newer[0] != older[0]
    ]
    assert len(pairs) >= 4
    for newer, older in pairs:
        topics = []
        for seed, (topic, fields, _, _) in enumerate((newer, older), start=1):
            columns = {name: ("float", each) for name, each in numbers(fields, seed).items()}
            topics.append((topic, 0, STAMPS.tolist(), columns))
        for order in (topics, topics[::-1]):
            with case(newer[0], order[0][0]):
                path = tmp_path / "a.ulg"
                path.write_bytes(ulog(order))
                columns = list(numbers(newer[1]).values())
                check(read_ulog(path), newer[2], columns, newer[3])


def test_px4s_integrals_of_the_imu_are_over_their_time(tmp_path):
    """0.002 rad in 4 ms are 0.5 rad/s; without a duration there is no rate."""
    fields = [
        *items("delta_angle"),
        "delta_angle_dt",
        *items("delta_velocity"),
        "delta_velocity_dt",
    ]
    columns = numbers(fields)
    columns["delta_angle_dt"] = np.where(np.arange(COUNT) == 5, 0.0, 4000.0)
    columns["delta_velocity_dt"] = np.full(COUNT, 5000.0)
    flight, parsed = px4(tmp_path / "a.ulg", "vehicle_imu", columns)
    known = np.arange(COUNT) != 5
    for axis, (place, sign) in zip("xyz", FLU, strict=True):
        gyro, force = (flight[f"imu.{kind}.{axis}"] for kind in KINDS)
        rates = sign * parsed[f"delta_angle[{place}]"] / 0.004
        np.testing.assert_allclose(gyro.values, rates[known], rtol=1e-6)
        np.testing.assert_allclose(gyro.time, TIME[known], atol=1e-9)
        expected = sign * parsed[f"delta_velocity[{place}]"] / 0.005
        np.testing.assert_allclose(force.values, expected, rtol=1e-6)


def test_a_number_that_px4_does_not_know_is_not_measured(tmp_path):
    columns = numbers(["voltage_v", "current_a"])
    columns["voltage_v"][3], columns["current_a"][7] = 0.0, -1.0
    flight, parsed = px4(tmp_path / "a.ulg", "battery_status", columns)
    for name, field, lost in (("voltage", "voltage_v", 3), ("current", "current_a", 7)):
        np.testing.assert_array_equal(
            flight[f"battery.{name}"].values, np.delete(parsed[field], lost).astype(float)
        )


def test_px4s_rotor_speeds_are_pyulogs_in_radians(tmp_path):
    """Of two speed controllers; a report may have room for more."""
    pyulog = pytest.importorskip("pyulog")
    rpm = {f"esc[{i}].esc_rpm": ("int32_t", 1000 * i + 100 * np.arange(COUNT)) for i in range(3)}
    fields = {"esc_count": ("uint8_t", [2] * COUNT), **rpm}
    path = tmp_path / "a.ulg"
    path.write_bytes(ulog([("esc_status", 0, STAMPS.tolist(), fields)]))
    parsed = pyulog.ULog(str(path)).get_dataset("esc_status").data
    flight = read_ulog(path)
    assert flight.motors("rotors.speed.") == xyz("rotors.speed.", "01")
    for i in range(2):
        check(flight, [f"rotors.speed.{i}"], [parsed[f"esc[{i}].esc_rpm"]], AS_IT_IS, RPM)


def test_px4s_rotor_speeds_are_in_the_order_of_the_motors(tmp_path, case):
    """An ESC states the function of its output since 1.13: 101 is the first motor."""
    path = tmp_path / "a.ulg"
    in_order = (0, 1, 2)
    for functions, motors in (
        ((103, 101, 102), (2, 0, 1)),
        ((0, 0, 0), in_order),
        ((101, 101, 102), in_order),
    ):
        with case(functions):
            fields = {"esc_count": ("uint8_t", [3] * COUNT)}
            for i in range(3):
                fields[f"esc[{i}].esc_rpm"] = ("int32_t", [1000 * (i + 1)] * COUNT)
                fields[f"esc[{i}].actuator_function"] = ("uint8_t", [functions[i]] * COUNT)
            path.write_bytes(ulog([("esc_status", 0, STAMPS.tolist(), fields)]))
            flight = read_ulog(path)
            for i, motor in enumerate(motors):
                speed = flight[f"rotors.speed.{motor}"].values[0]
                assert speed == pytest.approx(1000 * (i + 1) * RPM)


def test_a_position_that_px4_does_not_know_is_not_measured(tmp_path, case):
    """Indoors its estimator has a height alone, and writes zeros for the rest."""
    path = tmp_path / "a.ulg"
    flags = {"xy_valid": "xy", "z_valid": "z", "v_xy_valid": ("v_x", "v_y"), "v_z_valid": ["v_z"]}
    for wrong, lost in flags.items():
        with case(wrong):
            columns = {
                name: ("float", values)
                for name, values in numbers(["x", "y", "z", "vx", "vy", "vz"]).items()
            } | {name: ("bool", [name != wrong or i < 5 for i in range(COUNT)]) for name in flags}
            path.write_bytes(ulog([("vehicle_local_position", 0, STAMPS.tolist(), columns)]))
            flight = read_ulog(path)
            for name in ("x", "y", "z", "v_x", "v_y", "v_z"):
                count = len(flight[f"estimate.{name}"].time)
                assert count == (5 if name in lost else COUNT), name


def test_px4s_outputs_have_the_limits_of_their_group(tmp_path, case):
    """Of MAIN 1000 to 2000 us, of AUX 1100 to 1900 us: 1500 us are 0.5 of both, 1900 are not."""
    limits = {"PWM_MAIN_MIN": 1000, "PWM_MAIN_MAX": 2000, "PWM_AUX_MIN": 1100, "PWM_AUX_MAX": 1900}
    pulses = np.linspace(1500.0, 1900.0, COUNT)
    for first, expected in ((0, 0.9), (1, 1.0)):
        with case(first):
            topics = [
                (
                    "actuator_outputs",
                    instance,
                    STAMPS.tolist(),
                    {
                        "noutputs": ("uint32_t", [1] * COUNT),
                        "output[0]": ("float", pulses if instance == first else [900.0] * COUNT),
                    },
                )
                for instance in range(first + 1)
            ]
            path = tmp_path / "a.ulg"
            path.write_bytes(ulog(topics, limits))
            command = read_ulog(path)["motors.command_1"].values
            assert command[[0, -1]] == pytest.approx([0.5, expected])


def test_px4s_time_is_that_of_the_sample_where_all_samples_have_one(tmp_path, case):
    """Published 700 us after it was measured; a stamp of 0 says that it is not known."""
    gyro = {field: ("float", values) for field, values in numbers(items("gyro_rad")).items()}
    measured, begin = STAMPS - 700, int(STAMPS[0]) - 900
    first = ("battery_status", 0, [begin, int(STAMPS[6])], {"voltage_v": ("float", [16.0, 15.0])})
    for name, samples, expected in (
        ("all", measured, measured),
        ("none", np.zeros(COUNT), STAMPS),
        ("some", np.where(np.arange(COUNT) % 3 == 0, measured, 0), STAMPS),
        ("all but one", np.where(np.arange(COUNT) == 4, 0, measured), STAMPS),
    ):
        with case(name):
            fields = {"timestamp_sample": ("uint64_t", samples), **gyro}
            path = tmp_path / "a.ulg"
            path.write_bytes(ulog([first, ("sensor_combined", 0, STAMPS.tolist(), fields)]))
            found = read_ulog(path)["imu.angular_velocity.x"]
            np.testing.assert_allclose(found.time, 1e-6 * (expected - begin), atol=1e-9)
            np.testing.assert_allclose(found.values, gyro["gyro_rad[0]"][1], rtol=1e-6)


def test_what_px4_measured_before_its_log_began_is_left_out(tmp_path):
    """A topic that was never published comes once, with the time 0."""
    gyro = {field: ("float", values) for field, values in numbers(items("gyro_rad")).items()}
    never = {"voltage_v": ("float", [16.0, 15.0, 14.0])}
    begin = int(STAMPS[2])
    path = tmp_path / "a.ulg"
    path.write_bytes(
        ulog(
            [
                ("sensor_combined", 0, STAMPS.tolist(), gyro),
                ("battery_status", 0, [0, *STAMPS[[3, 8]].tolist()], never),
            ],
            begin=begin,
        )
    )
    flight = read_ulog(path)
    np.testing.assert_allclose(
        flight["imu.angular_velocity.x"].time, 1e-6 * (STAMPS[2:] - begin), atol=1e-9
    )
    assert flight["battery.voltage"].values.tolist() == [15.0, 14.0]


ARDUPILOT = (
    # message, columns, signals, where their numbers are, and to SI
    ("XKF1", ["PN", "PE", "PD"], xyz("estimate."), ENU, 1.0),
    ("XKF1", ["VN", "VE", "VD"], xyz("estimate.v_"), ENU, 1.0),
    ("NKF1", ["PN", "PE", "PD"], xyz("estimate."), ENU, 1.0),
    ("NKF1", ["VN", "VE", "VD"], xyz("estimate.v_"), ENU, 1.0),
    ("IMU", ["GyrX", "GyrY", "GyrZ"], xyz("imu.angular_velocity."), FLU, 1.0),
    ("IMU", ["AccX", "AccY", "AccZ"], xyz("imu.linear_acceleration."), FLU, 1.0),
    ("RATE", ["R", "P", "Y"], xyz("estimate.w_"), FLU, DEGREES),
    ("RATE", ["RDes", "PDes", "YDes"], xyz("rate_setpoint.w_"), FLU, DEGREES),
    ("RATE", ["ROut", "POut", "YOut"], xyz("torque_setpoint."), FLU, 1.0),
    *(
        (f"PSC{axis}", [f"{kind}P{axis}", f"{kind}V{axis}"], ours, ((0, sign), (1, sign)), 1.0)
        for kind in "TD"
        for axis, ours, sign in (
            ("N", ["setpoint.y", "setpoint.v_y"], 1.0),
            ("E", ["setpoint.x", "setpoint.v_x"], 1.0),
            ("D", ["setpoint.z", "setpoint.v_z"], -1.0),
        )
    ),
    ("CTUN", ["ThO"], ["attitude_setpoint.thrust"], AS_IT_IS, 1.0),
    ("ESC", ["RPM"], ["rotors.speed.0"], AS_IT_IS, RPM),
    ("BAT", ["Volt", "Curr"], ["battery.voltage", "battery.current"], SAME[:2], 1.0),
)


ARDUPILOT_ATTITUDES = (
    ("ATT", ["Roll", "Pitch", "Yaw"], "estimate", "estimate"),
    ("ATT", ["DesRoll", "DesPitch", "DesYaw"], "attitude_setpoint", "attitude_setpoint"),
    ("SIM", ["Roll", "Pitch", "Yaw"], "attitude", "position_data"),
)


def ardupilot(path, name, columns, *more):
    """Write a log of one message and others; return the flight, and what pymavlink reads of it."""
    reader = pytest.importorskip("pymavlink.DFReader")
    rows = list(zip(*columns.values(), strict=True))
    message = (name, "f" * len(columns), list(columns), STAMPS.tolist(), rows)
    path.write_bytes(dataflash([message, *more]))
    log, found = reader.DFReader_binary(str(path)), []
    while (each := log.recv_match(type=[name])) is not None:
        found.append([getattr(each, column) for column in columns])
    log.close()
    assert len(found) == COUNT
    return read_dataflash(path), np.transpose(found)


def test_ardupilots_numbers_are_pymavlinks_with_the_sign_of_our_axes(tmp_path, case):
    for name, fields, signals, places, scale in ARDUPILOT:
        with case(name, fields):
            flight, parsed = ardupilot(tmp_path / "a.bin", name, numbers(fields))
            check(flight, signals, parsed, places, scale)


def test_ardupilots_attitudes_are_turned_from_pymavlinks(tmp_path, case):
    for name, fields, turn, angles in ARDUPILOT_ATTITUDES:
        with case(name, fields):
            columns = {field: 80.0 * values for field, values in numbers(fields).items()}
            flight, parsed = ardupilot(tmp_path / "a.bin", name, columns)
            frd = Rotation.from_euler("ZYX", parsed.T[:, ::-1], degrees=True).as_matrix()
            for found in (by_quaternion(flight, turn), by_angles(flight, angles)):
                np.testing.assert_allclose(found, NED_TO_ENU @ frd @ FRD_TO_FLU, atol=1e-6)


def test_ardupilots_motors_are_the_channels_with_their_functions(tmp_path):
    """Motor 1 of SERVO3, 2 of SERVO1, and 1100 to 1900 us."""
    pulses = {f"C{i}": np.linspace(1100 + 100 * i, 1200 + 100 * i, COUNT) for i in (1, 2, 3)}
    asked = {"SERVO3_FUNCTION": 33, "SERVO1_FUNCTION": 34, "MOT_PWM_MIN": 1100, "MOT_PWM_MAX": 1900}
    rows = list(asked.items())
    told = ("PARM", "Nf", ("Name", "Value"), STAMPS[: len(rows)].tolist(), rows)
    flight, parsed = ardupilot(tmp_path / "a.bin", "RCOU", pulses, told)
    assert flight.motors("motors.command_") == xyz("motors.command_", "12")
    for motor, place in ((1, 2), (2, 0)):
        expected = (parsed[place] - 1100.0) / 800.0
        np.testing.assert_allclose(flight[f"motors.command_{motor}"].values, expected, rtol=1e-6)


def test_ardupilots_position_is_that_of_the_core_that_flew(tmp_path, case):
    """XKF4.PI has its number; the first one counts where none is stated."""
    stamps, names = STAMPS.tolist(), ("C", "VN", "VE", "VD", "PN", "PE", "PD")
    rows = [(core, *(10.0 * core + i for i in range(6))) for core in (0, 1)] * (COUNT // 2)
    estimates = ("XKF1", "Bffffff", names, stamps, rows)
    path = tmp_path / "a.bin"
    path.write_bytes(dataflash([estimates]))
    assert read_dataflash(path)["estimate.y"].values == pytest.approx(3.0)
    for primary, north in ((0, 3.0), (1, 13.0), (2, 3.0)):
        with case(primary):
            told = ("XKF4", "BB", ("C", "PI"), stamps, [(0, primary)] * COUNT)
            path.write_bytes(dataflash([estimates, told]))
            assert read_dataflash(path)["estimate.y"].values == pytest.approx(north)


def test_a_tricopters_tail_servo_is_no_motor(tmp_path, case):
    """Nor are the flaps below coaxial rotors; motors 9 to 12 have functions 82 to 85."""
    pulses = {f"C{i}": np.linspace(1000 + 50 * i, 1100 + 50 * i, COUNT) for i in range(1, 15)}
    for frame, functions, motors in (
        (7, (33, 34, 36, 39), (1, 2, 4)),
        (1, (33, 34, 36, 39), (1, 2, 4, 7)),
        (9, (33, 34, 35, 36, 37, 38), (5, 6)),
        (12, (*range(33, 41), *range(82, 86)), tuple(range(1, 13))),
    ):
        with case(frame):
            rows = [("FRAME_CLASS", frame)]
            rows += [(f"SERVO{i}_FUNCTION", each) for i, each in enumerate(functions, start=1)]
            stamps = STAMPS[0] + np.arange(len(rows))
            told = ("PARM", "Nf", ("Name", "Value"), stamps.tolist(), rows)
            flight, _ = ardupilot(tmp_path / "a.bin", "RCOU", pulses, told)
            assert flight.motors("motors.command_") == [f"motors.command_{i}" for i in motors]


def test_ardupilots_outputs_have_the_limits_of_their_kind(tmp_path, case):
    """AP_MotorsMulticopter: own limits if both are set, else those of the throttle's channel."""
    pulses = {"C1": np.full(COUNT, 1500.0)}
    pulses["C1"][-1] = 1700.0
    radio = {"RC3_MIN": 1100, "RC3_MAX": 1900, "RC5_MIN": 900, "RC5_MAX": 2100}
    for asked, expected in (
        ({"MOT_PWM_MIN": 1200, "MOT_PWM_MAX": 1800}, 0.5 + 200 / 600),
        ({"MOT_PWM_MIN": 0, "MOT_PWM_MAX": 1800} | radio, 0.5 + 200 / 800),
        (radio | {"RCMAP_THROTTLE": 5}, 0.5 + 200 / 1200),
        ({"MOT_PWM_TYPE": 6, "MOT_PWM_MIN": 1200, "MOT_PWM_MAX": 1800} | radio, 0.5 + 200 / 1000),
        ({}, 0.5 + 200 / 1000),
    ):
        with case(asked):
            rows = list(({"SERVO1_FUNCTION": 33} | asked).items())
            told = ("PARM", "Nf", ("Name", "Value"), [int(STAMPS[0])] * len(rows), rows)
            flight, _ = ardupilot(tmp_path / "a.bin", "RCOU", pulses, told)
            command = flight["motors.command_1"].values
            assert command[[0, -1]] == pytest.approx([0.5, expected])


def test_an_old_copters_motors_are_the_first_channels(tmp_path):
    """Which had no parameters for what channels do; those of a plane are not known."""
    pulses = {f"C{i}": np.linspace(1000 + 100 * i, 1100 + 100 * i, COUNT) for i in range(1, 6)}
    for firmware, motors in (("ArduCopter V3.2.1", "1234"), ("ArduPlane V3.3", "")):
        said = ("MSG", "Z", ("Message",), [int(STAMPS[0])], [(firmware,)])
        flight, parsed = ardupilot(tmp_path / "a.bin", "RCOU", pulses, said)
        assert flight.motors("motors.command_") == xyz("motors.command_", motors)
        for motor in map(int, motors):
            expected = (parsed[motor - 1] - 1000.0) / 1000.0
            np.testing.assert_allclose(
                flight[f"motors.command_{motor}"].values, expected, rtol=1e-6
            )


def test_the_firmware_is_the_text_with_a_version(tmp_path, case):
    """Not each text of ArduPilot about itself, whatever comes first."""
    for texts, firmware in (
        (["ArduPilot Ready", "ArduCopter V4.5.7 (2a3dc4b7)"], "ArduCopter V4.5.7 (2a3dc4b7)"),
        (["Frame: QUAD", "APM:Copter V3.5.7 (b11c6af3)"], "APM:Copter V3.5.7 (b11c6af3)"),
        (["ArduPilot Ready", "Arducam: none"], ""),
    ):
        with case(texts):
            stamps, rows = STAMPS[: len(texts)].tolist(), [(text,) for text in texts]
            told = ("MSG", "Z", ("Message",), stamps, rows)
            flight, _ = ardupilot(
                tmp_path / "a.bin", "IMU", numbers(["GyrX", "GyrY", "GyrZ"]), told
            )
            assert flight.firmware == firmware


def test_of_ardupilots_parameters_the_last_value_counts(tmp_path):
    """As pymavlink keeps them; a value that is written again has not changed."""
    reader = pytest.importorskip("pymavlink.DFReader")
    rows = [
        ("ATC_RAT_RLL_P", 0.25),
        ("MOT_PWM_MIN", 1000),
        ("ATC_RAT_RLL_P", 0.5),
        ("MOT_PWM_MIN", 1000),
    ]
    told = ("PARM", "Nf", ("Name", "Value"), STAMPS[: len(rows)].tolist(), rows)
    path = tmp_path / "a.bin"
    flight, _ = ardupilot(path, "IMU", numbers(["GyrX", "GyrY", "GyrZ"]), told)
    log = reader.DFReader_binary(str(path))
    while log.recv_msg() is not None:
        pass
    assert flight.parameters == {
        name: log.params[name] for name in ("ATC_RAT_RLL_P", "MOT_PWM_MIN")
    }
    log.close()
    assert flight.parameters["ATC_RAT_RLL_P"] == 0.5
    (remark,) = (each for each in flight.remarks if "changed" in each)
    assert remark.number == 1 and "ATC_RAT_RLL_P" in remark


def test_no_signal_of_these_readers_is_left_out_here():
    for rows, table, attitudes in (
        (ULOG_ROWS, PX4, PX4_ATTITUDES),
        (DATAFLASH_ROWS, ARDUPILOT, ARDUPILOT_ATTITUDES),
    ):
        known = {(row[0], name) for row in table for name in row[2]}
        for topic, _, turn, angles in attitudes:
            known |= {(topic, f"{turn}.q_{part}") for part in "wxyz"}
            known |= {(topic, f"{angles}.{angle}") for angle in ("roll", "pitch", "yaw")}
        found = {(row.topic, name) for row in rows for name in row.names}
        more = {(topic, name) for topic, name in found if name == "setpoint.yaw" or "ESC_" in topic}
        assert found - more <= known


BETAFLIGHT = (
    # field, signal, and to SI
    *((f"gyroADC[{i}]", f"imu.angular_velocity.{axis}", DEGREES) for i, axis in enumerate("xyz")),
    *(
        (f"accSmooth[{i}]", f"imu.linear_acceleration.{x}", GRAVITY / 2048)
        for i, x in enumerate("xyz")
    ),
    *((f"setpoint[{i}]", f"rate_setpoint.w_{axis}", DEGREES) for i, axis in enumerate("xyz")),
    ("setpoint[3]", "attitude_setpoint.thrust", 1e-3),
    *((f"eRPM[{i}]", f"rotors.speed.{i}", 100.0 * 2.0 / 12.0 * RPM) for i in range(4)),
    ("vbatLatest", "battery.voltage", 0.01),
    ("amperageLatest", "battery.current", 0.01),
)


def test_betaflights_numbers_are_orangeboxes_with_their_sign(tmp_path):
    """Its axes are forward, left, up, with nose down and a turn to the left positive."""
    orangebox = pytest.importorskip("orangebox")
    fields = [field for field, _, _ in BETAFLIGHT]
    columns = {field: np.rint(1000.0 * each) for field, each in numbers(fields).items()}
    rows = [[int(value) for value in row] for row in zip(*columns.values(), strict=True)]
    path = tmp_path / "a.bbl"
    path.write_bytes(blackbox(STAMPS.tolist(), rows, fields, {"motor_poles": "12"}))
    parser = orangebox.Parser.load(str(path))
    names = list(parser.field_names)
    parsed = np.array([frame.data for frame in parser.frames()], dtype=float).T
    np.testing.assert_array_equal(parsed[names.index("time")], STAMPS)
    flight = read_blackbox(path)
    for field, signal, scale in BETAFLIGHT:
        check(flight, [signal], [parsed[names.index(field)]], AS_IT_IS, scale)


CRAZYFLIE = {
    # variable: signal, and to SI; forward, left, up, and its pitch is positive nose up
    **{f"acc.{x}": (f"imu.linear_acceleration.{x}", GRAVITY) for x in "xyz"},
    **{f"gyro.{x}": (f"imu.angular_velocity.{x}", DEGREES) for x in "xyz"},
    **{f"stateEstimate.{x}": (f"estimate.{x}", 1.0) for x in "xyz"},
    **{f"stateEstimate.v{x}": (f"estimate.v_{x}", 1.0) for x in "xyz"},
    **{f"stateEstimate.a{x}": (f"estimate.a_{x}", GRAVITY) for x in "xyz"},
    **{f"stateEstimate.q{x}": (f"estimate.q_{x}", 1.0) for x in "wxyz"},
    **{
        f"{log}.{angle}": (f"{topic}.{angle}", sign * DEGREES)
        for log, topic in (
            ("stateEstimate", "estimate"),
            ("stabilizer", "estimate"),
            ("controller", "attitude_setpoint"),
        )
        for angle, sign in (("roll", 1.0), ("pitch", -1.0), ("yaw", 1.0))
    },
    "controller.rollRate": ("rate_setpoint.w_x", DEGREES),
    "controller.pitchRate": ("rate_setpoint.w_y", -DEGREES),
    "controller.yawRate": ("rate_setpoint.w_z", DEGREES),
    "controller.actuatorThrust": ("attitude_setpoint.thrust", 1.0 / 65535.0),
    **{f"ctrltarget.{x}": (f"setpoint.{x}", 1.0) for x in "xyz"},
    **{f"ctrltarget.v{x}": (f"setpoint.v_{x}", 1.0) for x in "xyz"},
    "ctrltarget.yaw": ("setpoint.yaw", DEGREES),
    "pm.vbat": ("battery.voltage", 1.0),
    "pm.vbatMV": ("battery.voltage", 1e-3),
    **{f"motor.m{i}": (f"motors.command_{i}", 1.0 / 65535.0) for i in range(1, 5)},
    **{f"pwm.m{i}_pwm": (f"motors.command_{i}", 1.0 / 65535.0) for i in range(1, 5)},
}


@pytest.mark.parametrize("version", [1, 2])
def test_a_crazyflies_numbers_are_those_that_were_written(tmp_path, case, version):
    assert CRAZYFLIE.keys() == SIGNAL_BY_USD_VARIABLE.keys()
    stamps = (STAMPS // 1000 if version == 1 else STAMPS).tolist()
    for variable, (signal, scale) in CRAZYFLIE.items():
        with case(variable):
            (values,) = numbers([variable]).values()
            path = tmp_path / "log00"
            path.write_bytes(usd(stamps, {variable: values.tolist()}, version))
            found = read_usd(path)[signal]
            np.testing.assert_allclose(found.values, scale * values, rtol=1e-6)
            seconds = (1e-3 if version == 1 else 1e-6) * (np.array(stamps) - stamps[0])
            np.testing.assert_allclose(found.time, seconds, atol=1e-9)
    begin = read_usd(path).parameters["first_sample_s"]
    assert begin == pytest.approx((1e-3 if version == 1 else 1e-6) * stamps[0])


def test_of_a_crazyflies_motors_those_behind_the_battery_count(tmp_path, case):
    columns = numbers(["motor.m2", "pwm.m2_pwm"])
    for names in (list(columns), list(columns)[::-1]):
        with case(names):
            path = tmp_path / "log00"
            path.write_bytes(usd(STAMPS.tolist(), {name: columns[name] for name in names}))
            flight = read_usd(path)
            pwm = columns["pwm.m2_pwm"] / 65535.0
            np.testing.assert_allclose(flight["motors.command_2"].values, pwm, rtol=1e-6)
            np.testing.assert_allclose(flight["motor.m2"].values, columns["motor.m2"], rtol=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_tables_numbers_are_those_of_its_mapping(tmp_path, case, sign):
    """A value is sign * (scale * x + offset) in its unit, whatever these are."""
    table, mapping = tmp_path / "a.csv", tmp_path / "a.mapping.yaml"
    (x,) = numbers(["x"]).values()
    table.write_text(
        "t,x\n" + "".join(f"{t},{v!r}\n" for t, v in zip(STAMPS, x.tolist(), strict=True))
    )
    for signal, unit, scale, offset, to_si, zero in (
        ("imu.angular_velocity.y", "deg/s", 3.0, 10.0, DEGREES, 0.0),
        ("imu.angular_velocity.y", "deg/s", -3.0, -10.0, DEGREES, 0.0),
        ("battery.voltage", "mV", 100.0, 11_000.0, 1e-3, 0.0),
        ("motors.command_2", '"1"', 0.5, 0.5, 1.0, 0.0),
        ("own.heat", "degC", 10.0, 20.0, 1.0, 273.15),
    ):
        with case(signal, scale):
            mapping.write_text(
                f"time: {{column: t, unit: us}}\ncolumns:\n  x: {{signal: {signal}, unit: {unit}, "
                f"scale: {scale}, offset: {offset}, sign: {sign:g}}}"
            )
            found = read_csv(table, mapping)[signal]
            expected = to_si * sign * (scale * x + offset) + zero
            np.testing.assert_allclose(found.values, expected, rtol=1e-12, atol=1e-12)
            np.testing.assert_allclose(found.time, TIME, atol=1e-9)


def table_of(columns):
    """Return a table of columns (N), of numbers or texts."""
    rows = [",".join(columns)]
    rows += [",".join(map(str, row)) for row in zip(*columns.values(), strict=True)]
    return "\n".join(rows)


def test_a_simulated_flights_commands_hold_from_the_row_before_on(tmp_path):
    """A row has the state at its time, and what was commanded up to then."""
    states = xyz("p_W.") + xyz("q_WB.", "wxyz") + xyz("v_W.") + xyz("w_W.") + xyz("vdot_W.")
    columns = {"t [s]": TIME} | numbers([f"{name} [SI]" for name in states])
    commands = ["speed_command.1", "speed_command.2", *xyz("setpoint."), "command.v_x"]
    columns |= numbers([f"{name} [SI]" for name in commands], seed=2)
    columns |= numbers(["speed.1 [SI]", "speed.2 [SI]"], seed=3)
    text = table_of(columns).replace("p_W.x [SI]", "p_W.x [m]")
    path = tmp_path / "a.csv"
    path.write_text(text)
    flight = read_states(path)
    for column, signal in (
        ("speed_command.1", "rotors.speed_command.0"),
        ("speed_command.2", "rotors.speed_command.1"),
        ("setpoint.z", "setpoint.z"),
        ("command.v_x", "command_velocity.v_x"),
    ):
        told = columns[f"{column} [SI]"]
        np.testing.assert_allclose(flight[signal].values, [*told[1:], told[-1]], rtol=1e-12)
    for column, signal in (
        ("speed.2", "rotors.speed.1"),
        ("p_W.z", "position_data.z"),
        ("v_W.y", "velocity_data.v_y"),
        ("w_W.x", "velocity_data.w_x"),
    ):
        check(flight, [signal], [columns[f"{column} [SI]"]], AS_IT_IS)
    q = np.column_stack([columns[f"q_WB.{part} [SI]"] for part in "wxyz"])
    turn = Rotation.from_quat(q, scalar_first=True).inv()
    up = [0.0, 0.0, GRAVITY]
    for name, signals, more in (
        ("w_W", "imu.angular_velocity.", 0.0),
        ("vdot_W", "imu.linear_acceleration.", up),
    ):
        W = np.column_stack([columns[f"{name}.{axis} [SI]"] for axis in "xyz"]) + more
        check(flight, xyz(signals), turn.apply(W).T, SAME)


NANOBENCH = (
    # columns, signals, and to SI
    *((f"imu_acc_{x}", f"imu.linear_acceleration.{x}", GRAVITY) for x in "xyz"),
    *((f"imu_gyro_{x}", f"imu.angular_velocity.{x}", 1.0) for x in "xyz"),
    *((f"motor_motor_m{i}", f"motors.command_{i}", 1.0 / 65535.0) for i in range(1, 5)),
    *((f"est_stateEstimate_{x}", f"estimate.{x}", 1.0) for x in "xyz"),
    *((f"est_stateEstimate_v{x}", f"estimate.v_{x}", 1.0) for x in "xyz"),
    *((f"est_stateEstimate_a{x}", f"estimate.a_{x}", GRAVITY) for x in "xyz"),
    ("att_stateEstimate_roll", "estimate.roll", DEGREES),
    ("att_stateEstimate_pitch", "estimate.pitch", -DEGREES),
    ("att_stateEstimate_yaw", "estimate.yaw", DEGREES),
    *((f"sp_ctrltarget_{x}", f"setpoint.{x}", 1.0) for x in "xyz"),
    ("sp_ctrltarget_yaw", "setpoint.yaw", DEGREES),
    ("pid_controller_roll", "attitude_setpoint.roll", DEGREES),
    ("pid_controller_pitch", "attitude_setpoint.pitch", -DEGREES),
    ("pid_controller_yaw", "attitude_setpoint.yaw", DEGREES),
    ("pid_controller_cmd_thrust", "attitude_setpoint.thrust", 1.0 / 65535.0),
    ("pwr_pm_vbat", "battery.voltage", 1.0),
    *((f"p{x}", f"position_data.{x}", 1.0) for x in "xyz"),
    *((f"v{x}", f"velocity_data.v_{x}", 1.0) for x in "xyz"),
    *((f"w{x}_vicon", f"attitude.w_{x}", 1.0) for x in "xyz"),
)


def nanobench(path, **changed):
    """Write a file of NanoBench with random numbers, but for some columns; return the columns."""
    head = ["px", "py", "pz", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw"]
    columns = {"t": [f"1700000000.{k:02d}" for k in range(COUNT)]}  # as exact as it is written
    columns |= numbers([*head, *(column for column, _, _ in NANOBENCH if column not in head)])
    columns |= changed
    path.write_text(table_of(columns))
    return columns


def test_nanobenchs_numbers_are_those_that_were_written(tmp_path, case):
    columns = nanobench(tmp_path / "a.csv")
    flight = read_nanobench(tmp_path / "a.csv")
    assert flight.parameters["controller"] == "PID"
    for column, signal, scale in NANOBENCH:
        with case(column):
            np.testing.assert_allclose(flight[signal].values, scale * columns[column], rtol=1e-6)
            np.testing.assert_allclose(flight[signal].time, 0.01 * np.arange(COUNT), atol=1e-6)


def test_rates_of_nanobench_are_in_the_world_too(tmp_path):
    columns = nanobench(tmp_path / "a.csv")
    flight = read_nanobench(tmp_path / "a.csv")
    q = np.column_stack([columns[f"q{part}"] for part in "wxyz"])
    w = np.column_stack([columns[f"w{axis}_vicon"] for axis in "xyz"])
    expected = Rotation.from_quat(q, scalar_first=True).apply(w)
    found = np.column_stack([flight[f"velocity_data.w_{axis}"].values for axis in "xyz"])
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_what_nanobench_extrapolated_is_left_out(tmp_path):
    """From the seventh row on all columns of the IMU go on along a line."""
    names = [f"imu_{kind}_{axis}" for kind in ("acc", "gyro") for axis in "xyz"]
    columns = numbers(names)
    for values in columns.values():
        values[6:] = values[6] + 0.25 * np.arange(COUNT - 6)
    nanobench(tmp_path / "a.csv", **columns)
    flight = read_nanobench(tmp_path / "a.csv")
    assert any("end at 0.06 s and were extrapolated" in remark for remark in flight.remarks)
    for name in ("imu.angular_velocity.x", "imu.linear_acceleration.z"):
        assert flight[name].time[-1] == pytest.approx(0.06)
        assert flight[name].gaps[-1] == (pytest.approx(0.06), pytest.approx(0.11))


def test_motors_that_nanobench_interpolated_were_not_measured(tmp_path):
    """A straight line through 4 rows; through 2, as from a packet that came late, it was."""
    names = [f"motor_motor_m{i}" for i in range(1, 5)]
    columns = numbers(names)
    for values in columns.values():
        values[3:8] = np.linspace(values[3], values[7], 5)
        values[9] = 0.5 * (values[8] + values[10])
    nanobench(tmp_path / "a.csv", **columns)
    flight = read_nanobench(tmp_path / "a.csv")
    assert any("motor 25.0 %" in remark for remark in flight.remarks)
    for i in range(1, 5):
        command = flight[f"motors.command_{i}"]
        rows = np.rint(100.0 * command.time).astype(int).tolist()
        assert rows == [0, 1, 2, 3, 7, 8, 9, 10, 11]
        assert command.gaps == ((pytest.approx(0.03), pytest.approx(0.07)),)
