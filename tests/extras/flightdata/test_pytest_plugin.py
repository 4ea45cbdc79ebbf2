"""The pytest plugin on specs about logs of other programs."""

import pytest

from tests.test_pytest_plugin import imported, plugin

pytestmark = pytest.mark.usefixtures("unheld")

pytest_plugins = ["pytester"]
__all__ = ["imported", "plugin"]

LOG = """\
cases:
  - {name: there, log: flown.csv, limits: {peak_speed: {max: 2}}}
  - {name: no motors, log: {file: flown.csv, missing: skip}, limits: {trim: {max: 1}}}
  - {name: gone, log: {file: gone.ulg, missing: skip}, limits: {trim: {max: 1}}}
  - {name: too fast, log: flown.csv, limits: {peak_speed: {max: 0.5}}}
"""


def test_logs_are_judged_and_what_they_lack_is_skipped(pytester, plugin):
    rows = [f"{0.01 * number},1.0,0,0" for number in range(200)]
    (pytester.path / "flown.csv").write_text("\n".join(["t,vx,vy,vz", *rows]))
    (pytester.path / "flown.mapping.yaml").write_text(
        "time: {column: t, unit: s}\ncolumns:\n"
        + "".join(f"  v{a}: {{signal: velocity_data.v_{a}, unit: m/s}}\n" for a in "xyz")
    )
    pytester.makefile(".workbench.yaml", log=LOG)
    done = pytester.runpytest_inprocess(*plugin, "-rs")
    done.assert_outcomes(passed=1, skipped=2, failed=1)
    done.stdout.fnmatch_lines(
        [
            "peak_speed is 1 m/s, and should be at most 0.5 m/s: 0.5 m/s above",
            "SKIPPED*trim: *has no motor commands*",
            "SKIPPED*there is no log gone.ulg",
        ]
    )
