"""`workbench gains import` of the parameters in a log."""

import json
import struct

import pytest

from tests.extras.flightdata.foreign_files import blackbox, dataflash, ulog, usd
from tests.extras.flightdata.tlog_writer import (
    AUTOPILOT_VERSION,
    HEARTBEAT,
    PARAM_VALUE,
    frame,
    tlog,
)


def test_import_reads_the_parameters_in_a_log(run, tmp_path, case):
    """Those of PX4 and ArduPilot are in their logs; the values are those of a file with them."""
    stamps = [1_000_000 + 10_000 * i for i in range(30)]
    fields = {f"gyro_rad[{i}]": ("float", [0.1] * 30) for i in range(3)}
    px4 = {"MC_ROLL_P": 5.5, "MC_ROLLRATE_P": 0.17, "MPC_THR_HOVER": 0.4}
    log = tmp_path / "flight.ulg"
    log.write_bytes(ulog([("sensor_combined", 0, stamps, fields)], px4))
    copter = {"ATC_ANG_RLL_P": 5.25, "ATC_RAT_RLL_P": 0.2}
    rows = [*copter.items(), ("ATC_RAT_RLL_P", 0.21)]  # changed in flight
    messages = [
        ("PARM", "Nf", ("Name", "Value"), stamps[:3], rows),
        ("MSG", "Z", ("Message",), stamps[:1], [("ArduCopter V4.5.7 (abc)",)]),
        ("IMU", "fff", ("GyrX", "GyrY", "GyrZ"), stamps, [(0.1, 0.0, 0.0)] * 30),
    ]
    (tmp_path / "flight.bin").write_bytes(dataflash(messages))
    plane = [("MSG", "Z", ("Message",), stamps[:1], [("ArduPlane V4.5.7 (abc)",)]), *messages[2:]]
    (tmp_path / "plane.bin").write_bytes(dataflash(plane))
    for name, firmware, values in (
        ("flight.ulg", "px4", px4),
        ("flight.bin", "ardupilot", copter | {"ATC_RAT_RLL_P": 0.21}),
    ):
        with case(name):
            words = ("gains", "import", tmp_path / name, "--no-margins", "--json")
            found = json.loads(run(*words).out)
            assert found["firmware"] == firmware
            gains = {row["file_name"]: row["b"] for row in found["gains"]}
            assert {key: gains[key] for key in values} == pytest.approx(values)
    changed = run("gains", "import", tmp_path / "flight.bin", "--no-margins")
    assert "1 parameters changed in the log; the last values count: ATC_RAT_RLL_P" in changed.err
    (tmp_path / "log07").write_bytes(usd(stamps, {"gyro.x": [1.0] * 30}))
    for words, said in (
        (("flight.ulg", "--for", "ardupilot"), "is a log of px4"),
        (("plane.bin",), "is a log of ArduPlane V4.5.7 (abc), not of a copter"),
        (("log07",), "is a log (Crazyflie usd log), and such logs have no gains"),
    ):
        with case(words):
            refused = run("gains", "import", tmp_path / words[0], *words[1:])
            assert refused.code == 2 and said in refused.err


HEADERS = {
    "rollPID": "50,85,44",
    "d_min": "31,35,0",
    "ff_weight": "125,130,100",
    "levelPID": "60,75,75",
    "dterm_lpf1_dyn_hz": "80,160",
    "dterm_lpf1_type": "2",
    "looptime": "125",
}
"""Of Betaflight 4.5, whose command line calls them as below; type 2 is PT2."""
COMMAND_LINE = {"p_roll": 50, "i_roll": 85, "d_roll": 44, "d_min_roll": 31, "f_roll": 125}
COMMAND_LINE |= {"f_yaw": 100, "angle_p_gain": 60, "dterm_lpf1_dyn_max_hz": 160}


