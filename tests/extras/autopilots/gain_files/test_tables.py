"""The tables of firmwares against the sources of the tags that they name.

The test wants clones in the folder that WORKBENCH_FIRMWARES names, one a firmware, with the tags:
`betaflight`, `px4`, `ardupilot`, `crazyflie`; other clones of a firmware may stand beside it, as
`ardupilot-2`. The readers take definitions from the text, macros by their first definition.
"""

import math
import os
import re
import subprocess
from pathlib import Path

import pytest

from workbench.extras.autopilots.gain_files.table import load_table

CLONES = Path(os.environ.get("WORKBENCH_FIRMWARES", "none"))


def text_of(firmware: str, commit: str, *paths: str) -> str:
    """Return the text of files of a commit, without comments; skip if no clone has it."""
    for clone in sorted(CLONES.glob(f"{firmware}*")):
        shown = [
            subprocess.run(
                ["git", f"--git-dir={clone}", "show", f"{commit}:{path}"],
                capture_output=True,
                check=False,
            )
            for path in paths
        ]
        found = "\n".join(each.stdout.decode(errors="replace") for each in shown)
        if found.strip():
            return found
    pytest.skip(f"no clone of {firmware} has {commit[:9]}: set WORKBENCH_FIRMWARES")


def bare(text: str) -> str:
    return re.sub(r"//[^\n]*", "", re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL))


def macros(text: str) -> dict[str, str]:
    found: dict[str, str] = {}
    for name, value in re.findall(r"#[ \t]*define[ \t]+(\w+)[ \t]+([^\n]+)", text):
        found.setdefault(name, value.strip())
    return found


def number(text: str, known: dict[str, str]) -> float | None:
    """Return the number that a text or a macro stands for, None if it is none."""
    for _ in range(5):
        text = text.strip().strip("()")
        try:
            return float(text.rstrip("fF") if not text.startswith("0x") else int(text, 16))
        except ValueError:
            text = known.get(text, "")
    return None


def checked(firmware: str):
    return [
        pytest.param(each, id=f"{firmware} {each.version}")
        for each in load_table(firmware).releases
        if each.checked
    ]


BETAFLIGHT = (
    "cli/settings.c",
    "fc/parameter_names.h",
    "flight/pid.c",
    "flight/pid.h",
    "sensors/gyro.c",
    "sensors/gyro.h",
    "pg/motor.c",
    "pg/dyn_notch.c",
    "pg/rpm_filter.c",
    "flight/rpm_filter.c",
    "flight/mixer.c",
    "flight/mixer_init.c",
    "fc/controlrate_profile.c",
    "fc/controlrate_profile.h",
    "config/simplified_tuning.h",
)


@pytest.mark.parametrize("release", checked("betaflight"))
def test_betaflights_table_is_that_of_its_settings(release, case):
    text = bare(text_of("betaflight", release.commit, *(f"src/main/{p}" for p in BETAFLIGHT)))
    known = macros(text)
    names = {name: value.strip('"') for name, value in known.items() if "PARAM_NAME" in name}
    resets = dict(re.findall(r"^\s*\.(\w+(?:\.\w+)*)\s*=\s*([^,\n{][^,\n]*),", text, re.MULTILINE))
    resets |= dict(re.findall(r"Config->(\w+(?:\.\w+)*)\s*=\s*([^;\n]+);", text))
    gains = dict(re.findall(r"\[(PID_\w+)\]\s*=\s*(\{[^}]*\}|\w+)", text))
    table = load_table("betaflight").names(release)
    seen, compared = set(), 0
    entry = r"\{\s*(\"\w+\"|PARAM_NAME_\w+)\s*,\s*VAR_\w+([^,]*),([^;]*?)offsetof\(\w+,\s*([^)]+)\)"
    for written, flags, config, place in re.findall(entry, text):
        name = written.strip('"') if written.startswith('"') else names[written]
        seen.add(name)
        setting = table.get(name)
        if setting is None:
            continue
        with case(name):
            limits = re.search(r"minmax(?:Unsigned)?\s*=\s*\{([^,]+),([^}]+)\}", config)
            for at, own in enumerate((setting.least, setting.most) if limits else (), 1):
                value = number(limits[at], known)
                assert value is None or value == own
                compared += value is not None
            kind = (
                "rateprofile" if "RATE_VALUE" in flags else "profile" if "PROFILE" in flags else ""
            )
            assert setting.scope == kind
            value = reset_of(place.strip(), resets, gains, known)
            if value is not None and not setting.words and setting.default is not None:
                assert value == setting.default
                compared += 1
    others = {each.name for each in load_table("betaflight").others if each.covers(release.numbers)}
    assert table.keys() <= seen
    assert compared > 250
    every = re.findall(r"\{\s*(?:\"(\w+)\"|(PARAM_NAME_\w+))\s*,\s*VAR_", text)
    assert {(own or names[macro]).casefold() for own, macro in every} == table.keys() | others


