"""Numbers as people type them: a point or a comma before the decimals, and an exponent."""

import math
import re

from workbench.common.errors import LONGEST_ECHO, WorkbenchError

NUMBER = r"[-+\N{MINUS SIGN}]?[\d.,]+(?:[eE][-+\N{MINUS SIGN}]?\d+)?"
"""Expression for what may be meant as a number; `read_number` says whether it is one."""
_PLAIN = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", re.ASCII)


def read_number(text: str) -> float:
    """Return the number that a text says; it does not depend on the locale.

    A point and a comma both separate the decimals: who types 0,5 means a half. So neither can
    separate thousands, and a text that has two of them is refused.

    Raises:
        WorkbenchError: if it is no number, or one that is too large for a computer.
    """
    typed = text.strip()
    if not typed:
        raise WorkbenchError("There is no number: type one, as 1.2 or 1e-3.")
    plain = typed.replace("\N{MINUS SIGN}", "-")
    said = f"'{typed[:LONGEST_ECHO]}'"
    if plain.count(".") + plain.count(",") > 1:
        raise WorkbenchError(
            f"{said} has more than one point or comma: separate the decimals by one of them, "
            "and leave out separators of thousands, as in 1000.5."
        )
    plain = plain.replace(",", ".")
    if not _PLAIN.fullmatch(plain):
        raise WorkbenchError(f"{said} is not a number: write it as 1.2, 1,2 or 1e-3.")
    number = float(plain)
    if math.isinf(number):
        raise WorkbenchError(f"{said} is too large.")
    return number


def read_whole_number(text: str) -> int:
    """Return the whole number that a text says.

    Raises:
        WorkbenchError: if it is no number, or not a whole one.
    """
    number = read_number(text)
    if not number.is_integer():
        raise WorkbenchError(f"'{text.strip()[:LONGEST_ECHO]}' is not a whole number.")
    return int(number)
