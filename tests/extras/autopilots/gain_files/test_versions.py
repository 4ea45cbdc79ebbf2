"""What files of other versions and firmwares mean, by lines that a person may have typed.

Values are those of the tags' settings.c, pid.c, simplified_tuning.c and parameter definitions.
"""

from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.extras.autopilots.gain_files.firmware import (
    BETAFLIGHT_FIRMWARE,
    PX4_FIRMWARE,
    find_firmware,
)
from workbench.extras.autopilots.gain_files.imported_gains import imported_gains
from workbench.extras.autopilots.gain_files.parameter_file import encoded, file_of
from workbench.gains.formats import export_gains, import_gains

HEAD = "# Betaflight / STM32F405 (S405) {} x / y (z) MSP API: 1.46\n"
QGC = "# Stack: {}\n# Vehicle: Multi-Rotor\n# Version: {}\n#\n"
CASES = Path(__file__).parents[4] / "../shared/cases"


def put(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def read(tmp_path, text, **words):
    return import_gains(put(tmp_path / "x.txt", text), **words)


def told(found) -> str:
    return "; ".join(map(str, found.remarks))


@pytest.mark.parametrize(
    ("version", "lines", "expected"),
    [
        (  # 45 x 1.5 x 1.2, 80 x 1.5 x 1.2, 47 x 1.5 x 1.2
            "4.5.1",
            "set simplified_master_multiplier = 150\nset simplified_pi_gain = 120\n",
            {"p_roll": 81, "i_roll": 144, "p_pitch": 84, "f_yaw": 180, "d_roll": 45},
        ),
        (  # d = 30 x 1.2 x (1 + 10 / 30 x 0.5): cut, not rounded; d_min = 36
            "4.3.2",
            "set simplified_d_gain = 120\nset simplified_dmax_gain = 50\n",
            {"d_roll": 36, "d_max_roll": 42, "d_pitch": 40, "d_max_pitch": 48},
        ),
        (  # d_max = 40 x 1.2 x (0.5 + 0.5 x 30 / 40)
            "2025.12.1",
            "set simplified_d_gain = 120\nset simplified_d_max_gain = 50\n",
            {"d_roll": 36, "d_max_roll": 42, "d_pitch": 40, "d_max_pitch": 48},
        ),
        (  # roll and pitch alone; pitch has its own ratio
            "2026.6.0",
            "set simplified_pids_mode = RP\nset simplified_i_gain = 60\n"
            "set simplified_pitch_pi_gain = 110\n",
            {"i_roll": 48, "i_pitch": 55, "p_pitch": 51, "f_pitch": 137, "i_yaw": 80},
        ),
        (  # cut-offs that are on; the static one follows the dynamic minimum
            "4.4.3",
            "set simplified_dterm_filter_multiplier = 80\nset simplified_gyro_filter = OFF\n"
            "set simplified_gyro_filter_multiplier = 50\nset dterm_lpf2_static_hz = 0\n",
            {
                "dterm_lpf1_dyn_min_hz": 60,
                "dterm_lpf1_dyn_max_hz": 120,
                "dterm_lpf2_static_hz": 0,
                "gyro_lpf1_dyn_min_hz": 250,
            },
        ),
    ],
)
def test_sliders_compute_gains_as_the_firmware_does(tmp_path, version, lines, expected):
    text = HEAD.format(version) + lines + "simplified_tuning apply\nset yaw_lowpass_hz = 90\nsave\n"
    found = read(tmp_path, text)
    flown = found.flown({})
    assert {name: flown[name] for name in expected} == expected
    # an export sets its gains behind the command, and all else stays
    values = {row.name: row.default for row in found.law.parameters} | flown | {"p_roll": 61.0}
    made = export_gains(values, found.law, BETAFLIGHT_FIRMWARE, present=found)
    before, after = text.split("simplified_tuning apply")
    assert made.text.startswith(f"{before}simplified_tuning apply\nsimplified_tuning disable\n")
    assert made.text.endswith(after)
    again = read(tmp_path, made.text).flown({})
    assert again == flown | {"p_roll": 61.0}


def test_an_export_tells_what_the_file_would_leave_at_another_value(tmp_path):
    """A file of one gain: the others count only where they are not the firmware's own."""
    found = read(tmp_path, HEAD.format("4.5.1") + "set p_roll = 50\n")
    values = {row.name: row.default for row in found.law.parameters} | found.flown({})
    law = found.law
    assert "does not have" not in told(export_gains(values, law, found.firmware, present=found))
    made = export_gains({**values, "p_pitch": 61.0}, law, found.firmware, present=found)
    (said,) = [str(each) for each in made.remarks if "does not have" in str(each)]
    assert "does not have p_pitch, and their values here are not the firmware's defaults" in said


@pytest.mark.parametrize(
    ("version", "name", "most"), [("4.2.9", "i_pitch", 200), ("2025.12", "f_roll", 1000)]
)
def test_an_export_has_nothing_that_betaflight_would_refuse(version, name, most):
    """Beyond a row of the tag's cli/settings.c the firmware keeps another value, and flies that."""
    law = load_controller("betaflight")
    values = {row.name: row.default for row in law.parameters}
    text = export_gains({**values, name: float(most)}, law, BETAFLIGHT_FIRMWARE, version).text
    assert f"set {name} = {most}\n" in text
    with pytest.raises(WorkbenchError, match=f"beyond what betaflight {version[:3]}.* takes, 0"):
        export_gains({**values, name: most + 1.0}, law, BETAFLIGHT_FIRMWARE, version)


def test_commands_run_in_order(tmp_path):
    head = HEAD.format("4.5.1")
    apply = "set simplified_master_multiplier = 200\nsimplified_tuning apply\n"
    assert read(tmp_path, head + apply + "set p_roll = 50\n").values["p_roll"] == 50.0
    assert read(tmp_path, f"{head}set p_roll = 50\n{apply}").values["p_roll"] == 90.0
    off = f"{head}set p_roll = 50\nsimplified_tuning disable\n{apply}"
    assert read(tmp_path, off).values["p_roll"] == 50.0
    old = read(tmp_path, HEAD.format("4.2.9") + "set p_roll = 50\nsimplified_tuning apply\n")
    assert old.values == {"p_roll": 50.0}
    assert "'simplified_tuning apply' is no command of 4.2" in told(old)


def test_an_export_behind_a_command_is_of_the_profile_in_use(tmp_path):
    text = HEAD.format("4.5.1") + (
        "profile 0\nset p_roll = 50\nprofile 1\nset p_roll = 60\nsimplified_tuning apply\n"
        "profile 0\n"
    )
    found = read(tmp_path, text)
    assert found.values["p_roll"] == 45.0
    values = {row.name: row.default for row in found.law.parameters} | found.flown({})
    made = export_gains({**values, "p_roll": 77.0}, found.law, BETAFLIGHT_FIRMWARE, present=found)
    assert "\nprofile 0\nsimplified_tuning disable\nset p_roll = 77\nprofile 1\n" in made.text
    assert read(tmp_path, made.text).values["p_roll"] == 77.0


def test_options_and_includes_of_presets_are_run_or_refused(tmp_path):
    folder = tmp_path / "presets" / "4.5"
    folder.mkdir(parents=True)
    put(folder / "defaults.txt", "#$ TITLE: d\nset p_roll = 45\nset i_roll = 80\n")
    text = (
        "#$ TITLE: t\n#$ FIRMWARE_VERSION: 4.4\n#$ FIRMWARE_VERSION: 4.5\n"
        "#$ INCLUDE: presets/4.5/defaults.txt\nset p_roll = 50\n"
        "#$ OPTION BEGIN (CHECKED): soft\n    set d_roll = 33\n#$ OPTION END\n"
        "#$ OPTION BEGIN (UNCHECKED): hard\n    set p_roll = 99\n#$ OPTION END\n"
    )
    found = import_gains(put(folder / "tune.txt", text))
    assert (found.version, found.values["p_roll"], found.values["i_roll"]) == ("4.5", 50.0, 80.0)
    assert (found.values["d_roll"], found.values["d_max_roll"]) == (30.0, 33.0)
    assert found.defaults == {"firmware": 4.5}  # a preset leaves all else
    assert "options that are checked: soft" in told(found)
    assert "not taken: hard" in told(found)
    values = {row.name: row.default for row in found.law.parameters} | found.flown({})
    made = export_gains({**values, "i_roll": 70.0}, found.law, BETAFLIGHT_FIRMWARE, present=found)
    assert "defaults.txt\nsimplified_tuning disable\nset i_roll = 70\nset p_roll = 50" in made.text
    for name in ("presets/4.5/none.txt", "presets/../../secret.txt", "/etc/passwd"):
        with pytest.raises(WorkbenchError, match="which is not there"):
            read(tmp_path, text.replace("presets/4.5/defaults.txt", name))
    put(folder / "loop.txt", "#$ TITLE: t\n#$ INCLUDE: presets/4.5/loop.txt\n")
    with pytest.raises(WorkbenchError, match="includes more than 50 files"):
        import_gains(folder / "loop.txt")


@pytest.mark.parametrize(
    ("text", "version", "expected"),
    [
        ("set p_roll = 50\nset d_roll = 44\nset d_min_roll = 33\n", "4.5", (33, 44)),
        ("set d_roll = 30\nset d_max_roll = 41\n", "2025.12", (30, 41)),
        ("set d_min_boost_gain = 20\nset d_roll = 36\n", "4.2", (23, 36)),
        ("set d_roll = 40\nset d_min_roll = 0\nset angle_limit = 55\n", "4.5", (40, 0)),
        ("set motor_idle = 400\nset d_roll = 31\n", "2025.12", (31, None)),
    ],
)
def test_without_a_version_the_names_decide(tmp_path, text, version, expected):
    found = read(tmp_path, text)
    assert found.release.version == version
    assert (found.values["d_roll"], found.values.get("d_max_roll")) == expected
    assert "states no version" in told(found)


def test_defaults_in_which_the_possible_versions_differ_stay(tmp_path):
    found = read(tmp_path, "set p_roll = 50\nset d_min_roll = 33\n")
    assert found.defaults["p_yaw"] == 45.0  # of 4.2 to 4.5
    assert not {"angle_limit", "i_yaw", "yaw_lowpass_hz"} & found.defaults.keys()
    assert "the versions have other defaults of angle_earth_ref, angle_limit" in told(found)


def test_a_parameter_beside_the_law_counts_where_it_is_not_the_default(tmp_path):
    lines = "1\t1\tMPC_LAND_SPEED\t0.7\t9\n1\t1\tMPC_ACC_HOR\t5\t9\n1\t1\tMC_YAW_P\t2\t9\n"
    found = read(tmp_path, QGC.format("PX4", "1.16.0") + lines)
    assert [(str(each), each.acts) for each in found.left] == [
        ("MPC_LAND_SPEED 0.7", False),
        ("MPC_ACC_HOR 5", True),
    ]


def test_what_has_another_meaning_in_some_versions_is_said(tmp_path):
    found = read(tmp_path, "set d_roll = 44\nset p_roll = 50\n")
    assert found.release.version == "2025.12"
    assert found.defaults == {}
    assert "other versions have another meaning of d_roll" in told(found)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "POS_XY_P 1.1\nACCEL_Z_P 0.4\nVEL_XY_IMAX 900\nATC_RAT_YAW_FILT 3\n",
            {
                "PSC_NE_POS_P": 1.1,
                "PSC_D_ACC_P": 0.04,
                "PSC_NE_VEL_IMAX": 9.0,
                "ATC_RAT_YAW_FLTE": 3.0,
            },
        ),
        ("1\t1\tMC_DTERM_CUTOFF\t80\t9\n", {"IMU_DGYRO_CUTOFF": 80.0}),
    ],
)
def test_names_of_versions_before_those_known_are_translated(tmp_path, text, expected):
    found = read(tmp_path, text)
    assert found.values == pytest.approx(expected)
    assert "names of earlier versions" in told(found)


