"""Gains out of autopilots' files and into them: nothing but gains changes, and none is lost."""

import math
import random
import struct
from pathlib import Path

import pytest

from tests.extras.autopilots.gain_files.made_up import gains_of, release_of, text_of
from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.extras.autopilots.gain_files.firmware import (
    SUPPORTED_FIRMWARES,
    find_firmware,
    read_parameter_file,
)
from workbench.extras.autopilots.gain_files.parameter_file import encoded
from workbench.gains.formats import export_gains, import_gains

SHARED = Path(__file__).parents[4] / "../shared/flights/given"
GIVEN = SHARED / "ardupilot/params_gpl3"
LOG = SHARED / "px4_ulog/sample.ulg"
SEED = 20260923
PIECES = (b"", b"\0", b"\xff", b"nan", b"-", b"1e999", b"\r", b"[" * 50, b"&a *a", b"#", b"0x")
"""What stands in damaged files."""


def single(value: float) -> bytes:
    """Return a number as an autopilot stores it."""
    return struct.pack("<f", value)


def put(path: Path, text: str) -> Path:
    path.write_bytes(text.encode())
    return path


def told(found) -> str:
    return "; ".join(map(str, found.remarks))


def everything(found) -> dict[str, float]:
    """Return all values of a law, with what was imported on top of its defaults."""
    return {row.name: row.default for row in found.law.parameters} | found.values


few_or_many = pytest.mark.parametrize("count", [40, pytest.param(300, marks=pytest.mark.slow)])


@few_or_many
def test_files_of_each_format_come_back_to_the_byte(tmp_path, case, count):
    """Imported and exported again nothing differs; one gain changed, one line does."""
    for firmware in SUPPORTED_FIRMWARES:
        rng = random.Random(SEED)
        for number in range(count):
            with case(firmware.name, number):
                law = load_controller(rng.choice(firmware.laws))
                release = release_of(firmware)
                gains = gains_of(firmware, law, rng, release)
                path = put(tmp_path / "made_up", text_of(firmware, gains, rng))
                before = path.read_bytes()
                found = import_gains(path, firmware.name, law=law)
                assert not found.unsafe
                release = found.release  # names that all have are read as the usual version's
                read = firmware.to_file(found.values, release)
                assert {n: single(read[n]) for n in gains} == {
                    n: single(value) for n, value in gains.items()
                }
                values = everything(found)
                same = export_gains(values, law, firmware, present=found)
                assert not same.written
                assert encoded(same.text) == before

                name = firmware.table.names(release)[rng.choice(sorted(gains))].law
                row = next(row for row in law.parameters if row.name == name)
                least, most = limits(firmware, release, row)
                other = least if values[name] > least + 1.0 else most
                made = export_gains({**values, name: other}, law, firmware, present=found)
                lines = before.decode().splitlines(), made.text.splitlines()
                changed = [pair for pair in zip(*lines, strict=True) if pair[0] != pair[1]]
                assert len(changed) == (single(values[name]) != single(other))
                assert made.text.count("\r") == before.decode().count("\r")
                if number % 10:  # every file is written once, and some a second time
                    continue
                path.write_bytes(encoded(made.text))
                again = import_gains(path, firmware.name, law=law).values
                assert {n: single(v) for n, v in again.items()} == {
                    n: single(v) for n, v in ({**found.values, name: other}).items()
                }


@pytest.mark.parametrize("count", [20, pytest.param(80, marks=pytest.mark.slow)])
def test_gains_of_each_version_come_back(tmp_path, case, count):
    """Written for a version and read again: equal in the file's resolution, no foreign name."""
    for firmware in SUPPORTED_FIRMWARES:
        for release in firmware.table.releases:
            rng = random.Random(SEED)
            for number in range(count):
                with case(firmware.name, release.version, number):
                    law = load_controller(rng.choice(firmware.laws))
                    given = drawn(firmware, release, law, rng)
                    path = tmp_path / f"new{firmware.suffixes[0]}"
                    made = export_gains(given, law, firmware, release.version)
                    found = import_gains(put(path, made.text), law=law)
                    assert (found.firmware, found.release) == (firmware, release)
                    assert not found.unsafe
                    assert not found.unknown
                    names = firmware.table.names(release)
                    assert made.written.keys() <= names.keys()
                    back = firmware.to_file(found.values, release)
                    for name, value in firmware.to_file(given, release).items():
                        if names[name].whole:
                            assert back[name] == round(value), name
                        else:
                            assert single(back[name]) == single(value), name
                    assert back.keys() == made.written.keys()


