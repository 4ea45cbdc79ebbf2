"""Gains of a law from the file of an autopilot."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.common.parameter import Parameter
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.extras.autopilots.gain_files.file_lines import FileLines
from workbench.extras.autopilots.gain_files.firmware import (
    BETAFLIGHT_FIRMWARE,
    CRAZYFLIE_FIRMWARE,
    Firmware,
)
from workbench.extras.autopilots.gain_files.parameter_file import ParameterFile
from workbench.extras.autopilots.gain_files.simplified_tuning import with_computed_values
from workbench.extras.autopilots.gain_files.table import Release, Setting
from workbench.gains.formats import VERSION_ROW, ImportedGains, joined_names, unsafe_reason
from workbench.gains.gain_choice import rule_gains
from workbench.gains.parameter_line import ParameterFileRemark
from workbench.plant.vehicle import Vehicle

_SELECTED_LAW_PARAMETER = "stabilizer.controller"
_LAW_OF = {1.0: "crazyflie", 2.0: "mellinger"}
"""The laws by the Crazyflie's controller parameter."""
_LEARNED_HOVER_THRUSTS = {
    "MPC_THR_HOVER": ("MPC_USE_HTE", 1.0),
    "MOT_THST_HOVER": ("MOT_HOVER_LEARN", 2.0),
}
"""Hover thrusts that the firmware estimates while another parameter is not 0; its default."""


@dataclass(frozen=True, kw_only=True)
class ReadGains(ImportedGains):
    """Gains of a law from the file of an autopilot, with what was read.

    Attributes:
        file: as it was read.
        firmware: of the file.
        release: version of the firmware, as assumed.
        stated: version that the file or the caller states, "" if the names decided.
        unknown: names in the file that are not in the table of the version, with their lines.
    """

    file: ParameterFile
    firmware: Firmware
    release: Release
    stated: str
    unknown: dict[str, int]

    def remarks_on(self, vehicle: Vehicle) -> tuple[ParameterFileRemark, ...]:
        """Return remarks on a hover thrust that differs from that of the vehicle."""
        said = []
        ruled = rule_gains(vehicle, self.law)
        for name in ("MPC_THR_HOVER", "MOT_THST_HOVER"):
            if name in self.values and name in ruled:
                value, own = self.values[name], ruled[name]
                if abs(value - own) > 0.05 * own:
                    text = (
                        f"{name} is {value:.3g} in the file, and {vehicle.name} hovers at "
                        f"{own:.3g}: vertical gains are scaled by the ratio"
                    )
                    said.append(ParameterFileRemark(text, self.file.counted[name].line))
        return tuple(said)


def imported_gains(
    file: ParameterFile, firmware: Firmware, version: str = "", law: Controller | None = None
) -> ReadGains:
    """Return the gains in parameters that were read; `file_of` makes them from a dictionary.

    Args:
        file: the parameters.
        firmware: theirs.
        version: of the firmware; by default that of the file, else the newest that has its names.
        law: with the requested gains; by default that of the firmware.

    Raises:
        WorkbenchError: if it has no gain of the law.
    """
    law = law or load_controller(_law_in(firmware, file))
    if law.unscheduled not in firmware.laws:
        raise WorkbenchError(
            f"{file.path}: has parameters of {firmware.name}, and {law.name} is not one of its "
            f"laws, as {' and '.join(firmware.laws)} are: `workbench gains import "
            f"{file.path.name} --controller {law.unscheduled}` translates them"
        )
    stated = version or file.version
    candidates, release, remarks = _release(firmware, file, stated)
    if firmware is BETAFLIGHT_FIRMWARE:
        file = with_computed_values(file, release)
    remarks = [*file.remarks, *remarks]
    read = FileLines(firmware, release, file)
    rows = {row.name: row for row in firmware.rows(law)}
    table = law.table
    values: dict[str, float] = {}
    wrong: dict[str, str] = {}
    taken = {name: each for name, each in read.numbers.items() if name not in read.refused}
    for name, value in firmware.to_law(taken, release).items():
        if name in rows:
            said = unsafe_reason(table.find(name), value)
            if said:
                wrong[name] = said
            else:
                values[name] = value
    parameters = {row.name for row in law.parameters}
    values |= {name: value for name, value in file.switches.items() if name in parameters}
    if not values and not wrong and firmware.strict and file.version and not file.partial:
        remarks.append(
            ParameterFileRemark(f"sets no gain: all have the defaults of {release.version}")
        )
    elif not values and not wrong:
        names = [firmware.file_name(name) for name in rows]
        raise WorkbenchError(
            f"{file.path}: sets none of the {len(rows)} gains of {law.name}, as "
            f"{joined_names(names, 3)}"
        )
    decided = bool(stated) or len(candidates) < len(firmware.table.releases)
    defaults: dict[str, float] = {}
    if decided and not file.partial:
        defaults = _defaults(firmware, law, candidates, read, values, wrong)
        remarks += _undecided(firmware, candidates, values)
    else:
        remarks += _ambiguous(firmware, candidates, read, file)
    if decided and VERSION_ROW in parameters:
        defaults[VERSION_ROW] = float(release.version)
    left = tuple(read.left(law))
    standing = tuple(read.standing(law)) if decided and not file.partial else ()
    remarks += [
        *read.old_names(),
        *read.strangers(),
        *values_beyond_ranges(firmware, rows, read.flown_values(values), read.lines),
        *other_meanings(firmware, law, release, defaults | values),
    ]
    return ReadGains(
        file=file,
        firmware=firmware,
        release=release,
        stated=stated,
        law=law,
        values=values,
        version=stated or release.version,
        read_as=release.version,
        defaults=defaults,
        unsafe=wrong,
        left=left,
        standing=standing,
        unknown=read.unknown,
        lines=tuple(sorted(read.account(law, wrong), key=lambda line: line.number)),
        remarks=tuple(remarks),
    )