@pytest.mark.parametrize(
    ("text", "firmware", "expected"),
    [
        ("1\t1\tATC_RAT_RLL_P\t0.200000002980232239\t9\n", "ArduPilot", {"ATC_RAT_RLL_P": 0.2}),
        ("1\t1\tPSC_ACCZ_P\t0.4\t9\n1\t1\tANGLE_MAX\t2500\t4\n", "ArduPilot", None),
        ("1\t1\tMC_ROLL_P\t5\t9\n", "PX4 Pro", {"MC_ROLL_P": 5.0}),
        ("1\t1\tMC_ROLL_P\t5\t9\n", "px4", {"MC_ROLL_P": 5.0}),
    ],
)
def test_the_stack_of_qgroundcontrols_file_counts(tmp_path, text, firmware, expected):
    found = read(tmp_path, QGC.format(firmware, "4.5.7" if "Ardu" in firmware else "1.15.4") + text)
    assert found.firmware.name == firmware.split()[0].lower()
    expected = expected or {"PSC_D_ACC_P": 0.04, "ATC_ANGLE_MAX": 25.0}
    assert found.values == pytest.approx(expected)
    values = {row.name: row.default for row in found.law.parameters} | found.values
    name = next(iter(found.values))
    made = export_gains({**values, name: 0.5 * values[name]}, found.law, found.firmware, "", found)
    assert len(set(made.text.splitlines()) ^ set(found.file.text.splitlines())) == 2
    assert encoded(export_gains(values, found.law, found.firmware, "", found).text) == (
        found.file.path.read_bytes()
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("# INAV/MATEKF405TE 7.1.1 Aug  1 2024 / 01:55:06 (a)\nset tpa_rate = 20\n", "INAV"),
        ("# EmuFlight / S405 (S405) 0.4.1 x / y (z) MSP API: 1.54\nset p_roll = 40\n", "EmuFlight"),
        ("# Cleanflight / SPRF3 2.5.0 Jun 8 2020 / 1 (a) MSP API: 1.42\nset p_roll = 4\n", "Clean"),
        ("batch start\nset mc_p_pitch = 44\nset tpa_rate = 20\n", "INAV"),
        ("set feathered_pids = 80\nset p_roll = 40\n", "EmuFlight"),
        (QGC.format("Generic", "1") + "1\t1\tMC_ROLL_P\t5\t9\n", "Generic"),
        ("# Stack: ArduPilot\n# Vehicle: Fixed Wing\n1\t1\tATC_RAT_RLL_P\t1\t9\n", "Fixed Wing"),
        ("H_COL_MAX,1700\nATC_RAT_RLL_P,0.1\n", "helicopters"),
        ("JS_GAIN_STEPS,4\nATC_RAT_RLL_P,0.1\n", "ArduSub"),
    ],
)
def test_firmwares_and_vehicles_without_a_law_are_refused(tmp_path, text, said):
    with pytest.raises(WorkbenchError, match=said):
        read(tmp_path, text)
    named = "betaflight" if "set " in text else "px4" if "MC_" in text else "ardupilot"
    assert read(tmp_path, text, firmware=named).values