def limits(firmware, release, row) -> tuple[float, float]:
    """Return what a version takes of a parameter of the law."""
    setting = firmware.table.by_law(release)[row.name]
    if not setting.name or not firmware.strict:
        return row.minimum, row.maximum
    if setting.words:
        return 0.0, len(setting.words) - 1.0
    return max(row.minimum, setting.least), min(row.maximum, setting.most)


def drawn(firmware, release, law, rng) -> dict[str, float]:
    """Return all values of a law, random ones of those that a version takes."""
    values = {row.name: row.default for row in law.parameters}
    rows = {row.name: row for row in law.parameters}
    for name in firmware.table.by_law(release).keys() & rows.keys():
        values[name] = rng.uniform(*limits(firmware, release, rows[name]))
    if "firmware" in values:
        values["firmware"] = float(release.version)
    return values


@pytest.mark.skipif(not GIVEN.is_dir(), reason="the given files of ArduPilot are not there")
def test_given_files_of_ardupilot_come_back(tmp_path, case):
    firmware, law = find_firmware("ardupilot"), load_controller("ardupilot")
    files = sorted(GIVEN.rglob("*.param"))
    assert len(files) == 13
    with_gains = 0
    for path in files:
        with case(path.name):
            before = path.read_bytes()
            _, file = read_parameter_file(path)
            assert encoded(file.replaced({})) == before
            # written anew, every number is the same one
            texts = {e.name: firmware.written(e, e.value) for e in file.entries}
            (tmp_path / "again.param").write_bytes(encoded(file.replaced(texts)))
            _, again = read_parameter_file(tmp_path / "again.param")
            assert [(e.name, single(e.value)) for e in again.entries] == [
                (e.name, single(e.value)) for e in file.entries
            ]
            try:
                found = import_gains(path, law=law)
            except WorkbenchError as error:
                assert "sets none of the" in str(error)
                continue
            with_gains += 1
            made = export_gains(everything(found), law, firmware, present=found)
            assert encoded(made.text) == before
    assert with_gains >= 7


@pytest.mark.skipif(not GIVEN.is_dir(), reason="the given files of ArduPilot are not there")
def test_defaults_are_those_that_a_vehicle_with_arducopter_4_5_had():
    """A file that its ground station saved before anything was set, of 4.5."""
    found = import_gains(GIVEN / "Holybro_X500_V2/00_default.param")
    defaults = {row.name: row.default for row in found.law.parameters}
    assert len(found.values) == len(found.firmware.rows(found.law)) == 71
    other = {name: value for name, value in found.values.items() if value != defaults[name]}
    assert other == {"PSC_NE_VEL_D": 0.5, "ATC_INPUT_TC": 0.15}
    own = found.firmware.defaults(found.firmware.table.release("4.5")[0])
    assert found.values == {name: pytest.approx(own[name], rel=1e-6) for name in found.values}


def log_parameters(path: Path) -> dict[str, tuple[float, int]]:
    """Return value and type of each parameter in a ULog, from its specification alone."""
    data, at, found = path.read_bytes(), 16, {}
    while at + 3 <= len(data):
        size, kind = struct.unpack_from("<HB", data, at)
        if kind == ord("P"):
            body = data[at + 3 : at + 3 + size]
            key = body[1 : 1 + body[0]].decode()
            sort, name = key.split(" ")
            code, number = ("<f", 9) if sort == "float" else ("<i", 6)
            found[name] = (struct.unpack_from(code, body, 1 + body[0])[0], number)
        at += 3 + size
    return found


