"""Sets of gains that are stored to be compared by one key."""

from collections.abc import Mapping

SLOTS = ("A", "B", "C")


class GainSlots:
    """Slots by their letter; one that is recalled twice gives back what was before.

    Attributes:
        stored: values by the slot's letter.
    """

    def __init__(self) -> None:
        self.stored: dict[str, Mapping[str, float]] = {}
        self._compared: Mapping[str, float] = {}

    def store(self, slot: str, values: Mapping[str, float]) -> None:
        """Let a slot have values."""
        self.stored[slot] = dict(values)
        self._compared = {}

    def recall(
        self, slot: str, present: Mapping[str, float]
    ) -> tuple[Mapping[str, float], str] | None:
        """Return what to fly now and what that is in words; None where nothing is to be done.

        Args:
            slot: its letter.
            present: values, that come back at the next recall.
        """
        if slot not in self.stored:
            return None
        if dict(present) != self.stored[slot]:
            self._compared = dict(present)
            return self.stored[slot], f"slot {slot}"
        return (self._compared, f"back from slot {slot}") if self._compared else None

    def clear(self) -> None:
        """Empty all."""
        self.stored = {}
        self._compared = {}
