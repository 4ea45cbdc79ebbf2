"""Import gains from the file of an autopilot, and export them to it."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.parameter import Parameter
from workbench.control.controller import Controller, load_controller
from workbench.gains.autopilots import command_line
from workbench.gains.autopilots.file_lines import FileLines, Left, Line
from workbench.gains.autopilots.firmware import (
    BETAFLIGHT,
    CRAZYFLIE,
    Firmware,
    read_parameter_file,
    same,
    unsafe,
)
from workbench.gains.autopilots.parameter_file import ParameterFile, Remark, joined
from workbench.gains.autopilots.table import Release, Setting
from workbench.scenario.parameters import parameter_table

_SELECTED = "stabilizer.controller"
_LAW_OF = {1.0: "crazyflie", 2.0: "mellinger"}
"""The laws by the Crazyflie's controller parameter."""
VERSION_ROW = "firmware"
"""Parameter of a law that computes as the version of this number."""
_LEARNED = {"MPC_THR_HOVER": ("MPC_USE_HTE", 1.0), "MOT_THST_HOVER": ("MOT_HOVER_LEARN", 2.0)}
"""Hover thrusts that the firmware estimates while another parameter is not 0; its default."""
_MOST_NAMED = 8


@dataclass(frozen=True)
class Imported:
    """Gains of a law from the file of an autopilot.

    Attributes:
        file: as it was read.
        firmware: of the file.
        release: version of the firmware, as assumed.
        stated: version that the file or the caller states, "" if the names decided.
        law: with these gains.
        values: what the file sets, by the names and in the units of the law.
        defaults: values that the file does not set, and its version has by default.
        unsafe: why a value must not fly, a clause by its name in the law.
        left: parameters of flight control in the file that the law does not have.
        standing: such parameters that are on by default in the version, and not in the file.
        unknown: names in the file that are not in the table of the version, with their lines.
        lines: of the file, and what becomes of each.
        remarks: on the file.
    """

    file: ParameterFile
    firmware: Firmware
    release: Release
    stated: str
    law: Controller
    values: dict[str, float]
    defaults: dict[str, float]
    unsafe: dict[str, str]
    left: tuple[Left, ...]
    standing: tuple[Left, ...]
    unknown: dict[str, int]
    lines: tuple[Line, ...]
    remarks: tuple[Remark, ...]

    @property
    def version(self) -> str:
        """Version of the firmware, as stated, else as assumed."""
        return self.stated or self.release.version

    @property
    def not_flown(self) -> tuple[str, ...]:
        """Names of flight control in the file that the law does not have."""
        return tuple(each.name for each in self.left)

    def flown(self, present: Mapping[str, float]) -> dict[str, float]:
        """Return values for a flight with the file: its own, and defaults of its version.

        Args:
            present: all values of the model; those of the workbench's own parameters are kept
                unless they are the law's default.
        """
        own = {row.name: row.default for row in self.law.parameters}
        defaults = {
            name: value
            for name, value in self.defaults.items()
            if self.firmware.has(name)
            or name == VERSION_ROW
            or present.get(name) in (None, own[name])
        }
        return defaults | self.values


@dataclass(frozen=True)
class Exported:
    """A parameter file to be written.

    Attributes:
        text: of the file.
        release: version of the firmware that it is for.
        written: changed values, by the names of the firmware.
        absent: gains of the law that the file lacks, by the names of the firmware.
        grounded: why the file would not fly, sentences; empty if it would.
        remarks: on the file.
    """

    text: str
    release: Release
    written: dict[str, float]
    absent: tuple[str, ...]
    grounded: tuple[str, ...]
    remarks: tuple[Remark, ...]

    @property
    def refusal(self) -> str:
        """Why it must not be written unless the user insists, a clause; "" if it may."""
        if not self.grounded:
            return ""
        return f"would not fly: {joined(self.grounded, 6)}; nothing is written"


def import_gains(
    path: Path | str,
    firmware: str = "",
    version: str = "",
    profile: int | None = None,
    law: Controller | None = None,
) -> Imported:
    """Read the gains of the law of a firmware from its parameter file.

    Args:
        path: the file.
        firmware: its name; by default detected from the text.
        version: of the firmware; by default that in the file, else the newest that has its names.
        profile: the one to use in a Betaflight file.
        law: with the requested gains; by default that of the firmware.

    Raises:
        WorkbenchError: if it is not such a file, or has no gain of the law.
    """
    found, file = read_parameter_file(Path(path), firmware, profile)
    return imported(file, found, version, law)


