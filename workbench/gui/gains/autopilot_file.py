"""The file of an autopilot's own parameters: read for the flying law, compared, and written."""

from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.control.controller import Controller
from workbench.gains.formats import (
    export_gains,
    firmware_of,
    gain_formats,
    import_gains,
    same_in_single,
)
from workbench.gains.gain_change import diff_gains
from workbench.gains.gains import GainFile
from workbench.gui.gains.gain_file_diff import GainFileDiff, GainFileValues


def load_autopilot_gains(path: Path, law: Controller, present: GainFileValues) -> GainFile:
    """Return the gains of an autopilot's file for the flying law; unsafe ones are left out.

    Raises:
        WorkbenchError: if it is not such a file, or belongs to another law.
    """
    found = import_gains(path)
    if law.unscheduled not in found.firmware.laws:
        raise WorkbenchError(
            f"{path.name} has gains of {found.firmware.name}, and {law.name} flies: choose File > "
            f"Controller > {found.law.name} first"
        )
    found = import_gains(path, found.firmware.name, law=law)
    file = found.firmware.file_name
    unsafe = [f"{file(name)} {why} and is left out" for name, why in found.unsafe.items()]
    left = [str(each) for each in found.left if each.acts]
    lacking = [f"not simulated: {', '.join(left)}"] if left else []
    said = [found.source, *unsafe, *lacking, *map(str, found.remarks)]
    return GainFile("", "; ".join(said), found.flown(present), controller=law.name)


def compare_autopilot_file(path: Path, law: Controller, flown: GainFileValues) -> GainFileDiff:
    """Return how an autopilot's file would change with the flown gains.

    Raises:
        WorkbenchError: if the flying law is not an autopilot's, or the file belongs to another one.
    """
    firmware = firmware_of(law)
    if firmware is None:
        laws = ", ".join(name for each in gain_formats() for name in each.laws)
        raise WorkbenchError(
            f"{law.name} is not an autopilot's law: `workbench gains export FILE --for px4 "
            f"--controller {law.unscheduled}` translates its gains; export from {laws}"
        )
    present = import_gains(path, firmware.name, law=law) if path.exists() else None
    made = export_gains(flown, law, firmware, present=present)
    own = made.defaults
    has = {row.name: own.get(row.name, row.default) for row in firmware.rows(law)}
    if present:
        has = {name: value for name, value in present.values.items() if firmware.has(name)}
    values = {name: flown[name] for name in has}
    changes = tuple(
        each for each in diff_gains(has, values, flown, law) if not same_in_single(each.a, each.b)
    )
    said = [f"what {firmware.name} {'has there' if present else 'has by default'}, and what flies"]
    grounded = [f"would not fly: {each}" for each in made.grounded]
    origin = "; ".join([*said, *grounded, *map(str, made.remarks)])
    return GainFileDiff(path.name, origin, flown, changes, path)


def write_autopilot_file(path: Path, law: Controller, values: GainFileValues, insists: bool) -> str:
    """Write gains to an autopilot's file; return why not, if they would not fly."""
    firmware = firmware_of(law)
    assert firmware is not None
    present = import_gains(path, firmware.name, law=law) if path.exists() else None
    made = export_gains(values, law, firmware, present=present)
    if made.refusal and not insists:
        return made.refusal
    write_atomically(path, made.data)
    return ""