def _law_in(firmware: Firmware, file: ParameterFile) -> str:
    """Return the law of a file."""
    entries = file.counted
    if firmware is CRAZYFLIE_FIRMWARE:
        chosen = entries.get(_SELECTED_LAW_PARAMETER)
        if chosen and chosen.value in _LAW_OF:
            return _LAW_OF[chosen.value]
        mellinger = sum(name.startswith("ctrlMel.") for name in entries)
        return "mellinger" if mellinger > len(entries) / 2 else firmware.laws[0]
    return firmware.laws[0]


def _release(
    firmware: Firmware, file: ParameterFile, stated: str
) -> tuple[tuple[Release, ...], Release, list[ParameterFileRemark]]:
    """Return versions that a file may be of, the one that it is read as, and remarks on that."""
    table = firmware.table
    if stated:
        release, said = table.release(stated)
        remarks = [ParameterFileRemark(said)] if said else []
        return (release,), release, [*remarks, *unchecked_release(firmware, release)]
    names = {each.name for each in file.entries if table.knows(each.name)}
    has = {each: sum(name in table.names(each) for name in names) for each in table.releases}
    most = max(has.values())
    candidates = tuple(each for each, count in has.items() if count == most)
    own = table.release(firmware.version)[0]
    release = own if own in candidates else candidates[-1]
    if len(candidates) == len(table.releases):
        return candidates, release, []
    first, last = candidates[0].version, candidates[-1].version
    span = f"{first} to {last}" if first != last else first
    said = (
        f"states no version: its names are of {span}, read as {release.version}; --firmware decides"
    )
    return candidates, release, [ParameterFileRemark(said), *unchecked_release(firmware, release)]


def unchecked_release(firmware: Firmware, release: Release) -> list[ParameterFileRemark]:
    """Return a remark on a version whose rows were not read from its source."""
    if release.checked:
        return []
    return [
        ParameterFileRemark(
            f"{firmware.name} {release.version} is not checked against the source: "
            f"{release.source}{': ' if release.note else ''}{release.note}"
        )
    ]


def _defaults(
    firmware: Firmware,
    law: Controller,
    candidates: Sequence[Release],
    read: FileLines,
    values: Mapping[str, float],
    wrong: Mapping[str, str],
) -> dict[str, float]:
    """Return defaults of all candidates alike, for parameters of the law that the file lacks."""
    known = {row.name: row for row in law.parameters}
    by_release = [firmware.defaults(each) for each in candidates]
    found = {}
    for name, value in by_release[-1].items():
        if name not in known or name in values or name in wrong or _is_learned(name, read):
            continue
        if all(each.get(name) == value for each in by_release):
            found[name] = min(max(value, known[name].minimum), known[name].maximum)
    return found


