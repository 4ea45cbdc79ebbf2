"""One topic of a flight as columns of numbers over time."""

from collections.abc import Sequence

import numpy as np

from workbench.gui.ring import Ring
from workbench.link.topics import CODES, PREFIX, Topic

WIDEST = 64
"""Numbers of a topic that are kept over time; of one with more, a point cloud, the newest."""
SLOWEST = 10.0
"""Rate that is taken for a topic that comes when something happens [1/s]."""


class TopicTable:
    """Samples of one topic: numbers over time, texts left out.

    Args:
        topic: what it carries.
        seconds: that are kept.

    Attributes:
        topic: what it carries.
        units: of each column, by its name: TOPIC.FIELD, or TOPIC.FIELD.INDEX of several numbers.
        newest: payload of the newest sample, b"" before the first.
    """

    def __init__(self, topic: Topic, seconds: float) -> None:
        self.topic = topic
        self.newest = b""
        numeric = [each for each in topic.fields if each.type in CODES]
        columns = sum(each.count for each in numeric)
        self.units: dict[str, str] = {}
        self._type = np.dtype(
            {
                "names": [each.name for each in numeric],
                "formats": [(f"<{CODES[each.type]}", (each.count,)) for each in numeric],
                "offsets": [_offset(topic, each.name) for each in numeric],
                "itemsize": topic.packer.size,
            }
        )
        self._ring = Ring(0, 1)
        if 0 < columns <= WIDEST:
            short = topic.name.removeprefix(PREFIX)
            for each in numeric:
                parts = [""] if each.count == 1 else [f".{index}" for index in range(each.count)]
                self.units.update({f"{short}.{each.name}{part}": each.unit for part in parts})
            self._ring = Ring(round(seconds * (topic.rate or SLOWEST)), 1 + columns)
        self._columns = {name: 1 + index for index, name in enumerate(self.units)}

    def append(self, times: Sequence[float], payloads: Sequence[bytes]) -> None:
        """Append samples at times [s], in their order."""
        self.newest = payloads[-1]
        if not self._columns:
            return
        table = np.frombuffer(b"".join(payloads), self._type)
        parts = [table[name].reshape(len(table), -1) for name in self._type.names or ()]
        self._ring.append(np.hstack([np.array(times)[:, None], *parts]))

    def series(self, name: str, since: float) -> tuple[np.ndarray, np.ndarray]:
        """Return times and values of a column (N) [s], from a time on: views, to be drawn now."""
        rows = self._ring.rows(since)
        return rows[:, 0], rows[:, self._columns[name]]


def _offset(topic: Topic, name: str) -> int:
    """Return where a field begins in a payload [bytes]."""
    before = 0
    for each in topic.fields:
        if each.name == name:
            break
        before += each.size
    return before
