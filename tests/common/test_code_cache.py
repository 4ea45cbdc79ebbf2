"""Machine code of several processes in one; oracle: the functions as Python runs them."""

import os
import subprocess
import sys
from pathlib import Path

LONG = "    unit = math.hypot(math.cos(unit), math.sin(unit))\n" * 60
"""So long that no compiler writes the function into those that call it."""
LAWS = f"""
import math
import sys

import numpy as np

from workbench.common.compiled import compile_cached
from workbench.common.jitable import register_jitable

LAYOUTS = {{"near": [("gain", float)], "far": [("more", float), ("gain", float)]}}


@register_jitable
def gain_of(record):
    unit = 1.0
{LONG}
    return unit * record.gain


def near(records):
    return gain_of(records[0]) + gain_of(records[-1]) - 39.0


def far(records):
    return gain_of(records[0]) + gain_of(records[-1]) - 38.0


for name in sys.argv[1:]:
    records = np.zeros(1, LAYOUTS[name])
    records["gain"] = 40.0
    run = compile_cached(globals()[name], ["common/compiled.py"], "a law", text=name)
    print(name, round(run(records), 6))
"""


def test_code_of_two_processes_is_not_confused_in_a_third(tmp_path):
    """Both have one type of record, so it has the same number of numba's in the first two."""
    script = tmp_path / "laws.py"
    script.write_text(LAWS)
    answers = {"near": "near 41.0", "far": "far 42.0"}
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    for names in (["near"], ["far"], ["near", "far"]):
        done = subprocess.run(
            [sys.executable, script, *names],
            capture_output=True,
            text=True,
            env=environment,
            cwd=Path(__file__).parents[2],
        )
        assert done.stdout.splitlines() == [answers[name] for name in names], done.stderr
