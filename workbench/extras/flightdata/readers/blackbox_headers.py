"""The headers of a blackbox log, and what they say of its frames.

Source: docs/development/Blackbox of Betaflight and src/parser.c of blackbox-tools, as facts.
"""

import re
from collections.abc import Mapping, Sequence
from enum import IntEnum
from itertools import pairwise
from typing import NamedTuple

from workbench.extras.flightdata.readers.blackbox_encoding import Decoder, field_decoders

MAX_BLACKBOX_FIELDS = 256
MAX_HEADER_BYTES = 10_000
"""Largest number of bytes of a header; Betaflight's are far shorter."""
MAX_HEADER_NUMBER = 1 << 64
"""Number of a header from which on it is a text; one of 400 digits is no float."""
_LOG_BEGIN_PATTERN = re.compile(rb"H Product:Blackbox flight data recorder[^\n]*\n")
_REFERENCES = {4: "minthrottle", 9: "vbatref", 11: "motorOutput"}
"""Predictors that are the first number of a header, 0 without it."""
_MIDDLE_PREDICTOR, _MIDDLE_US = 8, 1500
_PID_AXES = ("roll", "pitch", "yaw")
_PARAMETERS_BY_HEADER = {
    **{f"{axis}PID": tuple(f"{term}_{axis}" for term in "pid") for axis in _PID_AXES},
    **{f"d_{kind}": tuple(f"d_{kind}_{axis}" for axis in _PID_AXES) for kind in ("min", "max")},
    **dict.fromkeys(("feedforward_weight", "ff_weight"), tuple(f"f_{axis}" for axis in _PID_AXES)),
    **{
        f"{kind}_lpf1_dyn_hz": (f"{kind}_lpf1_dyn_min_hz", f"{kind}_lpf1_dyn_max_hz")
        for kind in ("dterm", "gyro")
    },
    **{
        f"{kind}_lowpass_dyn_hz": (f"dyn_lpf_{kind}_min_hz", f"dyn_lpf_{kind}_max_hz")
        for kind in ("dterm", "gyro")
    },
    "levelPID": ("angle_level_strength",),
    "dterm_filter_type": ("dterm_lowpass_type",),
    "dterm_filter2_type": ("dterm_lowpass2_type",),
    "d_min_gain": ("d_min_boost_gain",),
}
"""Parameters in the headers of Betaflight 4.2 and later that have another name there."""


class FieldPredictor(IntEnum):
    """What the number of a field is a difference to, by the numbers of the format."""

    PREVIOUS = 1
    STRAIGHT_LINE = 2
    AVERAGE_2 = 3
    MOTOR_0 = 5
    INCREMENT = 6
    HOME = 7
    MAIN_TIME = 10


class FrameCoding(NamedTuple):
    """How the frames of a kind are decoded.

    Attributes:
        decoders: of the fields, in order.
        predictors: place of the field and its predictor, for those whose prediction is not fixed.
        offsets: place of the field and its fixed prediction.
    """

    decoders: Sequence[Decoder]
    predictors: Sequence[tuple[int, FieldPredictor]]
    offsets: Sequence[tuple[int, int]]


def split_logs(data: bytes) -> list[bytes]:
    """Return the logs of a file."""
    places = [found.start() for found in _LOG_BEGIN_PATTERN.finditer(data)]
    return [data[a:b] for a, b in pairwise([*places, len(data)])]


def read_headers(data: bytes) -> tuple[dict[str, object], int]:
    """Return the headers of a log by name, and the place of its first frame.

    Raises:
        ValueError: if one is too long.
    """
    headers: dict[str, object] = {}
    at = 0
    while data.startswith(b"H ", at):
        end = data.find(b"\n", at, at + MAX_HEADER_BYTES)
        if end < 0:
            if len(data) - at < MAX_HEADER_BYTES:
                break  # a frame, or the log was cut
            raise ValueError(f"it has a header of more than {MAX_HEADER_BYTES // 1000} kB")
        name, colon, value = data[at + 2 : end].decode(errors="replace").partition(":")
        if colon:
            several = [_number_or_text(each.strip()) for each in value.split(",")]
            headers[name.strip()] = several if len(several) > 1 else several[0]
        at = end + 1
    return headers, at