@pytest.mark.parametrize(
    ("version", "line", "expected"),
    [
        ("4.4.3", "dshot_idle_value = 350", {"motor_idle": 350.0}),
        ("4.4.3", "angle_level_strength = 70", {"angle_p_gain": 70.0}),
        ("4.3.0", "level_limit = 45", {"angle_limit": 45.0}),
        ("4.2.11", "d_min_boost_gain = 30", {"d_max_gain": 30.0}),
        ("4.2.11", "dyn_lpf_dterm_min_hz = 105", {"dterm_lpf1_dyn_min_hz": 105.0}),
        ("4.2.11", "gyro_lowpass2_hz = 375", {"gyro_lpf2_static_hz": 375.0}),
        ("4.2.11", "dterm_lowpass2_type = BIQUAD", {"dterm_lpf2_type": 1.0}),
        ("4.5.1", "iterm_limit = 300", {"iterm_limit": 300.0}),
        ("2026.6.1", "iterm_windup = 70", {"iterm_windup": 70.0}),
        ("2025.12.3", "dterm_lpf1_type = PT3", {"dterm_lpf1_type": 3.0}),
    ],
)
def test_names_of_a_version_are_translated_both_ways(tmp_path, version, line, expected):
    found = read(tmp_path, HEAD.format(version) + f"set p_roll = 50\nset {line}\n")
    assert found.values == {"p_roll": 50.0, **expected}
    values = {row.name: row.default for row in found.law.parameters} | found.flown({})
    made = export_gains(values, found.law, BETAFLIGHT_FIRMWARE, version)
    assert f"set {line}\n" in made.text
    assert f"# Betaflight {version}\n" in made.text


