"""Files of parameters that nobody wrote, of each autopilot's format, by a seed."""

import math
import random

from workbench.control.controller import Controller
from workbench.extras.autopilots.gain_files.firmware import Firmware, find_firmware
from workbench.extras.autopilots.gain_files.parameter_file import integer_parameters
from workbench.extras.autopilots.gain_files.table import BASE_GAIN, Release, load_table

OTHERS = {
    "px4": ("BAT1_CAPACITY", "COM_RC_LOSS_T", "SYS_AUTOSTART", "CAL_GYRO0_ID"),
    "ardupilot": ("BATT_CAPACITY", "SERVO1_MIN", "LOG_BITMASK", "SR0_POSITION"),
    "betaflight": ("vbat_min_cell_voltage", "osd_units", "blackbox_device", "motor_pwm_protocol"),
    "crazyflie": ("ring.effect", "sound.effect", "stabilizer.estimator", "kalman.robustTdoa"),
}


VERSIONS = {"px4": "1.16", "ardupilot": "4.7", "betaflight": "4.6", "crazyflie": "2025.12"}
"""Those of the files below."""


def release_of(firmware: Firmware) -> Release:
    """Return the version of a file below."""
    return firmware.table.release(VERSIONS[firmware.name])[0]


def gains_of(
    firmware: Firmware, law: Controller, rng: random.Random, release: Release
) -> dict[str, float]:
    """Return some gains of a law in the units and by the names of a version."""
    rows = {row.name: row for row in law.parameters}
    names = firmware.table.names(release)
    known = [name for name, each in names.items() if each.law in rows and each.pair != BASE_GAIN]
    found = {}
    for name in rng.sample(known, rng.randint(3, len(known))):
        setting = names[name]
        row = rows[setting.law]
        least, most = row.minimum / setting.scale, row.maximum / setting.scale
        if firmware.strict:
            least, most = max(least, setting.least), min(most, setting.most)
        if setting.whole:
            found[name] = float(rng.randint(math.ceil(least), math.floor(most)))
        else:
            value = rng.uniform(least, most)
            found[name] = min(most, max(least, float(f"{value:.{rng.randint(2, 12)}g}")))
    return found


def number(value: float, rng: random.Random) -> str:
    """Return a number as somebody may have typed it."""
    if value.is_integer():
        return rng.choice([str(int(value)), f"{value:.1f}", f"{value:.6f}"])
    return rng.choice([repr(value), f"{value:.17e}", f"{value:.17g}"])


def text_of(firmware: Firmware, gains: dict[str, float], rng: random.Random) -> str:
    """Return a file with some gains, and other things."""
    end = rng.choice(["\n", "\n", "\r\n"])
    others = rng.sample(OTHERS[firmware.name], rng.randint(0, 4))
    names = [*gains, *others]
    rng.shuffle(names)
    make = {
        "px4": rng.choice([_params, _params, _script]),
        "ardupilot": _param,
        "betaflight": _cli,
        "crazyflie": rng.choice([_yaml, _json]),
    }[firmware.name]
    lines = make(names, gains, rng)
    return end.join(lines) + (end if rng.random() < 0.8 else "")


def _params(names, gains, rng):
    lines = ["# Onboard parameters for Vehicle 1", "#", "# Version: 1.16.0", ""]
    for name in names:
        whole = name in integer_parameters() or name not in gains
        text = str(round(gains.get(name, rng.randint(0, 9)))) if whole else f"{gains[name]:.18g}"
        lines.append(f"1\t1\t{name}\t{text}\t{6 if whole else 9}")
        if rng.random() < 0.1:  # the same name of another component is another parameter
            lines.append(f"1\t{rng.choice([2, 100])}\t{name}\t{rng.randint(0, 9)}\t6")
    return lines


def _script(names, gains, rng):
    lines = ["#!/bin/sh", "# @name Made up", ". ${R}etc/init.d/rc.mc_defaults", ""]
    for name in names:
        value = gains.get(name, float(rng.randint(0, 9)))
        set_ = rng.choice(["param set-default", "param set"])
        lines.append(f"{set_} {name} {number(value, rng)}{rng.choice(['', ' # why', ''])}")
    return lines


def _param(names, gains, rng):
    lines = ["# made up", ""]
    for name in names:
        value = gains.get(name, float(rng.randint(0, 99)))
        text = hex(int(value)) if name not in gains and rng.random() < 0.3 else number(value, rng)
        between = rng.choice([",", " ", "\t", ", ", "        "])
        lines.append(f"{name}{between}{text}{rng.choice(['', '  # said why, with 3 words', ' '])}")
    if rng.random() < 0.2:
        lines.append("@include other.parm")
    return lines


def _cli(names, gains, rng):
    lines = ["# Betaflight / SITL (SITL) 4.6.0 Jan  1 2026 / 00:00:00 (abc) MSP API: 1.47", ""]
    lines += ["batch start", "", "feature -GPS", "# master"]
    words = ("OFF", "AUTO", "3,4")
    lines += [f"set {name} = {rng.choice(words)}" for name in names if name not in gains]
    profiles = rng.randint(0, 2)
    for profile in range(profiles):  # the last one is the one that counts
        lines += [f"profile {profile}", ""]
        lines += [f"set {name} = {rng.randint(0, 99)}" for name in gains if rng.random() < 0.5]
    lines += ["rateprofile 0", "set roll_rc_rate = 7", f"profile {profiles}", ""]
    names = load_table("betaflight").names(release_of(find_firmware("betaflight")))
    lines += [f"set {name} = {names[name].text(value)}" for name, value in gains.items()]
    return [*lines, "", "save"]


def _yaml(names, gains, rng):
    lines = ["# made up", "firmware: '2025.12'", "params:"]
    for name in names:
        value = gains.get(name, float(rng.randint(0, 9)))
        lines.append(f"  {name}: {value!r}{rng.choice(['', '  # why'])}")
    return lines


def _json(names, gains, rng):
    lines = ["{", '  "firmware_version": "2025.12",']
    lines += [f'  "{name}": {gains.get(name, 1)!r},' for name in names]
    return [*lines[:-1], lines[-1].rstrip(","), "}"]
