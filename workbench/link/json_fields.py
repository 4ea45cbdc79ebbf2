"""Unambiguous JSON, and its values, each with type and bounds.

JSON that two parsers could interpret differently is rejected.
"""

import json
import math
import re
from collections.abc import Mapping
from enum import Enum
from typing import TypeVar

from workbench.common.plain_text import plain_name
from workbench.link.codes import DeniedError, NackCode
from workbench.link.drone_topics import MAX_LINK_NAME_CHARS
from workbench.link.wire import WireError

MAX_JSON_DEPTH = 8
"""Largest depth of nested objects and arrays; the outermost object counts as 1."""
MAX_INTEGER_CHARS = 20
"""Largest number of characters of an integer, for 64 bits."""
_JSON_STRING_PATTERN = re.compile(rb'"(?:[^"\\]|\\.)*+"?', re.DOTALL)
_BRACKET_PATTERN = re.compile(rb"[\[{\]}]")
_BRACKET_PAIR_PATTERN = re.compile(rb"\[\]|\{\}")
_NO_BRACKET_BYTES = bytes(set(range(256)) - set(b"[]{}"))
_LARGE_NUMBER_PATTERN = re.compile(rb"[0-9]{20}|[0-9][eE]")
"""Only a number with this many digits, or with an exponent, can be too large."""
_SURROGATE_PATTERN = re.compile(rb"\\u[dD][89a-fA-F]")


def read_json(payload: bytes) -> dict[str, object]:
    """Return the object in the payload of a control frame.

    Raises:
        WireError: code "json", for invalid UTF-8 or JSON, for anything but an object, and for
            ambiguous JSON: a repeated key, NaN and infinity, numbers too large, half of a surrogate
            pair, arrays and objects nested deeper than `MAX_JSON_DEPTH`.
    """
    try:
        bare = _JSON_STRING_PATTERN.sub(b"", payload)
        _check_depth(bare)  # first, as the parser is recursive
        unusual = _LARGE_NUMBER_PATTERN.search(bare)  # a check of each number would cost the most
        value = json.loads(
            payload.decode("utf-8"),
            object_pairs_hook=_object,
            parse_float=_float if unusual else None,
            parse_int=_integer if unusual else None,
            parse_constant=_no_number,
        )
        if _SURROGATE_PATTERN.search(payload):
            json.dumps(value, ensure_ascii=False).encode()
    except UnicodeDecodeError as error:
        raise WireError("json", f"byte {error.start} is not UTF-8") from error
    except UnicodeEncodeError as error:
        raise WireError("json", "a text has half of a surrogate pair") from error
    except ValueError as error:
        raise WireError("json", f"this is not strict JSON: {error}") from error
    if not isinstance(value, dict):
        raise WireError("json", "an operation is an object, in braces")
    return value


def write_json(value: object) -> bytes:
    """Return a value as JSON in UTF-8.

    Raises:
        ValueError: if a number in it is not finite.
    """
    text = json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    return text.encode("utf-8", "replace")


def _check_depth(bare: bytes) -> None:
    """Check the depth of nesting.

    Args:
        bare: JSON without its texts.
    """
    left = brackets = bare.translate(None, _NO_BRACKET_BYTES)
    for opening, closing in (b"[]", b"{}"):
        open_ = brackets.count(opening) - brackets.count(closing)
        if 0 != open_ <= MAX_JSON_DEPTH:
            raise ValueError("a bracket has no partner")
    for _ in range(MAX_JSON_DEPTH):
        left = _BRACKET_PAIR_PATTERN.sub(b"", left)  # the innermost ones
    if not left:
        return
    depth = 0
    for bracket in _BRACKET_PATTERN.finditer(brackets):
        depth += 1 if bracket[0] in b"[{" else -1
        if depth > MAX_JSON_DEPTH:
            raise ValueError(f"more than {MAX_JSON_DEPTH} objects and arrays within each other")