def _number_or_text(text: str) -> float | str:
    """Return a number if it is one below the limit, hexadecimal behind 0x."""
    try:
        number: float = int(text, 16 if text.startswith("0x") else 10)
    except ValueError:
        try:
            number = float(text)
        except ValueError:
            return text
    return number if abs(number) < MAX_HEADER_NUMBER else text


def parameters_in(headers: Mapping[str, object]) -> dict[str, float]:
    """Return the parameters of the firmware in headers, by the names of its command line."""
    found: dict[str, float] = {}
    for header, value in headers.items():
        names = _PARAMETERS_BY_HEADER.get(header, (header,))
        values = value if isinstance(value, list) else [value]
        if len(values) >= len(names) and (len(values) == 1 or header in _PARAMETERS_BY_HEADER):
            pairs = zip(names, values, strict=False)
            found |= {name: float(each) for name, each in pairs if isinstance(each, int | float)}
    if "angle_level_strength" in found:  # its name since 4.5
        found.setdefault("angle_p_gain", found["angle_level_strength"])
    return found


def header_integers(headers: Mapping[str, object], name: str) -> list[int]:
    """Return the whole numbers of a header, none if there is no such header.

    Raises:
        ValueError: if it has something else.
    """
    value = headers.get(name, [])
    several = value if isinstance(value, list) else [value]
    if not all(isinstance(each, int) for each in several):
        raise ValueError(f"the header {name} has something else than whole numbers")
    return several


def _names(headers: Mapping[str, object], mark: str) -> list[str]:
    """Return the names of the fields of a kind of frame."""
    value = headers.get(f"Field {mark} name", [])
    return [str(each) for each in (value if isinstance(value, list) else [value])]


def _frame_kind(headers: Mapping[str, object], kind: str, names: Sequence[str]) -> FrameCoding:
    """Return how a kind of frame is decoded.

    Raises:
        ValueError: if its headers do not fit each other, or have what is not known.
    """
    encodings = header_integers(headers, f"Field {kind} encoding")
    predictors = header_integers(headers, f"Field {kind} predictor")
    if not len(names) == len(encodings) == len(predictors):
        raise ValueError(f"the headers of the frames {kind} have different numbers of fields")
    changing, fixed = [], []
    for place, number in enumerate(predictors):
        if number in _REFERENCES:
            reference = header_integers(headers, _REFERENCES[number])
            fixed.append((place, reference[0] if reference else 0))
        elif number == _MIDDLE_PREDICTOR:
            fixed.append((place, _MIDDLE_US))
        elif number in tuple(FieldPredictor) and (
            number != FieldPredictor.MOTOR_0 or "motor[0]" in names
        ):
            changing.append((place, FieldPredictor(number)))
        elif number:
            raise ValueError(f"the predictor {number} of a field is not known")
    version = next(iter(header_integers(headers, "Data version")), 1)
    return FrameCoding(field_decoders(encodings, version), changing, fixed)


def field_names(headers: Mapping[str, object]) -> dict[str, list[str]]:
    """Return the names of the fields of frames, by the marks of the frames.

    Raises:
        ValueError: if there are none, or too many.
    """
    names = {mark: _names(headers, mark) for mark in "IGHS"}
    if len(names["I"]) < 2:
        raise ValueError("its headers do not name the fields of its frames")
    if sum(map(len, names.values())) > MAX_BLACKBOX_FIELDS:
        raise ValueError(f"its headers name more than {MAX_BLACKBOX_FIELDS} fields")
    return names | {"P": names["I"]}


def frame_kinds(
    headers: Mapping[str, object], names: Mapping[str, Sequence[str]]
) -> dict[str, FrameCoding]:
    """Return how frames are decoded, by their marks.

    Args:
        headers: of the log.
        names: of the fields, see `field_names`.

    Raises:
        ValueError: if the headers do not fit each other, or have what is not known.
    """
    return {
        mark: _frame_kind(headers, mark, fields)
        for mark, fields in names.items()
        if f"Field {mark} encoding" in headers
    }