def test_what_is_on_and_lacking_is_listed_with_its_value(tmp_path):
    lines = [
        "dyn_notch_count = 3",
        "gyro_notch1_hz = 200",
        "vbat_sag_compensation = 100",
        "mixer_type = LINEAR",
        "iterm_windup = 90",
        "crash_recovery = ON",
        "tpa_mode = PD",
        "use_integrated_yaw = OFF",
        "acc_limit = 0",
        "d_min_gain = 20",
        "osd_units = METRIC",
    ]
    text = HEAD.format("4.4.3") + "".join(f"set {line}\n" for line in ["p_roll = 50", *lines])
    found = read(tmp_path, text)
    assert [str(each) for each in found.left if each.acts] == [
        line.replace(" =", "") for line in lines[:7]
    ]
    assert [each.name for each in found.left if not each.acts] == [
        "use_integrated_yaw",
        "acc_limit",
    ]
    assert found.unknown == {"d_min_gain": 12, "osd_units": 13}
    assert "line 12: unknown to betaflight 4.4, which refuses the line: d_min_gain 20" in told(
        found
    )
    assert "of other parts: osd_units METRIC" in told(found)
    standing = {each.name: each.text for each in found.standing}
    assert standing["rpm_filter_harmonics"] == "3"
    assert "dyn_notch_count" not in standing  # it is in the file


