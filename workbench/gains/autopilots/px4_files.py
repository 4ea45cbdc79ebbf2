"""PX4's parameters: QGroundControl's .params files, and `param set-default` of airframe scripts.

A line of .params has vehicle, component, name, value and type, between tabs; reals have single
precision, written with all their digits. Of several components the autopilot's own counts, 1.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.gains.autopilots.numbers import long_single, number_in
from workbench.gains.autopilots.parameter_file import Entry, ParameterFile, lines_of

INT32, REAL32 = "6", "9"
"""MAV_PARAM_TYPE of the two types that PX4 has."""
PARAMS = re.compile(r"[ \t]*(\d+)[ \t]+(\d+)[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\d+)[ \t]*")
SCRIPT = re.compile(
    r"[ \t]*param[ \t]+set(?:-default)?(?:[ \t]+-[a-z])*[ \t]+(\w+)[ \t]+([^\s#;]+)"
)
_VERSION = re.compile(r"#[ \t]*(?:Version|PX4 Version)[ \t]*:[ \t]*v?(\S+)")
AUTOPILOT = "1"
WHOLE = ("MC_AIRMODE", "MPC_ACC_DECOUPLE")
"""Of the law's parameters, those that PX4 keeps as whole numbers."""
HEAD = """# Onboard parameters for Vehicle 1
#
# Stack: PX4 Pro
# Vehicle: Multi-Rotor
# Version: {version}
#
# Vehicle-Id Component-Id Name Value Type
"""


def read_params(path: Path, text: str) -> ParameterFile:
    """Read a .params file.

    Raises:
        WorkbenchError: naming the line that is none.
    """
    entries, version = [], ""
    for number, start, line in lines_of(text):
        bare = line.lstrip("\ufeff \t")
        if not bare or bare.startswith("#"):
            found = _VERSION.match(bare)
            version = found[1] if found and not version else version
            continue
        match = PARAMS.fullmatch(line)
        if not match:
            raise WorkbenchError(
                f"{path}:{number}: is no line of parameters: expected vehicle, component, name, "
                "value and type, between tabs"
            )
        vehicle, component, name, value, kind = match.groups()
        scope = f"{vehicle} {component}"
        at = start + match.start(4)
        entries.append(Entry(name, number_in(value), value, at, number, scope, kind != REAL32))
    scopes = list(dict.fromkeys(each.scope for each in entries))
    own = [scope for scope in scopes if scope.split()[1] == AUTOPILOT] or scopes
    remarks = []
    if len(scopes) > 1:
        remarks.append(
            f"has parameters of {len(scopes)} components: those of component "
            f"{own[0].split()[1]} of vehicle {own[0].split()[0]} count"
        )
    return ParameterFile(path, text, tuple(entries), version, own[0] if own else "", tuple(remarks))


def read_script(path: Path, text: str) -> ParameterFile:
    """Read what an airframe script sets; all else in it is left alone."""
    entries = []
    for number, start, line in lines_of(text):
        match = SCRIPT.match(line)
        if match:
            name, value = match.groups()
            whole = name in WHOLE
            at = start + match.start(2)
            entries.append(Entry(name, number_in(value), value, at, number, whole=whole))
    return ParameterFile(path, text, tuple(entries))


def written_value(entry: Entry, value: float) -> str:
    """Return a value as its line has it."""
    if entry.whole:
        return str(round(value))
    return long_single(value) if entry.scope else f"{value:.9g}"


def new_file(values: Mapping[str, float], version: str) -> str:
    """Return the text of a .params file."""
    lines = [HEAD.format(version=version)]
    for name in sorted(values):
        whole = name in WHOLE
        text = str(round(values[name])) if whole else long_single(values[name])
        lines.append(f"1\t{AUTOPILOT}\t{name}\t{text}\t{INT32 if whole else REAL32}\n")
    return "".join(lines)
