"""What a message of ROS 2 consists of, read from its definition as text."""

import re
from dataclasses import dataclass
from enum import Enum

from workbench.common.errors import WorkbenchError

NUMBERS = {
    "bool": "?",
    "byte": "B",
    "char": "B",
    "uint8": "B",
    "int8": "b",
    "uint16": "H",
    "int16": "h",
    "uint32": "I",
    "int32": "i",
    "uint64": "Q",
    "int64": "q",
    "float32": "f",
    "float64": "d",
}
"""Types of numbers, and what `struct` calls them."""
TEXT = "string"
SEPARATOR = "=" * 80
_TYPE = re.compile(r"([A-Za-z]\w*(?:/\w+){0,2})(?:\[(\d*)\])?")
_CONSTANT = re.compile(r"\s*\w+\s+[A-Z]\w*\s*=")
_NAME = re.compile(r"[a-z][a-z0-9_]*")


class Arity(Enum):
    """How many values a field has."""

    ONE = "one"
    FIXED = "fixed"
    """An array of as many as the definition says."""
    SEQUENCE = "sequence"
    """Any number, which goes before them."""


@dataclass(frozen=True)
class MessageField:
    """A field of a message.

    Attributes:
        name: in snake case.
        type: one of `NUMBERS`, `TEXT`, or the name of a definition, as std_msgs/msg/Header.
        arity: how many values it has.
        count: of a fixed array, 1 otherwise.
        unit: what the comment has in brackets, "" if none.
    """

    name: str
    type: str
    arity: Arity
    count: int
    unit: str

    @property
    def nested(self) -> bool:
        """Whether its values are messages."""
        return "/" in self.type


@dataclass(frozen=True)
class Definition:
    """A type of message.

    Attributes:
        name: with its package, as std_msgs/msg/Header.
        fields: in their order.
        text: from which it was read.
    """

    name: str
    fields: tuple[MessageField, ...]
    text: str


def read_definition(name: str, text: str) -> Definition:
    """Return the definition that a text describes; constants stay in the text only.

    Args:
        name: of the type, as std_msgs/msg/Header.
        text: as in a .msg file.

    Raises:
        WorkbenchError: for a line that is no field.
    """
    package = name.partition("/")[0]
    lines = enumerate(text.splitlines(), start=1)
    found = [_field(package, line, f"{name}, line {number}: ") for number, line in lines]
    return Definition(name, tuple(field for field in found if field is not None), text)


def split_schema(name: str, text: str) -> dict[str, Definition]:
    """Return the definitions of a schema by name: a type, and all that it includes behind it.

    Args:
        name: of the type that comes first.
        text: parts between lines of `=`, each but the first headed `MSG: package/Name`.

    Raises:
        WorkbenchError: for a line that is no field.
    """
    definitions = {}
    for part in re.split(r"^={3,}\n", text, flags=re.MULTILINE):
        head = re.match(r"MSG: (\w+)/(?:msg/)?(\w+)\n", part)
        part_name = f"{head[1]}/msg/{head[2]}" if head else name
        definitions[part_name] = read_definition(part_name, part[head.end() if head else 0 :])
    return definitions


def _field(package: str, line: str, where: str) -> MessageField | None:
    """Return the field of a line, None if it has none."""
    code, _, comment = line.partition("#")
    words = code.split()
    if not words or _CONSTANT.match(code):
        return None
    kind = _TYPE.fullmatch(words[0])
    if kind is None or len(words) < 2 or not _NAME.fullmatch(words[1]):
        raise WorkbenchError(f"{where}'{line.strip():.60}' is no field: write TYPE NAME")
    unit = re.match(r" *\[([^\]]*)\]", comment)
    arity = Arity.ONE if kind[2] is None else Arity.FIXED if kind[2] else Arity.SEQUENCE
    return MessageField(
        name=words[1],
        type=_full_name(package, kind[1], where),
        arity=arity,
        count=int(kind[2]) if arity is Arity.FIXED else 1,
        unit=unit[1] if unit else "",
    )


def _full_name(package: str, kind: str, where: str) -> str:
    """Return a type's name with its package, where it is not built in."""
    if kind in NUMBERS or kind == TEXT:
        return kind
    *packages, name = kind.split("/")
    if not packages and not name[0].isupper():
        raise WorkbenchError(f"{where}unknown type '{kind:.60}'")
    return f"{packages[0] if packages else package}/msg/{name}"
