"""The frames of a blackbox log.

A key frame (I) has whole numbers; those that follow (P) have differences to what the frames before
predict. Other frames have slow fields (S), the position of a satellite receiver (G, H), and events
(E). Behind a lost or damaged frame no prediction holds, so frames count again from the next key
frame on. A frame is intact if another one, or the end, follows it.

Source: docs/development/Blackbox of Betaflight and src/parser.c of blackbox-tools, as facts.
"""

import re
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from workbench.common.flight import LogRemark
from workbench.extras.flightdata.readers.blackbox_encoding import signed_number, unsigned_number
from workbench.extras.flightdata.readers.blackbox_headers import (
    FieldPredictor,
    FrameCoding,
    field_names,
    frame_kinds,
    header_integers,
    read_headers,
)

MIN_DAMAGED_END_BYTES = 256
"""Bytes behind the last frame from which on they are damage, and no frame that was cut."""
MAX_LOOP_JUMP = 5000
"""Largest number of control updates from a frame to the next one."""
MAX_FRAME_STEP_US = 10_000_000
"""Longest time from a frame to the next one with differences [us]."""
_FRAME_PATTERN = re.compile(rb"[IPSGHE]")
_FRAME_MARKS = frozenset(b"IPSGHE")
_COUNTER_MASK = 0xFFFFFFFF
_PADDING = b"\xff\0"
"""Bytes of an empty chip."""
_END_OF_LOG = b"End of log\0"
_UPDATE, _TIME = 0, 1
"""Places of the number of the control update and of the time [us] among the fields."""
_EVENT_SYNC_BEEP, _EVENT_ADJUSTMENT, _EVENT_RESUME, _EVENT_DISARM, _EVENT_MODE, _EVENT_END = (
    0,
    13,
    14,
    15,
    30,
    255,
)
_EVENT_NUMBERS = {_EVENT_SYNC_BEEP: 1, _EVENT_RESUME: 2, _EVENT_DISARM: 1, _EVENT_MODE: 2}
"""How many unsigned numbers follow the kind of an event."""


class BlackboxFrames(NamedTuple):
    """The frames of a log.

    Attributes:
        headers: by name, without those of the fields; numbers, texts, and lists of them.
        fields: values (n) by name; NaN where a frame lacks them. Slow fields and positions are
            those of the last frame with them.
        damage: what is wrong with the log, "" if nothing.
    """

    headers: Mapping[str, object]
    fields: Mapping[str, np.ndarray]
    damage: str