def _object(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise ValueError(f"the key {key[:40]!r} comes twice")
            seen.add(key)
    return found


def _float(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"the number {text[:40]} is too large")
    return value


def _integer(text: str) -> int:
    if len(text) > MAX_INTEGER_CHARS:
        raise ValueError(f"the integer {text[:40]}... is too long")
    return int(text)


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is not a number in JSON")


MAX_REQUEST_ID = 2**32 - 1
MAX_REQUEST_NAMES = 256
MAX_TOPIC_NAME_CHARS = 64
MAX_SENTENCE_CHARS = 1024

E = TypeVar("E", bound=Enum)


class JsonFields:
    """The fields of one operation; other keys are ignored.

    Attributes:
        id: of the operation, 0 without one.
        op: its name.
    """

    def __init__(self, values: Mapping[str, object]) -> None:
        self._values = values
        self.id = 0
        self.op = ""
        self.id = self.integer("id", 0, MAX_REQUEST_ID) if "id" in self else 0
        self.op = self.text("op", MAX_LINK_NAME_CHARS)

    def __contains__(self, name: str) -> bool:
        return self._values.get(name) is not None

    def bad(self, said: str) -> DeniedError:
        """Return the error for a value."""
        return DeniedError(NackCode.BAD_VALUE, f"{self.op}: {said}".lstrip(": "), self.id)

    def integer(self, name: str, low: int, high: int) -> int:
        """Return an integer within bounds."""
        value = self._values.get(name)
        # As in JavaScript, 3.0 and 3 are the same number, and true is not a number.
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise self.bad(f'"{name}" must be an integer within {low} .. {high}')
        return value

    def number(self, name: str, low: float = -math.inf, high: float = math.inf) -> float:
        """Return a finite number within bounds."""
        value = _finite_number(self._values.get(name))
        if value is None or not low <= value <= high:
            span = "" if low == -math.inf and high == math.inf else f" within {low:g} .. {high:g}"
            raise self.bad(f'"{name}" must be a number{span}')
        return value

    def truth(self, name: str) -> bool:
        """Return a truth value."""
        value = self._values.get(name)
        if not isinstance(value, bool):
            raise self.bad(f'"{name}" must be true or false')
        return value

    def text(self, name: str, longest: int) -> str:
        """Return a printable text of limited length in UTF-8 [bytes]."""
        value = self._values.get(name)
        if not _is_text(value, longest):
            raise self.bad(f'"{name}" must be a printable text of at most {longest} bytes')
        return str(value)

    def sentence(self, name: str) -> str:
        """Return a text for people, as one line of limited length without control characters."""
        value = self._values.get(name)
        if not isinstance(value, str):
            raise self.bad(f'"{name}" must be a text')
        return plain_name(value, MAX_SENTENCE_CHARS)

    def digits(self, name: str, count: int) -> str:
        """Return hexadecimal digits, in lower case."""
        value = self._values.get(name)
        allowed = set("0123456789abcdefABCDEF")
        if not isinstance(value, str) or len(value) != count or not set(value) <= allowed:
            raise self.bad(f'"{name}" must be {count} hexadecimal digits')
        return value.lower()

    def choice(self, name: str, choices: tuple[str, ...]) -> str:
        """Return one of several words."""
        value = self._values.get(name)
        if not isinstance(value, str) or value not in choices:
            raise self.bad(f'"{name}" must be one of {", ".join(choices)}')
        return value

    def member(self, name: str, kind: type[E]) -> E:
        """Return a member of a string enumeration."""
        return kind(self.choice(name, tuple(each.value for each in kind)))

    def names(self, name: str, longest: int) -> tuple[str, ...]:
        """Return several names."""
        value = self._values.get(name)
        if (
            not isinstance(value, list)
            or len(value) > MAX_REQUEST_NAMES
            or not all(_is_text(each, longest) for each in value)
        ):
            raise self.bad(f'"{name}" must be a list of at most {MAX_REQUEST_NAMES} names')
        return tuple(value)

    def numbers(self, name: str) -> dict[str, float]:
        """Return finite numbers by name."""
        value = self._values.get(name)
        found: dict[str, float] = {}
        if not isinstance(value, dict) or len(value) > MAX_REQUEST_NAMES:
            raise self.bad(f'"{name}" must be an object of at most {MAX_REQUEST_NAMES} numbers')
        for key, each in value.items():
            number = _finite_number(each)
            if number is None or not _is_text(key, MAX_LINK_NAME_CHARS):
                raise self.bad(f'"{name}" must give a number for each name')
            found[key] = number
        return found

    def integers(self, name: str, count: int) -> tuple[int, ...]:
        """Return a given number of integers."""
        value = self._values.get(name)
        if (
            not isinstance(value, list)
            or len(value) != count
            or not all(type(each) is int for each in value)  # true is an int to isinstance
        ):
            raise self.bad(f'"{name}" must be {count} integers')
        return tuple(value)

    def objects(self, name: str) -> list[dict[str, object]]:
        """Return several objects."""
        value = self._values.get(name)
        if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
            raise self.bad(f'"{name}" must be a list of objects')
        return value

    def within(self, name: str) -> "JsonFields":
        """Return the fields of a nested object."""
        value = self._values.get(name)
        if not isinstance(value, dict):
            raise self.bad(f'"{name}" must be an object')
        return self.part(value)

    def part(self, values: Mapping[str, object]) -> "JsonFields":
        """Return the fields of a part of this operation; its errors name the operation."""
        return JsonFields({**values, "op": self.op, "id": self.id})


def _finite_number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if math.isfinite(value) else None


def _is_text(value: object, longest: int) -> bool:
    if not isinstance(value, str) or len(value) > longest:
        return False
    # Printable text has no half surrogate pair, so it can be encoded.
    return value.isprintable() and len(value.encode()) <= longest
