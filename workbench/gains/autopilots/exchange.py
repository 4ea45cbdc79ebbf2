"""Import gains from the file of an autopilot, and export them to it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller, load_controller
from workbench.gains.autopilots import versions
from workbench.gains.autopilots.firmware import (
    CRAZYFLIE,
    Firmware,
    read_parameter_file,
    same,
    unsafe,
)
from workbench.gains.autopilots.parameter_file import ParameterFile, joined, tidy
from workbench.gains.autopilots.ranges import beyond
from workbench.scenario.parameters import parameter_table

_SELECTED = "stabilizer.controller"
_LAW_OF = {1.0: "crazyflie", 2.0: "mellinger"}
"""The laws by the Crazyflie's controller parameter."""


@dataclass(frozen=True)
class Imported:
    """Gains of a law from the file of an autopilot.

    Attributes:
        file: as it was read.
        firmware: of the file.
        version: of the firmware, as assumed.
        law: with these gains.
        values: flyable ones, by the names and in the units of the law.
        unsafe: why a value must not fly, a clause by its name in the law.
        not_flown: names of flight control in the file that the law does not have.
        remarks: sentences.
    """

    file: ParameterFile
    firmware: Firmware
    version: str
    law: Controller
    values: dict[str, float]
    unsafe: dict[str, str]
    not_flown: tuple[str, ...]
    remarks: tuple[str, ...]


@dataclass(frozen=True)
class Exported:
    """A parameter file to be written.

    Attributes:
        text: of the file.
        written: changed values, by the names of the firmware.
        absent: gains of the law that the file lacks, by the names of the firmware.
        remarks: sentences.
    """

    text: str
    written: dict[str, float]
    absent: tuple[str, ...]
    remarks: tuple[str, ...]


def import_gains(
    path: Path,
    firmware: str = "",
    version: str = "",
    profile: int | None = None,
    law: Controller | None = None,
) -> Imported:
    """Read the gains of the law of a firmware from its parameter file.

    Args:
        path: the file.
        firmware: its name; by default detected from the text.
        version: of the firmware; by default that in the file, else that of the law.
        profile: the one to use in a Betaflight file.
        law: with the requested gains; by default that of the firmware.

    Raises:
        WorkbenchError: if it is not such a file, or has no gain of the law.
    """
    found, file = read_parameter_file(path, firmware, profile)
    law = law or load_controller(_law_in(found, file))
    if law.unscheduled not in found.laws:
        raise WorkbenchError(
            f"{path}: has parameters of {found.name}, and {law.name} is not one of its laws: leave "
            f"--controller out, or say {' or '.join(found.laws)}; `workbench gains translate` "
            "makes gains of one law from those of another"
        )
    version = version or file.version or found.version
    remarks = list(file.remarks)
    numbers = {
        name: math.nan if entry.value is None else entry.value
        for name, entry in file.counted.items()
    }
    by_law = found.to_law({name: tidy(value) for name, value in numbers.items()}, version)
    rows = {row.name: row for row in found.rows(law)}
    table = parameter_table(law)
    values, wrong = {}, {}
    for name in rows:
        if name not in by_law:
            continue
        said = unsafe(table.find(name), by_law[name])
        if said:
            wrong[name] = said
        else:
            values[name] = by_law[name]
    if not values and not wrong:
        raise WorkbenchError(
            f"{path}: sets none of the {len(rows)} gains of {law.name}, as "
            f"{joined([found.file_name(name) for name in rows], 3)}"
        )
    remarks += [*_renamed(found, numbers, version), *_beyond(found, law, values)]
    if found.steps and "begins at the defaults" in " ".join(remarks):
        values = {name: row.default for name, row in rows.items() if name not in wrong} | values
    others = tuple(
        sorted(
            name
            for name in file.counted
            if found.families.match(name)
            and not set(found.to_law({name: 0.0}, version)) & set(rows)
        )
    )
    return Imported(file, found, version, law, values, wrong, others, tuple(remarks))


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
    version = version or (present.version if present else "") or firmware.version
    table = parameter_table(law)
    gains = {row.name: values[row.name] for row in firmware.rows(law)}
    for name, value in gains.items():
        said = unsafe(table.find(name), value)
        if said:
            raise WorkbenchError(f"{firmware.file_name(name)} {said}; nothing is exported")
    remarks = (*_rounded(firmware, gains), *_beyond(firmware, law, gains))
    wanted = firmware.to_file(gains, version)
    if present is None:
        return Exported(firmware.new(wanted, version), wanted, (), remarks)
    file = present.file
    entries = file.counted
    now = firmware.to_file(present.values, version)
    changed = {
        name: value
        for name, value in wanted.items()
        if name in entries and not (name in now and _equal(firmware, now[name], value))
    }
    texts = {name: firmware.written(entries[name], value) for name, value in changed.items()}
    defaults = firmware.to_file({row.name: row.default for row in firmware.rows(law)}, version)
    absent = tuple(name for name in wanted if name not in entries)
    told = [name for name in absent if not _equal(firmware, wanted[name], defaults[name])]
    if told:
        remarks = (
            *remarks,
            f"{file.path} does not have {joined(told)}, and their values here are not the "
            "firmware's defaults: export them to a separate file, and load both",
        )
    return Exported(file.replaced(texts), changed, absent, remarks)


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


def _renamed(firmware: Firmware, values: Mapping[str, float], version: str) -> tuple[str, ...]:
    """Return remarks on names of earlier versions."""
    known = {firmware.law_name(name): value for name, value in values.items()}
    renamed = versions.with_new_names(known, firmware.renames)[1]
    scaled = [
        f"{each.old} is {each.new} times {1.0 / each.factor:g}"
        for each in renamed.values()
        if each.factor != 1.0
    ]
    said = []
    if renamed:
        since = ".".join(map(str, next(iter(renamed.values())).since))
        said.append(f"{len(renamed)} names are from before {since}: {joined(list(renamed))}")
    if scaled:
        said.append(f"some of them are scaled: {joined(scaled)}")
    if any(f"d_min_{axis}" in values for axis in versions.AXES):
        said.append("d and d_min of before 4.6 are read as d_max and d")
    return tuple(said)


def _beyond(firmware: Firmware, law: Controller, gains: Mapping[str, float]) -> tuple[str, ...]:
    """Return remarks on gains beyond the ranges stated by a firmware."""
    found = beyond(firmware.advised, firmware.rows(law), gains)
    said = f"beyond the range that {firmware.name} recommends: {joined(found)}"
    return (said,) if found else ()


def _rounded(firmware: Firmware, gains: Mapping[str, float]) -> tuple[str, ...]:
    """Return remarks on gains that a firmware stores as whole numbers."""
    if not firmware.steps:
        return ()
    lost = [
        f"{name} {value:.4g} to {round(value)}"
        for name, value in gains.items()
        if not value.is_integer()
    ]
    return (
        (f"rounded, because {firmware.name} keeps whole numbers: {joined(lost)}",) if lost else ()
    )


def _equal(firmware: Firmware, a: float, b: float) -> bool:
    return round(a) == round(b) if firmware.steps else same(a, b)