FILES = {
    "betaflight": (
        HEAD.format("4.4.3") + "batch start\ndefaults nosave\nfeature -AIRMODE\nfeature AIRMODE\n"
        "mmix reset\nnonsense 3\nset gyro_1_spibus = 1\nset osd_units = METRIC\n"
        "set d_min_gain = 2\nprofile 1\nset p_roll = 99\nprofile 0\nset p_roll = 300\n"
        "set i_roll = 70\nset i_roll = 71\n"
        "set crash_recovery = ON\nset acc_limit = 0\nrateprofile 3\nset thr_mid = 40\n"
        "rateprofile 0\nset tpa_rate = 60\nsave\n",
        {
            "batch start": "not flown: a command of other parts",
            "defaults nosave": "not flown: a command of other parts",
            "feature -AIRMODE": "flown: ",
            "feature AIRMODE": "flown: ",
            "mmix reset": "not flown: a command of other parts",
            "nonsense 3": "unknown: is no command",
            "gyro_1_spibus 1": "not flown: of other parts",
            "osd_units METRIC": "not flown: of other parts",
            "d_min_gain 2": "unknown: betaflight 4.4 refuses it",
            "profile 1": "flown: ",
            "p_roll 99": "not flown: of profile 1, and profile 0 counts",
            "profile 0": "flown: ",
            "p_roll 300": "not flown: betaflight 4.4 refuses it: p_roll 300 (0 .. 250)",
            "i_roll 70": "not flown: set again in line 16",
            "i_roll 71": "flown: ",
            "crash_recovery ON": "not flown: not simulated",
            "acc_limit 0": "not flown: without effect here",
            "rateprofile 3": "flown: ",
            "thr_mid 40": "not flown: of rateprofile 3, and rateprofile 0 counts",
            "rateprofile 0": "flown: ",
            "tpa_rate 60": "flown: ",
            "save": "not flown: a command of other parts",
        },
    ),
    "px4": (
        QGC.format("PX4 Pro", "1.16.1").replace("Multi-Rotor", "Maker's F410")
        + "1\t1\tMC_ROLL_P\t5\t9\n1\t1\tMC_YAW_P\t-1\t9\n1\t100\tMC_ROLL_P\t3\t9\n"
        "1\t1\tMPC_ACC_HOR\t5\t9\n1\t1\tMPC_TYPO_P\t5\t9\n1\t1\tBAT1_N_CELLS\t4\t6\n",
        {
            "MC_ROLL_P 5": "flown: ",
            "MC_YAW_P -1": "not flown: is negative: this would reverse the sign of its part of the "
            "loop",
            "MC_ROLL_P 3": "not flown: of component 100 of vehicle 1, and component 1 of vehicle 1 "
            "counts",
            "MPC_ACC_HOR 5": "not flown: not simulated",
            "MPC_TYPO_P 5": "unknown: of flight control",
            "BAT1_N_CELLS 4": "unknown: of other parts, or unknown",
        },
    ),
    "ardupilot": (
        "# ArduCopter 4.1.3, by hand\n@include other.parm\nATC_RAT_RLL_FILT 30\nSERVO1_MIN 0x44C\n"
        "ATC_RAT_RLL_P 0.2 # tuned\nATC_RAT_RLL_PP 1\nMOT_SPIN_ARM 0.1\n",
        {
            "@include other.parm": "not flown: sets no parameter that is read",
            "ATC_RAT_RLL_FILT 30": "flown: ",
            "SERVO1_MIN 0x44C": "unknown: of other parts, or unknown",
            "ATC_RAT_RLL_P 0.2": "flown: ",
            "ATC_RAT_RLL_PP 1": "unknown: of flight control",
            "MOT_SPIN_ARM 0.1": "not flown: without effect here",
        },
    ),
    "script": (
        "#!/bin/sh\n. ${R}etc/init.d/rc.mc_defaults\nparam set-default MC_ROLL_P 7\n\n"
        "set VEHICLE mc\n",
        {
            ". ${R}etc/init.d/rc.mc_defaults": "not flown: sets no parameter that is read",
            "MC_ROLL_P 7": "flown: ",
            "set VEHICLE mc": "not flown: sets no parameter that is read",
        },
    ),
}


@pytest.mark.parametrize("kind", FILES)
def test_each_line_of_a_file_is_accounted_for_once(tmp_path, kind):
    text, expected = FILES[kind]
    found = read(tmp_path, text)
    lines = [(f"{each.name} {each.text}".strip(), each.part, each.why) for each in found.lines]
    assert [(line, f"{part}: {why}") for line, part, why in lines] == list(expected.items())
    written = [at for at, line in enumerate(text.splitlines(), 1) if line and line[0] != "#"]
    assert [each.number for each in found.lines] == written
    assert found.release.version == {"px4": "1.16", "ardupilot": "4.3"}.get(
        kind, found.release.version
    )


