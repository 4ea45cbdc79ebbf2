"""A line of an autopilot's parameter file: what becomes of it here, and remarks on it."""

from dataclasses import dataclass

LINE_FLOWN, LINE_NOT_FLOWN, LINE_UNKNOWN = "flown", "not flown", "unknown"


@dataclass(frozen=True)
class ParameterFileRemark:
    """One thing that the reader of a file should know.

    Attributes:
        text: a sentence.
        line: the first one concerned, counted from 1; 0 for the whole file.
        count: of lines or parameters concerned.
    """

    text: str
    line: int = 0
    count: int = 1

    def __str__(self) -> str:
        return f"line {self.line}: {self.text}" if self.line else self.text


@dataclass(frozen=True)
class UnusedParameter:
    """A parameter of a file, or of its version, that does not fly here.

    Attributes:
        name: in the firmware.
        text: its value.
        line: in the file, 0 if the version has it by default.
        acts: whether it changes a flight of the firmware.
    """

    name: str
    text: str
    line: int
    acts: bool

    def __str__(self) -> str:
        return f"{self.name} {self.text}"


@dataclass(frozen=True)
class ParameterLine:
    """What becomes of a line of a file; a command that computes values has one for each.

    Attributes:
        number: counted from 1.
        name: of the parameter, "" for a command.
        text: its value, or the command.
        part: `LINE_FLOWN`, `LINE_NOT_FLOWN` or `LINE_UNKNOWN`.
        why: a clause; "" if it flies.
    """

    number: int
    name: str
    text: str
    part: str
    why: str = ""