@pytest.mark.skipif(not LOG.is_file(), reason="the given log of PX4 is not there")
def test_parameters_of_a_px4_log_come_back(tmp_path):
    given = log_parameters(LOG)
    assert len(given) > 400
    lines = ["# Onboard parameters for Vehicle 1"]
    for name, (value, kind) in given.items():
        lines.append(f"1\t1\t{name}\t{value:.18g}\t{kind}")
    path = put(tmp_path / "log.params", "\n".join(lines) + "\n")
    found = import_gains(path)
    law, firmware = found.law, found.firmware
    assert single(found.values["MC_ROLLRATE_P"]) == single(given["MC_ROLLRATE_P"][0])
    assert encoded(export_gains(everything(found), law, firmware, present=found).text) == (
        path.read_bytes()
    )
    new = export_gains(everything(found), law, firmware)
    again = import_gains(put(tmp_path / "new.params", new.text))
    assert {n: single(again.values[n]) for n in found.values} == {
        n: single(value) for n, value in found.values.items()
    }


@pytest.mark.parametrize("count", [100, pytest.param(600, marks=pytest.mark.slow)])
def test_damaged_files_end_in_a_sentence(tmp_path, case, count):
    """Whatever a disk or a stranger did to a file: gains, or a WorkbenchError that names it."""
    rng = random.Random(SEED)
    path = tmp_path / "damaged"
    refused = 0
    for number in range(count):
        firmware = SUPPORTED_FIRMWARES[number % len(SUPPORTED_FIRMWARES)]
        law = load_controller(firmware.laws[0])
        gains = gains_of(firmware, law, rng, release_of(firmware))
        data = bytearray(text_of(firmware, gains, rng).encode())
        for _ in range(rng.randint(1, 30)):
            at = rng.randrange(len(data) or 1)
            data[at : at + rng.choice([0, 1, 7, 90])] = rng.choice(PIECES)
        path.write_bytes(data)
        with case(firmware.name, number):
            try:
                found = import_gains(path, rng.choice(["", firmware.name]))
                assert all(map(math.isfinite, found.values.values()))
                table = {row.name: row for row in found.law.parameters}
                for name, value in found.values.items():
                    assert table[name].minimum <= value <= table[name].maximum
                values = everything(found)
                made = export_gains(values, found.law, found.firmware, present=found)
                changed = set(made.written)
                assert not changed & set(found.firmware.to_file(found.values, found.release))
            except WorkbenchError as error:
                refused += 1
                assert str(path) in str(error)
    assert 0.1 * count < refused < 0.99 * count


def test_what_must_not_fly_is_named(tmp_path, case):
    for value, said in (
        ("nan", "is not a number"),
        ("inf", "is infinite"),
        ("1e39", "is out of range"),
        ("-0.15", "is negative: this would reverse"),
        ("20", "is out of range: keep it within 0 .. 10 s/rad"),
        ("zero", "is not a number"),
    ):
        with case(value):
            path = put(tmp_path / "x.params", f"1\t1\tMC_ROLLRATE_P\t{value}\t9\n")
            found = import_gains(path)
            assert found.values == {}
            assert said in found.unsafe["MC_ROLLRATE_P"]


def test_what_must_not_fly_is_not_exported(case):
    """Each gain of each law: no number, infinite, or just beyond its limits."""
    for firmware in SUPPORTED_FIRMWARES:
        for law in map(load_controller, firmware.laws):
            values = {row.name: row.default for row in law.parameters}
            for row in firmware.rows(law):
                low, high = math.nextafter(row.minimum, -1e9), math.nextafter(row.maximum, 1e9)
                for value in (math.nan, math.inf, -math.inf, low, high):
                    with case(law.name, row.name, value), pytest.raises(WorkbenchError) as caught:
                        export_gains({**values, row.name: value}, law, firmware)
                    said = str(caught.value)
                    assert said.startswith(firmware.file_name(row.name))
                    assert said.endswith("nothing is exported")


def test_what_a_crazyflie_has_stored_counts_before_what_it_has_now(tmp_path, case):
    """Of a parameter as the client writes it, in either order; its default is none of both."""
    for text, value in (
        ("{value: 240, stored_value: 260}", 260.0),
        ("{stored_value: 260, default_value: 250, value: 240}", 260.0),
        ("{value: 240, default_value: 250}", 240.0),
    ):
        with case(text):
            path = put(tmp_path / "x.yaml", f"params:\n  pid_rate.roll_kp: {text}\n")
            assert import_gains(path, "crazyflie").values == {"pid_rate_roll_kp": value}