def reset_of(place, resets, gains, known):
    """Return the default of a field, None if it is not a number in the text."""
    found = re.fullmatch(r"pid\[(PID_\w+)\]\.([PIDFS])", place)
    if found:
        written = gains[found[1]]
        written = written if written.startswith("{") else known[written]
        values = written.strip("{} ").split(",")
        at = "PIDFS".index(found[2])
        return number(values[at], known) if at < len(values) else None
    found = re.fullmatch(r"(d_min|d_max)\[FD_(ROLL|PITCH|YAW)\]", place)
    if found:
        written = known.get(f"{found[1].upper()}_DEFAULT", "")
        values = written.strip("{} ").split(",")
        at = ("ROLL", "PITCH", "YAW").index(found[2])
        return number(values[at], known) if at < len(values) else None
    return number(resets.get(place, ""), known)


@pytest.mark.parametrize("release", checked("px4"))
def test_px4s_table_is_that_of_its_parameters(release, case):
    folder, files, inside = "src/modules", [], r"(?:mc_\w+|sensors)/.*params.*\.c$"
    for clone in sorted(CLONES.glob("px4*")):
        listed = subprocess.run(
            ["git", f"--git-dir={clone}", "ls-tree", "-r", "--name-only", release.commit, folder],
            capture_output=True,
            check=False,
            text=True,
        ).stdout
        files = files or re.findall(rf"^{folder}/{inside}", listed, re.MULTILINE)
    text = text_of("px4", release.commit, *(files or ["src/modules/none.c"]))
    table, compared = load_table("px4").names(release), 0
    pattern = r"/\*\*((?:(?!\*/).)*?)\*/\s*PARAM_DEFINE_(FLOAT|INT32)\((\w+),\s*([^)]+)\)"
    for said, kind, name, written in re.findall(pattern, text, re.DOTALL):
        setting = table.get(name)
        if setting is None:
            continue
        with case(name):
            compared += 1
            assert setting.default == number(written, {})
            assert setting.whole == (kind == "INT32")
            for word, own, sign in (("min", setting.least, -1), ("max", setting.most, 1)):
                limit = re.search(rf"@{word}\s+(\S+)", said)
                assert own == (float(limit[1]) if limit else sign * math.inf)
    assert compared > 80


