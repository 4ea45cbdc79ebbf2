"""Gains in the files of autopilots: what a format does, and the formats of installed packages.

A format is for the files of one firmware. It is an entry of `workbench.gain_formats`, and its name
is that of the entry; see docs/extending.md.
"""

import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.extensions import (
    ExtensionGroup,
    complete_extensions,
    find_extensions,
    load_extension,
)
from workbench.common.parameter import Parameter
from workbench.control.controller import COMMON_PARAMETERS, Controller
from workbench.control.installed_laws import SHIPPED_CONTROLLERS
from workbench.gains.parameter_line import ParameterFileRemark, ParameterLine, UnusedParameter
from workbench.plant.vehicle import Vehicle

VERSION_ROW = "firmware"
"""Parameter of a law that computes as the version of this number."""


@dataclass(frozen=True, kw_only=True)
class ImportedGains:
    """Gains of a law from the file of an autopilot.

    Attributes:
        firmware: the format of the file.
        law: with these gains.
        values: what the file sets, by the names and in the units of the law.
        version: of the firmware, as stated, else as assumed.
        read_as: version whose names and scales are assumed.
        defaults: values that the file does not set, and its version has by default.
        unsafe: why a value must not fly, a clause by its name in the law.
        left: parameters of flight control in the file that the law does not have.
        standing: such parameters that are on by default in the version, and not in the file.
        lines: of the file, and what becomes of each.
        remarks: on the file.
    """

    firmware: "GainFormat"
    law: Controller
    values: dict[str, float]
    version: str = ""
    read_as: str = ""
    defaults: dict[str, float] = field(default_factory=dict)
    unsafe: dict[str, str] = field(default_factory=dict)
    left: tuple[UnusedParameter, ...] = ()
    standing: tuple[UnusedParameter, ...] = ()
    lines: tuple[ParameterLine, ...] = ()
    remarks: tuple[ParameterFileRemark, ...] = ()

    @property
    def source(self) -> str:
        """Name and version of the firmware."""
        return f"{self.firmware.name} {self.version}".rstrip()

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

    def remarks_on(self, vehicle: Vehicle) -> tuple[ParameterFileRemark, ...]:
        """Return remarks on what in the file does not fit a vehicle."""
        return ()


@dataclass(frozen=True, kw_only=True)
class ExportedGains:
    """A file of an autopilot to be written.

    Attributes:
        text: of the file; bytes that are not UTF-8 are surrogates.
        version: of the firmware that it is for.
        defaults: values of that version by the names and in the units of the law.
        written: changed values, by the names of the firmware.
        absent: gains of the law that the file lacks, by the names of the firmware.
        grounded: why the file would not fly, sentences; empty if it would.
        remarks: on the file.
    """

    text: str
    version: str = ""
    defaults: dict[str, float] = field(default_factory=dict)
    written: dict[str, float] = field(default_factory=dict)
    absent: tuple[str, ...] = ()
    grounded: tuple[str, ...] = ()
    remarks: tuple[ParameterFileRemark, ...] = ()

    @property
    def data(self) -> bytes:
        """The bytes of the file."""
        return self.text.encode("utf-8", "surrogateescape")

    @property
    def refusal(self) -> str:
        """Why it must not be written unless the user insists, a clause; "" if it may."""
        if not self.grounded:
            return ""
        return f"would not fly: {joined_names(self.grounded, 6)}; nothing is written"


@dataclass(frozen=True)
class GainFormat:
    """Reads and writes the gains of laws in the files of a firmware; a package derives from it.

    Attributes:
        name: as in `--for px4`.
        laws: controllers of this firmware, the usual one first.
        suffixes: of the names of its files, as `.params`.
    """

    name: str
    laws: tuple[str, ...]
    suffixes: tuple[str, ...] = ()

    def has(self, name: str) -> bool:
        """Return whether the firmware has a parameter of a law, not only the workbench."""
        return name not in [row.name for row in COMMON_PARAMETERS]

    def wrote(self, writer: str) -> bool:
        """Return whether a log was written by the firmware, from the name that the log states."""
        return writer.casefold().startswith(self.name)

    def file_name(self, name: str) -> str:
        """Return the name of a parameter of the law in the firmware."""
        return name

    def rows(self, law: Controller) -> tuple[Parameter, ...]:
        """Return the parameters of a law that the firmware has."""
        return tuple(row for row in law.parameters if self.has(row.name))

    def count_lines(self, path: Path) -> int:
        """Return how many lines of a file are as in this format, 0 if it is of another one.

        Raises:
            WorkbenchError: if the file is of no firmware with a law, or cannot be read.
        """
        raise NotImplementedError

    def read(
        self,
        path: Path,
        version: str,
        profile: int | None,
        law: Controller | None,
        *,
        named: bool,
    ) -> ImportedGains:
        """Read the gains in a file.

        Args:
            path: the file.
            version: of the firmware, "" to find it in the file.
            profile: the one to use, if a file has several; None for that in use.
            law: with the requested gains; None for that of the file.
            named: whether the user has named the format; else `count_lines` chose it.

        Raises:
            WorkbenchError: if it is not such a file, or has no gain of the law.
        """
        raise NotImplementedError

    def read_log(
        self,
        path: Path,
        writer: str,
        values: Mapping[str, float],
        version: str,
        law: Controller | None,
    ) -> ImportedGains:
        """Return the gains among the parameters in a log of the firmware.

        Args:
            path: the log.
            writer: what the log says that it was written by, name and version.
            values: the parameters, by the names of the firmware.
            version: of the firmware, "" if not known.
            law: with the requested gains; None for that of the firmware.

        Raises:
            WorkbenchError: if the log is of another kind of vehicle, or has no gain of the law.
        """
        raise NotImplementedError

    def write(
        self,
        values: Mapping[str, float],
        law: Controller,
        version: str,
        present: ImportedGains | None,
    ) -> ExportedGains:
        """Return a file with the gains of a law.

        Args:
            values: by the names of the law, at least all that the firmware has.
            law: with the gains.
            version: of the firmware, "" for that of the existing file, else that of the law.
            present: an existing file, in which only gains change; None for a new one.

        Raises:
            WorkbenchError: if the law is not one of the firmware, or a value must not fly.
        """
        raise NotImplementedError


