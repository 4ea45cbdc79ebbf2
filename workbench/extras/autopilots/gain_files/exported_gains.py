"""Gains of a law in the file of an autopilot."""

from collections.abc import Iterator, Mapping

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.extras.autopilots.gain_files import command_line
from workbench.extras.autopilots.gain_files.firmware import Firmware
from workbench.extras.autopilots.gain_files.imported_gains import (
    ReadGains,
    other_meanings,
    unchecked_release,
    values_beyond_ranges,
)
from workbench.extras.autopilots.gain_files.parameter_file import ParameterFile
from workbench.extras.autopilots.gain_files.table import Release, Setting
from workbench.gains.formats import (
    VERSION_ROW,
    ExportedGains,
    joined_names,
    same_in_single,
    unsafe_reason,
)
from workbench.gains.parameter_line import ParameterFileRemark

_MAX_GAINS_LISTED = 8


def exported_gains(
    values: Mapping[str, float],
    law: Controller,
    firmware: Firmware,
    version: str = "",
    present: ReadGains | None = None,
) -> ExportedGains:
    """Return a parameter file with the gains of a law, as `export_gains` says."""
    if law.unscheduled not in firmware.laws:
        raise WorkbenchError(
            f"{law.name} is not a law of {firmware.name}: its gains mean something else there; "
            f"`workbench gains export FILE --for {firmware.name} --controller {law.unscheduled}` "
            "translates them"
        )
    if law.schedule:
        raise WorkbenchError(f"{firmware.name} has no scheduled gains: export one set of them")
    flown = f"{values[VERSION_ROW]:g}" if VERSION_ROW in values else ""
    asked = version or (present.version if present else "") or flown or firmware.version
    release, said = firmware.table.release(asked)
    table = law.table
    gains = {row.name: values[row.name] for row in firmware.rows(law)}
    for name, value in gains.items():
        why = unsafe_reason(table.find(name), value)
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
        *([ParameterFileRemark(said)] if said else []),
        *unchecked_release(firmware, release),
        *_rounded(firmware, release, wanted),
        *values_beyond_ranges(firmware, rows, [(n, v, names[n]) for n, v in wanted.items()], {}),
        *_lacking(firmware, release, gains, law),
        *other_meanings(firmware, law, release, values),
    ]
    grounded = tuple(_grounded(firmware, release, gains))
    if present is None:
        new = {n: float(round(v)) if names[n].whole else v for n, v in wanted.items()}
        return ExportedGains(
            text=firmware.new(new, asked),
            version=release.version,
            defaults=firmware.defaults(release),
            written=wanted,
            grounded=grounded,
            remarks=tuple(remarks),
        )
    file = present.file
    entries = file.counted
    names = _settings_by_file_name(file, firmware, release)
    wanted = _valued(names, wanted, gains)
    now = _valued(names, firmware.to_file(present.values, release), present.values)
    same_as_now = {name for name in now if _equal_in_file(names[name], now[name], wanted[name])}
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
        ParameterFileRemark(
            f"{name} is {values[name]:g} here, and a command of the file that stays sets {set_:g}"
        )
        for name, set_ in file.switches.items()
        if values.get(name, set_) != set_
    ]
    late = {name: text for name, text in written.items() if entries[name].start < 0}
    if late:
        remarks.append(
            ParameterFileRemark(
                "a command of the file computes these otherwise, so lines behind it set them: "
                f"{joined_names(list(late), _MAX_GAINS_LISTED)}",
                min(entries[name].line for name in late),
                len(late),
            )
        )
    defaults = firmware.to_file(firmware.defaults(release), release)
    absent = tuple(name for name in wanted if name not in entries)
    told = [
        name
        for name in absent
        if name not in defaults or not _equal_in_file(names[name], wanted[name], defaults[name])
    ]
    if told:
        remarks.append(
            ParameterFileRemark(
                f"{file.path} does not have {joined_names(told)}, and their values here are not "
                "the "
                "firmware's defaults: export them to a separate file, and load both",
                0,
                len(told),
            )
        )
    early = {name: text for name, text in written.items() if name not in late}
    text = file.replaced(early, command_line.set_lines(file, late) if late else "")
    return ExportedGains(
        text=text,
        version=release.version,
        defaults=firmware.defaults(release),
        written=changed,
        absent=absent,
        grounded=grounded,
        remarks=tuple(remarks),
    )


def _settings_by_file_name(
    file: ParameterFile, firmware: Firmware, release: Release
) -> dict[str, Setting]:
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


def _rounded(
    firmware: Firmware, release: Release, wanted: Mapping[str, float]
) -> Iterator[ParameterFileRemark]:
    """Yield a remark on gains that a firmware stores as whole numbers."""
    names = firmware.table.names(release)
    lost = [
        f"{name} {value:.4g} to {round(value)}"
        for name, value in wanted.items()
        if names[name].whole and not value.is_integer()
    ]
    if lost:
        said = f"rounded, because {firmware.name} keeps whole numbers: {joined_names(lost)}"
        yield ParameterFileRemark(said, 0, len(lost))


def _lacking(
    firmware: Firmware, release: Release, gains: Mapping[str, float], law: Controller
) -> Iterator[ParameterFileRemark]:
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
        said = (
            f"{firmware.name} {release.version} does not have, and does not fly: "
            f"{joined_names(lost)}"
        )
        yield ParameterFileRemark(said, 0, len(lost))


def _grounded(firmware: Firmware, release: Release, gains: Mapping[str, float]) -> Iterator[str]:
    """Yield why gains of 0 would not fly, as `MC_YAW_P is 0: nothing corrects the heading`."""
    defaults = firmware.defaults(release)
    for law, setting in firmware.table.by_law(release).items():
        if setting.name and setting.zero and gains.get(law) == 0.0 and defaults.get(law) != 0.0:
            yield f"{setting.name} is 0: {setting.zero}"


def _equal_in_file(setting: Setting, a: float, b: float) -> bool:
    """Return whether two values are the same in the file's resolution."""
    return round(a) == round(b) if setting.whole else same_in_single(a, b)