def test_names_of_flight_control_that_no_version_has_are_told_apart(tmp_path):
    others = "".join(f"1\t1\tBAT{n}_X\t4\t6\n" for n in range(40))
    found = read(
        tmp_path,
        QGC.format("PX4", "1.16.0") + others + "1\t1\tMC_ROLLRATE_X\t5\t9\n1\t1\tMC_ROLL_P\t5\t9\n",
    )
    said = "line 45: of flight control, but not known to px4 1.16, and not flown: MC_ROLLRATE_X 5"
    assert said in told(found)


@pytest.mark.parametrize(
    ("lines", "expected", "said"),
    [
        ("feature -AIRMODE\nfeature AIRMODE\n", 1.0, ""),  # as a dump prints them
        ("feature -AIRMODE\n", 0.0, ""),
        ("feature -AIRMODE\naux 2 28 1 1300 2100 0 0\n", 0.0, "line 3: air mode is on a switch"),
        ("feature -AIRMODE\naux 2 28 1 900 900 0 0\n", 0.0, ""),
        ("feature AIRMODE\naux 2 28 1 1300 2100 0 0\n", 1.0, ""),
        ("feature -GPS\n", None, ""),
    ],
)
def test_the_last_line_of_air_mode_counts(tmp_path, lines, expected, said):
    found = read(tmp_path, HEAD.format("4.5.1") + lines + "set p_roll = 50\n")
    assert found.values.get("airmode") == expected
    assert ("air mode" in told(found)) == bool(said)
    assert said in told(found)
    values = {row.name: row.default for row in found.law.parameters} | {"airmode": 0.5}
    made = export_gains(values, found.law, BETAFLIGHT_FIRMWARE, present=found)
    stays = "airmode is 0.5 here, and a command of the file that stays sets"
    assert (stays in "".join(map(str, made.remarks))) == (expected is not None)


def test_a_diff_without_a_gain_has_the_defaults_of_its_version(tmp_path):
    """Unlike a file that states no version, or a preset, which leaves all else."""
    found = read(tmp_path, HEAD.format("4.4.0") + "defaults nosave\nset osd_units = METRIC\n")
    assert (found.values, found.defaults["i_yaw"], found.defaults["angle_p_gain"]) == ({}, 80, 50)
    assert "sets no gain: all have the defaults of 4.4" in told(found)
    for text in ("set osd_units = METRIC\n", "#$ FIRMWARE_VERSION: 4.4\nset osd_units = METRIC\n"):
        with pytest.raises(WorkbenchError, match="sets none of the"):
            read(tmp_path, text)


def test_values_beyond_a_recommendation_fly(tmp_path):
    text = (
        "ATC_ACCEL_R_MAX,409404\nATC_ANG_RLL_P,30.04\nATC_ANG_YAW_P,36\nWPNAV_SPEED,2500\n"
        "WPNAV_ACCEL,2000\nATC_RAT_RLL_P,0.062\nPSC_VELXY_P,7\n"
    )
    found = read(tmp_path, text, firmware="ardupilot")
    assert found.unsafe == {}
    assert found.values["ATC_ACC_R_MAX"] == pytest.approx(4094.04)
    assert (found.values["ATC_ANG_YAW_P"], found.values["WP_SPD"]) == (36.0, 25.0)
    (remark,) = [each for each in found.remarks if "recommends" in str(each)]
    assert (remark.line, remark.count) == (1, 6)
    assert "ATC_ACCEL_R_MAX 409404 = 4094.04 deg/s^2 (0 .. 180000)" in str(remark)
    mixed = read(tmp_path, "# ArduCopter 4.1.3\nPSC_D_ACC_P,0.3\nATC_RAT_RLL_P,0.1\n")
    assert "line 2: beyond the range that ardupilot recommends: PSC_D_ACC_P 0.3 (0.01 .. 0.25)" in (
        told(mixed)
    )
    refused = read(tmp_path, HEAD.format("4.5.1") + "set p_roll = 300\nset i_roll = 90\n")
    assert refused.values == {"i_roll": 90.0}
    assert "which refuses the line: p_roll 300 (0 .. 250)" in told(refused)