def test_files_that_are_none_are_refused(tmp_path, case):
    px4 = load_controller("px4")
    for text, words, said in (
        ("", {}, "is not a parameter file of px4, ardupilot"),
        ("hello\nworld\n", {}, "is not a parameter file"),
        ("1\t1\tMC_ROLL_P\t6.5\n", {"firmware": "px4"}, "x:1: is not a line of parameters"),
        ("BATT_CAPACITY,5000\n", {}, "sets none of the"),
        ("ATC_ANG_RLL_P,4.5\nATC_ANG_RLL_P\n", {}, "x:2: is not a line of parameters"),
        ("MC_ROLL_P: [1\n", {"firmware": "crazyflie"}, "is neither YAML nor JSON"),
        ("pid_rate.roll_kp: " + "[" * 99 + "]" * 99, {}, "deep"),
        (
            "set p_roll = 45\n",
            {"firmware": "betaflight", "law": px4},
            "translate",
        ),
        ("1\t1\tMC_ROLL_P\t6.5\t9\n", {"profile": 1}, "--profile is of Betaflight's files"),
    ):
        with case(text[:30], words), pytest.raises(WorkbenchError, match=said):
            import_gains(put(tmp_path / "x", text), **words)


def test_the_autopilots_own_component_counts(tmp_path):
    text = "1\t100\tMC_ROLL_P\t1\t9\n1\t1\tMC_ROLL_P\t6.5\t9\n1\t2\tMC_ROLL_P\t2\t9\n"
    found = import_gains(put(tmp_path / "x.params", text))
    assert found.values == {"MC_ROLL_P": 6.5}
    assert "3 components" in str(found.remarks[0])
    values = {**everything(found), "MC_ROLL_P": 7.0}
    made = export_gains(values, found.law, found.firmware, "", found)
    assert made.text == text.replace("6.5", "7")


def test_ardupilots_names_of_before_4_7_are_scaled(tmp_path, case):
    """Factors are those of the conversion table in AC_PosControl.cpp and of pull request 32192."""
    for old, value, new, expected in (
        ("PSC_ACCZ_P", 0.5, "PSC_D_ACC_P", 0.05),
        ("PSC_ACCZ_IMAX", 800.0, "PSC_D_ACC_IMAX", 0.8),
        ("PSC_VELXY_IMAX", 1000.0, "PSC_NE_VEL_IMAX", 10.0),
        ("PSC_VELXY_P", 2.0, "PSC_NE_VEL_P", 2.0),
        ("PSC_POSZ_P", 1.0, "PSC_D_POS_P", 1.0),
        ("ATC_ACCEL_R_MAX", 110000.0, "ATC_ACC_R_MAX", 1100.0),
        ("ANGLE_MAX", 3000.0, "ATC_ANGLE_MAX", 30.0),
    ):
        with case(old):
            found = import_gains(put(tmp_path / "x.param", f"{old},{value}  # why\n"))
            assert found.values[new] == pytest.approx(expected, rel=1e-6)
            values = {**everything(found), new: 0.5 * expected}
            made = export_gains(values, found.law, found.firmware, "", found)
            assert made.text == f"{old},{0.5 * value:g}  # why\n"
            fresh = export_gains(values, found.law, found.firmware, "4.6")
            assert f"{old},{0.5 * value:g}\n" in fresh.text
            assert new not in fresh.text


def test_numbers_of_ardupilot_may_be_hexadecimal(tmp_path):
    found = import_gains(put(tmp_path / "x.param", "ANGLE_MAX 0xBB8\n"))
    assert found.values == {"ATC_ANGLE_MAX": 30.0}