def test_import_reads_the_headers_of_a_blackbox_log(run, tmp_path):
    """The values are those of a dump with the same parameters."""
    stamps, rows = [1_000_000 + 1000 * i for i in range(50)], [[1, 2, 3, 200, 2048, 1600]] * 50
    log, dump = tmp_path / "flight.bbl", tmp_path / "dump.txt"
    log.write_bytes(blackbox(stamps, rows, headers=HEADERS))
    lines = [f"set {name} = {value}" for name, value in COMMAND_LINE.items()]
    lines += ["set d_min_pitch = 35", "set d_min_yaw = 0", "set f_pitch = 130"]
    lines += ["set dterm_lpf1_dyn_min_hz = 80", "set dterm_lpf1_type = PT2"]
    dump.write_text("\n".join(["# Betaflight / STM32F7X2 4.5.1", *lines]))
    found = [
        json.loads(run("gains", "import", each, "--no-margins", "--json").out)
        for each in (log, dump)
    ]
    assert found[0]["firmware"] == "betaflight" and found[0]["version"] == "4.5.1"
    gains = [{row["name"]: row["b"] for row in each["gains"]} for each in found]
    assert gains[0] == gains[1] and gains[0]["d_max_roll"] == 44
    log.write_bytes(blackbox(stamps, rows))
    refused = run("gains", "import", log)
    assert refused.code == 2 and "has no gains of betaflight in its header" in refused.err
    log.write_bytes(blackbox(stamps, rows, headers={"Firmware revision": "INAV 7.1.1"}))
    refused = run("gains", "import", log)
    assert refused.code == 2 and "is a log of INAV 7.1.1, not of Betaflight" in refused.err


def test_only_a_log_has_a_number(run, tmp_path):
    for name, text in (("x.params", "1 1 MC_ROLL_P 5.5 9\n"), ("g.yaml", "gains: {kp_roll: 1}")):
        path = tmp_path / name
        path.write_text(text)
        refused = run("gains", "import", path, "--log-number", "2")
        assert refused.code == 2 and "--log-number" in refused.err


def test_import_reads_the_parameters_of_a_telemetry_log(run, tmp_path, case):
    """PX4 sends the bits of whole numbers; who flew is in the heartbeats."""
    pytest.importorskip("pymavlink")
    whole = struct.unpack("<f", struct.pack("<i", 1))[0]
    for autopilot, firmware, values in (
        (12, "px4", {"MC_ROLL_P": (5.5, 9), "MPC_ACC_DECOUPLE": (whole, 6)}),
        (3, "ardupilot", {"ATC_ANG_RLL_P": (5.25, 9), "MOT_THST_HOVER": (0.25, 9)}),
    ):
        with case(firmware):
            version = (0, 0, (1 << 24) + (15 << 16) + (4 << 8) + 255)
            frames = [
                frame(HEARTBEAT, (0, 2, autopilot, 1, 4, 3)),
                *(frame(PARAM_VALUE, (v, 2, 0, n, kind)) for n, (v, kind) in values.items()),
                frame(AUTOPILOT_VERSION, version),
                frame(HEARTBEAT, (0, 2, autopilot, 1, 4, 3)),
            ]
            log = tmp_path / "flight.tlog"
            log.write_bytes(tlog((10**15 + 10**6 * i, each) for i, each in enumerate(frames)))
            words = ("gains", "import", log, "--no-margins", "--json")
            found = json.loads(run(*words).out)
            assert found["firmware"] == firmware and found["version"] == "1.15.4"
            gains = {row["file_name"]: row["b"] for row in found["gains"]}
            for name, (value, kind) in values.items():
                assert gains[name] == pytest.approx(1.0 if kind == 6 else value)
            other = "ardupilot" if firmware == "px4" else "px4"
            refused = run(*words, "--for", other)
            assert refused.code == 2 and f"is a log of {firmware}: leave out --for" in refused.err
            log.write_bytes(tlog((10**15 + 10**6 * i, frames[0]) for i in range(5)))
            refused = run("gains", "import", log)
            assert refused.code == 2 and "has no parameters: import" in refused.err