@pytest.mark.parametrize(
    ("text", "version", "expected"),
    [
        (HEAD.format("4.2.11") + "set p_yaw = 45\n", "4.2", {"p_roll": 42, "d_roll": 23}),
        (HEAD.format("4.2.11") + "set p_yaw = 45\n", "4.2", {"angle_earth_ref": 0}),
        (HEAD.format("4.3.1") + "set p_yaw = 45\n", "4.3", {"anti_gravity_gain": 0}),
        (HEAD.format("2026.6.1") + "set p_yaw = 45\n", "2026.6", {"d_max_gain": 0}),
        (HEAD.format("2026.6.1") + "set p_yaw = 45\n", "2026.6", {"d_max_advance": 35}),
        ("PSC_D_POS_P,1.1\n", "4.7", {"ATC_INPUT_TC": 0.1}),
        ("# ArduCopter 4.4.4\nATC_ANG_RLL_P,5\n", "4.4", {"PSC_NE_VEL_D": 0.5}),
        ("# ArduCopter V4.6.2\nATC_ANG_RLL_P,5\n", "4.6", {"PSC_NE_VEL_D": 0.25}),
        ("# ArduCopter 4.4.4\nATC_ANG_RLL_P,5\n", "4.4", {"ATC_RAT_YAW_FLTD": 0}),
        ("# ArduCopter 4.5.7\nATC_ANG_RLL_P,5\n", "4.5", {"ATC_RAT_YAW_FLTD": 20}),
        (QGC.format("PX4", "1.10.1") + "1\t1\tMC_YAW_P\t2\t9\n", "1.10", {"IMU_DGYRO_CUTOFF": 0}),
        (QGC.format("PX4", "1.11.2") + "1\t1\tMC_YAW_P\t2\t9\n", "1.11", {"IMU_GYRO_CUTOFF": 30}),
        (QGC.format("PX4", "1.13.0") + "1\t1\tMC_YAW_P\t2\t9\n", "1.13", {"MPC_Z_VEL_MAX_DN": 1}),
        (QGC.format("PX4", "1.14.3") + "1\t1\tMC_YAW_P\t2\t9\n", "1.14", {"MC_ROLL_P": 6.5}),
        (QGC.format("PX4", "1.15.0") + "1\t1\tMC_YAW_P\t2\t9\n", "1.15", {"MC_YAW_TQ_CUTOFF": 0}),
        (QGC.format("PX4", "1.17.0") + "1\t1\tMC_YAW_P\t2\t9\n", "1.17", {"IMU_DGYRO_CUTOFF": 20}),
        ("firmware: '2025.12'\npid_rate.roll_kp: 200\n", "2025.12", {"thrust_max": 0.1125}),
        ("firmware: '2025.12.1'\npid_rate.roll_kp: 200\n", "2025.12.1", {"thrust_max": 0.12}),
    ],
)
def test_what_a_file_does_not_set_has_the_defaults_of_its_version(
    tmp_path, text, version, expected
):
    found = read(tmp_path, text)
    assert found.release.version == version
    assert {name: found.defaults[name] for name in expected} == pytest.approx(expected)
    assert "MPC_THR_HOVER" not in found.defaults  # the firmware learns it


def test_a_vehicle_with_another_motor_keeps_its_thrust(tmp_path):
    found = read(tmp_path, "firmware: '2025.12'\npid_rate.roll_kp: 200\n")
    assert found.flown({"thrust_max": 0.12})["thrust_max"] == 0.1125
    assert "thrust_max" not in found.flown({"thrust_max": 3.4})


@pytest.mark.parametrize(
    ("version", "said"),
    [
        ("4.1.7", "older than those known: read as 4.2"),
        ("2027.1.0", "newer than those known: read as 2026.6"),
        ("2026.2.0", "not one of those known: read as 2025.12"),
        ("4.6.0", "4.6 is not checked against the source: 4.6.0 development snapshot"),
        ("4.5.4", ""),
    ],
)
def test_versions_that_the_table_does_not_have_are_said(tmp_path, version, said):
    found = read(tmp_path, HEAD.format(version) + "set p_roll = 50\n")
    assert said in told(found)
    assert bool(said) == ("read as" in told(found) or "not checked" in told(found))