def _is_learned(name: str, read: FileLines) -> bool:
    """Return whether the firmware estimates a parameter in flight."""
    if name not in _LEARNED_HOVER_THRUSTS:
        return False
    switch, default = _LEARNED_HOVER_THRUSTS[name]
    return read.numbers.get(switch, default) != 0.0


_HOW_TO_DECIDE = "`workbench gains import --firmware VERSION` decides"
"""For the app, too, which has no choice of a version."""


def _undecided(
    firmware: Firmware,
    candidates: Sequence[Release],
    values: Mapping[str, float],
) -> Iterator[ParameterFileRemark]:
    """Yield a remark on defaults in which the possible versions differ."""
    by_release = [firmware.defaults(each) for each in candidates]
    names = [
        firmware.file_name(name)
        for name, value in by_release[-1].items()
        if name not in values and any(each.get(name) != value for each in by_release)
    ]
    if names:
        yield ParameterFileRemark(
            f"the versions have other defaults of {joined_names(names)}, which stay as the model "
            f"has them; {_HOW_TO_DECIDE}",
            0,
            len(names),
        )


def _ambiguous(
    firmware: Firmware, candidates: Sequence[Release], read: FileLines, file: ParameterFile
) -> Iterator[ParameterFileRemark]:
    """Yield remarks on a file whose version nothing decides."""
    if file.partial:
        return
    by_release = [firmware.to_law(read.numbers, each) for each in candidates]
    other = [
        name
        for name, value in by_release[-1].items()
        if any(each.get(name) != value for each in by_release)
    ]
    meaning = f"; other versions have another meaning of {joined_names(other)}" if other else ""
    own = firmware.table.names(read.release)
    whose = "all" if all(name in own for name in read.settings) else "several"
    yield ParameterFileRemark(
        f"states no version, and its names are of {whose}: read as {read.release.version}"
        f"{meaning}; what it does not set stays as the model has it; {_HOW_TO_DECIDE}",
        0,
        max(1, len(other)),
    )


def values_beyond_ranges(
    firmware: Firmware,
    rows: Mapping[str, Parameter],
    values: Iterable[tuple[str, float, Setting]],
    lines: Mapping[str, int],
) -> Iterator[ParameterFileRemark]:
    """Yield a remark on values beyond the ranges that a firmware recommends."""
    if firmware.strict:
        return
    found = []
    for name, value, setting in values:
        row = rows.get(setting.law)
        if row is None or math.isnan(value):
            continue
        off = row.unit == "Hz" and value == 0.0
        if setting.least <= value <= setting.most or off or value == setting.default:
            continue
        si = value * setting.scale
        own = f" = {si:.6g} {row.unit}" if setting.scale != 1.0 else ""
        found.append((name, f"{name} {value:.6g}{own} ({_span(setting)})"))
    if found:
        listed = ", ".join(said for _, said in found)
        places = [lines[name] for name, _ in found if name in lines]
        yield ParameterFileRemark(
            f"beyond the range that {firmware.name} recommends: {listed}",
            min(places, default=0),
            len(found),
        )


def _span(setting: Setting) -> str:
    """Return a range, of which one end may be missing."""
    if math.isinf(setting.most):
        return f"from {setting.least:g}"
    if math.isinf(setting.least):
        return f"up to {setting.most:g}"
    return f"{setting.least:g} .. {setting.most:g}"


def other_meanings(
    firmware: Firmware, law: Controller, release: Release, values: Mapping[str, float]
) -> Iterator[ParameterFileRemark]:
    """Yield a remark on gains that fly here by the equations of another version than a file's."""
    own = f"{values[VERSION_ROW]:g}" if VERSION_ROW in values else firmware.flown_by(law)
    flown = firmware.table.release(own)[0]
    other = [
        f"{firmware.file_name(each.law)} {values[each.law]:g} ({each.note})"
        for each in firmware.table.meanings
        if (flown.numbers < each.since) != (release.numbers < each.since)
        if values.get(each.law)
    ]
    if other:
        chosen = any(row.name == VERSION_ROW for row in law.parameters)
        how = f"; --set {VERSION_ROW}={release.version} flies so" if chosen else ""
        yield ParameterFileRemark(
            f"flies as in {flown.version}, and {release.version} computes otherwise: "
            f"{joined_names(other)}{how}",
            0,
            len(other),
        )
