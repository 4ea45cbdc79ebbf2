"""Write MCAP files: messages in chunks, each written as soon as it is full."""

import os
from collections import Counter
from pathlib import Path

from mcap.well_known import Profile
from mcap.writer import Writer

from workbench.common.plain_files import open_file_size

MCAP_CHUNK_BYTES = 128 * 1024
"""Bytes of messages in a chunk, before it is compressed."""


class McapWriter(Writer):
    """An MCAP file that grows, in the profile of ROS 2.

    Args:
        path: the file; an existing one is overwritten.
        library: name of the writer, for the header of the file.

    Raises:
        OSError: from any method, if the file cannot be written.
    """

    def __init__(self, path: Path, library: str) -> None:
        self._path = path
        self._records = _Records(path)
        self._counts: Counter[int] = Counter()
        super().__init__(self._records, MCAP_CHUNK_BYTES)
        try:
            self.start(Profile.ROS2, library)
        except BaseException:
            self.discard()
            raise

    def discard(self) -> None:
        """Close and remove the file."""
        self._records.file.close()
        self._path.unlink(missing_ok=True)

    def is_in_place(self) -> bool:
        """Return whether the path still refers to the file."""
        try:
            there = self._path.stat()
        except (FileNotFoundError, NotADirectoryError):
            return False
        except OSError:  # unknown, and writing continues
            return True
        mine = os.fstat(self._records.file.fileno())
        return (there.st_dev, there.st_ino) == (mine.st_dev, mine.st_ino)

    def check_size(self) -> None:
        """Check that the file is as long as what was written to it.

        Raises:
            OSError: if another program shortened or extended it.
        """
        self._records.check_size()

    def message(self, channel: int, t_ns: int, wall_ns: int, data: bytes) -> None:
        """Add a message of a simulated time [ns], published at a wall time [ns since 1970]."""
        count = self._counts[channel]
        self._counts[channel] = count + 1
        self.add_message(channel, t_ns, data, wall_ns, count & 0xFFFFFFFF)

    def finish(self) -> None:
        """Write the messages since the last chunk and the summary, and close the file."""
        super().finish()
        self._records.file.close()

    def give_up(self) -> None:
        """Close the file with its complete records.

        Raises:
            OSError: if the incomplete rest cannot be cut off.
        """
        file = self._records.file
        try:  # a file that another program shortened is not filled up with zeros
            file.truncate(min(self._records.tell(), open_file_size(file)))
        finally:
            self._records.file.close()


class _Records:
    """A file that takes whole records, and knows how many bytes of them it has."""

    def __init__(self, path: Path) -> None:
        self.file = path.open("wb", buffering=0)
        self._at = 0

    def tell(self) -> int:
        return self._at

    def check_size(self) -> None:
        if open_file_size(self.file) != self._at:
            raise OSError("another program has shortened or overwritten the file")

    def write(self, data: bytes) -> None:
        """Write records to the system; only then they count.

        Behind the end of a shortened file they would follow a gap of zeros, which no reader passes.
        """
        self.check_size()
        rest = memoryview(data)
        while rest:
            rest = rest[self.file.write(rest) or 0 :]
        self._at += len(data)
