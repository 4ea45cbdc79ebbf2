"""Read Betaflight's blackbox logs: one of the logs in a file.

Roll to the right, nose down and counter-clockwise from above are positive, as in forward, left, up.
Motors are M1 rear right, M2 front right, M3 rear left, M4 front left. What a number means depends
on header and version:

- `gyro_scale` has the bits of a float: degrees per second of a count of the gyro, 1 since 3.1.
  Firmware before Betaflight states radians per microsecond.
- `blackbox_high_resolution` (since 4.4) multiplies gyro, rate setpoints and stick commands by 10.
- The voltage is in steps of 0.01 V since 4.0, of 0.1 V since 3.1, and the reading of a 12-bit
  converter before, whose scale is `vbatscale`. The current is in 0.01 A since 3.1, and a reading
  before, with offset and scale in `currentMeter`.
- `motorOutput` (before 3.1 `minthrottle` and `maxthrottle`) has the range of the motors.

What a header does not determine keeps the log's name, and a remark states it.

Source: github.com/betaflight/blackbox-log-viewer, and blackbox.c, battery.c and voltage.h of
Betaflight 2.9 to 2026.6, as facts.
"""

import re
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.extras.flightdata.readers.blackbox_frames import BlackboxFrames, read_frames
from workbench.extras.flightdata.readers.blackbox_headers import parameters_in, split_logs
from workbench.extras.flightdata.readers.blackbox_signals import (
    BLACKBOX_TOPIC,
    blackbox_signals,
)
from workbench.extras.flightdata.readers.several_logs import one_of_logs
from workbench.extras.flightdata.readers.topic_log import (
    MessageTable,
    parameter_number,
    topic_record,
)
from workbench.logs.readers.log_reader import LogReader, begins_with

BLACKBOX_FORMAT = "Betaflight blackbox log"
BLACKBOX_MAGIC = b"H Product:Blackbox flight data recorder"
MAX_BLACKBOX_FRAMES = 5_000_000
"""Largest number of frames of all logs in a file."""
HIGH_RESOLUTION_FACTOR = 10.0
HIGH_RESOLUTION_PATTERN = re.compile(r"(gyroADC|gyroUnfilt|rcCommand)\[\d\]|setpoint\[[012]\]")
"""Fields that `blackbox_high_resolution` multiplies."""


def read_blackbox(path: Path, number: int | None = None) -> Flight:
    """Read a log of Betaflight.

    Args:
        path: the file.
        number: of the log in it, from 1; None for the longest one.

    Raises:
        WorkbenchError: if it cannot be read, is not such a log, or has no log of that number.
    """
    logs = split_logs(path.read_bytes())
    left = MAX_BLACKBOX_FRAMES

    def read(each: int) -> Flight:
        nonlocal left
        try:
            found = read_frames(logs[each - 1], left)
        except ValueError as error:
            raise WorkbenchError(f"{path}: cannot be read as a blackbox log: {error}") from error
        left -= len(found.fields.get("time", ()))
        return _record_of_frames(path, found)

    return one_of_logs(path, len(logs), number, read, "frames")


def _record_of_frames(path: Path, found: BlackboxFrames) -> Flight:
    """Return the flight of the frames of a log."""
    headers = found.headers
    fields = dict(found.fields)
    if len(fields.get("time", ())) < 2:
        raise WorkbenchError(f"{path}: has fewer than two frames: it is empty or damaged")
    microseconds = fields.pop("time")
    fields.pop("loopIteration", None)
    if parameter_number(headers, "blackbox_high_resolution") > 0.0:
        fields = {
            name: values / HIGH_RESOLUTION_FACTOR
            if HIGH_RESOLUTION_PATTERN.fullmatch(name)
            else values
            for name, values in fields.items()
        }
    rows, remarks = blackbox_signals(headers, fields)
    filtered = any(name.startswith("gyroADC") for name in fields)
    return topic_record(
        path,
        BLACKBOX_FORMAT,
        {BLACKBOX_TOPIC: MessageTable(microseconds, fields)},
        rows,
        tick=1e-6,
        counter=True,
        noun="frame",
        firmware=str(headers.get("Firmware revision", headers.get("Firmware type", ""))),
        parameters={
            str(name): value if isinstance(value, int | float) else str(value)
            for name, value in headers.items()
        }
        | parameters_in(headers),
        remarks=(
            found.damage,
            "imu.angular_velocity is behind Betaflight's gyro filters" if filtered else "",
            *remarks,
        ),
    )


LOG_READER = LogReader(
    BLACKBOX_FORMAT,
    "Betaflight's .bbl or .bfl",
    lambda _, head: begins_with(head, BLACKBOX_MAGIC),
    lambda file: read_blackbox(file.path, file.number),
    place=30,
    endings=(".bbl", ".bfl"),
    needs_plain=True,
    has_several=True,
    firmware="betaflight",
)