@pytest.mark.parametrize("release", checked("ardupilot"))
def test_arducopters_defaults_are_those_of_its_source(release, case):
    attitude, navigation = "libraries/AC_AttitudeControl/", "libraries/AC_WPNav/"
    text = bare(
        text_of(
            "ardupilot",
            release.commit,
            f"{attitude}AC_AttitudeControl_Multi.h",
            f"{attitude}AC_AttitudeControl.h",
            f"{navigation}AC_WPNav.cpp",
            f"{navigation}AC_WPNav.h",
            "libraries/AP_Motors/AP_MotorsMulticopter.h",
            "ArduCopter/config.h",
        )
    )
    source = bare(text_of("ardupilot", release.commit, f"{attitude}AC_PosControl.cpp"))
    _, _, copters = source.rpartition("#else")  # those of Plane and Sub stand before
    known = macros(text) | {
        name: value
        for name, value in re.findall(r"#[ \t]*define[ \t]+(POSCONTROL_\w+)[ \t]+(\S+)", copters)
    }
    own = {name: each.default for name, each in load_table("ardupilot").names(release).items()}
    multi, angle = "AC_ATC_MULTI_RATE", "AC_ATTITUDE_CONTROL"
    pairs = {
        "PSC_POSXY_P": "POSCONTROL_POS_XY_P",
        "PSC_POSZ_P": "POSCONTROL_POS_Z_P",
        "PSC_VELZ_P": "POSCONTROL_VEL_Z_P",
        **{f"PSC_VELXY_{part}": f"POSCONTROL_VEL_XY_{part}" for part in ("P", "I", "D", "IMAX")},
        **{f"PSC_ACCZ_{part}": f"POSCONTROL_ACC_Z_{part}" for part in ("P", "I", "D", "IMAX")},
        "PSC_ACCZ_FLTE": "POSCONTROL_ACC_Z_FILT_HZ",
        "PSC_VELXY_FLTE": "POSCONTROL_VEL_XY_FILT_HZ",
        "PSC_VELXY_FLTD": "POSCONTROL_VEL_XY_FILT_D_HZ",
        **{
            f"ATC_RAT_{axis}_{part}": f"{multi}_{kind}_{part}"
            for axis, kind in (("RLL", "RP"), ("PIT", "RP"), ("YAW", "YAW"))
            for part in ("P", "I", "D", "IMAX")
        },
        "ATC_RAT_YAW_FLTE": f"{multi}_YAW_FILT_HZ",
        "ATC_ANG_RLL_P": f"{angle}_ANGLE_P",
        "ATC_ACCEL_R_MAX": f"{angle}_ACCEL_RP_MAX_DEFAULT_CDSS",
        "ATC_ACCEL_Y_MAX": f"{angle}_ACCEL_Y_MAX_DEFAULT_CDSS",
        "ATC_SLEW_YAW": f"{angle}_SLEW_YAW_DEFAULT_CDS",
        "ATC_THR_MIX_MAX": f"{angle}_MAX_DEFAULT",
        "WPNAV_SPEED": "WPNAV_WP_SPEED",
        "WPNAV_SPEED_UP": "WPNAV_WP_SPEED_UP",
        "WPNAV_SPEED_DN": "WPNAV_WP_SPEED_DOWN",
        "WPNAV_ACCEL": "WPNAV_ACCELERATION",
        "MOT_SPIN_MIN": "AP_MOTORS_SPIN_MIN_DEFAULT",
        "MOT_SPIN_MAX": "AP_MOTORS_SPIN_MAX_DEFAULT",
        "MOT_THST_EXPO": "AP_MOTORS_THST_EXPO_DEFAULT",
        "MOT_YAW_HEADROOM": "AP_MOTORS_YAW_HEADROOM_DEFAULT",
        "ANGLE_MAX": "DEFAULT_ANGLE_MAX",
    }
    for name, macro in pairs.items():
        with case(name):
            assert own[name] == pytest.approx(number(macro, known))
    multicopter = f"{attitude}AC_AttitudeControl_Multi"
    source = bare(text_of("ardupilot", release.commit, f"{multicopter}.h", f"{multicopter}.cpp"))
    known |= macros(source)
    for axis, kind in (("RLL", "roll"), ("PIT", "pitch"), ("YAW", "yaw")):
        filters = filters_of(kind, source)
        for part, written in zip(("FLTT", "FLTE", "FLTD"), filters, strict=True):
            with case(axis, part):
                assert own[f"ATC_RAT_{axis}_{part}"] == number(written, known)


