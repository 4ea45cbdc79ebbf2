"""JSON that means one thing only: what two readers could take differently is refused."""

import json
import math
import re

from workbench.link.wire import WireError

DEEPEST = 8
"""Objects and arrays within each other; the outermost object is the first."""
LONGEST_INTEGER = 20
"""Characters: those of the integers of 64 bits."""
_TEXT = re.compile(rb'"(?:[^"\\]|\\.)*+"?', re.DOTALL)
_BRACKET = re.compile(rb"[\[{\]}]")
_PAIR = re.compile(rb"\[\]|\{\}")
_NO_BRACKET = bytes(set(range(256)) - set(b"[]{}"))
_UNUSUAL = re.compile(rb"[0-9]{20}|[0-9][eE]")
"""Only a number with so many digits, or with an exponent, may be too large."""
_SURROGATE = re.compile(rb"\\u[dD][89a-fA-F]")


def read_json(payload: bytes) -> dict[str, object]:
    """Return the object that a control frame's payload has.

    Raises:
        WireError: code "json", for what is not UTF-8, no JSON or no object, and for what JSON's
            readers do not agree on: a key twice, NaN and infinity, numbers too large, half of a
            surrogate pair, arrays and objects more than `DEEPEST` within each other.
    """
    try:
        bare = _TEXT.sub(b"", payload)
        _check_depth(bare)  # first: the reader calls itself at each bracket
        unusual = _UNUSUAL.search(bare)  # to be asked about each number costs the most
        value = json.loads(
            payload.decode("utf-8"),
            object_pairs_hook=_object,
            parse_float=_number if unusual else None,
            parse_int=_integer if unusual else None,
            parse_constant=_no_number,
        )
        if _SURROGATE.search(payload):
            json.dumps(value, ensure_ascii=False).encode()
    except UnicodeDecodeError as error:
        raise WireError("json", f"byte {error.start} is not UTF-8") from error
    except UnicodeEncodeError as error:
        raise WireError("json", "a text has half of a surrogate pair") from error
    except ValueError as error:
        raise WireError("json", f"this is no strict JSON: {error}") from error
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
    """Refuse what is too deep.

    Args:
        bare: JSON without its texts.
    """
    left = brackets = bare.translate(None, _NO_BRACKET)
    for opening, closing in (b"[]", b"{}"):
        open_ = brackets.count(opening) - brackets.count(closing)
        if 0 != open_ <= DEEPEST:
            raise ValueError("a bracket has no other")
    for _ in range(DEEPEST):
        left = _PAIR.sub(b"", left)  # the innermost ones
    if not left:
        return
    depth = 0
    for bracket in _BRACKET.finditer(brackets):
        depth += 1 if bracket[0] in b"[{" else -1
        if depth > DEEPEST:
            raise ValueError(f"more than {DEEPEST} objects and arrays within each other")


def _object(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise ValueError(f"the key {key[:40]!r} comes twice")
            seen.add(key)
    return found


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"the number {text[:40]} is too large")
    return value


def _integer(text: str) -> int:
    if len(text) > LONGEST_INTEGER:
        raise ValueError(f"the integer {text[:40]}... is too long")
    return int(text)


def _no_number(text: str) -> float:
    raise ValueError(f"{text} is no number in JSON")