@dataclass(eq=False)
class _FrameReader:
    """The state of reading the frames of a log.

    Attributes:
        data: of the log.
        kinds: of frames, by their marks.
        names: of fields, by the marks of their frames.
        at: place in the data.
        previous: fields of the two frames before, the last one first; None behind damage.
        update: number of the control update of the last frame, None before the first one.
        rejected: likewise of a key frame that does not fit those before it.
        time: of the last frame [us].
        home: position of the home, none until it is known.
        slow: the last fields of slow frames.
        position: likewise of positions.
        rows: all fields of all frames.
        count: of frames.
        damaged: numbers of intact frames before the damaged places.
        ended: whether the mark of the end was read.
        intact_end: place behind the last intact frame.
    """

    data: bytes
    kinds: Mapping[str, FrameCoding]
    names: Mapping[str, Sequence[str]]
    at: int
    previous: tuple[list[float], list[float]] | None = None
    update: int | None = None
    rejected: int | None = None
    time: int = 0
    home: list[float] = field(default_factory=list)
    slow: list[float] = field(default_factory=list)
    position: list[float] = field(default_factory=list)
    rows: array = field(default_factory=lambda: array("d"))
    count: int = 0
    damaged: list[int] = field(default_factory=list)
    ended: bool = False
    intact_end: int = 0

    def read(self, most: int) -> None:
        """Read frames up to the end of the log, or the largest number of them."""
        data, size = self.data, len(self.data)
        while self.count < most and not self.ended:
            found = _FRAME_PATTERN.search(data, self.at)
            if found is None:
                return
            begin = found.start()
            mark = chr(data[begin])
            self.at = begin + 1
            try:
                values = self._event() if mark == "E" else self._values(mark)
            except IndexError:
                values = None
            end = self.at
            intact = end == size or end < size and data[end] in _FRAME_MARKS
            if self.ended:
                return
            if values is None or not intact:
                self.at = begin + 1
                self._lose_track()
            else:
                self._complete(mark, values)

    def _values(self, mark: str) -> list[float] | None:
        """Return the fields of a frame, None if its kind is not defined."""
        kind = self.kinds.get(mark)
        if kind is None:
            return None
        data, at = self.data, self.at
        values: list[float] = []
        for decode in kind.decoders:
            several, at = decode(data, at)
            values += several
        self.at = at
        for place, offset in kind.offsets:
            values[place] += offset
        last, before = self.previous or ((0,) * len(values), (0,) * len(values))
        if self.previous is None and mark == "P":
            return values
        home = iter(self.home)
        for place, predictor in kind.predictors:
            if predictor == FieldPredictor.PREVIOUS:
                values[place] += last[place]
            elif predictor == FieldPredictor.STRAIGHT_LINE:
                values[place] += 2 * last[place] - before[place]
            elif predictor == FieldPredictor.AVERAGE_2:
                values[place] += int((last[place] + before[place]) / 2)
            elif predictor == FieldPredictor.INCREMENT:
                values[place] = last[place] + 1
            elif predictor == FieldPredictor.MOTOR_0:
                values[place] += values[self.names[mark].index("motor[0]")]
            elif predictor == FieldPredictor.MAIN_TIME:
                values[place] += self.time
            else:
                values[place] += next(home, float("nan"))
        return values

    def _complete(self, mark: str, values: list[float]) -> None:
        """Use the fields of an intact frame, or the numbers of an event."""
        self.intact_end = self.at
        if mark == "S":
            self.slow = values
        elif mark == "G":
            self.position = values
        elif mark == "H":
            self.home = values
        elif mark in "IP":
            self._complete_main(mark, values)
        elif values:
            self.update, self.time = map(int, values)

    def _complete_main(self, mark: str, values: list[float]) -> None:
        """Use the fields of a key frame, or of one with differences."""
        if mark == "P" and self.previous is None:
            return
        update, time = (int(values[place]) & _COUNTER_MASK for place in (_UPDATE, _TIME))
        if mark == "P":
            if (time - self.time) & _COUNTER_MASK > MAX_FRAME_STEP_US:
                self._lose_track()
                return
        elif self.update is not None and not (
            self._follows(update, self.update) or self._follows(update, self.rejected)
        ):
            self.rejected = update
            self._lose_track()
            return
        values[_UPDATE], values[_TIME] = update, time
        self.previous = (values, self.previous[0] if mark == "P" and self.previous else values)
        self.update, self.rejected, self.time = update, None, time
        self.rows.extend(values)
        self.rows.extend(self.slow or self._unknown("S"))
        self.rows.extend(self.position or self._unknown("G"))
        self.count += 1

    def _lose_track(self) -> None:
        """Wait for the next key frame, and note the place once."""
        self.previous = None
        if not self.damaged or self.damaged[-1] != self.count:
            self.damaged.append(self.count)

    def _follows(self, update: int, before: int | None) -> bool:
        """Return whether a key frame may follow another one."""
        return before is not None and 0 <= update - before < MAX_LOOP_JUMP

    def _unknown(self, mark: str) -> list[float]:
        return [float("nan")] * len(self.names[mark])

    def _event(self) -> list[float] | None:
        """Return the numbers of the event of a pause, none of others, None if it is not known."""
        kind = self.data[self.at]
        self.at += 1
        if kind == _EVENT_END:
            self.ended = self.data.startswith(_END_OF_LOG, self.at)
            return None
        if kind == _EVENT_ADJUSTMENT:
            function = self.data[self.at]
            self.at = self.at + 5 if function > 127 else signed_number(self.data, self.at + 1)[1]
            return []
        if kind not in _EVENT_NUMBERS:
            return None
        numbers: list[float] = []
        for _ in range(_EVENT_NUMBERS[kind]):
            number, self.at = unsigned_number(self.data, self.at)
            numbers.append(number)
        return numbers if kind == _EVENT_RESUME else []

    def damage(self) -> str:
        """Return what is wrong with the log, "" if nothing."""
        damaged = [count for count in self.damaged if count < self.count]
        if damaged:
            place = f"frame {damaged[0]}"
            text = (
                f"the log is damaged at {len(damaged)} places, the first one behind {place}: "
                "frames were left out there, up to the next key frame"
            )
            return LogRemark(text, len(damaged), place)
        rest = 0 if self.ended else len(self.data[self.intact_end :].strip(_PADDING))
        if self.damaged and rest > MIN_DAMAGED_END_BYTES:
            place = f"frame {self.count}"
            text = f"the log is damaged, and was read up to {place}"
            return LogRemark(text, self.count, place)
        return ""


def read_frames(data: bytes, most: int) -> BlackboxFrames:
    """Return the frames of a log, as far as they are intact.

    Args:
        data: of the log, see `split_logs`.
        most: largest number of frames.

    Raises:
        ValueError: if the headers do not tell how the frames are written.
    """
    headers, begin = read_headers(data)
    names = field_names(headers)
    reader = _FrameReader(data, frame_kinds(headers, names), names, begin)
    reader.read(most)
    signed = dict(zip(names["I"], header_integers(headers, "Field I signed"), strict=False))
    fields: dict[str, np.ndarray] = {}
    every = [*names["I"], *names["S"], *names["G"]]
    columns = np.frombuffer(reader.rows).reshape(reader.count, len(every)).T
    for place, (name, values) in enumerate(zip(every, columns, strict=True)):
        if place < len(names["I"]):
            half = 2.0**31 if place not in (_UPDATE, _TIME) and signed.get(name, 1) else 0.0
            fields[name] = (values + half) % 2.0**32 - half
        else:
            fields.setdefault(name, values)
    damage = reader.damage()
    if reader.count >= most:
        damage = f"only the first {most} frames of the log were read"
    others = {name: each for name, each in headers.items() if not name.startswith("Field ")}
    return BlackboxFrames(others, fields, damage)