def filters_of(axis: str, source: str) -> list[str]:
    """Return the three filters of a rate controller, as its constructor has them."""
    found = re.search(rf"_pid_rate_{axis}\(([^()]*)\)", source)
    if found:
        return found[1].split(",")[5:8]
    found = re.search(rf"_pid_rate_{axis}\s*\{{(.*?)\}};", source, re.DOTALL)
    return [re.search(rf"filt_{part}_hz\s*=\s*(\w+[.\w]*)", found[1])[1] for part in "TED"]


STARTS = ("", "ATC_", "PSC", "MOT_", "WPNAV_", "WP_", "INS_")


@pytest.mark.parametrize(
    "release",
    [pytest.param(each, id=each.version) for each in load_table("ardupilot").releases],
)
def test_arducopters_ranges_are_those_of_its_source(release, case):
    folders = {
        "AC_AttitudeControl": "AC_AttitudeControl AC_AttitudeControl_Multi AC_PosControl",
        "AC_WPNav": "AC_WPNav",
        "AP_Motors": "AP_MotorsMulticopter",
        "AP_InertialSensor": "AP_InertialSensor",
    }
    paths = [f"libraries/{name}/{each}.cpp" for name in folders for each in folders[name].split()]
    text = text_of("ardupilot", release.commit, "ArduCopter/Parameters.cpp", *paths)
    table, compared = load_table("ardupilot").names(release), 0
    for block in re.split(r"//[ \t]*@Param(?:\{\w+\})?:[ \t]*", text)[1:]:
        written = block.split("\n")[0].strip()
        names = [f"{start}{written}" for start in STARTS if f"{start}{written}" in table]
        said = "".join(re.findall(r"(?m)^[ \t]*//[ \t]*(@\w+:.*\n)", block.split("AP_")[0]))
        limits = re.search(r"@Range:[ \t]*([-\d.]+)[ \t]+([-\d.]+)", said)
        if not names or not limits:
            continue
        with case(names[0]):
            own = table[names[0]].least, table[names[0]].most
            assert own == (float(limits[1]), float(limits[2]))
            compared += 1
    assert compared > 80


@pytest.mark.parametrize("release", checked("crazyflie"))
def test_the_crazyflies_table_is_that_of_its_source(release, case):
    folder, platform = "src/modules/src/controller", "src/platform/interface/platform_defaults"
    text = bare(
        text_of(
            "crazyflie",
            release.commit,
            f"{folder}/position_controller_pid.c",
            f"{folder}/attitude_pid_controller.c",
            f"{folder}/controller_mellinger.c",
        )
    )
    known = macros(bare(text_of("crazyflie", release.commit, f"{platform}_cf2.h")))
    names = set()
    groups = r"PARAM_GROUP_START\((\w+)\)(.*?)PARAM_GROUP_STOP"
    for group, body in re.findall(groups, text, re.DOTALL):
        names |= {f"{group}.{each}" for each in re.findall(r"PARAM_ADD\w*\([^,]+,\s*(\w+),", body)}
    table = load_table("crazyflie").names(release)
    assert table.keys() - {"stabilizer.controller"} <= names
    gains = r"^\s*\.(k\w+|i_range\w+|massThrust)\s*=\s*([\d.]+)"
    mellinger = dict(re.findall(gains, text, re.MULTILINE))
    for name, setting in table.items():
        group, _, rest = name.partition(".")
        with case(name):
            if group == "ctrlMel" and rest in mellinger:
                assert setting.default == float(mellinger[rest])
            elif group in ("pid_rate", "pid_attitude") and rest.count("_") == 1:
                axis, term = rest.upper().split("_")
                rate = "_RATE" if group == "pid_rate" else ""
                assert setting.default == number(f"PID_{axis}{rate}_{term}", known)
            elif found := re.fullmatch(r"v?([xyz])K([pidf]+)", rest, re.IGNORECASE):
                kind = "VEL" if group == "velCtlPid" else "POS"
                macro = f"PID_{kind}_{found[1].upper()}_K{found[2].upper()}"
                assert setting.default == number(macro, known)
    most = load_table("crazyflie").by_law(release)["thrust_max"].default
    assert most == number("THRUST_MAX", known)