def imported(
    file: ParameterFile, firmware: Firmware, version: str = "", law: Controller | None = None
) -> Imported:
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
            f"laws: leave --controller out, or say {' or '.join(firmware.laws)}; `workbench gains "
            "translate` makes gains of one law from those of another"
        )
    stated = version or file.version
    candidates, release, remarks = _release(firmware, file, stated)
    if firmware is BETAFLIGHT:
        file = command_line.settled(file, release)
    remarks = [*file.remarks, *remarks]
    read = FileLines(firmware, release, file)
    rows = {row.name: row for row in firmware.rows(law)}
    table = parameter_table(law)
    values: dict[str, float] = {}
    wrong: dict[str, str] = {}
    taken = {name: each for name, each in read.numbers.items() if name not in read.refused}
    for name, value in firmware.to_law(taken, release).items():
        if name in rows:
            said = unsafe(table.find(name), value)
            if said:
                wrong[name] = said
            else:
                values[name] = value
    parameters = {row.name for row in law.parameters}
    values |= {name: value for name, value in file.switches.items() if name in parameters}
    if not values and not wrong and firmware.strict and file.version and not file.partial:
        remarks.append(Remark(f"sets no gain: all have the defaults of {release.version}"))
    elif not values and not wrong:
        names = [firmware.file_name(name) for name in rows]
        raise WorkbenchError(
            f"{file.path}: sets none of the {len(rows)} gains of {law.name}, as {joined(names, 3)}"
        )
    decided = bool(stated) or len(candidates) < len(firmware.table.releases)
    defaults: dict[str, float] = {}
    if decided and not file.partial:
        defaults = _defaults(firmware, law, candidates, read, values, wrong)
        remarks += _undecided(firmware, candidates, defaults, values)
    else:
        remarks += _ambiguous(firmware, candidates, read, file)
    if decided and VERSION_ROW in parameters:
        defaults[VERSION_ROW] = float(release.version)
    left = tuple(read.left(law))
    standing = tuple(read.standing(law)) if decided and not file.partial else ()
    remarks += [
        *read.old_names(),
        *read.strangers(),
        *_beyond(firmware, rows, read.flown_values(values), read.lines),
        *_other_meaning(firmware, law, release, defaults | values),
    ]
    return Imported(
        file,
        firmware,
        release,
        stated,
        law,
        values,
        defaults,
        wrong,
        left,
        standing,
        read.unknown,
        tuple(sorted(read.account(law, wrong), key=lambda line: line.number)),
        tuple(remarks),
    )


