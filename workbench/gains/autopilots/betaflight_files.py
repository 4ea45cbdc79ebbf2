"""Betaflight's command line: what `diff` and `dump` print, and what is typed there.

`set NAME = VALUE` is for the profile that a line `profile N` above it chose, or for all; a dump
ends by choosing again the profile that was in use, and that one counts. A `diff` has what differs
from the defaults of its own version, in whole numbers.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from workbench.gains.autopilots.numbers import number_in
from workbench.gains.autopilots.parameter_file import Entry, ParameterFile, lines_of

SET = re.compile(r"[ \t]*set[ \t]+(\w+)[ \t]*=[ \t]*([^\r\n#]*[^\s#])[ \t]*(?:#.*)?")
_PROFILE = re.compile(r"[ \t]*profile[ \t]+(\d{1,3})[ \t]*(?:#.*)?")
_OTHER = re.compile(r"[ \t]*(rateprofile[ \t]+\d+|#[ \t]*(master|rateprofile)\b.*)[ \t]*")
_VERSION = re.compile(r"#[ \t]*(?:Betaflight|BTFL)\b.*?[ \t](\d+\.\d+\.\d+\S*)")
_SLIDERS = "simplified_pids_mode"


def read_cli(path: Path, text: str, profile: int | None = None) -> ParameterFile:
    """Read what a command line printed.

    Args:
        path: the file.
        text: of it.
        profile: whose gains count; without it those of the profile that is chosen last.
    """
    entries = []
    version, scope, chosen, resets = "", "", "", False
    for number, start, line in lines_of(text):
        found = _VERSION.match(line)
        if found and not version:
            version = found[1]
        resets = resets or line.strip() == "defaults nosave"
        if match := _PROFILE.fullmatch(line):
            scope = chosen = f"profile {int(match[1])}"
        elif _OTHER.fullmatch(line):
            scope = "others"
        elif match := SET.fullmatch(line):
            name, value = match.groups()
            at = start + match.start(2)
            of_profile = scope if scope.startswith("profile") else ""
            entries.append(Entry(name, number_in(value), value, at, number, of_profile, True))
    profiles = list(dict.fromkeys(each.scope for each in entries if each.scope))
    counted = chosen if profile is None else f"profile {profile}"
    remarks = []
    if len(profiles) > 1:
        remarks.append(f"has {', '.join(profiles)}: {counted} counts, --profile takes another")
    if counted and profiles and counted not in profiles:
        remarks.append(f"sets nothing in {counted}; it does in {', '.join(profiles)}")
    if resets:
        remarks.append("begins at the defaults of its version: what it does not set has those")
    sliders = [each for each in entries if each.name == _SLIDERS and each.text != "OFF"]
    if sliders:
        remarks.append(
            f"has {_SLIDERS} = {sliders[-1].text}: sliders rewrite gains when it is loaded, set "
            "it to OFF"
        )
    return ParameterFile(path, text, tuple(entries), version, counted, tuple(remarks))


def written_value(entry: Entry, value: float) -> str:
    """Return a value as its line has it."""
    return str(round(value))


def new_file(values: Mapping[str, float], version: str) -> str:
    """Return lines to paste into the command line."""
    lines = [f"# Betaflight {version}\n", "\n", "batch start\n", "\n", "profile 0\n", "\n"]
    lines += [f"set {name} = {round(values[name])}\n" for name in sorted(values)]
    return "".join([*lines, "\n", "save\n"])
