"""Numbers as autopilots keep and write them."""

import math
import re
import struct
from decimal import Decimal

_DECIMAL = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf(inity)?)", re.I)
_HEX = re.compile(r"0[xX][0-9a-fA-F]+")
_LONGEST = 60
"""Characters of a number; a longer text is none."""
_LEAST, _MOST = 1e-6, 1e9
"""Between these, numbers are written without an exponent."""
_SINGLE_DIGITS = 9
"""So many tell every number of single precision from its neighbours."""


def number_in(text: str) -> float | None:
    """Return the number that a text is, decimal or hexadecimal; None where it is none."""
    if len(text) > _LONGEST:
        return None
    if _HEX.fullmatch(text):
        return float(int(text, 16))
    return float(text) if _DECIMAL.fullmatch(text) else None


def single(value: float) -> float:
    """Return a number in single precision; one that is too large is infinite."""
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def shortest(value: float) -> str:
    """Return the shortest text that single precision reads as the same number."""
    for digits in range(1, _SINGLE_DIGITS):
        text = f"{value:.{digits}g}"
        if single(float(text)) == single(value):
            return _plain(text)
    return _plain(f"{single(value):.{_SINGLE_DIGITS}g}")


def _plain(text: str) -> str:
    """Return a number without an exponent, where that is no longer than people read."""
    return f"{Decimal(text):f}" if _LEAST <= abs(float(text)) < _MOST else text


def long_single(value: float) -> str:
    """Return a number in single precision as QGroundControl writes it, with all its digits."""
    return f"{single(value):.18g}"


def tidy(value: float) -> float:
    """Return a number of single precision as it was typed: 0.15 for 0.150000005960464478."""
    return float(shortest(value)) if math.isfinite(value) and single(value) == value else value