def export_gains(
    values: Mapping[str, float],
    law: Controller,
    firmware: Firmware,
    version: str = "",
    present: Imported | None = None,
) -> Exported:
    """Return a parameter file of a firmware with the gains of a law.

    Args:
        values: by the names of the law, at least all that the firmware has.
        law: with the gains.
        firmware: the one to fly them.
        version: of the firmware; by default that of the existing file, else that of the law.
        present: an existing file, in which only gains change; None for a new one.

    Raises:
        WorkbenchError: if the law is not one of the firmware, or a value must not fly.
    """
    if law.unscheduled not in firmware.laws:
        raise WorkbenchError(
            f"{law.name} is not a law of {firmware.name}: its gains mean something else there; "
            f"`workbench gains translate {law.unscheduled} --to {firmware.laws[0]}` makes the "
            "others"
        )
    if law.schedule:
        raise WorkbenchError(f"{firmware.name} has no scheduled gains: export one set of them")
    flown = f"{values[VERSION_ROW]:g}" if VERSION_ROW in values else ""
    asked = version or (present.version if present else "") or flown or firmware.version
    release, said = firmware.table.release(asked)
    table = parameter_table(law)
    gains = {row.name: values[row.name] for row in firmware.rows(law)}
    for name, value in gains.items():
        why = unsafe(table.find(name), value)
        if why:
            raise WorkbenchError(f"{firmware.file_name(name)} {why}; nothing is exported")
    wanted = firmware.to_file(gains, release)
    for name, value in wanted.items():
        taken = firmware.table.names(release)[name].taken(round(value)) if firmware.strict else ""
        if taken:
            raise WorkbenchError(
                f"{name} {value:.6g} is beyond what {firmware.name} {release.version} takes, "
                f"{taken}; nothing is exported"
            )
    rows = {row.name: row for row in firmware.rows(law)}
    names = firmware.table.names(release)
    remarks = [
        *([Remark(said)] if said else []),
        *_unchecked(firmware, release),
        *_rounded(firmware, release, wanted),
        *_beyond(firmware, rows, [(n, v, names[n]) for n, v in wanted.items()], {}),
        *_lacking(firmware, release, gains, law),
        *_other_meaning(firmware, law, release, values),
    ]
    grounded = tuple(_grounded(firmware, release, gains))
    if present is None:
        new = {n: float(round(v)) if names[n].whole else v for n, v in wanted.items()}
        text = firmware.new(new, asked)
        return Exported(text, release, wanted, (), grounded, tuple(remarks))
    file = present.file
    entries = file.counted
    names = _names_in(file, firmware, release)
    wanted = _valued(names, wanted, gains)
    now = _valued(names, firmware.to_file(present.values, release), present.values)
    same_as_now = {name for name in now if _equal(names[name], now[name], wanted[name])}
    changed = {
        name: value
        for name, value in wanted.items()
        if name in entries and not same_as_now.issuperset(_partners(name, names))
    }
    written = {
        name: names[name].text(round(value))
        if names[name].words
        else firmware.written(entries[name], value)
        for name, value in changed.items()
    }
    remarks += [
        Remark(
            f"{name} is {values[name]:g} here, and a command of the file that stays sets {set_:g}"
        )
        for name, set_ in file.switches.items()
        if values.get(name, set_) != set_
    ]
    late = {name: text for name, text in written.items() if entries[name].start < 0}
    if late:
        remarks.append(
            Remark(
                "a command of the file computes these otherwise, so lines behind it set them: "
                f"{joined(list(late), _MOST_NAMED)}",
                min(entries[name].line for name in late),
                len(late),
            )
        )
    defaults = firmware.to_file(firmware.defaults(release), release)
    absent = tuple(name for name in wanted if name not in entries)
    told = [
        name
        for name in absent
        if name not in defaults or not _equal(names[name], wanted[name], defaults[name])
    ]
    if told:
        remarks.append(
            Remark(
                f"{file.path} does not have {joined(told)}, and their values here are not the "
                "firmware's defaults: export them to a separate file, and load both",
                0,
                len(told),
            )
        )
    early = {name: text for name, text in written.items() if name not in late}
    text = file.replaced(early, command_line.set_lines(file, late) if late else "")
    return Exported(text, release, changed, absent, grounded, tuple(remarks))


def _names_in(file: ParameterFile, firmware: Firmware, release: Release) -> dict[str, Setting]:
    """Return rows of a version by name; a name of another version stands for its own in a file."""
    entries, by_law = file.counted, firmware.table.by_law(release)
    found = {each.name: each for each in by_law.values() if each.name}
    for name in entries:
        setting = firmware.setting(name, release)
        if setting is None or name in found or setting.law not in by_law:
            continue
        own = by_law[setting.law].name
        if own not in entries:
            found.pop(own, None)
            found[name] = setting
    return found


def _valued(
    names: Mapping[str, Setting], own: Mapping[str, float], gains: Mapping[str, float]
) -> dict[str, float]:
    """Return values by the names in a file, from those by a version's names and by the law's."""
    found = {name: value for name, value in own.items() if name in names}
    for name, setting in names.items():
        if name not in own and not setting.pair and setting.law in gains:
            found[name] = gains[setting.law] / setting.scale
    return found


def _partners(name: str, names: Mapping[str, Setting]) -> set[str]:
    """Return names that have a meaning together with one: Betaflight's d and d_min up to 4.5."""
    if not names[name].pair:
        return {name}
    axis = name.rpartition("_")[2]
    return {each for each, row in names.items() if row.pair and each.rpartition("_")[2] == axis}


def _law_in(firmware: Firmware, file: ParameterFile) -> str:
    """Return the law of a file."""
    entries = file.counted
    if firmware is CRAZYFLIE:
        chosen = entries.get(_SELECTED)
        if chosen and chosen.value in _LAW_OF:
            return _LAW_OF[chosen.value]
        mellinger = sum(name.startswith("ctrlMel.") for name in entries)
        return "mellinger" if mellinger > len(entries) / 2 else firmware.laws[0]
    return firmware.laws[0]


def _release(
    firmware: Firmware, file: ParameterFile, stated: str
) -> tuple[tuple[Release, ...], Release, list[Remark]]:
    """Return versions that a file may be of, the one that it is read as, and remarks on that."""
    table = firmware.table
    if stated:
        release, said = table.release(stated)
        remarks = [Remark(said)] if said else []
        return (release,), release, [*remarks, *_unchecked(firmware, release)]
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
    return candidates, release, [Remark(said), *_unchecked(firmware, release)]


