"""Read the definitions of ROS 2 messages, as in .msg files."""

import re
from dataclasses import dataclass
from enum import Enum

from workbench.common.errors import WorkbenchError

STRUCT_CODE_BY_ROS_TYPE = {
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
"""Types of numbers, and their codes in `struct`."""
TEXT_TYPE = "string"
SCHEMA_SEPARATOR = "=" * 80
_FIELD_TYPE_PATTERN = re.compile(r"([A-Za-z]\w*(?:/\w+){0,2})(?:\[(\d*)\])?")
_CONSTANT_LINE_PATTERN = re.compile(r"\s*\w+\s+[A-Z]\w*\s*=")
_FIELD_NAME_PATTERN = re.compile(r"[a-z][a-z0-9_]*")


class Arity(Enum):
    """The number of values of a field."""

    ONE = "one"
    FIXED = "fixed"
    """An array with the length in the definition."""
    SEQUENCE = "sequence"
    """Any number of values, preceded by that number."""


@dataclass(frozen=True)
class MessageField:
    """A field of a message.

    Attributes:
        name: in snake case.
        type: one of `STRUCT_CODE_BY_ROS_TYPE`, `TEXT_TYPE`, or the name of a type such as
            std_msgs/msg/Header.
        arity: whether it is one value, or an array.
        count: length of a fixed array, 1 otherwise.
        unit: in brackets in the comment, "" if there is none.
    """

    name: str
    type: str
    arity: Arity
    count: int
    unit: str

    @property
    def nested(self) -> bool:
        """Whether its values are nested messages."""
        return "/" in self.type


@dataclass(frozen=True)
class Definition:
    """A message type.

    Attributes:
        name: with its package, such as std_msgs/msg/Header.
        fields: in order.
        text: of the definition.
    """

    name: str
    fields: tuple[MessageField, ...]
    text: str


def read_definition(name: str, text: str) -> Definition:
    """Return the definition in a text; constants are only in its text.

    Args:
        name: of the type, such as std_msgs/msg/Header.
        text: as in a .msg file.

    Raises:
        WorkbenchError: for an invalid line.
    """
    package = name.partition("/")[0]
    lines = enumerate(text.splitlines(), start=1)
    found = [_field_in_line(package, line, f"{name}, line {number}: ") for number, line in lines]
    return Definition(name, tuple(field for field in found if field is not None), text)


def split_schema(name: str, text: str) -> dict[str, Definition]:
    """Return the definitions in a schema by name: a type, and then all types included in it.

    Args:
        name: of the first type.
        text: definitions separated by lines of `=`; from the second on they begin with `MSG:
            package/Name`.

    Raises:
        WorkbenchError: for an invalid line.
    """
    definitions = {}
    for part in re.split(r"^={3,}\n", text, flags=re.MULTILINE):
        head = re.match(r"MSG: (\w+)/(?:msg/)?(\w+)\n", part)
        part_name = f"{head[1]}/msg/{head[2]}" if head else name
        definitions[part_name] = read_definition(part_name, part[head.end() if head else 0 :])
    return definitions


def _field_in_line(package: str, line: str, where: str) -> MessageField | None:
    """Return the field in a line, or None."""
    code, _, comment = line.partition("#")
    words = code.split()
    if not words or _CONSTANT_LINE_PATTERN.match(code):
        return None
    kind = _FIELD_TYPE_PATTERN.fullmatch(words[0])
    if kind is None or len(words) < 2 or not _FIELD_NAME_PATTERN.fullmatch(words[1]):
        raise WorkbenchError(f"{where}'{line.strip():.60}' is not a field: write TYPE NAME")
    unit = re.match(r" *\[([^\]]*)\]", comment)
    arity = Arity.ONE if kind[2] is None else Arity.FIXED if kind[2] else Arity.SEQUENCE
    return MessageField(
        name=words[1],
        type=_full_name(package, kind[1], where),
        arity=arity,
        count=int(kind[2] or 1) if arity is Arity.FIXED else 1,
        unit=unit[1] if unit else "",
    )


def _full_name(package: str, kind: str, where: str) -> str:
    """Return the name of a type with its package, or of a built-in type."""
    if kind in STRUCT_CODE_BY_ROS_TYPE or kind == TEXT_TYPE:
        return kind
    *packages, name = kind.split("/")
    if not packages and not name[0].isupper():
        raise WorkbenchError(f"{where}unknown type '{kind:.60}'")
    return f"{packages[0] if packages else package}/msg/{name}"
