"""The file of a law that flies, watched for edits."""

from workbench.control.controller import Controller

PERIOD = 0.25
"""Between two looks at the file [s of wall]."""


class LawFile:
    """Tells when the file of a controller was saved with another text.

    It looks at the file from time to time: editors write in place, or another file of the name.

    Args:
        law: that flies.
        now: the wall time [s].
    """

    def __init__(self, law: Controller, now: float) -> None:
        self._path, self._text = law.file, law.text
        self._state = self._look()
        self._due = now

    def edited(self, now: float) -> bool:
        """Return whether there is a text that was not told of before."""
        if now < self._due:
            return False
        self._due = now + PERIOD
        state = self._look()
        if state in (None, self._state):  # gone for a moment, as some editors do
            return False
        self._state = state
        try:
            text = self._path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            return True  # who loads it says what is wrong
        changed, self._text = text != self._text, text
        return changed and bool(text)  # empty is what is about to be written

    def _look(self) -> tuple[int, int, int] | None:
        try:
            state = self._path.stat()
        except OSError:
            return None
        return state.st_mtime_ns, state.st_size, state.st_ino