def _unchecked(firmware: Firmware, release: Release) -> list[Remark]:
    """Return a remark on a version whose rows were not read from its source."""
    if release.checked:
        return []
    return [
        Remark(
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
    if name not in _LEARNED:
        return False
    switch, default = _LEARNED[name]
    return read.numbers.get(switch, default) != 0.0


def _undecided(
    firmware: Firmware,
    candidates: Sequence[Release],
    defaults: Mapping[str, float],
    values: Mapping[str, float],
) -> Iterator[Remark]:
    """Yield a remark on defaults in which the possible versions differ."""
    by_release = [firmware.defaults(each) for each in candidates]
    names = [
        firmware.file_name(name)
        for name, value in by_release[-1].items()
        if name not in values and any(each.get(name) != value for each in by_release)
    ]
    if names:
        yield Remark(
            f"the versions have other defaults of {joined(names)}, which stay as the model has "
            "them; --firmware VERSION decides",
            0,
            len(names),
        )


def _ambiguous(
    firmware: Firmware, candidates: Sequence[Release], read: FileLines, file: ParameterFile
) -> Iterator[Remark]:
    """Yield remarks on a file whose version nothing decides."""
    if file.partial:
        return
    by_release = [firmware.to_law(read.numbers, each) for each in candidates]
    other = [
        name
        for name, value in by_release[-1].items()
        if any(each.get(name) != value for each in by_release)
    ]
    meaning = f"; other versions have another meaning of {joined(other)}" if other else ""
    own = firmware.table.names(read.release)
    whose = "all" if all(name in own for name in read.settings) else "several"
    yield Remark(
        f"states no version, and its names are of {whose}: read as {read.release.version}"
        f"{meaning}; what it does not set stays as the model has it; --firmware VERSION decides",
        0,
        max(1, len(other)),
    )


def _beyond(
    firmware: Firmware,
    rows: Mapping[str, Parameter],
    values: Iterable[tuple[str, float, Setting]],
    lines: Mapping[str, int],
) -> Iterator[Remark]:
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
        yield Remark(
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


def _rounded(firmware: Firmware, release: Release, wanted: Mapping[str, float]) -> Iterator[Remark]:
    """Yield a remark on gains that a firmware stores as whole numbers."""
    names = firmware.table.names(release)
    lost = [
        f"{name} {value:.4g} to {round(value)}"
        for name, value in wanted.items()
        if names[name].whole and not value.is_integer()
    ]
    if lost:
        said = f"rounded, because {firmware.name} keeps whole numbers: {joined(lost)}"
        yield Remark(said, 0, len(lost))


def _lacking(
    firmware: Firmware, release: Release, gains: Mapping[str, float], law: Controller
) -> Iterator[Remark]:
    """Yield a remark on gains that act here, and that the version does not have."""
    by_law = firmware.table.by_law(release)
    own = {row.name: row.default for row in law.parameters}
    lost = []
    for name, value in gains.items():
        setting = by_law.get(name)
        if setting is not None and setting.name:
            continue
        alike = setting.default if setting is not None else own[name]
        if value != alike:
            lost.append(f"{name} {value:g}" + (f" (there {alike:g})" if setting else ""))
    if lost:
        said = f"{firmware.name} {release.version} does not have, and does not fly: {joined(lost)}"
        yield Remark(said, 0, len(lost))


def _grounded(firmware: Firmware, release: Release, gains: Mapping[str, float]) -> Iterator[str]:
    """Yield why gains of 0 would not fly, as `MC_YAW_P is 0: nothing corrects the heading`."""
    defaults = firmware.defaults(release)
    for law, setting in firmware.table.by_law(release).items():
        if setting.name and setting.zero and gains.get(law) == 0.0 and defaults.get(law) != 0.0:
            yield f"{setting.name} is 0: {setting.zero}"


def _other_meaning(
    firmware: Firmware, law: Controller, release: Release, values: Mapping[str, float]
) -> Iterator[Remark]:
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
        yield Remark(
            f"flies as in {flown.version}, and {release.version} computes otherwise: "
            f"{joined(other)}{how}",
            0,
            len(other),
        )


def _equal(setting: Setting, a: float, b: float) -> bool:
    """Return whether two values are the same in the file's resolution."""
    return round(a) == round(b) if setting.whole else same(a, b)