@cache
def gain_format_names() -> tuple[str, ...]:
    """Return the names of the formats of all installed packages; nothing of them is imported."""
    return complete_extensions(ExtensionGroup.GAIN_FORMATS)


@cache
def gain_formats() -> tuple[GainFormat, ...]:
    """Return the formats of all installed packages."""
    return tuple(map(find_firmware, gain_format_names()))


def find_firmware(name: str) -> GainFormat:
    """Return the format of the files of a firmware, by its name.

    Raises:
        WorkbenchError: if there is none, or its package cannot be imported.
    """
    known = find_extensions(ExtensionGroup.GAIN_FORMATS)
    if name not in known:
        raise unknown_name("firmware", name, known)
    found: GainFormat = load_extension(ExtensionGroup.GAIN_FORMATS, name)
    return found


def firmware_of(law: Controller) -> GainFormat | None:
    """Return the format of the firmware of a controller; None if it is not a firmware's."""
    if law.unscheduled in SHIPPED_CONTROLLERS:
        return None
    return next((each for each in gain_formats() if law.unscheduled in each.laws), None)


def recognised_format(path: Path) -> GainFormat:
    """Return the format of a file, by its lines.

    Raises:
        WorkbenchError: if none has such lines, or it cannot be read.
    """
    found, most, refusal = None, 0, None
    for each in gain_formats() or map(find_firmware, find_extensions(ExtensionGroup.GAIN_FORMATS)):
        try:
            count = each.count_lines(path)
        except WorkbenchError as error:
            refusal = refusal or error
            continue
        if count > most:
            found, most = each, count
    if found is None:
        known = ", ".join(gain_format_names()) or "none: install a package that has some"
        raise refusal or WorkbenchError(
            f"{path}: is not a file of an autopilot's parameters; known formats are {known}"
        )
    return found


def import_gains(
    path: Path | str,
    firmware: str = "",
    version: str = "",
    profile: int | None = None,
    law: Controller | None = None,
) -> ImportedGains:
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
    path = Path(path)
    chosen = find_firmware(firmware) if firmware else recognised_format(path)
    return chosen.read(path, version, profile, law, named=bool(firmware))


def export_gains(
    values: Mapping[str, float],
    law: Controller,
    firmware: GainFormat,
    version: str = "",
    present: ImportedGains | None = None,
) -> ExportedGains:
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
    return firmware.write(values, law, version, present)


def unsafe_reason(row: Parameter, value: float | None) -> str:
    """Return why a value must not fly, as a clause, else ""."""
    if value is None or math.isnan(value):
        return "is not a number"
    if math.isinf(value):
        return "is infinite"
    if value < 0.0 <= row.minimum:
        return "is negative: this would reverse the sign of its part of the loop"
    if not row.minimum <= value <= row.maximum:
        unit = "" if row.unit == "1" else f" {row.unit}"
        return f"is out of range: keep it within {row.minimum:g} .. {row.maximum:g}{unit}"
    if row.whole and not value.is_integer():
        return "is not a whole number"
    return ""


def joined_names(names: Sequence[str], most: int = 8) -> str:
    """Return some names, and the number of others."""
    more = f" and {len(names) - most} others" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def single(value: float) -> float:
    """Return a number in single precision; one that is too large is infinite."""
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def same_in_single(a: float, b: float) -> bool:
    """Return whether two numbers are equal in the single precision of a firmware."""
    return a == b or single(a) == single(b)
