"""How much of the processors a host keeps for others, by which a measurement is worth little."""

from pathlib import Path


class Host:
    """The share of processor time that was stolen (Linux counts it) since this was made."""

    def __init__(self) -> None:
        self._all, self._stolen = _times()

    @property
    def stolen(self) -> float:
        """Of all processor time [%]; 0 on a machine of its own."""
        every, stolen = _times()
        return 100.0 * (stolen - self._stolen) / max(every - self._all, 1)


def _times() -> tuple[int, int]:
    """Return processor time in all, and what was stolen of it [ticks]."""
    fields = Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0].split()[1:9]
    times = [int(field) for field in fields]
    return sum(times), times[7]