def test_px4s_velocity_gains_of_before_1_11_are_scaled(tmp_path):
    found = import_gains(put(tmp_path / "x.params", "1\t1\tMPC_XY_VEL_P\t0.09\t9\n"))
    assert found.values == {"MPC_XY_VEL_P_ACC": pytest.approx(1.8)}
    assert found.release.version == "1.10"
    assert "MPC_XY_VEL_P is MPC_XY_VEL_P_ACC times 0.05" in told(found)


def test_betaflights_d_of_before_4_6_is_the_peak(tmp_path, case):
    head = "# Betaflight / STM32F405 (S405) 4.5.1 Jul 27 2024 (77d01ba3b) MSP API: 1.46\n"
    for lines, d, d_max in (
        ("set d_roll = 45\nset d_min_roll = 32\n", 32.0, 45.0),
        ("set d_roll = 45\nset d_min_roll = 0\n", 45.0, 0.0),
        ("set d_roll = 45\n", 30.0, 45.0),
    ):
        with case(lines):
            path = put(tmp_path / "x.txt", head + lines)
            found = import_gains(path)
            assert (found.values["d_roll"], found.values["d_max_roll"]) == (d, d_max)
            made = export_gains(everything(found), found.law, found.firmware, "", found)
            assert made.text == head + lines


def test_the_profile_of_betaflight_that_is_in_use_counts(tmp_path):
    text = (
        "# Betaflight / SITL (SITL) 4.6.0 x (y) MSP API: 1.47\nset gyro_lpf1_static_hz = 0\n"
        "profile 0\nset p_roll = 40\nprofile 1\nset p_roll = 50\nprofile 0\nrateprofile 0\nsave\n"
    )
    path = put(tmp_path / "x.txt", text)
    first = import_gains(path)
    assert first.values["p_roll"] == 40.0
    (remark,) = [each for each in first.remarks if "--profile takes another" in str(each)]
    assert str(remark).startswith("line 6: has profile 0, profile 1: profile 0 counts")
    second = import_gains(path, profile=1)
    assert second.values["p_roll"] == 50.0
    values = {**everything(second), "p_roll": 60.0}
    made = export_gains(values, second.law, second.firmware, "", second)
    assert made.text == text.replace("= 50", "= 60")


def test_what_is_beyond_the_firmwares_own_ranges_is_named_and_taken(tmp_path, case):
    """Ranges are those of mc_rate_control_params.yaml and of @Range in AC_AttitudeControl.cpp."""
    for text, said in (
        ("1\t1\tMC_ROLLRATE_P\t0.8\t9\n", "MC_ROLLRATE_P 0.8 (0.01 .. 0.5)"),
        ("1\t1\tMC_ROLLRATE_P\t0.5\t9\n", ""),
        ("1\t1\tMC_YAWRATE_I\t15\t9\n", ""),  # has no largest value
        ("ATC_ANG_RLL_P,26\nATC_RAT_RLL_FLTD,0\n", "ATC_ANG_RLL_P 26 (3 .. 12)"),
        ("PSC_ACCZ_P,0.05\n", "PSC_ACCZ_P 0.05 = 0.005 s^2/m (0.2 .. 1.5)"),
    ):
        with case(text):
            found = import_gains(put(tmp_path / "x", text))
            version = found.release.version
            made = export_gains(everything(found), found.law, found.firmware, version)
            assert len(found.values) == text.count("\n")
            for remarks in (found.remarks, made.remarks):
                beyond = [str(each) for each in remarks if "recommends" in str(each)]
                assert [each.rpartition("recommends: ")[2] for each in beyond] == (
                    [said] if said else []
                )


def test_a_law_takes_all_that_its_firmware_takes(case):
    """Ranges and defaults of each version are within the rows of the law."""
    for firmware in SUPPORTED_FIRMWARES:
        rows = {row.name: row for law in firmware.laws for row in load_controller(law).parameters}
        for setting in firmware.table.settings:
            with case(firmware.name, setting.name, setting.law):
                if not setting.law:
                    continue
                row = rows[setting.law]
                most = (
                    setting.most if setting.name != "MPC_TILTMAX_AIR" else row.maximum
                )  # 1.10: 180
                for value in (setting.least, most, setting.default):
                    if value is not None and math.isfinite(value):
                        assert row.minimum <= round(value * setting.scale, 9) <= row.maximum