@pytest.mark.parametrize(
    ("text", "gains", "changed"),
    [
        # d_min 27 is not below d, so D is 27: a D of 28 is not one of 27 that rises to 28
        ("set d_roll = 27\nset d_min_roll = 27\n", {}, {}),
        (
            "set d_roll = 27\nset d_min_roll = 27\n",
            {"d_roll": 28.0},
            {"d_roll = 27": "d_roll = 28", "d_min_roll = 27": "d_min_roll = 0"},
        ),
        (
            "set d_roll = 27\nset d_min_roll = 27\n",
            {"d_max_roll": 35.0},
            {"d_roll = 27": "d_roll = 35"},
        ),
        (
            "set d_roll = 40\nset d_min_roll = 30\n",
            {"d_roll": 44.0, "d_max_roll": 0.0},
            {"d_roll = 40": "d_roll = 44", "d_min_roll = 30": "d_min_roll = 0"},
        ),
        # a file that mixes names of versions keeps them, with their scales
        (
            "# ArduCopter 4.5.7\nATC_RAT_RLL_P,0.1\nPSC_D_ACC_P,0.04\n",
            {"PSC_D_ACC_P": 0.03, "ATC_RAT_RLL_P": 0.2},
            {"PSC_D_ACC_P,0.04": "PSC_D_ACC_P,0.03", "RLL_P,0.1": "RLL_P,0.2"},
        ),
        (
            "PSC_D_ACC_I,0.1\nPSC_D_ACC_P,0.04\nANGLE_MAX 3000\nATC_ACCEL_Y_MAX,20000 # cd\n",
            {"ATC_ANGLE_MAX": 35.0, "ATC_ACC_Y_MAX": 180.0},
            {"ANGLE_MAX 3000": "ANGLE_MAX 3500", "ATC_ACCEL_Y_MAX,20000": "ATC_ACCEL_Y_MAX,18000"},
        ),
    ],
)
def test_an_export_changes_the_lines_that_a_file_has(tmp_path, text, gains, changed):
    text = text if "," in text else HEAD.format("4.4.3") + text
    found = read(tmp_path, text)
    flown = {row.name: row.default for row in found.law.parameters} | found.flown({}) | gains
    made = export_gains(flown, found.law, found.firmware, present=found)
    expected = text
    for before, after in changed.items():
        expected = expected.replace(f"{before}", after)
    assert made.text == expected
    assert not any("does not have" in str(each) for each in made.remarks)
    again = read(tmp_path, made.text).flown({})
    assert {name: again[name] for name in gains} == pytest.approx(gains)


def test_names_of_several_versions_are_not_called_those_of_all(tmp_path):
    found = read(tmp_path, "ANGLE_MAX,3000\nPSC_D_ACC_P,0.05\nATC_RAT_RLL_P,0.1\n")
    assert "its names are of several: read as 4.7" in told(found)
    assert found.values["ATC_ANGLE_MAX"] == 30.0


def test_parameters_of_a_log_are_read_as_a_file():
    found = imported_gains(
        file_of(Path("flight.ulg"), {"MC_ROLLRATE_P": 0.18, "SYS_X": 1}, "1.15.4"), PX4_FIRMWARE
    )
    assert found.values == {"MC_ROLLRATE_P": 0.18}
    assert found.flown({})["MC_ROLL_P"] == 6.5
    assert found.unknown == {"SYS_X": 0}


def test_gains_that_would_not_fly_are_named():
    for law, version, given, said in (
        ("px4", "1.16", {"MC_YAW_P": 0.0}, "MC_YAW_P is 0: nothing corrects the heading"),
        ("px4", "1.15", {"MPC_Z_VEL_I_ACC": 0.0}, "MPC_Z_VEL_I_ACC is 0: a hover thrust"),
        ("ardupilot", "4.5", {"PSC_D_ACC_P": 0.0}, "PSC_ACCZ_P is 0: the vertical acceleration"),
        ("betaflight", "4.3", {"p_yaw": 0.0}, "p_yaw is 0: the yaw rate has no feedback"),
        ("crazyflie", "2026.04", {"pid_attitude_roll_kp": 0.0}, "pid_attitude.roll_kp is 0"),
        ("ardupilot", "4.5", {"PSC_D_VEL_I": 0.0}, ""),  # as by default
    ):
        controller = load_controller(law)
        values = {row.name: row.default for row in controller.parameters} | given
        grounded = export_gains(values, controller, find_firmware(law), version).grounded
        assert [each[: len(said)] for each in grounded] == ([said] if said else [])


@pytest.mark.skipif(not CASES.is_dir(), reason="the given cases are not there")
@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("12-simplified-tuning-apply/tune.txt", {"p_roll": 81, "i_roll": 144, "p_pitch": 84}),
        ("14-d-min-without-version/lines.txt", {"d_roll": 33, "d_max_roll": 44}),
        ("23-qgc-file-of-ardupilot/iris.params", {"ATC_RAT_RLL_P": 0.2, "ATC_ANG_RLL_P": 6}),
        (
            "29-betaflight-names-of-before/lines.txt",
            {"motor_idle": 350, "angle_p_gain": 70, "angle_limit": 45, "iterm_limit": 300},
        ),
        ("30-ardupilot-autotuned/flight.param", {"ATC_ACC_P_MAX": 3011.83, "WP_ACC": 20}),
        ("31-inav-as-betaflight/diff.txt", None),
    ],
)
def test_given_cases_have_their_right_values(name, expected):
    if expected is None:
        with pytest.raises(WorkbenchError, match="is of INAV, whose laws are not here"):
            import_gains(CASES / name)
        return
    found = import_gains(CASES / name)
    assert found.unsafe == {}
    assert {each: found.values[each] for each in expected} == pytest.approx(expected)
