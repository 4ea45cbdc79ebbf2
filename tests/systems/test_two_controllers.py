"""Machine code of two laws, made in two processes, serves one that flies both."""

import subprocess
import sys
from pathlib import Path

FLY = """
import sys
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session
for name in sys.argv[1:]:
    session = Session(Scenario(controller=name))
    session.command([1.0, 0.0, 0.0], 0.0)
    session.tick(0.5)
    states = session.checkpoint().systems
    (path,) = (path for path in states if path.endswith("::controller"))
    print(name, [float(v).hex() for v in session.state()], states[path].state)
"""


def fly(*names: str) -> list[str]:
    """Return what laws make of a step, flown in one process after the other."""
    command = [sys.executable, "-W", "ignore", "-c", FLY, *names]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


def test_each_law_flies_as_if_it_were_alone(tmp_path):
    """They have functions of the same names, which numba tells apart within one process only."""
    own = tmp_path / "own.py"
    text = (Path(__file__).parents[2] / "workbench" / "controllers" / "pd.py").read_text()
    own.write_text(text.replace("g.kp_velocity_x * e[0]", "2.0 * g.kp_velocity_x * e[0]"))
    alone = [*fly("pd"), *fly(str(own))]
    assert alone[0].split(" ", 1)[1] != alone[1].split(" ", 1)[1]
    assert fly("pd", str(own)) == alone
