"""`workbench gains import` of the parameters in a log."""

import json

import pytest

from tests.logs.foreign_files import dataflash, ulog


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
    for words, said in (
        (("flight.ulg", "--for", "ardupilot"), "is a log of px4"),
        (("plane.bin",), "is a log of ArduPlane V4.5.7 (abc), not of a copter"),
    ):
        with case(words):
            refused = run("gains", "import", tmp_path / words[0], *words[1:])
            assert refused.code == 2 and said in refused.err
