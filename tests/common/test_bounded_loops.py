"""Loops of a user's functions end, in Python and in machine code."""

import time
from pathlib import Path

import numba
import pytest

from workbench.common.bounded_loops import LOOP_CHECK_NAMES, bounded_code
from workbench.common.errors import WorkbenchError
from workbench.common.own_file import limit_call_time, locate_non_finite

FILE = Path("/somewhere/mine.py")


def function(body: str, before: str = ""):
    """Return the function of a file, which begins in line 2, and its argument is x."""
    text = f"{before}\ndef function(x):\n" + "".join(f"    {line}\n" for line in body.splitlines())
    names = {"__name__": "mine", **LOOP_CHECK_NAMES}
    exec(bounded_code(text, FILE), names)
    return names["function"]


ENDLESS = (
    ("while x > 0.0:\n    x = x + 1.0\nreturn x", 3),
    ("'Doc.'\nn = 0\nwhile True:\n    n += 1", 5),
    ("while x > 0.0:\n    for i in range(3):\n        x = x + 1.0\nreturn x", 3),
    ("for k in range(3):\n    while x > 0.0:\n        x += 0.0\nreturn x", 4),
    ("n = 0\nfor k in range(int(x) * 10**8):\n    n += k\nreturn n", 4),
    ("n = 0\nwhile n < 10 if x > 0.0 else False:\n    n += 0\nelse:\n    n = 2\nreturn n", 4),
)
"""Bodies, and the line of the loop that does not end for x = 1."""
ENDING = (
    ("n = 0.0\nwhile x > 0.0:\n    x -= 1.0\n    n += x\nreturn n", 5.0, 10.0),
    ("n = 0.0\nwhile x > 0.0:\n    x -= 1.0\n    if x < 2.0:\n        break\nreturn x", 5.0, 1.0),
    ("while x > 9.0:\n    x = 0.0\nelse:\n    x = 7.0\nreturn x", 5.0, 7.0),
    ("n = 0.0\nfor k in range(int(x)):\n    n += k\nreturn n", 5.0, 10.0),
    ("n = 0.0\nfor k in (1.0, 2.0, x):\n    n += k\nreturn n", 5.0, 8.0),
    ("n = 0.0\nfor k, y in enumerate((1.0, x)):\n    n += k * y\nreturn n", 5.0, 5.0),
    ("n = 0.0\nfor k in range(1000):\n    n += x\nreturn n", 1.0, 1000.0),
)
"""Bodies, an argument, and what they return."""


def test_a_loop_that_does_not_end_is_named(case):
    for body, line in ENDLESS:
        python = function(body)
        for run in (python, numba.njit(python)):
            with case(body), pytest.raises(WorkbenchError) as caught:
                run(1.0)
            said = f"{FILE}:{line}: does not end: it has an endless loop"
            assert str(caught.value) == said


def test_loops_that_end_do_what_they_did(case):
    for body, argument, result in ENDING:
        python = function(body)
        for run in (python, numba.njit(python)):
            with case(body):
                assert run(argument) == result


def test_a_generator_without_end_is_named():
    """Only Python runs one."""
    run = function("for k in count():\n    x += k\nreturn x", "from itertools import count")
    with pytest.raises(WorkbenchError, match="mine.py:3: does not end"):
        run(1.0)


NOT_FINITE = (
    ("y = x * 2.0\nz = y * 1e400 * 0.0\nreturn z", 4, "z nan"),
    ("y = (x, (1.0, x / 1e-320 * 0.0))\nreturn y", 3, "y nan"),
    ("a = [x, x]\na[1] = a[0] - 1e400 + 1e400\nreturn a", 4, "a nan"),
    ("return x * 1e400", 3, "its result inf"),
    ("best = 1e400\nbest = min(best, x) + (1e400 - 1e400)\nreturn best", 4, "best nan"),
    ("best = 1e400\nworst = best - best\nreturn worst", 4, "worst nan"),
    ("def inner(y):\n    return y - y\nz = inner(x * 1e400)\nreturn z", 4, "its result nan"),
)
"""Bodies, and the line and the name of the number to blame."""


def test_the_line_that_first_makes_a_number_not_finite_is_named(case):
    for body, line, name in NOT_FINITE:
        run = function(body)
        with (
            case(body),
            pytest.raises(WorkbenchError) as caught,
            locate_non_finite(FILE, "update"),
        ):
            run(1.0)
        assert str(caught.value).startswith(f"{FILE}:{line}: update makes {name}: let it be")


def test_what_is_finite_is_not_named():
    with locate_non_finite(FILE, "update"):
        assert function("return x * 1e300")(1.0) == 1e300


def test_what_waits_for_ever_is_named():
    run = function("time.sleep(x)\nreturn x", "import time")
    began = time.monotonic()
    said = "^/somewhere/mine.py:3: update has not returned for 0.01 s: let it end"
    with pytest.raises(WorkbenchError, match=said), limit_call_time(FILE, "update", 0.01):
        run(3600.0)
    assert time.monotonic() - began < 600.0
    with limit_call_time(FILE, "update", 3600.0):
        assert run(0.0) == 0.0
